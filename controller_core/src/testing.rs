//! What the tests of several modules share.

use crate::scalar::Scalar;

/// A controller's number as `f64`.
pub fn wide<S: Scalar>(value: S) -> f64 {
    f64::from(value.to_f32())
}

/// The nearest `f32`.
#[allow(
    clippy::cast_possible_truncation,
    reason = "from f64 to f32 the cast rounds to the nearest and gives infinity beyond the range: nothing is cut off"
)]
pub fn narrow(value: f64) -> f32 {
    value as f32
}

/// How far two angles are apart on the circle.
pub fn apart(a: f64, b: f64) -> f64 {
    (a - b).sin().atan2((a - b).cos()).abs()
}
