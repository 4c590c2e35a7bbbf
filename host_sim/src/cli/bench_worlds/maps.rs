//! `bench movingai` and `bench map`: grid maps.

use controller_core::scalar::Fixed;
use host_sim::benchmark::{Course, Ground};
use host_sim::import::{GridMap, ImportError, map_server, moving_ai};
use host_sim::map_store::StoredScalar;
use nalgebra::Point2;

use super::args::{MovingAiArgs, RosMapArgs, WorldRunsArgs};
use super::drive::drive;
use super::plans::{Planned, Plans, plan};
use super::report::Report;
use crate::cli::args::ScalarArg;
use crate::cli::error::{CliError, Outcome};
use crate::cli::learning::seeds;
use crate::cli::output::OutputFolder;

pub fn moving_ai(args: &MovingAiArgs) -> Result<Outcome, CliError> {
    positive("--cell", args.cell)?;
    let map = moving_ai::load_map(&args.grid, args.cell)?;
    let problems = moving_ai::load_problems(&args.problems_file, &map)?;
    let ground = ground(map)?;
    let place = |(column, row): (usize, usize)| ground.map.middle(column, ground.map.rows - 1 - row);
    let plans: Vec<Planned> = problems
        .iter()
        .map(|problem| {
            let reference_m = problem.optimal_cells * args.cell;
            plan(&ground, place(problem.start), place(problem.goal), Some(reference_m))
        })
        .collect();
    let chosen = evenly(&plans, args.problems);
    run("movingai", &args.runs, args.goal.goal_tolerance, &ground, &plans, &chosen)
}

pub fn ros_map(args: &RosMapArgs) -> Result<Outcome, CliError> {
    positive("--scale", args.scale)?;
    let ground = ground(map_server::load(&args.grid, args.scale)?)?;
    let frame = ground.map.frame;
    let plans: Vec<Planned> = if let (Some(from), Some(to)) = (args.from, args.to) {
        let place = |(x, y)| frame.to_grid(Point2::new(x, y));
        vec![plan(&ground, place(from), place(to), None)]
    } else {
        let draw = |seed| {
            let none = || {
                CliError::Request(format!(
                    "{}: no two free places are joined; check --scale",
                    ground.map.name
                ))
            };
            ground.draw(seed).map(|(from, goal)| plan(&ground, from, goal, None)).ok_or_else(none)
        };
        seeds(args.runs.learning.seed, args.pairs)?.map(draw).collect::<Result<_, _>>()?
    };
    let chosen: Vec<&Planned> = plans.iter().collect();
    run("map", &args.runs, args.goal.goal_tolerance, &ground, &plans, &chosen)
}

fn ground(map: GridMap) -> Result<Ground, CliError> {
    let name = map.name.clone();
    Ground::new(map).map_err(|error| CliError::Request(format!("{name}: {error}")))
}

fn positive(option: &str, value: f64) -> Result<(), CliError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    let (problem, fix) = (format!("{value} is no length or factor"), String::from("give a number above 0"));
    Err(ImportError { file: String::from("arguments"), place: option.to_owned(), problem, fix }.into())
}

/// So many of the plans, evenly over the list.
fn evenly(plans: &[Planned], wanted: u32) -> Vec<&Planned> {
    let wanted = usize::try_from(wanted).unwrap_or(usize::MAX).min(plans.len());
    (0..wanted).filter_map(|i| plans.get(i * plans.len() / wanted)).collect()
}

fn run(
    what: &'static str,
    args: &WorldRunsArgs,
    goal_tolerance_m: f64,
    ground: &Ground,
    plans: &[Planned],
    driven: &[&Planned],
) -> Result<Outcome, CliError> {
    positive("--goal-tolerance", goal_tolerance_m)?;
    let courses: Vec<Course> = driven
        .iter()
        .zip(1..)
        .map(|(planned, number)| {
            let name = format!("{}_{number}", ground.map.name);
            ground.course(&name, planned.from, planned.goal, goal_tolerance_m)
        })
        .collect();
    let plans = Plans { ground, plans };
    match args.learning.scalar() {
        ScalarArg::F32 => run_in::<f32>(what, args, &courses, &plans),
        ScalarArg::Fixed => run_in::<Fixed>(what, args, &courses, &plans),
    }
}

fn run_in<S: StoredScalar>(
    what: &'static str,
    args: &WorldRunsArgs,
    courses: &[Course],
    plans: &Plans,
) -> Result<Outcome, CliError> {
    let folder = args.out.as_deref().map(|path| OutputFolder::open(path, &[])).transpose()?;
    let driven = if courses.is_empty() { Vec::new() } else { drive::<S>(args, courses)? };
    Report { what, args, scalar: S::NAME, courses, driven: &driven, plans: Some(plans) }.put(folder)
}
