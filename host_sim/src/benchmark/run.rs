//! One run over a course.

use controller_core::config::Config;
use controller_core::controller::{CHECKPOINTS, Mode};
use controller_core::units::Point;
use nalgebra::Point2;
use serde::Serialize;

use super::course::Course;
use super::course::TIME_LIMIT;
use super::pilot::{Following, Pilot};
use crate::khepera::{KheperaModel, TruePose};
use crate::mission::{MissionError, Sample};
use crate::number::narrow_point;
use crate::scenario::AVOIDANCE_PERIOD_MS;
use crate::sil::{ControllerPort, Order};
use crate::simulation::Simulation;

/// How to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunOptions {
    /// Seed of all noise.
    pub seed: u64,
    /// How the route is followed; `None` is decapitated: without planner, with the goal alone.
    pub following: Option<Following>,
    /// Milliseconds between two lines of the log; 0 for no log.
    pub sample_ms: u64,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The centre came within the tolerance of the goal, without contact.
    Goal,
    /// The body touched something.
    Contact,
    /// The time was over.
    Timeout,
    /// There is no route: the run was not begun.
    NoRoute,
}

/// What became of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CourseRun {
    /// Seed of the run.
    pub seed: u64,
    /// How it ended.
    pub end: End,
    /// AT: when, in s.
    pub time_s: f64,
    /// AT over OT.
    pub time_share: f64,
    /// The benchmark's score, 0 to 0.5.
    pub score: f64,
    /// Way driven in m.
    pub way_m: f64,
    /// Where it ended, in m.
    pub at: (f64, f64),
    /// Hash over all decisions and poses.
    pub hash: u64,
    /// The log.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

/// The configuration for a course and a way of being guided, on the base of another.
///
/// Where the planner goes on looking, two numbers are its own:
/// - the controller's **detour** is off: it measures progress by the distance to the checkpoint, which a checkpoint
///   that moves ahead of the robot keeps as it is, and the planner is the better judge of dead ends anyway;
/// - and the **swept path** needs no more room beside the body than the route has: a robot that asks for more waits
///   before the gap for ever.
#[must_use]
pub fn config_for(course: &Course, following: Option<Following>, base: &Config) -> Config {
    let mut config = base.clone();
    if let (Some(Following::Sight), Ok(route)) = (following, &course.route) {
        let cooperative = &mut config.cooperative;
        cooperative.detour_patience_ms = 0;
        cooperative.sweep_margin_m = cooperative.sweep_margin_m.min(route.margin_m.max(LEAST_ROOM_M));
    }
    config
}

/// Least room that a swept path can be asked to leave, in m.
const LEAST_ROOM_M: f32 = 0.001;

/// Drives a course once with a controller that has a trained map; `robot` gives the physical robot's numbers.
///
/// # Errors
/// If the controller refuses a checkpoint or cannot be reached any more.
pub fn run<C: ControllerPort>(
    course: &Course,
    controller: C,
    robot: &Config,
    options: RunOptions,
) -> Result<CourseRun, MissionError<C::Error>> {
    let shortest_s = course.shortest_s(robot.robot.speed_limit_mps);
    let scenario = &course.scenario;
    let start = TruePose { position: scenario.start.position, heading_rad: scenario.start.heading_rad };
    let Some(guide) = Guide::new(course, options.following) else {
        return Ok(not_begun(options.seed, start.position));
    };
    let model = KheperaModel::new(&robot.robot, &robot.servo, scenario.noise.actuator);
    let simulation =
        Simulation::new(controller, &scenario.world, model, &scenario.noise, start, options.seed);
    let mut drive = Drive { course, simulation, guide, samples: Vec::new() };
    let end = drive.drive(TIME_LIMIT * shortest_s, options.sample_ms)?;
    let time_s = drive.simulation.time_s();
    let place = drive.simulation.pose().position;
    let scored =
        if end == End::Goal { shortest_s / time_s.clamp(2.0 * shortest_s, 8.0 * shortest_s) } else { 0.0 };
    Ok(CourseRun {
        seed: options.seed,
        end,
        time_s,
        time_share: time_s / shortest_s,
        score: scored,
        way_m: drive.simulation.way_m(),
        at: (place.x, place.y),
        hash: drive.simulation.hash(),
        samples: drive.samples,
    })
}

fn not_begun(seed: u64, at: Point2<f64>) -> CourseRun {
    CourseRun {
        seed,
        end: End::NoRoute,
        time_s: 0.0,
        time_share: 0.0,
        score: 0.0,
        way_m: 0.0,
        at: (at.x, at.y),
        hash: 0,
        samples: Vec::new(),
    }
}

/// Who gives the controller its checkpoints.
enum Guide<'a> {
    /// A list that goes to the controller in parts; the number of those that it has been given.
    List(Vec<Point<f32>>, usize),
    /// The planner goes on looking.
    Pilot(Pilot<'a>),
}

impl<'a> Guide<'a> {
    /// `None` if there is a route to follow and there is none.
    fn new(course: &'a Course, following: Option<Following>) -> Option<Self> {
        let Some(following) = following else {
            return Some(Self::List(vec![narrow_point(course.goal)], 0));
        };
        let route = course.route.as_ref().ok()?;
        match following {
            Following::Checkpoints => {
                Some(Self::List(route.plan.checkpoints.iter().copied().map(narrow_point).collect(), 0))
            }
            Following::Sight => {
                let start = course.scenario.start.position;
                Pilot::new(&course.map, route, start, course.goal).map(Self::Pilot)
            }
        }
    }
}

struct Drive<'a, C> {
    course: &'a Course,
    simulation: Simulation<'a, C>,
    guide: Guide<'a>,
    samples: Vec<Sample>,
}

impl<C: ControllerPort> Drive<'_, C> {
    fn drive(&mut self, limit_s: f64, sample_ms: u64) -> Result<End, MissionError<C::Error>> {
        self.begin()?;
        while self.simulation.time_s() < limit_s {
            if self.simulation.tick().is_multiple_of(u64::from(AVOIDANCE_PERIOD_MS)) {
                self.look()?;
            }
            let outputs = self.simulation.step().map_err(MissionError::Port)?;
            if sample_ms > 0 && (self.simulation.tick() - 1).is_multiple_of(sample_ms) {
                self.samples.push(Sample::of(&self.simulation, &outputs, 0));
            }
            if outputs.reached.is_some() {
                self.refill(1)?;
            }
            if self.simulation.contacts() > 0 {
                return Ok(End::Contact);
            }
            if (self.simulation.pose().position - self.course.goal).norm() <= self.course.goal_tolerance_m {
                return Ok(End::Goal);
            }
        }
        Ok(End::Timeout)
    }

    fn begin(&mut self) -> Result<(), MissionError<C::Error>> {
        self.refill(CHECKPOINTS)?;
        self.simulation.controller.arm().map_err(MissionError::Port)?;
        self.simulation.controller.set_mode(Mode::Navigate, 0).map_err(MissionError::Port)
    }

    /// Gives the controller so many more checkpoints of a list.
    fn refill(&mut self, room: usize) -> Result<(), MissionError<C::Error>> {
        let Guide::List(places, given) = &mut self.guide else { return Ok(()) };
        let next = &places[*given..places.len().min(*given + room)];
        *given += next.len();
        if next.is_empty() {
            return Ok(());
        }
        Ok(self.simulation.controller.order(Order::Append(next)).map_err(MissionError::Port)??)
    }

    /// The pilot looks where the robot is and sets the checkpoint.
    fn look(&mut self) -> Result<(), MissionError<C::Error>> {
        let Guide::Pilot(pilot) = &mut self.guide else { return Ok(()) };
        let target = narrow_point(pilot.target(self.simulation.pose().position));
        Ok(self.simulation.controller.set_checkpoints(&[target]).map_err(MissionError::Port)??)
    }
}
