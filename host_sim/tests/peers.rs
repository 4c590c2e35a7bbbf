//! The peers on the simplest ways that there are; how good they are beyond is measured, not tested.
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, which clippy.toml cannot know")]

use host_sim::contender::Contender;
use host_sim::mission::{MissionOptions, MissionResult};
use host_sim::scenario::Scenario;
use host_sim::settings::Settings;
use host_sim::sil::{HostMap, Indirect};
use host_sim::sweep::{SweepError, run_one};

/// A closed room of 1 m by 0.6 m, from left to right, and what stands in it.
fn room(things: &str) -> Scenario {
    let text = format!(
        "name = \"room\"\ntitle = \"A room\"\nsource = \"ours\"\ntime_limit_s = 60\ngoal = [0.85, 0.30]\n\
         [robot]\nstart = [0.15, 0.30]\njitter = {{ position_m = 0.01, heading_deg = 30 }}\n\
         [[walls]]\nline = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.6], [0.0, 0.6], [0.0, 0.0]]\n{things}"
    );
    Scenario::parse("room.toml", &text).unwrap_or_else(|error| panic!("{error}"))
}

fn run(scenario: &Scenario, contender: Contender, seed: u64) -> MissionResult {
    let map: HostMap<f32, Indirect<f32>> = HostMap::regular();
    let options = MissionOptions { seed, sample_ms: 0 };
    run_one(scenario, &Settings::default(), Some(contender), &map, options).unwrap()
}

fn peers() -> impl Iterator<Item = Contender> {
    Contender::ALL.into_iter().filter(|contender| contender.is_peer())
}

fn assert_passes(scenario: &Scenario) {
    for contender in peers() {
        for seed in 1..=5 {
            let result = run(scenario, contender, seed);
            assert!(result.success, "{contender:?}, seed {seed}: {result:?}");
            assert!(result.arrivals[0].error_m < 0.0015, "{contender:?} stops at {:?}", result.arrivals);
        }
    }
}

#[test]
fn every_peer_crosses_an_empty_room_and_stops_at_the_goal() {
    assert_passes(&room(""));
}

#[test]
fn every_peer_goes_around_a_post() {
    assert_passes(&room("[[obstacles]]\ncentre = [0.5, 0.31]\nradius_m = 0.05\n"));
}

#[test]
fn every_peer_passes_a_doorway_of_20_cm() {
    assert_passes(&room(
        "[[obstacles]]\nrectangle = [[0.48, 0.0], [0.52, 0.2]]\n\
         [[obstacles]]\nrectangle = [[0.48, 0.4], [0.52, 0.6]]\n",
    ));
}

#[test]
fn a_goal_behind_a_wall_without_a_door_is_not_reached() {
    let scenario = room("[[obstacles]]\nrectangle = [[0.48, 0.0], [0.52, 0.6]]\n");
    for contender in peers() {
        assert!(!run(&scenario, contender, 1).reached, "{contender:?} went through a wall");
    }
}

#[test]
fn a_run_repeats_bit_for_bit_and_every_peer_and_seed_is_another_run() {
    let scenario = room("[[obstacles]]\ncentre = [0.5, 0.31]\nradius_m = 0.05\n");
    let mut hashes = std::collections::BTreeSet::new();
    for contender in peers() {
        for seed in [1, 2] {
            let result = run(&scenario, contender, seed);
            assert_eq!(result, run(&scenario, contender, seed), "{contender:?}, seed {seed}");
            assert!(hashes.insert(result.hash), "{contender:?}, seed {seed}");
        }
    }
}

#[test]
fn numbers_that_make_no_sense_are_refused_before_the_run() {
    let mut settings = Settings::default();
    settings.peers.vfh.cell_m = 0.0;
    let map: HostMap<f32, Indirect<f32>> = HostMap::regular();
    let options = MissionOptions { seed: 1, sample_ms: 0 };
    let error = run_one(&room(""), &settings, Some(Contender::VfhPlus), &map, options).unwrap_err();
    assert!(matches!(error, SweepError::Peers(_)), "{error}");
    assert_eq!(error.to_string(), "peers.vfh.cell_m = 0: must be between 0.001 and 0.1");
}
