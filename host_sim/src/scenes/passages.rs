//! Narrow ways: doors, corridors, gaps between posts.

use core::f64::consts::PI;

use nalgebra::Point2;

use super::build::{Disturbance, Draft, block, centimetres, direction, post, room};
use crate::scenario::Scenario;

/// A start is drawn from a disc of this radius.
const JITTER_M: f64 = 0.01;

/// A door in the middle of a wall that cuts a closed room in two: there is no other way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Door {
    /// Width of the door in m.
    pub width_m: f64,
    /// Angle at which the straight way from start to goal passes the door's middle, within ±45.
    pub approach_deg: f64,
}

/// Half the thickness of the wall, in m.
const HALF_WALL_M: f64 = 0.025;
/// From the door's middle to start and goal, in m.
const FROM_DOOR_M: f64 = 0.30;

impl Door {
    /// As [`super::Scene::name`].
    #[must_use]
    pub fn name(&self) -> String {
        format!("door_{}_{:+}", centimetres(self.width_m), self.approach_deg)
    }

    /// The door as an experiment: its middle is the origin, the wall lies along y.
    #[must_use]
    pub fn scenario(&self, disturbance: &Disturbance) -> Scenario {
        let (half_x, half_y) = (0.5, 0.35);
        let half = self.width_m / 2.0;
        let wall = [
            block((-HALF_WALL_M, half), (HALF_WALL_M, half_y)),
            block((-HALF_WALL_M, -half_y), (HALF_WALL_M, -half)),
        ];
        let (along, heading_rad) = direction(self.approach_deg);
        Draft {
            name: self.name(),
            title: format!("Door of {} cm at {:+} degrees", centimetres(self.width_m), self.approach_deg),
            start: Point2::origin() - along * FROM_DOOR_M,
            heading_rad,
            jitter_m: JITTER_M,
            jitter_rad: PI / 6.0,
            goal: Point2::origin() + along * FROM_DOOR_M,
            time_limit_s: 120.0,
            shapes: room((-half_x, -half_y), (half_x, half_y)).chain(wall.into_iter().flatten()).collect(),
            movers: Vec::new(),
        }
        .finish(disturbance)
    }
}

/// A corridor with a bend to the left and one to the right, which the goal lies behind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corridor {
    /// Width in m.
    pub width_m: f64,
}

impl Corridor {
    /// As [`super::Scene::name`].
    #[must_use]
    pub fn name(&self) -> String {
        format!("corridor_{}", centimetres(self.width_m))
    }

    /// The corridor as an experiment: 0.4 m ahead, 0.3 m to the left, 0.4 m ahead.
    #[must_use]
    pub fn scenario(&self, disturbance: &Disturbance) -> Scenario {
        let width = self.width_m;
        let half = width / 2.0;
        let (bend, rise, length) = (0.4, 0.3, 0.8);
        let walls = [
            // Below and above, from the start to the end.
            block((-0.10, -half - 0.02), (bend + half, -half)),
            block((-0.10, half), (bend - half, rise + half)),
            block((bend + half, -half - 0.02), (length + 0.1, rise - half)),
            block((bend - half - 0.02, rise + half), (length + 0.1, rise + half + 0.02)),
            // Its ends.
            block((-0.12, -half - 0.02), (-0.10, rise + half)),
            block((length + 0.1, -half - 0.02), (length + 0.12, rise + half + 0.02)),
        ];
        Draft {
            name: self.name(),
            title: format!("Corridor of {} cm with two bends", centimetres(width)),
            start: Point2::origin(),
            heading_rad: 0.0,
            // It must fit where the robot hardly does.
            jitter_m: JITTER_M.min((half - 0.026).max(0.0)),
            jitter_rad: PI / 6.0,
            goal: Point2::new(length, rise),
            time_limit_s: 120.0,
            shapes: walls.into_iter().flatten().collect(),
            movers: Vec::new(),
        }
        .finish(disturbance)
    }
}

/// Posts in four rows across the way in a closed room, each row's posts behind the gaps of the one before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slalom {
    /// Between two posts of a row, in m; the next row is half as far again.
    pub gap_m: f64,
}

/// Radius of a post, in m.
const POST_M: f64 = 0.015;

impl Slalom {
    /// As [`super::Scene::name`].
    #[must_use]
    pub fn name(&self) -> String {
        format!("slalom_{}", centimetres(self.gap_m))
    }

    /// The posts as an experiment.
    #[must_use]
    pub fn scenario(&self, disturbance: &Disturbance) -> Scenario {
        let pitch = self.gap_m + 2.0 * POST_M;
        let half_height = 0.3;
        let mut shapes: Vec<_> = Vec::new();
        let mut x = 0.0;
        for row in 0..4 {
            let shift = if row % 2 == 0 { 0.0 } else { pitch / 2.0 };
            let mut y = shift;
            while y < half_height + POST_M {
                shapes.push(post(x, y, POST_M));
                if y > 0.0 {
                    shapes.push(post(x, -y, POST_M));
                }
                y += pitch;
            }
            x += pitch;
        }
        let end = x - pitch;
        shapes.extend(room((-0.35, -half_height), (end + 0.35, half_height)));
        Draft {
            name: self.name(),
            title: format!("Rows of posts {} cm apart", centimetres(self.gap_m)),
            start: Point2::new(-0.25, 0.0),
            heading_rad: 0.0,
            jitter_m: JITTER_M,
            jitter_rad: PI / 6.0,
            goal: Point2::new(end + 0.25, 0.0),
            time_limit_s: 120.0,
            shapes,
            movers: Vec::new(),
        }
        .finish(disturbance)
    }
}
