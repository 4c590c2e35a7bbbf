//! Planning: sparse checkpoints in the workspace instead of a path in configuration space (P1, section 2.1).

pub mod checkpoint;
