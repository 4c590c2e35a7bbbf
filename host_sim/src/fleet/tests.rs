use controller_core::config::Config;
use nalgebra::Point2;

use super::{Company, run};
use crate::mission::MissionOptions;
use crate::scenario::Scenario;
use crate::sil::{HostMap, Indirect};
use crate::sweep::{self, learn};
use crate::training::TrainingPlan;

fn map() -> HostMap<f32, Indirect<f32>> {
    let plan = TrainingPlan { steps: 800, ..TrainingPlan::default() };
    learn::<f32, Indirect<f32>>(&Config::default(), &plan, &|| ()).unwrap().map
}

const OPTIONS: MissionOptions = MissionOptions { seed: 5, sample_ms: 1 };

#[test]
fn bodies_never_overlap_and_all_arrive() {
    let scenario = Scenario::builtin("robots_crossing").unwrap();
    let results = run(&scenario, &Config::default(), None, &map(), OPTIONS, Company::Told).unwrap();
    assert_eq!(results.len(), 4);
    assert!(results.iter().all(|result| result.success), "{results:?}");
    let place = |robot: usize, at: usize| {
        // A robot that is at its goal stays there.
        let samples = &results[robot].samples;
        samples.get(at).or(samples.last()).map(|sample| Point2::new(sample.x_m, sample.y_m)).unwrap()
    };
    let longest = results.iter().map(|result| result.samples.len()).max().unwrap();
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    let nearest = (0..longest).flat_map(|at| pairs.map(|(a, b)| (place(a, at) - place(b, at)).norm()));
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    // The log ends at the goal, a robot rolls on for a fraction of a millimetre.
    assert!(nearest > 0.05 - 1e-4, "the centres came as near as {nearest} m");
    assert!(nearest < 0.3, "and they met at all");
}

#[test]
fn robots_that_touch_are_seen_to_touch() {
    // Blind, deaf and head-on, both on the same line.
    let text = Scenario::builtin_text("robots_corridor").unwrap();
    let text = text.replace("jitter = { position_m = 0.02, heading_deg = 20 }", "");
    let scenario = Scenario::parse("test", &text).unwrap();
    let mut config = Config::default();
    config.robot.sensor_range_m = 0.01;
    let results = run(&scenario, &config, None, &map(), OPTIONS, Company::Silent).unwrap();
    assert!(results.iter().map(|result| result.contacts).sum::<u32>() > 0);
    assert!(results.iter().any(|result| !result.success));
    for at in 0..results[0].samples.len().min(results[1].samples.len()) {
        let [a, b] = [0, 1].map(|robot| &results[robot].samples[at]);
        let apart = (Point2::new(a.x_m, a.y_m) - Point2::new(b.x_m, b.y_m)).norm();
        assert!(apart > 0.05 - 1e-9, "bodies are solid: {apart} m at {} s", a.t_s);
    }
}

#[test]
fn a_robot_out_of_reach_of_the_others_drives_as_if_alone() {
    let text = Scenario::builtin_text("robots_corridor").unwrap();
    // The other one stands where it starts, 4 m away.
    let text = text.replace("start = [1.1, 0.1]", "start = [4.1, 0.1]");
    let text = text.replace("goal = [0.1, 0.1]", "goal = [4.0, 0.1]");
    let scenario = Scenario::parse("test", &text).unwrap();
    let (config, map) = (Config::default(), map());
    let together = run(&scenario, &config, None, &map, OPTIONS, Company::Told).unwrap();
    let alone = sweep::run_one(&scenario.of_robot(0), &config.clone().into(), None, &map, OPTIONS).unwrap();
    let (first, log) = (&together[0], alone.samples.len().min(together[0].samples.len()));
    assert_eq!(first.samples[..log], alone.samples[..log]);
    assert_eq!((first.arrivals.len(), first.contacts), (alone.arrivals.len(), 0));
}
