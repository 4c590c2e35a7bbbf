//! Angles and frames for any argument, in both scalars.

use super::{Point, Polar, Pose, angle_between, wrap};
use crate::scalar::{Fixed, Scalar};
use crate::testing::{apart, wide};
use proptest::prelude::*;

fn wrapping_keeps_the_direction<S: Scalar>(angle: f32) {
    let wrapped = wrap(S::from_f32(angle));
    assert!(wrapped >= -S::PI && wrapped < S::PI, "{angle}: {wrapped:?}");
    assert!(apart(wide(wrapped), wide(S::from_f32(angle))) < 1e-5, "{angle}: {wrapped:?}");
    assert_eq!(wrap(wrapped), wrapped, "wrapping twice changes nothing");
}

/// Where the interval ends, a last bit decides.
fn wrapping_half_turns_gives_a_half_turn<S: Scalar>() {
    for angle in [S::PI, -S::PI, S::PI + S::TAU, -S::PI - S::TAU, S::TAU - S::PI, S::PI - S::TAU] {
        let wrapped = wrap(angle);
        assert!(wrapped >= -S::PI && wrapped < S::PI, "{angle:?}: {wrapped:?}");
        assert!((wide(wrapped).abs() - core::f64::consts::PI).abs() < 1e-5, "{angle:?}: {wrapped:?}");
    }
    assert!(wide(wrap(S::TAU)).abs() < 1e-5);
}

#[test]
fn half_turns_stay_half_turns() {
    wrapping_half_turns_gives_a_half_turn::<f32>();
    wrapping_half_turns_gives_a_half_turn::<Fixed>();
}

fn the_turn_leads_from_one_to_the_other<S: Scalar>(from: f32, to: f32) {
    let turn = angle_between(S::from_f32(from), S::from_f32(to));
    assert!(turn >= -S::PI && turn < S::PI);
    assert!(apart(f64::from(from) + wide(turn), f64::from(to)) < 1e-5, "{from} {to}: {turn:?}");
}

fn frames_invert_each_other<S: Scalar>(pose: (f32, f32, f32), point: (f32, f32)) {
    let pose = Pose { x_m: S::from_f32(pose.0), y_m: S::from_f32(pose.1), heading_rad: S::from_f32(pose.2) };
    let point = Point::<S>::from_metres(point.0, point.1);
    let rotation = pose.heading_rad.sin_cos();
    let back = pose.to_world_frame(pose.to_robot_frame(point, rotation), rotation);
    assert!(wide(back.distance_to(point)) < 5e-5, "{point:?} became {back:?}");
    // What is seen is what the robot frame says.
    let seen = pose.see(point).to_point();
    assert!(wide(seen.distance_to(pose.to_robot_frame(point, rotation))) < 1e-4);
}

fn polar_and_cartesian_invert_each_other<S: Scalar>(bearing: f32, distance: f32) {
    let place = Polar { bearing_rad: S::from_f32(bearing), distance_m: S::from_f32(distance) };
    let back = place.to_point().to_polar();
    assert!((wide(back.distance_m) - wide(place.distance_m)).abs() < 2e-5);
    // A short vector in fixed point has a coarse angle.
    assert!(apart(wide(back.bearing_rad), wide(place.bearing_rad)) * f64::from(distance) < 2e-5);
}

proptest! {
    #[test]
    fn angles(angle in -12.0_f32..12.0, from in -3.1_f32..3.1, to in -3.1_f32..3.1) {
        wrapping_keeps_the_direction::<f32>(angle);
        wrapping_keeps_the_direction::<Fixed>(angle);
        the_turn_leads_from_one_to_the_other::<f32>(from, to);
        the_turn_leads_from_one_to_the_other::<Fixed>(from, to);
    }

    #[test]
    fn frames(
        pose in (-9.0_f32..9.0, -9.0_f32..9.0, -3.1_f32..3.1),
        point in (-9.0_f32..9.0, -9.0_f32..9.0),
        bearing in -3.1_f32..3.1,
        distance in 0.0_f32..5.0,
    ) {
        frames_invert_each_other::<f32>(pose, point);
        frames_invert_each_other::<Fixed>(pose, point);
        polar_and_cartesian_invert_each_other::<f32>(bearing, distance);
        polar_and_cartesian_invert_each_other::<Fixed>(bearing, distance);
    }
}
