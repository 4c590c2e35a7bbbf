//! The ring of directed long-range sensors: sensor j looks along a fixed bearing `α_j` and measures a distance.
//!
//! ```text
//!           0  ahead              sensor j looks along j · 360° / SENSORS,
//!       1       11                anticlockwise from the heading; readings
//!    2     ( )     10             are ranges beyond the body, so that
//!    3     ( )      9             d_j = body radius + range
//!    4     ( )      8
//!       5       7
//!           6  behind
//! ```

use heapless::Vec;

use crate::list::first;
use crate::scalar::Scalar;
use crate::units::{Polar, wrap};

/// One scan: the range beyond the body that each sensor reads; `None` where it sees nothing within its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scan<S, const SENSORS: usize> {
    /// Range beyond the body, in metres, per sensor.
    pub range_m: [Option<S>; SENSORS],
}

impl<S, const SENSORS: usize> Scan<S, SENSORS> {
    /// A scan that sees nothing.
    pub const EMPTY: Self = Self { range_m: [const { None }; SENSORS] };
}

impl<S, const SENSORS: usize> Default for Scan<S, SENSORS> {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// Where the sensors sit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProximityParameters<S> {
    /// Body radius, from the robot's centre to the sensors (m).
    pub body_radius_m: S,
    /// Largest range beyond the body (m); a longer reading counts as nothing seen.
    pub range_m: S,
}

impl<S: Scalar> ProximityParameters<S> {
    /// What a sensor detects: nothing at its largest range and beyond; a reading that is not a number is ignored, a
    /// negative one counts as zero.
    #[inline]
    #[must_use]
    pub fn detected_m(&self, range_m: Option<S>) -> Option<S> {
        Some(range_m.filter(|range| *range < self.range_m)?.max(S::ZERO))
    }
}

/// The bearing `α_j` of sensor j, in [−π, π).
#[must_use]
pub fn sensor_bearing<S: Scalar>(sensor: usize, sensors: usize) -> S {
    let count = |i: usize| S::from_i32(i32::try_from(i).unwrap_or(0));
    // Multiply first: TAU / 12 would round once and the error would grow with j.
    wrap(S::TAU * count(sensor) / count(sensors.max(1)))
}

/// What the sensors detect: `u_j = (α_j, d_j)` for every sensor that sees something.
#[must_use]
pub fn detections<S: Scalar, const SENSORS: usize>(
    parameters: &ProximityParameters<S>,
    scan: &Scan<S, SENSORS>,
) -> Vec<Polar<S>, SENSORS> {
    first(scan.range_m.iter().enumerate().filter_map(|(sensor, range)| {
        Some(Polar {
            distance_m: parameters.body_radius_m + parameters.detected_m(*range)?,
            bearing_rad: sensor_bearing(sensor, SENSORS),
        })
    }))
}

#[cfg(test)]
mod tests {
    use super::{ProximityParameters, Scan, detections, sensor_bearing};
    use crate::scalar::{Fixed, Scalar};

    fn check<S: Scalar>() {
        let s = S::from_f32;
        let parameters = ProximityParameters { body_radius_m: s(0.025), range_m: s(0.175) };
        let mut scan = Scan::<S, 12>::EMPTY;
        assert!(detections(&parameters, &scan).is_empty());
        scan.range_m[3] = Some(s(0.05));
        scan.range_m[9] = Some(s(-1.0));
        scan.range_m[0] = Some(s(0.175));
        let seen = detections(&parameters, &scan);
        assert_eq!(seen.len(), 2, "a reading at full range sees nothing");
        assert!((seen[0].bearing_rad.to_f32() - core::f32::consts::FRAC_PI_2).abs() < 1e-5);
        assert!((seen[0].distance_m.to_f32() - 0.075).abs() < 1e-5);
        assert!((seen[1].bearing_rad.to_f32() + core::f32::consts::FRAC_PI_2).abs() < 1e-5);
        assert!((seen[1].distance_m.to_f32() - 0.025).abs() < 1e-5);
        assert!((sensor_bearing::<S>(11, 12).to_f32() + core::f32::consts::PI / 6.0).abs() < 1e-5);
    }

    #[test]
    fn readings_become_places_beside_the_body() {
        check::<f32>();
        check::<Fixed>();
    }
}
