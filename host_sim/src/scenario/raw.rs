//! The scenario file as it is written: what serde sees, before anything is believed.

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::error::{ScenarioError, most_similar};

/// A point as `[x, y]` in metres.
pub(super) type RawPoint = [f64; 2];

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScenario {
    pub name: String,
    pub title: String,
    pub source: String,
    pub time_limit_s: f64,
    pub goal: Option<RawPoint>,
    pub checkpoints: Option<Vec<RawPoint>>,
    #[serde(default)]
    pub plan: bool,
    pub tolerance_m: Option<f64>,
    pub robot: RawRobot,
    #[serde(default)]
    pub robots: Vec<RawCompanion>,
    #[serde(default)]
    pub control: RawControl,
    #[serde(default)]
    pub noise: RawNoise,
    #[serde(default)]
    pub walls: Vec<RawSolid>,
    #[serde(default)]
    pub obstacles: Vec<RawSolid>,
    #[serde(default)]
    pub movers: Vec<RawMover>,
    #[serde(default)]
    pub replace: Vec<RawReplacement>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRobot {
    pub start: RawPoint,
    #[serde(default)]
    pub heading_deg: f64,
    #[serde(default)]
    pub jitter: RawJitter,
}

/// A robot beside that of `robot`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCompanion {
    pub start: RawPoint,
    #[serde(default)]
    pub heading_deg: f64,
    #[serde(default)]
    pub jitter: RawJitter,
    pub goal: Option<RawPoint>,
    pub checkpoints: Option<Vec<RawPoint>>,
}

#[derive(Debug, Deserialize, Default, Clone, Copy)]
#[serde(deny_unknown_fields)]
pub(super) struct RawJitter {
    #[serde(default)]
    pub position_m: f64,
    #[serde(default)]
    pub heading_deg: f64,
}

#[derive(Debug, Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawControl {
    pub controller: Option<RawController>,
    pub target_period_ms: Option<u32>,
}

#[derive(Debug, Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawController {
    Cooperative,
    Fusion,
}

#[derive(Debug, Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawNoise {
    pub sensor: Option<f64>,
    pub actuator: Option<f64>,
    pub sensor_resolution_m: Option<f64>,
    pub dropout: Option<f64>,
    pub beam_half_width_deg: Option<f64>,
    pub pose_position_m: Option<f64>,
    pub pose_heading_deg: Option<f64>,
}

/// A wall or an obstacle: exactly one of `line`, `rectangle`, `polygon` and `centre` says its shape.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSolid {
    pub line: Option<Vec<RawPoint>>,
    pub rectangle: Option<[RawPoint; 2]>,
    pub polygon: Option<Vec<RawPoint>>,
    pub centre: Option<RawPoint>,
    pub radius_m: Option<f64>,
    pub known: Option<bool>,
    pub from_s: Option<f64>,
    pub until_s: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMover {
    pub centre: RawPoint,
    pub orbit_radius_m: f64,
    pub speed_m_s: f64,
    #[serde(default)]
    pub phase_deg: f64,
    #[serde(default)]
    pub phase_jitter_deg: f64,
    #[serde(default)]
    pub direction: RawDirection,
    pub radius_m: Option<f64>,
}

#[derive(Debug, Deserialize, Clone, Copy, Default)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawDirection {
    #[default]
    Anticlockwise,
    Clockwise,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawReplacement {
    pub checkpoint: usize,
    pub to: RawPoint,
    pub at_s: Option<f64>,
    pub after_checkpoint: Option<usize>,
    pub delay_s: Option<f64>,
}

/// Reads a TOML text without judging its values; errors name the key and its place in the file.
pub(crate) fn toml_document<T: DeserializeOwned>(file: &str, text: &str) -> Result<T, ScenarioError> {
    let syntax = |error: &toml::de::Error| {
        let (line, column) = line_and_column(text, error.span().map_or(0, |span| span.start));
        ScenarioError::Syntax { file: file.to_owned(), line, column, problem: one_line(error.message()) }
    };
    let deserializer = toml::Deserializer::parse(text).map_err(|error| syntax(&error))?;
    serde_path_to_error::deserialize(deserializer).map_err(|error| key_error(file, text, &error))
}

fn key_error(file: &str, text: &str, error: &serde_path_to_error::Error<toml::de::Error>) -> ScenarioError {
    let problem = one_line(error.inner().message());
    let path = error.path().to_string();
    // serde quotes names with backticks: first the one at fault, then those it would have taken.
    let mut names = problem.split('`').skip(1).step_by(2);
    let at_fault = names.next().unwrap_or_default().to_owned();
    let accepted: Vec<&str> = names.collect();
    let missing = problem.starts_with("missing field");
    let (key, fix) = if missing {
        (join(&path, &at_fault), format!("add `{at_fault} = ...`{}", in_table(&path)))
    } else if accepted.is_empty() {
        (path, String::from("give it a value of the expected kind"))
    } else {
        let like = most_similar(&at_fault, accepted.iter().copied());
        let fix =
            like.map_or_else(|| String::from("use one of those"), |name| format!("did you mean `{name}`?"));
        (path, fix)
    };
    let (line, column) = line_and_column(text, error.inner().span().map_or(0, |span| span.start));
    ScenarioError::Key { file: file.to_owned(), line, column, key, problem, fix }
}

/// Path of `name` in the table at `path`; serde names the root `.`.
fn join(path: &str, name: &str) -> String {
    if path == "." { name.to_owned() } else { format!("{path}.{name}") }
}

fn in_table(path: &str) -> String {
    if path == "." { String::from(" above the first table") } else { format!(" to `{path}`") }
}

fn one_line(message: &str) -> String {
    message.split('\n').map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(", ")
}

/// Line and column of a byte offset, both from 1, columns in characters.
fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let last_line = before.rsplit('\n').next().unwrap_or_default();
    (before.matches('\n').count() + 1, last_line.chars().count() + 1)
}
