//! Every number of the peers: the table `[peers]` of a file for `--config`.
//!
//! A group is a struct of `f64`, in SI units with the unit in the name; [`Number`] tells what each may be and where a
//! search looks for it. Nothing is validated again after [`PeerConfig::validate`].
//!
//! The defaults were found by the search behind `host_sim search NAME`, the same for all: seed 1, 12 generations of 16
//! candidates, on 21 scenes (traps, doors, a wall's end, a corridor, posts, moving discs, three figures of the papers).

use serde::{Deserialize, Serialize};

use crate::contender::Contender;
use crate::search::Dimension;

/// A number of a group: what it is called and what it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// Name in a file below `[peers]`, such as `apf.range_m`.
    pub name: &'static str,
    /// Smallest value that makes sense.
    pub low: f64,
    /// Largest value that makes sense.
    pub high: f64,
    /// Where a search looks; `None` for what is given and not tuned.
    pub search: Option<Dimension>,
}

/// A group of numbers that can be listed, read and set without knowing them.
pub trait Numbers {
    /// The numbers, in the order of the fields.
    fn list(&self) -> &'static [Number];
    /// The value of the number at this place of the list.
    fn value_mut(&mut self, place: usize) -> Option<&mut f64>;
}

/// Makes a group of lines `field: default, low to high, where a search looks;`: `linear` or `log` and the bounds, or
/// `given` for what is not tuned.
macro_rules! numbers {
    (@search $name:expr, given) => { None };
    (@search $name:expr, $scale:ident($low:literal, $high:literal)) => {
        Some($crate::search::Dimension::$scale($name, $low, $high))
    };
    ($(#[$doc:meta])* $group:ident, $table:literal {
        $(
            $(#[$field_doc:meta])+
            $field:ident: $default:literal, $low:literal to $high:literal,
            $search:ident $(($from:literal, $to:literal))?;
        )+
    }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $group {
            $($(#[$field_doc])+ pub $field: f64,)+
        }

        impl Default for $group {
            fn default() -> Self {
                Self { $($field: $default,)+ }
            }
        }

        impl $crate::peers::config::Numbers for $group {
            fn list(&self) -> &'static [$crate::peers::config::Number] {
                const LIST: &[$crate::peers::config::Number] = &[$($crate::peers::config::Number {
                    name: concat!($table, ".", stringify!($field)),
                    low: $low,
                    high: $high,
                    search: numbers!(
                        @search concat!($table, ".", stringify!($field)),
                        $search $(($from, $to))?
                    ),
                }),+];
                LIST
            }

            fn value_mut(&mut self, place: usize) -> Option<&mut f64> {
                let values = [$(&mut self.$field),+];
                values.into_iter().nth(place)
            }
        }
    };
}
pub(super) use numbers;

numbers! {
    /// The short memory of what was seen, see [`super::surroundings`]. Common to all peers.
    MemoryConfig, "memory" {
        /// How far from the axis of a beam a point may lie to be replaced by its reading, in m.
        merge_m: 0.008, 0.0 to 1.0, given;
    }
}

numbers! {
    /// The last centimetres, see [`super::approach`]. Common to all peers.
    ApproachConfig, "approach" {
        /// Below this distance a target is near, in m.
        distance_m: 0.1, 0.0 to 10.0, given;
        /// What the way to it must leave free beside the body, in m.
        margin_m: 0.002, 0.0 to 1.0, given;
        /// Time constant of the speed in s.
        time_s: 0.35, 0.05 to 10.0, given;
    }
}

/// The numbers of all peers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PeerConfig {
    /// Short memory.
    pub memory: MemoryConfig,
    /// Final approach.
    pub approach: ApproachConfig,
    /// Artificial potential field.
    pub apf: super::apf::ApfConfig,
    /// VFH+.
    pub vfh: super::vfh::VfhConfig,
    /// Dynamic window approach.
    pub dwa: super::dwa::DwaConfig,
    /// Bug2.
    pub bug2: super::bug2::Bug2Config,
}

/// A number that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} = {value}: must be {must}")]
pub struct PeerConfigError {
    /// As in a file: `peers.apf.range_m`.
    pub name: String,
    /// What it is.
    pub value: f64,
    /// What it must be.
    pub must: String,
}

impl PeerConfig {
    fn groups(&mut self) -> [&mut dyn Numbers; 6] {
        let Self { memory, approach, apf, vfh, dwa, bug2 } = self;
        [memory, approach, apf, vfh, dwa, bug2]
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first that is out of its range, or no number.
    pub fn validate(&self) -> Result<(), PeerConfigError> {
        let mut copy = self.clone();
        for numbers in copy.groups() {
            for (place, number) in numbers.list().iter().enumerate() {
                let value = numbers.value_mut(place).map_or(f64::NAN, |value| *value);
                if !(number.low..=number.high).contains(&value) {
                    let must = format!("between {} and {}", number.low, number.high);
                    let name = format!("peers.{}", number.name);
                    return Err(PeerConfigError { name, value, must });
                }
            }
        }
        Ok(())
    }

    /// What a search may tune of a contender, by its names in a file below `[peers]`, and where to look. None for those
    /// that are no peers.
    #[must_use]
    pub fn searched(contender: Contender) -> Vec<Dimension> {
        let table = format!("{}.", contender.name());
        let mut config = Self::default();
        let numbers = config.groups().into_iter().flat_map(|numbers| numbers.list());
        numbers.filter_map(|number| number.search).filter(|number| number.name.starts_with(&table)).collect()
    }

    /// The number of this name (as in [`PeerConfig::searched`]), to read or to change; validate after a change.
    pub fn number_mut(&mut self, name: &str) -> Option<&mut f64> {
        self.groups().into_iter().find_map(|numbers| {
            let place = numbers.list().iter().position(|number| number.name == name)?;
            numbers.value_mut(place)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::PeerConfig;
    use crate::contender::Contender;

    #[test]
    fn defaults_are_valid_and_can_be_searched() {
        PeerConfig::default().validate().unwrap();
        for contender in Contender::ALL {
            let searched = PeerConfig::searched(contender);
            assert_eq!(searched.is_empty(), !contender.is_peer(), "{contender:?}");
            for range in searched {
                let name = range.name;
                let mut config = PeerConfig::default();
                for value in [range.low, range.high] {
                    *config.number_mut(name).unwrap() = value;
                    config.validate().unwrap_or_else(|error| panic!("{error}"));
                }
                *config.number_mut(name).unwrap() = f64::NAN;
                let error = config.validate().unwrap_err().to_string();
                assert!(error.starts_with(&format!("peers.{name} = NaN: must be between ")), "{error}");
            }
        }
    }
}
