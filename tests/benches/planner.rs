//! How long does a plan take on a map of 512 × 512 cells?
//!
//! ```text
//! cargo bench -p tests --bench planner
//! ```
//!
//! Random maps of 5.12 m side with 1 cm cells, discs of 2 to 7 cm and walls with a doorway of 20 cm; start and goal at
//! random. A measurement, not a test: times depend on the machine, so the ratio to the emptiest map is printed too.

use std::time::Instant;

use controller_core::planning::{BitGrid, Footprint, Planner};
use controller_core::units::Point;
use host_sim::random::{Purpose, Stream};
use tests::narrow;

const SIDE: u16 = 512;
const CELL_M: f32 = 0.01;
const SEEDS: u64 = 4;
/// 32 cells a word.
type Grid = BitGrid<8192>;

/// A cell of the map.
fn draw(stream: &mut Stream) -> (f64, f64) {
    (stream.between(0.0, f64::from(SIDE)), stream.between(0.0, f64::from(SIDE)))
}

fn block(grid: &mut Grid, occupied: impl Fn(f64, f64) -> bool) {
    for column in 0..SIDE {
        for row in 0..SIDE {
            if occupied(f64::from(column) + 0.5, f64::from(row) + 0.5) {
                grid.set_free(column, row, false).expect("the cell is on the map");
            }
        }
    }
}

fn map(stream: &mut Stream, discs: u32, walls: u32) -> Box<Grid> {
    let mut grid = Box::new(Grid::new(SIDE, SIDE, CELL_M, (0.0, 0.0)).expect("the map fits"));
    for column in 0..SIDE {
        for row in 0..SIDE {
            grid.set_free(column, row, true).expect("the cell is on the map");
        }
    }
    for _ in 0..discs {
        let ((x, y), radius) = (draw(stream), stream.between(2.0, 7.0));
        block(&mut grid, |column, row| (column - x).hypot(row - y) < radius);
    }
    for _ in 0..walls {
        let (x, door) = draw(stream);
        block(&mut grid, |column, row| (column - x).abs() < 1.0 && (row - door).abs() > 10.0);
    }
    grid
}

/// Least milliseconds and cells over the seeds' plans, and how many plans there were.
fn measure(discs: u32, walls: u32) -> (f64, f64, usize, u64) {
    let robot = Footprint::new(0.025, 0.005).expect("the robot is valid");
    let mut planner = Box::new(Planner::<8192, 16384>::new());
    let (mut least, mut most, mut cells, mut plans) = (f64::INFINITY, 0.0_f64, 0, 0);
    for seed in 0..SEEDS {
        let mut stream = Stream::new(seed, Purpose::Start);
        let grid = map(&mut stream, discs, walls);
        let metres = |cell: f64| narrow(cell) * CELL_M;
        // A place in a disc is refused at once and says nothing: another is drawn.
        for _ in 0..20 {
            let [start, goal] =
                [(); 2].map(|()| draw(&mut stream)).map(|(x, y)| Point { x_m: metres(x), y_m: metres(y) });
            let before = Instant::now();
            let plan = planner.plan::<f32, _, 256>(&*grid, &robot, start, goal);
            let time_ms = before.elapsed().as_secs_f64() * 1e3;
            if plan.is_ok() {
                least = least.min(time_ms);
                most = most.max(time_ms);
                cells = cells.max(planner.cell_count());
                plans += 1;
                break;
            }
        }
    }
    (least, most, cells, plans)
}

fn main() {
    println!(
        "{:>6} {:>6} {:>6} {:>9} {:>9} {:>7} {:>6}",
        "discs", "walls", "plans", "least ms", "most ms", "ratio", "cells"
    );
    let mut empty_ms = None;
    for (discs, walls) in [(0, 0), (100, 4), (400, 2), (1200, 0)] {
        let (least, most, cells, plans) = measure(discs, walls);
        let reference = *empty_ms.get_or_insert(least);
        println!(
            "{discs:>6} {walls:>6} {plans:>6} {least:>9.1} {most:>9.1} {:>7.1} {cells:>6}",
            most / reference
        );
    }
}
