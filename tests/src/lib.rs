//! What the tests of the claims share: scalars side by side, trained maps, references in `f64`, and the budgets.
//!
//! Each file in `claims/` is one claim of the papers or one bar of the project. It begins with goal, method, the
//! paper's number, ours, the tolerance and why.
#![forbid(unsafe_code)]

pub mod budgets;

pub mod learning;

pub mod fields;

pub mod statistics;

pub mod maps;

pub mod visibility;

pub mod missions;

pub mod wire;

/// Makes two tests of each generic function `name::<S>()`: `name::f32` and `name::fixed`.
#[macro_export]
macro_rules! for_each_scalar {
    ($($body:ident),+ $(,)?) => {
        $(
            mod $body {
                #[test]
                fn f32() {
                    super::$body::<f32>();
                }

                #[test]
                fn fixed() {
                    super::$body::<controller_core::scalar::Fixed>();
                }
            }
        )+
    };
}

pub use host_sim::number::narrow;

/// A controller's number as `f64`.
#[must_use]
pub fn wide<S: controller_core::scalar::Scalar>(value: S) -> f64 {
    f64::from(value.to_f32())
}

/// The examples of the README compile and run.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
