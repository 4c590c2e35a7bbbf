//! What a search for a contender's numbers is about: which numbers, on which scenes, and what a run is worth.
//!
//! The same scenes, score and budget for every contender, so that a comparison is of ideas and not of patience. Tests
//! and tables use other measures, angles and seeds besides those tuned on.

use controller_core::kohonen::map::Map;

use crate::contender::Contender;
use crate::mission::{MissionOptions, MissionResult};
use crate::peers::config::PeerConfig;
use crate::scenario::{Scenario, ScenarioError};
use crate::scenes::{Circling, Corridor, Disturbance, Door, Scene, Side, Slalom, Trap, WallEnd};
use crate::search::{Candidate, Dimension, SearchPlan, search};
use crate::settings::Settings;
use crate::sil::{HostMap, Indirect};
use crate::sweep::run_one;

/// Traps that are tuned on: side, width and depth in cm, approach in degrees.
const TRAPS: [(Side, f64, f64, f64); 7] = [
    (Side::Outside, 20.0, 10.0, 0.0),
    (Side::Outside, 20.0, 10.0, 30.0),
    (Side::Outside, 30.0, 20.0, 0.0),
    (Side::Outside, 30.0, 20.0, -20.0),
    (Side::Inside, 30.0, 25.0, 0.0),
    (Side::Inside, 40.0, 40.0, 0.0),
    (Side::Inside, 40.0, 40.0, 45.0),
];
/// Doors: width in cm, approach in degrees.
const DOORS: [(f64, f64); 6] = [(8.0, 0.0), (8.0, 45.0), (7.0, 0.0), (7.0, -45.0), (6.5, 0.0), (6.5, 30.0)];
/// Figures of the papers: crowded rooms, and moving robots.
const FIGURES: [&str; 3] = ["p1_fig8", "p2_fig6", "p2_fig7"];

/// The scenes that are tuned on.
///
/// # Errors
/// None, as long as the figures are built in.
pub fn scenes() -> Result<Vec<Scenario>, ScenarioError> {
    let metres = |centimetres: f64| centimetres / 100.0;
    let trap = |(side, width, depth, approach_deg)| {
        Scene::Trap(Trap { width_m: metres(width), depth_m: metres(depth), side, approach_deg })
    };
    let door = |(width, approach_deg)| Scene::Door(Door { width_m: metres(width), approach_deg });
    let others = [
        Scene::WallEnd(WallEnd { past_m: 0.05, approach_deg: 0.0 }),
        Scene::Corridor(Corridor { width_m: 0.1 }),
        Scene::Slalom(Slalom { gap_m: 0.1 }),
        Scene::Circling(Circling { discs: 2, speed_m_s: 0.05 }),
        Scene::Circling(Circling { discs: 2, speed_m_s: 0.1 }),
    ];
    let drawn = TRAPS.map(trap).into_iter().chain(DOORS.map(door)).chain(others);
    let drawn = drawn.map(|scene| Ok(scene.scenario(&Disturbance::PAPERS)));
    drawn.chain(FIGURES.map(Scenario::builtin)).collect()
}

/// What a run is worth: 1 for success and up to a tenth more for haste, a little for arriving with a contact.
#[must_use]
pub fn score(result: &MissionResult, time_limit_s: f64) -> f64 {
    let haste = 0.1 * (1.0 - result.duration_s / time_limit_s).max(0.0);
    match (result.success, result.reached) {
        (true, _) => 1.0 + haste,
        (false, true) => 0.2 + haste,
        (false, false) => 0.0,
    }
}

/// A search for the numbers of a peer.
#[derive(Debug)]
pub struct Tuning {
    contender: Contender,
    settings: Settings,
    space: Vec<Dimension>,
    scenes: Vec<Scenario>,
}

impl Tuning {
    /// From these settings on; `None` for a contender without numbers to search for.
    #[must_use]
    pub fn new(contender: Contender, settings: Settings, scenes: Vec<Scenario>) -> Option<Self> {
        let space = PeerConfig::searched(contender);
        (!space.is_empty()).then_some(Self { contender, settings, space, scenes })
    }

    /// Runs of the whole search.
    #[must_use]
    pub fn total_runs(&self, plan: &SearchPlan) -> u64 {
        plan.total_runs(self.scenes.len())
    }

    /// Names of the scenes.
    pub fn scene_names(&self) -> impl Iterator<Item = &str> {
        self.scenes.iter().map(|scene| scene.name.as_str())
    }

    /// The settings with these values in the place of what is searched for.
    #[must_use]
    pub fn with_values(&self, values: &[f64]) -> Settings {
        let mut settings = self.settings.clone();
        for (dimension, &value) in self.space.iter().zip(values) {
            if let Some(number) = settings.peers.number_mut(dimension.name) {
                *number = value;
            }
        }
        settings
    }

    /// Names and values of a candidate.
    pub fn named<'a>(&'a self, candidate: &'a Candidate) -> impl Iterator<Item = (&'static str, f64)> + 'a {
        self.space.iter().map(|dimension| dimension.name).zip(candidate.values.iter().copied())
    }

    /// Searches; `progress` hears of every run, `report` of every generation with its best.
    pub fn run(
        &self,
        plan: &SearchPlan,
        progress: &(dyn Fn() + Sync),
        mut report: impl FnMut(u32, &Candidate),
    ) -> Vec<Candidate> {
        let mut peers = self.settings.peers.clone();
        let start = self.space.iter().map(|dimension| {
            let value = peers.number_mut(dimension.name).map_or(dimension.low, |value| *value);
            value.clamp(dimension.low, dimension.high)
        });
        let start: Vec<f64> = start.collect();
        let map: HostMap<f32, Indirect<f32>> = Map::regular();
        let score = |values: &[f64], scene: usize, seed: u64| {
            let scene = &self.scenes[scene];
            let options = MissionOptions { seed, sample_ms: 0 };
            let run = run_one(scene, &self.with_values(values), Some(self.contender), &map, options);
            progress();
            // A run that cannot begin is worth nothing.
            run.map_or(0.0, |result| score(&result, scene.time_limit_s))
        };
        search(&self.space, &start, self.scenes.len(), plan, score, |generation, survivors| {
            if let Some(best) = survivors.first() {
                report(generation, best);
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{SearchPlan, Settings, Tuning, scenes};
    use crate::contender::Contender;

    #[test]
    fn a_search_says_the_same_twice_and_stays_within_what_is_valid() {
        let scenes: Vec<_> =
            scenes().unwrap().into_iter().filter(|scene| scene.name == "door_8_+0").collect();
        assert_eq!(scenes.len(), 1);
        let plan = SearchPlan { seed: 5, generations: 2, candidates: 3, survivors: 2, runs: 1 };
        for contender in Contender::ALL {
            let tuning = Tuning::new(contender, Settings::default(), scenes.clone());
            assert_eq!(tuning.is_some(), contender.is_peer());
            let Some(tuning) = tuning else { continue };
            let find = || tuning.run(&plan, &|| (), |_, _| ());
            let found = find();
            assert_eq!(found, find(), "{contender:?}");
            tuning.with_values(&found[0].values).peers.validate().unwrap();
        }
    }
}
