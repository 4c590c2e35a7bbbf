//! The coordinates of the map: bearing in radians, distance in units of the reach of one step.
//!
//! *Open in the papers*: α and d have different scales. We divide d by the **reach** d₀ = c* · step, the longest way
//! of one training step, and commands by c*: every weight is then of order 1, the gradient of Eq. 8 is
//! well-conditioned (with d in metres the mean positioning error was 646 mm instead of 3 mm in a prototype), and
//! 16 bits store a weight.
//!
//! **Behind the robot**: the map is a chart of bearings within ±90° and *signed* distances. A near place behind, such
//! as a target just overshot, is `(α ± π, −d)`: the linear `c = M u` of a place ahead continues through d = 0 into
//! driving backwards, whereas at α = 180° no `M` without a bias could say "both wheels back". Farther places behind
//! are turned towards first (see [`crate::motor_control::Aim`]).

use crate::scalar::Scalar;
use crate::units::{Polar, WheelSpeeds, angle_between, wrap};

/// How far behind the robot the map reaches, as a share of the reach.
///
/// Chosen because overshooting a target by more than 4 cm does not happen, and every row spent behind is missing
/// ahead.
pub const BEHIND_SHARE: f32 = 0.25;

/// Which places the map has coordinates for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Chart {
    /// Bearings within ±90° and signed distances, see the module docs.
    #[default]
    Signed,
    /// Bearings of the full circle and distances from 0 on: the papers' literal form.
    Unsigned,
}

impl Chart {
    /// The coordinates of a place that is given with a distance ≥ 0 and a bearing of the full circle.
    #[must_use]
    pub fn coordinates<S: Scalar>(self, place: Features<S>) -> Features<S> {
        match self {
            Self::Signed => place.folded(),
            Self::Unsigned => place,
        }
    }

    /// Half of the bearings that the map spans (rad), and its least distance (features).
    pub(crate) fn bounds<S: Scalar>(self) -> (S, S) {
        match self {
            Self::Signed => (S::PI * S::HALF, -S::from_f32(BEHIND_SHARE)),
            Self::Unsigned => (S::PI, S::ZERO),
        }
    }
}

/// How far beyond ±90° a bearing still counts as ahead: far above the rounding of either scalar.
pub(super) const STRAIGHT_ASIDE_RAD: f32 = 1e-3;

/// A place in the coordinates of the map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Features<S> {
    /// Bearing α (rad).
    pub bearing: S,
    /// Distance d in units of the reach; negative for a place behind, see the module docs.
    pub distance: S,
}

impl<S: Scalar> Features<S> {
    /// The same place with a distance ≥ 0 and a bearing of the full circle, as sensors give it.
    #[must_use]
    pub fn unfolded(self) -> Self {
        if self.distance < S::ZERO {
            Self { bearing: wrap(self.bearing + S::PI), distance: -self.distance }
        } else {
            self
        }
    }

    /// The same place with a bearing within ±90° and a signed distance, as the map holds it.
    ///
    /// Straight aside is ahead: a sensor looks there, and rounding must not put the obstacle it sees on the right
    /// behind and the one on the left ahead.
    #[must_use]
    pub fn folded(self) -> Self {
        if self.bearing.abs() > S::PI * S::HALF + S::from_f32(STRAIGHT_ASIDE_RAD) {
            Self { bearing: wrap(self.bearing + S::PI), distance: -self.distance }
        } else {
            self
        }
    }

    /// The same place with a bearing that differs by less than half a turn from `reference_rad`, so that a linear
    /// map around the reference applies to it.
    #[must_use]
    pub fn unwrapped_around(self, reference_rad: S) -> Self {
        Self { bearing: reference_rad + angle_between(reference_rad, self.bearing), ..self }
    }
}

/// A motor command in units of c* per wheel: `left`, `right` within ±1 where it is realisable.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Command<S> {
    /// Left wheel.
    pub left: S,
    /// Right wheel.
    pub right: S,
}

impl<S: Scalar> Command<S> {
    /// `−c* ≤ c ≤ c*` for each wheel (P1 Eq. 5).
    #[must_use]
    pub fn is_realisable(self) -> bool {
        self.left.abs() <= S::ONE && self.right.abs() <= S::ONE
    }

    /// Both wheels scaled by one factor so that neither exceeds c*: the curvature stays, which saturating each
    /// wheel would lose (P1, below Eq. 5).
    #[must_use]
    pub fn scaled_to_limit(self) -> Self {
        let largest = self.left.abs().max(self.right.abs());
        if largest > S::ONE {
            let command = Self { left: self.left / largest, right: self.right / largest };
            // A division that rounded up must not leave the range.
            command.saturated()
        } else {
            self
        }
    }

    /// Each wheel limited to ±1 on its own.
    #[must_use]
    pub fn saturated(self) -> Self {
        Self { left: self.left.clamp(-S::ONE, S::ONE), right: self.right.clamp(-S::ONE, S::ONE) }
    }
}

/// Converts between SI units and the map's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling<S> {
    reach_m: S,
    per_reach: S,
    speed_limit_mps: S,
    per_speed: S,
}

impl<S: Scalar> Scaling<S> {
    /// The scaling for a robot of top speed `speed_limit_mps` (c*) and a training step of `step_s`.
    #[must_use]
    pub fn new(speed_limit_mps: f32, step_s: f32) -> Self {
        let reach = speed_limit_mps * step_s;
        Self {
            reach_m: S::from_f32(reach),
            per_reach: S::from_f32(1.0 / reach),
            speed_limit_mps: S::from_f32(speed_limit_mps),
            per_speed: S::from_f32(1.0 / speed_limit_mps),
        }
    }

    /// A place in SI units as features.
    #[must_use]
    pub fn features(&self, place: Polar<S>) -> Features<S> {
        Features { bearing: place.bearing_rad, distance: place.distance_m * self.per_reach }
    }

    /// Features as a place in SI units.
    #[must_use]
    pub fn place(&self, features: Features<S>) -> Polar<S> {
        Polar { bearing_rad: features.bearing, distance_m: features.distance * self.reach_m }
    }

    /// Wheel speeds in units of c*.
    #[must_use]
    pub fn command(&self, speeds: WheelSpeeds<S>) -> Command<S> {
        Command { left: speeds.left_mps * self.per_speed, right: speeds.right_mps * self.per_speed }
    }

    /// A command as wheel speeds.
    #[must_use]
    pub fn speeds(&self, command: Command<S>) -> WheelSpeeds<S> {
        WheelSpeeds {
            left_mps: command.left * self.speed_limit_mps,
            right_mps: command.right * self.speed_limit_mps,
        }
    }

    /// The longest way of one training step, in metres.
    #[must_use]
    pub fn reach_m(&self) -> S {
        self.reach_m
    }
}
