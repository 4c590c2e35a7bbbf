//! Bar: the whole controller fits a small microcontroller.
//!
//! * **Goal**: 15 × 15 neurons and 12 sensors, learning included, within 12 KiB (`f32`) and 6 KiB (fixed point).
//! * **Method**: `size_of` of the controller (map, fields, memory, detour, checkpoints, odometry, servo, the training
//!   step under way) and of its parameters (schedules of learning included). There is no heap and no other static
//!   state; the stack is measured on the target.
//! * **Ours**: printed; the targets' own sizes are held at compile time in the crate `firmware`.
//! * **Tolerance**: none for the bar; the ratchet of [`tests::budgets`] stands a little above the present size.

use controller_core::config::Parameters;
use controller_core::controller::{Controller, Inputs, Outputs};
use controller_core::kohonen::map::Map;
use controller_core::kohonen::output::ControlMatrix;
use controller_core::scalar::{Fixed, Scalar};
use tests::budgets::{MEMORY_F32, MEMORY_FIXED, MemoryBudget};

/// Controller and parameters in bytes.
fn size_of_all<S: Scalar>() -> usize {
    let controller = size_of::<Controller<S, ControlMatrix<S::Weight>, 15, 15, 12>>();
    let parameters = size_of::<Parameters<S, 12>>();
    let map = size_of::<Map<S, ControlMatrix<S::Weight>, 15, 15>>();
    let name = S::NAME;
    println!("{name}: controller {controller} B (of which map {map} B), parameters {parameters} B");
    println!("{name}: inputs {} B, outputs {} B", size_of::<Inputs<S, 12>>(), size_of::<Outputs<S>>());
    println!("{name}: together {} B", controller + parameters);
    controller + parameters
}

fn check(size: usize, budget: MemoryBudget, name: &str) {
    assert!(size <= budget.bar, "{size} B are more than the promise of {} B", budget.bar);
    assert!(
        size <= budget.ratchet,
        "{size} B passed the ratchet of {} B: if the controller was meant to grow, raise {name} in \
         tests/src/budgets.rs in a commit that says what the bytes are for",
        budget.ratchet
    );
    let slack = budget.ratchet - size;
    assert!(
        slack <= 512,
        "{slack} B below the ratchet: lower {name} in tests/src/budgets.rs to keep what was won"
    );
}

#[test]
fn f32_controller_fits_12_kib() {
    check(size_of_all::<f32>(), MEMORY_F32, "MEMORY_F32");
}

#[test]
fn fixed_controller_fits_6_kib() {
    check(size_of_all::<Fixed>(), MEMORY_FIXED, "MEMORY_FIXED");
}
