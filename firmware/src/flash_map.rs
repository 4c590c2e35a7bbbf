//! The map that the image was built with: a table in flash, loaded at the start, so that the robot finds its way
//! without a host that has one.
//!
//! `build.rs` makes the table of the file that `EKM_NAV_MAP` names (`cargo xtask firmware BOARD --map FILE` sets it)
//! and refuses what does not fit. Without one the table is `None` and nothing of this is in the image. Learning goes on
//! in RAM from where the file ends; a restart begins with the file again.

use controller_core::kohonen::lattice::NeuronIndex;
use controller_core::kohonen::map::Neuron;
use controller_core::kohonen::output::ControlMatrix;
use controller_core::scalar::Scalar;
use protocol::endpoint::BoardDeliberation;
use protocol::message::{COLUMNS, ROWS};

use crate::board::Real;

type Weight = <Real as Scalar>::Weight;

/// A neuron as this board's RAM holds it.
pub type MapNeuron = Neuron<Weight, ControlMatrix<Weight>>;

/// A learned map in this board's own weights: nothing is converted, and loading takes no stack.
pub struct FlashMap {
    /// Training steps it has seen: where the schedules of learning stand.
    pub trained_steps: u32,
    /// For each column one bit per row: the neuron has won in training.
    pub won: [u32; COLUMNS],
    /// Column by column.
    pub neurons: [[MapNeuron; ROWS]; COLUMNS],
}

include!(concat!(env!("OUT_DIR"), "/flash_map.rs"));

impl FlashMap {
    /// Loads it, neuron by neuron.
    pub fn put(&self, deliberation: &mut BoardDeliberation<Real>) {
        let (map, trained_steps) = deliberation.map_mut();
        for (column, (neurons, won)) in self.neurons.iter().zip(&self.won).enumerate() {
            for (row, neuron) in neurons.iter().enumerate() {
                map.set_neuron(NeuronIndex::new(column, row), *neuron, won >> row & 1 == 1);
            }
        }
        *trained_steps = self.trained_steps;
        defmt::info!("a map of {=u32} training steps from flash", self.trained_steps);
    }
}
