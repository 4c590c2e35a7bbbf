//! What the ways to candidate places are held against, gathered once for each integration.

use heapless::Vec;

use crate::integration::sweep::{self, Obstacle, SweepParameters};
use crate::localisation::mover::Mover;
use crate::scalar::Scalar;
use crate::units::{Point, Polar};

/// Obstacle points near enough to matter within a step, and what moves; robot frame.
#[derive(Clone, Debug)]
pub struct Ways<S, const POINTS: usize, const MOVERS: usize> {
    points: Vec<Obstacle<S>, POINTS>,
    movers: Vec<Mover<S>, MOVERS>,
    /// Clearance wished beyond the body (m).
    margin_m: S,
}

impl<S: Scalar, const POINTS: usize, const MOVERS: usize> Ways<S, POINTS, MOVERS> {
    /// Keeps of the points those that the body can come near to within a step of length `reach_m`; on the way through
    /// an opening `margin_m` of clearance must do.
    #[inline]
    #[must_use]
    pub fn among(
        p: &SweepParameters<S>,
        margin_m: Option<S>,
        reach_m: S,
        points: impl Iterator<Item = Point<S>>,
        movers: Vec<Mover<S>, MOVERS>,
    ) -> Self {
        let margin_m = margin_m.unwrap_or(p.margin_m);
        let mut kept: Vec<Obstacle<S>, POINTS> = Vec::new();
        // Points farther than the body can come within a step decide nothing.
        let farthest = reach_m + p.body_radius_m + margin_m + p.headway * reach_m;
        for point in points {
            // There is room for all.
            if point.x_m.abs() < farthest
                && point.y_m.abs() < farthest
                && kept.push(Obstacle::new(point)).is_err()
            {
                break;
            }
        }
        Self { points: kept, movers, margin_m }
    }

    /// The inhibition of a neuron for what lies on the way to its place, [`Scalar::LIMIT`] as soon as it is `enough`;
    /// see [`sweep::inhibition`].
    #[inline]
    #[must_use]
    pub fn inhibition(&mut self, p: &SweepParameters<S>, place: Polar<S>, enough: S) -> S {
        let checked = p.strength_per_m > S::ZERO && !(self.points.is_empty() && self.movers().is_empty());
        if !checked {
            return S::ZERO;
        }
        let p = SweepParameters { margin_m: self.margin_m, ..*p };
        // Said to the compiler, which else keeps the code for what cannot be.
        let movers: &[Mover<S>] = if MOVERS == 0 { &[] } else { &self.movers };
        sweep::inhibition(&p, place, &mut self.points, movers, enough)
    }

    /// What moves.
    #[must_use]
    pub fn movers(&self) -> &[Mover<S>] {
        // Said to the compiler, which else keeps the code for what cannot be.
        if MOVERS == 0 { &[] } else { &self.movers }
    }

    /// The obstacle points.
    pub fn points(&self) -> impl Iterator<Item = Point<S>> + '_ {
        self.points.iter().map(|obstacle| obstacle.at)
    }
}
