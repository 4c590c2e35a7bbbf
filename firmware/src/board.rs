//! The boards: what differs between them, and nothing else.
//!
//! | | `stm32f405` | `stm32f100` |
//! | --- | --- | --- |
//! | core | Cortex-M4F | Cortex-M3, no FPU |
//! | [`Real`] | `f32` | [`Fixed`](controller_core::scalar::Fixed) |
//! | target | `thumbv7em-none-eabihf` | `thumbv7m-none-eabi` |
//! | QEMU machine | `netduinoplus2` | `stm32vldiscovery` |
//!
//! The target chooses the board, [`This`]; everything above is written against the trait [`Board`]. All numbers of the
//! hardware stand in the board's file. USART, timers and watchdog of the two chips have the same registers, so that
//! [`crate::drivers`] serve both.
//!
//! # Pins, the same on both boards
//!
//! | pin | function |
//! | --- | --- |
//! | PA9, PA10 | link: USART1 transmit, receive |
//! | PA6, PA7 | pulse width of the left and right motor: TIM3 channels 1 and 2 |
//! | PB13, PB14 | direction of the left and right motor: low is forward |
//! | PB12 | motor driver enabled while high; pull it down on the board, so that motors rest during reset |

use controller_core::scalar::Scalar;
use controller_core::schedule::Tick;

#[cfg(board = "stm32f405")]
pub mod stm32f405;
#[cfg(board = "stm32f405")]
pub use stm32f4::stm32f405 as pac;
#[cfg(board = "stm32f405")]
pub use stm32f405::Stm32f405 as This;

#[cfg(board = "stm32f100")]
pub mod stm32f100;
#[cfg(board = "stm32f100")]
pub use stm32f1::stm32f100 as pac;
#[cfg(board = "stm32f100")]
pub use stm32f100::Stm32f100 as This;

/// The number type of this board's controller.
pub type Real = <This as Board>::Real;

/// How often a flag of the clocks is looked at before it is given up: more than the slowest crystal needs, 2 ms of
/// the fastest loop at 16 MHz, and soon over in an emulator without clocks.
pub const CLOCK_POLLS: u32 = 100_000;

/// Frequency of the motors' pulses: above hearing, and slow enough for common motor drivers.
pub const PULSE_HZ: u32 = 20_000;

/// The watchdog's patience at the nominal rate of its clock, which may be off by half: longer than any task's period
/// in the cooperative architecture, shorter than a robot at full speed needs for a tenth of a metre.
pub const WATCHDOG_MS: u32 = 500;

/// Where the clock of the core comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub enum ClockSource {
    /// The crystal, multiplied.
    Crystal,
    /// The chip's own oscillator, multiplied, since the crystal does not start: within 1 %, good enough for the link.
    Internal,
    /// The chip's own oscillator as it is, since nothing can be multiplied: too slow for real time.
    Slow,
    /// An emulator: there are no clocks to set.
    Emulated,
}

/// The clocks as they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub struct Clocks {
    /// Where they come from.
    pub source: ClockSource,
    /// Clock of the core and of `SysTick`.
    pub core_hz: u32,
    /// Clock of USART1.
    pub usart_hz: u32,
    /// Clock of the timers TIM2 and TIM3.
    pub timer_hz: u32,
}

impl Clocks {
    /// The image runs in an emulator. Silicon never reads `RCC_CR` as 0: the internal oscillator runs after reset.
    #[must_use]
    pub fn is_emulated(&self) -> bool {
        self.source == ClockSource::Emulated
    }
}

/// What the firmware asks of a board.
pub trait Board {
    /// The number type of its controller.
    type Real: Scalar;

    /// What it calls itself on the link.
    const ID: protocol::message::Board;

    /// Flash for the image.
    const FLASH_BYTES: u32;

    /// RAM for data and stack.
    const RAM_BYTES: u32;

    /// Clocks with the crystal.
    const CLOCKS: Clocks;

    /// Bits per second of the link: 10 for a byte.
    const BAUD: u32;

    /// In real time the host is told what the servo does every so many milliseconds, and answers with readings: as
    /// often as the core has time for both.
    const REPORT_MS: Tick;

    /// Prescaler (`IWDG_PR`) and count of the independent watchdog for [`WATCHDOG_MS`].
    const WATCHDOG: (u8, u16);

    /// Sets the clocks, with bounded waits, and lets them reach the peripherals in use.
    fn start_clocks(peripherals: &pac::Peripherals) -> Clocks;

    /// Connects the pins. Motors stay without power.
    fn route_pins(peripherals: &pac::Peripherals);

    /// Starts the free-running stopwatch.
    fn start_stopwatch(peripherals: &pac::Peripherals, clocks: &Clocks);

    /// Microseconds since some moment, wrapping after 71 minutes; from any task.
    fn micros() -> u32;
}

/// Looks at a flag until it is set, [`CLOCK_POLLS`] times at most.
fn wait_until(is_set: impl Fn() -> bool) -> bool {
    (0..CLOCK_POLLS).any(|_| is_set())
}
