//! What a user of `cargo xtask` sees: exit codes, and where the words go.

use std::process::{Command, Output};

fn xtask(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_xtask")).args(arguments).output().expect("the binary under test starts")
}

#[test]
fn wrong_usage_is_exit_code_2_and_said_on_stderr() {
    for arguments in [&["test", "--fast"][..], &["tset"], &[]] {
        let output = xtask(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert!(String::from_utf8_lossy(&output.stderr).starts_with("error: "), "{arguments:?}");
    }
}

#[test]
fn help_is_exit_code_0_and_printed_on_stdout() {
    for arguments in [&["--help"][..], &["test", "--help"], &["doctor", "--help"]] {
        let output = xtask(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(String::from_utf8_lossy(&output.stdout).contains("Usage: cargo xtask"), "{arguments:?}");
    }
}

#[test]
fn doctor_fails_exactly_where_something_is_missing() {
    let output = xtask(&["doctor"]);
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("thumbv7em-none-eabihf") && said.contains("thumbv7m-none-eabi"), "{said}");
    let expected = i32::from(said.contains("MISSING"));
    assert_eq!(output.status.code(), Some(expected), "{said}");

    // Nothing can be found where there is nowhere to look.
    let blind = Command::new(env!("CARGO_BIN_EXE_xtask")).arg("doctor").env("PATH", "").output();
    let blind = blind.expect("the binary under test starts");
    assert_eq!(blind.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&blind.stdout).contains("rustup target add thumbv7m-none-eabi"));
}
