//! JSON worlds at the robot's scale: `circles`, `segments`, `start`, `goal`, and what the benchmark says of them.
//!
//! Metres and radians. `start` is x, y and heading, `goal` x and y, a circle x, y and radius, a segment x and y of both
//! ends. What is left out: `goal_tol` (a tenth of a metre), `official_path_len` or `shortest_m`, `gap_bottleneck_m`,
//! `scale`. Other keys are not read.

use std::path::Path;

use nalgebra::Point2;
use serde::Deserialize;

use super::{ImportError, Reader, SHAPES_MAX, VectorWorld, read_text};
use crate::scenario::Shape;

/// How near the goal counts where the file does not say, in m.
const GOAL_TOLERANCE_M: f64 = 0.1;

#[derive(Debug, Deserialize)]
struct Raw {
    #[serde(default)]
    name: Option<String>,
    #[serde(default)]
    source: Option<String>,
    #[serde(default)]
    circles: Vec<[f64; 3]>,
    #[serde(default)]
    segments: Vec<[f64; 4]>,
    start: [f64; 3],
    goal: [f64; 2],
    #[serde(default)]
    goal_tol: Option<f64>,
    #[serde(default)]
    official_path_len: Option<f64>,
    #[serde(default)]
    shortest_m: Option<f64>,
    #[serde(default)]
    gap_bottleneck_m: Option<f64>,
    #[serde(default)]
    scale: Option<f64>,
}

/// Reads a world.
///
/// # Errors
/// If it cannot be read, is no such JSON, or holds what makes no sense.
pub fn load(path: &Path) -> Result<VectorWorld, ImportError> {
    parse(path, &read_text(path)?)
}

/// A world from its text; `path` is what errors call it, and its stem the name of a world that has none.
///
/// # Errors
/// As [`load`].
pub fn parse(path: &Path, text: &str) -> Result<VectorWorld, ImportError> {
    let reader = Reader::new(path);
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let raw: Raw = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let problem = error.inner().to_string();
        reader.error(
            &error.path().to_string(),
            problem,
            "give a world with `start`, `goal`, `circles`, `segments`",
        )
    })?;
    let end = deserializer.end();
    end.map_err(|error| reader.error("", error.to_string(), "give one JSON object and nothing behind it"))?;
    let [x, y, heading_rad] = raw.start;
    let optional = |key: &str, value: Option<f64>| value.map(|value| reader.length(key, value)).transpose();
    let tolerance = optional("goal_tol", raw.goal_tol)?;
    let official = optional("official_path_len", raw.official_path_len)?;
    let shortest = optional("shortest_m", raw.shortest_m)?;
    Ok(VectorWorld {
        shapes: shapes(&reader, &raw)?,
        start: point(&reader, "start", [x, y])?,
        heading_rad: reader.coordinate("start[2]", heading_rad)?,
        goal: point(&reader, "goal", raw.goal)?,
        goal_tolerance_m: tolerance.unwrap_or(GOAL_TOLERANCE_M),
        reference_length_m: official.or(shortest),
        gap_m: optional("gap_bottleneck_m", raw.gap_bottleneck_m)?,
        scale: optional("scale", raw.scale)?,
        name: file_stem(path).or(raw.name).unwrap_or_default(),
        source: raw.source.unwrap_or_default(),
    })
}

/// The name of a file without folder and ending: worlds of two scales have the same name inside.
pub(super) fn file_stem(path: &Path) -> Option<String> {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned())
}

fn shapes(reader: &Reader, raw: &Raw) -> Result<Vec<Shape>, ImportError> {
    let count = raw.circles.len() + raw.segments.len();
    if count > SHAPES_MAX {
        let problem = format!("{count} shapes are more than {SHAPES_MAX}");
        return Err(reader.error("circles", problem, "give a smaller world"));
    }
    let mut shapes = Vec::with_capacity(count);
    for (i, &[x, y, radius]) in raw.circles.iter().enumerate() {
        let place = format!("circles[{i}]");
        let [x, y] = [reader.coordinate(&place, x)?, reader.coordinate(&place, y)?];
        shapes.push(VectorWorld::post(x, y, reader.length(&place, radius)?));
    }
    for (i, &ends) in raw.segments.iter().enumerate() {
        for value in ends {
            reader.coordinate(&format!("segments[{i}]"), value)?;
        }
        shapes.push(VectorWorld::wall((ends[0], ends[1]), (ends[2], ends[3])));
    }
    Ok(shapes)
}

fn point(reader: &Reader, key: &str, [x, y]: [f64; 2]) -> Result<Point2<f64>, ImportError> {
    Ok(Point2::new(reader.coordinate(key, x)?, reader.coordinate(key, y)?))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Point2;

    use super::parse;
    use crate::scenario::Shape;

    fn world(text: &str) -> Result<super::VectorWorld, String> {
        parse(Path::new("some.json"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn what_a_world_says_is_taken_and_the_rest_has_defaults() {
        let world = world(
            r#"{"circles": [[1, 2, 0.5]], "segments": [[0, 0, 3, 0]], "start": [0, 1, 1.5], "goal": [2, 3],
                "official_path_len": 4.5, "gap_bottleneck_m": 0.06, "other": [1]}"#,
        )
        .unwrap();
        assert_eq!((world.start, world.goal), (Point2::new(0.0, 1.0), Point2::new(2.0, 3.0)));
        assert_eq!((world.reference_length_m, world.gap_m, world.scale), (Some(4.5), Some(0.06), None));
        assert_eq!((world.name.as_str(), world.goal_tolerance_m), ("some", 0.1));
        assert!(matches!(world.shapes[0], Shape::Disc(disc) if disc.radius_m.to_bits() == 0.5_f64.to_bits()));
        assert!(matches!(&world.shapes[1], Shape::Line(points) if points.len() == 2));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        for (text, place) in [
            ("", "some.json: "),
            ("[]", "some.json: "),
            (r#"{"goal": [0, 0]}"#, "`start`"),
            (r#"{"start": [0, 0, 0], "goal": [0, "x"]}"#, "goal[1]"),
            (r#"{"start": [0, 0, 0], "goal": [0, 1e9]}"#, "goal: 1000000000 m"),
            (r#"{"start": [0, 0, 0], "goal": [0, 0], "circles": [[0, 0, 1], [0, 0, -1]]}"#, "circles[1]: -1"),
            (r#"{"start": [0, 0, 0], "goal": [0, 0], "goal_tol": 0}"#, "goal_tol: 0"),
            (r#"{"start": [0, 0, 0], "goal": [0, 0]} x"#, "trailing"),
        ] {
            let error = world(text).unwrap_err();
            assert!(error.contains(place), "{text}: {error}");
        }
    }
}
