//! `evaluate robots`: several robots in one world, with and without the separation field.

use clap::Args;
use std::path::PathBuf;

use controller_core::scalar::Fixed;
use host_sim::figure::draw_run;
use host_sim::fleet::{self, Company, FleetSummary};
use host_sim::map_store::StoredScalar;
use host_sim::mission::MissionResult;
use host_sim::run_log;
use host_sim::scenario::Scenario;
use host_sim::sil::Indirect;
use host_sim::statistics::Rate;
use host_sim::sweep::{Maps, SweepPlan, combined_hash};
use serde_json::{Value, json};

use super::super::args::{LearningArgs, ScalarArg};
use super::super::error::{CliError, Outcome};
use super::super::learning::{configuration, learn, learn_each, seeds, threads, training_plan};
use super::super::output::{OutputFolder, hex};
use super::super::progress::Progress;
use super::super::single_run::result_json;
use super::super::table::{facts, percent, table};
use super::Report;

/// Runs whose paths are drawn; more would hide each other.
const DRAWN_RUNS: usize = 6;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim evaluate robots                      all built-in scenes, 100 runs each
  host_sim evaluate robots robots_crossing --runs 500 --out fig
  host_sim evaluate robots my.toml

A scene of several robots has [[robots]] tables beside [robot]; `scenarios robots_crossing --print` shows one.")]
pub struct EvaluateRobotsArgs {
    /// Scenarios of several robots, built in or TOML files; default: all that are built in
    pub scenarios: Vec<String>,
    #[command(flatten)]
    pub learning: LearningArgs,
    /// How many runs of each, with consecutive seeds
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub runs: u32,
    /// Learn a map for each run with the run's seed, instead of one for all with the first
    #[arg(long)]
    pub fresh_maps: bool,
    /// Exit with 1 unless with separation at least so many percent of the runs of each scene succeed
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(0..=100))]
    pub require: Option<u8>,
    /// Threads; default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Draw paths (SVG) into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

/// All runs of a scene, with or without separation.
struct Row {
    scenario: Scenario,
    separated: bool,
    runs: Vec<Vec<MissionResult>>,
    summary: FleetSummary,
}

pub fn robots(args: &EvaluateRobotsArgs) -> Result<Report, CliError> {
    match args.learning.scalar() {
        ScalarArg::F32 => robots_in::<f32>(args),
        ScalarArg::Fixed => robots_in::<Fixed>(args),
    }
}

/// The scenes that were asked for; one robot alone is none.
fn scenes(args: &EvaluateRobotsArgs) -> Result<Vec<Scenario>, CliError> {
    let builtin: Vec<String> = Scenario::fleet_names().map(String::from).collect();
    let names = if args.scenarios.is_empty() { &builtin } else { &args.scenarios };
    let load = |name: &String| {
        let scenario = Scenario::load(name)?;
        if scenario.robot_count() < 2 {
            let message = format!(
                "{name}: robots = []: `evaluate robots` needs several robots; add a [[robots]] table, or use `run`"
            );
            return Err(CliError::Request(message));
        }
        Ok(scenario)
    };
    names.iter().map(load).collect()
}

fn file_name(scenario: &Scenario, separated: bool) -> String {
    format!("{}{}.svg", scenario.name, if separated { "" } else { "_without" })
}

fn robots_in<S: StoredScalar>(args: &EvaluateRobotsArgs) -> Result<Report, CliError> {
    let config = configuration(&args.learning)?;
    let scenes = scenes(args)?;
    let seeds = seeds(args.learning.seed, args.runs)?;
    let pool = threads(args.threads)?;
    let names: Vec<String> =
        scenes.iter().flat_map(|scene| [true, false].map(|separated| file_name(scene, separated))).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let folder = args.out.as_deref().map(|out| OutputFolder::open(out, &names)).transpose()?;
    let plan = training_plan(&args.learning);
    let maps = if args.fresh_maps {
        let learned = pool.install(|| learn_each::<S, Indirect<S>>(&config, &plan, seeds.clone()))?;
        Maps::PerRun(learned.into_iter().map(|learned| learned.map).collect())
    } else {
        Maps::Shared(Box::new(learn::<S, Indirect<S>>(&config, &plan)?.map))
    };
    let sweep = SweepPlan { seeds, logged: if folder.is_some() { DRAWN_RUNS } else { 0 } };
    let mut rows = Vec::new();
    for scenario in &scenes {
        for separated in [true, false] {
            let bar = Progress::new("runs", u64::from(args.runs));
            let company = if separated { Company::Told } else { Company::Silent };
            let runs = pool.install(|| {
                fleet::run_all(scenario, &config, None, &maps, (&sweep, company), &|| bar.advance())
            })?;
            let summary = fleet::summarise(scenario, &runs);
            rows.push(Row { scenario: scenario.clone(), separated, runs, summary });
        }
    }
    let mut files = Vec::new();
    if let Some(folder) = folder {
        for row in &rows {
            files.push(folder.write(&file_name(&row.scenario, row.separated), row.figure().as_bytes())?);
        }
    }
    let documents = rows.iter().map(Row::document).collect::<Vec<_>>();
    let wrote = files.iter().map(|file| format!("wrote {file}\n"));
    let required = f64::from(args.require.unwrap_or(0));
    let enough = |row: &Row| !row.separated || row.summary.success.share() * 100.0 >= required;
    Ok(Report {
        text: core::iter::once(text(args, S::NAME, &rows)).chain(wrote).collect(),
        document: json!({
            "scalar": S::NAME, "seed": args.learning.seed, "scenes": documents, "files": files
        }),
        outcome: if rows.iter().all(enough) { Outcome::Ok } else { Outcome::RobotFailed },
    })
}

impl Row {
    fn hash(&self) -> String {
        hex(combined_hash(self.runs.iter().flatten()))
    }

    /// The paths of the first runs, in a colour for each robot.
    fn figure(&self) -> String {
        let drawn = self.runs.iter().take(DRAWN_RUNS).flat_map(|run| run.iter().enumerate());
        let traces: Vec<_> = drawn
            .map(|(robot, result)| run_log::trace(&format!("robot {}", robot + 1), &result.samples))
            .collect();
        draw_run(&self.scenario, &traces)
    }

    fn document(&self) -> Value {
        let summary = &self.summary;
        json!({
            "scenario": self.scenario.name,
            "separation": self.separated,
            "summary": summary,
            "wilson_95": {
                "success": summary.success.wilson_95(),
                "arrived": summary.arrived.wilson_95(),
                "contact": summary.contact.wilson_95(),
            },
            "runs": self.runs.iter().map(|run| run.iter().map(result_json).collect()).collect::<Vec<Value>>(),
            "hash": self.hash(),
        })
    }
}

fn text(args: &EvaluateRobotsArgs, scalar: &str, rows: &[Row]) -> String {
    let (first, last) = (args.learning.seed, args.learning.seed + u64::from(args.runs) - 1);
    let map = if args.fresh_maps { "one for each run" } else { "one for all runs" };
    let head = facts([
        ("runs", format!("{} each, seeds {first} to {last}, scalar {scalar}", args.runs)),
        ("map", format!("{map}, {} steps", args.learning.steps)),
        ("success", String::from("all robots at their goals, every checkpoint within tolerance, no contact")),
        ("rates", String::from("in %, with Wilson's 95 % intervals; times until the last robot is there")),
    ]);
    let names =
        ["scene", "separation", "success", "all arrive", "contact", "median s", "95 % s", "way", "hash"];
    let mut cells = vec![names.map(String::from).to_vec()];
    for row in rows {
        let summary = &row.summary;
        let number = |value: Option<f64>, decimals: usize| {
            value.map_or_else(|| String::from("-"), |value| format!("{value:.decimals$}"))
        };
        cells.push(vec![
            row.scenario.name.clone(),
            String::from(if row.separated { "with" } else { "without" }),
            rate(summary.success),
            rate(summary.arrived),
            rate(summary.contact),
            number(summary.time_median_s, 1),
            number(summary.time_95_s, 1),
            number(summary.way_median, 2),
            row.hash(),
        ]);
    }
    format!("{head}\n{}", table(&cells))
}

fn rate(rate: Rate) -> String {
    let (low, high) = rate.wilson_95();
    format!("{} [{}, {}]", percent(rate.share()), percent(low), percent(high))
}
