//! Who drives: the two architectures of the papers, and the controllers that people use instead.

use clap::ValueEnum;
use controller_core::config::Architecture;
use serde::Serialize;

use crate::scenario::{ControllerKind, Scenario};

/// A controller that can be sent through a scenario. The names are those of the command line and of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Contender {
    /// Cooperative EKMs with neural integration (P2)
    Cooperative,
    /// Braitenberg avoidance with command fusion (P1)
    Fusion,
    /// Artificial potential field (Khatib 1986)
    #[serde(rename = "apf")]
    #[value(name = "apf")]
    PotentialField,
    /// Vector field histogram, VFH+ (Ulrich and Borenstein 1998)
    #[serde(rename = "vfh")]
    #[value(name = "vfh")]
    VfhPlus,
    /// Dynamic window approach (Fox, Burgard and Thrun 1997)
    #[serde(rename = "dwa")]
    #[value(name = "dwa")]
    DynamicWindow,
    /// Bug2 (Lumelsky and Stepanov 1987)
    #[serde(rename = "bug2")]
    #[value(name = "bug2")]
    Bug2,
}

impl Contender {
    /// All, those of the papers first.
    pub const ALL: [Self; 6] = [
        Self::Cooperative,
        Self::Fusion,
        Self::PotentialField,
        Self::VfhPlus,
        Self::DynamicWindow,
        Self::Bug2,
    ];
    /// Those of the papers, which drive with a learned map and run on boards.
    pub const PAPERS: [Self; 2] = [Self::Cooperative, Self::Fusion];

    /// The one that runs if the user does not say.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        match scenario.controller {
            ControllerKind::Cooperative => Self::Cooperative,
            ControllerKind::Fusion => Self::Fusion,
        }
    }

    /// The name on the command line and in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cooperative => "cooperative",
            Self::Fusion => "fusion",
            Self::PotentialField => "apf",
            Self::VfhPlus => "vfh",
            Self::DynamicWindow => "dwa",
            Self::Bug2 => "bug2",
        }
    }

    /// The core's architecture; `None` for a peer, which the core does not know.
    #[must_use]
    pub fn architecture(self) -> Option<Architecture> {
        match self {
            Self::Cooperative => Some(Architecture::Cooperative),
            Self::Fusion => Some(Architecture::Fusion),
            Self::PotentialField | Self::VfhPlus | Self::DynamicWindow | Self::Bug2 => None,
        }
    }

    /// Whether it is none of the papers': it needs no map, and is told the robot's measures instead.
    #[must_use]
    pub fn is_peer(self) -> bool {
        self.architecture().is_none()
    }
}

impl From<Architecture> for Contender {
    fn from(architecture: Architecture) -> Self {
        match architecture {
            Architecture::Cooperative => Self::Cooperative,
            Architecture::Fusion => Self::Fusion,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Contender;
    use clap::ValueEnum;

    #[test]
    fn command_line_files_and_texts_have_the_same_names() {
        for contender in Contender::ALL {
            let value = contender.to_possible_value().unwrap();
            assert_eq!(value.get_name(), contender.name());
            assert_eq!(serde_json::json!(contender), contender.name());
            assert_eq!(contender.is_peer(), !Contender::PAPERS.contains(&contender));
        }
        assert_eq!(Contender::value_variants(), Contender::ALL);
    }
}
