//! All runs over all courses, in parallel, in an order that does not depend on the threads.

use host_sim::benchmark::{self, Course, CourseRun, Following, RunOptions};
use host_sim::map_store::StoredScalar;
use host_sim::mission;
use host_sim::peers;
use host_sim::peers::port::PeerPort;
use host_sim::peers::robot::PeerRobot;
use host_sim::sil::{Indirect, Sil};
use host_sim::sweep::{LOG_PERIOD_MS, Maps};
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

use super::args::WorldRunsArgs;
use crate::cli::error::CliError;
use crate::cli::learning::{learn, learn_each, load_map_file, seeds, settings, threads, training_plan};
use crate::cli::progress::Progress;

/// Paths of each kind in a figure.
const DRAWN_PATHS: u32 = 10;

/// With or without the planner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    pub following: Option<Following>,
}

impl Kind {
    pub fn name(self) -> &'static str {
        if self.following.is_some() { "planned" } else { "decapitated" }
    }
}

/// What was asked for.
pub fn kinds(args: &WorldRunsArgs) -> Vec<Kind> {
    let planned = Kind { following: Some(args.following.following()) };
    let decapitated = Kind { following: None };
    match (args.planned, args.decapitated) {
        (true, _) => vec![planned],
        (false, true) => vec![decapitated],
        (false, false) => vec![planned, decapitated],
    }
}

/// A run and what it was.
pub struct Driven {
    /// Place in the list of courses.
    pub course: usize,
    pub kind: Kind,
    pub run: CourseRun,
}

/// Learns or loads the map, and drives each course in each way with each seed.
pub fn drive<S: StoredScalar>(args: &WorldRunsArgs, courses: &[Course]) -> Result<Vec<Driven>, CliError> {
    let settings = settings(&args.learning)?;
    let mut config = settings.core.clone();
    let seeds = seeds(args.learning.seed, args.runs)?;
    let threads = threads(args.threads)?;
    let plan = training_plan(&args.learning);
    let stored = load_map_file::<S>(args.map.as_deref(), args.map_of_another_robot, &config)?;
    let maps = if let Some(stored) = stored {
        Maps::Shared(Box::new(stored.map))
    } else if args.fresh_maps {
        let learned = threads.install(|| learn_each::<S, Indirect<S>>(&config, &plan, seeds.clone()))?;
        Maps::PerRun(learned.into_iter().map(|learned| learned.map).collect())
    } else {
        Maps::Shared(Box::new(learn::<S, Indirect<S>>(&config, &plan)?.map))
    };
    if let Some(course) = courses.first() {
        config = mission::config_for(&course.scenario, &config, Some(args.controller));
    }
    let tasks = tasks(courses.len(), &kinds(args), args.runs);
    let bar = Progress::new("driving", u64::try_from(tasks.len()).unwrap_or(u64::MAX));
    let one = |&(course, kind, number): &(usize, Kind, u32)| {
        let logged = args.out.is_some() && number < DRAWN_PATHS;
        let options = RunOptions {
            seed: seeds.start + u64::from(number),
            following: kind.following,
            sample_ms: if logged { LOG_PERIOD_MS } else { 0 },
        };
        let config = benchmark::config_for(&courses[course], kind.following, &config);
        let index = usize::try_from(number).unwrap_or(0);
        let navigator = peers::navigator(args.controller, PeerRobot::new(&config), &settings.peers);
        let run = if let Some(navigator) = navigator {
            let controller = PeerPort::new(navigator, &config, &settings.peers)?;
            benchmark::run(&courses[course], controller, &config, options)
        } else {
            let map = maps.of_run(index).cloned().unwrap_or_default();
            benchmark::run(&courses[course], Sil::trained(&config, map, 0)?, &config, options)
        };
        bar.advance();
        Ok(Driven { course, kind, run: run? })
    };
    let driven: Vec<Result<Driven, CliError>> = threads.install(|| tasks.par_iter().map(one).collect());
    driven.into_iter().collect()
}

fn tasks(courses: usize, kinds: &[Kind], runs: u32) -> Vec<(usize, Kind, u32)> {
    let of_course =
        |course| kinds.iter().flat_map(move |&kind| (0..runs).map(move |run| (course, kind, run)));
    (0..courses).flat_map(of_course).collect()
}
