//! Integration: several modules' wishes become one motor command.
//!
//! * [`neural`]: cooperative EKMs, target and obstacle fields added over the motor control EKM (P2 Eq. 8–10)
//! * [`sweep`]: the body's way along a candidate command, checked against obstacle points (ours)
//! * [`ways`]: what those ways are held against
//! * [`command_fusion`]: P1's weighted sum of two commands (Eq. 10), the architecture's first form

pub mod neural;

pub mod sweep;

pub mod ways;

pub mod command_fusion;
