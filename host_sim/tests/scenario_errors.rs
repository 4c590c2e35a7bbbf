//! Everything that can be wrong with a scenario is refused, with the file, the key, the value and a way out.

use host_sim::scenario::{Scenario, ScenarioError};

const FILE: &str = "room.toml";

/// A sound scenario in which each test breaks one thing.
const SOUND: &str = r#"
name = "room"
title = "A room"
source = "test"
time_limit_s = 60
checkpoints = [[0.5, 0.5], [0.9, 0.5]]

[robot]
start = [0.2, 0.5]
heading_deg = 0
jitter = { position_m = 0.01, heading_deg = 5 }

[control]
controller = "cooperative"
target_period_ms = 256

[noise]
sensor = 0.1
beam_half_width_deg = 7.5

[[walls]]
line = [[0.0, 0.0], [1.2, 0.0], [1.2, 1.0], [0.0, 1.0], [0.0, 0.0]]

[[obstacles]]
rectangle = [[0.65, 0.6], [0.75, 0.7]]

[[obstacles]]
centre = [0.7, 0.3]
radius_m = 0.05

[[movers]]
centre = [0.7, 0.8]
orbit_radius_m = 0.05
speed_m_s = 0.05

[[replace]]
checkpoint = 2
to = [1.0, 0.4]
at_s = 3
"#;

/// Its only wall.
const WALL: &str = "line = [[0.0, 0.0], [1.2, 0.0], [1.2, 1.0], [0.0, 1.0], [0.0, 0.0]]";

/// The complaint about the sound scenario with `from` exchanged for `to`.
#[track_caller]
fn complaint(from: &str, to: &str) -> ScenarioError {
    assert!(SOUND.contains(from), "{from:?} is not in the sound scenario");
    let text = SOUND.replacen(from, to, 1);
    match Scenario::parse(FILE, &text) {
        Ok(_) => panic!("accepted {to:?}"),
        Err(error) => error,
    }
}

/// Asserts that the change is refused at `key`, in a message with all of `parts`.
#[track_caller]
fn refused(from: &str, to: &str, key: &str, parts: &[&str]) {
    let error = complaint(from, to);
    let message = error.to_string();
    assert_eq!(error.key(), Some(key), "{message}");
    for part in [FILE, key].iter().chain(parts) {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
}

#[test]
fn the_sound_scenario_is_accepted() {
    let scenario = Scenario::parse(FILE, SOUND).unwrap();
    assert_eq!(scenario.world.movers.len(), 1);
    assert_eq!(scenario.solids.iter().map(|solid| solid.known).collect::<Vec<_>>(), [true, false, false]);
}

#[test]
fn movers_may_begin_elsewhere_in_each_run() {
    let text = SOUND.replace("speed_m_s = 0.05", "speed_m_s = 0.05\nphase_jitter_deg = 180");
    let world = Scenario::parse(FILE, &text).unwrap().world;
    assert_ne!(world.of_run(1).movers, world.of_run(2).movers);
    let sound = Scenario::parse(FILE, SOUND).unwrap().world;
    assert_eq!(sound.of_run(1).movers, sound.movers);
}

#[test]
fn a_name_that_is_neither_built_in_nor_a_file_lists_what_is() {
    let message = Scenario::load("p2_fig66").unwrap_err().to_string();
    assert!(message.contains("`p2_fig66`") && message.contains("did you mean `p2_fig6`?"), "{message}");
    assert!(Scenario::builtin_names().all(|name| message.contains(name)), "{message}");
}

#[test]
fn an_unreadable_file_is_named_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    let error = Scenario::load(path).unwrap_err();
    assert!(matches!(error, ScenarioError::Unreadable { .. }), "{error}");
    assert!(error.to_string().contains(path), "{error}");
}

#[test]
fn a_file_that_is_not_text_is_unreadable() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("noise.toml");
    std::fs::write(&path, [0xff, 0xfe, 0x00]).unwrap();
    let error = Scenario::load(path.to_str().unwrap()).unwrap_err();
    assert!(error.to_string().contains("noise.toml: cannot be read"), "{error}");
}

#[test]
fn a_file_is_loaded_by_its_path() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.toml");
    std::fs::write(&path, SOUND).unwrap();
    assert_eq!(Scenario::load(path.to_str().unwrap()).unwrap().name, "room");
}

#[test]
fn broken_toml_is_refused_with_line_and_column() {
    let error = complaint("time_limit_s = 60", "time_limit_s = = 60");
    assert!(matches!(error, ScenarioError::Syntax { line: 5, column: 16, .. }), "{error:?}");
    assert!(error.to_string().starts_with("room.toml:5:16: not valid TOML"), "{error}");
}

#[test]
fn an_unknown_key_is_refused_with_its_place_and_the_nearest_known_one() {
    refused(
        "radius_m = 0.05",
        "radios_m = 0.05",
        "obstacles[1].radios_m",
        &[":29:1", "did you mean `radius_m`?"],
    );
    refused("speed_m_s", "velocity", "movers[0].velocity", &["expected one of", "`speed_m_s`"]);
    refused("[noise]\n", "[noise]\ngain = 1\n", "noise.gain", &["`actuator`"]);
}

#[test]
fn a_missing_key_is_refused_with_the_table_it_belongs_to() {
    refused("time_limit_s = 60", "", "time_limit_s", &["missing", "add `time_limit_s = ...`"]);
    refused("start = [0.2, 0.5]", "", "robot.start", &["missing", "to `robot`"]);
    refused("orbit_radius_m = 0.05", "", "movers[0].orbit_radius_m", &["missing", "to `movers[0]`"]);
}

#[test]
fn a_value_of_the_wrong_kind_is_refused() {
    refused("time_limit_s = 60", "time_limit_s = \"long\"", "time_limit_s", &["\"long\"", "f64", ":5:16"]);
    refused("start = [0.2, 0.5]", "start = [0.2]", "robot.start", &["length"]);
    refused("= \"cooperative\"", "= \"cooperating\"", "control.controller", &["did you mean `cooperative`?"]);
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    refused("heading_deg = 0", "heading_deg = nan", "robot.heading_deg", &["NaN", "not a finite number"]);
    refused("start = [0.2, 0.5]", "start = [inf, 0.5]", "robot.start", &["[inf, 0.5]"]);
    refused("[0.9, 0.5]]", "[0.9, nan]]", "checkpoints[1]", &["[0.9, NaN]"]);
    refused("[1.2, 0.0]", "[-inf, 0.0]", "walls[0].line[1]", &["[-inf, 0]"]);
    refused("time_limit_s = 60", "time_limit_s = inf", "time_limit_s", &["inf"]);
}

#[test]
fn numbers_out_of_all_proportion_are_refused() {
    refused("time_limit_s = 60", "time_limit_s = 1e300", "time_limit_s", &["out of all proportion"]);
    refused("start = [0.2, 0.5]", "start = [0.2, -1e200]", "robot.start", &["ordinary size"]);
    refused("orbit_radius_m = 0.05", "orbit_radius_m = 1e-300", "movers[0].orbit_radius_m", &["too small"]);
}

#[test]
fn sizes_must_be_positive() {
    refused("radius_m = 0.05", "radius_m = -0.05", "obstacles[1].radius_m", &["-0.05", "greater than zero"]);
    refused("radius_m = 0.05", "radius_m = 0", "obstacles[1].radius_m", &["= 0:"]);
    refused(
        "orbit_radius_m = 0.05",
        "orbit_radius_m = 0",
        "movers[0].orbit_radius_m",
        &["greater than zero"],
    );
    refused("speed_m_s = 0.05", "speed_m_s = 0.05\nradius_m = -1", "movers[0].radius_m", &["-1"]);
    refused(
        "speed_m_s = 0.05",
        "speed_m_s = 0.05\nphase_jitter_deg = -1",
        "movers[0].phase_jitter_deg",
        &["-1", "must not be negative"],
    );
    refused("time_limit_s = 60", "time_limit_s = 0", "time_limit_s", &["greater than zero"]);
    refused("time_limit_s = 60", "time_limit_s = -5", "time_limit_s", &["-5"]);
    refused("time_limit_s = 60", "time_limit_s = 60\ntolerance_m = 0", "tolerance_m", &["greater than zero"]);
}

#[test]
fn speeds_jitter_and_noise_must_not_be_negative() {
    refused(
        "speed_m_s = 0.05",
        "speed_m_s = -0.05",
        "movers[0].speed_m_s",
        &["-0.05", "must not be negative"],
    );
    refused("position_m = 0.01", "position_m = -0.01", "robot.jitter.position_m", &["-0.01"]);
    refused("sensor = 0.1", "sensor = -0.1", "noise.sensor", &["-0.1"]);
    refused("sensor = 0.1", "pose_position_m = -1", "noise.pose_position_m", &["-1"]);
}

#[test]
fn noise_is_a_fraction_and_beams_do_not_overlap_their_neighbours() {
    refused("sensor = 0.1", "sensor = 10", "noise.sensor", &["= 10:", "0.1 for 10 %"]);
    refused("half_width_deg = 7.5", "half_width_deg = 45", "noise.beam_half_width_deg", &["45", "30"]);
}

#[test]
fn a_target_period_must_be_a_multiple_of_the_avoidance_period() {
    for period in ["0", "100", "300"] {
        let key = "control.target_period_ms";
        refused("= 256", &format!("= {period}"), key, &[period, "128 ms", "256 (P2) or 1024 (P1)"]);
    }
}

#[test]
fn texts_must_say_something_and_names_must_suit_a_file() {
    refused("name = \"room\"", "name = \"\"", "name", &["is empty"]);
    refused("title = \"A room\"", "title = \"  \"", "title", &["is empty"]);
    refused("source = \"test\"", "source = \"\"", "source", &["is empty"]);
    refused("name = \"room\"", "name = \"../room\"", "name", &["\"../room\"", "file name"]);
}

#[test]
fn a_robot_without_a_goal_is_refused() {
    let listed = "checkpoints = [[0.5, 0.5], [0.9, 0.5]]";
    refused(listed, "", "goal", &["nowhere to go", "add `goal = [x, y]`"]);
    refused(listed, "checkpoints = []", "goal", &["nowhere to go"]);
    refused(listed, "plan = true", "goal", &["nowhere to go"]);
}

#[test]
fn a_route_is_given_in_one_way() {
    let listed = "checkpoints = [[0.5, 0.5], [0.9, 0.5]]";
    refused(listed, &format!("{listed}\ngoal = [0.9, 0.5]"), "checkpoints", &["beside `goal`"]);
    refused(listed, &format!("{listed}\nplan = true"), "plan", &["leave `plan` out"]);
}

#[test]
fn a_start_in_or_at_a_wall_is_refused() {
    let start = "start = [0.2, 0.5]";
    refused(start, "start = [0.7, 0.65]", "robot.start", &["[0.7, 0.65]", "inside a wall"]);
    refused(start, "start = [0.02, 0.5]", "robot.start", &["0.0200 m", "more than 0.0350 m"]);
    // Clear by itself, but not wherever the jitter may put it.
    refused(start, "start = [0.03, 0.5]", "robot.start", &["0.0300 m", "jitter"]);
}

#[test]
fn a_start_on_a_closing_door_is_judged_at_time_zero() {
    let door = "rectangle = [[0.15, 0.45], [0.25, 0.55]]";
    let later = format!("{door}\nfrom_s = 2\n[[obstacles]]\ncentre = [0.7, 0.3]");
    let text = SOUND.replacen("centre = [0.7, 0.3]", &later, 1);
    assert!(Scenario::parse(FILE, &text).is_ok());
    let now = later.replace("from_s", "until_s");
    refused("centre = [0.7, 0.3]", &now, "robot.start", &["inside a wall"]);
}

#[test]
fn a_goal_or_checkpoint_in_contact_is_refused() {
    refused("[[0.5, 0.5],", "[[0.7, 0.37],", "checkpoints[0]", &["[0.7, 0.37]", "0.0200 m"]);
    refused("[[0.5, 0.5], [0.9, 0.5]]", "[[0.5, 0.5], [1.2, 0.5]]", "checkpoints[1]", &["inside a wall"]);
    refused("to = [1.0, 0.4]", "to = [1.19, 0.4]", "replace[0].to", &["[1.19, 0.4]", "0.0100 m"]);
    let text = SOUND.replacen("checkpoints = [[0.5, 0.5], [0.9, 0.5]]", "goal = [0.7, 0.3]", 1);
    let text = text.split("[[replace]]").next().unwrap();
    assert_eq!(Scenario::parse(FILE, text).unwrap_err().key(), Some("goal"));
}

#[test]
fn a_mover_that_hits_the_start_or_a_wall_is_refused() {
    refused(
        "centre = [0.7, 0.8]",
        "centre = [0.25, 0.5]",
        "movers[0].centre",
        &["hits the robot at its start"],
    );
    // The robot starts inside the circle, clear of the ring: that is allowed.
    let ring = SOUND.replacen(
        "centre = [0.7, 0.8]\norbit_radius_m = 0.05",
        "centre = [0.2, 0.5]\norbit_radius_m = 0.1",
        1,
    );
    assert!(Scenario::parse(FILE, &ring).is_ok());
    refused(
        "orbit_radius_m = 0.05",
        "orbit_radius_m = 0.18",
        "movers[0].orbit_radius_m",
        &["0.18", "runs through"],
    );
}

#[test]
fn a_solid_has_exactly_one_shape() {
    refused(
        "rectangle = [[0.65, 0.6], [0.75, 0.7]]",
        "",
        "obstacles[0]",
        &["exactly one shape", "`polygon`"],
    );
    refused("radius_m = 0.05", "", "obstacles[1].radius_m", &["needs a radius"]);
    refused(
        "radius_m = 0.05",
        "radius_m = 0.05\nline = [[0, 0], [1, 1]]",
        "obstacles[1]",
        &["exactly one shape"],
    );
    let rectangle = "rectangle = [[0.65, 0.6], [0.75, 0.7]]";
    refused(rectangle, "line = [[0.65, 0.6]]", "obstacles[0].line", &["fewer than two points"]);
    refused(rectangle, "rectangle = [[0.6, 0.6], [0.6, 0.7]]", "obstacles[0].rectangle", &["no area"]);
    let bow = "polygon = [[0.6, 0.6], [0.8, 0.8], [0.8, 0.6], [0.6, 0.7]]";
    refused(rectangle, bow, "obstacles[0].polygon", &["crosses or touches itself"]);
}

#[test]
fn a_solid_disappears_after_it_has_appeared() {
    refused("radius_m = 0.05", "radius_m = 0.05\nfrom_s = -1", "obstacles[1].from_s", &["-1"]);
    refused(
        "radius_m = 0.05",
        "radius_m = 0.05\nfrom_s = 4\nuntil_s = 4",
        "obstacles[1].until_s",
        &["from_s = 4"],
    );
}

#[test]
fn a_replacement_names_an_existing_checkpoint_and_one_trigger() {
    refused("checkpoint = 2", "checkpoint = 3", "replace[0].checkpoint", &["there are 2 checkpoints"]);
    refused("checkpoint = 2", "checkpoint = 0", "replace[0].checkpoint", &["count from 1"]);
    refused("at_s = 3", "", "replace[0]", &["exactly one trigger"]);
    refused("at_s = 3", "at_s = 3\nafter_checkpoint = 1", "replace[0]", &["exactly one trigger"]);
    refused("at_s = 3", "at_s = 60", "replace[0].at_s", &["time limit"]);
    refused("at_s = 3", "after_checkpoint = 2", "replace[0].after_checkpoint", &["earlier checkpoint"]);
    refused("at_s = 3", "after_checkpoint = 1\ndelay_s = -1", "replace[0].delay_s", &["-1"]);
    let planned = "goal = [0.9, 0.5]\nplan = true";
    refused(
        "checkpoints = [[0.5, 0.5], [0.9, 0.5]]",
        planned,
        "replace[0]",
        &["`checkpoints` instead of `plan`"],
    );
}

#[test]
fn further_robots_need_a_goal_and_room() {
    let robot = |keys: &str| format!("[[walls]]\n{WALL}\n[[robots]]\n{keys}\n");
    let refused_robot = |keys: &str, key: &str, parts: &[&str]| {
        refused(&format!("[[walls]]\n{WALL}\n"), &robot(keys), key, parts);
    };
    refused_robot("start = [0.4, 0.2]", "robots[0]", &["where the robot goes", "goal = [x, y]"]);
    refused_robot(
        "start = [0.25, 0.5]\ngoal = [0.2, 0.2]",
        "robots[0].start",
        &["[0.25, 0.5]", "0.0500", "0.0600"],
    );
    refused_robot("start = [0.4, 0.2]\ngoal = [0.9, 0.53]", "robots[0].goal", &["0.0300", "move them apart"]);
    refused_robot("start = [0.7, 0.3]\ngoal = [0.2, 0.2]", "robots[0].start", &["inside"]);
    refused_robot("start = [0.4, 0.2]\ngoal = [0.7, 0.3]", "robots[0].goal", &["inside"]);
    let sound = SOUND.replace("[[walls]]", "[[robots]]\nstart = [0.4, 0.2]\ngoal = [0.2, 0.2]\n[[walls]]");
    let scenario = Scenario::parse(FILE, &sound).unwrap();
    assert_eq!(scenario.robot_count(), 2);
    let second = scenario.of_robot(1);
    let place = |x, y| nalgebra::Point2::new(x, y);
    assert_eq!((second.start.position, second.goal()), (place(0.4, 0.2), Some(place(0.2, 0.2))));
    assert_eq!(second.robot_count(), 1);
    assert_eq!(scenario.of_robot(0).start, scenario.start);
}
