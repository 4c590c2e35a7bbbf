//! `run`: a scenario once, or with many seeds.

use controller_core::config::Config;
use controller_core::scalar::Fixed;
use host_sim::map_store::StoredScalar;
use host_sim::mission::{MissionOptions, MissionResult};
use host_sim::scenario::Scenario;
use host_sim::sil::{HostMap, Indirect};
use host_sim::sweep::{self, LOG_PERIOD_MS};
use protocol::message::Health;
use serde_json::json;

use super::args::{ControllerArg, RunArgs, ScalarArg};
use super::error::{CliError, Outcome};
use super::learning::{configuration, learn, load_map, load_scenario, training_plan};
use super::linked;
use super::main_job::training_text;
use super::output::{OutputFolder, print, print_json};
use super::single_run::{SingleRun, controller_of, file_names};
use super::sweep_run;
use super::table::facts;

pub fn run(args: &RunArgs) -> Result<Outcome, CliError> {
    if let Some(address) = &args.link.link {
        return linked::run(args, address);
    }
    match args.learning.scalar() {
        ScalarArg::F32 => run_in::<f32>(args),
        ScalarArg::Fixed => run_in::<Fixed>(args),
    }
}

fn run_in<S: StoredScalar>(args: &RunArgs) -> Result<Outcome, CliError> {
    if args.runs > 1 || args.require.is_some() {
        sweep_run::sweep_run::<S>(args)
    } else {
        run_once::<S>(args, |task| {
            let architecture = Some(task.controller.architecture());
            let result = sweep::run_one(task.scenario, task.config, architecture, task.map, task.options)?;
            Ok(Driven { result, notes: Vec::new(), health: None })
        })
    }
}

/// What is to be driven, and with what.
pub struct Task<'a, S: StoredScalar> {
    pub scenario: &'a Scenario,
    pub config: &'a Config,
    pub controller: ControllerArg,
    pub map: &'a HostMap<S, Indirect<S>>,
    /// How long the map was trained.
    pub steps: u32,
    pub options: MissionOptions,
}

/// What came of it.
pub struct Driven {
    pub result: MissionResult,
    /// What else there is to say.
    pub notes: Vec<(&'static str, String)>,
    /// How the board did, where there is one.
    pub health: Option<Health>,
}

/// Runs a scenario once; `drive` says by which controller.
pub fn run_once<S: StoredScalar>(
    args: &RunArgs,
    drive: impl FnOnce(&Task<S>) -> Result<Driven, CliError>,
) -> Result<Outcome, CliError> {
    let config = configuration(&args.learning)?;
    let scenario = load_scenario(&args.scenario)?;
    let loaded = load_map::<S>(&args.saved, &config)?;
    let controller = args.controller.unwrap_or_else(|| controller_of(&scenario));
    let [svg, csv] = file_names(&scenario);
    let folder = args.out.as_deref().map(|path| OutputFolder::open(path, &[&svg, &csv])).transpose()?;

    let plan = training_plan(&args.learning);
    let (map, steps, training, source) = if let (Some(stored), Some(path)) = (loaded, &args.saved.map) {
        let file = path.display().to_string();
        (stored.map, stored.provenance.steps, json!({ "map": file }), ("map", file))
    } else {
        let learned = learn::<S, Indirect<S>>(&config, &plan)?;
        let training = json!({ "seed": plan.seed, "steps": plan.steps });
        (learned.map, plan.steps, training, ("learned", training_text(plan.steps, &config)))
    };
    let sample_ms = if folder.is_some() { LOG_PERIOD_MS } else { 0 };
    let options = MissionOptions { seed: plan.seed, sample_ms };
    let task = Task { scenario: &scenario, config: &config, controller, map: &map, steps, options };
    let Driven { result, notes, health } = drive(&task)?;
    let run = SingleRun { scenario: &scenario, controller, scalar: S::NAME, result: &result };
    let files = folder.map_or_else(|| Ok(Vec::new()), |folder| run.write(&folder))?;
    if args.json {
        let mut document = run.json(&training, &files);
        if let Some(health) = health {
            document["board"] = json!({ "health": health });
        }
        print_json(&document)?;
    } else {
        let wrote = if files.is_empty() { String::new() } else { format!("wrote {}\n", files.join(", ")) };
        let (head, notes) = (facts([source]), facts(notes));
        print(&format!("{head}{}{notes}\n{wrote}{}", run.text(), run.verdict()))?;
    }
    Ok(if result.success { Outcome::Ok } else { Outcome::RobotFailed })
}
