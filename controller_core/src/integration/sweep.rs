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

/// Points of the arc that are checked after the start.
const CHORDS: i32 = 4;

/// What the way to what moves counts for beside the way to what stands: a place that is seen is surer than one that is
/// foretold.
const FORETOLD_SHARE: f32 = 0.2;

/// Coming nearer by less is rounding (m): a turn on the spot does not come nearer.
const ROUNDING_M: f32 = 1e-5;

/// The lack of clearance on the way to `place`, as inhibition ≥ 0.
///
/// Only points that the way comes *nearer* to count: a robot that stands too close may always leave.
pub fn inhibition<'a, S: Scalar>(
    p: &SweepParameters<S>,
    place: Polar<S>,
    obstacles: impl Iterator<Item = &'a Point<S>> + Clone,
    movers: &[Mover<S>],
) -> S {
    let (share, half_turn) = (p.look_ahead, place.bearing_rad);
    // Arc length of a chord: d · α / sin α, as a series that holds within 1 % up to 90°.
    let square = half_turn * half_turn;
    let stretch = S::ONE + square * (S::from_f32(1.0 / 6.0) + square * S::from_f32(0.022));
    let chords = S::from_i32(CHORDS);
    let length = place.distance_m * stretch * share / chords;
    let turn = (half_turn + half_turn) * share / chords;
    let safe = p.body_radius_m + p.margin_m + p.headway * place.distance_m;
    let safe_square = safe * safe;
    let mut at = Point { x_m: S::ZERO, y_m: S::ZERO };
    let mut heading = turn * S::HALF;
    let mut worst = S::ZERO;
    let mut worst_foretold = S::ZERO;
    let chord_s = p.step_s * share / chords;
    // On the middle of a chord the body is nearest to where a mover is then.
    let mut now_s = chord_s * S::HALF;
    // A chord that is driven backwards ends before it begins.
    let (first, last) = (length.min(S::ZERO), length.max(S::ZERO));
    for _ in 0..CHORDS {
        let (sin, cos) = heading.sin_cos();
        // Beside the chord, and beyond its ends; apart, since most places are far aside.
        let aside_of = |place: Point<S>| (place.y_m - at.y_m) * cos - (place.x_m - at.x_m) * sin;
        let beyond_of = |place: Point<S>| {
            let along = (place.x_m - at.x_m) * cos + (place.y_m - at.y_m) * sin;
            along - along.clamp(first, last)
        };
        for mover in movers {
            let safe = p.body_radius_m + p.body_radius_m + mover.clearance_m;
            let there = mover.after(now_s);
            let (beyond, aside) = (beyond_of(there), aside_of(there));
            if beyond.abs() < safe && aside.abs() < safe {
                let distance = S::hypot(beyond, aside);
                let nearer = S::hypot(mover.at.x_m, mover.at.y_m) - distance;
                if nearer > S::from_f32(ROUNDING_M) {
                    worst_foretold = worst_foretold.max((safe - distance).min(nearer));
                }
            }
        }
        now_s += chord_s;
        for obstacle in obstacles.clone() {
            let aside = aside_of(*obstacle);
            if aside.abs() >= safe {
                continue;
            }
            let beyond = beyond_of(*obstacle);
            if beyond.abs() >= safe || beyond * beyond + aside * aside >= safe_square {
                continue;
            }
            let distance = S::hypot(beyond, aside);
            let now = S::hypot(obstacle.x_m, obstacle.y_m);
            let nearer = now - distance;
            if nearer > S::from_f32(ROUNDING_M) {
                worst = worst.max((safe - distance).min(nearer));
            }
        }
        at = Point { x_m: at.x_m + length * cos, y_m: at.y_m + length * sin };
        heading += turn;
    }
    (worst + worst_foretold * S::from_f32(FORETOLD_SHARE)) * p.strength_per_m
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
            inhibition(&p, Polar { bearing_rad: s(bearing), distance_m: s(distance) }, post.iter(), &[])
                .to_f32()
        };
        assert!((to(0.0, 0.16) - 1.5).abs() < 0.05, "passes at 30 mm, 5 mm too near: {}", to(0.0, 0.16));
        assert!(to(0.0, 0.02).abs() < 1e-6, "stops before it");
        assert!(to(-0.5, 0.12).abs() < 1e-6, "turns away from it");
        assert!(to(0.36, 0.09) > 2.0, "would drive over it");
        let touching = [Point::from_metres(0.026, 0.0)];
        let away = Polar { bearing_rad: s(1.57), distance_m: S::ZERO };
        assert!(inhibition(&p, away, touching.iter(), &[]) <= S::ZERO, "a turn on the spot is always free");
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
            inhibition(&p, place, [].iter(), &[mover(turn)]).to_f32()
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
