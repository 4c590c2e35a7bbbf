//! One run of a scenario, from start to goal: what the papers' figures show.

use core::convert::Infallible;

use controller_core::config::Config;
use controller_core::controller::{Mode, Outputs};
use controller_core::planning::checkpoint::{CheckpointError, Reached};
use controller_core::safety::StopCause;
use nalgebra::Point2;
use serde::Serialize;

use crate::contender::Contender;
use crate::khepera::{KheperaModel, TruePose, wrapped};
use crate::number::narrow_point;
use crate::random::{Purpose, Stream};
use crate::route_planner::{self, RouteError};
use crate::scenario::{Route, Scenario, Trigger};
use crate::sil::{ControllerPort, Order};
use crate::simulation::{Simulation, seconds};
use crate::world::World;

/// Why a mission cannot begin or go on; `E` is what can be wrong with the way to the controller.
#[derive(Debug, thiserror::Error)]
pub enum MissionError<E: core::error::Error = Infallible> {
    /// There is no plan.
    #[error(transparent)]
    Route(#[from] RouteError),
    /// The controller does not take the checkpoints.
    #[error("the controller refuses the checkpoints: {0}")]
    Checkpoints(#[from] CheckpointError),
    /// The controller cannot be reached any more.
    #[error("{0}")]
    Port(E),
}

/// A checkpoint that was reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Arrival {
    /// Number from 1, as in files and figures.
    pub checkpoint: u16,
    /// When, in s.
    pub t_s: f64,
    /// True distance of the robot's centre; at the goal after the robot has come to rest. In m.
    pub error_m: f64,
}

/// A line of the log.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sample {
    /// Time in s.
    pub t_s: f64,
    /// True position in m.
    pub x_m: f64,
    /// True position in m.
    pub y_m: f64,
    /// True heading in rad.
    pub heading_rad: f64,
    /// Commanded speed of the left wheel in m/s.
    pub left_mps: f32,
    /// Commanded speed of the right wheel in m/s.
    pub right_mps: f32,
    /// Checkpoint on the way, from 1.
    pub checkpoint: u16,
    /// Contacts so far.
    pub contacts: u32,
}

impl Sample {
    /// Of the tick that a simulation has just made.
    pub(crate) fn of<C: ControllerPort>(
        simulation: &Simulation<'_, C>,
        outputs: &Outputs<f32>,
        checkpoint: u16,
    ) -> Self {
        let pose = simulation.pose();
        let command = outputs.command.value;
        Self {
            t_s: seconds(simulation.tick() - 1),
            x_m: pose.position.x,
            y_m: pose.position.y,
            heading_rad: pose.heading_rad,
            left_mps: command.left_mps,
            right_mps: command.right_mps,
            checkpoint,
            contacts: simulation.contacts(),
        }
    }
}

/// What became of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MissionResult {
    /// Seed of the run.
    pub seed: u64,
    /// The goal was reached in time.
    pub reached: bool,
    /// All checkpoints were reached within the scenario's tolerance, and nothing was touched.
    pub success: bool,
    /// Contacts.
    pub contacts: u32,
    /// When the robot reached the goal or was given up, in s.
    pub duration_s: f64,
    /// Way driven, in m.
    pub way_m: f64,
    /// How much the heading changed, taken each 128 ms whichever way it turned, in rad: over the way, how
    /// smoothly the robot drove.
    pub turned_rad: f64,
    /// Checkpoints in the order reached.
    pub arrivals: Vec<Arrival>,
    /// Checkpoints that there were.
    pub checkpoints: Vec<(f64, f64)>,
    /// Why the wheels last had to stand still after the start, if ever.
    pub stopped: Option<StopCause>,
    /// Hash over all decisions and poses.
    pub hash: u64,
    /// The log, every [`MissionOptions::sample_ms`]; empty if that is 0.
    #[serde(skip)]
    pub samples: Vec<Sample>,
}

/// How to run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MissionOptions {
    /// Seed of start, noise and everything else that is drawn.
    pub seed: u64,
    /// Milliseconds between two lines of the log; 0 for no log.
    pub sample_ms: u64,
}

/// The configuration that a scenario asks for, on the base of another; without a contender, for the one that the
/// scenario names. Of what peers need, it has the robot and the schedule.
#[must_use]
pub fn config_for(scenario: &Scenario, base: &Config, contender: Option<Contender>) -> Config {
    let mut config = base.clone();
    let contender = contender.unwrap_or_else(|| Contender::of(scenario));
    config.architecture = contender.architecture().unwrap_or(base.architecture);
    // Checked by the scenario: a multiple of 128 below 10 s.
    config.schedule.target_period_ms = u16::try_from(scenario.target_period_ms).unwrap_or(u16::MAX);
    config
}

/// Milliseconds between two headings of [`MissionResult::turned_rad`]: the period of obstacle avoidance.
const TURN_PERIOD_MS: u64 = 128;

/// How long the robot may roll out at the goal, in ms.
pub(crate) const SETTLE_MS: u64 = 300;

/// Where a run starts.
fn start_of(scenario: &Scenario, seed: u64) -> TruePose {
    let mut stream = Stream::new(seed, Purpose::Start);
    let start = &scenario.start;
    let (x, y) = stream.in_unit_disc();
    let offset = nalgebra::Vector2::new(x, y) * start.jitter_position_m;
    let heading = start.heading_rad + start.jitter_heading_rad * stream.symmetric();
    TruePose { position: start.position + offset, heading_rad: wrapped(heading) }
}

/// A mission under way.
pub(crate) struct Mission<'a, C> {
    scenario: &'a Scenario,
    /// The robot in its world.
    pub simulation: Simulation<'a, C>,
    checkpoints: Vec<Point2<f64>>,
    arrivals: Vec<Arrival>,
    /// Replacements that are still to come.
    pending: Vec<usize>,
    stopped: Option<StopCause>,
    samples: Vec<Sample>,
    turned_rad: f64,
}

/// Runs a scenario with a controller that has a trained map; `robot` gives the physical robot's numbers.
///
/// # Errors
/// If there is no plan, or the controller refuses its checkpoints or cannot be reached any more.
pub fn run<C: ControllerPort>(
    scenario: &Scenario,
    controller: C,
    robot: &Config,
    options: MissionOptions,
) -> Result<MissionResult, MissionError<C::Error>> {
    let world = scenario.world.of_run(options.seed);
    let mut mission = Mission::begin(scenario, &world, controller, robot, options.seed)?;
    let reached = mission.drive(options.sample_ms)?;
    Ok(mission.result(options.seed, reached))
}

impl<'a, C: ControllerPort> Mission<'a, C> {
    /// A robot at its start in the world of its run, ready to go.
    pub(crate) fn begin(
        scenario: &'a Scenario,
        world: &'a World,
        controller: C,
        robot: &Config,
        seed: u64,
    ) -> Result<Self, MissionError<C::Error>> {
        let start = start_of(scenario, seed);
        let checkpoints = match &scenario.route {
            Route::Checkpoints(checkpoints) => checkpoints.clone(),
            Route::Planned { .. } => route_planner::plan(scenario, start.position, 0.0)?.checkpoints,
        };
        let model = KheperaModel::new(&robot.robot, &robot.servo, scenario.noise.actuator);
        let mut simulation = Simulation::new(controller, world, model, &scenario.noise, start, seed);
        let points: Vec<_> = checkpoints.iter().copied().map(narrow_point).collect();
        simulation.controller.set_checkpoints(&points).map_err(MissionError::Port)??;
        simulation.controller.arm().map_err(MissionError::Port)?;
        simulation.controller.set_mode(Mode::Navigate, 0).map_err(MissionError::Port)?;
        Ok(Self {
            scenario,
            simulation,
            checkpoints,
            arrivals: Vec::new(),
            pending: (0..scenario.replacements.len()).collect(),
            stopped: None,
            samples: Vec::new(),
            turned_rad: 0.0,
        })
    }

    /// Drives until the goal or the time limit; whether the goal was reached.
    fn drive(&mut self, sample_ms: u64) -> Result<bool, MissionError<C::Error>> {
        let mut heading_rad = self.simulation.pose().heading_rad;
        while self.simulation.time_s() < self.scenario.time_limit_s {
            if self.simulation.tick().is_multiple_of(TURN_PERIOD_MS) {
                let before_rad = core::mem::replace(&mut heading_rad, self.simulation.pose().heading_rad);
                self.turned_rad += wrapped(heading_rad - before_rad).abs();
            }
            self.replace_checkpoints()?;
            let outputs = self.simulation.step().map_err(MissionError::Port)?;
            self.note(&outputs, sample_ms);
            let Some(reached) = outputs.reached else { continue };
            let t_s = self.simulation.time_s();
            if reached.is_goal {
                for _ in 0..SETTLE_MS {
                    self.simulation.step().map_err(MissionError::Port)?;
                }
            }
            self.arrive(reached, t_s);
            if reached.is_goal {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Keeps of a tick that has just been run what the result tells.
    pub(crate) fn note(&mut self, outputs: &Outputs<f32>, sample_ms: u64) {
        self.stopped = outputs.stopped.or(self.stopped);
        if sample_ms > 0 && (self.simulation.tick() - 1).is_multiple_of(sample_ms) {
            let checkpoint = u16::try_from(self.arrivals.len() + 1).unwrap_or(u16::MAX);
            self.samples.push(Sample::of(&self.simulation, outputs, checkpoint));
        }
    }

    /// A checkpoint was reached at `t_s`, and the robot is where its error is to be measured.
    pub(crate) fn arrive(&mut self, reached: Reached, t_s: f64) {
        let error_m = self.distance_to(usize::from(reached.number));
        self.arrivals.push(Arrival { checkpoint: reached.number + 1, t_s, error_m });
    }

    fn distance_to(&self, checkpoint: usize) -> f64 {
        let place = self.checkpoints.get(checkpoint);
        place.map_or(f64::INFINITY, |place| (self.simulation.pose().position - place).norm())
    }

    /// The planner replaces checkpoints under way (P1 Fig. 9).
    pub(crate) fn replace_checkpoints(&mut self) -> Result<(), MissionError<C::Error>> {
        if self.pending.is_empty() {
            return Ok(());
        }
        let now_s = self.simulation.time_s();
        let scenario = self.scenario;
        let arrivals = &self.arrivals;
        let due = |trigger: Trigger| match trigger {
            Trigger::At { t_s } => now_s >= t_s,
            Trigger::AfterCheckpoint { checkpoint, delay_s } => {
                arrivals.get(checkpoint).is_some_and(|arrival| now_s >= arrival.t_s + delay_s)
            }
        };
        let (ripe, pending): (Vec<_>, Vec<_>) =
            self.pending.iter().partition(|&&index| due(scenario.replacements[index].trigger));
        self.pending = pending;
        for index in ripe {
            let replacement = scenario.replacements[index];
            // One that is behind already has come too late: the plan's change no longer matters.
            if replacement.checkpoint >= self.arrivals.len() {
                let at = narrow_point(replacement.to);
                let order = Order::Checkpoint { number: replacement.checkpoint, at };
                self.simulation.controller.order(order).map_err(MissionError::Port)??;
                self.checkpoints[replacement.checkpoint] = replacement.to;
            }
        }
        Ok(())
    }

    /// What became of it.
    pub(crate) fn result(self, seed: u64, reached: bool) -> MissionResult {
        let contacts = self.simulation.contacts();
        let precise = self.arrivals.iter().all(|arrival| arrival.error_m < self.scenario.tolerance_m);
        MissionResult {
            seed,
            reached,
            success: reached && precise && contacts == 0,
            contacts,
            duration_s: self
                .arrivals
                .last()
                .filter(|_| reached)
                .map_or(self.simulation.time_s(), |last| last.t_s),
            way_m: self.simulation.way_m(),
            turned_rad: self.turned_rad,
            arrivals: self.arrivals,
            checkpoints: self.checkpoints.iter().map(|place| (place.x, place.y)).collect(),
            stopped: self.stopped,
            hash: self.simulation.hash(),
            samples: self.samples,
        }
    }
}
