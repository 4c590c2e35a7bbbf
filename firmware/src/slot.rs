//! A mailbox for one value between two tasks, without copying it out.
//!
//! Values of a hundred bytes and more would otherwise lie on the stacks of both tasks, on a board whose whole stack is
//! not two thousand bytes.
#![expect(unsafe_code, reason = "what one task reads in place, another has written")]

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};

/// Room for one value.
pub struct Slot<T> {
    value: UnsafeCell<Option<T>>,
    is_full: AtomicBool,
}

/// The end that fills the slot.
pub struct Filler<T: 'static>(&'static Slot<T>);

/// The end that empties it.
pub struct Taker<T: 'static>(&'static Slot<T>);

// SAFETY: `Slot::split` gives out one end of each kind, and `is_full` says which of the two may touch the value.
unsafe impl<T: Send> Sync for Slot<T> {}

impl<T> Slot<T> {
    /// An empty slot with what [`Filler::fill`] begins with.
    #[must_use]
    pub const fn with(blank: T) -> Self {
        Self { value: UnsafeCell::new(Some(blank)), is_full: AtomicBool::new(false) }
    }

    /// An empty slot.
    #[must_use]
    pub const fn new() -> Self {
        Self { value: UnsafeCell::new(None), is_full: AtomicBool::new(false) }
    }

    /// Its two ends.
    pub fn split(&'static mut self) -> (Filler<T>, Taker<T>) {
        (Filler(self), Taker(self))
    }
}

impl<T> Default for Slot<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> Filler<T> {
    /// Fills the slot in place, from what lay in it last; `false`, and nothing is done, where the last value is still
    /// being worked on.
    pub fn fill(&mut self, work: impl FnOnce(&mut T)) -> bool {
        if self.0.is_full.load(Ordering::Acquire) {
            return false;
        }
        // SAFETY: the slot is empty, so the other end does not touch the value, and there is one of this kind.
        let Some(value) = (unsafe { &mut *self.0.value.get() }) else { return false };
        work(value);
        self.0.is_full.store(true, Ordering::Release);
        true
    }

    /// Puts a value in; `false`, and the value is lost, where the last is still being worked on.
    pub fn put(&mut self, value: T) -> bool {
        if self.0.is_full.load(Ordering::Acquire) {
            return false;
        }
        // SAFETY: the slot is empty, so the other end does not touch the value, and there is one of this kind.
        unsafe { *self.0.value.get() = Some(value) };
        self.0.is_full.store(true, Ordering::Release);
        true
    }
}

impl<T> Taker<T> {
    /// Works on the value where it lies, if there is one; afterwards the slot is empty.
    pub fn take<R>(&mut self, work: impl FnOnce(&T) -> R) -> Option<R> {
        if !self.0.is_full.load(Ordering::Acquire) {
            return None;
        }
        // SAFETY: the slot is full, so the other end does not touch the value, and there is one of this kind.
        let value = unsafe { &*self.0.value.get() };
        let result = value.as_ref().map(work);
        self.0.is_full.store(false, Ordering::Release);
        result
    }
}
