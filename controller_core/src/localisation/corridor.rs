//! Corridors (ours): straight ways from the robot's centre, and what flanks them.

use crate::scalar::Scalar;
use crate::units::{Point, wrap};

/// Directions around the robot that are tried.
pub const DIRECTIONS: i32 = 36;

/// What flanks a straight way from the robot's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corridor<S> {
    /// Nearest point to the left of its middle line (m).
    pub left_m: S,
    /// And to the right (m).
    pub right_m: S,
    /// How far along the farther of them lies (m).
    pub depth_m: S,
}

impl<S: Scalar> Corridor<S> {
    /// The corridor of `length_m` at `bearing` (rad, robot frame) between obstacle points.
    // Once in flash, though asked from several places.
    #[inline(never)]
    #[must_use]
    pub fn along(length_m: S, bearing: S, points: &[Point<S>]) -> Self {
        let (sin, cos) = bearing.sin_cos();
        let mut corridor = Self { left_m: S::LIMIT, right_m: S::LIMIT, depth_m: S::ZERO };
        let (mut left_at, mut right_at) = (S::ZERO, S::ZERO);
        for point in points {
            let along = point.x_m * cos + point.y_m * sin;
            if along <= S::ZERO || along >= length_m {
                continue;
            }
            let aside = point.y_m * cos - point.x_m * sin;
            if aside >= S::ZERO && aside < corridor.left_m {
                (corridor.left_m, left_at) = (aside, along);
            }
            if aside <= S::ZERO && -aside < corridor.right_m {
                (corridor.right_m, right_at) = (-aside, along);
            }
        }
        corridor.depth_m = left_at.max(right_at);
        corridor
    }

    /// Room on the narrower side (m).
    #[must_use]
    pub fn room_m(&self) -> S {
        self.left_m.min(self.right_m)
    }

    /// Something `half_width_m` to either side passes.
    #[must_use]
    pub fn is_free(&self, half_width_m: S) -> bool {
        self.room_m() > half_width_m
    }
}

/// The first direction, from `bearing` on and turning towards `side` (+1 left, −1 right), whose corridor of
/// `length_m` is
/// free; `bearing` itself where none is.
#[must_use]
pub fn turned_free<S: Scalar>(
    (half_width_m, length_m): (S, S),
    bearing: S,
    side: S,
    points: &[Point<S>],
) -> S {
    let step = side * S::TAU / S::from_i32(DIRECTIONS);
    let mut tried = bearing;
    for _ in 0..DIRECTIONS / 2 {
        if Corridor::along(length_m, tried, points).is_free(half_width_m) {
            return tried;
        }
        tried = wrap(tried + step);
    }
    bearing
}

#[cfg(test)]
mod tests {
    use super::{Corridor, turned_free};
    use crate::scalar::{Fixed, Scalar};
    use crate::units::Point;

    fn check<S: Scalar>() {
        let s = S::from_f32;
        // A wall to the left and a post ahead on the right: the wedge that a robot following the wall drives into.
        let points = [(0.0, 0.033), (0.02, 0.033), (0.03, -0.012)].map(|(x, y)| Point::from_metres(x, y));
        let ahead = Corridor::along(s(0.045), S::ZERO, &points);
        assert!(
            (ahead.left_m.to_f32() - 0.033).abs() < 1e-4 && (ahead.right_m.to_f32() - 0.012).abs() < 1e-4
        );
        assert!(!ahead.is_free(s(0.028)) && ahead.is_free(s(0.01)));
        let turned = turned_free((s(0.028), s(0.045)), S::ZERO, -S::ONE, &points).to_f32();
        assert!((-1.7..-1.4).contains(&turned), "past the post: {turned}");
        let left = turned_free((s(0.028), s(0.045)), S::ZERO, S::ONE, &points).to_f32();
        assert!(!(-0.5..2.0).contains(&left), "back from the wall: {left}");
        let free = turned_free((s(0.028), s(0.045)), s(0.4), S::ONE, &[]);
        assert_eq!(free, s(0.4), "nothing near");
    }

    #[test]
    fn turns_away_from_what_it_would_lead_into() {
        check::<f32>();
        check::<Fixed>();
    }

    #[test]
    fn keeps_the_direction_where_none_is_free() {
        let ring = [(0.026, 0.0), (-0.026, 0.0), (0.0, 0.026), (0.0, -0.026)];
        let points = ring.map(|(x, y)| Point::from_metres(x, y));
        assert!(turned_free::<f32>((0.028, 0.045), 0.3, 1.0, &points) - 0.3 < 1e-6);
    }
}
