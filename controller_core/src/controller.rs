//! The controller: the fast and the slow half together, and the order within a tick.
//!
//! [`tick`] runs a whole tick in the documented order; it is what simulator, stub and lockstep firmware call. Firmware
//! with preemptive tasks calls the two halves itself, at their own priorities: [`crate::reflex`] each millisecond,
//! [`crate::deliberation`] when it is released. No event can fail, allocate or block.

use crate::config::Parameters;
use crate::deliberation::Deliberation;
use crate::integration::neural::Decision;
use crate::kohonen::map::Map;
use crate::kohonen::output::{ControlMatrix, Output};
use crate::kohonen::self_organisation::Plasticity;
use crate::localisation::obstacle::ObstacleField;
use crate::localisation::separation::{Others, Report};
use crate::localisation::target::TargetField;
use crate::planning::checkpoint::{Checkpoints, Reached};
use crate::reflex::Reflex;
use crate::safety::{Gate, StopCause};
use crate::scalar::Scalar;
use crate::schedule::{Release, Stamped, Tick};
use crate::sensing::proximity::Scan;
use crate::state_hash::StateHash;
use crate::units::{EncoderCounts, Point, Pose, WheelDrive, WheelSpeeds};

/// Checkpoints held at a time.
pub const CHECKPOINTS: usize = 16;
/// Obstacle points remembered at a time: those of the last scans, most of them merged.
pub const MEMORY_POINTS: usize = 6;
/// What may move and is followed at a time, where there is room for it: boards follow nothing, see
/// [`crate::localisation::mover`].
pub const MOVERS: usize = 6;

/// What the controller is to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum Mode {
    /// Stand still.
    #[default]
    Standby,
    /// Move about an obstacle-free place and train the map online, from the first untrained move.
    Learn,
    /// Go to the checkpoints, avoiding obstacles.
    Navigate,
}

/// What comes in at a tick. Readings that are not due may be given; they are latched when their module is released.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs<S, const SENSORS: usize> {
    /// The encoder counters.
    pub encoders: EncoderCounts,
    /// A pose measured from outside, where there is one.
    pub pose_fix: Option<Pose<S>>,
    /// A new scan, where there is one.
    pub scan: Option<Scan<S, SENSORS>>,
    /// Two random draws in ±1 for exploration while learning; needed at the ticks that begin a training step.
    pub exploration: [S; 2],
}

impl<S: Scalar, const SENSORS: usize> Default for Inputs<S, SENSORS> {
    fn default() -> Self {
        Self { encoders: EncoderCounts::default(), pose_fix: None, scan: None, exploration: [S::ZERO; 2] }
    }
}

impl<const SENSORS: usize> Inputs<f32, SENSORS> {
    /// The same in another scalar; what it cannot hold is saturated.
    #[must_use]
    pub fn converted<S: Scalar>(&self) -> Inputs<S, SENSORS> {
        let pose = |pose: Pose<f32>| Pose {
            x_m: S::from_f32(pose.x_m),
            y_m: S::from_f32(pose.y_m),
            heading_rad: S::from_f32(pose.heading_rad),
        };
        Inputs {
            encoders: self.encoders,
            pose_fix: self.pose_fix.map(pose),
            scan: self.scan.map(|scan| Scan { range_m: scan.range_m.map(|range| range.map(S::from_f32)) }),
            exploration: self.exploration.map(S::from_f32),
        }
    }
}

/// What goes out at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outputs<S> {
    /// What to drive the motors with until the next tick.
    pub drive: WheelDrive<S>,
    /// The motor command c that the servo holds.
    pub command: Stamped<WheelSpeeds<S>>,
    /// A checkpoint reached in this tick.
    pub reached: Option<Reached>,
    /// Why the wheels stand still, where they must.
    pub stopped: Option<StopCause>,
    /// What was released in this tick.
    pub released: Release,
}

impl<S: Scalar> Outputs<S> {
    /// The same in `f32`.
    #[must_use]
    pub fn to_f32(&self) -> Outputs<f32> {
        let speeds = self.command.value;
        Outputs {
            drive: WheelDrive { left: self.drive.left.to_f32(), right: self.drive.right.to_f32() },
            command: Stamped {
                value: WheelSpeeds {
                    left_mps: speeds.left_mps.to_f32(),
                    right_mps: speeds.right_mps.to_f32(),
                },
                renewed: self.command.renewed,
            },
            reached: self.reached,
            stopped: self.stopped,
            released: self.released,
        }
    }
}

/// The whole architecture: both halves in static memory.
///
/// `O` is the output layer of the map: [`ControlMatrix`] (indirect) or
/// [`crate::kohonen::output::MotorVector`] (direct).
#[derive(Clone, Debug)]
pub struct Controller<
    S: Scalar,
    O = ControlMatrix<<S as Scalar>::Weight>,
    const COLUMNS: usize = 15,
    const ROWS: usize = 15,
    const SENSORS: usize = 12,
    const TRACKS: usize = MOVERS,
> {
    /// The fast half.
    pub reflex: Reflex<S>,
    /// The slow half.
    pub deliberation: Deliberation<S, O, COLUMNS, ROWS, SENSORS, TRACKS>,
}

impl<
    S: Scalar,
    O: Output<S>,
    const COLUMNS: usize,
    const ROWS: usize,
    const SENSORS: usize,
    const TRACKS: usize,
> Default for Controller<S, O, COLUMNS, ROWS, SENSORS, TRACKS>
{
    fn default() -> Self {
        Self::new(Map::regular(), 0)
    }
}

/// One tick of both halves, everything in the order of [`crate::schedule`].
// On a host the whole tick becomes one function, in a sixth less time; on a board flash is dearer than calls.
#[cfg_attr(not(target_os = "none"), inline(always))]
pub fn tick<
    S: Scalar,
    O: Output<S>,
    const COLUMNS: usize,
    const ROWS: usize,
    const SENSORS: usize,
    const TRACKS: usize,
>(
    reflex: &mut Reflex<S>,
    deliberation: &mut Deliberation<S, O, COLUMNS, ROWS, SENSORS, TRACKS>,
    p: &Parameters<S, SENSORS>,
    now: Tick,
    inputs: &Inputs<S, SENSORS>,
) -> Outputs<S> {
    tick_among(reflex, deliberation, p, now, inputs, &Others::<S, 0>::NONE)
}

/// As [`tick`], among other robots that are known of.
// On a host only, as above.
#[cfg_attr(not(target_os = "none"), inline(always))]
pub fn tick_among<
    S: Scalar,
    O: Output<S>,
    const COLUMNS: usize,
    const ROWS: usize,
    const SENSORS: usize,
    const TRACKS: usize,
    const COUNT: usize,
>(
    reflex: &mut Reflex<S>,
    deliberation: &mut Deliberation<S, O, COLUMNS, ROWS, SENSORS, TRACKS>,
    p: &Parameters<S, SENSORS>,
    now: Tick,
    inputs: &Inputs<S, SENSORS>,
    others: &Others<S, COUNT>,
) -> Outputs<S> {
    let released = p.reflex.schedule.at(now);
    if let Some(pose) = inputs.pose_fix {
        reflex.fix_pose(pose);
    }
    if let Some(scan) = inputs.scan {
        reflex.note_scan(now);
        deliberation.take_scan(scan);
    }
    reflex.supervision.untrained = reflex.mode() == Mode::Navigate && !deliberation.map().is_trained();
    let (drive, stopped) = reflex.tick(&p.reflex, now, inputs.encoders);
    let reached = reflex.arrive(&p.reflex, now);
    let learning = reflex.mode() == Mode::Learn && released.step;
    let navigating = reflex.mode() == Mode::Navigate && (released.avoidance || released.target);
    if learning || navigating {
        let latched = reflex.latch(&p.reflex, now);
        let speeds = if learning {
            deliberation.learn(p, &latched, inputs.exploration)
        } else {
            if released.avoidance {
                deliberation.avoid_among(p, &latched, others);
            }
            if released.target {
                deliberation.reach_among(p, &latched, others);
            }
            deliberation.integrate(p, &latched)
        };
        reflex.take_command(now, speeds);
    }
    Outputs { drive, command: reflex.command(), reached, stopped, released }
}

impl<
    S: Scalar,
    O: Output<S>,
    const COLUMNS: usize,
    const ROWS: usize,
    const SENSORS: usize,
    const TRACKS: usize,
> Controller<S, O, COLUMNS, ROWS, SENSORS, TRACKS>
{
    /// A controller with a map that has been trained for `trained_steps` steps; disarmed, standing by.
    #[inline]
    #[must_use]
    pub fn new(map: Map<S, O, COLUMNS, ROWS>, trained_steps: u32) -> Self {
        Self { reflex: Reflex::default(), deliberation: Deliberation::new(map, trained_steps) }
    }

    /// One tick, see [`tick`].
    // On a host only, see `tick`.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn step(&mut self, p: &Parameters<S, SENSORS>, now: Tick, inputs: &Inputs<S, SENSORS>) -> Outputs<S> {
        tick(&mut self.reflex, &mut self.deliberation, p, now, inputs)
    }

    /// One tick among other robots, see [`tick_among`].
    // On a host only, see `tick`.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn step_among<const COUNT: usize>(
        &mut self,
        p: &Parameters<S, SENSORS>,
        now: Tick,
        inputs: &Inputs<S, SENSORS>,
        others: &Others<S, COUNT>,
    ) -> Outputs<S> {
        tick_among(&mut self.reflex, &mut self.deliberation, p, now, inputs, others)
    }

    /// Changes the mode; the robot stops first, and a training step under way is dropped.
    pub fn set_mode(&mut self, mode: Mode, now: Tick) {
        self.reflex.set_mode(mode, now);
        self.deliberation.change_mode(now);
    }

    /// What this robot, known to others as `robot`, tells them of itself.
    #[must_use]
    pub fn report(&self, p: &Parameters<S, SENSORS>, robot: u8) -> Report<S> {
        let pose = self.pose(p);
        let (sin, cos) = pose.heading_rad.sin_cos();
        let speed = self.reflex.measured_speeds().forward();
        let velocity_mps = Point { x_m: speed * cos, y_m: speed * sin };
        Report { robot, at: pose.position(), velocity_mps, age_ms: 0 }
    }

    /// Lets the motors run.
    pub fn arm(&mut self) {
        self.reflex.gate.arm();
    }

    /// The safety gate: arm, disarm, emergency stop.
    pub fn gate_mut(&mut self) -> &mut Gate {
        &mut self.reflex.gate
    }

    /// The checkpoints: replace, append, clear.
    pub fn checkpoints_mut(&mut self) -> &mut Checkpoints<S, CHECKPOINTS> {
        &mut self.reflex.checkpoints
    }

    /// The checkpoints ahead.
    #[must_use]
    pub fn checkpoints(&self) -> &Checkpoints<S, CHECKPOINTS> {
        &self.reflex.checkpoints
    }

    /// The pose now.
    #[must_use]
    pub fn pose(&self, p: &Parameters<S, SENSORS>) -> Pose<S> {
        self.reflex.pose(&p.reflex)
    }

    /// The map.
    #[must_use]
    pub fn map(&self) -> &Map<S, O, COLUMNS, ROWS> {
        self.deliberation.map()
    }

    /// How surprised the map has been of late.
    #[must_use]
    pub fn plasticity(&self) -> &Plasticity<S> {
        self.deliberation.plasticity()
    }

    /// Training steps so far.
    #[must_use]
    pub fn trained_steps(&self) -> u32 {
        self.deliberation.trained_steps()
    }

    /// The mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.reflex.mode()
    }

    /// The last decision of neural integration.
    #[must_use]
    pub fn decision(&self) -> &Decision<S> {
        self.deliberation.decision()
    }

    /// The target field, with its age.
    #[must_use]
    pub fn target_field(&self) -> &Stamped<Option<TargetField<S>>> {
        self.deliberation.target_field()
    }

    /// The obstacle fields, with their age.
    #[must_use]
    pub fn obstacle_field(&self) -> &Stamped<ObstacleField<S, COLUMNS, ROWS>> {
        self.deliberation.obstacle_field()
    }

    /// The running hash over all commands and drives since start.
    #[must_use]
    pub fn hash(&self) -> StateHash {
        self.reflex.hash()
    }
}
