//! How a command ends.

use std::process::ExitCode;

use controller_core::config::ConfigError;
use host_sim::config_file::ConfigFileError;
use host_sim::mission::MissionError;
use host_sim::route_planner::RouteError;
use host_sim::scenario::ScenarioError;
use host_sim::sweep::SweepError;

/// A command that did what it was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// And all is well.
    Ok,
    /// And the robot did not do what it should: exit code 1.
    RobotFailed,
}

/// A command that could not.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The request cannot be carried out as it stands: exit code 2. The text says what to do.
    #[error("{0}")]
    Request(String),
    /// There is no way to the goal: exit code 1, for that is an answer.
    #[error("{0}; move the goal, or remove or widen known walls in the scenario")]
    NoWay(RouteError),
}

impl CliError {
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Request(_) => ExitCode::from(2),
            Self::NoWay(_) => ExitCode::from(1),
        }
    }
}

impl From<ScenarioError> for CliError {
    fn from(error: ScenarioError) -> Self {
        Self::Request(error.to_string())
    }
}

impl From<ConfigFileError> for CliError {
    fn from(error: ConfigFileError) -> Self {
        Self::Request(error.to_string())
    }
}

impl From<ConfigError> for CliError {
    fn from(error: ConfigError) -> Self {
        Self::Request(format!("{error}; correct it in the file of --config"))
    }
}

impl From<RouteError> for CliError {
    fn from(error: RouteError) -> Self {
        match error {
            RouteError::Plan(_) => Self::NoWay(error),
            RouteError::Map(_) => Self::Request(format!("{error}; add [[walls]] to the scenario")),
        }
    }
}

impl From<SweepError> for CliError {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Config(error) => error.into(),
            SweepError::Mission(MissionError::Route(error)) => error.into(),
            SweepError::Mission(error @ MissionError::Checkpoints(_)) => {
                Self::Request(format!("{error}; change the scenario's checkpoints"))
            }
        }
    }
}
