//! Where it ends: the deepest trap that a controller leaves, the narrowest door that it passes.

use core::fmt::{self, Display, Formatter};

use serde::Serialize;

use crate::evaluation::SceneResult;
use crate::questions::Question;
use crate::scenes::Side;
use crate::statistics::Rate;
use crate::world::KHEPERA_RADIUS_M;

/// A trap or a door counts as passed from this share of the runs on.
pub const PASSED: f64 = 0.99;

/// What a question asks, where there is more or less of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum Measure {
    /// A U; the deeper the harder.
    Trap {
        /// Where the robot starts.
        side: Side,
        /// Inner width in cm.
        width_cm: f64,
        /// Inner depth in cm.
        depth_cm: f64,
    },
    /// A door; the narrower the harder.
    Door {
        /// How it is approached, under which conditions.
        approach: String,
        /// Its width in cm.
        width_cm: f64,
    },
}

impl Measure {
    /// What is compared with what: `U from inside`, `door ±45°`.
    #[must_use]
    pub fn group(&self) -> String {
        match self {
            Self::Trap { side, .. } => format!("U {side}"),
            Self::Door { approach, .. } => format!("door {approach}"),
        }
    }

    /// Larger where it is harder.
    fn difficulty(&self) -> f64 {
        match self {
            Self::Trap { depth_cm, .. } => *depth_cm,
            Self::Door { width_cm, .. } => -width_cm,
        }
    }
}

impl Display for Measure {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Trap { width_cm, depth_cm, .. } => write!(f, "{depth_cm} cm deep, {width_cm} cm wide"),
            Self::Door { width_cm, .. } => {
                write!(f, "{width_cm} cm ({:.2} diameters)", width_cm / 200.0 / KHEPERA_RADIUS_M)
            }
        }
    }
}

/// The limit of a controller in one group of questions.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Limit {
    /// The group, see [`Measure::group`].
    pub group: String,
    /// The hardest that is passed in at least [`PASSED`] of the runs; of equal ones the first.
    pub passed: Option<Passed>,
    /// Those that are no harder and yet are not passed: with any of them the limit is no clean one.
    pub missed: Vec<Measure>,
}

/// A question that is passed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Passed {
    /// Which.
    pub measure: Measure,
    /// How often.
    pub success: Rate,
    /// Wilson's 95 % interval of it.
    pub success_wilson_95: (f64, f64),
}

/// The limits in all groups, in the order in which they first occur; `results` are the questions' own.
#[must_use]
pub fn limits(questions: &[Question], results: &[SceneResult]) -> Vec<Limit> {
    let answers = || {
        let pairs = questions.iter().zip(results);
        pairs.filter_map(|(question, result)| Some((question.measure.as_ref()?, result.success)))
    };
    let mut groups: Vec<String> = Vec::new();
    for (measure, _) in answers() {
        let group = measure.group();
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    groups
        .into_iter()
        .map(|group| {
            let of_group = answers().filter(|(measure, _)| measure.group() == group).collect();
            limit(group, of_group)
        })
        .collect()
}

fn limit(group: String, answers: Vec<(&Measure, Rate)>) -> Limit {
    let is_passed = |success: Rate| success.share() >= PASSED;
    let mut best: Option<(&Measure, Rate)> = None;
    for &(measure, success) in answers.iter().filter(|(_, success)| is_passed(*success)) {
        if best.is_none_or(|(easier, _)| measure.difficulty() > easier.difficulty()) {
            best = Some((measure, success));
        }
    }
    let difficulty = best.map_or(f64::NEG_INFINITY, |(measure, _)| measure.difficulty());
    let missed = answers
        .iter()
        .filter(|(measure, success)| !is_passed(*success) && measure.difficulty() <= difficulty)
        .map(|(measure, _)| (*measure).clone())
        .collect();
    let passed = best.map(|(measure, success)| Passed {
        measure: measure.clone(),
        success,
        success_wilson_95: success.wilson_95(),
    });
    Limit { group, passed, missed }
}

#[cfg(test)]
mod tests {
    use super::{Limit, Measure, limits};
    use crate::evaluation::SceneResult;
    use crate::questions::Question;
    use crate::scenes::Side;
    use crate::statistics::Rate;

    fn asked(measure: Measure, count: u32) -> (Question, SceneResult) {
        let success = Rate { count, runs: 100 };
        let question = Question { name: measure.to_string(), scenarios: Vec::new(), measure: Some(measure) };
        (question, SceneResult { success, ..SceneResult::of([]) })
    }

    fn limits_of(asked: impl IntoIterator<Item = (Question, SceneResult)>) -> Vec<Limit> {
        let (questions, results): (Vec<_>, Vec<_>) = asked.into_iter().unzip();
        limits(&questions, &results)
    }

    fn trap(side: Side, depth_cm: f64, count: u32) -> (Question, SceneResult) {
        asked(Measure::Trap { side, width_cm: 30.0, depth_cm }, count)
    }

    fn door(width_cm: f64, count: u32) -> (Question, SceneResult) {
        asked(Measure::Door { approach: String::from("straight"), width_cm }, count)
    }

    #[test]
    fn the_deepest_u_that_is_left_in_99_of_100_runs_counts_whatever_the_order() {
        let [inside, outside] = <[Limit; 2]>::try_from(limits_of([
            trap(Side::Inside, 60.0, 98),
            trap(Side::Outside, 10.0, 100),
            trap(Side::Inside, 40.0, 99),
            trap(Side::Inside, 15.0, 97),
            trap(Side::Inside, 25.0, 100),
            trap(Side::Outside, 80.0, 0),
        ]))
        .unwrap();
        let passed = inside.passed.unwrap();
        assert_eq!((inside.group.as_str(), passed.success.count), ("U from inside", 99));
        assert_eq!(passed.measure.to_string(), "40 cm deep, 30 cm wide");
        assert!(passed.success_wilson_95.0 > 0.94 && passed.success_wilson_95.1 < 1.0);
        assert_eq!(
            inside.missed.iter().map(Measure::to_string).collect::<Vec<_>>(),
            ["15 cm deep, 30 cm wide"]
        );
        assert_eq!(outside.passed.unwrap().measure.to_string(), "10 cm deep, 30 cm wide");
        assert!(outside.missed.is_empty(), "a harder one may fail");
    }

    #[test]
    fn the_narrowest_door_counts_and_none_is_none() {
        let [limit] =
            <[Limit; 1]>::try_from(limits_of([door(12.0, 100), door(8.0, 99), door(7.0, 98)])).unwrap();
        assert_eq!(limit.passed.unwrap().measure.to_string(), "8 cm (1.60 diameters)");
        let [limit] = <[Limit; 1]>::try_from(limits_of([door(12.0, 98), door(8.0, 50)])).unwrap();
        assert_eq!((limit.passed, limit.missed), (None, Vec::new()));
        let plain = Question { name: String::from("corridor"), scenarios: Vec::new(), measure: None };
        assert_eq!(limits_of([(plain, SceneResult::of([]))]), []);
    }
}
