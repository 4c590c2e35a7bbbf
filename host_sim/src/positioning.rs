//! P1's positioning test (section 3.2): random targets in sequence, without training; how near does the robot stop?

use controller_core::config::{Architecture, Config, ConfigError};
use controller_core::controller::Mode;
use controller_core::kohonen::output::Output;
use controller_core::scalar::Scalar;
use nalgebra::Point2;

use crate::khepera::{KheperaModel, TruePose};
use crate::number::narrow_point;
use crate::random::Purpose;
use crate::scenario::NoiseLevels;
use crate::sil::{ControllerPort, HostMap, Sil};
use crate::simulation::{Simulation, seconds};
use crate::training::TargetSource;
use crate::world::World;

/// The test: P1 has 50 targets.
#[derive(Debug, Clone, PartialEq)]
pub struct PositioningPlan {
    /// Targets in sequence.
    pub targets: u32,
    /// Seed of targets and noise.
    pub seed: u64,
    /// Side of the square in which targets are drawn, in m.
    pub arena_m: f64,
    /// Targets are at least this far apart, in m.
    pub apart_m: f64,
    /// A target is given up after so many steps.
    pub steps_max: u32,
}

impl Default for PositioningPlan {
    fn default() -> Self {
        Self { targets: 50, seed: 1, arena_m: 1.0, apart_m: 0.1, steps_max: 60 }
    }
}

/// What happened at one target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetResult {
    /// Distance from the robot's centre to the target after it stopped, or when it was given up, in m.
    pub error_m: f64,
    /// Smallest distance on the way, in m.
    pub nearest_m: f64,
    /// Steps until nearer than 25 mm, if ever.
    pub steps_to_25_mm: Option<f64>,
    /// Straight distance from the last target, in m.
    pub distance_m: f64,
    /// The robot stopped by itself.
    pub stopped: bool,
}

/// How long the robot may roll out after its controller stopped it, in ms.
const SETTLE_MS: u32 = 200;

/// Runs the test with the core in this process.
///
/// # Errors
/// If the configuration cannot be used.
pub fn positioning_test<S: Scalar, O: Output<S>>(
    config: &Config,
    map: &HostMap<S, O>,
    plan: &PositioningPlan,
    noise: &NoiseLevels,
) -> Result<Vec<TargetResult>, ConfigError> {
    let config = config_for(config);
    let Ok(results) = positioning_test_with(Sil::trained(&config, map.clone(), 0)?, &config, plan, noise);
    Ok(results)
}

/// The configuration of the test: target reaching as in P1, one command per training step.
#[must_use]
pub fn config_for(base: &Config) -> Config {
    let mut config = base.clone();
    config.architecture = Architecture::Fusion;
    config.schedule.target_period_ms = config.schedule.step_ms;
    config
}

/// Runs the test with a controller that is at its start, has a trained map and the configuration `config`, which
/// [`config_for`] makes.
///
/// # Errors
/// If the controller cannot be reached any more.
pub fn positioning_test_with<C: ControllerPort>(
    controller: C,
    config: &Config,
    plan: &PositioningPlan,
    noise: &NoiseLevels,
) -> Result<Vec<TargetResult>, C::Error> {
    let world = World::default();
    let model = KheperaModel::new(&config.robot, &config.servo, noise.actuator);
    let start = TruePose { position: Point2::origin(), heading_rad: 0.0 };
    let mut simulation = Simulation::new(controller, &world, model, noise, start, plan.seed);
    simulation.controller.arm()?;
    simulation.controller.set_mode(Mode::Navigate, 0)?;
    let mut targets = TargetSource::new(plan.seed, Purpose::TestTargets, plan.arena_m);
    let step_ms = u64::from(config.schedule.step_ms);
    let mut from = Point2::origin();
    let mut results = Vec::new();
    for _ in 0..plan.targets {
        let target = targets.next(from, plan.apart_m);
        results.push(approach(&mut simulation, target, from, step_ms, u64::from(plan.steps_max))?);
        from = target;
    }
    Ok(results)
}

fn approach<C: ControllerPort>(
    simulation: &mut Simulation<C>,
    target: Point2<f64>,
    from: Point2<f64>,
    step_ms: u64,
    steps_max: u64,
) -> Result<TargetResult, C::Error> {
    // Begin with a step: the paper's time is counted in steps.
    while !simulation.tick().is_multiple_of(step_ms) {
        simulation.step()?;
    }
    let placed = simulation.controller.set_checkpoints(&[narrow_point(target)])?;
    debug_assert!(placed.is_ok(), "{placed:?}");
    let begin = simulation.tick();
    let mut nearest_m = f64::INFINITY;
    let mut steps_to_25_mm = None;
    let mut stopped = false;
    while simulation.tick() - begin < steps_max * step_ms && !stopped {
        stopped = simulation.step()?.reached.is_some();
        let distance = (simulation.pose().position - target).norm();
        nearest_m = nearest_m.min(distance);
        if distance < 0.025 && steps_to_25_mm.is_none() {
            steps_to_25_mm = Some(seconds(simulation.tick() - begin) / seconds(step_ms));
        }
    }
    if stopped {
        for _ in 0..SETTLE_MS {
            simulation.step()?;
        }
    }
    Ok(TargetResult {
        error_m: (simulation.pose().position - target).norm(),
        nearest_m,
        steps_to_25_mm,
        distance_m: (target - from).norm(),
        stopped,
    })
}

/// The figures of one or several tests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositioningSummary {
    /// Mean positioning error E of P1 Fig. 4, in m.
    pub mean_error_m: f64,
    /// Largest error, in m.
    pub worst_error_m: f64,
    /// Share of the targets that were approached to 1 mm.
    pub within_1_mm: f64,
    /// Share of the targets at which the robot did not stop by itself.
    pub never_stopped: f64,
    /// Steps per metre until nearer than 25 mm (P1 Fig. 5b), over the targets that were.
    pub steps_per_metre: f64,
}

/// Summarises results.
#[must_use]
pub fn summarise(results: &[TargetResult]) -> PositioningSummary {
    let count = results.iter().map(|_| 1.0).sum::<f64>().max(1.0);
    let share = |holds: &dyn Fn(&TargetResult) -> bool| {
        results.iter().map(|result| if holds(result) { 1.0 } else { 0.0 }).sum::<f64>() / count
    };
    let paces: Vec<f64> =
        results.iter().filter_map(|result| Some(result.steps_to_25_mm? / result.distance_m)).collect();
    PositioningSummary {
        mean_error_m: results.iter().map(|result| result.error_m).sum::<f64>() / count,
        worst_error_m: results.iter().map(|result| result.error_m).fold(0.0, f64::max),
        within_1_mm: share(&|result| result.nearest_m < 0.001),
        never_stopped: share(&|result| !result.stopped),
        steps_per_metre: paces.iter().sum::<f64>() / paces.iter().map(|_| 1.0).sum::<f64>().max(1.0),
    }
}
