//! Bug2: straight at the target, around what is in the way, and on where the straight line is met again nearer to it.
//!
//! Source: V. J. Lumelsky and A. A. Stepanov, *Path-Planning Strategies for a Point Mobile Automaton Moving Amidst
//! Unknown Obstacles of Arbitrary Shape*, Algorithmica 2, 1987. The **m-line** joins the place where the target was set
//! with the target. Where an obstacle blocks it is the hit point; the robot follows the obstacle's edge until it meets
//! the m-line nearer to the target than there, and is free to leave.
//!
//! # Left open, and chosen
//!
//! * **A body instead of a point**: a point at distance d blocks ± asin(r / d), r the body's radius and what a passage
//!   must leave free. Within a margin, which is larger, it blocks more: along the margin's edge the way is parallel to
//!   it, nearer it leads away.
//! * **Following an edge**: with noisy readings from twelve beams no distance to "the wall" can be controlled. The
//!   robot sweeps from the edge that it follows away from it, over all directions that are blocked, and takes the first
//!   free one: the tangent, at posts, corners and doorways alike.
//! * **Side**: the one that needs the smaller turn; left where both are equal. The paper's proof holds for any choice.
//! * **m-line met**: the side on which it lies has changed between two decisions.
//! * **What moves** is not foreseen in the paper. An edge that is gone is followed no more; one that led back to its
//!   hit point, where the paper would call the target unreachable, is followed the other way around; and one on which
//!   the robot has turned by more than two circles and a quarter is left, with a new m-line from there.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Point2;

use super::config::numbers;
use super::robot::{PeerRobot, Twist, free_way, turn};
use super::steering::Steering;
use super::{Navigator, View};

numbers! {
    /// Numbers of Bug2.
    Bug2Config, "bug2" {
        /// What a passage must leave free beside the body, in m.
        gap_m: 0.00209, 0.0 to 1.0, linear(0.0, 0.01);
        /// Edges are followed at this distance from the body, in m.
        margin_m: 0.00439, 0.0001 to 1.0, linear(0.002, 0.02);
        /// Obstacles farther away than this block no direction while an edge is followed, in m from the robot's centre.
        look_m: 0.0583, 0.001 to 20.0, linear(0.05, 0.2);
        /// An obstacle on the way to the target is hit at this distance before the body would touch it, in m.
        hit_m: 0.0171, 0.0 to 20.0, linear(0.005, 0.1);
        /// How much nearer than the hit point the m-line must be met, in m.
        gain_m: 0.00656, 0.0 to 10.0, linear(0.005, 0.08);
        /// How far the way to the target must be free to leave, in m.
        leave_m: 0.12, 0.0 to 10.0, linear(0.01, 0.12);
        /// Speed where nothing is near, as a share of c*.
        cruise_share: 0.864, 0.01 to 1.0, linear(0.3, 1.0);
        /// Time that the free way ahead must last, in s.
        headway_s: 0.445, 0.0 to 100.0, linear(0.1, 1.5);
        /// Within this distance of the body the speed falls, in m.
        near_m: 0.0171, 0.0001 to 20.0, log(0.001, 0.1);
        /// Beyond this bearing the robot turns on the spot, in rad.
        spot_rad: 1.43, 0.01 to 3.2, linear(0.3, 1.57);
        /// Time constant of a turn, in s.
        turn_time_s: 0.307, 0.01 to 10.0, linear(0.13, 0.6);
        /// Directions beyond this bearing are taken backwards, in rad.
        back_rad: 2.99, 0.0 to 3.2, linear(1.57, 3.2);
        /// How long a point is remembered that is not seen again, in s.
        memory_s: 0.2, 0.0 to 600.0, log(0.2, 20.0);
    }
}

/// How far from its hit point the robot has been before a return counts, and how near it then comes, in m.
const ROUND_AWAY_M: f64 = 0.15;
const ROUND_BACK_M: f64 = 0.03;
/// Where the hand is: so far from the last direction, towards the edge, in rad.
const HAND_RAD: f64 = 2.2;
/// An edge that has turned by more than this leads in circles, in rad.
const TURNED_RAD: f64 = 4.5 * PI;
/// An edge point that is remembered no more is the same as one at this distance from it, in m.
const SAME_EDGE_M: f64 = 0.04;

/// The straight line to a target.
#[derive(Debug, Clone, Copy, PartialEq)]
struct MLine {
    from: Point2<f64>,
    to: Point2<f64>,
}

impl MLine {
    /// Distance from the line, positive to its left, in m.
    fn offset(&self, place: Point2<f64>) -> f64 {
        let line = self.to - self.from;
        let length = line.norm();
        if length > 0.0 { line.perp(&(place - self.from)) / length } else { 0.0 }
    }
}

/// An edge that is being followed.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Edge {
    hit: Point2<f64>,
    hit_distance_m: f64,
    /// Which way the sweep goes: 1 anticlockwise (the edge is on the right), -1 clockwise.
    side: f64,
    /// The point that decided the last direction, world frame.
    at: Point2<f64>,
    /// The last direction, world frame.
    direction_rad: f64,
    /// The m-line's offset at the last decision.
    offset_m: f64,
    /// The robot has been away from the hit point.
    has_left: bool,
    /// How far the direction has turned since the hit point, in rad.
    turned_rad: f64,
}

/// Bug2 on its way.
#[derive(Debug, Clone)]
pub struct Bug2 {
    robot: PeerRobot,
    steering: Steering,
    config: Bug2Config,
    line: Option<MLine>,
    edge: Option<Edge>,
}

impl Bug2 {
    /// For a robot.
    #[must_use]
    pub fn new(robot: PeerRobot, config: Bug2Config) -> Self {
        Self {
            robot,
            steering: Steering {
                cruise_share: config.cruise_share,
                headway_s: config.headway_s,
                near_m: config.near_m,
                margin_m: config.gap_m,
                spot_rad: config.spot_rad,
                turn_time_s: config.turn_time_s,
                back_rad: config.back_rad,
            },
            line: None,
            edge: None,
            config,
        }
    }

    /// What a passage must leave free around the robot's centre.
    fn radius_m(&self) -> f64 {
        self.robot.body_radius_m + self.config.gap_m
    }

    /// Half of the angle that a point at this distance blocks.
    fn blocked_rad(&self, distance_m: f64) -> f64 {
        let passed =
            if distance_m > self.radius_m() { libm::asin(self.radius_m() / distance_m) } else { FRAC_PI_2 };
        // At the margin the way leads along it; nearer, away from it.
        let depth = 1.0 + (self.robot.body_radius_m - distance_m) / self.config.margin_m;
        let pushed =
            if depth > 0.0 { FRAC_PI_2 * (1.0 + depth.min(1.0) / 2.0) } else { FRAC_PI_2 * (1.0 + depth) };
        passed.max(pushed)
    }

    /// Sweeps from a bearing over what is blocked, to the first free bearing and the point that ends what is blocked,
    /// if anything is. `None` where everything is.
    fn sweep(&self, points: &[Point2<f64>], start: f64, side: f64) -> Option<(f64, Option<Point2<f64>>)> {
        let look = self.config.look_m.max(self.radius_m());
        let polar = |point: &Point2<f64>| (libm::atan2(point.y, point.x), point.coords.norm(), *point);
        let near: Vec<_> = points.iter().map(polar).filter(|&(_, distance, _)| distance < look).collect();
        let (mut swept, mut last) = (0.0, None);
        loop {
            let direction = start + side * swept;
            let mut next = swept;
            for &(bearing, distance, point) in &near {
                let half = self.blocked_rad(distance);
                let off = side * turn(direction, bearing);
                // The direction lies within what the point blocks: on to its end.
                if off.abs() < half && swept + off + half > next {
                    next = swept + off + half;
                    last = Some(point);
                }
            }
            if next <= swept + 1e-6 {
                return Some((turn(0.0, direction), last));
            }
            if next >= TAU {
                return None;
            }
            swept = next;
        }
    }

    /// Begins to follow what blocks the way to the target.
    fn hit(&self, view: &View, line: &MLine) -> Option<Edge> {
        let towards = view.target.bearing_rad;
        let way = |side| self.sweep(view.points, towards, side).map(|(bearing, at)| (side, bearing, at));
        let size = |(_, bearing, _): &(f64, f64, Option<Point2<f64>>)| turn(towards, *bearing).abs();
        let ways = [way(1.0), way(-1.0)];
        let (side, bearing, at) = ways.into_iter().flatten().min_by(|a, b| size(a).total_cmp(&size(b)))?;
        Some(Edge {
            hit: view.position,
            hit_distance_m: view.target.distance_m,
            side,
            at: view.to_world(at?),
            direction_rad: view.heading_rad + bearing,
            offset_m: line.offset(view.position),
            has_left: false,
            turned_rad: 0.0,
        })
    }

    /// The bearing along the edge; `None` where it is gone or there is no way on.
    fn follow(&self, view: &View, edge: &mut Edge) -> Option<f64> {
        // The hand on the edge: what is blocked there ends where the edge does.
        let hand = turn(view.heading_rad, edge.direction_rad) - edge.side * HAND_RAD;
        let (mut bearing, mut at) = self.sweep(view.points, hand, edge.side)?;
        if at.is_none() {
            let known = view.to_robot(edge.at);
            let gap = |point: &Point2<f64>| (point - known).norm();
            let nearest = view.points.iter().min_by(|a, b| gap(a).total_cmp(&gap(b)))?;
            if gap(nearest) > SAME_EDGE_M {
                return None;
            }
            (bearing, at) = self.sweep(view.points, libm::atan2(nearest.y, nearest.x), edge.side)?;
            at = at.or(Some(*nearest));
        }
        edge.at = view.to_world(at?);
        let direction = view.heading_rad + bearing;
        edge.turned_rad += turn(edge.direction_rad, direction);
        edge.direction_rad = direction;
        Some(bearing)
    }

    fn is_free(&self, view: &View, way_m: f64) -> bool {
        let way = way_m.min(view.target.distance_m);
        let towards = view.target.bearing_rad;
        // Not along what is nearer than the margin.
        let is_pushed = |point: &Point2<f64>| {
            let distance = point.coords.norm();
            let bearing = libm::atan2(point.y, point.x);
            distance < self.robot.body_radius_m + self.config.margin_m
                && turn(towards, bearing).abs() < self.blocked_rad(distance)
        };
        free_way(view.points, towards, self.radius_m(), way) >= way - 1e-9
            && !view.points.iter().any(is_pushed)
    }

    /// Whether the edge can be left here.
    fn leaves(&self, view: &View, line: &MLine, edge: &mut Edge) -> bool {
        let offset = line.offset(view.position);
        let is_met = offset * edge.offset_m <= 0.0;
        edge.offset_m = offset;
        let is_nearer = view.target.distance_m < edge.hit_distance_m - self.config.gain_m;
        is_met && is_nearer && self.is_free(view, self.config.leave_m)
    }

    /// Turns around where the edge has led back to its hit point.
    fn heed_round(view: &View, edge: &mut Edge) {
        let from_hit = (view.position - edge.hit).norm();
        edge.has_left |= from_hit > ROUND_AWAY_M;
        if edge.has_left && from_hit < ROUND_BACK_M {
            edge.has_left = false;
            edge.side = -edge.side;
        }
    }

    /// The bearing to take; `None` where there is none.
    fn bearing(&mut self, view: &View) -> Option<f64> {
        let target = view.target.position;
        let line = match self.line {
            Some(line) if line.to == target => line,
            _ => {
                self.edge = None;
                *self.line.insert(MLine { from: view.position, to: target })
            }
        };
        if let Some(mut edge) = self.edge.take() {
            Self::heed_round(view, &mut edge);
            if edge.turned_rad.abs() > TURNED_RAD {
                self.line = None;
                return Some(view.target.bearing_rad);
            }
            if !self.leaves(view, &line, &mut edge)
                && let Some(bearing) = self.follow(view, &mut edge)
            {
                self.edge = Some(edge);
                return Some(bearing);
            }
        }
        if self.is_free(view, self.config.hit_m) {
            return Some(view.target.bearing_rad);
        }
        let mut edge = self.hit(view, &line)?;
        let bearing = self.follow(view, &mut edge);
        self.edge = Some(edge);
        bearing
    }
}

impl Navigator for Bug2 {
    fn decide(&mut self, view: &View) -> Twist {
        let Some(bearing) = self.bearing(view) else {
            // Boxed in by what may be noise: look around.
            return Twist { forward_mps: 0.0, turn_radps: self.robot.turn_limit_radps() / 4.0 };
        };
        self.steering.towards(&self.robot, view, bearing)
    }

    fn reset(&mut self) {
        self.line = None;
        self.edge = None;
    }

    fn memory_s(&self) -> f64 {
        self.config.memory_s
    }
}

#[cfg(test)]
mod tests {
    use super::{Bug2, Bug2Config, MLine};
    use crate::peers::testing::{ROBOT, view};
    use core::f64::consts::FRAC_PI_2;
    use nalgebra::Point2;

    /// A wall across the way, with an opening if wished.
    fn wall(ahead_m: f64, opening: core::ops::Range<f64>) -> Vec<Point2<f64>> {
        let across = (-30..=30).map(|i| f64::from(i) * 0.01).filter(|y| !opening.contains(y));
        across.map(|y| Point2::new(ahead_m, y)).collect()
    }

    #[test]
    fn follows_a_wall_and_enters_an_opening_in_it() {
        let mut bug = Bug2::new(ROBOT, Bug2Config::default());
        let at = ROBOT.body_radius_m + Bug2Config::default().margin_m;
        let closed = wall(at, 0.0..0.0);
        let bearing = bug.bearing(&view(&[None; 12], &closed, 0.0)).unwrap();
        assert!((bearing.abs() - FRAC_PI_2).abs() < 0.2, "along the wall: {bearing}");
        let mut bug = Bug2::new(ROBOT, Bug2Config::default());
        let open = wall(at, -0.05..0.05);
        let bearing = bug.bearing(&view(&[None; 12], &open, 0.0)).unwrap();
        assert!(bearing.abs() < 1e-9 && bug.edge.is_none(), "through it: {bearing}");
    }

    #[test]
    fn the_m_line_has_two_sides() {
        let line = MLine { from: Point2::new(0.0, 0.0), to: Point2::new(2.0, 0.0) };
        assert!((line.offset(Point2::new(1.0, 0.3)) - 0.3).abs() < 1e-12);
        assert!((line.offset(Point2::new(5.0, -0.3)) + 0.3).abs() < 1e-12);
        let nowhere = MLine { from: line.to, to: line.to };
        assert!(nowhere.offset(line.from).abs() < 1e-12);
    }
}
