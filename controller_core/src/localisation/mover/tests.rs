//! A ring that sees discs and walls without noise, beside a robot that drives.

use super::{MoverParameters, Movers};
use crate::scalar::{Fixed, Scalar};
use crate::schedule::Schedule;
use crate::sensing::proximity::{ProximityParameters, Scan};
use crate::units::Pose;

const SENSORS: usize = 12;
const RADIUS_M: f32 = 0.025;
const RANGE_M: f32 = 0.175;
const PERIOD_S: f32 = 0.128;

fn parameters<S: Scalar>(headway_s: f32) -> MoverParameters<S> {
    MoverParameters { headway_s: S::from_f32(headway_s), speed_mps: S::from_f32(0.02) }
}

const SCHEDULE: Schedule = Schedule { avoidance_period_ms: 128, target_period_ms: 256, step_ms: 1024 };

fn ring<S: Scalar>() -> ProximityParameters<S> {
    ProximityParameters { body_radius_m: S::from_f32(RADIUS_M), range_m: S::from_f32(RANGE_M) }
}

/// What stands around: the distance (m) of its nearest point along a bearing (rad, world), from a place (m).
type Surroundings<'a> = &'a dyn Fn(f32, (f32, f32)) -> Option<f32>;

/// A disc of the robot's size, as a ray from `from` along `bearing` meets it.
fn disc(centre: (f32, f32), bearing: f32, from: (f32, f32)) -> Option<f32> {
    let (x, y) = (centre.0 - from.0, centre.1 - from.1);
    let (sin, cos) = (libm::sinf(bearing), libm::cosf(bearing));
    let (along, aside) = (x * cos + y * sin, y * cos - x * sin);
    (along > 0.0 && aside.abs() < RADIUS_M).then(|| along - libm::sqrtf(RADIUS_M * RADIUS_M - aside * aside))
}

fn scan<S: Scalar>(pose: (f32, f32, f32), surroundings: Surroundings) -> Scan<S, SENSORS> {
    let range_m = core::array::from_fn(|sensor| {
        let bearing = pose.2 + core::f32::consts::TAU / 12.0 * f32::from(u8::try_from(sensor).unwrap());
        // Rays half a degree apart over the width of the beam.
        let rays = (-15_i8..=15).map(|ray| bearing + f32::from(ray) * 0.5_f32.to_radians());
        let nearest = rays.filter_map(|ray| surroundings(ray, (pose.0, pose.1))).reduce(f32::min);
        nearest.map(|distance| distance - RADIUS_M).filter(|range| *range < RANGE_M).map(S::from_f32)
    });
    Scan { range_m }
}

/// Follows what is around a robot that drives straight on along x for some scans.
fn follow<S: Scalar>(
    speed_mps: f32,
    scans: u8,
    headway_s: f32,
    surroundings: impl Fn(f32, f32, (f32, f32)) -> Option<f32>,
) -> (Movers<S, SENSORS, 6>, Pose<S>) {
    let mut movers = Movers::NONE;
    let mut pose = Pose::default();
    for number in 0..scans {
        let t = f32::from(number) * PERIOD_S;
        let x = speed_mps * t;
        pose.x_m = S::from_f32(x);
        let scan = scan((x, 0.0, 0.0), &|bearing, from| surroundings(t, bearing, from));
        movers.renew(&parameters(headway_s), &SCHEDULE, &ring(), &scan, pose);
    }
    (movers, pose)
}

fn check_crossing<S: Scalar>() {
    // Ahead, from the left to the right, while the robot drives towards its way.
    let at = |t: f32| (0.14, 0.11 - 0.1 * t);
    let (movers, pose) = follow::<S>(0.03, 12, 0.5, |t, bearing, from| disc(at(t), bearing, from));
    let seen = movers.seen_from(&parameters(0.5), pose);
    assert_eq!(seen.len(), 1, "{}: {movers:?}", S::NAME);
    let (mover, (x, y)) = (seen[0], at(11.0 * PERIOD_S));
    let off = libm::hypotf(mover.at.x_m.to_f32() + pose.x_m.to_f32() - x, mover.at.y_m.to_f32() - y);
    // A sector is 8 cm wide there.
    assert!(off < 0.04, "{}: {off} m off", S::NAME);
    let velocity = (mover.velocity_mps.x_m.to_f32(), mover.velocity_mps.y_m.to_f32());
    assert!(velocity.1 < -0.04 && velocity.0.abs() < 0.05, "{}: {velocity:?}", S::NAME);
    assert!(mover.clearance_m.to_f32() > 0.02, "{}: {mover:?}", S::NAME);
}

#[test]
fn a_disc_that_crosses_the_way_is_followed() {
    check_crossing::<f32>();
    check_crossing::<Fixed>();
}

fn check_standing<S: Scalar>() {
    let post = |_: f32, bearing: f32, from| disc((0.3, 0.08), bearing, from);
    let wall = |_: f32, bearing: f32, (_, y): (f32, f32)| {
        let sine = libm::sinf(bearing);
        (sine > 0.05).then(|| (0.06 - y) / sine)
    };
    let jambs = |t: f32, bearing: f32, from: (f32, f32)| {
        let distance = wall(t, bearing, from)?;
        let x = from.0 + distance * libm::cosf(bearing);
        (!(0.2..0.28).contains(&x)).then_some(distance)
    };
    for scans in 1..40 {
        // A wall is never alone. One beam tells little of where in it a post is, and a jamb's wall comes into view as
        // the robot goes on: both may seem to move, but not quickly.
        for (name, least, (movers, pose)) in [
            ("a wall", 0.0, follow::<S>(0.11, scans, 0.5, wall)),
            ("a post", 0.045, follow::<S>(0.11, scans, 0.5, post)),
            ("a door", 0.06, follow::<S>(0.06, scans, 0.5, jambs)),
        ] {
            let p = MoverParameters { speed_mps: S::from_f32(least), ..parameters(0.5) };
            let movers = movers.seen_from(&p, pose);
            assert!(movers.is_empty(), "{}: {name} moves after {scans} scans: {movers:?}", S::NAME);
        }
    }
}

#[test]
fn what_stands_beside_a_robot_that_drives_does_not_move() {
    check_standing::<f32>();
    check_standing::<Fixed>();
}

#[test]
fn a_circle_is_followed_round() {
    // Around a robot that stands: one rad/s, 12 cm away, as if on a leash.
    let at = |t: f32| (0.12 * libm::cosf(t), 0.12 * libm::sinf(t));
    let (movers, pose) = follow::<f32>(0.0, 40, 0.5, |t, bearing, from| disc(at(t), bearing, from));
    let mover = movers.seen_from(&parameters(0.5), pose)[0];
    assert!((0.5..=1.25).contains(&mover.turn_radps), "{mover:?}");
    let (soon, there) = (mover.after(0.5), at(39.0 * PERIOD_S + 0.5));
    let off = libm::hypotf(soon.x_m - there.0, soon.y_m - there.1);
    assert!(off < 0.04, "{off} m off half a second later");
}

#[test]
fn what_is_gone_is_forgotten_and_without_headway_nothing_moves() {
    let at = |t: f32| (0.15, 0.12 - 0.1 * t);
    let crossing = |t: f32, bearing: f32, from| disc(at(t), bearing, from);
    let (mut movers, pose) = follow::<f32>(0.0, 12, 0.5, crossing);
    assert_eq!(movers.seen_from(&parameters(0.5), pose).len(), 1);
    for _ in 0..5 {
        movers.renew(&parameters(0.5), &SCHEDULE, &ring(), &Scan::<f32, SENSORS>::EMPTY, pose);
    }
    assert!(movers.seen_from(&parameters(0.5), pose).is_empty());
    // It comes back a little farther on, and nothing is known of it any more.
    movers.renew(
        &parameters(0.5),
        &SCHEDULE,
        &ring(),
        &scan((0.0, 0.0, 0.0), &|b, from| disc(at(1.4), b, from)),
        pose,
    );
    assert!(movers.seen_from(&parameters(0.5), pose).is_empty());
    let (movers, _) = follow::<f32>(0.0, 12, 0.0, crossing);
    assert_eq!(movers, Movers::NONE);
}

#[test]
fn a_disc_is_followed_though_a_post_stands_before_it() {
    // A post is known; then a disc comes behind it, in the beam beside the post's and hardly farther away.
    let at = |t: f32| (0.17 - 0.05 * (t - 1.3).max(0.0), -0.01);
    let (movers, pose) = follow::<f32>(0.0, 22, 0.5, |t, bearing, from| {
        let post = disc((0.105, 0.06), bearing, from);
        let comes = disc(at(t), bearing, from).filter(|_| t > 1.3);
        post.into_iter().chain(comes).reduce(f32::min)
    });
    let seen = movers.seen_from(&parameters(0.5), pose);
    assert_eq!(seen.len(), 1, "{movers:?}");
    let (mover, there) = (seen[0], at(21.0 * PERIOD_S));
    let off = libm::hypotf(mover.at.x_m - there.0, mover.at.y_m - there.1);
    // The post hides a part of the sector.
    assert!(off < 0.04 && mover.velocity_mps.x_m < -0.01, "{off} m off: {mover:?}");
}
