//! What cooperative EKMs are compared with.
//!
//! * [`braitenberg`]: reactive obstacle avoidance of P1 (Eq. 9)
//!
//! The direct-mapping EKM is [`crate::kohonen::output::MotorVector`], and P1's command fusion stands beside neural
//! integration in [`crate::integration::command_fusion`].

pub mod braitenberg;
