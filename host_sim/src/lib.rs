//! The host side of ekm-nav: the world the simulated Khepera drives in, and the experiments of both papers.
//!
//! ```text
//! scenario (TOML) ──► world ──► what the sensors see, what the body touches
//!        │              └─────► what the planner knows (raster)
//!        └──► figure (SVG): world, checkpoints, paths
//! ```
//!
//! Frame: x to the right, y up, angles anticlockwise from +x, metres, radians, seconds from the start of the run.
//! Transcendental functions come from `libm`, so that a run gives the same bits on every platform.
#![forbid(unsafe_code)]

pub mod geometry;

pub mod beam;

pub mod solids;

pub mod mover;

pub mod world;

pub mod scenario;

pub mod scenes;

pub mod raster;

pub mod benchmark;
pub mod import;

pub mod figure;

pub mod number;

pub mod random;

pub mod khepera;

pub mod proximity_model;

pub mod self_calibration;
pub mod sil;

pub mod link;

pub mod simulation;

pub mod training;

pub mod positioning;

pub mod arc;

pub mod lateness;
pub mod learning_curve;
pub mod limits;

pub mod route_planner;

pub mod mission;

pub mod explanation;

pub mod fleet;

pub mod statistics;

pub mod sweep;

pub mod evaluation;

pub mod questions;

pub mod search;
pub mod tuning;

pub mod map_store;

pub mod map_report;

pub mod run_log;

pub mod config_file;

pub mod contender;

pub mod peers;

pub mod settings;
