//! `run --runs N`: rates over many seeds, both controllers beside each other.

use host_sim::contender::Contender;
use host_sim::map_store::StoredScalar;
use host_sim::mission::MissionResult;
use host_sim::run_log;
use host_sim::scenario::Scenario;
use host_sim::sil::Indirect;
use host_sim::statistics::Rate;
use host_sim::sweep::{self, Maps, SweepPlan, SweepSummary};
use nalgebra::Point2;
use serde_json::{Value, json};

use super::args::RunArgs;
use super::error::{CliError, Outcome};
use super::learning::{learn, learn_each, load_map, load_scenario, seeds, settings, threads, training_plan};
use super::output::{OutputFolder, hex, print, print_json};
use super::progress::Progress;
use super::run::NO_MAP;
use super::single_run::result_json;
use super::table::{facts, millimetres, percent, table};

/// Paths in a figure; more would hide each other.
const DRAWN_PATHS: usize = 20;

/// All runs of one controller.
struct Column {
    controller: Contender,
    results: Vec<MissionResult>,
    summary: SweepSummary,
}

pub fn sweep_run<S: StoredScalar>(args: &RunArgs) -> Result<Outcome, CliError> {
    let settings = settings(&args.learning)?;
    let config = &settings.core;
    let scenario = load_scenario(&args.scenario)?;
    let seeds = seeds(args.learning.seed, args.runs)?;
    let threads = threads(args.threads)?;
    let loaded = load_map::<S>(&args.saved, config)?;
    let [svg, csv] = file_names(&scenario);
    let folder = args.out.as_deref().map(|path| OutputFolder::open(path, &[&svg, &csv])).transpose()?;

    let plan = training_plan(&args.learning);
    let maps = if let Some(stored) = loaded {
        Maps::Shared(Box::new(stored.map))
    } else if args.fresh_maps {
        let learned = threads.install(|| learn_each::<S, Indirect<S>>(config, &plan, seeds.clone()))?;
        Maps::PerRun(learned.into_iter().map(|learned| learned.map).collect())
    } else if is_peer(args) {
        Maps::PerRun(Vec::new())
    } else {
        Maps::Shared(Box::new(learn::<S, Indirect<S>>(config, &plan)?.map))
    };
    let controllers =
        args.controller.map_or_else(|| Contender::PAPERS.to_vec(), |controller| vec![controller]);
    let sweep = SweepPlan { seeds, logged: if folder.is_some() { DRAWN_PATHS } else { 0 } };
    let mut columns = Vec::new();
    for controller in controllers {
        let bar = Progress::new(controller.name(), u64::from(args.runs));
        let progress = || bar.advance();
        let runs = || sweep::run_all(&scenario, &settings, Some(controller), &maps, &sweep, &progress);
        let results = threads.install(runs)?;
        columns.push(Column { controller, summary: sweep::summarise(&results), results });
    }

    let mut files = Vec::new();
    if let Some(folder) = folder {
        files.push(folder.write(&svg, figure(&scenario, &columns).as_bytes())?);
        files.push(folder.write(&csv, runs_csv(&columns).as_bytes())?);
    }
    if args.json {
        print_json(&document(args, &scenario, S::NAME, &columns, &files))?;
    } else {
        print(&text(args, &scenario, S::NAME, &columns, &files))?;
    }
    let enough = |column: &Column| {
        let required = f64::from(args.require.unwrap_or(0));
        column.summary.success.share() * 100.0 >= required
    };
    Ok(if columns.iter().all(enough) { Outcome::Ok } else { Outcome::RobotFailed })
}

/// Whether all runs are those of a controller that needs no map.
fn is_peer(args: &RunArgs) -> bool {
    args.controller.is_some_and(Contender::is_peer)
}

/// Names of the files of a sweep.
fn file_names(scenario: &Scenario) -> [String; 2] {
    [format!("{}_runs.svg", scenario.name), format!("{}_runs.csv", scenario.name)]
}

fn all_results(columns: &[Column]) -> impl Iterator<Item = &MissionResult> {
    columns.iter().flat_map(|column| &column.results)
}

fn sweep_hash(columns: &[Column]) -> String {
    hex(sweep::combined_hash(all_results(columns)))
}

/// The first paths of each controller, in its colour.
fn figure(scenario: &Scenario, columns: &[Column]) -> String {
    let mut traces = Vec::new();
    for column in columns {
        let logged = column.results.iter().filter(|result| !result.samples.is_empty());
        traces.extend(logged.map(|result| run_log::trace(column.controller.name(), &result.samples)));
    }
    let Some(first) = all_results(columns).next() else {
        return host_sim::figure::draw_run(scenario, &traces);
    };
    // Planned from starts a centimetre apart, the checkpoints of the others are the same or look the same.
    let checkpoints = first.checkpoints.iter().map(|&(x, y)| Point2::new(x, y)).collect();
    host_sim::figure::draw_run(&scenario.clone().with_checkpoints(checkpoints), &traces)
}

/// One line for each run.
fn runs_csv(columns: &[Column]) -> String {
    let mut text =
        String::from("controller,seed,success,reached,contacts,duration_s,way_m,error_max_m,hash\n");
    for column in columns {
        for run in &column.results {
            let error_m = run.arrivals.iter().map(|arrival| arrival.error_m).fold(0.0, f64::max);
            text += &format!(
                "{},{},{},{},{},{:.3},{:.4},{error_m:.6},{}\n",
                column.controller.name(),
                run.seed,
                run.success,
                run.reached,
                run.contacts,
                run.duration_s,
                run.way_m,
                hex(run.hash)
            );
        }
    }
    text
}

fn text(args: &RunArgs, scenario: &Scenario, scalar: &str, columns: &[Column], files: &[String]) -> String {
    let first = args.learning.seed;
    let last = first + u64::from(args.runs) - 1;
    let map = match (&args.saved.map, args.fresh_maps) {
        (Some(path), _) => path.display().to_string(),
        _ if is_peer(args) => String::from(NO_MAP),
        (None, true) => format!("one for each run, {} steps", args.learning.steps),
        (None, false) => format!("one for all runs, {} steps, seed {first}", args.learning.steps),
    };
    let head = facts([
        ("scenario", format!("{}: {} ({})", scenario.name, scenario.title, scenario.source)),
        ("runs", format!("{}, seeds {first} to {last}, scalar {scalar}", args.runs)),
        ("map", map),
        ("rates", String::from("in %, with Wilson's 95 % intervals")),
    ]);
    let mut rows = vec![vec![String::from("controller")]];
    rows[0].extend(columns.iter().map(|column| column.controller.name().to_owned()));
    let mut add = |name: &str, value: &dyn Fn(&SweepSummary) -> String| {
        let cells = columns.iter().map(|column| value(&column.summary));
        rows.push(core::iter::once(name.to_owned()).chain(cells).collect());
    };
    add("success", &|summary| rate(summary.success));
    add("goal reached", &|summary| rate(summary.reached));
    add("contact", &|summary| rate(summary.contact));
    add("time median s", &|summary| or_dash(summary.time_median_s, |time| format!("{time:.1}")));
    add("time 95th percentile s", &|summary| or_dash(summary.time_95_s, |time| format!("{time:.1}")));
    add("path median m", &|summary| or_dash(summary.way_median_m, |way| format!("{way:.2}")));
    add("worst checkpoint mm", &|summary| or_dash(summary.error_worst_m, millimetres));
    let wrote = if files.is_empty() { String::new() } else { format!("wrote {}\n", files.join(", ")) };
    let hash = facts([("sweep hash", sweep_hash(columns))]);
    format!("{head}\n{}\n{hash}{wrote}{}", table(&rows), verdict(args, columns))
}

/// Whether what was required has come true.
fn verdict(args: &RunArgs, columns: &[Column]) -> String {
    let Some(required) = args.require else { return String::new() };
    let short = |column: &&Column| column.summary.success.share() * 100.0 < f64::from(required);
    let short: Vec<_> = columns.iter().filter(short).map(|column| column.controller.name()).collect();
    if short.is_empty() {
        format!("ok: success in at least {required} % of the runs\n")
    } else {
        format!("FAILED: success in less than {required} % of the runs with {}\n", short.join(" and "))
    }
}

/// A rate with Wilson's interval.
fn rate(rate: Rate) -> String {
    let (low, high) = rate.wilson_95();
    format!("{} [{}, {}]", percent(rate.share()), percent(low), percent(high))
}

fn or_dash(value: Option<f64>, format: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| String::from("-"), format)
}

fn document(
    args: &RunArgs,
    scenario: &Scenario,
    scalar: &str,
    columns: &[Column],
    files: &[String],
) -> Value {
    let controller = |column: &Column| {
        let summary = &column.summary;
        json!({
            "controller": column.controller.name(),
            "summary": summary,
            "wilson_95": {
                "success": summary.success.wilson_95(),
                "reached": summary.reached.wilson_95(),
                "contact": summary.contact.wilson_95(),
            },
            "runs": column.results.iter().map(result_json).collect::<Vec<_>>(),
        })
    };
    json!({
        "scenario": scenario.name,
        "scalar": scalar,
        "seed": args.learning.seed,
        "runs": args.runs,
        "training": {
            "steps": (args.saved.map.is_none() && !is_peer(args)).then_some(args.learning.steps),
            "map": args.saved.map.as_ref().map(|path| path.display().to_string()),
            "fresh_maps": args.fresh_maps,
        },
        "controllers": columns.iter().map(controller).collect::<Vec<_>>(),
        "sweep_hash": sweep_hash(columns),
        "files": files,
    })
}
