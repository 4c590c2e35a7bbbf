//! The command line as its users meet it: text, JSON, files and exit codes of the built program.
//!
//! After a change of the controller's behaviour: `INSTA_UPDATE=always cargo test -p host_sim --test cli`, then look at
//! what `git diff` says about the snapshot.
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, which clippy.toml cannot know")]

use std::path::Path;
use std::process::{Command, Output, Stdio};

use protocol::map_file::{
    FORMAT_VERSION, MapHeader, NeuronRecord, Provenance, Robot, encode, encoded_bytes_max,
};
use protocol::message::ScalarKind;
use serde_json::Value;
use tempfile::TempDir;

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host_sim"));
    command.current_dir(folder).args(arguments);
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The text of a run that must be well.
fn ok(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}\n{}{}", stdout(&output), stderr(&output));
    assert_eq!(stderr(&output), "", "no progress bars where there is no terminal: {arguments:?}");
    stdout(&output)
}

/// The document of a command, whether or not the robot did what it should.
fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, arguments);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments:?}\n{}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap()
}

/// Requires exit code 2, nothing on stdout, and every one of `words` in the message.
fn assert_refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let output = run(folder, arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}\n{}{message}", stdout(&output));
    assert_eq!(stdout(&output), "", "{arguments:?}");
    for word in words {
        assert!(message.contains(word), "{arguments:?} must say `{word}`:\n{message}");
    }
}

fn files_in(folder: &Path) -> Vec<String> {
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(name).collect();
    names.sort();
    names
}

/// The value behind a name at the start of a line.
fn fact(text: &str, name: &str) -> String {
    let line = text.lines().find(|line| line.starts_with(name));
    line.unwrap_or_else(|| panic!("no `{name}` in\n{text}"))[name.len()..].trim().to_owned()
}

#[test]
fn the_main_job_learns_arrives_and_writes_three_whole_files() {
    let folder = TempDir::new().unwrap();
    let text = ok(folder.path(), &[]);
    assert!(text.ends_with("ok: goal reached without contact, every checkpoint within 5 mm\n"), "{text}");
    assert_eq!(fact(&text, "run"), "seed 1, scalar f32, controller cooperative");
    assert_eq!(fact(&text, "contacts"), "0");
    assert_eq!(fact(&text, "state hash").len(), 16);
    assert_eq!(files_in(folder.path()), ["out"]);
    let out = folder.path().join("out");
    assert_eq!(files_in(&out), ["map.ekm", "p2_fig6.csv", "p2_fig6.svg"]);
    let log = std::fs::read_to_string(out.join("p2_fig6.csv")).unwrap();
    let lines: Vec<&str> = log.lines().collect();
    assert!(lines.len() > 100 && lines.iter().all(|line| line.split(',').count() == 8), "{log}");
    let figure = std::fs::read_to_string(out.join("p2_fig6.svg")).unwrap();
    assert!(figure.starts_with("<svg") && figure.trim_end().ends_with("</svg>"));

    // The saved map drives exactly as the one just learned, and `run` does what the main job did.
    let again = ok(folder.path(), &["run", "p2_fig6", "--map", "out/map.ekm"]);
    assert_eq!(fact(&again, "state hash"), fact(&text, "state hash"));
    let relearned = ok(folder.path(), &["run", "p2_fig6"]);
    assert_eq!(fact(&relearned, "state hash"), fact(&text, "state hash"));
}

#[test]
fn the_main_job_works_in_fixed_point_and_its_map_is_kept_exactly() {
    let folder = TempDir::new().unwrap();
    let text = ok(folder.path(), &["--scalar", "fixed"]);
    assert_eq!(fact(&text, "run"), "seed 1, scalar fixed, controller cooperative");
    let again = ok(folder.path(), &["run", "p2_fig6", "--scalar", "fixed", "--map", "out/map.ekm"]);
    assert_eq!(fact(&again, "state hash"), fact(&text, "state hash"));
    assert_refused(
        folder.path(),
        &["run", "p2_fig6", "--map", "out/map.ekm"],
        &["out/map.ekm", "scalar fixed, not f32", "--scalar fixed"],
    );
}

#[test]
fn a_robot_that_fails_gives_exit_code_1_and_the_reason() {
    let folder = TempDir::new().unwrap();
    let output = run(folder.path(), &["run", "p2_fig6", "--steps", "1"]);
    let text = stdout(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("FAILED: goal not reached within 120 s"), "{text}");
    let swept = run(folder.path(), &["run", "p2_fig6", "--steps", "1", "--runs", "2", "--require", "1"]);
    assert_eq!(swept.status.code(), Some(1));
    assert!(stdout(&swept).contains("FAILED: success in less than 1 %"), "{}", stdout(&swept));
}

#[test]
fn the_hash_over_many_runs_depends_on_the_seed_and_not_on_the_threads() {
    let folder = TempDir::new().unwrap();
    let sweep = |seed: &str, threads: &str| {
        let arguments =
            ["run", "p2_fig5", "--steps", "500", "--runs", "3", "--seed", seed, "--threads", threads];
        fact(&ok(folder.path(), &arguments), "sweep hash")
    };
    let one = sweep("1", "1");
    assert_eq!(one, sweep("1", "1"));
    assert_eq!(one, sweep("1", "2"));
    assert_ne!(one, sweep("2", "2"));
}

#[test]
fn maps_of_their_own_make_each_run_a_main_job() {
    let folder = TempDir::new().unwrap();
    let arguments = ["run", "p2_fig5", "--steps", "300", "--runs", "2", "--fresh-maps", "--json"];
    let sweep = json(folder.path(), &arguments);
    let single = json(folder.path(), &["run", "p2_fig5", "--steps", "300", "--seed", "2", "--json"]);
    assert_eq!(sweep["controllers"][0]["runs"][1]["hash"], single["result"]["hash"]);
}

#[test]
fn a_small_sweep_is_as_committed() {
    let folder = TempDir::new().unwrap();
    insta::assert_snapshot!("sweep", ok(folder.path(), &["run", "p2_fig5", "--runs", "8"]));
}

#[test]
fn the_parameters_are_as_committed() {
    // The link numbers them so: lines are only ever added at the end.
    let folder = TempDir::new().unwrap();
    insta::assert_snapshot!("parameters", ok(folder.path(), &["config", "--list"]));
}

#[test]
fn json_is_one_document_for_every_command_that_offers_it() {
    let folder = TempDir::new().unwrap();
    let once = json(folder.path(), &["run", "p2_fig5", "--json", "--out", "o"]);
    assert_eq!(once["result"]["hash"].as_str().unwrap().len(), 16);
    assert_eq!(once["files"].as_array().unwrap().len(), 2);
    let main_job = json(folder.path(), &["--json"]);
    assert_eq!((&main_job["scenario"], &main_job["result"]["success"]), (&"p2_fig6".into(), &true.into()));
    let sweep = json(folder.path(), &["run", "p2_fig5", "--runs", "2", "--json", "--out", "o"]);
    assert_eq!(sweep["controllers"].as_array().unwrap().len(), 2);
    assert_eq!(sweep["controllers"][1]["runs"].as_array().unwrap().len(), 2);
    assert_eq!(files_in(&folder.path().join("o")).len(), 4);
    let scenarios = json(folder.path(), &["scenarios", "--json"]);
    assert_eq!(scenarios.as_array().unwrap().len(), 9);
    let plan = json(folder.path(), &["plan", "p2_fig6", "--json", "--out", "plan.svg"]);
    assert_eq!((plan["checkpoints"].as_array().unwrap().len(), &plan["file"]), (3, &"plan.svg".into()));
    let parameters = json(folder.path(), &["config", "--list", "--json"]);
    let speed = &parameters[3];
    assert_eq!((&speed["name"], &speed["unit"]), (&"robot.speed_limit_mps".into(), &"m/s".into()));
    assert_eq!((&speed["default"], &speed["low"], &speed["high"]), (&0.16.into(), &0.005.into(), &5.into()));
    assert_eq!(parameters[0]["choices"], serde_json::json!(["cooperative", "fusion"]));
    let bench = json(folder.path(), &["bench", "--runs", "1", "--steps", "100", "--json"]);
    assert!(bench["speeds"][0]["times_real_time"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_papers_positioning_experiment_is_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let line =
        ["evaluate", "positioning", "--trials", "2", "--steps", "300", "--every", "200", "--targets", "3"];
    let text = ok(folder.path(), &[&line[..], &["--mapping", "indirect", "--out", "fig"]].concat());
    for expected in ["precise, indirect, f32", "p1, indirect, fixed", "p1, analytic", "P1, figures: direct"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    let csv = std::fs::read_to_string(folder.path().join("fig/positioning.csv")).unwrap();
    // Two tests of two trials of two settings in two arithmetics.
    assert_eq!(csv.lines().count(), 1 + 2 * 2 * 2 * 2);
    for figure in ["p1_fig4.svg", "p1_fig5a.svg", "p1_fig5b.svg", "p1_fig6.svg"] {
        let svg = std::fs::read_to_string(folder.path().join("fig").join(figure)).unwrap();
        assert!(svg.contains("indirect, fixed"), "{figure}");
    }
    let one = |threads| {
        let line = [&line[..], &["--scalar", "f32", "--threads", threads, "--json"]].concat();
        json(folder.path(), &line)
    };
    let document = one("1");
    assert_eq!(document["kinds"].as_array().unwrap().len(), 4, "both settings, both mappings");
    assert_eq!(document["kinds"][0]["trials"][1]["points"][1]["steps"], 300);
    assert_eq!(document, one("2"), "whatever the threads");
    let ablation = ok(folder.path(), &[&line[..], &["--config", "precise", "--ablate"]].concat());
    for instead in ["(nothing changed)", "plain gradient", "speeds in units of 8 mm/s"] {
        assert!(ablation.contains(instead), "{instead}: {ablation}");
    }
}

#[test]
fn a_changed_robot_is_learned_anew() {
    let folder = tempfile::tempdir().unwrap();
    let line =
        ["evaluate", "calibration", "--trials", "2", "--steps", "100", "--further", "30", "--targets", "1"];
    let text = ok(folder.path(), &[&line[..], &["--every", "20", "--out", "fig"]].concat());
    for expected in ["wheel base + 20 %", "left motor − 20 %", "without learning", "30 steps later"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert_eq!(files_in(&folder.path().join("fig")), ["self_calibration.svg"]);
    let document = json(folder.path(), &[&line[..], &["--json"]].concat());
    let change = &document["changes"][0];
    let missed = |when: &str| change[when]["one_step_error_m"].as_f64().unwrap();
    assert!(missed("before") > 0.0 && missed("without_learning") > 0.0, "{change}");
    assert_eq!(
        change["learning"].as_array().unwrap().len(),
        1,
        "every 100 steps, but at the end in any case"
    );
}

#[test]
fn every_built_in_configuration_can_be_used() {
    let folder = tempfile::tempdir().unwrap();
    for (name, line) in [
        ("precise", "goal_tolerance_m = 0.0002"),
        ("p1", "command_unit_mps = 0.008"),
        ("literal", "chart = \"unsigned\""),
        ("large", "wheel_base_m = 0.106"),
        ("boards", "mover_headway_s = 0.0"),
    ] {
        let text = ok(folder.path(), &["config", "--config", name]);
        assert!(text.contains(line), "{name}: {text}");
    }
    assert!(ok(folder.path(), &["config"]).contains("mover_headway_s = 0.6"), "movers are followed here");
}

#[test]
fn training_is_measured_for_both_mappings_and_saved_on_request() {
    let folder = TempDir::new().unwrap();
    let trials = json(folder.path(), &["train", "--trials", "2", "--json"]);
    let error = |mapping: usize| trials["mappings"][mapping]["all"]["mean_error_m"].as_f64().unwrap();
    assert_eq!(trials["mappings"][0]["mapping"], "indirect");
    assert!(error(0) < error(1), "P1: the indirect map is the more precise one: {trials}");
    let text = ok(folder.path(), &["train", "--steps", "300", "--out", "my.ekm"]);
    assert!(text.contains("wrote my.ekm"), "{text}");
    assert_eq!(files_in(folder.path()), ["my.ekm"]);
    assert_refused(
        folder.path(),
        &["train", "--mapping", "direct", "--out", "d.ekm"],
        &["indirect maps only"],
    );
}

#[test]
fn a_map_can_be_shown_and_drawn() {
    let folder = TempDir::new().unwrap();
    ok(folder.path(), &["train", "--steps", "100", "--out", "my.ekm"]);
    let text = ok(folder.path(), &["map", "show", "my.ekm"]);
    // An optimised program knows its commit.
    let by = fact(&text, "by ");
    insta::assert_snapshot!("map_show", text.replace(&by, "core 0.1.0, commit unknown"));
    assert_eq!(files_in(folder.path()), ["my.ekm"]);
    let shown = json(folder.path(), &["map", "show", "my.ekm", "--json", "--out", "my.svg"]);
    assert_eq!(
        (&shown["scalar"], &shown["columns"], &shown["file"]),
        (&"f32".into(), &15.into(), &"my.svg".into())
    );
    assert!(
        by.starts_with("core 0.1.0, commit ")
            && by.ends_with(shown["provenance"]["commit"].as_str().unwrap())
    );
    assert_eq!(shown["robot"]["wheel_base_m"], 0.053);
    assert_eq!((&shown["provenance"]["seed"], &shown["provenance"]["steps"]), (&1.into(), &100.into()));
    assert_eq!(shown["statistics"]["neurons"], 225);
    let text = ok(folder.path(), &["map", "show", "my.ekm", "--out", "my.svg"]);
    assert!(text.ends_with("wrote my.svg\n"), "{text}");
    assert_eq!(fact(&text, "map hash"), shown["hash"].as_str().unwrap());
    let figure = std::fs::read_to_string(folder.path().join("my.svg")).unwrap();
    assert!(figure.starts_with("<svg") && figure.trim_end().ends_with("</svg>"));
}

#[test]
fn a_map_of_another_robot_is_refused_unless_it_is_meant() {
    let folder = TempDir::new().unwrap();
    ok(folder.path(), &["train", "--steps", "100", "--out", "my.ekm"]);
    std::fs::write(folder.path().join("wide.toml"), "[robot]\nwheel_base_m = 0.06\n").unwrap();
    let run_wide = ["run", "p2_fig5", "--map", "my.ekm", "--config", "wide.toml"];
    let words =
        ["my.ekm", "robot.wheel_base_m = 0.053", "has 0.06", "train a new map", "--map-of-another-robot"];
    assert_refused(folder.path(), &run_wide, &words);
    assert_refused(folder.path(), &[&run_wide[..], &["--runs", "2"]].concat(), &words);
    let output = run(folder.path(), &[&run_wide[..], &["--map-of-another-robot"]].concat());
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", stderr(&output));
    assert!(stderr(&output).contains("note: my.ekm was learned with robot.wheel_base_m = 0.053"));
    assert_refused(folder.path(), &["run", "p2_fig5", "--map-of-another-robot"], &["--map <FILE.ekm>"]);
}

#[test]
fn two_maps_can_be_compared() {
    let folder = TempDir::new().unwrap();
    for (seed, name) in [("1", "a.ekm"), ("1", "again.ekm"), ("2", "b.ekm")] {
        ok(folder.path(), &["train", "--steps", "100", "--seed", seed, "--out", name]);
    }
    insta::assert_snapshot!("map_diff", ok(folder.path(), &["map", "diff", "a.ekm", "b.ekm"]));
    let same = ok(folder.path(), &["map", "diff", "a.ekm", "again.ekm", "--require-same"]);
    assert!(same.ends_with("the same map, bit for bit\n"), "{same}");
    let required = run(folder.path(), &["map", "diff", "a.ekm", "b.ekm", "--require-same"]);
    assert_eq!(required.status.code(), Some(1), "{}", stderr(&required));
    assert!(stdout(&required).ends_with("FAILED: the maps differ\n"), "{}", stdout(&required));
    let document = json(folder.path(), &["map", "diff", "a.ekm", "b.ekm", "--json"]);
    assert_eq!((&document["same"], &document["differences"]["neurons"]), (&false.into(), &225.into()));
    assert_eq!(document["differences"]["headers"][0]["name"], "seed");
}

#[test]
fn a_map_can_be_exported_to_a_file_or_not() {
    let folder = TempDir::new().unwrap();
    ok(folder.path(), &["train", "--steps", "100", "--out", "my.ekm"]);
    let map = std::fs::read(folder.path().join("my.ekm")).unwrap();
    for (language, name, words) in [
        ("rust", "map.rs", "pub const MAP: ["),
        ("c", "map.h", "static const struct ekm_map_neuron ekm_map["),
    ] {
        let text = ok(folder.path(), &["map", "export", "my.ekm", "--to", language]);
        assert!(text.contains(words), "{text}");
        let said = ok(folder.path(), &["map", "export", "my.ekm", "--to", language, "--out", name]);
        assert_eq!(said, format!("wrote {name}\n"));
        assert_eq!(std::fs::read_to_string(folder.path().join(name)).unwrap(), text);
    }
    let over = ["map", "export", "my.ekm", "--to", "c", "--out", "./my.ekm"];
    assert_refused(folder.path(), &over, &["./my.ekm", "overwrite the map", "another --out"]);
    assert_eq!(std::fs::read(folder.path().join("my.ekm")).unwrap(), map);
}

/// A whole map file of this lattice, with a version of the format.
fn map_file(format_version: u16, columns: u8, rows: u8) -> Vec<u8> {
    let header = MapHeader {
        format_version: FORMAT_VERSION,
        scalar: ScalarKind::F32,
        columns,
        rows,
        reach_m: 0.2,
        speed_limit_mps: 0.1,
        robot: Robot { wheel_base_m: 0.1, body_radius_m: 0.06, encoder_counts_per_m: 5000.0 },
        provenance: Provenance {
            seed: 1,
            steps: 1,
            horizon_ms: 2000,
            config_digest: 1,
            core_version: "0.0.0".try_into().unwrap(),
            commit: "unknown".try_into().unwrap(),
        },
    };
    let neurons = vec![NeuronRecord::default(); header.neuron_count()];
    let mut bytes = vec![0; encoded_bytes_max(neurons.len())];
    let length = encode(&header, &neurons, &mut bytes).unwrap().len();
    bytes.truncate(length);
    // The version is the first byte of the body, and the sum at the end is over all before it.
    bytes[12] = u8::try_from(format_version).unwrap();
    let sum = length - 4;
    let crc = crc32(&bytes[..sum]);
    bytes[sum..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// CRC-32 (ISO-HDLC), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let shift = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), shift))
}

#[test]
fn what_is_no_map_is_refused_by_every_map_command_and_nothing_is_written() {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let whole = map_file(2, 15, 15);
    let mut damaged = whole.clone();
    damaged[200] ^= 4;
    write("whole.ekm", &whole);
    write("text.ekm", b"not a map at all\n");
    write("empty.ekm", b"");
    write("cut.ekm", &whole[..whole.len() - 1]);
    write("longer.ekm", &[&whole[..], b"x"].concat());
    write("damaged.ekm", &damaged);
    write("older.ekm", &map_file(1, 15, 15));
    write("newer.ekm", &map_file(3, 15, 15));
    write("none.ekm", &map_file(2, 0, 15));
    write("small.ekm", &map_file(2, 3, 2));
    std::fs::create_dir(folder.path().join("folder.ekm")).unwrap();
    let before = files_in(folder.path());
    for (name, words) in [
        ("text.ekm", &["not a map file", "not a ma", "train --out"][..]),
        ("empty.ekm", &["has been cut: 0 bytes", "train --out"]),
        ("cut.ekm", &["has been cut", "train --out"]),
        ("longer.ekm", &["has been added to", "train --out"]),
        ("damaged.ekm", &["is damaged: CRC-32", "train --out"]),
        ("older.ekm", &["map format 1", "format 2", "train --out"]),
        ("newer.ekm", &["map format 3", "format 2", "train --out"]),
        ("none.ekm", &["0 × 15 neurons", "train --out"]),
        ("folder.ekm", &["cannot be read", "train --out"]),
        ("missing.ekm", &["cannot be read", "train --out missing.ekm"]),
    ] {
        let words = [&[name][..], words].concat();
        assert_refused(folder.path(), &["map", "show", name, "--out", "new/a.svg"], &words);
        assert_refused(folder.path(), &["map", "show", name, "--json"], &words);
        assert_refused(folder.path(), &["map", "diff", "whole.ekm", name], &words);
        assert_refused(folder.path(), &["map", "diff", name, "whole.ekm", "--require-same"], &words);
        assert_refused(folder.path(), &["map", "export", name, "--to", "rust", "--out", "new/a.rs"], &words);
        assert_refused(folder.path(), &["map", "export", name, "--to", "c"], &words);
    }
    let lattices = ["whole.ekm and small.ekm", "15 × 15", "3 × 2", "same lattice"];
    assert_refused(folder.path(), &["map", "diff", "whole.ekm", "small.ekm"], &lattices);
    assert_refused(folder.path(), &["map", "show", "whole.ekm", "--out", "folder.ekm"], &["it is a folder"]);
    assert_refused(folder.path(), &["map", "export", "whole.ekm"], &["--to"]);
    assert_eq!(files_in(folder.path()), before, "nothing was written");
    // Another robot's map of another lattice is a map all the same.
    let small = ok(folder.path(), &["map", "show", "small.ekm"]);
    assert_eq!(fact(&small, "trained"), "0 of 6 neurons");
}

#[test]
fn help_gives_examples() {
    let folder = TempDir::new().unwrap();
    for arguments in [&["--help"][..], &["run", "--help"], &["train", "--help"], &["map", "--help"]] {
        let text = ok(folder.path(), arguments);
        assert!(text.contains("Examples") && text.contains("\n  host_sim "), "{text}");
    }
}

#[test]
fn what_is_printed_can_be_copied_edited_and_used() {
    let folder = TempDir::new().unwrap();
    let scenario = ok(folder.path(), &["scenarios", "p2_fig6", "--print"]);
    std::fs::write(folder.path().join("mine.toml"), &scenario).unwrap();
    std::fs::write(folder.path().join("config.toml"), ok(folder.path(), &["config", "--print"])).unwrap();
    let mine = ok(folder.path(), &["run", "mine.toml", "--config", "config.toml"]);
    let builtin = ok(folder.path(), &["run", "p2_fig6"]);
    assert_eq!(fact(&mine, "state hash"), fact(&builtin, "state hash"));

    // The last doorway walled up on the planner's map: an answer, not a misuse.
    let closed = scenario + "\n[[walls]]\nrectangle = [[1.10, 0.42], [1.12, 0.58]]\n";
    std::fs::write(folder.path().join("closed.toml"), closed).unwrap();
    for command in ["run", "plan"] {
        let output = run(folder.path(), &[command, "closed.toml"]);
        assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
        assert!(
            stderr(&output).contains("no plan") && stderr(&output).contains("walls"),
            "{}",
            stderr(&output)
        );
    }
}

#[test]
fn peers_run_like_our_controllers_and_their_numbers_come_from_a_file() {
    let folder = TempDir::new().unwrap();
    let text = ok(folder.path(), &["run", "p2_fig5", "--controller", "bug2"]);
    assert_eq!(fact(&text, "run"), "seed 1, scalar f32, controller bug2");
    assert!(fact(&text, "learned").starts_with("nothing"), "{text}");
    let sweep = ["run", "p2_fig5", "--controller", "apf", "--runs", "3", "--json"];
    let document = json(folder.path(), &sweep);
    assert_eq!(document["controllers"][0]["controller"], "apf");
    assert_eq!(document["controllers"][0]["runs"].as_array().unwrap().len(), 3);
    std::fs::write(folder.path().join("slow.toml"), "[peers.apf]\ncruise_share = 0.2\n").unwrap();
    let slow = json(folder.path(), &[&sweep[..], &["--config", "slow.toml"]].concat());
    let median = |document: &Value| document["controllers"][0]["summary"]["time_median_s"].as_f64().unwrap();
    assert!(median(&slow) > 2.0 * median(&document), "{slow}");
    assert!(ok(folder.path(), &["config", "--print"]).contains("[peers.vfh]\n"));
}

#[test]
fn a_search_prints_a_table_that_config_takes() {
    let folder = TempDir::new().unwrap();
    let search = ["search", "bug2", "--generations", "1", "--candidates", "4"];
    let output = run(folder.path(), &search);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    std::fs::write(folder.path().join("found.toml"), &output.stdout).unwrap();
    let config = ok(folder.path(), &["config", "--print", "--config", "found.toml"]);
    let number = |text: &str| {
        let line = text.lines().find(|line| line.contains("margin_m = ")).unwrap_or_default().to_owned();
        line.rsplit(' ').next().and_then(|value| value.parse::<f64>().ok()).unwrap()
    };
    let bug2 = config.split("[peers.bug2]").nth(1).unwrap();
    let found = number(&stdout(&output));
    assert!(found > 0.0 && (number(bug2) - found).abs() < 1e-12, "{config}");
}

#[test]
fn wrong_requests_are_refused_with_a_remedy() {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("bad.toml", "name = 1\n");
    write("key.toml", "[servo]\nstal_share = 0.2\n");
    write("value.toml", "[servo]\nstall_share = 2\n");
    let refused = |arguments: &[&str], words: &[&str]| assert_refused(folder.path(), arguments, words);
    refused(&["--nonsense"], &["--nonsense", "--help"]);
    refused(&["run"], &["<SCENARIO>"]);
    refused(&["run", "p2_fig66"], &["did you mean `p2_fig6`", "p1_fig7", "p2_fig7"]);
    refused(&["run", "bad.toml"], &["bad.toml:1", "`name`"]);
    refused(&["run", "p2_fig6", "--controller", "magic"], &["cooperative, fusion"]);
    refused(&["run", "p2_fig6", "--runs", "0"], &["--runs"]);
    refused(&["run", "p2_fig6", "--seed", "18446744073709551615", "--runs", "2"], &["--seed", "smaller"]);
    refused(&["run", "p2_fig6", "--map", "none.ekm"], &["none.ekm", "train --out none.ekm"]);
    refused(&["run", "p2_fig6", "--map", "bad.toml"], &["bad.toml", "train"]);
    refused(&["run", "p2_fig6", "--map", "m.ekm", "--steps", "9"], &["--map", "--steps"]);
    refused(&["--config", "key.toml"], &["key.toml:2", "servo.stal_share", "did you mean `stall_share`"]);
    refused(&["--config", "value.toml"], &["value.toml", "servo.stall_share = 2", "between 0 and 1"]);
    write("peer.toml", "[peers.bug2]\nmargin_m = -1\n");
    refused(&["--config", "peer.toml"], &["peer.toml", "peers.bug2.margin_m = -1", "must be between"]);
    refused(&["run", "p2_fig6", "--controller", "vfh", "--link", "stub"], &["vfh", "this process", "--link"]);
    refused(&["run", "p2_fig6", "--controller", "dwa", "--map", "m.ekm"], &["dwa", "without a map", "--map"]);
    refused(&["run", "p2_fig6", "--controller", "apf", "--scalar", "fixed"], &["apf", "--scalar fixed"]);
    refused(&["search", "apf", "--candidates", "1"], &["--candidates"]);
    refused(&["config", "--json"], &["--list"]);
    refused(&["--config", "none.toml"], &["none.toml", "config --print"]);
    assert_eq!(
        files_in(folder.path()),
        ["bad.toml", "key.toml", "peer.toml", "value.toml"],
        "nothing was written"
    );
}

#[test]
fn output_that_cannot_be_written_is_refused_before_the_work_and_leaves_nothing() {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("file"), "mine").unwrap();
    std::fs::create_dir_all(folder.path().join("taken/p2_fig6.svg")).unwrap();
    assert_refused(folder.path(), &["--out", "file"], &["file", "--out"]);
    assert_refused(folder.path(), &["run", "p2_fig6", "--out", "file/below"], &["file/below", "--out"]);
    assert_refused(folder.path(), &["--out", "taken"], &["taken/p2_fig6.svg", "it is a folder"]);
    assert_refused(folder.path(), &["train", "--out", "taken"], &["taken", "it is a folder"]);
    assert_refused(folder.path(), &["plan", "p2_fig6", "--out", "new/"], &["not the name of a file"]);
    assert_eq!(files_in(folder.path()), ["file", "taken"]);
    assert_eq!(files_in(&folder.path().join("taken")), ["p2_fig6.svg"]);
    assert_eq!(std::fs::read_to_string(folder.path().join("file")).unwrap(), "mine");
}

#[test]
fn a_reader_that_went_away_is_no_error() {
    let folder = TempDir::new().unwrap();
    let mut main_job = command(folder.path(), &[]);
    let mut child = main_job.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Learning takes far longer than this, so the pipe is closed when the table is printed.
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
}

#[test]
fn a_board_makes_the_same_run_and_learns_the_same_map() {
    let folder = TempDir::new().unwrap();
    let arguments = |more: &[&'static str]| {
        [&["run", "p2_fig6", "--steps", "600", "--scalar", "fixed", "--json"][..], more].concat()
    };
    // A board has defaults of its own, and what a file leaves out is as it has it.
    let here = json(folder.path(), &arguments(&["--config", "boards"]));
    let output = run(folder.path(), &arguments(&["--link", "stub", "--verify"]));
    let there: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(there["result"], here["result"]);
    let said = stderr(&output);
    for words in ["connected to stub: board stub, scalar fixed", "lockstep", "× real time"] {
        assert!(said.contains(words), "{words} is missing in:\n{said}");
    }

    std::fs::write(folder.path().join("short.toml"), "[cooperative]\nmemory_ms = 250\n").unwrap();
    assert_ne!(json(folder.path(), &arguments(&["--link", "stub", "--config", "short.toml"])), there);
    std::fs::write(folder.path().join("movers.toml"), "[cooperative]\nmover_headway_s = 0.6\n").unwrap();
    let refused = arguments(&["--link", "stub", "--config", "movers.toml"]);
    assert_refused(folder.path(), &refused, &["cooperative.mover_headway_s", "0.6", "boards"]);

    let train = |more: &[&str]| {
        let output = run(folder.path(), &[&["train", "--steps", "60"][..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stdout(&output)
    };
    let here = train(&["--out", "here.ekm"]);
    let there = train(&["--out", "there.ekm", "--link", "stub", "--verify"]);
    assert_eq!(fact(&there, "state hash"), fact(&here, "state hash"));
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("there.ekm"), bytes("here.ekm"));
}

#[test]
fn a_board_can_be_asked_what_it_is_and_given_parameters() {
    let folder = TempDir::new().unwrap();
    let output = run(folder.path(), &["link", "stub", "--parameters", "--set", "robot.body_radius_m=0.03"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    assert_eq!(fact(&text, "board"), "stub");
    let row = fact(&text, "robot.body_radius_m");
    assert_eq!(row.split_whitespace().collect::<Vec<_>>(), ["0.03", "0.025", "m"], "{text}");
    let document = json(folder.path(), &["link", "stub", "--json"]);
    assert_eq!((&document["scalar"], &document["health"]["tick"]), (&Value::from("f32"), &Value::from(0)));

    let link = |more: &[&'static str]| [&["link", "stub"][..], more].concat();
    assert_refused(folder.path(), &link(&["--set", "robot.wheels=3"]), &["robot.wheels", "config --print"]);
    assert_refused(
        folder.path(),
        &link(&["--set", "robot.body_radius_m=-1"]),
        &["robot.body_radius_m", "must be"],
    );
    assert_refused(folder.path(), &link(&["--set", "robot.body_radius_m"]), &["NAME=VALUE"]);
    assert_refused(folder.path(), &["link", "usb:1"], &["usb:1", "tcp:HOST:PORT"]);
}

#[test]
fn a_board_that_is_not_there_or_cannot_do_it_is_said_so() {
    let folder = TempDir::new().unwrap();
    for (arguments, words) in [
        (&["run", "p2_fig6", "--link", "serial:/dev/ttyNONE7"][..], &["/dev/ttyNONE7", "plugged in"][..]),
        (&["train", "--link", "qemu:stm32f405", "--image", "none"], &["none", "cargo xtask firmware"]),
        (&["run", "p2_fig6", "--link", "qemu:stm32f405", "--real-time"], &["qemu:stm32f405:usart"]),
        (&["link", "tcp:127.0.0.1:1"], &["127.0.0.1:1", "hil_stub"]),
    ] {
        let output = run(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {}", stderr(&output));
        assert!(stdout(&output).is_empty(), "{arguments:?}");
        for word in words {
            assert!(stderr(&output).contains(word), "{arguments:?} must say {word}: {}", stderr(&output));
        }
    }
    let with_link = |arguments: &[&'static str]| [arguments, &["--link", "stub"]].concat();
    assert_refused(
        folder.path(),
        &with_link(&["run", "p2_fig6", "--runs", "2"]),
        &["--runs", "one run at a time"],
    );
    assert_refused(folder.path(), &with_link(&["train", "--trials", "2"]), &["--trials", "one map"]);
    assert_refused(folder.path(), &["run", "p2_fig6", "--verify"], &["--link"]);
    assert_refused(folder.path(), &["run", "p2_fig6", "--real-time"], &["--link"]);
}

#[test]
fn explain_says_why_in_text_json_and_picture() {
    let folder = TempDir::new().unwrap();
    let base = ["explain", "p2_fig4", "--steps", "300"];
    let text = ok(folder.path(), &[&base[..], &["--at", "2.0", "--out", "why.svg"]].concat());
    for words in ["decided at 1.920 s, 80 ms before", "winner", "target field", "open, armed", "why "] {
        assert!(text.contains(words), "`{words}` is missing in {text}");
    }
    let picture = std::fs::read_to_string(folder.path().join("why.svg")).unwrap();
    assert!(picture.contains("Decision at 1.920 s") && !picture.contains("NaN"), "{picture}");
    let document = json(folder.path(), &[&base[..], &["--tick", "2000", "--json"]].concat());
    let decision = &document["explanation"]["decision"];
    assert_eq!(decision["tick"], 1920);
    let best = decision["neurons"].as_array().unwrap().iter().map(|neuron| neuron["total"].as_f64().unwrap());
    assert_eq!(decision["winner"]["total"].as_f64(), best.reduce(f64::max));
    let fused = [&base[..], &["--at", "2", "--controller", "fusion"]].concat();
    assert!(ok(folder.path(), &fused).contains("target's share 0.42"));
    assert_refused(folder.path(), &base, &["--at <SECONDS>"]);
    assert_refused(folder.path(), &[&base[..], &["--at", "-3"]].concat(), &["-3"]);
    let late = [&base[..], &["--at", "100000"]].concat();
    assert_refused(folder.path(), &late, &["100000000", "earlier"]);
}

#[test]
fn robots_are_evaluated_with_and_without_separation_and_alike_on_any_number_of_threads() {
    let folder = TempDir::new().unwrap();
    let base = ["evaluate", "robots", "robots_corridor", "--steps", "300", "--runs", "2", "--json"];
    let document = |threads| json(folder.path(), &[&base[..], &["--threads", threads]].concat());
    let scenes = document("1")["scenes"].clone();
    assert_eq!(scenes, document("2")["scenes"]);
    let rows = scenes.as_array().unwrap();
    let separated: Vec<_> = rows.iter().map(|row| row["separation"].as_bool().unwrap()).collect();
    assert_eq!(separated, [true, false]);
    assert_ne!(rows[0]["hash"], rows[1]["hash"], "separation changes what the robots do");
    assert_eq!(rows[0]["runs"][1].as_array().unwrap().len(), 2, "two robots");

    ok(
        folder.path(),
        &["evaluate", "robots", "robots_corridor", "--steps", "300", "--runs", "1", "--out", "fig"],
    );
    let picture = std::fs::read_to_string(folder.path().join("fig/robots_corridor.svg")).unwrap();
    assert!(picture.contains("robot 2"), "{picture}");

    assert_refused(folder.path(), &["evaluate", "robots", "p2_fig4"], &["p2_fig4", "[[robots]]", "run"]);
    assert_refused(
        folder.path(),
        &["run", "robots_corridor"],
        &["one robot", "evaluate robots robots_corridor"],
    );
}
