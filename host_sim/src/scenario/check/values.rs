//! Checks of single values, and how they are shown in a complaint.

use core::fmt::{Display, Write};

use nalgebra::Point2;

use super::super::error::ScenarioError;
use super::super::raw::RawPoint;
use super::{AVOIDANCE_PERIOD_MS, Checked};

/// No number of a scenario is larger; squares and products of such numbers cannot overflow.
const LARGEST: f64 = 1e6;
/// No size of a scenario is smaller; ratios of such numbers cannot overflow either.
const SMALLEST: f64 = 1e-6;

/// The checks of one file.
pub(super) struct Check<'a> {
    pub(super) file: &'a str,
}

/// Single values.
impl Check<'_> {
    pub(super) fn wrong(
        &self,
        key: &str,
        value: impl Display,
        problem: impl Into<String>,
        fix: &str,
    ) -> ScenarioError {
        let (file, key, value) = (self.file.to_owned(), key.to_owned(), value.to_string());
        ScenarioError::Value { file, key, value, problem: problem.into(), fix: fix.to_owned() }
    }

    pub(super) fn finite(&self, key: &str, value: f64) -> Checked<f64> {
        if !value.is_finite() {
            return Err(self.wrong(key, value, "is not a finite number", "write an ordinary number"));
        }
        if value.abs() > LARGEST {
            return Err(self.wrong(
                key,
                value,
                "is out of all proportion",
                "use metres, seconds and degrees",
            ));
        }
        Ok(value)
    }

    pub(super) fn positive(&self, key: &str, value: f64) -> Checked<f64> {
        if self.finite(key, value)? <= 0.0 {
            return Err(self.wrong(key, value, "must be greater than zero", "write a positive number"));
        }
        if value < SMALLEST {
            return Err(self.wrong(
                key,
                value,
                "is too small to mean anything",
                "use metres, seconds and degrees",
            ));
        }
        Ok(value)
    }

    pub(super) fn not_negative(&self, key: &str, value: f64) -> Checked<f64> {
        if self.finite(key, value)? >= 0.0 {
            return Ok(value);
        }
        Err(self.wrong(key, value, "must not be negative", "write zero or a positive number"))
    }

    pub(super) fn fraction(&self, key: &str, value: f64) -> Checked<f64> {
        if self.not_negative(key, value)? <= 1.0 {
            return Ok(value);
        }
        Err(self.wrong(key, value, "is a fraction, 0 to 1", "write 0.1 for 10 %"))
    }

    pub(super) fn point(&self, key: &str, [x, y]: RawPoint) -> Checked<Point2<f64>> {
        let point = Point2::new(x, y);
        if x.abs() <= LARGEST && y.abs() <= LARGEST {
            return Ok(point);
        }
        let problem = "is not a pair of finite numbers of ordinary size";
        Err(self.wrong(key, show(point), problem, "write [x, y] in metres"))
    }

    pub(super) fn filled(&self, key: &str, value: &str) -> Checked<String> {
        if value.trim().is_empty() {
            return Err(self.wrong(key, format!("{value:?}"), "is empty", "write a short text"));
        }
        Ok(value.to_owned())
    }

    /// A name becomes part of file names.
    pub(super) fn name(&self, key: &str, value: &str) -> Checked<String> {
        let plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-';
        if self.filled(key, value)?.chars().all(plain) {
            return Ok(value.to_owned());
        }
        let problem = "must serve as a file name";
        Err(self.wrong(key, format!("{value:?}"), problem, "use letters, digits, `-` and `_` only"))
    }

    pub(super) fn period(&self, value: u32) -> Checked<u32> {
        if value > 0 && value.is_multiple_of(AVOIDANCE_PERIOD_MS) {
            return Ok(value);
        }
        let problem = format!("is not a multiple of the avoidance period, {AVOIDANCE_PERIOD_MS} ms");
        Err(self.wrong("control.target_period_ms", value, problem, "use 256 (P2) or 1024 (P1)"))
    }

    /// Checks every element of a list; `one` gets the element's key, such as `obstacles[2]`.
    pub(super) fn all<R, T>(
        &self,
        key: &str,
        list: &[R],
        one: impl Fn(&Self, &str, &R) -> Checked<T>,
    ) -> Checked<Vec<T>> {
        list.iter().enumerate().map(|(i, raw)| one(self, &format!("{key}[{i}]"), raw)).collect()
    }

    pub(super) fn points(&self, key: &str, list: &[RawPoint]) -> Checked<Vec<Point2<f64>>> {
        self.all(key, list, |check, key, raw| check.point(key, *raw))
    }
}

/// A point as it would be written.
pub(super) fn show(point: Point2<f64>) -> String {
    format!("[{}, {}]", point.x, point.y)
}

/// Points as they would be written.
pub(super) fn list(points: &[Point2<f64>]) -> String {
    let mut text = String::from("[");
    for (i, point) in points.iter().enumerate() {
        let comma = if i == 0 { "" } else { ", " };
        // Writing to a string cannot fail.
        let _ = write!(text, "{comma}{}", show(*point));
    }
    text + "]"
}
