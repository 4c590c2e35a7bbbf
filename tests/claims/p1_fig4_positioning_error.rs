//! P1 Fig. 4: mean positioning error against training steps, indirect against direct mapping.
//!
//! * **Goal**: after training from scratch the robot stops at its targets, and indirect mapping gets there sooner
//!   than direct mapping.
//! * **Method**: P1, section 3.2. Training from an untrained map in an empty place under 10 % noise, one step being
//!   1.024 s. After 500, 1,000 and 2,000 steps, without training, 50 random targets in sequence: E = mean distance
//!   from the robot's centre to the target after it has stopped (or was given up after 60 steps). Five trials, each
//!   with a seed of its own for training, targets and noise; means over the trials.
//! * **Paper**: 3 mm (indirect) and 8 mm (direct) at 100,000 steps, stable from 50,000.
//! * **Ours**: `docs/numbers.md`. The robot stops itself within 1 mm, so E of a map that always gets there is just
//!   below 1 mm; what is beyond are targets at which it never stopped.
//! * **Tolerance**: the bar is 3 mm at 2,000 steps, P1's figure after a fiftieth of its training; what we measure is
//!   a third of it. Half of direct's error at 500 steps: what we measure is about a fifth, and a mean of five trials,
//!   of which one is usually unlucky, scatters by a factor of two. At 2,000 steps both maps stop within the stop rule
//!   in most trials, so there the claim is no more than "not worse".
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use controller_core::config::Config;
use controller_core::kohonen::output::Output;
use controller_core::scalar::Scalar;
use host_sim::positioning::summarise;
use host_sim::sil::Sil;
use host_sim::simulation::PAPERS;
use host_sim::training::{Training, TrainingPlan};
use host_sim::world::World;
use tests::for_each_scalar;
use tests::learning::{Direct, Indirect, positioning};
use tests::statistics::{largest, mean};

/// Seeds of the trials, apart from those that parameters are tuned on.
const TRIALS: core::ops::RangeInclusive<u64> = 101..=105;

/// Training steps at which a map is tested.
const TESTED_AT: [u32; 3] = [500, 1000, 2000];

/// The mean positioning error in mm of each trial, for each entry of [`TESTED_AT`].
fn errors_mm<S: Scalar, O: Output<S>>() -> [Vec<f64>; TESTED_AT.len()] {
    let world = World::default();
    let mut errors = [const { Vec::new() }; TESTED_AT.len()];
    for seed in TRIALS {
        let plan = TrainingPlan { seed, ..TrainingPlan::default() };
        let mut training = Training::<Sil<S, O>>::new(&Config::default(), plan, &PAPERS, &world).unwrap();
        let mut trained = 0;
        for (steps, errors) in TESTED_AT.into_iter().zip(&mut errors) {
            let Ok(()) = training.run(steps - trained);
            trained = steps;
            let summary = summarise(&positioning(training.controller().controller.map(), seed));
            errors.push(summary.mean_error_m * 1000.0);
        }
    }
    for (steps, errors) in TESTED_AT.iter().zip(&errors) {
        let mean = mean(errors);
        println!("{:5} {:8} {steps:4} steps: E = {mean:5.2} mm, trials {errors:.2?}", S::NAME, O::NAME);
    }
    errors
}

fn indirect_map_stops_within_3_mm_and_learns_sooner<S: Scalar>() {
    let [indirect_500, indirect_1000, indirect_2000] = errors_mm::<S, Indirect<S>>();
    let [direct_500, direct_1000, direct_2000] = errors_mm::<S, Direct<S>>();
    assert!(mean(&indirect_2000) <= 3.0, "the bar of 3 mm: {indirect_2000:?}");
    assert!(largest(&indirect_2000) <= 5.0, "one trial may be unlucky, not lost: {indirect_2000:?}");
    assert!(mean(&indirect_500) <= 0.5 * mean(&direct_500), "{indirect_500:?} against {direct_500:?}");
    assert!(mean(&indirect_1000) < mean(&direct_1000), "{indirect_1000:?} against {direct_1000:?}");
    assert!(mean(&indirect_2000) <= mean(&direct_2000), "{indirect_2000:?} against {direct_2000:?}");
}

for_each_scalar!(indirect_map_stops_within_3_mm_and_learns_sooner);
