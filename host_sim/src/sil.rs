//! The controller as the simulator meets it: a port that takes readings and gives drives.
//!
//! Everything that crosses the port is `f32` in SI units, as on the wire. [`Sil`] (software in the loop) runs the
//! core in this process; a board behind a serial link can stand in its place.

use controller_core::config::{Config, ConfigError, Parameters};
use controller_core::controller::{Controller, Inputs, Mode, Outputs};
use controller_core::kohonen::map::Map;
use controller_core::kohonen::output::{ControlMatrix, Output};
use controller_core::planning::checkpoint::CheckpointError;
use controller_core::scalar::Scalar;
use controller_core::schedule::{Schedule, Tick};
use controller_core::units::Point;

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
pub trait ControllerPort {
    /// One tick.
    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Outputs<f32>;

    /// When the controller reads what.
    fn schedule(&self) -> Schedule;

    /// Standby, learn or navigate.
    fn set_mode(&mut self, mode: Mode, now: Tick);

    /// Lets the motors run.
    fn arm(&mut self);

    /// Replaces all checkpoints.
    ///
    /// # Errors
    /// As [`controller_core::planning::checkpoint::Checkpoints::replace_all`].
    fn set_checkpoints(&mut self, checkpoints: &[Point<f32>]) -> Result<(), CheckpointError>;

    /// Replaces one checkpoint that is still ahead.
    ///
    /// # Errors
    /// As [`controller_core::planning::checkpoint::Checkpoints::replace`].
    fn replace_checkpoint(&mut self, number: usize, checkpoint: Point<f32>) -> Result<(), CheckpointError>;

    /// Hash over all commands and drives since start.
    fn hash(&self) -> u64;
}

/// The core in this process.
#[derive(Debug, Clone)]
pub struct Sil<S: Scalar, O: Output<S> = Indirect<S>> {
    /// Its configuration in its own scalar.
    pub parameters: Parameters<S, SENSORS>,
    /// The controller.
    pub controller: Controller<S, O, COLUMNS, ROWS, SENSORS>,
}

impl<S: Scalar, O: Output<S>> Sil<S, O> {
    /// A controller with an untrained map.
    ///
    /// # Errors
    /// If the configuration cannot be used.
    pub fn untrained(config: &Config) -> Result<Self, ConfigError> {
        Ok(Self { parameters: config.build()?, controller: Controller::default() })
    }

    /// A controller with a map that was trained for `steps` steps.
    ///
    /// # Errors
    /// If the configuration cannot be used.
    pub fn trained(config: &Config, map: HostMap<S, O>, steps: u32) -> Result<Self, ConfigError> {
        Ok(Self { parameters: config.build()?, controller: Controller::new(map, steps) })
    }
}

fn point_from<S: Scalar>(point: Point<f32>) -> Point<S> {
    Point::from_metres(point.x_m, point.y_m)
}

impl<S: Scalar, O: Output<S>> ControllerPort for Sil<S, O> {
    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Outputs<f32> {
        self.controller.step(&self.parameters, now, &inputs.converted()).to_f32()
    }

    fn schedule(&self) -> Schedule {
        self.parameters.reflex.schedule
    }

    fn set_mode(&mut self, mode: Mode, now: Tick) {
        self.controller.set_mode(mode, now);
    }

    fn arm(&mut self) {
        self.controller.arm();
    }

    fn set_checkpoints(&mut self, checkpoints: &[Point<f32>]) -> Result<(), CheckpointError> {
        let points: Vec<Point<S>> = checkpoints.iter().copied().map(point_from).collect();
        self.controller.checkpoints_mut().replace_all(&points)
    }

    fn replace_checkpoint(&mut self, number: usize, checkpoint: Point<f32>) -> Result<(), CheckpointError> {
        self.controller.checkpoints_mut().replace(number, point_from(checkpoint))
    }

    fn hash(&self) -> u64 {
        self.controller.hash().value()
    }
}
