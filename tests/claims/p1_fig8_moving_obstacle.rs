//! P1 Fig. 8: three rooms, and a robot that circles anticlockwise in the middle one.
//!
//! * **Goal**: pass it without contact.
//! * **Method**: 20 runs under 10 % noise on sensors and actuators, each from a start of its own and with a map that it
//!   learnt from scratch; success means every checkpoint within 5 mm, in time, without contact.
//! * **Paper**: a picture of one run, with command fusion; no rate.
//! * **Ours**: `docs/numbers.md`, over 100 runs.
//! * **Tolerance**: below the rate over 100 runs by what 20 runs scatter.

use controller_core::config::Architecture;
use controller_core::scalar::Scalar;
use tests::for_each_scalar;
use tests::missions::success_percent;

fn cooperative_ekms_succeed<S: Scalar>() {
    let success = success_percent::<S>("p1_fig8", Architecture::Cooperative, 20);
    assert!(success >= 90.0, "{success} %");
}

fn command_fusion_succeeds<S: Scalar>() {
    let success = success_percent::<S>("p1_fig8", Architecture::Fusion, 20);
    assert!(success >= 80.0, "{success} %");
}

for_each_scalar!(cooperative_ekms_succeed, command_fusion_succeeds);
