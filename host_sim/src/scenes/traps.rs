//! Traps: a U between the robot and its goal, and a wall whose end hides the goal.

use core::f64::consts::PI;
use core::fmt::{self, Display, Formatter};

use nalgebra::Point2;
use serde::Serialize;

use super::build::{Disturbance, Draft, WALL_M, block, centimetres, direction};
use crate::scenario::Scenario;
use crate::world::KHEPERA_RADIUS_M;

/// Where the robot starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Before the mouth of the U, heading for the goal.
    Outside,
    /// Inside, near the bottom, with any heading.
    Inside,
}

impl Display for Side {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Outside => "from outside",
            Self::Inside => "from inside",
        })
    }
}

/// A U that opens towards where the robot comes from; its goal lies behind the bottom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trap {
    /// Inner width in m.
    pub width_m: f64,
    /// Inner depth in m.
    pub depth_m: f64,
    /// Where the robot starts.
    pub side: Side,
    /// Angle between the axis of the U and the straight way to the goal, within ±80.
    pub approach_deg: f64,
}

/// From the mouth to a start outside, in m.
const BEFORE_MOUTH_M: f64 = 0.25;
/// From the bottom to the goal, in m.
const BEHIND_BOTTOM_M: f64 = 0.30;
/// Between the body and the bottom where the robot starts inside.
const FROM_BOTTOM_M: f64 = 0.035;
/// A start is drawn from a disc of this radius.
const JITTER_M: f64 = 0.01;
/// Time for everything but the trap, in s.
const TIME_S: f64 = 60.0;
/// And for each metre of the U's inside: enough to follow it all at a third of c*, there and back.
const TIME_S_PER_M: f64 = 60.0;

impl Trap {
    /// As [`super::Scene::name`].
    #[must_use]
    pub fn name(&self) -> String {
        let side = match self.side {
            Side::Outside => "out",
            Side::Inside => "in",
        };
        let (width, depth) = (centimetres(self.width_m), centimetres(self.depth_m));
        format!("trap_{side}_{width}x{depth}_{:+}", self.approach_deg)
    }

    /// The trap as an experiment. The bottom's inner face is at x = 0, the U opens towards −x.
    #[must_use]
    pub fn scenario(&self, disturbance: &Disturbance) -> Scenario {
        let (half, depth) = (self.width_m / 2.0, self.depth_m);
        let outer = half + WALL_M;
        let shapes = [
            block((0.0, -outer), (WALL_M, outer)),
            block((-depth, half), (0.0, outer)),
            block((-depth, -outer), (0.0, -half)),
        ];
        let (along, angle) = direction(self.approach_deg);
        let bottom = Point2::origin();
        let (start, heading_rad, jitter_rad) = match self.side {
            Side::Outside => (bottom - along * (depth + BEFORE_MOUTH_M), angle, PI / 6.0),
            Side::Inside => {
                (Point2::new(-(KHEPERA_RADIUS_M + FROM_BOTTOM_M).min(depth / 2.0 + 0.03), 0.0), 0.0, PI)
            }
        };
        Draft {
            name: self.name(),
            title: format!(
                "U of {} x {} cm, approached at {:+} degrees",
                centimetres(self.width_m),
                centimetres(depth),
                self.approach_deg
            ),
            start,
            heading_rad,
            jitter_m: JITTER_M,
            jitter_rad,
            goal: bottom + along * (BEHIND_BOTTOM_M + WALL_M),
            time_limit_s: TIME_S + TIME_S_PER_M * (self.width_m + 2.0 * depth),
            shapes: shapes.into_iter().flatten().collect(),
            movers: Vec::new(),
        }
        .finish(disturbance)
    }
}

/// A wall with one end; the goal lies straight behind it, near that end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallEnd {
    /// From the straight way to the wall's end, in m.
    pub past_m: f64,
    /// Angle at which the straight way meets the wall, from its normal.
    pub approach_deg: f64,
}

/// To the other end, where there is no way round.
const WALL_LENGTH_M: f64 = 0.6;

impl WallEnd {
    /// As [`super::Scene::name`].
    #[must_use]
    pub fn name(&self) -> String {
        format!("wall_end_{}_{:+}", centimetres(self.past_m), self.approach_deg)
    }

    /// The wall as an experiment: 1 cm thin, as long as makes its other end the worse choice.
    #[must_use]
    pub fn scenario(&self, disturbance: &Disturbance) -> Scenario {
        let (along, heading_rad) = direction(self.approach_deg);
        let wall = block((-0.005, -WALL_LENGTH_M), (0.005, self.past_m));
        Draft {
            name: self.name(),
            title: format!(
                "A wall that ends {} cm beside the way, met at {:+} degrees",
                centimetres(self.past_m),
                self.approach_deg
            ),
            start: Point2::origin() - along * 0.3,
            heading_rad,
            jitter_m: JITTER_M,
            jitter_rad: PI / 6.0,
            goal: Point2::origin() + along * 0.2,
            time_limit_s: TIME_S + TIME_S_PER_M,
            shapes: wall.into_iter().collect(),
            movers: Vec::new(),
        }
        .finish(disturbance)
    }
}
