//! Other programs: how they are started, and what it means when they fail.

use std::env;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};

/// Cargo: the one that runs us, so that both build with the same toolchain.
pub fn cargo() -> OsString {
    env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Runs a program in `folder` with its output in ours and no input; its command line is shown first.
pub fn run(
    folder: &Path,
    program: &OsString,
    arguments: &[&str],
    variables: &[(&str, &str)],
) -> Result<(), String> {
    let name = Path::new(program).file_name().unwrap_or(program).to_string_lossy().into_owned();
    let set: String = variables.iter().map(|(key, value)| format!("{key}={value} ")).collect();
    let line = format!("{set}{name} {}", arguments.join(" "));
    println!("$ {line}");
    let status = Command::new(program)
        .args(arguments)
        .envs(variables.iter().copied())
        .current_dir(folder)
        .stdin(Stdio::null())
        .status()
        .map_err(|error| format!("`{line}` could not be started: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("`{line}` failed ({status})")) }
}

/// What a program prints; `None` where it is missing or fails.
pub fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
