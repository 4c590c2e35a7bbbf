//! Movers (ours): what moves is told from what stands, and the way to where it will be is not taken.
//!
//! The papers' robots meet others that circle (P1 Fig. 8, P2 Fig. 7), but obstacle fields take each scan for a world
//! that stands: something that crosses the way lies aside of it until it is too late. Here **echoes** that a body may
//! have thrown are followed from scan to scan as tracks of position, velocity and rate of turn, in the world, where the
//! robot's own motion drops out. A track that is quicker, and has come farther, than noise makes it look is a mover.
//! Integration holds the way to each candidate place against where the movers will be by then
//! ([`crate::integration::sweep`]).
//!
//! A beam tells how far something is, but only in which sector. So a track is corrected along the line of sight, and
//! across it by no more than what it has left the sector by: else a post would move along with the beam that sees it.
//! How wide the sector is follows from which beams see a disc of the robot's size and which do not.
//!
//! Walls throw no such echoes: along them the nearest place moves with the robot. Movers are taken to be as large as
//! this robot, and to turn on as they do: a disc that circles, as in both papers, is somewhere else within a second
//! than where its velocity points to. With the discs' true motion instead of tracks none of 400 runs among one and two
//! discs at 10 cm/s had a contact; without the rate of turn 16 had.
//!
//! Boards follow nothing: on the smaller one the code has no room (5 kB of flash), and on both the time of an
//! integration is not bounded as it has to be there, since among movers nearly every neuron's way may have to be
//! judged. So [`crate::config::CooperativeConfig::mover_headway_s`] is 0 by default, and whoever runs the core on a
//! machine with room sets it.
//!
//! Tried and left out: what is now where an earlier scan looked through (edges of standing things look alike), keeping
//! away from all that is near (doors close), the robot's own inertia (it no longer dares to brake).

use heapless::Vec;

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
    /// Slower than this beside the body counts as standing (m/s); farther away noise grows and with it this.
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
/// An echo belongs to a track no farther aside than this (rad),
const GATE_RAD: f32 = 0.6;
/// and no nearer or farther than this (m),
const GATE_M: f32 = 0.035;
/// and this share of its distance.
const GATE_SHARE: f32 = 0.2;
/// Nearer than this share of the body's radius, a body fills more than two beams, and its echo is no longer alone.
const CLOSE_RADII: f32 = 3.5;
/// Scans after which a track's velocity is believed.
const SEEN_MIN: u8 = 4;
/// More than this is not counted, so that a track which turns out to be of a wall is soon forgotten.
const SEEN_MAX: u8 = 12;
/// A track without an echo is a mover for one scan more,
const MISSED_AS_MOVER: u8 = 1;
/// and kept for so many.
const MISSED_MAX: u8 = 4;
/// Gains of a track along the line of sight for position and velocity, by the number of scans: those of a Kalman filter
/// that begins with nothing known, held where it would no longer follow a turn.
const GAINS: [(f32, f32); 6] = [(1.0, 0.0), (0.8, 0.15), (0.65, 0.22), (0.6, 0.2), (0.55, 0.17), (0.5, 0.14)];
/// The same from then on.
const GAINS_HELD: (f32, f32) = (0.45, 0.11);
/// The same across it.
const GAINS_ACROSS: (f32, f32) = (0.92, 0.065);
/// Gain of the rate of turn.
const GAIN_TURN: f32 = 1.3;
/// Nothing turns faster (rad/s).
const TURN_MAX_RADPS: f32 = 1.25;
/// Below this speed there is no direction that could turn (m/s).
const TURN_SPEED_MPS: f32 = 0.03;
/// What of speed is taken for noise grows by this with each metre of gap (1/s).
const NOISE_PER_S: f32 = 0.055;
/// This share of what may be noise is taken from the speed.
const NOISE_SHARE: f32 = 0.54;
/// A mover has come this far (m),
const MOVED_M: f32 = 0.0117;
/// and this share of the gap; both within some hundred scans.
const MOVED_SHARE: f32 = 0.14;
/// What is kept of the way from one scan to the next.
const MOVED_KEPT: f32 = 0.99;
/// Room beyond both bodies for any mover (m).
const CLEARANCE_M: f32 = 0.011;

/// An echo of something that may be a body.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Echo<S> {
    /// Where its centre is, if it is as large as this robot.
    centre: Polar<S>,
    /// Half the width of the sector that it may lie in (rad).
    half_width_rad: S,
    /// Nothing beside it is about as near.
    is_alone: bool,
}

impl<S: Scalar> Echo<S> {
    /// The echo of a sensor, if it reads less than its neighbours do.
    fn of<const SENSORS: usize>(
        ring: &ProximityParameters<S>,
        scan: &Scan<S, SENSORS>,
        sensor: usize,
    ) -> Option<Self> {
        let distance = |turn: usize| {
            let reading = scan.range_m.get((sensor + turn) % SENSORS.max(1)).copied().flatten()?;
            (reading < ring.range_m).then(|| ring.body_radius_m + reading.max(S::ZERO))
        };
        let here = distance(0)?;
        let (left, right) = (distance(1), distance(SENSORS - 1));
        // Of two alike the first is taken.
        if right.is_some_and(|right| right <= here) || left.is_some_and(|left| left < here) {
            return None;
        }
        let far = here * S::from_f32(ALONE_RATIO);
        let is_far = |distance: Option<S>| distance.is_none_or(|distance| distance > far);
        let spacing = S::TAU / S::from_i32(i32::try_from(SENSORS).unwrap_or(1));
        let beam = spacing * S::from_f32(BEAM_SHARE);
        // How wide it looks: an arc sine, within 1 % for what does not touch.
        let sine = ring.body_radius_m / (here + ring.body_radius_m);
        let width = sine + sine * sine * sine * S::from_f32(1.0 / 6.0);
        // Seen by both beams it lies between them, by one alone where the other does not reach.
        let between = (width - beam).max(S::ZERO);
        let (aside, half_width, is_alone) = match (is_far(right), is_far(left)) {
            (true, true) => (S::ZERO, (spacing - beam - width).max(S::ZERO).min(beam + width), true),
            (true, false) => (S::HALF, between, is_far(distance(2))),
            (false, true) => (-S::HALF, between, is_far(distance(SENSORS - 2))),
            (false, false) => (S::ZERO, between, false),
        };
        Some(Self {
            centre: Polar {
                bearing_rad: wrap(sensor_bearing::<S>(sensor, SENSORS) + spacing * aside),
                distance_m: here + ring.body_radius_m,
            },
            half_width_rad: half_width + S::from_f32(SECTOR_SLACK_RAD),
            is_alone,
        })
    }

    /// How far a bearing (rad) is beyond the sector, left positive.
    fn beyond(&self, bearing: S) -> S {
        let off = angle_between(bearing, self.centre.bearing_rad);
        off - off.clamp(-self.half_width_rad, self.half_width_rad)
    }
}

/// What has been followed over some scans, in the world. With the bits of weights where those do: a board has little
/// memory, and nothing of this kind does 8 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Track<S: Scalar> {
    at: Point<S>,
    velocity_mps: [S::Weight; 2],
    turn_radps: S::Weight,
    /// The way that it has come of late (m).
    moved_m: [S::Weight; 2],
    /// Scans that have seen it, less those that have seen a wall there.
    seen: u8,
    /// Scans since.
    missed: u8,
}

/// The time between two scans.
#[derive(Clone, Copy, Debug)]
struct Period<S> {
    /// It (s).
    length_s: S,
    /// Scans in a second.
    per_second: S,
}

fn stored<S: Scalar>(point: Point<S>) -> [S::Weight; 2] {
    [point.x_m.to_weight(), point.y_m.to_weight()]
}

fn read<S: Scalar>([x, y]: [S::Weight; 2]) -> Point<S> {
    Point { x_m: S::from_weight(x), y_m: S::from_weight(y) }
}

impl<S: Scalar> Track<S> {
    fn new(at: Point<S>) -> Self {
        let still = [S::WEIGHT_ZERO; 2];
        Self { at, velocity_mps: still, turn_radps: S::WEIGHT_ZERO, moved_m: still, seen: 1, missed: 0 }
    }

    /// Goes on as before until the next scan.
    fn advance(&mut self, period: Period<S>) {
        let Point { x_m: x, y_m: y } = read::<S>(self.velocity_mps);
        let turn = S::from_weight(self.turn_radps) * period.length_s;
        let half = turn * S::HALF;
        self.go(Point { x_m: (x - y * half) * period.length_s, y_m: (y + x * half) * period.length_s });
        let shrink = S::ONE - turn * half;
        self.velocity_mps = stored(Point { x_m: x * shrink - y * turn, y_m: y * shrink + x * turn });
        self.missed = self.missed.saturating_add(1);
    }

    fn go(&mut self, way: Point<S>) {
        self.at = Point { x_m: self.at.x_m + way.x_m, y_m: self.at.y_m + way.y_m };
        let moved = read::<S>(self.moved_m);
        self.moved_m = stored(Point { x_m: moved.x_m + way.x_m, y_m: moved.y_m + way.y_m });
    }

    /// How badly an echo fits, where it may be of this track.
    fn misfit(&self, ring: &ProximityParameters<S>, echo: &Echo<S>, pose: Pose<S>) -> Option<S> {
        let close = ring.body_radius_m * S::from_f32(CLOSE_RADII);
        let fits = echo.is_alone || (self.seen >= SEEN_MIN && echo.centre.distance_m < close);
        if self.missed == 0 || self.missed > MISSED_MAX || !fits {
            return None;
        }
        let place = pose.see(self.at);
        let aside = angle_between(place.bearing_rad, echo.centre.bearing_rad).abs();
        let away = (place.distance_m - echo.centre.distance_m).abs();
        let gate = S::from_f32(GATE_M) + echo.centre.distance_m * S::from_f32(GATE_SHARE);
        let is_near = aside < S::from_f32(GATE_RAD) && away < gate;
        is_near.then(|| away + aside * echo.centre.distance_m * S::HALF)
    }

    /// Takes over an echo.
    fn follow(&mut self, period: Period<S>, echo: &Echo<S>, pose: Pose<S>) {
        let s = S::from_f32;
        self.missed = 0;
        self.seen = if echo.is_alone {
            self.seen.saturating_add(1).min(SEEN_MAX)
        } else {
            self.seen.saturating_sub(1).max(1)
        };
        let place = pose.see(self.at);
        let (sin, cos) = wrap(place.bearing_rad + pose.heading_rad).sin_cos();
        let away = echo.centre.distance_m - place.distance_m;
        let across = echo.beyond(place.bearing_rad) * place.distance_m;
        let in_world =
            |along: S, aside: S| Point { x_m: cos * along - sin * aside, y_m: sin * along + cos * aside };
        let scan = usize::from(self.seen.saturating_sub(1));
        let (position, velocity) = GAINS.get(scan).copied().unwrap_or(GAINS_HELD);
        self.go(in_world(away * s(position), across * s(GAINS_ACROSS.0)));
        // A wall that stands where a mover was says nothing of how that moves.
        if echo.is_alone {
            let (along, aside) = (away * s(velocity), across * s(GAINS_ACROSS.1));
            self.correct(in_world(along * period.per_second, aside * period.per_second), period);
        }
        let moved = read::<S>(self.moved_m);
        self.moved_m = stored(Point { x_m: moved.x_m * s(MOVED_KEPT), y_m: moved.y_m * s(MOVED_KEPT) });
    }

    /// Corrects the velocity by a difference, and the rate of turn by how far that turns it.
    fn correct(&mut self, by: Point<S>, period: Period<S>) {
        let before = read::<S>(self.velocity_mps);
        self.velocity_mps = stored(Point { x_m: before.x_m + by.x_m, y_m: before.y_m + by.y_m });
        let square = before.x_m * before.x_m + before.y_m * before.y_m;
        let least = S::from_f32(TURN_SPEED_MPS * TURN_SPEED_MPS);
        if self.seen >= SEEN_MIN && square > least {
            let turned = (before.x_m * by.y_m - before.y_m * by.x_m) / square;
            let turn = S::from_weight(self.turn_radps) + turned * period.per_second * S::from_f32(GAIN_TURN);
            let most = S::from_f32(TURN_MAX_RADPS);
            self.turn_radps = turn.clamp(-most, most).to_weight();
        }
    }

    /// How it moves, seen from a robot of the same size, if it does.
    fn mover(&self, p: &MoverParameters<S>, body_radius_m: S, pose: Pose<S>) -> Option<Mover<S>> {
        let rotation = pose.heading_rad.sin_cos();
        let at = pose.to_robot_frame(self.at, rotation);
        let gap = (S::hypot(at.x_m, at.y_m) - body_radius_m - body_radius_m).max(S::ZERO);
        let (velocity, moved) = (read::<S>(self.velocity_mps), read::<S>(self.moved_m));
        let speed = S::hypot(velocity.x_m, velocity.y_m);
        // That noise may feign.
        let feigned = p.speed_mps + gap * S::from_f32(NOISE_PER_S);
        let least_m = S::from_f32(MOVED_M) + gap * S::from_f32(MOVED_SHARE);
        let moves = self.seen >= SEEN_MIN
            && self.missed <= MISSED_AS_MOVER
            && speed > feigned
            && S::hypot(moved.x_m, moved.y_m) > least_m;
        let told = speed - feigned * S::from_f32(NOISE_SHARE);
        moves.then(|| {
            let share = told / speed;
            let (x, y) = (velocity.x_m * share, velocity.y_m * share);
            let (sin, cos) = rotation;
            Mover {
                at,
                velocity_mps: Point { x_m: x * cos + y * sin, y_m: y * cos - x * sin },
                turn_radps: S::from_weight(self.turn_radps),
                clearance_m: S::from_f32(CLEARANCE_M) + told * p.headway_s,
            }
        })
    }
}

/// The tracks, at most `TRACKS`; where they do not suffice the one that has not been seen for longest goes. One that
/// has been lost stays in its place until another needs it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Movers<S: Scalar, const TRACKS: usize> {
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
        let period_ms = S::from_i32(i32::from(schedule.avoidance_period_ms));
        let period =
            Period { length_s: period_ms * S::from_f32(0.001), per_second: S::from_i32(1000) / period_ms };
        for track in &mut self.tracks {
            track.advance(period);
        }
        for echo in (0..SENSORS).filter_map(|sensor| Echo::of(ring, scan, sensor)) {
            let mut best: Option<(S, &mut Track<S>)> = None;
            for track in &mut self.tracks {
                let Some(misfit) = track.misfit(ring, &echo, pose) else { continue };
                if best.as_ref().is_none_or(|(least, _)| misfit < *least) {
                    best = Some((misfit, track));
                }
            }
            match best {
                Some((_, track)) => track.follow(period, &echo, pose),
                None if echo.is_alone => self.begin(&echo, pose),
                None => {}
            }
        }
    }

    fn begin(&mut self, echo: &Echo<S>, pose: Pose<S>) {
        let at = pose.to_world_frame(echo.centre.to_point(), pose.heading_rad.sin_cos());
        if let Err(track) = self.tracks.push(Track::new(at))
            && let Some(oldest) = self.tracks.iter_mut().max_by_key(|track| track.missed)
            && oldest.missed > 0
        {
            *oldest = track;
        }
    }

    /// What moves, seen from `pose`.
    #[must_use]
    pub fn seen_from(
        &self,
        p: &MoverParameters<S>,
        body_radius_m: S,
        pose: Pose<S>,
    ) -> Vec<Mover<S>, TRACKS> {
        if TRACKS == 0 {
            return Vec::new();
        }
        first(self.tracks.iter().filter_map(|track| track.mover(p, body_radius_m, pose)))
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
        for mover in self.seen_from(p, body_radius_m, pose) {
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
