//! The controller core of ekm-nav: integrated planning and control with cooperative Extended Kohonen Maps.
#![no_std]

pub mod scalar;

pub mod units;

pub mod planning;
