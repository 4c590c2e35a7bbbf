//! Discs that circle across the way.

use core::f64::consts::{PI, TAU};

use nalgebra::Point2;

use super::build::{Disturbance, Draft, centimetres};
use crate::mover::{Direction, Mover};
use crate::scenario::Scenario;
use crate::world::KHEPERA_RADIUS_M;

/// Discs of the robot's size on circles whose middle lies on the straight way.
///
/// They do not look where they go: a robot that stands in their way is driven into, and that counts as contact. Where
/// on its circle a pair begins is drawn in each run, so that it meets the robot at any phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circling {
    /// How many, up to two on each of three circles along the way.
    pub discs: u8,
    /// Their speed in m/s.
    pub speed_m_s: f64,
}

/// Radius of the circles, in m.
const ORBIT_M: f64 = 0.10;
/// Between two circles' centres, in m.
const APART_M: f64 = 0.40;

impl Circling {
    /// As [`super::Scene::name`].
    #[must_use]
    pub fn name(&self) -> String {
        format!("circling_{}_{}", self.discs, centimetres(self.speed_m_s))
    }

    /// The discs as an experiment, in the open.
    #[must_use]
    pub fn scenario(&self, disturbance: &Disturbance) -> Scenario {
        let circles = self.discs.div_ceil(2);
        let mover = |disc: u8| {
            let circle = f64::from(disc / 2);
            // The second of a circle is opposite the first; neighbours turn against each other.
            let direction =
                if (disc / 2).is_multiple_of(2) { Direction::Anticlockwise } else { Direction::Clockwise };
            let phase = PI * f64::from(disc % 2) + TAU * 0.2 * circle;
            Mover::new(
                Point2::new(APART_M * circle, 0.0),
                ORBIT_M,
                KHEPERA_RADIUS_M,
                self.speed_m_s,
                direction,
                phase,
            )
            .with_phase_jitter(PI)
        };
        let end = APART_M * (f64::from(circles) - 1.0).max(0.0);
        Draft {
            name: self.name(),
            title: format!("{} discs that circle at {} cm/s", self.discs, centimetres(self.speed_m_s)),
            start: Point2::new(-0.35, 0.0),
            heading_rad: 0.0,
            jitter_m: 0.05,
            jitter_rad: PI / 2.0,
            goal: Point2::new(end + 0.35, 0.0),
            time_limit_s: 120.0,
            shapes: Vec::new(),
            movers: (0..self.discs).map(mover).collect(),
        }
        .finish(disturbance)
    }
}
