//! The fast half of the controller, each millisecond: odometry, arrival at checkpoints, homeostatic control, safety
//! gate.
//!
//! It holds what must never wait: the pose, the command being carried out, the checkpoints and the gate. The slow half
//! ([`crate::deliberation`]) works on what is latched here at its release ([`Reflex::latch`]) and hands back a command
//! ([`Reflex::take_command`]); between the two lies nothing else, so firmware can run them at different priorities.

use crate::controller::{CHECKPOINTS, Mode};
use crate::planning::checkpoint::{CheckpointParameters, Checkpoints, Reached};
use crate::safety::{Conditions, Gate, StopCause, Supervision};
use crate::scalar::Scalar;
use crate::schedule::{Schedule, Stamped, Tick};
use crate::sensing::odometry::{Odometry, OdometryParameters};
use crate::servo::{Servo, ServoParameters};
use crate::state_hash::StateHash;
use crate::units::{EncoderCounts, Point, Pose, WheelDrive, WheelSpeeds};

/// The numbers of the fast half; see [`crate::config`].
#[derive(Clone, Debug)]
pub struct ReflexParameters<S> {
    /// Periods.
    pub schedule: Schedule,
    /// Encoders.
    pub odometry: OdometryParameters<S>,
    /// Servo.
    pub servo: ServoParameters<S>,
    /// Arrival.
    pub checkpoints: CheckpointParameters<S>,
    /// Oldest scan to drive on.
    pub scan_age_max_ms: u16,
    /// Oldest command to carry out.
    pub command_age_max_ms: u16,
}

/// What the slow half works on: the state of one moment, latched at its release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Latched<S> {
    /// The moment.
    pub now: Tick,
    /// Where the robot was.
    pub pose: Pose<S>,
    /// The checkpoint it was on its way to.
    pub target: Option<Point<S>>,
    /// Running count of checkpoints reached.
    pub arrivals: u16,
    /// Running count of goals reached.
    pub goals: u16,
    /// Running count of heading change ([`Odometry::turn_counts`]).
    pub turn_counts: i32,
}

/// The state of the fast half.
#[derive(Clone, Debug)]
pub struct Reflex<S> {
    /// Arm, disarm, emergency stop.
    pub gate: Gate,
    /// What lies outside: set by who runs this.
    pub supervision: Supervision,
    /// The checkpoints ahead: replace, append, clear.
    pub checkpoints: Checkpoints<S, CHECKPOINTS>,
    mode: Mode,
    odometry: Odometry<S>,
    servo: Servo<S>,
    command: Stamped<WheelSpeeds<S>>,
    scanned: Option<Tick>,
    arrivals: u16,
    goals: u16,
    hash: StateHash,
}

impl<S: Scalar> Default for Reflex<S> {
    fn default() -> Self {
        Self {
            gate: Gate::default(),
            supervision: Supervision::default(),
            checkpoints: Checkpoints::default(),
            mode: Mode::default(),
            odometry: Odometry::default(),
            servo: Servo::default(),
            command: Stamped::default(),
            scanned: None,
            arrivals: 0,
            goals: 0,
            hash: StateHash::default(),
        }
    }
}

impl<S: Scalar> Reflex<S> {
    /// Homeostatic control for one millisecond: odometry, servo, safety gate.
    // On a host only, see `controller::tick`.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn tick(
        &mut self,
        p: &ReflexParameters<S>,
        now: Tick,
        encoders: EncoderCounts,
    ) -> (WheelDrive<S>, Option<StopCause>) {
        let counted = self.odometry.advance(&p.odometry, encoders);
        let command = if self.mode == Mode::Standby { WheelSpeeds::STOP } else { self.command.value };
        let mut drive = self.servo.step(&p.servo, command, counted);
        let stopped = self.gate.check(&self.conditions(p, now, drive));
        if stopped.is_some() {
            drive = WheelDrive::default();
            self.servo.reset();
        }
        self.hash.add(drive.left);
        self.hash.add(drive.right);
        (drive, stopped)
    }

    fn conditions(&self, p: &ReflexParameters<S>, now: Tick, drive: WheelDrive<S>) -> Conditions {
        let navigating = self.mode == Mode::Navigate;
        let period = match self.mode {
            Mode::Standby => None,
            Mode::Learn => Some(p.schedule.step_ms),
            Mode::Navigate => Some(p.schedule.avoidance_period_ms),
        };
        let valid = |drive: S| drive >= -S::ONE && drive <= S::ONE;
        Conditions {
            supervision: Supervision {
                untrained: navigating && self.supervision.untrained,
                ..self.supervision
            },
            scan_age_ms: navigating.then(|| {
                (self.scanned.map_or(Tick::MAX, |scanned| now.saturating_sub(scanned)), p.scan_age_max_ms)
            }),
            command_age_ms: period
                .map(|period| (self.command.age_ms(now), p.command_age_max_ms.saturating_add(period))),
            stalled: self.servo.is_stalled(),
            drive_invalid: !(valid(drive.left) && valid(drive.right)),
        }
    }

    /// Takes over a pose measured from outside.
    pub fn fix_pose(&mut self, pose: Pose<S>) {
        self.odometry.fix(pose);
    }

    /// Notes that a scan has come; the slow half has it.
    pub fn note_scan(&mut self, now: Tick) {
        self.scanned = Some(now);
    }

    /// Checks whether the current checkpoint is reached; at the goal the robot stops at once.
    // On a host only, see `controller::tick`.
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub fn arrive(&mut self, p: &ReflexParameters<S>, now: Tick) -> Option<Reached> {
        if self.mode == Mode::Standby {
            return None;
        }
        let speed = self.servo.reference().forward().abs();
        let here = || self.odometry.pose(&p.odometry);
        let reached = self.checkpoints.arrive(&p.checkpoints, here, speed)?;
        self.arrivals = self.arrivals.wrapping_add(1);
        if reached.is_goal && self.mode == Mode::Navigate {
            self.goals = self.goals.wrapping_add(1);
            self.take_command(now, WheelSpeeds::STOP);
        }
        Some(reached)
    }

    /// What the slow half is to work on.
    #[must_use]
    pub fn latch(&self, p: &ReflexParameters<S>, now: Tick) -> Latched<S> {
        Latched {
            now,
            pose: self.pose(p),
            target: self.checkpoints.current(),
            arrivals: self.arrivals,
            goals: self.goals,
            turn_counts: self.odometry.turn_counts(),
        }
    }

    /// Carries out a command from the next tick on, until the next. A robot that navigates without a checkpoint ahead
    /// stands still, whatever a computation begun before the goal was reached still wants.
    pub fn take_command(&mut self, now: Tick, speeds: WheelSpeeds<S>) {
        let idle = self.mode == Mode::Navigate && self.checkpoints.remaining() == 0;
        let speeds = if idle { WheelSpeeds::STOP } else { speeds };
        self.command = Stamped::new(speeds, now);
        self.hash.add(speeds.left_mps);
        self.hash.add(speeds.right_mps);
    }

    /// Changes the mode; the robot stops first.
    pub fn set_mode(&mut self, mode: Mode, now: Tick) {
        self.mode = mode;
        self.command = Stamped::new(WheelSpeeds::STOP, now);
    }

    /// The mode.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The pose now.
    #[must_use]
    pub fn pose(&self, p: &ReflexParameters<S>) -> Pose<S> {
        self.odometry.pose(&p.odometry)
    }

    /// The command being carried out, with its age.
    #[must_use]
    pub fn command(&self) -> Stamped<WheelSpeeds<S>> {
        self.command
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
