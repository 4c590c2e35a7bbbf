//! `run` and `train` with a board in the controller's place.

use core::convert::Infallible;
use core::fmt::Write;
use std::time::Instant;

use controller_core::config::{Config, ConfigError};
use controller_core::scalar::Fixed;
use host_sim::link::address::{Address, OpenOptions};
use host_sim::link::port::LinkPort;
use host_sim::link::real_time::{Pace, RealTimePort};
use host_sim::link::session::Session;
use host_sim::link::transport::Transport;
use host_sim::link::verify::Verified;
use host_sim::map_store::StoredScalar;
use host_sim::mission;
use host_sim::positioning::{self, PositioningPlan, TargetResult, positioning_test_with};
use host_sim::sil::{ControllerPort, Indirect, Sil};
use host_sim::simulation::PAPERS;
use host_sim::sweep::Learned;
use host_sim::training::{Training, TrainingPlan};
use host_sim::world::World;
use protocol::message::{Health, ScalarKind, TimeBase};

use super::args::{MappingArg, RunArgs, ScalarArg, TrainArgs, WayArgs};
use super::error::{CliError, Outcome};
use super::learning::settings_on_board;
use super::output::complain;
use super::progress::Progress;
use super::run::{Driven, Task, run_once};
use super::train::learn_save_test;

/// A session with whatever board there is.
pub type AnySession = Session<Box<dyn Transport>>;

/// Connects to a board and says to which.
pub fn connect(
    address: &Address,
    way: &WayArgs,
    scalar: Option<ScalarArg>,
    time_base: TimeBase,
) -> Result<AnySession, CliError> {
    let scalar = scalar.map(ScalarArg::kind);
    let transport = address.open(&OpenOptions {
        baud: way.baud,
        image: way.image.clone(),
        log: way.log.clone(),
        stub_scalar: scalar.unwrap_or(ScalarKind::F32),
        real_time: time_base == TimeBase::RealTime,
    })?;
    let session = Session::open(transport, address.board(), scalar, time_base)?;
    complain(&format!("connected to {address}: {}", board_text(&session)));
    Ok(session)
}

/// What a board has said of itself, in one line.
fn board_text(session: &AnySession) -> String {
    let hello = &session.board;
    let map = hello.map_hash.map_or_else(|| String::from("no map"), |hash| format!("map {hash:016x}"));
    format!(
        "board {}, scalar {}, firmware {}, {map}, {}",
        hello.board.map_or("unknown", |board| board.name()),
        hello.scalar.map_or("unknown", ScalarKind::name),
        hello.build_id,
        hello.time_base.name(),
    )
}

/// What the link did, and how fast.
fn complain_counts(session: &AnySession, begin: Instant) {
    let counts = session.client.counts();
    let seconds = begin.elapsed().as_secs_f64().max(f64::MIN_POSITIVE);
    let answered = u32::try_from(counts.answered).map_or(f64::INFINITY, f64::from);
    let mut text = format!(
        "link: {} requests in {seconds:.2} s ({:.0} a second), longest answer {:.1} ms",
        counts.answered,
        answered / seconds,
        counts.answer_max.as_secs_f64() * 1000.0,
    );
    if counts.repeated > 0 || counts.frames.bad > 0 {
        // Writing to a string cannot fail.
        let _ = write!(text, ", {} sent again, {} damaged", counts.repeated, counts.frames.bad);
    }
    complain(&text);
}

pub fn run(args: &RunArgs, address: &Address) -> Result<Outcome, CliError> {
    let refused = [
        (args.runs > 1, "--runs"),
        (args.fresh_maps, "--fresh-maps"),
        (args.require.is_some(), "--require"),
        (args.threads.is_some(), "--threads"),
    ];
    if let Some((_, name)) = refused.into_iter().find(|(is_given, _)| *is_given) {
        return Err(CliError::Request(format!(
            "a board makes one run at a time; leave out {name} or --link"
        )));
    }
    let time_base = if args.real_time { TimeBase::RealTime } else { TimeBase::Lockstep };
    let session = connect(address, &args.link.way, args.learning.scalar, time_base)?;
    match session.board.scalar {
        Some(ScalarKind::F32) => run_in::<f32>(args, session),
        Some(ScalarKind::Fixed) => run_in::<Fixed>(args, session),
        None => Err(nameless(address)),
    }
}

fn nameless(address: &Address) -> CliError {
    CliError::Device(format!("{address}: the board does not say what it computes with; flash this version"))
}

fn run_in<S: StoredScalar>(args: &RunArgs, mut session: AnySession) -> Result<Outcome, CliError> {
    run_once::<S>(args, &settings_on_board(&args.learning)?, |task| {
        let config = mission::config_for(task.scenario, &task.settings.core, Some(task.controller));
        session.configure(&config)?;
        session.upload_map(task.map, task.steps)?;
        let begin = Instant::now();
        let mut driven = if args.real_time {
            drive_in_real_time(task, &config, &mut session)?
        } else {
            let port = LinkPort::begin(&mut session, &config)?;
            drive_in_lockstep(task, &config, port, args.link.verify)?
        };
        complain_counts(&session, begin);
        complain(&format!(
            "that is {:.1} × real time",
            driven.result.duration_s / begin.elapsed().as_secs_f64()
        ));
        session.stop()?;
        let health = session.health()?;
        if let Some(bytes) = health.stack_bytes_max {
            driven.notes.push(("stack", format!("{bytes} bytes on the board at most")));
        }
        Ok(Driven { health: Some(health), ..driven })
    })
}

fn drive_in_lockstep<S: StoredScalar>(
    task: &Task<S>,
    config: &Config,
    port: LinkPort<Box<dyn Transport>>,
    verify: bool,
) -> Result<Driven, CliError> {
    if !verify {
        let result = mission::run(task.scenario, port, config, task.options)?;
        return Ok(Driven { result, notes: Vec::new(), health: None });
    }
    let reference = Sil::trained(config, task.map.clone(), task.steps)?;
    let verified = Verified { tested: port, reference };
    let result = mission::run(task.scenario, verified, config, task.options)?;
    let notes = vec![("verified", String::from("the same state digest as in this process after every tick"))];
    Ok(Driven { result, notes, health: None })
}

fn drive_in_real_time<S: StoredScalar>(
    task: &Task<S>,
    config: &Config,
    session: &mut AnySession,
) -> Result<Driven, CliError> {
    let mut port = RealTimePort::begin(session, config)?;
    let result = mission::run(task.scenario, &mut port, config, task.options)?;
    let pace = port.pace().clone();
    let health = session.health()?;
    Ok(Driven { result, notes: real_time_facts(&pace, &health), health: None })
}

fn real_time_facts(pace: &Pace, health: &Health) -> Vec<(&'static str, String)> {
    let (missed, released) = (&health.deadlines_missed, &health.releases);
    let response = &health.response_us_max;
    vec![
        ("outputs", format!("{} received, {} ticks without", pace.outputs, pace.missed)),
        ("host", format!("at most {} ticks behind the board", pace.behind_ticks_max)),
        (
            "readings",
            format!("at most {} ms old on the board, {} held back", health.readings_age_ms_max, pace.held),
        ),
        (
            "deadlines",
            format!(
                "missed {} of {} (servo), {} of {} (avoidance), {} of {} (target)",
                missed.servo,
                released.servo,
                missed.avoidance,
                released.avoidance,
                missed.target,
                released.target
            ),
        ),
        (
            "response",
            format!(
                "at most {} µs (servo), {} µs (avoidance), {} µs (target)",
                response.servo, response.avoidance, response.target
            ),
        ),
        ("servo period", format!("{} to {} µs", health.servo_period_us_min, health.servo_period_us_max)),
        ("stops", format!("{} reported", pace.faults.len())),
    ]
}

pub fn train(args: &TrainArgs, address: &Address) -> Result<Outcome, CliError> {
    let refused = [
        (args.trials.is_some(), "--trials"),
        (args.threads.is_some(), "--threads"),
        (args.mapping == Some(MappingArg::Direct), "--mapping direct"),
    ];
    if let Some((_, name)) = refused.into_iter().find(|(is_given, _)| *is_given) {
        return Err(CliError::Request(format!(
            "a board learns one map, an indirect one; leave out {name} or --link"
        )));
    }
    let config = settings_on_board(&args.learning)?.core;
    let session = connect(address, &args.link.way, args.learning.scalar, TimeBase::Lockstep)?;
    match session.board.scalar {
        Some(ScalarKind::F32) => train_in::<f32>(args, &config, session),
        Some(ScalarKind::Fixed) => train_in::<Fixed>(args, &config, session),
        None => Err(nameless(address)),
    }
}

fn train_in<S: StoredScalar>(
    args: &TrainArgs,
    config: &Config,
    session: AnySession,
) -> Result<Outcome, CliError> {
    // Both parts of the work need it, one after the other.
    let session = core::cell::RefCell::new(session);
    let outcome = learn_save_test::<S>(
        args,
        config,
        |plan| {
            let session = &mut *session.borrow_mut();
            session.configure(config)?;
            session.forget_map()?;
            let begin = Instant::now();
            let hash = learn_on(session, config, plan, args.link.verify, Sil::<S, Indirect<S>>::untrained)?;
            complain_counts(session, begin);
            session.stop()?;
            let (map, _) = session.download_map::<S>()?;
            Ok(Learned { map, hash })
        },
        |learned, plan| {
            let session = &mut *session.borrow_mut();
            let plan = PositioningPlan { seed: plan.seed, ..PositioningPlan::default() };
            let config = positioning::config_for(config);
            session.configure(&config)?;
            let reference = |config: &Config| Sil::trained(config, learned.map.clone(), plan.targets);
            test_on(session, &config, &plan, args.link.verify, reference)
        },
    )?;
    session.borrow_mut().stop()?;
    Ok(outcome)
}

/// Learns on the board; the hash over all decisions and poses.
fn learn_on<C: ControllerPort<Error = Infallible>>(
    session: &mut AnySession,
    config: &Config,
    plan: &TrainingPlan,
    verify: bool,
    reference: impl FnOnce(&Config) -> Result<C, ConfigError>,
) -> Result<u64, CliError> {
    fn learn<C: ControllerPort>(port: C, config: &Config, plan: &TrainingPlan) -> Result<u64, C::Error> {
        let bar = Progress::new("learning on the board", u64::from(plan.steps));
        let world = World::default();
        let mut training = Training::with(port, config, plan.clone(), &PAPERS, &world)?;
        for _ in 0..plan.steps {
            training.run(1)?;
            bar.advance();
        }
        Ok(training.simulation_mut().hash())
    }
    let port = LinkPort::begin(session, config)?;
    if verify {
        Ok(learn(Verified { tested: port, reference: reference(config)? }, config, plan)?)
    } else {
        Ok(learn(port, config, plan)?)
    }
}

/// Measures the board's own map on the board.
fn test_on<C: ControllerPort<Error = Infallible>>(
    session: &mut AnySession,
    config: &Config,
    plan: &PositioningPlan,
    verify: bool,
    reference: impl FnOnce(&Config) -> Result<C, ConfigError>,
) -> Result<Vec<TargetResult>, CliError> {
    let port = LinkPort::begin(session, config)?;
    if verify {
        let verified = Verified { tested: port, reference: reference(config)? };
        Ok(positioning_test_with(verified, config, plan, &PAPERS)?)
    } else {
        Ok(positioning_test_with(port, config, plan, &PAPERS)?)
    }
}
