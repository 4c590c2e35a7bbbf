//! P1's evaluation (section 3.2, Figs. 4 and 5): how precisely does a map position the robot while it learns?
//!
//! Each trial trains a map from scratch, and every so many steps a copy of the map is tested without training, with the
//! same targets each time. The robot with the analytic inverse ([`crate::arc`]) drives to the same targets: what a step
//! of this length can do at best.

use controller_core::config::{Config, ConfigError};
use controller_core::kohonen::features::{BEHIND_SHARE, Scaling};
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
    /// Distance of the farthest trained neuron at the end, in m (P1 Fig. 6).
    pub farthest_m: f64,
}

impl Curve {
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
    let farthest_m = farthest(training.controller().controller.map()) * reach_m(config);
    Ok(Curve { seed, points, farthest_m })
}

/// Longest way of one training step, in m.
fn reach_m(config: &Config) -> f64 {
    let step_s = f32::from(config.schedule.step_ms) / 1000.0;
    f64::from(Scaling::<f32>::new(config.robot.speed_limit_mps, step_s).reach_m())
}

/// Largest distance of a trained neuron, in units of the reach.
fn farthest<S: Scalar, O: Output<S>>(map: &HostMap<S, O>) -> f64 {
    let trained = lattice().filter(|&index| map.has_won(index));
    trained.map(|index| f64::from(map.place(index).distance.to_f32())).fold(0.0, f64::max)
}

/// The test driven by the analytic inverse, without inertia and noise, on the targets of `plan`. Like the maps it stops
/// as soon as it is within the configuration's tolerance of the goal.
#[must_use]
pub fn analytic_test(config: &Config, plan: &PositioningPlan) -> Vec<TargetResult> {
    let robot = ArcRobot {
        wheel_base_m: f64::from(config.robot.wheel_base_m),
        reach_m: reach_m(config),
        far_share: f64::from(config.reaching.far_share),
        behind_share: f64::from(BEHIND_SHARE),
    };
    let limits = (0.025, f64::from(config.reaching.goal_tolerance_m));
    let mut targets = TargetSource::new(plan.seed, Purpose::TestTargets, plan.arena_m);
    let mut place = Place { position: Point2::origin(), heading_rad: 0.0 };
    let mut from = place.position;
    let mut results = Vec::new();
    for _ in 0..plan.targets {
        let target = targets.next(from, plan.apart_m);
        let approach = robot.approach(place, target, limits, plan.steps_max);
        if let Some((_, arrived)) = approach {
            place = arrived;
        }
        let error_m = (target - place.position).norm();
        results.push(TargetResult {
            error_m,
            nearest_m: error_m,
            steps_to_25_mm: approach.map(|(steps, _)| steps),
            distance_m: (target - from).norm(),
            stopped: approach.is_some(),
        });
        from = target;
    }
    results
}

#[cfg(test)]
mod tests {
    use super::{Curve, CurvePlan, CurvePoint, analytic_test, learning_curve};
    use crate::positioning::{PositioningPlan, TargetResult};
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
        assert!((super::farthest(&map) * super::reach_m(&config) - once.farthest_m).abs() < 1e-12);
    }

    #[test]
    fn an_error_counts_as_low_from_where_it_stays_low() {
        let point = |steps: u32, error_m: f64| {
            let result = TargetResult {
                error_m,
                nearest_m: error_m,
                steps_to_25_mm: None,
                distance_m: 1.0,
                stopped: true,
            };
            CurvePoint { steps, results: vec![result] }
        };
        let points = vec![point(1, 0.001), point(2, 0.01), point(3, 0.002), point(4, 0.001)];
        let curve = Curve { seed: 1, points, farthest_m: 0.0 };
        assert_eq!(curve.steps_until_below(0.003), Some(3));
        assert_eq!(curve.steps_until_below(0.0005), None);
        assert_eq!(curve.steps_until_below(1.0), Some(1));
    }

    #[test]
    fn the_analytic_inverse_gets_to_every_target() {
        let results = analytic_test(&Config::default(), &PositioningPlan::default());
        assert!(results.iter().all(|result| result.stopped && result.error_m < 0.001), "{results:?}");
    }
}
