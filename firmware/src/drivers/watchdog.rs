//! The independent watchdog: resets the chip when it has not been fed for [`crate::board::WATCHDOG_MS`].
#![expect(unsafe_code, reason = "prescaler and count are plain numbers to the register crates")]

use crate::board::{Board, This, pac};

/// The watchdog, asleep until [`Watchdog::start`]; from then on nothing but a reset ends it.
pub struct Watchdog {
    registers: pac::IWDG,
    runs: bool,
}

impl Watchdog {
    /// Takes the watchdog over and lets it sleep.
    #[must_use]
    pub fn new(registers: pac::IWDG) -> Self {
        Self { registers, runs: false }
    }

    /// Starts it, once. It runs on while a debugger holds the core.
    pub fn start(&mut self) {
        if self.runs {
            return;
        }
        self.runs = true;
        let (prescaler, count) = This::WATCHDOG;
        let registers = &self.registers;
        // Starting first: only then does the watchdog have the clock to take the numbers over.
        registers.kr().write(|w| w.key().start());
        registers.kr().write(|w| w.key().unlock());
        // SAFETY: prescaler and count were asserted to be within their fields.
        registers.pr().write(|w| unsafe { w.bits(prescaler.into()) });
        // SAFETY: likewise.
        registers.rlr().write(|w| unsafe { w.bits(count) });
        self.feed();
    }

    /// Feeds it; nothing if it sleeps.
    pub fn feed(&mut self) {
        if self.runs {
            self.registers.kr().write(|w| w.key().feed());
        }
    }
}
