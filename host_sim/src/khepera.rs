//! The simulated Khepera: motors, encoders, wheels on the ground. No controller, no world.
//!
//! ```text
//! drive ──► motor (first order) ──► wheel ──► encoder counts
//!                                     └─ slip (actuator noise) ──► pose
//! ```
//!
//! Actuator noise is slip between wheel and ground: the encoders do not see it, so the servo cannot take it out, and
//! only the learnt map and the pose fixes can. It is white in steps of [`KheperaModel::slip_period_ms`].

use controller_core::config::{RobotConfig, ServoConfig};
use controller_core::units::{EncoderCounts, WheelDrive};
use nalgebra::{Point2, Vector2};

use crate::random::Stream;

/// Length of a tick in s.
pub const TICK_S: f64 = 0.001;

/// How a wheel and its motor differ from what they should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelModel {
    /// Radius as a share of the right one. Encoders count turns, so they do not see it.
    pub radius_share: f64,
    /// Speed of the free motor as a share of the right one.
    pub motor_share: f64,
}

impl WheelModel {
    /// As it should be.
    pub const SOUND: Self = Self { radius_share: 1.0, motor_share: 1.0 };
}

/// The physical robot. It takes its numbers from the controller's configuration unless an experiment makes the two
/// differ.
#[derive(Debug, Clone, PartialEq)]
pub struct KheperaModel {
    /// Radius of the body in m.
    pub body_radius_m: f64,
    /// Distance between the wheels' points of contact in m.
    pub wheel_base_m: f64,
    /// Speed of a free wheel at full drive in m/s.
    pub free_speed_mps: f64,
    /// Time constant of motor and gear in s.
    pub motor_time_constant_s: f64,
    /// Encoder counts per metre of wheel travel.
    pub encoder_counts_per_m: f64,
    /// Range of the sensors beyond the body in m.
    pub sensor_range_m: f64,
    /// Slip: each wheel's way over ground is its own way times 1 ± this.
    pub slip: f64,
    /// How long a draw of the slip lasts, in ms.
    pub slip_period_ms: u32,
    /// The left wheel.
    pub left: WheelModel,
    /// The right wheel.
    pub right: WheelModel,
}

impl KheperaModel {
    /// The robot that a configuration describes, with the given slip.
    #[must_use]
    pub fn new(robot: &RobotConfig, servo: &ServoConfig, slip: f64) -> Self {
        Self {
            body_radius_m: f64::from(robot.body_radius_m),
            wheel_base_m: f64::from(robot.wheel_base_m),
            free_speed_mps: f64::from(servo.free_speed_mps),
            motor_time_constant_s: 0.02,
            encoder_counts_per_m: f64::from(robot.encoder_counts_per_m),
            sensor_range_m: f64::from(robot.sensor_range_m),
            slip,
            slip_period_ms: 64,
            left: WheelModel::SOUND,
            right: WheelModel::SOUND,
        }
    }
}

/// Position and heading, exact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TruePose {
    /// Centre of the body.
    pub position: Point2<f64>,
    /// Heading in rad, within ±π.
    pub heading_rad: f64,
}

/// A wheel with its motor.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Wheel {
    speed_mps: f64,
    /// Travel since start in counts, with its fraction.
    travel_counts: f64,
    slip: f64,
}

/// The robot's state.
#[derive(Debug, Clone)]
pub struct Khepera {
    model: KheperaModel,
    pose: TruePose,
    left: Wheel,
    right: Wheel,
    slip: Stream,
    ticks: u64,
}

/// Whole counts of a travel, towards −∞ like a quadrature counter.
#[allow(clippy::cast_possible_truncation, reason = "2^31 counts are 179 km; the cast saturates there")]
fn whole_counts(travel: f64) -> i32 {
    travel.floor() as i32
}

/// Brings an angle into ±π.
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    use core::f64::consts::{PI, TAU};
    if angle_rad >= PI {
        angle_rad - TAU
    } else if angle_rad < -PI {
        angle_rad + TAU
    } else {
        angle_rad
    }
}

impl Khepera {
    /// A robot at rest.
    #[must_use]
    pub fn new(model: KheperaModel, pose: TruePose, slip: Stream) -> Self {
        Self { model, pose, left: Wheel::default(), right: Wheel::default(), slip, ticks: 0 }
    }

    /// One tick under a drive: where the body would go if nothing were in its way. The heading is taken over, the
    /// position is for [`Khepera::place`].
    pub fn tick(&mut self, drive: WheelDrive<f32>) -> Vector2<f64> {
        if self.ticks.is_multiple_of(u64::from(self.model.slip_period_ms)) {
            self.left.slip = self.slip.symmetric() * self.model.slip;
            self.right.slip = self.slip.symmetric() * self.model.slip;
        }
        self.ticks += 1;
        let model = &self.model;
        let gain = TICK_S / model.motor_time_constant_s;
        let roll = |wheel: &mut Wheel, of: WheelModel, drive: f32| {
            let free_speed_mps = model.free_speed_mps * of.motor_share;
            wheel.speed_mps += (f64::from(drive) * free_speed_mps - wheel.speed_mps) * gain;
            let way = wheel.speed_mps * TICK_S;
            wheel.travel_counts += way * model.encoder_counts_per_m;
            way * of.radius_share * (1.0 + wheel.slip)
        };
        let left = roll(&mut self.left, model.left, drive.left);
        let right = roll(&mut self.right, model.right, drive.right);
        let turn = (right - left) / model.wheel_base_m;
        let way = f64::midpoint(left, right);
        // A tenth of a millimetre and a few milliradians: the chord along the mean heading is the arc.
        let (sin, cos) = libm::sincos(self.pose.heading_rad + turn * 0.5);
        self.pose.heading_rad = wrapped(self.pose.heading_rad + turn);
        Vector2::new(way * cos, way * sin)
    }

    /// Puts the body where the world lets it.
    pub fn place(&mut self, position: Point2<f64>) {
        self.pose.position = position;
    }

    /// The pose.
    #[must_use]
    pub fn pose(&self) -> TruePose {
        self.pose
    }

    /// What the encoders say.
    #[must_use]
    pub fn encoders(&self) -> EncoderCounts {
        EncoderCounts {
            left: whole_counts(self.left.travel_counts),
            right: whole_counts(self.right.travel_counts),
        }
    }

    /// The physical robot.
    #[must_use]
    pub fn model(&self) -> &KheperaModel {
        &self.model
    }

    /// Changes the physical robot under way, as wear or damage do.
    pub fn model_mut(&mut self) -> &mut KheperaModel {
        &mut self.model
    }
}

#[cfg(test)]
mod tests {
    use super::{Khepera, KheperaModel, TruePose};
    use crate::random::{Purpose, Stream};
    use controller_core::config::Config;
    use controller_core::units::WheelDrive;
    use nalgebra::Point2;

    fn robot(slip: f64) -> Khepera {
        let config = Config::default();
        let model = KheperaModel::new(&config.robot, &config.servo, slip);
        let pose = TruePose { position: Point2::origin(), heading_rad: 0.0 };
        Khepera::new(model, pose, Stream::new(1, Purpose::Slip))
    }

    fn drive(robot: &mut Khepera, left: f32, right: f32, ticks: u32) {
        for _ in 0..ticks {
            let way = robot.tick(WheelDrive { left, right });
            robot.place(robot.pose().position + way);
        }
    }

    #[test]
    fn goes_straight_turns_on_the_spot_and_counts() {
        let mut straight = robot(0.0);
        drive(&mut straight, 0.4, 0.4, 1000);
        // 0.1 m/s for a second, less the motor's lag: its 20 ms in steps of 1 ms add up to 19.
        assert!((straight.pose().position.x - 0.0981).abs() < 1e-6, "{:?}", straight.pose());
        assert!(straight.pose().position.y.abs() < 1e-12);
        assert!((f64::from(straight.encoders().left) - 1177.0).abs() < 2.0);

        let mut spin = robot(0.0);
        drive(&mut spin, -0.4, 0.4, 400);
        let expected = 2.0 * 0.1 * (0.4 - 0.019) / 0.053;
        assert!((spin.pose().heading_rad - expected).abs() < 2e-3, "{:?}", spin.pose());
        assert!(spin.pose().position.coords.norm() < 1e-9);
        assert!(spin.encoders().left < 0 && spin.encoders().right > 0);
    }

    #[test]
    fn slip_moves_the_body_but_not_the_encoders() {
        let (mut sure, mut slipping) = (robot(0.0), robot(0.1));
        drive(&mut sure, 0.5, 0.4, 2000);
        drive(&mut slipping, 0.5, 0.4, 2000);
        assert_eq!(sure.encoders(), slipping.encoders());
        let apart = (sure.pose().position - slipping.pose().position).norm();
        assert!(apart > 1e-4 && apart < 0.03, "{apart}");
    }
}
