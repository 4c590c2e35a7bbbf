//! The log of a run as CSV and as a path for figures.

use core::fmt::Write;

use nalgebra::Point2;

use crate::figure::{PathTrace, TracePose};
use crate::mission::{MissionResult, Sample};
use crate::scenario::Scenario;

/// Head of the CSV file; units are part of the names.
const COLUMNS: &str = "t_s,x_m,y_m,heading_rad,left_mps,right_mps,checkpoint,contacts";

/// The log as CSV. Numbers have the decimals that mean something (1 µm, 10 µrad), so that two logs can be compared.
#[must_use]
pub fn csv(samples: &[Sample]) -> String {
    let mut text = format!("{COLUMNS}\n");
    for s in samples {
        // Writing to a `String` cannot fail.
        let _ = writeln!(
            text,
            "{:.3},{:.6},{:.6},{:.5},{:.5},{:.5},{},{}",
            s.t_s, s.x_m, s.y_m, s.heading_rad, s.left_mps, s.right_mps, s.checkpoint, s.contacts
        );
    }
    text
}

/// The way driven, to be drawn.
#[must_use]
pub fn trace(label: &str, samples: &[Sample]) -> PathTrace {
    let pose = |s: &Sample| TracePose {
        t_s: s.t_s,
        position: Point2::new(s.x_m, s.y_m),
        heading_rad: s.heading_rad,
    };
    PathTrace { label: label.to_owned(), poses: samples.iter().map(pose).collect() }
}

/// The run as a picture: the world, the checkpoints it had in the end, and the way.
#[must_use]
pub fn figure(scenario: &Scenario, label: &str, result: &MissionResult) -> String {
    let checkpoints = result.checkpoints.iter().map(|&(x, y)| Point2::new(x, y)).collect();
    let scenario = scenario.clone().with_checkpoints(checkpoints);
    crate::figure::draw_run(&scenario, &[trace(label, &result.samples)])
}

#[cfg(test)]
mod tests {
    use super::csv;
    use crate::mission::Sample;

    #[test]
    fn a_log_has_a_head_and_as_many_fields_in_each_line() {
        let sample = Sample {
            t_s: 0.128,
            x_m: 0.07,
            y_m: -0.063,
            heading_rad: -core::f64::consts::FRAC_PI_4,
            left_mps: 0.16,
            right_mps: 0.0,
            checkpoint: 2,
            contacts: 0,
        };
        let text = csv(&[sample]);
        let (head, line) = text.trim_end().split_once('\n').unwrap();
        assert_eq!(line, "0.128,0.070000,-0.063000,-0.78540,0.16000,0.00000,2,0");
        assert_eq!(head.split(',').count(), line.split(',').count());
    }
}
