//! hil_stub
fn main() {}
