//! `train`: learn a map, then measure how precisely it positions the robot (P1, section 3.2).

use controller_core::config::Config;
use controller_core::kohonen::output::{ControlMatrix, MotorVector, Output};
use controller_core::scalar::{Fixed, Scalar};
use core::ops::Range;
use host_sim::map_store::{self, StoredScalar};
use host_sim::positioning::{PositioningPlan, PositioningSummary, TargetResult, positioning_test, summarise};
use host_sim::sil::{HostMap, Indirect};
use host_sim::simulation::PAPERS;
use host_sim::sweep::Learned;
use host_sim::training::TrainingPlan;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use serde_json::{Value, json};

use super::args::{MappingArg, ScalarArg, TrainArgs};
use super::error::{CliError, Outcome};
use super::learning::{configuration, learn, learn_each, seeds, threads, training_plan};
use super::linked;
use super::main_job::training_text;
use super::output::{OutputFolder, hex, print, print_json};
use super::table::{facts, millimetres, percent, table};

/// All trials of one mapping.
struct Trials {
    mapping: &'static str,
    seeds: Vec<u64>,
    each: Vec<PositioningSummary>,
    all: PositioningSummary,
    hashes: Vec<u64>,
}

pub fn train(args: &TrainArgs) -> Result<Outcome, CliError> {
    if let Some(address) = &args.link.link {
        return linked::train(args, address);
    }
    match args.learning.scalar() {
        ScalarArg::F32 => train_in::<f32>(args),
        ScalarArg::Fixed => train_in::<Fixed>(args),
    }
}

fn train_in<S: StoredScalar>(args: &TrainArgs) -> Result<Outcome, CliError> {
    let config = configuration(&args.learning)?;
    let seeds = seeds(args.learning.seed, args.trials.unwrap_or(1))?;
    if args.trials.is_none() {
        return train_once::<S>(args, &config);
    }
    let pool = threads(args.threads)?;
    let mut trials = Vec::new();
    if args.mapping != Some(MappingArg::Direct) {
        trials.push(pool.install(|| measure::<S, ControlMatrix<S::Weight>>(args, &config, seeds.clone()))?);
    }
    if args.mapping != Some(MappingArg::Indirect) {
        trials.push(pool.install(|| measure::<S, MotorVector<S::Weight>>(args, &config, seeds.clone()))?);
    }
    report(args, &config, S::NAME, &trials, None)
}

/// One map, which can be saved.
fn train_once<S: StoredScalar>(args: &TrainArgs, config: &Config) -> Result<Outcome, CliError> {
    if args.mapping == Some(MappingArg::Direct) {
        if args.out.is_some() {
            let message = "--out saves indirect maps only; leave out --out or --mapping direct";
            return Err(CliError::Request(message.to_owned()));
        }
        let plan = training_plan(&args.learning);
        let learned = learn::<S, MotorVector<S::Weight>>(config, &plan)?;
        let results = test(config, &learned.map, plan.seed)?;
        let trials = summary::<S, MotorVector<S::Weight>>(vec![(plan.seed, learned.hash, results)]);
        return report(args, config, S::NAME, &[trials], None);
    }
    learn_save_test::<S>(
        args,
        config,
        |plan| learn::<S, Indirect<S>>(config, plan),
        |learned, plan| test(config, &learned.map, plan.seed),
    )
}

/// Learns a map, saves it if that was asked for, and measures it; where it learns and drives is for the two functions
/// to say.
pub fn learn_save_test<S: StoredScalar>(
    args: &TrainArgs,
    config: &Config,
    learn: impl FnOnce(&TrainingPlan) -> Result<Learned<S, Indirect<S>>, CliError>,
    test: impl FnOnce(&Learned<S, Indirect<S>>, &TrainingPlan) -> Result<Vec<TargetResult>, CliError>,
) -> Result<Outcome, CliError> {
    let plan = training_plan(&args.learning);
    let target = args.out.as_deref().map(OutputFolder::for_file).transpose()?;
    let learned = learn(&plan)?;
    let mut file = None;
    if let Some((folder, name)) = target {
        let bytes = map_store::to_bytes(&learned.map, config, plan.seed, plan.steps)
            .map_err(|error| CliError::Request(format!("the map cannot be saved ({error})")))?;
        file = Some(folder.write(&name, &bytes)?);
    }
    let results = test(&learned, &plan)?;
    let trials = summary::<S, Indirect<S>>(vec![(plan.seed, learned.hash, results)]);
    report(args, config, S::NAME, &[trials], file)
}

/// Trains and tests a map for each seed, in parallel.
fn measure<S: Scalar, O: Output<S>>(
    args: &TrainArgs,
    config: &Config,
    seeds: Range<u64>,
) -> Result<Trials, CliError> {
    let learned = learn_each::<S, O>(config, &training_plan(&args.learning), seeds.clone())?;
    let pairs: Vec<_> = seeds.zip(learned).collect();
    let tested: Vec<_> = pairs
        .into_par_iter()
        .map(|(seed, learned)| Ok((seed, learned.hash, test(config, &learned.map, seed)?)))
        .collect();
    Ok(summary::<S, O>(tested.into_iter().collect::<Result<_, CliError>>()?))
}

fn test<S: Scalar, O: Output<S>>(
    config: &Config,
    map: &HostMap<S, O>,
    seed: u64,
) -> Result<Vec<TargetResult>, CliError> {
    let plan = PositioningPlan { seed, ..PositioningPlan::default() };
    Ok(positioning_test(config, map, &plan, &PAPERS)?)
}

/// Sums up trials: seed, hash of the training, results.
fn summary<S: Scalar, O: Output<S>>(trials: Vec<(u64, u64, Vec<TargetResult>)>) -> Trials {
    let all: Vec<TargetResult> = trials.iter().flat_map(|(_, _, results)| results.iter().copied()).collect();
    Trials {
        mapping: O::NAME,
        seeds: trials.iter().map(|(seed, _, _)| *seed).collect(),
        each: trials.iter().map(|(_, _, results)| summarise(results)).collect(),
        all: summarise(&all),
        hashes: trials.iter().map(|(_, hash, _)| *hash).collect(),
    }
}

impl Trials {
    /// Mean error of the worst trial.
    fn worst_trial_m(&self) -> f64 {
        self.each.iter().map(|trial| trial.mean_error_m).fold(0.0, f64::max)
    }
}

fn report(
    args: &TrainArgs,
    config: &Config,
    scalar: &str,
    trials: &[Trials],
    file: Option<String>,
) -> Result<Outcome, CliError> {
    if args.json {
        let mappings: Vec<Value> = trials.iter().map(document).collect();
        print_json(&json!({
            "scalar": scalar,
            "seed": args.learning.seed,
            "steps": args.learning.steps,
            "targets": PositioningPlan::default().targets,
            "mappings": mappings,
            "file": file,
        }))?;
        return Ok(Outcome::Ok);
    }
    let targets = PositioningPlan::default().targets;
    let first = args.learning.seed;
    let seeds = match args.trials {
        Some(trials) => format!("seeds {first} to {}", first + u64::from(trials) - 1),
        None => format!("seed {first}"),
    };
    let head = facts([
        ("learned", training_text(args.learning.steps, config)),
        ("tested", format!("with {targets} targets each, {seeds}, scalar {scalar}, 10 % noise")),
    ]);
    let hashes: String = match trials {
        [one] if args.trials.is_none() => {
            one.hashes.iter().map(|hash| facts([("state hash", hex(*hash))])).collect()
        }
        _ => String::new(),
    };
    let wrote = file.map_or_else(String::new, |file| format!("wrote {file}\n"));
    print(&format!("{head}\n{}\n{hashes}{wrote}", results_table(trials)))?;
    Ok(Outcome::Ok)
}

fn results_table(trials: &[Trials]) -> String {
    let head = [
        "mapping",
        "mean error mm",
        "worst trial mm",
        "worst target mm",
        "within 1 mm %",
        "never stopped %",
        "steps/m",
    ];
    let mut rows = vec![head.map(String::from).to_vec()];
    for trials in trials {
        rows.push(vec![
            trials.mapping.to_owned(),
            format!("{:.2}", trials.all.mean_error_m * 1000.0),
            format!("{:.2}", trials.worst_trial_m() * 1000.0),
            millimetres(trials.all.worst_error_m),
            percent(trials.all.within_1_mm),
            percent(trials.all.never_stopped),
            format!("{:.1}", trials.all.steps_per_metre),
        ]);
    }
    table(&rows)
}

fn document(trials: &Trials) -> Value {
    let figures = |summary: &PositioningSummary| {
        json!({
            "mean_error_m": summary.mean_error_m,
            "worst_error_m": summary.worst_error_m,
            "within_1_mm": summary.within_1_mm,
            "never_stopped": summary.never_stopped,
            "steps_per_metre": summary.steps_per_metre,
        })
    };
    let each = trials.seeds.iter().zip(&trials.each).zip(&trials.hashes);
    json!({
        "mapping": trials.mapping,
        "all": figures(&trials.all),
        "trials": each
            .map(|((seed, summary), hash)| json!({ "seed": seed, "hash": hex(*hash), "figures": figures(summary) }))
            .collect::<Vec<_>>(),
    })
}
