//! Every message comes back as it was sent, and nothing else is taken for one.
#![expect(
    clippy::unwrap_used,
    reason = "clippy.toml allows it in #[test] functions; the helpers here are part of them"
)]

use controller_core::scalar::{Fixed, Scalar};
use controller_core::units::{EncoderCounts, Point, Pose, WheelDrive, WheelSpeeds};
use heapless::{String, Vec};
use proptest::prelude::{Just, Strategy, any, prop, prop_oneof};
use proptest::{option, prop_assert, prop_assert_eq, proptest};
use protocol::codec::{DecodeError, EncodeError, Message, from_bytes, to_slice};
use protocol::message::{
    Board, CHECKPOINTS_PER_MESSAGE, Checkpoints, FaultCause, FaultReport, FromBoard, FromHost, Hello,
    Mismatch, Outputs, PROTOCOL_VERSION, SENSORS, ScalarKind, Scan, Step, TimeBase, Wheel,
};

fn finite() -> impl Strategy<Value = f32> {
    any::<f32>().prop_filter("finite", |value| value.is_finite())
}

fn point() -> impl Strategy<Value = Point<f32>> {
    (finite(), finite()).prop_map(|(x_m, y_m)| Point { x_m, y_m })
}

fn hello() -> impl Strategy<Value = Hello> {
    (
        any::<(u16, u32, Option<u64>)>(),
        "[0-9a-f]{0,40}",
        prop_oneof![Just(Board::Stm32f405), Just(Board::Stm32f100), Just(Board::Stub)],
        prop_oneof![Just(ScalarKind::F32), Just(ScalarKind::Fixed)],
        prop_oneof![Just(TimeBase::Lockstep), Just(TimeBase::RealTime)],
    )
        .prop_map(|((protocol_version, epoch, map_hash), build_id, board, scalar, time_base)| Hello {
            protocol_version,
            build_id: String::try_from(build_id.as_str()).unwrap(),
            board,
            scalar,
            map_hash,
            time_base,
            epoch,
        })
}

fn step() -> impl Strategy<Value = Step> {
    let pose = (finite(), finite(), finite());
    let pose = option::of(pose.prop_map(|(x_m, y_m, heading_rad)| Pose { x_m, y_m, heading_rad }));
    let range = option::of(finite().prop_map(f32::abs));
    let scan = option::of(prop::array::uniform12(range).prop_map(|ranges_m| Scan { ranges_m }));
    (any::<(u64, i32, i32)>(), pose, scan).prop_map(|((tick, left, right), pose_fix, scan)| Step {
        tick,
        encoders: EncoderCounts { left, right },
        pose_fix,
        scan,
    })
}

fn checkpoints() -> impl Strategy<Value = Checkpoints> {
    let list = || {
        prop::collection::vec(point(), 0..=CHECKPOINTS_PER_MESSAGE)
            .prop_map(|points| Vec::from_slice(&points).unwrap())
    };
    prop_oneof![
        list().prop_map(Checkpoints::ReplaceAll),
        list().prop_map(Checkpoints::Append),
        (any::<u8>(), point()).prop_map(|(index, point)| Checkpoints::ReplaceOne { index, point }),
        Just(Checkpoints::Clear),
    ]
}

fn from_host() -> impl Strategy<Value = FromHost> {
    prop_oneof![
        hello().prop_map(FromHost::Hello),
        step().prop_map(FromHost::Step),
        checkpoints().prop_map(FromHost::Checkpoints),
        Just(FromHost::Arm),
        Just(FromHost::Disarm),
        Just(FromHost::EStop),
    ]
}

fn outputs() -> impl Strategy<Value = Outputs> {
    (any::<(u64, Option<u16>, u64)>(), prop::array::uniform4(finite())).prop_map(
        |((tick, winner, state_digest), [left, right, left_mps, right_mps])| Outputs {
            tick,
            wheel_drive: WheelDrive { left, right },
            wheel_speed_command: WheelSpeeds { left_mps, right_mps },
            winner,
            state_digest,
        },
    )
}

fn fault() -> impl Strategy<Value = FaultReport> {
    let cause = prop_oneof![
        Just(FaultCause::NotArmed),
        Just(FaultCause::EStop),
        any::<u32>().prop_map(|silent_ms| FaultCause::LinkSilent { silent_ms }),
        any::<u32>().prop_map(|age_ms| FaultCause::SensorsStale { age_ms }),
        Just(FaultCause::CommandNotFinite),
        Just(FaultCause::CommandOutOfRange),
        prop_oneof![Just(Wheel::Left), Just(Wheel::Right)]
            .prop_map(|wheel| FaultCause::ServoStalled { wheel }),
        any::<u32>().prop_map(|missed_count| FaultCause::DeadlineMissed { missed_count }),
    ];
    (any::<u64>(), cause, any::<bool>()).prop_map(|(tick, cause, latched)| FaultReport {
        tick,
        cause,
        latched,
    })
}

fn from_board() -> impl Strategy<Value = FromBoard> {
    prop_oneof![
        hello().prop_map(FromBoard::Hello),
        outputs().prop_map(FromBoard::Outputs),
        fault().prop_map(FromBoard::Fault),
    ]
}

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
    fn whatever_is_accepted_can_be_sent(bytes in prop::collection::vec(any::<u8>(), 0..160), key in 0_u8..7) {
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

fn hello_example() -> Hello {
    Hello {
        protocol_version: PROTOCOL_VERSION,
        build_id: String::try_from("0123456789abcdef0123456789abcdef01234567").unwrap(),
        board: Board::Stm32f100,
        scalar: ScalarKind::Fixed,
        map_hash: Some(u64::MAX),
        time_base: TimeBase::Lockstep,
        epoch: u32::MAX,
    }
}

const STEP: Step = Step {
    tick: u64::MAX,
    encoders: EncoderCounts { left: i32::MIN, right: i32::MIN },
    pose_fix: Some(Pose { x_m: 1.0, y_m: -2.0, heading_rad: 0.5 }),
    scan: Some(Scan { ranges_m: [Some(0.175); SENSORS] }),
};

const OUTPUTS: Outputs = Outputs {
    tick: u64::MAX,
    wheel_drive: WheelDrive { left: 0.25, right: -1.0 },
    wheel_speed_command: WheelSpeeds { left_mps: 0.04, right_mps: -0.16 },
    winner: Some(u16::MAX),
    state_digest: u64::MAX,
};

/// The numbers on the wire may only grow; whoever reorders an enum breaks every board in the field.
#[test]
fn the_first_byte_is_the_variants_place() {
    let checkpoints = FromHost::Checkpoints(Checkpoints::Clear);
    let host = [
        FromHost::Hello(hello_example()),
        FromHost::Step(STEP),
        checkpoints,
        FromHost::Arm,
        FromHost::Disarm,
        FromHost::EStop,
    ];
    let keys: std::vec::Vec<u8> = host.iter().map(|message| sent(message)[0]).collect();
    assert_eq!(keys, [0, 1, 2, 3, 4, 5]);
    let report = FaultReport { tick: 0, cause: FaultCause::NotArmed, latched: false };
    let board = [FromBoard::Hello(hello_example()), FromBoard::Outputs(OUTPUTS), FromBoard::Fault(report)];
    let keys: std::vec::Vec<u8> = board.iter().map(|message| sent(message)[0]).collect();
    assert_eq!(keys, [0, 1, 2]);

    let one_more = |key, known| Err(DecodeError::UnknownMessage { key, known });
    assert_eq!(from_bytes::<FromHost>(&[6]).map(|_| ()), one_more(6, 6));
    assert_eq!(from_bytes::<FromBoard>(&[3]).map(|_| ()), one_more(3, 3));
}

/// Version 1, byte by byte: change these only together with [`PROTOCOL_VERSION`].
#[test]
fn the_bytes_of_version_1_stay() {
    let step = Step { tick: 300, encoders: EncoderCounts { left: -1, right: 2 }, pose_fix: None, scan: None };
    assert_eq!(sent(&FromHost::Step(step)), [1, 0xac, 0x02, 1, 4, 0, 0]);
    let point = Point { x_m: 1.0, y_m: -0.5 };
    let replace = FromHost::Checkpoints(Checkpoints::ReplaceOne { index: 7, point });
    assert_eq!(sent(&replace), [2, 2, 7, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf]);
    let cause = FaultCause::ServoStalled { wheel: Wheel::Right };
    let fault = FromBoard::Fault(FaultReport { tick: 5, cause, latched: true });
    assert_eq!(sent(&fault), [2, 5, 6, 1, 1]);
}

#[test]
fn the_largest_message_is_as_large_as_announced() {
    let full = Vec::from_array([Point { x_m: 1.0, y_m: 2.0 }; CHECKPOINTS_PER_MESSAGE]);
    let host = [
        FromHost::Hello(hello_example()),
        FromHost::Step(STEP),
        FromHost::Checkpoints(Checkpoints::Append(full)),
    ];
    assert_eq!(host.iter().map(|message| sent(message).len()).max(), Some(FromHost::MAX_BYTES));
    // 10 for the tick, 5 and 5 for the counts, a mark before the pose, the scan, and each range.
    assert_eq!(sent(&host[1]).len(), 1 + 10 + 10 + 13 + 1 + SENSORS * 5);

    let newest = Hello { protocol_version: u16::MAX, ..hello_example() };
    let report =
        FaultReport { tick: u64::MAX, cause: FaultCause::LinkSilent { silent_ms: u32::MAX }, latched: true };
    let board = [FromBoard::Hello(newest), FromBoard::Outputs(OUTPUTS), FromBoard::Fault(report)];
    assert_eq!(board.iter().map(|message| sent(message).len()).max(), Some(FromBoard::MAX_BYTES));

    let mut short = [0; FromHost::MAX_BYTES - 1];
    let available_bytes = short.len();
    assert_eq!(to_slice(&host[2], &mut short), Err(EncodeError::BufferTooSmall { available_bytes }));
}

#[test]
fn what_is_not_finite_is_named_and_refused_on_both_sides() {
    let with_pose = |pose| FromHost::Step(Step { pose_fix: Some(pose), ..STEP });
    let with_range = |range| FromHost::Step(Step { scan: Some(Scan { ranges_m: [range; SENSORS] }), ..STEP });
    let at =
        |x_m, y_m| FromHost::Checkpoints(Checkpoints::ReplaceOne { index: 0, point: Point { x_m, y_m } });
    let nan = f32::NAN;
    let pose = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
    let cases = [
        (with_pose(Pose { x_m: nan, ..pose }), "pose_fix.x_m"),
        (with_pose(Pose { y_m: f32::INFINITY, ..pose }), "pose_fix.y_m"),
        (with_pose(Pose { heading_rad: nan, ..pose }), "pose_fix.heading_rad"),
        (with_range(Some(nan)), "scan.ranges_m"),
        (with_range(Some(-0.1)), "scan.ranges_m"),
        (at(f32::NEG_INFINITY, 0.0), "checkpoints.x_m"),
        (at(0.0, nan), "checkpoints.y_m"),
    ];
    for (message, field) in cases {
        let mut buffer = [0; FromHost::MAX_BYTES];
        assert_eq!(to_slice(&message, &mut buffer), Err(EncodeError::InvalidValue { field }));
        let raw = postcard::to_slice(&message, &mut buffer).unwrap();
        assert_eq!(from_bytes::<FromHost>(raw), Err(DecodeError::InvalidValue { field }));
    }
    let outputs =
        FromBoard::Outputs(Outputs { wheel_drive: WheelDrive { left: 0.0, right: nan }, ..OUTPUTS });
    let field = "wheel_drive.right";
    assert_eq!(to_slice(&outputs, &mut [0; 99]), Err(EncodeError::InvalidValue { field }));
}

#[test]
fn malformed_fields_are_told_apart() {
    let what = |bytes: &[u8]| match from_bytes::<FromHost>(bytes) {
        Err(DecodeError::Malformed { what }) => what,
        other => panic!("{other:?}"),
    };
    assert_eq!(what(&[1, 0, 0, 0, 2]), "the mark of an optional field is neither 0 nor 1");
    assert_eq!(what(&[0, 1, 2, 0xff, 0xff, 0, 0, 0, 0, 0]), "a text is not UTF-8");
    assert_eq!(what(&[0, 0xff, 0xff, 0xff, 0xff]), "an integer is larger than its type");
    let limit = "an unknown variant, or a list or text longer than its limit";
    assert_eq!(what(&[2, 9]), limit);
    assert_eq!(what(&[&[2, 0, 17][..], &[0; 17 * 8]].concat()), limit);
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
    assert_eq!(
        with(|hello| hello.protocol_version = 2),
        Err(Mismatch::ProtocolVersion { ours: 1, theirs: 2 })
    );
    assert_eq!(
        with(|hello| hello.board = Board::Stub),
        Err(Mismatch::Board { ours: Board::Stm32f100, theirs: Board::Stub })
    );
    let scalar = with(|hello| hello.scalar = ScalarKind::F32).unwrap_err();
    assert_eq!(scalar, Mismatch::Scalar { ours: ScalarKind::Fixed, theirs: ScalarKind::F32 });
    assert_eq!(scalar.to_string(), "scalar f32 on the other side, fixed on this");
    assert_eq!(with(|hello| hello.map_hash = Some(1)), Err(Mismatch::MapHash { ours: u64::MAX, theirs: 1 }));
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
