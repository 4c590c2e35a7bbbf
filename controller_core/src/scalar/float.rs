//! `f32` as the controller's number, with our own `exp` and `sin`/`cos` (see the parent for why).

use super::Scalar;

/// 2⁻ᶠ for |f| ≤ ½: the Taylor polynomial of exp(−f ln 2), degree 6, remainder below 2e-7.
#[inline(always)]
fn exp2_neg_fraction(f: f32) -> f32 {
    let t = f * -core::f32::consts::LN_2;
    let p = 1.0 / 120.0 + t * (1.0 / 720.0);
    let p = 1.0 / 24.0 + t * p;
    let p = 1.0 / 6.0 + t * p;
    let p = 0.5 + t * p;
    let p = 1.0 + t * p;
    1.0 + t * p
}

/// 2⁻ʸ for 0 ≤ y < 126.
#[inline(always)]
fn exp2_neg(y: f32) -> f32 {
    let n = whole(y + 0.5);
    let f = y - float(n.cast_signed());
    exp2_neg_fraction(f) * f32::from_bits(127_u32.wrapping_sub(n) << 23)
}

/// The integer part of a value known to be small and non-negative.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "callers pass 0 ≤ value < 200; the cast saturates anyway"
)]
fn whole(value: f32) -> u32 {
    value as u32
}

/// A small integer as `f32`, exactly.
#[allow(
    clippy::cast_precision_loss,
    reason = "counts below 2^24 are exact; larger ones round, as documented"
)]
fn float(count: i32) -> f32 {
    count as f32
}

impl Scalar for f32 {
    type Weight = Self;

    const NAME: &'static str = "f32";
    const ZERO: Self = 0.0;
    const WEIGHT_ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const HALF: Self = 0.5;
    const PI: Self = core::f32::consts::PI;
    const TAU: Self = core::f32::consts::TAU;
    const LIMIT: Self = 2000.0;

    fn from_f32(value: f32) -> Self {
        if value.is_nan() { 0.0 } else { value }
    }

    fn to_f32(self) -> f32 {
        self
    }

    fn from_i32(count: i32) -> Self {
        float(count)
    }

    fn to_bits(self) -> u32 {
        Self::to_bits(self)
    }

    fn to_weight(self) -> Self::Weight {
        self
    }

    fn from_weight(weight: Self::Weight) -> Self {
        weight
    }

    fn round(self) -> Self {
        libm::roundf(self)
    }

    fn sqrt(self) -> Self {
        if self > 0.0 { libm::sqrtf(self) } else { 0.0 }
    }

    fn hypot(a: Self, b: Self) -> Self {
        // libm::hypotf squares in f64, which an M4F emulates; the controller's lengths are far from overflow.
        libm::sqrtf(a * a + b * b)
    }

    fn sin_cos(self) -> (Self, Self) {
        // Quadrant k and remainder r in ±π/4, with π/2 in two parts (Cody and Waite) to keep r exact.
        const FRAC_2_PI: f32 = core::f32::consts::FRAC_2_PI;
        const PI_2_HIGH: f32 = 1.570_312_5;
        const PI_2_LOW: f32 = 4.838_268e-4;
        let turns = self.abs() * FRAC_2_PI + 0.5;
        let quadrant = whole(turns).min(64);
        let k = float(quadrant.cast_signed());
        let r = (self.abs() - k * PI_2_HIGH) - k * PI_2_LOW;
        let z = r * r;
        let sin = r + r * z * (-1.0 / 6.0 + z * (1.0 / 120.0 + z * (-1.0 / 5040.0 + z * (1.0 / 362_880.0))));
        let cos = 1.0 + z * (-0.5 + z * (1.0 / 24.0 + z * (-1.0 / 720.0 + z * (1.0 / 40_320.0))));
        let (sin, cos) = match quadrant % 4 {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        };
        (if self < 0.0 { -sin } else { sin }, cos)
    }

    fn atan2(y: Self, x: Self) -> Self {
        libm::atan2f(y, x)
    }

    fn atan2_coarse(y: Self, x: Self) -> Self {
        micromath::F32(y).atan2(micromath::F32(x)).0
    }

    // Into the loops over neurons, where the coefficients then stay in registers; likewise below.
    #[inline(always)]
    fn exp_neg(self) -> Self {
        if self <= 0.0 {
            return 1.0;
        }
        let y = self * core::f32::consts::LOG2_E;
        // Below 2⁻¹²⁶ the result would be subnormal: no field is that weak. NaN gives 0, too.
        if y < 126.0 { exp2_neg(y) } else { 0.0 }
    }

    #[inline(always)]
    fn exp_neg_within_16(self) -> Self {
        exp2_neg(self * core::f32::consts::LOG2_E)
    }
}
