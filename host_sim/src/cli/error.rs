//! How a command ends.

use core::convert::Infallible;
use std::process::ExitCode;

use controller_core::config::ConfigError;
use host_sim::config_file::ConfigFileError;
use host_sim::explanation::ExplainError;
use host_sim::import::ImportError;
use host_sim::link::LinkError;
use host_sim::link::verify::VerifyError;
use host_sim::mission::MissionError;
use host_sim::route_planner::RouteError;
use host_sim::scenario::ScenarioError;
use host_sim::sweep::SweepError;

/// A command that did what it was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// And all is well.
    Ok,
    /// And the robot, or what was required of a file, is not as it should be: exit code 1.
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
    /// The board and the core in this process disagree: exit code 1, for that is what was asked.
    #[error("{0}")]
    Differs(String),
    /// The board, or the way to it: exit code 3.
    #[error("{0}")]
    Device(String),
}

impl CliError {
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Request(_) => ExitCode::from(2),
            Self::NoWay(_) | Self::Differs(_) => ExitCode::from(1),
            Self::Device(_) => ExitCode::from(3),
        }
    }
}

impl From<ScenarioError> for CliError {
    fn from(error: ScenarioError) -> Self {
        Self::Request(error.to_string())
    }
}

impl From<ImportError> for CliError {
    fn from(error: ImportError) -> Self {
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
            SweepError::Peers(error) => Self::Request(format!("{error}; correct it in the file of --config")),
            SweepError::Mission(error) => error.into(),
        }
    }
}

impl From<ExplainError> for CliError {
    fn from(error: ExplainError) -> Self {
        match error {
            ExplainError::Run(error) => error.into(),
            error @ ExplainError::Over { .. } => Self::Request(error.to_string()),
        }
    }
}

impl<E: core::error::Error + Into<Self>> From<MissionError<E>> for CliError {
    fn from(error: MissionError<E>) -> Self {
        match error {
            MissionError::Route(error) => error.into(),
            MissionError::Port(error) => error.into(),
            error @ MissionError::Checkpoints(_) => {
                Self::Request(format!("{error}; change the scenario's checkpoints"))
            }
        }
    }
}

impl From<Infallible> for CliError {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl From<LinkError> for CliError {
    fn from(error: LinkError) -> Self {
        Self::Device(error.to_string())
    }
}

impl From<VerifyError<LinkError>> for CliError {
    fn from(error: VerifyError<LinkError>) -> Self {
        match error {
            VerifyError::Port(error) => error.into(),
            VerifyError::Differs { .. } | VerifyError::Answers { .. } => Self::Differs(error.to_string()),
        }
    }
}
