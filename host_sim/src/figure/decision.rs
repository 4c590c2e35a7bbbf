//! A picture of a decision in the robot's frame, ahead being up.

use controller_core::config::Config;
use controller_core::units::Point;
use nalgebra::{Point2, Vector2};
use svg::Document;
use svg::node::element::{Circle, Group, Line, Path, Polygon};

use super::canvas::{Canvas, decimal};
use super::lattice::upright;
use super::legend::{self, Mark};
use super::{CHECKPOINT, MOVING, START, UNFORESEEN, circle};
use crate::arc;
use crate::explanation::{Explanation, NeuronActivity, Place};
use crate::geometry::Bounds;

const WINNER: &str = "#0b62b0";
const SECOND: &str = "#7b4fa3";
const FREE: &str = "#2e9e4f";
const PALE: &str = "#e6e6e6";
const INHIBITED: &str = "#d1495b";
const ARC: &str = "#0b62b0";
/// Radius of a neuron's mark, in SVG units.
const NEURON_RADIUS: f64 = 7.0;
/// Lines that the arc of a command is drawn with.
const ARC_LINES: u32 = 24;
/// What is farther than this many reaches is shown at the edge.
const SHOWN_REACHES: f64 = 1.4;

/// Draws what a command was decided from; `robot` gives body, wheel base and the length of a step.
///
/// Neurons stand where their step leads to. The greener, the more activity is left of them after all inhibition; red
/// ones are inhibited, from pale to full at an inhibition of 1. The same explanation gives the same text.
#[must_use]
pub fn draw_decision(explanation: &Explanation, robot: &Config) -> String {
    let step_s = f64::from(robot.schedule.step_ms) / 1000.0;
    let shown_m = f64::from(robot.robot.speed_limit_mps) * step_s * SHOWN_REACHES;
    let decision = &explanation.decision;
    let entries = entries(explanation);
    let bounds = Bounds::of_point(Point2::origin()).grown(shown_m);
    let canvas = Canvas::showing(bounds, legend::height_of(&entries));
    let (title, under) = titles(explanation);
    let mut document = canvas.titled_document(&title, &under);
    document = document.add(draw_neurons(&canvas, &decision.neurons));
    document = draw_obstacles(&canvas, document, explanation);
    let radius_m = f64::from(robot.robot.body_radius_m);
    let others = decision.others.iter().map(|other| (other.place, SECOND));
    for (place, colour) in others.chain(decision.movers.iter().map(|mover| (mover.place, MOVING))) {
        let place = position(place);
        if shown(place, shown_m) == place {
            let body = circle(&canvas, place, radius_m).set("fill", colour).set("fill-opacity", 0.15);
            document = document.add(body.set("stroke", colour).set("stroke-width", 2));
        }
    }
    document = document.add(draw_body(&canvas, radius_m));
    document = document.add(draw_arc(&canvas, explanation.decision.command, robot, step_s));
    for (neuron, colour) in [(decision.runner_up, SECOND), (decision.winner, WINNER)] {
        if let Some(neuron) = neuron {
            document = document.add(ring(&canvas, position(neuron.place), colour));
        }
    }
    if let Some(field) = decision.field {
        document = document.add(triangle(&canvas, shown(position(field.aim), shown_m)));
    }
    if let Some(target) = decision.target {
        let place = canvas.place(shown(position(target), shown_m));
        let dot = Circle::new().set("cx", decimal(place.x)).set("cy", decimal(place.y)).set("r", 7);
        document =
            document.add(dot.set("fill", CHECKPOINT).set("stroke", "#ffffff").set("stroke-width", 1.5));
    }
    let document = legend::draw_scale_bar(&canvas, document, 0.05, "5 cm");
    legend::draw_entries(&canvas, document, &entries).to_string()
}

fn titles(explanation: &Explanation) -> (String, String) {
    let decision = &explanation.decision;
    let title = format!(
        "Decision at {:.3} s: left {:.3}, right {:.3} m/s",
        explanation.decided_s(),
        decision.command[0],
        decision.command[1]
    );
    (title, decision.verdict.last().cloned().unwrap_or_default())
}

fn entries(explanation: &Explanation) -> Vec<(Mark, String)> {
    let decision = &explanation.decision;
    let mut entries = Vec::new();
    let mut add = |mark: Mark, label: &str| entries.push((mark, label.to_owned()));
    if !decision.neurons.is_empty() {
        add(Mark::Dot(FREE), "neuron with activity left");
        add(Mark::Dot(INHIBITED), "inhibited neuron");
    }
    if decision.winner.is_some() {
        add(Mark::Ring(WINNER), "winner neuron");
        add(Mark::Ring(SECOND), "second neuron");
    }
    add(Mark::Stroke(ARC), "way of the command");
    add(Mark::Dot(MOVING), "detection");
    add(Mark::Hollow(UNFORESEEN), "remembered point");
    if !decision.movers.is_empty() {
        add(Mark::Ring(MOVING), "what moves");
    }
    if !decision.others.is_empty() {
        add(Mark::Ring(SECOND), "other robot");
    }
    add(Mark::Dot(CHECKPOINT), "target, at the edge if far");
    if decision.field.is_some() {
        add(Mark::Triangle(CHECKPOINT), "where the map is aimed");
    }
    entries
}

fn upright_point(point: Point<f32>) -> Point2<f64> {
    upright(Point2::new(f64::from(point.x_m), f64::from(point.y_m)))
}

fn position(place: Place) -> Point2<f64> {
    upright_point(place.to_point())
}

/// The place, or where the edge of the picture is in its direction.
fn shown(place: Point2<f64>, shown_m: f64) -> Point2<f64> {
    let farthest = place.x.abs().max(place.y.abs());
    if farthest > shown_m * 0.97 { Point2::from(place.coords * (shown_m * 0.97 / farthest)) } else { place }
}

/// The colour of what is left of a neuron's activity, given the largest there is.
fn colour_of(total: f32, largest: f32) -> String {
    let (full, share) =
        if total > 0.0 { (FREE, total / largest.max(f32::MIN_POSITIVE)) } else { (INHIBITED, -total) };
    blend(PALE, full, f64::from(share.clamp(0.0, 1.0)))
}

/// A colour between two, given as `#rrggbb`.
fn blend(from: &str, to: &str, share: f64) -> String {
    let channel = |colour: &str, at: usize| {
        colour.get(at..at + 2).and_then(|digits| u8::from_str_radix(digits, 16).ok()).map_or(0.0, f64::from)
    };
    let mixed = |at: usize| {
        let (low, high) = (channel(from, at), channel(to, at));
        format!("{:.0}", low + (high - low) * share)
    };
    format!("rgb({},{},{})", mixed(1), mixed(3), mixed(5))
}

fn draw_neurons(canvas: &Canvas, neurons: &[NeuronActivity]) -> Group {
    let largest = neurons.iter().map(|neuron| neuron.total).fold(0.0, f32::max);
    // The best on top.
    let mut sorted: Vec<_> = neurons.iter().collect();
    sorted.sort_by(|a, b| a.total.total_cmp(&b.total));
    let mut group = Group::new().set("stroke", "#ffffff").set("stroke-width", 1);
    for neuron in sorted {
        let place = canvas.place(position(neuron.place));
        let dot = Circle::new().set("cx", decimal(place.x)).set("cy", decimal(place.y));
        group = group.add(dot.set("r", decimal(NEURON_RADIUS)).set("fill", colour_of(neuron.total, largest)));
    }
    group
}

fn draw_obstacles(canvas: &Canvas, mut document: Document, explanation: &Explanation) -> Document {
    let decision = &explanation.decision;
    let dot = |place: Point2<f64>| {
        let place = canvas.place(place);
        Circle::new().set("cx", decimal(place.x)).set("cy", decimal(place.y))
    };
    if let Some(wall) = decision.detour {
        let (from, to) = (canvas.place(Point2::origin()), canvas.place(position(wall.place)));
        let line = Line::new().set("x1", decimal(from.x)).set("y1", decimal(from.y));
        let line = line.set("x2", decimal(to.x)).set("y2", decimal(to.y)).set("stroke-dasharray", "5 4");
        document = document.add(line.set("stroke", MOVING).set("stroke-width", 1.5));
    }
    for &point in &decision.remembered {
        let hollow = dot(upright_point(point)).set("r", 6).set("fill", "none");
        document = document.add(hollow.set("stroke", UNFORESEEN).set("stroke-width", 2));
    }
    for detection in &decision.detections {
        let mark = dot(position(detection.place)).set("r", 5).set("fill", MOVING);
        document = document.add(mark.set("stroke", "#ffffff").set("stroke-width", 1));
    }
    document
}

fn draw_body(canvas: &Canvas, radius_m: f64) -> Group {
    let place = canvas.place(Point2::origin());
    let size = canvas.length(radius_m);
    let corner = |x: f64, y: f64| format!("{},{}", decimal(place.x + x * size), decimal(place.y + y * size));
    let corners = [corner(0.0, -0.9), corner(0.6, 0.55), corner(-0.6, 0.55)].join(" ");
    let body = circle(canvas, Point2::origin(), radius_m).set("fill-opacity", 0.08);
    let heading = Polygon::new().set("points", corners).set("fill-opacity", 0.25);
    Group::new().set("stroke", START).set("fill", START).set("stroke-width", 1.5).add(body).add(heading)
}

/// Where the command leads to within a step, without lag and slip.
fn draw_arc(canvas: &Canvas, command: [f32; 2], robot: &Config, step_s: f64) -> Path {
    let [left, right] = command.map(|speed| f64::from(speed) * step_s / f64::from(ARC_LINES));
    let base = f64::from(robot.robot.wheel_base_m);
    let mut place = arc::Place { position: Point2::origin(), heading_rad: 0.0 };
    let mut points = vec![upright(place.position)];
    for _ in 0..ARC_LINES {
        place = place.after((left, right), base);
        points.push(upright(place.position));
    }
    let path = Path::new().set("d", canvas.path(points.into_iter())).set("fill", "none");
    path.set("stroke", ARC).set("stroke-width", 3)
}

fn ring(canvas: &Canvas, place: Point2<f64>, colour: &'static str) -> Circle {
    let place = canvas.place(place);
    let ring = Circle::new().set("cx", decimal(place.x)).set("cy", decimal(place.y)).set("r", 11);
    ring.set("fill", "none").set("stroke", colour).set("stroke-width", 3)
}

fn triangle(canvas: &Canvas, place: Point2<f64>) -> Polygon {
    let place = canvas.place(place);
    let corner = |x: f64, y: f64| {
        let corner = place + Vector2::new(x, y);
        format!("{},{}", decimal(corner.x), decimal(corner.y))
    };
    let corners = [corner(0.0, -7.0), corner(6.5, 5.0), corner(-6.5, 5.0)].join(" ");
    Polygon::new().set("points", corners).set("fill", CHECKPOINT).set("stroke", "#ffffff")
}

#[cfg(test)]
mod tests {
    use super::{blend, colour_of};

    #[test]
    fn colours_run_from_pale_to_full() {
        assert_eq!(blend("#000000", "#ff8000", 0.5), "rgb(128,64,0)");
        assert_eq!(colour_of(0.04, 0.04), "rgb(46,158,79)");
        assert_eq!(colour_of(-5.0, 0.04), "rgb(209,73,91)");
        assert_eq!(colour_of(0.0, 0.0), "rgb(230,230,230)");
    }
}
