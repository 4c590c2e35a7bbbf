//! Curves over two axes, as in P1 Figs. 4 and 5.

use core::fmt::Write;

use nalgebra::Point2;
use svg::Document;
use svg::node::element::{Circle, Line, Path, Rectangle};

use super::canvas::{decimal, text};

const WIDTH: f64 = 920.0;
const HEIGHT: f64 = 460.0;
// Room around the axes.
const LEFT: f64 = 78.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 64.0;
const BOTTOM: f64 = 56.0;
const GRID: &str = "#dddddd";
const LINES: [&str; 8] =
    ["#0b62b0", "#d1495b", "#00868b", "#7b4fa3", "#b8860b", "#3c7d22", "#e07b39", "#5c6b7a"];

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// What it shows, with its unit.
    pub label: String,
    /// Least and greatest value; both above 0 where it is logarithmic.
    pub range: (f64, f64),
    /// Values with a line and a number.
    pub ticks: Vec<f64>,
    /// Logarithmic.
    pub is_logarithmic: bool,
}

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Its name.
    pub label: String,
    /// Its points; what is beyond an axis is drawn at its end.
    pub points: Vec<(f64, f64)>,
    /// How it is drawn.
    pub style: Style,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// A line in a colour of its own.
    Line,
    /// Dashed and grey: what others measured, or a limit.
    Reference,
    /// A dot for each point, in a colour of its own.
    Dots,
}

impl Axis {
    /// Where a value is, 0 to 1.
    fn share(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        let share = if self.is_logarithmic {
            libm::log(value.max(low) / low) / libm::log(high / low)
        } else {
            (value - low) / (high - low)
        };
        share.clamp(0.0, 1.0)
    }
}

/// Draws curves. The same input gives the same text.
#[must_use]
pub fn draw_chart(title: &str, x: &Axis, y: &Axis, series: &[Series]) -> String {
    let place = |(at_x, at_y): (f64, f64)| {
        Point2::new(
            LEFT + x.share(at_x) * (WIDTH - LEFT - RIGHT),
            HEIGHT - BOTTOM - y.share(at_y) * (HEIGHT - TOP - BOTTOM),
        )
    };
    let line = |from: Point2<f64>, to: Point2<f64>, colour: &str| {
        Line::new()
            .set("x1", decimal(from.x))
            .set("y1", decimal(from.y))
            .set("x2", decimal(to.x))
            .set("y2", decimal(to.y))
            .set("stroke", colour)
    };
    let paper =
        Rectangle::new().set("width", decimal(WIDTH)).set("height", decimal(HEIGHT)).set("fill", "#ffffff");
    let mut document = Document::new()
        .set("viewBox", format!("0 0 {} {}", decimal(WIDTH), decimal(HEIGHT)))
        .set("width", decimal(WIDTH))
        .set("height", decimal(HEIGHT))
        .set("font-family", "DejaVu Sans, Verdana, Helvetica, sans-serif")
        .add(paper)
        .add(text(Point2::new(LEFT, 30.0), 18.0, title).set("font-weight", "bold"));
    for &tick in &x.ticks {
        let (low, high) = (place((tick, y.range.0)), place((tick, y.range.1)));
        let number = text(low + nalgebra::Vector2::new(0.0, 18.0), 13.0, &tick.to_string());
        document = document.add(line(low, high, GRID)).add(number.set("text-anchor", "middle"));
    }
    for &tick in &y.ticks {
        let (low, high) = (place((x.range.0, tick)), place((x.range.1, tick)));
        let number = text(low + nalgebra::Vector2::new(-8.0, 4.0), 13.0, &tick.to_string());
        document = document.add(line(low, high, GRID)).add(number.set("text-anchor", "end"));
    }
    let middle = Point2::new(f64::midpoint(LEFT, WIDTH - RIGHT), HEIGHT - 14.0);
    document = document.add(text(middle, 14.0, &x.label).set("text-anchor", "middle"));
    document = document.add(text(Point2::new(LEFT, TOP - 8.0), 14.0, &y.label));
    let mut row = TOP + 8.0;
    for (number, series) in series.iter().enumerate() {
        let colour = if series.style == Style::Reference { "#777777" } else { LINES[number % LINES.len()] };
        let mut d = String::new();
        for (i, &point) in series.points.iter().enumerate() {
            let at = place(point);
            if series.style == Style::Dots {
                let dot = Circle::new().set("cx", decimal(at.x)).set("cy", decimal(at.y)).set("r", 3);
                document = document.add(dot.set("fill", colour));
                continue;
            }
            let step = if i == 0 { 'M' } else { 'L' };
            // Writing to a string cannot fail.
            let _ = write!(d, "{step}{} {}", decimal(at.x), decimal(at.y));
        }
        let mut path =
            Path::new().set("d", d).set("fill", "none").set("stroke", colour).set("stroke-width", 2);
        if series.style == Style::Reference {
            path = path.set("stroke-dasharray", "6 4");
        }
        document = document.add(path);
        // Beside the picture, where no curve runs through it.
        let from = Point2::new(WIDTH - RIGHT + 14.0, row);
        let to = from + nalgebra::Vector2::new(24.0, 0.0);
        let mut mark = line(from, to, colour).set("stroke-width", 2);
        if series.style == Style::Reference {
            mark = mark.set("stroke-dasharray", "6 4");
        }
        let name = text(to + nalgebra::Vector2::new(6.0, 4.0), 13.0, &series.label);
        document = document.add(mark).add(name);
        row += 22.0;
    }
    document.to_string()
}
