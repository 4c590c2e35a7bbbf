//! What the tests of the peers share.

use nalgebra::Point2;

use super::robot::{PeerRobot, Twist};
use super::{Target, View};
use crate::proximity_model::SENSORS;

/// A Khepera.
pub const ROBOT: PeerRobot = PeerRobot {
    body_radius_m: 0.025,
    wheel_base_m: 0.053,
    speed_limit_mps: 0.16,
    acceleration_mps2: 1.5,
    reach_m: 0.2,
    period_s: 0.128,
};

/// A robot at rest in the origin with a target 1 m away.
pub fn view<'a>(ranges: &'a [Option<f64>; SENSORS], points: &'a [Point2<f64>], bearing_rad: f64) -> View<'a> {
    let (sin, cos) = libm::sincos(bearing_rad);
    View {
        position: Point2::origin(),
        heading_rad: 0.0,
        target: Target { position: Point2::new(cos, sin), bearing_rad, distance_m: 1.0 },
        ranges,
        points,
        speed: Twist::STOP,
    }
}
