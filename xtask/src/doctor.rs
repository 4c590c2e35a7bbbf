//! What must be installed to build and check this repository: what is there, what is missing, how to get it.
//!
//! `rust-toolchain.toml` lists components, yet rustup may be told not to install on its own (`RUSTUP_AUTO_INSTALL=0`)
//! and then ignores the list without a word. So `cargo xtask test` asks rustup by name, asks Debian's packages for the
//! emulator where it may, and looks again.

use std::ffi::OsString;
use std::fs;
use std::path::Path;

use crate::command;

/// The targets of the two boards.
pub const TARGETS: [&str; 2] = ["thumbv7em-none-eabihf", "thumbv7m-none-eabi"];

/// Something that must be there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Need {
    /// The compiler itself.
    Compiler,
    /// A cargo subcommand that rustup has as a component.
    Component(&'static str),
    /// The standard library of a target.
    Target(&'static str),
    /// The emulator of the boards.
    Qemu,
}

/// What runs the firmware images where there is no board.
pub const QEMU: &str = "qemu-system-arm";

const NEEDS: [Need; 6] = [
    Need::Compiler,
    Need::Component("clippy"),
    Need::Component("rustfmt"),
    Need::Target(TARGETS[0]),
    Need::Target(TARGETS[1]),
    Need::Qemu,
];

impl Need {
    fn name(self) -> &'static str {
        match self {
            Self::Compiler => "rustc",
            Self::Component(name) | Self::Target(name) => name,
            Self::Qemu => QEMU,
        }
    }

    /// What is there, in a few words; `None` where it is missing.
    fn found(self) -> Option<String> {
        match self {
            Self::Compiler => command::output("rustc", &["--version"]),
            Self::Component("clippy") => command::output("cargo-clippy", &["--version"]),
            Self::Component(program) => command::output(program, &["--version"]),
            Self::Target(target) => {
                let folder = command::output("rustc", &["--print", "target-libdir", "--target", target])?;
                holds_core(Path::new(&folder)).then(|| "installed".to_owned())
            }
            Self::Qemu => {
                let version = command::output(QEMU, &["--version"])?;
                version.lines().next().map(str::to_owned)
            }
        }
    }

    /// The commands that install it, one after the other; none for what cannot be had so. The compiler is not asked
    /// for: without it nobody would read this.
    fn installation(self) -> Vec<Vec<&'static str>> {
        match self {
            Self::Compiler => Vec::new(),
            Self::Component(name) => vec![vec!["rustup", "component", "add", name]],
            Self::Target(name) => vec![vec!["rustup", "target", "add", name]],
            Self::Qemu => {
                let Some(apt) = apt_get() else { return Vec::new() };
                let install = ["install", "--yes", "--no-install-recommends", QEMU];
                vec![[&apt[..], &["update"]].concat(), [&apt[..], &install].concat()]
            }
        }
    }

    /// How to get it by hand.
    fn remedy(self) -> String {
        match self {
            Self::Compiler => "install Rust with rustup (https://rustup.rs)".to_owned(),
            Self::Component(name) => {
                format!("`rustup component add {name}`; without rustup, your system's package for {name}")
            }
            Self::Target(name) => format!(
                "`rustup target add {name}`. Without rustup, on Debian: `apt-get install rustc-web cargo-web \
                 rust-web-src`, then build the firmware by hand with `RUSTC=/usr/bin/rustc RUSTC_BOOTSTRAP=1 \
                 /usr/bin/cargo build --release -Zbuild-std=core,panic_abort --target {name} -p firmware`; \
                 `cargo xtask test` itself needs the target installed"
            ),
            Self::Qemu => "on Debian and Ubuntu `apt-get install qemu-system-arm`, on Fedora `dnf install \
                           qemu-system-arm`, with Homebrew `brew install qemu`; version 7.2 is the oldest tried"
                .to_owned(),
        }
    }
}

/// How to call Debian's package manager without a question: as root, or where sudo asks for no password.
fn apt_get() -> Option<Vec<&'static str>> {
    command::output("apt-get", &["--version"])?;
    if command::output("id", &["-u"])? == "0" {
        return Some(vec!["apt-get"]);
    }
    command::output("sudo", &["--non-interactive", "true"])
        .map(|_| vec!["sudo", "--non-interactive", "apt-get"])
}

/// Whether a folder of target libraries holds `core`: it is the one every target has.
fn holds_core(folder: &Path) -> bool {
    let Ok(entries) = fs::read_dir(folder) else { return false };
    entries.flatten().any(|entry| entry.file_name().to_string_lossy().starts_with("libcore-"))
}

/// The targets that are missing, each with what to do; empty where both can be built for.
pub fn missing_targets() -> Vec<String> {
    let targets = NEEDS.into_iter().filter(|need| matches!(need, Need::Target(_)));
    targets.filter(|need| need.found().is_none()).map(complaint).collect()
}

/// In a few words; the remedy in full is what [`report`] prints.
fn complaint(need: Need) -> String {
    format!("{} is missing: {}", need.name(), need.remedy())
}

/// The emulator's complaint, where it is missing.
pub fn missing_qemu() -> Option<String> {
    Need::Qemu.found().is_none().then(|| complaint(Need::Qemu))
}

/// What is there and what is missing, for people to read; and whether nothing is.
pub fn report() -> (String, bool) {
    let mut text = String::new();
    let mut complete = true;
    for need in NEEDS {
        if let Some(found) = need.found() {
            text += &format!("present  {:<22} {found}\n", need.name());
        } else {
            complete = false;
            text += &format!("MISSING  {:<22} {}\n", need.name(), need.remedy());
        }
    }
    text += &match command::output("rustup", &["--version"]) {
        Some(version) => format!("present  {:<22} {version}\n", "rustup"),
        // Needed only to install the others.
        None => format!("absent   {:<22} not needed as long as nothing is missing\n", "rustup"),
    };
    text += if complete { "All there.\n" } else { "Something is missing; see above.\n" };
    (text, complete)
}

/// The first step of `cargo xtask test`: as [`report`], but installs what is missing.
pub fn provide(root: &Path) -> Result<(), String> {
    for need in NEEDS {
        if need.found().is_some() {
            continue;
        }
        println!("{} is missing: trying to install it", need.name());
        for line in need.installation() {
            let Some((program, arguments)) = line.split_first() else { continue };
            // Whether it helped is seen below, by looking again.
            if let Err(message) = command::run(root, &OsString::from(program), arguments, &[]) {
                println!("{message}");
            }
        }
    }
    print!("{}", report().0);
    let missing: Vec<String> =
        NEEDS.into_iter().filter(|need| need.found().is_none()).map(complaint).collect();
    if missing.is_empty() { Ok(()) } else { Err(missing.join("\n")) }
}

#[cfg(test)]
mod tests {
    use super::{NEEDS, Need, TARGETS, complaint, holds_core};
    use std::path::Path;

    #[test]
    fn every_complaint_names_the_thing_and_a_command() {
        for need in NEEDS {
            let said = complaint(need);
            assert!(said.contains(need.name()), "{said}");
            assert!(said.contains("rustup") || said.contains("apt-get install"), "{said}");
        }
        assert!(Need::Target(TARGETS[1]).remedy().contains("-Zbuild-std=core,panic_abort"));
        assert_eq!(Need::Component("clippy").installation(), [["rustup", "component", "add", "clippy"]]);
        assert_eq!(Need::Target("t").installation(), [["rustup", "target", "add", "t"]]);
    }

    #[test]
    fn what_does_not_exist_is_not_found() {
        assert!(Need::Compiler.found().is_some(), "this test was compiled by one");
        assert_eq!(Need::Target("thumbv0-none-eabi").found(), None);
        assert_eq!(Need::Component("rust-no-such-component").found(), None);
        assert!(!holds_core(Path::new(env!("CARGO_MANIFEST_DIR"))));
    }
}
