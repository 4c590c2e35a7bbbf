//! `bench` on worlds that others drew, as a user runs it.
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, which clippy.toml cannot know")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use host_sim::benchmark::Ground;
use host_sim::import::{GridMap, moving_ai};
use serde_json::Value;
use tempfile::TempDir;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/worlds").join(name)
}

fn host_sim(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_host_sim")).args(arguments).output().expect("host_sim starts")
}

/// A short training will do: the worlds are easy.
fn bench(arguments: &[&str]) -> Output {
    let quick = ["--steps", "500", "--runs", "1"];
    host_sim(&[&["bench"], arguments, &quick].concat())
}

fn json(output: &Output) -> Value {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON document")
}

/// The complaint of a request that cannot be carried out.
fn refused(arguments: &[&str]) -> String {
    let output = bench(arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    String::from_utf8(output.stderr).expect("text")
}

#[test]
fn barn_scores_runs_and_draws_them() {
    let folder = TempDir::new().unwrap();
    let (world, out) = (data("barn_000_W.json"), folder.path().to_str().unwrap());
    let arguments = ["barn", world.to_str().unwrap(), "--planned", "--json", "--out", out];
    let document = json(&bench(&arguments));
    let run = &document["runs"][0];
    let (time_share, score) = (run["time_share"].as_f64().unwrap(), run["score"].as_f64().unwrap());
    assert_eq!(run["end"], "goal");
    assert!((score - 1.0 / time_share.clamp(2.0, 8.0)).abs() < 1e-9, "{run}");
    assert_eq!(document["scales"][0]["scale"], "W");
    assert_eq!(document["runs"].as_array().map(Vec::len), Some(1), "decapitated was not asked for");
    let csv = std::fs::read_to_string(folder.path().join("barn_runs.csv")).unwrap();
    assert!(csv.lines().nth(1).unwrap().starts_with("barn_000_W,planned,1,goal,"), "{csv}");
    for name in ["barn_plans.csv", "barn_000_W.svg"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
    let again = json(&bench(&[&arguments[..], &["--threads", "1"]].concat()));
    assert_eq!(again["runs"], document["runs"]);
}

#[test]
fn barn_takes_a_folder_and_a_scale() {
    let folder = TempDir::new().unwrap();
    std::fs::copy(data("world_0.world"), folder.path().join("world_0.world")).unwrap();
    let document =
        json(&bench(&["barn", folder.path().to_str().unwrap(), "--scale", "c", "--decapitated", "--json"]));
    assert_eq!(document["scales"][0]["scale"], "C");
    assert_eq!(document["runs"][0]["kind"], "decapitated");
    let empty = TempDir::new().unwrap();
    assert!(refused(&["barn", empty.path().to_str().unwrap()]).contains("no .json and no .world"));
}

#[test]
fn moving_ai_plans_all_problems_and_drives_some() {
    let (map, problems) = (data("room-32-32-4.map"), data("room-32-32-4.scen"));
    let files = [map.to_str().unwrap(), problems.to_str().unwrap()];
    let document = json(&bench(&["movingai", files[0], files[1], "--problems", "1", "--planned", "--json"]));
    assert_eq!(document["plans"]["found"]["count"], 40);
    assert_eq!(document["plans"]["found"]["runs"], 40);
    assert!(document["plans"]["length_over_reference"]["most"].as_f64().unwrap() < 1.1);
    assert_eq!(document["runs"].as_array().map(Vec::len), Some(1));
    let only_plans = bench(&["movingai", files[0], files[1], "--problems", "0"]);
    assert!(String::from_utf8_lossy(&only_plans.stdout).contains("40 of 40"));
    assert!(refused(&["movingai", files[1], files[0]]).contains("line 1"));
    assert!(refused(&["movingai", files[0], files[1], "--cell=-1"]).contains("--cell"));
    // A body of 5 cm in cells of 2 cm: places in walls are an answer, not a wrong request.
    assert!(bench(&["movingai", files[0], files[1], "--cell", "0.02", "--problems", "0"]).status.success());
}

/// Runs plan anew under way, on a thread of the pool, where a large planner was once more than the stack. Half of
/// what a thread has by default must do: how much is on the stack depends on how the build is optimised.
#[test]
fn plans_need_little_stack() {
    let small = moving_ai::load_map(&data("random-32-32-10.map"), 0.1).unwrap();
    // Four by four of them side by side: more cells than the small planner has.
    let side = 4;
    let (columns, rows) = (side * small.columns, side * small.rows);
    let cell = |row: usize, column: usize| small.is_passable(column % small.columns, row % small.rows);
    let passable = (0..rows)
        .flat_map(|row| {
            let cell = &cell;
            (0..columns).map(move |column| cell(row, column))
        })
        .collect();
    let large = GridMap { columns, rows, passable, ..small.clone() };
    let plan = move || {
        [small, large].map(|map| {
            let ground = Ground::new(map).unwrap();
            let (from, goal) = ground.draw(1).unwrap();
            ground.route(from, goal).map(|route| route.plan.cells)
        })
    };
    let thread = std::thread::Builder::new().stack_size(1024 * 1024).spawn(plan).unwrap();
    let [few, many] = thread.join().unwrap().map(Result::unwrap);
    assert!(few < 1024 && many > 1024, "{few} {many}");
}

#[test]
fn a_ros_map_is_driven_between_places_of_its_own_frame() {
    let map = data("tb3_sandbox.yaml");
    let map = [map.to_str().unwrap(), "--scale", "0.2381"];
    let places = ["--from=-0.48,-0.12", "--to=-0.36,0.0"];
    let document = json(&bench(&[&["map"], &map[..], &places, &["--planned", "--json"]].concat()));
    assert_eq!(document["runs"][0]["end"], "goal", "{document}");
    let pairs = json(&bench(&[&["map"], &map[..], &["--pairs", "2", "--planned", "--json"]].concat()));
    assert_eq!(pairs["plans"]["found"]["runs"], 2);
    assert!(refused(&["map", map[0], "--scale", "nan"]).contains("--scale"));
    assert!(refused(&["map", map[0], "--from", "1"]).contains("--from"));
    assert!(refused(&["map", data("tb3_sandbox.pgm").to_str().unwrap()]).contains("tb3_sandbox.pgm"));
}

#[test]
fn broken_files_are_refused_by_name() {
    let folder = TempDir::new().unwrap();
    let write = |name: &str, content: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let yaml = b"image: a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n\
        occupied_thresh: 0.65\nfree_thresh: 0.2\n";
    for (kind, name, content, said) in [
        ("barn", "a.json", &b"{\"start\": [0, 0]}"[..], "start"),
        ("barn", "b.json", b"\xff\xfe", "UTF-8"),
        ("barn", "a.world", b"<sdf", "no XML"),
        ("map", "a.yaml", yaml, "a.pgm"),
        ("map", "b.yaml", b"image: 3", "b.yaml"),
    ] {
        let file = write(name, content);
        let complaint = refused(&[kind, &file]);
        assert!(complaint.contains(name) || complaint.contains(said), "{complaint}");
        assert!(complaint.contains(said), "{complaint}");
    }
    write("a.pgm", b"P5 2 2 255\n12");
    assert!(refused(&["map", folder.path().join("a.yaml").to_str().unwrap()]).contains("2 bytes"));
    assert!(refused(&["barn", "no/such.json"]).contains("no/such.json"));
}
