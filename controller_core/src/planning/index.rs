//! How wide the numbers are by which cells, passages and ends of passages refer to each other.

use core::fmt::Debug;

mod sealed {
    pub trait Sealed {}
    impl Sealed for u16 {}
    impl Sealed for u32 {}
}

/// The type that a planner stores its numbers in: `u16` for what a microcontroller holds, `u32` for maps whose passages
/// are more than 16 bits can tell apart.
pub trait Index: Copy + PartialEq + Debug + sealed::Sealed {
    /// No number; the largest, as [`Index::get`] gives it.
    const NONE: u32;

    /// [`Index::NONE`] as stored.
    const LAST: Self;

    /// What a new node of the search has as its state: half of [`Index::NONE`].
    const UNSEEN: Self;

    /// Most passages: their ends are numbered too, and half of the numbers are states.
    const PASSAGES_MAX: usize;

    /// The number as stored; beyond the range it becomes [`Index::NONE`].
    fn of(number: u32) -> Self;

    /// The number.
    fn get(self) -> u32;
}

impl Index for u16 {
    const NONE: u32 = 0xFFFF;
    const LAST: Self = Self::MAX;
    const UNSEEN: Self = Self::MAX / 2;
    const PASSAGES_MAX: usize = 16_382;

    fn of(number: u32) -> Self {
        Self::try_from(number).unwrap_or(Self::MAX)
    }

    fn get(self) -> u32 {
        u32::from(self)
    }
}

impl Index for u32 {
    const NONE: Self = Self::MAX;
    const LAST: Self = Self::MAX;
    const UNSEEN: Self = Self::MAX / 2;
    const PASSAGES_MAX: usize = 1_000_000_000;

    fn of(number: u32) -> Self {
        number
    }

    fn get(self) -> u32 {
        self
    }
}

/// The number as a place in a store.
pub(super) fn place(number: u32) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

/// A place in a store as a number.
pub(super) fn number(place: usize) -> u32 {
    u32::try_from(place).unwrap_or(u32::MAX)
}
