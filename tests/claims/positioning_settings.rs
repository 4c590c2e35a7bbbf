//! P1, section 3.2, in the settings that the program has built in: how precise is positioning where we do our best,
//! where speeds have units as in the paper, and with a robot of another size?
//!
//! * **Goal**: an order of magnitude better than the paper with continuous speeds, better in the paper's own setting.
//! * **Method**: as P1 Fig. 4, after 2,000 steps from nothing; five trials with seeds of their own.
//! * **Paper**: 3 mm at 100,000 steps.
//! * **Ours**: `docs/numbers.md`.
//! * **Tolerance**: `precise` 0.3 mm, no trial above 0.7 mm, 99 % of the targets approached to 1 mm, at most 1 % at
//!   which it never stopped; `p1` 2 mm. What fixed point may be worse by is a fifth. The time to a target is that of
//!   the exact inverse within 5 %: over forty trials it is within 3 %, and five scatter by more than a percent.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::path::Path;

use controller_core::config::Config;
use controller_core::scalar::{Fixed, Scalar};
use host_sim::config_file;
use host_sim::learning_curve::analytic_test;
use host_sim::positioning::{PositioningPlan, TargetResult, positioning_test, summarise};
use host_sim::simulation::PAPERS;
use tests::for_each_scalar;
use tests::learning::{Indirect, STEPS, trained_under};
use tests::statistics::{largest, mean};

const TRIALS: core::ops::RangeInclusive<u64> = 401..=405;

fn setting(name: &str) -> Config {
    config_file::load(Path::new(name)).unwrap().core
}

/// E of each trial in mm, and all results.
fn trials<S: Scalar>(name: &str) -> (Vec<f64>, Vec<TargetResult>) {
    let config = setting(name);
    let (mut errors_mm, mut all) = (Vec::new(), Vec::new());
    for seed in TRIALS {
        let map = trained_under::<S, Indirect<S>>(&config, &PAPERS, seed, STEPS);
        let plan = PositioningPlan { seed, ..PositioningPlan::default() };
        let results = positioning_test(&config, &map, &plan, &PAPERS).unwrap();
        errors_mm.push(summarise(&results).mean_error_m * 1000.0);
        all.extend(results);
    }
    println!("{name} {}: {errors_mm:.3?} mm, {:?}", S::NAME, summarise(&all));
    (errors_mm, all)
}

fn the_most_precise_setting_is_ten_times_better_than_the_paper<S: Scalar>() {
    let (errors_mm, results) = trials::<S>("precise");
    let summary = summarise(&results);
    assert!(mean(&errors_mm) <= 0.3 && largest(&errors_mm) <= 0.7, "{errors_mm:?}");
    assert!(summary.within_1_mm >= 0.99 && summary.never_stopped <= 0.01, "{summary:?}");
    let exact = TRIALS.flat_map(|seed| {
        analytic_test(&setting("precise"), &PositioningPlan { seed, ..PositioningPlan::default() })
    });
    let exact = summarise(&exact.collect::<Vec<_>>());
    let ratio = summary.steps_per_metre / exact.steps_per_metre;
    println!("{} T(25 mm): {ratio:.3} of the exact inverse's", S::NAME);
    assert!(ratio <= 1.05, "{summary:?} against {exact:?}");
}

fn in_its_own_setting_the_paper_is_beaten<S: Scalar>() {
    let (errors_mm, results) = trials::<S>("p1");
    let summary = summarise(&results);
    assert!(mean(&errors_mm) <= 2.0, "{errors_mm:?}");
    assert!(summary.never_stopped <= 0.03, "{summary:?}");
}

fn a_robot_of_another_size_learns_from_nothing<S: Scalar>() {
    let (errors_mm, _) = trials::<S>("large");
    assert!(mean(&errors_mm) <= 0.3 && largest(&errors_mm) <= 0.7, "{errors_mm:?}");
}

#[test]
fn sixteen_bits_cost_no_more_than_a_fifth() {
    for name in ["precise", "p1"] {
        let (float, fixed) = (mean(&trials::<f32>(name).0), mean(&trials::<Fixed>(name).0));
        assert!(fixed <= 1.2 * float, "{name}: {fixed} against {float}");
    }
}

for_each_scalar!(
    the_most_precise_setting_is_ten_times_better_than_the_paper,
    in_its_own_setting_the_paper_is_beaten,
    a_robot_of_another_size_learns_from_nothing,
);
