//! P1's evaluation (section 3.2, Figs. 4 and 5): how precisely does a map position the robot while it learns?
//!
//! Each trial trains a map from scratch, and every so many steps a copy of the map is tested without training, with the
//! same targets each time. The robot with the analytic inverse ([`crate::arc`]) drives to the same targets: what a step
//! of this length can do at best.

use controller_core::config::{Config, ConfigError};
use controller_core::kohonen::features::{BEHIND_SHARE, Features, Scaling};
use controller_core::kohonen::output::Output;
use controller_core::scalar::Scalar;
use nalgebra::Point2;

use crate::arc::{ArcRobot, Place};
use crate::map_store::lattice;
use crate::positioning::{PositioningPlan, TargetResult, positioning_test, summarise};
use crate::random::Purpose;
use crate::sil::{HostMap, Sil};
use crate::simulation::PAPERS;
use crate::training::{TargetSource, Training, TrainingPlan};
use crate::world::World;

/// What a trial does; the seeds of both plans are replaced by the trial's.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePlan {
    /// All training.
    pub training: TrainingPlan,
    /// Training steps between two tests; the last test comes at the end in any case.
    pub every: u32,
    /// A test.
    pub test: PositioningPlan,
}

/// A test after so much training.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePoint {
    /// Training steps before it.
    pub steps: u32,
    /// What happened at each target.
    pub results: Vec<TargetResult>,
}

impl CurvePoint {
    /// Mean positioning error E of P1 Fig. 4, in m.
    #[must_use]
    pub fn mean_error_m(&self) -> f64 {
        summarise(&self.results).mean_error_m
    }
}

/// A trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its seed.
    pub seed: u64,
    /// The tests, in order.
    pub points: Vec<CurvePoint>,
    /// The trained neurons at the end (P1 Fig. 6): bearing in rad, distance in m.
    pub neurons: Vec<[f64; 2]>,
    /// The largest element of an output at the end, in the map's units.
    pub largest_output: f64,
}

impl Curve {
    /// Distance of the farthest trained neuron at the end, in m.
    #[must_use]
    pub fn farthest_m(&self) -> f64 {
        self.neurons.iter().map(|[_, distance_m]| *distance_m).fold(0.0, f64::max)
    }

    /// The largest mean error over the least one, of the tests from so many training steps on; 1 of fewer than two.
    #[must_use]
    pub fn drift(&self, from_steps: u32) -> f64 {
        let later = self.points.iter().filter(|point| point.steps >= from_steps);
        let (least, largest) = later.fold((f64::INFINITY, 0.0_f64), |(least, largest), point| {
            let error_m = point.mean_error_m();
            (error_m.min(least), error_m.max(largest))
        });
        if least > 0.0 { (largest / least).max(1.0) } else { 1.0 }
    }

    /// Simulated time of training and tests, in training steps.
    #[must_use]
    pub fn simulated_steps(&self) -> f64 {
        let trained = self.points.last().map_or(0, |point| point.steps);
        let tested = self.points.iter().flat_map(|point| &point.results).map(|result| result.steps);
        f64::from(trained) + tested.sum::<f64>()
    }

    /// Steps from which on the mean error stays below a limit, as far as it was tested; `None` if it does not.
    #[must_use]
    pub fn steps_until_below(&self, limit_m: f64) -> Option<u32> {
        let below = self.points.iter().rev().take_while(|point| point.mean_error_m() < limit_m);
        below.last().map(|point| point.steps)
    }
}

/// Trains a map under the papers' noise, and tests it on the way; `progress` hears of every step.
///
/// # Errors
/// If the configuration cannot be used.
pub fn learning_curve<S: Scalar, O: Output<S>>(
    config: &Config,
    plan: &CurvePlan,
    seed: u64,
    progress: &(dyn Fn() + Sync),
) -> Result<Curve, ConfigError> {
    let world = World::default();
    let test = PositioningPlan { seed, ..plan.test.clone() };
    let training = TrainingPlan { seed, ..plan.training.clone() };
    let mut training = Training::<Sil<S, O>>::new(config, training, &PAPERS, &world)?;
    let (mut points, mut done) = (Vec::new(), 0);
    while done < plan.training.steps {
        // At least one step, so that it ends whatever was asked for.
        let steps = plan.every.clamp(1, plan.training.steps - done);
        for _ in 0..steps {
            let Ok(()) = training.run(1);
            progress();
        }
        done += steps;
        let map = training.controller().controller.map();
        points.push(CurvePoint { steps: done, results: positioning_test(config, map, &test, &PAPERS)? });
    }
    let map = training.controller().controller.map();
    let reach_m = reach_m(config);
    let neurons = trained(map).map(|place| {
        let place = place.unfolded();
        [f64::from(place.bearing.to_f32()), f64::from(place.distance.to_f32()) * reach_m]
    });
    Ok(Curve { seed, points, neurons: neurons.collect(), largest_output: largest_output(map) })
}

/// Longest way of one training step, in m.
fn reach_m(config: &Config) -> f64 {
    let step_s = f32::from(config.schedule.step_ms) / 1000.0;
    f64::from(Scaling::<f32>::new(config.robot.speed_limit_mps, step_s).reach_m())
}

/// The weights of the trained neurons.
fn trained<S: Scalar, O: Output<S>>(map: &HostMap<S, O>) -> impl Iterator<Item = Features<S>> + '_ {
    lattice().filter(|&index| map.has_won(index)).map(|index| map.place(index))
}

/// The largest element of any output: what it commands for a radian and for a reach.
fn largest_output<S: Scalar, O: Output<S>>(map: &HostMap<S, O>) -> f64 {
    let units = [(S::ONE, S::ZERO), (S::ZERO, S::ONE)];
    let commands = lattice().flat_map(|index| {
        let output = map.neuron(index).output;
        units.map(|(bearing, distance)| output.command(Features { bearing, distance }))
    });
    let largest =
        commands.flat_map(|command| [command.left, command.right]).map(|speed| speed.to_f32().abs());
    f64::from(largest.fold(0.0, f32::max))
}

/// The test driven by the analytic inverse, without inertia and noise, on the targets of `plan`. Like the maps it stops
/// as soon as it is within the configuration's tolerance of the goal.
#[must_use]
pub fn analytic_test(config: &Config, plan: &PositioningPlan) -> Vec<TargetResult> {
    let step_s = f64::from(config.schedule.step_ms) / 1000.0;
    let far_share = f64::from(config.reaching.far_share);
    let robot = ArcRobot {
        wheel_base_m: f64::from(config.robot.wheel_base_m),
        reach_m: reach_m(config),
        // 0 is the papers' literal form: no place is far.
        far_share: if far_share > 0.0 { far_share } else { f64::INFINITY },
        behind_share: f64::from(BEHIND_SHARE),
        near_share: f64::from(config.reaching.near_share),
        near_bearing_rad: f64::from(config.near_bearing_rad()),
        unit_m: f64::from(config.robot.command_unit_mps) * step_s,
        goal_way_m: f64::from(config.reaching.goal_speed_mps) * step_s,
    };
    let stop_m = f64::from(config.reaching.goal_tolerance_m);
    let mut targets = TargetSource::new(plan.seed, Purpose::TestTargets, plan.arena_m);
    let mut place = Place { position: Point2::origin(), heading_rad: 0.0 };
    let mut from = place.position;
    let mut results = Vec::new();
    for _ in 0..plan.targets {
        let target = targets.next(from, plan.apart_m);
        let (result, end) = robot.approach(place, target, stop_m, plan.steps_max);
        results.push(TargetResult { distance_m: (target - from).norm(), ..result });
        (from, place) = (target, end);
    }
    results
}

#[cfg(test)]
mod tests {
    use super::{Curve, CurvePlan, CurvePoint, analytic_test, learning_curve};
    use crate::positioning::{Approach, PositioningPlan};
    use crate::sil::Indirect;
    use crate::sweep::learn;
    use crate::training::TrainingPlan;
    use controller_core::config::Config;

    fn plan(steps: u32, every: u32) -> CurvePlan {
        CurvePlan {
            training: TrainingPlan { steps, ..TrainingPlan::default() },
            every,
            test: PositioningPlan { targets: 2, ..PositioningPlan::default() },
        }
    }

    #[test]
    fn a_test_on_the_way_changes_nothing() {
        let config = Config::default();
        let curve =
            |every| learning_curve::<f32, Indirect<f32>>(&config, &plan(50, every), 3, &|| ()).unwrap();
        let (once, often) = (curve(50), curve(20));
        assert_eq!(often.points.iter().map(|point| point.steps).collect::<Vec<_>>(), [20, 40, 50]);
        assert_eq!(once.points.last(), often.points.last());
        // And it is the map that `train` makes.
        let training = TrainingPlan { steps: 50, seed: 3, ..TrainingPlan::default() };
        let map = learn::<f32, Indirect<f32>>(&config, &training, &|| ()).unwrap().map;
        let farthest = super::trained(&map).map(|place| f64::from(place.distance)).fold(0.0, f64::max);
        assert!((farthest * super::reach_m(&config) - once.farthest_m()).abs() < 1e-12);
    }

    #[test]
    fn an_error_counts_as_low_from_where_it_stays_low() {
        let point = |steps: u32, error_m: f64| {
            let result = Approach::NEW.end(error_m, 1.0, 1.0, true);
            CurvePoint { steps, results: vec![result] }
        };
        let points = vec![point(1, 0.001), point(2, 0.01), point(3, 0.002), point(4, 0.001)];
        let curve = Curve { seed: 1, points, neurons: Vec::new(), largest_output: 0.0 };
        assert_eq!(curve.steps_until_below(0.003), Some(3));
        assert_eq!(curve.steps_until_below(0.0005), None);
        assert_eq!(curve.steps_until_below(1.0), Some(1));
        assert!((curve.drift(2) - 10.0).abs() < 1e-12 && (curve.drift(4) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_analytic_inverse_gets_to_every_target() {
        let results = analytic_test(&Config::default(), &PositioningPlan::default());
        assert!(results.iter().all(|result| result.stopped && result.error_m < 0.001), "{results:?}");
    }
}
