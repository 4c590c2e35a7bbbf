//! P2 Fig. 4: an unforeseen concave obstacle between robot and target.
//!
//! * **Goal**: cooperative EKMs get out and reach the goal, command fusion is trapped.
//! * **Method**: 20 runs under 10 % noise on sensors and actuators, each from a start of its own and with a map that it
//!   learnt from scratch; success means every checkpoint within 5 mm, in time, without contact.
//! * **Paper**: pictures of one run each; no rate.
//! * **Ours**: `docs/numbers.md`, over 100 runs.
//! * **Tolerance**: below the rate over 100 runs by what 20 runs scatter.

use controller_core::config::Architecture;
use controller_core::scalar::Scalar;
use tests::for_each_scalar;
use tests::missions::success_percent;

fn cooperative_ekms_succeed<S: Scalar>() {
    let success = success_percent::<S>("p2_fig4", Architecture::Cooperative, 20);
    assert!(success >= 90.0, "{success} %");
}

fn command_fusion_is_trapped<S: Scalar>() {
    let success = success_percent::<S>("p2_fig4", Architecture::Fusion, 20);
    assert!(success <= 25.0, "{success} %");
}

for_each_scalar!(cooperative_ekms_succeed, command_fusion_is_trapped);
