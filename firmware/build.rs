//! Chooses the board by the target, lays out its memory, puts a learned map into it, and notes the build.
//!
//! Linker arguments stand here and not in a `.cargo/config.toml`, so that the image can be built from any directory,
//! and so that changing them does not build `core`'s dependants anew.

use core::error::Error;
use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use protocol::message::ScalarKind;

mod build_map;

/// A board as the linker sees it.
struct Board {
    name: &'static str,
    target: &'static str,
    /// What its controller computes with, as `board.rs` says.
    scalar: ScalarKind,
    /// Regions: name, origin, bytes. The register crates' interrupt vectors stand at the start of FLASH.
    flash: (u32, u32),
    ram: (u32, u32),
    /// Bytes of the RAM, from its start on, that are the stack's; the variables lie above. A stack that grows beyond
    /// them leaves the RAM, which is a fault and stops the motors, instead of overwriting variables.
    stack_bytes: u32,
}

const BOARDS: [Board; 2] = [
    Board {
        name: "stm32f405",
        target: "thumbv7em-none-eabihf",
        scalar: ScalarKind::F32,
        flash: (0x0800_0000, 1024 * 1024),
        // SRAM1 and SRAM2, adjacent. The core-coupled memory stays free.
        ram: (0x2000_0000, 128 * 1024),
        stack_bytes: 64 * 1024,
    },
    Board {
        name: "stm32f100",
        target: "thumbv7m-none-eabi",
        scalar: ScalarKind::Fixed,
        flash: (0x0800_0000, 128 * 1024),
        ram: (0x2000_0000, 8 * 1024),
        // All that the variables leave.
        stack_bytes: 2048,
    },
];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(board, values(\"stm32f405\", \"stm32f100\"))");
    let target = env::var("TARGET")?;
    let Some(board) = BOARDS.iter().find(|board| board.target == target) else {
        let known = BOARDS.map(|board| format!("--target {} ({})", board.target, board.name)).join(" or ");
        return Err(format!("there is no board with target {target}: build the firmware with {known}").into());
    };
    println!("cargo:rustc-cfg=board=\"{}\"", board.name);

    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR")?);
    put_map(board, &out)?;
    let ((flash, flash_bytes), (ram, ram_bytes)) = (board.flash, board.ram);
    let memory = |ram: u32, ram_bytes: u32| {
        format!(
            "MEMORY\n{{\n  FLASH : ORIGIN = {flash:#010x}, LENGTH = {flash_bytes}\n  \
             RAM : ORIGIN = {ram:#010x}, LENGTH = {ram_bytes}\n}}\n"
        )
    };
    let stack_top = ram + board.stack_bytes;
    let firmware = format!(
        "{}_stack_start = {stack_top:#010x};\n_stack_end = {ram:#010x};\n",
        memory(stack_top, ram_bytes - board.stack_bytes)
    );
    for (program, memory) in [("firmware", firmware), ("instructions", memory(ram, ram_bytes))] {
        let folder = out.join(program);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join("memory.x"), memory)?;
        println!("cargo:rustc-link-arg-bin={program}=-L{}", folder.display());
    }
    // Vectors and sections, the log's table, and no padding of segments to pages the chip does not have.
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    // This one runs on a machine with 128 KiB whichever the board is, and keeps more than the board's RAM holds.
    println!("cargo:rustc-link-arg-bin=instructions=--defsym=_stack_start=0x20010000");
    println!("cargo:rustc-env=EKM_BUILD_ID={}", build_id());
    // Without it defmt leaves out all lines but errors.
    println!("cargo:rerun-if-env-changed=DEFMT_LOG");
    println!("cargo:rustc-env=DEFMT_LOG={}", env::var("DEFMT_LOG").unwrap_or_else(|_| "info".to_owned()));
    Ok(())
}

/// Makes the table of the map that the variable `EKM_NAV_MAP` names; a relative path begins at the root of the
/// repository.
fn put_map(board: &Board, out: &Path) -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build_map.rs");
    println!("cargo:rerun-if-env-changed=EKM_NAV_MAP");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    let file = env::var_os("EKM_NAV_MAP").filter(|name| !name.is_empty()).map(|name| root.join(name));
    if let Some(file) = &file {
        println!("cargo:rerun-if-changed={}", file.display());
    }
    match build_map::source(file.as_deref(), board.scalar) {
        Ok(text) => fs::write(out.join("flash_map.rs"), text)?,
        // Cargo shows it as an error of its own, and fails.
        Err(message) => println!("cargo::error=EKM_NAV_MAP: {message}"),
    }
    Ok(())
}

/// What the board says it is: the variable `EKM_BUILD_ID` where it is set, else the commit, else "unknown".
fn build_id() -> String {
    println!("cargo:rerun-if-env-changed=EKM_BUILD_ID");
    if let Ok(given) = env::var("EKM_BUILD_ID") {
        return given;
    }
    let git = |arguments: &[&str]| {
        let output =
            Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned())
    };
    // HEAD's log gets a line with each commit and each change of branch.
    if let Some(log) = git(&["rev-parse", "--path-format=absolute", "--git-path", "logs/HEAD"]) {
        println!("cargo:rerun-if-changed={log}");
    }
    git(&["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown".to_owned())
}
