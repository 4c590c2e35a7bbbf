//! The log: [`defmt`] frames to a debug probe on silicon ([`crate::rtt`]), to the host's file or console in an
//! emulator.
//!
//! A line is written with interrupts off, since any task may log; so lines are few and short, and none is written in
//! the 1 ms task while nothing is amiss.
#![expect(unsafe_code, reason = "defmt's logger is an unsafe trait")]

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicI32, Ordering};

use critical_section::RestoreState;
use semihosting::fd::{BorrowedFd, OwnedFd};

use crate::board::{Board, This};
use crate::rtt;

/// Where lines go in an emulator; -1 for RTT.
static FILE: AtomicI32 = AtomicI32::new(-1);

/// Lines go to this file of the host from now on.
pub fn to_file(file: OwnedFd) {
    // It stays open for good.
    FILE.store(file.into_raw_fd(), Ordering::Relaxed);
}

/// Lines go to a file of the host: this is an emulator.
#[must_use]
pub fn is_to_file() -> bool {
    FILE.load(Ordering::Relaxed) != -1
}

/// What is touched between `acquire` and `release` alone.
struct Guarded {
    encoder: UnsafeCell<defmt::Encoder>,
    /// How interrupts stood before the line.
    interrupts: UnsafeCell<RestoreState>,
}

// SAFETY: both cells are touched between `acquire` and `release` alone, and there interrupts are off, on the one core.
unsafe impl Sync for Guarded {}

static GUARDED: Guarded = Guarded {
    encoder: UnsafeCell::new(defmt::Encoder::new()),
    interrupts: UnsafeCell::new(RestoreState::invalid()),
};

defmt::timestamp!("{=u32:us}", This::micros());

#[defmt::global_logger]
struct Logger;

// SAFETY: `acquire` turns interrupts off and `release` restores them, so one execution context holds the logger at a
// time. Nothing that this crate logs does so while it is being formatted, so it is not acquired twice.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: `release` restores, as defmt promises to call it once for each `acquire`.
        let interrupts = unsafe { critical_section::acquire() };
        // SAFETY: interrupts are off.
        unsafe { *GUARDED.interrupts.get() = interrupts };
        // SAFETY: likewise.
        unsafe { &mut *GUARDED.encoder.get() }.start_frame(put);
    }

    unsafe fn flush() {}

    unsafe fn release() {
        // SAFETY: between `acquire` and here interrupts are off.
        unsafe { &mut *GUARDED.encoder.get() }.end_frame(put);
        // SAFETY: likewise, and the state is that of the `acquire` before.
        unsafe { critical_section::release(*GUARDED.interrupts.get()) };
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: between `acquire` and `release` interrupts are off.
        unsafe { &mut *GUARDED.encoder.get() }.write(bytes, put);
    }
}

fn put(bytes: &[u8]) {
    match FILE.load(Ordering::Relaxed) {
        -1 => rtt::write(bytes),
        file => {
            // SAFETY: not -1, and never closed.
            let file = unsafe { BorrowedFd::borrow_raw(file) };
            // A log that cannot be written is no reason to stop.
            let _ = semihosting::sys::write(file, bytes);
        }
    }
}
