//! What the ways to candidate places are held against, gathered once for each integration.

use heapless::Vec;

use crate::integration::sweep::{self, SweepParameters};
use crate::localisation::separation::{self, Moving, OTHERS, SeparationParameters};
use crate::scalar::Scalar;
use crate::units::{Point, Polar};

/// Obstacle points near enough to matter within a step, and other robots; robot frame.
#[derive(Clone, Debug)]
pub struct Ways<S, const POINTS: usize> {
    points: Vec<Point<S>, POINTS>,
    others: Vec<Moving<S>, OTHERS>,
}

impl<S: Scalar, const POINTS: usize> Ways<S, POINTS> {
    /// Keeps of the points those that the body can come near to within a step of length `reach_m`.
    #[inline]
    #[must_use]
    pub fn among(
        p: &SweepParameters<S>,
        reach_m: S,
        points: impl Iterator<Item = Point<S>>,
        others: Vec<Moving<S>, OTHERS>,
    ) -> Self {
        let mut kept: Vec<Point<S>, POINTS> = Vec::new();
        // Points farther than the body can come within a step decide nothing.
        let farthest = reach_m + p.body_radius_m + p.margin_m;
        for point in points {
            // There is room for all.
            if point.x_m.abs() < farthest && point.y_m.abs() < farthest && kept.push(point).is_err() {
                break;
            }
        }
        Self { points: kept, others }
    }

    /// The inhibition of a neuron for the obstacle points on the way to its place; see [`sweep`].
    #[inline]
    #[must_use]
    pub fn of_obstacles(&self, p: &SweepParameters<S>, place: Polar<S>) -> S {
        let checked = p.strength > S::ZERO && !self.points.is_empty();
        if checked { sweep::inhibition(p, place, self.points.iter()) } else { S::ZERO }
    }

    /// The inhibition of a neuron for the other robots on the way to its place, the worst of them; see [`separation`].
    #[inline]
    #[must_use]
    pub fn of_others(&self, p: &SeparationParameters<S>, look_ahead: S, place: Polar<S>) -> S {
        let each = self.others.iter().map(|other| separation::inhibition(p, place, look_ahead, other));
        each.fold(S::ZERO, S::max)
    }

    /// The obstacle points.
    #[must_use]
    pub fn points(&self) -> &[Point<S>] {
        &self.points
    }

    /// The other robots.
    #[must_use]
    pub fn others(&self) -> &[Moving<S>] {
        &self.others
    }
}
