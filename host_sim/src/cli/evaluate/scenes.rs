//! `evaluate scenarios`, `traps`, `doors` and `traffic`: rates of all controllers over many scenes.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use controller_core::scalar::{Fixed, Scalar};
use host_sim::config_file;
use host_sim::contender::Contender;
use host_sim::evaluation::{RunPlan, SceneResult, Subject, run_scenes};
use host_sim::figure::{HeatMap, draw_heat_map, draw_run};
use host_sim::mission::MissionResult;
use host_sim::questions::{self, Question, Surface};
use host_sim::route_planner;
use host_sim::run_log;
use host_sim::scenario::Scenario;
use host_sim::scenes::Disturbance;
use host_sim::settings::Settings;
use host_sim::sil::Indirect;
use host_sim::simulation::PAPERS;
use host_sim::statistics::Rate;
use host_sim::sweep::Maps;
use host_sim::training::TrainingPlan;
use rayon::ThreadPool;
use serde_json::{Value, json};

use super::super::args::ScalarArg;
use super::super::error::{CliError, Outcome};
use super::super::learning::{learn_each, seeds, threads};
use super::super::output::{OutputFolder, print, print_json};
use super::super::progress::Progress;
use super::super::table::{facts, percent, table};

/// Paths in a figure; more would hide each other.
const DRAWN_PATHS: u32 = 20;
/// A trap or a door counts as passed from this share of the runs on.
const PASSED: f64 = 0.99;

/// What the evaluations over scenes need to know.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// Runs of each scene, with consecutive seeds
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub runs: u32,
    /// Seed of the first run
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Only these controllers; default: all
    #[arg(long, value_enum)]
    pub controller: Vec<Contender>,
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
    /// Noise of sensors and actuators, as a share
    #[arg(long, value_name = "SHARE", default_value_t = 0.1, value_parser = share)]
    pub noise: f64,
    /// Share of readings that are missing
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub dropout: f64,
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
}

impl What {
    fn name(self) -> &'static str {
        match self {
            Self::Papers => "scenarios",
            Self::Traps => "traps",
            Self::Doors => "doors",
            Self::Traffic => "traffic",
        }
    }

    fn questions(self, disturbance: &Disturbance) -> Result<Vec<Question>, CliError> {
        Ok(match self {
            Self::Papers => questions::papers(disturbance)?,
            Self::Traps => questions::traps(disturbance),
            Self::Doors => questions::doors(disturbance),
            Self::Traffic => questions::traffic_surfaces(disturbance)
                .into_iter()
                .flat_map(|surface| surface.cells)
                .collect(),
        })
    }

    fn surfaces(self, disturbance: &Disturbance) -> Vec<Surface> {
        match self {
            Self::Papers => Vec::new(),
            Self::Traps => questions::trap_surfaces(disturbance),
            Self::Doors => questions::door_surfaces(disturbance),
            Self::Traffic => questions::traffic_surfaces(disturbance),
        }
    }
}

/// One controller's answers to all questions.
struct Column {
    contender: Contender,
    results: Vec<SceneResult>,
    /// Of the first scene of each question, the runs that kept a log.
    drawn: Vec<Vec<MissionResult>>,
}

/// A surface that was measured.
struct Measured {
    surface: Surface,
    results: Vec<SceneResult>,
}

pub fn evaluate(what: What, args: &SceneArgs) -> Result<Outcome, CliError> {
    match args.scalar {
        ScalarArg::F32 => evaluate_with::<f32>(what, args),
        ScalarArg::Fixed => evaluate_with::<Fixed>(what, args),
    }
}

fn evaluate_with<S: Scalar>(what: What, args: &SceneArgs) -> Result<Outcome, CliError> {
    let settings = args.config.as_deref().map_or_else(|| Ok(Settings::default()), config_file::load)?;
    let mut disturbance = Disturbance { noise: PAPERS, jitter: 1.0 };
    disturbance.noise.sensor = args.noise;
    disturbance.noise.actuator = args.noise;
    disturbance.noise.dropout = args.dropout;
    let questions = what.questions(&disturbance)?;
    let csv = format!("{}.csv", what.name());
    let folder = args.out.as_deref().map(|out| OutputFolder::open(out, &[&csv])).transpose()?;
    seeds(args.seed, args.runs)?;
    let pool = threads(args.threads)?;
    let begin = Instant::now();
    let training = TrainingPlan { steps: args.steps, ..TrainingPlan::default() };
    let map_seeds = seeds(args.seed, args.maps)?;
    let learned = pool.install(|| learn_each::<S, Indirect<S>>(&settings.core, &training, map_seeds))?;
    let maps = Maps::PerRun(learned.into_iter().map(|learned| learned.map).collect());
    let contenders =
        if args.controller.is_empty() { Contender::ALL.to_vec() } else { args.controller.clone() };
    let logged = if folder.is_some() { DRAWN_PATHS } else { 0 };
    let plan = RunPlan { seed: args.seed, runs: args.runs, logged };
    let mut columns = Vec::new();
    for &contender in &contenders {
        let subject = Subject { settings: &settings, contender, maps: &maps };
        let (results, drawn) = ask(&questions, &subject, plan, &pool)?;
        columns.push(Column { contender, results, drawn });
    }
    let mut surfaces = Vec::new();
    if let Some(&contender) = contenders.first().filter(|_| args.surfaces) {
        let subject = Subject { settings: &settings, contender, maps: &maps };
        for surface in what.surfaces(&disturbance) {
            let (results, _) = ask(&surface.cells, &subject, RunPlan { logged: 0, ..plan }, &pool)?;
            surfaces.push(Measured { surface, results });
        }
    }
    let mut files = Vec::new();
    if let Some(folder) = folder {
        files.push(folder.write(&csv, rates_csv(&questions, &columns).as_bytes())?);
        for (name, figure) in figures(&questions, &columns) {
            files.push(folder.write(&name, figure.as_bytes())?);
        }
        for measured in &surfaces {
            let name = measured.surface.name;
            files.push(folder.write(&format!("{name}.csv"), measured.csv().as_bytes())?);
            let figure = draw_heat_map(&measured.heat_map(args, contenders[0]));
            files.push(folder.write(&format!("{name}.svg"), figure.as_bytes())?);
        }
    }
    if args.json {
        print_json(&document(what, args, &questions, &columns, &surfaces, &files))?;
    } else {
        let took = format!("{:.0} s", begin.elapsed().as_secs_f64());
        let head = facts([
            ("runs", format!("{} of each scene, seeds {} and up", args.runs, args.seed)),
            (
                "noise",
                format!(
                    "{} % of ranges and speeds, {} % dropout",
                    percent(args.noise),
                    percent(args.dropout)
                ),
            ),
            ("maps", format!("{} in turn, {} steps each, scalar {}", args.maps, args.steps, S::NAME)),
            ("took", took),
        ]);
        let wrote = if files.is_empty() { String::new() } else { format!("wrote {}\n", files.join(", ")) };
        let lines: String = surfaces.iter().map(Measured::limits).collect();
        print(&format!("{head}\n{}\n{lines}{}{wrote}", rates_table(&questions, &columns), what_it_means()))?;
    }
    let required = f64::from(args.require.unwrap_or(0)) / 100.0;
    let first = columns.first().into_iter().flat_map(|column| &column.results);
    Ok(if first.into_iter().all(|result| result.success.share() >= required) {
        Outcome::Ok
    } else {
        Outcome::RobotFailed
    })
}

/// Runs all scenes of all questions; per question, the rates and the first scene's runs with a log.
fn ask<S: Scalar>(
    questions: &[Question],
    subject: &Subject<'_, S>,
    plan: RunPlan,
    pool: &ThreadPool,
) -> Result<(Vec<SceneResult>, Vec<Vec<MissionResult>>), CliError> {
    let scenes = questions.iter().map(|question| question.scenarios.len());
    let bar = Progress::new(
        subject.contender.name(),
        scenes.clone().map(|_| u64::from(plan.runs)).sum::<u64>().max(1),
    );
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

fn rate(rate: Rate) -> String {
    let (low, high) = rate.wilson_95();
    format!("{} [{}, {}]", percent(rate.share()), percent(low), percent(high))
}

/// The first controller in full; of the others success and contact.
fn rates_table(questions: &[Question], columns: &[Column]) -> String {
    let mut rows = vec![vec![String::from("scene")]];
    for (number, column) in columns.iter().enumerate() {
        rows[0].push(format!("{}: success", column.contender.name()));
        rows[0].push(String::from("contact"));
        if number == 0 {
            rows[0].extend(["late", "median s"].map(String::from));
        }
    }
    for (index, question) in questions.iter().enumerate() {
        let mut row = vec![question.name.clone()];
        for (number, column) in columns.iter().enumerate() {
            let Some(result) = column.results.get(index) else { continue };
            row.push(if number == 0 { rate(result.success) } else { percent(result.success.share()) });
            row.push(percent(result.contact.share()));
            if number == 0 {
                row.push(percent(result.late.share()));
                row.push(result.time_median_s.map_or_else(|| String::from("-"), |time| format!("{time:.1}")));
            }
        }
        rows.push(row);
    }
    table(&rows)
}

fn what_it_means() -> &'static str {
    "success: the goal within 5 mm, in time, without contact; in %, [Wilson's 95 % interval]\n"
}

/// One line for each scene and controller.
fn rates_csv(questions: &[Question], columns: &[Column]) -> String {
    let mut text = String::from(
        "scene,controller,runs,success,success_low,success_high,contact,late,time_median_s,way_median_m,\
         way_over_shortest,turn_median_rad_per_m\n",
    );
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.4}"));
    for (index, question) in questions.iter().enumerate() {
        let shortest = shortest(question);
        for column in columns {
            let Some(result) = column.results.get(index) else { continue };
            let (low, high) = result.success.wilson_95();
            let over = result.way_median_m.zip(shortest).map(|(way, shortest)| way / shortest);
            text += &format!(
                "\"{}\",{},{},{:.4},{low:.4},{high:.4},{:.4},{:.4},{},{},{},{}\n",
                question.name,
                column.contender.name(),
                result.success.runs,
                result.success.share(),
                result.contact.share(),
                result.late.share(),
                number(result.time_median_s),
                number(result.way_median_m),
                number(over),
                number(result.turn_median_rad_per_m),
            );
        }
    }
    text
}

/// The shortest way that the body fits along, where all is known; only of a question with one scene.
fn shortest(question: &Question) -> Option<f64> {
    let [scenario] = question.scenarios.as_slice() else { return None };
    route_planner::shortest_m(scenario)
}

/// The paths of each question's first scene, all controllers over each other.
fn figures(questions: &[Question], columns: &[Column]) -> Vec<(String, String)> {
    let mut figures = Vec::new();
    for (index, question) in questions.iter().enumerate() {
        let Some(scenario) = question.scenarios.first() else { continue };
        let mut traces = Vec::new();
        for column in columns {
            let runs = column.drawn.get(index).into_iter().flatten();
            traces.extend(runs.map(|run| run_log::trace(column.contender.name(), &run.samples)));
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

impl Measured {
    fn rows(&self) -> impl Iterator<Item = (&String, &[SceneResult])> {
        let width = self.surface.column_names.len().max(1);
        self.surface.row_names.iter().zip(self.results.chunks(width))
    }

    fn csv(&self) -> String {
        let mut text =
            format!("\"{}\",\"{}\",runs,success,contact,late\n", self.surface.rows, self.surface.columns);
        for (row, results) in self.rows() {
            for (column, result) in self.surface.column_names.iter().zip(results) {
                text += &format!(
                    "{row},{column},{},{:.4},{:.4},{:.4}\n",
                    result.success.runs,
                    result.success.share(),
                    result.contact.share(),
                    result.late.share()
                );
            }
        }
        text
    }

    fn heat_map(&self, args: &SceneArgs, contender: Contender) -> HeatMap {
        let cell = |result: &SceneResult| {
            let hint = format!(
                "{} of {}, contact {} %, late {} %",
                result.success.count,
                result.success.runs,
                percent(result.contact.share()),
                percent(result.late.share())
            );
            Some((result.success.share(), hint))
        };
        HeatMap {
            title: self.surface.title.to_owned(),
            under: format!(
                "success in % with {}; {} runs of each scene, seeds {} and up, {} % noise",
                contender.name(),
                args.runs,
                args.seed,
                percent(args.noise)
            ),
            columns: self.surface.columns.to_owned(),
            rows: self.surface.rows.to_owned(),
            column_names: self.surface.column_names.clone(),
            row_names: self.surface.row_names.clone(),
            shares: self.rows().map(|(_, results)| results.iter().map(cell).collect()).collect(),
        }
    }

    /// Where it ends: of each row, the columns that are passed.
    fn limits(&self) -> String {
        let mut text = format!("{}: at least {} % in\n", self.surface.title, percent(PASSED));
        for (row, results) in self.rows() {
            let passed: Vec<&str> = self
                .surface
                .column_names
                .iter()
                .zip(results)
                .filter(|(_, result)| result.success.share() >= PASSED)
                .map(|(name, _)| name.as_str())
                .collect();
            let passed = if passed.is_empty() { String::from("none") } else { passed.join(", ") };
            text += &format!("  {} {row}: {} {passed}\n", self.surface.rows, self.surface.columns);
        }
        text
    }
}

fn result_json(name: &str, result: &SceneResult) -> Value {
    json!({ "name": name, "result": result, "success_wilson_95": result.success.wilson_95() })
}

fn document(
    what: What,
    args: &SceneArgs,
    questions: &[Question],
    columns: &[Column],
    surfaces: &[Measured],
    files: &[String],
) -> Value {
    let column = |column: &Column| {
        let answers = questions.iter().zip(&column.results);
        json!({
            "controller": column.contender,
            "scenes": answers.map(|(question, result)| result_json(&question.name, result)).collect::<Vec<_>>(),
        })
    };
    let surface = |measured: &Measured| {
        let cells = measured.surface.cells.iter().zip(&measured.results);
        json!({
            "name": measured.surface.name,
            "rows": { "what": measured.surface.rows, "names": measured.surface.row_names },
            "columns": { "what": measured.surface.columns, "names": measured.surface.column_names },
            "cells": cells.map(|(cell, result)| result_json(&cell.name, result)).collect::<Vec<_>>(),
        })
    };
    json!({
        "evaluation": what.name(),
        "seed": args.seed,
        "runs": args.runs,
        "noise": args.noise,
        "dropout": args.dropout,
        "scalar": args.scalar.to_possible_value().map(|value| value.get_name().to_owned()),
        "controllers": columns.iter().map(column).collect::<Vec<_>>(),
        "surfaces": surfaces.iter().map(surface).collect::<Vec<_>>(),
        "files": files,
    })
}
