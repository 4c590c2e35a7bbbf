//! Every message comes back as it was sent, and nothing else is taken for one.
#![expect(
    clippy::unwrap_used,
    reason = "clippy.toml allows it in #[test] functions; the helpers here are part of them"
)]

mod common;

use common::{
    OUTPUTS, READINGS, board_examples, from_board, from_host, full_checkpoints, full_neurons, hello_example,
    host_examples,
};
use controller_core::scalar::{Fixed, Scalar};
use controller_core::units::{Point, Pose, WheelDrive};
use proptest::prelude::{any, prop};
use proptest::{prop_assert, prop_assert_eq, proptest};
use protocol::codec::{DecodeError, EncodeError, Message, from_bytes, to_slice};
use protocol::message::{
    Board, Checkpoints, Fields, FromBoard, FromHost, Hello, MapRequest, Mismatch, Neurons, Outputs,
    PROTOCOL_VERSION, ParameterValue, Parameters, ROWS, Readings, SENSORS, ScalarKind, Scan, TimeBase,
};

fn sent<M: Message>(message: &M) -> std::vec::Vec<u8> {
    let mut buffer = vec![0; M::MAX_BYTES];
    to_slice(message, &mut buffer).unwrap().to_vec()
}

proptest! {
    #[test]
    fn host_messages_come_back(message in from_host()) {
        prop_assert_eq!(from_bytes(&sent(&message)), Ok(message));
    }

    #[test]
    fn board_messages_come_back(message in from_board()) {
        prop_assert_eq!(from_bytes(&sent(&message)), Ok(message));
    }

    #[test]
    fn a_part_is_not_a_message(message in from_host(), surplus_bytes in 1_usize..9) {
        let bytes = sent(&message);
        for found_bytes in 0..bytes.len() {
            let truncated = Err(DecodeError::Truncated { found_bytes });
            prop_assert_eq!(from_bytes::<FromHost>(&bytes[..found_bytes]), truncated);
        }
        let longer = [&bytes[..], &[0; 8][..surplus_bytes]].concat();
        prop_assert_eq!(from_bytes::<FromHost>(&longer), Err(DecodeError::TrailingBytes { surplus_bytes }));
    }

    #[test]
    fn whatever_is_accepted_can_be_sent(bytes in prop::collection::vec(any::<u8>(), 0..160), key in 0_u8..15) {
        // Most first bytes are no message: give the decoder something to chew on.
        let bytes = [&[key][..], &bytes[..]].concat();
        for end in 0..=bytes.len() {
            if let Ok(message) = from_bytes::<FromHost>(&bytes[..end]) {
                prop_assert_eq!(from_bytes(&sent(&message)), Ok(message));
            }
            if let Ok(message) = from_bytes::<FromBoard>(&bytes[..end]) {
                prop_assert_eq!(from_bytes(&sent(&message)), Ok(message));
            }
        }
    }

    #[test]
    fn fixed_point_below_sixteen_passes_through_f32(bits in -(1_i32 << 24)..(1 << 24)) {
        let value = Fixed::from_bits(bits);
        prop_assert!(value.abs().to_f32() <= 16.0);
        prop_assert_eq!(Fixed::from_f32(value.to_f32()), value);
    }
}

/// The numbers on the wire may only grow; whoever reorders an enum breaks every board in the field.
#[test]
fn the_first_byte_is_the_variants_place() {
    let name = |debug: std::string::String| debug.split(['(', ' ']).next().unwrap_or_default().to_owned();
    let mut host: std::vec::Vec<_> =
        host_examples().iter().map(|(_, message)| (sent(message)[0], name(format!("{message:?}")))).collect();
    host.dedup();
    let names = [
        "Hello",
        "Step",
        "Checkpoints",
        "Arm",
        "Disarm",
        "EStop",
        "Sense",
        "Begin",
        "Mode",
        "Parameters",
        "Map",
        "Health",
        "Telemetry",
        "Fields",
    ];
    let expected =
        |names: &[&str]| (0..).zip(names.iter().map(ToString::to_string)).collect::<std::vec::Vec<_>>();
    assert_eq!(host, expected(&names));

    let mut board: std::vec::Vec<_> = board_examples()
        .iter()
        .map(|(_, message)| (sent(message)[0], name(format!("{message:?}"))))
        .collect();
    board.sort();
    board.dedup();
    let names = [
        "Hello",
        "Outputs",
        "Fault",
        "Done",
        "Refused",
        "Parameter",
        "Map",
        "Neurons",
        "Health",
        "Telemetry",
        "Fields",
    ];
    assert_eq!(board, expected(&names));

    let one_more = |key, known| Err(DecodeError::UnknownMessage { key, known });
    assert_eq!(from_bytes::<FromHost>(&[14]).map(|_| ()), one_more(14, 14));
    assert_eq!(from_bytes::<FromBoard>(&[11]).map(|_| ()), one_more(11, 11));
}

/// What the limits promise, reached where a message can reach it.
#[test]
fn the_largest_message_is_as_large_as_announced() {
    let bytes = |message| sent::<FromHost>(&message).len();
    // 3 for the version, 10 and 10 and 5 for numbers of 64 and 32 bits, a mark before each that may be absent.
    let hello = Hello { protocol_version: u16::MAX, schema_hash: u64::MAX, ..hello_example() };
    assert_eq!(bytes(FromHost::Hello(hello.clone())), 1 + 3 + 10 + 41 + 2 + 2 + 11 + 11 + 1 + 5);
    // 10 for the tick, 5 and 5 for the counts, a mark before the pose, the scan, each range, and the draws.
    assert_eq!(bytes(FromHost::Step(READINGS)), 1 + 10 + 10 + 13 + (1 + SENSORS * 5) + 9);
    assert_eq!(bytes(FromHost::Map(MapRequest::Write(full_neurons()))), 1 + 1 + 3 + 1 + 5 * 25);
    let largest = FromHost::Checkpoints(Checkpoints::Append(full_checkpoints()));
    assert_eq!(bytes(largest.clone()), FromHost::MAX_BYTES);
    assert!(host_examples().into_iter().all(|(_, message)| bytes(message) <= FromHost::MAX_BYTES));

    let bytes = |message| sent::<FromBoard>(&message).len();
    assert_eq!(bytes(FromBoard::Hello(hello)), 1 + 3 + 10 + 41 + 2 + 2 + 11 + 11 + 1 + 5);
    assert_eq!(bytes(FromBoard::Outputs(OUTPUTS)), 1 + 10 + 8 + 8 + 10 + 5 + 2 + 10);
    let fields = Fields { column: 7, target: [0.5; ROWS], obstacles: [0.5; ROWS] };
    assert_eq!(bytes(FromBoard::Fields(fields)), 1 + 1 + 2 * ROWS * 4);
    assert_eq!(bytes(FromBoard::Neurons(full_neurons())), FromBoard::MAX_BYTES);

    let mut short = [0; FromHost::MAX_BYTES - 1];
    let available_bytes = short.len();
    assert_eq!(to_slice(&largest, &mut short), Err(EncodeError::BufferTooSmall { available_bytes }));
}

#[test]
fn what_is_not_finite_is_named_and_refused_on_both_sides() {
    fn refused<M: Message>(message: &M, field: &str) {
        let mut buffer = [0; 140];
        match to_slice(message, &mut buffer) {
            Err(EncodeError::InvalidValue { field: found }) => assert_eq!(found, field),
            other => panic!("{field}: {other:?}"),
        }
        let raw = postcard::to_slice(message, &mut buffer).unwrap();
        match from_bytes::<M>(raw) {
            Err(DecodeError::InvalidValue { field: found }) => assert_eq!(found, field),
            other => panic!("{field}: {:?}", other.map(|_| ())),
        }
    }
    let nan = f32::NAN;
    let pose = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
    let with_pose = |pose| Readings { pose_fix: Some(pose), ..READINGS };
    let with_range = |range| Readings { scan: Some(Scan { ranges_m: [range; SENSORS] }), ..READINGS };
    let readings = [
        (with_pose(Pose { x_m: nan, ..pose }), "pose_fix.x_m"),
        (with_pose(Pose { y_m: f32::INFINITY, ..pose }), "pose_fix.y_m"),
        (with_pose(Pose { heading_rad: nan, ..pose }), "pose_fix.heading_rad"),
        (with_range(Some(nan)), "scan.ranges_m"),
        (with_range(Some(-0.1)), "scan.ranges_m"),
        (Readings { exploration: Some([0.0, nan]), ..READINGS }, "exploration"),
    ];
    for (readings, field) in readings {
        refused(&FromHost::Step(readings), field);
        refused(&FromHost::Sense(readings), field);
    }
    let at =
        |x_m, y_m| FromHost::Checkpoints(Checkpoints::ReplaceOne { index: 0, point: Point { x_m, y_m } });
    refused(&at(f32::NEG_INFINITY, 0.0), "checkpoints.x_m");
    refused(&at(0.0, nan), "checkpoints.y_m");
    let mut points = full_checkpoints();
    points[15].y_m = nan;
    refused(&FromHost::Checkpoints(Checkpoints::ReplaceAll(points)), "checkpoints.y_m");
    let value = ParameterValue { index: 0, value: f32::INFINITY };
    refused(&FromHost::Parameters(Parameters::Set(value)), "parameter.value");
    refused(&FromBoard::Parameter(value), "parameter.value");
    let mut neurons: Neurons = full_neurons();
    neurons.neurons[4].right[1] = nan;
    let field = "right[1]";
    refused(&FromHost::Map(MapRequest::Write(neurons.clone())), field);
    refused(&FromBoard::Neurons(neurons), field);

    let drive =
        |left, right| FromBoard::Outputs(Outputs { wheel_drive: WheelDrive { left, right }, ..OUTPUTS });
    refused(&drive(nan, 0.0), "wheel_drive.left");
    refused(&drive(0.0, nan), "wheel_drive.right");
    let mut fields = Fields { column: 0, target: [0.0; ROWS], obstacles: [0.0; ROWS] };
    fields.obstacles[14] = nan;
    refused(&FromBoard::Fields(fields), "fields.obstacles");
    fields.target[0] = nan;
    refused(&FromBoard::Fields(fields), "fields.target");
    for (name, message) in board_examples() {
        let FromBoard::Telemetry(telemetry) = message else { continue };
        let mut activity = telemetry;
        activity.activity = nan;
        refused(&FromBoard::Telemetry(activity), "telemetry.activity");
        let mut target = telemetry;
        let Some(place) = &mut target.target else { continue };
        place.distance_m = nan;
        refused(&FromBoard::Telemetry(target), "telemetry.target.distance_m");
        assert_eq!(name, "telemetry");
    }
}

/// One message, one encoding: an integer in more bytes than it needs would be a second one.
#[test]
fn padded_integers_are_refused() {
    let step = [1, 0, 0, 0, 0, 0, 0];
    assert!(from_bytes::<FromHost>(&step).is_ok());
    let padded = Err(DecodeError::Malformed { what: "an integer takes more bytes than it needs" });
    assert_eq!(from_bytes::<FromHost>(&[1, 0x80, 0, 0, 0, 0, 0, 0]), padded);
    assert_eq!(from_bytes::<FromHost>(&[10, 0x81, 0, 5]), padded);
}

#[test]
fn malformed_fields_are_told_apart() {
    let what = |bytes: &[u8]| match from_bytes::<FromHost>(bytes) {
        Err(DecodeError::Malformed { what }) => what,
        other => panic!("{other:?}"),
    };
    assert_eq!(what(&[1, 0, 0, 0, 2]), "the mark of an optional field is neither 0 nor 1");
    assert_eq!(what(&[0, 0xff, 0xff, 0xff, 0xff]), "an integer is larger than its type");
    let limit = "an unknown variant, a text beyond ASCII, or a list or text longer than its limit";
    assert_eq!(what(&[0, 1, 0, 2, 0xff, 0xff, 0, 0, 0, 0, 0, 0]), limit);
    assert_eq!(what(&[2, 9]), limit);
    assert_eq!(what(&[&[2, 0, 17][..], &[0; 17 * 8]].concat()), limit);
    assert_eq!(what(&[8, 3]), limit);
    assert_eq!(what(&[&[10, 2, 0, 6][..], &[0; 6 * 25]].concat()), limit);
    let fault = from_bytes::<FromBoard>(&[2, 0, 0, 2]);
    assert_eq!(fault, Err(DecodeError::Malformed { what: "a truth value is neither 0 nor 1" }));
}

#[test]
fn two_ends_that_do_not_fit_are_named() {
    let ours = hello_example();
    let with = |change: fn(&mut Hello)| {
        let mut theirs = hello_example();
        change(&mut theirs);
        ours.check_against(&theirs)
    };
    assert_eq!(with(|_| ()), Ok(()));
    assert_eq!(with(|hello| hello.epoch = 3), Ok(()));
    assert_eq!(with(|hello| hello.build_id.clear()), Ok(()));
    assert_eq!(with(|hello| hello.map_hash = None), Ok(()));
    assert_eq!(with(|hello| hello.parameters_hash = None), Ok(()));
    assert_eq!(with(|hello| hello.board = None), Ok(()));
    assert_eq!(with(|hello| hello.scalar = None), Ok(()));
    assert_eq!(
        with(|hello| (hello.protocol_version, hello.schema_hash) = (1, 0)),
        Err(Mismatch::ProtocolVersion { ours: PROTOCOL_VERSION, theirs: 1 })
    );
    assert_eq!(
        with(|hello| hello.schema_hash = 1),
        Err(Mismatch::Schema { ours: ours.schema_hash, theirs: 1 })
    );
    assert_eq!(
        with(|hello| hello.board = Some(Board::Stub)),
        Err(Mismatch::Board { ours: Board::Stm32f100, theirs: Board::Stub })
    );
    let scalar = with(|hello| hello.scalar = Some(ScalarKind::F32)).unwrap_err();
    assert_eq!(scalar, Mismatch::Scalar { ours: ScalarKind::Fixed, theirs: ScalarKind::F32 });
    assert_eq!(scalar.to_string(), "scalar f32 on the other side, fixed on this");
    assert_eq!(with(|hello| hello.map_hash = Some(1)), Err(Mismatch::MapHash { ours: u64::MAX, theirs: 1 }));
    assert_eq!(
        with(|hello| hello.parameters_hash = Some(1)),
        Err(Mismatch::ParametersHash { ours: u64::MAX, theirs: 1 })
    );
    assert_eq!(
        with(|hello| hello.time_base = TimeBase::RealTime),
        Err(Mismatch::TimeBase { ours: TimeBase::Lockstep, theirs: TimeBase::RealTime })
    );
}

#[test]
fn scalar_kinds_have_the_names_of_the_scalars() {
    assert_eq!(ScalarKind::of::<f32>(), Some(ScalarKind::F32));
    assert_eq!(ScalarKind::of::<Fixed>(), Some(ScalarKind::Fixed));
}

#[test]
fn readings_are_read_alone_as_in_their_message() {
    let mut buffer = [0; FromHost::MAX_BYTES];
    let body = to_slice(&FromHost::Sense(READINGS), &mut buffer).unwrap();
    assert_eq!(body[0], FromHost::SENSE);
    assert_eq!(FromHost::read_sense(body), Some(Ok(READINGS)));
    assert_eq!(
        FromHost::read_sense(&body[..2]),
        Some(Err(DecodeError::Truncated { found_bytes: 1 })),
        "without the number of the message"
    );
    let body = to_slice(&FromHost::EStop, &mut buffer).unwrap();
    assert_eq!((body.len(), body[0]), (1, FromHost::ESTOP));
    assert_eq!(FromHost::read_sense(body), None);
    assert_eq!(FromHost::read_sense(&[]), None);
}
