//! A world of discs and walls with a start and a goal.

use nalgebra::Point2;

use crate::geometry::Disc;
use crate::scenario::Shape;

/// A world to cross, at the robot's scale.
#[derive(Debug, Clone, PartialEq)]
pub struct VectorWorld {
    /// Its name.
    pub name: String,
    /// Where it comes from.
    pub source: String,
    /// Walls and obstacles; the planner knows them all.
    pub shapes: Vec<Shape>,
    /// Where the robot starts.
    pub start: Point2<f64>,
    /// Its heading there in rad.
    pub heading_rad: f64,
    /// Where it shall go.
    pub goal: Point2<f64>,
    /// How near the centre must come, in m.
    pub goal_tolerance_m: f64,
    /// Length of the way that the benchmark takes for the shortest, in m.
    pub reference_length_m: Option<f64>,
    /// Width of the tightest gap that no way avoids, in m.
    pub gap_m: Option<f64>,
    /// Metres here for a metre of the source.
    pub scale: Option<f64>,
}

impl VectorWorld {
    /// A round post.
    #[must_use]
    pub fn post(x: f64, y: f64, radius_m: f64) -> Shape {
        Shape::Disc(Disc { centre: Point2::new(x, y), radius_m })
    }

    /// A straight wall.
    #[must_use]
    pub fn wall(from: (f64, f64), to: (f64, f64)) -> Shape {
        Shape::Line(vec![Point2::new(from.0, from.1), Point2::new(to.0, to.1)])
    }
}
