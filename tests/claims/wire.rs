//! Nothing that comes over the link makes a board panic, or drive when it must not.
//!
//! * **Goal**: bytes of any kind, and whole frames with bodies of any kind, are refused or mean one thing; a board
//!   answers each request once, and its motors stand still while an emergency stop lasts or nobody is there.
//! * **Method**: `tests/src/wire.rs` says what must hold. Fuzz targets look for bytes that break it; this test
//!   replays what they begin from, so that every build checks it. `docs/fuzzing.md` has the figures.
//! * **Tolerance**: none.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::fs;
use std::path::{Path, PathBuf};

use controller_core::controller::Mode;
use controller_core::units::{Point, Pose};
use protocol::codec::{Message, to_slice};
use protocol::frame::{DELIMITER, FRAME_BYTES_MAX, encode};
use protocol::map_file::NeuronRecord;
use protocol::message::{
    COLUMNS, Checkpoints, FromBoard, FromHost, MapRequest, NEURONS_PER_MESSAGE, Neurons, ParameterValue,
    Parameters, ROWS, Readings, SENSORS, Scan, TimeBase,
};
use tests::wire::{any_bodies, any_bytes, hello};

fn folder(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds").join(target)
}

fn replay(target: &str, check: fn(&[u8])) {
    let mut count = 0;
    for entry in fs::read_dir(folder(target)).unwrap() {
        let path = entry.unwrap().path();
        println!("{}", path.display());
        check(&fs::read(&path).unwrap());
        count += 1;
    }
    assert!(count > 20, "{count} seeds of {target}");
}

#[test]
fn bytes_of_any_kind() {
    replay("decoder", any_bytes);
}

#[test]
fn bodies_of_any_kind() {
    replay("bodies", any_bodies);
}

/// Makes the seeds anew, when messages have changed: `cargo test -p tests --test wire -- --ignored`.
#[test]
#[ignore = "writes into the source tree"]
fn write_the_seeds() {
    for (target, seeds) in [("decoder", streams()), ("bodies", conversations())] {
        let folder = folder(target);
        fs::create_dir_all(&folder).unwrap();
        for (name, bytes) in seeds {
            fs::write(folder.join(name), bytes).unwrap();
        }
    }
}

const POINT: Point<f32> = Point { x_m: 0.5, y_m: 0.125 };

fn readings(tick: u64, scan: bool) -> Readings {
    let ranges_m = core::array::from_fn(|i| (i < 2).then_some(0.0625));
    Readings {
        tick,
        pose_fix: scan.then_some(Pose { x_m: 0.25, y_m: 0.0, heading_rad: 0.0 }),
        scan: scan.then_some(Scan { ranges_m }),
        ..Readings::default()
    }
}

/// Some neurons of every part of a map, which drive straight at full speed.
fn map() -> impl Iterator<Item = FromHost> {
    let record = |number: usize| NeuronRecord {
        bearing_rad: [-1.5, -0.75, 0.0, 0.75, 1.5][number / ROWS * 5 / COLUMNS],
        distance_per_reach: [0.0, 0.5, 1.0][number % ROWS * 3 / ROWS],
        left: [-0.5, 1.0],
        right: [0.5, 1.0],
        has_won: true,
    };
    (0..COLUMNS * ROWS).step_by(9 * NEURONS_PER_MESSAGE).map(move |first| {
        let neurons = (first..first + NEURONS_PER_MESSAGE).map(record).collect();
        FromHost::Map(MapRequest::Write(Neurons { first: u16::try_from(first).unwrap(), neurons }))
    })
}

/// One of each request, and of each form of it.
fn all_requests() -> Vec<FromHost> {
    let one_neuron = Neurons {
        first: 224,
        neurons: heapless::Vec::from_slice(&[NeuronRecord { has_won: true, ..NeuronRecord::default() }])
            .unwrap(),
    };
    let points = || heapless::Vec::from_slice(&[POINT; 2]).unwrap();
    vec![
        FromHost::Hello(hello(TimeBase::Lockstep)),
        FromHost::Hello(hello(TimeBase::RealTime)),
        FromHost::Step(readings(0, false)),
        FromHost::Step(Readings { exploration: Some([0.5, -0.5]), ..readings(0, true) }),
        FromHost::Checkpoints(Checkpoints::ReplaceAll(points())),
        FromHost::Checkpoints(Checkpoints::Append(points())),
        FromHost::Checkpoints(Checkpoints::ReplaceOne { index: 1, point: POINT }),
        FromHost::Checkpoints(Checkpoints::Clear),
        FromHost::Arm,
        FromHost::Disarm,
        FromHost::EStop,
        FromHost::Sense(readings(0, true)),
        FromHost::Begin,
        FromHost::Mode(Mode::Standby),
        FromHost::Mode(Mode::Learn),
        FromHost::Mode(Mode::Navigate),
        FromHost::Parameters(Parameters::Get { index: 3 }),
        FromHost::Parameters(Parameters::Set(ParameterValue { index: 3, value: 0.25 })),
        FromHost::Parameters(Parameters::Commit),
        FromHost::Parameters(Parameters::Defaults),
        FromHost::Map(MapRequest::Describe),
        FromHost::Map(MapRequest::Read { first: 220 }),
        FromHost::Map(MapRequest::Write(one_neuron)),
        FromHost::Map(MapRequest::Confirm { trained_steps: 1000, hash: 1 }),
        FromHost::Map(MapRequest::Forget),
        FromHost::Health,
        FromHost::Telemetry,
        FromHost::Fields { column: 7 },
    ]
}

fn name<M: core::fmt::Debug>(number: usize, message: &M) -> String {
    let text = format!("{message:?}");
    let word = text.split(|c: char| !c.is_alphanumeric()).next().unwrap().to_lowercase();
    format!("{number:02}_{word}")
}

fn framed<M: Message>(sequence: u8, message: &M) -> Vec<u8> {
    encode(sequence, message, &mut [0; FRAME_BYTES_MAX]).unwrap().to_vec()
}

/// For `any_bytes`: frames alone and one after the other, and damage of each kind.
fn streams() -> Vec<(String, Vec<u8>)> {
    let requests = all_requests();
    let mut seeds: Vec<_> =
        (0..).zip(&requests).map(|(i, request)| (name(i, request), framed(1, request))).collect();
    let replies = [FromBoard::Done, FromBoard::Hello(hello(TimeBase::Lockstep))];
    seeds.extend((50..).zip(&replies).map(|(i, reply)| (name(i, reply), framed(1, reply))));
    let arm = framed(7, &FromHost::Arm);
    let cut = &arm[..arm.len() - 3];
    let mut flipped = arm.clone();
    flipped[2] ^= 0x10;
    let crafted = [
        ("80_empty_frames", [&[DELIMITER; 3][..], &arm].concat()),
        ("81_cut", [cut, &[DELIMITER], &arm].concat()),
        ("82_joined", [cut, &arm, &arm].concat()),
        ("83_flipped", [&flipped[..], &arm].concat()),
        ("84_too_long", [&[0x55; 300][..], &[DELIMITER], &arm].concat()),
        ("85_longest_run", [&[0xff][..], &[1; 254], &[DELIMITER], &arm].concat()),
        ("86_no_content", vec![1, DELIMITER]),
        ("87_two_in_a_row", [framed(1, &FromHost::Begin), framed(2, &FromHost::Arm)].concat()),
    ];
    seeds.extend(crafted.map(|(name, bytes)| (name.to_owned(), bytes)));
    seeds
}

/// A request for `any_bodies`: control byte, length, body.
fn put(seed: &mut Vec<u8>, control: u8, request: &FromHost) {
    let mut buffer = [0; FromHost::MAX_BYTES];
    let body = to_slice(request, &mut buffer).unwrap();
    seed.extend([control, u8::try_from(body.len()).unwrap()]);
    seed.extend(&*body);
}

/// For `any_bodies`: each request alone, and whole sessions.
fn conversations() -> Vec<(String, Vec<u8>)> {
    const LOCKSTEP: u8 = 0;
    const REAL_TIME: u8 = 1;
    const NO_HELLO: u8 = 2;
    const REPEATED: u8 = 0x80;
    const LONG: u8 = 0xf;
    let talk = |opening: u8, requests: &[(u8, FromHost)]| {
        let mut seed = vec![opening];
        for (control, request) in requests {
            put(&mut seed, *control, request);
        }
        seed
    };
    let requests = all_requests();
    let mut seeds: Vec<_> = (0..)
        .zip(&requests)
        .map(|(i, request)| (name(i, request), talk(LOCKSTEP, &[(0, request.clone())])))
        .collect();
    let navigate = |step: fn(Readings) -> FromHost, control: u8| {
        let mut all = vec![(0, FromHost::Begin)];
        all.extend(map().map(|part| (0, part)));
        let goal = Checkpoints::ReplaceAll(heapless::Vec::from_slice(&[POINT]).unwrap());
        all.push((0, FromHost::Checkpoints(goal)));
        all.extend([FromHost::Arm, FromHost::Mode(Mode::Navigate)].map(|request| (0, request)));
        all.push((control, step(readings(0, true))));
        all.extend((1..20).map(|tick| (control, step(readings(tick, false)))));
        all.extend(
            [FromHost::Telemetry, FromHost::Fields { column: 7 }, FromHost::Health]
                .map(|request| (0, request)),
        );
        all.extend(
            [FromHost::EStop, FromHost::Arm, FromHost::Disarm, FromHost::Arm]
                .map(|request| (control, request)),
        );
        all
    };
    let learn = |step: fn(Readings) -> FromHost, control: u8| {
        let draws = |tick| Readings { exploration: Some([0.5, -0.5]), ..readings(tick, false) };
        let mut all = vec![
            (0, FromHost::Arm),
            (0, FromHost::Map(MapRequest::Forget)),
            (0, FromHost::Mode(Mode::Learn)),
        ];
        all.extend((0..20).map(|tick| (control, step(draws(tick)))));
        all
    };
    let set = |index, value| (0, FromHost::Parameters(Parameters::Set(ParameterValue { index, value })));
    let mut parameters: Vec<_> =
        (0..12).map(|index| (0, FromHost::Parameters(Parameters::Get { index }))).collect();
    parameters.extend([set(0, 0.1), set(1, 0.0), set(2, 1.0), set(200, 1.0)]);
    parameters.push((0, FromHost::Parameters(Parameters::Commit)));
    parameters.push((REPEATED, FromHost::Parameters(Parameters::Commit)));
    let sessions = [
        ("70_navigate_in_lockstep", talk(LOCKSTEP, &navigate(FromHost::Step, 0))),
        ("71_navigate_in_real_time", talk(REAL_TIME, &navigate(FromHost::Sense, 9))),
        ("72_learn_in_lockstep", talk(LOCKSTEP, &learn(FromHost::Step, 0))),
        ("73_learn_in_real_time", talk(REAL_TIME, &learn(FromHost::Sense, LONG))),
        ("74_parameters", talk(LOCKSTEP, &parameters)),
        (
            "75_no_hello",
            talk(NO_HELLO, &[(0, FromHost::Arm), (REPEATED, FromHost::EStop), (0, FromHost::Begin)]),
        ),
        ("76_unasked_number", talk(NO_HELLO, &[(REPEATED, FromHost::EStop), (REPEATED, FromHost::Disarm)])),
        (
            "77_change_of_time_base",
            talk(
                LOCKSTEP,
                &[
                    (0, FromHost::EStop),
                    (0, FromHost::Hello(hello(TimeBase::RealTime))),
                    (3, FromHost::Arm),
                    (0, FromHost::Step(readings(0, false))),
                ],
            ),
        ),
        ("78_bodies_of_nothing", vec![LOCKSTEP, 0, 0, 0, 1, 99, REPEATED, 3, 1, 0x80, 0, 0, 255]),
    ];
    seeds.extend(sessions.map(|(name, bytes)| (name.to_owned(), bytes)));
    assert_eq!(SENSORS, 12, "the ranges of `readings`");
    seeds
}
