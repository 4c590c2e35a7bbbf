//! Artificial potential field: the target attracts, obstacles repel, and the robot follows the sum.
//!
//! Source: O. Khatib, *Real-Time Obstacle Avoidance for Manipulators and Mobile Robots*, Int. J. of Robotics Research
//! 5(1), 1986. The repulsion is its FIRAS function, `η (1/ρ − 1/ρ₀) / ρ²` away from an obstacle at distance ρ < ρ₀.
//!
//! # Left open, and chosen
//!
//! * **Attraction**: of constant size (the potential grows with the distance, not with its square), since a far target
//!   must not outweigh every obstacle. All gains are relative to it.
//! * **Obstacles**: what each of the twelve sensors sees now is one, ρ the range beyond the body. The field has no
//!   memory.
//! * **A body that cannot move sideways** steers towards the force, see [`super::steering`].
//! * **Swirl**: a share of each repulsion is turned by 90°, to the side on which the target lies (vortex fields: C. De
//!   Medio and G. Oriolo, *Robot Obstacle Avoidance Using Vortex Fields*, 1991). 0 is Khatib's field.

use controller_core::sensing::proximity::sensor_bearing;
use nalgebra::Vector2;

use super::config::numbers;
use super::robot::{PeerRobot, Twist};
use super::steering::Steering;
use super::{Navigator, View};
use crate::proximity_model::SENSORS;

numbers! {
    /// Numbers of the potential field.
    ApfConfig, "apf" {
        /// ρ₀: obstacles farther beyond the body than this do not repel, in m.
        range_m: 0.0457, 0.001 to 20.0, linear(0.01, 0.175);
        /// η, relative to the attraction, in m³.
        repulsion_m3: 2.62e-6, 0.0 to 1.0, log(1e-9, 1e-4);
        /// Share of the repulsion that goes around the obstacle.
        swirl: 1.76, 0.0 to 100.0, linear(0.0, 2.0);
        /// Speed where nothing is near, as a share of c*.
        cruise_share: 0.526, 0.01 to 1.0, linear(0.3, 1.0);
        /// Time that the free way ahead must last, in s.
        headway_s: 1.03, 0.0 to 100.0, linear(0.1, 1.5);
        /// What the way ahead must leave free beside the body, in m.
        margin_m: 0.00373, 0.0 to 1.0, linear(0.0, 0.01);
        /// Within this distance of the body the speed falls, in m.
        near_m: 0.001, 0.0001 to 20.0, log(0.001, 0.1);
        /// Beyond this bearing of the force the robot turns on the spot, in rad.
        spot_rad: 1.4, 0.01 to 3.2, linear(0.3, 1.57);
        /// Time constant of the turn towards the force, in s.
        turn_time_s: 0.394, 0.01 to 10.0, linear(0.13, 0.6);
        /// Directions beyond this bearing are taken backwards, in rad.
        back_rad: 2.94, 0.0 to 3.2, linear(1.57, 3.2);
        /// How long a point is remembered that is not seen again, in s.
        memory_s: 0.952, 0.0 to 600.0, log(0.2, 20.0);
    }
}

/// Ranges below this repel no more, in m: half of what the sensors resolve.
const NEAREST_M: f64 = 0.0025;

/// The potential field; it has no state.
#[derive(Debug, Clone)]
pub struct PotentialField {
    robot: PeerRobot,
    steering: Steering,
    config: ApfConfig,
}

impl PotentialField {
    /// A field for a robot.
    #[must_use]
    pub fn new(robot: PeerRobot, config: ApfConfig) -> Self {
        Self {
            robot,
            steering: Steering {
                cruise_share: config.cruise_share,
                headway_s: config.headway_s,
                near_m: config.near_m,
                margin_m: config.margin_m,
                spot_rad: config.spot_rad,
                turn_time_s: config.turn_time_s,
                back_rad: config.back_rad,
            },
            config,
        }
    }

    /// The sum of attraction (of size 1) and repulsions, robot frame.
    fn force(&self, view: &View) -> Vector2<f64> {
        let (sin, cos) = libm::sincos(view.target.bearing_rad);
        let attraction = Vector2::new(cos, sin);
        let mut force = attraction;
        for (sensor, distance) in view.ranges.iter().enumerate() {
            let Some(distance) = distance else { continue };
            let range = (distance - self.robot.body_radius_m).max(NEAREST_M);
            if range >= self.config.range_m {
                continue;
            }
            let size = self.config.repulsion_m3 * (1.0 / range - 1.0 / self.config.range_m) / (range * range);
            let (sin, cos) = libm::sincos(f64::from(sensor_bearing::<f32>(sensor, SENSORS)));
            let away = -Vector2::new(cos, sin);
            let side = if away.perp(&attraction) < 0.0 { -1.0 } else { 1.0 };
            force += (away + Vector2::new(-away.y, away.x) * (side * self.config.swirl)) * size;
        }
        force
    }
}

impl Navigator for PotentialField {
    fn decide(&mut self, view: &View) -> Twist {
        let force = self.force(view);
        self.steering.towards(&self.robot, view, libm::atan2(force.y, force.x))
    }

    fn reset(&mut self) {}

    fn memory_s(&self) -> f64 {
        self.config.memory_s
    }
}

#[cfg(test)]
mod tests {
    use super::{ApfConfig, PotentialField};
    use crate::peers::testing::{ROBOT, view};

    #[test]
    fn an_obstacle_pushes_away_within_its_range_only() {
        let config = ApfConfig { swirl: 0.0, ..ApfConfig::default() };
        let field = PotentialField::new(ROBOT, config.clone());
        let force = |range_m: f64| {
            let mut ranges = [None; 12];
            // To the left, with the target straight ahead.
            ranges[3] = Some(ROBOT.body_radius_m + range_m);
            field.force(&view(&ranges, &[], 0.0))
        };
        assert!((force(config.range_m).norm() - 1.0).abs() < 1e-12, "the attraction alone");
        let (far, near) = (force(0.8 * config.range_m), force(0.4 * config.range_m));
        assert!(near.y < far.y && far.y < 0.0, "to the right, the more the nearer: {far:?}, {near:?}");
        let range: f64 = 0.4 * config.range_m;
        let expected = config.repulsion_m3 * (1.0 / range - 1.0 / config.range_m) / (range * range);
        assert!((near.y + expected).abs() < 1e-6 && (near.x - 1.0).abs() < 1e-6, "{near:?}");
    }
}
