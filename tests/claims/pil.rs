//! The firmware, as it ships, is the core: the same bits in the simulator and on the emulated microcontroller.
//!
//! * **Claim**: whatever the simulator measures of the controller holds for the firmware image of either board.
//! * **Method**: the image runs in QEMU (STM32F405, Cortex-M4F, `f32`; STM32F100, Cortex-M3, fixed point), the
//!   simulator drives it over the link as it would a robot, and a second core in this process gets the same readings.
//!   Their state digests are compared after every tick. Over pipes (semihosting) whole missions and learning; over the
//!   emulated USART every byte takes the driver's way. In real time the board's own timer runs under QEMU's instruction
//!   counter, slower than silicon (125 million instructions a second).
//! * **Paper**: none; no open project that we know of shows this.
//! * **Tolerance**: none. Digests and map hashes are equal; in real time no deadline is missed and none is left out.
//!
//! These tests need QEMU and the images: `cargo xtask pil` builds both kinds of thing and runs them; those named
//! `long_` with `--long`.
#![expect(
    clippy::unwrap_used,
    reason = "clippy.toml allows it in #[test] functions; the helpers here are part of them"
)]

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use controller_core::config::Config;
use controller_core::scalar::{Fixed, Scalar};
use host_sim::link::LinkError;
use host_sim::link::port::LinkPort;
use host_sim::link::qemu::{Qemu, QemuOptions, Way};
use host_sim::link::real_time::RealTimePort;
use host_sim::link::session::Session;
use host_sim::link::verify::Verified;
use host_sim::map_store::{self, LearnedOn, StoredScalar};
use host_sim::mission::{self, MissionOptions, config_for};
use host_sim::positioning::{PositioningPlan, positioning_test, positioning_test_with, summarise};
use host_sim::scenario::Scenario;
use host_sim::sil::{HostMap, Indirect, Sil};
use host_sim::simulation::PAPERS;
use host_sim::sweep::learn;
use host_sim::training::{Training, TrainingPlan};
use host_sim::world::World;
use protocol::message::{Board, Health, TimeBase};

/// Nothing was tuned on these.
const SEEDS: [u64; 2] = [9101, 9102];

/// Where cargo builds.
fn target_folder() -> PathBuf {
    env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../target"), PathBuf::from)
}

/// Where `cargo xtask firmware` puts the image of a board.
fn image(board: Board) -> PathBuf {
    let target = match board {
        Board::Stm32f100 => "thumbv7m-none-eabi",
        Board::Stm32f405 | Board::Stub => "thumbv7em-none-eabihf",
    };
    target_folder().join(target).join("firmware/firmware")
}

fn connect(board: Board, way: Way, icount: Option<&str>) -> Session<Qemu> {
    try_to_connect(board, way, icount).unwrap()
}

fn try_to_connect(board: Board, way: Way, icount: Option<&str>) -> Result<Session<Qemu>, LinkError> {
    let icount = icount.map(str::to_owned);
    let time_base = if icount.is_some() { TimeBase::RealTime } else { TimeBase::Lockstep };
    let qemu = Qemu::start(&QemuOptions { board, image: image(board), log: None, way, icount })?;
    Session::open(qemu, Some(board), None, time_base)
}

fn map_of<S: Scalar>(seed: u64, steps: u32) -> HostMap<S, Indirect<S>> {
    let plan = TrainingPlan { steps, seed, ..TrainingPlan::default() };
    learn::<S, Indirect<S>>(&Config::default(), &plan, &|| ()).unwrap().map
}

/// Learned maps of the missions.
const STEPS: u32 = 1000;

/// A mission on the board with the core beside it: fails at the first tick after which their digests differ.
fn verified<S: Scalar>(board: Board, way: Way, seed: u64, time_limit_s: Option<f64>) -> Health {
    let map = map_of::<S>(seed, STEPS);
    let mut session = connect(board, way, None);
    session.upload_map(&map, STEPS).unwrap();
    drives(&mut session, &map, seed, time_limit_s)
}

/// A mission on a board that has this map.
fn drives<S: Scalar>(
    session: &mut Session<Qemu>,
    map: &HostMap<S, Indirect<S>>,
    seed: u64,
    time_limit_s: Option<f64>,
) -> Health {
    let mut scenario = Scenario::builtin("p2_fig6").unwrap();
    scenario.time_limit_s = time_limit_s.unwrap_or(scenario.time_limit_s);
    let config = config_for(&scenario, &Config::default(), None);
    let options = MissionOptions { seed, sample_ms: 0 };
    let reference = || Sil::<S>::trained(&config, map.clone(), STEPS).unwrap();
    let expected = mission::run(&scenario, reference(), &config, options).unwrap();

    session.configure(&config).unwrap();
    let begin = Instant::now();
    let tested = LinkPort::begin(session, &config).unwrap();
    let both = Verified { tested, reference: reference() };
    let result = mission::run(&scenario, both, &config, options).unwrap();
    let seconds = begin.elapsed().as_secs_f64();
    assert_eq!(result, expected);
    assert_eq!(
        result.success,
        time_limit_s.is_none(),
        "a whole mission, or the beginning of one: {result:?}"
    );
    let health = session.health().unwrap();
    println!(
        "{} seed {seed}: {:.1} s in {seconds:.1} s, {:.1} × real time; hash {:016x}; stack {} B",
        session.board.board.map_or("unknown", Board::name),
        result.duration_s,
        result.duration_s / seconds,
        result.hash,
        health.stack_bytes_max.unwrap_or_default(),
    );
    // Requests may have come twice, and been dropped once, where the emulator was slower than the host was patient.
    assert_eq!(health.frames_bad, 0);
    health
}

#[test]
#[ignore = "needs QEMU and the firmware images: cargo xtask pil"]
fn a_whole_mission_on_the_stm32f405_is_bit_for_bit_the_simulators() {
    for seed in SEEDS {
        verified::<f32>(Board::Stm32f405, Way::Semihosting, seed, None);
    }
}

#[test]
#[ignore = "needs QEMU and the firmware images: cargo xtask pil"]
fn a_whole_mission_on_the_stm32f100_is_bit_for_bit_the_simulators() {
    for seed in SEEDS {
        verified::<Fixed>(Board::Stm32f100, Way::Semihosting, seed, None);
    }
}

#[test]
#[ignore = "needs QEMU and the firmware images: cargo xtask pil"]
fn the_usarts_bytes_make_no_difference() {
    verified::<f32>(Board::Stm32f405, Way::Usart, SEEDS[0], Some(10.0));
    verified::<Fixed>(Board::Stm32f100, Way::Usart, SEEDS[0], Some(10.0));
}

/// An image that was built with a map starts with it: the host gives it none, and finds the file's, bit for bit, with
/// the training steps that it has seen. Then it drives as the simulator does with that file.
fn starts_with_its_map<S: StoredScalar>(board: Board) {
    let image = target_folder().join("pil").join(board.name());
    let file = fs::read(image.with_extension("ekm")).unwrap();
    let stored = map_store::from_bytes::<S>(&file, &Config::default(), LearnedOn::ThisRobot).unwrap();
    let options = QemuOptions { board, image, log: None, way: Way::Semihosting, icount: None };
    let qemu = Qemu::start(&options).unwrap();
    let mut session = Session::open(qemu, Some(board), None, TimeBase::Lockstep).unwrap();
    assert_eq!(session.board.map_hash, Some(stored.map.hash()));
    let (map, trained_steps) = session.download_map::<S>().unwrap();
    assert_eq!(map, stored.map);
    assert_eq!(trained_steps, stored.provenance.steps);
    assert_eq!(trained_steps, STEPS, "missions compare with a map of so many steps");
    drives(&mut session, &map, SEEDS[0], Some(5.0));
}

#[test]
#[ignore = "needs QEMU and the firmware images: cargo xtask pil"]
fn a_map_in_flash_drives_without_a_host_that_has_one() {
    starts_with_its_map::<f32>(Board::Stm32f405);
    starts_with_its_map::<Fixed>(Board::Stm32f100);
}

/// Learns from nothing on the board; its map has the hash of one learned here. Then the board drives to targets with
/// it.
fn learns<S: Scalar>(board: Board, steps: u32, targets: u32) {
    let config = Config::default();
    let plan = TrainingPlan { steps, seed: SEEDS[0], ..TrainingPlan::default() };
    let expected = map_of::<S>(SEEDS[0], steps);
    let mut session = connect(board, Way::Semihosting, None);
    assert_eq!(session.board.map_hash, None, "an image that was built without a map knows nothing");
    session.configure(&config).unwrap();
    session.forget_map().unwrap();
    let begin = Instant::now();
    let world = World::default();
    let port = LinkPort::begin(&mut session, &config).unwrap();
    let mut training = Training::with(port, &config, plan, &PAPERS, &world).unwrap();
    training.run(steps).unwrap();
    session.stop().unwrap();
    let (map, trained) = session.download_map::<S>().unwrap();
    let seconds = begin.elapsed().as_secs_f64();
    println!(
        "{}: {steps} training steps in {seconds:.0} s, {:.1} × real time; map {:016x}",
        board.name(),
        f64::from(steps) * 1.024 / seconds,
        map.hash()
    );
    assert_eq!(map.hash(), expected.hash());
    // The last step is still under way.
    assert_eq!(trained, steps - 1);

    let plan = PositioningPlan { targets, seed: SEEDS[0], ..PositioningPlan::default() };
    let here = positioning_test::<S, Indirect<S>>(&config, &map, &plan, &PAPERS).unwrap();
    let config = host_sim::positioning::config_for(&config);
    session.configure(&config).unwrap();
    let port = LinkPort::begin(&mut session, &config).unwrap();
    let there = positioning_test_with(port, &config, &plan, &PAPERS).unwrap();
    assert_eq!(there, here);
    println!("{}: mean positioning error {:.2} mm", board.name(), summarise(&there).mean_error_m * 1000.0);
}

#[test]
#[ignore = "needs QEMU and the firmware images: cargo xtask pil"]
fn the_board_learns_the_simulators_map() {
    learns::<f32>(Board::Stm32f405, 40, 2);
    learns::<Fixed>(Board::Stm32f100, 40, 2);
}

#[test]
#[ignore = "takes minutes: cargo xtask pil --long"]
fn long_the_board_learns_a_thousand_steps() {
    learns::<f32>(Board::Stm32f405, 1000, 50);
}

/// Ten seconds and more on the board's own clock.
///
/// `late_us_max` is how late the servo may start: the longest that anything locks what it shares.
fn keeps_time<S: Scalar>(board: Board, icount: &str, late_us_max: u32) {
    let mut scenario = Scenario::builtin("p2_fig6").unwrap();
    scenario.time_limit_s = 10.5;
    let config = config_for(&scenario, &Config::default(), None);
    let map = map_of::<S>(SEEDS[0], STEPS);
    let options = MissionOptions { seed: SEEDS[0], sample_ms: 0 };
    let attempt = || {
        let mut session = try_to_connect(board, Way::Usart, Some(icount))?;
        session.configure(&config)?;
        session.upload_map(&map, STEPS)?;
        let port = RealTimePort::begin(&mut session, &config)?;
        let result = mission::run(&scenario, port, &config, options)
            .map_err(|error| LinkError::Gone { reason: error.to_string() })?;
        Ok::<_, LinkError>((result, session.health()?))
    };
    // An emulator that counts instructions is deaf for seconds on a busy machine; that says nothing about the board.
    // One that has ended does: the firmware has found a fault.
    let outcomes = (0..5).map(|_| attempt().inspect_err(|error| println!("{error}")));
    let mut conclusive = outcomes.skip_while(|outcome| {
        outcome.as_ref().is_err_and(|error| !error.to_string().contains("the emulator has ended"))
    });
    let (result, health) = conclusive.next().unwrap().unwrap();
    println!("{}: {result:?}\n{health:?}", board.name());
    assert!(health.tick >= 10_000, "ten seconds");
    let missed = health.deadlines_missed;
    assert_eq!((missed.servo, missed.avoidance, missed.target), (0, 0, 0));
    // None was left out: the servo at each tick, the others once in a period of it.
    assert!(u64::from(health.releases.servo) >= health.tick);
    let expected = health.tick / u64::from(config.schedule.avoidance_period_ms);
    assert!(u64::from(health.releases.avoidance).abs_diff(expected) <= 1, "{expected}");
    let expected = health.tick / u64::from(config.schedule.target_period_ms);
    assert!(u64::from(health.releases.target).abs_diff(expected) <= 1, "{expected}");
    // The timer is exact; what a start may be late by is the longest lock above the servo's priority.
    let late = health.servo_period_us_max.max(2000 - health.servo_period_us_min.min(1000)) - 1000;
    assert!(late <= late_us_max, "{late} us");
}

#[test]
#[ignore = "needs QEMU and the firmware images: cargo xtask pil"]
fn in_real_time_no_deadline_is_missed() {
    // 8 ns for an instruction, and 64: slower than the boards.
    keeps_time::<f32>(Board::Stm32f405, "shift=3", 100);
    keeps_time::<Fixed>(Board::Stm32f100, "shift=6,align=on", 500);
}
