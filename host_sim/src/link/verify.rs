//! Two controllers on the same inputs, compared after every tick: a board, and the core in this process.

use controller_core::controller::{Inputs, Outputs};
use controller_core::schedule::{Schedule, Tick};

use crate::proximity_model::SENSORS;
use crate::sil::{Answer, ControllerPort, Order};

/// Drives the simulation with the first; fails at the first tick after which the two differ.
#[derive(Debug, Clone)]
pub struct Verified<A, B> {
    /// The controller that is tested, and whose outputs are used.
    pub tested: A,
    /// The one that it must agree with.
    pub reference: B,
}

/// The reference cannot fail: it runs in this process.
#[derive(Debug, thiserror::Error)]
pub enum VerifyError<E: core::error::Error> {
    /// The way to the tested controller.
    #[error("{0}")]
    Port(E),
    /// The two have decided otherwise.
    #[error(
        "the board differs from the core in this process after tick {tick}: state digest {tested:016x} instead of \
         {reference:016x}; if both are built from the same commit, report this with scenario and seed"
    )]
    Differs {
        /// The first tick after which.
        tick: Tick,
        /// Digest of the tested controller.
        tested: u64,
        /// Digest of the reference.
        reference: u64,
    },
    /// They answer a change of checkpoints otherwise.
    #[error(
        "the board answers a change of checkpoints with `{tested:?}`, the core in this process with `{reference:?}`"
    )]
    Answers {
        /// The tested controller.
        tested: Answer,
        /// The reference.
        reference: Answer,
    },
}

impl<A: ControllerPort, B: ControllerPort<Error = core::convert::Infallible>> ControllerPort
    for Verified<A, B>
{
    type Error = VerifyError<A::Error>;

    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Result<Outputs<f32>, Self::Error> {
        let outputs = self.tested.step(now, inputs).map_err(VerifyError::Port)?;
        let Ok(_) = self.reference.step(now, inputs);
        let (tested, reference) = (self.tested.hash(), self.reference.hash());
        if tested == reference {
            Ok(outputs)
        } else {
            Err(VerifyError::Differs { tick: now, tested, reference })
        }
    }

    fn schedule(&self) -> Schedule {
        self.reference.schedule()
    }

    fn order(&mut self, order: Order<'_>) -> Result<Answer, Self::Error> {
        let Ok(reference) = self.reference.order(order);
        let tested = self.tested.order(order).map_err(VerifyError::Port)?;
        if tested == reference { Ok(tested) } else { Err(VerifyError::Answers { tested, reference }) }
    }

    fn hash(&self) -> u64 {
        self.tested.hash()
    }
}
