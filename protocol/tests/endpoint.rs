//! The board's end of the link: each request is answered, carried out once, and refused for a reason.
#![expect(
    clippy::unwrap_used,
    reason = "clippy.toml allows it in #[test] functions; the helpers here are part of them"
)]

use controller_core::config::{Config, PARAMETERS};
use controller_core::controller::Mode;
use controller_core::safety::StopCause;
use controller_core::scalar::{Fixed, Scalar};
use controller_core::units::{EncoderCounts, Point, Pose};
use heapless::Vec;
use protocol::endpoint::{Identity, LINK_SILENT_MS, LocalBoard};
use protocol::frame::{Decoder, Frame};
use protocol::message::{
    Board, COLUMNS, Checkpoints, FromBoard, FromHost, Hello, MapRequest, Neurons, PROTOCOL_VERSION,
    ParameterValue, Parameters, ROWS, Readings, Refusal, ScalarKind, Scan, TimeBase,
};
use protocol::schema;

/// A host that asks one thing after the other.
struct Host<S: Scalar> {
    board: LocalBoard<S>,
    sequence: u8,
}

fn decoded(bytes: &[u8]) -> Option<Frame<FromBoard>> {
    let mut decoder = Decoder::<FromBoard>::new();
    bytes.iter().find_map(|&byte| decoder.push(byte)).map(Result::unwrap)
}

impl<S: Scalar> Host<S> {
    fn new() -> Self {
        let identity = Identity { board: Board::Stub, build_id: "test" };
        Self { board: LocalBoard::new(identity, 7).unwrap(), sequence: 0 }
    }

    /// A host whose hello has been taken.
    fn connected(time_base: TimeBase) -> Self {
        let mut host = Self::new();
        let FromBoard::Hello(board) = host.ask(FromHost::Hello(expected(time_base))) else { panic!() };
        expected(time_base).check_against(&board).unwrap();
        host
    }

    fn ask(&mut self, message: FromHost) -> FromBoard {
        self.sequence = self.sequence.checked_add(1).unwrap_or(1);
        let reply = decoded(self.board.serve(&Frame { sequence: self.sequence, message })).unwrap();
        assert_eq!(reply.sequence, self.sequence);
        reply.message
    }

    fn done(&mut self, message: FromHost) {
        assert_eq!(self.ask(message), FromBoard::Done);
    }

    fn refused(&mut self, message: FromHost, refusal: Refusal) {
        assert_eq!(self.ask(message), FromBoard::Refused(refusal));
    }

    fn sense(&mut self, readings: Readings) {
        let frame = Frame { sequence: 0, message: FromHost::Sense(readings) };
        assert!(self.board.serve(&frame).is_empty(), "nobody answers to readings");
    }
}

fn expected(time_base: TimeBase) -> Hello {
    Hello {
        protocol_version: PROTOCOL_VERSION,
        schema_hash: schema::HASH,
        build_id: "host".try_into().unwrap(),
        board: None,
        scalar: None,
        map_hash: None,
        parameters_hash: None,
        time_base,
        epoch: 1,
    }
}

fn readings(tick: u64) -> Readings {
    Readings { tick, ..Readings::default() }
}

/// The test runs for both scalars.
macro_rules! for_each_scalar {
    ($($name:ident => $test:ident;)+) => {
        $(#[test] fn $name() { $test::<f32>(); $test::<Fixed>(); })+
    };
}

for_each_scalar! {
    a_board_introduces_itself => introduces_itself;
    nothing_is_done_before_a_fitting_hello => needs_a_hello;
    a_repeated_request_is_answered_alike_and_done_once => repeats;
    a_step_must_be_the_next => steps_follow;
    an_emergency_stop_is_latched => emergency;
    parameters_change_as_a_group => parameters;
    a_map_is_replaced_as_a_whole => maps;
    a_moving_robot_keeps_its_map => keeps_its_map;
    begin_starts_anew_and_keeps_map_and_parameters => begins;
    time_bases_are_kept_apart => time_bases;
    silence_stops_the_motors_in_real_time => silence;
}

fn introduces_itself<S: Scalar>() {
    let mut host = Host::<S>::new();
    let frame = decoded(host.board.announce()).unwrap();
    let FromBoard::Hello(hello) = frame.message else { panic!("{:?}", frame.message) };
    assert_eq!(frame.sequence, 0);
    assert_eq!((hello.board, hello.scalar), (Some(Board::Stub), ScalarKind::of::<S>()));
    assert_eq!((hello.build_id.as_str(), hello.epoch, hello.map_hash), ("test", 7, None));
    assert_eq!(hello.parameters_hash, Some(Config::default().hash()));
}

fn needs_a_hello<S: Scalar>() {
    let mut host = Host::<S>::new();
    host.refused(FromHost::Arm, Refusal::Mismatch);
    host.done(FromHost::EStop);
    let other = match ScalarKind::of::<S>() {
        Some(ScalarKind::F32) => ScalarKind::Fixed,
        _ => ScalarKind::F32,
    };
    for wrong in [
        Hello { protocol_version: PROTOCOL_VERSION + 1, ..expected(TimeBase::Lockstep) },
        Hello { board: Some(Board::Stm32f405), ..expected(TimeBase::Lockstep) },
        Hello { scalar: Some(other), ..expected(TimeBase::Lockstep) },
        Hello { parameters_hash: Some(1), ..expected(TimeBase::Lockstep) },
    ] {
        let FromBoard::Hello(board) = host.ask(FromHost::Hello(wrong.clone())) else { panic!() };
        assert!(wrong.check_against(&board).is_err(), "the answer tells what does not fit");
        host.refused(FromHost::Step(readings(0)), Refusal::Mismatch);
    }
    host.ask(FromHost::Hello(expected(TimeBase::Lockstep)));
    assert!(matches!(host.ask(FromHost::Step(readings(0))), FromBoard::Outputs(_)));
}

fn repeats<S: Scalar>() {
    let mut host = Host::<S>::connected(TimeBase::Lockstep);
    let frame = Frame { sequence: 9, message: FromHost::Step(readings(0)) };
    let first = host.board.serve(&frame).to_vec();
    assert_eq!(host.board.serve(&frame), first, "the answer was lost");
    host.sequence = 9;
    let FromBoard::Outputs(outputs) = host.ask(FromHost::Step(readings(1))) else { panic!() };
    assert_eq!(outputs.tick, 1, "one step was made, not two");
    // A host that has been started again begins with any number.
    let hello = Frame { sequence: 10, message: FromHost::Hello(expected(TimeBase::Lockstep)) };
    let reply = decoded(host.board.serve(&hello)).unwrap();
    assert!(matches!(reply.message, FromBoard::Hello(_)));
}

fn steps_follow<S: Scalar>() {
    let mut host = Host::<S>::connected(TimeBase::Lockstep);
    host.refused(FromHost::Step(readings(5)), Refusal::Tick { expected: 0, found: 5 });
    for tick in 0..3 {
        let FromBoard::Outputs(outputs) = host.ask(FromHost::Step(readings(tick))) else { panic!() };
        assert_eq!((outputs.tick, outputs.stopped), (tick, Some(StopCause::NotArmed)));
    }
    host.refused(FromHost::Step(readings(2)), Refusal::Tick { expected: 3, found: 2 });
}

fn emergency<S: Scalar>() {
    let mut host = Host::<S>::connected(TimeBase::Lockstep);
    host.done(FromHost::Arm);
    host.done(FromHost::EStop);
    host.refused(FromHost::Arm, Refusal::EmergencyStop);
    let FromBoard::Outputs(outputs) = host.ask(FromHost::Step(readings(0))) else { panic!() };
    assert_eq!(outputs.stopped, Some(StopCause::EmergencyStop));
    host.done(FromHost::Begin);
    host.refused(FromHost::Arm, Refusal::EmergencyStop);
    host.ask(FromHost::Hello(expected(TimeBase::RealTime)));
    host.refused(FromHost::Arm, Refusal::EmergencyStop);
    host.ask(FromHost::Hello(expected(TimeBase::Lockstep)));
    host.done(FromHost::Disarm);
    host.done(FromHost::Arm);
    let FromBoard::Outputs(outputs) = host.ask(FromHost::Step(readings(0))) else { panic!() };
    assert_eq!(outputs.stopped, None);
}

fn index_of(name: &str) -> u8 {
    u8::try_from(PARAMETERS.iter().position(|parameter| parameter.name == name).unwrap()).unwrap()
}

fn parameters<S: Scalar>() {
    let mut host = Host::<S>::connected(TimeBase::Lockstep);
    let count = u8::try_from(PARAMETERS.len()).unwrap();
    let set =
        |name, value| FromHost::Parameters(Parameters::Set(ParameterValue { index: index_of(name), value }));
    let get = |index| FromHost::Parameters(Parameters::Get { index });
    let commit = FromHost::Parameters(Parameters::Commit);
    host.refused(get(count), Refusal::NoSuchParameter { count });
    // Each within its range, together impossible: only the commit can tell.
    host.done(set("schedule.target_period_ms", 300.0));
    let index = index_of("schedule.target_period_ms");
    host.refused(commit.clone(), Refusal::BadParameter { index });
    host.done(set("schedule.target_period_ms", 512.0));
    // A board does not follow what moves, and says so instead of leaving it out.
    host.done(set("cooperative.mover_headway_s", 0.6));
    let index = index_of("cooperative.mover_headway_s");
    host.refused(commit.clone(), Refusal::BadParameter { index });
    host.done(set("cooperative.mover_headway_s", 0.0));
    let index = index_of("servo.stall_share");
    host.refused(set("servo.stall_share", 1.5), Refusal::BadParameter { index });
    host.done(commit.clone());
    let index = index_of("schedule.target_period_ms");
    assert_eq!(host.ask(get(index)), FromBoard::Parameter(ParameterValue { index, value: 512.0 }));
    let mut config = Config::default();
    config.schedule.target_period_ms = 512;
    let parameters_hash = |host: &mut Host<S>| {
        let FromBoard::Hello(hello) = host.ask(FromHost::Hello(expected(TimeBase::Lockstep))) else {
            panic!()
        };
        hello.parameters_hash
    };
    assert_eq!(parameters_hash(&mut host), Some(config.hash()));
    host.done(FromHost::Parameters(Parameters::Defaults));
    assert_eq!(parameters_hash(&mut host), Some(config.hash()), "not in use yet");
    host.done(commit);
    assert_eq!(parameters_hash(&mut host), Some(Config::default().hash()));
}

fn described<S: Scalar>(host: &mut Host<S>) -> (u64, u32, u16) {
    let FromBoard::Map(map) = host.ask(FromHost::Map(MapRequest::Describe)) else { panic!() };
    assert_eq!((usize::from(map.columns), usize::from(map.rows)), (COLUMNS, ROWS));
    (map.hash, map.trained_steps, map.trained_neurons)
}

fn maps<S: Scalar>() {
    let mut host = Host::<S>::connected(TimeBase::Lockstep);
    let (untrained, ..) = described(&mut host);
    let count = u16::try_from(COLUMNS * ROWS).unwrap();
    host.refused(FromHost::Map(MapRequest::Read { first: count }), Refusal::NoSuchNeurons { count });
    // The first neuron of the last column becomes a trained one.
    let first = count - 15;
    let FromBoard::Neurons(mut neurons) = host.ask(FromHost::Map(MapRequest::Read { first })) else {
        panic!()
    };
    neurons.neurons[0].left = [0.25, -0.5];
    neurons.neurons[0].has_won = true;
    host.done(FromHost::Map(MapRequest::Write(neurons.clone())));
    let beyond = Neurons { first: count - 1, neurons: neurons.neurons.clone() };
    host.refused(FromHost::Map(MapRequest::Write(beyond)), Refusal::NoSuchNeurons { count });
    let (hash, ..) = described(&mut host);
    assert_ne!(hash, untrained);
    let confirm = |hash| FromHost::Map(MapRequest::Confirm { trained_steps: 11, hash });
    host.refused(confirm(untrained), Refusal::MapHash { found: hash });
    host.done(confirm(hash));
    assert_eq!(described(&mut host), (hash, 11, 1));
    let FromBoard::Neurons(back) = host.ask(FromHost::Map(MapRequest::Read { first })) else { panic!() };
    assert_eq!(back, neurons);
    let last = MapRequest::Read { first: count - 1 };
    let FromBoard::Neurons(last) = host.ask(FromHost::Map(last)) else { panic!() };
    assert_eq!(last.neurons.len(), 1);
    host.done(FromHost::Map(MapRequest::Forget));
    assert_eq!(described(&mut host), (untrained, 0, 0));
}

fn keeps_its_map<S: Scalar>() {
    let mut host = Host::<S>::connected(TimeBase::Lockstep);
    for mode in [Mode::Learn, Mode::Navigate] {
        host.done(FromHost::Mode(mode));
        host.refused(FromHost::Map(MapRequest::Forget), Refusal::NotStandingBy);
    }
    let FromBoard::Outputs(outputs) = host.ask(FromHost::Step(readings(0))) else { panic!() };
    assert_eq!(outputs.stopped, Some(StopCause::NotArmed));
    host.done(FromHost::Arm);
    let FromBoard::Outputs(outputs) = host.ask(FromHost::Step(readings(1))) else { panic!() };
    assert_eq!(outputs.stopped, Some(StopCause::UntrainedMap));
}

fn goal() -> FromHost {
    FromHost::Checkpoints(Checkpoints::ReplaceAll(Vec::from_slice(&[Point { x_m: 0.3, y_m: 0.1 }]).unwrap()))
}

/// Learns for a while with the wheels' counts made up; the digest at the end.
fn learned<S: Scalar>(host: &mut Host<S>) -> u64 {
    host.done(FromHost::Begin);
    host.done(goal());
    host.done(FromHost::Arm);
    host.done(FromHost::Mode(Mode::Learn));
    let mut digest = 0;
    for tick in 0..4_u16 * 1024 {
        let way = i32::from(tick);
        let readings = Readings {
            tick: tick.into(),
            encoders: EncoderCounts { left: way, right: way + way / 4 },
            exploration: tick.is_multiple_of(1024).then_some([0.5, -0.25]),
            ..Readings::default()
        };
        let FromBoard::Outputs(outputs) = host.ask(FromHost::Step(readings)) else { panic!() };
        digest = outputs.state_digest;
    }
    host.done(FromHost::Mode(Mode::Standby));
    digest
}

fn begins<S: Scalar>() {
    let mut host = Host::<S>::connected(TimeBase::Lockstep);
    let first = learned(&mut host);
    let (map, steps, neurons) = described(&mut host);
    assert!(steps == 3 && neurons > 0, "{steps} steps, {neurons} neurons");
    host.done(FromHost::Begin);
    assert_eq!(described(&mut host), (map, 3, neurons), "the map stays");
    host.refused(FromHost::Step(readings(1)), Refusal::Tick { expected: 0, found: 1 });
    // From the same map the same run.
    host.done(FromHost::Map(MapRequest::Forget));
    assert_eq!(learned(&mut host), first);
    assert_eq!(described(&mut host).0, map);
}

fn time_bases<S: Scalar>() {
    let mut host = Host::<S>::connected(TimeBase::RealTime);
    let present = TimeBase::RealTime;
    host.refused(FromHost::Step(readings(0)), Refusal::TimeBase { present });
    assert!(host.board.tick().is_some());
    host.done(FromHost::Arm);
    host.ask(FromHost::Hello(expected(TimeBase::Lockstep)));
    assert!(host.board.tick().is_none(), "in lockstep time stands still by itself");
    let FromBoard::Outputs(outputs) = host.ask(FromHost::Step(readings(0))) else { panic!() };
    assert_eq!(outputs.stopped, Some(StopCause::NotArmed), "the change of time base begins anew");
}

fn silence<S: Scalar>() {
    let mut host = Host::<S>::connected(TimeBase::Lockstep);
    learned(&mut host);
    host.ask(FromHost::Hello(expected(TimeBase::RealTime)));
    host.done(FromHost::Begin);
    host.done(goal());
    host.done(FromHost::Arm);
    host.done(FromHost::Mode(Mode::Navigate));
    let mut moved = false;
    for tick in 0..300 {
        if tick % 10 == 0 {
            host.sense(Readings {
                pose_fix: Some(Pose::default()),
                scan: Some(Scan::default()),
                ..readings(tick)
            });
        }
        let outputs = host.board.tick().unwrap();
        assert!(matches!(outputs.stopped, None | Some(StopCause::ScanTooOld)), "{outputs:?}");
        moved |= outputs.wheel_drive.left.abs() > 0.0;
    }
    assert!(moved, "the robot was on its way");
    let stopped_after = (0..2 * LINK_SILENT_MS).find(|_| {
        let outputs = host.board.tick().unwrap();
        let stands = outputs.wheel_drive.left.abs() + outputs.wheel_drive.right.abs() < 1e-9;
        stands && outputs.stopped == Some(StopCause::LinkSilent)
    });
    assert!(stopped_after.is_some_and(|ticks| ticks <= LINK_SILENT_MS), "{stopped_after:?}");
    host.sense(readings(500));
    assert_ne!(host.board.tick().unwrap().stopped, Some(StopCause::LinkSilent), "the host is back");
}
