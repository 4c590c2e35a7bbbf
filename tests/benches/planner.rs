//! How long does a plan take on maps of 512 × 512 cells, and into how few cells do they fall?
//!
//! ```text
//! cargo bench -p tests --bench planner
//! ```
//!
//! Drawn maps of several kinds with cells of 10 cm, start and goal at random. *One plan* is the core's planner for one
//! disc; *route* is what the benchmarks on worlds take: the shorter of several plans, with the most room that has any.
//! A measurement, not a test: times depend on the machine. They are of this thread on its processor where the system
//! tells that, so that what else runs counts little.

use std::time::Instant;

use controller_core::planning::Footprint;
use host_sim::benchmark::{Ground, MARGINS_M};
use host_sim::number::narrow;
use host_sim::route_planner::plan_long;
use host_sim::world::KHEPERA_RADIUS_M;
use tests::maps::{Kind, draw};

const SIDE: usize = 512;
const SEEDS: u64 = 3;
const PAIRS: u64 = 3;

/// Time of this thread on a processor in ms; where the system does not tell, time on the wall.
struct Clock(Instant);

impl Clock {
    fn now_ms(&self) -> f64 {
        let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
        let nanoseconds = told.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
        nanoseconds.map_or_else(|| self.0.elapsed().as_secs_f64() * 1e3, |nanoseconds| nanoseconds * 1e-6)
    }

    fn time_ms<T>(&self, work: impl FnOnce() -> T) -> (T, f64) {
        let before = self.now_ms();
        let result = work();
        (result, self.now_ms() - before)
    }
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

fn measure(kind: Kind, clock: &Clock) -> Most {
    let robot = Footprint::new(narrow(KHEPERA_RADIUS_M), MARGINS_M[0]).expect("the robot is valid");
    let mut most = Most::default();
    for seed in 0..SEEDS {
        let ground = Ground::new(draw(kind, SIDE, seed)).expect("the map fits");
        for (from, goal) in (0..PAIRS).filter_map(|pair| ground.draw(100 * seed + pair)) {
            let (plan, plan_ms) = clock.time_ms(|| plan_long(&ground.planner.raster, &robot, from, goal));
            let (route, route_ms) = clock.time_ms(|| ground.route(from, goal));
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

fn main() {
    let clock = Clock(Instant::now());
    println!("most of {SEEDS} maps of {SIDE} x {SIDE} cells with {PAIRS} pairs of places each");
    println!(
        "{:28} {:>6} {:>12} {:>9} {:>7} {:>7}",
        "map", "plans", "one plan ms", "route ms", "cells", "of free"
    );
    for kind in Kind::ALL {
        let most = measure(kind, &clock);
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
