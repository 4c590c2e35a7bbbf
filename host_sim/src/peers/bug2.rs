//! Bug2: straight at the target, around what is in the way, and on where the straight line is met again nearer to it.
//!
//! Source: V. J. Lumelsky and A. A. Stepanov, *Path-Planning Strategies for a Point Mobile Automaton Moving Amidst
//! Unknown Obstacles of Arbitrary Shape*, Algorithmica 2, 1987. The **m-line** joins the place where the target was set
//! with the target. Where an obstacle blocks it is the hit point; the robot follows the obstacle's edge until it meets
//! the m-line nearer to the target than there, and is free to leave.
//!
//! # Left open, and chosen
//!
//! * **A body instead of a point**: a direction is blocked where a disc of the body's radius and a margin would touch a
//!   remembered point on its way; that of a point at distance d blocks ± asin((radius + margin) / d).
//! * **Following an edge**: with noisy readings from twelve beams no distance to "the wall" can be controlled. The robot
//!   sweeps from the edge that it follows away from it, over all directions that are blocked, and takes the first free
//!   one: the tangent, at posts, corners and doorways alike. A point nearer than the margin pushes it out again.
//! * **Side**: the one that needs the smaller turn; left where both are equal. The paper's proof holds for any choice.
//! * **m-line met**: the side on which it lies has changed between two decisions.
//! * **An edge that is gone** (a moving robot) is followed no more. One that led back to its hit point is followed the
//!   other way around: the paper would call the target unreachable.

use core::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Point2;

use super::config::{linear, numbers};
use super::robot::{PeerRobot, Twist, free_way, turn};
use super::{Navigator, View};

numbers! {
    /// Numbers of Bug2.
    Bug2Config {
        /// What must be free beside the body, in m; edges are followed at this distance.
        margin_m: 0.005, 0.0001 to 1.0, linear(0.002, 0.02);
        /// Obstacles farther away than this block no direction while an edge is followed, in m from the robot's centre.
        look_m: 0.1, 0.001 to 20.0, linear(0.05, 0.2);
        /// An obstacle on the way to the target is hit at this distance before the body would touch it, in m.
        hit_m: 0.03, 0.0 to 20.0, linear(0.005, 0.1);
        /// How much nearer than the hit point the m-line must be met, in m.
        gain_m: 0.02, 0.0 to 10.0, linear(0.005, 0.08);
        /// How far the way to the target must be free to leave, in m.
        leave_m: 0.05, 0.0 to 10.0, linear(0.01, 0.12);
        /// Speed where nothing is near, as a share of c*.
        cruise_share: 0.7, 0.01 to 1.0, linear(0.3, 1.0);
        /// Time that the free way ahead must last, in s.
        headway_s: 0.3, 0.0 to 100.0, linear(0.1, 1.5);
        /// Beyond this bearing the robot turns on the spot, in rad.
        spot_rad: 0.7, 0.01 to 3.2, linear(0.3, 1.57);
        /// Time constant of a turn, in s.
        turn_time_s: 0.2, 0.01 to 10.0, linear(0.13, 0.6);
    }
}

/// How far from its hit point the robot has been before a return counts, and how near it then comes, in m.
const ROUND_AWAY_M: f64 = 0.15;
const ROUND_BACK_M: f64 = 0.03;
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
    /// The m-line's offset at the last decision.
    offset_m: f64,
    /// The robot has been away from the hit point.
    has_left: bool,
}

/// Bug2 on its way.
#[derive(Debug, Clone)]
pub struct Bug2 {
    robot: PeerRobot,
    config: Bug2Config,
    line: Option<MLine>,
    edge: Option<Edge>,
}

impl Bug2 {
    /// For a robot.
    #[must_use]
    pub fn new(robot: PeerRobot, config: Bug2Config) -> Self {
        Self { robot, config, line: None, edge: None }
    }

    fn radius_m(&self) -> f64 {
        self.robot.body_radius_m + self.config.margin_m
    }

    /// Half of the angle that a point at this distance blocks.
    fn blocked_rad(&self, distance_m: f64) -> f64 {
        let radius = self.radius_m();
        if distance_m > radius {
            return libm::asin(radius / distance_m);
        }
        // Nearer than it should be: straight away from it at the body, along it at the margin.
        let depth = (radius - distance_m) / self.config.margin_m;
        FRAC_PI_2 * (1.0 + depth.min(1.0) / 2.0)
    }

    /// Sweeps from a point of the edge, to the first free bearing and the point that ends what is blocked. `None` where
    /// everything is.
    fn sweep(&self, points: &[Point2<f64>], from: Point2<f64>, side: f64) -> Option<(f64, Point2<f64>)> {
        let start = libm::atan2(from.y, from.x);
        let radius = self.radius_m();
        let look = self.config.look_m.max(radius);
        let polar = |point: &Point2<f64>| (libm::atan2(point.y, point.x), point.coords.norm(), *point);
        let near: Vec<_> = points.iter().map(polar).filter(|&(_, distance, _)| distance < look).collect();
        let mut swept = self.blocked_rad(from.coords.norm().min(look));
        let mut last = from;
        loop {
            let direction = start + side * swept;
            let mut next = swept;
            for &(bearing, distance, point) in &near {
                let half = self.blocked_rad(distance);
                let off = side * turn(direction, bearing);
                // The direction lies within what the point blocks: on to its end.
                if off.abs() < half && swept + off + half > next {
                    next = swept + off + half;
                    last = point;
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
        // What blocks it first.
        let free = |point: &Point2<f64>| {
            free_way(core::slice::from_ref(point), towards, self.radius_m(), f64::INFINITY)
        };
        let first = view.points.iter().min_by(|a, b| free(a).total_cmp(&free(b)))?;
        let way = |side| self.sweep(view.points, *first, side).map(|(bearing, at)| (side, bearing, at));
        let size = |(_, bearing, _): &(f64, f64, Point2<f64>)| turn(towards, *bearing).abs();
        let ways = [way(1.0), way(-1.0)];
        let (side, _, at) = ways.into_iter().flatten().min_by(|a, b| size(a).total_cmp(&size(b)))?;
        Some(Edge {
            hit: view.position,
            hit_distance_m: view.target.distance_m,
            side,
            at: view.to_world(at),
            offset_m: line.offset(view.position),
            has_left: false,
        })
    }

    /// The bearing along the edge; `None` where it is gone or there is no way on.
    fn follow(&self, view: &View, edge: &mut Edge) -> Option<f64> {
        let known = view.to_robot(edge.at);
        let gap = |point: &Point2<f64>| (point - known).norm();
        let nearest = view.points.iter().min_by(|a, b| gap(a).total_cmp(&gap(b)))?;
        if gap(nearest) > SAME_EDGE_M {
            return None;
        }
        let (bearing, at) = self.sweep(view.points, *nearest, edge.side)?;
        edge.at = view.to_world(at);
        Some(bearing)
    }

    fn is_free(&self, view: &View, way_m: f64) -> bool {
        let way = way_m.min(view.target.distance_m);
        free_way(view.points, view.target.bearing_rad, self.radius_m(), way) >= way - 1e-9
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
        let config = self.config.clone();
        let Some(bearing) = self.bearing(view) else {
            // Boxed in by what may be noise: look around.
            return Twist { forward_mps: 0.0, turn_radps: self.robot.turn_limit_radps() / 4.0 };
        };
        let body = self.robot.body_radius_m;
        let free = free_way(view.points, 0.0, body + config.margin_m / 2.0, self.robot.reach_m);
        let cruise = config.cruise_share * self.robot.speed_limit_mps;
        let speed = cruise.min(free / config.headway_s.max(self.robot.period_s));
        self.robot.heading_for(bearing, speed, config.spot_rad, config.turn_time_s)
    }

    fn reset(&mut self) {
        self.line = None;
        self.edge = None;
    }
}
