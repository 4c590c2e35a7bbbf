//! The controller as the boards run it, and what it may take of their RAM.
//!
//! Sizes are held at compile time, on the target, where `usize` has four bytes; the host's are held by `tests`
//! (`memory`). A build that fails here says that the controller grew: if it was meant to, raise the ratchet in a commit
//! that says what the bytes are for.

use protocol::endpoint;

use crate::board::Real;

/// Its fast half.
pub type Fast = endpoint::Fast<Real>;

/// Its slow half.
pub type Slow = endpoint::Slow<Real>;

/// Bytes of RAM for both, parameters and learning included.
pub const RAM_BYTES: usize = size_of::<Fast>() + size_of::<Slow>();

const _: () = {
    // Promises to users, then ratchets, a little above the present sizes.
    #[cfg(board = "stm32f405")]
    assert!(RAM_BYTES <= 12 * 1024 && RAM_BYTES <= 9000);
    #[cfg(board = "stm32f100")]
    assert!(RAM_BYTES <= 6 * 1024 && RAM_BYTES <= 6000);
};
