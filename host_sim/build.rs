//! Notes the commit that the program is built from, for the provenance of the maps that it trains.
//!
//! Only where it is optimised: then a commit costs one compilation of this package. Tests and debug builds say
//! `unknown`, so that their output does not depend on the commit, and a commit does not have all tests compiled anew.
//!
//! Nothing here fails a build: without git, or outside a checkout, the commit is `unknown` as well.

use std::env;
use std::path::Path;
use std::process::Command;

/// What training depends on, from the root of the repository: a change of it makes the tree dirty.
const SOURCES: [&str; 11] = [
    "Cargo.toml",
    "Cargo.lock",
    "controller_core/Cargo.toml",
    "controller_core/src",
    "protocol/Cargo.toml",
    "protocol/src",
    "hil_stub/Cargo.toml",
    "hil_stub/src",
    "host_sim/Cargo.toml",
    "host_sim/build.rs",
    "host_sim/src",
];

/// Of a commit's hash; with `-dirty` it fits into the header of a map.
const HASH_LETTERS: usize = 12;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let is_optimised = env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = if is_optimised { commit() } else { None };
    println!("cargo:rustc-env=EKM_NAV_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}

/// The commit, with `-dirty` behind it where the sources differ from it.
fn commit() -> Option<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent()?;
    // A copy of the sources within another repository must not take that one's commit.
    if !root.join(".git").exists() {
        return None;
    }
    let git = |arguments: &[&str]| {
        // Without locks: another git may be at work.
        let output =
            Command::new("git").arg("--no-optional-locks").args(arguments).current_dir(root).output();
        let output = output.ok().filter(|output| output.status.success())?;
        Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
    };
    for source in SOURCES {
        println!("cargo:rerun-if-changed=../{source}");
    }
    // HEAD's log gets a line with each commit and each change of branch.
    if let Some(log) = git(&["rev-parse", "--path-format=absolute", "--git-path", "logs/HEAD"]) {
        println!("cargo:rerun-if-changed={log}");
    }
    let hash = git(&["rev-parse", "HEAD"])?;
    let changes = git(&[&["status", "--porcelain", "--"][..], &SOURCES].concat())?;
    let mark = if changes.is_empty() { "" } else { "-dirty" };
    Some(hash.get(..HASH_LETTERS)?.to_owned() + mark)
}
