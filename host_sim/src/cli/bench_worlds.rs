//! `bench barn`, `bench movingai`, `bench map`: the robot on worlds that others drew.

mod args;
mod barn;
mod drive;
mod maps;
mod plans;
mod report;

pub use args::BenchWorlds;

use super::error::{CliError, Outcome};

pub fn bench(worlds: &BenchWorlds) -> Result<Outcome, CliError> {
    match worlds {
        BenchWorlds::Barn(args) => barn::barn(args),
        BenchWorlds::MovingAi(args) => maps::moving_ai(args),
        BenchWorlds::Map(args) => maps::ros_map(args),
    }
}
