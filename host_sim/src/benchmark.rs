//! Worlds that others drew, driven by their rules: with the planner, which knows the world, and without.
//!
//! A [`Course`] is a world with a start and a goal and all that its runs share: the planner's map, the route, the time
//! that is allowed. [`run()`] drives it once and ends it by the benchmark's rule, not by the controller's: as soon as
//! the centre is near enough to the goal, at the first contact, or when the time is over.
//!
//! # Score
//! BARN's (Perille et al. 2020; the challenge's rule of 2024). With OT = length of the shortest way / c*, a run that
//! took AT scores OT / clip(AT, 2 OT, 8 OT) if it reached the goal without contact, else nothing: at most 0.5.

mod course;
mod ground;
mod pilot;
mod run;
mod tally;

pub use course::{Course, MARGINS_M, PlannedRoute, PlannerMap};
pub use ground::Ground;
pub use pilot::{Following, Pilot};
pub use run::{CourseRun, End, RunOptions, config_for, run};
pub use tally::{GAP_CLASSES, Tally, gap_class};
