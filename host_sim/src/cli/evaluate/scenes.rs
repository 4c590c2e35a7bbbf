//! `evaluate scenarios`, `traps`, `doors`, `traffic` and `surfaces`: rates of all controllers over many scenes.

mod entrants;
mod surfaces;
mod tables;

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use controller_core::scalar::{Fixed, Scalar};
use host_sim::evaluation::{RunPlan, SceneResult, Subject, run_scenes};
use host_sim::figure::{draw_heat_map, draw_run};
use host_sim::lateness::LATENESS_MAX_MS;
use host_sim::limits::{Limit, limits};
use host_sim::mission::MissionResult;
use host_sim::questions::{self, Question, Surface};
use host_sim::run_log;
use host_sim::scenario::Scenario;
use host_sim::scenes::Disturbance;
use host_sim::simulation::PAPERS;
use rayon::ThreadPool;
use serde_json::{Value, json};

use super::super::args::{ScalarArg, assignment};
use super::super::error::{CliError, Outcome};
use super::super::learning::{seeds, settings_of, threads};
use super::super::link::change;
use super::super::output::OutputFolder;
use super::super::progress::Progress;
use super::super::table::{facts, percent};
use super::Report;
use entrants::{Entrant, equip};
use surfaces::Measured;

/// Paths in a figure; more would hide each other.
const DRAWN_PATHS: u32 = 20;

/// What the evaluations over scenes need to know.
#[derive(Debug, Clone, Args)]
pub struct SceneArgs {
    /// Runs of each scene, with consecutive seeds
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub runs: u32,
    /// Seed of the first run
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Only these controllers; may be given several times. Default: all, of `literal` and `fusion-asymmetric` only in
    /// `scenarios`; the first is the one that surfaces are measured with
    #[arg(long, value_enum)]
    pub controller: Vec<Entrant>,
    /// Only scenes, or of `surfaces` only those, whose name contains this; may be given several times
    #[arg(long, value_name = "TEXT")]
    pub only: Vec<String>,
    /// Maps to drive with in turn, learned with the seeds from --seed on
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub maps: u32,
    /// Training steps of each map
    #[arg(long, value_name = "N", default_value_t = 2000)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub steps: u32,
    /// Arithmetic of our controllers
    #[arg(long, value_enum, default_value_t = ScalarArg::F32)]
    pub scalar: ScalarArg,
    /// Numbers of the controllers, by file or by name: `precise`, `p1`, `literal`, `large`
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub config: Option<PathBuf>,
    /// Another value for a parameter of cooperative EKMs or command fusion (`config --list`); may be given
    /// several times
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    pub set: Vec<(String, f32)>,
    /// Noise of sensors and actuators, as a share
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = share)]
    pub noise: f64,
    /// Share of readings that are missing
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub dropout: f64,
    /// Avoidance and target reaching have their answers late by up to so many ms, each time anew
    #[arg(long, value_name = "MS", default_value_t = 0)]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=i64::from(LATENESS_MAX_MS)))]
    pub task_jitter: u16,
    /// Also what costs minutes: the surfaces over two measures, for the first controller
    #[arg(long)]
    pub surfaces: bool,
    /// Exit with 1 unless the first controller succeeds in at least so many percent of the runs of each line
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(0..=100))]
    pub require: Option<u8>,
    /// Threads; default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Write rates (CSV), paths and surfaces (SVG) into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

fn share(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| (0.0..=1.0).contains(value));
    value.ok_or_else(|| String::from("must be a number between 0 and 1"))
}

impl SceneArgs {
    fn disturbance(&self) -> Disturbance {
        let mut disturbance = Disturbance { noise: PAPERS, jitter: 1.0 };
        disturbance.noise.sensor = self.noise;
        disturbance.noise.actuator = self.noise;
        disturbance.noise.dropout = self.dropout;
        disturbance.noise.task_jitter_ms = self.task_jitter;
        disturbance
    }

    /// Leaves out what none of the texts of `--only` fits; each of them must fit something.
    fn choose<T>(&self, all: &mut Vec<T>, name: impl Fn(&T) -> &str) -> Result<(), CliError> {
        let names: Vec<&str> = all.iter().map(&name).collect();
        if let Some(text) = self.only.iter().find(|text| !names.iter().any(|name| name.contains(*text))) {
            let message = format!("--only {text}: nothing is called so; there are {}", names.join("; "));
            return Err(CliError::Request(message));
        }
        all.retain(|one| self.only.is_empty() || self.only.iter().any(|text| name(one).contains(text)));
        Ok(())
    }

    /// The first of them in full and on surfaces.
    fn entrants(&self, what: What) -> Vec<Entrant> {
        match what {
            _ if !self.controller.is_empty() => self.controller.clone(),
            What::Papers => Entrant::value_variants().to_vec(),
            What::Surfaces => vec![Entrant::Cooperative],
            What::Traps | What::Doors | What::Traffic => Entrant::CONTENDERS.to_vec(),
        }
    }
}

/// Which scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// The seven figures of the papers.
    Papers,
    /// U-shaped traps and walls' ends.
    Traps,
    /// Doors, corridors, rows of posts.
    Doors,
    /// Discs that circle.
    Traffic,
    /// Nothing but the surfaces of all others.
    Surfaces,
}

impl What {
    pub fn name(self) -> &'static str {
        match self {
            Self::Papers => "scenarios",
            Self::Traps => "traps",
            Self::Doors => "doors",
            Self::Traffic => "traffic",
            Self::Surfaces => "surfaces",
        }
    }

    /// The scenes that are asked for; those that none of the texts of `--only` fits are left out.
    fn questions(self, args: &SceneArgs) -> Result<Vec<Question>, CliError> {
        let disturbance = &args.disturbance();
        let mut questions = match self {
            Self::Papers => questions::papers(disturbance)?,
            Self::Traps => questions::traps(disturbance),
            Self::Doors => questions::doors(disturbance),
            Self::Traffic => questions::traffic_surfaces(disturbance)
                .into_iter()
                .flat_map(|surface| surface.cells)
                .collect(),
            Self::Surfaces => return Ok(Vec::new()),
        };
        args.choose(&mut questions, |question| &question.name)?;
        Ok(questions)
    }

    fn surfaces(self, args: &SceneArgs) -> Result<Vec<Surface>, CliError> {
        let disturbance = &args.disturbance();
        if self != Self::Surfaces {
            return Ok(if args.surfaces { self.surfaces_of_kind(disturbance) } else { Vec::new() });
        }
        let kinds = [Self::Traps, Self::Doors, Self::Traffic].into_iter();
        let mut surfaces = kinds.flat_map(|what| what.surfaces_of_kind(disturbance)).collect();
        args.choose(&mut surfaces, |surface| surface.name)?;
        Ok(surfaces)
    }

    fn surfaces_of_kind(self, disturbance: &Disturbance) -> Vec<Surface> {
        match self {
            Self::Papers | Self::Surfaces => Vec::new(),
            Self::Traps => questions::trap_surfaces(disturbance),
            Self::Doors => questions::door_surfaces(disturbance),
            Self::Traffic => questions::traffic_surfaces(disturbance),
        }
    }
}

/// One controller's answers to all questions.
struct Column {
    entrant: Entrant,
    results: Vec<SceneResult>,
    limits: Vec<Limit>,
    /// Of the first scene of each question, the runs that kept a log.
    drawn: Vec<Vec<MissionResult>>,
}

/// All that was measured.
struct Answers {
    questions: Vec<Question>,
    columns: Vec<Column>,
    surfaces: Vec<Measured>,
}

pub fn evaluate(what: What, args: &SceneArgs) -> Result<Report, CliError> {
    match args.scalar {
        ScalarArg::F32 => evaluate_with::<f32>(what, args),
        ScalarArg::Fixed => evaluate_with::<Fixed>(what, args),
    }
}

fn evaluate_with<S: Scalar>(what: What, args: &SceneArgs) -> Result<Report, CliError> {
    let questions = what.questions(args)?;
    let csv = format!("{}.csv", what.name());
    let folder = args.out.as_deref().map(|out| OutputFolder::open(out, &[&csv])).transpose()?;
    seeds(args.seed, args.runs)?;
    let begin = Instant::now();
    let logged = if folder.is_some() { DRAWN_PATHS } else { 0 };
    let answers = answers::<S>(what, args, questions, logged)?;
    let took_s = begin.elapsed().as_secs_f64();
    let files = folder.map_or_else(|| Ok(Vec::new()), |folder| write(what, args, &answers, &folder))?;
    let required = f64::from(args.require.unwrap_or(0)) / 100.0;
    let mut first = answers.columns.first().into_iter().flat_map(|column| &column.results);
    let enough = first.all(|result| result.success.share() >= required);
    Ok(Report {
        text: text(what, args, S::NAME, &answers, took_s, &files),
        document: document(what, args, &answers, &files),
        outcome: if enough { Outcome::Ok } else { Outcome::RobotFailed },
    })
}

fn answers<S: Scalar>(
    what: What,
    args: &SceneArgs,
    questions: Vec<Question>,
    logged: u32,
) -> Result<Answers, CliError> {
    let mut settings = settings_of(args.config.as_deref())?;
    for change in args.set.iter().map(change) {
        let (index, value) = change?;
        settings.core.set(usize::from(index), value).map_err(|error| CliError::Request(error.to_string()))?;
    }
    settings.core.validate().map_err(|error| CliError::Request(error.to_string()))?;
    let pool = threads(args.threads)?;
    let entrants = args.entrants(what);
    let equipment = pool.install(|| equip::<S>(&entrants, &settings, args))?;
    let plan = RunPlan { seed: args.seed, runs: args.runs, logged };
    let mut columns = Vec::new();
    for (&entrant, equipment) in entrants.iter().zip(&equipment) {
        let (results, drawn) = ask(&questions, entrant.name(), &equipment.subject(entrant), plan, &pool)?;
        columns.push(Column { entrant, limits: limits(&questions, &results), results, drawn });
    }
    let mut surfaces = Vec::new();
    for surface in what.surfaces(args)? {
        let Some((&entrant, equipment)) = entrants.iter().zip(&equipment).next() else { continue };
        let (plan, controller) = (RunPlan { logged: 0, ..plan }, entrant.name());
        let (results, _) = ask(&surface.cells, surface.name, &equipment.subject(entrant), plan, &pool)?;
        surfaces.push(Measured { surface, controller, results });
    }
    Ok(Answers { questions, columns, surfaces })
}

/// Runs all scenes of all questions; per question, the rates and the first scene's runs with a log.
fn ask<S: Scalar>(
    questions: &[Question],
    name: &'static str,
    subject: &Subject<'_, S>,
    plan: RunPlan,
    pool: &ThreadPool,
) -> Result<(Vec<SceneResult>, Vec<Vec<MissionResult>>), CliError> {
    let scenes = questions.iter().flat_map(|question| &question.scenarios);
    let bar = Progress::new(name, scenes.map(|_| u64::from(plan.runs)).sum::<u64>().max(1));
    let (mut results, mut drawn) = (Vec::new(), Vec::new());
    for question in questions {
        let progress = || bar.advance();
        let mut runs = pool.install(|| run_scenes(&question.scenarios, subject, plan, &progress))?;
        results.push(SceneResult::of(runs.iter().flatten()));
        let mut first = if runs.is_empty() { Vec::new() } else { runs.swap_remove(0) };
        first.retain(|run| !run.samples.is_empty());
        drawn.push(first);
    }
    Ok((results, drawn))
}

/// Writes rates, limits, paths and surfaces.
fn write(
    what: What,
    args: &SceneArgs,
    answers: &Answers,
    folder: &OutputFolder,
) -> Result<Vec<String>, CliError> {
    let Answers { questions, columns, surfaces } = answers;
    let mut files = Vec::new();
    let mut add = |name: String, content: String| -> Result<(), CliError> {
        files.push(folder.write(&name, content.as_bytes())?);
        Ok(())
    };
    if !questions.is_empty() {
        add(format!("{}.csv", what.name()), tables::rates_csv(questions, columns))?;
    }
    if columns.iter().any(|column| !column.limits.is_empty()) {
        add(format!("{}_limits.csv", what.name()), tables::limits_csv(columns))?;
    }
    for (name, figure) in figures(questions, columns) {
        add(name, figure)?;
    }
    for measured in surfaces {
        let name = measured.surface.name;
        add(format!("{name}.csv"), measured.csv())?;
        add(format!("{name}.svg"), draw_heat_map(&measured.heat_map(args)))?;
    }
    Ok(files)
}

fn text(
    what: What,
    args: &SceneArgs,
    scalar: &str,
    answers: &Answers,
    took_s: f64,
    files: &[String],
) -> String {
    let Answers { questions, columns, surfaces } = answers;
    let late = if args.task_jitter > 0 {
        format!(", tasks up to {} ms late", args.task_jitter)
    } else {
        String::new()
    };
    let (noise, dropout) = (percent(args.noise), percent(args.dropout));
    let mut text = facts([
        ("runs", format!("{} of each scene, seeds {} and up", args.runs, args.seed)),
        ("noise", format!("{noise} % of ranges and speeds, {dropout} % dropout{late}")),
        ("maps", format!("{} in turn, {} steps each, scalar {scalar}", args.maps, args.steps)),
        ("took", format!("{took_s:.0} s")),
    ]);
    text.push('\n');
    if !questions.is_empty() {
        text += &tables::rates(what, questions, columns);
        text.push('\n');
    }
    text += &tables::limits(columns);
    text.extend(surfaces.iter().map(Measured::text));
    text += tables::WHAT_IT_MEANS;
    if what == What::Papers {
        text += tables::WHAT_IT_ADDS;
    }
    if !files.is_empty() {
        text += &format!("wrote {}\n", files.join(", "));
    }
    text
}

/// The paths of each question's first scene, all controllers over each other.
fn figures(questions: &[Question], columns: &[Column]) -> Vec<(String, String)> {
    let mut figures = Vec::new();
    for (index, question) in questions.iter().enumerate() {
        let Some(scenario) = question.scenarios.first() else { continue };
        let mut traces = Vec::new();
        for column in columns {
            let runs = column.drawn.get(index).into_iter().flatten();
            traces.extend(runs.map(|run| run_log::trace(column.entrant.name(), &run.samples)));
        }
        figures.push((
            format!("{}_paths.svg", scenario.name),
            draw_run(&drawable(scenario, columns, index), &traces),
        ));
    }
    figures
}

/// The scenario with the checkpoints that its first run had, where they were planned.
fn drawable(scenario: &Scenario, columns: &[Column], index: usize) -> Scenario {
    let first = columns.iter().find_map(|column| column.drawn.get(index)?.first());
    let Some(run) = first else { return scenario.clone() };
    let checkpoints = run.checkpoints.iter().map(|&(x, y)| nalgebra::Point2::new(x, y)).collect();
    scenario.clone().with_checkpoints(checkpoints)
}

fn result_json(name: &str, result: &SceneResult) -> Value {
    json!({ "name": name, "result": result, "success_wilson_95": result.success.wilson_95() })
}

fn document(what: What, args: &SceneArgs, answers: &Answers, files: &[String]) -> Value {
    let column = |column: &Column| {
        let answers = answers.questions.iter().zip(&column.results);
        json!({
            "controller": column.entrant.name(),
            "scenes": answers.map(|(question, result)| result_json(&question.name, result)).collect::<Vec<_>>(),
            "limits": column.limits,
        })
    };
    json!({
        "evaluation": what.name(),
        "seed": args.seed,
        "runs": args.runs,
        "noise": args.noise,
        "dropout": args.dropout,
        "task_jitter_ms": args.task_jitter,
        "scalar": args.scalar.to_possible_value().map(|value| value.get_name().to_owned()),
        "controllers": answers.columns.iter().map(column).collect::<Vec<_>>(),
        "surfaces": answers.surfaces.iter().map(Measured::document).collect::<Vec<_>>(),
        "files": files,
    })
}
