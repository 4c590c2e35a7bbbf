//! What host and board say to each other.
//!
//! The number of a variant is its position, first byte of the body; variants are only ever appended:
//!
//! | | [`FromHost`] | [`FromBoard`] |
//! | --- | --- | --- |
//! | 0 | `Hello` | `Hello` |
//! | 1 | `Step` | `Outputs` |
//! | 2 | `Checkpoints` | `Fault` |
//! | 3 | `Arm` | |
//! | 4 | `Disarm` | |
//! | 5 | `EStop` | |

use controller_core::scalar::Scalar;
use controller_core::units::{EncoderCounts, Point, Pose, WheelDrive, WheelSpeeds};
use core::fmt;
use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

use crate::codec::{Message, all_finite};

/// Version of the messages of this crate; two ends of different versions do not talk.
pub const PROTOCOL_VERSION: u16 = 1;

/// Proximity sensors of the robot, evenly spaced, number 0 straight ahead, anticlockwise.
pub const SENSORS: usize = 12;

/// Most checkpoints of one message; a longer list is sent as [`Checkpoints::ReplaceAll`] and [`Checkpoints::Append`]s.
///
/// Chosen because 16 keep the largest message under 140 bytes, which the receive buffer of a board with 8 KiB of
/// RAM can spare.
pub const CHECKPOINTS_PER_MESSAGE: usize = 16;

/// Longest [`Hello::build_id`]: a whole commit hash.
pub const BUILD_ID_BYTES: usize = 40;

/// From the host to the board.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum FromHost {
    /// First message of a session: what the host expects.
    Hello(Hello),
    /// One tick's inputs.
    Step(Step),
    /// Where to go.
    Checkpoints(Checkpoints),
    /// Let the wheels turn. Refused with [`FaultCause::EStop`] until a [`FromHost::Disarm`] has ended the stop.
    Arm,
    /// Wheels to zero until the next [`FromHost::Arm`]; also ends an emergency stop.
    Disarm,
    /// Wheels to zero at once; latched.
    EStop,
}

/// From the board to the host.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum FromBoard {
    /// First message of a session, and the answer to the host's: what the board is.
    Hello(Hello),
    /// What a tick led to.
    Outputs(Outputs),
    /// Something stopped or endangers the motion.
    Fault(FaultReport),
}

/// Who is speaking: the host says what it expects, the board what it is. No reals.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// [`PROTOCOL_VERSION`] of the speaker.
    pub protocol_version: u16,
    /// The build of the speaker, for people to read (commit hash or release); need not agree.
    pub build_id: String<BUILD_ID_BYTES>,
    /// The board.
    pub board: Board,
    /// What the controller computes with.
    pub scalar: ScalarKind,
    /// Hash of the learned map; `None` where there is no map yet, or where any will do.
    pub map_hash: Option<u64>,
    /// Who advances the tick; the host chooses.
    pub time_base: TimeBase,
    /// Sessions of the speaker since it was started; a new number tells the other side of a reset. Need not agree.
    pub epoch: u32,
}

/// The boards the firmware knows, and the process that stands for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Board {
    /// STM32F405 (Cortex-M4F).
    Stm32f405,
    /// STM32F100 (Cortex-M3, no FPU).
    Stm32f100,
    /// A process on the host that is the board as far as the link can tell.
    Stub,
}

/// The number type of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ScalarKind {
    /// `f32`.
    F32,
    /// [`controller_core::scalar::Fixed`].
    Fixed,
}

/// Who advances the tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TimeBase {
    /// The host: one [`Step`], one tick.
    Lockstep,
    /// The board's timer: one tick per millisecond.
    RealTime,
}

/// One tick's inputs. Every real is finite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// The tick they belong to: milliseconds since start.
    pub tick: u64,
    /// Encoder counts at this tick.
    pub encoders: EncoderCounts,
    /// Pose from outside, where one was measured for this tick.
    pub pose_fix: Option<Pose<f32>>,
    /// Proximity readings, where the sensors were read for this tick.
    pub scan: Option<Scan>,
}

/// One reading of all proximity sensors. Every range is finite and not negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scan {
    /// Distance from the robot's body along each sensor's axis; `None` where nothing is within reach.
    pub ranges_m: [Option<f32>; SENSORS],
}

/// What a tick led to. Every real is finite.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outputs {
    /// The tick: milliseconds since start.
    pub tick: u64,
    /// What the motors are driven with, in ±1.
    pub wheel_drive: WheelDrive<f32>,
    /// What the servo is asked for.
    pub wheel_speed_command: WheelSpeeds<f32>,
    /// The winning neuron, column × rows + row; `None` where none has been chosen.
    pub winner: Option<u16>,
    /// Digest of the controller's whole state after this tick: equal digests, equal runs.
    pub state_digest: u64,
}

/// Changes the list of checkpoints. Every coordinate is finite.
///
/// An index outside the list, or more checkpoints than the controller holds, is a matter of the receiver's state
/// and so the receiver's to refuse.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// Something stopped or endangers the motion. No reals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultReport {
    /// The tick at which it was noticed: milliseconds since start.
    pub tick: u64,
    /// What happened.
    pub cause: FaultCause,
    /// Whether the wheels stay at zero until the host acts; otherwise the fault ends with its cause.
    pub latched: bool,
}

/// Why the wheels were stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FaultCause {
    /// A motion was asked for, but the host has not armed the board.
    NotArmed,
    /// The host asked for an emergency stop.
    EStop,
    /// Nothing valid came over the link for this long.
    LinkSilent {
        /// Time since the last valid message.
        silent_ms: u32,
    },
    /// The latest sensor readings are too old to act on.
    SensorsStale {
        /// Their age.
        age_ms: u32,
    },
    /// A command was not a number.
    CommandNotFinite,
    /// A command lay outside what the wheels can do.
    CommandOutOfRange,
    /// The servo drives a wheel that does not turn.
    ServoStalled {
        /// Which wheel.
        wheel: Wheel,
    },
    /// Work was not done in its period.
    DeadlineMissed {
        /// Deadlines missed since start.
        missed_count: u32,
    },
}

/// One of the two wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wheel {
    /// The left one.
    Left,
    /// The right one.
    Right,
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
        if self.board != theirs.board {
            return Err(Mismatch::Board { ours: self.board, theirs: theirs.board });
        }
        if self.scalar != theirs.scalar {
            return Err(Mismatch::Scalar { ours: self.scalar, theirs: theirs.scalar });
        }
        if let (Some(ours), Some(theirs)) = (self.map_hash, theirs.map_hash)
            && ours != theirs
        {
            return Err(Mismatch::MapHash { ours, theirs });
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
            Self::Board { ours, theirs } => {
                write!(f, "board {} on the other side, {} expected", theirs.name(), ours.name())
            }
            Self::Scalar { ours, theirs } => {
                write!(f, "scalar {} on the other side, {} on this", theirs.name(), ours.name())
            }
            Self::MapHash { ours, theirs } => {
                write!(f, "map {theirs:016x} on the other side, {ours:016x} on this")
            }
            Self::TimeBase { ours, theirs } => {
                write!(f, "time base {} on the other side, {} on this", theirs.name(), ours.name())
            }
        }
    }
}

impl core::error::Error for Mismatch {}

impl Message for FromHost {
    const KINDS: u8 = 6;
    // Variant, variant of the change, length, points.
    const MAX_BYTES: usize = 1 + 1 + 1 + CHECKPOINTS_PER_MESSAGE * (4 + 4);

    fn first_invalid(&self) -> Option<&'static str> {
        match self {
            Self::Step(step) => step.first_invalid(),
            Self::Checkpoints(checkpoints) => checkpoints.first_invalid(),
            Self::Hello(_) | Self::Arm | Self::Disarm | Self::EStop => None,
        }
    }
}

impl Message for FromBoard {
    const KINDS: u8 = 3;
    // Hello: variant, version, length and build id, board, scalar, map hash, time base, epoch.
    const MAX_BYTES: usize = 1 + 3 + (1 + BUILD_ID_BYTES) + 1 + 1 + (1 + 10) + 1 + 5;

    fn first_invalid(&self) -> Option<&'static str> {
        match self {
            Self::Outputs(outputs) => outputs.first_invalid(),
            Self::Hello(_) | Self::Fault(_) => None,
        }
    }
}

impl Step {
    fn first_invalid(&self) -> Option<&'static str> {
        let pose = self.pose_fix.and_then(|pose| {
            all_finite(&[
                ("pose_fix.x_m", pose.x_m),
                ("pose_fix.y_m", pose.y_m),
                ("pose_fix.heading_rad", pose.heading_rad),
            ])
        });
        let usable = |range_m: &f32| range_m.is_finite() && *range_m >= 0.0;
        let scan = self.scan.filter(|scan| !scan.ranges_m.iter().flatten().all(usable));
        pose.or(scan.map(|_| "scan.ranges_m"))
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
