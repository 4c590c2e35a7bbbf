//! The controller as the boards run it, and what it may take of their RAM.
//!
//! Sizes are held at compile time, on the target, where `usize` has four bytes; the host's are held by `tests`
//! (`memory`). A build that fails here says that the controller grew: if it was meant to, raise the ratchet in a commit
//! that says what the bytes are for.

#![expect(unsafe_code, reason = "a large value is made in its place")]

use core::mem::MaybeUninit;

use controller_core::config::Parameters;
use protocol::endpoint::{self, BoardDeliberation};
use protocol::message::SENSORS;

use crate::board::Real;

/// Its fast half.
pub type Fast = endpoint::Fast<Real>;

/// Its slow half.
pub type Slow = endpoint::Slow<Real>;

/// Makes the slow half in its place.
///
/// Built on the stack and then moved, it would need twice its size in RAM, which one of the boards does not have.
#[inline(never)]
pub fn put_slow(
    place: &'static mut MaybeUninit<Slow>,
    parameters: &Parameters<Real, SENSORS>,
) -> &'static mut Slow {
    let slow = place.as_mut_ptr();
    // SAFETY: within `place`, aligned, and not read before; a constant is copied from flash.
    unsafe { (&raw mut (*slow).deliberation).write(BoardDeliberation::<Real>::BLANK) };
    // SAFETY: likewise.
    unsafe { (&raw mut (*slow).parameters).write(parameters.clone()) };
    // SAFETY: these are all its fields.
    let slow = unsafe { place.assume_init_mut() };
    slow.deliberation.map_mut().0.reset();
    slow
}

/// Bytes of RAM for both, parameters and learning included.
pub const RAM_BYTES: usize = size_of::<Fast>() + size_of::<Slow>();

const _: () = {
    // Promises to users, then ratchets, a little above the present sizes.
    #[cfg(board = "stm32f405")]
    assert!(RAM_BYTES <= 12 * 1024 && RAM_BYTES <= 9000);
    #[cfg(board = "stm32f100")]
    assert!(RAM_BYTES <= 6 * 1024 && RAM_BYTES <= 6000);
};
