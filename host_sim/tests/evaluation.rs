//! The evaluations' short form: few runs of a question of each kind, the table held against the committed one; and what
//! the options change.
//!
//! After a change of the controller's behaviour: `INSTA_UPDATE=always cargo test -p host_sim --test evaluation`, then
//! look at what `git diff` says about the snapshots.
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, which clippy.toml cannot know")]

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

/// What an evaluation prints; it must be well.
fn evaluate(folder: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host_sim"));
    let output = command.current_dir(folder).arg("evaluate").args(arguments).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}\n{said}");
    String::from_utf8(output.stdout).unwrap()
}

/// The same as a document.
fn document(arguments: &[&str]) -> Value {
    let folder = TempDir::new().unwrap();
    serde_json::from_str(&evaluate(folder.path(), &[arguments, &["--json"]].concat())).unwrap()
}

/// How long it took is not held.
fn without_time(text: &str) -> String {
    text.lines().filter(|line| !line.starts_with("took ")).map(|line| format!("{line}\n")).collect()
}

/// Few runs and two maps: enough to notice that something has changed.
const SHORT: [&str; 6] = ["--runs", "3", "--maps", "2", "--seed", "450000"];

#[track_caller]
fn assert_table(name: &str, what: &[&str]) {
    let folder = TempDir::new().unwrap();
    insta::assert_snapshot!(name, without_time(&evaluate(folder.path(), &[what, &SHORT].concat())));
}

#[test]
fn the_table_of_scenarios_is_as_committed() {
    assert_table(
        "evaluate_scenarios",
        &["scenarios", "--only", "p2_fig4", "--only", "p2_fig5", "--only", "p2_fig7"],
    );
}

#[test]
fn the_table_of_traps_is_as_committed() {
    assert_table("evaluate_traps", &["traps", "--only", "30 x 2", "--only", "past"]);
}

#[test]
fn the_table_of_doors_is_as_committed() {
    assert_table("evaluate_doors", &["doors", "--only", "door 10", "--only", "door 8", "--only", "8 cm"]);
}

#[test]
fn the_table_of_traffic_is_as_committed() {
    assert_table("evaluate_traffic", &["traffic", "--only", "2 discs at 5 "]);
}

#[test]
fn limits_are_told_to_people_and_to_programs() {
    let folder = TempDir::new().unwrap();
    let line = [
        "doors",
        "--runs",
        "1",
        "--maps",
        "1",
        "--steps",
        "300",
        "--controller",
        "vfh",
        "--controller",
        "apf",
    ];
    let text = evaluate(folder.path(), &[&line[..], &["--only", "door 1", "--out", "o"]].concat());
    assert!(text.contains("door straight") && text.contains("door ±45°"), "{text}");
    assert!(text.contains("diameters): 100.0 [20.7, 100.0]"), "one of one, with its interval: {text}");
    let csv = std::fs::read_to_string(folder.path().join("o/doors_limits.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 2 * 2, "{csv}");
    let document = document(&[&line[..], &["--only", "door 1"]].concat());
    let limit = &document["controllers"][0]["limits"][0];
    assert_eq!(
        (&limit["group"], &limit["passed"]["measure"]["what"]),
        (&"door straight".into(), &"door".into())
    );
    assert!(limit["passed"]["success_wilson_95"][0].as_f64().unwrap() < 0.21, "{limit}");
}

#[test]
fn late_tasks_change_runs_and_no_jitter_does_not() {
    let line = ["doors", "--runs", "2", "--maps", "1", "--steps", "500", "--controller", "cooperative"];
    let scenes = |jitter: &str| {
        let line = [&line[..], &["--only", "door 12", "--task-jitter", jitter]].concat();
        document(&line)["controllers"][0]["scenes"].clone()
    };
    let (none, some) = (scenes("0"), scenes("60"));
    assert_ne!(none, some);
    assert_eq!(some, scenes("60"), "the seed decides");
    assert_eq!(some[0]["result"]["success"]["count"], 2, "a wide door does not ask for punctuality: {some}");
}

#[test]
fn discs_begin_elsewhere_in_each_run() {
    let line = ["traffic", "--runs", "12", "--maps", "1", "--controller", "apf", "--only", "2 discs at 10 "];
    let success =
        document(&line)["controllers"][0]["scenes"][0]["result"]["success"]["count"].as_u64().unwrap();
    assert!((1..12).contains(&success), "neither all nor none: {success}");
}

#[test]
fn surfaces_are_drawn_and_a_scene_that_is_not_there_is_refused() {
    let folder = TempDir::new().unwrap();
    let line =
        ["traffic", "--surfaces", "--runs", "1", "--controller", "vfh", "--only", "1 discs", "--out", "o"];
    let text = evaluate(folder.path(), &line);
    assert!(text.contains("discs 6:"), "{text}");
    let drawn = std::fs::read_to_string(folder.path().join("o/traffic.svg")).unwrap();
    assert!(drawn.contains("with vfh"), "{drawn}");

    let mut command = Command::new(env!("CARGO_BIN_EXE_host_sim"));
    let output = command.args(["evaluate", "doors", "--only", "window"]).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(said.contains("--only window") && said.contains("corridor 12 cm"), "{said}");
}
