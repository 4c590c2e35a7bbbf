//! Drivers of what both chips have in the same form.
//!
//! Registers are reached without owning the peripheral where two tasks share it; each such place says why that is
//! sound. Nothing here waits without a bound.

pub mod usart;

pub mod motors;

pub mod stopwatch;

pub mod watchdog;

pub mod stack;
