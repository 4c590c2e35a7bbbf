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

/// The papers' ε of P(ε) and T(ε) run to the robot's radius, 25 mm; here in whole millimetres.
pub const EPSILONS_MM: usize = 25;

/// What happened at one target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetResult {
    /// Distance from the robot's centre to the target after it stopped, or when it was given up, in m.
    pub error_m: f64,
    /// Smallest distance on the way, in m.
    pub nearest_m: f64,
    /// Steps until nearer than 1 mm, 2 mm and so on, where it ever was; see [`TargetResult::steps_to`].
    pub steps_to_mm: [Option<f64>; EPSILONS_MM],
    /// Steps until it stopped or was given up.
    pub steps: f64,
    /// Straight distance from the last target, in m.
    pub distance_m: f64,
    /// The robot stopped by itself.
    pub stopped: bool,
}

impl TargetResult {
    /// Steps until nearer than so many millimetres, if ever; `None` also beyond [`EPSILONS_MM`].
    #[must_use]
    pub fn steps_to(&self, epsilon_mm: usize) -> Option<f64> {
        self.steps_to_mm.get(epsilon_mm.checked_sub(1)?).copied().flatten()
    }
}

/// Watches a robot come near its target.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Approach {
    nearest_m: f64,
    steps_to_mm: [Option<f64>; EPSILONS_MM],
}

impl Approach {
    pub(crate) const NEW: Self = Self { nearest_m: f64::INFINITY, steps_to_mm: [None; EPSILONS_MM] };

    /// The robot is at this distance after so many steps.
    pub(crate) fn see(&mut self, distance_m: f64, steps: f64) {
        if distance_m >= self.nearest_m {
            return;
        }
        self.nearest_m = distance_m;
        let mut epsilon_m = 0.0;
        for first in &mut self.steps_to_mm {
            epsilon_m += 0.001;
            if distance_m < epsilon_m && first.is_none() {
                *first = Some(steps);
            }
        }
    }

    /// The robot has ended `error_m` from its target after so many steps; it began `distance_m` from it.
    pub(crate) fn end(self, error_m: f64, distance_m: f64, steps: f64, stopped: bool) -> TargetResult {
        let Self { nearest_m, steps_to_mm } = self;
        TargetResult { error_m, nearest_m: nearest_m.min(error_m), steps_to_mm, steps, distance_m, stopped }
    }
}

/// How long the robot may roll out after its controller stopped it, in ms.
const SETTLE_MS: u32 = 200;

/// A robot whose command is 0 for longer than this has stopped, wherever it is.
const STEPS_AT_REST: u64 = 2;

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
    let model = KheperaModel::new(&config.robot, &config.servo, noise.actuator);
    positioning_test_of(model, config, map, plan, noise)
}

/// As [`positioning_test`], of a robot that may differ from what its configuration says.
///
/// # Errors
/// If the configuration cannot be used.
pub fn positioning_test_of<S: Scalar, O: Output<S>>(
    model: KheperaModel,
    config: &Config,
    map: &HostMap<S, O>,
    plan: &PositioningPlan,
    noise: &NoiseLevels,
) -> Result<Vec<TargetResult>, ConfigError> {
    let config = config_for(config);
    let controller = Sil::trained(&config, map.clone(), 0)?;
    let Ok(results) = run(controller, model, &config, plan, noise);
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
    let model = KheperaModel::new(&config.robot, &config.servo, noise.actuator);
    run(controller, model, config, plan, noise)
}

fn run<C: ControllerPort>(
    controller: C,
    model: KheperaModel,
    config: &Config,
    plan: &PositioningPlan,
    noise: &NoiseLevels,
) -> Result<Vec<TargetResult>, C::Error> {
    let world = World::default();
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
    let mut way = Approach::NEW;
    let mut stopped = false;
    let mut at_rest_ms = 0;
    let mut steps = 0.0;
    while simulation.tick() - begin < steps_max * step_ms && !stopped {
        let outputs = simulation.step()?;
        steps = seconds(simulation.tick() - begin) / seconds(step_ms);
        way.see((simulation.pose().position - target).norm(), steps);
        // Where speeds have units, the papers' c = 0 comes about by itself; what it comes from then stays as it is.
        let speeds = outputs.command.value;
        at_rest_ms = if speeds.left_mps == 0.0 && speeds.right_mps == 0.0 { at_rest_ms + 1 } else { 0 };
        stopped = outputs.reached.is_some() || at_rest_ms > STEPS_AT_REST * step_ms;
    }
    if stopped {
        for _ in 0..SETTLE_MS {
            simulation.step()?;
        }
    }
    let error_m = (simulation.pose().position - target).norm();
    Ok(way.end(error_m, (target - from).norm(), steps, stopped))
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
    PositioningSummary {
        mean_error_m: results.iter().map(|result| result.error_m).sum::<f64>() / count,
        worst_error_m: results.iter().map(|result| result.error_m).fold(0.0, f64::max),
        within_1_mm: share(&|result| result.nearest_m < 0.001),
        never_stopped: share(&|result| !result.stopped),
        steps_per_metre: steps_per_metre(results, EPSILONS_MM),
    }
}

/// T(ε) of P1 Fig. 5b: steps per metre until nearer than so many millimetres, over the targets that were; 0 of none.
#[must_use]
pub fn steps_per_metre(results: &[TargetResult], epsilon_mm: usize) -> f64 {
    let pace = |result: &TargetResult| Some(result.steps_to(epsilon_mm)? / result.distance_m);
    let paces: Vec<f64> = results.iter().filter_map(pace).collect();
    // The sum of nothing is −0, which nobody wants to read.
    (paces.iter().sum::<f64>() + 0.0) / paces.iter().map(|_| 1.0).sum::<f64>().max(1.0)
}
