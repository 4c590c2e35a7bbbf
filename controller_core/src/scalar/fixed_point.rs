//! Fixed point for cores without an FPU: Q11.20 values, Q3.12 weights, saturating throughout.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use fixed::types::{I4F12, I12F20};

use super::Scalar;

/// Fractional bits of [`Fixed`]: a micrometre, a microradian.
const FRACTION_BITS: u32 = I12F20::FRAC_NBITS;

/// A signed fixed-point number with 20 fractional bits: ±2048 in steps of 9.5e-7.
///
/// In metres that is a micrometre over two kilometres, in radians a microradian. Addition, subtraction,
/// multiplication and division **saturate**; multiplication and division round to the nearest. `x / 0` is the largest
/// value of the sign of x.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fixed(I12F20);

/// A stored weight in 16 bits: Q3.12, ±8 in steps of 2.4e-4.
///
/// With bearings in radians and distances and speeds normalised to the reach of one step, every weight of a trained
/// map lies within ±4; the step is 0.04 mm of distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct FixedWeight(I4F12);

impl FixedWeight {
    /// The weight from its raw bits (units of 2⁻¹²).
    #[must_use]
    pub const fn from_bits(bits: i16) -> Self {
        Self(I4F12::from_bits(bits))
    }

    /// The raw bits (units of 2⁻¹²).
    #[must_use]
    pub const fn to_bits(self) -> i16 {
        self.0.to_bits()
    }
}

/// Brings a wide intermediate result back into 32 bits.
#[allow(clippy::cast_possible_truncation, reason = "clamped to the range of i32 in the same expression")]
const fn saturate(bits: i64) -> i32 {
    if bits > i32::MAX as i64 {
        i32::MAX
    } else if bits < i32::MIN as i64 {
        i32::MIN
    } else {
        bits as i32
    }
}

/// a · b in units of 2⁻⁴⁰, to the nearest unit of 2⁻²⁰, saturated: as [`saturate`], in half the instructions.
///
/// Why it is right: the shifted product fits into 32 bits if and only if its bits 31 and above, bits 51 and above of
/// `wide`, are all the same. `high >> 19` is made of bits 51 to 63 and copies of the sign; `result >> 31` is 32 copies
/// of bit 51. So they are equal just when it fits, and `result` is then the whole of it. Otherwise the signs of the
/// factors say which end it is beyond. (Asked for the sign of `wide`, the compiler multiplies once more on a
/// Cortex-M3.)
#[expect(clippy::cast_possible_truncation, reason = "each half is taken by its own cast: see above")]
const fn product(a: i32, b: i32) -> i32 {
    let wide = a as i64 * b as i64 + (1 << (FRACTION_BITS - 1));
    let (high, result) = ((wide >> 32) as i32, (wide >> FRACTION_BITS) as i32);
    if high >> (FRACTION_BITS - 1) == result >> 31 { result } else { ((a ^ b) >> 31) ^ i32::MAX }
}

/// `value` in units of 2⁻²⁰: the nearest, ties to even; saturated; 0 for what is no number.
///
/// As `I12F20::saturating_from_num`, which keeps a panic for NaN in the code however it is guarded. Where floats are
/// computed by software it takes 280 instructions less than a cast of `rintf(value * 2²⁰)`; a scan has twelve of them.
const fn nearest(value: f32) -> i32 {
    // A float is mantissa · 2^(exponent − 150), so this is mantissa · 2^(exponent − 130).
    const UNIT_EXPONENT: u32 = 150 - FRACTION_BITS;
    let bits = value.to_bits();
    let (exponent, mantissa) = (bits >> 23 & 0xff, bits & 0x007f_ffff | 0x0080_0000);
    let magnitude = if exponent >= UNIT_EXPONENT {
        let up = exponent - UNIT_EXPONENT;
        if value.is_nan() {
            return 0;
        }
        // The mantissa has 24 bits, and 31 is what there is room for.
        if up > 7 {
            return if value < 0.0 { i32::MIN } else { i32::MAX };
        }
        mantissa << up
    } else {
        let down = UNIT_EXPONENT - exponent;
        if down > 24 {
            // Less than half a unit.
            return 0;
        }
        let (floor, rest, half) = (mantissa >> down, mantissa & ((1 << down) - 1), 1 << (down - 1));
        if rest > half || (rest == half && floor & 1 == 1) { floor + 1 } else { floor }
    };
    let magnitude = magnitude.cast_signed();
    if value < 0.0 { -magnitude } else { magnitude }
}

impl Fixed {
    /// The number from its raw bits (units of 2⁻²⁰); not a scaled value, see [`Scalar::from_f32`].
    #[must_use]
    pub const fn from_bits(bits: i32) -> Self {
        Self(I12F20::from_bits(bits))
    }

    /// A constant, rounded to the nearest at compile time.
    const fn constant(text: &str) -> Self {
        Self(I12F20::lit(text))
    }

    /// Rounded, not truncated: a floor would pull every servo and learning update the same way.
    #[inline(always)]
    fn product(self, other: Self) -> Self {
        Self::from_bits(product(self.raw(), other.raw()))
    }

    const fn raw(self) -> i32 {
        self.0.to_bits()
    }
}

impl Add for Fixed {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl Sub for Fixed {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Neg for Fixed {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.saturating_neg())
    }
}

impl Mul for Fixed {
    type Output = Self;
    // Called on a board, where a hundred copies of it have no room.
    #[cfg_attr(target_arch = "arm", inline(never))]
    fn mul(self, other: Self) -> Self {
        self.product(other)
    }
}

impl Div for Fixed {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let divisor = i64::from(other.raw());
        if divisor == 0 {
            return Self::from_bits(if self.raw() < 0 { i32::MIN } else { i32::MAX });
        }
        let dividend = i64::from(self.raw()) << FRACTION_BITS;
        let half = divisor.abs() / 2;
        let rounded = if dividend < 0 { dividend - half } else { dividend + half };
        Self::from_bits(saturate(rounded / divisor))
    }
}

impl AddAssign for Fixed {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Fixed {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// Square root of a 64-bit radicand, as raw bits.
fn root(radicand: u64) -> Fixed {
    Fixed::from_bits(saturate(radicand.isqrt().cast_signed()))
}

/// atan(z) for z in [0, 1]: its Chebyshev series to degree 13, whose truncation error is below 3e-7 rad.
fn atan_unit(z: Fixed) -> Fixed {
    const C: [Fixed; 7] = [
        Fixed::constant("0.999995623"),
        Fixed::constant("-0.333160020"),
        Fixed::constant("0.197968920"),
        Fixed::constant("-0.131959022"),
        Fixed::constant("0.078999834"),
        Fixed::constant("-0.033105251"),
        Fixed::constant("0.006658290"),
    ];
    let square = z * z;
    z * horner(square, &C)
}

/// c₀ + x (c₁ + x (c₂ + …)).
fn horner(x: Fixed, coefficients: &[Fixed]) -> Fixed {
    coefficients.iter().rev().fold(Fixed::ZERO, |sum, &c| sum.product(x) + c)
}

impl Scalar for Fixed {
    type Weight = FixedWeight;

    const NAME: &'static str = "fixed";
    const ZERO: Self = Self(I12F20::ZERO);
    const WEIGHT_ZERO: FixedWeight = FixedWeight(I4F12::ZERO);
    const ONE: Self = Self(I12F20::ONE);
    const HALF: Self = Self::constant("0.5");
    // Rounded to the nearest. The library's are rounded down, and twice its π is less than its 2π: an angle of exactly
    // π was then too large before and too small after a turn had been taken off.
    const PI: Self = Self::constant("3.14159265358979");
    const TAU: Self = Self::constant("6.28318530717959");
    const LIMIT: Self = Self::constant("2000");

    fn from_f32(value: f32) -> Self {
        Self::from_bits(nearest(value))
    }

    fn to_f32(self) -> f32 {
        self.0.to_num()
    }

    fn from_i32(count: i32) -> Self {
        Self(I12F20::saturating_from_num(count))
    }

    fn to_bits(self) -> u32 {
        self.raw().cast_unsigned()
    }

    fn to_weight(self) -> FixedWeight {
        const DROPPED: u32 = FRACTION_BITS - I4F12::FRAC_NBITS;
        let rounded = (i64::from(self.raw()) + (1 << (DROPPED - 1))) >> DROPPED;
        let bits = i16::try_from(rounded).unwrap_or(if rounded < 0 { i16::MIN } else { i16::MAX });
        FixedWeight::from_bits(bits)
    }

    fn from_weight(weight: FixedWeight) -> Self {
        Self(I12F20::from_num(weight.0))
    }

    fn round(self) -> Self {
        Self(self.0.saturating_round())
    }

    fn sqrt(self) -> Self {
        match u64::try_from(self.raw()) {
            Ok(bits) => root(bits << FRACTION_BITS),
            Err(_) => Self::ZERO,
        }
    }

    fn hypot(a: Self, b: Self) -> Self {
        let square = |x: Self| u64::from(x.raw().unsigned_abs()).pow(2);
        root(square(a) + square(b))
    }

    fn sin_cos(self) -> (Self, Self) {
        const FRAC_2_PI: Fixed = Fixed(I12F20::FRAC_2_PI);
        const FRAC_PI_2: Fixed = Fixed(I12F20::FRAC_PI_2);
        const SIN: [Fixed; 4] = [
            Fixed::ONE,
            Fixed::constant("-0.166666667"),
            Fixed::constant("0.008333333"),
            Fixed::constant("-0.000198413"),
        ];
        const COS: [Fixed; 5] = [
            Fixed::ONE,
            Fixed::constant("-0.5"),
            Fixed::constant("0.041666667"),
            Fixed::constant("-0.001388889"),
            Fixed::constant("0.000024802"),
        ];
        let magnitude = self.abs();
        let quadrant: i32 = (magnitude * FRAC_2_PI + Self::HALF).0.to_num();
        let r = magnitude - Self::from_i32(quadrant) * FRAC_PI_2;
        let square = r * r;
        let sin = r * horner(square, &SIN);
        let cos = horner(square, &COS);
        let (sin, cos) = match quadrant % 4 {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        };
        (if self < Self::ZERO { -sin } else { sin }, cos)
    }

    fn atan2(y: Self, x: Self) -> Self {
        const FRAC_PI_2: Fixed = Fixed(I12F20::FRAC_PI_2);
        let (ax, ay) = (x.abs(), y.abs());
        if ax == Self::ZERO && ay == Self::ZERO {
            return Self::ZERO;
        }
        let first = if ay <= ax { atan_unit(ay / ax) } else { FRAC_PI_2 - atan_unit(ax / ay) };
        let upper = if x < Self::ZERO { Self::PI - first } else { first };
        if y < Self::ZERO { -upper } else { upper }
    }

    fn atan2_coarse(y: Self, x: Self) -> Self {
        // The polynomial is already as cheap as the division before it: nothing to gain from a coarser one.
        Self::atan2(y, x)
    }

    fn exp_neg(self) -> Self {
        const LOG2_E: Fixed = Fixed(I12F20::LOG2_E);
        /// Taylor coefficients of 2⁻ᶠ = exp(−f ln 2).
        const C: [Fixed; 7] = [
            Fixed::ONE,
            Fixed::constant("-0.693147181"),
            Fixed::constant("0.240226507"),
            Fixed::constant("-0.055504109"),
            Fixed::constant("0.009618129"),
            Fixed::constant("-0.001333356"),
            Fixed::constant("0.000154035"),
        ];
        if self <= Self::ZERO {
            return Self::ONE;
        }
        let y = self * LOG2_E;
        let n: u32 = (y + Self::HALF).0.to_num();
        if n > FRACTION_BITS {
            return Self::ZERO;
        }
        let fraction = y - Self(I12F20::from_num(n));
        Self::from_bits(horner(fraction, &C).raw() >> n)
    }
}

#[cfg(test)]
mod tests {
    use super::{Fixed, I12F20};
    use crate::scalar::Scalar;

    #[test]
    fn the_nearest_value_of_a_float_is_that_of_the_fixed_crate() {
        let check = |value: f32| {
            let expected = if value.is_nan() { I12F20::ZERO } else { I12F20::saturating_from_num(value) };
            assert_eq!(Fixed::from_f32(value).0, expected, "{value:e}");
        };
        (0..u32::MAX).step_by(4099).for_each(|bits| check(f32::from_bits(bits)));
        // Ties, at every magnitude they occur in.
        (0..5_000).for_each(|halves: u16| check((f32::from(halves) - 2_500.0) / 2_097_152.0));
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2048.0, -2048.0, 2047.9999].into_iter().for_each(check);
    }
}
