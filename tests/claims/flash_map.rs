//! A map that is built into firmware is the file's, bit for bit, and one that does not fit fails the build.
//!
//! * **Claim**: an image holds the very weights that the simulator learned, in the board's own number type.
//! * **Method**: what the firmware's build script makes of a map file is read back and compared with the map; files
//!   that do not fit a board or its robot are offered. That the board then drives with it is shown by `pil`.
//! * **Paper**: none.
//! * **Tolerance**: none.
#![expect(
    clippy::unwrap_used,
    reason = "clippy.toml allows it in #[test] functions; the helpers here are part of them"
)]

use std::path::Path;

use controller_core::config::Config;
use controller_core::kohonen::lattice::NeuronIndex;
use controller_core::scalar::Fixed;
use host_sim::map_store::{StoredScalar, to_bytes};
use host_sim::sil::{HostMap, Indirect};
use host_sim::sweep::learn;
use host_sim::training::TrainingPlan;
use protocol::convert::neuron_index;
use protocol::message::{COLUMNS, ROWS, ScalarKind};

#[path = "../../firmware/build_map.rs"]
mod build_map;

const STEPS: u32 = 40;

fn learned<S: StoredScalar>(config: &Config) -> (HostMap<S, Indirect<S>>, Vec<u8>) {
    let plan = TrainingPlan { steps: STEPS, ..TrainingPlan::default() };
    let map = learn::<S, Indirect<S>>(config, &plan, &|| ()).unwrap().map;
    let file = to_bytes(&map, config, plan.seed, plan.steps).unwrap();
    (map, file)
}

/// The numbers between the last `start` and the next `]` of a line.
fn numbers<T: core::str::FromStr<Err: core::fmt::Debug>>(line: &str, start: &str) -> Vec<T> {
    let (_, rest) = line.rsplit_once(start).unwrap();
    let (list, _) = rest.split_once(']').unwrap();
    list.split(", ").map(|number| number.parse().unwrap()).collect()
}

/// The table holds what `bits` makes of the map's neurons, column by column, and which of them have won.
fn holds_the_map<S: StoredScalar>(bits: impl Fn(S::Weight) -> i64) {
    let (map, file) = learned::<S>(&Config::default());
    let text = build_map::table(&file, S::KIND).unwrap();
    let indices = || (0..).map_while(neuron_index::<COLUMNS, ROWS>);
    let expected: Vec<Vec<i64>> = indices()
        .map(|index| {
            let neuron = map.neuron(index);
            let ([a, b], [c, d]) = (neuron.output.left, neuron.output.right);
            [neuron.bearing, neuron.distance, a, b, c, d].map(&bits).to_vec()
        })
        .collect();
    let lines = text.lines().filter(|line| line.trim_start().starts_with("neuron(["));
    assert_eq!(lines.map(|line| numbers::<i64>(line, "([")).collect::<Vec<_>>(), expected);
    let won = text.lines().find(|line| line.contains("won: [")).unwrap();
    let won = numbers::<u32>(won, "won: [");
    let has_won = |index: NeuronIndex| won[usize::from(index.column)] >> index.row & 1 == 1;
    assert!(indices().all(|index| has_won(index) == map.has_won(index)) && map.is_trained());
    assert!(text.contains(&format!("trained_steps: {STEPS},")), "{text}");
}

#[test]
fn the_table_holds_the_map_bit_for_bit() {
    holds_the_map::<f32>(|weight| i64::from(weight.to_bits()));
    holds_the_map::<Fixed>(|weight| i64::from(weight.to_bits()));
}

#[test]
fn without_a_file_there_is_no_table() {
    let text = build_map::source(None, ScalarKind::F32).unwrap();
    assert!(text.contains("IN_FLASH: Option<&FlashMap> = None;"), "{text}");
    let missing = build_map::source(Some(Path::new("no/map.ekm")), ScalarKind::Fixed).unwrap_err();
    assert!(missing.starts_with("no/map.ekm: cannot be read"), "{missing}");
    assert!(missing.contains("train --scalar fixed --out"), "{missing}");
}

#[test]
fn what_does_not_fit_fails_the_build_and_says_why() {
    let (_, file) = learned::<f32>(&Config::default());
    let refused = |file: &[u8], scalar: ScalarKind, words: &[&str]| {
        let message = build_map::table(file, scalar).unwrap_err();
        for word in words {
            assert!(message.contains(word), "`{word}` is missing: {message}");
        }
    };
    let words = ["scalar f32, not fixed", "for this board", "train --scalar fixed --out"];
    refused(&file, ScalarKind::Fixed, &words);
    refused(b"# A map\n", ScalarKind::F32, &["not a map file", "train --scalar f32 --out"]);
    refused(&file[..500], ScalarKind::F32, &["has been cut: 500 bytes"]);
    let mut damaged = file.clone();
    damaged[1000] ^= 1;
    refused(&damaged, ScalarKind::F32, &["is damaged"]);

    let of_robot = |change: fn(&mut Config)| {
        let mut config = Config::default();
        change(&mut config);
        learned::<f32>(&config).1
    };
    let wider = of_robot(|config| config.robot.wheel_base_m = 0.06);
    refused(&wider, ScalarKind::F32, &["robot.wheel_base_m = 0.06", "has 0.053", "train on that robot"]);
    let faster = of_robot(|config| config.robot.speed_limit_mps = 0.18);
    refused(&faster, ScalarKind::F32, &["robot.speed_limit_mps = 0.18", "has 0.16"]);
    let shorter = of_robot(|config| config.schedule.step_ms = 768);
    refused(&shorter, ScalarKind::F32, &["the reach of a step in m"]);

    let nothing = HostMap::<f32, Indirect<f32>>::regular();
    let nothing = to_bytes(&nothing, &Config::default(), 1, 1).unwrap();
    refused(&nothing, ScalarKind::F32, &["none of its neurons has learned anything"]);
}
