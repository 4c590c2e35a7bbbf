//! host_sim
fn main() {}
