//! The main job: learn to move, save what was learned, cross three rooms.

use controller_core::config::Config;
use controller_core::scalar::Fixed;
use host_sim::contender::Contender;
use host_sim::map_store::{self, StoredScalar};
use host_sim::mission::MissionOptions;
use host_sim::scenario::Scenario;
use host_sim::sil::Indirect;
use host_sim::sweep::{self, LOG_PERIOD_MS};
use serde_json::json;

use super::args::{MainJobArgs, ScalarArg};
use super::error::{CliError, Outcome};
use super::learning::{learn, settings, training_plan};
use super::output::{OutputFolder, print, print_json};
use super::single_run::{SingleRun, file_names};
use super::table::facts;

const SCENARIO: &str = "p2_fig6";
const CONTROLLER: Contender = Contender::Cooperative;
const MAP_FILE: &str = "map.ekm";

pub fn main_job(args: &MainJobArgs) -> Result<Outcome, CliError> {
    match args.learning.scalar() {
        ScalarArg::F32 => main_job_in::<f32>(args),
        ScalarArg::Fixed => main_job_in::<Fixed>(args),
    }
}

fn main_job_in<S: StoredScalar>(args: &MainJobArgs) -> Result<Outcome, CliError> {
    let settings = settings(&args.learning)?;
    let config = &settings.core;
    let scenario = Scenario::builtin(SCENARIO)?;
    let [svg, csv] = file_names(&scenario);
    let folder = OutputFolder::open(&args.out, &[MAP_FILE, &svg, &csv])?;

    let plan = training_plan(&args.learning);
    let learned = learn::<S, Indirect<S>>(config, &plan)?;
    let map = map_store::to_bytes(&learned.map, config, plan.seed, plan.steps).map_err(|error| {
        CliError::Request(format!("the map cannot be saved ({error}); change the configuration"))
    })?;

    let options = MissionOptions { seed: plan.seed, sample_ms: LOG_PERIOD_MS };
    let result = sweep::run_one(&scenario, &settings, Some(CONTROLLER), &learned.map, options)?;
    let run = SingleRun { scenario: &scenario, controller: CONTROLLER, scalar: S::NAME, result: &result };

    let mut files = vec![folder.write(MAP_FILE, &map)?];
    files.extend(run.write(&folder)?);
    if args.json {
        print_json(&run.json(&json!({ "seed": plan.seed, "steps": plan.steps }), &files))?;
    } else {
        let learned = facts([("learned", training_text(plan.steps, config))]);
        print(&format!("{learned}{}\nwrote {}\n{}", run.text(), files.join(", "), run.verdict()))?;
    }
    Ok(if result.success { Outcome::Ok } else { Outcome::RobotFailed })
}

/// How long the robot has learned.
pub fn training_text(steps: u32, config: &Config) -> String {
    let step_s = f64::from(config.schedule.step_ms) / 1000.0;
    let minutes = f64::from(steps) * step_s / 60.0;
    format!("a map from scratch in {steps} steps of {step_s} s ({minutes:.0} min of the robot's time)")
}
