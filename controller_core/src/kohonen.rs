//! The Extended Kohonen Map that everything else reads: where the robot can get to, and with which command.
//!
//! A lattice of `COLUMNS` × `ROWS` neurons over the local workspace U′ of the robot (bearing × distance). Neuron i
//! holds a sensory weight `w_i = (α_i, d_i)` and an output: a control parameter matrix `M_i` (indirect mapping,
//! `c = M_i u`, P1 Eq. 1) or, as the baseline, a motor vector `c_i` (direct mapping). Target localisation, obstacle
//! localisation and motor control share the `w_i` (P2, section II-C), so one map serves all three.
//!
//! * [`features`]: the normalised coordinates in which the map lives
//! * [`lattice`]: neighbourhood `G(k, i)`
//! * [`map`]: the weights, and the winner with angular priority (P1 Eq. 2–4)
//! * [`output`]: indirect and direct mapping behind one trait
//! * [`self_organisation`]: online training (P1 Eq. 6–8, P2 Eq. 11–13)

pub mod features;

pub mod lattice;

pub mod map;

pub mod output;

pub mod self_organisation;

#[cfg(test)]
mod tests;
