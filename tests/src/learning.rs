//! Maps trained as the main job trains them, and P1's positioning test on them.

use controller_core::config::Config;
use controller_core::kohonen::output::{MotorVector, Output};
use controller_core::scalar::Scalar;
use host_sim::positioning::{PositioningPlan, TargetResult, positioning_test};
use host_sim::scenario::NoiseLevels;
use host_sim::sil::{HostMap, Sil};
use host_sim::simulation::PAPERS;
use host_sim::training::{Training, TrainingPlan};
use host_sim::world::World;

pub use host_sim::sil::Indirect;

/// The baseline's output layer.
pub type Direct<S> = MotorVector<<S as Scalar>::Weight>;

/// Training steps of the bars.
pub const STEPS: u32 = 2000;

/// A map trained from scratch for `steps` steps in an empty world under `noise`.
///
/// # Panics
/// If the configuration is invalid.
#[must_use]
pub fn trained_under<S: Scalar, O: Output<S>>(
    config: &Config,
    noise: &NoiseLevels,
    seed: u64,
    steps: u32,
) -> HostMap<S, O> {
    let world = World::default();
    let plan = TrainingPlan { seed, ..TrainingPlan::default() };
    let mut training =
        Training::<Sil<S, O>>::new(config, plan, noise, &world).expect("the configuration is valid");
    let Ok(()) = training.run(steps);
    training.controller().controller.map().clone()
}

/// As [`trained_under`] the papers' noise, with the default configuration.
#[must_use]
pub fn trained<S: Scalar, O: Output<S>>(seed: u64, steps: u32) -> HostMap<S, O> {
    trained_under(&Config::default(), &PAPERS, seed, steps)
}

/// P1's positioning test under the papers' noise: 50 targets, drawn by `seed`.
///
/// # Panics
/// If the configuration is invalid.
#[must_use]
pub fn positioning<S: Scalar, O: Output<S>>(map: &HostMap<S, O>, seed: u64) -> Vec<TargetResult> {
    let plan = PositioningPlan { seed, ..PositioningPlan::default() };
    positioning_test(&Config::default(), map, &plan, &PAPERS).expect("the configuration is valid")
}
