//! A short memory of obstacles (ours): what a sensor saw half a second ago is still there, though the beam has moved
//! on.
//!
//! Between two beams at 30° a wall's end or a thin post disappears just when the robot passes it. The memory holds
//! the last detections as points of the world, carried by odometry, for `lifetime_ms`; they take part in the
//! swept-path check ([`crate::integration::sweep`]) only. Longer memories close narrow doors, because range noise
//! thickens walls.

use heapless::Vec;

use crate::scalar::Scalar;
use crate::units::{Point, Pose};

/// How long and how finely obstacles are remembered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MemoryParameters<S> {
    /// Points older than this are forgotten (ms); 0 remembers nothing.
    pub lifetime_ms: u16,
    /// A new point this close to an old one replaces it (m).
    pub merge_m: S,
}

/// The remembered points, at most `POINTS`; where they do not suffice the oldest go first. One that is too old stays in
/// its place until another needs it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObstacleMemory<S, const POINTS: usize> {
    points: Vec<Point<S>, POINTS>,
    /// Of each point; apart from them, since together they would be padded.
    ages_ms: Vec<u16, POINTS>,
}

impl<S: Scalar, const POINTS: usize> ObstacleMemory<S, POINTS> {
    /// Nothing remembered.
    pub const EMPTY: Self = Self { points: Vec::new(), ages_ms: Vec::new() };

    /// Lets `elapsed_ms` pass.
    pub fn age(&mut self, elapsed_ms: u16) {
        for age_ms in &mut self.ages_ms {
            *age_ms = age_ms.saturating_add(elapsed_ms);
        }
    }

    /// Remembers a point of the world.
    pub fn remember(&mut self, p: &MemoryParameters<S>, at: Point<S>) {
        if p.lifetime_ms == 0 {
            return;
        }
        let near = |old: &Point<S>| {
            // The axis test first: most points are far, and a root is dear.
            (old.x_m - at.x_m).abs() < p.merge_m
                && (old.y_m - at.y_m).abs() < p.merge_m
                && old.distance_to(at) < p.merge_m
        };
        let mut entries = self.points.iter_mut().zip(&mut self.ages_ms);
        if let Some((point, age_ms)) = entries.find(|(point, age_ms)| **age_ms < p.lifetime_ms && near(point))
        {
            (*point, *age_ms) = (at, 0);
        } else if self.points.push(at).is_ok() {
            // As many as points.
            let _ = self.ages_ms.push(0);
        } else {
            let entries = self.points.iter_mut().zip(&mut self.ages_ms);
            if let Some((point, age_ms)) = entries.max_by_key(|(_, age_ms)| **age_ms) {
                (*point, *age_ms) = (at, 0);
            }
        }
    }

    /// The points that are not too old, in the robot frame.
    pub fn seen_from(&self, p: &MemoryParameters<S>, pose: Pose<S>) -> impl Iterator<Item = Point<S>> + '_ {
        let rotation = pose.heading_rad.sin_cos();
        let lifetime_ms = p.lifetime_ms;
        let entries = self.points.iter().zip(&self.ages_ms);
        let kept = entries.filter(move |(_, age_ms)| **age_ms < lifetime_ms);
        kept.map(move |(&point, _)| pose.to_robot_frame(point, rotation))
    }

    /// Forgets everything, as when the pose has jumped.
    pub fn clear(&mut self) {
        self.points.clear();
        self.ages_ms.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::{MemoryParameters, ObstacleMemory};
    use crate::scalar::{Fixed, Scalar};
    use crate::units::{Point, Pose};

    fn check<S: Scalar>() {
        let p = MemoryParameters { lifetime_ms: 500, merge_m: S::from_f32(0.014) };
        let mut memory = ObstacleMemory::<S, 3>::default();
        memory.remember(&p, Point::from_metres(1.0, 0.0));
        memory.age(128);
        memory.remember(&p, Point::from_metres(1.01, 0.0));
        assert_eq!(memory.seen_from(&p, Pose::default()).count(), 1, "merged");
        for x in [2.0, 3.0, 4.0] {
            memory.age(50);
            memory.remember(&p, Point::from_metres(x, 0.0));
        }
        let pose = Pose { x_m: S::ONE, y_m: S::ZERO, heading_rad: S::PI * S::HALF };
        let seen: heapless::Vec<f32, 3> = memory.seen_from(&p, pose).map(|at| -at.y_m.to_f32()).collect();
        assert_eq!(seen.len(), 3);
        assert!(
            (seen.iter().copied().fold(f32::MAX, f32::min) - 1.0).abs() < 1e-4,
            "the oldest went: {seen:?}"
        );
        memory.age(500);
        assert_eq!(memory.seen_from(&p, pose).count(), 0, "forgotten");
    }

    #[test]
    fn remembers_merges_and_forgets() {
        check::<f32>();
        check::<Fixed>();
    }
}
