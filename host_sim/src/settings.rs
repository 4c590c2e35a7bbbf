//! All numbers of all contenders: what a file for `--config` can hold.

use controller_core::config::Config;

use crate::peers::config::PeerConfig;

/// The core's configuration and its peers'.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Settings {
    /// Robot, schedule, and the two architectures of the papers.
    pub core: Config,
    /// The peers, see [`crate::peers`].
    pub peers: PeerConfig,
}

impl From<Config> for Settings {
    fn from(core: Config) -> Self {
        Self { core, peers: PeerConfig::default() }
    }
}
