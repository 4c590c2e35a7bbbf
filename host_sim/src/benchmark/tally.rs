//! The figures of many runs.

use serde::Serialize;

use super::run::{CourseRun, End};
use crate::statistics::{Rate, quantile};
use crate::world::KHEPERA_RADIUS_M;

/// Upper ends of the classes of worlds, by their tightest gap in body diameters; the last class is open.
pub const GAP_CLASSES: [f64; 5] = [1.5, 2.0, 2.5, 3.0, 4.0];

/// The class of a world by its tightest gap: how many of [`GAP_CLASSES`] it reaches.
#[must_use]
pub fn gap_class(gap_m: f64) -> usize {
    let diameters = gap_m / (2.0 * KHEPERA_RADIUS_M);
    GAP_CLASSES.iter().filter(|end| diameters >= **end).count()
}

/// What became of runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tally {
    /// Goal reached in time and without contact.
    pub success: Rate,
    /// Ended by a contact.
    pub contact: Rate,
    /// Ended by the time limit.
    pub timeout: Rate,
    /// Not begun, for there is no route.
    pub no_route: Rate,
    /// Mean score over all runs.
    pub score: f64,
    /// Median of AT / OT over the successes.
    pub time_share_median: Option<f64>,
}

impl Tally {
    /// Of these runs.
    #[must_use]
    pub fn of(runs: &[&CourseRun]) -> Self {
        let rate = |end: End| Rate::of(runs.iter().map(|run| run.end == end));
        let success = rate(End::Goal);
        let shares: Vec<f64> =
            runs.iter().filter(|run| run.end == End::Goal).map(|run| run.time_share).collect();
        let score = runs.iter().map(|run| run.score).sum::<f64>() / f64::from(success.runs.max(1));
        Self {
            success,
            contact: rate(End::Contact),
            timeout: rate(End::Timeout),
            no_route: rate(End::NoRoute),
            score,
            time_share_median: quantile(&shares, 0.5),
        }
    }
}
