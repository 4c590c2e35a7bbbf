//! The robot as peers know it: its exact measures, and how it moves.

use core::f64::consts::{PI, TAU};

use controller_core::config::Config;
use controller_core::units::WheelSpeeds;
use nalgebra::{Point2, Vector2};

use crate::number::narrow;

/// Measures of the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeerRobot {
    /// Radius of the body in m.
    pub body_radius_m: f64,
    /// Distance between the wheels in m.
    pub wheel_base_m: f64,
    /// c*: largest speed of a wheel in m/s.
    pub speed_limit_mps: f64,
    /// Largest acceleration of a wheel in m/s².
    pub acceleration_mps2: f64,
    /// Range of the sensors from the robot's centre in m.
    pub reach_m: f64,
    /// Time between two decisions in s.
    pub period_s: f64,
}

impl PeerRobot {
    /// The robot of a configuration.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        let robot = &config.robot;
        Self {
            body_radius_m: robot.body_radius_m.into(),
            wheel_base_m: robot.wheel_base_m.into(),
            speed_limit_mps: robot.speed_limit_mps.into(),
            acceleration_mps2: config.servo.acceleration_mps2.into(),
            reach_m: f64::from(robot.body_radius_m) + f64::from(robot.sensor_range_m),
            period_s: f64::from(config.schedule.avoidance_period_ms) / 1000.0,
        }
    }

    /// Fastest turn on the spot in rad/s.
    #[must_use]
    pub fn turn_limit_radps(&self) -> f64 {
        2.0 * self.speed_limit_mps / self.wheel_base_m
    }
}

/// Motion of the body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Twist {
    /// Speed of the centre along the heading in m/s.
    pub forward_mps: f64,
    /// Anticlockwise turn in rad/s.
    pub turn_radps: f64,
}

impl Twist {
    /// Standing still.
    pub const STOP: Self = Self { forward_mps: 0.0, turn_radps: 0.0 };

    /// From the speeds of the wheels.
    #[must_use]
    pub fn of_wheels(wheels: WheelSpeeds<f32>, robot: &PeerRobot) -> Self {
        let (left, right) = (f64::from(wheels.left_mps), f64::from(wheels.right_mps));
        Self { forward_mps: f64::midpoint(left, right), turn_radps: (right - left) / robot.wheel_base_m }
    }

    /// The speeds of the wheels; where one would be beyond c*, the turn is kept and the way shortened.
    #[must_use]
    pub fn wheels(self, robot: &PeerRobot) -> WheelSpeeds<f32> {
        let limit = robot.speed_limit_mps;
        let half = (self.turn_radps * robot.wheel_base_m / 2.0).clamp(-limit, limit);
        let room = limit - half.abs();
        let forward = self.forward_mps.clamp(-room, room);
        WheelSpeeds { left_mps: narrow(forward - half), right_mps: narrow(forward + half) }
    }
}

/// The turn from one direction to another, in ±π rad.
#[must_use]
pub fn turn(from_rad: f64, to_rad: f64) -> f64 {
    let angle = to_rad - from_rad;
    angle - TAU * libm::floor((angle + PI) / TAU)
}

/// How far a disc of this radius can go straight along a bearing before it meets one of the points (robot frame), in m;
/// at most `farthest_m`. A point that is inside the disc blocks the ways that lead nearer to it.
#[must_use]
pub fn free_way(points: &[Point2<f64>], bearing_rad: f64, radius_m: f64, farthest_m: f64) -> f64 {
    let (sin, cos) = libm::sincos(bearing_rad);
    let direction = Vector2::new(cos, sin);
    let mut free = farthest_m;
    for point in points {
        let along = point.coords.dot(&direction);
        let aside = point.coords.perp(&direction).abs();
        if along > 0.0 && aside < radius_m {
            let until = along - libm::sqrt(radius_m * radius_m - aside * aside);
            free = free.min(until.max(0.0));
        }
    }
    free
}

#[cfg(test)]
mod tests {
    use super::{PeerRobot, Twist, free_way};
    use controller_core::config::Config;
    use nalgebra::Point2;

    #[test]
    fn wheels_keep_the_turn_and_the_limit() {
        let robot = PeerRobot::new(&Config::default());
        let twist = Twist { forward_mps: 0.16, turn_radps: 2.0 };
        let wheels = twist.wheels(&robot);
        let back = Twist::of_wheels(wheels, &robot);
        assert!((back.turn_radps - 2.0).abs() < 1e-6, "{back:?}");
        assert!((wheels.right_mps - 0.16).abs() < 1e-6 && wheels.left_mps < 0.16, "{wheels:?}");
        let spin = Twist { forward_mps: 0.1, turn_radps: -100.0 }.wheels(&robot);
        assert!((spin.left_mps - 0.16).abs() < 1e-6 && (spin.right_mps + 0.16).abs() < 1e-6, "{spin:?}");
    }

    #[test]
    fn a_disc_goes_as_far_as_its_edge_lets_it() {
        let points = [Point2::new(0.1, 0.03), Point2::new(-0.2, 0.0), Point2::new(0.01, 0.04)];
        // 3-4-5: the disc of 5 cm touches the point 3 cm aside when its centre is 4 cm before it.
        let free = free_way(&points[..1], 0.0, 0.05, 1.0);
        assert!((free - 0.06).abs() < 1e-12, "{free}");
        assert!((free_way(&points, 0.0, 0.02, 1.0) - 1.0).abs() < 1e-12, "it passes below");
        assert!(free_way(&points, 0.0, 0.05, 1.0) <= 0.0, "the third point is inside the disc and ahead");
        let away = -core::f64::consts::FRAC_PI_2;
        assert!((free_way(&points[2..], away, 0.05, 1.0) - 1.0).abs() < 1e-12, "but it can leave");
    }
}
