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

use crate::number::low_word;
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

/// Half turns up to this are rotated by with a Taylor polynomial, whose remainder is below 1e-15; a tick turns by less
/// than half of it.
const SMALL_RAD: f64 = 0.02;

/// Ticks after which the direction is taken from the heading anew; its rounding errors stay below 1e-13 meanwhile.
const DIRECTION_TICKS: u64 = 64;

/// The robot's state.
#[derive(Debug, Clone)]
pub struct Khepera {
    model: KheperaModel,
    pose: TruePose,
    /// Unit vector along the heading: to turn it on costs a fraction of two trigonometric functions.
    direction: Vector2<f64>,
    way_m: f64,
    left: Wheel,
    right: Wheel,
    slip: Stream,
    /// Ticks until the slip is drawn anew.
    slip_ticks: u32,
    ticks: u64,
}

/// Whole counts of a travel, towards −∞ like a quadrature counter; they wrap around like one.
fn whole_counts(travel: f64) -> i32 {
    // Added to this, an f64 has no digits left behind the point, and its lowest bits are the nearest integer.
    const NO_FRACTION: f64 = 6_755_399_441_055_744.0;
    let shifted = travel + NO_FRACTION;
    let nearest = low_word(shifted.to_bits()).cast_signed();
    nearest.wrapping_sub(i32::from(shifted - NO_FRACTION > travel))
}

/// Sine and cosine of half the turn of a tick.
fn half_turn(turn_rad: f64) -> (f64, f64) {
    let half = turn_rad * 0.5;
    if half.abs() > SMALL_RAD {
        return libm::sincos(half);
    }
    let z = half * half;
    let sin = half + half * z * (-1.0 / 6.0 + z * (1.0 / 120.0));
    let cos = 1.0 + z * (-0.5 + z * (1.0 / 24.0 + z * (-1.0 / 720.0)));
    (sin, cos)
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
        let direction = Vector2::x();
        let (left, right) = (Wheel::default(), Wheel::default());
        Self { model, pose, direction, way_m: 0.0, left, right, slip, slip_ticks: 0, ticks: 0 }
    }

    /// One tick under a drive: where the body would go if nothing were in its way. The heading is taken over, the
    /// position is for [`Khepera::place`].
    #[inline(always)]
    pub fn tick(&mut self, drive: WheelDrive<f32>) -> Vector2<f64> {
        if self.slip_ticks == 0 {
            self.slip_ticks = self.model.slip_period_ms;
            self.left.slip = self.slip.symmetric() * self.model.slip;
            self.right.slip = self.slip.symmetric() * self.model.slip;
        }
        self.slip_ticks = self.slip_ticks.wrapping_sub(1);
        if self.ticks.is_multiple_of(DIRECTION_TICKS) {
            let (sin, cos) = libm::sincos(self.pose.heading_rad);
            self.direction = Vector2::new(cos, sin);
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
        // A product, since a processor that divides ahead need not wait for the wheels.
        let turn = (right - left) * (1.0 / model.wheel_base_m);
        let way = (left + right) * 0.5;
        // A tenth of a millimetre and a few milliradians: the chord along the mean heading is the arc.
        let (sin, cos) = half_turn(turn);
        let before = self.direction;
        let mean = Vector2::new(before.x * cos - before.y * sin, before.x * sin + before.y * cos);
        // Turned by the same once more: mean is in the middle.
        self.direction = mean * (2.0 * cos) - before;
        self.pose.heading_rad = wrapped(self.pose.heading_rad + turn);
        self.way_m = way.abs();
        mean * way
    }

    /// Length of what the last tick gave.
    #[must_use]
    pub fn way_m(&self) -> f64 {
        self.way_m
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
    use super::{Khepera, KheperaModel, TruePose, whole_counts};
    use crate::number::narrow;
    use crate::random::{Purpose, Stream};
    use controller_core::config::Config;
    use controller_core::units::WheelDrive;
    use nalgebra::{Point2, Vector2};

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
    fn the_direction_is_that_of_the_heading() {
        // Another wheel base makes a tick turn by more than the polynomial is for.
        for wheel_base_m in [0.053, 0.005] {
            let mut robot = robot(0.1);
            robot.model_mut().wheel_base_m = wheel_base_m;
            let mut draws = Stream::new(1, Purpose::Exploration);
            for tick in 0..20_000 {
                drive(&mut robot, narrow(draws.symmetric()), 1.0, 1);
                let (sin, cos) = robot.pose().heading_rad.sin_cos();
                let apart = (robot.direction - Vector2::new(cos, sin)).norm();
                assert!(apart < 1e-13, "{apart} after {tick} ticks");
            }
        }
    }

    #[test]
    fn counts_are_whole_towards_minus_infinity() {
        for (travel, counts) in
            [(0.0, 0), (0.5, 0), (1.0, 1), (2.999, 2), (-1e-9, -1), (-1.0, -1), (-7.5, -8)]
        {
            assert_eq!(whole_counts(travel), counts, "{travel}");
        }
        assert_eq!(whole_counts(2_147_483_647.5), i32::MAX);
        assert_eq!(whole_counts(2_147_483_648.5), i32::MIN, "as a counter wraps around");
        let mut draws = Stream::new(1, Purpose::Exploration);
        for _ in 0..10_000 {
            let travel = draws.symmetric() * 1e6;
            assert!((f64::from(whole_counts(travel)) - travel.floor()).abs() < f64::EPSILON, "{travel}");
        }
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
