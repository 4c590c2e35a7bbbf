//! From a direction to a motion: how a differential drive follows what potential field, VFH+ and Bug2 decide.
//!
//! The robot turns towards the direction and drives on as far as it looks there, no faster than the free way ahead
//! allows. Where a direction behind is allowed to be taken backwards, it is: the ring of sensors looks there as well.

use core::f64::consts::PI;

use super::View;
use super::robot::{PeerRobot, Twist, free_way, turn};

/// The numbers of steering, as a peer's group has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steering {
    /// Speed where nothing is near, as a share of c*.
    pub cruise_share: f64,
    /// Time that the free way ahead must last, in s.
    pub headway_s: f64,
    /// Within this distance of the body the speed falls, to a quarter at contact, in m.
    pub near_m: f64,
    /// What the way ahead must leave free beside the body, in m.
    pub margin_m: f64,
    /// Beyond this angle off the direction the robot turns on the spot, in rad.
    pub spot_rad: f64,
    /// Time constant of the turn, in s.
    pub turn_time_s: f64,
    /// Directions beyond this bearing are taken backwards, in rad.
    pub back_rad: f64,
}

/// Share of the speed that is left at contact.
const SLOWEST_SHARE: f64 = 0.25;

impl Steering {
    /// The motion towards a bearing.
    #[must_use]
    pub fn towards(&self, robot: &PeerRobot, view: &View, bearing_rad: f64) -> Twist {
        let backwards = bearing_rad.abs() > self.back_rad;
        let (sign, front, off) =
            if backwards { (-1.0, PI, turn(PI, bearing_rad)) } else { (1.0, 0.0, bearing_rad) };
        let free = free_way(view.points, front, robot.body_radius_m + self.margin_m, robot.reach_m);
        let nearest = view.points.iter().map(|point| point.coords.norm()).fold(f64::INFINITY, f64::min);
        let room = ((nearest - robot.body_radius_m).max(0.0) / self.near_m).min(1.0);
        let cruise =
            self.cruise_share * robot.speed_limit_mps * (SLOWEST_SHARE + (1.0 - SLOWEST_SHARE) * room);
        let speed = cruise.min(free / self.headway_s.max(robot.period_s));
        let limit = robot.turn_limit_radps();
        Twist {
            forward_mps: sign * speed * (1.0 - off.abs() / self.spot_rad).max(0.0),
            turn_radps: (off / self.turn_time_s.max(robot.period_s)).clamp(-limit, limit),
        }
    }
}
