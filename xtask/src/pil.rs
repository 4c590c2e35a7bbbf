//! `cargo xtask pil`: the tests that run the firmware in the emulator (processor in the loop).

use std::path::Path;

use crate::command;
use crate::doctor;
use crate::firmware::{self, BOARDS};

/// Builds the images and runs the tests that need them; `long` adds those that take minutes.
pub fn run(root: &Path, long: bool) -> Result<(), String> {
    if let Some(complaint) = doctor::missing_qemu() {
        return Err(complaint);
    }
    firmware::build(root, &BOARDS, &["firmware"])?;
    let mut arguments =
        vec!["test", "-p", "tests", "--test", "pil", "--", "--ignored", "--nocapture", "--test-threads", "1"];
    if !long {
        arguments.extend(["--skip", "long_"]);
    }
    command::run(root, &command::cargo(), &arguments, &[])
}
