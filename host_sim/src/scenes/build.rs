//! What all scenes are made of.

use nalgebra::{Point2, Vector2};

use crate::geometry::{Disc, Polygon};
use crate::mover::Mover;
use crate::scenario::{ControllerKind, NoiseLevels, Route, Scenario, Shape, Solid, Start};
use crate::simulation::PAPERS;
use crate::world::{Window, World};

/// "If it was less than 5 mm from the checkpoint" (both papers).
const TOLERANCE_M: f64 = 0.005;

/// Thickness of a trap's walls in m.
pub(super) const WALL_M: f64 = 0.02;

/// What disturbs a run beyond the scene itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disturbance {
    /// Noise of sensors and actuators, and missing readings.
    pub noise: NoiseLevels,
    /// Factor on how far start and heading are drawn.
    pub jitter: f64,
}

impl Disturbance {
    /// The papers' noise, and starts that vary by a centimetre.
    pub const PAPERS: Self = Self { noise: PAPERS, jitter: 1.0 };
}

/// A scene under construction.
pub(super) struct Draft {
    pub name: String,
    pub title: String,
    pub start: Point2<f64>,
    pub heading_rad: f64,
    /// The start is drawn from a disc of this radius in m.
    pub jitter_m: f64,
    /// The heading is drawn from ± this angle.
    pub jitter_rad: f64,
    pub goal: Point2<f64>,
    pub time_limit_s: f64,
    pub shapes: Vec<Shape>,
    pub movers: Vec<Mover>,
}

impl Draft {
    /// The scene as an experiment: nothing in it is known beforehand.
    pub fn finish(self, disturbance: &Disturbance) -> Scenario {
        let mut world = World { movers: self.movers, ..World::default() };
        for shape in &self.shapes {
            shape.add_to(&mut world.permanent);
        }
        let solid = |shape| Solid { shape, known: false, window: Window::ALWAYS };
        Scenario {
            name: self.name,
            title: self.title,
            source: String::from("ours"),
            start: Start {
                position: self.start,
                heading_rad: self.heading_rad,
                jitter_position_m: self.jitter_m * disturbance.jitter,
                jitter_heading_rad: (self.jitter_rad * disturbance.jitter).min(core::f64::consts::PI),
            },
            route: Route::Checkpoints(vec![self.goal]),
            replacements: Vec::new(),
            companions: Vec::new(),
            tolerance_m: TOLERANCE_M,
            time_limit_s: self.time_limit_s,
            controller: ControllerKind::Cooperative,
            target_period_ms: 256,
            noise: disturbance.noise,
            solids: self.shapes.into_iter().map(solid).collect(),
            world,
        }
    }
}

/// A block between two corners.
pub(super) fn block(low: (f64, f64), high: (f64, f64)) -> Option<Shape> {
    let corners = [(low.0, low.1), (high.0, low.1), (high.0, high.1), (low.0, high.1)];
    Polygon::new(&corners.map(|(x, y)| Point2::new(x, y))).map(Shape::Polygon)
}

/// Walls along the inside of a box.
pub(super) fn room(low: (f64, f64), high: (f64, f64)) -> impl Iterator<Item = Shape> {
    let ((left, bottom), (right, top)) = (low, high);
    [
        block((left - WALL_M, bottom - WALL_M), (left, top + WALL_M)),
        block((right, bottom - WALL_M), (right + WALL_M, top + WALL_M)),
        block((left, bottom - WALL_M), (right, bottom)),
        block((left, top), (right, top + WALL_M)),
    ]
    .into_iter()
    .flatten()
}

/// A round post.
pub(super) fn post(x: f64, y: f64, radius_m: f64) -> Shape {
    Shape::Disc(Disc { centre: Point2::new(x, y), radius_m })
}

/// The unit vector at an angle in degrees, and the angle in rad.
pub(super) fn direction(angle_deg: f64) -> (Vector2<f64>, f64) {
    let angle = angle_deg.to_radians();
    let (sin, cos) = libm::sincos(angle);
    (Vector2::new(cos, sin), angle)
}

/// A length in cm for a name: `40`, `7.5`.
pub(super) fn centimetres(metres: f64) -> String {
    // A hundredth of a millimetre: what rounding leaves does not show.
    format!("{}", (metres * 10_000.0).round() / 100.0)
}
