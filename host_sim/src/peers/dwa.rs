//! Dynamic window approach: of the motions that the robot can reach within a period and stop from, the best by heading,
//! clearance and velocity.
//!
//! Source: D. Fox, W. Burgard and S. Thrun, *The Dynamic Window Approach to Collision Avoidance*, IEEE Robotics and
//! Automation Magazine 4(1), 1997: `G(v, ω) = α · heading + β · dist + γ · velocity` over the (v, ω) of the window.
//!
//! # Left open, and chosen
//!
//! * **Obstacles** are the points seen lately, not a field of lines: twelve beams see no lines. `dist` is the way along
//!   the arc until the body and a margin touch a point, exact for each.
//! * **Admissible** is a motion if the way left after a period suffices to brake.
//! * **A turn on the spot** touches nothing, for a round body: its `dist` is the free way straight on after it.
//! * **G is not smoothed**: with few samples there is nothing to smooth.
//! * **Stuck**: the paper turns away in place until the robot can move on. Here, when it has hardly moved for a
//!   while, it turns to the side of the wider free way until there is one.

use nalgebra::Point2;

use super::config::numbers;
use super::robot::{PeerRobot, Twist, free_way, turn};
use super::{Navigator, View};

numbers! {
    /// Numbers of the dynamic window approach.
    DwaConfig, "dwa" {
        /// α: heading.
        heading_weight: 0.676, 0.0 to 1000.0, linear(0.1, 2.0);
        /// β: clearance.
        clearance_weight: 1.01, 0.0 to 1000.0, linear(0.0, 2.0);
        /// γ: velocity.
        velocity_weight: 0.932, 0.0 to 1000.0, linear(0.0, 1.0);
        /// What must be free beside the body, in m.
        margin_m: 0.00295, 0.0 to 1.0, linear(0.0, 0.02);
        /// Clearance beyond this is no better, in m.
        clearance_m: 0.145, 0.001 to 20.0, linear(0.03, 0.2);
        /// Fastest speed, as a share of c*.
        cruise_share: 0.948, 0.01 to 1.0, linear(0.3, 1.0);
        /// Share of the wheels' acceleration that is counted on for braking.
        braking_share: 0.793, 0.01 to 1.0, linear(0.05, 1.0);
        /// Time for which a motion is looked ahead for its heading, in s.
        horizon_s: 0.255, 0.01 to 10.0, linear(0.1, 0.8);
        /// Time without way after which the robot is stuck, in s.
        stuck_s: 1.0, 0.1 to 1000.0, linear(0.3, 4.0);
        /// Free way that ends the turn away, in m.
        escape_m: 0.084, 0.0 to 20.0, linear(0.03, 0.17);
        /// How long a point is remembered that is not seen again, in s.
        memory_s: 2.11, 0.0 to 600.0, log(0.2, 20.0);
    }
}

/// Samples of the speed, and of the turn to either side.
const SPEEDS: u8 = 6;
const TURNS: i8 = 10;
/// Slower than this the robot makes no way, as a share of c*.
const IDLE_SHARE: f64 = 0.1;
/// How fast it turns away, as a share of its fastest turn.
const ESCAPE_SHARE: f64 = 0.3;

/// The dynamic window approach on its way.
#[derive(Debug, Clone)]
pub struct DynamicWindow {
    robot: PeerRobot,
    config: DwaConfig,
    /// How long the robot has made no way.
    idle_s: f64,
    escape: Option<Escape>,
}

impl DynamicWindow {
    /// For a robot.
    #[must_use]
    pub fn new(robot: PeerRobot, config: DwaConfig) -> Self {
        Self { robot, config, idle_s: 0.0, escape: None }
    }

    fn radius_m(&self) -> f64 {
        self.robot.body_radius_m + self.config.margin_m
    }

    /// The free way of a motion in m, at most what counts as clear.
    fn clearance(&self, points: &[Point2<f64>], motion: Twist) -> f64 {
        let farthest = self.config.clearance_m;
        let radius = self.radius_m();
        if motion.forward_mps < 1e-6 {
            let heading = motion.turn_radps * self.config.horizon_s;
            return free_way(points, heading, radius, farthest);
        }
        if motion.turn_radps.abs() < 1e-3 * motion.forward_mps / farthest {
            return free_way(points, 0.0, radius, farthest);
        }
        free_arc(points, motion.forward_mps / motion.turn_radps, radius, farthest)
    }

    /// α · heading + β · dist + γ · velocity; `None` where the robot could not stop in time.
    fn score(&self, view: &View, points: &[Point2<f64>], motion: Twist) -> Option<f64> {
        let config = &self.config;
        let clearance = self.clearance(points, motion);
        let left = clearance - motion.forward_mps * self.robot.period_s;
        let braking = config.braking_share * self.robot.acceleration_mps2;
        let is_admissible =
            motion.forward_mps < 1e-6 || motion.forward_mps * motion.forward_mps <= 2.0 * braking * left;
        is_admissible.then(|| {
            let turned = motion.turn_radps * config.horizon_s;
            let (sin, cos) = libm::sincos(turned / 2.0);
            let way = motion.forward_mps * config.horizon_s;
            let (x, y) = (way * cos, way * sin);
            let (sin, cos) = libm::sincos(view.target.bearing_rad);
            let distance = view.target.distance_m;
            let bearing = libm::atan2(distance * sin - y, distance * cos - x);
            let heading = 1.0 - turn(turned, bearing).abs() / core::f64::consts::PI;
            config.heading_weight * heading
                + config.clearance_weight * clearance / config.clearance_m
                + config.velocity_weight * motion.forward_mps / self.robot.speed_limit_mps
        })
    }

    /// The best motion of the window; standing still where none is admissible.
    fn best(&self, view: &View) -> Twist {
        let robot = &self.robot;
        let reach = self.config.clearance_m + self.radius_m();
        let near = |point: &&Point2<f64>| point.coords.norm_squared() < reach * reach;
        let points: Vec<Point2<f64>> = view.points.iter().filter(near).copied().collect();
        let change = robot.acceleration_mps2 * robot.period_s;
        let fastest = self.config.cruise_share * robot.speed_limit_mps;
        let low = (view.speed.forward_mps - change).clamp(0.0, fastest);
        let high = (view.speed.forward_mps + change).clamp(low, fastest);
        let turn_change = 2.0 * change / robot.wheel_base_m;
        let mut best = (f64::NEG_INFINITY, Twist::STOP);
        for i in 0..=SPEEDS {
            let forward_mps = low + (high - low) * f64::from(i) / f64::from(SPEEDS);
            let limit = 2.0 * (robot.speed_limit_mps - forward_mps) / robot.wheel_base_m;
            for j in -TURNS..=TURNS {
                // Fine near straight on, coarse at the ends.
                let share = f64::from(j) / f64::from(TURNS);
                let turn_radps = limit * share * share.abs();
                if (turn_radps - view.speed.turn_radps).abs() > turn_change {
                    continue;
                }
                let motion = Twist { forward_mps, turn_radps };
                let score = self.score(view, &points, motion).unwrap_or(f64::NEG_INFINITY);
                if score > best.0 {
                    best = (score, motion);
                }
            }
        }
        best.1
    }

    /// Turns away while there is no way ahead.
    fn escape(&mut self, view: &View) -> Option<Twist> {
        let (radius, reach) = (self.radius_m(), self.robot.reach_m);
        let free = |bearing: f64| free_way(view.points, bearing, radius, reach);
        let mut escape = self.escape.take().or_else(|| {
            let side = |sign: f64| free(sign * 0.8) + free(sign * 1.6) + free(sign * 2.4);
            let sign = if side(-1.0) > side(1.0) { -1.0 } else { 1.0 };
            (self.idle_s >= self.config.stuck_s).then_some(Escape { sign, turned_s: 0.0 })
        })?;
        self.idle_s = 0.0;
        // At least a quarter: what is in the way must have left the front.
        let turned = escape.turned_s * self.robot.turn_limit_radps() * ESCAPE_SHARE;
        if turned > core::f64::consts::FRAC_PI_2 && free(0.0) >= self.config.escape_m {
            return None;
        }
        escape.turned_s += self.robot.period_s;
        self.escape = Some(escape);
        let turn_radps = escape.sign * self.robot.turn_limit_radps() * ESCAPE_SHARE;
        Some(Twist { forward_mps: 0.0, turn_radps })
    }
}

/// Turning away.
#[derive(Debug, Clone, Copy)]
struct Escape {
    /// 1 to the left, -1 to the right.
    sign: f64,
    /// For how long by now, in s.
    turned_s: f64,
}

/// How far a disc of this radius can go along a circle (its signed radius, left positive) before it meets one of the
/// points, in m; at most `farthest_m`.
fn free_arc(points: &[Point2<f64>], circle_m: f64, radius_m: f64, farthest_m: f64) -> f64 {
    let size = circle_m.abs();
    let mut free = farthest_m;
    for point in points {
        // Mirrored to the left, seen from the middle of the circle, with the robot at angle zero.
        let y = if circle_m < 0.0 { -point.y } else { point.y };
        let (ahead, out) = (point.x, size - y);
        let from_middle = libm::sqrt(ahead * ahead + out * out);
        if (from_middle - size).abs() >= radius_m {
            continue;
        }
        let angle = libm::atan2(ahead, out);
        let cosine =
            (from_middle * from_middle + size * size - radius_m * radius_m) / (2.0 * from_middle * size);
        let half = libm::acos(cosine.clamp(-1.0, 1.0));
        let until = if angle >= half {
            angle - half
        } else if angle >= 0.0 {
            // Inside already, and ahead.
            0.0
        } else if angle > -half {
            // Inside, and left behind: met again after a whole turn at the earliest.
            continue;
        } else {
            angle - half + core::f64::consts::TAU
        };
        free = free.min(until * size);
    }
    free
}

impl Navigator for DynamicWindow {
    fn decide(&mut self, view: &View) -> Twist {
        if let Some(away) = self.escape(view) {
            return away;
        }
        let motion = self.best(view);
        let is_idle = motion.forward_mps < IDLE_SHARE * self.robot.speed_limit_mps;
        self.idle_s = if is_idle { self.idle_s + self.robot.period_s } else { 0.0 };
        motion
    }

    fn reset(&mut self) {
        self.idle_s = 0.0;
        self.escape = None;
    }

    fn memory_s(&self) -> f64 {
        self.config.memory_s
    }
}

#[cfg(test)]
mod tests {
    use super::free_arc;
    use nalgebra::Point2;

    #[test]
    fn arcs_end_where_the_disc_touches() {
        // A quarter circle of 0.1 m to the left ends at (0.1, 0.1); a point just beyond it stops the disc earlier.
        let point = [Point2::new(0.1, 0.1)];
        let free = free_arc(&point, 0.1, 0.02, 1.0);
        let expected = 0.1 * (core::f64::consts::FRAC_PI_2 - 2.0 * libm::asin(0.1));
        assert!((free - expected).abs() < 1e-12, "{free}, expected {expected}");
        assert!((free_arc(&point, -0.1, 0.02, 0.5) - 0.5).abs() < 1e-12, "the other circle is clear");
        let mirrored = [Point2::new(0.1, -0.1)];
        assert!((free_arc(&mirrored, -0.1, 0.02, 1.0) - expected).abs() < 1e-12);
        let behind = [Point2::new(-0.01, 0.0)];
        assert!(free_arc(&behind, 0.1, 0.02, 0.5) >= 0.5, "what it touches behind it can leave");
        let ahead = [Point2::new(0.01, 0.0)];
        assert!(free_arc(&ahead, 0.1, 0.02, 0.5) <= 0.0);
    }
}
