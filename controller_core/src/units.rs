//! Quantities at the boundaries of the modules: SI units, REP-103 frames, and the one place where angles wrap.
//!
//! World frame: x forward, y left, heading 0 along +x, positive anticlockwise (to the left). Robot frame: the same
//! axes fixed to the body. A **bearing** is an angle from the heading, left positive. Plain fields carry their unit
//! last: `distance_m`, `left_mps`, `heading_rad`.

use crate::scalar::Scalar;

/// Brings an angle that is at most a few turns off into [−π, π).
///
/// Larger magnitudes (a broken sensor) give 0 instead of a long loop.
///
/// ```
/// use controller_core::units::wrap;
/// assert!((wrap(3.5_f32) - (3.5 - core::f32::consts::TAU)).abs() < 1e-6);
/// ```
#[must_use]
pub fn wrap<S: Scalar>(angle_rad: S) -> S {
    if angle_rad.abs() < S::PI { angle_rad } else { turn_back(angle_rad) }
}

/// [`wrap`] where there is something to do; apart, because mostly there is nothing.
#[inline(never)]
fn turn_back<S: Scalar>(angle_rad: S) -> S {
    let mut angle = angle_rad;
    for _ in 0..4 {
        if angle >= S::PI {
            angle -= S::TAU;
        } else if angle < -S::PI {
            angle += S::TAU;
        } else {
            return angle;
        }
    }
    S::ZERO
}

/// The angle from `from_rad` to `to_rad`, in [−π, π). No other file subtracts two angles.
#[must_use]
pub fn angle_between<S: Scalar>(from_rad: S, to_rad: S) -> S {
    wrap(to_rad - from_rad)
}

/// A place seen from the robot: `u = (α, d)` of the papers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Polar<S> {
    /// Bearing α from the heading, left positive, in [−π, π).
    pub bearing_rad: S,
    /// Distance d from the robot's centre.
    pub distance_m: S,
}

/// Position and heading in the world frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Pose<S> {
    /// World x of the robot's centre.
    pub x_m: S,
    /// World y of the robot's centre.
    pub y_m: S,
    /// Heading, anticlockwise from +x, in [−π, π).
    pub heading_rad: S,
}

/// A point; of the world or of the robot frame, as the holder says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct Point<S> {
    /// x coordinate.
    pub x_m: S,
    /// y coordinate.
    pub y_m: S,
}

/// A pair of wheel speeds: the motor control vector `c = (v_l, v_r)` of the papers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct WheelSpeeds<S> {
    /// Speed of the left wheel over ground, forward positive.
    pub left_mps: S,
    /// Speed of the right wheel over ground, forward positive.
    pub right_mps: S,
}

/// What the motors are driven with: a fraction of full drive per wheel, in ±1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct WheelDrive<S> {
    /// Left motor, forward positive.
    pub left: S,
    /// Right motor, forward positive.
    pub right: S,
}

/// Running counts of the two wheel encoders since power-up; they wrap around like the hardware counter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub struct EncoderCounts {
    /// Left wheel, forward positive.
    pub left: i32,
    /// Right wheel, forward positive.
    pub right: i32,
}

impl<S: Scalar> Point<S> {
    /// The point from `f32` metres.
    #[must_use]
    pub fn from_metres(x_m: f32, y_m: f32) -> Self {
        Self { x_m: S::from_f32(x_m), y_m: S::from_f32(y_m) }
    }

    /// Distance to another point of the same frame.
    #[must_use]
    pub fn distance_to(self, other: Self) -> S {
        S::hypot(other.x_m - self.x_m, other.y_m - self.y_m)
    }

    /// The point as seen from the origin of its frame.
    #[must_use]
    pub fn to_polar(self) -> Polar<S> {
        Polar { bearing_rad: S::atan2(self.y_m, self.x_m), distance_m: S::hypot(self.x_m, self.y_m) }
    }
}

impl<S: Scalar> Polar<S> {
    /// The same place in Cartesian coordinates of the robot frame.
    #[must_use]
    pub fn to_point(self) -> Point<S> {
        let (sin, cos) = self.bearing_rad.sin_cos();
        Point { x_m: self.distance_m * cos, y_m: self.distance_m * sin }
    }
}

impl<S: Scalar> Pose<S> {
    /// The position without the heading.
    #[must_use]
    pub fn position(self) -> Point<S> {
        Point { x_m: self.x_m, y_m: self.y_m }
    }

    /// Every field finite and within [`Scalar::LIMIT`], the heading wrapped; what is not becomes 0.
    #[must_use]
    pub fn sanitised(self) -> Self {
        Self {
            x_m: self.x_m.sanitised(),
            y_m: self.y_m.sanitised(),
            heading_rad: wrap(self.heading_rad.sanitised()),
        }
    }

    /// A point of the world in the robot frame, given the sine and cosine of the heading.
    #[must_use]
    pub fn to_robot_frame(self, world: Point<S>, (sin, cos): (S, S)) -> Point<S> {
        let (dx, dy) = (world.x_m - self.x_m, world.y_m - self.y_m);
        Point { x_m: dx * cos + dy * sin, y_m: dy * cos - dx * sin }
    }

    /// A point of the robot frame in the world, given the sine and cosine of the heading.
    #[must_use]
    pub fn to_world_frame(self, robot: Point<S>, (sin, cos): (S, S)) -> Point<S> {
        Point {
            x_m: self.x_m + robot.x_m * cos - robot.y_m * sin,
            y_m: self.y_m + robot.x_m * sin + robot.y_m * cos,
        }
    }

    /// A point of the world as bearing and distance from the robot: `u_p` of the papers.
    #[must_use]
    pub fn see(self, world: Point<S>) -> Polar<S> {
        let (dx, dy) = (world.x_m - self.x_m, world.y_m - self.y_m);
        Polar { bearing_rad: angle_between(self.heading_rad, S::atan2(dy, dx)), distance_m: S::hypot(dx, dy) }
    }
}

impl<S: Scalar> WheelSpeeds<S> {
    /// Both wheels at rest.
    pub const STOP: Self = Self { left_mps: S::ZERO, right_mps: S::ZERO };

    /// Speed of the robot's centre along its heading.
    #[must_use]
    pub fn forward(self) -> S {
        (self.left_mps + self.right_mps) * S::HALF
    }

    /// Each wheel limited to ±`limit_mps` on its own.
    #[must_use]
    pub fn saturated(self, limit_mps: S) -> Self {
        Self {
            left_mps: self.left_mps.clamp(-limit_mps, limit_mps),
            right_mps: self.right_mps.clamp(-limit_mps, limit_mps),
        }
    }
}

#[cfg(test)]
mod tests;
