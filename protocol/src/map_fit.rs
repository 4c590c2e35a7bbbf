//! Whether a stored map is one for this controller: its lattice, its scalar, and the robot it was learned on.
//!
//! The map's numbers are ratios: distances in units of the reach, commands in units of the top speed c*. What they mean
//! in the world also depends on the wheel base, which says how far two wheel speeds turn the body. A map with other
//! values of these three drives another robot than it learned, and is refused. Body radius and encoder do not count:
//! neither changes what a command does.

use core::fmt;

use controller_core::config::Config;
use controller_core::kohonen::features::Scaling;

use crate::map_file::{MapHeader, Robot};
use crate::message::{COLUMNS, ROWS, ScalarKind};

/// How far the wheel bases of map and configuration may be apart, as a share: what rounding on the way from
/// millimetres or inches may bring about, and no measurement.
const WHEEL_BASE_SHARE: f32 = 1e-5;

/// What does not fit. As text it is what was found and what was expected, without the remedy, which differs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Misfit {
    /// Another lattice.
    Lattice {
        /// The map's columns.
        columns: u8,
        /// The map's rows.
        rows: u8,
    },
    /// Learned with the other scalar.
    Scalar {
        /// The map's.
        found: ScalarKind,
        /// The controller's.
        expected: ScalarKind,
    },
    /// Learned on another robot: the weights would mean other distances, speeds or turns.
    Robot {
        /// Which number.
        name: &'static str,
        /// The map's.
        found: f32,
        /// The configuration's.
        expected: f32,
    },
}

impl Robot {
    /// The robot of a configuration.
    #[must_use]
    pub const fn of(config: &Config) -> Self {
        let robot = &config.robot;
        Self {
            wheel_base_m: robot.wheel_base_m,
            body_radius_m: robot.body_radius_m,
            encoder_counts_per_m: robot.encoder_counts_per_m,
        }
    }
}

/// The two units of a map's numbers: the reach in m, and the top speed in m/s.
#[must_use]
pub fn units(config: &Config) -> (f32, f32) {
    let speed = config.robot.speed_limit_mps;
    let step_s = f32::from(config.schedule.step_ms) / 1000.0;
    (Scaling::<f32>::new(speed, step_s).reach_m(), speed)
}

impl MapHeader {
    /// Whether the map is one for a controller of this scalar and configuration.
    ///
    /// # Errors
    /// The first thing that does not fit; the robot is looked at last, so that [`Misfit::Robot`] says that the rest
    /// does.
    pub fn check_fit(&self, scalar: ScalarKind, config: &Config) -> Result<(), Misfit> {
        if (usize::from(self.columns), usize::from(self.rows)) != (COLUMNS, ROWS) {
            return Err(Misfit::Lattice { columns: self.columns, rows: self.rows });
        }
        if self.scalar != scalar {
            return Err(Misfit::Scalar { found: self.scalar, expected: scalar });
        }
        let (reach_m, speed_limit_mps) = units(config);
        // Bit for bit: the file holds the very number, not a measurement, and the weights are divided by it.
        let same = |found: f32, expected: f32| found.to_bits() == expected.to_bits();
        let near = |found: f32, expected: f32| (found - expected).abs() <= expected * WHEEL_BASE_SHARE;
        let wheel_base_m = config.robot.wheel_base_m;
        let robot = |name, found, expected, fits: bool| {
            if fits { Ok(()) } else { Err(Misfit::Robot { name, found, expected }) }
        };
        let found = (self.speed_limit_mps, self.reach_m, self.robot.wheel_base_m);
        robot("robot.speed_limit_mps", found.0, speed_limit_mps, same(found.0, speed_limit_mps))?;
        robot("the reach of a step in m", found.1, reach_m, same(found.1, reach_m))?;
        robot("robot.wheel_base_m", found.2, wheel_base_m, near(found.2, wheel_base_m))
    }
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Lattice { columns, rows } => write!(
                f,
                "has a lattice of {columns} × {rows} neurons, the controller one of {COLUMNS} × {ROWS}"
            ),
            Self::Scalar { found, expected } => {
                write!(f, "was learned with scalar {}, not {}", found.name(), expected.name())
            }
            Self::Robot { name, found, expected } => {
                write!(f, "was learned with {name} = {found}, the configuration has {expected}")
            }
        }
    }
}

impl core::error::Error for Misfit {}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::{Misfit, units};
    use crate::map_file::{FORMAT_VERSION, MapHeader, Provenance, Robot};
    use crate::message::ScalarKind;
    use controller_core::config::Config;
    use heapless::String;
    use std::string::ToString;

    fn header(config: &Config) -> MapHeader {
        let (reach_m, speed_limit_mps) = units(config);
        MapHeader {
            format_version: FORMAT_VERSION,
            scalar: ScalarKind::F32,
            columns: 15,
            rows: 15,
            reach_m,
            speed_limit_mps,
            robot: Robot::of(config),
            provenance: Provenance {
                seed: 1,
                steps: 2,
                horizon_ms: 3,
                config_digest: 4,
                core_version: String::new(),
                commit: String::new(),
            },
        }
    }

    /// What a map of a changed robot does not fit in the default one.
    fn misfit(change: impl FnOnce(&mut Config)) -> Result<(), Misfit> {
        let mut config = Config::default();
        change(&mut config);
        header(&config).check_fit(ScalarKind::F32, &Config::default())
    }

    #[test]
    fn a_map_of_this_robot_fits() {
        assert_eq!(misfit(|_| ()), Ok(()));
    }

    #[test]
    fn what_changes_the_meaning_of_the_numbers_is_refused_and_named() {
        let text = |change: fn(&mut Config)| misfit(change).unwrap_err().to_string();
        let speed = text(|config| config.robot.speed_limit_mps = 0.2);
        assert_eq!(speed, "was learned with robot.speed_limit_mps = 0.2, the configuration has 0.16");
        assert!(text(|config| config.schedule.step_ms = 512).contains("the reach of a step in m = 0.08192"));
        let base = text(|config| config.robot.wheel_base_m = 0.0531);
        assert_eq!(base, "was learned with robot.wheel_base_m = 0.0531, the configuration has 0.053");
    }

    #[test]
    fn neither_rounding_nor_what_does_not_matter_is_refused() {
        assert_eq!(misfit(|config| config.robot.wheel_base_m = 0.053_f32.next_up().next_up()), Ok(()));
        assert_eq!(misfit(|config| config.robot.body_radius_m = 0.03), Ok(()));
        assert_eq!(misfit(|config| config.robot.encoder_counts_per_m = 9000.0), Ok(()));
    }

    #[test]
    fn the_robot_is_looked_at_last() {
        let mut other = Config::default();
        other.robot.wheel_base_m = 0.1;
        let fixed = MapHeader { scalar: ScalarKind::Fixed, ..header(&other) };
        let scalar = fixed.check_fit(ScalarKind::F32, &Config::default()).unwrap_err();
        assert_eq!(scalar.to_string(), "was learned with scalar fixed, not f32");
        let lattice = MapHeader { columns: 9, ..fixed }.check_fit(ScalarKind::F32, &other).unwrap_err();
        assert_eq!(lattice, Misfit::Lattice { columns: 9, rows: 15 });
        assert!(lattice.to_string().contains("9 × 15 neurons, the controller one of 15 × 15"));
    }
}
