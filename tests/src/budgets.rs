//! What the controller may take, in one place.
//!
//! A ratchet stands a little above what was measured. A test that says "passed its ratchet" means: the controller
//! grew. If it was meant to, raise the number here in a commit of its own and say what the bytes are for; the bar
//! itself is a promise to users and does not move.

/// Bytes of RAM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryBudget {
    /// The promise.
    pub bar: usize,
    /// A little above the present size of the 64-bit host build, whose `usize` is twice the target's.
    pub ratchet: usize,
}

/// Controller, parameters and training state of 15 × 15 neurons and 12 sensors in `f32`.
pub const MEMORY_F32: MemoryBudget = MemoryBudget { bar: 12 * 1024, ratchet: 9550 };

/// The same in fixed point.
pub const MEMORY_FIXED: MemoryBudget = MemoryBudget { bar: 6 * 1024, ratchet: 5950 };
