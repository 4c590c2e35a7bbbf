//! `bench`: how fast the simulator is with the controller, on one core and with the contact test at every tick.
//!
//! A measurement, not a test: it fails on no machine for being slow.

use std::time::Instant;

use controller_core::scalar::Fixed;
use host_sim::contender::Contender;
use host_sim::map_store::StoredScalar;
use host_sim::mission::MissionOptions;
use host_sim::scenario::Scenario;
use host_sim::sil::Indirect;
use host_sim::sweep;
use serde_json::json;

use super::args::{BenchArgs, ScalarArg};
use super::bench_worlds;
use super::error::{CliError, Outcome};
use super::learning::{learn, seeds, settings, training_plan};
use super::output::{print, print_json};
use super::table::{facts, table};

const SCENARIO: &str = "p2_fig6";

/// Virtual time against real time.
struct Speed {
    what: String,
    virtual_s: f64,
    real_s: f64,
}

impl Speed {
    /// Measures work that returns its virtual time.
    fn of(what: String, work: impl FnOnce() -> Result<f64, CliError>) -> Result<Self, CliError> {
        let start = Instant::now();
        let virtual_s = work()?;
        Ok(Self { what, virtual_s, real_s: start.elapsed().as_secs_f64() })
    }

    fn factor(&self) -> f64 {
        self.virtual_s / self.real_s.max(f64::MIN_POSITIVE)
    }
}

pub fn bench(args: &BenchArgs) -> Result<Outcome, CliError> {
    if let Some(worlds) = &args.what {
        return bench_worlds::bench(worlds);
    }
    match args.learning.scalar() {
        ScalarArg::F32 => bench_in::<f32>(args),
        ScalarArg::Fixed => bench_in::<Fixed>(args),
    }
}

fn bench_in<S: StoredScalar>(args: &BenchArgs) -> Result<Outcome, CliError> {
    let settings = settings(&args.learning)?;
    let config = &settings.core;
    let scenario = Scenario::builtin(SCENARIO)?;
    let seeds = seeds(args.learning.seed, args.runs)?;
    let plan = training_plan(&args.learning);
    let mut map = None;
    let mut speeds = vec![Speed::of(String::from("training"), || {
        map = Some(learn::<S, Indirect<S>>(config, &plan)?.map);
        Ok(f64::from(plan.steps) * f64::from(config.schedule.step_ms) / 1000.0)
    })?];
    let map = map.unwrap_or_default();
    for controller in Contender::PAPERS {
        speeds.push(Speed::of(format!("{SCENARIO}, {}", controller.name()), || {
            let mut virtual_s = 0.0;
            for seed in seeds.clone() {
                let options = MissionOptions { seed, sample_ms: 0 };
                let run = sweep::run_one(&scenario, &settings, Some(controller), &map, options)?;
                virtual_s += run.duration_s;
            }
            Ok(virtual_s)
        })?);
    }
    if args.json {
        let speed = |speed: &Speed| {
            json!({
                "what": speed.what,
                "virtual_s": speed.virtual_s,
                "real_s": speed.real_s,
                "times_real_time": speed.factor(),
            })
        };
        print_json(&json!({ "scalar": S::NAME, "speeds": speeds.iter().map(speed).collect::<Vec<_>>() }))?;
    } else {
        print(&text(args, S::NAME, &speeds))?;
    }
    Ok(Outcome::Ok)
}

fn text(args: &BenchArgs, scalar: &str, speeds: &[Speed]) -> String {
    let head = facts([
        ("measured", format!("on one core, scalar {scalar}, servo and contact test every 1 ms")),
        ("missions", format!("{} for each controller", args.runs)),
    ]);
    let mut rows = vec![["", "virtual s", "real s", "× real time"].map(String::from).to_vec()];
    for speed in speeds {
        rows.push(vec![
            speed.what.clone(),
            format!("{:.1}", speed.virtual_s),
            format!("{:.3}", speed.real_s),
            format!("{:.0}", speed.factor()),
        ]);
    }
    format!("{head}\n{}", table(&rows))
}
