//! Movers (ours): what moves is told from what stands, and the way to where it will be is not taken.
//!
//! The papers' robots meet others that circle (P1 Fig. 8, P2 Fig. 7), but obstacle fields take each scan for a world
//! that stands: something that crosses the way lies aside of it until it is too late. Here **echoes** that a body may
//! have thrown are followed from scan to scan as tracks, in the world, where the robot's own motion drops out. A track
//! holds what is believed of place, velocity and rate of turn, and how sure that is (the module `belief`). Integration
//! holds the way to each candidate place against where the movers will be by then ([`crate::integration::sweep`]).
//!
//! A beam tells how far something is, but only in which sector. So across the line of sight a track is weighed at some
//! places of its belief by how well a disc there explains which beams see it, at what distance, and which do not.
//!
//! What moves has to be known as such within five scans: with the discs' true motion told from the fifth scan on that
//! they are in range none of 1,200 runs among 1, 2 and 4 discs at 10 cm/s had a contact, from the sixth 3, 8 and 16 %,
//! from the eighth 20 to 61 % (in a scratch program). So little is asked of a mover: a speed that is believed at a
//! little more than half a standard deviation. What stands then seems to move now and then, as a post does that one
//! beam sees askew, or a jamb whose wall comes into view; that costs time. Walls are no bodies: their echoes are not
//! alone.
//!
//! Movers are taken to be as large as this robot, and to turn on as they do: a disc that circles, as in both papers, is
//! somewhere else within a second than where its velocity points to.
//!
//! Boards follow nothing: the smaller one has no room for the code. So
//! [`crate::config::CooperativeConfig::mover_headway_s`] is 0 by default, and whoever runs the core on a machine with
//! room sets it.
//!
//! Tried and left out: fixed gains instead of a belief (1, 2 and 4 discs at 10 cm/s: 95, 88 and 78 % instead of 99, 97
//! and 93); the likelihood of standing points and discs of several sizes against that of a mover (sure after seven
//! scans, too late); echoes beside what is followed already (doors); what is now where an earlier scan looked through
//! (edges of standing things look alike); keeping away from all that is near (doors close); the robot's own inertia (it
//! no longer dares to brake).

mod belief;

use heapless::Vec;

use belief::Belief;

use crate::list::first;
use crate::scalar::Scalar;
use crate::schedule::Schedule;
use crate::sensing::proximity::{ProximityParameters, Scan, sensor_bearing};
use crate::units::{Point, Polar, Pose, angle_between, wrap};

/// When something moves, and how much room it is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MoverParameters<S> {
    /// A mover is given so many seconds of its way (s); 0: nothing is taken for one.
    pub headway_s: S,
    /// What is not quicker than this, with what it may err by taken off, counts as standing (m/s).
    pub speed_mps: S,
}

/// Something that moves, seen from the robot: robot frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mover<S> {
    /// Where its centre is.
    pub at: Point<S>,
    /// How it moves (m/s).
    pub velocity_mps: Point<S>,
    /// How fast it turns, anticlockwise positive (rad/s).
    pub turn_radps: S,
    /// Room that it is given beyond both bodies (m).
    pub clearance_m: S,
}

impl<S: Scalar> Mover<S> {
    /// Where its centre will be after so many seconds, up to about one.
    #[must_use]
    pub fn after(&self, seconds: S) -> Point<S> {
        let aside = seconds * seconds * S::HALF * self.turn_radps;
        let Point { x_m, y_m } = self.velocity_mps;
        Point {
            x_m: self.at.x_m + x_m * seconds - y_m * aside,
            y_m: self.at.y_m + y_m * seconds + x_m * aside,
        }
    }
}

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
/// Places across the line of sight that are weighed, to either side, and the standard deviations between two of them.
const PLACES: i32 = 8;
/// See [`PLACES`].
const APART: f32 = 0.3125;
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
const FITS: f32 = 3.0;
/// It is of the mover, and no sign of something new, within so many.
const TAKEN: f32 = 2.4;
/// Nearer than this share of the body's radius, a body fills more than two beams, and its echo is no longer alone.
const CLOSE_RADII: f32 = 3.5;
/// Scans after which a track's velocity is believed.
const SEEN_MIN: u8 = 3;
/// So many, and an echo that is not alone is still believed to be its own where it is close.
const SEEN_CLOSE: u8 = 4;
/// More than this is not counted, so that a track which turns out to be of a wall is soon forgotten.
const SEEN_MAX: u8 = 12;
/// A track without an echo is a mover for one scan more,
const MISSED_AS_MOVER: u8 = 1;
/// and kept for so many.
const MISSED_MAX: u8 = 5;
/// So many standard deviations of its speed are taken off before a mover is held against the least speed.
const DEVIATIONS: f32 = 0.6;
/// A mover has come this far (m).
const MOVED_M: f32 = 0.012;
/// Room beyond both bodies for any mover (m),
const CLEARANCE_M: f32 = 0.0063;
/// and for each metre by which its place may err.
const CLEARANCE_SHARE: f32 = 0.24;

/// An echo of something that may be a body: nothing beside it is about as near.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Echo<S> {
    /// Where its centre is, if it is as large as this robot.
    centre: Polar<S>,
    /// Half the width of the sector that it may lie in (rad).
    half_width_rad: S,
    /// What was read (m).
    range_m: S,
}

impl<S: Scalar> Echo<S> {
    /// The echo of a sensor, if it reads less than its neighbours do and is alone.
    fn of<const SENSORS: usize>(sight: &Sight<S, SENSORS>, sensor: usize) -> Option<Self> {
        let range_m = sight.range_m(sensor)?;
        // Of two alike the first is taken.
        let (right, left) = (sight.beside(sensor, SENSORS - 1), sight.beside(sensor, 1));
        if right.is_some_and(|right| right <= range_m) || left.is_some_and(|left| left < range_m) {
            return None;
        }
        let side = sight.side(sensor, range_m)?;
        let body_radius_m = sight.ring.body_radius_m;
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
        Some(Self {
            centre: Polar {
                bearing_rad: wrap(sensor_bearing::<S>(sensor, SENSORS) + spacing * aside),
                distance_m,
            },
            half_width_rad: half_width + S::from_f32(SECTOR_SLACK_RAD),
            range_m,
        })
    }
}

/// On which side of the sensor that sees a body best the next one sees it too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    None,
    Left,
    Right,
}

/// A scan, and what a disc of this robot's size would read in it.
#[derive(Clone, Copy, Debug)]
struct Sight<'a, S, const SENSORS: usize> {
    ring: &'a ProximityParameters<S>,
    scan: &'a Scan<S, SENSORS>,
}

/// What a sensor should read, and how much it may differ (standard deviation, m).
#[derive(Clone, Copy, Debug)]
struct Expected<S> {
    range_m: S,
    deviation_m: S,
}

impl<S: Scalar> Expected<S> {
    fn new(range_m: S, doubt_m: S) -> Self {
        Self { range_m, deviation_m: S::hypot(noise_m(range_m), doubt_m) }
    }

    fn fits(&self, range_m: S, deviations: f32) -> bool {
        (range_m - self.range_m).abs() < self.deviation_m * S::from_f32(deviations)
    }
}

impl<S: Scalar, const SENSORS: usize> Sight<'_, S, SENSORS> {
    fn range_m(&self, sensor: usize) -> Option<S> {
        let range = self.scan.range_m.get(sensor).copied().flatten();
        range.filter(|range| *range < self.ring.range_m).map(|range| range.max(S::ZERO))
    }

    /// What a sensor reads of a disc that is so far away, aside of its bearing by `off`; `None` if it does not see it.
    /// `doubt_m` is what the distance may err by.
    fn expected(&self, off: S, distance_m: S, doubt_m: S) -> Option<Expected<S>> {
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
    fn sensors_near(bearing: S) -> impl Iterator<Item = (usize, S)> {
        let bearings = (0..SENSORS).map(|sensor| (sensor, sensor_bearing::<S>(sensor, SENSORS)));
        bearings.filter(move |(_, of)| angle_between(bearing, *of).abs() < S::from_f32(ASIDE_RAD))
    }

    /// How well a disc at `bearing` explains what the sensors near a bearing read.
    fn likelihood(&self, near: S, bearing: S, distance_m: S, doubt_m: S) -> S {
        let unseen = Expected::new(distance_m - self.ring.body_radius_m - self.ring.body_radius_m, doubt_m);
        let of = |(sensor, at): (usize, S)| {
            let range_m = self.range_m(sensor);
            match (self.expected(angle_between(bearing, at), distance_m, doubt_m), range_m) {
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

    /// What the sensor reads that is so many places to the left.
    fn beside(&self, sensor: usize, places: usize) -> Option<S> {
        self.range_m((sensor + places) % SENSORS.max(1))
    }

    /// Where nothing beside what a sensor reads is about as near but for one more beam that sees it: which.
    fn side(&self, sensor: usize, range_m: S) -> Option<Side> {
        let radius = self.ring.body_radius_m;
        let far = (radius + range_m) * S::from_f32(ALONE_RATIO);
        let is_far = |places| self.beside(sensor, places).is_none_or(|range| radius + range > far);
        let (side, is_alone) = match (is_far(SENSORS - 1), is_far(1)) {
            (true, true) => (Side::None, true),
            (true, false) => (Side::Left, is_far(2)),
            (false, true) => (Side::Right, is_far(SENSORS - 2)),
            (false, false) => return None,
        };
        is_alone.then_some(side)
    }
}

/// The standard deviation of a reading (m).
fn noise_m<S: Scalar>(range_m: S) -> S {
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

/// Something that is followed, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Track<S> {
    belief: Belief<S>,
    /// Where it was first.
    begun: Point<S>,
    /// Scans that have seen it, less those that have seen a wall there.
    seen: u8,
    /// Scans since.
    missed: u8,
}

impl<S: Scalar> Track<S> {
    /// Begins with an echo.
    fn new(echo: &Echo<S>, pose: Pose<S>) -> Self {
        let at = pose.to_world_frame(echo.centre.to_point(), pose.heading_rad.sin_cos());
        let direction = wrap(echo.centre.bearing_rad + pose.heading_rad).sin_cos();
        // The standard deviation of what is anywhere in the sector: 1/√3 of half its width.
        let across_m = echo.half_width_rad * echo.centre.distance_m * S::from_f32(0.577);
        Self {
            belief: Belief::new(at, direction, noise_m(echo.range_m), across_m),
            begun: at,
            seen: 1,
            missed: 0,
        }
    }

    /// Goes on as before until the next scan.
    fn advance(&mut self, seconds: S) {
        self.belief.advance(seconds);
        self.missed = self.missed.saturating_add(1);
    }

    /// Takes over what a scan made at `pose` says of it, and marks the sensors whose readings are of it.
    fn follow<const SENSORS: usize>(
        &mut self,
        sight: &Sight<S, SENSORS>,
        pose: Pose<S>,
        taken: &mut [bool; SENSORS],
    ) {
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
        if sum < S::from_f32(1e-5) {
            // Nowhere in what is believed would a disc explain the scan.
            return;
        }
        let mean = first / sum;
        let share = (second / sum - mean * mean).clamp(S::from_f32(0.01), S::ONE);
        let bearing = place.bearing_rad + mean * deviation_rad;
        // What fits best is what should be read nearest.
        let expected = |at: S| sight.expected(angle_between(bearing, at), distance_m, doubt_m);
        let mut nearest: Option<(usize, S, Expected<S>)> = None;
        for (sensor, at) in Sight::<S, SENSORS>::sensors_near(place.bearing_rad) {
            if let (Some(expected), Some(range)) = (expected(at), sight.range_m(sensor))
                && expected.fits(range, FITS)
                && nearest.is_none_or(|(.., least)| expected.range_m < least.range_m)
            {
                nearest = Some((sensor, range, expected));
            }
        }
        let Some((sensor, range, least)) = nearest else { return };
        let is_alone = sight.side(sensor, range).is_some();
        let is_close = distance_m < sight.ring.body_radius_m * S::from_f32(CLOSE_RADII);
        if is_alone {
            self.seen = self.seen.saturating_add(1).min(SEEN_MAX);
        } else {
            let seen = self.seen;
            self.seen = seen.saturating_sub(1).max(1);
            if !is_close || seen < SEEN_CLOSE {
                return;
            }
        }
        self.missed = 0;
        for (sensor, at) in Sight::<S, SENSORS>::sensors_near(place.bearing_rad) {
            if let (Some(expected), Some(range), Some(taken)) =
                (expected(at), sight.range_m(sensor), taken.get_mut(sensor))
            {
                *taken |= expected.fits(range, TAKEN);
            }
        }
        self.belief.correct(across, mean * deviation_rad * distance_m, share);
        let doubt_m = self.belief.deviation_m(along);
        let noise_m = noise_m(least.range_m);
        // In units of the larger of both: the squares of millimetres are too small for fixed point.
        let (doubt, noise) = (doubt_m / doubt_m.max(noise_m), noise_m / doubt_m.max(noise_m));
        let gain = doubt * doubt / (doubt * doubt + noise * noise);
        self.belief.correct(along, gain * (range - least.range_m), S::ONE - gain);
    }

    /// How it moves, seen from a robot of the same size, if it does.
    fn mover(&self, p: &MoverParameters<S>, pose: Pose<S>) -> Option<Mover<S>> {
        let at = self.belief.at();
        let velocity = self.belief.velocity_mps();
        let speed = S::hypot(velocity.x_m, velocity.y_m);
        let moves = self.seen >= SEEN_MIN
            && self.missed <= MISSED_AS_MOVER
            && self.belief.speed_at_least_mps(DEVIATIONS) > p.speed_mps
            && at.distance_to(self.begun) > S::from_f32(MOVED_M);
        moves.then(|| {
            let rotation = pose.heading_rad.sin_cos();
            let (sin, cos) = rotation;
            let err = S::hypot(
                self.belief.deviation_m((S::ONE, S::ZERO)),
                self.belief.deviation_m((S::ZERO, S::ONE)),
            );
            Mover {
                at: pose.to_robot_frame(at, rotation),
                velocity_mps: Point {
                    x_m: velocity.x_m * cos + velocity.y_m * sin,
                    y_m: velocity.y_m * cos - velocity.x_m * sin,
                },
                turn_radps: self.belief.turn_radps(),
                clearance_m: S::from_f32(CLEARANCE_M)
                    + err * S::from_f32(CLEARANCE_SHARE)
                    + speed * p.headway_s,
            }
        })
    }
}

/// The tracks, at most `TRACKS`; where they do not suffice the one that has not been seen for longest goes. One that
/// has been lost stays in its place until another needs it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Movers<S, const TRACKS: usize> {
    tracks: Vec<Track<S>, TRACKS>,
}

impl<S: Scalar, const TRACKS: usize> Movers<S, TRACKS> {
    /// Nothing is followed.
    pub const NONE: Self = Self { tracks: Vec::new() };

    /// Takes over a scan, made at `pose`, one period after the last.
    pub fn renew<const SENSORS: usize>(
        &mut self,
        p: &MoverParameters<S>,
        schedule: &Schedule,
        ring: &ProximityParameters<S>,
        scan: &Scan<S, SENSORS>,
        pose: Pose<S>,
    ) {
        if TRACKS == 0 || p.headway_s <= S::ZERO {
            return;
        }
        let seconds = S::from_i32(i32::from(schedule.avoidance_period_ms)) * S::from_f32(0.001);
        for track in &mut self.tracks {
            track.advance(seconds);
        }
        self.tracks.retain(|track| track.missed <= MISSED_MAX);
        // What is known best takes its readings first.
        self.tracks.sort_unstable_by_key(|track| u8::MAX - track.seen);
        let sight = Sight { ring, scan };
        let mut taken = [false; SENSORS];
        for track in &mut self.tracks {
            track.follow(&sight, pose, &mut taken);
        }
        for (sensor, is_taken) in taken.into_iter().enumerate() {
            if !is_taken && let Some(echo) = Echo::of(&sight, sensor) {
                self.begin(Track::new(&echo, pose));
            }
        }
    }

    fn begin(&mut self, track: Track<S>) {
        if let Err(track) = self.tracks.push(track)
            && let Some(least) =
                self.tracks.iter_mut().max_by_key(|track| (track.missed, u8::MAX - track.seen))
            && (least.missed > 0 || least.seen <= 1)
        {
            *least = track;
        }
    }

    /// What moves, seen from `pose`.
    #[must_use]
    pub fn seen_from(&self, p: &MoverParameters<S>, pose: Pose<S>) -> Vec<Mover<S>, TRACKS> {
        if TRACKS == 0 {
            return Vec::new();
        }
        first(self.tracks.iter().filter_map(|track| track.mover(p, pose)))
    }

    /// Leaves out of what sensors see what may well be of something that moves: nearer to its centre than a body's
    /// diameter. It is no wall to be followed; it will be gone before it is gone round.
    pub fn leave_out<const SENSORS: usize>(
        &self,
        p: &MoverParameters<S>,
        body_radius_m: S,
        pose: Pose<S>,
        detections: &mut Vec<Polar<S>, SENSORS>,
    ) {
        if TRACKS == 0 {
            return;
        }
        for mover in self.seen_from(p, pose) {
            let apart =
                |place: &Polar<S>| mover.at.distance_to(place.to_point()) > body_radius_m + body_radius_m;
            *detections = first(detections.iter().copied().filter(apart));
        }
    }

    /// Follows nothing any more, as when the pose has jumped.
    pub fn clear(&mut self) {
        self.tracks.clear();
    }
}

#[cfg(test)]
mod tests;
