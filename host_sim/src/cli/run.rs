//! `run`: a scenario once, or with many seeds.

use controller_core::scalar::Fixed;
use host_sim::contender::Contender;
use host_sim::map_store::StoredScalar;
use host_sim::mission::{MissionOptions, MissionResult};
use host_sim::scenario::Scenario;
use host_sim::settings::Settings;
use host_sim::sil::{HostMap, Indirect};
use host_sim::sweep::{self, LOG_PERIOD_MS};
use protocol::message::Health;
use serde_json::{Value, json};

use super::args::{RunArgs, ScalarArg};
use super::error::{CliError, Outcome};
use super::learning::{learn, load_map, load_scenario, settings, training_plan};
use super::linked;
use super::main_job::training_text;
use super::output::{OutputFolder, print, print_json};
use super::single_run::{SingleRun, file_names};
use super::sweep_run;
use super::table::facts;

pub fn run(args: &RunArgs) -> Result<Outcome, CliError> {
    check_peer(args)?;
    if let Some(address) = &args.link.link {
        return linked::run(args, address);
    }
    match args.learning.scalar() {
        ScalarArg::F32 => run_in::<f32>(args),
        ScalarArg::Fixed => run_in::<Fixed>(args),
    }
}

/// What there is to say of a peer's map.
pub const NO_MAP: &str = "nothing: this controller is told the robot's measures";

/// Refuses what a peer of our controllers does not have.
fn check_peer(args: &RunArgs) -> Result<(), CliError> {
    let Some(peer) = args.controller.filter(|controller| controller.is_peer()) else { return Ok(()) };
    let refused = [
        (args.link.link.is_some(), "--link", "runs in this process only"),
        (args.saved.map.is_some(), "--map", "drives without a map"),
        (args.fresh_maps, "--fresh-maps", "drives without a map"),
        (args.learning.scalar() == ScalarArg::Fixed, "--scalar fixed", "computes in floating point"),
    ];
    match refused.into_iter().find(|(is_given, ..)| *is_given) {
        Some((_, name, why)) => Err(CliError::Request(format!(
            "the controller {} {why}; leave out {name}, or take cooperative or fusion",
            peer.name()
        ))),
        None => Ok(()),
    }
}

fn run_in<S: StoredScalar>(args: &RunArgs) -> Result<Outcome, CliError> {
    if args.runs > 1 || args.require.is_some() {
        sweep_run::sweep_run::<S>(args)
    } else {
        run_once::<S>(args, &settings(&args.learning)?, |task| {
            let contender = Some(task.controller);
            let result = sweep::run_one(task.scenario, task.settings, contender, task.map, task.options)?;
            Ok(Driven { result, notes: Vec::new(), health: None })
        })
    }
}

/// What is to be driven, and with what.
pub struct Task<'a, S: StoredScalar> {
    pub scenario: &'a Scenario,
    pub settings: &'a Settings,
    pub controller: Contender,
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

/// Runs a scenario once, with these numbers; `drive` says by which controller.
pub fn run_once<S: StoredScalar>(
    args: &RunArgs,
    settings: &Settings,
    drive: impl FnOnce(&Task<S>) -> Result<Driven, CliError>,
) -> Result<Outcome, CliError> {
    let config = &settings.core;
    let scenario = load_scenario(&args.scenario)?;
    let loaded = load_map::<S>(&args.saved, config)?;
    let controller = args.controller.unwrap_or_else(|| Contender::of(&scenario));
    let [svg, csv] = file_names(&scenario);
    let folder = args.out.as_deref().map(|path| OutputFolder::open(path, &[&svg, &csv])).transpose()?;

    let plan = training_plan(&args.learning);
    let (map, steps, training, source) = if let (Some(stored), Some(path)) = (loaded, &args.saved.map) {
        let file = path.display().to_string();
        (stored.map, stored.provenance.steps, json!({ "map": file }), ("map", file))
    } else if controller.is_peer() {
        (HostMap::regular(), 0, Value::Null, ("learned", String::from(NO_MAP)))
    } else {
        let learned = learn::<S, Indirect<S>>(config, &plan)?;
        let training = json!({ "seed": plan.seed, "steps": plan.steps });
        (learned.map, plan.steps, training, ("learned", training_text(plan.steps, config)))
    };
    let sample_ms = if folder.is_some() { LOG_PERIOD_MS } else { 0 };
    let options = MissionOptions { seed: plan.seed, sample_ms };
    let task = Task { scenario: &scenario, settings, controller, map: &map, steps, options };
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
