//! How deep the stack has been: the start-up code paints the free memory, and what is no longer paint has been used.
#![expect(unsafe_code, reason = "the linker's symbols and the memory below the stack are read")]

use core::ptr;

/// What the start-up code of `cortex-m-rt` paints with.
const PAINT: u32 = 0xcccc_cccc;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Bytes of stack that have been in use at some time since the reset.
#[must_use]
pub fn bytes_max() -> u32 {
    let (top, bottom) = (ptr::addr_of!(_stack_start), ptr::addr_of!(_stack_end));
    let mut word = bottom;
    // SAFETY: from the end of the variables to the top of the stack all is RAM, and aligned; it is read volatile,
    // since the stack in use changes at any time.
    while word < top && unsafe { ptr::read_volatile(word) } == PAINT {
        word = word.wrapping_add(1);
    }
    u32::try_from(top.addr().saturating_sub(word.addr())).unwrap_or(u32::MAX)
}

/// Whether a value lies within the stack.
#[must_use]
pub fn holds<T>(value: *const T) -> bool {
    let (top, bottom) = (ptr::addr_of!(_stack_start).addr(), ptr::addr_of!(_stack_end).addr());
    value.is_aligned() && value.addr() >= bottom && value.addr().saturating_add(size_of::<T>()) <= top
}
