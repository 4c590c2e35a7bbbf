//! Rates over scenes: one question in many measures, many runs of each, by the same maps.
//!
//! All runs of all scenes go to the threads together; results come back in the order of the scenes, whichever thread
//! was first.

use controller_core::scalar::Scalar;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;

use crate::contender::Contender;
use crate::mission::{MissionOptions, MissionResult};
use crate::scenario::Scenario;
use crate::settings::Settings;
use crate::sil::Indirect;
use crate::statistics::{Rate, quantile};
use crate::sweep::{LOG_PERIOD_MS, Maps, SweepError, run_one};

/// What is evaluated: a controller, the numbers of all, and the maps for those that drive with one.
#[derive(Debug)]
pub struct Subject<'a, S: Scalar> {
    /// The numbers.
    pub settings: &'a Settings,
    /// Who drives.
    pub contender: Contender,
    /// Learned maps; run `i` drives with the `i`th, in turn.
    pub maps: &'a Maps<S, Indirect<S>>,
}

/// Which runs of each scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunPlan {
    /// Seed of the first run; the others follow.
    pub seed: u64,
    /// Runs of each scene.
    pub runs: u32,
    /// The first so many keep a log.
    pub logged: u32,
}

/// What came of the runs of one scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SceneResult {
    /// Runs without contact that reached the goal in time.
    pub success: Rate,
    /// Runs with a contact or more.
    pub contact: Rate,
    /// Runs that did not reach the goal in time.
    pub late: Rate,
    /// Median time to the goal over the runs that reached it, in s.
    pub time_median_s: Option<f64>,
    /// Median way to the goal, in m.
    pub way_median_m: Option<f64>,
    /// Median over the same runs of how much the heading changed for each metre, in rad/m.
    pub turn_median_rad_per_m: Option<f64>,
}

impl SceneResult {
    /// Of runs.
    #[must_use]
    pub fn of<'a>(results: impl IntoIterator<Item = &'a MissionResult>) -> Self {
        let results: Vec<&MissionResult> = results.into_iter().collect();
        let arrived = || results.iter().filter(|result| result.reached);
        let times: Vec<f64> = arrived().map(|result| result.duration_s).collect();
        let ways: Vec<f64> = arrived().map(|result| result.way_m).collect();
        let turns: Vec<f64> =
            arrived().map(|result| result.turned_rad / result.way_m.max(f64::MIN_POSITIVE)).collect();
        Self {
            success: Rate::of(results.iter().map(|result| result.success)),
            contact: Rate::of(results.iter().map(|result| result.contacts > 0)),
            late: Rate::of(results.iter().map(|result| !result.reached)),
            time_median_s: quantile(&times, 0.5),
            way_median_m: quantile(&ways, 0.5),
            turn_median_rad_per_m: quantile(&turns, 0.5),
        }
    }
}

/// Runs every scenario so many times; `progress` hears of every run that is done.
///
/// # Errors
/// That of the first run, in their order, that cannot begin.
pub fn run_scenes<S: Scalar>(
    scenarios: &[Scenario],
    subject: &Subject<'_, S>,
    plan: RunPlan,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<Vec<MissionResult>>, SweepError> {
    let runs = scenarios.iter().flat_map(|scenario| (0..plan.runs).map(move |run| (scenario, run)));
    let runs: Vec<(&Scenario, u32)> = runs.collect();
    let run = |(scenario, run): (&Scenario, u32)| {
        let sample_ms = if run < plan.logged { LOG_PERIOD_MS } else { 0 };
        let options = MissionOptions { seed: plan.seed.wrapping_add(u64::from(run)), sample_ms };
        let index = usize::try_from(run).unwrap_or(usize::MAX);
        let result = subject
            .maps
            .with(index, |map| run_one(scenario, subject.settings, Some(subject.contender), map, options));
        progress();
        result
    };
    let results: Vec<_> = runs.into_par_iter().map(run).collect();
    let results: Vec<MissionResult> = results.into_iter().collect::<Result<_, _>>()?;
    let per_scene = usize::try_from(plan.runs.max(1)).unwrap_or(usize::MAX);
    Ok(results.chunks(per_scene).map(<[MissionResult]>::to_vec).collect())
}
