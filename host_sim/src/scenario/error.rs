//! What can be wrong with a scenario, said so that it can be put right: file, key, value, and what to do.

use std::io;

/// A scenario that cannot be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// Neither a built-in name nor a file.
    #[error("no scenario is called `{name}` and no such file exists{hint}; built in are {known}")]
    NotFound {
        /// What was asked for.
        name: String,
        /// `; did you mean ...`, or empty.
        hint: String,
        /// The built-in names.
        known: String,
    },
    /// The file exists but cannot be read.
    #[error("{file}: cannot be read ({source}); check that it is a text file and that you may read it")]
    Unreadable {
        /// Path as given.
        file: String,
        /// The system's reason.
        source: io::Error,
    },
    /// The file is not TOML.
    #[error("{file}:{line}:{column}: not valid TOML: {problem}; correct the line or see https://toml.io")]
    Syntax {
        /// Path or built-in name.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// What the parser met.
        problem: String,
    },
    /// A key that is unknown, missing, or holds a value of the wrong type.
    #[error("{file}:{line}:{column}: `{key}`: {problem}; {fix}")]
    Key {
        /// Path or built-in name.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// Path of the key, list places counted from 0, such as `obstacles[2].radius_m`.
        key: String,
        /// What is wrong.
        problem: String,
        /// What to do.
        fix: String,
    },
    /// A value that has the right type and makes no sense.
    #[error("{file}: `{key}` = {value}: {problem}; {fix}")]
    Value {
        /// Path or built-in name.
        file: String,
        /// Path of the key, list places counted from 0, such as `obstacles[2].radius_m`.
        key: String,
        /// The value as it would be written.
        value: String,
        /// What is wrong.
        problem: String,
        /// What to do.
        fix: String,
    },
}

impl ScenarioError {
    /// Path of the key at fault, if the fault is at a key.
    #[must_use]
    pub fn key(&self) -> Option<&str> {
        match self {
            Self::Key { key, .. } | Self::Value { key, .. } => Some(key),
            Self::NotFound { .. } | Self::Unreadable { .. } | Self::Syntax { .. } => None,
        }
    }
}

/// The candidate most like `word`, if one is like it at all.
pub(super) fn most_similar<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A third of the letters wrong is a slip of the keyboard; more is another word.
    let limit = word.chars().count().div_ceil(3);
    let scored = candidates.into_iter().map(|candidate| (edit_distance(word, candidate), candidate));
    scored.filter(|(distance, _)| *distance <= limit).min().map(|(_, candidate)| candidate)
}

/// Insertions, deletions and replacements that turn one word into the other.
fn edit_distance(from: &str, to: &str) -> usize {
    // One row of the usual table at a time: `row[j]` is the distance from what was read so far to the first j letters.
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, letter) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, other) in to.iter().enumerate() {
            let replaced = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use super::{edit_distance, most_similar};

    #[test]
    fn edit_distance_counts_single_letter_changes() {
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("radius", "radius"), 0);
    }

    #[test]
    fn a_slip_finds_its_word_and_another_word_does_not() {
        assert_eq!(most_similar("gaol", ["goal", "walls"]), Some("goal"));
        assert_eq!(most_similar("elephant", ["goal", "walls"]), None);
    }
}
