//! `evaluate`: experiments of the papers, repeated.

mod ablation;
pub mod all;
mod calibration;
mod figures;
mod report;
pub mod robots;
pub mod scenes;
mod trials;

use std::path::Path;
use std::time::Instant;

use controller_core::config::Config;
use host_sim::config_file;
use host_sim::learning_curve::{CurvePlan, analytic_test};
use host_sim::positioning::{PositioningPlan, TargetResult};
use host_sim::training::TrainingPlan;
use serde_json::{Value, json};

use super::args::{EvaluateArgs, EvaluatePositioningArgs, Evaluation, MappingArg, ScalarArg};
use super::error::{CliError, Outcome};
use super::learning::{seeds, threads};
use super::output::{OutputFolder, print, print_json};
use super::table::facts;
use scenes::What;
use trials::{Kind, Subject};

const CSV: &str = "positioning.csv";

/// What the robot's exact inverse makes of the targets of all trials.
struct Analytic {
    name: String,
    config_name: String,
    results: Vec<TargetResult>,
}

/// What an evaluation has to say.
pub struct Report {
    text: String,
    document: Value,
    outcome: Outcome,
}

impl Report {
    /// As text or as one JSON document.
    fn print(&self, json: bool) -> Result<Outcome, CliError> {
        if json {
            print_json(&self.document)?;
        } else {
            print(&self.text)?;
        }
        Ok(self.outcome)
    }
}

pub fn evaluate(args: &EvaluateArgs) -> Result<Outcome, CliError> {
    match &args.what {
        Evaluation::Positioning(args) => positioning(args),
        Evaluation::Calibration(args) => calibration::calibration(args),
        Evaluation::Scenarios(args) => scenes::evaluate(What::Papers, args)?.print(args.json),
        Evaluation::Traps(args) => scenes::evaluate(What::Traps, args)?.print(args.json),
        Evaluation::Doors(args) => scenes::evaluate(What::Doors, args)?.print(args.json),
        Evaluation::Traffic(args) => scenes::evaluate(What::Traffic, args)?.print(args.json),
        Evaluation::Surfaces(args) => scenes::evaluate(What::Surfaces, args)?.print(args.json),
        Evaluation::Robots(args) => robots::robots(args)?.print(args.json),
        Evaluation::All(args) => all::all(args),
    }
}

fn positioning(args: &EvaluatePositioningArgs) -> Result<Outcome, CliError> {
    let configs: Vec<(String, Config)> = args
        .config
        .iter()
        .map(|path| Ok((name_of(path), config_file::load(path)?.core)))
        .collect::<Result<_, CliError>>()?;
    let names = [&[CSV], &figures::FILES[..]].concat();
    let folder = args.out.as_deref().map(|out| OutputFolder::open(out, &names)).transpose()?;
    let seeds: Vec<u64> = seeds(args.trials.seed, args.trials.count)?.collect();
    let plan = CurvePlan {
        training: TrainingPlan { steps: args.steps, ..TrainingPlan::default() },
        every: args.every,
        test: PositioningPlan { targets: args.trials.targets, ..PositioningPlan::default() },
    };
    let pool = threads(args.trials.threads)?;
    let begin = Instant::now();
    if args.ablate {
        let (_, base) =
            configs.first().ok_or_else(|| CliError::Request(String::from("--config is missing")))?;
        let scalar = args.scalar.unwrap_or(ScalarArg::F32);
        let mapping = args.mapping.unwrap_or(MappingArg::Indirect);
        let text = pool.install(|| ablation::ablate(base, (mapping, scalar), &plan, &seeds))?;
        print(&format!(
            "{}\n{text}",
            head(args, &configs, format!("{:.1} s", begin.elapsed().as_secs_f64()))
        ))?;
        return Ok(Outcome::Ok);
    }
    let subjects = subjects(args, &configs);
    let kinds = pool.install(|| trials::run(subjects, &plan, &seeds))?;
    let pace = pace(&kinds, begin.elapsed().as_secs_f64());
    let analytic: Vec<Analytic> =
        configs.iter().map(|(name, config)| analytic(name, config, &plan.test, &seeds)).collect();
    let mut files = Vec::new();
    if let Some(folder) = folder {
        files.push(folder.write(CSV, report::csv(&kinds).as_bytes())?);
        for (name, figure) in figures::FILES.iter().zip(figures::draw(&kinds, &analytic)) {
            files.push(folder.write(name, figure.as_bytes())?);
        }
    }
    if args.trials.json {
        let document = json!({
            "seeds": seeds,
            "steps": args.steps,
            "every": args.every,
            "targets": args.trials.targets,
            "kinds": kinds.iter().map(report::document).collect::<Vec<_>>(),
            "analytic": analytic.iter().map(report::analytic_document).collect::<Vec<_>>(),
            "files": files,
        });
        print_json(&document)?;
        return Ok(Outcome::Ok);
    }
    print(&format!("{}\n{}", head(args, &configs, pace), report::tables(&kinds, &analytic)))?;
    files.iter().try_for_each(|file| print(&format!("wrote {file}\n")))?;
    Ok(Outcome::Ok)
}

/// The name of a configuration in tables: that of its file, without ending.
fn name_of(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// All that was asked for: each configuration with each scalar and each output layer.
fn subjects<'a>(args: &EvaluatePositioningArgs, configs: &'a [(String, Config)]) -> Vec<Subject<'a>> {
    let scalars = args.scalar.map_or_else(|| vec![ScalarArg::F32, ScalarArg::Fixed], |one| vec![one]);
    let mappings =
        args.mapping.map_or_else(|| vec![MappingArg::Indirect, MappingArg::Direct], |one| vec![one]);
    let mut subjects = Vec::new();
    for (config_name, config) in configs {
        for &scalar in &scalars {
            for &mapping in &mappings {
                let mut subject = Subject { name: String::new(), config_name, config, mapping, scalar };
                subject.name =
                    format!("{config_name}, {}, {}", subject.mapping_name(), subject.scalar_name());
                subjects.push(subject);
            }
        }
    }
    subjects
}

fn analytic(name: &str, config: &Config, test: &PositioningPlan, seeds: &[u64]) -> Analytic {
    let results = seeds
        .iter()
        .flat_map(|&seed| analytic_test(config, &PositioningPlan { seed, ..test.clone() }))
        .collect();
    Analytic { name: format!("{name}, analytic"), config_name: name.to_owned(), results }
}

/// How fast it went.
fn pace(kinds: &[Kind], seconds: f64) -> String {
    let simulated_s: f64 = kinds.iter().map(Kind::simulated_s).sum();
    format!("{seconds:.1} s, {:.0} × real time with all tests", simulated_s / seconds)
}

/// What was done.
fn head(args: &EvaluatePositioningArgs, configs: &[(String, Config)], took: String) -> String {
    let step_ms = configs.first().map_or(0, |(_, config)| config.schedule.step_ms);
    let last = args.trials.last_seed();
    facts([
        (
            "trained",
            format!(
                "{} trials of {} steps of {:.3} s, seeds {} to {last}, 10 % noise",
                args.trials.count,
                args.steps,
                f64::from(step_ms) / 1000.0,
                args.trials.seed,
            ),
        ),
        ("tested", format!("every {} steps with {} targets each", args.every, args.trials.targets)),
        ("took", took),
    ])
}
