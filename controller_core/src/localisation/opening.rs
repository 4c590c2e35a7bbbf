//! Openings (ours): a door hardly wider than the body is aimed at through its middle, square to its jambs' gap.
//!
//! Target and obstacle fields let the robot slide along a wall and past a narrow door in it: seen at a slant both jambs
//! inhibit the way in, and seen squarely, for the centimetre in which it could turn, the field of a target elsewhere
//! knows nothing of a turn on the spot. So where the wanted direction is hidden, straight **corridors** of the body's
//! width are held against the detected points. One that is free and has a point close by on either side is an opening.
//! The place behind it becomes the target until the robot is through, and is measured anew, more squarely each time, on
//! the way. Fields, neurons and motor control stay as they are; only the centre of the target field moves.

use crate::localisation::corridor::{Corridor, DIRECTIONS};
use crate::scalar::Scalar;
use crate::units::{Point, Polar, Pose, angle_between, wrap};

/// What counts as an opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpeningParameters<S> {
    /// Half the width of a corridor that must be free (m).
    pub half_width_m: S,
    /// Points on either side no farther from the middle than this make a corridor an opening (m); 0: there are none.
    pub flank_m: S,
    /// How far a corridor is looked along (m): no farther than where two beams could have a body between them.
    pub length_m: S,
    /// Openings at most this far from the wanted direction are taken (rad).
    pub aside_rad: S,
    /// Beyond this bearing the robot turns on the spot before it drives (rad); also see [`super::departure`].
    pub turn_rad: S,
    /// 1 / (√2 `σ_ad`) of the target field on the way through, per reach: between jambs shorter steps must do.
    pub distance_steepness: S,
    /// How long one is tried; then none is, for as long (ms).
    pub give_up_ms: u16,
}

/// Where to go, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Way<S> {
    /// The place.
    pub place: Polar<S>,
    /// It is to be turned towards on the spot first.
    pub turn_first: bool,
}

/// The opening that the robot is on its way through.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Opening<S> {
    /// Behind it, in the world.
    behind: Option<Point<S>>,
    /// Since it was found; or what remains of the time in which none is taken.
    elapsed_ms: u16,
}

/// On a detour openings are looked for so far towards the wall from the wanted direction, in the angle that is
/// searched.
const WALL_SIDE: f32 = 0.8;
/// Beyond the jambs, in body radii, that an opening's far place lies.
const BEYOND: f32 = 2.0;

/// Free for the body, with something close on both sides.
fn is_opening<S: Scalar>(p: &OpeningParameters<S>, corridor: &Corridor<S>) -> bool {
    corridor.is_free(p.half_width_m) && corridor.left_m.max(corridor.right_m) < p.flank_m
}

/// The opening with the most room within `aside` of a direction, as a place behind it.
#[inline(never)]
fn find<S: Scalar>(p: &OpeningParameters<S>, wanted: S, aside: S, points: &[Point<S>]) -> Option<Polar<S>> {
    let mut best: Option<(S, Polar<S>)> = None;
    let step = S::TAU / S::from_i32(DIRECTIONS);
    for index in 0..DIRECTIONS {
        let bearing = wrap(step * S::from_i32(index));
        if angle_between(wanted, bearing).abs() > aside {
            continue;
        }
        let corridor = Corridor::along(p.length_m, bearing, points);
        let room = corridor.room_m();
        if is_opening(p, &corridor) && best.is_none_or(|(most, _)| room > most) {
            let distance_m = corridor.depth_m + p.half_width_m * S::from_f32(BEYOND);
            best = Some((room, Polar { bearing_rad: bearing, distance_m }));
        }
    }
    best.map(|(_, place)| place)
}

impl<S: Scalar> Opening<S> {
    /// None under way.
    pub const NONE: Self = Self { behind: None, elapsed_ms: 0 };

    /// Where to go, given the place that is wanted, the side of a detour (see [`super::detour`]), the points detected
    /// now (robot frame), and the pose; `elapsed_ms` after the last time.
    pub fn direct(
        &mut self,
        p: &OpeningParameters<S>,
        wanted: Polar<S>,
        side: Option<S>,
        pose: Pose<S>,
        points: &[Point<S>],
        elapsed_ms: u16,
    ) -> Way<S> {
        let straight = Way { place: wanted, turn_first: false };
        if p.flank_m <= S::ZERO {
            return straight;
        }
        let Some(behind) = self.behind else {
            self.elapsed_ms = self.elapsed_ms.saturating_sub(elapsed_ms);
            let is_open = Corridor::along(p.length_m, wanted.bearing_rad, points).is_free(p.half_width_m);
            if self.elapsed_ms > 0 || is_open || wanted.distance_m < p.length_m {
                return straight;
            }
            // A door in a wall that is followed lies on the wall's side.
            let towards = side.map_or(S::ZERO, |side| side * p.aside_rad * S::from_f32(WALL_SIDE));
            return match find(p, wrap(wanted.bearing_rad - towards), p.aside_rad, points) {
                Some(place) => self.through(p, place, pose),
                None => straight,
            };
        };
        self.elapsed_ms = self.elapsed_ms.saturating_add(elapsed_ms);
        let place = pose.see(behind);
        let is_through = place.distance_m < p.half_width_m * S::from_f32(BEYOND);
        if is_through || self.elapsed_ms >= p.give_up_ms {
            self.behind = None;
            self.elapsed_ms = if is_through { 0 } else { p.give_up_ms };
            return straight;
        }
        match find(p, place.bearing_rad, p.turn_rad, points) {
            // What is measured on the way into it is nearer and more square.
            Some(place) => self.through(p, place, pose),
            None => Way { place, turn_first: place.bearing_rad.abs() > p.turn_rad },
        }
    }

    fn through(&mut self, p: &OpeningParameters<S>, place: Polar<S>, pose: Pose<S>) -> Way<S> {
        let rotation = pose.heading_rad.sin_cos();
        self.behind = Some(pose.to_world_frame(place.to_point(), rotation));
        Way { place, turn_first: place.bearing_rad.abs() > p.turn_rad }
    }

    /// On the way through an opening.
    #[must_use]
    pub fn is_passing(&self) -> bool {
        self.behind.is_some()
    }

    /// Starts afresh, as for a new target.
    pub fn reset(&mut self) {
        *self = Self::NONE;
    }
}

#[cfg(test)]
mod tests {
    use super::{Opening, OpeningParameters};
    use crate::scalar::{Fixed, Scalar};
    use crate::units::{Point, Polar, Pose};

    fn parameters<S: Scalar>() -> OpeningParameters<S> {
        let s = S::from_f32;
        OpeningParameters {
            half_width_m: s(0.028),
            flank_m: s(0.075),
            length_m: s(0.1),
            aside_rad: s(1.5),
            turn_rad: s(0.35),
            distance_steepness: s(4.0),
            give_up_ms: 4000,
        }
    }

    fn polar<S: Scalar>(bearing: f32, distance: f32) -> Polar<S> {
        Polar { bearing_rad: S::from_f32(bearing), distance_m: S::from_f32(distance) }
    }

    /// The jambs of a door of 8 cm in a wall 6 cm to the left of the robot, and the wall beside them.
    fn door<S: Scalar>() -> [Point<S>; 4] {
        [(-0.08, 0.06), (-0.04, 0.06), (0.04, 0.06), (0.08, 0.06)].map(|(x, y)| Point::from_metres(x, y))
    }

    fn check<S: Scalar>() {
        let p = parameters::<S>();
        let pose = Pose { x_m: S::ONE, y_m: S::ZERO, heading_rad: S::ZERO };
        let ahead = [Point::from_metres(0.05, 0.0)];
        let mut opening = Opening::NONE;
        // Free: nothing to look for. Hidden by a wall without a door: nothing to find.
        let target = polar(1.0, 0.5);
        let way = opening.direct(&p, target, None, pose, &[], 256);
        assert!(way.place == target && !way.turn_first);
        assert_eq!(opening.direct(&p, polar(0.0, 0.5), None, pose, &ahead, 256).place, polar(0.0, 0.5));
        // The door is seen squarely while the target lies behind the wall.
        let way = opening.direct(&p, target, None, pose, &door(), 256);
        assert!(opening.is_passing() && way.turn_first);
        assert!((way.place.bearing_rad.to_f32() - core::f32::consts::FRAC_PI_2).abs() < 0.02, "{way:?}");
        assert!(way.place.distance_m.to_f32() > 0.1, "behind the jambs: {way:?}");
        // Turned towards it, it is driven to though the jambs are no longer seen; and left once through.
        let turned = Pose { heading_rad: S::PI * S::HALF, ..pose };
        let way = opening.direct(&p, target, None, turned, &[], 256);
        assert!(!way.turn_first && way.place.bearing_rad.to_f32().abs() < 0.02, "{way:?}");
        let through = Pose { y_m: S::from_f32(0.08), ..turned };
        assert_eq!(opening.direct(&p, target, None, through, &[], 256).place, target);
        assert!(!opening.is_passing());
    }

    #[test]
    fn a_door_beside_the_way_is_taken_squarely() {
        check::<f32>();
        check::<Fixed>();
    }

    #[test]
    fn what_leads_nowhere_is_given_up_for_as_long() {
        let p = parameters::<f32>();
        let mut opening = Opening::NONE;
        let passing: heapless::Vec<bool, 64> = (0..48)
            .map(|_| {
                opening.direct(&p, polar(1.0, 0.5), None, Pose::default(), &door(), 256);
                opening.is_passing()
            })
            .collect();
        let flips = passing.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!(flips, 2, "tried for 4 s, left alone for 4 s, tried again");
    }

    #[test]
    fn on_a_detour_the_wall_side_is_looked_at() {
        let p = OpeningParameters { aside_rad: 1.0, ..parameters::<f32>() };
        // The wall on the left is followed, along it the way is hidden, and the door lies at right angles to it.
        let points = [(0.05, 0.0), (-0.04, 0.06), (0.04, 0.06)].map(|(x, y)| Point::from_metres(x, y));
        for (side, finds) in [(None, false), (Some(1.0), false), (Some(-1.0), true)] {
            let mut opening = Opening::NONE;
            opening.direct(&p, polar(0.0, 0.5), side, Pose::default(), &points, 256);
            assert_eq!(opening.is_passing(), finds, "{side:?}");
        }
    }

    #[test]
    fn none_are_looked_for_where_they_are_switched_off() {
        let p = OpeningParameters { flank_m: 0.0, ..parameters::<f32>() };
        let mut opening = Opening::NONE;
        opening.direct(&p, polar(1.0, 0.5), None, Pose::default(), &door(), 256);
        assert!(!opening.is_passing());
    }
}
