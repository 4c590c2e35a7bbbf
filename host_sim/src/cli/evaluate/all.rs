//! `evaluate all`: every evaluation that drives, one after the other.

use std::time::Instant;

use clap::Args;
use serde_json::{Map, Value};

use super::super::args::LearningArgs;
use super::super::error::{CliError, Outcome};
use super::super::output::{print, print_json};
use super::Report;
use super::robots::{EvaluateRobotsArgs, robots};
use super::scenes::{SceneArgs, What, evaluate};

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim evaluate all --out fig               what the results in docs/ are made of
  host_sim evaluate all --runs 2 --scenario-runs 4 --robot-runs 4    a first look

Each evaluation can be had alone: scenarios, traps, doors, traffic, surfaces, robots.")]
pub struct EvaluateAllArgs {
    #[command(flatten)]
    pub scenes: SceneArgs,
    /// Runs of each of the papers' scenarios, in place of --runs
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub scenario_runs: u32,
    /// Runs of each scene of several robots, in place of --runs
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub robot_runs: u32,
}

pub fn all(args: &EvaluateAllArgs) -> Result<Outcome, CliError> {
    let begin = Instant::now();
    let usual = &SceneArgs { surfaces: false, ..args.scenes.clone() };
    let mut reports = Reports { json: usual.json, outcome: Outcome::Ok, documents: Map::new() };
    let scenarios = SceneArgs { runs: args.scenario_runs, ..usual.clone() };
    reports.add(What::Papers.name(), evaluate(What::Papers, &scenarios)?)?;
    for what in [What::Traps, What::Doors, What::Traffic, What::Surfaces] {
        reports.add(what.name(), evaluate(what, usual)?)?;
    }
    reports.add("robots", robots(&robot_args(args))?)?;
    if usual.json {
        print_json(&Value::Object(reports.documents))?;
    } else {
        print(&format!("\nall of it took {:.0} s\n", begin.elapsed().as_secs_f64()))?;
    }
    Ok(reports.outcome)
}

fn robot_args(args: &EvaluateAllArgs) -> EvaluateRobotsArgs {
    let scenes = &args.scenes;
    EvaluateRobotsArgs {
        scenarios: Vec::new(),
        learning: LearningArgs {
            steps: scenes.steps,
            scalar: Some(scenes.scalar),
            seed: scenes.seed,
            config: scenes.config.clone(),
        },
        runs: args.robot_runs,
        fresh_maps: false,
        require: scenes.require,
        threads: scenes.threads,
        out: scenes.out.clone(),
        json: scenes.json,
    }
}

/// What has been reported so far.
struct Reports {
    json: bool,
    outcome: Outcome,
    documents: Map<String, Value>,
}

impl Reports {
    /// Text is printed as soon as it is there, since the whole takes minutes.
    fn add(&mut self, name: &str, report: Report) -> Result<(), CliError> {
        if report.outcome == Outcome::RobotFailed {
            self.outcome = Outcome::RobotFailed;
        }
        if self.json {
            self.documents.insert(name.to_owned(), report.document);
        } else {
            print(&format!("== {name} ==\n\n{}\n", report.text))?;
        }
        Ok(())
    }
}
