//! The controller as the boards run it, and what it may take of their RAM.
//!
//! Sizes are held at compile time, on the target, where `usize` has four bytes; the host's are held by `tests`
//! (`memory`). A build that fails here says that the controller grew: if it was meant to, raise the ratchet in a commit
//! that says what the bytes are for.

#![expect(unsafe_code, reason = "a large value is made in its place")]

use core::mem::MaybeUninit;
use core::ptr;

use controller_core::config::{Config, ConfigError, Parameters};
use protocol::endpoint::{self, BoardDeliberation, Identity, Session};
use protocol::message::SENSORS;

use crate::board::Real;
use crate::flash_map::IN_FLASH;

/// Its fast half.
pub type Fast = endpoint::Fast<Real>;

/// Its slow half.
pub type Slow = endpoint::Slow<Real>;

/// Makes the slow half in its place, with the default parameters and the map in flash, if there is one.
///
/// Built on the stack and then moved, it would need twice its size in RAM, which one of the boards does not have. For
/// the same reason this and the following functions are kept apart (`inline(never)`): their stack frames would add up.
///
/// # Errors
/// If the number type of this board cannot hold the default parameters.
#[inline(never)]
pub fn put_slow(place: &'static mut MaybeUninit<Slow>) -> Result<&'static mut Slow, ConfigError> {
    let slow = place.as_mut_ptr();
    // SAFETY: within `place`, aligned, and not read before; a constant is copied from flash.
    unsafe { (&raw mut (*slow).deliberation).write(BoardDeliberation::<Real>::BLANK) };
    // SAFETY: likewise; nothing is read through this reference.
    let parameters = unsafe { &mut *(&raw mut (*slow).parameters).cast() };
    put_parameters(parameters)?;
    // SAFETY: these are all its fields.
    let slow = unsafe { place.assume_init_mut() };
    slow.deliberation.map_mut().0.reset();
    if let Some(map) = IN_FLASH {
        map.put(&mut slow.deliberation);
    }
    Ok(slow)
}

#[inline(never)]
fn put_parameters(place: &mut MaybeUninit<Parameters<Real, SENSORS>>) -> Result<(), ConfigError> {
    match &Config::default().build::<Real, SENSORS>() {
        Ok(parameters) => {
            // SAFETY: plain data without an owner, so a copy of its bytes is a copy; moved, it would go by way of the
            // stack once more.
            unsafe { ptr::copy_nonoverlapping(parameters, place.as_mut_ptr(), 1) };
            Ok(())
        }
        Err(error) => Err(*error),
    }
}

/// Makes the fast half in its place.
#[inline(never)]
pub fn put_fast(place: &'static mut MaybeUninit<Fast>, slow: &Slow) -> &'static mut Fast {
    place.write(Fast::new(slow.parameters.reflex.clone()))
}

/// Makes the session in its place.
#[inline(never)]
pub fn put_session(
    place: &'static mut MaybeUninit<Session>,
    identity: Identity,
    epoch: u32,
) -> &'static mut Session {
    place.write(Session::new(identity, epoch))
}

/// Bytes of RAM for both, parameters and learning included.
pub const RAM_BYTES: usize = size_of::<Fast>() + size_of::<Slow>();

const _: () = {
    // Promises to users, then ratchets, a little above the present sizes.
    #[cfg(board = "stm32f405")]
    assert!(RAM_BYTES <= 12 * 1024 && RAM_BYTES <= 8000);
    #[cfg(board = "stm32f100")]
    assert!(RAM_BYTES <= 6 * 1024 && RAM_BYTES <= 4900);
};
