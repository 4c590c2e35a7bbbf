//! What the ring has read of late, and from where: something stood at a place before a mover could have come there.

use crate::scalar::Scalar;
use crate::sensing::proximity::{ProximityParameters, Scan, sensor_bearing};
use crate::units::{Point, Pose, angle_between};

/// Scans that are kept for each track, so that a controller without tracks keeps none.
const PER_TRACK: usize = 3;
/// What is younger than this (s) may be of the mover itself, as it came.
const SINCE_S: f32 = 0.89;
/// A reading is of a place that it misses by no more than this (m),
const NEAR_M: f32 = 0.01;
/// and so much of its distance from the robot's centre.
const NEAR_SHARE: f32 = 0.06;
/// Added to a reading, so that zero stands for none (m).
const READ_M: i32 = 1;

/// A scan, with the bits of weights, and where it was made.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Old<S: Scalar, const SENSORS: usize> {
    pose: Pose<S>,
    range_m: [S::Weight; SENSORS],
}

impl<S: Scalar, const SENSORS: usize> Old<S, SENSORS> {
    /// Nothing has been read.
    const NONE: Self = Self {
        pose: Pose { x_m: S::ZERO, y_m: S::ZERO, heading_rad: S::ZERO },
        range_m: [S::WEIGHT_ZERO; SENSORS],
    };

    fn new(ring: &ProximityParameters<S>, scan: &Scan<S, SENSORS>, pose: Pose<S>) -> Self {
        let range_m = scan.range_m.map(|range| {
            let range = ring.detected_m(range);
            range.map_or(S::WEIGHT_ZERO, |range| (range + S::from_i32(READ_M)).to_weight())
        });
        Self { pose, range_m }
    }

    /// Whether a sensor has seen something at a place.
    fn has_seen(&self, ring: &ProximityParameters<S>, at: Point<S>) -> bool {
        let place = self.pose.see(at);
        let half_spacing = S::PI / S::from_i32(i32::try_from(SENSORS).unwrap_or(1));
        self.range_m.iter().enumerate().any(|(sensor, &range)| {
            let range_m = S::from_weight(range) - S::from_i32(READ_M);
            if range_m < S::ZERO {
                return false;
            }
            let off = angle_between(place.bearing_rad, sensor_bearing(sensor, SENSORS));
            let distance_m = ring.body_radius_m + range_m;
            let miss = S::hypot(place.distance_m - distance_m, place.distance_m * off);
            off.abs() <= half_spacing && miss < S::from_f32(NEAR_M) + distance_m * S::from_f32(NEAR_SHARE)
        })
    }
}

/// The last scans, three for each track; the youngest first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Past<S: Scalar, const SENSORS: usize, const TRACKS: usize> {
    scans: [[Old<S, SENSORS>; PER_TRACK]; TRACKS],
}

impl<S: Scalar, const SENSORS: usize, const TRACKS: usize> Past<S, SENSORS, TRACKS> {
    /// Nothing has been read.
    pub(super) const NONE: Self = Self { scans: [[Old::NONE; PER_TRACK]; TRACKS] };

    /// Keeps a scan; the oldest goes.
    pub(super) fn keep(&mut self, ring: &ProximityParameters<S>, scan: &Scan<S, SENSORS>, pose: Pose<S>) {
        let scans = self.scans.as_flattened_mut();
        if let Some(oldest) = scans.last_mut() {
            *oldest = Old::new(ring, scan, pose);
            scans.rotate_right(1);
        }
    }

    /// How many scans, the last of them made a period of `period_s` ago, have seen something at a place before a mover
    /// that is there now could have been there.
    pub(super) fn has_seen(&self, ring: &ProximityParameters<S>, at: Point<S>, period_s: S) -> usize {
        let mut age_s = S::ZERO;
        let mut seen = 0;
        for old in self.scans.as_flattened() {
            age_s += period_s;
            seen += usize::from(age_s > S::from_f32(SINCE_S) && old.has_seen(ring, at));
        }
        seen
    }

    /// Keeps nothing any more.
    pub(super) fn clear(&mut self) {
        *self = Self::NONE;
    }
}

#[cfg(test)]
mod tests {
    use super::{PER_TRACK, Past};
    use crate::scalar::{Fixed, Scalar};
    use crate::sensing::proximity::{ProximityParameters, Scan};
    use crate::units::{Point, Pose};

    const TRACKS: usize = 6;

    fn check<S: Scalar>() {
        let s = S::from_f32;
        let ring = ProximityParameters { body_radius_m: s(0.025), range_m: s(0.175) };
        let mut scan = Scan::<S, 12>::EMPTY;
        // 10 cm ahead of a robot that looks along y.
        scan.range_m[0] = Some(s(0.075));
        let pose = Pose { x_m: S::ONE, y_m: S::ZERO, heading_rad: s(core::f32::consts::FRAC_PI_2) };
        let (there, beside) = (Point { x_m: S::ONE, y_m: s(0.1) }, Point { x_m: S::ONE, y_m: s(0.15) });
        let mut past = Past::<S, 12, TRACKS>::NONE;
        let seen = |past: &Past<S, 12, TRACKS>, at| past.has_seen(&ring, at, s(0.128));
        for scans in 1..=40 {
            past.keep(&ring, &scan, pose);
            // Six scans of 128 ms are too young, and only so many are kept.
            let old = scans.min(PER_TRACK * TRACKS).saturating_sub(6);
            assert_eq!(seen(&past, there), old, "{}: {scans}", S::NAME);
            assert_eq!(seen(&past, beside), 0, "{}: {scans}", S::NAME);
        }
        for _ in 0..PER_TRACK * TRACKS {
            past.keep(&ring, &Scan::EMPTY, pose);
        }
        assert_eq!(seen(&past, there), 0, "it has gone");
        past.clear();
        assert_eq!(past, Past::NONE);
    }

    #[test]
    fn what_stood_long_ago_is_known_for_a_while() {
        check::<f32>();
        check::<Fixed>();
    }
}
