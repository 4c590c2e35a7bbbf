//! `evaluate calibration`: the robot changes by a fifth, and its map learns on.

use controller_core::config::Config;
use controller_core::scalar::{Fixed, Scalar};
use host_sim::config_file;
use host_sim::figure::{Axis, Series, Style, draw_chart};
use host_sim::positioning::{PositioningPlan, summarise};
use host_sim::self_calibration::{CHANGES, Calibration, CalibrationPlan, Change, Fit, calibrate};
use host_sim::sil::Indirect;
use host_sim::statistics::Mean;
use host_sim::training::TrainingPlan;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use serde_json::{Value, json};

use super::super::args::{EvaluateCalibrationArgs, ScalarArg};
use super::super::error::{CliError, Outcome};
use super::super::learning::{seeds, threads};
use super::super::output::{OutputFolder, print, print_json};
use super::super::progress::Progress;
use super::super::table::{facts, table};

const FIGURE: &str = "self_calibration.svg";

/// All trials of one change.
struct Recovery {
    change: &'static Change,
    trials: Vec<Calibration>,
}

pub fn calibration(args: &EvaluateCalibrationArgs) -> Result<Outcome, CliError> {
    let config = config_file::load(&args.config)?.core;
    let folder = args.out.as_deref().map(|out| OutputFolder::open(out, &[FIGURE])).transpose()?;
    let seeds: Vec<u64> = seeds(args.trials.seed, args.trials.count)?.collect();
    let plan = CalibrationPlan {
        training: TrainingPlan { steps: args.steps, ..TrainingPlan::default() },
        further_steps: args.further,
        every: args.every,
        test: PositioningPlan { targets: args.trials.targets, ..PositioningPlan::default() },
    };
    let recoveries = threads(args.trials.threads)?.install(|| match args.scalar {
        ScalarArg::F32 => recoveries::<f32>(&config, &plan, &seeds),
        ScalarArg::Fixed => recoveries::<Fixed>(&config, &plan, &seeds),
    })?;
    let file =
        folder.map(|folder| folder.write(FIGURE, figure(&recoveries, args.every).as_bytes())).transpose()?;
    if args.trials.json {
        print_json(&json!({
            "seeds": seeds,
            "steps": args.steps,
            "changes": recoveries.iter().map(Recovery::document).collect::<Vec<_>>(),
            "files": file.iter().collect::<Vec<_>>(),
        }))?;
        return Ok(Outcome::Ok);
    }
    print(&text(args, &recoveries))?;
    file.iter().try_for_each(|file| print(&format!("wrote {file}\n")))?;
    Ok(Outcome::Ok)
}

/// All trials of all changes, in parallel.
fn recoveries<S: Scalar>(
    config: &Config,
    plan: &CalibrationPlan,
    seeds: &[u64],
) -> Result<Vec<Recovery>, CliError> {
    let jobs: Vec<(&Change, u64)> =
        CHANGES.iter().flat_map(|change| seeds.iter().map(move |&seed| (change, seed))).collect();
    let each = u64::from(plan.training.steps) + u64::from(plan.further_steps);
    let bar = Progress::new("learning", jobs.iter().map(|_| each).sum());
    let trial = |&(change, seed): &(&Change, u64)| {
        calibrate::<S, Indirect<S>>(config, plan, seed, change, &|| bar.advance())
    };
    let trials: Vec<Result<Calibration, _>> = jobs.par_iter().map(trial).collect();
    let mut trials = trials.into_iter();
    let mut recoveries = Vec::new();
    for change in &CHANGES {
        let trials = trials.by_ref().take(seeds.len()).collect::<Result<_, _>>()?;
        recoveries.push(Recovery { change, trials });
    }
    Ok(recoveries)
}

/// What a fit shows, over all trials.
struct Stage {
    error: Mean,
    worst_trial_m: f64,
    one_step_m: f64,
    steps_per_metre: f64,
    never_stopped: f64,
}

impl Stage {
    fn of<'a>(fits: impl Iterator<Item = &'a Fit>) -> Self {
        let fits: Vec<&Fit> = fits.collect();
        let errors_m: Vec<f64> = fits.iter().map(|fit| summarise(&fit.results).mean_error_m).collect();
        let all: Vec<_> = fits.iter().flat_map(|fit| &fit.results).copied().collect();
        let summary = summarise(&all);
        Self {
            worst_trial_m: errors_m.iter().copied().fold(0.0, f64::max),
            error: Mean::of(errors_m),
            one_step_m: Mean::of(fits.iter().map(|fit| fit.one_step_m)).mean,
            steps_per_metre: summary.steps_per_metre,
            never_stopped: summary.never_stopped,
        }
    }

    fn document(&self) -> Value {
        json!({
            "mean_error_m": self.error,
            "worst_trial_m": self.worst_trial_m,
            "one_step_error_m": self.one_step_m,
            "steps_per_metre": self.steps_per_metre,
            "never_stopped": self.never_stopped,
        })
    }
}

impl Recovery {
    fn before(&self) -> Stage {
        Stage::of(self.trials.iter().map(|trial| &trial.before))
    }

    fn frozen(&self) -> Stage {
        Stage::of(self.trials.iter().map(|trial| &trial.frozen))
    }

    /// Steps after the change, and what there is then.
    fn learning(&self) -> Vec<(u32, Stage)> {
        let tests = self.trials.first().map_or(&[][..], |trial| &trial.learning);
        let stage = |(number, (steps, _)): (usize, &(u32, Fit))| {
            let fits = self.trials.iter().filter_map(|trial| Some(&trial.learning.get(number)?.1));
            (*steps, Stage::of(fits))
        };
        tests.iter().enumerate().map(stage).collect()
    }

    fn document(&self) -> Value {
        let learning = self.learning();
        let learning =
            learning.iter().map(|(steps, stage)| json!({ "steps": steps, "figures": stage.document() }));
        json!({
            "change": self.change.name,
            "before": self.before().document(),
            "without_learning": self.frozen().document(),
            "learning": learning.collect::<Vec<_>>(),
        })
    }
}

fn text(args: &EvaluateCalibrationArgs, recoveries: &[Recovery]) -> String {
    let last = args.trials.last_seed();
    let head = facts([
        (
            "trained",
            format!(
                "{} trials of {} steps, seeds {} to {last}, 10 % noise",
                args.trials.count, args.steps, args.trials.seed
            ),
        ),
        ("then", format!("the robot changes, and learns on for {} steps", args.further)),
        (
            "one step",
            String::from(
                "mean distance from a place in reach to where one step towards it ends, without noise",
            ),
        ),
    ]);
    let names =
        ["change", "when", "E mm", "± 95 %", "worst trial", "one step mm", "T(25 mm)", "never stopped %"];
    let mut rows = vec![names.map(String::from).to_vec()];
    for recovery in recoveries {
        let mut add = |when: String, stage: &Stage| {
            // Said once for each change.
            let change = if when == "before" { recovery.change.name } else { "" };
            rows.push(vec![
                change.to_owned(),
                when,
                format!("{:.2}", stage.error.mean * 1000.0),
                format!("{:.2}", stage.error.half_width_95 * 1000.0),
                format!("{:.2}", stage.worst_trial_m * 1000.0),
                format!("{:.1}", stage.one_step_m * 1000.0),
                format!("{:.2}", stage.steps_per_metre),
                format!("{:.1}", stage.never_stopped * 100.0),
            ]);
        };
        add(String::from("before"), &recovery.before());
        add(String::from("without learning"), &recovery.frozen());
        for (steps, stage) in recovery.learning() {
            add(format!("{steps} steps later"), &stage);
        }
    }
    format!("{head}\n{}", table(&rows))
}

/// What one step misses, over the steps after the change.
fn figure(recoveries: &[Recovery], every: u32) -> String {
    let before = -f64::from(every);
    let mut series = Vec::new();
    for recovery in recoveries {
        let millimetres = |stage: &Stage| stage.one_step_m * 1000.0;
        let (was, frozen) = (millimetres(&recovery.before()), millimetres(&recovery.frozen()));
        let mut points = vec![(before, was), (0.0, was), (0.0, frozen)];
        points
            .extend(recovery.learning().iter().map(|(steps, stage)| (f64::from(*steps), millimetres(stage))));
        series.push(Series { label: recovery.change.name.to_owned(), points, style: Style::Line });
    }
    let end = series.iter().flat_map(|series| &series.points).map(|point| point.0).fold(1.0, f64::max);
    let top = series.iter().flat_map(|series| &series.points).map(|point| point.1).fold(1.0, f64::max).ceil();
    let x = Axis {
        label: String::from("training steps after the robot changed"),
        range: (before, end),
        ticks: [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * end).to_vec(),
        is_logarithmic: false,
    };
    let y = Axis {
        label: String::from("what one step misses, in mm"),
        range: (0.0, top),
        ticks: [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * top).to_vec(),
        is_logarithmic: false,
    };
    draw_chart("Self-calibration: the robot changes under way", &x, &y, &series)
}
