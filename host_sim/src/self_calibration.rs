//! Self-calibration: the robot changes under way, and its map follows by learning on, without a reset.
//!
//! The map holds nothing but what the robot's own moves taught it. So a worn wheel, another wheel base or a weak motor
//! needs no calibration by hand: the same online learning (P1 Eq. 6–8) that made the map takes the change in.

use controller_core::config::{Config, ConfigError};
use controller_core::controller::Mode;
use controller_core::kohonen::output::Output;
use controller_core::scalar::Scalar;
use nalgebra::{Point2, Vector2};

use crate::khepera::{KheperaModel, TruePose};
use crate::number::narrow_point;
use crate::positioning::{PositioningPlan, TargetResult, config_for, positioning_test_of};
use crate::scenario::NoiseLevels;
use crate::sil::{ControllerPort, HostMap, Sil};
use crate::simulation::{PAPERS, Simulation};
use crate::training::{Training, TrainingPlan};
use crate::world::World;

/// A change of the physical robot that its configuration does not know of.
#[derive(Debug, Clone, Copy)]
pub struct Change {
    /// What changes, and by how much.
    pub name: &'static str,
    /// Makes it so.
    pub apply: fn(&mut KheperaModel),
}

/// By a fifth more and less: what carries the robot, and what drives it.
pub const CHANGES: [Change; 8] = [
    Change { name: "wheel base + 20 %", apply: |robot| robot.wheel_base_m *= 1.2 },
    Change { name: "wheel base − 20 %", apply: |robot| robot.wheel_base_m *= 0.8 },
    Change {
        name: "wheel radius + 20 %",
        apply: |robot| (robot.left.radius_share, robot.right.radius_share) = (1.2, 1.2),
    },
    Change {
        name: "wheel radius − 20 %",
        apply: |robot| (robot.left.radius_share, robot.right.radius_share) = (0.8, 0.8),
    },
    Change { name: "left wheel + 20 %", apply: |robot| robot.left.radius_share = 1.2 },
    Change { name: "left wheel − 20 %", apply: |robot| robot.left.radius_share = 0.8 },
    Change { name: "left motor + 20 %", apply: |robot| robot.left.motor_share = 1.2 },
    Change { name: "left motor − 20 %", apply: |robot| robot.left.motor_share = 0.8 },
];

/// What is done with each change; the seeds of both plans are replaced by the trial's.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationPlan {
    /// Training before the change.
    pub training: TrainingPlan,
    /// Training steps after it.
    pub further_steps: u32,
    /// Steps between two tests after it; the last test comes at the end in any case.
    pub every: u32,
    /// A test.
    pub test: PositioningPlan,
}

/// How well a map fits its robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The positioning test, under noise.
    pub results: Vec<TargetResult>,
    /// Mean distance, in m, from a place within one step's reach to where one step towards it ends, without noise: what
    /// the map knows, where the test also shows what feedback makes up for.
    pub one_step_m: f64,
}

/// A trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Its seed.
    pub seed: u64,
    /// The map before the change, on the robot as it was.
    pub before: Fit,
    /// The same map after the change: how it stays without learning.
    pub frozen: Fit,
    /// Learning on: steps after the change, and the fit.
    pub learning: Vec<(u32, Fit)>,
}

/// Trains a map, changes the robot, and trains on; `progress` hears of every step.
///
/// # Errors
/// If the configuration cannot be used.
pub fn calibrate<S: Scalar, O: Output<S>>(
    config: &Config,
    plan: &CalibrationPlan,
    seed: u64,
    change: &Change,
    progress: &(dyn Fn() + Sync),
) -> Result<Calibration, ConfigError> {
    let world = World::default();
    let test = PositioningPlan { seed, ..plan.test.clone() };
    let mut training =
        Training::<Sil<S, O>>::new(config, TrainingPlan { seed, ..plan.training.clone() }, &PAPERS, &world)?;
    let sound = KheperaModel::new(&config.robot, &config.servo, PAPERS.actuator);
    let mut changed = sound.clone();
    (change.apply)(&mut changed);
    let train = |training: &mut Training<Sil<S, O>>, steps: u32| {
        for _ in 0..steps {
            let Ok(()) = training.run(1);
            progress();
        }
    };
    train(&mut training, plan.training.steps);
    let map = training.controller().controller.map();
    let before = fit(&sound, config, map, &test)?;
    let frozen = fit(&changed, config, map, &test)?;
    *training.simulation_mut().model_mut() = changed.clone();
    let (mut learning, mut done) = (Vec::new(), 0);
    while done < plan.further_steps {
        // At least one step, so that it ends whatever was asked for.
        let steps = plan.every.clamp(1, plan.further_steps - done);
        train(&mut training, steps);
        done += steps;
        let map = training.controller().controller.map();
        learning.push((done, fit(&changed, config, map, &test)?));
    }
    Ok(Calibration { seed, before, frozen, learning })
}

fn fit<S: Scalar, O: Output<S>>(
    model: &KheperaModel,
    config: &Config,
    map: &HostMap<S, O>,
    test: &PositioningPlan,
) -> Result<Fit, ConfigError> {
    Ok(Fit {
        results: positioning_test_of(model.clone(), config, map, test, &PAPERS)?,
        one_step_m: one_step_error_m(model, config, map)?,
    })
}

/// Places that one step of a Khepera reaches whatever changes by a fifth: bearings in degrees, shares of the reach.
const BEARINGS_DEG: [f64; 5] = [-50.0, -25.0, 0.0, 25.0, 50.0];
const SHARES: [f64; 3] = [0.2, 0.35, 0.5];

fn one_step_error_m<S: Scalar, O: Output<S>>(
    model: &KheperaModel,
    config: &Config,
    map: &HostMap<S, O>,
) -> Result<f64, ConfigError> {
    let mut config = config_for(config);
    // Nothing shall stop the step before its end.
    config.reaching.goal_tolerance_m = 1e-4;
    let world = World::default();
    let model = KheperaModel { slip: 0.0, ..model.clone() };
    let noise = NoiseLevels { sensor: 0.0, actuator: 0.0, ..PAPERS };
    let step_ms = config.schedule.step_ms;
    let reach_m = f64::from(config.robot.speed_limit_mps) * f64::from(step_ms) / 1000.0;
    let (mut sum_m, mut count) = (0.0, 0.0);
    for bearing_deg in BEARINGS_DEG {
        for share in SHARES {
            let (sin, cos) = libm::sincos(bearing_deg.to_radians());
            let place = Point2::origin() + Vector2::new(cos, sin) * share * reach_m;
            let start = TruePose { position: Point2::origin(), heading_rad: 0.0 };
            let controller = Sil::trained(&config, map.clone(), 0)?;
            let mut simulation = Simulation::new(controller, &world, model.clone(), &noise, start, 0);
            let Ok(()) = simulation.controller.arm();
            let Ok(()) = simulation.controller.set_mode(Mode::Navigate, 0);
            let Ok(placed) = simulation.controller.set_checkpoints(&[narrow_point(place)]);
            debug_assert!(placed.is_ok(), "{placed:?}");
            for _ in 0..step_ms {
                let Ok(_) = simulation.step();
            }
            sum_m += (simulation.pose().position - place).norm();
            count += 1.0;
        }
    }
    Ok(sum_m / count)
}
