//! What the planner tells the controller under way: its checkpoints one after the other, or the farthest place of the
//! route that the robot can go straight to.
//!
//! The papers' controller slows down at each checkpoint, since a step shall end there, and turns on to the next one
//! only within millimetres of it. That is what checkpoints at doors are for. A route round many posts has a dozen
//! corners that mean nothing but "not through here". So here the planner goes on looking, and moves the checkpoint
//! ahead along the route as far as the body, with some room, can go straight: as P1 Fig. 9 exchanges a checkpoint under
//! way.

use controller_core::planning::{Footprint, is_straight_clear};
use nalgebra::Point2;

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

/// Room beside the body that is kept on the straight way, in m. Less than a route in the open has, or nothing beyond
/// the next corner would be in sight before the robot is there.
const ROOM_M: f32 = 0.005;

/// And at most this share of the route's room, in gaps that are tight: cutting their corners costs contacts.
const ROOM_SHARE: f32 = 0.95;

/// What is left of the body's radius where it asks whether it sees something at all.
const ALONE_SHARE: f32 = 0.9;

/// A route and how far the robot has come on it.
#[derive(Debug, Clone)]
pub struct Pilot<'a> {
    map: &'a PlannerMap,
    goal: Point2<f64>,
    /// The body with the room that it needs on a straight way.
    with_room: Footprint,
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
        let mut pilot =
            Self { map, goal, with_room: alone, alone, places: Vec::new(), progress_m: 0.0, blind: 0 };
        pilot.follow(route, start);
        Some(pilot)
    }

    /// Takes a new route.
    fn follow(&mut self, route: &PlannedRoute, start: Point2<f64>) {
        self.with_room = footprint(ROOM_M.min(ROOM_SHARE * route.margin_m)).unwrap_or(self.alone);
        self.places = core::iter::once(start).chain(route.plan.checkpoints.iter().copied()).collect();
        self.progress_m = 0.0;
        self.blind = 0;
    }

    /// Where the robot at `here` is to go: the farthest place ahead on the route that it can go straight to. To be
    /// asked every 128 ms.
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
        let target = self.farthest(here, &self.with_room).or_else(|| self.farthest(here, &self.alone));
        self.blind = if target.is_some() { 0 } else { self.blind + 1 };
        target.unwrap_or_else(|| self.at(self.progress_m + BLIND_M))
    }

    /// The end of the first stretch ahead that is in sight of this disc.
    fn farthest(&self, here: Point2<f64>, disc: &Footprint) -> Option<Point2<f64>> {
        let mut ahead_m = STEP_M;
        let mut target = None;
        while ahead_m <= HORIZON_M {
            let place = self.at(self.progress_m + ahead_m);
            if self.sees(here, place, disc) {
                target = Some(place);
            } else if target.is_some() {
                break;
            }
            ahead_m += STEP_M;
        }
        target
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
