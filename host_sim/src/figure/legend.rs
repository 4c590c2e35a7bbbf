//! What the marks mean, and how long 10 cm are.

use nalgebra::{Point2, Vector2};
use svg::Document;
use svg::node::element::{Circle, Line, Path, Polygon, Rectangle};

use super::canvas::{Canvas, decimal, text};
use super::{CHECKPOINT, KNOWN, MOVING, START, UNFORESEEN, colour_of};
use crate::scenario::{Scenario, Solid};
use crate::world::Window;

const ROW_HEIGHT: f64 = 24.0;
const COLUMNS: usize = 4;
const SCALE_BAR_M: f64 = 0.1;
const TEXT_SIZE: f64 = 13.0;

pub(super) enum Mark {
    Block { colour: &'static str, opacity: f64 },
    Dot(&'static str),
    Hollow(&'static str),
    Ring(&'static str),
    Triangle(&'static str),
    Stroke(&'static str),
}

/// Height of the whole legend.
pub(super) fn height(scenario: &Scenario, labels: &[&str]) -> f64 {
    height_of(&entries(scenario, labels))
}

/// Height of a legend with these entries and a scale bar.
pub(super) fn height_of(entries: &[(Mark, String)]) -> f64 {
    let rows = entries.len().div_ceil(COLUMNS) + 1;
    (0..rows).fold(12.0, |height, _| height + ROW_HEIGHT)
}

/// Draws the scale bar and every mark that occurs in the picture.
pub(super) fn draw(canvas: &Canvas, document: Document, scenario: &Scenario, labels: &[&str]) -> Document {
    let document = draw_scale_bar(canvas, document, SCALE_BAR_M, "10 cm");
    draw_entries(canvas, document, &entries(scenario, labels))
}

/// Draws the marks with their meanings, below the scale bar.
pub(super) fn draw_entries(canvas: &Canvas, mut document: Document, entries: &[(Mark, String)]) -> Document {
    let (left, right) = canvas.sides();
    // Adding step by step gives the places without converting counts to floats.
    let mut place = Point2::new(left, canvas.legend_top() + ROW_HEIGHT * 1.5);
    for row in entries.chunks(COLUMNS) {
        place.x = left;
        for (mark, label) in row {
            document = draw_mark(document, place, mark);
            document = document.add(text(place + Vector2::new(34.0, 4.5), TEXT_SIZE, label));
            place.x += (right - left) / 4.0;
        }
        place.y += ROW_HEIGHT;
    }
    document
}

fn entries(scenario: &Scenario, labels: &[&str]) -> Vec<(Mark, String)> {
    let always = |known: bool| move |solid: &&Solid| solid.known == known && solid.window == Window::ALWAYS;
    let block = |colour: &'static str, opacity: f64| Mark::Block { colour, opacity };
    let mut entries = Vec::new();
    let mut add = |mark: Mark, label: &str| entries.push((mark, label.to_owned()));
    if scenario.solids.iter().any(|solid| always(true)(&solid)) {
        add(block(KNOWN, 1.0), "known wall");
    }
    if scenario.solids.iter().any(|solid| always(false)(&solid)) {
        add(block(UNFORESEEN, 1.0), "unforeseen obstacle");
    }
    for solid in scenario.solids.iter().filter(|solid| solid.window != Window::ALWAYS) {
        let colour = if solid.known { KNOWN } else { UNFORESEEN };
        if solid.window.from_s > 0.0 {
            add(block(colour, 0.55), &format!("appears at {} s", solid.window.from_s));
        } else {
            add(block(colour, 0.12), &format!("disappears at {} s", solid.window.until_s));
        }
    }
    if !scenario.world.movers.is_empty() {
        add(Mark::Dot(MOVING), "circling robot");
    }
    add(Mark::Ring(START), "start");
    add(Mark::Dot(CHECKPOINT), if scenario.route.checkpoints().len() > 1 { "checkpoint" } else { "goal" });
    if !scenario.replacements.is_empty() {
        add(Mark::Triangle(CHECKPOINT), "new checkpoint");
    }
    for label in labels {
        add(Mark::Stroke(colour_of(labels, label)), label);
    }
    entries
}

fn draw_mark(document: Document, place: Point2<f64>, mark: &Mark) -> Document {
    let middle = place + Vector2::new(13.0, 0.0);
    let dot = || Circle::new().set("cx", decimal(middle.x)).set("cy", decimal(middle.y));
    match mark {
        Mark::Block { colour, opacity } => {
            let block = Rectangle::new().set("x", decimal(place.x)).set("y", decimal(place.y - 6.0));
            let block =
                block.set("width", 26).set("height", 12).set("fill", *colour).set("fill-opacity", *opacity);
            document.add(if *opacity < 1.0 { block.set("stroke", *colour) } else { block })
        }
        Mark::Dot(colour) => document.add(dot().set("r", 5).set("fill", *colour)),
        Mark::Ring(colour) => {
            let ring = dot().set("r", 7).set("fill", *colour).set("fill-opacity", 0.1);
            document.add(ring.set("stroke", *colour).set("stroke-width", 2))
        }
        Mark::Hollow(colour) => {
            let hollow = dot().set("r", 5).set("fill", "#ffffff");
            document.add(hollow.set("stroke", *colour).set("stroke-width", 1.2))
        }
        Mark::Triangle(colour) => {
            let corner = |x: f64, y: f64| format!("{},{}", decimal(middle.x + x), decimal(middle.y + y));
            let corners = [corner(0.0, -7.0), corner(6.5, 5.0), corner(-6.5, 5.0)].join(" ");
            document.add(Polygon::new().set("points", corners).set("fill", *colour))
        }
        Mark::Stroke(colour) => {
            let line = Line::new().set("x1", decimal(place.x)).set("x2", decimal(place.x + 26.0));
            let line = line.set("y1", decimal(place.y)).set("y2", decimal(place.y));
            document.add(line.set("stroke", *colour).set("stroke-width", 2.5))
        }
    }
}

/// Draws how long a length is, at the right end above the entries.
pub(super) fn draw_scale_bar(canvas: &Canvas, document: Document, length_m: f64, label: &str) -> Document {
    let (_, right) = canvas.sides();
    let y = canvas.legend_top() + 4.0;
    let left = right - canvas.length(length_m);
    let (x0, x1, y0, y1) = (decimal(left), decimal(right), decimal(y - 5.0), decimal(y + 5.0));
    let bar = format!("M{x0} {y0}V{y1}M{x0} {0}H{x1}M{x1} {y0}V{y1}", decimal(y));
    let bar = Path::new().set("d", bar).set("stroke", "#1a1a1a").set("stroke-width", 2).set("fill", "none");
    let label = text(Point2::new(left - 8.0, y + 4.5), TEXT_SIZE, label).set("text-anchor", "end");
    document.add(bar).add(label)
}
