//! Localisation EKMs: a target and each detected obstacle become activity over the neurons of the shared map.
//!
//! * [`target`]: the target field `a_i` (P2 Eq. 1–5)
//! * [`obstacle`]: the obstacle fields `b_ij`, summed over the sensors (P2 Eq. 6–7)
//! * [`memory`]: obstacles seen a moment ago (ours)
//! * [`mover`]: what moves, and where to (ours)
//! * [`corridor`], [`opening`]: doors hardly wider than the body are aimed at squarely (ours)
//! * [`separation`]: other robots, known by communication (P2 names it, the rest is ours)
//! * [`departure`]: the turn towards the next checkpoint where one has been reached (ours)
//! * [`detour`]: where the target field is centred when the way is blocked for good (ours)
//!
//! Fields stand until they are renewed (P2, section II-D).

pub mod target;

pub mod obstacle;
pub mod opening;

pub mod corridor;

pub mod memory;

pub mod mover;

pub mod separation;

pub mod departure;

pub mod detour;
