//! What the planner tells the controller under way: its checkpoints one after the other, or the farthest place of the
//! route that the robot can go straight to.
//!
//! The papers' controller slows down at each checkpoint, since a step shall end there, and turns on to the next one only
//! within millimetres of it. That is what checkpoints at doors are for. A route round many posts has a dozen corners
//! that mean nothing but "not through here". So here the planner goes on looking, and moves the checkpoint ahead
//! along the route as far as the body, with some room, can go straight: as P1 Fig. 9 exchanges a checkpoint under way.

use controller_core::planning::{Footprint, is_straight_clear};
use nalgebra::Point2;

use super::course::{PlannedRoute, footprint};
use crate::number::narrow_point;
use crate::raster::Raster;

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

/// Share of the route's room beside the body that must be kept on the straight way. Less than all of it, or nothing
/// beyond the next corner would be in sight before the robot is there.
const ROOM_SHARE: f32 = 0.5;

/// A route and how far the robot has come on it.
#[derive(Debug, Clone)]
pub struct Pilot<'a> {
    raster: &'a Raster,
    footprint: Footprint,
    /// The start, and the checkpoints.
    places: Vec<Point2<f64>>,
    /// Way along the route to the place nearest to the robot, in m; never shrinks.
    progress_m: f64,
}

impl<'a> Pilot<'a> {
    /// A pilot at the start of a route.
    #[must_use]
    pub fn new(raster: &'a Raster, route: &PlannedRoute, start: Point2<f64>) -> Option<Self> {
        let footprint = footprint(ROOM_SHARE * route.margin_m).ok()?;
        let places = core::iter::once(start).chain(route.plan.checkpoints.iter().copied()).collect();
        Some(Self { raster, footprint, places, progress_m: 0.0 })
    }

    /// Where the robot at `here` is to go: the farthest place ahead on the route that it can go straight to.
    pub fn target(&mut self, here: Point2<f64>) -> Point2<f64> {
        self.advance(here);
        let mut target = None;
        let mut ahead_m = STEP_M;
        while ahead_m <= HORIZON_M {
            let place = self.at(self.progress_m + ahead_m);
            if is_straight_clear(self.raster, &self.footprint, narrow_point(here), narrow_point(place)) {
                target = Some(place);
            } else if target.is_some() {
                break;
            }
            ahead_m += STEP_M;
        }
        target.unwrap_or_else(|| self.at(self.progress_m + BLIND_M))
    }

    /// Moves on along the route while that comes nearer to the robot.
    fn advance(&mut self, here: Point2<f64>) {
        let mut best = (self.progress_m, (self.at(self.progress_m) - here).norm());
        let mut ahead_m = STEP_M;
        // A place farther along is taken only where it is nearer: loops of the route are not cut short.
        while ahead_m <= 0.5 * HORIZON_M {
            let distance = (self.at(self.progress_m + ahead_m) - here).norm();
            if distance < best.1 {
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
        self.places.last().copied().unwrap_or_else(Point2::origin)
    }
}
