//! Where the robot is: encoder counts carry the pose from one fix to the next.
//!
//! The pose comes from outside (`fix`, as in the papers' experiments) or from the encoders alone. Between fixes the
//! way is summed in **counts** since an anchor pose: in metres, fixed point would round each count of 83 µm by up to
//! half a percent, always the same way.

use crate::scalar::Scalar;
use crate::units::{EncoderCounts, Pose, wrap};

/// The robot's geometry as the encoders see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryParameters<S> {
    /// Counts of both wheels together for 5 cm of way. Not for a metre or a decimetre, since with 12 counts per
    /// millimetre those leave the range of fixed point; to divide by, since metres per count would be rounded by up
    /// to a percent.
    pub half_counts_per_5_cm: S,
    /// Counts of difference between the wheels for one radian of heading.
    pub counts_per_radian: S,
}

/// The state of dead reckoning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Odometry<S> {
    anchor: Pose<S>,
    /// Way since the anchor, in half counts of world x and y (sum of both wheels).
    way_x: S,
    way_y: S,
    /// Right minus left counts since the anchor.
    turn: i32,
    /// Right minus left counts since power-up: the heading without wrapping.
    turn_total: i32,
    heading_rad: S,
    last: Option<EncoderCounts>,
}

/// Way (half counts) and turn (counts) after which the anchor moves along: keeps the sums far from saturation.
const ANCHOR_WAY_HALF_COUNTS: i32 = 512;
const ANCHOR_TURN_COUNTS: i32 = 1024;

impl<S: Scalar> Odometry<S> {
    /// The counts since the last call, also across a wrap-around of the counters; none at the first call.
    ///
    /// More than 2¹⁵ counts in one tick are no motion but a reset of the counters, and count as none.
    // On a host only, see `controller::tick`.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn advance(&mut self, p: &OdometryParameters<S>, counts: EncoderCounts) -> EncoderCounts {
        let last = self.last.replace(counts).unwrap_or(counts);
        let moved = |now: i32, before: i32| {
            let difference = now.wrapping_sub(before);
            if difference.unsigned_abs() < 1 << 15 { difference } else { 0 }
        };
        let delta =
            EncoderCounts { left: moved(counts.left, last.left), right: moved(counts.right, last.right) };
        // One test of both: which wheel has counted in a tick is hard to predict.
        if delta.left | delta.right != 0 {
            self.integrate(p, delta);
        }
        delta
    }

    // On a host only, see `controller::tick`.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn integrate(&mut self, p: &OdometryParameters<S>, delta: EncoderCounts) {
        let turned = delta.right - delta.left;
        let before = self.heading_rad;
        self.turn += turned;
        self.turn_total = self.turn_total.wrapping_add(turned);
        self.heading_rad = wrap(self.anchor.heading_rad + S::from_i32(self.turn) / p.counts_per_radian);
        // The chord of a tick points along the mean heading.
        let half_turn = crate::units::angle_between(before, self.heading_rad) * S::HALF;
        let (sin, cos) = wrap(before + half_turn).sin_cos();
        let way = S::from_i32(delta.left + delta.right);
        self.way_x += way * cos;
        self.way_y += way * sin;
        let far = S::from_i32(ANCHOR_WAY_HALF_COUNTS);
        if self.way_x.abs() > far || self.way_y.abs() > far || self.turn.abs() > ANCHOR_TURN_COUNTS {
            self.anchor_at(self.pose(p));
        }
    }

    fn anchor_at(&mut self, pose: Pose<S>) {
        self.anchor = pose;
        self.heading_rad = pose.heading_rad;
        self.way_x = S::ZERO;
        self.way_y = S::ZERO;
        self.turn = 0;
    }

    /// Takes over a pose measured from outside; values that are no numbers become 0.
    pub fn fix(&mut self, pose: Pose<S>) {
        self.anchor_at(pose.sanitised());
    }

    /// The pose now.
    #[must_use]
    pub fn pose(&self, p: &OdometryParameters<S>) -> Pose<S> {
        let five_cm = S::from_f32(0.05);
        let metres = |half_counts: S| half_counts / p.half_counts_per_5_cm * five_cm;
        Pose {
            x_m: self.anchor.x_m + metres(self.way_x),
            y_m: self.anchor.y_m + metres(self.way_y),
            heading_rad: self.heading_rad,
        }
    }

    /// Running count of heading change; the difference of two values is a turn without wrapping.
    #[must_use]
    pub fn turn_counts(&self) -> i32 {
        self.turn_total
    }
}
