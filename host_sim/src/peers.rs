//! The controllers that people use, as peers of cooperative EKMs: the same robot, the same sensors, the same odometry.
//!
//! ```text
//! scan ──► surroundings: what was seen lately, as points ──┐
//! pose, checkpoint ────────────────────────────────────────┼─► near and free? ─► final approach ──┐
//!                                                          └─► else the navigator's decision ─────┴─► wheel speeds
//! ```
//!
//! A [`Navigator`] decides each avoidance period (128 ms). Everything else is the core's own
//! ([`controller_core::reflex`]) and the same for all: odometry, arrival at checkpoints, servo and safety gate; see
//! [`port`]. Peers learn no map and are told the robot's measures instead. Two more things are common to them, so that
//! they are compared on obstacles and not on parking or on what twelve beams miss: the way over the last centimetres
//! ([`approach`]) and the short memory of what was seen ([`surroundings`]).
//!
//! The peers are written from the published descriptions alone. Each module names its source, what that leaves open,
//! and what we chose.

pub mod apf;
pub mod approach;
pub mod bug2;
pub mod config;
pub mod dwa;
pub mod port;
pub mod robot;
pub mod steering;
pub mod surroundings;
#[cfg(test)]
mod testing;
pub mod vfh;

use nalgebra::{Point2, Vector2};

use crate::contender::Contender;
use crate::proximity_model::SENSORS;
use config::PeerConfig;
use robot::{PeerRobot, Twist};

/// What a navigator works on: the state of one moment.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Where the centre of the body is, world frame.
    pub position: Point2<f64>,
    /// Heading, anticlockwise from +x, in rad.
    pub heading_rad: f64,
    /// The checkpoint on the way.
    pub target: Target,
    /// What each sensor sees now: distance from the robot's centre, in m.
    pub ranges: &'a [Option<f64>; SENSORS],
    /// What was seen lately, robot frame; see [`surroundings`].
    pub points: &'a [Point2<f64>],
    /// How the wheels move now, as the servo measures it.
    pub speed: Twist,
}

impl View<'_> {
    /// A point of the robot frame in the world.
    #[must_use]
    pub fn to_world(&self, point: Point2<f64>) -> Point2<f64> {
        let (sin, cos) = libm::sincos(self.heading_rad);
        self.position + Vector2::new(point.x * cos - point.y * sin, point.x * sin + point.y * cos)
    }

    /// A point of the world in the robot frame.
    #[must_use]
    pub fn to_robot(&self, point: Point2<f64>) -> Point2<f64> {
        let (sin, cos) = libm::sincos(self.heading_rad);
        let to = point - self.position;
        Point2::new(to.x * cos + to.y * sin, to.y * cos - to.x * sin)
    }
}

/// A checkpoint as a navigator sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// World frame.
    pub position: Point2<f64>,
    /// From the heading, left positive, in ±π rad.
    pub bearing_rad: f64,
    /// From the robot's centre in m.
    pub distance_m: f64,
}

/// A controller that decides where to move, from what is seen and where the target is.
pub trait Navigator {
    /// The motion until the next decision.
    fn decide(&mut self, view: &View) -> Twist;

    /// Forgets everything: a new mission begins.
    fn reset(&mut self);

    /// How long what was seen is remembered for this navigator, in s.
    fn memory_s(&self) -> f64;
}

impl<N: Navigator + ?Sized> Navigator for Box<N> {
    fn decide(&mut self, view: &View) -> Twist {
        (**self).decide(view)
    }

    fn reset(&mut self) {
        (**self).reset();
    }

    fn memory_s(&self) -> f64 {
        (**self).memory_s()
    }
}

/// The navigator of a contender; `None` for those that are no peers.
#[must_use]
pub fn navigator(contender: Contender, robot: PeerRobot, config: &PeerConfig) -> Option<Box<dyn Navigator>> {
    match contender {
        Contender::Cooperative | Contender::Fusion => None,
        Contender::PotentialField => Some(Box::new(apf::PotentialField::new(robot, config.apf.clone()))),
        Contender::VfhPlus => Some(Box::new(vfh::Vfh::new(robot, config.vfh.clone()))),
        Contender::DynamicWindow => Some(Box::new(dwa::DynamicWindow::new(robot, config.dwa.clone()))),
        Contender::Bug2 => Some(Box::new(bug2::Bug2::new(robot, config.bug2.clone()))),
    }
}
