//! Bar: no input makes the controller panic or drive the wheels beyond their limits.
//!
//! * **Goal**: a million random steps with extreme inputs, both scalars: no panic, every drive a number within ±1,
//!   every command a number within ±c*, the pose a number, and the map of places that one step can lead to.
//! * **Method**: each step draws its inputs from ranges that go far beyond what any sensor says (counters that jump
//!   over their wrap-around, poses of ±10³⁰ m, negative ranges, and in a second test NaN and infinities), and now and
//!   then a new mode, architecture, gate action or checkpoint list. Time mostly goes on by a tick, sometimes jumps,
//!   up to the end of the counter. Overflow checks and debug assertions are on in the test profile.
//! * **Ours**: none of the millions fails.
//! * **Tolerance**: none.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use controller_core::config::{Architecture, Config, Parameters};
use controller_core::controller::{CHECKPOINTS, Controller, Inputs, Mode};
use controller_core::kohonen::map::Eligible;
use controller_core::kohonen::output::ControlMatrix;
use controller_core::scalar::Scalar;
use controller_core::sensing::proximity::Scan;
use controller_core::units::{EncoderCounts, Point, Pose, WheelSpeeds};
use host_sim::random::{Purpose, Stream};
use tests::{for_each_scalar, narrow};

const SENSORS: usize = 12;

/// Numbers with edges.
struct Extremes {
    stream: Stream,
    with_nan: bool,
}

impl Extremes {
    /// Whether something happens that happens once in `in_n` draws.
    fn once(&mut self, in_n: f64) -> bool {
        self.stream.between(0.0, in_n) < 1.0
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        let at = self.stream.between(0.0, tests::statistics::count(from));
        // `between` excludes its upper bound.
        from.iter()
            .copied()
            .zip(1_u32..)
            .find(|&(_, end)| at < f64::from(end))
            .map_or(from[0], |(item, _)| item)
    }

    /// A number of any magnitude.
    fn number(&mut self) -> f32 {
        const EDGES: [f32; 12] = [
            0.0,
            -0.0,
            f32::MIN_POSITIVE,
            1e-45,
            1e-6,
            0.1749,
            2047.999,
            -2048.0,
            1e9,
            -1e30,
            f32::MAX,
            f32::MIN,
        ];
        const BROKEN: [f32; 3] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
        if self.with_nan && self.once(20.0) {
            return self.pick(&BROKEN);
        }
        let plain = [0.01, 0.3, 4.0, 3000.0];
        if self.once(4.0) { self.pick(&EDGES) } else { narrow(self.stream.symmetric()) * self.pick(&plain) }
    }

    fn counter(&mut self, before: i32) -> i32 {
        let steps = [0, 1, -1, 3, -7, 40, -333, 32_767, -32_768, 32_769, i32::MAX, i32::MIN];
        let step = if self.once(3.0) { self.pick(&steps) } else { self.pick(&steps[..5]) };
        before.wrapping_add(step)
    }

    fn inputs<S: Scalar>(&mut self, encoders: EncoderCounts) -> Inputs<S, SENSORS> {
        let encoders =
            EncoderCounts { left: self.counter(encoders.left), right: self.counter(encoders.right) };
        // NaN goes in as it is: `from_f32` would take it away.
        let pose_fix = self.once(5.0).then(|| Pose {
            x_m: self.scalar(),
            y_m: self.scalar(),
            heading_rad: self.scalar(),
        });
        let scan = self.once(5.0).then(|| Scan {
            range_m: core::array::from_fn(|_| if self.once(3.0) { None } else { Some(self.scalar()) }),
        });
        Inputs { encoders, pose_fix, scan, exploration: [self.scalar(), self.scalar()] }
    }

    fn scalar<S: Scalar>(&mut self) -> S {
        let number = self.number();
        if number.is_nan() {
            // What the sum of two broken readings gives: NaN in f32, zero in fixed point.
            return S::from_f32(f32::INFINITY) + S::from_f32(f32::NEG_INFINITY);
        }
        S::from_f32(number)
    }

    fn point<S: Scalar>(&mut self) -> Point<S> {
        let edges = [0.0, 1e-4, 0.02, -0.15, 1.0, 1999.9, -2000.0, 3000.0];
        let x = self.pick(&edges);
        let y = if self.once(2.0) { self.pick(&edges) } else { self.number() };
        Point { x_m: S::from_f32(x), y_m: S::from_f32(y) }
    }
}

type Robot<S> = Controller<S, ControlMatrix<<S as Scalar>::Weight>, 15, 15, SENSORS>;

/// Something that people or planners do, at any time.
fn meddle<S: Scalar>(extremes: &mut Extremes, robot: &mut Robot<S>, now: u64) {
    let points: Vec<Point<S>> =
        (0..extremes.pick(&[0, 1, 2, CHECKPOINTS, CHECKPOINTS + 1])).map(|_| extremes.point()).collect();
    // Refusals are part of the exercise.
    match extremes.pick(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]) {
        0 | 1 => robot.set_mode(extremes.pick(&[Mode::Standby, Mode::Learn, Mode::Navigate]), now),
        2 => robot.gate_mut().emergency_stop(),
        3 => robot.gate_mut().disarm(),
        4 => drop(robot.checkpoints_mut().append(&points)),
        5 => drop(robot.checkpoints_mut().replace(points.len(), extremes.point())),
        6 => robot.checkpoints_mut().clear(),
        _ => drop(robot.checkpoints_mut().replace_all(&points)),
    }
    if extremes.once(1.2) {
        robot.gate_mut().release();
        robot.arm();
    }
}

fn variants<S: Scalar>() -> [Parameters<S, SENSORS>; 3] {
    let mut literal = Config::default();
    literal.reaching.far_share = 0.0;
    literal.cooperative.cruise_share = 0.0;
    literal.reaching.beyond = controller_core::motor_control::Beyond::OwnWeight;
    literal.cooperative.obstacle_centre = controller_core::localisation::obstacle::FieldCentre::Neuron;
    literal.schedule.avoidance_period_ms = 2;
    literal.schedule.target_period_ms = 4;
    literal.schedule.step_ms = 8;
    let mut fusion = Config { architecture: Architecture::Fusion, ..Config::default() };
    fusion.schedule.avoidance_period_ms = 4;
    let mut fast = Config::default();
    fast.schedule.avoidance_period_ms = 8;
    fast.schedule.target_period_ms = 16;
    fast.cooperative.mover_headway_s = 0.6;
    [literal, fusion, fast].map(|config| config.build().unwrap())
}

/// `steps` random steps; what the wheels were driven with must have been sane at each, and not always nothing.
fn survives<S: Scalar>(steps: u32, with_nan: bool, seed: u64) {
    let mut extremes = Extremes { stream: Stream::new(seed, Purpose::TestTargets), with_nan };
    let variants = variants::<S>();
    let mut p = &variants[0];
    // Untrained maps have little to say in navigation, so half of the robots start with one that has learnt.
    let map = tests::learning::trained::<S, ControlMatrix<S::Weight>>(seed, 300);
    let mut robot = Robot::new(map.clone(), 300);
    let (mut now, mut encoders) = (0_u64, EncoderCounts::default());
    let (mut learning, mut navigating, mut reached) = (0_u32, 0_u32, 0_u32);
    for step in 0..steps {
        if extremes.once(40.0) {
            meddle(&mut extremes, &mut robot, now);
        }
        if extremes.once(500.0) {
            p = &variants[extremes.pick(&[0, 1, 2])];
        }
        if extremes.once(20_000.0) {
            robot = if extremes.once(2.0) { Robot::default() } else { Robot::new(map.clone(), 300) };
        }
        let jump =
            if extremes.once(1000.0) { extremes.pick(&[0, 7, 127, 1024, 70_000, u64::MAX / 2]) } else { 1 };
        now = now.saturating_add(jump);
        if now == u64::MAX {
            now = 0;
        }
        let inputs = extremes.inputs::<S>(encoders);
        encoders = inputs.encoders;
        let outputs = robot.step(p, now, &inputs);
        for drive in [outputs.drive.left, outputs.drive.right] {
            // Also false for NaN.
            assert!(drive >= -S::ONE && drive <= S::ONE, "step {step}: drive {drive:?}");
        }
        let command = outputs.command.value;
        for speed in [command.left_mps, command.right_mps] {
            assert!(
                speed >= -p.speed_limit_mps && speed <= p.speed_limit_mps,
                "step {step}: command {speed:?}"
            );
        }
        let pose = robot.pose(p);
        for number in [pose.x_m, pose.y_m, pose.heading_rad] {
            // A fix is at most LIMIT away; encoders that jump lead farther, but nowhere without numbers.
            assert!(number.abs() <= S::LIMIT + S::LIMIT, "step {step}: {pose:?}");
        }
        let is_commanded = outputs.stopped.is_none() && command != WheelSpeeds::STOP;
        learning += u32::from(is_commanded && robot.mode() == Mode::Learn);
        navigating += u32::from(is_commanded && robot.mode() == Mode::Navigate);
        reached += u32::from(outputs.reached.is_some());
    }
    println!(
        "{}: {steps} steps, moving in {learning} (learning) and {navigating}, {reached} reached",
        S::NAME
    );
    assert!(learning > steps / 20 && navigating > steps / 20, "the robot must have been allowed to move");
    assert!(reached > 0, "some checkpoint must have been reached");
    assert_sane_map(&robot);
}

/// Whatever was learnt must be places that a step can lead to.
fn assert_sane_map<S: Scalar>(robot: &Robot<S>) {
    for (index, place) in robot.map().places(Eligible::All) {
        let own = robot.map().own_command(index);
        for number in [place.bearing, place.distance, own.left, own.right] {
            assert!(number.abs() <= S::from_f32(2.0), "{index:?}: {place:?}, {own:?}");
        }
    }
}

fn extreme_numbers_do_no_harm<S: Scalar>() {
    survives::<S>(1_000_000, false, 1);
}

fn numbers_that_are_none_do_no_harm<S: Scalar>() {
    survives::<S>(200_000, true, 2);
}

for_each_scalar!(extreme_numbers_do_no_harm, numbers_that_are_none_do_no_harm);
