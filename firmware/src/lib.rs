//! The robot's firmware: [`controller_core`] on a microcontroller.
//!
//! # What is here
//!
//! * [`board`]: the two boards, with the number type their controller computes with, their memory and their clock
//! * [`controller`]: the controller as they run it; building this crate compiles it for the target and checks its size
//!
//! # What is not here yet
//!
//! Tasks, drivers, the link and an image to flash. This crate compiles for both boards and does nothing on them.
//! Where it is going stands in `ARCHITECTURE.md`.
#![no_std]
#![forbid(unsafe_code)]

pub mod board;

pub mod controller;
