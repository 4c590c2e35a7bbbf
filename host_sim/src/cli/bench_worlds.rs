//! `bench barn`, `bench movingai`, `bench map`: the robot on worlds that others drew.

mod args;
mod barn;
mod drive;
mod report;

pub use args::BenchWorlds;

use super::error::{CliError, Outcome};

pub fn bench(worlds: &BenchWorlds) -> Result<Outcome, CliError> {
    match worlds {
        BenchWorlds::Barn(args) => barn::barn(args),
    }
}
