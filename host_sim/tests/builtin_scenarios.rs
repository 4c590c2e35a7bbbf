//! The built-in scenarios: each is sound, its goals can be reached, and its sizes are those that its comments claim.

use std::collections::{HashSet, VecDeque};

use host_sim::beam::Beam;
use host_sim::geometry::{Bounds, Disc, Polygon};
use host_sim::mover::Direction;
use host_sim::scenario::{ControllerKind, Route, Scenario, Shape, Solid, Trigger};
use host_sim::world::{KHEPERA_RADIUS_M, World};
use nalgebra::{Point2, Vector2};

/// Step of the search for a way, small against the narrowest passage's spare width.
const STEP_M: f64 = 0.01;

fn all() -> impl Iterator<Item = Scenario> {
    Scenario::builtin_names().map(|name| Scenario::load(name).unwrap_or_else(|error| panic!("{error}")))
}

fn load(name: &str) -> Scenario {
    Scenario::builtin(name).expect("a built-in scenario")
}

fn without_movers(scenario: &Scenario) -> World {
    World { movers: Vec::new(), ..scenario.world.clone() }
}

/// Whether the robot's body can be moved from one place to the other in small steps without contact.
fn way_exists(world: &World, t_s: f64, from: Point2<f64>, to: Point2<f64>) -> bool {
    let place =
        |(i, j): (i32, i32)| Point2::new(from.x + f64::from(i) * STEP_M, from.y + f64::from(j) * STEP_M);
    let box_around = Bounds::of_point(from).union(&Bounds::of_point(to)).grown(1.0);
    let mut seen = HashSet::from([(0, 0)]);
    let mut queue = VecDeque::from([(0, 0)]);
    while let Some((i, j)) = queue.pop_front() {
        if (place((i, j)) - to).norm() < STEP_M {
            return true;
        }
        for next in [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)] {
            // Half a step to spare: between two such places the body is clear too.
            let clear = world.clearance(place(next), t_s) > KHEPERA_RADIUS_M + STEP_M / 2.0;
            if clear && box_around.contains(place(next)) && seen.insert(next) {
                queue.push_back(next);
            }
        }
    }
    false
}

#[test]
fn every_builtin_scenario_is_sound_and_carries_its_name() {
    assert_eq!(Scenario::builtin_names().len(), 7);
    for (scenario, name) in all().zip(Scenario::builtin_names()) {
        let (paper, figure) = name.split_once("_fig").unwrap();
        assert_eq!(scenario.name, name);
        assert_eq!(scenario.source, format!("{} Fig. {figure}", paper.to_uppercase()));
    }
}

#[test]
fn p1_scenes_run_p1s_controller_and_period_and_p2_scenes_p2s() {
    for scenario in all() {
        let expected = if scenario.name.starts_with("p1") {
            (ControllerKind::Fusion, 1024)
        } else {
            (ControllerKind::Cooperative, 256)
        };
        assert_eq!((scenario.controller, scenario.target_period_ms), expected, "{}", scenario.name);
    }
}

#[test]
fn noise_is_the_papers_in_every_scene() {
    for scenario in all() {
        let noise = scenario.noise;
        let found = [noise.sensor, noise.actuator, noise.sensor_resolution_m].map(|level| level.to_string());
        assert_eq!(found, ["0.1", "0.1", "0.005"], "{}", scenario.name);
    }
}

#[test]
fn every_checkpoint_can_be_reached_from_the_one_before() {
    for scenario in all() {
        let world = without_movers(&scenario);
        let mut checkpoints = scenario.route.checkpoints().to_vec();
        for replacement in &scenario.replacements {
            checkpoints[replacement.checkpoint] = replacement.to;
        }
        let mut from = scenario.start.position;
        for to in checkpoints {
            assert!(way_exists(&world, scenario.time_limit_s, from, to), "{}: {from} to {to}", scenario.name);
            from = to;
        }
    }
}

#[test]
fn every_scene_is_closed() {
    for scenario in all() {
        let outside = Point2::new(-0.2, 0.3);
        assert!(!way_exists(&scenario.world, 0.0, scenario.start.position, outside), "{}", scenario.name);
    }
}

#[test]
fn without_the_doorway_there_is_no_way_round_the_obstacles_of_p2_fig5() {
    let scenario = load("p2_fig5");
    let mut world = without_movers(&scenario);
    let goal = scenario.goal().unwrap();
    assert!(way_exists(&world, 0.0, scenario.start.position, goal));
    let plug = Disc { centre: Point2::new(0.5, 0.3), radius_m: 0.02 };
    world.permanent.discs.push(plug);
    assert!(!way_exists(&world, 0.0, scenario.start.position, goal));
}

#[test]
fn the_doorway_of_p2_fig5_is_9_cm_wide() {
    let world = load("p2_fig5").world;
    assert!((world.static_clearance(Point2::new(0.5, 0.3)) - 0.045).abs() < 1e-9);
}

#[test]
fn the_concave_obstacle_of_p2_fig4_is_30_cm_wide_and_20_cm_deep_and_faces_the_robot() {
    let scenario = load("p2_fig4");
    let bottom_m =
        scenario.world.beam_range(scenario.start.position, &Beam::new(0.0, 0.0), 1.0, 0.0).unwrap();
    let inside = scenario.start.position + Vector2::new(bottom_m - 0.19, 0.0);
    for angle_deg in [90.0_f64, -90.0] {
        let side = scenario.world.beam_range(inside, &Beam::new(angle_deg.to_radians(), 0.0), 1.0, 0.0);
        assert!((side.unwrap() - 0.15).abs() < 1e-9);
    }
    // A centimetre further from the bottom than it is deep, the sides are gone.
    let before = inside - Vector2::new(0.02, 0.0);
    assert!(scenario.world.beam_range(before, &Beam::new(90.0_f64.to_radians(), 0.0), 0.4, 0.0).is_none());
}

#[test]
fn the_posts_of_p2_fig6_are_10_to_11_cm_apart() {
    let discs = load("p2_fig6").world.permanent.discs;
    for row in [&discs[0..4], &discs[4..8]] {
        for pair in row.windows(2) {
            let gap_m = (pair[0].centre - pair[1].centre).norm() - pair[0].radius_m - pair[1].radius_m;
            assert!((0.10..=0.11).contains(&gap_m), "{gap_m} m");
        }
    }
}

#[test]
fn the_planner_of_p2_fig6_knows_the_rooms_and_none_of_the_obstacles() {
    let scenario = load("p2_fig6");
    assert!(matches!(scenario.route, Route::Planned { .. }));
    assert!(scenario.solids.iter().all(|solid| solid.known == matches_wall(solid)));
    let map = scenario.known_raster(0.02).unwrap();
    assert_eq!((map.columns(), map.rows()), (85, 37));
    for column in 0..map.columns() {
        for row in 0..map.rows() {
            let middle = nalgebra::center(&map.cell(column, row).low, &map.cell(column, row).high);
            let in_wall = walls(&scenario).any(|wall| wall.contains(middle));
            assert!(!(in_wall && map.is_free(column, row)), "column {column}, row {row}");
        }
    }
}

fn walls(scenario: &Scenario) -> impl Iterator<Item = &Polygon> {
    scenario.solids.iter().filter(|solid| solid.known).filter_map(|solid| match &solid.shape {
        Shape::Polygon(polygon) => Some(polygon),
        _ => None,
    })
}

/// The walls of the three rooms are the only rectangles along the axes.
fn matches_wall(solid: &Solid) -> bool {
    match &solid.shape {
        Shape::Polygon(polygon) => polygon.edges().len() == 4,
        _ => false,
    }
}

#[test]
fn the_straight_line_of_p2_fig7_is_blocked_at_both_doorways() {
    let scenario = load("p2_fig7");
    assert_eq!(scenario.route, Route::Checkpoints(vec![scenario.goal().unwrap()]));
    let line = scenario.goal().unwrap() - scenario.start.position;
    let blocked = |wall_x: f64| {
        let along = (wall_x - scenario.start.position.x) / line.x;
        scenario.world.static_clearance(scenario.start.position + line * along) < 0.0
    };
    assert!(blocked(0.55) && blocked(1.11));
}

#[test]
fn the_circling_robots_are_kheperas_that_go_anticlockwise_and_never_meet() {
    for name in ["p1_fig8", "p2_fig7"] {
        let movers = load(name).world.movers;
        for (i, mover) in movers.iter().enumerate() {
            assert_eq!((mover.direction(), mover.radius_m), (Direction::Anticlockwise, KHEPERA_RADIUS_M));
            assert!((mover.speed_m_s() - 0.05).abs() < 1e-12);
            for other in &movers[i + 1..] {
                let apart_m =
                    (mover.centre - other.centre).norm() - mover.orbit_radius_m - other.orbit_radius_m;
                assert!(apart_m > 2.0 * KHEPERA_RADIUS_M, "{apart_m} m");
            }
        }
    }
}

#[test]
fn in_p1_fig9_the_lower_doorway_closes_and_the_upper_opens() {
    let scenario = load("p1_fig9");
    let replacement = scenario.replacements[0];
    let old = scenario.route.checkpoints()[replacement.checkpoint];
    assert_eq!(replacement.checkpoint, 1);
    assert!(matches!(replacement.trigger, Trigger::AfterCheckpoint { checkpoint: 0, .. }));
    let is_open = |place, t_s| scenario.world.clearance(place, t_s) > KHEPERA_RADIUS_M;
    let open = [0.0, scenario.time_limit_s].map(|t_s| (is_open(old, t_s), is_open(replacement.to, t_s)));
    assert_eq!(open, [(true, false), (false, true)]);
    assert_ne!(
        scenario.known_raster(0.02).unwrap(),
        scenario.known_raster_at(0.02, scenario.time_limit_s).unwrap()
    );
}
