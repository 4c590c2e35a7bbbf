//! Learning from scratch: motor babbling that turns into target reaching, in an obstacle-free place (P1, section 3.1).

use controller_core::config::{Config, ConfigError};
use controller_core::controller::Mode;
use controller_core::kohonen::output::Output;
use controller_core::scalar::Scalar;
use nalgebra::Point2;

use crate::khepera::{KheperaModel, TruePose};
use crate::number::narrow_point;
use crate::random::{Purpose, Stream};
use crate::scenario::NoiseLevels;
use crate::sil::{ControllerPort, Sil};
use crate::simulation::Simulation;
use crate::world::World;

/// How long and where to learn.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingPlan {
    /// Training steps, each of `schedule.step_ms`.
    pub steps: u32,
    /// Seed of exploration, targets and noise.
    pub seed: u64,
    /// Side of the square in which targets are drawn, in m; it has no walls.
    pub arena_m: f64,
    /// A target nearer than this is exchanged for another, in m.
    pub near_m: f64,
    /// A target is given up after so many steps.
    pub steps_per_target: u32,
}

impl Default for TrainingPlan {
    fn default() -> Self {
        // A target is renewed after ten steps at the latest: about as many as a metre takes, so that far, near and
        // turning moves all occur.
        Self { steps: 2000, seed: 1, arena_m: 1.0, near_m: 0.005, steps_per_target: 12 }
    }
}

/// Draws targets in a square around the origin.
#[derive(Debug, Clone)]
pub struct TargetSource {
    stream: Stream,
    arena_m: f64,
}

impl TargetSource {
    /// Targets in a square of side `arena_m`.
    #[must_use]
    pub fn new(seed: u64, purpose: Purpose, arena_m: f64) -> Self {
        Self { stream: Stream::new(seed, purpose), arena_m }
    }

    /// The next target, at least `apart_m` from `from`.
    pub fn next(&mut self, from: Point2<f64>, apart_m: f64) -> Point2<f64> {
        let half = self.arena_m / 2.0;
        let mut target = from;
        // A square much wider than `apart_m` yields one at once; the bound is for form's sake.
        for _ in 0..1000 {
            target = Point2::new(self.stream.between(-half, half), self.stream.between(-half, half));
            if (target - from).norm() >= apart_m {
                break;
            }
        }
        target
    }
}

/// A learner under way: train some steps, look at the map, train on.
#[derive(Debug)]
pub struct Training<'w, C> {
    simulation: Simulation<'w, C>,
    targets: TargetSource,
    target: Point2<f64>,
    steps_on_target: u32,
    plan: TrainingPlan,
    step_ms: u64,
}

impl<'w, S: Scalar, O: Output<S>> Training<'w, Sil<S, O>> {
    /// A robot with an untrained map in the middle of the arena. `world` is usually empty.
    ///
    /// # Errors
    /// If the configuration cannot be used.
    pub fn new(
        config: &Config,
        plan: TrainingPlan,
        noise: &NoiseLevels,
        world: &'w World,
    ) -> Result<Self, ConfigError> {
        let Ok(training) = Self::with(Sil::untrained(config)?, config, plan, noise, world);
        Ok(training)
    }
}

impl<'w, C: ControllerPort> Training<'w, C> {
    /// The same with a controller that is at its start: at tick 0, with the map that it is to go on with. `config` must
    /// be its configuration.
    ///
    /// # Errors
    /// If the controller cannot be reached.
    pub fn with(
        mut controller: C,
        config: &Config,
        plan: TrainingPlan,
        noise: &NoiseLevels,
        world: &'w World,
    ) -> Result<Self, C::Error> {
        controller.arm()?;
        controller.set_mode(Mode::Learn, 0)?;
        let start = TruePose { position: Point2::origin(), heading_rad: 0.0 };
        let model = KheperaModel::new(&config.robot, &config.servo, noise.actuator);
        let simulation = Simulation::new(controller, world, model, noise, start, plan.seed);
        Ok(Self {
            simulation,
            targets: TargetSource::new(plan.seed, Purpose::TrainingTargets, plan.arena_m),
            target: Point2::origin(),
            steps_on_target: u32::MAX,
            plan,
            step_ms: u64::from(config.schedule.step_ms),
        })
    }

    /// Trains for `steps` more steps.
    ///
    /// # Errors
    /// If the controller cannot be reached any more.
    pub fn run(&mut self, steps: u32) -> Result<(), C::Error> {
        for _ in 0..steps {
            self.choose_target()?;
            for _ in 0..self.step_ms {
                self.simulation.step()?;
            }
        }
        Ok(())
    }

    fn choose_target(&mut self) -> Result<(), C::Error> {
        let here = self.simulation.pose().position;
        let arrived = (self.target - here).norm() < self.plan.near_m;
        if arrived || self.steps_on_target >= self.plan.steps_per_target {
            self.target = self.targets.next(here, 0.1);
            self.steps_on_target = 0;
        }
        self.steps_on_target += 1;
        // The arena is far smaller than what a checkpoint may be, and one always fits.
        let placed = self.simulation.controller.set_checkpoints(&[narrow_point(self.target)])?;
        debug_assert!(placed.is_ok(), "{placed:?}");
        Ok(())
    }

    /// The learner.
    #[must_use]
    pub fn controller(&self) -> &C {
        &self.simulation.controller
    }

    /// The robot, to change it under way.
    pub fn simulation_mut(&mut self) -> &mut Simulation<'w, C> {
        &mut self.simulation
    }

    /// The seed, steps and arena.
    #[must_use]
    pub fn plan(&self) -> &TrainingPlan {
        &self.plan
    }
}
