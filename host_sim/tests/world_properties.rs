//! Distances and ranges of the world against dense sampling of its surfaces.
//!
//! The sampler knows nothing of projections and crossings: it walks along every outline and measures. Its answer can be
//! off by the distance between two samples, no more, so that each exact answer is held from both sides.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use host_sim::beam::Beam;
use host_sim::geometry::{Disc, Polygon, Segment};
use host_sim::mover::{Direction, Mover};
use host_sim::solids::Solids;
use host_sim::world::{Timed, Window, World};
use nalgebra::{Point2, Vector2};
use proptest::collection::vec;
use proptest::prelude::{Just, Strategy, any, prop_assert, prop_assert_eq, proptest};

/// Samples per metre of outline.
const PER_METRE: f64 = 2000.0;
/// Furthest that a surface point can be from a sample, with some room for rounding.
const SAMPLING_M: f64 = 0.6 / PER_METRE;
const ROUNDING_M: f64 = 1e-9;

fn point() -> impl Strategy<Value = Point2<f64>> {
    (0.0..1.0_f64, 0.0..1.0_f64).prop_map(|(x, y)| Point2::new(x, y))
}

fn disc() -> impl Strategy<Value = Disc> {
    (point(), 0.01..0.2_f64).prop_map(|(centre, radius_m)| Disc { centre, radius_m })
}

/// A polygon that is star-shaped, so that it cannot cross itself, and usually not convex.
fn polygon() -> impl Strategy<Value = Polygon> {
    let corners = vec((0.02..0.25_f64, 0.1..0.9_f64), 3..9);
    (point(), corners, any::<bool>()).prop_map(|(centre, corners, backwards)| {
        let step = TAU / f64::from(u32::try_from(corners.len()).expect("fewer than nine corners"));
        let mut sector = 0.0;
        let mut vertices = Vec::new();
        for (radius, place) in corners {
            let (sin, cos) = ((sector + place) * step).sin_cos();
            vertices.push(centre + Vector2::new(cos, sin) * radius);
            sector += 1.0;
        }
        if backwards {
            vertices.reverse();
        }
        Polygon::new(&vertices).expect("sectors of positive angle enclose an area")
    })
}

fn solids() -> impl Strategy<Value = Solids> {
    let segments = vec((point(), point()).prop_map(|(from, to)| Segment::new(from, to)), 0..4);
    (segments, vec(disc(), 0..3), vec(polygon(), 0..3)).prop_map(|(segments, discs, polygons)| Solids {
        segments,
        discs,
        polygons,
        index: None,
    })
}

fn mover() -> impl Strategy<Value = Mover> {
    let direction = proptest::prop_oneof![Just(Direction::Anticlockwise), Just(Direction::Clockwise)];
    (point(), 0.03..0.3_f64, 0.01..0.05_f64, 0.0..0.2_f64, direction, -PI..PI).prop_map(
        |(centre, orbit_m, radius_m, speed_m_s, direction, phase)| {
            Mover::new(centre, orbit_m, radius_m, speed_m_s, direction, phase)
        },
    )
}

fn world() -> impl Strategy<Value = World> {
    let timed = (solids(), 0.0..5.0_f64, 0.1..5.0_f64).prop_map(|(solids, from_s, span_s)| {
        let window = Window { from_s, until_s: from_s + span_s };
        Timed { window, solids }
    });
    (solids(), vec(timed, 0..2), vec(mover(), 0..2)).prop_map(|(permanent, timed, movers)| World {
        permanent,
        timed,
        movers,
        ..World::default()
    })
}

fn along(segment: &Segment) -> Vec<Point2<f64>> {
    let steps = (segment.edge().norm() * PER_METRE).ceil().max(1.0);
    let mut places = vec![segment.end()];
    let mut step = 0.0;
    while step < steps {
        places.push(segment.start() + segment.edge() * (step / steps));
        step += 1.0;
    }
    places
}

fn around(disc: &Disc) -> Vec<Point2<f64>> {
    let steps = (disc.radius_m * TAU * PER_METRE).ceil();
    let mut places = Vec::new();
    let mut step = 0.0;
    while step < steps {
        let (sin, cos) = (step / steps * TAU).sin_cos();
        places.push(disc.centre + Vector2::new(cos, sin) * disc.radius_m);
        step += 1.0;
    }
    places
}

/// Everything that is there at the time, in samples.
fn surface(world: &World, t_s: f64) -> Vec<Point2<f64>> {
    let mut samples = Vec::new();
    for solids in present(world, t_s) {
        samples.extend(solids.segments.iter().flat_map(along));
        samples.extend(solids.discs.iter().flat_map(around));
        samples.extend(solids.polygons.iter().flat_map(|polygon| polygon.edges().iter().flat_map(along)));
    }
    samples.extend(world.movers.iter().flat_map(|mover| around(&mover.at(t_s))));
    samples
}

fn present(world: &World, t_s: f64) -> impl Iterator<Item = &Solids> {
    let timed =
        world.timed.iter().filter(move |timed| timed.window.from_s <= t_s && t_s < timed.window.until_s);
    core::iter::once(&world.permanent).chain(timed.map(|timed| &timed.solids))
}

/// How often the outline winds around the point, from the angles that its corners turn through.
fn winds_around(polygon: &Polygon, point: Point2<f64>) -> bool {
    let turn = |edge: &Segment| {
        let (from, to) = (edge.start() - point, edge.end() - point);
        from.perp(&to).atan2(from.dot(&to))
    };
    polygon.edges().iter().map(turn).sum::<f64>().abs() > PI
}

fn is_inside(world: &World, point: Point2<f64>, t_s: f64) -> bool {
    let in_disc = |disc: &Disc| (point - disc.centre).norm() < disc.radius_m;
    present(world, t_s).any(|solids| {
        solids.discs.iter().any(in_disc) || solids.polygons.iter().any(|polygon| winds_around(polygon, point))
    }) || world.movers.iter().any(|mover| in_disc(&mover.at(t_s)))
}

/// Distance from an offset to the cone around `axis_rad`, zero inside.
fn distance_to_cone(offset: Vector2<f64>, axis_rad: f64, half_width_rad: f64) -> f64 {
    let turn = (offset.y.atan2(offset.x) - axis_rad).rem_euclid(TAU);
    let beyond = turn.min(TAU - turn) - half_width_rad;
    if beyond <= 0.0 {
        0.0
    } else if beyond < FRAC_PI_2 {
        offset.norm() * beyond.sin()
    } else {
        offset.norm()
    }
}

fn smallest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

proptest! {
    #[test]
    fn clearance_is_the_distance_to_the_nearest_sample(world in world(), centre in point(), t_s in 0.0..8.0_f64) {
        let clearance = world.clearance(centre, t_s);
        let nearest = smallest(surface(&world, t_s).iter().map(|sample| (sample - centre).norm()));
        if is_inside(&world, centre, t_s) {
            // Where solids overlap, the depth in one of them may exceed the distance to another's outline.
            prop_assert!(clearance <= ROUNDING_M, "{clearance} m inside something");
        } else if nearest.is_finite() {
            prop_assert!((clearance - nearest).abs() <= SAMPLING_M, "{clearance} m, sampled {nearest} m");
        } else {
            prop_assert!(clearance.is_infinite());
        }
        let parts = world.static_clearance(centre).min(world.movers_clearance(centre, t_s));
        prop_assert_eq!(clearance.to_bits(), parts.to_bits());
    }

    #[test]
    fn depth_in_a_single_solid_is_the_distance_to_its_outline(polygon in polygon(), place in point()) {
        let outline: Vec<_> = polygon.edges().iter().flat_map(along).collect();
        let nearest = smallest(outline.iter().map(|sample| (sample - place).norm()));
        let expected = if winds_around(&polygon, place) { -nearest } else { nearest };
        prop_assert!((polygon.clearance(place) - expected).abs() <= SAMPLING_M);
    }

    #[test]
    fn going_back_along_the_normal_by_the_clearance_ends_on_the_surface(
        world in world(), centre in point(), t_s in 0.0..8.0_f64,
    ) {
        match world.nearest_surface(centre, t_s) {
            None => prop_assert!(world.clearance(centre, t_s).is_infinite()),
            Some(nearest) => {
                prop_assert!((nearest.normal.norm() - 1.0).abs() < 1e-12);
                prop_assert!((nearest.clearance_m - world.clearance(centre, t_s)).abs() < ROUNDING_M);
                let landing = centre - nearest.normal * nearest.clearance_m;
                let off = smallest(surface(&world, t_s).iter().map(|sample| (sample - landing).norm()));
                prop_assert!(off <= SAMPLING_M, "{off} m off the surface");
                prop_assert_eq!(world.nearest_surface_normal(centre, t_s), Some(nearest.normal));
            }
        }
    }

    #[test]
    fn a_range_is_the_distance_to_the_nearest_sample_in_the_cone(
        world in world(),
        apex in point(),
        axis in -PI..PI,
        half_width in proptest::prop_oneof![Just(0.0), 0.0..1.2_f64],
        range_max in proptest::prop_oneof![Just(0.2), 0.05..1.5_f64],
        t_s in 0.0..8.0_f64,
    ) {
        let range = world.beam_range(apex, &Beam::new(axis, half_width), range_max, t_s);
        let offsets: Vec<_> = surface(&world, t_s).iter().map(|sample| sample - apex).collect();
        let near_cone = |within_m: f64| {
            let chosen = offsets.iter().filter(|offset| distance_to_cone(**offset, axis, half_width) <= within_m);
            smallest(chosen.map(|offset| offset.norm()))
        };
        // No sample inside the cone is nearer than the range; and the point of the range has a sample beside it.
        let inside = near_cone(0.0);
        match range {
            Some(range) => {
                prop_assert!(range <= range_max);
                prop_assert!(range <= inside + ROUNDING_M, "{range} m, but a sample at {inside} m");
                let beside = near_cone(SAMPLING_M);
                prop_assert!(range >= beside - SAMPLING_M, "{range} m, but no sample before {beside} m");
            }
            None => prop_assert!(inside > range_max - ROUNDING_M, "nothing, but a sample at {inside} m"),
        }
    }

    #[test]
    fn a_scan_is_its_beams_one_by_one(world in world(), apex in point(), turn in -PI..PI, t_s in 0.0..8.0_f64) {
        let (sin, cos) = turn.sin_cos();
        let beams = core::array::from_fn::<_, 12, _>(|i| {
            Beam::new(PI / 6.0 * f64::from(u8::try_from(i).unwrap()), 0.13).turned(cos, sin)
        });
        let scan = world.scan(apex, &beams, 0.2, t_s);
        prop_assert_eq!(scan, beams.map(|beam| world.beam_range(apex, &beam, 0.2, t_s)));
    }

    /// What lets a simulator skip contact tests: clearance is used up no faster than by travelling.
    #[test]
    fn clearance_shrinks_no_faster_than_robot_and_movers_travel(
        world in world(), from in point(), to in point(), t_s in 0.0..8.0_f64, span_s in 0.0..2.0_f64,
    ) {
        let travel = (to - from).norm();
        prop_assert!(world.static_clearance(to) >= world.static_clearance(from) - travel - ROUNDING_M);
        let later_s = (t_s + span_s).min(world.next_change_s(t_s) - 1e-6).max(t_s);
        let spent = travel + world.fastest_mover_m_s() * (later_s - t_s);
        prop_assert!(world.movers_clearance(to, later_s) >= world.movers_clearance(from, t_s) - spent - ROUNDING_M);
    }

    #[test]
    fn a_movers_least_clearance_is_reached_and_never_passed(mover in mover(), place in point()) {
        let round_s = TAU * mover.orbit_radius_m / mover.speed_m_s().max(0.01);
        let moments = (0..2000).map(|i| round_s * f64::from(i) / 2000.0);
        let least = smallest(moments.map(|t_s| mover.at(t_s).clearance(place)));
        prop_assert!(mover.least_clearance(place) <= least + ROUNDING_M);
        if mover.speed_m_s() > 0.01 {
            prop_assert!(mover.least_clearance(place) >= least - TAU * mover.orbit_radius_m / 2000.0);
        }
    }

    /// A ring that is clear of everything never touches it; a ring that is not does so within one round.
    #[test]
    fn a_movers_ring_is_as_clear_as_its_rounds(mover in mover(), solids in solids()) {
        let world = World { permanent: solids, ..World::default() };
        let still = Mover::new(mover.centre, mover.orbit_radius_m, mover.radius_m, TAU * mover.orbit_radius_m,
            mover.direction(), 0.0);
        let rounds = (0..4000).map(|i| world.static_clearance(still.at(f64::from(i) / 4000.0).centre));
        let least = smallest(rounds) - mover.radius_m;
        let claimed = still.least_clearance_from(&world.permanent);
        if least.is_infinite() {
            prop_assert!(claimed.is_infinite());
        } else if least > 0.001 {
            prop_assert!((claimed - least).abs() < 0.001, "claims {claimed} m, least is {least} m");
        } else {
            prop_assert!(claimed <= least.max(0.0) + ROUNDING_M, "claims {claimed} m, least is {least} m");
        }
    }
}
