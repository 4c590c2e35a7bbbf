//! The trail (ours): places the robot has just been to inhibit a little, so that it does not go there again.
//!
//! In a dead end target and obstacles hold each other and the robot swings to and fro. A weak, fading inhibition
//! around its own recent path tips that balance ("avoid the past", after Balch and Arkin, 1993): without it the
//! prototype got out of no U it had been put into, with it out of all up to 30 × 25 cm.

use heapless::Deque;

use crate::scalar::Scalar;
use crate::units::{Point, Pose};

/// How strongly and how long the past inhibits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrailParameters<S> {
    /// Inhibition at a fresh point of the trail; 0 switches the trail off.
    pub strength: S,
    /// Radius of its cone (m).
    pub radius_m: S,
    /// 1 / radius (per m).
    pub per_radius: S,
    /// Way between two points (m).
    pub spacing_m: S,
    /// Points fade linearly over this time (ms).
    pub lifetime_ms: u16,
    /// 1 / lifetime (per second).
    pub fading_per_s: S,
    /// Points younger than this do not inhibit yet: the robot is still there (ms).
    pub silent_ms: u16,
}

/// One point of the trail.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trodden<S> {
    at: Point<S>,
    age_ms: u16,
}

/// The trail, at most `POINTS` long; the oldest end is dropped.
#[derive(Clone, Debug)]
pub struct Trail<S, const POINTS: usize> {
    points: Deque<Trodden<S>, POINTS>,
}

impl<S, const POINTS: usize> Default for Trail<S, POINTS> {
    fn default() -> Self {
        Self { points: Deque::new() }
    }
}

/// A point of the trail in the robot frame and how much it inhibits at its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Avoided<S> {
    /// Robot frame.
    pub at: Point<S>,
    /// Inhibition at the centre.
    pub strength: S,
}

impl<S: Scalar, const POINTS: usize> Trail<S, POINTS> {
    /// Lets `elapsed_ms` pass and adds the present position where it is far enough from the last point.
    pub fn extend(&mut self, p: &TrailParameters<S>, here: Point<S>, elapsed_ms: u16) {
        if p.strength <= S::ZERO {
            return;
        }
        for point in &mut self.points {
            point.age_ms = point.age_ms.saturating_add(elapsed_ms);
        }
        while self.points.front().is_some_and(|point| point.age_ms >= p.lifetime_ms) {
            self.points.pop_front();
        }
        if self.points.back().is_none_or(|last| last.at.distance_to(here) >= p.spacing_m) {
            if self.points.is_full() {
                self.points.pop_front();
            }
            // Cannot fail: there is room now.
            let _ = self.points.push_back(Trodden { at: here, age_ms: 0 });
        }
    }

    /// The inhibiting points, in the robot frame.
    pub fn seen_from<'a>(
        &'a self,
        p: &'a TrailParameters<S>,
        pose: Pose<S>,
    ) -> impl Iterator<Item = Avoided<S>> + 'a {
        let rotation = pose.heading_rad.sin_cos();
        self.points.iter().filter(move |point| point.age_ms >= p.silent_ms).map(move |point| {
            let age_s = S::from_i32(i32::from(point.age_ms)) / S::from_i32(1000);
            let left = (S::ONE - age_s * p.fading_per_s).clamp(S::ZERO, S::ONE);
            Avoided { at: pose.to_robot_frame(point.at, rotation), strength: p.strength * left }
        })
    }

    /// Forgets the past, as when a checkpoint is reached: the way back may be the way on.
    pub fn clear(&mut self) {
        self.points.clear();
    }
}

/// The inhibition that a point of the trail gives to a place of the robot frame: a cone.
#[must_use]
pub fn inhibition<S: Scalar>(p: &TrailParameters<S>, avoided: &Avoided<S>, place: Point<S>) -> S {
    let (dx, dy) = (place.x_m - avoided.at.x_m, place.y_m - avoided.at.y_m);
    if dx.abs() >= p.radius_m || dy.abs() >= p.radius_m {
        return S::ZERO;
    }
    let near = (S::ONE - S::hypot(dx, dy) * p.per_radius).max(S::ZERO);
    avoided.strength * near
}

#[cfg(test)]
mod tests {
    use super::{Trail, TrailParameters, inhibition};
    use crate::scalar::{Fixed, Scalar};
    use crate::units::{Point, Pose};

    fn check<S: Scalar>() {
        let s = S::from_f32;
        let p = TrailParameters {
            strength: s(0.03),
            radius_m: s(0.07),
            per_radius: s(1.0 / 0.07),
            spacing_m: s(0.018),
            lifetime_ms: 10_000,
            fading_per_s: s(0.1),
            silent_ms: 1000,
        };
        let mut trail = Trail::<S, 4>::default();
        for step in 0..6_u8 {
            trail.extend(&p, Point::from_metres(0.02 * f32::from(step), 0.0), 500);
            trail.extend(&p, Point::from_metres(0.02 * f32::from(step) + 0.001, 0.0), 0);
        }
        let seen: heapless::Vec<_, 4> = trail.seen_from(&p, Pose::default()).collect();
        assert_eq!(seen.len(), 2, "four points kept, the two youngest silent: {seen:?}");
        assert!((seen[0].at.x_m.to_f32() - 0.04).abs() < 2e-3);
        assert!((seen[0].strength.to_f32() - 0.03 * 0.85).abs() < 1e-4);
        assert!((inhibition(&p, &seen[0], seen[0].at) - seen[0].strength).abs() < s(1e-5));
        assert_eq!(inhibition(&p, &seen[0], Point::from_metres(0.2, 0.0)), S::ZERO);
        trail.extend(&p, Point::from_metres(5.0, 0.0), 10_000);
        assert_eq!(trail.seen_from(&p, Pose::default()).count(), 0, "faded");
    }

    #[test]
    fn the_past_inhibits_and_fades() {
        check::<f32>();
        check::<Fixed>();
    }
}
