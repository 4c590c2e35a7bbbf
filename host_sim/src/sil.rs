//! The controller as the simulator meets it: a port that takes readings and gives drives.
//!
//! Everything that crosses the port is `f32` in SI units, as on the wire. [`Sil`] (software in the loop) runs the
//! core in this process; a board behind a serial link ([`crate::link::port`]) can stand in its place.

use core::convert::Infallible;

use controller_core::config::{Config, ConfigError, Parameters};
use controller_core::controller::{Controller, Inputs, Mode, Outputs};
use controller_core::kohonen::map::Map;
use controller_core::kohonen::output::{ControlMatrix, Output};
use controller_core::localisation::separation::{
    OTHERS, Others, Report, SeparationConfig, SeparationParameters,
};
use controller_core::planning::checkpoint::CheckpointError;
use controller_core::reflex::Latched;
use controller_core::scalar::Scalar;
use controller_core::schedule::{Schedule, Tick};
use controller_core::sensing::proximity::Scan;
use controller_core::units::Point;

use crate::lateness::Finished;
use crate::proximity_model::SENSORS;

/// Columns of the map, along the bearing.
pub const COLUMNS: usize = 15;
/// Rows of the map, along the distance.
pub const ROWS: usize = 15;

/// The map in a scalar and with an output layer.
pub type HostMap<S, O> = Map<S, O, COLUMNS, ROWS>;
/// The output layer of the architecture: indirect mapping.
pub type Indirect<S> = ControlMatrix<<S as Scalar>::Weight>;

/// A controller that the simulator can drive.
///
/// # Errors
/// All methods that return [`ControllerPort::Error`] do so where the controller cannot be reached any more; the run
/// then has no meaning and ends.
#[allow(clippy::missing_errors_doc, reason = "said once, for all methods")]
pub trait ControllerPort {
    /// What can be wrong with the way to the controller; in this process, nothing.
    type Error: core::error::Error;

    /// One tick.
    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Result<Outputs<f32>, Self::Error>;

    /// One tick in which only these tasks have their answers, to what was latched at their last release.
    ///
    /// A controller elsewhere has tasks of its own, which nobody can make late from here: it takes an ordinary step.
    fn step_late(
        &mut self,
        now: Tick,
        inputs: &Inputs<f32, SENSORS>,
        finished: Finished,
    ) -> Result<Outputs<f32>, Self::Error> {
        let _ = finished;
        self.step(now, inputs)
    }

    /// When the controller reads what.
    fn schedule(&self) -> Schedule;

    /// Tells the controller what it is to do.
    fn order(&mut self, order: Order<'_>) -> Result<Answer, Self::Error>;

    /// Hash over all commands and drives since start.
    fn hash(&self) -> u64;

    /// Standby, learn or navigate.
    fn set_mode(&mut self, mode: Mode, now: Tick) -> Result<(), Self::Error> {
        self.order(Order::Mode { mode, now }).map(drop)
    }

    /// Lets the motors run.
    fn arm(&mut self) -> Result<(), Self::Error> {
        self.order(Order::Arm).map(drop)
    }

    /// Replaces all checkpoints.
    fn set_checkpoints(&mut self, checkpoints: &[Point<f32>]) -> Result<Answer, Self::Error> {
        self.order(Order::Checkpoints(checkpoints))
    }
}

/// What a controller can be told to do between two ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order<'a> {
    /// Stand by, learn or navigate, from this tick on.
    Mode {
        /// Which of them.
        mode: Mode,
        /// The present tick.
        now: Tick,
    },
    /// Let the motors run.
    Arm,
    /// Replace all checkpoints, as [`controller_core::planning::checkpoint::Checkpoints::replace_all`].
    Checkpoints(&'a [Point<f32>]),
    /// Add some behind the last, as [`controller_core::planning::checkpoint::Checkpoints::append`]: a long route goes
    /// to the controller in parts.
    Append(&'a [Point<f32>]),
    /// Replace one that is still ahead, as [`controller_core::planning::checkpoint::Checkpoints::replace`].
    Checkpoint {
        /// Which, counted from the first that was ever set.
        number: usize,
        /// Where it is to be.
        at: Point<f32>,
    },
}

/// What a controller says to an order. Only changes of checkpoints can be refused; then nothing has changed.
pub type Answer = Result<(), CheckpointError>;

impl<C: ControllerPort> ControllerPort for &mut C {
    type Error = C::Error;

    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Result<Outputs<f32>, C::Error> {
        (**self).step(now, inputs)
    }

    fn step_late(
        &mut self,
        now: Tick,
        inputs: &Inputs<f32, SENSORS>,
        finished: Finished,
    ) -> Result<Outputs<f32>, C::Error> {
        (**self).step_late(now, inputs, finished)
    }

    fn schedule(&self) -> Schedule {
        (**self).schedule()
    }

    fn order(&mut self, order: Order<'_>) -> Result<Answer, C::Error> {
        (**self).order(order)
    }

    fn hash(&self) -> u64 {
        (**self).hash()
    }
}

/// The core in this process.
#[derive(Debug, Clone)]
pub struct Sil<S: Scalar, O: Output<S> = Indirect<S>> {
    /// Its configuration in its own scalar.
    pub parameters: Parameters<S, SENSORS>,
    /// The controller.
    pub controller: Controller<S, O, COLUMNS, ROWS, SENSORS>,
    /// Other robots that it has been told of; nobody where there is one alone.
    pub others: Others<S, OTHERS>,
    /// What tasks that run late have yet to work on.
    pending: Pending<S>,
}

/// What was latched for tasks that are not ready.
#[derive(Debug, Clone)]
struct Pending<S> {
    avoidance: Option<(Latched<S>, Option<Scan<S, SENSORS>>)>,
    target: Option<Latched<S>>,
}

impl<S> Default for Pending<S> {
    fn default() -> Self {
        Self { avoidance: None, target: None }
    }
}

impl<S: Scalar, O: Output<S>> Sil<S, O> {
    fn with(
        config: &Config,
        controller: Controller<S, O, COLUMNS, ROWS, SENSORS>,
    ) -> Result<Self, ConfigError> {
        let separation = SeparationParameters::new(&SeparationConfig::default(), config);
        let others = Others::new(separation);
        Ok(Self { parameters: config.build()?, controller, others, pending: Pending::default() })
    }

    /// Takes over what another robot tells of itself; command fusion has no use for it.
    pub fn hear(&mut self, now: Tick, report: &Report<S>) {
        self.others.forget(now);
        self.others.hear(self.controller.pose(&self.parameters).position(), now, report);
    }

    /// A controller with an untrained map.
    ///
    /// # Errors
    /// If the configuration cannot be used.
    pub fn untrained(config: &Config) -> Result<Self, ConfigError> {
        Self::with(config, Controller::default())
    }

    /// A controller with a map that was trained for `steps` steps.
    ///
    /// # Errors
    /// If the configuration cannot be used.
    pub fn trained(config: &Config, map: HostMap<S, O>, steps: u32) -> Result<Self, ConfigError> {
        Self::with(config, Controller::new(map, steps))
    }
}

impl<S: Scalar, O: Output<S>> Sil<S, O> {
    /// The core's tick, with the slow tasks' answers as late as on a board that is busy: the fast half latches
    /// what they
    /// are to work on when they are released, and takes their command when they have it. Training is never late.
    fn tick_late(&mut self, now: Tick, inputs: &Inputs<S, SENSORS>, finished: Finished) -> Outputs<S> {
        if self.controller.reflex.mode() != Mode::Navigate {
            return self.controller.step(&self.parameters, now, inputs);
        }
        self.others.forget(now);
        let p = &self.parameters;
        let Controller { reflex, deliberation } = &mut self.controller;
        let released = p.reflex.schedule.at(now);
        if let Some(pose) = inputs.pose_fix {
            reflex.fix_pose(pose);
        }
        if inputs.scan.is_some() {
            reflex.note_scan(now);
        }
        reflex.supervision.untrained = !deliberation.map().is_trained();
        let (drive, stopped) = reflex.tick(&p.reflex, now, inputs.encoders);
        let reached = reflex.arrive(&p.reflex, now);
        if released.avoidance {
            self.pending.avoidance = Some((reflex.latch(&p.reflex, now), inputs.scan));
        }
        if released.target {
            self.pending.target = Some(reflex.latch(&p.reflex, now));
        }
        let mut answered = None;
        if let Some((latched, scan)) = self.pending.avoidance.take_if(|_| finished.avoidance) {
            if let Some(scan) = scan {
                deliberation.take_scan(scan);
            }
            deliberation.avoid_among(p, &latched, &self.others);
            answered = Some(latched);
        }
        if let Some(latched) = self.pending.target.take_if(|_| finished.target) {
            deliberation.reach_among(p, &latched, &self.others);
            // Both at once: the younger moment.
            answered = Some(answered.filter(|other| other.now > latched.now).unwrap_or(latched));
        }
        if let Some(latched) = answered {
            let speeds = deliberation.integrate(p, &latched);
            reflex.take_command(latched.now, speeds);
        }
        Outputs { drive, command: reflex.command(), reached, stopped, released }
    }
}

fn points_from<S: Scalar>(points: &[Point<f32>]) -> Vec<Point<S>> {
    points.iter().copied().map(point_from).collect()
}

fn point_from<S: Scalar>(point: Point<f32>) -> Point<S> {
    Point::from_metres(point.x_m, point.y_m)
}

impl<S: Scalar, O: Output<S>> ControllerPort for Sil<S, O> {
    type Error = Infallible;

    // So that inputs and outputs need not be built in memory.
    #[inline(always)]
    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Result<Outputs<f32>, Infallible> {
        let inputs = inputs.converted();
        let outputs = if self.others.is_empty() {
            self.controller.step(&self.parameters, now, &inputs)
        } else {
            self.others.forget(now);
            self.controller.step_among(&self.parameters, now, &inputs, &self.others)
        };
        Ok(outputs.to_f32())
    }

    fn step_late(
        &mut self,
        now: Tick,
        inputs: &Inputs<f32, SENSORS>,
        finished: Finished,
    ) -> Result<Outputs<f32>, Infallible> {
        Ok(self.tick_late(now, &inputs.converted(), finished).to_f32())
    }

    fn schedule(&self) -> Schedule {
        self.parameters.reflex.schedule
    }

    fn order(&mut self, order: Order<'_>) -> Result<Answer, Infallible> {
        match order {
            Order::Mode { mode, now } => {
                self.controller.set_mode(mode, now);
                self.pending = Pending::default();
            }
            Order::Arm => self.controller.arm(),
            Order::Checkpoints(checkpoints) => {
                return Ok(self.controller.checkpoints_mut().replace_all(&points_from(checkpoints)));
            }
            Order::Append(checkpoints) => {
                return Ok(self.controller.checkpoints_mut().append(&points_from(checkpoints)));
            }
            Order::Checkpoint { number, at } => {
                return Ok(self.controller.checkpoints_mut().replace(number, point_from(at)));
            }
        }
        Ok(Ok(()))
    }

    fn hash(&self) -> u64 {
        self.controller.hash().value()
    }
}
