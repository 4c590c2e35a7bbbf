//! The simulator and a board, over every link that needs no hardware: whole missions with the same state hash as in one
//! process, bad lines, and every way in which a board can be the wrong one or go away, each with its name and in time.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, which clippy.toml cannot know")]

use core::time::Duration;
use std::io::{self, Read, Write};
use std::net::TcpListener;
use std::thread;
use std::time::Instant;

use controller_core::config::Config;
use controller_core::controller::Mode;
use controller_core::scalar::{Fixed, Scalar};
use hil_stub::board::{Stub, StubOptions};
use hil_stub::faults::LinkFaults;
use hil_stub::serve::{Pty, serve_tcp};
use host_sim::link::LinkError;
use host_sim::link::address::{Address, OpenOptions};
use host_sim::link::port::LinkPort;
use host_sim::link::real_time::RealTimePort;
use host_sim::link::session::{Session, greeting};
use host_sim::link::stub::InProcess;
use host_sim::link::transport::Transport;
use host_sim::link::verify::{Verified, VerifyError};
use host_sim::mission::{self, MissionError, MissionOptions, MissionResult, config_for};
use host_sim::positioning::{self, PositioningPlan, positioning_test, positioning_test_with};
use host_sim::scenario::Scenario;
use host_sim::sil::{ControllerPort, HostMap, Indirect, Sil};
use host_sim::simulation::PAPERS;
use host_sim::sweep::learn;
use host_sim::training::{Training, TrainingPlan};
use host_sim::world::World;
use protocol::frame::{Decoder, FRAME_BYTES_MAX, Frame, encode};
use protocol::message::{
    Board, FromBoard, FromHost, Hello, Mismatch, PROTOCOL_VERSION, Readings, Refusal, ScalarKind, TimeBase,
};

/// Every error comes within this.
const IN_TIME: Duration = Duration::from_secs(2);

const OPTIONS: MissionOptions = MissionOptions { seed: 1, sample_ms: 0 };

fn learned<S: Scalar>() -> HostMap<S, Indirect<S>> {
    let plan = TrainingPlan { steps: 600, ..TrainingPlan::default() };
    learn::<S, Indirect<S>>(&Config::default(), &plan, &|| ()).unwrap().map
}

fn scenario(time_limit_s: f64) -> Scenario {
    let mut scenario = Scenario::builtin("p2_fig6").unwrap();
    scenario.time_limit_s = time_limit_s;
    scenario
}

const WHOLE: f64 = 60.0;

fn config() -> Config {
    config_for(&scenario(WHOLE), &Config::default(), None)
}

/// The mission in this process.
fn reference<S: Scalar>(map: &HostMap<S, Indirect<S>>, time_limit_s: f64) -> MissionResult {
    let controller = Sil::trained(&config(), map.clone(), 0).unwrap();
    mission::run(&scenario(time_limit_s), controller, &config(), OPTIONS).unwrap()
}

fn open<T: Transport>(transport: T, scalar: ScalarKind) -> Result<Session<T>, LinkError> {
    Session::open(transport, Some(Board::Stub), Some(scalar), TimeBase::Lockstep)
}

/// The mission on a board.
fn drive<S: Scalar, T: Transport>(
    session: &mut Session<T>,
    map: &HostMap<S, Indirect<S>>,
    time_limit_s: f64,
) -> Result<MissionResult, MissionError<LinkError>> {
    session.configure(&config()).map_err(MissionError::Port)?;
    session.upload_map(map, 600).map_err(MissionError::Port)?;
    let port = LinkPort::begin(session, &config()).map_err(MissionError::Port)?;
    mission::run(&scenario(time_limit_s), port, &config(), OPTIONS)
}

fn in_process(scalar: ScalarKind, faults: LinkFaults) -> InProcess {
    InProcess::start(StubOptions { scalar, faults, ..StubOptions::default() }).unwrap()
}

/// A stub behind a pseudo-terminal, in a thread that ends with the process.
fn behind_a_pty(options: StubOptions) -> Box<dyn Transport> {
    let pty = Pty::open().unwrap();
    let path = pty.path().to_owned();
    thread::spawn(move || pty.serve(&mut Stub::new(options).unwrap()));
    Address::Serial(path).open(&OpenOptions::default()).unwrap()
}

/// A stub behind TCP, in a thread that ends with the process, and its address.
fn behind_tcp(options: StubOptions) -> Address {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || serve_tcp(&mut Stub::new(options).unwrap(), &listener, false, || ()));
    Address::Tcp(address)
}

fn whole_mission<S: Scalar>(scalar: ScalarKind) {
    let map = learned::<S>();
    let expected = reference(&map, WHOLE);
    // Whole, that is; how often without contact is what evaluations say.
    assert!(expected.reached, "{expected:?}");
    let options = StubOptions { scalar, ..StubOptions::default() };
    let transports: [(&str, Box<dyn Transport>); 3] = [
        ("in process", Box::new(in_process(scalar, LinkFaults::default()))),
        ("pty", behind_a_pty(options.clone())),
        ("tcp", behind_tcp(options).open(&OpenOptions::default()).unwrap()),
    ];
    for (name, transport) in transports {
        let mut session = open(transport, scalar).unwrap();
        let begin = Instant::now();
        let result = drive(&mut session, &map, WHOLE).unwrap();
        let counts = session.client.counts();
        println!("{name}: {} requests in {:.2} s", counts.answered, begin.elapsed().as_secs_f64());
        assert_eq!(result, expected, "{name}");
        assert_eq!(counts.frames.bad, 0, "{name}");
    }
}

#[test]
fn a_whole_mission_is_the_same_over_every_link_f32() {
    whole_mission::<f32>(ScalarKind::F32);
}

#[test]
fn a_whole_mission_is_the_same_over_every_link_fixed() {
    whole_mission::<Fixed>(ScalarKind::Fixed);
}

#[test]
fn a_bad_line_costs_time_and_changes_nothing() {
    let map = learned::<f32>();
    let expected = reference(&map, 6.0).hash;
    for seed in [1, 2] {
        let faults = LinkFaults { seed, loss: 0.01, corruption: 0.01, ..LinkFaults::default() };
        let mut session = open(in_process(ScalarKind::F32, faults), ScalarKind::F32).unwrap();
        assert_eq!(drive(&mut session, &map, 6.0).unwrap().hash, expected, "seed {seed}");
        let counts = session.client.counts();
        assert!(counts.repeated > 100 && counts.frames.bad > 30, "{counts:?}");
    }
    let late = LinkFaults { loss: 0.02, delay_ms: 0..=4, ..LinkFaults::default() };
    let transport = behind_a_pty(StubOptions { faults: late, ..StubOptions::default() });
    let mut session = open(transport, ScalarKind::F32).unwrap();
    assert_eq!(drive(&mut session, &map, 0.5).unwrap().hash, reference(&map, 0.5).hash);
}

#[test]
fn a_board_learns_and_positions_as_this_process_does() {
    let plan = TrainingPlan { steps: 60, ..TrainingPlan::default() };
    let config = Config::default();
    let expected = learn::<Fixed, Indirect<Fixed>>(&config, &plan, &|| ()).unwrap();
    let mut session = open(in_process(ScalarKind::Fixed, LinkFaults::default()), ScalarKind::Fixed).unwrap();
    session.configure(&config).unwrap();
    session.forget_map().unwrap();
    let world = World::default();
    let port = LinkPort::begin(&mut session, &config).unwrap();
    let mut training = Training::with(port, &config, plan.clone(), &PAPERS, &world).unwrap();
    training.run(plan.steps).unwrap();
    assert_eq!(training.simulation_mut().hash(), expected.hash);
    session.stop().unwrap();
    let (map, steps) = session.download_map::<Fixed>().unwrap();
    assert_eq!(map.hash(), expected.map.hash());
    // The last step is still under way.
    assert_eq!(steps, plan.steps - 1);

    let plan = PositioningPlan { targets: 3, ..PositioningPlan::default() };
    let there = positioning::config_for(&config);
    session.configure(&there).unwrap();
    let port = LinkPort::begin(&mut session, &there).unwrap();
    let results = positioning_test_with(port, &there, &plan, &PAPERS).unwrap();
    assert_eq!(results, positioning_test(&config, &expected.map, &plan, &PAPERS).unwrap());
}

#[test]
fn parameters_are_read_set_as_a_group_and_refused_by_name() {
    let mut session = open(in_process(ScalarKind::F32, LinkFaults::default()), ScalarKind::F32).unwrap();
    let mut config = Config::default();
    config.robot.body_radius_m = 0.03;
    session.configure(&config).unwrap();
    assert_eq!(session.board.parameters_hash, Some(config.hash()));
    let there = session.parameters().unwrap();
    assert!(
        there.iter().enumerate().all(|(i, value)| config.get(i).map(f32::to_bits) == Some(value.to_bits()))
    );
    session.configure(&Config::default()).unwrap();
    assert_eq!(session.board.parameters_hash, Some(Config::default().hash()));

    let named = |name| controller_core::config::PARAMETERS.iter().position(|one| one.name == name).unwrap();
    let index = u8::try_from(named("schedule.target_period_ms")).unwrap();
    session.set(index, 300.0).unwrap();
    let error = session.commit().unwrap_err();
    assert!(error.to_string().contains("schedule.target_period_ms must be"), "{error}");
    let error = session.set(u8::MAX, 1.0).unwrap_err();
    assert!(matches!(error, LinkError::Refused { refusal: Refusal::NoSuchParameter { .. }, .. }), "{error}");
}

#[test]
fn a_board_keeps_its_state_while_hosts_come_and_go() {
    let address = behind_tcp(StubOptions::default());
    let map = learned::<f32>();
    let visit = || open(address.open(&OpenOptions::default()).unwrap(), ScalarKind::F32).unwrap();
    let mut first = visit();
    assert_eq!(first.board.map_hash, None);
    first.upload_map(&map, 600).unwrap();
    let epoch = first.board.epoch;
    drop(first);
    let mut second = visit();
    assert_eq!((second.board.map_hash, second.board.epoch), (Some(map.hash()), epoch));
    assert!(second.download_map::<f32>().unwrap() == (map.clone(), 600));
    assert_eq!(drive(&mut second, &map, 2.0).unwrap().hash, reference(&map, 2.0).hash);
}

#[test]
fn a_difference_is_found_at_its_tick() {
    let map = learned::<f32>();
    let mut session = open(in_process(ScalarKind::F32, LinkFaults::default()), ScalarKind::F32).unwrap();
    session.configure(&config()).unwrap();
    session.upload_map(&map, 600).unwrap();
    let tested = LinkPort::begin(&mut session, &config()).unwrap();
    let mut reference = Sil::trained(&config(), map, 600).unwrap();
    // A robot that is told of a wall it does not have brakes differently, sooner or later.
    reference.parameters.reflex.servo.proportional *= 1.001;
    let result = mission::run(&scenario(5.0), Verified { tested, reference }, &config(), OPTIONS);
    let Err(MissionError::Port(VerifyError::Differs { tick, tested, reference })) = result else {
        panic!("{result:?}")
    };
    assert!(tick < 1000 && tested != reference, "tick {tick}");
}

#[test]
fn a_board_on_its_own_clock_is_kept_up_with() {
    let map = learned::<f32>();
    let transport = behind_a_pty(StubOptions::default());
    let mut session = Session::open(transport, None, None, TimeBase::RealTime).unwrap();
    session.configure(&config()).unwrap();
    session.upload_map(&map, 600).unwrap();
    let mut port = RealTimePort::begin(&mut session, &config()).unwrap();
    let begin = Instant::now();
    let result = mission::run(&scenario(2.0), &mut port, &config(), OPTIONS).unwrap();
    let took = begin.elapsed();
    let pace = port.pace().clone();
    // How punctual is for the machine to say; that it is real time, that it moves and that nothing is lost, is not.
    assert!((Duration::from_millis(1_500)..Duration::from_secs(10)).contains(&took), "{took:?}");
    assert!(result.way_m > 0.05 && result.contacts == 0, "{result:?}");
    assert!(pace.outputs > 1_500, "{pace:?}");
    let health = session.health().unwrap();
    assert!(health.tick >= 1_900 && health.frames_bad == 0, "{health:?}");
    // Lockstep is refused, and said to be.
    let error = session.client.command(&FromHost::Step(Default::default())).unwrap_err();
    assert!(error.to_string().contains("real-time"), "{error}");
    session.stop().unwrap();
}

/// A board of a test's making: what it answers to each frame, byte for byte.
struct Fake<F> {
    decoder: Decoder<FromHost>,
    answer: F,
    output: Vec<u8>,
}

impl<F: FnMut(Frame<FromHost>) -> Vec<u8>> Fake<F> {
    fn new(answer: F) -> Self {
        Self { decoder: Decoder::new(), answer, output: Vec::new() }
    }
}

impl<F: FnMut(Frame<FromHost>) -> Vec<u8>> Transport for Fake<F> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        for &byte in bytes {
            if let Some(Ok(frame)) = self.decoder.push(byte) {
                let answer = (self.answer)(frame);
                self.output.extend(answer);
            }
        }
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        if self.output.is_empty() {
            thread::sleep(patience);
            return Ok(0);
        }
        let count = self.output.len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.output[..count]);
        self.output.drain(..count);
        Ok(count)
    }
}

fn framed(sequence: u8, message: &FromBoard) -> Vec<u8> {
    encode(sequence, message, &mut [0; FRAME_BYTES_MAX]).unwrap().to_vec()
}

/// A hello that would fit.
fn board() -> Hello {
    Hello { epoch: 7, ..greeting(Some(Board::Stub), Some(ScalarKind::F32), TimeBase::Lockstep) }
}

/// Opens a session that must fail, in time.
fn failure(transport: impl Transport) -> LinkError {
    let begin = Instant::now();
    let error = open(transport, ScalarKind::F32).err().unwrap();
    assert!(begin.elapsed() < IN_TIME, "{error} took {:?}", begin.elapsed());
    error
}

fn assert_says(error: &LinkError, words: &[&str]) {
    let text = error.to_string();
    assert!(words.iter().all(|word| text.contains(word)), "must say {words:?}: {text}");
}

#[test]
fn a_board_that_does_not_fit_is_named_with_both_sides() {
    let saying = |hello: Hello| {
        failure(Fake::new(move |frame| framed(frame.sequence, &FromBoard::Hello(hello.clone()))))
    };
    let error = saying(Hello { protocol_version: 9, ..board() });
    assert_says(&error, &["protocol version 9", &format!("{PROTOCOL_VERSION} on this"), "same commit"]);
    let error = saying(Hello { schema_hash: 0xBAD, ..board() });
    assert_says(&error, &["schema 0000000000000bad", "same commit"]);
    let error = saying(Hello { board: Some(Board::Stm32f405), ..board() });
    assert!(matches!(error, LinkError::Mismatch { mismatch: Mismatch::Board { .. } }));
    assert_says(&error, &["stm32f405", "stub"]);
    let error = failure(in_process(ScalarKind::Fixed, LinkFaults::default()));
    assert_says(&error, &["scalar fixed", "f32", "--scalar"]);
}

#[test]
fn frames_of_another_version_are_told_from_noise() {
    // Whole frames with another key: those of this version, as they were sent.
    let echo = |frame: Frame<FromHost>| {
        encode(frame.sequence, &frame.message, &mut [0; FRAME_BYTES_MAX]).unwrap().to_vec()
    };
    assert_says(&failure(Fake::new(echo)), &["key", "same version", "hello"]);
    let noise = |_| b"ThreadX v6.1 booting\r\n\x00".repeat(3);
    let error = failure(Fake::new(noise));
    assert!(matches!(error, LinkError::Garbage { bytes: 66.., .. }), "{error:?}");
    assert_says(&error, &["baud rate"]);
}

#[test]
fn silence_is_not_waited_for_long() {
    assert_says(&failure(Fake::new(|_| Vec::new())), &["silent for 15", "hello", "cable"]);
}

#[test]
fn a_connection_that_ends_in_mid_frame_is_gone() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut first = [0; 8];
        stream.read_exact(&mut first).unwrap();
        let frame = framed(1, &FromBoard::Hello(board()));
        stream.write_all(&frame[..frame.len() / 2]).unwrap();
    });
    let error = failure(Address::Tcp(address).open(&OpenOptions::default()).unwrap());
    assert!(matches!(error, LinkError::Gone { .. }), "{error:?}");
    assert_says(&error, &["gone away", "plug"]);
}

#[test]
fn what_is_not_there_is_named_with_what_to_do() {
    let begin = Instant::now();
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    for (address, words) in [
        (Address::Serial("/dev/ttyNONE7".into()), ["/dev/ttyNONE7", "plugged in"]),
        (Address::Tcp(free.to_string()), ["127.0.0.1", "hil_stub"]),
        ("qemu:stm32f405".parse().unwrap(), ["no-such-image", "cargo xtask firmware"]),
    ] {
        let options = OpenOptions { image: Some("no-such-image".into()), ..OpenOptions::default() };
        assert_says(&address.open(&options).err().unwrap(), &words);
    }
    assert!(begin.elapsed() < IN_TIME);
}

#[test]
fn a_reset_in_mid_run_is_noticed_and_named() {
    let map = learned::<f32>();
    let faults = LinkFaults { reset_after: Some(1000), ..LinkFaults::default() };
    let mut session = open(in_process(ScalarKind::F32, faults), ScalarKind::F32).unwrap();
    let begin = Instant::now();
    let error = drive(&mut session, &map, WHOLE).unwrap_err();
    assert!(begin.elapsed() < IN_TIME);
    let MissionError::Port(error) = error else { panic!("{error:?}") };
    assert!(matches!(error, LinkError::Restarted { before: 1, after: 2 }), "{error:?}");
    assert_says(&error, &["restarted", "repeat the run"]);
}

#[test]
fn a_reset_whose_announcement_is_lost_is_noticed_too() {
    let mut hellos = 0;
    let forgetful = move |frame: Frame<FromHost>| {
        let reply = if let FromHost::Hello(_) = frame.message {
            hellos += 1;
            // The second hello is to ask the board who it is by now.
            FromBoard::Hello(Hello { epoch: 6 + hellos, ..board() })
        } else {
            FromBoard::Refused(Refusal::Mismatch)
        };
        framed(frame.sequence, &reply)
    };
    let mut session = open(Fake::new(forgetful), ScalarKind::F32).unwrap();
    let error = session.begin().unwrap_err();
    assert!(matches!(error, LinkError::Restarted { before: 7, after: 8 }), "{error:?}");
}

#[test]
fn a_board_that_falls_silent_in_mid_run_ends_the_run_in_time() {
    let stub = core::cell::RefCell::new(Stub::new(StubOptions::default()).unwrap());
    let mut left = 200;
    let failing = |frame: Frame<FromHost>| {
        left -= 1;
        if left < 0 {
            return Vec::new();
        }
        let mut stub = stub.borrow_mut();
        stub.receive(
            encode(frame.sequence, &frame.message, &mut [0; FRAME_BYTES_MAX]).unwrap(),
            Duration::ZERO,
        );
        let answer = stub.output().to_vec();
        stub.sent(usize::MAX);
        answer
    };
    let mut session = open(Fake::new(failing), ScalarKind::F32).unwrap();
    let mut port = LinkPort::begin(&mut session, &Config::default()).unwrap();
    port.arm().unwrap();
    port.set_mode(Mode::Standby, 0).unwrap();
    let begin = Instant::now();
    let error = (0..).find_map(|tick| port.step(tick, &Default::default()).err()).unwrap();
    assert!(begin.elapsed() < IN_TIME);
    assert_says(&error, &["silent", "a step"]);
}

#[test]
fn refusals_say_what_and_why() {
    let mut session = open(in_process(ScalarKind::F32, LinkFaults::default()), ScalarKind::F32).unwrap();
    let mut port = LinkPort::begin(&mut session, &Config::default()).unwrap();
    let error = port.step(5, &Default::default()).unwrap_err();
    assert_says(&error, &["refuses", "a step", "next tick is 0, not 5"]);
    port.set_mode(Mode::Learn, 0).unwrap();
    assert_says(&session.forget_map().unwrap_err(), &["forget the map", "learns or navigates"]);
    session.client.command(&FromHost::EStop).unwrap();
    assert_says(&session.client.command(&FromHost::Arm).unwrap_err(), &["emergency stop", "disarm"]);
    session.stop().unwrap();
    session.client.command(&FromHost::Arm).unwrap();
}

#[test]
fn readings_use_up_no_numbers_of_requests() {
    let stub = in_process(ScalarKind::F32, LinkFaults::default());
    let mut session =
        Session::open(stub, Some(Board::Stub), Some(ScalarKind::F32), TimeBase::RealTime).unwrap();
    session.begin().unwrap();
    // As many as there are numbers, less one: the next request would have that of the last.
    for _ in 0..254 {
        session.client.tell(&FromHost::Sense(Readings::default())).unwrap();
    }
    session.client.command(&FromHost::Mode(Mode::Navigate)).unwrap();
    assert_eq!(session.telemetry().unwrap().mode, Mode::Navigate);
}
