//! All numbers of all contenders: what a file for `--config` can hold.

use controller_core::config::Config;

use crate::peers::config::PeerConfig;

/// Headway to what moves in the simulator (s), where it is followed.
const MOVER_HEADWAY_S: f32 = 0.6;
/// And the share of the top speed that the robot cruises at then: it gives way in time.
const CRUISE_SHARE: f32 = 0.75;

/// The core's configuration and its peers'.
///
/// The default is the simulator's, which follows what moves; boards do not ([`Settings::of_boards`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Robot, schedule, and the two architectures of the papers.
    pub core: Config,
    /// The peers, see [`crate::peers`].
    pub peers: PeerConfig,
}

impl Settings {
    /// What boards do by default, the core's own: nothing that moves is followed, for that they have neither the memory
    /// nor the flash.
    #[must_use]
    pub fn of_boards() -> Self {
        Config::default().into()
    }
}

impl Default for Settings {
    fn default() -> Self {
        let mut settings = Self::of_boards();
        settings.core.cooperative.mover_headway_s = MOVER_HEADWAY_S;
        settings.core.cooperative.cruise_share = CRUISE_SHARE;
        settings
    }
}

impl From<Config> for Settings {
    fn from(core: Config) -> Self {
        Self { core, peers: PeerConfig::default() }
    }
}
