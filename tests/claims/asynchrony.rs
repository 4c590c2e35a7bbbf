//! Asynchronous modules (P1 Fig. 1, P2 section II-D) and the safety gate below them.
//!
//! * **Goal**: each module renews its output at its own period, and what it has said stands until then; what is too
//!   old stops the wheels.
//! * **Method**: the controller with a trained map, closed over a Khepera without noise (or over encoders that a test
//!   makes up), with new readings at *every* tick, so that whatever is taken over too early shows.
//! * **Paper**: avoidance 128 ms; target reaching 256 ms (P2) and 1024 ms (P1); integration when either has renewed
//!   its part; the planner may replace checkpoints under way or be absent.
//! * **Tolerance**: none, ticks are exact.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use controller_core::config::{Architecture, Config, Parameters};
use controller_core::controller::{Controller, Inputs, Mode, Outputs};
use controller_core::kohonen::output::ControlMatrix;
use controller_core::safety::StopCause;
use controller_core::scalar::Scalar;
use controller_core::sensing::proximity::Scan;
use controller_core::units::{Point, Pose, WheelDrive, WheelSpeeds};
use host_sim::khepera::{Khepera, KheperaModel, TruePose};
use host_sim::random::{Purpose, Stream};
use nalgebra::Point2;
use tests::learning::{Indirect, trained};
use tests::{for_each_scalar, narrow};

const SENSORS: usize = 12;

/// The controller on a robot without noise.
struct Rig<S: Scalar> {
    p: Parameters<S, SENSORS>,
    controller: Controller<S, ControlMatrix<S::Weight>, 15, 15, SENSORS>,
    robot: Khepera,
    now: u64,
    /// A robot that somebody holds.
    blocked: bool,
}

/// What the sensors see.
#[derive(Clone, Copy)]
enum See {
    /// No scan comes at all.
    NoScan,
    /// A scan of nothing.
    Nothing,
    /// An obstacle ahead on the left, nearer at every tick.
    Approaching,
}

impl<S: Scalar> Rig<S> {
    /// Armed, navigating to checkpoints (m).
    fn new(config: &Config, checkpoints: &[(f32, f32)]) -> Self {
        let mut controller = Controller::new(trained::<S, Indirect<S>>(1, 600), 600);
        let points: Vec<Point<S>> = checkpoints.iter().map(|&(x, y)| Point::from_metres(x, y)).collect();
        controller.checkpoints_mut().replace_all(&points).unwrap();
        controller.arm();
        controller.set_mode(Mode::Navigate, 0);
        let start = TruePose { position: Point2::origin(), heading_rad: 0.0 };
        let model = KheperaModel::new(&config.robot, &config.servo, 0.0);
        let robot = Khepera::new(model, start, Stream::new(1, Purpose::Slip));
        Self { p: config.build().unwrap(), controller, robot, now: 0, blocked: false }
    }

    /// One tick, with a pose fix and, if any, a scan that differ from those before.
    fn tick(&mut self, see: See) -> Outputs<S> {
        let pose = self.robot.pose();
        let number = |value: f64| S::from_f32(narrow(value));
        let mut scan = Scan::EMPTY;
        if let See::Approaching = see {
            let millimetres = u8::try_from(150 - self.now / 100).unwrap();
            scan.range_m[1] = Some(S::from_f32(f32::from(millimetres) / 1000.0));
        }
        let inputs = Inputs {
            encoders: self.robot.encoders(),
            pose_fix: Some(Pose {
                x_m: number(pose.position.x),
                y_m: number(pose.position.y),
                heading_rad: number(pose.heading_rad),
            }),
            scan: (!matches!(see, See::NoScan)).then_some(scan),
            exploration: [S::ZERO; 2],
        };
        let outputs = self.controller.step(&self.p, self.now, &inputs);
        if !self.blocked {
            let drive = WheelDrive { left: outputs.drive.left.to_f32(), right: outputs.drive.right.to_f32() };
            let way = self.robot.tick(drive);
            self.robot.place(self.robot.pose().position + way);
        }
        self.now += 1;
        outputs
    }

    /// Ticks up to, not including, `end`.
    fn run_to(&mut self, end: u64, see: See) {
        while self.now < end {
            self.tick(see);
        }
    }

    /// Moves from here on for `ticks`, in m.
    fn way_in(&mut self, ticks: u64, see: See) -> f64 {
        let from = self.robot.pose().position;
        self.run_to(self.now + ticks, see);
        (self.robot.pose().position - from).norm()
    }
}

fn is_zero<S: Scalar>(drive: WheelDrive<S>) -> bool {
    drive == WheelDrive { left: S::ZERO, right: S::ZERO }
}

fn fields_stand_until_renewed<S: Scalar>() {
    let mut config = Config::default();
    // Wide enough that an obstacle nearer by a millimetre shows in 16-bit sums, whichever neurons are near it.
    config.cooperative.obstacle_bearing_sigma_rad = 0.21;
    config.cooperative.obstacle_front_sigma_m = 0.035;
    let mut rig = Rig::<S>::new(&config, &[(0.9, 0.4)]);
    let (mut target, mut obstacles) = (None, None);
    let (mut targets, mut fields) = (0, 0);
    for tick in 0..2048_u64 {
        let outputs = rig.tick(See::Approaching);
        let (new_target, new_obstacles) =
            (*rig.controller.target_field(), rig.controller.obstacle_field().clone());
        assert_eq!(new_target.renewed, tick / 256 * 256, "target field at {tick}");
        assert_eq!(new_target.age_ms(tick), tick % 256);
        assert_eq!(new_obstacles.renewed, tick / 128 * 128, "obstacle fields at {tick}");
        assert_eq!(outputs.command.renewed, tick / 128 * 128, "integration fires when either is renewed");
        assert_eq!(outputs.command.age_ms(tick), tick % 128);
        let is_new = |old: bool| u32::from(!old);
        if tick.is_multiple_of(256) {
            targets += is_new(target == Some(new_target.value));
        } else {
            assert_eq!(target, Some(new_target.value), "the target field changed at {tick}");
        }
        if tick.is_multiple_of(128) {
            fields += is_new(obstacles.as_ref() == Some(&new_obstacles.value));
        } else {
            assert_eq!(
                obstacles.as_ref(),
                Some(&new_obstacles.value),
                "the obstacle fields changed at {tick}"
            );
        }
        (target, obstacles) = (Some(new_target.value), Some(new_obstacles.value));
    }
    assert_eq!((targets, fields), (8, 16), "every renewal brought something new");
}

fn in_p1_mode_the_target_command_stands_for_1024_ms<S: Scalar>() {
    let mut config = Config { architecture: Architecture::Fusion, ..Config::default() };
    config.schedule.target_period_ms = 1024;
    let mut rig = Rig::<S>::new(&config, &[(0.9, 0.4)]);
    let (mut last, mut changes) = (WheelSpeeds::STOP, Vec::new());
    for tick in 0..4096_u64 {
        // Nothing is seen, so the fused command is the target's.
        let command = rig.tick(See::Nothing).command;
        assert_eq!(rig.controller.target_field().renewed, tick / 1024 * 1024);
        assert_eq!(command.renewed, tick / 128 * 128);
        if command.value != last {
            changes.push(tick);
        }
        last = command.value;
    }
    assert_eq!(changes, [0, 1024, 2048, 3072], "the robot moves, so each renewal says something else");
    let before = last;
    rig.run_to(4096 + 128, See::Approaching);
    let between = rig.tick(See::Approaching).command.value;
    assert_ne!(between, before, "avoidance joins in at its own period");
}

fn a_replaced_checkpoint_counts_from_the_next_target_release<S: Scalar>() {
    let mut rig = Rig::<S>::new(&Config::default(), &[(0.9, 0.3), (1.5, 0.3)]);
    rig.run_to(300, See::Nothing);
    let before = rig.controller.target_field().value.unwrap();
    rig.controller.checkpoints_mut().replace(0, Point::from_metres(0.9, -0.3)).unwrap();
    rig.run_to(512, See::Nothing);
    assert_eq!(rig.controller.target_field().value, Some(before), "the field stands until 512");
    rig.tick(See::Nothing);
    let after = rig.controller.target_field().value.unwrap();
    assert!(before.target.bearing > S::ZERO && after.target.bearing < S::ZERO, "{before:?} {after:?}");
    rig.run_to(40_000, See::Nothing);
    assert_eq!(rig.controller.checkpoints().remaining(), 0, "both were reached");
    let at = rig.robot.pose().position;
    assert!((at - Point2::new(1.5, 0.3)).norm() < 0.003, "{at}");
}

fn without_a_planner_the_robot_stands<S: Scalar>() {
    let mut rig = Rig::<S>::new(&Config::default(), &[]);
    for _ in 0..2000 {
        let outputs = rig.tick(See::Approaching);
        assert_eq!((outputs.command.value, outputs.stopped), (WheelSpeeds::STOP, None));
        assert!(is_zero(outputs.drive), "{outputs:?}");
    }
    // Taken away under way: stops at the next integration, and stays.
    let mut rig = Rig::<S>::new(&Config::default(), &[(0.9, 0.3)]);
    rig.run_to(1000, See::Nothing);
    rig.controller.checkpoints_mut().clear();
    rig.run_to(1024, See::Nothing);
    assert_eq!(rig.tick(See::Nothing).command.value, WheelSpeeds::STOP);
    rig.run_to(1500, See::Nothing);
    assert!(rig.way_in(1000, See::Nothing) < 1e-4);
    rig.controller.checkpoints_mut().replace_all(&[Point::from_metres(0.9, 0.3)]).unwrap();
    assert!(rig.way_in(1000, See::Nothing) > 0.05, "a planner that comes back is heard");
}

fn silent_sensors_stop_the_wheels<S: Scalar>() {
    let config = Config::default();
    let limit = u64::from(config.safety.scan_age_max_ms);
    let mut rig = Rig::<S>::new(&config, &[(0.9, 0.3)]);
    for _ in 0..limit + 200 {
        let outputs = rig.tick(See::NoScan);
        assert_eq!(outputs.stopped, Some(StopCause::ScanTooOld), "no scan has ever come");
        assert!(is_zero(outputs.drive));
    }
    assert!(rig.way_in(1000, See::Nothing) > 0.05, "clears with the first scan");
    let last_scan = rig.now - 1;
    loop {
        let outputs = rig.tick(See::NoScan);
        let age = rig.now - 1 - last_scan;
        assert_eq!(outputs.stopped, (age > limit).then_some(StopCause::ScanTooOld), "age {age}");
        assert!(age <= limit || is_zero(outputs.drive));
        if age > limit + 500 {
            break;
        }
    }
    assert!(rig.way_in(500, See::NoScan) < 1e-4, "stands");
    assert!(rig.way_in(1000, See::Nothing) > 0.05, "clears with the next scan");
}

fn an_emergency_stop_is_latched<S: Scalar>() {
    let mut rig = Rig::<S>::new(&Config::default(), &[(0.9, 0.3)]);
    assert!(rig.way_in(1000, See::Nothing) > 0.05);
    rig.controller.gate_mut().emergency_stop();
    let outputs = rig.tick(See::Nothing);
    assert_eq!(outputs.stopped, Some(StopCause::EmergencyStop));
    assert!(is_zero(outputs.drive), "cut in the same tick");
    rig.controller.arm();
    rig.controller.set_mode(Mode::Navigate, rig.now);
    rig.run_to(rig.now + 300, See::Nothing);
    assert!(rig.way_in(2000, See::Nothing) < 1e-6, "neither arming nor a new mode ends it");
    rig.controller.gate_mut().release();
    assert_eq!(rig.tick(See::Nothing).stopped, Some(StopCause::NotArmed));
    assert!(rig.way_in(1000, See::Nothing) < 1e-6, "released, not armed");
    rig.controller.arm();
    assert!(rig.way_in(1000, See::Nothing) > 0.05);
}

fn disarmed_or_standing_by_nothing_is_driven<S: Scalar>() {
    let mut rig = Rig::<S>::new(&Config::default(), &[(0.9, 0.3)]);
    rig.controller.gate_mut().disarm();
    for _ in 0..1000 {
        let outputs = rig.tick(See::Nothing);
        assert_eq!(outputs.stopped, Some(StopCause::NotArmed));
        assert!(is_zero(outputs.drive));
    }
    rig.controller.arm();
    assert!(rig.way_in(1000, See::Nothing) > 0.05);
    rig.controller.set_mode(Mode::Standby, rig.now);
    rig.run_to(rig.now + 500, See::Nothing);
    assert!(rig.way_in(1000, See::Nothing) < 1e-4, "standing by");
}

fn a_blocked_wheel_is_reported<S: Scalar>() {
    let config = Config::default();
    let mut rig = Rig::<S>::new(&config, &[(0.9, 0.0)]);
    rig.run_to(1000, See::Nothing);
    rig.blocked = true;
    let mut stalls = Vec::new();
    for tick in 0..2000_u64 {
        let outputs = rig.tick(See::Nothing);
        match outputs.stopped {
            None => {}
            Some(StopCause::Stalled) => {
                assert!(is_zero(outputs.drive));
                stalls.push(tick);
            }
            Some(other) => panic!("{other:?}"),
        }
    }
    let first = stalls.first().copied().unwrap();
    let last = stalls.iter().zip(first..).take_while(|(at, tick)| *at == tick).count();
    println!("{} stalls {first} ms after blocking, for {last} ms", S::NAME);
    assert!(last >= usize::from(config.servo.stall_hold_ms), "the motors rest for {last} ms");
    let limit = u64::from(config.servo.stall_ms);
    assert!((limit..limit + 100).contains(&first), "first stall after {first} ms");
    rig.blocked = false;
    rig.run_to(rig.now + 1000, See::Nothing);
    assert!(rig.way_in(1000, See::Nothing) > 0.05, "goes on when it is freed");
}

for_each_scalar!(
    fields_stand_until_renewed,
    in_p1_mode_the_target_command_stands_for_1024_ms,
    a_replaced_checkpoint_counts_from_the_next_target_release,
    without_a_planner_the_robot_stands,
    silent_sensors_stop_the_wheels,
    an_emergency_stop_is_latched,
    disarmed_or_standing_by_nothing_is_driven,
    a_blocked_wheel_is_reported,
);
