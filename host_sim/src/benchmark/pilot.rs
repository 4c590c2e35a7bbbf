//! What the planner tells the controller under way: its checkpoints one after the other, or the farthest place of the
//! route that the robot can go straight to.
//!
//! The papers' controller slows down at each checkpoint, since a step shall end there, and turns on to the next one
//! only within millimetres of it. That is what checkpoints at doors are for. A route round many posts has a dozen
//! corners that mean nothing but "not through here". So here the planner goes on looking, and moves the checkpoint
//! ahead along the route as far as the body can go straight with room to spare: as P1 Fig. 9 exchanges a checkpoint
//! under way.
//!
//! Three things keep the robot off corners: bends of the route are moved from them into the middle of gaps, a place
//! that is seen with more room is worth more, and near a wall it is told in which direction to go on rather than a
//! place that is a few centimetres ahead.

use controller_core::planning::{Footprint, is_straight_clear};
use nalgebra::{Point2, Vector2};

use super::course::{PlannedRoute, PlannerMap, footprint};
use crate::number::{narrow, narrow_point};
use crate::world::KHEPERA_RADIUS_M;

/// How a route is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Following {
    /// The controller takes the checkpoints as they are, one after the other.
    Checkpoints,
    /// The checkpoint moves along the route, ahead of the robot, as far as there is a straight clear way to it.
    Sight,
}

/// Between two places of the route that are looked at, in m.
const STEP_M: f64 = 0.01;

/// How far ahead along the route is looked, in m: beyond the sensors' and a step's reach.
const HORIZON_M: f64 = 0.5;

/// Where nothing is in sight, the checkpoint is so far ahead, in m: the reach of a sidestep.
const BLIND_M: f64 = 0.05;

/// Looks without anything of the route in sight after which there is a new one: a second.
const BLIND_LOOKS: u32 = 8;

/// Room beside the body that is asked for in turn, in m. More than the first does not make a way better.
const ROOMS_M: [f32; 12] =
    [0.02, 0.0175, 0.015, 0.0125, 0.01, 0.0075, 0.005, 0.004, 0.003, 0.002, 0.001, 0.0];

/// Seeing farther than this makes a way no better, in m: a step's reach.
const REACH_M: f64 = 0.16;

/// A place nearer than this is a direction to the controller: it is moved out along the straight way, in m.
///
/// Openings are not looked for on the way to a target that is nearer than they are searched, 0.128 m. Beside a door the
/// place in it is; the near jamb then pushes the robot past it, and it creeps at the jamb until it touches it. So what
/// counts is that this is more than that length.
const DIRECTION_M: f64 = 0.14;

/// Where the route ahead has less room than this beside the body, in m, places are handed out as they are: hardly wider
/// than the body, a gap is no opening to imprecise ranges, and the robot would wait before it.
const NARROW_M: f32 = 0.0075;

/// How far a bend of the route is moved at once, in m.
const MOVES_M: [f64; 3] = [0.0025, 0.005, 0.01];

/// Directions in which it can be.
const MOVE_DIRECTIONS: u32 = 16;

/// How often all bends are moved.
const MOVE_ROUNDS: u32 = 8;

/// What is left of the body's radius where it asks whether it sees something at all.
const ALONE_SHARE: f32 = 0.9;

/// A route and how far the robot has come on it.
#[derive(Debug, Clone)]
pub struct Pilot<'a> {
    map: &'a PlannerMap,
    goal: Point2<f64>,
    /// The body with so much room beside it, in m: the most first.
    roomy: Vec<(f32, Footprint)>,
    /// The body with [`NARROW_M`].
    narrow: Footprint,
    /// The body alone, nearly: its own place must not count as a wall when it has come too near to one.
    alone: Footprint,
    /// The start, and the checkpoints.
    places: Vec<Point2<f64>>,
    /// Way along the route to the place nearest to the robot, in m; never shrinks.
    progress_m: f64,
    /// Looks since something of the route was in sight.
    blind: u32,
}

impl<'a> Pilot<'a> {
    /// A pilot at the start of a route.
    #[must_use]
    pub fn new(
        map: &'a PlannerMap,
        route: &PlannedRoute,
        start: Point2<f64>,
        goal: Point2<f64>,
    ) -> Option<Self> {
        let alone = Footprint::new(ALONE_SHARE * narrow(KHEPERA_RADIUS_M), 0.0).ok()?;
        let roomy = ROOMS_M.into_iter().filter_map(|room_m| Some((room_m, footprint(room_m).ok()?)));
        let mut pilot = Self {
            map,
            goal,
            roomy: roomy.collect(),
            narrow: footprint(NARROW_M).ok()?,
            alone,
            places: Vec::new(),
            progress_m: 0.0,
            blind: 0,
        };
        pilot.follow(route, start);
        Some(pilot)
    }

    /// Takes a new route.
    fn follow(&mut self, route: &PlannedRoute, start: Point2<f64>) {
        self.places = core::iter::once(start).chain(route.plan.checkpoints.iter().copied()).collect();
        // The plan's goal is rounded to `f32`; the goal itself is told apart by its value.
        if let Some(last) = self.places.last_mut() {
            *last = self.goal;
        }
        self.progress_m = 0.0;
        self.blind = 0;
        self.ease();
    }

    /// Moves the bends away from the corners that the shortest way hugs, where there is room: into the middle of doors.
    ///
    /// A plan has the same margin everywhere, that of its tightest gap. A bend moves to where the body has more room,
    /// as long as the straight ways to its neighbours do not lose any.
    fn ease(&mut self) {
        for _ in 0..MOVE_ROUNDS {
            let mut has_moved = false;
            for index in 1..self.places.len().saturating_sub(1) {
                if let Some(place) = self.roomier(index) {
                    self.places[index] = place;
                    has_moved = true;
                }
            }
            if !has_moved {
                break;
            }
        }
    }

    /// A place near a bend with more room, if there is one.
    fn roomier(&self, index: usize) -> Option<Point2<f64>> {
        let [before, here, next] =
            [index.checked_sub(1)?, index, index + 1].map(|i| self.places.get(i).copied());
        let (before, here, next) = (before?, here?, next?);
        let keeps =
            |from, to, rank: usize| self.roomy.get(rank).is_some_and(|(_, disc)| self.sees(from, to, disc));
        let rank = |from, to| (0..self.roomy.len()).find(|&rank| keeps(from, to, rank));
        let (mut most, joins) = (rank(here, here)?, (rank(before, here)?, rank(here, next)?));
        let mut best = None;
        for length_m in MOVES_M {
            for direction in 0..MOVE_DIRECTIONS {
                let angle = f64::from(direction) / f64::from(MOVE_DIRECTIONS) * core::f64::consts::TAU;
                let place = here + Vector2::new(libm::cos(angle), libm::sin(angle)) * length_m;
                let Some(more) = (0..most).find(|&rank| keeps(place, place, rank)) else { continue };
                if keeps(before, place, joins.0) && keeps(place, next, joins.1) {
                    (most, best) = (more, Some(place));
                }
            }
        }
        best
    }

    /// Where the robot at `here` is to go: the place ahead on the route to go straight to, or one beyond it in the same
    /// direction. To be asked every 128 ms.
    ///
    /// A robot that avoidance has pushed to where nothing of the route is in sight gets a new route after a second.
    pub fn target(&mut self, here: Point2<f64>) -> Point2<f64> {
        if self.blind >= BLIND_LOOKS {
            // Too near to a wall for a route: it goes on with the old one, and asks again in a second.
            self.blind = 0;
            if let Ok(route) = self.map.route(here, self.goal) {
                self.follow(&route, here);
            }
        }
        self.advance(here);
        let target = self.best(here).or_else(|| self.farthest(here, &self.alone).map(|(_, place)| place));
        self.blind = if target.is_some() { 0 } else { self.blind + 1 };
        let target = target.unwrap_or_else(|| self.at(self.progress_m + BLIND_M));
        if target == self.goal || self.is_roomy(here) || self.is_narrow_ahead() {
            return target;
        }
        moved_out(here, target)
    }

    /// The place in sight that is far and has much room on the way to it: what is seen past a corner with little room
    /// counts less than what is seen with more, though nearer.
    fn best(&self, here: Point2<f64>) -> Option<Point2<f64>> {
        let mut best: Option<(f64, Point2<f64>)> = None;
        for (room_m, disc) in &self.roomy {
            if !self.sees(here, here, disc) {
                continue;
            }
            let Some((ahead_m, place)) = self.farthest(here, disc) else { continue };
            let value = ahead_m.min(REACH_M) / REACH_M + f64::from(room_m / ROOMS_M[0]);
            if best.is_none_or(|(most, _)| value > most) {
                best = Some((value, place));
            }
            if ahead_m >= REACH_M {
                // With less room there is nothing better.
                break;
            }
        }
        best.map(|(_, place)| place)
    }

    /// The end of the first stretch ahead that is in sight of this disc, and how far along the route it is, in m.
    fn farthest(&self, here: Point2<f64>, disc: &Footprint) -> Option<(f64, Point2<f64>)> {
        let mut ahead_m = STEP_M;
        let mut target = None;
        while ahead_m <= HORIZON_M {
            let place = self.at(self.progress_m + ahead_m);
            if self.sees(here, place, disc) {
                target = Some((ahead_m, place));
            } else if target.is_some() {
                break;
            }
            ahead_m += STEP_M;
        }
        target
    }

    /// There is as much room beside the body as is ever asked for: nothing that it could creep along.
    fn is_roomy(&self, here: Point2<f64>) -> bool {
        self.roomy.first().is_some_and(|(_, disc)| self.sees(here, here, disc))
    }

    /// The route over the next step has a place with less room than [`NARROW_M`].
    fn is_narrow_ahead(&self) -> bool {
        let mut ahead_m = 0.0;
        while ahead_m <= REACH_M {
            let place = self.at(self.progress_m + ahead_m);
            if !self.sees(place, place, &self.narrow) {
                return true;
            }
            ahead_m += STEP_M;
        }
        false
    }

    fn sees(&self, here: Point2<f64>, place: Point2<f64>, disc: &Footprint) -> bool {
        is_straight_clear(&*self.map.raster, disc, narrow_point(here), narrow_point(place))
    }

    /// Moves on along the route to what is nearest of it; what is behind a wall is not near.
    fn advance(&mut self, here: Point2<f64>) {
        let mut best = (self.progress_m, (self.at(self.progress_m) - here).norm());
        let mut ahead_m = STEP_M;
        while ahead_m <= 0.5 * HORIZON_M {
            let place = self.at(self.progress_m + ahead_m);
            let distance = (place - here).norm();
            if distance < best.1 && self.sees(here, place, &self.alone) {
                best = (self.progress_m + ahead_m, distance);
            }
            ahead_m += STEP_M;
        }
        self.progress_m = best.0;
    }

    /// The place so far along the route, in m; the goal beyond its end.
    fn at(&self, way_m: f64) -> Point2<f64> {
        let mut left_m = way_m;
        for ends in self.places.windows(2) {
            let length = (ends[1] - ends[0]).norm();
            if left_m < length {
                return ends[0] + (ends[1] - ends[0]) * (left_m / length);
            }
            left_m -= length;
        }
        self.places.last().copied().unwrap_or(self.goal)
    }
}

/// The place, or one [`DIRECTION_M`] away in its direction if it is nearer.
fn moved_out(here: Point2<f64>, place: Point2<f64>) -> Point2<f64> {
    let way = place - here;
    let length_m = way.norm();
    // On the place itself there is no direction.
    if (f64::EPSILON..DIRECTION_M).contains(&length_m) {
        here + way * (DIRECTION_M / length_m)
    } else {
        place
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::{DIRECTION_M, Pilot, moved_out};
    use crate::benchmark::Ground;
    use crate::import::{GridMap, MapFrame};

    /// Two rooms of 4 x 3 cells of 10 cm, and a door of one cell in the wall between them.
    fn rooms() -> Ground {
        let rows = ["....", "....", "....", "@.@@", "....", "....", "...."];
        let passable = rows.iter().flat_map(|row| row.chars().map(|cell| cell == '.')).collect();
        let (name, source) = (String::from("rooms"), String::from("drawn here"));
        let (columns, rows) = (4, rows.len());
        Ground::new(GridMap { name, source, columns, rows, cell_m: 0.1, frame: MapFrame::IDENTITY, passable })
            .unwrap()
    }

    fn at(x: f64, y: f64) -> Point2<f64> {
        Point2::new(x, y)
    }

    #[test]
    fn bends_of_the_route_stand_off_from_the_jambs() {
        let ground = rooms();
        let (start, goal) = (at(0.35, 0.25), at(0.35, 0.45));
        let route = ground.route(start, goal).unwrap();
        let pilot = Pilot::new(&ground.planner, &route, start, goal).unwrap();
        let jambs = [at(0.1, 0.3), at(0.2, 0.3), at(0.1, 0.4), at(0.2, 0.4)];
        let off = |places: &[Point2<f64>]| {
            let all = places.iter().flat_map(|place| jambs.map(|jamb| (place - jamb).norm()));
            all.fold(f64::INFINITY, f64::min)
        };
        let (planned, eased) = (off(&route.plan.checkpoints), off(&pilot.places));
        assert!(eased > planned + 0.005, "{eased} {planned}");
        assert_eq!((pilot.places.first(), pilot.places.last()), (Some(&start), Some(&goal)));
    }

    #[test]
    fn beside_a_wall_a_near_place_is_a_direction_and_the_goal_is_not() {
        let ground = rooms();
        // Close to the wall beside the door: the door is near, and what is behind it is hidden.
        let (here, goal) = (at(0.26, 0.268), at(0.35, 0.45));
        let route = ground.route(at(0.35, 0.15), goal).unwrap();
        let mut pilot = Pilot::new(&ground.planner, &route, at(0.35, 0.15), goal).unwrap();
        let target = pilot.target(here);
        assert!((target - here).norm() >= DIRECTION_M - 1e-9, "{target}");
        let near = at(0.35, 0.43);
        let route = ground.route(near, goal).unwrap();
        let mut pilot = Pilot::new(&ground.planner, &route, near, goal).unwrap();
        assert_eq!(pilot.target(near), goal);
    }

    #[test]
    fn places_are_moved_out_along_their_direction() {
        let out = moved_out(at(1.0, 1.0), at(1.0, 1.05));
        assert!((out - at(1.0, 1.0 + DIRECTION_M)).norm() < 1e-12, "{out}");
        for place in [at(1.0, 1.0), at(1.5, 1.0)] {
            assert_eq!(moved_out(at(1.0, 1.0), place), place);
        }
    }
}
