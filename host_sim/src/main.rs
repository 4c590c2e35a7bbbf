//! `host_sim`, the simulator's command line: learns maps, runs the papers' experiments, prints what came of them.
//!
//! Results go to stdout, progress and errors to stderr. Exit codes: 0 ok, 1 the robot or a check failed, 2 the
//! request cannot be carried out (and nothing was written), 3 the board or the way to it failed.
#![forbid(unsafe_code)]

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
