//! Pictures say what they show, in valid SVG, and the same picture is the same text.

use host_sim::figure::{PathTrace, TracePose, draw_run};
use host_sim::scenario::Scenario;
use nalgebra::Point2;

/// Start, and every checkpoint, and each outlined pose are circles; so are dots in the legend.
fn circles(picture: &str) -> usize {
    picture.matches("<circle").count()
}

/// A drive along the bottom of the rooms: 2.5 s in steps of 0.1 s.
fn trace(label: &str) -> PathTrace {
    let pose = |step: i32| {
        let t_s = f64::from(step) * 0.1;
        TracePose { t_s, position: Point2::new(0.1 + 0.1 * t_s, 0.1), heading_rad: 0.0 }
    };
    PathTrace { label: label.to_owned(), poses: (0..=25).map(pose).collect() }
}

#[test]
fn every_builtin_scenario_can_be_drawn_and_says_what_it_is() {
    for name in Scenario::builtin_names() {
        let scenario = Scenario::builtin(name).unwrap();
        let picture = draw_run(&scenario, &[]);
        for text in [&scenario.title, &scenario.source, name, "10 cm", "known wall", "start", "goal"] {
            assert!(picture.contains(text), "{name} does not say {text:?}");
        }
        assert_eq!(picture.contains("unforeseen obstacle"), scenario.solids.iter().any(|solid| !solid.known));
        assert_eq!(picture.contains("circling robot"), !scenario.world.movers.is_empty());
        assert_eq!(picture.contains("new checkpoint"), !scenario.replacements.is_empty());
        assert!(!picture.contains("NaN") && !picture.contains("inf"), "{name}");
        assert_eq!(picture, draw_run(&scenario, &[]));
    }
}

#[test]
fn a_path_carries_an_outline_each_second_and_at_its_end() {
    let scenario = Scenario::builtin("p2_fig6").unwrap();
    let empty = circles(&draw_run(&scenario, &[]));
    // At 0, 1, 2 and 2.5 s.
    assert_eq!(circles(&draw_run(&scenario, &[trace("a")])), empty + 4);
}

#[test]
fn a_bundle_of_paths_is_drawn_without_outlines() {
    let scenario = Scenario::builtin("p2_fig6").unwrap();
    let bundle: Vec<PathTrace> = (0..20).map(|_| trace("a")).collect();
    let picture = draw_run(&scenario, &bundle);
    assert_eq!(circles(&picture), circles(&draw_run(&scenario, &[])));
    assert_eq!(picture.matches(">\na\n<").count(), 1, "one entry in the legend for one label");
}

#[test]
fn paths_of_different_labels_differ_in_colour() {
    let scenario = Scenario::builtin("p2_fig6").unwrap();
    let colours = |labels: [&str; 2]| {
        let picture = draw_run(&scenario, &labels.map(trace));
        ["#0b62b0", "#d1495b"].map(|colour| picture.contains(colour))
    };
    assert_eq!(colours(["a", "b"]), [true, true]);
    assert_eq!(colours(["a", "a"]), [true, false]);
}

#[test]
fn a_path_without_poses_is_no_trouble() {
    let scenario = Scenario::builtin("p2_fig4").unwrap();
    let nothing = PathTrace { label: "stuck".to_owned(), poses: Vec::new() };
    assert!(draw_run(&scenario, &[nothing]).contains("stuck"));
}

#[test]
fn markup_in_a_title_is_only_text() {
    let mut scenario = Scenario::builtin("p2_fig4").unwrap();
    scenario.title = "<b>5 < 6 & 7</b>".to_owned();
    let picture = draw_run(&scenario, &[]);
    assert!(!picture.contains("<b>"));
    assert!(picture.contains("&lt;b&gt;5 &lt; 6 &amp; 7"), "{picture}");
}

#[test]
fn a_planners_checkpoints_are_numbered_up_to_the_goal() {
    let scenario = Scenario::builtin("p2_fig6").unwrap();
    let goal = scenario.goal().unwrap();
    let count =
        |picture: &str| ["1", "2", "goal"].map(|label| picture.matches(&format!("\n{label}\n")).count());
    assert_eq!(count(&draw_run(&scenario, &[])), [0, 0, 2], "the mark and the legend");
    let planned = scenario.with_checkpoints(vec![Point2::new(0.55, 0.2), Point2::new(1.11, 0.5), goal]);
    assert_eq!(count(&draw_run(&planned, &[])), [1, 1, 1]);
}
