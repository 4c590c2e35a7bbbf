//! From the wire to the core's types and back.

use controller_core::controller;
use controller_core::kohonen::lattice::NeuronIndex;
use controller_core::kohonen::map::{Map, Neuron};
use controller_core::kohonen::output::ControlMatrix;
use controller_core::scalar::Scalar;
use controller_core::schedule::Tick;
use controller_core::sensing::proximity;

use crate::map_file::NeuronRecord;
use crate::message::{Outputs, Readings, SENSORS, Scan};

impl Readings {
    /// What the core takes in at a tick.
    #[must_use]
    pub fn to_inputs(&self) -> controller::Inputs<f32, SENSORS> {
        controller::Inputs {
            encoders: self.encoders,
            pose_fix: self.pose_fix,
            scan: self.scan.map(|scan| proximity::Scan { range_m: scan.ranges_m }),
            exploration: self.exploration.unwrap_or_default(),
        }
    }

    /// The core's inputs of a tick as they are sent. Draws that are both 0, as at all ticks that need none, are left
    /// out.
    #[must_use]
    pub fn from_inputs(tick: Tick, inputs: &controller::Inputs<f32, SENSORS>) -> Self {
        let is_drawn = inputs.exploration.iter().any(|draw| draw.to_bits() != 0);
        Self {
            tick,
            encoders: inputs.encoders,
            pose_fix: inputs.pose_fix,
            scan: inputs.scan.map(|scan| Scan { ranges_m: scan.range_m }),
            exploration: is_drawn.then_some(inputs.exploration),
        }
    }
}

impl Outputs {
    /// What the core gave out at a tick, with the controller's digest after it.
    #[must_use]
    pub fn from_core<S: Scalar>(tick: Tick, outputs: &controller::Outputs<S>, state_digest: u64) -> Self {
        let outputs = outputs.to_f32();
        Self {
            tick,
            wheel_drive: outputs.drive,
            wheel_speed_command: outputs.command.value,
            commanded_at_tick: outputs.command.renewed,
            reached: outputs.reached,
            stopped: outputs.stopped,
            state_digest,
        }
    }
}

/// The index of neuron number `number`, counted column by column; `None` beyond the last.
#[must_use]
pub fn neuron_index<const COLUMNS: usize, const ROWS: usize>(number: usize) -> Option<NeuronIndex> {
    let (column, row) = (number / ROWS, number % ROWS);
    (column < COLUMNS).then(|| NeuronIndex::new(column, row))
}

impl NeuronRecord {
    /// A neuron as it is sent and stored.
    #[must_use]
    pub fn of<S: Scalar, const COLUMNS: usize, const ROWS: usize>(
        map: &Map<S, ControlMatrix<S::Weight>, COLUMNS, ROWS>,
        index: NeuronIndex,
    ) -> Self {
        let read = |weight| S::from_weight(weight).to_f32();
        let neuron = map.neuron(index);
        Self {
            bearing_rad: read(neuron.bearing),
            distance_per_reach: read(neuron.distance),
            left: neuron.output.left.map(read),
            right: neuron.output.right.map(read),
            has_won: map.has_won(index),
        }
    }

    /// Puts it into a map.
    pub fn put<S: Scalar, const COLUMNS: usize, const ROWS: usize>(
        &self,
        map: &mut Map<S, ControlMatrix<S::Weight>, COLUMNS, ROWS>,
        index: NeuronIndex,
    ) {
        let write = |value| S::from_f32(value).to_weight();
        let output = ControlMatrix { left: self.left.map(write), right: self.right.map(write) };
        let neuron =
            Neuron { bearing: write(self.bearing_rad), distance: write(self.distance_per_reach), output };
        map.set_neuron(index, neuron, self.has_won);
    }
}
