//! The controller: one type that composes the modules, one method per event.
//!
//! [`Controller::step`] runs a whole tick in the documented order; it is what simulator, stub and lockstep firmware
//! call. Firmware with preemptive tasks calls the events themselves: [`Controller::servo_tick`] (1 ms),
//! [`Controller::avoid`] (128 ms), [`Controller::reach`] (256 ms), [`Controller::integrate`] (after either),
//! [`Controller::learn`] (each training step). No event can fail, allocate or block.

use heapless::Vec;

use crate::config::{Architecture, Parameters};
use crate::integration::{command_fusion, neural, neural::Decision, sweep};
use crate::kohonen::features::Command;
use crate::kohonen::map::Map;
use crate::kohonen::output::{ControlMatrix, Output};
use crate::kohonen::self_organisation::{displacement, train};
use crate::localisation::detour::Detour;
use crate::localisation::memory::ObstacleMemory;
use crate::localisation::obstacle::ObstacleField;
use crate::localisation::target::TargetField;
use crate::motor_control;
use crate::planning::checkpoint::{Checkpoints, Reached};
use crate::safety::{Conditions, Gate, StopCause};
use crate::scalar::Scalar;
use crate::schedule::{Release, Stamped, Tick};
use crate::sensing::odometry::Odometry;
use crate::sensing::proximity::{Scan, detections};
use crate::servo::Servo;
use crate::state_hash::StateHash;
use crate::units::{EncoderCounts, Point, Pose, WheelDrive, WheelSpeeds};

/// Checkpoints held at a time.
pub const CHECKPOINTS: usize = 16;
/// Obstacle points remembered at a time: half a second of scans, most of them merged.
pub const MEMORY_POINTS: usize = 32;
/// Points that the swept path is checked against.
const SWEEP_POINTS: usize = MEMORY_POINTS + 32;

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

/// A training step under way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TrainingStep<S> {
    start: Pose<S>,
    turn_counts: i32,
    command: Command<S>,
}

/// What the modules last said, standing until renewed.
#[derive(Clone, Debug)]
struct Standing<S: Scalar, const COLUMNS: usize, const ROWS: usize, const SENSORS: usize> {
    target: Stamped<Option<TargetField<S>>>,
    obstacles: Stamped<ObstacleField<S, COLUMNS, ROWS>>,
    /// Detected points of the last scan, robot frame.
    points: Vec<Point<S>, SENSORS>,
    /// P1: the command for the target, and away from obstacles.
    reaching: Command<S>,
    avoidance: Option<Command<S>>,
    command: Stamped<WheelSpeeds<S>>,
    decision: Decision<S>,
}

/// The whole architecture: map, fields, servo, checkpoints, in static memory.
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
> {
    map: Map<S, O, COLUMNS, ROWS>,
    standing: Standing<S, COLUMNS, ROWS, SENSORS>,
    /// The last scan; none has come yet at first, and then the robot does not navigate.
    scan: Option<Stamped<Scan<S, SENSORS>>>,
    memory: ObstacleMemory<S, MEMORY_POINTS>,
    detour: Detour<S>,
    checkpoints: Checkpoints<S, CHECKPOINTS>,
    odometry: Odometry<S>,
    servo: Servo<S>,
    gate: Gate,
    mode: Mode,
    trained_steps: u32,
    step: Option<TrainingStep<S>>,
    hash: StateHash,
}

impl<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize, const SENSORS: usize> Default
    for Controller<S, O, COLUMNS, ROWS, SENSORS>
{
    fn default() -> Self {
        Self::new(Map::regular(), 0)
    }
}

impl<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize, const SENSORS: usize>
    Controller<S, O, COLUMNS, ROWS, SENSORS>
{
    /// A controller with a map that has been trained for `trained_steps` steps; disarmed, standing by.
    #[must_use]
    pub fn new(map: Map<S, O, COLUMNS, ROWS>, trained_steps: u32) -> Self {
        Self {
            map,
            standing: Standing {
                target: Stamped::default(),
                obstacles: Stamped::default(),
                points: Vec::new(),
                reaching: Command::default(),
                avoidance: None,
                command: Stamped::default(),
                decision: Decision::default(),
            },
            scan: None,
            memory: ObstacleMemory::default(),
            detour: Detour::default(),
            checkpoints: Checkpoints::default(),
            odometry: Odometry::default(),
            servo: Servo::default(),
            gate: Gate::default(),
            mode: Mode::default(),
            trained_steps,
            step: None,
            hash: StateHash::default(),
        }
    }

    /// One tick, everything in the order of [`crate::schedule`].
    pub fn step(&mut self, p: &Parameters<S, SENSORS>, now: Tick, inputs: &Inputs<S, SENSORS>) -> Outputs<S> {
        let released = p.schedule.at(now);
        if let Some(pose) = inputs.pose_fix {
            self.fix_pose(pose);
        }
        if let Some(scan) = inputs.scan {
            self.scan = Some(Stamped::new(scan, now));
        }
        let (drive, stopped) = self.servo_tick(p, now, inputs.encoders);
        let reached = self.arrive(p, now);
        match self.mode {
            Mode::Standby => {}
            Mode::Learn => {
                if released.step {
                    self.learn(p, now, inputs.exploration);
                }
            }
            Mode::Navigate => {
                if released.avoidance {
                    self.avoid(p, now);
                }
                if released.target {
                    self.reach(p, now);
                }
                if released.avoidance || released.target {
                    self.integrate(p, now);
                }
            }
        }
        Outputs { drive, command: self.standing.command, reached, stopped, released }
    }

    /// Homeostatic control, each millisecond: odometry, servo, safety gate.
    pub fn servo_tick(
        &mut self,
        p: &Parameters<S, SENSORS>,
        now: Tick,
        encoders: EncoderCounts,
    ) -> (WheelDrive<S>, Option<StopCause>) {
        let counted = self.odometry.advance(&p.odometry, encoders);
        let command =
            if self.mode == Mode::Standby { WheelSpeeds::STOP } else { self.standing.command.value };
        let mut drive = self.servo.step(&p.servo, command, counted);
        let stopped = self.gate.check(&self.conditions(p, now));
        if stopped.is_some() {
            drive = WheelDrive::default();
            self.servo.reset();
        }
        self.hash.add(drive.left);
        self.hash.add(drive.right);
        (drive, stopped)
    }

    fn conditions(&self, p: &Parameters<S, SENSORS>, now: Tick) -> Conditions {
        let navigating = self.mode == Mode::Navigate;
        let period = match self.mode {
            Mode::Standby => None,
            Mode::Learn => Some(p.schedule.step_ms),
            Mode::Navigate => Some(p.schedule.avoidance_period_ms),
        };
        Conditions {
            untrained: navigating && !self.map.is_trained(),
            scan_age_ms: navigating
                .then(|| (self.scan.map_or(Tick::MAX, |scan| scan.age_ms(now)), p.scan_age_max_ms)),
            command_age_ms: period.map(|period| {
                (self.standing.command.age_ms(now), p.command_age_max_ms.saturating_add(period))
            }),
            stalled: self.servo.is_stalled(),
            ..Conditions::default()
        }
    }

    /// Takes over a pose measured from outside.
    pub fn fix_pose(&mut self, pose: Pose<S>) {
        self.odometry.fix(pose);
    }

    /// Checks whether the current checkpoint is reached; at the goal the robot stops at once.
    fn arrive(&mut self, p: &Parameters<S, SENSORS>, now: Tick) -> Option<Reached> {
        if self.mode == Mode::Standby || self.checkpoints.remaining() == 0 {
            return None;
        }
        let reached =
            self.checkpoints.arrive(&p.checkpoints, self.pose(p), self.servo.reference().forward().abs())?;
        self.detour.reset();
        if reached.is_goal && self.mode == Mode::Navigate {
            self.standing.target = Stamped::new(None, now);
            self.standing.reaching = Command::default();
            self.set_command(p, now, Command::default());
        }
        Some(reached)
    }

    fn latched_scan(&self) -> Scan<S, SENSORS> {
        self.scan.map_or(Scan::EMPTY, |scan| scan.value)
    }

    /// Obstacle avoidance: the latched scan renews the obstacle fields (P2), or the avoiding command (P1).
    pub fn avoid(&mut self, p: &Parameters<S, SENSORS>, now: Tick) {
        let scan = self.latched_scan();
        if p.architecture == Architecture::Fusion {
            self.standing.avoidance = p.wiring.avoid(&p.avoidance, &scan);
            return;
        }
        let pose = self.pose(p);
        let seen = detections(&p.proximity, &scan);
        self.standing.points = seen.iter().map(|place| place.to_point()).collect();
        let period = p.schedule.avoidance_period_ms;
        self.memory.age(&p.memory, period);
        let rotation = pose.heading_rad.sin_cos();
        for &point in &self.standing.points {
            self.memory.remember(&p.memory, pose.to_world_frame(point, rotation));
        }
        let field = &mut self.standing.obstacles;
        field.value.renew(&self.map, &p.neural.obstacle, &p.reaching.winner, &p.scaling, &seen);
        field.renewed = now;
    }

    /// Target reaching: the current checkpoint renews the target field (P2), or the command for it (P1).
    pub fn reach(&mut self, p: &Parameters<S, SENSORS>, now: Tick) {
        let seen = self.checkpoints.current().map(|at| self.pose(p).see(at));
        let scan = self.latched_scan();
        match p.architecture {
            Architecture::Cooperative => {
                let field = seen.and_then(|target| {
                    let detections = detections(&p.proximity, &scan);
                    let place =
                        self.detour.direct(&p.detour, target, &detections, p.schedule.target_period_ms);
                    TargetField::localise(
                        &self.map,
                        &p.neural.target,
                        &p.reaching.winner,
                        p.scaling.features(place),
                    )
                });
                self.standing.target = Stamped::new(field, now);
            }
            Architecture::Fusion => {
                let reached = seen.and_then(|target| {
                    motor_control::reach(&self.map, &p.reaching, p.scaling.features(target))
                });
                self.standing.reaching = reached.map_or_else(Command::default, |(_, command)| command);
                self.standing.target.renewed = now;
            }
        }
    }

    /// Integration: what stands of the modules becomes one command. Without a checkpoint the robot stops.
    pub fn integrate(&mut self, p: &Parameters<S, SENSORS>, now: Tick) {
        let command = if self.checkpoints.remaining() == 0 {
            Command::default()
        } else {
            match p.architecture {
                Architecture::Cooperative => self.integrate_fields(p),
                Architecture::Fusion => match self.standing.avoidance {
                    Some(avoidance) => {
                        command_fusion::fuse(p.target_share, self.standing.reaching, avoidance)
                    }
                    None => self.standing.reaching,
                },
            }
        };
        self.set_command(p, now, command);
    }

    fn integrate_fields(&mut self, p: &Parameters<S, SENSORS>) -> Command<S> {
        let Some(target) = self.standing.target.value else { return Command::default() };
        let obstacles: Vec<Point<S>, SWEEP_POINTS> = {
            // Points farther than the body can come within a step decide nothing.
            let farthest = p.scaling.reach_m() + p.sweep.body_radius_m + p.sweep.margin_m;
            let near = |point: &Point<S>| point.x_m.abs() < farthest && point.y_m.abs() < farthest;
            let remembered = self.memory.seen_from(self.pose(p));
            let points = self.standing.points.iter().copied().chain(remembered).filter(near);
            points.take(SWEEP_POINTS).collect()
        };
        let checked = p.sweep.strength > S::ZERO && !obstacles.is_empty();
        let decision = neural::integrate(
            &self.map,
            &p.neural,
            &p.reaching,
            &p.scaling,
            &target,
            &self.standing.obstacles.value,
            |place| {
                if checked { sweep::inhibition(&p.sweep, place, obstacles.iter()) } else { S::ZERO }
            },
        );
        self.standing.decision = decision.unwrap_or_default();
        self.standing.decision.command
    }

    fn set_command(&mut self, p: &Parameters<S, SENSORS>, now: Tick, command: Command<S>) {
        let speeds = p.scaling.speeds(command).saturated(p.speed_limit_mps);
        self.standing.command = Stamped::new(speeds, now);
        self.hash.add(speeds.left_mps);
        self.hash.add(speeds.right_mps);
    }

    /// One training step ends, the next begins (P1 Eq. 6–8): the map learns from the way just made, then the
    /// current checkpoint and a random part give the next command.
    pub fn learn(&mut self, p: &Parameters<S, SENSORS>, now: Tick, exploration: [S; 2]) {
        let here = self.pose(p);
        if let Some(step) = self.step.take() {
            let counts = self.odometry.turn_counts().wrapping_sub(step.turn_counts);
            let turned = S::from_i32(counts) / p.odometry.counts_per_radian;
            let reached = p.scaling.features(displacement(step.start, here, turned));
            let winner = &p.reaching.winner;
            train(&mut self.map, &p.learning, winner, self.trained_steps, reached, step.command);
            self.trained_steps = self.trained_steps.saturating_add(1);
        }
        let wished = self
            .checkpoints
            .current()
            .and_then(|at| motor_control::reach(&self.map, &p.reaching, p.scaling.features(here.see(at))))
            .map_or_else(Command::default, |(_, command)| command);
        let amplitude = p.learning.exploration.at(self.trained_steps);
        let draw = |x: S| x.clamp(-S::ONE, S::ONE) * amplitude;
        let command =
            Command { left: wished.left + draw(exploration[0]), right: wished.right + draw(exploration[1]) }
                .saturated();
        self.set_command(p, now, command);
        self.step = Some(TrainingStep { start: here, turn_counts: self.odometry.turn_counts(), command });
    }

    /// Changes the mode; the robot stops first, and a training step under way is dropped.
    pub fn set_mode(&mut self, mode: Mode, now: Tick) {
        self.mode = mode;
        self.step = None;
        self.standing.command = Stamped::new(WheelSpeeds::STOP, now);
        self.standing.target = Stamped::new(None, now);
        self.standing.reaching = Command::default();
        self.standing.avoidance = None;
        self.memory.clear();
        self.detour.reset();
    }

    /// Lets the motors run.
    pub fn arm(&mut self) {
        self.gate.arm();
    }

    /// The safety gate: arm, disarm, emergency stop.
    pub fn gate_mut(&mut self) -> &mut Gate {
        &mut self.gate
    }

    /// The checkpoints: replace, append, clear.
    pub fn checkpoints_mut(&mut self) -> &mut Checkpoints<S, CHECKPOINTS> {
        &mut self.checkpoints
    }

    /// The checkpoints ahead.
    #[must_use]
    pub fn checkpoints(&self) -> &Checkpoints<S, CHECKPOINTS> {
        &self.checkpoints
    }

    /// The pose now.
    #[must_use]
    pub fn pose(&self, p: &Parameters<S, SENSORS>) -> Pose<S> {
        self.odometry.pose(&p.odometry)
    }

    /// The map.
    #[must_use]
    pub fn map(&self) -> &Map<S, O, COLUMNS, ROWS> {
        &self.map
    }

    /// Training steps so far.
    #[must_use]
    pub fn trained_steps(&self) -> u32 {
        self.trained_steps
    }

    /// The mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The last decision of neural integration.
    #[must_use]
    pub fn decision(&self) -> &Decision<S> {
        &self.standing.decision
    }

    /// The target field, with its age.
    #[must_use]
    pub fn target_field(&self) -> &Stamped<Option<TargetField<S>>> {
        &self.standing.target
    }

    /// The obstacle fields, with their age.
    #[must_use]
    pub fn obstacle_field(&self) -> &Stamped<ObstacleField<S, COLUMNS, ROWS>> {
        &self.standing.obstacles
    }

    /// The wheel speeds as the servo measures them.
    #[must_use]
    pub fn measured_speeds(&self) -> WheelSpeeds<S> {
        self.servo.measured()
    }

    /// The running hash over all commands and drives since start.
    #[must_use]
    pub fn hash(&self) -> StateHash {
        self.hash
    }
}
