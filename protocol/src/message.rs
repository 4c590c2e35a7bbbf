//! What host and board say to each other.
//!
//! The host asks, the board answers: each [`FromHost`] but [`FromHost::Sense`] gets exactly one [`FromBoard`] with the
//! sequence number of its frame. Unasked, under sequence number 0, the board says [`FromBoard::Hello`] when it has
//! started, and in real time [`FromBoard::Outputs`], each tick or every few, and [`FromBoard::Fault`] when the wheels
//! were stopped.
//!
//! Readings, which nobody answers, go under sequence number 0 too: under a number they would let the others come round
//! sooner, to where the board takes a new request for the last one again.
//!
//! The number of a variant is its position, first byte of the body; variants are only ever appended:
//!
//! | | [`FromHost`] | answered by | [`FromBoard`] |
//! | --- | --- | --- | --- |
//! | 0 | `Hello` | `Hello`, `Refused` | `Hello` |
//! | 1 | `Step` | `Outputs`, `Refused` | `Outputs` |
//! | 2 | `Checkpoints` | `Done`, `Refused` | `Fault` |
//! | 3 | `Arm` | `Done`, `Refused` | `Done` |
//! | 4 | `Disarm` | `Done` | `Refused` |
//! | 5 | `EStop` | `Done` | `Parameter` |
//! | 6 | `Sense` | nothing | `Map` |
//! | 7 | `Begin` | `Done` | `Neurons` |
//! | 8 | `Mode` | `Done` | `Health` |
//! | 9 | `Parameters` | `Parameter`, `Done`, `Refused` | `Telemetry` |
//! | 10 | `Map` | `Map`, `Neurons`, `Done`, `Refused` | `Fields` |
//! | 11 | `Health` | `Health` | |
//! | 12 | `Telemetry` | `Telemetry` | |
//! | 13 | `Fields` | `Fields`, `Refused` | |

use controller_core::controller::Mode;
use controller_core::planning::checkpoint::{CheckpointError, Reached};
use controller_core::safety::StopCause;
use controller_core::scalar::Scalar;
use controller_core::units::{EncoderCounts, Point, Polar, Pose, WheelDrive, WheelSpeeds};
use core::fmt;
use heapless::{String, Vec};
use postcard_schema::Schema;
use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};

use crate::codec::{DecodeError, Message, all_finite, read};
use crate::map_file::NeuronRecord;

/// Version of the messages of this crate; two ends of different versions do not talk.
pub const PROTOCOL_VERSION: u16 = 2;

/// Proximity sensors of the robot, evenly spaced, number 0 straight ahead, anticlockwise.
pub const SENSORS: usize = 12;

/// Most checkpoints of one message; a longer list is sent as [`Checkpoints::ReplaceAll`] and [`Checkpoints::Append`]s.
///
/// Chosen because 16 keep the largest message under 140 bytes, which the receive buffer of a board with 8 KiB of
/// RAM can spare.
pub const CHECKPOINTS_PER_MESSAGE: usize = 16;

/// Most neurons of one message: as large as the longest list of checkpoints.
pub const NEURONS_PER_MESSAGE: usize = 5;

/// Rows of the map: neurons along the distance.
pub const ROWS: usize = 15;

/// Columns of the map: neurons along the bearing.
pub const COLUMNS: usize = 15;

/// Longest [`Hello::build_id`]: a whole commit hash.
pub const BUILD_ID_BYTES: usize = 40;

/// From the host to the board.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum FromHost {
    /// First message of a session: what the host expects. Changes nothing on the board but the time base.
    Hello(Hello),
    /// One tick's inputs; the board computes the tick. Lockstep only.
    Step(Readings),
    /// Where to go.
    Checkpoints(Checkpoints),
    /// Let the wheels turn. Refused until a [`FromHost::Disarm`] has ended an emergency stop.
    Arm,
    /// Wheels to zero until the next [`FromHost::Arm`]; also ends an emergency stop.
    Disarm,
    /// Wheels to zero at once; latched.
    EStop,
    /// Readings for the board's own ticks. Real time only; never answered, and a later one replaces it.
    Sense(Readings),
    /// A run begins: the controller as after a start, at tick 0, disarmed, standing by. Map and parameters stay.
    Begin,
    /// Stand by, learn or navigate.
    Mode(Mode),
    /// Read and set parameters.
    Parameters(Parameters),
    /// Read and replace the learned map.
    Map(MapRequest),
    /// Ask how the link and the tasks are doing.
    Health,
    /// Ask what the controller thinks.
    Telemetry,
    /// Ask for the fields over one column of the map.
    Fields {
        /// Which.
        column: u8,
    },
}

/// From the board to the host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum FromBoard {
    /// Unasked when the board has started, and the answer to the host's: what the board is.
    Hello(Hello),
    /// What a tick led to.
    Outputs(Outputs),
    /// The wheels were stopped.
    Fault(FaultReport),
    /// Done as asked.
    Done,
    /// Not done, and nothing was changed.
    Refused(Refusal),
    /// A parameter.
    Parameter(ParameterValue),
    /// The map as a whole.
    Map(MapSummary),
    /// Some of its neurons.
    Neurons(Neurons),
    /// How link and tasks are doing.
    Health(Health),
    /// What the controller thinks.
    Telemetry(Telemetry),
    /// The fields over one column of the map.
    Fields(Fields),
}

/// Reads a text that must be ASCII: checking all of UTF-8 is 300 bytes of flash.
fn ascii<'de, D: Deserializer<'de>, const N: usize>(from: D) -> Result<String<N>, D::Error> {
    struct Ascii<const N: usize>;
    impl<const N: usize> Visitor<'_> for Ascii<N> {
        type Value = String<N>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "at most {N} bytes of ASCII")
        }

        fn visit_bytes<E: de::Error>(self, bytes: &[u8]) -> Result<Self::Value, E> {
            let mut text = String::new();
            for &byte in bytes {
                if !byte.is_ascii() || text.push(char::from(byte)).is_err() {
                    return Err(E::invalid_length(bytes.len(), &self));
                }
            }
            Ok(text)
        }
    }
    // A text and its bytes are the same on the wire.
    from.deserialize_bytes(Ascii)
}

/// Who is speaking: the host says what it expects, the board what it is. No reals.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Hello {
    /// [`PROTOCOL_VERSION`] of the speaker.
    pub protocol_version: u16,
    /// [`crate::schema::HASH`] of the speaker: the shape of every message.
    pub schema_hash: u64,
    /// The build of the speaker, for people to read (commit hash or release, in ASCII); need not agree.
    #[serde(deserialize_with = "ascii")]
    pub build_id: String<BUILD_ID_BYTES>,
    /// The board; `None` where any will do.
    pub board: Option<Board>,
    /// What the controller computes with; `None` where any will do.
    pub scalar: Option<ScalarKind>,
    /// Hash of the learned map; `None` where there is no map yet, or where any will do.
    pub map_hash: Option<u64>,
    /// Hash of the parameters ([`controller_core::config::Config::hash`]); `None` where any will do.
    pub parameters_hash: Option<u64>,
    /// Who advances the tick; the host chooses.
    pub time_base: TimeBase,
    /// Sessions of the speaker since it was started; a new number tells the other side of a reset. Need not agree.
    pub epoch: u32,
}

/// The boards the firmware knows, and the process that stands for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Board {
    /// STM32F405 (Cortex-M4F).
    Stm32f405,
    /// STM32F100 (Cortex-M3, no FPU).
    Stm32f100,
    /// A process on the host that is the board as far as the link can tell.
    Stub,
}

/// The number type of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum ScalarKind {
    /// `f32`.
    F32,
    /// [`controller_core::scalar::Fixed`].
    Fixed,
}

/// Who advances the tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum TimeBase {
    /// The host: one [`FromHost::Step`], one tick.
    Lockstep,
    /// The board's timer: one tick per millisecond.
    RealTime,
}

/// What a tick's sensors say. Every real is finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Readings {
    /// Lockstep: the tick they belong to, milliseconds since [`FromHost::Begin`]. Real time: the board's latest tick
    /// that the host has seen; by its age the board measures the link.
    pub tick: u64,
    /// Encoder counts at this tick.
    pub encoders: EncoderCounts,
    /// Pose from outside, where one was measured for this tick.
    pub pose_fix: Option<Pose<f32>>,
    /// Proximity readings, where the sensors were read for this tick.
    pub scan: Option<Scan>,
    /// Random draws in ±1, at the ticks that begin a training step.
    pub exploration: Option<[f32; 2]>,
}

/// One reading of all proximity sensors. Every range is finite and not negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Scan {
    /// Distance from the robot's body along each sensor's axis; `None` where nothing is within reach.
    pub ranges_m: [Option<f32>; SENSORS],
}

/// What a tick led to. Every real is finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, Schema)]
pub struct Outputs {
    /// The tick: milliseconds since [`FromHost::Begin`].
    pub tick: u64,
    /// What the motors are driven with, in ±1.
    pub wheel_drive: WheelDrive<f32>,
    /// What the servo is asked for …
    pub wheel_speed_command: WheelSpeeds<f32>,
    /// … and since which tick.
    pub commanded_at_tick: u64,
    /// A checkpoint reached in this tick.
    pub reached: Option<Reached>,
    /// Why the wheels stand still, where they must.
    pub stopped: Option<StopCause>,
    /// Running digest over all that the controller decided since [`FromHost::Begin`]: equal digests, equal runs.
    pub state_digest: u64,
}

/// Changes the list of checkpoints. Every coordinate is finite.
///
/// An index outside the list, or more checkpoints than the controller holds, is a matter of the receiver's state
/// and so the receiver's to refuse.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Checkpoints {
    /// These, from the first.
    ReplaceAll(Vec<Point<f32>, CHECKPOINTS_PER_MESSAGE>),
    /// These, after the last.
    Append(Vec<Point<f32>, CHECKPOINTS_PER_MESSAGE>),
    /// One, in place.
    ReplaceOne {
        /// Which, counted from the first of the list as last replaced.
        index: u8,
        /// Where to, in the world frame.
        point: Point<f32>,
    },
    /// None: the robot stops.
    Clear,
}

/// The wheels were stopped. No reals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct FaultReport {
    /// The tick at which it was noticed: milliseconds since start.
    pub tick: u64,
    /// Why.
    pub cause: StopCause,
    /// Whether the wheels stay at zero until the host acts; otherwise the stop ends with its cause.
    pub latched: bool,
}

/// Why the board has not done what it was asked. No reals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum Refusal {
    /// No hello has come yet that fits; the board's own, with which it answers every hello, says in what.
    Mismatch,
    /// Only in the other time base.
    TimeBase {
        /// The present one.
        present: TimeBase,
    },
    /// A step that does not follow the last one.
    Tick {
        /// The next tick.
        expected: u64,
        /// The tick of the step.
        found: u64,
    },
    /// The list of checkpoints cannot be changed so.
    Checkpoints(CheckpointError),
    /// There is no parameter of this number.
    NoSuchParameter {
        /// How many there are.
        count: u8,
    },
    /// The parameters cannot be used; all stay as they were.
    BadParameter {
        /// The first that cannot be.
        index: u8,
    },
    /// The map has no such neurons.
    NoSuchNeurons {
        /// How many there are.
        count: u16,
    },
    /// The map as received is not the one that was sent.
    MapHash {
        /// Hash of the map as it is now on the board.
        found: u64,
    },
    /// An emergency stop is latched.
    EmergencyStop,
    /// Not while the robot learns or navigates.
    NotStandingBy,
    /// The answer would hold a number that is not finite.
    NotFinite,
}

/// Reads and sets parameters. They are numbered as in [`controller_core::config::PARAMETERS`], which has name, unit,
/// range and default of each. Every real is finite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Parameters {
    /// What is the value, staged changes included?
    Get {
        /// Of which.
        index: u8,
    },
    /// Stage a change: it acts from the next [`Parameters::Commit`].
    Set(ParameterValue),
    /// Check all as a group and use them from the next tick. Refused, those in use stay, and what was staged waits to
    /// be corrected.
    Commit,
    /// Stage the defaults of all.
    Defaults,
}

/// A parameter and its value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct ParameterValue {
    /// Which.
    pub index: u8,
    /// In the unit of the list; what is counted or chosen is a whole number.
    pub value: f32,
}

/// Reads and replaces the learned map. Neurons are numbered column × rows + row. Every real is finite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum MapRequest {
    /// What map is it?
    Describe,
    /// Give [`NEURONS_PER_MESSAGE`] neurons from this one on, or what is left of them.
    Read {
        /// Number of the first.
        first: u16,
    },
    /// Replace neurons. Not while the robot learns or navigates.
    Write(Neurons),
    /// End of a replacement: the map has been trained for so many steps, and is now that of this hash.
    Confirm {
        /// Training steps it has seen.
        trained_steps: u32,
        /// Its hash, as [`MapSummary::hash`].
        hash: u64,
    },
    /// Forget everything learned.
    Forget,
}

/// The learned map as a whole. No reals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct MapSummary {
    /// Hash of all neurons ([`controller_core::kohonen::map::Map::hash`]).
    pub hash: u64,
    /// Training steps it has seen.
    pub trained_steps: u32,
    /// Neurons along the bearing.
    pub columns: u8,
    /// Neurons along the distance.
    pub rows: u8,
    /// Neurons that have won in training.
    pub trained_neurons: u16,
}

/// Some neurons of the map. Every real is finite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Neurons {
    /// Number of the first.
    pub first: u16,
    /// It and those that follow, column by column.
    pub neurons: Vec<NeuronRecord, NEURONS_PER_MESSAGE>,
}

/// How link and tasks are doing, since the board was started. No reals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Health {
    /// The tick.
    pub tick: u64,
    /// Frames received whole.
    pub frames_good: u32,
    /// Frames received damaged: checksum, stuffing, length, another schema.
    pub frames_bad: u32,
    /// Requests lost because another was still being answered.
    pub requests_dropped: u32,
    /// Releases of a task whose job before was not done yet.
    pub deadlines_missed: TaskCounts,
    /// Releases.
    pub releases: TaskCounts,
    /// Longest time from release to end of a job.
    pub response_us_max: TaskCounts,
    /// Shortest time between two starts of the servo.
    pub servo_period_us_min: u32,
    /// Longest time between two starts of the servo.
    pub servo_period_us_max: u32,
    /// Oldest readings that the servo has worked with.
    pub readings_age_ms_max: u32,
    /// Deepest stack so far; `None` where it is not measured.
    pub stack_bytes_max: Option<u32>,
}

/// One number for each task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct TaskCounts {
    /// Homeostatic control.
    pub servo: u32,
    /// Obstacle avoidance.
    pub avoidance: u32,
    /// Target reaching.
    pub target: u32,
}

/// What the controller thinks. Every real is finite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Telemetry {
    /// The tick.
    pub tick: u64,
    /// What the board is to do.
    pub mode: Mode,
    /// Where it believes to be.
    pub pose: Pose<f32>,
    /// Checkpoints ahead.
    pub checkpoints_ahead: u8,
    /// Training steps so far.
    pub trained_steps: u32,
    /// The target of the target field, robot frame; `None` without one.
    pub target: Option<Polar<f32>>,
    /// Age of the target field.
    pub target_age_ms: u32,
    /// Age of the obstacle fields.
    pub obstacles_age_ms: u32,
    /// The winner of neural integration, column × rows + row.
    pub winner: u16,
    /// Its activity `e_k`, swept path included.
    pub activity: f32,
    /// Candidates judged until it was found.
    pub judged: u16,
    /// The winner stands for the target itself: nothing diverts the robot.
    pub is_target: bool,
    /// Detected points of the last scan that were used.
    pub detections: u8,
}

/// The fields over one column of the map, row by row. Every real is finite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Fields {
    /// Which column.
    pub column: u8,
    /// The target field `a_i`, amplitude included; 0 without a target.
    pub target: [f32; ROWS],
    /// The obstacle fields summed, `Σ_j b_ij`; 0 for neurons that never won.
    pub obstacles: [f32; ROWS],
}

/// Two ends that must not work together; both sides are named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mismatch {
    /// They speak different versions of this protocol.
    ProtocolVersion {
        /// This side's.
        ours: u16,
        /// The other side's.
        theirs: u16,
    },
    /// They have different messages.
    Schema {
        /// This side's.
        ours: u64,
        /// The other side's.
        theirs: u64,
    },
    /// Another board than expected.
    Board {
        /// This side's.
        ours: Board,
        /// The other side's.
        theirs: Board,
    },
    /// Another number type than expected: the runs would differ.
    Scalar {
        /// This side's.
        ours: ScalarKind,
        /// The other side's.
        theirs: ScalarKind,
    },
    /// Both have a map, and not the same.
    MapHash {
        /// This side's.
        ours: u64,
        /// The other side's.
        theirs: u64,
    },
    /// Both name their parameters, and not the same.
    ParametersHash {
        /// This side's.
        ours: u64,
        /// The other side's.
        theirs: u64,
    },
    /// Both or neither would advance the tick.
    TimeBase {
        /// This side's.
        ours: TimeBase,
        /// The other side's.
        theirs: TimeBase,
    },
}

impl Hello {
    /// Whether two ends may work together.
    ///
    /// # Errors
    /// The first field that forbids it, the version before all others: without it the rest means nothing.
    pub fn check_against(&self, theirs: &Self) -> Result<(), Mismatch> {
        if self.protocol_version != theirs.protocol_version {
            return Err(Mismatch::ProtocolVersion {
                ours: self.protocol_version,
                theirs: theirs.protocol_version,
            });
        }
        if self.schema_hash != theirs.schema_hash {
            return Err(Mismatch::Schema { ours: self.schema_hash, theirs: theirs.schema_hash });
        }
        if let (Some(ours), Some(theirs)) = (self.board, theirs.board)
            && ours != theirs
        {
            return Err(Mismatch::Board { ours, theirs });
        }
        if let (Some(ours), Some(theirs)) = (self.scalar, theirs.scalar)
            && ours != theirs
        {
            return Err(Mismatch::Scalar { ours, theirs });
        }
        if let (Some(ours), Some(theirs)) = (self.map_hash, theirs.map_hash)
            && ours != theirs
        {
            return Err(Mismatch::MapHash { ours, theirs });
        }
        if let (Some(ours), Some(theirs)) = (self.parameters_hash, theirs.parameters_hash)
            && ours != theirs
        {
            return Err(Mismatch::ParametersHash { ours, theirs });
        }
        if self.time_base != theirs.time_base {
            return Err(Mismatch::TimeBase { ours: self.time_base, theirs: theirs.time_base });
        }
        Ok(())
    }
}

impl ScalarKind {
    /// The kind of a scalar type, by its name; `None` for one the wire has no number for.
    ///
    /// ```
    /// use protocol::message::ScalarKind;
    /// assert_eq!(ScalarKind::of::<f32>(), Some(ScalarKind::F32));
    /// ```
    #[must_use]
    pub fn of<S: Scalar>() -> Option<Self> {
        [Self::F32, Self::Fixed].into_iter().find(|kind| kind.name() == S::NAME)
    }

    /// The name users type and read, as [`Scalar::NAME`].
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::Fixed => "fixed",
        }
    }
}

impl Board {
    /// The name users type and read.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stm32f405 => "stm32f405",
            Self::Stm32f100 => "stm32f100",
            Self::Stub => "stub",
        }
    }
}

impl TimeBase {
    /// The name users type and read.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lockstep => "lockstep",
            Self::RealTime => "real-time",
        }
    }
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ProtocolVersion { ours, theirs } => {
                write!(f, "protocol version {theirs} on the other side, {ours} on this")
            }
            Self::Schema { ours, theirs } => {
                write!(f, "message schema {theirs:016x} on the other side, {ours:016x} on this")
            }
            Self::Board { ours, theirs } => {
                write!(f, "board {} on the other side, {} expected", theirs.name(), ours.name())
            }
            Self::Scalar { ours, theirs } => {
                write!(f, "scalar {} on the other side, {} on this", theirs.name(), ours.name())
            }
            Self::MapHash { ours, theirs } => {
                write!(f, "map {theirs:016x} on the other side, {ours:016x} on this")
            }
            Self::ParametersHash { ours, theirs } => {
                write!(f, "parameters {theirs:016x} on the other side, {ours:016x} on this")
            }
            Self::TimeBase { ours, theirs } => {
                write!(f, "time base {} on the other side, {} on this", theirs.name(), ours.name())
            }
        }
    }
}

impl core::error::Error for Mismatch {}

impl Message for FromHost {
    const KINDS: u8 = 14;
    // Variant, variant of the change, length, points.
    const MAX_BYTES: usize = 1 + 1 + 1 + CHECKPOINTS_PER_MESSAGE * (4 + 4);

    fn read(bytes: &[u8]) -> Result<Self, DecodeError> {
        read(bytes, Self::first_invalid)
    }

    fn first_invalid(&self) -> Option<&'static str> {
        match self {
            Self::Step(readings) | Self::Sense(readings) => readings.first_invalid(),
            Self::Checkpoints(checkpoints) => checkpoints.first_invalid(),
            Self::Parameters(Parameters::Set(parameter)) => parameter.first_invalid(),
            Self::Map(MapRequest::Write(neurons)) => neurons.first_invalid(),
            Self::Hello(_)
            | Self::Arm
            | Self::Disarm
            | Self::EStop
            | Self::Begin
            | Self::Mode(_)
            | Self::Parameters(Parameters::Get { .. } | Parameters::Commit | Parameters::Defaults)
            | Self::Map(_)
            | Self::Health
            | Self::Telemetry
            | Self::Fields { .. } => None,
        }
    }
}

impl Message for FromBoard {
    const KINDS: u8 = 11;
    // Neurons: variant, number of the first, length, neurons.
    const MAX_BYTES: usize = 1 + 3 + 1 + NEURONS_PER_MESSAGE * NeuronRecord::BYTES;

    fn read(bytes: &[u8]) -> Result<Self, DecodeError> {
        read(bytes, Self::first_invalid)
    }

    fn first_invalid(&self) -> Option<&'static str> {
        match self {
            Self::Outputs(outputs) => outputs.first_invalid(),
            Self::Parameter(parameter) => parameter.first_invalid(),
            Self::Neurons(neurons) => neurons.first_invalid(),
            Self::Telemetry(telemetry) => telemetry.first_invalid(),
            Self::Fields(fields) => fields.first_invalid(),
            Self::Hello(_)
            | Self::Fault(_)
            | Self::Done
            | Self::Refused(_)
            | Self::Map(_)
            | Self::Health(_) => None,
        }
    }
}

const _: () = {
    // One buffer for either: neurons, down and up, are the largest after checkpoints.
    assert!(FromHost::MAX_BYTES >= 1 + 1 + 3 + 1 + NEURONS_PER_MESSAGE * NeuronRecord::BYTES);
    // Hello: variant, version, schema, length and build id, board, scalar, two hashes, time base, epoch.
    assert!(FromBoard::MAX_BYTES >= 1 + 3 + 10 + (1 + BUILD_ID_BYTES) + 2 + 2 + 2 * (1 + 10) + 1 + 5);
    // Health: variant, tick, three counts, three times three, three, stack.
    assert!(FromBoard::MAX_BYTES >= 1 + 10 + 5 * (3 + 9 + 3) + 1 + 5);
    assert!(FromBoard::MAX_BYTES >= 1 + 1 + 2 * ROWS * 4, "fields");
};

impl ParameterValue {
    fn first_invalid(&self) -> Option<&'static str> {
        all_finite(&[("parameter.value", self.value)])
    }
}

impl Neurons {
    fn first_invalid(&self) -> Option<&'static str> {
        self.neurons.iter().find_map(NeuronRecord::first_invalid)
    }
}

impl FromHost {
    /// Number of [`FromHost::EStop`].
    pub const ESTOP: u8 = 5;

    /// Number of [`FromHost::Sense`].
    pub const SENSE: u8 = 6;

    /// The readings of a [`FromHost::Sense`] alone, from its body; `None` where it is another message. For who has no
    /// room for the largest of all messages.
    #[must_use]
    pub fn read_sense(body: &[u8]) -> Option<Result<Readings, DecodeError>> {
        match body.split_first() {
            Some((&Self::SENSE, readings)) => Some(read(readings, Readings::first_invalid)),
            _ => None,
        }
    }
}

impl Readings {
    fn first_invalid(&self) -> Option<&'static str> {
        let pose = self.pose_fix.as_ref().and_then(|pose| {
            all_finite(&[
                ("pose_fix.x_m", pose.x_m),
                ("pose_fix.y_m", pose.y_m),
                ("pose_fix.heading_rad", pose.heading_rad),
            ])
        });
        let usable = |range_m: &f32| range_m.is_finite() && *range_m >= 0.0;
        let scan = self.scan.as_ref().filter(|scan| !scan.ranges_m.iter().flatten().all(usable));
        let draws = self.exploration.as_ref().filter(|draws| !draws.iter().all(|draw| draw.is_finite()));
        pose.or(scan.map(|_| "scan.ranges_m")).or(draws.map(|_| "exploration"))
    }
}

impl Outputs {
    fn first_invalid(&self) -> Option<&'static str> {
        all_finite(&[
            ("wheel_drive.left", self.wheel_drive.left),
            ("wheel_drive.right", self.wheel_drive.right),
            ("wheel_speed_command.left_mps", self.wheel_speed_command.left_mps),
            ("wheel_speed_command.right_mps", self.wheel_speed_command.right_mps),
        ])
    }
}

impl Telemetry {
    fn first_invalid(&self) -> Option<&'static str> {
        let target = self.target.map_or([0.0; 2], |target| [target.bearing_rad, target.distance_m]);
        all_finite(&[
            ("telemetry.pose.x_m", self.pose.x_m),
            ("telemetry.pose.y_m", self.pose.y_m),
            ("telemetry.pose.heading_rad", self.pose.heading_rad),
            ("telemetry.target.bearing_rad", target[0]),
            ("telemetry.target.distance_m", target[1]),
            ("telemetry.activity", self.activity),
        ])
    }
}

impl Fields {
    fn first_invalid(&self) -> Option<&'static str> {
        let finite = |values: &[f32]| values.iter().all(|value| value.is_finite());
        if !finite(&self.target) {
            Some("fields.target")
        } else if finite(&self.obstacles) {
            None
        } else {
            Some("fields.obstacles")
        }
    }
}

impl Checkpoints {
    fn first_invalid(&self) -> Option<&'static str> {
        let of_point = |point: &Point<f32>| {
            all_finite(&[("checkpoints.x_m", point.x_m), ("checkpoints.y_m", point.y_m)])
        };
        match self {
            Self::ReplaceAll(points) | Self::Append(points) => points.iter().find_map(of_point),
            Self::ReplaceOne { point, .. } => of_point(point),
            Self::Clear => None,
        }
    }
}
