//! The number type of the whole controller: one small trait, two implementors.
//!
//! `f32` is for cores with an FPU, [`Fixed`] (Q11.20 in 32 bits) for those without. Both are *types*, never Cargo
//! features, so one binary can run and compare both. Every method is **total**: no argument panics, fixed point
//! saturates instead of wrapping, and a division by zero gives the largest magnitude of its sign.
//!
//! All maths is pure Rust, so that x86-64, Cortex-M4F and soft-float Cortex-M3 produce the same bits: `libm`
//! where its `f32` routine computes in `f32` (`sqrtf`, `atan2f`), `micromath` where a milliradian is enough
//! ([`Scalar::atan2_coarse`]), and polynomials of our own where libm would fall back to `f64` (`sinf`, `cosf`) or
//! where the function is the hot spot of neural integration ([`Scalar::exp_neg`]). The error bounds that the method
//! docs state are held by the tests at the end of this file, against `f64`.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

mod fixed_point;
mod float;

pub use fixed_point::{Fixed, FixedWeight};

/// A real number of the controller: total, ordered, small.
///
/// Only what the controller calls stands here, so that every implementor can honour all of it.
pub trait Scalar:
    Copy
    + Debug
    + Default
    + PartialEq
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// How a trained weight is stored: `f32`, or 16 bits (Q3.12) for fixed point.
    type Weight: Copy + Debug + Default + PartialEq + Send + Sync + 'static;

    /// The name users type and read: `f32` or `fixed`.
    const NAME: &'static str;
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// ½.
    const HALF: Self;
    /// π.
    const PI: Self;
    /// 2π.
    const TAU: Self;
    /// 0 as a stored weight.
    const WEIGHT_ZERO: Self::Weight;
    /// A magnitude no valid quantity of the controller exceeds (it bounds inputs before they are used).
    const LIMIT: Self;

    /// The nearest representable value; saturates, and NaN gives zero.
    fn from_f32(value: f32) -> Self;

    /// The value as `f32`, for configuration, telemetry and logs.
    fn to_f32(self) -> f32;

    /// An integer count; saturates in fixed point, rounds above 2²⁴ in `f32`.
    fn from_i32(count: i32) -> Self;

    /// The raw bits, for state hashes. Equal bits mean equal behaviour; NaN payloads never occur in the state.
    fn to_bits(self) -> u32;

    /// Stores a weight; 16-bit storage rounds to the nearest and saturates at ±8.
    fn to_weight(self) -> Self::Weight;

    /// Reads a stored weight.
    fn from_weight(weight: Self::Weight) -> Self;

    /// The nearest whole number; halves away from zero.
    #[must_use]
    fn round(self) -> Self;

    /// Square root; negative arguments give zero. Relative error ≤ 6e-8 (`f32`), absolute ≤ 1e-6 (fixed).
    fn sqrt(self) -> Self;

    /// √(a² + b²) without intermediate loss in fixed point.
    fn hypot(a: Self, b: Self) -> Self;

    /// Sine and cosine of an angle within ±2π. Absolute error ≤ 3e-7 (`f32`), ≤ 4e-6 (fixed).
    fn sin_cos(self) -> (Self, Self);

    /// The angle of the vector (`x`, `y`) in (−π, π]; 0 for the zero vector. Error ≤ 4e-7 rad (`f32`), ≤ 6e-6 (fixed).
    fn atan2(y: Self, x: Self) -> Self;

    /// [`Scalar::atan2`] where 3 mrad are enough and cost matters: bearings of remembered obstacle points, whose
    /// sensor beam is a hundred times wider.
    fn atan2_coarse(y: Self, x: Self) -> Self;

    /// exp(−x) for x ≥ 0; negative x counts as 0. Absolute error ≤ 4e-7 (`f32`), ≤ 3e-6 (fixed).
    fn exp_neg(self) -> Self;

    /// [`Scalar::exp_neg`] of 0 ≤ x ≤ 16, the same to the last bit; what it gives elsewhere means nothing.
    #[must_use]
    fn exp_neg_within_16(self) -> Self {
        self.exp_neg()
    }

    /// The magnitude.
    #[must_use]
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }

    /// The smaller of two values.
    #[must_use]
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// The larger of two values.
    #[must_use]
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }

    /// The value brought into `low..=high`; anything unordered (NaN) becomes `low`.
    #[must_use]
    fn clamp(self, low: Self, high: Self) -> Self {
        // Two selections, which a processor may have as instructions; NaN is not greater.
        let raised = if self > low { self } else { low };
        raised.min(high)
    }

    /// The value, or zero where it is not a number or beyond [`Scalar::LIMIT`] by saturation.
    #[must_use]
    fn sanitised(self) -> Self {
        if self >= -Self::LIMIT && self <= Self::LIMIT { self } else { Self::ZERO }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use core::f64::consts::{PI, TAU};

    use super::{Fixed, Scalar};
    use crate::testing::narrow;

    /// The nearest value of the scalar.
    fn scalar<S: Scalar>(value: f64) -> S {
        S::from_f32(narrow(value))
    }

    /// Largest |approximation − exact| of `f` over `steps` + 1 evenly spaced arguments in `low..=high`.
    fn max_error<S: Scalar>(
        (low, high): (f64, f64),
        exact: impl Fn(f64) -> f64,
        approximation: impl Fn(S) -> S,
    ) -> f64 {
        let steps = 20_000_u32;
        (0..=steps)
            .map(|i| {
                let x = scalar::<S>(low + (high - low) * f64::from(i) / f64::from(steps));
                (f64::from(approximation(x).to_f32()) - exact(f64::from(x.to_f32()))).abs()
            })
            .fold(0.0, f64::max)
    }

    fn check_functions<S: Scalar>(sin_cos: f64, atan2: f64, exp: f64, sqrt: f64) {
        let turn = (-TAU, TAU);
        let e = max_error::<S>(turn, f64::sin, |x| x.sin_cos().0);
        assert!(e <= sin_cos, "{} sin: {e:e}", S::NAME);
        let e = max_error::<S>(turn, f64::cos, |x| x.sin_cos().1);
        assert!(e <= sin_cos, "{} cos: {e:e}", S::NAME);
        let e = max_error::<S>((0.0, 20.0), |x| (-x).exp(), S::exp_neg);
        assert!(e <= exp, "{} exp_neg: {e:e}", S::NAME);
        let e = max_error::<S>((0.0, 100.0), f64::sqrt, S::sqrt);
        assert!(e <= sqrt, "{} sqrt: {e:e}", S::NAME);
        for i in 0..1000_i32 {
            let angle = 0.999 * (TAU * f64::from(i) / 1000.0 - PI);
            for radius in [0.01, 0.2, 3.0] {
                let x = scalar::<S>(radius * angle.cos());
                let y = scalar::<S>(radius * angle.sin());
                let exact = f64::from(y.to_f32()).atan2(f64::from(x.to_f32()));
                let error = (f64::from(S::atan2(y, x).to_f32()) - exact).abs();
                // A short vector in fixed point has a coarse angle of its own; the bound is for the function.
                assert!(error <= atan2, "{} atan2({y:?}, {x:?}): {error:e}", S::NAME);
                let error = (f64::from(S::atan2_coarse(y, x).to_f32()) - exact).abs();
                assert!(error <= 3e-3, "{} atan2_coarse({y:?}, {x:?}): {error:e}", S::NAME);
            }
        }
    }

    #[test]
    fn exponentials_of_small_arguments_are_the_same() {
        fn check<S: Scalar>() {
            for i in 0..=32_000_i32 {
                let x = S::from_i32(i) / S::from_i32(2000);
                assert_eq!(x.exp_neg_within_16().to_bits(), x.exp_neg().to_bits(), "{x:?}");
            }
        }
        check::<f32>();
        check::<Fixed>();
        assert_eq!(0.0_f32.exp_neg_within_16().to_bits(), 1.0_f32.to_bits());
    }

    #[test]
    fn functions_hold_their_documented_error_bounds() {
        check_functions::<f32>(3e-7, 4e-7, 4e-7, 6e-7);
        check_functions::<Fixed>(4e-6, 6e-6, 3e-6, 1e-6);
    }

    fn check_totality<S: Scalar>() {
        let extremes = [0.0, -0.0, 1e-7, -1e-7, 1.0, -1.0, 2047.9, -2048.0, 1e9, -1e9, f32::MAX, f32::MIN];
        for a in extremes.map(S::from_f32) {
            for b in extremes.map(S::from_f32) {
                let _ =
                    (a + b, a - b, a * b, a / b, -a, S::hypot(a, b), S::atan2(a, b), S::atan2_coarse(a, b));
                let _ = a.clamp(-S::ONE, S::ONE);
            }
            let _ = (a.sqrt(), a.exp_neg(), a.sin_cos(), a.to_weight(), a.sanitised());
        }
        assert_eq!(S::from_f32(f32::NAN), S::ZERO);
        assert_eq!(S::ONE.exp_neg().clamp(S::ZERO, S::ONE), S::ONE.exp_neg());
    }

    #[test]
    fn no_argument_panics() {
        check_totality::<f32>();
        check_totality::<Fixed>();
    }

    #[test]
    fn fixed_saturates_and_rounds() {
        let max = Fixed::from_bits(i32::MAX);
        assert_eq!(max + Fixed::ONE, max);
        assert_eq!(max * max, max);
        assert_eq!(Fixed::ONE / Fixed::ZERO, max);
        assert_eq!(-Fixed::ONE / Fixed::ZERO, Fixed::from_bits(i32::MIN));
        assert_eq!((Fixed::from_bits(1) * Fixed::HALF).to_bits(), 1, "half a step rounds up");
        assert_eq!(Fixed::from_f32(100.0).to_weight().to_bits(), i16::MAX);
        assert_eq!(Fixed::from_weight(Fixed::from_f32(-1.5).to_weight()), Fixed::from_f32(-1.5));
    }

    #[test]
    fn clamping_nan_gives_the_lower_bound() {
        assert!((Scalar::clamp(f32::NAN, -1.0, 1.0) - -1.0).abs() < f32::EPSILON);
        assert!(Scalar::sanitised(f32::NAN).abs() < f32::EPSILON);
        assert!(Scalar::sanitised(f32::INFINITY).abs() < f32::EPSILON);
    }
}
