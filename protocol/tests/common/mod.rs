//! What the tests of the wire share: every message as a strategy, and named examples of each.
#![allow(dead_code, reason = "each test program uses its part")]
#![expect(clippy::unwrap_used, reason = "clippy.toml allows it in #[test] functions; these are part of them")]

use controller_core::controller::Mode;
use controller_core::planning::checkpoint::{CheckpointError, Reached};
use controller_core::safety::StopCause;
use controller_core::units::{EncoderCounts, Point, Polar, Pose, WheelDrive, WheelSpeeds};
use heapless::{String, Vec};
use proptest::prelude::{Just, Strategy, any, prop, prop_oneof};
use proptest::{option, sample};
use protocol::map_file::NeuronRecord;
use protocol::message::{
    BUILD_ID_BYTES, Board, CHECKPOINTS_PER_MESSAGE, Checkpoints, FaultReport, Fields, FromBoard, FromHost,
    Health, Hello, MapRequest, MapSummary, NEURONS_PER_MESSAGE, Neurons, Outputs, PROTOCOL_VERSION,
    ParameterValue, Parameters, ROWS, Readings, Refusal, SENSORS, ScalarKind, Scan, TaskCounts, Telemetry,
    TimeBase,
};
use protocol::schema;

const BOARDS: [Board; 3] = [Board::Stm32f405, Board::Stm32f100, Board::Stub];
const SCALARS: [ScalarKind; 2] = [ScalarKind::F32, ScalarKind::Fixed];
const TIME_BASES: [TimeBase; 2] = [TimeBase::Lockstep, TimeBase::RealTime];
const MODES: [Mode; 3] = [Mode::Standby, Mode::Learn, Mode::Navigate];
const CAUSES: [StopCause; 9] = [
    StopCause::EmergencyStop,
    StopCause::NotArmed,
    StopCause::UntrainedMap,
    StopCause::ScanTooOld,
    StopCause::CommandTooOld,
    StopCause::Stalled,
    StopCause::LinkSilent,
    StopCause::DeadlineMissed,
    StopCause::DriveInvalid,
];

fn finite() -> impl Strategy<Value = f32> {
    any::<f32>().prop_filter("finite", |value| value.is_finite())
}

fn finite_of<const N: usize>() -> impl Strategy<Value = [f32; N]> {
    prop::collection::vec(finite(), N).prop_map(|values| values.try_into().unwrap())
}

fn point() -> impl Strategy<Value = Point<f32>> {
    (finite(), finite()).prop_map(|(x_m, y_m)| Point { x_m, y_m })
}

fn pose() -> impl Strategy<Value = Pose<f32>> {
    (finite(), finite(), finite()).prop_map(|(x_m, y_m, heading_rad)| Pose { x_m, y_m, heading_rad })
}

pub fn hello() -> impl Strategy<Value = Hello> {
    (
        any::<(u16, u64, u32, Option<u64>, Option<u64>)>(),
        "[0-9a-f]{0,40}",
        option::of(sample::select(&BOARDS[..])),
        option::of(sample::select(&SCALARS[..])),
        sample::select(&TIME_BASES[..]),
    )
        .prop_map(|(numbers, build_id, board, scalar, time_base)| {
            let (protocol_version, schema_hash, epoch, map_hash, parameters_hash) = numbers;
            Hello {
                protocol_version,
                schema_hash,
                build_id: String::try_from(build_id.as_str()).unwrap(),
                board,
                scalar,
                map_hash,
                parameters_hash,
                time_base,
                epoch,
            }
        })
}

fn readings() -> impl Strategy<Value = Readings> {
    let range = option::of(finite().prop_map(f32::abs));
    let scan = prop::array::uniform12(range).prop_map(|ranges_m| Scan { ranges_m });
    (any::<(u64, i32, i32)>(), option::of(pose()), option::of(scan), option::of(finite_of::<2>())).prop_map(
        |((tick, left, right), pose_fix, scan, exploration)| Readings {
            tick,
            encoders: EncoderCounts { left, right },
            pose_fix,
            scan,
            exploration,
        },
    )
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

fn parameter_value() -> impl Strategy<Value = ParameterValue> {
    (any::<u8>(), finite()).prop_map(|(index, value)| ParameterValue { index, value })
}

fn neurons() -> impl Strategy<Value = Neurons> {
    let record =
        (finite_of::<6>(), any::<bool>()).prop_map(|([bearing_rad, distance_per_reach, m @ ..], has_won)| {
            NeuronRecord { bearing_rad, distance_per_reach, left: [m[0], m[1]], right: [m[2], m[3]], has_won }
        });
    (any::<u16>(), prop::collection::vec(record, 0..=NEURONS_PER_MESSAGE))
        .prop_map(|(first, records)| Neurons { first, neurons: Vec::from_slice(&records).unwrap() })
}

pub fn from_host() -> impl Strategy<Value = FromHost> {
    let parameters = prop_oneof![
        any::<u8>().prop_map(|index| Parameters::Get { index }),
        parameter_value().prop_map(Parameters::Set),
        Just(Parameters::Commit),
        Just(Parameters::Defaults),
    ];
    let map = prop_oneof![
        Just(MapRequest::Describe),
        any::<u16>().prop_map(|first| MapRequest::Read { first }),
        neurons().prop_map(MapRequest::Write),
        any::<(u32, u64)>().prop_map(|(trained_steps, hash)| MapRequest::Confirm { trained_steps, hash }),
        Just(MapRequest::Forget),
    ];
    prop_oneof![
        hello().prop_map(FromHost::Hello),
        readings().prop_map(FromHost::Step),
        checkpoints().prop_map(FromHost::Checkpoints),
        Just(FromHost::Arm),
        Just(FromHost::Disarm),
        Just(FromHost::EStop),
        readings().prop_map(FromHost::Sense),
        Just(FromHost::Begin),
        sample::select(&MODES[..]).prop_map(FromHost::Mode),
        parameters.prop_map(FromHost::Parameters),
        map.prop_map(FromHost::Map),
        Just(FromHost::Health),
        Just(FromHost::Telemetry),
        any::<u8>().prop_map(|column| FromHost::Fields { column }),
    ]
}

fn outputs() -> impl Strategy<Value = Outputs> {
    let reached = any::<(u16, bool)>().prop_map(|(number, is_goal)| Reached { number, is_goal });
    let stopped = option::of(sample::select(&CAUSES[..]));
    (any::<(u64, u64, u64)>(), finite_of::<4>(), option::of(reached), stopped).prop_map(
        |((tick, commanded_at_tick, state_digest), [left, right, left_mps, right_mps], reached, stopped)| {
            Outputs {
                tick,
                wheel_drive: WheelDrive { left, right },
                wheel_speed_command: WheelSpeeds { left_mps, right_mps },
                commanded_at_tick,
                reached,
                stopped,
                state_digest,
            }
        },
    )
}

fn refusal() -> impl Strategy<Value = Refusal> {
    let checkpoints = prop_oneof![
        any::<(u16, u16)>().prop_map(|(count, capacity)| CheckpointError::TooMany { count, capacity }),
        any::<(u16, u16, u16)>().prop_map(|(number, first, end)| CheckpointError::NotAhead {
            number,
            first,
            end
        }),
        any::<u16>().prop_map(|position| CheckpointError::OutOfRange { position }),
    ];
    prop_oneof![
        Just(Refusal::Mismatch),
        sample::select(&TIME_BASES[..]).prop_map(|present| Refusal::TimeBase { present }),
        any::<(u64, u64)>().prop_map(|(expected, found)| Refusal::Tick { expected, found }),
        checkpoints.prop_map(Refusal::Checkpoints),
        any::<u8>().prop_map(|count| Refusal::NoSuchParameter { count }),
        any::<u8>().prop_map(|index| Refusal::BadParameter { index }),
        any::<u16>().prop_map(|count| Refusal::NoSuchNeurons { count }),
        any::<u64>().prop_map(|found| Refusal::MapHash { found }),
        Just(Refusal::EmergencyStop),
        Just(Refusal::NotStandingBy),
        Just(Refusal::NotFinite),
    ]
}

fn health() -> impl Strategy<Value = Health> {
    (any::<(u64, Option<u32>)>(), prop::array::uniform15(any::<u32>())).prop_map(
        |((tick, stack_bytes_max), n)| {
            let tasks = |at: usize| TaskCounts { servo: n[at], avoidance: n[at + 1], target: n[at + 2] };
            Health {
                tick,
                frames_good: n[0],
                frames_bad: n[1],
                requests_dropped: n[2],
                deadlines_missed: tasks(3),
                releases: tasks(6),
                response_us_max: tasks(9),
                servo_period_us_min: n[12],
                servo_period_us_max: n[13],
                readings_age_ms_max: n[14],
                stack_bytes_max,
            }
        },
    )
}

fn telemetry() -> impl Strategy<Value = Telemetry> {
    let polar = (finite(), finite()).prop_map(|(bearing_rad, distance_m)| Polar { bearing_rad, distance_m });
    let numbers = any::<((u64, u32, u32, u32), (u8, u8, u16, u16), bool)>();
    (numbers, sample::select(&MODES[..]), pose(), option::of(polar), finite()).prop_map(
        |((wide, narrow, is_target), mode, pose, target, activity)| Telemetry {
            tick: wide.0,
            mode,
            pose,
            checkpoints_ahead: narrow.0,
            trained_steps: wide.1,
            target,
            target_age_ms: wide.2,
            obstacles_age_ms: wide.3,
            winner: narrow.2,
            activity,
            judged: narrow.3,
            is_target,
            detections: narrow.1,
        },
    )
}

pub fn from_board() -> impl Strategy<Value = FromBoard> {
    let fault = (any::<(u64, bool)>(), sample::select(&CAUSES[..]))
        .prop_map(|((tick, latched), cause)| FaultReport { tick, cause, latched });
    let summary =
        any::<(u64, u32, u8, u8, u16)>().prop_map(|(hash, trained_steps, columns, rows, trained_neurons)| {
            MapSummary { hash, trained_steps, columns, rows, trained_neurons }
        });
    let fields = (any::<u8>(), finite_of::<ROWS>(), finite_of::<ROWS>())
        .prop_map(|(column, target, obstacles)| Fields { column, target, obstacles });
    prop_oneof![
        hello().prop_map(FromBoard::Hello),
        outputs().prop_map(FromBoard::Outputs),
        fault.prop_map(FromBoard::Fault),
        Just(FromBoard::Done),
        refusal().prop_map(FromBoard::Refused),
        parameter_value().prop_map(FromBoard::Parameter),
        summary.prop_map(FromBoard::Map),
        neurons().prop_map(FromBoard::Neurons),
        health().prop_map(FromBoard::Health),
        telemetry().prop_map(FromBoard::Telemetry),
        fields.prop_map(FromBoard::Fields),
    ]
}

/// A board's hello, every field present.
pub fn hello_example() -> Hello {
    Hello {
        protocol_version: PROTOCOL_VERSION,
        schema_hash: schema::HASH,
        build_id: String::try_from("0123456789abcdef0123456789abcdef01234567").unwrap(),
        board: Some(Board::Stm32f100),
        scalar: Some(ScalarKind::Fixed),
        map_hash: Some(u64::MAX),
        parameters_hash: Some(u64::MAX),
        time_base: TimeBase::Lockstep,
        epoch: u32::MAX,
    }
}

/// Readings with everything in them, and the largest numbers.
pub const READINGS: Readings = Readings {
    tick: u64::MAX,
    encoders: EncoderCounts { left: i32::MIN, right: i32::MIN },
    pose_fix: Some(Pose { x_m: 1.0, y_m: -2.0, heading_rad: 0.5 }),
    scan: Some(Scan { ranges_m: [Some(0.175); SENSORS] }),
    exploration: Some([1.0, -1.0]),
};

/// Outputs with everything in them, and the largest numbers.
pub const OUTPUTS: Outputs = Outputs {
    tick: u64::MAX,
    wheel_drive: WheelDrive { left: 0.25, right: -1.0 },
    wheel_speed_command: WheelSpeeds { left_mps: 0.04, right_mps: -0.16 },
    commanded_at_tick: u64::MAX,
    reached: Some(Reached { number: u16::MAX, is_goal: true }),
    stopped: Some(StopCause::Stalled),
    state_digest: u64::MAX,
};

/// As many neurons as a message holds.
pub fn full_neurons() -> Neurons {
    let record = NeuronRecord {
        bearing_rad: -0.25,
        distance_per_reach: 1.0,
        left: [-0.5, 1.0],
        right: [0.5, 1.0],
        has_won: true,
    };
    Neurons { first: u16::MAX, neurons: Vec::from_array([record; NEURONS_PER_MESSAGE]) }
}

/// As many checkpoints as a message holds.
pub fn full_checkpoints() -> Vec<Point<f32>, CHECKPOINTS_PER_MESSAGE> {
    Vec::from_array([Point { x_m: 1.0, y_m: -0.5 }; CHECKPOINTS_PER_MESSAGE])
}

/// One of every message of the host, and of every form of those that have several.
pub fn host_examples() -> std::vec::Vec<(&'static str, FromHost)> {
    let any_board = Hello {
        build_id: String::<BUILD_ID_BYTES>::new(),
        board: None,
        scalar: None,
        map_hash: None,
        parameters_hash: None,
        epoch: 0,
        ..hello_example()
    };
    let first_step = Readings { encoders: EncoderCounts { left: -1, right: 2 }, ..Readings::default() };
    let mut ranges_m = [None; SENSORS];
    ranges_m[0] = Some(0.175);
    ranges_m[11] = Some(0.0);
    let scan = Some(Scan { ranges_m });
    let two = || Vec::from_slice(&[Point { x_m: 1.0, y_m: -0.5 }, Point { x_m: 0.0, y_m: 2.0 }]).unwrap();
    let value = ParameterValue { index: 3, value: 0.25 };
    let one_neuron =
        Neurons { first: 224, neurons: full_neurons().neurons.iter().copied().take(1).collect() };
    vec![
        ("hello_to_any_board", FromHost::Hello(any_board)),
        ("hello_to_one_board", FromHost::Hello(hello_example())),
        ("step_of_counts_alone", FromHost::Step(first_step)),
        ("step_with_a_scan", FromHost::Step(Readings { tick: 128, scan, ..first_step })),
        ("step_with_everything", FromHost::Step(READINGS)),
        ("checkpoints_replace_all", FromHost::Checkpoints(Checkpoints::ReplaceAll(two()))),
        ("checkpoints_append_full", FromHost::Checkpoints(Checkpoints::Append(full_checkpoints()))),
        (
            "checkpoints_replace_one",
            FromHost::Checkpoints(Checkpoints::ReplaceOne { index: 7, point: Point { x_m: 1.0, y_m: -0.5 } }),
        ),
        ("checkpoints_clear", FromHost::Checkpoints(Checkpoints::Clear)),
        ("arm", FromHost::Arm),
        ("disarm", FromHost::Disarm),
        ("estop", FromHost::EStop),
        ("sense", FromHost::Sense(Readings { tick: 300, scan, ..first_step })),
        ("begin", FromHost::Begin),
        ("mode_standby", FromHost::Mode(Mode::Standby)),
        ("mode_learn", FromHost::Mode(Mode::Learn)),
        ("mode_navigate", FromHost::Mode(Mode::Navigate)),
        ("parameters_get", FromHost::Parameters(Parameters::Get { index: 3 })),
        ("parameters_set", FromHost::Parameters(Parameters::Set(value))),
        ("parameters_commit", FromHost::Parameters(Parameters::Commit)),
        ("parameters_defaults", FromHost::Parameters(Parameters::Defaults)),
        ("map_describe", FromHost::Map(MapRequest::Describe)),
        ("map_read", FromHost::Map(MapRequest::Read { first: 220 })),
        ("map_write", FromHost::Map(MapRequest::Write(one_neuron))),
        (
            "map_confirm",
            FromHost::Map(MapRequest::Confirm { trained_steps: 1000, hash: 0x0123_4567_89ab_cdef }),
        ),
        ("map_forget", FromHost::Map(MapRequest::Forget)),
        ("health", FromHost::Health),
        ("telemetry", FromHost::Telemetry),
        ("fields", FromHost::Fields { column: 7 }),
    ]
}

/// One of every message of the board, and of every form of those that have several.
pub fn board_examples() -> std::vec::Vec<(&'static str, FromBoard)> {
    let resting = Outputs { tick: 0, commanded_at_tick: 0, reached: None, stopped: None, ..OUTPUTS };
    let tasks = |servo| TaskCounts { servo, avoidance: servo / 128, target: servo / 256 };
    let health = Health {
        tick: 2560,
        frames_good: 2600,
        frames_bad: 1,
        requests_dropped: 0,
        deadlines_missed: TaskCounts::default(),
        releases: tasks(2560),
        response_us_max: tasks(25_600),
        servo_period_us_min: 990,
        servo_period_us_max: 1010,
        readings_age_ms_max: 2,
        stack_bytes_max: Some(1500),
    };
    let telemetry = Telemetry {
        tick: 2560,
        mode: Mode::Navigate,
        pose: Pose { x_m: 1.0, y_m: -2.0, heading_rad: 0.5 },
        checkpoints_ahead: 2,
        trained_steps: 1000,
        target: Some(Polar { bearing_rad: -0.25, distance_m: 0.5 }),
        target_age_ms: 0,
        obstacles_age_ms: 128,
        winner: 112,
        activity: 0.75,
        judged: 3,
        is_target: false,
        detections: 4,
    };
    let mut fields = Fields { column: 7, target: [0.0; ROWS], obstacles: [0.0; ROWS] };
    fields.target[14] = 1.0;
    fields.obstacles[0] = 0.5;
    let refused = |name, refusal| (name, FromBoard::Refused(refusal));
    let mut examples = vec![
        ("hello", FromBoard::Hello(hello_example())),
        ("outputs_at_rest", FromBoard::Outputs(resting)),
        ("outputs_with_everything", FromBoard::Outputs(OUTPUTS)),
        ("done", FromBoard::Done),
        refused("refused_mismatch", Refusal::Mismatch),
        refused("refused_time_base", Refusal::TimeBase { present: TimeBase::RealTime }),
        refused("refused_tick", Refusal::Tick { expected: 5, found: 300 }),
        refused(
            "refused_too_many_checkpoints",
            Refusal::Checkpoints(CheckpointError::TooMany { count: 17, capacity: 16 }),
        ),
        refused(
            "refused_checkpoint_not_ahead",
            Refusal::Checkpoints(CheckpointError::NotAhead { number: 1, first: 2, end: 5 }),
        ),
        refused(
            "refused_checkpoint_out_of_range",
            Refusal::Checkpoints(CheckpointError::OutOfRange { position: 3 }),
        ),
        refused("refused_no_such_parameter", Refusal::NoSuchParameter { count: 60 }),
        refused("refused_bad_parameter", Refusal::BadParameter { index: 3 }),
        refused("refused_no_such_neurons", Refusal::NoSuchNeurons { count: 225 }),
        refused("refused_map_hash", Refusal::MapHash { found: 0x0123_4567_89ab_cdef }),
        refused("refused_emergency_stop", Refusal::EmergencyStop),
        refused("refused_not_standing_by", Refusal::NotStandingBy),
        refused("refused_not_finite", Refusal::NotFinite),
        ("parameter", FromBoard::Parameter(ParameterValue { index: 3, value: 0.25 })),
        (
            "map",
            FromBoard::Map(MapSummary {
                hash: 0x0123_4567_89ab_cdef,
                trained_steps: 1000,
                columns: 15,
                rows: 15,
                trained_neurons: 200,
            }),
        ),
        ("neurons_full", FromBoard::Neurons(full_neurons())),
        ("health", FromBoard::Health(health)),
        ("telemetry", FromBoard::Telemetry(telemetry)),
        ("telemetry_without_target", FromBoard::Telemetry(Telemetry { target: None, ..telemetry })),
        ("fields", FromBoard::Fields(fields)),
    ];
    let causes = [
        "fault_emergency_stop",
        "fault_not_armed",
        "fault_untrained_map",
        "fault_scan_too_old",
        "fault_command_too_old",
        "fault_stalled",
        "fault_link_silent",
        "fault_deadline_missed",
        "fault_drive_invalid",
    ];
    examples.extend(causes.into_iter().zip(CAUSES).map(|(name, cause)| {
        (name, FromBoard::Fault(FaultReport { tick: 300, cause, latched: cause == StopCause::Stalled }))
    }));
    examples
}
