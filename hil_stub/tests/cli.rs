//! A stub that does nothing must not look like one that works.

use std::process::Command;

#[test]
fn says_that_it_is_not_built_yet_and_fails() {
    let output = Command::new(env!("CARGO_BIN_EXE_hil_stub")).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("not built yet") && said.contains("ARCHITECTURE.md"), "{said}");
}
