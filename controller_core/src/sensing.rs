//! Sensing: raw readings become what the maps understand.
//!
//! * [`proximity`]: a ring of range readings becomes obstacle places `u_j` (P2, section II-C)
//! * [`odometry`]: encoder counts and pose fixes become the pose, and from it `u_p` and `v`

pub mod proximity;

pub mod odometry;

#[cfg(test)]
mod tests;
