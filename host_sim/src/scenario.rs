//! An experiment as a file: the world, where the robot starts, where it shall go, and what disturbs it.
//!
//! A file is TOML, in metres, degrees and seconds; `scenarios/*.toml` of this crate are built in and are the best
//! description of the format. It is read in two steps: `raw` takes the text apart, `check` believes nothing of it.
//! What comes out is a [`Scenario`] that can be run: every number is finite, every shape has a size, and the robot, the
//! checkpoints and the movers stand clear of the walls.
//!
//! *Known* solids are on the planner's map; the others are unforeseen, and only the sensors can find them. Walls are
//! known and obstacles are unforeseen unless the file says otherwise.

mod builtin;
mod check;
mod error;
mod raw;

use std::path::Path;

use nalgebra::Point2;

use crate::geometry::{Disc, Polygon, Segment};
use crate::raster::{Raster, RasterError};
use crate::solids::Solids;
use crate::world::{Window, World};

pub use error::ScenarioError;
pub(crate) use raw::toml_document;

/// Period of obstacle avoidance in ms, of which the target-reaching period is a multiple.
pub const AVOIDANCE_PERIOD_MS: u32 = 128;

/// A checked experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Short name for files and commands: letters, digits, `-` and `_`.
    pub name: String,
    /// Title for figures.
    pub title: String,
    /// The figure of the papers that it reproduces, or where else it comes from.
    pub source: String,
    /// Where the robot starts.
    pub start: Start,
    /// Where it shall go.
    pub route: Route,
    /// Further robots in the same world, where there are several.
    pub companions: Vec<Companion>,
    /// Checkpoints that the planner exchanges under way.
    pub replacements: Vec<Replacement>,
    /// A checkpoint is reached at less than this distance, in m.
    pub tolerance_m: f64,
    /// The run is given up at this time, in s.
    pub time_limit_s: f64,
    /// Which way of integrating behaviours runs if the user does not say.
    pub controller: ControllerKind,
    /// Period of target reaching in ms, a multiple of [`AVOIDANCE_PERIOD_MS`].
    pub target_period_ms: u32,
    /// What disturbs sensors, motors and pose.
    pub noise: NoiseLevels,
    /// Walls, then obstacles, in the file's order.
    pub solids: Vec<Solid>,
    /// What can be touched and seen: `solids` and the movers, laid out for the simulator.
    pub world: World,
}

/// A further robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Companion {
    /// Where it starts.
    pub start: Start,
    /// Where it shall go.
    pub checkpoints: Vec<Point2<f64>>,
}

/// The robot's pose at time zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Centre of the body.
    pub position: Point2<f64>,
    /// Heading in rad, anticlockwise from +x.
    pub heading_rad: f64,
    /// The position is drawn uniformly from a disc of this radius in m; the checks leave room for it.
    pub jitter_position_m: f64,
    /// The heading is drawn uniformly from ± this angle in rad.
    pub jitter_heading_rad: f64,
}

/// How the robot gets its checkpoints.
#[derive(Debug, Clone, PartialEq)]
pub enum Route {
    /// They are given, at least one; the last is the goal.
    Checkpoints(Vec<Point2<f64>>),
    /// The planner finds them on the known map.
    Planned {
        /// The goal.
        goal: Point2<f64>,
    },
}

impl Route {
    /// The checkpoints that are known without planning: all of them, or the goal alone.
    #[must_use]
    pub fn checkpoints(&self) -> &[Point2<f64>] {
        match self {
            Self::Checkpoints(checkpoints) => checkpoints,
            Self::Planned { goal } => core::slice::from_ref(goal),
        }
    }
}

/// A checkpoint that is exchanged while the robot is under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Replacement {
    /// When.
    pub trigger: Trigger,
    /// Index of the checkpoint, from 0 (files and figures count from 1).
    pub checkpoint: usize,
    /// Its new place.
    pub to: Point2<f64>,
}

/// When a checkpoint is exchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trigger {
    /// At a time of the run, in s.
    At {
        /// The time.
        t_s: f64,
    },
    /// Some time after another checkpoint was reached.
    AfterCheckpoint {
        /// Index of the checkpoint, from 0.
        checkpoint: usize,
        /// Seconds after it was reached.
        delay_s: f64,
    },
}

/// How target reaching and obstacle avoidance become one command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ControllerKind {
    /// Cooperative EKMs with neural integration (P2).
    Cooperative,
    /// Braitenberg avoidance and command fusion (P1).
    Fusion,
}

/// What disturbs sensors, motors and pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseLevels {
    /// Fraction of a range reading, 0 to 1.
    pub sensor: f64,
    /// Fraction of a wheel command, 0 to 1.
    pub actuator: f64,
    /// Step to which ranges are rounded, in m; zero for none.
    pub sensor_resolution_m: f64,
    /// Share of readings that are missing, as if nothing were there, 0 to 1.
    pub dropout: f64,
    /// Half the width of a sensor's cone in rad; zero for a pencil ray.
    pub beam_half_width_rad: f64,
    /// Error of the pose fix's position in m.
    pub pose_position_m: f64,
    /// Error of the pose fix's heading in rad.
    pub pose_heading_rad: f64,
    /// Avoidance and target reaching have their answers late by up to so many ms, see [`crate::lateness`].
    pub task_jitter_ms: u16,
}

/// A wall or obstacle.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Its shape.
    pub shape: Shape,
    /// Whether the planner knows of it.
    pub known: bool,
    /// When it is there.
    pub window: Window,
}

/// The shape of a wall or obstacle.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A wall of zero thickness along two points or more.
    Line(Vec<Point2<f64>>),
    /// A solid block.
    Polygon(Polygon),
    /// A round post.
    Disc(Disc),
}

impl Shape {
    /// Adds the shape to a set.
    pub fn add_to(&self, solids: &mut Solids) {
        match self {
            Self::Line(points) => {
                solids.segments.extend(points.windows(2).map(|ends| Segment::new(ends[0], ends[1])));
            }
            Self::Polygon(polygon) => solids.polygons.push(polygon.clone()),
            Self::Disc(disc) => solids.discs.push(*disc),
        }
    }
}

impl Scenario {
    /// Names of the built-in scenarios of several robots.
    pub fn fleet_names() -> impl ExactSizeIterator<Item = &'static str> {
        builtin::FLEETS.iter().map(|(name, _)| *name)
    }

    /// Names of the built-in scenarios of one robot, in the papers' order.
    pub fn builtin_names() -> impl ExactSizeIterator<Item = &'static str> {
        builtin::ALL.iter().map(|(name, _)| *name)
    }

    /// A built-in scenario.
    ///
    /// # Errors
    ///
    /// If there is none of that name.
    pub fn builtin(name: &str) -> Result<Self, ScenarioError> {
        Self::parse(&format!("{name} (built in)"), Self::builtin_text(name)?)
    }

    /// The file of a built-in scenario, to be copied and edited.
    ///
    /// # Errors
    ///
    /// If there is none of that name.
    pub fn builtin_text(name: &str) -> Result<&'static str, ScenarioError> {
        let found = builtin::ALL.iter().chain(&builtin::FLEETS).find(|(builtin, _)| *builtin == name);
        found.map(|(_, text)| *text).ok_or_else(|| builtin::not_found(name))
    }

    /// A built-in scenario by its name, or a file by its path.
    ///
    /// # Errors
    ///
    /// If there is neither, or the file cannot be read or makes no sense.
    pub fn load(name_or_path: &str) -> Result<Self, ScenarioError> {
        let is_builtin = Self::builtin_names().chain(Self::fleet_names()).any(|name| name == name_or_path);
        if is_builtin || !Path::new(name_or_path).exists() {
            return Self::builtin(name_or_path);
        }
        let unreadable = |source| ScenarioError::Unreadable { file: name_or_path.to_owned(), source };
        Self::parse(name_or_path, &std::fs::read_to_string(name_or_path).map_err(unreadable)?)
    }

    /// A scenario from its text; `file` is what errors call it.
    ///
    /// # Errors
    ///
    /// If the text is not TOML, has unknown or missing keys, or describes something that cannot be run.
    pub fn parse(file: &str, text: &str) -> Result<Self, ScenarioError> {
        check::scenario(file, &toml_document::<raw::RawScenario>(file, text)?)
    }

    /// How many robots are driven.
    #[must_use]
    pub fn robot_count(&self) -> usize {
        self.companions.len() + 1
    }

    /// The experiment as one of its robots meets it, without the others: 0 is the first, a number beyond the last as
    /// well.
    #[must_use]
    pub fn of_robot(&self, robot: usize) -> Self {
        let mut scenario = Self { companions: Vec::new(), ..self.clone() };
        if let Some(companion) = robot.checked_sub(1).and_then(|index| self.companions.get(index)) {
            scenario.start = companion.start;
            scenario.route = Route::Checkpoints(companion.checkpoints.clone());
            scenario.replacements.clear();
        }
        scenario
    }

    /// An experiment with known shapes only, under the papers' noise and schedule, with cooperative EKMs.
    ///
    /// Nothing is checked: whoever imports a world from elsewhere decides what to make of a start in a wall.
    #[must_use]
    pub fn of_known(name: &str, source: &str, shapes: Vec<Shape>, start: Start, goal: Point2<f64>) -> Self {
        let solid = |shape| Solid { shape, known: true, window: Window::ALWAYS };
        let solids: Vec<Solid> = shapes.into_iter().map(solid).collect();
        let mut world = check::world(&solids, Vec::new());
        world.permanent = world.permanent.indexed();
        Self {
            name: name.to_owned(),
            title: name.to_owned(),
            source: source.to_owned(),
            start,
            route: Route::Planned { goal },
            replacements: Vec::new(),
            companions: Vec::new(),
            tolerance_m: 0.005,
            time_limit_s: f64::INFINITY,
            controller: ControllerKind::Cooperative,
            target_period_ms: 2 * AVOIDANCE_PERIOD_MS,
            noise: crate::simulation::PAPERS,
            world,
            solids,
        }
    }

    /// The same experiment with these checkpoints, such as a planner's.
    #[must_use]
    pub fn with_checkpoints(mut self, checkpoints: Vec<Point2<f64>>) -> Self {
        self.route = Route::Checkpoints(checkpoints);
        self
    }

    /// The planner's map at the start of the run: the known walls and obstacles that are there at time zero.
    ///
    /// # Errors
    ///
    /// If the cell size is not positive or too small, or nothing is known.
    pub fn known_raster(&self, cell_size_m: f64) -> Result<Raster, RasterError> {
        self.known_raster_at(cell_size_m, 0.0)
    }

    /// The planner's map of what is there at time `t_s`, for planning again after a change.
    ///
    /// # Errors
    ///
    /// As [`Scenario::known_raster`].
    pub fn known_raster_at(&self, cell_size_m: f64, t_s: f64) -> Result<Raster, RasterError> {
        let known = self.solids.iter().filter(|solid| solid.known && solid.window.contains(t_s));
        Raster::of(known.map(|solid| &solid.shape), cell_size_m)
    }

    /// The last checkpoint.
    #[must_use]
    pub fn goal(&self) -> Option<Point2<f64>> {
        self.route.checkpoints().last().copied()
    }
}
