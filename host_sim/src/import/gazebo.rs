//! Gazebo worlds (SDF 1.6 and later): upright cylinders and boxes, seen from above.
//!
//! A model stands where `<state>` says, or else where its own pose says, as in Gazebo. What has no outline on the
//! ground (planes, lights) is left out; shapes that cannot be seen from above as a disc or a rectangle are refused, for
//! a world without them would be another world.
//!
//! The file has neither start nor goal. BARN's are the same for all of its worlds, in its metres: from (−2.25, 3)
//! heading along +y to a metre around (−2.25, 13) (the challenge's `run.py`, `INIT_POSITION` and `GOAL_POSITION`).

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Isometry2, Point2, Vector2};
use roxmltree::{Document, Node, ParsingOptions};

use super::json_world::file_stem;
use super::{ImportError, Reader, SHAPES_MAX, VectorWorld, read_text};
use crate::geometry::Polygon;
use crate::scenario::Shape;

/// BARN's scale at which the width of its robot (0.43 m) becomes the diameter of ours.
pub const SCALE_WIDTH: f64 = 0.05 / 0.43;

/// BARN's scale at which the circle around its robot (0.43 m × 0.508 m) becomes ours.
pub const SCALE_CIRCUMSCRIBED: f64 = 0.075_124_707_013_642_64;

/// Start, goal and tolerance of BARN in its own metres.
const BARN_START: (f64, f64) = (-2.25, 3.0);
const BARN_GOAL: (f64, f64) = (-2.25, 13.0);
const BARN_TOLERANCE: f64 = 1.0;

/// Most elements and texts of a file; a BARN world has some ten thousand.
const NODES_MAX: u32 = 4_000_000;

/// Roll or pitch in rad above which a shape does not stand upright.
const TILT_MAX_RAD: f64 = 1e-3;

/// Reads a world and scales it.
///
/// # Errors
/// If it cannot be read, is no SDF, or holds what cannot be seen from above.
pub fn load(path: &Path, scale: f64) -> Result<VectorWorld, ImportError> {
    parse(path, &read_text(path)?, scale)
}

/// A world from its text; `path` is what errors call it.
///
/// # Errors
/// As [`load`].
pub fn parse(path: &Path, text: &str, scale: f64) -> Result<VectorWorld, ImportError> {
    let reader = Reader::new(path);
    let options = ParsingOptions { nodes_limit: NODES_MAX, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options)
        .map_err(|error| reader.error("", format!("no XML: {error}"), "give a Gazebo world"))?;
    let world = document.root_element().children().find(|node| node.has_tag_name("world"));
    let world = world.ok_or_else(|| reader.error("", "no <sdf><world>".to_owned(), "give a Gazebo world"))?;
    let mut source = Source { reader: &reader, scale, stated: HashMap::new(), shapes: Vec::new() };
    source.read_state(world)?;
    for node in world.children().filter(Node::is_element) {
        match node.tag_name().name() {
            "model" => source.model(node)?,
            "include" | "actor" => source.not_read(node)?,
            _ => {}
        }
    }
    let at = |(x, y): (f64, f64)| Point2::new(x * scale, y * scale);
    Ok(VectorWorld {
        name: file_stem(path).unwrap_or_default(),
        source: String::from("Gazebo world"),
        shapes: source.shapes,
        start: at(BARN_START),
        heading_rad: core::f64::consts::FRAC_PI_2,
        goal: at(BARN_GOAL),
        goal_tolerance_m: BARN_TOLERANCE * scale,
        reference_length_m: None,
        gap_m: None,
        scale: Some(scale),
    })
}

struct Source<'a> {
    reader: &'a Reader,
    scale: f64,
    /// Poses of models in `<state>`.
    stated: HashMap<String, Isometry2<f64>>,
    shapes: Vec<Shape>,
}

impl Source<'_> {
    fn read_state(&mut self, world: Node) -> Result<(), ImportError> {
        let states = world.children().filter(|node| node.has_tag_name("state"));
        for model in states.flat_map(|state| state.children()).filter(|node| node.has_tag_name("model")) {
            if model.children().any(|node| node.has_tag_name("pose")) {
                let pose = self.pose(model)?;
                self.stated.insert(name_of(model), pose);
            }
        }
        Ok(())
    }

    fn model(&mut self, model: Node) -> Result<(), ImportError> {
        let stated = self.stated.get(&name_of(model)).copied();
        let pose = stated.map_or_else(|| self.pose(model), Ok)?;
        for link in model.children().filter(|node| node.has_tag_name("link")) {
            let link_pose = pose * self.pose(link)?;
            for collision in link.children().filter(|node| node.has_tag_name("collision")) {
                let collision_pose = link_pose * self.pose(collision)?;
                let geometries = collision.children().filter(|node| node.has_tag_name("geometry"));
                for shape in geometries.flat_map(|node| node.children()).filter(Node::is_element) {
                    self.shape(shape, &collision_pose)?;
                }
            }
        }
        match model.children().find(|node| node.has_tag_name("include") || node.has_tag_name("model")) {
            Some(nested) => self.not_read(nested),
            None => Ok(()),
        }
    }

    fn shape(&mut self, shape: Node, pose: &Isometry2<f64>) -> Result<(), ImportError> {
        let place = self.place(shape);
        let made = match shape.tag_name().name() {
            "plane" | "empty" => return Ok(()),
            "cylinder" => {
                let radius = self.lengths(shape, "radius")?;
                let [radius] = radius[..] else { return Err(self.wrong_count(&place, "radius", 1)) };
                let centre = pose.translation.vector * self.scale;
                self.reader.coordinate(&place, centre.x)?;
                self.reader.coordinate(&place, centre.y)?;
                VectorWorld::post(centre.x, centre.y, radius)
            }
            "box" => {
                let size = self.lengths(shape, "size")?;
                let [x, y, _] = size[..] else { return Err(self.wrong_count(&place, "size", 3)) };
                self.rectangle(&place, pose, Vector2::new(x, y) * 0.5)?
            }
            other => {
                let problem = format!("<{other}> cannot be seen from above as a disc or a rectangle");
                return Err(self.reader.error(&place, problem, "use cylinders and boxes"));
            }
        };
        if self.shapes.len() == SHAPES_MAX {
            let problem = format!("more than {SHAPES_MAX} shapes");
            return Err(self.reader.error(&place, problem, "give a smaller world"));
        }
        self.shapes.push(made);
        Ok(())
    }

    /// A box of these half sides, in scaled metres.
    fn rectangle(
        &self,
        place: &str,
        pose: &Isometry2<f64>,
        half: Vector2<f64>,
    ) -> Result<Shape, ImportError> {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
            let corner = Vector2::new(x * half.x, y * half.y);
            Point2::from(pose.translation.vector * self.scale + pose.rotation * corner)
        });
        for corner in corners {
            self.reader.coordinate(place, corner.x)?;
            self.reader.coordinate(place, corner.y)?;
        }
        let flat = || self.reader.error(place, "a box without area".to_owned(), "give it a size");
        Ok(Shape::Polygon(Polygon::new(&corners).ok_or_else(flat)?))
    }

    /// The numbers of a child, scaled.
    fn lengths(&self, shape: Node, child: &str) -> Result<Vec<f64>, ImportError> {
        let place = self.place(shape);
        let text = shape.children().find(|node| node.has_tag_name(child)).and_then(|node| node.text());
        let text = text.ok_or_else(|| {
            self.reader.error(&place, format!("<{child}> is missing"), "give the size of the shape")
        })?;
        let length =
            |word: &str| self.reader.length(&place, self.reader.number::<f64>(&place, word)? * self.scale);
        text.split_whitespace().map(length).collect()
    }

    /// The pose of an element in its parent, the identity if it says nothing.
    fn pose(&self, element: Node) -> Result<Isometry2<f64>, ImportError> {
        let Some(pose) = element.children().find(|node| node.has_tag_name("pose")) else {
            return Ok(Isometry2::identity());
        };
        let place = self.place(pose);
        let relative = pose.attributes().find(|attribute| {
            matches!(attribute.name(), "frame" | "relative_to") && !attribute.value().is_empty()
        });
        if let Some(attribute) = relative {
            let problem = format!("a pose relative to `{}`", super::error::shortened(attribute.value()));
            return Err(self.reader.error(&place, problem, "give poses relative to the parent"));
        }
        let words = pose.text().unwrap_or_default().split_whitespace();
        let numbers: Vec<f64> =
            words.map(|word| self.reader.number(&place, word)).collect::<Result<_, _>>()?;
        let [x, y, _, roll, pitch, yaw] = numbers[..] else {
            return Err(self.wrong_count(&place, "pose", 6));
        };
        if !(roll.abs() <= TILT_MAX_RAD && pitch.abs() <= TILT_MAX_RAD) {
            let problem = format!("roll {roll} and pitch {pitch} rad: does not stand upright");
            return Err(self.reader.error(&place, problem, "stand it up"));
        }
        let fits = |value: f64| self.reader.coordinate(&place, value * self.scale).map(|_| value);
        let yaw = if yaw.is_finite() { yaw } else { fits(yaw)? };
        let rotation = nalgebra::UnitComplex::from_cos_sin_unchecked(libm::cos(yaw), libm::sin(yaw));
        Ok(Isometry2::from_parts(Vector2::new(fits(x)?, fits(y)?).into(), rotation))
    }

    /// Refuses what stands for a shape elsewhere, unless it is one of Gazebo's that has none.
    fn not_read(&self, node: Node) -> Result<(), ImportError> {
        let uri = node.children().find(|child| child.has_tag_name("uri")).and_then(|uri| uri.text());
        if matches!(uri.map(str::trim), Some("model://sun" | "model://ground_plane")) {
            return Ok(());
        }
        let problem = format!("<{}> is not read", node.tag_name().name());
        Err(self.reader.error(&self.place(node), problem, "write its shapes into the world"))
    }

    fn wrong_count(&self, place: &str, what: &str, count: usize) -> ImportError {
        self.reader.error(place, format!("<{what}> has not {count} number(s)"), "correct it")
    }

    fn place(&self, node: Node) -> String {
        let position = node.document().text_pos_at(node.range().start);
        format!("line {}", position.row)
    }
}

fn name_of(node: Node) -> String {
    node.attribute("name").unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Point2;

    use super::{SCALE_WIDTH, parse};
    use crate::scenario::Shape;

    fn model(name: &str, pose: &str, geometry: &str) -> String {
        format!(
            "<model name='{name}'><pose frame=''>{pose}</pose><link name='l'><collision name='c'>\
             <geometry>{geometry}</geometry></collision></link></model>"
        )
    }

    fn shapes(inside: &str) -> Result<Vec<Shape>, String> {
        let text = format!("<sdf version='1.6'>\n<world name='w'>\n{inside}</world></sdf>");
        let world = parse(Path::new("w.world"), &text, 0.1).map_err(|error| error.to_string())?;
        assert!((world.start - Point2::new(-0.225, 0.3)).norm() < 1e-12);
        assert!((world.goal - Point2::new(-0.225, 1.3)).norm() < 1e-12);
        Ok(world.shapes)
    }

    #[test]
    fn cylinders_and_boxes_stand_where_state_or_pose_say() {
        let post = "<cylinder><radius>0.5</radius><length>1</length></cylinder>";
        let inside = model("a", "1 2 0 0 0 0", post)
            + &model("b", "1 2 0 0 0 0", post)
            + &model("c", "1 0 0 0 0 1.5707963267948966", "<box><size>4 2 1</size></box>")
            + &model("ground_plane", "0 0 0 0 0 0", "<plane><normal>0 0 1</normal></plane>")
            + "<state><model name='b'><pose>3 4 0 0 0 0</pose></model></state>";
        let shapes = shapes(&inside).unwrap();
        let [Shape::Disc(a), Shape::Disc(b), Shape::Polygon(c)] = &shapes[..] else { panic!("{shapes:?}") };
        assert!((a.centre - Point2::new(0.1, 0.2)).norm() < 1e-12 && (a.radius_m - 0.05).abs() < 1e-12);
        assert!((b.centre - Point2::new(0.3, 0.4)).norm() < 1e-12);
        let bounds = c.bounds();
        assert!((bounds.low - Point2::new(0.0, -0.2)).norm() < 1e-12, "{bounds:?}");
        assert!((bounds.high - Point2::new(0.2, 0.2)).norm() < 1e-12, "{bounds:?}");
    }

    #[test]
    fn what_cannot_be_taken_is_refused_with_its_line() {
        let post = "<cylinder><radius>0.5</radius></cylinder>";
        for (inside, said) in [
            (model("a", "1 2 0 0.5 0 0", post), "line 3: roll 0.5"),
            (model("a", "1 2", post), "6 number"),
            (model("a", "1 x 0 0 0 0", post), "`x`"),
            (model("a", "NaN 0 0 0 0 0", post), "NaN m"),
            (model("a", "1e9 0 0 0 0 0", post), "±1000 m"),
            (model("a", "0 0 0 0 0 0", "<cylinder/>"), "<radius> is missing"),
            (model("a", "0 0 0 0 0 0", "<cylinder><radius>-1</radius></cylinder>"), "no length"),
            (model("a", "0 0 0 0 0 0", "<mesh/>"), "<mesh>"),
            (String::from("<include><uri>model://table</uri></include>"), "<include> is not read"),
            (String::from("<model>"), "no XML"),
        ] {
            let error = shapes(&inside).unwrap_err();
            assert!(error.starts_with("w.world: ") && error.contains(said), "{inside}: {error}");
        }
        assert!(shapes("<include><uri>model://sun</uri></include>").unwrap().is_empty());
        for text in ["", "<a/>", "<!DOCTYPE a [<!ENTITY b 'c'>]><sdf/>"] {
            assert!(parse(Path::new("w.world"), text, SCALE_WIDTH).is_err(), "{text}");
        }
    }

    #[test]
    fn a_thousand_nested_elements_are_no_danger() {
        for depth in [1_000, 100_000] {
            let text = format!("<sdf><world>{}{}</world></sdf>", "<a>".repeat(depth), "</a>".repeat(depth));
            // Read or refused; the stack must not overflow.
            let _ = parse(Path::new("w.world"), &text, SCALE_WIDTH);
        }
    }
}
