//! Something that is followed from scan to scan, and whether it moves.

use super::belief::Belief;
use super::sight::{Echo, Expected, FITS, Marks, Sight, noise_m};
use super::{Mover, MoverParameters};
use crate::scalar::Scalar;
use crate::units::{Point, Polar, Pose, angle_between, wrap};

/// Places across the line of sight that are weighed, to either side, and the standard deviations between two of them.
const PLACES: i32 = 8;
/// See [`PLACES`].
const APART: f32 = 0.3125;
/// Less likely than this, and a scan says nothing of a track.
const LIKELY: f32 = 1e-5;
/// A reading is of the mover, and no sign of something new, within so many standard deviations.
const TAKEN: f32 = 2.4;
/// Nearer than this share of the body's radius, a body fills more than two beams, and its echo is no longer alone.
const CLOSE_RADII: f32 = 3.5;
/// So many scans, and an echo that is not alone is still believed to be its own where it is close.
const SEEN_CLOSE: u8 = 4;
/// So many, and it is known well: its readings explain why an echo beside them is not alone.
const SEEN_WELL: u8 = 6;
/// More than this is not counted, so that a track which turns out to be of a wall is soon forgotten.
const SEEN_MAX: u8 = 12;
/// A track without an echo is kept for so many scans.
const MISSED_MAX: u8 = 5;
/// No more scans than this that saw it beside something else are counted,
const BESIDE_MAX: u8 = 8;
/// and so many at once for a track that begins there.
const BESIDE_NEW: u8 = 2;
/// More scans than this that said it moves are not counted.
const PROVEN_MAX: u8 = 8;
/// After so many it surely moves.
const PROVEN_SURELY: u8 = 4;
/// Where so many scans have seen something already before it could be there, it stands.
const STOOD_SCANS: usize = 2;
/// Room beyond both bodies for any mover (m),
const CLEARANCE_M: f32 = 0.0063;
/// and for each metre by which its place may err.
const CLEARANCE_SHARE: f32 = 0.24;

/// What is asked of a track before it is taken to move.
#[derive(Clone, Copy, Debug)]
struct Proof {
    /// Scans that have seen it.
    seen: u8,
    /// Scans since.
    missed: u8,
    /// So many standard deviations of its speed are taken off before that is held against the least speed.
    deviations: f32,
}

/// Of something that is alone,
const ALONE: Proof = Proof { seen: 3, missed: 1, deviations: 0.6 };
/// of something beside what stands, for edges of walls look so at times,
const BESIDE: Proof = Proof { seen: 5, missed: 1, deviations: 1.2 };
/// and of what has been a mover of late: else it is given up when it passes something, and taken for a wall.
const HELD: Proof = Proof { seen: 1, missed: 2, deviations: 0.6 };

/// Something that is followed, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Track<S> {
    belief: Belief<S>,
    /// Scans that have seen it, less those that have seen a wall there.
    seen: u8,
    /// Scans since.
    missed: u8,
    /// Scans that have seen it beside something else that is known, less those that have seen it alone.
    beside: u8,
    /// Scans that said it moves, less those that said it does not.
    proven: u8,
    /// Something has been there before it could be.
    stood: bool,
}

impl<S: Scalar> Track<S> {
    /// Begins with an echo.
    pub(super) fn new(echo: &Echo<S>, pose: Pose<S>) -> Self {
        let at = pose.to_world_frame(echo.centre.to_point(), pose.heading_rad.sin_cos());
        let direction = wrap(echo.centre.bearing_rad + pose.heading_rad).sin_cos();
        // The standard deviation of what is anywhere in the sector: 1/√3 of half its width.
        let across_m = echo.half_width_rad * echo.centre.distance_m * S::from_f32(0.577);
        Self {
            belief: Belief::new(at, direction, noise_m(echo.range_m), across_m),
            seen: 1,
            missed: 0,
            beside: if echo.is_beside { BESIDE_NEW } else { 0 },
            proven: 0,
            stood: false,
        }
    }

    /// Goes on as before until the next scan.
    pub(super) fn advance(&mut self, seconds: S) {
        self.belief.advance(seconds);
        self.missed = self.missed.saturating_add(1);
    }

    /// Whether it has been lost.
    pub(super) fn is_lost(&self) -> bool {
        self.missed > MISSED_MAX
    }

    /// How far from a place of the world it is believed to be (m).
    pub(super) fn distance_to(&self, place: Point<S>) -> S {
        self.belief.at().distance_to(place)
    }

    /// The larger, the sooner its readings are its own.
    pub(super) fn seen(&self) -> u8 {
        self.seen
    }

    /// Whether its readings explain those beside them.
    pub(super) fn is_known_well(&self) -> bool {
        self.seen >= SEEN_WELL
    }

    /// How dispensable it is, if it is at all.
    pub(super) fn dispensable(&self) -> Option<(u8, u8)> {
        (self.missed > 0 || self.seen <= 1).then_some((self.missed, u8::MAX - self.seen))
    }

    /// Takes over what a scan made at `pose` says of it, and marks the sensors whose readings are of it.
    pub(super) fn follow<const SENSORS: usize>(
        &mut self,
        sight: &Sight<S, SENSORS>,
        pose: Pose<S>,
    ) -> Marks<SENSORS> {
        let mut readings = [false; SENSORS];
        let place = pose.see(self.belief.at());
        let (sin, cos) = wrap(place.bearing_rad + pose.heading_rad).sin_cos();
        let (along, across) = ((cos, sin), (-sin, cos));
        let distance_m = place.distance_m.max(sight.ring.body_radius_m);
        let doubt_m = self.belief.deviation_m(along);
        let deviation_rad = self.belief.deviation_m(across) / distance_m;
        // The belief across the line of sight times the likelihood: its sum, and its moments.
        let (mut sum, mut first, mut second) = (S::ZERO, S::ZERO, S::ZERO);
        for place_of in -PLACES..=PLACES {
            let z = S::from_i32(place_of) * S::from_f32(APART);
            let bearing = place.bearing_rad + z * deviation_rad;
            let weight = (z * z * S::HALF).exp_neg()
                * sight.likelihood(place.bearing_rad, bearing, distance_m, doubt_m);
            sum += weight;
            first += weight * z;
            second += weight * z * z;
        }
        if sum < S::from_f32(LIKELY) {
            // Nowhere in what is believed would a disc explain the scan.
            return readings;
        }
        let mean = first / sum;
        let share = (second / sum - mean * mean).clamp(S::from_f32(0.01), S::ONE);
        let bearing = place.bearing_rad + mean * deviation_rad;
        // What fits best is what should be read nearest.
        let expected = |at: S| sight.expected(angle_between(bearing, at), distance_m, doubt_m);
        let mut nearest: Option<(usize, S, Expected<S>)> = None;
        for (sensor, at) in Sight::<S, SENSORS>::sensors_near(place.bearing_rad) {
            if let (Some(expected), Some(range)) = (expected(at), sight.free_range_m(sensor))
                && expected.fits(range, FITS)
                && nearest.is_none_or(|(.., least)| expected.range_m < least.range_m)
            {
                nearest = Some((sensor, range, expected));
            }
        }
        let Some((sensor, range, least)) = nearest else { return readings };
        let is_close = distance_m < sight.ring.body_radius_m * S::from_f32(CLOSE_RADII);
        if !self.count(sight.is_alone(sensor, range, false), sight.is_alone(sensor, range, true), is_close) {
            return readings;
        }
        self.missed = 0;
        for (sensor, at) in Sight::<S, SENSORS>::sensors_near(place.bearing_rad) {
            if let (Some(expected), Some(range), Some(reading)) =
                (expected(at), sight.free_range_m(sensor), readings.get_mut(sensor))
            {
                *reading = expected.fits(range, TAKEN);
            }
        }
        self.belief.correct(across, mean * deviation_rad * distance_m, share);
        let doubt_m = self.belief.deviation_m(along);
        let noise_m = noise_m(least.range_m);
        // In units of the larger of both: the squares of millimetres are too small for fixed point.
        let (doubt, noise) = (doubt_m / doubt_m.max(noise_m), noise_m / doubt_m.max(noise_m));
        let gain = doubt * doubt / (doubt * doubt + noise * noise);
        self.belief.correct(along, gain * (range - least.range_m), S::ONE - gain);
        readings
    }

    /// Counts an echo that is alone, or alone but for what is explained, or neither; whether it is its own.
    fn count(&mut self, is_alone: bool, is_beside: bool, is_close: bool) -> bool {
        self.beside =
            if is_alone { self.beside.saturating_sub(1) } else { (self.beside + 1).min(BESIDE_MAX) };
        let seen = self.seen;
        if is_alone || is_beside {
            self.seen = (seen + 1).min(SEEN_MAX);
            return true;
        }
        self.seen = seen.saturating_sub(1).max(1);
        is_close && seen >= SEEN_CLOSE
    }

    /// The nearest of it, seen from `pose`; in the world.
    pub(super) fn surface(&self, body_radius_m: S, pose: Pose<S>) -> Point<S> {
        let Polar { bearing_rad, distance_m } = pose.see(self.belief.at());
        let nearest = Polar { bearing_rad, distance_m: distance_m - body_radius_m };
        pose.to_world_frame(nearest.to_point(), pose.heading_rad.sin_cos())
    }

    /// Judges whether it moves; so many older scans have seen something there.
    pub(super) fn judge(&mut self, p: &MoverParameters<S>, scans: usize) {
        self.stood = scans >= STOOD_SCANS;
        self.proven =
            if self.moves(p) { (self.proven + 1).min(PROVEN_MAX) } else { self.proven.saturating_sub(1) };
    }

    /// Whether it is taken to move.
    fn moves(&self, p: &MoverParameters<S>) -> bool {
        let proof = match (self.proven, self.beside) {
            (0, 0) => ALONE,
            (0, _) => BESIDE,
            _ => HELD,
        };
        !self.stood
            && self.seen >= proof.seen
            && self.missed <= proof.missed
            && self.belief.speed_at_least_mps(proof.deviations) > p.speed_mps
    }

    /// How it moves, seen from a robot of the same size, if it does.
    pub(super) fn mover(&self, p: &MoverParameters<S>, pose: Pose<S>) -> Option<Mover<S>> {
        self.moves(p).then(|| {
            let velocity = self.belief.velocity_mps();
            let speed = S::hypot(velocity.x_m, velocity.y_m);
            let rotation = pose.heading_rad.sin_cos();
            let (sin, cos) = rotation;
            let err = S::hypot(
                self.belief.deviation_m((S::ONE, S::ZERO)),
                self.belief.deviation_m((S::ZERO, S::ONE)),
            );
            Mover {
                at: pose.to_robot_frame(self.belief.at(), rotation),
                velocity_mps: Point {
                    x_m: velocity.x_m * cos + velocity.y_m * sin,
                    y_m: velocity.y_m * cos - velocity.x_m * sin,
                },
                turn_radps: self.belief.turn_radps(),
                is_sure: self.proven >= PROVEN_SURELY,
                clearance_m: S::from_f32(CLEARANCE_M)
                    + err * S::from_f32(CLEARANCE_SHARE)
                    + speed * p.headway_s,
            }
        })
    }
}
