//! Pictures as SVG: of runs ([`draw_run`]), of learned maps ([`draw_map`]) and of decisions ([`draw_decision`]).
//!
//! A run shows the world as the papers draw it, the checkpoints, and the paths. Known walls are black, unforeseen
//! obstacles grey, and movers are drawn where they start, with their circle and sense. A single path carries the
//! robot's outline once a second, so that speed can be read from it; a bundle of paths is drawn as thin lines.

mod canvas;
mod chart;
mod decision;
mod heat;
mod lattice;
mod legend;

pub use chart::{Axis, Series, Style, draw_chart};
pub use decision::draw_decision;
pub use heat::{HeatCell, HeatMap, draw_heat_map};
pub use lattice::draw_map;

use nalgebra::{Point2, Vector2};
use svg::Document;
use svg::node::element::{Circle, Group, Line, Path, Polygon};

use crate::mover::{Direction, Mover};
use crate::scenario::{Scenario, Shape, Solid};
use crate::world::{KHEPERA_RADIUS_M, Window};
use canvas::{Canvas, decimal, text};

/// Time between two outlines of the robot in s.
const OUTLINE_PERIOD_S: f64 = 1.0;
/// With more paths than this, outlines would hide each other.
const OUTLINED_PATHS_MAX: usize = 2;

/// A label needs this much of the picture's width.
const LABEL_ROOM: f64 = 110.0;

const KNOWN: &str = "#1a1a1a";
const UNFORESEEN: &str = "#9a9a9a";
const MOVING: &str = "#e07b00";
const CHECKPOINT: &str = "#c2185b";
const START: &str = "#2e7d32";
/// Colours of paths, told apart by most colour-blind readers; they repeat.
const PATHS: [&str; 4] = ["#0b62b0", "#d1495b", "#00868b", "#7b4fa3"];

/// One pose of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracePose {
    /// Time in s.
    pub t_s: f64,
    /// Centre of the robot.
    pub position: Point2<f64>,
    /// Heading in rad.
    pub heading_rad: f64,
}

/// The path of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct PathTrace {
    /// What the legend calls it; paths of the same label share a colour and one entry.
    pub label: String,
    /// The poses in order of time.
    pub poses: Vec<TracePose>,
}

/// Draws the scenario and the paths driven in it.
///
/// The same input gives the same text, so that pictures can be compared with committed ones. The checkpoints are the
/// scenario's; those of a planner are drawn by passing [`Scenario::with_checkpoints`].
#[must_use]
pub fn draw_run(scenario: &Scenario, traces: &[PathTrace]) -> String {
    let labels = labels(traces);
    let canvas = Canvas::around(scenario, legend::height(scenario, &labels));
    let mut document = canvas.document(scenario);
    for solid in &scenario.solids {
        document = document.add(draw_solid(&canvas, solid));
    }
    for mover in &scenario.world.movers {
        document = document.add(draw_mover(&canvas, mover));
    }
    let outlined = traces.len() <= OUTLINED_PATHS_MAX;
    for trace in traces {
        document = document.add(draw_trace(&canvas, trace, colour_of(&labels, &trace.label), outlined));
    }
    for robot in 0..scenario.robot_count() {
        let scenario = scenario.of_robot(robot);
        document = draw_checkpoints(&canvas, document, &scenario);
        document = document.add(draw_start(&canvas, &scenario));
    }
    legend::draw(&canvas, document, scenario, &labels).to_string()
}

/// The distinct labels in order of appearance.
fn labels(traces: &[PathTrace]) -> Vec<&str> {
    let mut labels = Vec::new();
    for trace in traces {
        if !labels.contains(&trace.label.as_str()) {
            labels.push(trace.label.as_str());
        }
    }
    labels
}

fn colour_of(labels: &[&str], label: &str) -> &'static str {
    let index = labels.iter().position(|known| *known == label).unwrap_or(0);
    PATHS[index % PATHS.len()]
}

fn draw_solid(canvas: &Canvas, solid: &Solid) -> Group {
    let colour = if solid.known { KNOWN } else { UNFORESEEN };
    let group = style_solid(Group::new(), solid.window, colour);
    match &solid.shape {
        Shape::Line(points) => {
            let line = Path::new().set("d", canvas.path(points.iter().copied())).set("fill", "none");
            group.set("stroke", colour).set("stroke-width", 3).set("stroke-linejoin", "round").add(line)
        }
        Shape::Polygon(polygon) => group.add(Polygon::new().set("points", canvas.points(polygon.vertices()))),
        Shape::Disc(disc) => group.add(circle(canvas, disc.centre, disc.radius_m)),
    }
}

/// What is there only for a time is drawn as an outline: it is not there for all of the path.
fn style_solid(group: Group, window: Window, colour: &'static str) -> Group {
    if window == Window::ALWAYS {
        // The thin edge closes the hairline that renderers leave between walls that meet.
        return group.set("fill", colour).set("stroke", colour).set("stroke-width", 0.6);
    }
    let group = group.set("fill", colour).set("stroke", colour).set("stroke-width", 1.5);
    if window.from_s > 0.0 {
        group.set("fill-opacity", 0.55)
    } else {
        group.set("fill-opacity", 0.12).set("stroke-dasharray", "4 3")
    }
}

fn draw_mover(canvas: &Canvas, mover: &Mover) -> Group {
    let orbit =
        circle(canvas, mover.centre, mover.orbit_radius_m).set("fill", "none").set("stroke-dasharray", "5 4");
    let disc = mover.at(0.0);
    let body = circle(canvas, disc.centre, disc.radius_m).set("fill", MOVING).set("fill-opacity", 0.85);
    let outwards = (disc.centre - mover.centre) / mover.orbit_radius_m;
    let sign = match mover.direction() {
        Direction::Anticlockwise => 1.0,
        Direction::Clockwise => -1.0,
    };
    let ahead = Vector2::new(-outwards.y, outwards.x) * sign;
    let tip = disc.centre + ahead * (disc.radius_m * 0.75);
    let corner =
        |side: f64| disc.centre - ahead * (disc.radius_m * 0.35) + outwards * (disc.radius_m * 0.5 * side);
    let arrow = Polygon::new().set("points", canvas.points([tip, corner(1.0), corner(-1.0)].into_iter()));
    let group = Group::new().set("stroke", MOVING).set("stroke-width", 1.5);
    group.add(orbit).add(body).add(arrow.set("fill", "#ffffff").set("stroke", "none"))
}

fn draw_trace(canvas: &Canvas, trace: &PathTrace, colour: &'static str, outlined: bool) -> Group {
    let line = Path::new()
        .set("d", canvas.path(trace.poses.iter().map(|pose| pose.position)))
        .set("fill", "none")
        .set("stroke-linejoin", "round")
        .set("stroke-width", if outlined { 2.0 } else { 1.0 })
        .set("stroke-opacity", if outlined { 1.0 } else { 0.45 });
    let mut group = Group::new().set("stroke", colour).set("fill", colour);
    if outlined {
        for pose in outlines(&trace.poses) {
            group = group.add(draw_robot(canvas, pose.position, pose.heading_rad));
        }
    }
    group.add(line)
}

/// The first pose in each period, and the last of all.
fn outlines(poses: &[TracePose]) -> Vec<TracePose> {
    let mut next_s = f64::NEG_INFINITY;
    let mut chosen = Vec::new();
    for pose in poses {
        if pose.t_s >= next_s {
            chosen.push(*pose);
            // From the grid, not from the pose: sparse poses must not make the outlines drift.
            next_s = OUTLINE_PERIOD_S * ((pose.t_s / OUTLINE_PERIOD_S).floor() + 1.0);
        }
    }
    match (chosen.last(), poses.last()) {
        (Some(drawn), Some(last)) if drawn != last => chosen.push(*last),
        _ => {}
    }
    chosen
}

/// The body as a circle, the heading as a radius.
fn draw_robot(canvas: &Canvas, position: Point2<f64>, heading_rad: f64) -> Group {
    let (sin, cos) = libm::sincos(heading_rad);
    let nose = canvas.place(position + Vector2::new(cos, sin) * KHEPERA_RADIUS_M);
    let middle = canvas.place(position);
    let body = circle(canvas, position, KHEPERA_RADIUS_M).set("fill-opacity", 0.10);
    let heading = Line::new().set("x1", decimal(middle.x)).set("y1", decimal(middle.y));
    let heading = heading.set("x2", decimal(nose.x)).set("y2", decimal(nose.y));
    Group::new().set("stroke-width", 1).set("stroke-opacity", 0.7).add(body).add(heading)
}

fn draw_start(canvas: &Canvas, scenario: &Scenario) -> Group {
    let start = &scenario.start;
    let robot = draw_robot(canvas, start.position, start.heading_rad);
    Group::new()
        .set("stroke", START)
        .set("fill", START)
        .add(robot.set("stroke-width", 2).set("stroke-opacity", 1))
}

fn draw_checkpoints(canvas: &Canvas, mut document: Document, scenario: &Scenario) -> Document {
    let checkpoints = scenario.route.checkpoints();
    for (i, checkpoint) in checkpoints.iter().enumerate() {
        let place = canvas.place(*checkpoint);
        let goal = i + 1 == checkpoints.len();
        let label = if goal { String::from("goal") } else { (i + 1).to_string() };
        let dot = Circle::new().set("cx", decimal(place.x)).set("cy", decimal(place.y)).set("r", 4.5);
        document = document
            .add(dot.set("fill", CHECKPOINT).set("stroke", "#ffffff").set("stroke-width", 1))
            .add(label_at(canvas, place, &label));
    }
    for replacement in &scenario.replacements {
        let place = canvas.place(replacement.to);
        let corner = |x: f64, y: f64| format!("{},{}", decimal(place.x + x), decimal(place.y + y));
        let corners = [corner(0.0, -7.0), corner(6.5, 5.0), corner(-6.5, 5.0)].join(" ");
        let triangle = Polygon::new().set("points", corners).set("fill", CHECKPOINT).set("stroke", "#ffffff");
        document = document.add(triangle).add(label_at(
            canvas,
            place,
            &format!("{} new", replacement.checkpoint + 1),
        ));
    }
    document
}

/// A label above a mark, on the side away from the picture's edge, with a white edge so that it can be read on a
/// wall.
fn label_at(canvas: &Canvas, place: Point2<f64>, label: &str) -> svg::node::element::Text {
    let (_, right) = canvas.sides();
    let (aside, anchor) = if place.x > right - LABEL_ROOM { (-9.0, "end") } else { (9.0, "start") };
    text(place + Vector2::new(aside, -8.0), 15.0, label)
        .set("text-anchor", anchor)
        .set("fill", CHECKPOINT)
        .set("font-weight", "bold")
        .set("stroke", "#ffffff")
        .set("stroke-width", 3)
        .set("paint-order", "stroke")
}

fn circle(canvas: &Canvas, centre: Point2<f64>, radius_m: f64) -> Circle {
    let place = canvas.place(centre);
    Circle::new()
        .set("cx", decimal(place.x))
        .set("cy", decimal(place.y))
        .set("r", decimal(canvas.length(radius_m)))
}
