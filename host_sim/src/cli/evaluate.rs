//! `evaluate`: experiments of the papers, repeated.

use core::fmt::Write;
use std::time::Instant;

use controller_core::config::Config;
use controller_core::kohonen::output::{ControlMatrix, MotorVector, Output};
use controller_core::scalar::{Fixed, Scalar};
use host_sim::config_file;
use host_sim::figure::{Axis, Series, draw_chart};
use host_sim::learning_curve::{Curve, CurvePlan, CurvePoint, analytic_test, learning_curve};
use host_sim::positioning::{PositioningPlan, TargetResult, summarise};
use host_sim::statistics::{Mean, Rate};
use host_sim::training::TrainingPlan;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use serde_json::{Value, json};

use super::args::{EvaluateArgs, EvaluatePositioningArgs, Evaluation, MappingArg, ScalarArg};
use super::error::{CliError, Outcome};
use super::learning::{seeds, threads};
use super::output::{OutputFolder, print, print_json};
use super::progress::Progress;
use super::table::{facts, percent, table};

/// Mean errors of P1 Fig. 4 after 50,000 steps and more, read from the figure: mapping, m.
const PAPER_M: [(&str, f64); 2] = [("paper, indirect", 0.003), ("paper, direct", 0.008)];

/// Distances ε at which P(ε) is printed, in m.
const WITHIN_M: [f64; 4] = [0.025, 0.005, 0.003, 0.001];

/// Errors that the table says the steps to, in m.
const LEARNED_M: [f64; 2] = [0.003, 0.001];

const CSV: &str = "positioning.csv";
const FIG_4: &str = "p1_fig4.svg";
const FIG_5: &str = "p1_fig5a.svg";

/// All trials of one kind of map.
struct Kind {
    name: String,
    mapping: &'static str,
    scalar: &'static str,
    curves: Vec<Curve>,
}

pub fn evaluate(args: &EvaluateArgs) -> Result<Outcome, CliError> {
    match &args.what {
        Evaluation::Positioning(args) => positioning(args),
    }
}

fn positioning(args: &EvaluatePositioningArgs) -> Result<Outcome, CliError> {
    let config = args.config.as_deref().map_or_else(|| Ok(Config::default()), config_file::load)?;
    let folder = args.out.as_deref().map(|out| OutputFolder::open(out, &[CSV, FIG_4, FIG_5])).transpose()?;
    let seeds: Vec<u64> = seeds(args.seed, args.trials)?.collect();
    let plan = CurvePlan {
        training: TrainingPlan { steps: args.steps, ..TrainingPlan::default() },
        every: args.every,
        test: PositioningPlan { targets: args.targets, ..PositioningPlan::default() },
    };
    let begin = Instant::now();
    let kinds = threads(args.threads)?.install(|| kinds(args, &config, &plan, &seeds))?;
    let pace = pace(&config, &kinds, begin.elapsed().as_secs_f64());
    let analytic: Vec<TargetResult> = seeds
        .iter()
        .flat_map(|&seed| analytic_test(&config, &PositioningPlan { seed, ..plan.test.clone() }))
        .collect();
    let mut files = Vec::new();
    if let Some(folder) = folder {
        files.push(folder.write(CSV, csv(&kinds).as_bytes())?);
        files.push(folder.write(FIG_4, figure_4(&kinds).as_bytes())?);
        files.push(folder.write(FIG_5, figure_5(&kinds, &analytic).as_bytes())?);
    }
    if args.json {
        let document = json!({
            "seeds": seeds,
            "steps": args.steps,
            "every": args.every,
            "targets": args.targets,
            "kinds": kinds.iter().map(Kind::document).collect::<Vec<_>>(),
            "analytic": figures(&analytic),
            "files": files,
        });
        print_json(&document)?;
        return Ok(Outcome::Ok);
    }
    print(&text(args, &config, &kinds, &analytic, &pace))?;
    files.iter().try_for_each(|file| print(&format!("wrote {file}\n")))?;
    Ok(Outcome::Ok)
}

/// The trials of all kinds that were asked for.
fn kinds(
    args: &EvaluatePositioningArgs,
    config: &Config,
    plan: &CurvePlan,
    seeds: &[u64],
) -> Result<Vec<Kind>, CliError> {
    let mut kinds = Vec::new();
    if args.scalar != Some(ScalarArg::Fixed) {
        of_scalar::<f32>(args, config, plan, seeds, &mut kinds)?;
    }
    if args.scalar != Some(ScalarArg::F32) {
        of_scalar::<Fixed>(args, config, plan, seeds, &mut kinds)?;
    }
    Ok(kinds)
}

fn of_scalar<S: Scalar>(
    args: &EvaluatePositioningArgs,
    config: &Config,
    plan: &CurvePlan,
    seeds: &[u64],
    kinds: &mut Vec<Kind>,
) -> Result<(), CliError> {
    if args.mapping != Some(MappingArg::Direct) {
        kinds.push(kind::<S, ControlMatrix<S::Weight>>(config, plan, seeds)?);
    }
    if args.mapping != Some(MappingArg::Indirect) {
        kinds.push(kind::<S, MotorVector<S::Weight>>(config, plan, seeds)?);
    }
    Ok(())
}

/// The trials of one kind, in parallel.
fn kind<S: Scalar, O: Output<S>>(config: &Config, plan: &CurvePlan, seeds: &[u64]) -> Result<Kind, CliError> {
    let name = format!("{}, {}", O::NAME, S::NAME);
    let steps = seeds.iter().map(|_| u64::from(plan.training.steps)).sum();
    let bar = Progress::new("learning", steps);
    let learn = |&seed: &u64| learning_curve::<S, O>(config, plan, seed, &|| bar.advance());
    let curves: Vec<_> = seeds.into_par_iter().map(learn).collect();
    Ok(Kind {
        name,
        mapping: O::NAME,
        scalar: S::NAME,
        curves: curves.into_iter().collect::<Result<_, _>>()?,
    })
}

/// How fast it went.
fn pace(config: &Config, kinds: &[Kind], seconds: f64) -> String {
    let curves = kinds.iter().flat_map(|kind| &kind.curves);
    let steps: f64 = curves.filter_map(|curve| curve.points.last()).map(|point| f64::from(point.steps)).sum();
    let factor = steps * f64::from(config.schedule.step_ms) / 1000.0 / seconds;
    format!("{seconds:.1} s with all tests; the training alone would be {factor:.0} × real time")
}

impl Kind {
    /// All results after all training.
    fn last(&self) -> Vec<TargetResult> {
        let results = self.curves.iter().filter_map(|curve| curve.points.last()).map(|point| &point.results);
        results.flatten().copied().collect()
    }

    /// Mean errors of the trials after all training, in m.
    fn trial_errors_m(&self) -> impl Iterator<Item = f64> + '_ {
        self.curves.iter().filter_map(|curve| curve.points.last()).map(CurvePoint::mean_error_m)
    }

    /// Steps from which on every trial stays below; `None` if one does not.
    fn steps_until_all_below(&self, limit_m: f64) -> Option<u32> {
        let steps: Option<Vec<u32>> =
            self.curves.iter().map(|curve| curve.steps_until_below(limit_m)).collect();
        steps?.into_iter().max()
    }

    /// E over the steps: mean of the trials, in mm.
    fn curve_mm(&self) -> Vec<(f64, f64)> {
        let tests = self.curves.first().map_or(&[][..], |curve| &curve.points);
        let mean = |number: usize| {
            Mean::of(self.curves.iter().filter_map(|curve| Some(curve.points.get(number)?.mean_error_m())))
        };
        tests
            .iter()
            .enumerate()
            .map(|(number, point)| (f64::from(point.steps), mean(number).mean * 1000.0))
            .collect()
    }

    fn document(&self) -> Value {
        let error = Mean::of(self.trial_errors_m());
        let trial = |curve: &Curve| {
            let points = curve
                .points
                .iter()
                .map(|point| json!({ "steps": point.steps, "figures": figures(&point.results) }));
            json!({
                "seed": curve.seed,
                "farthest_neuron_m": curve.farthest_m,
                "points": points.collect::<Vec<_>>(),
            })
        };
        json!({
            "mapping": self.mapping,
            "scalar": self.scalar,
            "mean_error_m": error,
            "worst_trial_m": self.trial_errors_m().fold(0.0, f64::max),
            "all": figures(&self.last()),
            "steps_until_below": LEARNED_M
                .map(|limit_m| json!({ "error_m": limit_m, "steps": self.steps_until_all_below(limit_m) })),
            "trials": self.curves.iter().map(trial).collect::<Vec<_>>(),
        })
    }
}

/// P(ε).
fn within(results: &[TargetResult], epsilon_m: f64) -> Rate {
    Rate::of(results.iter().map(|result| result.nearest_m < epsilon_m))
}

fn figures(results: &[TargetResult]) -> Value {
    let summary = summarise(results);
    let rate = |rate: Rate| json!({ "share": rate.share(), "wilson_95": rate.wilson_95() });
    json!({
        "mean_error_m": summary.mean_error_m,
        "worst_error_m": summary.worst_error_m,
        "within": WITHIN_M.map(|epsilon_m| json!({ "m": epsilon_m, "rate": rate(within(results, epsilon_m)) })),
        "steps_per_metre": summary.steps_per_metre,
        "never_stopped": rate(Rate::of(results.iter().map(|result| !result.stopped))),
    })
}

fn text(
    args: &EvaluatePositioningArgs,
    config: &Config,
    kinds: &[Kind],
    analytic: &[TargetResult],
    pace: &str,
) -> String {
    let head = facts([
        (
            "trained",
            format!(
                "{} trials of {} steps of {:.3} s, seeds {} to {}, 10 % noise",
                args.trials,
                args.steps,
                f64::from(config.schedule.step_ms) / 1000.0,
                args.seed,
                args.seed + u64::from(args.trials) - 1
            ),
        ),
        ("tested", format!("every {} steps with {} targets each", args.every, args.targets)),
        (
            "paper",
            String::from("3 mm (indirect) and 8 mm (direct) after 50,000 steps, T(25 mm) 9 and 17.5 steps/m"),
        ),
        ("took", pace.to_owned()),
    ]);
    let names = [
        "map",
        "E mm",
        "± 95 %",
        "worst trial",
        "P(25)",
        "P(5)",
        "P(3)",
        "P(1 mm) %",
        "T(25 mm)",
        "never stopped %",
        "farthest mm",
    ];
    let mut rows = vec![names.map(String::from).to_vec()];
    for kind in kinds {
        let error = Mean::of(kind.trial_errors_m());
        let farthest = kind.curves.iter().map(|curve| curve.farthest_m).fold(0.0, f64::max);
        rows.push(row(
            &kind.name,
            &kind.last(),
            Some(error),
            kind.trial_errors_m().fold(0.0, f64::max),
            farthest,
        ));
    }
    rows.push(row("analytic inverse", analytic, None, 0.0, 0.0));
    let mut learned = vec![["steps until all trials stay below", "3 mm", "1 mm"].map(String::from).to_vec()];
    for kind in kinds {
        let steps = |limit_m| {
            kind.steps_until_all_below(limit_m).map_or_else(|| String::from("–"), |steps| steps.to_string())
        };
        learned.push([vec![kind.name.clone()], LEARNED_M.map(steps).to_vec()].concat());
    }
    format!("{head}\n{}\n{}", table(&rows), table(&learned))
}

/// A line of the table; without a mean over trials it is of a robot that has nothing to learn.
fn row(
    name: &str,
    results: &[TargetResult],
    error: Option<Mean>,
    worst_trial_m: f64,
    farthest_m: f64,
) -> Vec<String> {
    let summary = summarise(results);
    let learned = |text: String| if error.is_some() { text } else { String::from("–") };
    let mut cells = vec![
        name.to_owned(),
        format!("{:.2}", summary.mean_error_m * 1000.0),
        error.map_or_else(|| String::from("–"), |error| format!("{:.2}", error.half_width_95 * 1000.0)),
        learned(format!("{:.2}", worst_trial_m * 1000.0)),
    ];
    cells.extend(WITHIN_M.map(|epsilon_m| percent(within(results, epsilon_m).share())));
    cells.push(format!("{:.2}", summary.steps_per_metre));
    cells.push(percent(summary.never_stopped));
    cells.push(learned(format!("{:.0}", farthest_m * 1000.0)));
    cells
}

/// Every test of every trial; units are part of the names.
fn csv(kinds: &[Kind]) -> String {
    let mut text = String::from(
        "mapping,scalar,seed,steps,mean_error_m,worst_error_m,within_1_mm,never_stopped,steps_per_metre\n",
    );
    for kind in kinds {
        for curve in &kind.curves {
            for point in &curve.points {
                let s = summarise(&point.results);
                // Writing to a string cannot fail.
                let _ = writeln!(
                    text,
                    "{},{},{},{},{:.6},{:.6},{:.3},{:.3},{:.3}",
                    kind.mapping,
                    kind.scalar,
                    curve.seed,
                    point.steps,
                    s.mean_error_m,
                    s.worst_error_m,
                    s.within_1_mm,
                    s.never_stopped,
                    s.steps_per_metre
                );
            }
        }
    }
    text
}

/// P1 Fig. 4: E over the training steps.
fn figure_4(kinds: &[Kind]) -> String {
    let mut series: Vec<Series> = kinds
        .iter()
        .map(|kind| Series { label: kind.name.clone(), points: kind.curve_mm(), is_reference: false })
        .collect();
    let end = series.iter().flat_map(|series| &series.points).map(|point| point.0).fold(1.0, f64::max);
    for (label, error_m) in PAPER_M {
        let points = vec![(0.0, error_m * 1000.0), (end, error_m * 1000.0)];
        series.push(Series { label: label.to_owned(), points, is_reference: true });
    }
    let x = Axis {
        label: String::from("training steps"),
        range: (0.0, end),
        ticks: [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * end).to_vec(),
        is_logarithmic: false,
    };
    let y = Axis {
        label: String::from("mean positioning error in mm"),
        range: (0.1, 300.0),
        ticks: vec![0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0],
        is_logarithmic: true,
    };
    draw_chart("Positioning error (P1 Fig. 4)", &x, &y, &series)
}

/// P1 Fig. 5a: P(ε).
fn figure_5(kinds: &[Kind], analytic: &[TargetResult]) -> String {
    let points = |results: &[TargetResult]| {
        let at = |half_mm: u32| {
            let epsilon_mm = f64::from(half_mm) / 2.0;
            (epsilon_mm, within(results, epsilon_mm / 1000.0).share())
        };
        (1..=50).map(at).collect::<Vec<_>>()
    };
    let mut series: Vec<Series> = kinds
        .iter()
        .map(|kind| Series { label: kind.name.clone(), points: points(&kind.last()), is_reference: false })
        .collect();
    series.push(Series {
        label: String::from("analytic inverse"),
        points: points(analytic),
        is_reference: true,
    });
    let x = Axis {
        label: String::from("ε in mm"),
        range: (0.0, 25.0),
        ticks: vec![0.0, 5.0, 10.0, 15.0, 20.0, 25.0],
        is_logarithmic: false,
    };
    let y = Axis {
        label: String::from("P(ε): share of the targets approached to less than ε"),
        range: (0.0, 1.0),
        ticks: vec![0.0, 0.25, 0.5, 0.75, 1.0],
        is_logarithmic: false,
    };
    draw_chart("Target reaching probability (P1 Fig. 5a)", &x, &y, &series)
}
