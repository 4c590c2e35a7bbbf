//! `cargo xtask pil`: the tests that run the firmware in the emulator (processor in the loop).

use std::fs;
use std::path::Path;

use crate::command;
use crate::doctor;
use crate::firmware::{self, BOARDS, Board};

/// Seed of the maps in flash; the tests need not know it.
const SEED: &str = "9101";

/// Puts a map and the board's image with it where the tests look for them: `BOARD.ekm` and `BOARD` in the folder `pil`
/// of the target folder. The image without a map is to be built afterwards, so that this one stays in nobody's way.
fn with_map(root: &Path, board: Board) -> Result<(), String> {
    let folder = command::target_folder(root).join("pil");
    let map = folder.join(board.name).with_extension("ekm");
    let file = map.to_string_lossy();
    let train = ["run", "--release", "--quiet", "-p", "host_sim", "--", "train"];
    let options = ["--steps", "1000", "--seed", SEED, "--scalar", board.scalar, "--out", &file];
    command::run(root, &command::cargo(), &[&train[..], &options].concat(), &[])?;
    firmware::build(root, &[board], &["firmware"], Some(&map))?;
    let image = board.image(root, "firmware");
    fs::copy(&image, folder.join(board.name))
        .map_err(|error| format!("{}: cannot be copied ({error})", image.display()))?;
    Ok(())
}

/// Builds the images and runs the tests that need them; `long` adds those that take minutes.
pub fn run(root: &Path, long: bool) -> Result<(), String> {
    if let Some(complaint) = doctor::missing_qemu() {
        return Err(complaint);
    }
    for board in BOARDS {
        with_map(root, board)?;
    }
    firmware::build(root, &BOARDS, &["firmware"], None)?;
    let mut arguments =
        vec!["test", "-p", "tests", "--test", "pil", "--", "--ignored", "--nocapture", "--test-threads", "1"];
    if !long {
        arguments.extend(["--skip", "long_"]);
    }
    command::run(root, &command::cargo(), &arguments, &[])
}
