//! P2 Fig. 7: three rooms, two circling robots, no planner.
//!
//! * **Goal**: a purely reactive robot reaches the goal room.
//! * **Method**: 20 runs under 10 % noise on sensors and actuators, each from a start of its own and with a map that it
//!   learnt from scratch; success means every checkpoint within 5 mm, in time, without contact.
//! * **Paper**: a picture of one run; no rate.
//! * **Ours**: `docs/numbers.md`, over 100 runs.
//!   What is missing is contact: a circling robot drives into ours more often than it should.
//! * **Tolerance**: below the rate over 100 runs by what 20 runs scatter.

use controller_core::config::Architecture;
use controller_core::scalar::Scalar;
use tests::for_each_scalar;
use tests::missions::success_percent;

fn cooperative_ekms_succeed<S: Scalar>() {
    let success = success_percent::<S>("p2_fig7", Architecture::Cooperative, 20);
    assert!(success >= 90.0, "{success} %");
}

for_each_scalar!(cooperative_ekms_succeed);
