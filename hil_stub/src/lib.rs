//! A board without a board: the controller core behind the link, on the host, with no physics.
//!
//! As far as the link can tell, a [`board::Stub`] is a board: it runs the board's own end of the protocol
//! ([`protocol::endpoint`]) behind real frames. It takes bytes and the time and gives bytes, so that it serves equally
//! as a process behind a pseudo-terminal ([`serve`]) and inside a simulator's own process. What a bad line does to
//! frames is in [`faults`], drawn from a seed and so the same in every run.
#![forbid(unsafe_code)]

pub mod faults;

pub mod board;

#[cfg(unix)]
pub mod serve;
