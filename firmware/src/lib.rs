//! The robot's firmware: [`controller_core`] on a microcontroller.
//!
//! * [`board`]: the two boards, chosen by the target: number type, memory, clocks, pins
//! * [`drivers`]: USART, motors, stopwatch, watchdog
//! * [`controller`]: the controller as the boards run it, and the RAM it may take
//! * [`flash_map`]: the learned map that the image may have been built with
//! * [`watch`]: what the tasks were released for, how long they took, what they missed
//! * [`slot`]: a mailbox between two tasks
//! * [`log`]: where log lines go: by [`rtt`] to a debug probe, or by [`emulator`] to the host
//!
//! The application, with its tasks, is `main.rs`.
#![no_std]

pub mod board;

pub mod drivers;

pub mod controller;

pub mod flash_map;

pub mod watch;

pub mod slot;

pub mod log;

pub mod rtt;

pub mod emulator;
