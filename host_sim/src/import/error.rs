//! What can be wrong with a file that others wrote.

use std::path::Path;

use super::COORDINATE_MAX_M;

/// A file that cannot be taken: which, where in it, what is wrong, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{file}{}{place}: {problem}; {fix}", if place.is_empty() { "" } else { ": " })]
pub struct ImportError {
    /// Path as given.
    pub file: String,
    /// Line, key or element; empty for the file as a whole.
    pub place: String,
    /// What is wrong, with the value.
    pub problem: String,
    /// What to do.
    pub fix: String,
}

/// Makes the errors of one file, and checks what every kind of file has.
#[derive(Debug, Clone)]
pub struct Reader {
    file: String,
}

impl Reader {
    /// For the file at `path`.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self { file: path.display().to_string() }
    }

    /// An error at a place of this file.
    #[must_use]
    pub fn error(&self, place: &str, problem: String, fix: &str) -> ImportError {
        ImportError { file: self.file.clone(), place: place.to_owned(), problem, fix: fix.to_owned() }
    }

    /// A coordinate in m.
    ///
    /// # Errors
    /// If it is no number or not within ±[`COORDINATE_MAX_M`].
    pub fn coordinate(&self, place: &str, value: f64) -> Result<f64, ImportError> {
        if value.abs() <= COORDINATE_MAX_M {
            return Ok(value);
        }
        let problem = format!("{value} m is not within ±{COORDINATE_MAX_M} m");
        Err(self.error(place, problem, "give metres at the robot's scale"))
    }

    /// A length above 0, in m.
    ///
    /// # Errors
    /// If it is not.
    pub fn length(&self, place: &str, value: f64) -> Result<f64, ImportError> {
        if value > 0.0 {
            return self.coordinate(place, value);
        }
        Err(self.error(place, format!("{value} is no length"), "give a number of metres above 0"))
    }

    /// A number of the text.
    ///
    /// # Errors
    /// If it is none.
    pub fn number<T: core::str::FromStr>(&self, place: &str, text: &str) -> Result<T, ImportError> {
        let wrong = |_| self.error(place, format!("`{}` is no such number", shortened(text)), "correct it");
        text.trim().parse().map_err(wrong)
    }
}

/// The beginning of a text that may be of any length.
pub(super) fn shortened(text: &str) -> String {
    const SHOWN: usize = 40;
    let mut shown: String = text.trim().chars().take(SHOWN).collect();
    if text.trim().chars().nth(SHOWN).is_some() {
        shown.push('…');
    }
    shown
}
