//! What the trials show, as tables, JSON and CSV.

use core::fmt::Write;

use host_sim::learning_curve::{Curve, CurvePoint};
use host_sim::positioning::{EPSILONS_MM, TargetResult, steps_per_metre, summarise};
use host_sim::statistics::{Mean, Rate};
use serde_json::{Value, json};

use super::super::table::{percent, table};
use super::Analytic;
use super::trials::Kind;

/// What P1 reports of a mapping after 50,000 steps and more, read from its figures.
pub struct Paper {
    pub name: &'static str,
    /// Fig. 4.
    pub error_m: f64,
    /// Fig. 5b.
    pub steps_per_metre: f64,
    /// Fig. 6: distance of the farthest neuron.
    pub extent_m: f64,
}

pub const PAPER: [Paper; 2] = [
    Paper { name: "P1, figures: indirect", error_m: 0.003, steps_per_metre: 9.0, extent_m: 0.16 },
    Paper { name: "P1, figures: direct", error_m: 0.008, steps_per_metre: 17.5, extent_m: 0.11 },
];

/// Distances ε at which P(ε) is printed, in m.
const WITHIN_M: [f64; 4] = [0.025, 0.005, 0.003, 0.001];

/// Errors that the table says the steps to, in m.
const LEARNED_M: [f64; 2] = [0.003, 0.001];

/// Training steps and errors of which the table says how many trials were below.
const MILESTONES: [(u32, f64); 2] = [(750, 0.003), (1500, 0.001)];

/// P(ε).
pub fn within(results: &[TargetResult], epsilon_m: f64) -> Rate {
    Rate::of(results.iter().map(|result| result.nearest_m < epsilon_m))
}

/// What the columns of [`result_cells`] hold.
pub const RESULT_HEAD: [&str; 10] = [
    "E mm",
    "± 95 %",
    "worst trial",
    "P(25)",
    "P(5)",
    "P(3)",
    "P(1 mm) %",
    "T(25 mm)",
    "never stopped %",
    "extent mm",
];

/// The cells of a line after its name.
pub fn result_cells(kind: &Kind) -> Vec<String> {
    let results = kind.last();
    let error = Mean::of(kind.trial_errors_m());
    let extent_m = kind.curves.iter().map(Curve::farthest_m).fold(0.0, f64::max);
    let mut cells = vec![
        format!("{:.2}", error.mean * 1000.0),
        format!("{:.2}", error.half_width_95 * 1000.0),
        format!("{:.2}", kind.worst_trial_m() * 1000.0),
    ];
    cells.extend(shared_cells(&results));
    cells.push(format!("{:.0}", extent_m * 1000.0));
    cells
}

fn shared_cells(results: &[TargetResult]) -> Vec<String> {
    let summary = summarise(results);
    let mut cells = WITHIN_M.map(|epsilon_m| percent(within(results, epsilon_m).share())).to_vec();
    cells.push(format!("{:.2}", summary.steps_per_metre));
    cells.push(percent(summary.never_stopped));
    cells
}

fn dash() -> String {
    String::from("–")
}

/// The two tables.
pub fn tables(kinds: &[Kind], analytic: &[Analytic]) -> String {
    let head = |first: &str, rest: &[&str]| {
        core::iter::once(first).chain(rest.iter().copied()).map(String::from).collect::<Vec<_>>()
    };
    let mut rows = vec![head("map", &RESULT_HEAD)];
    rows.extend(kinds.iter().map(|kind| [vec![kind.name().to_owned()], result_cells(kind)].concat()));
    for of in analytic {
        // It has nothing to learn, so no trials that could differ, and no neurons.
        let error_mm = summarise(&of.results).mean_error_m * 1000.0;
        let first = vec![of.name.clone(), format!("{error_mm:.2}"), dash(), dash()];
        rows.push([first, shared_cells(&of.results), vec![dash()]].concat());
    }
    for paper in &PAPER {
        let mut cells = vec![paper.name.to_owned(), format!("{:.0}", paper.error_m * 1000.0)];
        cells.extend((0..6).map(|_| dash()));
        cells.push(format!("{:.1}", paper.steps_per_metre));
        cells.extend([dash(), format!("{:.0}", paper.extent_m * 1000.0)]);
        rows.push(cells);
    }
    let learned_head = [
        "all trials below 3 mm from",
        "1 mm from step",
        "trials below 3 mm at 750",
        "1 mm at 1500 steps",
        "E worst/best later",
        "largest M",
    ];
    let mut learned = vec![head("learning", &learned_head)];
    for kind in kinds {
        let mut cells = vec![kind.name().to_owned()];
        cells.extend(
            LEARNED_M.map(|limit_m| {
                kind.steps_until_all_below(limit_m).map_or_else(dash, |steps| steps.to_string())
            }),
        );
        cells.extend(MILESTONES.map(|(steps, limit_m)| {
            let below = kind.trials_below(steps, limit_m);
            below.map_or_else(dash, |below| format!("{below} of {}", kind.curves.len()))
        }));
        let largest = kind.curves.iter().map(|curve| curve.largest_output).fold(0.0, f64::max);
        cells.extend([format!("{:.2}", kind.drift()), format!("{largest:.2}")]);
        learned.push(cells);
    }
    format!("{}\n{}", table(&rows), table(&learned))
}

fn figures(results: &[TargetResult]) -> Value {
    let summary = summarise(results);
    let rate = |rate: Rate| json!({ "share": rate.share(), "wilson_95": rate.wilson_95() });
    json!({
        "mean_error_m": summary.mean_error_m,
        "worst_error_m": summary.worst_error_m,
        "within": WITHIN_M.map(|epsilon_m| json!({ "m": epsilon_m, "rate": rate(within(results, epsilon_m)) })),
        "steps_per_metre": summary.steps_per_metre,
        "steps_per_metre_to_mm": (1..=EPSILONS_MM).map(|mm| steps_per_metre(results, mm)).collect::<Vec<_>>(),
        "never_stopped": rate(Rate::of(results.iter().map(|result| !result.stopped))),
    })
}

/// An analytic inverse as JSON.
pub fn analytic_document(of: &Analytic) -> Value {
    json!({ "config": of.config_name, "figures": figures(&of.results) })
}

/// A kind as JSON.
pub fn document(kind: &Kind) -> Value {
    let trial = |curve: &Curve| {
        let point = |point: &CurvePoint| json!({ "steps": point.steps, "figures": figures(&point.results) });
        json!({
            "seed": curve.seed,
            "extent_m": curve.farthest_m(),
            "largest_output": curve.largest_output,
            "points": curve.points.iter().map(point).collect::<Vec<_>>(),
        })
    };
    json!({
        "config": kind.subject.config_name,
        "mapping": kind.subject.mapping_name(),
        "scalar": kind.subject.scalar_name(),
        "mean_error_m": Mean::of(kind.trial_errors_m()),
        "worst_trial_m": kind.worst_trial_m(),
        "all": figures(&kind.last()),
        "steps_until_below": LEARNED_M
            .map(|limit_m| json!({ "error_m": limit_m, "steps": kind.steps_until_all_below(limit_m) })),
        "drift": kind.drift(),
        "trials": kind.curves.iter().map(trial).collect::<Vec<_>>(),
    })
}

/// Every test of every trial; units are part of the names.
pub fn csv(kinds: &[Kind]) -> String {
    let mut text = String::from(
        "config,mapping,scalar,seed,steps,mean_error_m,worst_error_m,within_1_mm,never_stopped,steps_per_metre\n",
    );
    for kind in kinds {
        let Kind { subject, curves } = kind;
        for (curve, point) in
            curves.iter().flat_map(|curve| curve.points.iter().map(move |point| (curve, point)))
        {
            let s = summarise(&point.results);
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{},{},{},{},{},{:.6},{:.6},{:.3},{:.3},{:.3}",
                subject.config_name,
                subject.mapping_name(),
                subject.scalar_name(),
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
    text
}
