//! Many runs of one scenario, in parallel, with an outcome that does not depend on the number of threads.
//!
//! Run `i` has the seed `first + i` and nothing in common with the others but what all of them only read. Results come
//! back in the order of the runs, whichever thread was first.

use core::ops::Range;

use controller_core::config::{Config, ConfigError};
use controller_core::kohonen::output::Output;
use controller_core::scalar::Scalar;
use controller_core::state_hash::StateHash;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;

use crate::contender::Contender;
use crate::mission::{self, MissionError, MissionOptions, MissionResult};
use crate::peers;
use crate::peers::config::PeerConfigError;
use crate::peers::port::PeerPort;
use crate::peers::robot::PeerRobot;
use crate::scenario::Scenario;
use crate::settings::Settings;
use crate::sil::{HostMap, Sil};
use crate::simulation::PAPERS;
use crate::statistics::{Rate, quantile};
use crate::training::{Training, TrainingPlan};
use crate::world::World;

/// Why a run cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The configuration cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The configuration of the peers cannot be used.
    #[error(transparent)]
    Peers(#[from] PeerConfigError),
    /// The mission cannot begin.
    #[error(transparent)]
    Mission(#[from] MissionError),
}

/// The maps that the runs drive with.
#[derive(Debug, Clone)]
pub enum Maps<S: Scalar, O: Output<S>> {
    /// The same for all.
    Shared(Box<HostMap<S, O>>),
    /// One for each run, in their order.
    PerRun(Vec<HostMap<S, O>>),
}

impl<S: Scalar, O: Output<S>> Maps<S, O> {
    /// The map of a run; with too few maps they are used in turn.
    #[must_use]
    pub fn of_run(&self, run: usize) -> Option<&HostMap<S, O>> {
        match self {
            Self::Shared(map) => Some(map),
            Self::PerRun(maps) => maps.get(run.checked_rem(maps.len())?),
        }
    }

    /// Does something with the map of a run; without any map, with an untrained one.
    pub fn with<R>(&self, run: usize, f: impl FnOnce(&HostMap<S, O>) -> R) -> R {
        match self.of_run(run) {
            Some(map) => f(map),
            None => f(&HostMap::regular()),
        }
    }
}

/// Milliseconds between two lines of a log: the period of obstacle avoidance, in which a command stands.
pub const LOG_PERIOD_MS: u64 = 128;

/// What came of training.
#[derive(Debug, Clone)]
pub struct Learned<S: Scalar, O: Output<S>> {
    /// The map.
    pub map: HostMap<S, O>,
    /// Hash over all decisions and poses.
    pub hash: u64,
}

/// Learns a map from scratch in an empty place under the papers' noise; `progress` hears of every step.
///
/// # Errors
/// If the configuration cannot be used.
pub fn learn<S: Scalar, O: Output<S>>(
    config: &Config,
    plan: &TrainingPlan,
    progress: &(dyn Fn() + Sync),
) -> Result<Learned<S, O>, ConfigError> {
    let world = World::default();
    let mut training = Training::<Sil<S, O>>::new(config, plan.clone(), &PAPERS, &world)?;
    for _ in 0..plan.steps {
        let Ok(()) = training.run(1);
        progress();
    }
    let hash = training.simulation_mut().hash();
    Ok(Learned { map: training.controller().controller.map().clone(), hash })
}

/// Learns one map for each seed, in parallel.
///
/// # Errors
/// If the configuration cannot be used.
pub fn learn_each<S: Scalar, O: Output<S>>(
    config: &Config,
    plan: &TrainingPlan,
    seeds: Range<u64>,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<Learned<S, O>>, ConfigError> {
    let learn_one = |seed| learn(config, &TrainingPlan { seed, ..plan.clone() }, progress);
    let learned: Vec<_> = seeds.collect::<Vec<_>>().into_par_iter().map(learn_one).collect();
    learned.into_iter().collect()
}

/// One run of a contender, by default the one that the scenario names; the log is kept every `sample_ms`, 0 for none.
///
/// Peers do not look at the map.
///
/// # Errors
/// If the configuration cannot be used, or the mission cannot begin.
pub fn run_one<S: Scalar, O: Output<S>>(
    scenario: &Scenario,
    base: &Settings,
    contender: Option<Contender>,
    map: &HostMap<S, O>,
    options: MissionOptions,
) -> Result<MissionResult, SweepError> {
    let config = mission::config_for(scenario, &base.core, contender);
    let navigator =
        contender.and_then(|contender| peers::navigator(contender, PeerRobot::new(&config), &base.peers));
    if let Some(navigator) = navigator {
        base.peers.validate()?;
        let controller = PeerPort::new(navigator, &config, &base.peers)?;
        return Ok(mission::run(scenario, controller, &config, options)?);
    }
    // Navigation does not ask how long the map was trained.
    let controller = Sil::trained(&config, map.clone(), 0)?;
    Ok(mission::run(scenario, controller, &config, options)?)
}

/// Which runs, and what is kept of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SweepPlan {
    /// One run for each seed.
    pub seeds: Range<u64>,
    /// The first so many runs keep a log, every [`LOG_PERIOD_MS`].
    pub logged: usize,
}

/// Runs a scenario with each seed; `progress` hears of every run that is done.
///
/// # Errors
/// That of the first run, in their order, that cannot begin.
pub fn run_all<S: Scalar, O: Output<S>>(
    scenario: &Scenario,
    base: &Settings,
    contender: Option<Contender>,
    maps: &Maps<S, O>,
    plan: &SweepPlan,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<MissionResult>, SweepError> {
    for_all(maps, plan, progress, |map, options| run_one(scenario, base, contender, map, options))
}

/// Does something with the map and the options of each run, in parallel; the outcomes come in the order of the runs.
pub(crate) fn for_all<S: Scalar, O: Output<S>, T: Send>(
    maps: &Maps<S, O>,
    plan: &SweepPlan,
    progress: &(dyn Fn() + Sync),
    run_one: impl Fn(&HostMap<S, O>, MissionOptions) -> Result<T, SweepError> + Sync,
) -> Result<Vec<T>, SweepError> {
    let runs: Vec<(usize, u64)> = plan.seeds.clone().enumerate().collect();
    let run = |(run, seed)| {
        let sample_ms = if run < plan.logged { LOG_PERIOD_MS } else { 0 };
        let options = MissionOptions { seed, sample_ms };
        let result = maps.with(run, |map| run_one(map, options));
        progress();
        result
    };
    // Collected before the first error is taken: which one that is must not depend on the threads.
    let results: Vec<_> = runs.into_par_iter().map(run).collect();
    results.into_iter().collect()
}

/// Hash over the state hashes of all runs, in their order.
pub fn combined_hash<'a>(results: impl IntoIterator<Item = &'a MissionResult>) -> u64 {
    let mut hash = StateHash::default();
    for result in results {
        for shift in [0, 32] {
            hash.add_word(u32::try_from(result.hash >> shift & 0xFFFF_FFFF).unwrap_or(0));
        }
    }
    hash.value()
}

/// The figures of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SweepSummary {
    /// Runs without contact that reached every checkpoint within the scenario's tolerance.
    pub success: Rate,
    /// Runs that reached the goal in time.
    pub reached: Rate,
    /// Runs with a contact or more.
    pub contact: Rate,
    /// Median time to the goal over the runs that reached it, in s.
    pub time_median_s: Option<f64>,
    /// 95th percentile of the time to the goal, in s.
    pub time_95_s: Option<f64>,
    /// Median way to the goal, in m.
    pub way_median_m: Option<f64>,
    /// Largest distance from a reached checkpoint over all runs, in m.
    pub error_worst_m: Option<f64>,
}

/// Summarises runs.
#[must_use]
pub fn summarise(results: &[MissionResult]) -> SweepSummary {
    let arrived = || results.iter().filter(|result| result.reached);
    let times: Vec<f64> = arrived().map(|result| result.duration_s).collect();
    let ways: Vec<f64> = arrived().map(|result| result.way_m).collect();
    let errors: Vec<f64> =
        results.iter().flat_map(|result| &result.arrivals).map(|arrival| arrival.error_m).collect();
    SweepSummary {
        success: Rate::of(results.iter().map(|result| result.success)),
        reached: Rate::of(results.iter().map(|result| result.reached)),
        contact: Rate::of(results.iter().map(|result| result.contacts > 0)),
        time_median_s: quantile(&times, 0.5),
        time_95_s: quantile(&times, 0.95),
        way_median_m: quantile(&ways, 0.5),
        error_worst_m: quantile(&errors, 1.0),
    }
}
