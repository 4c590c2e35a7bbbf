//! P2 Fig. 6, the main job: three rooms, planner, unforeseen convex and concave obstacles.
//!
//! * **Goal**: cooperative EKMs reach all three checkpoints; command fusion, with the same checkpoints, does not.
//! * **Method**: 40 runs under 10 % noise on sensors and actuators, each from a start of its own and with a map that it
//!   learnt from scratch; success means every checkpoint within 5 mm, in time, without contact.
//! * **Paper**: a picture of one run; no rate.
//! * **Ours**: `docs/numbers.md`, over 100 runs.
//! * **Tolerance**: below the rate over 100 runs by what 40 runs scatter.

use controller_core::config::Architecture;
use controller_core::scalar::Scalar;
use tests::for_each_scalar;
use tests::missions::success_percent;

fn cooperative_ekms_succeed<S: Scalar>() {
    let success = success_percent::<S>("p2_fig6", Architecture::Cooperative, 40);
    assert!(success >= 95.0, "{success} %");
}

fn command_fusion_is_trapped<S: Scalar>() {
    let success = success_percent::<S>("p2_fig6", Architecture::Fusion, 40);
    assert!(success <= 25.0, "{success} %");
}

for_each_scalar!(cooperative_ekms_succeed, command_fusion_is_trapped);
