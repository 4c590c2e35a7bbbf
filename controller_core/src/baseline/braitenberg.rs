//! Obstacle avoidance as a Braitenberg vehicle of type 3C: `c_o = Z u_o` (P1 Eq. 9).
//!
//! `u_o` is how near each sensor sees something, 0 at the avoidance range and 1 at the body. Forward-facing sensors
//! of one side act on the motor of the *other* side with large negative weights, all other elements are small and
//! positive (P1, section 2.4), so that an obstacle in front on the left turns the robot right.
//!
//! *Open in the papers*: the elements of Z, and from where on an obstacle counts (the Khepera's own sensors see a few
//! centimetres). [`Wiring::symmetric`] is the literal reading;
//! [`Wiring::asymmetric`] breaks the tie of an obstacle straight ahead by turning on the spot.

use crate::kohonen::features::Command;
use crate::scalar::Scalar;
use crate::sensing::proximity::{Scan, sensor_bearing};

/// How strongly and from where on the vehicle avoids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AvoidanceParameters<S> {
    /// Obstacles farther than this beyond the body do not count (m).
    pub range_m: S,
    /// 1 / range (per m).
    pub per_range: S,
    /// Factor on Z.
    pub gain: S,
}

/// The matrix Z, per sensor the effect on the left and on the right motor, in units of c*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wiring<S, const SENSORS: usize> {
    effect: [Command<S>; SENSORS],
}

/// Where a sensor looks, for the wiring.
enum Direction {
    Ahead,
    FrontLeft,
    FrontRight,
    Behind,
}

fn direction(bearing_rad: f32) -> Direction {
    let quarter_turn = core::f32::consts::FRAC_PI_2 + 1e-3;
    if bearing_rad.abs() < 1e-3 {
        Direction::Ahead
    } else if bearing_rad.abs() > quarter_turn {
        Direction::Behind
    } else if bearing_rad > 0.0 {
        Direction::FrontLeft
    } else {
        Direction::FrontRight
    }
}

impl<S: Scalar, const SENSORS: usize> Wiring<S, SENSORS> {
    fn from_effects(ahead: (f32, f32), inner: f32, outer: f32, behind: f32) -> Self {
        let effect = core::array::from_fn(|sensor| {
            let (left, right) = match direction(sensor_bearing::<f32>(sensor, SENSORS)) {
                Direction::Ahead => ahead,
                // Seen on the left: the right motor slows down.
                Direction::FrontLeft => (outer, inner),
                Direction::FrontRight => (inner, outer),
                Direction::Behind => (behind, behind),
            };
            Command { left: S::from_f32(left), right: S::from_f32(right) }
        });
        Self { effect }
    }

    /// The literal reading: a sensor straight ahead slows both motors alike.
    #[must_use]
    pub fn symmetric() -> Self {
        Self::from_effects((-0.2, -0.2), -0.2, 0.05, 0.02)
    }

    /// A sensor straight ahead turns the robot on the spot; the strongest of 893 wirings that a prototype drew.
    #[must_use]
    pub fn asymmetric() -> Self {
        Self::from_effects((-0.3, 0.15), -0.3, 0.2, 0.02)
    }

    /// The command `c_o` for a scan; `None` where nothing is near enough to avoid.
    #[must_use]
    pub fn avoid(&self, p: &AvoidanceParameters<S>, scan: &Scan<S, SENSORS>) -> Option<Command<S>> {
        let mut command = Command { left: S::ZERO, right: S::ZERO };
        let mut seen = false;
        for (range, effect) in scan.range_m.iter().zip(&self.effect) {
            let Some(range) = range.filter(|range| *range < p.range_m) else { continue };
            seen = true;
            let nearness = (S::ONE - range.max(S::ZERO) * p.per_range) * p.gain;
            command.left += nearness * effect.left;
            command.right += nearness * effect.right;
        }
        seen.then_some(command)
    }
}

#[cfg(test)]
mod tests {
    use super::{AvoidanceParameters, Wiring};
    use crate::scalar::{Fixed, Scalar};
    use crate::sensing::proximity::Scan;

    fn check<S: Scalar>() {
        let s = S::from_f32;
        let p = AvoidanceParameters { range_m: s(0.175), per_range: s(1.0 / 0.175), gain: s(4.0) };
        let seeing = |sensor: usize| {
            let mut scan = Scan::<S, 12>::EMPTY;
            scan.range_m[sensor] = Some(s(0.05));
            scan
        };
        for wiring in [Wiring::<S, 12>::symmetric(), Wiring::asymmetric()] {
            assert_eq!(wiring.avoid(&p, &Scan::EMPTY), None);
            let left = wiring.avoid(&p, &seeing(1)).unwrap();
            assert!(
                left.right < S::ZERO && left.left > S::ZERO,
                "an obstacle on the left turns right: {left:?}"
            );
            let right = wiring.avoid(&p, &seeing(11)).unwrap();
            assert_eq!((right.left, right.right), (left.right, left.left), "mirrored");
            let behind = wiring.avoid(&p, &seeing(6)).unwrap();
            assert!(behind.left > S::ZERO && behind.left == behind.right, "driven on: {behind:?}");
        }
        let ahead = Wiring::<S, 12>::symmetric().avoid(&p, &seeing(0)).unwrap();
        assert_eq!(ahead.left, ahead.right, "the tie that traps it");
    }

    #[test]
    fn turns_away_from_what_it_sees() {
        check::<f32>();
        check::<Fixed>();
    }
}
