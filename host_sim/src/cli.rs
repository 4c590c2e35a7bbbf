//! The commands: what was asked for, one file for each command, and how results and errors leave the program.

mod args;
mod bench;
mod bench_worlds;
mod config;
mod error;
mod evaluate;
mod explain;
mod learning;
mod link;
mod linked;
mod main_job;
mod map;
mod output;
mod plan;
mod progress;
mod run;
mod scenarios;
mod search;
mod single_run;
mod sweep_run;
mod table;
mod train;

use std::process::ExitCode;

use clap::Parser;

use args::{Cli, Command};
use error::{CliError, Outcome};

/// Parses the arguments, does what they ask for, and says by the exit code what came of it.
pub fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help on stdout, errors on stderr; neither can be reported if it cannot be printed.
            let _ = error.print();
            return if error.use_stderr() { ExitCode::from(2) } else { ExitCode::SUCCESS };
        }
    };
    match dispatch(&cli) {
        Ok(Outcome::Ok) => ExitCode::SUCCESS,
        Ok(Outcome::RobotFailed) => ExitCode::from(1),
        Err(error) => {
            output::complain(&format!("error: {error}"));
            error.exit_code()
        }
    }
}

fn dispatch(cli: &Cli) -> Result<Outcome, CliError> {
    match &cli.command {
        None => main_job::main_job(&cli.main_job),
        Some(Command::Run(args)) => run::run(args),
        Some(Command::Train(args)) => train::train(args),
        Some(Command::Map(args)) => map::map(args),
        Some(Command::Evaluate(args)) => evaluate::evaluate(args),
        Some(Command::Explain(args)) => explain::explain(args),
        Some(Command::Scenarios(args)) => scenarios::scenarios(args),
        Some(Command::Plan(args)) => plan::plan(args),
        Some(Command::Link(args)) => link::link(args),
        Some(Command::Bench(args)) => bench::bench(args),
        Some(Command::Config(args)) => config::config(args),
        Some(Command::Search(args)) => search::search(args),
    }
}
