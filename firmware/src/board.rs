//! The boards: what differs between them, and nothing else.
//!
//! | | [`stm32f405`] | [`stm32f100`] |
//! | --- | --- | --- |
//! | core | Cortex-M4F | Cortex-M3, no FPU |
//! | `Real` | `f32` | [`Fixed`](controller_core::scalar::Fixed) |
//! | target | `thumbv7em-none-eabihf` | `thumbv7m-none-eabi` |
//!
//! `Real` is named here and nowhere else; everything above is generic over it.

use controller_core::scalar::Scalar;

pub mod stm32f405;

pub mod stm32f100;

/// What a board offers, for the boot log and for budgets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub struct Board {
    /// The name users type and read.
    pub name: &'static str,
    /// The name of its number type.
    pub scalar: &'static str,
    /// Flash for the image.
    pub flash_bytes: u32,
    /// RAM for data and stack.
    pub ram_bytes: u32,
    /// Clock of the core.
    pub core_hz: u32,
}

/// The name of a board's number type; does not compile for what is none.
const fn scalar_name<S: Scalar>() -> &'static str {
    S::NAME
}
