//! From metres to the picture: the world fills the middle, the title stands above, the legend below.

use core::fmt::Write;

use nalgebra::Point2;
use svg::Document;
use svg::node::element::{Rectangle, Text};

use crate::geometry::Bounds;
use crate::scenario::Scenario;
use crate::solids::Solids;

/// Width of every picture, in SVG units.
const WIDTH: f64 = 1000.0;
const MARGIN: f64 = 24.0;
const TITLE_HEIGHT: f64 = 56.0;
/// Room around places that no wall encloses, in m.
const SURROUND_M: f64 = 0.05;

/// Where the parts of one picture go.
pub(super) struct Canvas {
    /// Upper left corner of the world, in m.
    corner: Point2<f64>,
    /// SVG units per metre.
    scale: f64,
    world_height: f64,
    legend_height: f64,
}

impl Canvas {
    /// A canvas that shows everything in the scenario.
    pub(super) fn around(scenario: &Scenario, legend_height: f64) -> Self {
        let mut solids = Solids::default();
        for solid in &scenario.solids {
            solid.shape.add_to(&mut solids);
        }
        let of_companions = scenario
            .companions
            .iter()
            .flat_map(|companion| companion.checkpoints.iter().copied().chain([companion.start.position]));
        let places = scenario.route.checkpoints().iter().copied().chain(of_companions);
        let places = places.map(|place| Bounds::of_point(place).grown(SURROUND_M));
        let start = Bounds::of_point(scenario.start.position).grown(SURROUND_M);
        let movers = scenario.world.movers.iter();
        let circles =
            movers.map(|mover| Bounds::of_point(mover.centre).grown(mover.orbit_radius_m + mover.radius_m));
        let everything = solids.bounds().into_iter().chain(places).chain(circles);
        Self::showing(everything.fold(start, |all, next| all.union(&next)), legend_height)
    }

    /// A canvas that shows a part of the plane.
    pub(super) fn showing(bounds: Bounds, legend_height: f64) -> Self {
        let scale = (WIDTH - 2.0 * MARGIN) / (bounds.high.x - bounds.low.x);
        let world_height = (bounds.high.y - bounds.low.y) * scale;
        Self { corner: Point2::new(bounds.low.x, bounds.high.y), scale, world_height, legend_height }
    }

    /// An empty picture with the scenario's title.
    pub(super) fn document(&self, scenario: &Scenario) -> Document {
        let under = format!("{} · scenario {}", scenario.source, scenario.name);
        self.titled_document(&scenario.title, &under)
    }

    /// An empty picture with a title and a line under it.
    pub(super) fn titled_document(&self, title: &str, under: &str) -> Document {
        let height = decimal(self.legend_top() + self.legend_height);
        let paper = Rectangle::new()
            .set("width", decimal(WIDTH))
            .set("height", height.clone())
            .set("fill", "#ffffff");
        let heading = text(Point2::new(MARGIN, 27.0), 21.0, title).set("font-weight", "bold");
        Document::new()
            .set("viewBox", format!("0 0 {} {height}", decimal(WIDTH)))
            .set("width", decimal(WIDTH))
            .set("height", height)
            .set("font-family", "DejaVu Sans, Verdana, Helvetica, sans-serif")
            .add(paper)
            .add(heading)
            .add(text(Point2::new(MARGIN, 46.0), 14.0, under).set("fill", "#555555"))
    }

    /// Where a point of the world is in the picture, whose y runs downwards.
    pub(super) fn place(&self, point: Point2<f64>) -> Point2<f64> {
        let x = MARGIN + (point.x - self.corner.x) * self.scale;
        Point2::new(x, TITLE_HEIGHT + (self.corner.y - point.y) * self.scale)
    }

    /// A length of the world in the picture.
    pub(super) fn length(&self, length_m: f64) -> f64 {
        length_m * self.scale
    }

    /// Left and right end of what may be drawn on.
    pub(super) const fn sides(&self) -> (f64, f64) {
        (MARGIN, WIDTH - MARGIN)
    }

    /// Where the legend begins.
    pub(super) fn legend_top(&self) -> f64 {
        TITLE_HEIGHT + self.world_height + 16.0
    }

    /// The `d` attribute of an open path.
    pub(super) fn path(&self, points: impl Iterator<Item = Point2<f64>>) -> String {
        let mut path = String::new();
        for (i, point) in points.enumerate() {
            let place = self.place(point);
            let step = if i == 0 { 'M' } else { 'L' };
            // Writing to a string cannot fail.
            let _ = write!(path, "{step}{} {}", decimal(place.x), decimal(place.y));
        }
        path
    }

    /// The `points` attribute of a polygon.
    pub(super) fn points(&self, points: impl Iterator<Item = Point2<f64>>) -> String {
        let places = points.map(|point| self.place(point));
        places.map(|place| format!("{},{}", decimal(place.x), decimal(place.y))).collect::<Vec<_>>().join(" ")
    }
}

/// A coordinate with one place after the point: a tenth of a pixel is finer than any screen, and files stay small.
pub(super) fn decimal(value: f64) -> String {
    let rounded = format!("{value:.1}");
    // The rounding of a small negative number leaves a sign that would make equal pictures differ.
    if rounded == "-0.0" { String::from("0.0") } else { rounded }
}

/// Text whose baseline begins at a place of the picture.
pub(super) fn text(place: Point2<f64>, size: f64, content: &str) -> Text {
    let text = Text::new(content).set("x", decimal(place.x)).set("y", decimal(place.y));
    text.set("font-size", decimal(size)).set("fill", "#1a1a1a")
}
