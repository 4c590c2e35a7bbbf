//! The swept-path check (ours): would the body touch something on the way to a candidate place?
//!
//! An obstacle field judges the *end* of a step by a Gaussian in (α, d). Narrow enough for doors, it leaves the body's
//! flanks unwatched on the way. So the circular arc to a candidate is walked in a few chords, and the disc of the
//! body with a margin is held against the obstacle points seen now or remembered, and against where what moves will be
//! by then ([`crate::localisation::mover`]).

use heapless::Vec;

use crate::localisation::mover::Mover;
use crate::scalar::Scalar;
use crate::units::{Point, Polar};

/// The numbers of the check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepParameters<S> {
    /// Body radius (m).
    pub body_radius_m: S,
    /// Clearance wished beyond the body (m).
    pub margin_m: S,
    /// Inhibition per lack of clearance (per m); 0 switches the check off.
    pub strength_per_m: S,
    /// Share of the step that is checked: the next command comes long before the step ends.
    pub look_ahead: S,
    /// Further clearance wished, per length of the step.
    pub headway: S,
    /// Duration of a step (s).
    pub step_s: S,
}

/// Chords that stand for the arc.
const CHORDS: usize = 4;

/// What a chord is of the arc.
const CHORD_SHARE: f32 = 0.25;

/// What the way to what moves counts for beside the way to what stands: a place that is seen is surer than one that is
/// foretold.
const FORETOLD_SHARE: f32 = 0.2;

/// Coming nearer by less is rounding (m): a turn on the spot does not come nearer.
const ROUNDING_M: f32 = 1e-5;

/// A chord of the way: where it begins, and where it heads to.
#[derive(Clone, Copy, Debug)]
struct Chord<S> {
    from: Point<S>,
    sin: S,
    cos: S,
}

/// The way to a place: an arc as chords of one length, each turned by the same against the one before.
struct Arc<S> {
    /// Those that have been asked for.
    chords: Vec<Chord<S>, CHORDS>,
    length: S,
    sin_turn: S,
    cos_turn: S,
}

impl<S: Scalar> Arc<S> {
    fn to(place: Polar<S>, share: S) -> Self {
        let half_turn = place.bearing_rad;
        // Arc length of a chord: d · α / sin α, as a series that holds within 1 % up to 90°.
        let square = half_turn * half_turn;
        let stretch = S::ONE + square * (S::from_f32(1.0 / 6.0) + square * S::from_f32(0.022));
        let share = share * S::from_f32(CHORD_SHARE);
        let (sin, cos) = (half_turn * share).sin_cos();
        // One sine and one cosine do for all chords.
        let (sin_turn, cos_turn) = ((sin + sin) * cos, S::ONE - (sin + sin) * sin);
        let first = Chord { from: Point { x_m: S::ZERO, y_m: S::ZERO }, sin, cos };
        let length = place.distance_m * stretch * share;
        Self { chords: core::iter::once(first).collect(), length, sin_turn, cos_turn }
    }

    fn chord(&mut self, index: usize) -> Option<Chord<S>> {
        if index == self.chords.len()
            && let Some(&Chord { from, sin, cos }) = self.chords.last()
        {
            // There is room for all that are asked for.
            let _ = self.chords.push(Chord {
                from: Point { x_m: from.x_m + self.length * cos, y_m: from.y_m + self.length * sin },
                sin: sin * self.cos_turn + cos * self.sin_turn,
                cos: cos * self.cos_turn - sin * self.sin_turn,
            });
        }
        self.chords.get(index).copied()
    }
}

impl<S: Scalar> Chord<S> {
    /// Beside and beyond the chord, how far a place lies; `None` where either is at least `bound`, as for most.
    #[inline]
    fn offset(&self, length: S, place: Point<S>, bound: S) -> Option<(S, S)> {
        let (x, y) = (place.x_m - self.from.x_m, place.y_m - self.from.y_m);
        let aside = y * self.cos - x * self.sin;
        if aside.abs() >= bound {
            return None;
        }
        let along = x * self.cos + y * self.sin;
        // A chord that is driven backwards ends before it begins.
        let beyond = along - along.clamp(length.min(S::ZERO), length.max(S::ZERO));
        (beyond.abs() < bound).then_some((aside, beyond))
    }
}

/// The length of a vector where it is shorter than `bound`.
fn shorter<S: Scalar>((a, b): (S, S), bound: S) -> Option<S> {
    (bound > S::ZERO && a * a + b * b < bound * bound).then(|| S::hypot(a, b))
}

/// Something that the body must not touch, robot frame.
#[derive(Clone, Copy, Debug)]
pub struct Obstacle<S> {
    /// Where.
    pub at: Point<S>,
    /// How far; 0 as long as nobody has asked.
    range_m: S,
}

impl<S: Scalar> Obstacle<S> {
    /// An obstacle at a place.
    #[must_use]
    pub const fn new(at: Point<S>) -> Self {
        Self { at, range_m: S::ZERO }
    }

    /// How far it is: found out once, and for few of all.
    fn range_m(&mut self) -> S {
        if self.range_m <= S::ZERO {
            self.range_m = S::hypot(self.at.x_m, self.at.y_m);
        }
        self.range_m
    }
}

/// The lack of clearance on the way to `place`, as inhibition ≥ 0; [`Scalar::LIMIT`] as soon as it is `enough`.
///
/// Only points that the way comes *nearer* to count: a robot that stands too close may always leave. The point that was
/// enough is put first: the next candidate's way often leads to it too. In what order they are, changes nothing else.
pub fn inhibition<S: Scalar>(
    p: &SweepParameters<S>,
    place: Polar<S>,
    obstacles: &mut [Obstacle<S>],
    movers: &[Mover<S>],
    enough: S,
) -> S {
    let mut arc = Arc::to(place, p.look_ahead);
    let foretold = foretold(p, &mut arc, movers) * S::from_f32(FORETOLD_SHARE);
    let safe = p.body_radius_m + p.margin_m + p.headway * place.distance_m.abs();
    let mut worst = S::ZERO;
    let mut found = None;
    'all: for (index, obstacle) in obstacles.iter_mut().enumerate() {
        for chord in 0..CHORDS {
            let Some(chord) = arc.chord(chord) else { break };
            let Some(offset) = chord.offset(arc.length, obstacle.at, safe - worst) else { continue };
            // No more counts than the way comes nearer.
            let counts_from = safe.min(obstacle.range_m() - S::from_f32(ROUNDING_M));
            let Some(distance) = shorter(offset, counts_from - worst) else { continue };
            worst = counts_from - distance;
            if (worst + foretold) * p.strength_per_m >= enough {
                found = Some(index);
                break 'all;
            }
        }
    }
    let Some(index) = found else { return (worst + foretold) * p.strength_per_m };
    if let Some((first, others)) = obstacles.split_first_mut()
        && let Some(other) = others.get_mut(index.wrapping_sub(1))
    {
        core::mem::swap(first, other);
    }
    S::LIMIT
}

/// The lack of clearance to where what moves will be.
fn foretold<S: Scalar>(p: &SweepParameters<S>, arc: &mut Arc<S>, movers: &[Mover<S>]) -> S {
    let chord_s = p.step_s * p.look_ahead * S::from_f32(CHORD_SHARE);
    let mut worst = S::ZERO;
    for mover in movers {
        let safe = p.body_radius_m + p.body_radius_m + mover.clearance_m;
        let counts_from = safe.min(S::hypot(mover.at.x_m, mover.at.y_m) - S::from_f32(ROUNDING_M));
        // On the middle of a chord the body is nearest to where a mover is then.
        let mut now_s = chord_s * S::HALF;
        for chord in 0..CHORDS {
            let Some(chord) = arc.chord(chord) else { break };
            let offset = chord.offset(arc.length, mover.after(now_s), counts_from - worst);
            if let Some(distance) = offset.and_then(|offset| shorter(offset, counts_from - worst)) {
                worst = counts_from - distance;
            }
            now_s += chord_s;
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::{Mover, Obstacle, SweepParameters, inhibition};
    use crate::scalar::{Fixed, Scalar};
    use crate::units::{Point, Polar};

    fn parameters<S: Scalar>() -> SweepParameters<S> {
        SweepParameters {
            body_radius_m: S::from_f32(0.025),
            margin_m: S::from_f32(0.01),
            strength_per_m: S::from_f32(300.0),
            look_ahead: S::ONE,
            headway: S::ZERO,
            step_s: S::ONE,
        }
    }

    fn check<S: Scalar>() {
        let s = S::from_f32;
        let p = parameters::<S>();
        let post = [Obstacle::new(Point::from_metres(0.08, 0.03))];
        let to = |bearing, distance| {
            let place = Polar { bearing_rad: s(bearing), distance_m: s(distance) };
            inhibition(&p, place, &mut post.clone(), &[], S::LIMIT).to_f32()
        };
        assert!((to(0.0, 0.16) - 1.5).abs() < 0.05, "passes at 30 mm, 5 mm too near: {}", to(0.0, 0.16));
        assert!(to(0.0, 0.02).abs() < 1e-6, "stops before it");
        assert!(to(-0.5, 0.12).abs() < 1e-6, "turns away from it");
        assert!(to(0.36, 0.09) > 2.0, "would drive over it");
        // A way back asks for as much room as one ahead.
        let mirrored = [Obstacle::new(Point::from_metres(-0.08, -0.03))];
        let hasty = SweepParameters { headway: s(0.1), ..p };
        let lack = |at: f32, post: &[Obstacle<S>; 1]| {
            let place = Polar { bearing_rad: S::ZERO, distance_m: s(at) };
            inhibition(&hasty, place, &mut post.clone(), &[], S::LIMIT).to_f32()
        };
        assert!((lack(0.16, &post) - lack(-0.16, &mirrored)).abs() < 0.05, "{}", lack(-0.16, &mirrored));
        assert!(lack(-0.16, &mirrored) > 6.0, "{}", lack(-0.16, &mirrored));
        let touching = [Obstacle::new(Point::from_metres(0.026, 0.0))];
        let away = Polar { bearing_rad: s(1.57), distance_m: S::ZERO };
        assert!(
            inhibition(&p, away, &mut touching.clone(), &[], S::LIMIT) <= S::ZERO,
            "a turn on the spot is always free"
        );
    }

    fn check_movers<S: Scalar>() {
        let s = S::from_f32;
        let p = parameters::<S>();
        // From the left across the way, 10 cm ahead.
        let mover = |turn| Mover {
            at: Point::from_metres(0.1, 0.1),
            velocity_mps: Point::from_metres(0.0, -0.1),
            turn_radps: s(turn),
            clearance_m: s(0.01),
            is_sure: true,
        };
        let to = |bearing, distance, turn| {
            let place = Polar { bearing_rad: s(bearing), distance_m: s(distance) };
            inhibition(&p, place, &mut [], &[mover(turn)], S::LIMIT).to_f32()
        };
        assert!(to(0.0, 0.16, 0.0) > 1.0, "they meet: {}", to(0.0, 0.16, 0.0));
        assert!(to(0.0, 0.01, 0.0).abs() < 1e-6, "it passes a robot that waits: {}", to(0.0, 0.01, 0.0));
        assert!(to(0.0, -0.04, 0.0).abs() < 1e-6, "and one that backs away");
        assert!(to(0.0, 0.01, -1.2) > 0.1, "unless it turns towards it: {}", to(0.0, 0.01, -1.2));
    }

    #[test]
    fn what_the_body_would_meet_inhibits() {
        check_movers::<f32>();
        check_movers::<Fixed>();
    }

    #[test]
    fn what_the_body_would_touch_inhibits() {
        check::<f32>();
        check::<Fixed>();
    }
}
