//! What the ways to candidate places are held against, gathered once for each integration.
//!
//! # Crowding (ours)
//! The swept path counts only what a way comes *nearer* to, so a robot that stands too close may always leave. But it
//! need not: to turn on the spot a millimetre or two from a post is as free, and in a narrow place, where all that
//! leads to the target is obstructed, that is what wins, to and fro, until the range of the post is read a step of the
//! sensor too large and the robot turns into it. So as long as something is nearer than [`CROWDED`] says, a way also
//! loses for how near to it it *ends*.

use heapless::Vec;

use crate::integration::neural::Wishes;
use crate::integration::sweep::{self, Obstacle, SweepParameters};
use crate::localisation::mover::Mover;
use crate::scalar::Scalar;
use crate::units::{Point, Polar};

/// Nearer to the body than this, in body radii, is too near to stay: just less than what can be had on both sides in
/// the narrowest gap that is to be passed (5 mm in one of 6 cm), and than one step of the ranges.
pub const CROWDED: f32 = 0.19;

/// What a way loses for each body radius that it ends too near. That it loses is what counts, not how much: anything
/// from 0.5 to 25 measures alike.
const CROWDED_COST: f32 = 1.5;

/// Obstacle points near enough to matter within a step, and what moves; robot frame.
#[derive(Clone, Debug)]
pub struct Ways<S, const POINTS: usize, const MOVERS: usize> {
    points: Vec<Obstacle<S>, POINTS>,
    movers: Vec<Mover<S>, MOVERS>,
    /// The nearest point, if it is too near to stay.
    crowding: Option<Point<S>>,
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
        let mut crowding = None;
        let mut crowded = S::from_f32(1.0 + CROWDED) * p.body_radius_m;
        for point in points {
            // The axis test first: most points are far, and a root is dear.
            if point.x_m.abs() < crowded && point.y_m.abs() < crowded {
                let range_m = S::hypot(point.x_m, point.y_m);
                if range_m < crowded {
                    (crowding, crowded) = (Some(point), range_m);
                }
            }
            // There is room for all.
            if point.x_m.abs() < farthest
                && point.y_m.abs() < farthest
                && kept.push(Obstacle::new(point)).is_err()
            {
                break;
            }
        }
        Self { points: kept, movers, crowding, margin_m }
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
        let inhibition = sweep::inhibition(&p, place, &mut self.points, movers, enough);
        // Last, since few ways come so far.
        if inhibition < enough { inhibition + self.crowding(&p, place) } else { inhibition }
    }

    /// What a way loses because it ends too near to what is too near already.
    #[must_use]
    pub fn crowding(&self, p: &SweepParameters<S>, place: Polar<S>) -> S {
        let Some(nearest) = self.crowding else { return S::ZERO };
        let least = S::from_f32(1.0 + CROWDED) * p.body_radius_m;
        let lack = (least - place.to_point().distance_to(nearest)).max(S::ZERO);
        lack * S::from_f32(CROWDED_COST) / p.body_radius_m
    }

    /// What moves.
    #[must_use]
    pub fn movers(&self) -> &[Mover<S>] {
        // Said to the compiler, which else keeps the code for what cannot be.
        if MOVERS == 0 { &[] } else { &self.movers }
    }

    /// How finely places are told apart: coarsely where something surely moves.
    #[must_use]
    pub fn wishes(&self) -> Wishes {
        if self.movers().iter().any(|mover| mover.is_sure) { Wishes::Coarse } else { Wishes::Fine }
    }

    /// The obstacle points.
    pub fn points(&self) -> impl Iterator<Item = Point<S>> + '_ {
        self.points.iter().map(|obstacle| obstacle.at)
    }
}

#[cfg(test)]
mod tests {
    use heapless::Vec;

    use super::{CROWDED, Ways};
    use crate::config::Config;
    use crate::scalar::{Fixed, Scalar};
    use crate::units::{Point, Polar};

    /// Of a way with a post at `room` body radii ahead of the body.
    fn loss<S: Scalar>(room: f32, bearing: f32, distance: f32) -> f32 {
        let p = Config::default().build::<S, 12>().unwrap();
        let post = Point { x_m: p.sweep.body_radius_m * S::from_f32(1.0 + room), y_m: S::ZERO };
        let mut ways = Ways::<S, 4, 0>::among(
            &p.sweep,
            None,
            p.scaling.reach_m(),
            [Point::from_metres(0.1, 0.1), post].into_iter(),
            Vec::new(),
        );
        let place = Polar { bearing_rad: S::from_f32(bearing), distance_m: S::from_f32(distance) };
        let crowding = ways.crowding(&p.sweep, place).to_f32();
        assert!(crowding >= 0.0 && ways.inhibition(&p.sweep, place, S::LIMIT).to_f32() >= crowding);
        crowding
    }

    fn check<S: Scalar>() {
        let near = CROWDED * 0.5;
        let (turn, back, half) =
            (loss::<S>(near, 1.2, 0.0), loss::<S>(near, 0.0, -0.01), loss::<S>(near, 0.0, -0.001));
        assert!(turn > half && half > back && back <= 0.0, "{}: {turn} {half} {back}", S::NAME);
        // Where there is room enough, nothing is lost, whatever may come of the way.
        assert!(loss::<S>(CROWDED * 1.05, 1.2, 0.0) <= 0.0);
        assert!(loss::<S>(CROWDED * 1.05, 0.0, 0.02) <= 0.0);
    }

    #[test]
    fn what_is_too_near_is_to_be_left() {
        check::<f32>();
        check::<Fixed>();
    }
}
