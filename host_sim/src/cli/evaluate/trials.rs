//! Trials of several kinds of map, all in parallel.

use controller_core::config::Config;
use controller_core::kohonen::output::{ControlMatrix, MotorVector, Output};
use controller_core::scalar::{Fixed, Scalar};
use host_sim::learning_curve::{Curve, CurvePlan, CurvePoint, learning_curve};
use host_sim::positioning::TargetResult;
use host_sim::statistics::Mean;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

use super::super::args::{MappingArg, ScalarArg};
use super::super::error::CliError;
use super::super::progress::Progress;

/// What is learned: a configuration, a scalar and an output layer.
pub struct Subject<'a> {
    /// What tables and files call it.
    pub name: String,
    /// The name of its configuration.
    pub config_name: &'a str,
    pub config: &'a Config,
    pub mapping: MappingArg,
    pub scalar: ScalarArg,
}

/// All trials of one subject.
pub struct Kind<'a> {
    pub subject: Subject<'a>,
    pub curves: Vec<Curve>,
}

impl Subject<'_> {
    fn learn(&self, plan: &CurvePlan, seed: u64, progress: &(dyn Fn() + Sync)) -> Result<Curve, CliError> {
        match self.scalar {
            ScalarArg::F32 => self.learn_in::<f32>(plan, seed, progress),
            ScalarArg::Fixed => self.learn_in::<Fixed>(plan, seed, progress),
        }
    }

    fn learn_in<S: Scalar>(
        &self,
        plan: &CurvePlan,
        seed: u64,
        progress: &(dyn Fn() + Sync),
    ) -> Result<Curve, CliError> {
        Ok(match self.mapping {
            MappingArg::Indirect => {
                learning_curve::<S, ControlMatrix<S::Weight>>(self.config, plan, seed, progress)?
            }
            MappingArg::Direct => {
                learning_curve::<S, MotorVector<S::Weight>>(self.config, plan, seed, progress)?
            }
        })
    }

    pub fn mapping_name(&self) -> &'static str {
        match self.mapping {
            MappingArg::Indirect => <ControlMatrix<f32> as Output<f32>>::NAME,
            MappingArg::Direct => <MotorVector<f32> as Output<f32>>::NAME,
        }
    }

    pub fn scalar_name(&self) -> &'static str {
        match self.scalar {
            ScalarArg::F32 => f32::NAME,
            ScalarArg::Fixed => Fixed::NAME,
        }
    }
}

/// Runs all trials of all subjects.
pub fn run<'a>(
    subjects: Vec<Subject<'a>>,
    plan: &CurvePlan,
    seeds: &[u64],
) -> Result<Vec<Kind<'a>>, CliError> {
    // All at once, so that no core waits for the last trial of a subject.
    let jobs: Vec<(&Subject, u64)> =
        subjects.iter().flat_map(|subject| seeds.iter().map(move |&seed| (subject, seed))).collect();
    let steps = jobs.iter().map(|_| u64::from(plan.training.steps)).sum();
    let bar = Progress::new("learning", steps);
    let learn = |&(subject, seed): &(&Subject, u64)| subject.learn(plan, seed, &|| bar.advance());
    let curves: Vec<Result<Curve, CliError>> = jobs.par_iter().map(learn).collect();
    let mut curves = curves.into_iter();
    let mut kinds = Vec::new();
    for subject in subjects {
        let curves = curves.by_ref().take(seeds.len()).collect::<Result<_, _>>()?;
        kinds.push(Kind { subject, curves });
    }
    Ok(kinds)
}

impl Kind<'_> {
    pub fn name(&self) -> &str {
        &self.subject.name
    }

    /// All results after all training.
    pub fn last(&self) -> Vec<TargetResult> {
        let results = self.curves.iter().filter_map(|curve| curve.points.last()).map(|point| &point.results);
        results.flatten().copied().collect()
    }

    /// Mean errors of the trials after all training, in m.
    pub fn trial_errors_m(&self) -> impl Iterator<Item = f64> + '_ {
        self.curves.iter().filter_map(|curve| curve.points.last()).map(CurvePoint::mean_error_m)
    }

    /// The largest of them.
    pub fn worst_trial_m(&self) -> f64 {
        self.trial_errors_m().fold(0.0, f64::max)
    }

    /// Steps from which on every trial stays below; `None` if one does not.
    pub fn steps_until_all_below(&self, limit_m: f64) -> Option<u32> {
        let steps: Option<Vec<u32>> =
            self.curves.iter().map(|curve| curve.steps_until_below(limit_m)).collect();
        steps?.into_iter().max()
    }

    /// How many trials' errors are below a limit after so many steps; `None` where there was no test then.
    pub fn trials_below(&self, steps: u32, limit_m: f64) -> Option<usize> {
        let below = |curve: &Curve| {
            let point = curve.points.iter().find(|point| point.steps == steps)?;
            Some(point.mean_error_m() < limit_m)
        };
        let each: Option<Vec<bool>> = self.curves.iter().map(below).collect();
        Some(each?.into_iter().filter(|&is_below| is_below).count())
    }

    /// E over the steps, mean of the trials: steps, m.
    pub fn mean_curve(&self) -> Vec<(u32, f64)> {
        let tests = self.curves.first().map_or(&[][..], |curve| &curve.points);
        let mean = |number: usize| {
            Mean::of(self.curves.iter().filter_map(|curve| Some(curve.points.get(number)?.mean_error_m())))
        };
        tests.iter().enumerate().map(|(number, point)| (point.steps, mean(number).mean)).collect()
    }

    /// The largest drift of a trial once the schedules stand still.
    pub fn drift(&self) -> f64 {
        let from = u32::from(self.subject.config.learning.annealing_steps);
        self.curves.iter().map(|curve| curve.drift(from)).fold(1.0, f64::max)
    }

    /// Simulated time of training and tests, in s.
    pub fn simulated_s(&self) -> f64 {
        let step_s = f64::from(self.subject.config.schedule.step_ms) / 1000.0;
        self.curves.iter().map(Curve::simulated_steps).sum::<f64>() * step_s
    }
}
