//! ROS `map_server` maps: a YAML file and a PGM image.
//!
//! A pixel of value v is occupied with p = 1 − v/maximum, or v/maximum with `negate`; above `occupied_thresh` it is
//! occupied, below `free_thresh` free, in between unknown (mode `trinary`). In mode `scale` what lies in between is
//! more or less likely occupied, in mode `raw` v itself is the percentage. Whatever the mode, only what is free is
//! passable here: a robot has no business in the unknown. `origin` is the pose of the lower left corner. Format:
//! <https://wiki.ros.org/map_server>, and <https://docs.nav2.org> for the modes.

use std::path::Path;

use nalgebra::Point2;
use serde::Deserialize;

use super::json_world::file_stem;
use super::pgm::{self, Pgm};
use super::{GridMap, ImportError, MapFrame, Reader, read_bytes, read_text};

#[derive(Debug, Deserialize)]
struct Raw {
    image: String,
    resolution: f64,
    origin: Vec<f64>,
    negate: Negate,
    occupied_thresh: f64,
    free_thresh: f64,
    #[serde(default)]
    mode: Mode,
}

/// Written as a number by most, as a truth value by some.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged)]
enum Negate {
    Number(u8),
    Truth(bool),
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

/// Reads a map; `scale` is metres here for a metre there, so that a map of another robot fits ours.
///
/// # Errors
/// If YAML or image cannot be read or make no sense.
pub fn load(path: &Path, scale: f64) -> Result<GridMap, ImportError> {
    let reader = Reader::new(path);
    let raw = parse_yaml(&reader, &read_text(path)?)?;
    let image_path = path.parent().unwrap_or(Path::new("")).join(&raw.image);
    let image = pgm::parse(&image_path, &read_bytes(&image_path)?)?;
    grid(path, &raw, &image, scale)
}

fn parse_yaml(reader: &Reader, text: &str) -> Result<Raw, ImportError> {
    serde_saphyr::from_str(text).map_err(|error| {
        let problem = error.to_string();
        let problem = problem.lines().next().unwrap_or_default().to_owned();
        let fix = "give image, resolution, origin, negate, occupied_thresh and free_thresh";
        reader.error("", problem, fix)
    })
}

fn grid(path: &Path, raw: &Raw, image: &Pgm, scale: f64) -> Result<GridMap, ImportError> {
    let reader = Reader::new(path);
    let [x, y, yaw_rad] = raw.origin[..] else {
        let problem = format!("{} numbers instead of 3", raw.origin.len());
        return Err(reader.error("origin", problem, "give x, y and yaw"));
    };
    let share = |key: &str, value: f64| {
        let wrong = || reader.error(key, format!("{value} is no probability"), "give 0 to 1");
        (0.0..=1.0).contains(&value).then_some(value).ok_or_else(wrong)
    };
    let free = share("free_thresh", raw.free_thresh)?;
    let occupied = share("occupied_thresh", raw.occupied_thresh)?;
    if free > occupied {
        let problem = format!("{free} is above occupied_thresh = {occupied}");
        return Err(reader.error("free_thresh", problem, "exchange them"));
    }
    let negate = match raw.negate {
        Negate::Number(0) | Negate::Truth(false) => false,
        Negate::Number(1) | Negate::Truth(true) => true,
        Negate::Number(other) => return Err(reader.error("negate", other.to_string(), "give 0 or 1")),
    };
    let free_values = FreeValues { mode: raw.mode, negate, free, maximum: f64::from(image.maximum) };
    // The image has its first row on top.
    let rows = image.values.chunks_exact(image.width).rev();
    let passable = rows.flatten().map(|&value| free_values.contain(value)).collect();
    let origin =
        Point2::new(reader.coordinate("origin[0]", x * scale)?, reader.coordinate("origin[1]", y * scale)?);
    let frame = MapFrame { origin, yaw_rad: reader.coordinate("origin[2]", yaw_rad)? };
    Ok(GridMap {
        name: file_stem(path).unwrap_or_default(),
        source: String::from("ROS map_server map"),
        columns: image.width,
        rows: image.height,
        cell_m: reader.length("resolution", raw.resolution * scale)?,
        frame,
        passable,
    })
}

/// Which values of pixels are free.
struct FreeValues {
    mode: Mode,
    negate: bool,
    free: f64,
    maximum: f64,
}

impl FreeValues {
    fn contain(&self, value: u16) -> bool {
        let value = f64::from(value);
        let occupied = match (self.mode, self.negate) {
            // Values above 100 are unknown, and above any threshold.
            (Mode::Raw, _) => value / 100.0,
            (Mode::Trinary | Mode::Scale, true) => value / self.maximum,
            (Mode::Trinary | Mode::Scale, false) => 1.0 - value / self.maximum,
        };
        occupied < self.free
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{Pgm, Reader, grid, parse_yaml};

    const YAML: &str = "image: a.pgm\nresolution: 0.05\norigin: [-1.0, 2.0, 0.5]\nnegate: 0\n\
                        occupied_thresh: 0.65\nfree_thresh: 0.196\n";

    fn passable(yaml: &str, values: &[u16]) -> Result<Vec<bool>, String> {
        let raw = parse_yaml(&Reader::new(Path::new("m.yaml")), yaml).map_err(|error| error.to_string())?;
        let image = Pgm { width: 1, height: values.len(), maximum: 255, values: values.to_vec() };
        Ok(grid(Path::new("m.yaml"), &raw, &image, 0.5).map_err(|error| error.to_string())?.passable)
    }

    #[test]
    fn only_what_is_free_is_passable_and_the_first_row_is_on_top() {
        assert_eq!(passable(YAML, &[254, 205, 0]).unwrap(), [false, false, true]);
        assert_eq!(passable(YAML, &[0, 206, 255]).unwrap(), [true, true, false]);
        let negated = YAML.replace("negate: 0", "negate: 1");
        assert_eq!(passable(&negated, &[0, 100, 255]).unwrap(), [false, false, true]);
        assert_eq!(passable(&negated.replace("negate: 1", "negate: true"), &[0]).unwrap(), [true]);
        let scale = format!("{YAML}mode: scale\nanother_key: 3\n");
        assert_eq!(passable(&scale, &[255, 150, 0]).unwrap(), [false, false, true]);
        let raw = format!("{YAML}mode: raw\n");
        assert_eq!(passable(&raw, &[0, 19, 20, 100, 255]).unwrap(), [false, false, false, true, true]);
    }

    #[test]
    fn scale_and_origin_are_taken() {
        let raw = parse_yaml(&Reader::new(Path::new("m.yaml")), YAML).unwrap();
        let image = Pgm { width: 2, height: 1, maximum: 1, values: vec![0, 1] };
        let map = grid(Path::new("m.yaml"), &raw, &image, 0.5).unwrap();
        assert!((map.cell_m - 0.025).abs() < 1e-12 && (map.frame.yaw_rad - 0.5).abs() < 1e-12);
        assert!((map.frame.origin.x + 0.5).abs() < 1e-12 && (map.frame.origin.y - 1.0).abs() < 1e-12);
        assert_eq!(map.passable, [false, true]);
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (from, to, said) in [
            ("resolution: 0.05", "resolution: 0", "resolution: 0 is no length"),
            ("resolution: 0.05", "resolution: .nan", "resolution: NaN"),
            ("resolution: 0.05\n", "", "resolution"),
            ("[-1.0, 2.0, 0.5]", "[-1.0, 2.0]", "origin: 2 numbers"),
            ("[-1.0, 2.0, 0.5]", "[.inf, 2.0, 0.0]", "origin[0]"),
            ("0.65", "1.5", "occupied_thresh: 1.5"),
            ("0.196", "0.8", "free_thresh: 0.8 is above"),
            ("negate: 0", "negate: 2", "negate: 2"),
            ("negate: 0", "mode: fuzzy\nnegate: 0", "fuzzy"),
            ("image: a.pgm", "image: [", "m.yaml: "),
        ] {
            let error = passable(&YAML.replace(from, to), &[0]).unwrap_err();
            assert!(error.starts_with("m.yaml: ") && error.contains(said), "{to}: {error}");
        }
        assert!(passable("", &[0]).is_err());
    }
}
