//! The bytes of every message, as other programs have them: `golden/` is what a released version looks like for good.
#![expect(
    clippy::unwrap_used,
    reason = "clippy.toml allows it in #[test] functions; the helpers here are part of them"
)]

mod common;

use common::{board_examples, host_examples};
use core::fmt::{Debug, Write};
use protocol::codec::Message;
use protocol::frame::{Decoder, FRAME_BYTES_MAX, Frame, FrameError, encode};
use protocol::map_file::{self, FORMAT_VERSION, MapHeader, NeuronRecord, Provenance, Robot};
use protocol::message::{FromBoard, FromHost, PROTOCOL_VERSION, ScalarKind};

/// The present version first, then earlier releases.
const VERSIONS: [(u16, &str); 1] = [(2, include_str!("golden/v2.txt"))];

/// Sequence number of all golden frames.
const SEQUENCE: u8 = 7;

/// `direction name hex` of each line.
fn lines(text: &str) -> impl Iterator<Item = (&str, &str, Vec<u8>)> {
    let lines = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.map(|line| {
        let words: Vec<&str> = line.split(' ').collect();
        let [direction, name, hex] = words[..] else { panic!("not `direction name hex`: {line}") };
        let pairs = hex.as_bytes().chunks(2).map(|pair| core::str::from_utf8(pair).unwrap());
        (direction, name, pairs.map(|pair| u8::from_str_radix(pair, 16).unwrap()).collect())
    })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

fn received<M: Message>(bytes: &[u8]) -> Vec<Result<Frame<M>, FrameError>> {
    let mut decoder = Decoder::new();
    bytes.iter().filter_map(|&byte| decoder.push(byte)).collect()
}

fn check<M: Message + Debug + PartialEq + Clone>(direction: &str, examples: Vec<(&str, M)>) {
    let golden: Vec<_> = lines(VERSIONS[0].1).filter(|line| line.0 == direction).collect();
    let mut wrong = String::new();
    for (name, message) in &examples {
        let mut buffer = [0; FRAME_BYTES_MAX];
        let bytes = encode(SEQUENCE, message, &mut buffer).unwrap();
        match golden.iter().find(|line| line.1 == *name) {
            Some((_, _, expected)) if expected == bytes => {
                let frame = Frame { sequence: SEQUENCE, message: message.clone() };
                assert_eq!(received(bytes), [Ok(frame)], "{name}");
            }
            _ => writeln!(wrong, "{direction} {name} {}", hex(bytes)).unwrap(),
        }
    }
    assert!(wrong.is_empty(), "lines that golden/v{PROTOCOL_VERSION}.txt lacks or has otherwise:\n{wrong}");
    for (_, name, _) in golden {
        assert!(examples.iter().any(|example| example.0 == name), "no example is called {direction} {name}");
    }
}

#[test]
fn the_bytes_of_the_host_stay() {
    check::<FromHost>("from_host", host_examples());
}

#[test]
fn the_bytes_of_the_board_stay() {
    check::<FromBoard>("from_board", board_examples());
}

/// The present version of the map file.
const MAP: (u16, &str) = (2, include_str!("golden/map_v2.txt"));

#[test]
fn the_bytes_of_a_map_file_stay() {
    let header = MapHeader {
        format_version: FORMAT_VERSION,
        scalar: ScalarKind::Fixed,
        columns: 2,
        rows: 1,
        reach_m: 0.163_84,
        speed_limit_mps: 0.16,
        robot: Robot { wheel_base_m: 0.053, body_radius_m: 0.025, encoder_counts_per_m: 12_000.0 },
        provenance: Provenance {
            seed: 300,
            steps: 2000,
            horizon_ms: 1024,
            config_digest: 0x0123_4567_89ab_cdef,
            core_version: "0.1.0".try_into().unwrap(),
            commit: "0123456789ab-dirty".try_into().unwrap(),
        },
    };
    let trained = NeuronRecord {
        bearing_rad: 0.5,
        distance_per_reach: -0.25,
        left: [1.0, -2.0],
        right: [-1.0, 2.0],
        has_won: true,
    };
    let neurons = [trained, NeuronRecord::default()];
    let mut file = vec![0; map_file::encoded_bytes_max(neurons.len())];
    let file = map_file::encode(&header, &neurons, &mut file).unwrap();
    assert_eq!(MAP.0, FORMAT_VERSION, "add golden/map_v{FORMAT_VERSION}.txt");
    assert_eq!(hex(file), MAP.1.trim(), "golden/map_v{FORMAT_VERSION}.txt has it otherwise");
}

#[test]
fn the_present_version_is_the_first() {
    assert_eq!(VERSIONS[0].0, PROTOCOL_VERSION, "add golden/v{PROTOCOL_VERSION}.txt in front of the others");
}

/// A board of an earlier release is told by name, not by nonsense.
#[test]
fn earlier_versions_are_refused_by_their_key() {
    for (version, text) in &VERSIONS[1..] {
        for (direction, name, bytes) in lines(text) {
            let error = match direction {
                "from_host" => received::<FromHost>(&bytes).pop().unwrap().err(),
                _ => received::<FromBoard>(&bytes).pop().unwrap().err(),
            };
            assert!(
                matches!(error, Some(FrameError::Key { .. } | FrameError::TooLong { .. })),
                "version {version}, {direction} {name}: {error:?}"
            );
        }
    }
}
