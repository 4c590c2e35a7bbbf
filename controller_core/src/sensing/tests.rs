//! Dead reckoning over long drives, against an integration in `f64`, in both scalars.

extern crate std;

use std::vec::Vec;

use super::odometry::{Odometry, OdometryParameters};
use crate::config::Config;
use crate::scalar::{Fixed, Scalar};
use crate::testing::{apart, wide};
use crate::units::{EncoderCounts, Pose};
use proptest::prelude::*;

/// The Khepera's: 12 counts per millimetre, wheels 53 mm apart.
const COUNTS_PER_M: f64 = 12_000.0;
const WHEEL_BASE_M: f64 = 0.053;

fn parameters<S: Scalar>() -> OdometryParameters<S> {
    Config::default().build::<S, 12>().expect("the default is valid").reflex.odometry
}

/// x, y and heading.
#[derive(Clone, Copy, Debug)]
struct Exact(f64, f64, f64);

impl Exact {
    fn advance(&mut self, left: i32, right: i32) {
        let turn = f64::from(right - left) / (COUNTS_PER_M * WHEEL_BASE_M);
        let way = f64::from(left + right) / (2.0 * COUNTS_PER_M);
        let mean = self.2 + turn / 2.0;
        *self = Self(self.0 + way * mean.cos(), self.1 + way * mean.sin(), self.2 + turn);
    }
}

fn error<S: Scalar>(pose: Pose<S>, exact: Exact) -> (f64, f64) {
    let distance = (wide(pose.x_m) - exact.0).hypot(wide(pose.y_m) - exact.1);
    (distance, apart(wide(pose.heading_rad), exact.2))
}

/// Drives with constant counts per tick, each for some ticks; the counters start anywhere.
fn a_long_drive_is_followed<S: Scalar>(legs: &[(i8, i8, u16)], first: (i32, i32)) {
    let p = parameters::<S>();
    let mut odometry = Odometry::<S>::default();
    let mut counts = EncoderCounts { left: first.0, right: first.1 };
    let delta = odometry.advance(&p, counts);
    assert_eq!(delta, EncoderCounts::default(), "where the counters start is no motion");
    let mut exact = Exact(0.0, 0.0, 0.0);
    let turned_before = odometry.turn_counts();
    let mut turned = 0;
    for &(left, right, ticks) in legs {
        let (left, right) = (i32::from(left), i32::from(right));
        for _ in 0..ticks {
            counts.left = counts.left.wrapping_add(left);
            counts.right = counts.right.wrapping_add(right);
            assert_eq!(odometry.advance(&p, counts), EncoderCounts { left, right });
            exact.advance(left, right);
            turned += right - left;
        }
    }
    let (distance, turn) = error(odometry.pose(&p), exact);
    assert!(distance < 2e-4, "{} {distance} m off: {:?} {exact:?}", S::NAME, odometry.pose(&p));
    assert!(turn < 1e-4, "{} {turn} rad off", S::NAME);
    assert_eq!(odometry.turn_counts() - turned_before, turned, "the turn is counted without wrapping");
    // A counter that starts anew is no motion.
    let before = odometry.pose(&p);
    odometry.advance(&p, EncoderCounts { left: counts.left.wrapping_add(1 << 20), right: counts.right });
    assert_eq!(odometry.pose(&p), before);
    // A fix replaces what was reckoned, and reckoning goes on from there.
    odometry.fix(Pose { x_m: S::ONE, y_m: S::ZERO, heading_rad: S::ZERO });
    counts.left = counts.left.wrapping_add(1 << 20);
    for _ in 0..100 {
        counts = EncoderCounts { left: counts.left.wrapping_add(2), right: counts.right.wrapping_add(2) };
        odometry.advance(&p, counts);
    }
    let (distance, turn) = error(odometry.pose(&p), Exact(1.0 + 200.0 / COUNTS_PER_M, 0.0, 0.0));
    assert!(distance < 1e-5 && turn < 1e-6, "{distance} {turn}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn long_drives(
        legs in proptest::collection::vec((-4_i8..=4, -4_i8..=4, 1_u16..2000), 1..20),
        first in prop_oneof![
            Just((i32::MAX - 100, i32::MIN + 100)),
            Just((i32::MIN + 50, i32::MAX - 50)),
            (any::<i32>(), any::<i32>()),
        ],
    ) {
        let legs: Vec<_> = legs;
        a_long_drive_is_followed::<f32>(&legs, first);
        a_long_drive_is_followed::<Fixed>(&legs, first);
    }
}
