//! The controller as the boards run it: its shape, its size, and one call per tick.
//!
//! The shape is named once here. Sizes are held at compile time, on the target, where `usize` has four bytes; the
//! host's are held by `tests` (`memory`). A build that fails here says that the controller grew: if it was meant to,
//! raise the ratchet in a commit that says what the bytes are for.

use controller_core::config::Parameters;
use controller_core::controller::{Controller, Inputs, Outputs};
use controller_core::kohonen::output::ControlMatrix;
use controller_core::scalar::Scalar;
use controller_core::schedule::Tick;

/// Sensors of the ring.
pub const SENSORS: usize = 12;

/// The controller with its 15 × 15 neurons.
pub type RobotController<S> = Controller<S, ControlMatrix<<S as Scalar>::Weight>, 15, 15, SENSORS>;

/// Its numbers.
pub type RobotParameters<S> = Parameters<S, SENSORS>;

/// Bytes of RAM for controller and parameters, learning included.
pub const fn ram_bytes<S: Scalar>() -> usize {
    size_of::<RobotController<S>>() + size_of::<RobotParameters<S>>()
}

macro_rules! one_tick {
    ($(#[$doc:meta])* $name:ident: $real:ty) => {
        $(#[$doc])*
        pub fn $name(
            controller: &mut RobotController<$real>,
            parameters: &RobotParameters<$real>,
            now: Tick,
            inputs: &Inputs<$real, SENSORS>,
        ) -> Outputs<$real> {
            controller.step(parameters, now, inputs)
        }
    };
}

// Not generic, so that building this crate compiles the whole controller for the target.
one_tick! {
    /// One tick of the STM32F405's controller.
    step_stm32f405: crate::board::stm32f405::Real
}
one_tick! {
    /// One tick of the STM32F100's controller.
    step_stm32f100: crate::board::stm32f100::Real
}

const _: () = {
    use crate::board::{stm32f100, stm32f405};
    // Promises to users.
    assert!(ram_bytes::<stm32f405::Real>() <= 12 * 1024);
    assert!(ram_bytes::<stm32f100::Real>() <= 6 * 1024);
    // Ratchets, a little above the present sizes.
    assert!(ram_bytes::<stm32f405::Real>() <= 7930);
    assert!(ram_bytes::<stm32f100::Real>() <= 4780);
};
