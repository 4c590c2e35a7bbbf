//! The firmware images: building them, and putting them on a board.

use std::path::{self, Path, PathBuf};

use crate::command;
use crate::doctor;
use crate::image::Image;

/// A board as this repository builds for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board {
    /// As people write it, and as it calls itself on the link.
    pub name: &'static str,
    /// Of the compiler.
    pub target: &'static str,
    /// As `probe-rs` calls the chip.
    pub chip: &'static str,
    /// What its controller computes with, as the simulator takes it.
    pub scalar: &'static str,
}

/// All of them.
pub const BOARDS: [Board; 2] = [
    Board { name: "stm32f405", target: doctor::TARGETS[0], chip: "STM32F405RG", scalar: "f32" },
    Board { name: "stm32f100", target: doctor::TARGETS[1], chip: "STM32F100RB", scalar: "fixed" },
];

/// Optimised for size, with one unit of code; see the root `Cargo.toml`.
const PROFILE: &str = "firmware";

impl Board {
    /// The board of this name.
    pub fn named(name: &str) -> Option<Self> {
        BOARDS.into_iter().find(|board| board.name == name)
    }

    /// Where cargo puts the program `program` built for this board.
    pub fn image(self, root: &Path, program: &str) -> PathBuf {
        command::target_folder(root).join(self.target).join(PROFILE).join(program)
    }
}

/// Builds the programs of the firmware (`firmware`, `instructions`) for these boards, with a learned map if one is
/// named.
pub fn build(root: &Path, boards: &[Board], programs: &[&str], map: Option<&Path>) -> Result<(), String> {
    let missing = doctor::missing_targets();
    if !missing.is_empty() {
        return Err(missing.join("\n"));
    }
    let mut arguments = vec!["build", "--profile", PROFILE, "-p", "firmware"];
    for board in boards {
        arguments.extend(["--target", board.target]);
    }
    for program in programs {
        arguments.extend(["--bin", program]);
    }
    let Some(map) = map else {
        return command::run(root, &command::cargo(), &arguments, &[]);
    };
    // From here, where the user is; cargo builds elsewhere.
    let map = path::absolute(map).map_err(|error| format!("{}: {error}", map.display()))?;
    command::run(root, &command::cargo(), &arguments, &[("EKM_NAV_MAP", &map.to_string_lossy())])
}

/// `cargo xtask firmware`: builds, and says where the images are and what they take.
pub fn build_and_tell(root: &Path, boards: &[Board], map: Option<&Path>) -> Result<(), String> {
    build(root, boards, &["firmware"], map)?;
    let with_map = map.map_or_else(String::new, |map| format!(", with the map {}", map.display()));
    for board in boards {
        let path = board.image(root, "firmware");
        let image = Image::read(&path)?;
        println!(
            "{}: {} bytes of flash, {} bytes of RAM before the stack{with_map}: {}",
            board.name,
            image.flash_bytes,
            image.static_ram_bytes,
            path.display()
        );
    }
    Ok(())
}

/// `cargo xtask flash`: puts the image on a board that is connected through a debug probe, and shows its log.
pub fn flash(root: &Path, board: Board, map: Option<&Path>) -> Result<(), String> {
    build(root, &[board], &["firmware"], map)?;
    if command::output("probe-rs", &["--version"]).is_none() {
        return Err(
            "probe-rs is missing: `cargo install probe-rs-tools --locked`, see https://probe.rs".to_owned()
        );
    }
    let image = board.image(root, "firmware");
    let arguments = ["run", "--chip", board.chip, &image.to_string_lossy()];
    command::run(root, &"probe-rs".into(), &arguments, &[])
}
