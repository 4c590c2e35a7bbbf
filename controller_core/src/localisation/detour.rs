//! The detour (ours): when the target has not come nearer for a while, the target field follows the wall instead.
//!
//! Cooperative EKMs slide along an obstacle as long as that brings the robot nearer to the target. Deep in a U nothing
//! near does, and the robot swings between the corners. After `patience` without progress it therefore **commits to a
//! side**: the target is taken to lie along the nearest obstacle, which keeps the fields, the neurons and the motor
//! control as they are and only moves the centre of the target field. The detour ends when the robot is nearer to the
//! target than ever before and sees it free, which no wall can make happen twice at the same place (the leave condition
//! of the Bug algorithms: Lumelsky and Stepanov 1987; Kamon and Rivlin 1997). A side that leads nowhere is given up for
//! the other, each time after twice as long.
//!
//! Giving way to what moves is no want of progress: a robot that has left a doorway for it would take the doorway for a
//! dead end, since no place but the doorway itself is nearer than ever. So all is forgotten then, a detour under way
//! included. But walls' ends seem to move at times, and would keep the robot from following any wall to where it can be
//! left: only a few detours are given up before the target is reached.

use crate::localisation::corridor::turned_free;
use crate::scalar::Scalar;
use crate::units::{Point, Polar, Pose, angle_between, wrap};

/// When and how to follow a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DetourParameters<S> {
    /// Time without progress after which a detour begins (ms); 0 switches detours off.
    pub patience_ms: u16,
    /// Coming nearer by this much is progress (m); near the target a fifth of the distance is.
    pub progress_m: S,
    /// Distance from the robot's centre at which a wall is followed (m).
    pub follow_m: S,
    /// 1 / `follow_m`.
    pub per_follow: S,
    /// Bearings this close to the target's must be free to end a detour (rad).
    pub free_rad: S,
    /// Obstacles farther than this do not hide the target (m).
    pub free_m: S,
    /// Time after which the other side is tried, the first time (ms).
    pub side_ms: u16,
    /// The way along the wall must be free for so far (m), or it is turned away from the wall until it is; 0: it
    /// need not.
    pub clear_m: S,
    /// Half the width that must be free (m).
    pub half_width_m: S,
}

/// So many detours are given up for what moves until the target is reached or another. Without a bound the maze of
/// Kheperax is left in 20 % of runs, with none given up in 96, but then others come late: 2 to 3 % of P2 Fig. 7, and a
/// tenth where gaps between posts are 7 cm. From two on the figures are as without a bound.
const GIVEN_UP_MAX: u8 = 3;

/// A detour under way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Following<S> {
    /// +1: the wall is kept on the right, −1: on the left.
    side: S,
    /// Where the wall was when it was last seen, in the world.
    wall: Point<S>,
    elapsed_ms: u32,
    give_up_ms: u32,
}

/// Progress towards the current target, and the detour if there is one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Detour<S> {
    nearest_m: Option<S>,
    stuck_ms: u16,
    following: Option<Following<S>>,
    /// Detours that were given up for what moves.
    given_up: u8,
}

/// The detection nearest to the robot.
fn nearest<S: Scalar>(detections: impl Iterator<Item = Polar<S>>) -> Option<Polar<S>> {
    detections.reduce(|near, next| if next.distance_m < near.distance_m { next } else { near })
}

impl<S: Scalar> Detour<S> {
    /// Nothing known, no detour under way.
    pub const NONE: Self = Self { nearest_m: None, stuck_ms: 0, following: None, given_up: 0 };

    /// Takes note of where the target is, `elapsed_ms` after the last time, and says where to go: the target itself, or
    /// a place along the wall. `detections` and `points` are what is seen now in the robot frame, the same in polar
    /// coordinates but for what is not to be followed.
    pub fn direct(
        &mut self,
        p: &DetourParameters<S>,
        pose: Pose<S>,
        target: Polar<S>,
        detections: &[Polar<S>],
        points: &[Point<S>],
        elapsed_ms: u16,
    ) -> Polar<S> {
        if p.patience_ms == 0 {
            return target;
        }
        let best = self.nearest_m.unwrap_or(target.distance_m);
        // The last centimetre before a target is made in steps of less than a centimetre.
        let progress = p.progress_m.min(best * S::from_f32(0.2));
        let has_progressed = target.distance_m < best - progress;
        if self.nearest_m.is_none() || has_progressed {
            self.nearest_m = Some(target.distance_m);
            self.stuck_ms = 0;
        } else {
            self.stuck_ms = self.stuck_ms.saturating_add(elapsed_ms);
        }
        if let Some(following) = &mut self.following {
            if has_progressed && is_free(p, target, detections) {
                self.following = None;
                return target;
            }
            return following.along(p, pose, target, detections, points, elapsed_ms);
        }
        // What is near and can be seen can be driven to: a robot that is fine-positioning at a checkpoint needs no
        // detour. What only seems to be free can hold the robot for ever: the far side of a U is seen late.
        let is_near = target.distance_m < p.free_m;
        if self.stuck_ms < p.patience_ms || is_near && is_free(p, target, detections) {
            return target;
        }
        let Some(wall) = nearest(detections.iter().copied()) else { return target };
        // The side on which the target lies of the wall is the shorter way round, as far as can be seen.
        let turn = angle_between(wall.bearing_rad, target.bearing_rad);
        let side = if turn < S::ZERO { -S::ONE } else { S::ONE };
        let wall = pose.to_world_frame(wall.to_point(), pose.heading_rad.sin_cos());
        let mut following = Following { side, wall, elapsed_ms: 0, give_up_ms: u32::from(p.side_ms) };
        let place = following.along(p, pose, target, detections, points, 0);
        self.following = Some(following);
        place
    }

    /// The wall that is being followed: +1 with it on the right, −1 on the left.
    #[must_use]
    pub fn side(&self) -> Option<S> {
        self.following.map(|following| following.side)
    }

    /// The wall being followed: +1 where it is kept on the right, −1 on the left, and where it was when last seen.
    #[must_use]
    pub fn following(&self) -> Option<(S, Point<S>)> {
        self.following.map(|following| (following.side, following.wall))
    }

    /// Starts afresh since something moves, as far as detours may be given up for that.
    pub fn give_way(&mut self) {
        let given_up = self.given_up + u8::from(self.following.is_some());
        if given_up <= GIVEN_UP_MAX {
            *self = Self { given_up, ..Self::NONE };
        }
    }

    /// Starts afresh, as for a new target.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

/// No obstacle hides the target.
fn is_free<S: Scalar>(p: &DetourParameters<S>, target: Polar<S>, detections: &[Polar<S>]) -> bool {
    let hides = |obstacle: &Polar<S>| {
        angle_between(obstacle.bearing_rad, target.bearing_rad).abs() < p.free_rad
            && obstacle.distance_m < p.free_m.min(target.distance_m)
    };
    !detections.iter().any(hides)
}

impl<S: Scalar> Following<S> {
    /// The nearest detection on the side where the wall is kept, or nearly ahead. In a doorway the far post may be the
    /// nearest of all; to follow it would lead back out.
    fn nearest_aside(&self, detections: &[Polar<S>]) -> Option<Polar<S>> {
        let quarter_turn = S::PI * S::HALF;
        let limit = quarter_turn + S::from_f32(0.3);
        let aside = |obstacle: &Polar<S>| {
            angle_between(-(self.side * quarter_turn), obstacle.bearing_rad).abs() < limit
        };
        nearest(detections.iter().copied().filter(aside))
    }

    /// A place along the wall: at right angles to it, leaning towards it where it is farther than wished.
    fn along(
        &mut self,
        p: &DetourParameters<S>,
        pose: Pose<S>,
        target: Polar<S>,
        detections: &[Polar<S>],
        points: &[Point<S>],
        elapsed_ms: u16,
    ) -> Polar<S> {
        self.elapsed_ms = self.elapsed_ms.saturating_add(u32::from(elapsed_ms));
        if self.elapsed_ms >= self.give_up_ms {
            self.side = -self.side;
            self.elapsed_ms = 0;
            self.give_up_ms = self.give_up_ms.saturating_mul(2);
        }
        if let Some(wall) = self.nearest_aside(detections) {
            self.wall = pose.to_world_frame(wall.to_point(), pose.heading_rad.sin_cos());
        }
        let wall = pose.see(self.wall);
        let farther = ((wall.distance_m - p.follow_m) * p.per_follow).clamp(-S::ONE, S::ONE);
        let quarter_turn = S::PI * S::HALF;
        let along = wrap(wall.bearing_rad + self.side * (quarter_turn - farther * S::HALF));
        // Where two walls meet, each is nearest in turn and leads into the other.
        let bearing = turned_free((p.half_width_m, p.clear_m), along, self.side, points);
        // As far as the target is, within reason: a far place is driven to at full speed.
        Polar { bearing_rad: bearing, distance_m: target.distance_m.max(p.free_m + p.free_m) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Detour, DetourParameters, GIVEN_UP_MAX};
    use crate::scalar::{Fixed, Scalar};
    use crate::units::{Point, Polar, Pose};

    fn parameters<S: Scalar>() -> DetourParameters<S> {
        let s = S::from_f32;
        DetourParameters {
            patience_ms: 1000,
            progress_m: s(0.01),
            follow_m: s(0.05),
            per_follow: s(20.0),
            free_rad: s(0.4),
            free_m: s(0.12),
            side_ms: 4000,
            clear_m: s(0.045),
            half_width_m: s(0.028),
        }
    }

    fn polar<S: Scalar>(bearing: f32, distance: f32) -> Polar<S> {
        Polar { bearing_rad: S::from_f32(bearing), distance_m: S::from_f32(distance) }
    }

    fn check<S: Scalar>() {
        let p = parameters::<S>();
        let mut detour = Detour::<S>::default();
        let ahead = polar(0.0, 0.5);
        let wall = [polar(-0.1, 0.05)];
        for _ in 0..5 {
            assert_eq!(detour.direct(&p, Pose::default(), ahead, &wall, &[], 200), ahead, "patient");
        }
        let along = detour.direct(&p, Pose::default(), ahead, &wall, &[], 200);
        assert_eq!(detour.side(), Some(S::ONE));
        assert!(
            (along.bearing_rad.to_f32() - (core::f32::consts::FRAC_PI_2 - 0.1)).abs() < 1e-3,
            "{along:?}"
        );
        // Nearer than ever, but hidden: it goes on.
        let nearer = polar(-0.1, 0.3);
        detour.direct(&p, Pose::default(), nearer, &wall, &[], 200);
        assert!(detour.side().is_some());
        // Nearer still, and free.
        let free = polar(1.5, 0.2);
        assert_eq!(detour.direct(&p, Pose::default(), free, &wall, &[], 200), free);
        assert_eq!(detour.side(), None);
    }

    #[test]
    fn follows_the_wall_until_nearer_than_ever_and_free() {
        check::<f32>();
        check::<Fixed>();
    }

    #[test]
    fn a_wall_that_is_lost_stays_where_it_was() {
        let p = DetourParameters { patience_ms: 1, ..parameters::<f32>() };
        let mut detour = Detour::default();
        let (target, wall) = (polar(0.0, 0.5), [polar(0.0, 0.05)]);
        detour.direct(&p, Pose::default(), target, &wall, &[], 200);
        let along = detour.direct(&p, Pose::default(), target, &wall, &[], 200);
        // The robot turns towards it, and sees the wall no more: in the world the way is the same.
        let turned = Pose { heading_rad: along.bearing_rad, ..Pose::default() };
        let again = detour.direct(&p, turned, target, &[], &[], 200);
        assert!(again.bearing_rad.abs() < 1e-5, "straight on: {again:?}");
    }

    #[test]
    fn the_way_along_a_wall_keeps_out_of_corners() {
        let p = DetourParameters { patience_ms: 1, ..parameters::<f32>() };
        let mut detour = Detour::default();
        let (target, wall) = (polar(0.0, 0.5), [polar(-0.1, 0.035)]);
        // Along the wall, to the left, is another.
        let corner = [wall[0].to_point(), Point::from_metres(0.0, 0.034), Point::from_metres(-0.02, 0.034)];
        detour.direct(&p, Pose::default(), target, &wall, &corner, 200);
        let along = detour.direct(&p, Pose::default(), target, &wall, &corner, 200);
        assert!(along.bearing_rad.abs() > 2.3, "turned away from both: {along:?}");
    }

    #[test]
    fn only_a_few_detours_are_given_up_for_what_moves() {
        let p = parameters::<f32>();
        let mut detour = Detour::default();
        let (ahead, wall) = (polar(0.0, 0.5), [polar(-0.1, 0.05)]);
        let follow = |detour: &mut Detour<f32>| {
            for _ in 0..6 {
                detour.direct(&p, Pose::default(), ahead, &wall, &[], 200);
            }
            assert!(detour.side().is_some());
        };
        for _ in 0..GIVEN_UP_MAX {
            // Without a detour that is free of charge.
            detour.give_way();
            follow(&mut detour);
            detour.give_way();
            assert_eq!(detour.side(), None);
        }
        follow(&mut detour);
        detour.give_way();
        assert!(detour.side().is_some(), "no more");
        detour.reset();
        follow(&mut detour);
        detour.give_way();
        assert_eq!(detour.side(), None, "another target");
    }

    #[test]
    fn what_is_free_but_not_come_nearer_to_is_gone_round() {
        let p = parameters::<f32>();
        let wall = [polar(2.0, 0.05)];
        for (distance, follows) in [(0.5, true), (0.1, false)] {
            let mut detour = Detour::default();
            for _ in 0..10 {
                detour.direct(&p, Pose::default(), polar(0.0, distance), &wall, &[], 200);
            }
            assert_eq!(detour.side().is_some(), follows, "a free target {distance} m away");
        }
    }

    #[test]
    fn a_side_that_leads_nowhere_is_given_up() {
        let p = parameters::<f32>();
        let mut detour = Detour::default();
        let (ahead, wall) = (polar(0.0, 0.5), [polar(-0.1, 0.05)]);
        let sides: heapless::Vec<bool, 128> = (0..80)
            .map(|_| detour.direct(&p, Pose::default(), ahead, &wall, &[], 200).bearing_rad > 0.1)
            .collect();
        let flips = sides.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!(flips, 3, "begins, then changes after 4 s and after 8 s more");
    }
}
