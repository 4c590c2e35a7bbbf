//! The other end of the link: the simulator as the host of a board, an emulated one, or one that this process plays.
//!
//! ```text
//! Simulation ──► port (lockstep, real time, verified) ──► client ──► transport ──► board
//!                ControllerPort                           requests,   bytes
//!                                                         answers
//! ```
//!
//! * [`address`]: what the user types, and what it opens
//! * [`transport`]: bytes with a time limit; [`serial`], [`tcp`], [`stub`] and `qemu` are some
//! * [`client`]: one request, one answer; what is lost is asked for again, and what goes wrong has a name
//! * [`session`]: hello, parameters, map: a board is made ready for a run
//! * [`port`]: a board in lockstep as a [`crate::sil::ControllerPort`]
//! * [`verify`]: the same with the core in this process beside it, compared after every tick
//! * [`real_time`]: a board that runs on its own clock, with the simulator keeping up

pub mod address;

pub mod transport;

pub mod serial;

pub mod tcp;

pub mod stub;

#[cfg(unix)]
pub mod qemu;

mod error;

pub mod client;

pub mod session;

pub mod port;

pub mod verify;

pub mod real_time;

pub use error::LinkError;
