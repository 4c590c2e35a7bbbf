//! Success rates of the papers' figures: the same sweep for each claim.

use controller_core::config::Architecture;
use controller_core::scalar::Scalar;
use host_sim::mission::MissionResult;
use host_sim::scenario::Scenario;
use host_sim::settings::Settings;
use host_sim::statistics::Rate;
use host_sim::sweep::{Maps, SweepPlan, learn_each, run_all, summarise};
use host_sim::training::TrainingPlan;

use crate::learning::{Indirect, STEPS};

/// Seeds that no parameter was tuned on; each learns a map of its own.
const FIRST_SEED: u64 = 9001;

/// Runs a built-in scenario `runs` times as the simulator does by default, each with a map learnt from scratch under
/// noise.
///
/// # Panics
/// If there is no such scenario, or a run cannot begin.
#[must_use]
pub fn sweep<S: Scalar>(scenario: &str, architecture: Architecture, runs: u64) -> Vec<MissionResult> {
    let seeds = FIRST_SEED..FIRST_SEED + runs;
    let scenario = Scenario::builtin(scenario).expect("the scenario is built in");
    let settings = Settings::default();
    let plan = TrainingPlan { steps: STEPS, ..TrainingPlan::default() };
    let learned = learn_each::<S, Indirect<S>>(&settings.core, &plan, seeds.clone(), &|| ());
    let learned = learned.expect("the default is valid");
    let maps = Maps::PerRun(learned.into_iter().map(|learned| learned.map).collect());
    let plan = SweepPlan { seeds, logged: 0 };
    run_all(&scenario, &settings, Some(architecture.into()), &maps, &plan, &|| ()).expect("every run begins")
}

/// Success rate in percent, printed with its interval and the contacts.
#[must_use]
pub fn success_percent<S: Scalar>(scenario: &str, architecture: Architecture, runs: u64) -> f64 {
    let summary = summarise(&sweep::<S>(scenario, architecture, runs));
    let percent = |rate: Rate| {
        let (low, high) = rate.wilson_95();
        format!("{:.0} % [{:.0}, {:.0}]", 100.0 * rate.share(), 100.0 * low, 100.0 * high)
    };
    println!(
        "{scenario}, {architecture:?}, {}: success {}, contact {}",
        S::NAME,
        percent(summary.success),
        percent(summary.contact)
    );
    100.0 * summary.success.share()
}
