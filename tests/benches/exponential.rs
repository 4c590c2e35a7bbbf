//! Which exponential? Time and error of four, on the load of one neural integration.
//!
//! ```text
//! cargo bench -p tests --bench exponential
//! ```
//!
//! Each pass computes 12 × 225 Gaussians exp(−x), as many as 12 obstacle fields have over 15 × 15 neurons, at the
//! arguments that occur there (0 to 16; weaker ones are not computed). Times are those of one process and are printed
//! as ratios to `libm::expf`, since a host's nanoseconds mean nothing to a microcontroller: without an FPU only the
//! fixed-point one is spared emulated floats. Instructions on the targets are the firmware's business. The minimum of
//! many passes is taken: what disturbs only ever adds.

use core::hint::black_box;
use std::time::Instant;

use controller_core::scalar::{Fixed, Scalar};
use tests::{narrow, wide};

const FIELDS: u32 = 12;
const NEURONS: u32 = 225;
const PASSES: u32 = 400;

/// The arguments of one pass, in an order that no branch predictor learns by heart.
fn arguments() -> Vec<f32> {
    let count = FIELDS * NEURONS;
    // A multiplier coprime to the count visits every argument once.
    (0..count).map(|i| narrow(f64::from(i * 1009 % count) * 16.0 / f64::from(count))).collect()
}

/// Nanoseconds per exponential: the quickest of many passes.
fn time_ns<T: Copy>(arguments: &[T], exp: impl Fn(T) -> T) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..PASSES {
        let start = Instant::now();
        for &x in black_box(arguments) {
            black_box(exp(x));
        }
        least = least.min(start.elapsed().as_secs_f64());
    }
    least * 1e9 / f64::from(FIELDS * NEURONS)
}

/// Largest absolute and relative error against `f64`, relative where the exact value is above 10⁻³.
fn errors<S: Scalar>(arguments: &[S], exp: impl Fn(S) -> S) -> (f64, f64) {
    arguments.iter().fold((0.0_f64, 0.0_f64), |(absolute, relative), &x| {
        let exact = (-wide(x)).exp();
        let error = (wide(exp(x)) - exact).abs();
        (absolute.max(error), if exact > 1e-3 { relative.max(error / exact) } else { relative })
    })
}

struct Row {
    name: &'static str,
    ns: f64,
    errors: (f64, f64),
}

fn row<S: Scalar>(name: &'static str, arguments: &[S], exp: impl Fn(S) -> S) -> Row {
    Row { name, ns: time_ns(arguments, &exp), errors: errors(arguments, &exp) }
}

fn main() {
    let plain = arguments();
    let fixed: Vec<Fixed> = plain.iter().map(|&x| Fixed::from_f32(x)).collect();
    let rows = [
        row("std f32::exp", &plain, |x: f32| (-x).exp()),
        row("libm expf", &plain, |x: f32| libm::expf(-x)),
        row("micromath exp", &plain, |x: f32| micromath::F32(-x).exp().0),
        row("ours, f32", &plain, |x: f32| x.exp_neg()),
        row("ours, fixed", &fixed, |x: Fixed| x.exp_neg()),
    ];
    let reference_ns = rows[1].ns;
    println!("{:<14} {:>10} {:>8} {:>12} {:>12}", "exp(-x)", "time/expf", "ns", "max abs err", "max rel err");
    for Row { name, ns, errors: (absolute, relative) } in rows {
        println!("{name:<14} {:>10.2} {ns:>8.2} {absolute:>12.1e} {relative:>12.1e}", ns / reference_ns);
    }
}
