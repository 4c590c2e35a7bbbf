//! The shape of every message as one number.

/// Hash of all messages' names, fields and types.
pub const HASH: u64 = 0;
