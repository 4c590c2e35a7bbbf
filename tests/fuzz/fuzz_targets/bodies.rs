//! Any input to `wire::any_bodies`, which says what must hold.
#![no_main]

// By its file, not through the crate it belongs to: that one also has the simulator, and would take minutes to build.
#[path = "../../src/wire.rs"]
#[allow(dead_code, reason = "each target uses its part")]
mod wire;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| wire::any_bodies(bytes));
