//! How long does a plan take on maps of 512 × 512 cells, and into how few cells do they fall?
//!
//! ```text
//! cargo bench -p tests --bench planner
//! cargo bench -p tests --bench planner -- room-32-32-4.map
//! ```
//!
//! Drawn maps of several kinds with cells of 10 cm, start and goal at random. *One plan* is the core's planner for one
//! disc; *route* is what the benchmarks on worlds take: the shorter of two plans, with the most room that has any. A
//! measurement, not a test: times depend on the machine. The least of several repetitions counts, since what else runs
//! only adds to it.
//!
//! Given Moving AI maps, it says into how many cells they fall and how many they need at least.

use std::path::Path;
use std::time::Instant;

use controller_core::planning::Footprint;
use host_sim::benchmark::{Ground, MARGINS_M};
use host_sim::import::moving_ai;
use host_sim::number::narrow;
use host_sim::route_planner::plan_long;
use host_sim::world::KHEPERA_RADIUS_M;
use tests::maps::{CELL_M, Kind, draw};
use tests::visibility::cells_needed;

const SIDE: usize = 512;
const SEEDS: u64 = 3;
const PAIRS: u64 = 3;

/// How often a plan is repeated.
const REPETITIONS: u32 = 3;

/// The least time of several repetitions in ms.
fn time_ms<T>(work: impl Fn() -> T) -> (T, f64) {
    let once = || {
        let before = Instant::now();
        let result = work();
        (result, before.elapsed().as_secs_f64() * 1e3)
    };
    let (mut result, mut least_ms) = once();
    for _ in 1..REPETITIONS {
        let (again, ms) = once();
        (result, least_ms) = (again, least_ms.min(ms));
    }
    (result, least_ms)
}

/// The most of several figures.
#[derive(Default)]
struct Most {
    plan_ms: f64,
    route_ms: f64,
    cells: usize,
    share: f64,
    plans: u32,
    problem: String,
}

fn measure(kind: Kind) -> Most {
    let robot = robot();
    let mut most = Most::default();
    for seed in 0..SEEDS {
        let ground = Ground::new(draw(kind, SIDE, seed)).expect("the map fits");
        for (from, goal) in (0..PAIRS).filter_map(|pair| ground.draw(100 * seed + pair)) {
            let (plan, plan_ms) = time_ms(|| plan_long(&ground.planner.raster, &robot, from, goal));
            let (route, route_ms) = time_ms(|| ground.route(from, goal));
            match (plan, route) {
                (Ok(plan), Ok(_)) => {
                    most.plan_ms = most.plan_ms.max(plan_ms);
                    most.route_ms = most.route_ms.max(route_ms);
                    most.cells = most.cells.max(plan.cells);
                    most.share = most.share.max(ground.planner.cell_share(&plan));
                    most.plans += 1;
                }
                (Err(error), _) | (_, Err(error)) => most.problem = error.to_string(),
            }
        }
    }
    most
}

fn robot() -> Footprint {
    Footprint::new(narrow(KHEPERA_RADIUS_M), MARGINS_M[0]).expect("the robot is valid")
}

/// Cells of a map beside the least number of cells whose places all see each other.
fn compare(path: &str) {
    let ground = moving_ai::load_map(Path::new(path), CELL_M).map(Ground::new);
    let ground = ground.expect("a Moving AI map").expect("the map fits");
    let plan = ground.draw(0).map(|(from, goal)| plan_long(&ground.planner.raster, &robot(), from, goal));
    let cells = plan.expect("the map has two places").expect("they are joined").cells;
    let free = ground.planner.free_cells();
    println!(
        "{path}: {cells} cells of {free} free, needed at least {}",
        cells_needed(&ground.planner.raster, &robot())
    );
}

fn main() {
    let maps: Vec<String> = std::env::args().skip(1).filter(|argument| argument.ends_with(".map")).collect();
    if !maps.is_empty() {
        maps.iter().for_each(|path| compare(path));
        return;
    }
    println!("most of {SEEDS} maps of {SIDE} x {SIDE} cells with {PAIRS} pairs of places each");
    println!(
        "{:28} {:>6} {:>12} {:>9} {:>7} {:>7}",
        "map", "plans", "one plan ms", "route ms", "cells", "of free"
    );
    for kind in Kind::ALL {
        let most = measure(kind);
        println!(
            "{:28} {:>6} {:>12.1} {:>9.1} {:>7} {:>5.1} % {}",
            kind.name(),
            most.plans,
            most.plan_ms,
            most.route_ms,
            most.cells,
            100.0 * most.share,
            most.problem
        );
    }
}
