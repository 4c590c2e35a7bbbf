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
//! A reading is of one thing: tracks take theirs in turn, what is known best first (`sight`). So an echo beside that of
//! something known may be of something new, as a disc behind a jamb is; but edges of walls look so as well, and more is
//! asked there (`track`).
//!
//! What moves has to be known as such within a few scans, so little is asked of a mover: a speed that is believed at a
//! little more than half a standard deviation. What stands then seems to move now and then, as a post does that one
//! beam sees askew, or a jamb whose wall comes into view; that costs time. Walls are no bodies: their echoes are not
//! alone. And where scans of more than 0.9 s ago have seen something already, nothing has come since (`past`); of what
//! seems to move in doors and between posts that is half to four fifths, of what does 2 to 8 %.
//!
//! Movers are taken to be as large as this robot, and to turn on as they do: a disc that circles, as in both papers, is
//! somewhere else within a second than where its velocity points to.
//!
//! Boards follow nothing: the smaller one has no room for the code. So
//! [`crate::config::CooperativeConfig::mover_headway_s`] is 0 by default, and whoever runs the core on a machine with
//! room sets it.
//!
//! Tried and left out: fixed gains instead of a belief (1, 2 and 4 discs at 10 cm/s: 95, 88 and 78 % instead of 99, 97
//! and 93, in the state of then); the likelihood of standing points and discs of several sizes against that of a mover
//! (sure after seven scans, too late); what is now where an earlier scan looked through (edges of standing things look
//! alike); keeping away from all that is near (doors close); the robot's own inertia (it no longer dares to brake);
//! more weight for ways that would touch (no difference: contacts are not foretold); a least way that a mover has come
//! (none).

mod belief;
mod past;
mod sight;
mod track;

use heapless::Vec;

use past::Past;
use sight::Sight;
use track::Track;

use crate::list::first;
use crate::scalar::Scalar;
use crate::schedule::Schedule;
use crate::sensing::proximity::{ProximityParameters, Scan};
use crate::units::{Point, Polar, Pose};

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
    /// It has moved for some scans. Most of what seems to and stands is found out before.
    pub is_sure: bool,
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

/// The tracks, at most `TRACKS`; where they do not suffice the one that has not been seen for longest goes. One that
/// has been lost stays in its place until another needs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Movers<S: Scalar, const SENSORS: usize, const TRACKS: usize> {
    tracks: Vec<Track<S>, TRACKS>,
    past: Past<S, SENSORS, TRACKS>,
}

impl<S: Scalar, const SENSORS: usize, const TRACKS: usize> Movers<S, SENSORS, TRACKS> {
    /// Nothing is followed.
    pub const NONE: Self = Self { tracks: Vec::new(), past: Past::NONE };

    /// Takes over a scan, made at `pose`, one period after the last.
    pub fn renew(
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
        self.tracks.retain(|track| !track.is_lost());
        // What is known best takes its readings first.
        self.tracks.sort_unstable_by_key(|track| u8::MAX - track.seen());
        let mut sight = Sight::new(ring, scan);
        for track in &mut self.tracks {
            let readings = track.follow(&sight, pose);
            sight.take(&readings, track.is_known_well());
            let surface = track.surface(ring.body_radius_m, pose);
            track.judge(p, self.past.has_seen(ring, surface, seconds));
        }
        for sensor in 0..SENSORS {
            if let Some(echo) = sight.echo(sensor) {
                self.begin(Track::new(&echo, pose));
            }
        }
        self.past.keep(ring, scan, pose);
    }

    fn begin(&mut self, track: Track<S>) {
        if let Err(track) = self.tracks.push(track) {
            let dispensable = |track: &&mut Track<S>| track.dispensable();
            let tracks = self.tracks.iter_mut().filter(|track| track.dispensable().is_some());
            if let Some(least) = tracks.max_by_key(dispensable) {
                *least = track;
            }
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

    /// Follows nothing any more that is within a body's diameter of a place of the robot frame: something there has
    /// told of itself, and is kept apart from by other means ([`super::separation`]). Both at once are too much of it.
    pub fn leave_to_itself(&mut self, body_radius_m: S, pose: Pose<S>, place: Point<S>) {
        if TRACKS == 0 {
            return;
        }
        let place = pose.to_world_frame(place, pose.heading_rad.sin_cos());
        self.tracks.retain(|track| track.distance_to(place) > body_radius_m + body_radius_m);
    }

    /// Leaves out of what sensors see what may well be of something that moves: nearer to its centre than a body's
    /// diameter. It is no wall to be followed; it will be gone before it is gone round.
    pub fn leave_out(
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
        self.past.clear();
    }
}

#[cfg(test)]
mod tests;
