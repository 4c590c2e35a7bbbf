//! What commands share: the configuration, the map to drive with, threads and seeds.

use core::ops::Range;
use std::path::Path;

use controller_core::config::Config;
use controller_core::kohonen::output::Output;
use controller_core::scalar::Scalar;
use host_sim::config_file;
use host_sim::map_store::{self, LearnedOn, StoredMap, StoredScalar};
use host_sim::route_planner;
use host_sim::scenario::{Route, Scenario};
use host_sim::settings::Settings;
use host_sim::sweep::{self, Learned};
use host_sim::training::TrainingPlan;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::args::{LearningArgs, SavedMapArgs};
use super::error::CliError;
use super::output::complain;
use super::progress::Progress;

/// The configuration that was asked for, checked.
pub fn configuration(args: &LearningArgs) -> Result<Config, CliError> {
    Ok(settings(args)?.core)
}

/// The same with the peers' numbers.
pub fn settings(args: &LearningArgs) -> Result<Settings, CliError> {
    settings_of(args.config.as_deref())
}

/// The configuration that was asked for of a board; what its file leaves out is as boards have it.
pub fn settings_on_board(args: &LearningArgs) -> Result<Settings, CliError> {
    let base = Settings::of_boards();
    let settings = match args.config.as_deref() {
        Some(path) => config_file::load_over(&base, path)?,
        None => base,
    };
    settings.core.check_without_movers()?;
    Ok(settings)
}

/// The numbers of a file or of a built-in name; without either, the defaults.
pub fn settings_of(config: Option<&Path>) -> Result<Settings, CliError> {
    Ok(config.map_or_else(|| Ok(Settings::default()), config_file::load)?)
}

/// A scenario of one robot that can be run: where it is to be planned, there is a plan, so that nobody waits for
/// nothing.
pub fn load_scenario(name_or_path: &str) -> Result<Scenario, CliError> {
    let scenario = load_any_scenario(name_or_path)?;
    if scenario.robot_count() > 1 {
        let message = format!(
            "{name_or_path}: [[robots]]: this command drives one robot; use `evaluate robots {name_or_path}`, or take \
             the table out"
        );
        return Err(CliError::Request(message));
    }
    Ok(scenario)
}

/// As [`load_scenario`], with any number of robots.
pub fn load_any_scenario(name_or_path: &str) -> Result<Scenario, CliError> {
    let scenario = Scenario::load(name_or_path)?;
    if matches!(scenario.route, Route::Planned { .. }) {
        route_planner::plan(&scenario, scenario.start.position, 0.0)?;
    }
    Ok(scenario)
}

/// The training that was asked for.
pub fn training_plan(args: &LearningArgs) -> TrainingPlan {
    TrainingPlan { steps: args.steps, seed: args.seed, ..TrainingPlan::default() }
}

/// Learns one map, with a progress bar.
pub fn learn<S: Scalar, O: Output<S>>(
    config: &Config,
    plan: &TrainingPlan,
) -> Result<Learned<S, O>, CliError> {
    let bar = Progress::new("learning", u64::from(plan.steps));
    Ok(sweep::learn(config, plan, &|| bar.advance())?)
}

/// Learns a map for each seed, with one progress bar for all.
pub fn learn_each<S: Scalar, O: Output<S>>(
    config: &Config,
    plan: &TrainingPlan,
    seeds: Range<u64>,
) -> Result<Vec<Learned<S, O>>, CliError> {
    let maps = seeds.end - seeds.start;
    let bar = Progress::new("learning", u64::from(plan.steps).saturating_mul(maps));
    Ok(sweep::learn_each(config, plan, seeds, &|| bar.advance())?)
}

/// The map that was asked for with `--map`, and where it comes from.
pub fn load_map<S: StoredScalar>(
    args: &SavedMapArgs,
    config: &Config,
) -> Result<Option<StoredMap<S>>, CliError> {
    load_map_file(args.map.as_deref(), args.map_of_another_robot, config)
}

/// A map from its file, if one is given.
pub fn load_map_file<S: StoredScalar>(
    path: Option<&Path>,
    map_of_another_robot: bool,
    config: &Config,
) -> Result<Option<StoredMap<S>>, CliError> {
    let Some(path) = path else { return Ok(None) };
    let file = path.display();
    let bytes = read_map_file(path)?;
    let learned_on = if map_of_another_robot { LearnedOn::AnyRobot } else { LearnedOn::ThisRobot };
    let stored = map_store::from_bytes::<S>(&bytes, config, learned_on)
        .map_err(|error| CliError::Request(format!("{file}: {error}")))?;
    if let Some(misfit) = &stored.another_robot {
        complain(&format!("note: {file} {misfit}"));
    } else if stored.provenance.config_digest != map_store::training_digest(config) {
        complain(&format!("note: {file} was learned with another configuration or version"));
    }
    Ok(Some(stored))
}

/// The bytes of a map file, whatever they are.
pub fn read_map_file(path: &Path) -> Result<Vec<u8>, CliError> {
    let file = path.display();
    std::fs::read(path).map_err(|error| {
        CliError::Request(format!("{file}: cannot be read ({error}); `train --out {file}` makes a map"))
    })
}

/// The seeds of so many runs.
pub fn seeds(first: u64, runs: u32) -> Result<Range<u64>, CliError> {
    let end = first.checked_add(u64::from(runs));
    let end = end.ok_or_else(|| {
        CliError::Request(format!("--seed {first} has not {runs} seeds from it on; choose a smaller one"))
    })?;
    Ok(first..end)
}

/// The threads that were asked for; by default one per core.
pub fn threads(count: Option<u16>) -> Result<ThreadPool, CliError> {
    let pool = ThreadPoolBuilder::new().num_threads(count.map_or(0, usize::from)).build();
    pool.map_err(|error| {
        CliError::Request(format!("cannot start the threads ({error}); ask for fewer with --threads"))
    })
}
