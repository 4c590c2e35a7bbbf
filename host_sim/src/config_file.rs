//! The controller's configuration as a TOML file: any number that is not in the file is as in a base, the simulator's
//! default or that of boards.
//!
//! The numbers of the peers are in it as well, in the table `[peers]`. Some files are built in, and go by
//! their names: `configs/*.toml` of this crate.

use std::path::Path;

use controller_core::config::{
    Architecture, Config, ConfigError, CooperativeConfig, FusionConfig, LearningConfig, ReachingConfig,
    RobotConfig, SafetyConfig, ScheduleConfig, ServoConfig,
};
use serde::{Deserialize, Serialize};

use crate::peers::config::{PeerConfig, PeerConfigError};
use crate::scenario::{ScenarioError, toml_document};
use crate::settings::Settings;

/// The configurations that are part of the program: name and text.
pub const BUILTIN: [(&str, &str); 5] = [
    ("precise", include_str!("../configs/precise.toml")),
    ("p1", include_str!("../configs/p1.toml")),
    ("literal", include_str!("../configs/literal.toml")),
    ("large", include_str!("../configs/large.toml")),
    ("boards", include_str!("../configs/boards.toml")),
];

/// Why a file is not a configuration.
#[derive(Debug, thiserror::Error)]
pub enum ConfigFileError {
    /// It cannot be read.
    #[error(
        "{file}: cannot be read ({source}); `config --print` writes a file to begin with, and `precise`, `p1`, \
         `literal`, `large` and `boards` are built in"
    )]
    Unreadable {
        /// Path as given.
        file: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Not TOML, an unknown key, or a value of the wrong kind; said as for scenarios.
    #[error(transparent)]
    Document(#[from] ScenarioError),
    /// A number that cannot be used.
    #[error("{file}: {error}; change it, or leave the key out for the default")]
    Value {
        /// Path as given.
        file: String,
        /// Key, value, and what it must be.
        error: ConfigError,
    },
    /// A number of the peers that cannot be used.
    #[error("{file}: {error}; change it, or leave the key out for the default")]
    PeerValue {
        /// Path as given.
        file: String,
        /// Key, value, and what it must be.
        error: PeerConfigError,
    },
}

/// What a file holds: the groups of [`Config`], and the peers.
///
/// Written out, since serde cannot say where in a file an unknown key stands once it has taken two structs apart.
#[derive(Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
struct File {
    architecture: Architecture,
    robot: RobotConfig,
    servo: ServoConfig,
    schedule: ScheduleConfig,
    learning: LearningConfig,
    reaching: ReachingConfig,
    cooperative: CooperativeConfig,
    fusion: FusionConfig,
    safety: SafetyConfig,
    peers: PeerConfig,
}

impl Default for File {
    fn default() -> Self {
        Settings::default().into()
    }
}

impl From<Settings> for File {
    fn from(settings: Settings) -> Self {
        let Settings { core, peers } = settings;
        let Config { architecture, robot, servo, schedule, learning, reaching, cooperative, fusion, safety } =
            core;
        Self { architecture, robot, servo, schedule, learning, reaching, cooperative, fusion, safety, peers }
    }
}

impl From<File> for Settings {
    fn from(file: File) -> Self {
        let File {
            architecture,
            robot,
            servo,
            schedule,
            learning,
            reaching,
            cooperative,
            fusion,
            safety,
            peers,
        } = file;
        let core =
            Config { architecture, robot, servo, schedule, learning, reaching, cooperative, fusion, safety };
        Self { core, peers }
    }
}

/// Reads and checks a file, or what is built in under this name; what it leaves out is as in the simulator's default.
///
/// # Errors
/// What is wrong, where, and what to do.
pub fn load(path: &Path) -> Result<Settings, ConfigFileError> {
    load_over(&Settings::default(), path)
}

/// As [`load`], with another base.
///
/// # Errors
/// As [`load`].
pub fn load_over(base: &Settings, path: &Path) -> Result<Settings, ConfigFileError> {
    let file = path.display().to_string();
    if let Some((_, text)) = BUILTIN.iter().find(|(name, _)| *name == file) {
        return parse_over(base, &format!("{file} (built in)"), text);
    }
    let unreadable = |source| ConfigFileError::Unreadable { file: file.clone(), source };
    let text = std::fs::read_to_string(path).map_err(unreadable)?;
    parse_over(base, &file, &text)
}

/// Reads and checks a text; `file` is what errors call it.
///
/// # Errors
/// As [`load`].
pub fn parse(file: &str, text: &str) -> Result<Settings, ConfigFileError> {
    parse_over(&Settings::default(), file, text)
}

fn parse_over(base: &Settings, file: &str, text: &str) -> Result<Settings, ConfigFileError> {
    // First by itself, for errors that say where; what it leaves out is then another's default.
    let alone: File = toml_document(file, text)?;
    let settings: Settings = over(base, text).unwrap_or(alone).into();
    let file = || file.to_owned();
    settings.core.validate().map_err(|error| ConfigFileError::Value { file: file(), error })?;
    settings.peers.validate().map_err(|error| ConfigFileError::PeerValue { file: file(), error })?;
    Ok(settings)
}

/// A text that is a [`File`] by itself, which makes it one over any base.
fn over(base: &Settings, text: &str) -> Option<File> {
    let mut merged = toml::Table::try_from(File::from(base.clone())).ok()?;
    put_over(&mut merged, toml::from_str(text).ok()?);
    merged.try_into().ok()
}

fn put_over(base: &mut toml::Table, given: toml::Table) {
    for (key, value) in given {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(base)), toml::Value::Table(given)) => put_over(base, given),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// A configuration as a file that [`parse`] reads back.
///
/// # Errors
/// Never for a valid configuration: TOML has all its types.
pub fn to_toml(settings: &Settings) -> Result<String, toml::ser::Error> {
    toml::to_string_pretty(&File::from(settings.clone()))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{load, parse, parse_over, to_toml};
    use crate::settings::Settings;

    #[test]
    fn the_default_survives_the_way_through_a_file() {
        let text = to_toml(&Settings::default()).unwrap();
        assert_eq!(parse("default.toml", &text).unwrap(), Settings::default());
        assert_eq!(parse("empty.toml", "").unwrap(), Settings::default());
        assert!(
            text.contains("speed_limit_mps = 0.16\n"),
            "floats are printed as people write them:\n{text}"
        );
    }

    #[test]
    fn what_a_file_leaves_out_is_as_in_its_base() {
        let partial = "[cooperative]\nmemory_ms = 250\n[peers.apf]\nrange_m = 0.2\n";
        for base in [Settings::default(), Settings::of_boards()] {
            let mut expected = base.clone();
            expected.core.cooperative.memory_ms = 250;
            expected.peers.apf.range_m = 0.2;
            assert_eq!(parse_over(&base, "partial.toml", partial).unwrap(), expected);
        }
        assert_eq!(load(Path::new("boards")).unwrap(), Settings::of_boards());
        assert!(Settings::of_boards().core.check_without_movers().is_ok());
        assert!(Settings::default().core.check_without_movers().is_err());
    }

    #[test]
    fn errors_name_file_key_value_and_fix() {
        let error = |text: &str| parse("my.toml", text).unwrap_err().to_string();
        let unknown = error("[servo]\nstall_shore = 0.3\n");
        assert!(
            unknown.contains("my.toml:2:1") && unknown.contains("did you mean `stall_share`"),
            "{unknown}"
        );
        let value = error("[servo]\nstall_share = 1.5\n");
        assert!(
            value.starts_with("my.toml: servo.stall_share = 1.5: must be between 0 and 1; change"),
            "{value}"
        );
        let peer = error("[peers.apf]\nrange_m = -1\n");
        let text = "my.toml: peers.apf.range_m = -1: must be between 0.001 and 20; change it";
        assert!(peer.starts_with(text), "{peer}");
        let unknown = error("[peers.apf]\nrang_m = 1\n");
        assert!(unknown.contains("my.toml:2:1") && unknown.contains("did you mean `range_m`"), "{unknown}");
        let kind = error("[servo]\nstall_share = \"much\"\n");
        assert!(kind.contains("servo.stall_share"), "{kind}");
    }
}
