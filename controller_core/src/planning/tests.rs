//! The planner against hand-drawn worlds, a slow reference, and nonsense.
extern crate std;

use std::vec::Vec;

use super::{BitGrid, Footprint, GridError, PlanError, Planner, Workspace};
use crate::scalar::{Fixed, Scalar};
use crate::units::Point;
use world::{CELL_M, Random, World};

mod reference;
mod world;

type Scratch = Planner<512, 1024>;

/// Length of a plan and the least clearance of its joins, in cells.
fn measure<S: Scalar>(world: &World, start: Point<S>, plan: &[Point<S>]) -> (f64, f64) {
    let place = |p: Point<S>| {
        let at = |m: f32, origin: f32| (f64::from(m) - f64::from(origin)) / f64::from(CELL_M);
        (at(p.x_m.to_f32(), world.origin_m.0), at(p.y_m.to_f32(), world.origin_m.1))
    };
    let mut from = place(start);
    let (mut length, mut clear) = (0.0, f64::MAX);
    for &point in plan {
        let to = place(point);
        length += (to.0 - from.0).hypot(to.1 - from.1);
        clear = clear.min(reference::clearance(world, from, to, 8.0));
        from = to;
    }
    (length, clear)
}

/// The point in the middle of a cell.
fn middle<S: Scalar>(world: &World, column: u16, row: u16) -> Point<S> {
    Point::from_metres(
        world.origin_m.0 + (f32::from(column) + 0.5) * CELL_M,
        world.origin_m.1 + (f32::from(row) + 0.5) * CELL_M,
    )
}

#[test]
fn explore() {
    let mut planner = std::boxed::Box::new(Scratch::new());
    let robot = Footprint::new(0.025, 0.005).unwrap();
    let (mut both, mut none, mut differ) = (0, 0, 0);
    let mut ratios = Vec::new();
    let mut shares = Vec::new();
    let mut counts = Vec::new();
    let mut worst = f64::MAX;
    for seed in 0..240_u64 {
        let mut random = Random::new(seed + 7777);
        let (columns, rows) = (random.between(40, 64), random.between(40, 64));
        let (discs, walls) = (random.between(0, 14), random.between(0, 3));
        let world = World::random(seed, columns, rows, discs, walls);
        let mut place = || {
            for _ in 0..300 {
                let at = (random.between(3, columns - 4), random.between(3, rows - 4));
                let spot = (f64::from(at.0) + 0.5, f64::from(at.1) + 0.5);
                if reference::clearance(&world, spot, spot, 4.0) >= 3.0 {
                    return at;
                }
            }
            (3, 3)
        };
        let (s, g) = (place(), place());
        let (start, goal) = (middle::<f32>(&world, s.0, s.1), middle::<f32>(&world, g.0, g.1));
        let lattice = |p: (u16, u16)| (2 * i32::from(p.0) + 1, 2 * i32::from(p.1) + 1);
        let best = reference::shortest(&world, 3.0, 2, lattice(s), lattice(g));
        let plan = planner.plan::<f32, _, 64>(&world, &robot, start, goal);
        match (best, plan) {
            (Some(best), Ok(plan)) => {
                both += 1;
                let (length, clear) = measure(&world, start, &plan);
                if best > 1.0 {
                    ratios.push((length / best, seed));
                }
                worst = worst.min(clear);
                if clear < 2.99 || length / best > 1.1 {
                    std::println!(
                        "seed {seed} clear {clear} length {length} best {best} start {s:?} goal {g:?} plan {:?}",
                        plan.iter().map(|p| (p.x_m / CELL_M, p.y_m / CELL_M)).collect::<Vec<_>>()
                    );
                    for row in (0..rows).rev() {
                        let line: std::string::String = (0..columns)
                            .map(|c| {
                                if (c, row) == s {
                                    'S'
                                } else if (c, row) == g {
                                    'G'
                                } else if plan
                                    .iter()
                                    .any(|p| (p.x_m / CELL_M) as u16 == c && (p.y_m / CELL_M) as u16 == row)
                                {
                                    'o'
                                } else if world.is_free(c, row) {
                                    '.'
                                } else {
                                    '#'
                                }
                            })
                            .collect();
                        std::println!("{line}");
                    }
                }
                shares.push(planner.cell_count() as f64 / world.free_cells() as f64);
                counts.push(plan.len());
            }
            (None, Err(_)) => none += 1,
            (best, plan) => {
                differ += 1;
                let small = planner
                    .plan::<f32, _, 64>(&world, &Footprint::new(0.0295, 0.0).unwrap(), start, goal)
                    .is_ok();
                std::println!("seed {seed}: {best:?} smaller {small} {plan:?}");
            }
        }
    }
    ratios.sort_by(|a, b| a.partial_cmp(b).unwrap());
    shares.sort_by(|a, b| a.partial_cmp(b).unwrap());
    counts.sort_unstable();
    let n = ratios.len();
    std::println!("both {both} none {none} differ {differ} clearance {worst}");
    std::println!(
        "ratio median {:?} 90% {:?} worst {:?}",
        ratios[n / 2],
        ratios[n * 9 / 10],
        &ratios[n - 8..]
    );
    std::println!(
        "cells/free median {} max {}; checkpoints {} {}",
        shares[shares.len() / 2],
        shares[shares.len() - 1],
        counts[counts.len() / 2],
        counts[counts.len() - 1]
    );
}

#[test]
fn speed() {
    let mut planner = std::boxed::Box::new(Planner::<8192, 16384>::new());
    let robot = Footprint::new(0.025, 0.005).unwrap();
    for (discs, walls) in [(0, 0), (100, 4), (400, 2), (1200, 0)] {
        let mut slowest = 0.0_f64;
        let mut total = 0.0;
        let (mut ok, mut cells, mut passages, mut checkpoints) = (0, 0, 0, 0);
        for seed in 0..10 {
            let mut random = Random::new(seed + 99);
            let world = World::random(seed, 512, 512, discs, walls);
            let mut place = || {
                for _ in 0..300 {
                    let at = (random.between(3, 508), random.between(3, 508));
                    let spot = (f64::from(at.0) + 0.5, f64::from(at.1) + 0.5);
                    if reference::clearance(&world, spot, spot, 4.0) >= 3.0 {
                        return at;
                    }
                }
                (3, 3)
            };
            let (s, g) = (place(), place());
            let before = std::time::Instant::now();
            let plan = planner.plan::<f32, _, 256>(
                &world,
                &robot,
                middle(&world, s.0, s.1),
                middle(&world, g.0, g.1),
            );
            let t = before.elapsed().as_secs_f64() * 1e3;
            slowest = slowest.max(t);
            total += t;
            ok += usize::from(plan.is_ok());
            cells += planner.cell_count();
            passages += planner.passage_count();
            if let Ok(plan) = plan {
                checkpoints += plan.len();
            }
        }
        std::println!(
            "512: discs {discs} walls {walls}: mean {} ms, slowest {slowest} ms, ok {ok}/10, mean cells {} passages {} checkpoints {}",
            total / 10.0,
            cells / 10,
            passages / 10,
            checkpoints / ok.max(1)
        );
    }
}
