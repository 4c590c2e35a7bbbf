//! The planner on worlds that others drew, against a slow reference that shares no code with it.
//!
//! The reference searches a lattice with 32 directions (all coprime steps up to 3 each way) and asks the simulator's
//! shapes, not a raster, whether the disc fits. It is the longer way by at most 1.4 % in the open and by about a
//! lattice step at corners, so that a plan within a few percent of it is within 10 % of the shortest way.
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, which clippy.toml cannot know")]

use core::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};
use std::path::{Path, PathBuf};

use controller_core::planning::{Footprint, PlanError};
use host_sim::benchmark::{Course, Ground, MARGINS_M};
use host_sim::geometry::Disc;
use host_sim::import::{GridMap, MapFrame, gazebo, json_world, map_server, moving_ai};
use host_sim::raster::Raster;
use host_sim::route_planner;
use host_sim::scenario::Shape;
use host_sim::solids::Solids;
use nalgebra::{Point2, Vector2};

/// Body and full margin, in m.
const REACH_M: f64 = 0.035;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/worlds").join(name)
}

fn solids(shapes: &[Shape]) -> Solids {
    let mut solids = Solids::default();
    shapes.iter().for_each(|shape| shape.add_to(&mut solids));
    solids.indexed()
}

/// Whether the disc can go straight: in steps of what is clear, so that nothing is jumped over.
fn is_clear(solids: &Solids, from: Point2<f64>, to: Point2<f64>, reach_m: f64) -> bool {
    const LEAST_M: f64 = 2e-4;
    let length = (to - from).norm();
    let mut at = 0.0;
    while at < length {
        let spare = solids.clearance(from + (to - from) * (at / length)) - reach_m;
        if spare < -1e-9 {
            return false;
        }
        at += spare.max(LEAST_M);
    }
    solids.clearance(to) >= reach_m - 1e-9
}

/// Length of the shortest way over a lattice around `from`, on which `goal` must lie.
fn shortest(
    solids: &Solids,
    spacing_m: f64,
    reach_m: f64,
    from: Point2<f64>,
    goal: Point2<f64>,
) -> Option<f64> {
    let place = |(x, y): (i32, i32)| from + Vector2::new(f64::from(x), f64::from(y)) * spacing_m;
    let steps: Vec<(i32, i32)> = (-3..=3_i32)
        .flat_map(|x| (-3..=3_i32).map(move |y| (x, y)))
        .filter(|&(x, y)| matches!((x.abs(), y.abs()), (0, 1) | (1, 0) | (1, _) | (_, 1) | (2, 3) | (3, 2)))
        .collect();
    let mut costs = HashMap::from([((0, 0), 0.0)]);
    let mut queue = BinaryHeap::from([(Reverse(0_u64), (0, 0), 0_u64)]);
    let mut known = HashMap::new();
    while let Some((_, at, cost)) = queue.pop() {
        let cost = f64::from_bits(cost);
        if (place(at) - goal).norm() < 1e-6 {
            return Some(cost);
        }
        if cost > costs[&at] {
            continue;
        }
        for (x, y) in &steps {
            let next = (at.0 + x, at.1 + y);
            let total = cost + f64::from(*x).hypot(f64::from(*y)) * spacing_m;
            if costs.get(&next).is_some_and(|known| *known <= total) {
                continue;
            }
            if !*known.entry((at, next)).or_insert_with(|| is_clear(solids, place(at), place(next), reach_m))
            {
                continue;
            }
            costs.insert(next, total);
            let bound = total + (goal - place(next)).norm();
            // The bits of numbers above zero are in their order.
            queue.push((Reverse(bound.to_bits()), next, total.to_bits()));
        }
    }
    None
}

/// Plans and references of pairs of places, as ratios; every straight join is tested on the shapes themselves.
fn ratios(ground: &Ground, pairs: &[(Point2<f64>, Point2<f64>)], spacing_m: f64) -> Vec<f64> {
    let solids = solids(&ground.map.shapes());
    // The planner is exact up to a thousandth of a cell.
    let reach_m = REACH_M - 1.5e-3 * ground.map.cell_m;
    let mut ratios = Vec::new();
    for &(from, goal) in pairs {
        let Some(reference) = shortest(&solids, spacing_m, REACH_M, from, goal) else {
            panic!("the reference finds no way from {from} to {goal}")
        };
        let route = ground.route(from, goal).unwrap();
        assert!((f64::from(route.margin_m) - 0.01).abs() < 1e-6, "{route:?}");
        let mut before = from;
        for &place in &route.plan.checkpoints {
            assert!(is_clear(&solids, before, place, reach_m), "{before} to {place}");
            before = place;
        }
        ratios.push(route.plan.length_m(from) / reference);
    }
    ratios
}

fn worst(ratios: &[f64]) -> f64 {
    ratios.iter().copied().fold(0.0, f64::max)
}

#[test]
fn plans_on_a_moving_ai_map_exist_and_are_short() {
    let map = moving_ai::load_map(&data("room-32-32-4.map"), 0.1).unwrap();
    let problems = moving_ai::load_problems(&data("room-32-32-4.scen"), &map).unwrap();
    let ground = Ground::new(map).unwrap();
    let place = |(column, row): (usize, usize)| ground.map.middle(column, ground.map.rows - 1 - row);
    let pairs: Vec<_> = problems.iter().take(8).map(|p| (place(p.start), place(p.goal))).collect();
    let ratios = ratios(&ground, &pairs, 0.025);
    assert!(worst(&ratios) <= 1.05, "{ratios:?}");
}

/// The way of a point over the middles of cells leaves the body more than its margin, so that it bounds the shortest.
/// These are the problems of the set at which a single plan took the wrong side.
#[test]
fn plans_are_hardly_longer_than_the_best_way_over_the_cells() {
    let map = moving_ai::load_map(&data("random-32-32-10.map"), 0.1).unwrap();
    let problems = moving_ai::load_problems(&data("random-32-32-10.scen"), &map).unwrap();
    let ground = Ground::new(map).unwrap();
    let place = |(column, row): (usize, usize)| ground.map.middle(column, ground.map.rows - 1 - row);
    for problem in &problems {
        let (from, goal) = (place(problem.start), place(problem.goal));
        let length = ground.route(from, goal).unwrap().plan.length_m(from);
        assert!(length <= 1.03 * 0.1 * problem.optimal_cells, "{problem:?}: {length} m");
    }
}

#[test]
fn plans_on_a_ros_map_exist_and_are_short() {
    let map = map_server::load(&data("tb3_sandbox.yaml"), 0.2381).unwrap();
    let cell_m = map.cell_m;
    let ground = Ground::new(map).unwrap();
    let pairs: Vec<_> = (1..=8).map(|seed| ground.draw(seed).unwrap()).collect();
    let ratios = ratios(&ground, &pairs, cell_m);
    assert!(worst(&ratios) <= 1.05, "{ratios:?}");
    let free = ground.planner.free_cells();
    let plan = ground.route(pairs[0].0, pairs[0].1).unwrap().plan;
    assert!(plan.cells * 20 <= free, "{} cells of {free}", plan.cells);
}

#[test]
fn a_gazebo_world_is_the_json_world_of_the_same_name() {
    let json = json_world::load(&data("barn_000_W.json")).unwrap();
    let world = gazebo::load(&data("world_0.world"), gazebo::SCALE_WIDTH).unwrap();
    assert!((world.start - json.start).norm() < 1e-6 && (world.goal - json.goal).norm() < 1e-6);
    assert!((world.goal_tolerance_m - json.goal_tolerance_m).abs() < 1e-6);
    let discs = |shapes: &[Shape]| -> Vec<Disc> {
        let disc = |shape: &Shape| if let Shape::Disc(disc) = shape { Some(*disc) } else { None };
        shapes.iter().filter_map(disc).collect()
    };
    let (ours, theirs) = (discs(&world.shapes), discs(&json.shapes));
    assert_eq!((ours.len(), theirs.len()), (209, 209));
    for (a, b) in ours.iter().zip(&theirs) {
        assert!((a.centre - b.centre).norm() < 2e-6 && (a.radius_m - b.radius_m).abs() < 2e-6, "{a:?} {b:?}");
    }
}

#[test]
fn where_only_the_body_fits_the_margin_is_reduced() {
    let world = json_world::load(&data("barn_180_C.json")).unwrap();
    let solids = solids(&world.shapes);
    let (start, goal) = (world.start, world.goal);
    let course = Course::of_world(world).unwrap();
    let route = course.route.unwrap();
    // The gap is 6.3 mm wider than the body.
    assert!(route.margin_m > 0.0 && route.margin_m < 0.004, "{}", route.margin_m);
    let reach_m = 0.025 + f64::from(route.margin_m);
    let mut before = start;
    for &place in &route.plan.checkpoints {
        assert!(is_clear(&solids, before, place, reach_m - 1e-4), "{before} to {place}");
        before = place;
    }
    assert!((before - goal).norm() < 1e-6);
    assert!(route.plan.length_m(start) < 1.05 * course.shortest_m);
}

#[test]
fn a_map_that_is_too_full_is_refused_with_the_capacity() {
    // Every second cell of every second row: no planner has room for all the gaps.
    let side = 512;
    let passable = (0..side * side).map(|i| (i % side) % 2 == 0 || (i / side) % 2 == 0).collect();
    let (name, source) = (String::from("full"), String::new());
    let map =
        GridMap { name, source, columns: side, rows: side, cell_m: 0.1, frame: MapFrame::IDENTITY, passable };
    let raster = Raster::within(map.bounds(), map.shapes()[1..].iter(), map.cell_m).unwrap();
    let footprint = Footprint::new(0.025, MARGINS_M[0]).unwrap();
    let (from, goal) = (map.middle(0, 0), map.middle(510, 510));
    let plan = std::thread::Builder::new()
        .stack_size(16 << 20)
        .spawn(move || route_planner::plan_long(&raster, &footprint, from, goal))
        .unwrap()
        .join()
        .unwrap();
    assert!(
        matches!(plan, Err(PlanError::TooManyCells { .. } | PlanError::TooManyPassages { .. })),
        "{plan:?}"
    );
}
