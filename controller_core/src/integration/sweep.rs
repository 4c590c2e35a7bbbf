//! The swept-path check (ours): would the body touch something on the way to a candidate place?
//!
//! An obstacle field judges the *end* of a step by a Gaussian in (α, d). Narrow enough for doors, it leaves the body's
//! flanks unwatched on the way. So the circular arc to a candidate is walked in a few chords, and the disc of the
//! body with a margin is held against the obstacle points seen now or remembered, and against where what moves will be
//! by then ([`crate::localisation::mover`]).

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

/// A chord of the way: where the body is, and where it heads to.
#[derive(Clone, Copy, Debug)]
struct Chord<S> {
    from: Point<S>,
    sin: S,
    cos: S,
}

/// The way to a place.
struct Arc<S> {
    chords: [Chord<S>; CHORDS],
    /// A chord that is driven backwards ends before it begins.
    first: S,
    last: S,
}

impl<S: Scalar> Arc<S> {
    fn to(place: Polar<S>, share: S) -> Self {
        let half_turn = place.bearing_rad;
        // Arc length of a chord: d · α / sin α, as a series that holds within 1 % up to 90°.
        let square = half_turn * half_turn;
        let stretch = S::ONE + square * (S::from_f32(1.0 / 6.0) + square * S::from_f32(0.022));
        let length = place.distance_m * stretch * share * S::from_f32(CHORD_SHARE);
        let turn = (half_turn + half_turn) * share * S::from_f32(CHORD_SHARE);
        let mut from = Point { x_m: S::ZERO, y_m: S::ZERO };
        let mut heading = turn * S::HALF;
        let chords = core::array::from_fn(|_| {
            let (sin, cos) = heading.sin_cos();
            let chord = Chord { from, sin, cos };
            from = Point { x_m: from.x_m + length * cos, y_m: from.y_m + length * sin };
            heading += turn;
            chord
        });
        Self { chords, first: length.min(S::ZERO), last: length.max(S::ZERO) }
    }

    /// How near a chord comes to a place; `None` from `safe` on, which most places are found to be at once.
    #[inline]
    fn distance(&self, chord: &Chord<S>, place: Point<S>, safe: S) -> Option<S> {
        let (x, y) = (place.x_m - chord.from.x_m, place.y_m - chord.from.y_m);
        let aside = y * chord.cos - x * chord.sin;
        if aside.abs() >= safe {
            return None;
        }
        let along = x * chord.cos + y * chord.sin;
        let beyond = along - along.clamp(self.first, self.last);
        if beyond.abs() >= safe || beyond * beyond + aside * aside >= safe * safe {
            return None;
        }
        Some(S::hypot(beyond, aside))
    }
}

/// What of the lack of clearance `safe − distance` counts: as much as the way comes nearer.
fn lack<S: Scalar>(place: Point<S>, safe: S, distance: S) -> S {
    let nearer = S::hypot(place.x_m, place.y_m) - distance;
    if nearer > S::from_f32(ROUNDING_M) { (safe - distance).min(nearer) } else { S::ZERO }
}

/// The lack of clearance on the way to `place`, as inhibition ≥ 0; [`Scalar::LIMIT`] as soon as it is `enough`.
///
/// Only points that the way comes *nearer* to count: a robot that stands too close may always leave. The point that was
/// enough is put first: the next candidate's way often leads to it too. In what order they are, changes nothing else.
pub fn inhibition<S: Scalar>(
    p: &SweepParameters<S>,
    place: Polar<S>,
    obstacles: &mut [Point<S>],
    movers: &[Mover<S>],
    enough: S,
) -> S {
    let arc = Arc::to(place, p.look_ahead);
    let foretold = foretold(p, &arc, movers) * S::from_f32(FORETOLD_SHARE);
    let safe = p.body_radius_m + p.margin_m + p.headway * place.distance_m;
    let mut worst = S::ZERO;
    let mut found = None;
    for (index, obstacle) in obstacles.iter().enumerate() {
        for chord in &arc.chords {
            if let Some(distance) = arc.distance(chord, *obstacle, safe) {
                worst = worst.max(lack(*obstacle, safe, distance));
            }
        }
        if (worst + foretold) * p.strength_per_m >= enough {
            found = Some(index);
            break;
        }
    }
    match found {
        Some(index) => {
            if index < obstacles.len() {
                obstacles.swap(0, index);
            }
            S::LIMIT
        }
        None => (worst + foretold) * p.strength_per_m,
    }
}

/// The lack of clearance to where what moves will be.
fn foretold<S: Scalar>(p: &SweepParameters<S>, arc: &Arc<S>, movers: &[Mover<S>]) -> S {
    let chord_s = p.step_s * p.look_ahead * S::from_f32(CHORD_SHARE);
    let mut worst = S::ZERO;
    for mover in movers {
        let safe = p.body_radius_m + p.body_radius_m + mover.clearance_m;
        // On the middle of a chord the body is nearest to where a mover is then.
        let mut now_s = chord_s * S::HALF;
        for chord in &arc.chords {
            if let Some(distance) = arc.distance(chord, mover.after(now_s), safe) {
                worst = worst.max(lack(mover.at, safe, distance));
            }
            now_s += chord_s;
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::{Mover, SweepParameters, inhibition};
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
        let post = [Point::from_metres(0.08, 0.03)];
        let to = |bearing, distance| {
            let place = Polar { bearing_rad: s(bearing), distance_m: s(distance) };
            inhibition(&p, place, &mut post.clone(), &[], S::LIMIT).to_f32()
        };
        assert!((to(0.0, 0.16) - 1.5).abs() < 0.05, "passes at 30 mm, 5 mm too near: {}", to(0.0, 0.16));
        assert!(to(0.0, 0.02).abs() < 1e-6, "stops before it");
        assert!(to(-0.5, 0.12).abs() < 1e-6, "turns away from it");
        assert!(to(0.36, 0.09) > 2.0, "would drive over it");
        let touching = [Point::from_metres(0.026, 0.0)];
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
