//! `cargo xtask`: the one helper of the repository. It checks what CI checks, and says what must be installed.
//!
//! * [`cli`]: what was asked for
//! * [`doctor`]: what is present, what is missing, how to get it
//! * [`checks`]: `cargo xtask test`, step by step
//! * [`firmware`]: the images for the boards; [`image`] reads their sizes
//! * [`pil`]: the firmware's tests in the emulator
//! * [`budget`]: what the firmware takes, against what it may take
//! * [`tidy`]: the repository's own rules about its files
//!
//! It has few dependencies, since it is built before anything else is checked.

use std::env;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

mod budget;
mod checks;
mod cli;
mod command;
mod doctor;
mod firmware;
mod image;
mod pil;
mod tidy;

/// A check failed.
const FAILED: u8 = 1;
/// The command line makes no sense.
const USAGE: u8 = 2;

fn main() -> ExitCode {
    let arguments: Vec<String> =
        env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()).collect();
    let asked = match cli::parse(&arguments) {
        Ok(asked) => asked,
        Err(message) => {
            eprintln!("error: {message}");
            return ExitCode::from(USAGE);
        }
    };
    let (text, passed) = match asked {
        cli::Asked::Help(text) => (text.to_owned(), true),
        cli::Asked::Test { quick } => (String::new(), checks::run(&root(), quick)),
        cli::Asked::Doctor => doctor::report(),
        cli::Asked::Firmware { board, map } => {
            let boards = board.map_or_else(|| firmware::BOARDS.to_vec(), |board| vec![board]);
            told(firmware::build_and_tell(&root(), &boards, map.as_deref()))
        }
        cli::Asked::Flash { board, map } => told(firmware::flash(&root(), board, map.as_deref())),
        cli::Asked::Pil { long } => told(pil::run(&root(), long)),
        cli::Asked::Budget => told(budget::run(&root())),
    };
    // Where nobody reads on (`| head`), there is nobody to tell.
    let _ = io::stdout().write_all(text.as_bytes());
    if passed { ExitCode::SUCCESS } else { ExitCode::from(FAILED) }
}

/// An error is told where errors go.
fn told(result: Result<(), String>) -> (String, bool) {
    if let Err(message) = &result {
        eprintln!("error: {message}");
    }
    (String::new(), result.is_ok())
}

/// The repository: the folder above this crate's. Cargo says where that is now; the compiler, where it was.
fn root() -> PathBuf {
    let here =
        env::var_os("CARGO_MANIFEST_DIR").map_or_else(|| env!("CARGO_MANIFEST_DIR").into(), PathBuf::from);
    here.parent().map_or_else(|| here.clone(), PathBuf::from)
}
