//! A scan, whose its readings are, and what a disc of this robot's size would read in it.

use crate::scalar::Scalar;
use crate::sensing::proximity::{ProximityParameters, Scan, sensor_bearing};
use crate::units::{Polar, angle_between, wrap};

/// Neighbouring beams that read this many times as far leave an echo alone: a wall is seen by its neighbours at 1.15
/// times the distance, at most 1.4 with noise.
const ALONE_RATIO: f32 = 1.6;
/// Half the width of a beam, as a share of the bearing between two: beams cover half of the circle.
const BEAM_SHARE: f32 = 0.25;
/// What a bearing may err by beyond its sector (rad): others are not quite as large as this robot.
const SECTOR_SLACK_RAD: f32 = 0.03;
/// The standard deviation of a reading, as a share of it,
const NOISE_SHARE: f32 = 0.06;
/// and beyond that (m).
const NOISE_M: f32 = 0.002;
/// Beams farther aside of a track than this say nothing of it (rad).
const ASIDE_RAD: f32 = 0.9;
/// The likelihood of a reading that fits, where its standard deviation is a metre, against that of any reading; a
/// sensor reads something of 0 to 175 mm. An eighth of it, so that the product over some beams is a number.
const FITS_M: f32 = 0.07 / 8.0;
/// A beam that should see the mover reads something else,
const MISSED: f32 = 0.03 / 8.0;
/// or something that hides it,
const HIDDEN: f32 = 0.22 / 8.0;
/// or it would read nearly as far as it can.
const FAR: f32 = 0.5 / 8.0;
/// A beam that should not see it reads something as far away,
const OTHER: f32 = 0.5 / 8.0;
/// within so many standard deviations.
const OTHER_FITS: f32 = 2.0;
/// A beam that should not see it reads something else, or nothing.
const NOTHING: f32 = 1.0 / 8.0;
/// Expected farther than this, a reading may well be none (m).
const FAR_M: f32 = 0.165;
/// A reading fits within so many standard deviations.
pub(super) const FITS: f32 = 3.0;

/// Marks of sensors.
pub(super) type Marks<const SENSORS: usize> = [bool; SENSORS];

/// An echo of something that may be a body: nothing beside it is about as near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Echo<S> {
    /// Where its centre is, if it is as large as this robot.
    pub(super) centre: Polar<S>,
    /// Half the width of the sector that it may lie in (rad).
    pub(super) half_width_rad: S,
    /// What was read (m).
    pub(super) range_m: S,
    /// It is alone only since what is beside it is known to be something else.
    pub(super) is_beside: bool,
}

/// On which side of the sensor that sees a body best the next one sees it too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    None,
    Left,
    Right,
}

/// What a sensor should read, and how much it may differ (standard deviation, m).
#[derive(Clone, Copy, Debug)]
pub(super) struct Expected<S> {
    pub(super) range_m: S,
    deviation_m: S,
}

impl<S: Scalar> Expected<S> {
    fn new(range_m: S, doubt_m: S) -> Self {
        Self { range_m, deviation_m: S::hypot(noise_m(range_m), doubt_m) }
    }

    pub(super) fn fits(&self, range_m: S, deviations: f32) -> bool {
        (range_m - self.range_m).abs() < self.deviation_m * S::from_f32(deviations)
    }
}

/// A scan, and whose its readings are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight<'a, S, const SENSORS: usize> {
    pub(super) ring: &'a ProximityParameters<S>,
    scan: &'a Scan<S, SENSORS>,
    /// Readings of what is followed already: a reading is of one thing.
    taken: Marks<SENSORS>,
    /// Those of what is known well. They are no part of what is beside them.
    explained: Marks<SENSORS>,
}

impl<'a, S: Scalar, const SENSORS: usize> Sight<'a, S, SENSORS> {
    /// A scan of which nothing is known yet.
    pub(super) fn new(ring: &'a ProximityParameters<S>, scan: &'a Scan<S, SENSORS>) -> Self {
        Self { ring, scan, taken: [false; SENSORS], explained: [false; SENSORS] }
    }

    /// Whose some of the readings are is known.
    pub(super) fn take(&mut self, readings: &Marks<SENSORS>, is_known_well: bool) {
        for ((taken, explained), &is_of_it) in self.taken.iter_mut().zip(&mut self.explained).zip(readings) {
            *explained |= is_of_it && !*taken && is_known_well;
            *taken |= is_of_it;
        }
    }

    /// A reading of something near.
    fn range_m(&self, sensor: usize) -> Option<S> {
        self.ring.detected_m(self.scan.range_m.get(sensor).copied().flatten())
    }

    fn is_taken(&self, sensor: usize) -> bool {
        self.taken.get(sensor).copied().unwrap_or_default()
    }

    /// A reading that is of nothing followed so far.
    pub(super) fn free_range_m(&self, sensor: usize) -> Option<S> {
        self.range_m(sensor).filter(|_| !self.is_taken(sensor))
    }

    /// What a sensor reads of a disc that is so far away, aside of its bearing by `off`; `None` if it does not see it.
    /// `doubt_m` is what the distance may err by.
    pub(super) fn expected(&self, off: S, distance_m: S, doubt_m: S) -> Option<Expected<S>> {
        let outside = (off.abs() - half_beam::<S, SENSORS>()).max(S::ZERO);
        let radius = self.ring.body_radius_m;
        if outside > S::ONE {
            return None;
        }
        // The nearest of it within the beam: on the line of sight, or on the beam's edge.
        let (sin, cos) = outside.sin_cos();
        let aside = distance_m * sin;
        if aside >= radius {
            return None;
        }
        let half_chord = ((radius + aside) * (radius - aside)).sqrt();
        Some(Expected::new((distance_m * cos - half_chord - radius).max(S::ZERO), doubt_m))
    }

    /// The sensors that may say something of what is at a bearing.
    pub(super) fn sensors_near(bearing: S) -> impl Iterator<Item = (usize, S)> {
        let bearings = (0..SENSORS).map(|sensor| (sensor, sensor_bearing::<S>(sensor, SENSORS)));
        bearings.filter(move |(_, of)| angle_between(bearing, *of).abs() < S::from_f32(ASIDE_RAD))
    }

    /// How well a disc at `bearing` explains what the sensors near a bearing read.
    pub(super) fn likelihood(&self, near: S, bearing: S, distance_m: S, doubt_m: S) -> S {
        let unseen = Expected::new(distance_m - self.ring.body_radius_m - self.ring.body_radius_m, doubt_m);
        let of = |(sensor, at): (usize, S)| {
            let range_m = self.range_m(sensor);
            match (self.expected(angle_between(bearing, at), distance_m, doubt_m), range_m) {
                // What is known to be something else hides it, or is where it should be in front of.
                (Some(expected), Some(range)) if self.is_taken(sensor) => {
                    let is_behind = range < expected.range_m || expected.fits(range, OTHER_FITS);
                    S::from_f32(if is_behind { HIDDEN } else { MISSED })
                }
                (None, Some(_)) if self.is_taken(sensor) => S::from_f32(NOTHING),
                (Some(expected), Some(range)) if expected.fits(range, FITS) => {
                    let z = (range - expected.range_m) / expected.deviation_m;
                    let density = (z * z * S::HALF).exp_neg() * S::from_f32(FITS_M) / expected.deviation_m;
                    density.max(S::from_f32(MISSED))
                }
                (Some(expected), Some(range)) if range < expected.range_m => S::from_f32(HIDDEN),
                (Some(expected), _) if expected.range_m > S::from_f32(FAR_M) => S::from_f32(FAR),
                (Some(_), _) => S::from_f32(MISSED),
                (None, Some(range)) if unseen.fits(range, OTHER_FITS) => S::from_f32(OTHER),
                (None, _) => S::from_f32(NOTHING),
            }
        };
        Self::sensors_near(near).map(of).fold(S::ONE, |product, factor| product * factor)
    }

    /// What the sensor reads that is so many places to the left, if that may be of the same thing.
    fn beside(&self, sensor: usize, places: usize, but_explained: bool) -> Option<S> {
        let sensor = (sensor + places) % SENSORS.max(1);
        let is_else = but_explained && self.explained.get(sensor).copied().unwrap_or_default();
        self.range_m(sensor).filter(|_| !is_else)
    }

    /// Where nothing beside what a sensor reads is about as near but for one more beam that sees it: which.
    fn side(&self, sensor: usize, range_m: S, but_explained: bool) -> Option<Side> {
        let radius = self.ring.body_radius_m;
        let far = (radius + range_m) * S::from_f32(ALONE_RATIO);
        let is_far =
            |places| self.beside(sensor, places, but_explained).is_none_or(|range| radius + range > far);
        let (side, is_alone) = match (is_far(SENSORS - 1), is_far(1)) {
            (true, true) => (Side::None, true),
            (true, false) => (Side::Left, is_far(2)),
            (false, true) => (Side::Right, is_far(SENSORS - 2)),
            (false, false) => return None,
        };
        is_alone.then_some(side)
    }

    /// Whether what a sensor reads is alone, leaving out what is explained or not.
    pub(super) fn is_alone(&self, sensor: usize, range_m: S, but_explained: bool) -> bool {
        self.side(sensor, range_m, but_explained).is_some()
    }

    /// The echo of a sensor, if it is of nothing followed so far, reads less than its neighbours do and is alone.
    pub(super) fn echo(&self, sensor: usize) -> Option<Echo<S>> {
        let range_m = self.free_range_m(sensor)?;
        self.echo_but(sensor, range_m, false).or_else(|| self.echo_but(sensor, range_m, true))
    }

    fn echo_but(&self, sensor: usize, range_m: S, but_explained: bool) -> Option<Echo<S>> {
        // Of two alike the first is taken.
        let right = self.beside(sensor, SENSORS - 1, but_explained);
        let left = self.beside(sensor, 1, but_explained);
        if right.is_some_and(|right| right <= range_m) || left.is_some_and(|left| left < range_m) {
            return None;
        }
        let side = self.side(sensor, range_m, but_explained)?;
        let body_radius_m = self.ring.body_radius_m;
        let distance_m = body_radius_m + range_m + body_radius_m;
        let (spacing, beam) = (spacing::<S, SENSORS>(), half_beam::<S, SENSORS>());
        // How wide it looks: an arc sine, within 1 % for what does not touch.
        let sine = body_radius_m / distance_m;
        let width = sine + sine * sine * sine * S::from_f32(1.0 / 6.0);
        // Seen by both beams it lies between them, by one alone where the other does not reach.
        let (aside, half_width) = match side {
            Side::None => (S::ZERO, (spacing - beam - width).max(S::ZERO).min(beam + width)),
            Side::Left => (S::HALF, (width - beam).max(S::ZERO)),
            Side::Right => (-S::HALF, (width - beam).max(S::ZERO)),
        };
        Some(Echo {
            centre: Polar {
                bearing_rad: wrap(sensor_bearing::<S>(sensor, SENSORS) + spacing * aside),
                distance_m,
            },
            half_width_rad: half_width + S::from_f32(SECTOR_SLACK_RAD),
            range_m,
            is_beside: but_explained,
        })
    }
}

/// The standard deviation of a reading (m).
pub(super) fn noise_m<S: Scalar>(range_m: S) -> S {
    range_m * S::from_f32(NOISE_SHARE) + S::from_f32(NOISE_M)
}

/// Half the width of a beam (rad).
fn half_beam<S: Scalar, const SENSORS: usize>() -> S {
    spacing::<S, SENSORS>() * S::from_f32(BEAM_SHARE)
}

/// The bearing between two beams (rad).
fn spacing<S: Scalar, const SENSORS: usize>() -> S {
    S::TAU / S::from_i32(i32::try_from(SENSORS).unwrap_or(1))
}
