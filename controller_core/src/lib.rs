//! The controller core of ekm-nav: integrated planning and control with cooperative Extended Kohonen Maps.
#![no_std]
#![forbid(unsafe_code)]

pub mod scalar;

pub mod units;

pub mod config;

pub mod schedule;

pub mod planning;

pub mod sensing;

pub mod kohonen;

pub mod localisation;

pub mod integration;

pub mod motor_control;

pub mod baseline;

pub mod servo;

pub mod safety;

pub mod state_hash;

pub mod reflex;

pub mod deliberation;

pub mod controller;

mod list;

#[cfg(test)]
mod testing;
