//! Microseconds since some moment, for measuring: a reading costs a few instructions and needs nobody's permission.

#[cfg(board = "stm32f405")]
mod tim2 {
    #![expect(unsafe_code, reason = "the counter is read by every task")]

    use crate::board::pac;

    /// TIM2, 32 bits at 1 MHz.
    pub fn tim2() -> u32 {
        // SAFETY: the counter is only read, and after the start nobody writes to this timer.
        unsafe { pac::TIM2::steal() }.cnt().read().bits()
    }
}
#[cfg(board = "stm32f405")]
pub use tim2::tim2;

#[cfg(board = "stm32f100")]
mod systick {
    use core::sync::atomic::{AtomicU32, Ordering};

    use cortex_m::peripheral::{SCB, SYST};

    /// Milliseconds counted by the servo.
    static MILLISECONDS: AtomicU32 = AtomicU32::new(0);
    /// Clocks of a microsecond.
    static CLOCKS_PER_MICROSECOND: AtomicU32 = AtomicU32::new(1);

    /// `SysTick` must be set to a millisecond, and [`count`] called at each of its interrupts.
    pub fn start_by_systick(core_hz: u32) {
        CLOCKS_PER_MICROSECOND.store((core_hz / 1_000_000).max(1), Ordering::Relaxed);
    }

    /// A millisecond has passed.
    pub fn count() {
        // Only the interrupt of SysTick writes.
        MILLISECONDS.store(MILLISECONDS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
    }

    /// Milliseconds from the interrupts, the rest from the counter.
    pub fn by_systick() -> u32 {
        let clocks = CLOCKS_PER_MICROSECOND.load(Ordering::Relaxed).max(1);
        let read = || {
            let passed = SYST::get_reload().saturating_sub(SYST::get_current()) / clocks;
            (MILLISECONDS.load(Ordering::Relaxed), passed, SCB::is_pendst_pending())
        };
        let (before, mut passed, pending) = read();
        let mut milliseconds = before;
        if pending {
            // The counter has begun anew, and the interrupt has not been served yet: what was read may be of either
            // round, so read again, now surely of the new one.
            (milliseconds, passed, _) = read();
            if milliseconds == before {
                milliseconds = milliseconds.wrapping_add(1);
            }
        }
        milliseconds.wrapping_mul(1000).wrapping_add(passed)
    }
}
#[cfg(board = "stm32f100")]
pub use systick::{by_systick, count, start_by_systick};

/// A millisecond has passed; this stopwatch counts by itself.
#[cfg(board = "stm32f405")]
pub fn count() {}
