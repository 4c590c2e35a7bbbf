//! A picture of a learned map: the places of its neurons as the robot sees them, ahead being up.

use nalgebra::{Point2, Vector2};
use svg::node::element::{Circle, Group, Path, Polygon};

use super::canvas::{Canvas, decimal, text};
use super::legend::{self, Mark};
use super::{START, circle};
use crate::geometry::Bounds;
use crate::map_report::MapRecords;

const NEURON: &str = "#0b62b0";
const UNTRAINED: &str = "#8a8a8a";
const REACH: &str = "#c2185b";
const RING: &str = "#dddddd";
/// Radius of a neuron's mark, in SVG units.
const NEURON_RADIUS: f64 = 4.0;
/// Room around the reach and all neurons, in reaches.
const MARGIN_SHARE: f64 = 0.04;

/// Draws the neurons of a map in the robot's frame: x ahead and up, y to the left, in m.
///
/// Trained neurons are filled and untrained ones hollow; neighbours on the lattice are joined; a circle shows the reach
/// and thin ones the distances. The same map gives the same text.
#[must_use]
pub fn draw_map(map: &MapRecords) -> String {
    let reach_m = f64::from(map.header().reach_m);
    let places: Vec<Point2<f64>> = map.neurons().iter().map(|neuron| upright(map.position(neuron))).collect();
    let robot = Bounds::of_point(Point2::origin()).grown(reach_m);
    let bounds = places.iter().fold(robot, |all, place| all.union(&Bounds::of_point(*place)));
    let entries = entries();
    let canvas = Canvas::showing(bounds.grown(reach_m * MARGIN_SHARE), legend::height_of(&entries));
    let scale = Scale::of(reach_m);
    let (title, under) = titles(map);
    let document = canvas.titled_document(&title, &under);
    let document = document
        .add(draw_rings(&canvas, &scale, reach_m))
        .add(draw_reach(&canvas, reach_m))
        .add(draw_links(&canvas, map, &places))
        .add(draw_robot(&canvas))
        .add(draw_neurons(&canvas, map, &places));
    let document = legend::draw_scale_bar(&canvas, document, scale.step_m, &scale.label(1));
    legend::draw_entries(&canvas, document, &entries).to_string()
}

/// From the robot's frame to the canvas's, whose y runs upwards.
pub(super) fn upright(place: Point2<f64>) -> Point2<f64> {
    Point2::new(-place.y, place.x)
}

fn titles(map: &MapRecords) -> (String, String) {
    let made = &map.header().provenance;
    let (columns, rows) = map.lattice();
    let statistics = map.statistics();
    let under = format!(
        "{} of {} neurons trained · {} steps of {} s, seed {}, scalar {} · hash {:016x}",
        statistics.trained,
        statistics.neurons,
        made.steps,
        f64::from(made.horizon_ms) / 1000.0,
        made.seed,
        map.scalar_name(),
        map.hash(),
    );
    (format!("Learned map of {columns} × {rows} neurons, seen from above, ahead is up"), under)
}

fn entries() -> Vec<(Mark, String)> {
    let entry = |mark: Mark, label: &str| (mark, label.to_owned());
    vec![
        entry(Mark::Dot(NEURON), "trained neuron"),
        entry(Mark::Hollow(UNTRAINED), "untrained neuron"),
        entry(Mark::Stroke(REACH), "reach of a step"),
        entry(Mark::Triangle(START), "robot"),
    ]
}

/// Distances that can be read: 1, 2 or 5 times a power of ten metres.
struct Scale {
    step_m: f64,
    digit: u32,
    /// The power of ten, as in `1e-2`.
    exponent: String,
}

impl Scale {
    /// The largest step of which the reach holds two.
    fn of(reach_m: f64) -> Self {
        // Printing with an exponent is the exact way to the first digit.
        let half = format!("{:e}", reach_m / 2.0);
        let (mantissa, exponent) = half.split_once('e').unwrap_or((&half, "0"));
        let digit = match mantissa.chars().next() {
            Some('5'..='9') => 5,
            Some('2'..='4') => 2,
            _ => 1,
        };
        let exponent = exponent.to_owned();
        let step_m = format!("{digit}e{exponent}").parse().unwrap_or(reach_m);
        Self { step_m, digit, exponent }
    }

    /// So many steps, as text.
    fn label(&self, steps: u32) -> String {
        let length: f64 = format!("{}e{}", self.digit * steps, self.exponent).parse().unwrap_or(self.step_m);
        if (1e-4..1e5).contains(&length) { format!("{length} m") } else { format!("{length:e} m") }
    }
}

/// Circles of equal distance, labelled behind the robot, where the fewest neurons are.
fn draw_rings(canvas: &Canvas, scale: &Scale, reach_m: f64) -> Group {
    let mut group = Group::new().set("stroke", RING).set("stroke-width", 1).set("fill", "none");
    let mut labels = Group::new();
    // At most four: the step is more than a fifth of the reach.
    for steps in 1..=4 {
        let radius_m = scale.step_m * f64::from(steps);
        if radius_m > reach_m {
            break;
        }
        group = group.add(circle(canvas, Point2::origin(), radius_m));
        let place = canvas.place(Point2::new(0.0, -radius_m)) + Vector2::new(0.0, -4.0);
        let label = text(place, 13.0, &scale.label(steps));
        labels = labels.add(label.set("text-anchor", "middle").set("fill", "#777777"));
    }
    Group::new().add(group).add(labels)
}

fn draw_reach(canvas: &Canvas, reach_m: f64) -> Circle {
    let ring = circle(canvas, Point2::origin(), reach_m).set("fill", "none");
    ring.set("stroke", REACH).set("stroke-width", 2)
}

/// Lines between neighbours on the lattice; those with an untrained end are paler.
fn draw_links(canvas: &Canvas, map: &MapRecords, places: &[Point2<f64>]) -> Group {
    let (mut trained, mut untrained) = (String::new(), String::new());
    let (_, rows) = map.lattice();
    let mut link = |from: usize, to: usize| {
        if let (Some(a), Some(b)) = (places.get(from), places.get(to)) {
            let both = map.neurons()[from].has_won && map.neurons()[to].has_won;
            let lines = if both { &mut trained } else { &mut untrained };
            lines.push_str(&canvas.path([*a, *b].into_iter()));
        }
    };
    for index in 0..places.len() {
        // The next column; behind the last one there are no places.
        link(index, index + rows);
        if (index + 1) % rows != 0 {
            link(index, index + 1);
        }
    }
    let lines = |data: String, colour: &'static str, opacity: f64| {
        Path::new().set("d", data).set("stroke", colour).set("stroke-opacity", opacity)
    };
    let group = Group::new().set("fill", "none").set("stroke-width", 1);
    group.add(lines(untrained, UNTRAINED, 0.45)).add(lines(trained, NEURON, 0.55))
}

/// A triangle that points ahead, larger than the knot of neurons at its middle: the file does not know the body's size.
fn draw_robot(canvas: &Canvas) -> Polygon {
    let place = canvas.place(Point2::origin());
    let corner = |x: f64, y: f64| format!("{},{}", decimal(place.x + x), decimal(place.y + y));
    let corners = [corner(0.0, -32.0), corner(24.0, 22.0), corner(-24.0, 22.0)].join(" ");
    let triangle = Polygon::new().set("points", corners).set("fill", START).set("fill-opacity", 0.2);
    triangle.set("stroke", START).set("stroke-width", 1.5)
}

fn draw_neurons(canvas: &Canvas, map: &MapRecords, places: &[Point2<f64>]) -> Group {
    let mut group = Group::new().set("stroke-width", 1.2);
    // The trained ones on top.
    for has_won in [false, true] {
        for (neuron, place) in
            map.neurons().iter().zip(places).filter(|(neuron, _)| neuron.has_won == has_won)
        {
            let place = canvas.place(*place);
            let dot = Circle::new().set("cx", decimal(place.x)).set("cy", decimal(place.y));
            let dot = dot.set("r", decimal(NEURON_RADIUS));
            group = group.add(if neuron.has_won {
                dot.set("fill", NEURON).set("stroke", "#ffffff")
            } else {
                dot.set("fill", "#ffffff").set("stroke", UNTRAINED)
            });
        }
    }
    group
}

#[cfg(test)]
mod tests {
    use super::{Scale, draw_map};
    use crate::map_report::tests::{header, learned, records};
    use protocol::map_file::{MapHeader, NeuronRecord};

    #[test]
    fn every_neuron_is_drawn_trained_or_not() {
        let (map, _) = learned::<f32>(1);
        let picture = draw_map(&map);
        let (trained, neurons) = (map.statistics().trained, map.neurons().len());
        let dots = |attribute: &str| {
            picture.lines().filter(|line| line.starts_with("<circle") && line.contains(attribute)).count()
        };
        // Each kind also stands in the legend once.
        assert_eq!(dots("fill=\"#0b62b0\""), trained + 1);
        assert_eq!(dots("stroke=\"#8a8a8a\""), neurons - trained + 1);
        for words in ["ahead is up", "15 × 15 neurons", "reach of a step", "0.05 m", "0.1 m", "0.15 m"] {
            assert!(picture.contains(words), "{words} is missing in {picture}");
        }
        // All neighbours: 14 × 15 along each axis.
        assert_eq!(picture.matches('M').count() - 3, 2 * 14 * 15, "but for the three of the scale bar");
        assert_eq!(picture, draw_map(&map));
    }

    #[test]
    fn ahead_is_up_and_left_is_left() {
        let at = |bearing_rad: f32| {
            let neuron = NeuronRecord {
                bearing_rad,
                distance_per_reach: 1.0,
                has_won: true,
                ..NeuronRecord::default()
            };
            let picture = draw_map(&records(&header(1, 1), &[neuron]).unwrap());
            let dot = picture.lines().find(|line| line.contains("stroke=\"#ffffff\"")).unwrap().to_owned();
            let value = |name: &str| {
                let (_, rest) = dot.split_once(&format!("{name}=\"")).unwrap();
                rest.split_once('"').unwrap().0.parse::<f64>().unwrap()
            };
            (value("cx"), value("cy"))
        };
        let (ahead, left) = (at(0.0), at(core::f32::consts::FRAC_PI_2));
        assert!(left.0 < ahead.0 - 100.0 && ahead.1 < left.1 - 100.0, "{ahead:?} {left:?}");
    }

    #[test]
    fn a_map_of_any_size_can_be_drawn() {
        for (reach_m, label) in
            [(0.001, "0.0005 m"), (30.0, "10 m"), (f32::MAX, "1e38 m"), (1e-40, "2e-41 m")]
        {
            let far = NeuronRecord { distance_per_reach: 2.0, ..NeuronRecord::default() };
            let map = records(&MapHeader { reach_m, ..header(1, 2) }, &[far; 2]).unwrap();
            let picture = draw_map(&map);
            assert!(
                picture.contains(label) && !picture.contains("NaN") && !picture.contains("inf"),
                "{picture}"
            );
        }
    }

    #[test]
    fn the_step_of_the_scale_goes_twice_into_the_reach() {
        for (reach_m, digit, exponent) in
            [(0.163_84, 5, "-2"), (2.0, 1, "0"), (1.999, 5, "-1"), (90.0, 2, "1")]
        {
            let scale = Scale::of(reach_m);
            assert_eq!((scale.digit, scale.exponent.as_str()), (digit, exponent));
            assert!(scale.step_m * 2.0 <= reach_m && reach_m / scale.step_m < 5.0 + 1e-9);
        }
    }
}
