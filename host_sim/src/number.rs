//! From the simulator's `f64` to the controller's `f32`, in one place.

use controller_core::units::Point;
use nalgebra::Point2;

/// The nearest `f32`, as a converter in front of the controller would give.
#[allow(
    clippy::cast_possible_truncation,
    reason = "from f64 to f32 the cast rounds to the nearest and gives infinity beyond the range: nothing is cut off"
)]
#[must_use]
pub fn narrow(value: f64) -> f32 {
    value as f32
}

/// A point in the controller's type.
#[must_use]
pub fn narrow_point(point: Point2<f64>) -> Point<f32> {
    Point { x_m: narrow(point.x), y_m: narrow(point.y) }
}

/// The lower 32 bits.
#[must_use]
pub fn low_word(bits: u64) -> u32 {
    u32::try_from(bits & 0xFFFF_FFFF).unwrap_or(0)
}
