//! The ring of proximity sensors: what the controller's [`Scan`] would read, noise and resolution included.
//!
//! It inverts the controller's own model: the same bearings, the same body radius.

use controller_core::sensing::proximity::{Scan, sensor_bearing};

use crate::beam::Beam;
use crate::khepera::TruePose;
use crate::number::narrow;
use crate::random::Stream;
use crate::world::World;

/// Sensors of the ring (P2: twelve).
pub const SENSORS: usize = 12;

/// The ring on its robot.
#[derive(Debug, Clone)]
pub struct ProximityRing {
    beams: [Beam; SENSORS],
    body_radius_m: f64,
    range_m: f64,
    resolution_m: f64,
    noise: f64,
    stream: Stream,
    /// Share of readings that are missing, and what draws them.
    dropout: Option<(f64, Stream)>,
}

impl ProximityRing {
    /// A ring with beams of the given half-width; ranges are disturbed by ± `noise` of their length, then rounded to
    /// `resolution_m` (zero: not rounded).
    #[must_use]
    pub fn new(
        body_radius_m: f64,
        range_m: f64,
        half_width_rad: f64,
        resolution_m: f64,
        noise: f64,
        stream: Stream,
    ) -> Self {
        let beams =
            core::array::from_fn(|j| Beam::new(f64::from(sensor_bearing::<f32>(j, SENSORS)), half_width_rad));
        Self { beams, body_radius_m, range_m, resolution_m, noise, stream, dropout: None }
    }

    /// The same ring, but this share of its readings is missing: the controller takes them for free space.
    #[must_use]
    pub fn with_dropout(self, share: f64, stream: Stream) -> Self {
        Self { dropout: (share > 0.0).then_some((share, stream)), ..self }
    }

    /// One scan.
    pub fn scan(&mut self, world: &World, robot: TruePose, t_s: f64) -> Scan<f32, SENSORS> {
        let (sin, cos) = libm::sincos(robot.heading_rad);
        let beams = core::array::from_fn::<Beam, SENSORS, _>(|j| self.beams[j].turned(cos, sin));
        let seen = world.scan(robot.position, &beams, self.body_radius_m + self.range_m, t_s);
        let range_m = seen.map(|distance| {
            // One draw per sensor and scan, seen or not: what a world holds must not shift the stream.
            let disturbance = 1.0 + self.noise * self.stream.symmetric();
            if let Some((share, stream)) = &mut self.dropout
                && stream.between(0.0, 1.0) < *share
            {
                return None;
            }
            let range = (distance? - self.body_radius_m).max(0.0) * disturbance;
            let rounded = if self.resolution_m > 0.0 {
                (range / self.resolution_m).round() * self.resolution_m
            } else {
                range
            };
            (rounded < self.range_m).then(|| narrow(rounded))
        });
        Scan { range_m }
    }
}

#[cfg(test)]
mod tests {
    use super::{ProximityRing, SENSORS};
    use crate::geometry::{Disc, Segment};
    use crate::khepera::TruePose;
    use crate::random::{Purpose, Stream};
    use crate::world::World;
    use nalgebra::Point2;

    fn ring(noise: f64) -> ProximityRing {
        ProximityRing::new(0.025, 0.175, 0.13, 0.005, noise, Stream::new(1, Purpose::Proximity))
    }

    #[test]
    fn reads_what_is_in_its_beams() {
        let mut world = World::default();
        world.permanent.segments.push(Segment::new(Point2::new(-1.0, 0.1), Point2::new(1.0, 0.1)));
        world.permanent.discs.push(Disc { centre: Point2::new(-0.3, 0.0), radius_m: 0.05 });
        let robot = TruePose { position: Point2::origin(), heading_rad: core::f64::consts::FRAC_PI_2 };
        let scan = ring(0.0).scan(&world, robot, 0.0);
        let ahead = scan.range_m[0].unwrap();
        assert!((ahead - 0.075).abs() < 1e-6, "wall 75 mm beyond the body: {ahead}");
        assert_eq!(scan.range_m[3], None, "the post is beyond the range");
        assert_eq!(scan.range_m[6], None, "nothing behind");
        assert_eq!(scan.range_m.len(), SENSORS);
    }

    #[test]
    fn a_share_of_the_readings_is_missing() {
        let mut world = World::default();
        world.permanent.segments.push(Segment::new(Point2::new(0.125, -1.0), Point2::new(0.125, 1.0)));
        let robot = TruePose { position: Point2::origin(), heading_rad: 0.0 };
        let mut ring = ring(0.1).with_dropout(0.3, Stream::new(1, Purpose::Dropout));
        let seen = (0..1000).filter(|_| ring.scan(&world, robot, 0.0).range_m[0].is_some()).count();
        assert!((660..740).contains(&seen), "{seen} of 1000");
    }

    #[test]
    fn noise_is_a_share_of_the_range() {
        let mut world = World::default();
        world.permanent.segments.push(Segment::new(Point2::new(0.125, -1.0), Point2::new(0.125, 1.0)));
        let robot = TruePose { position: Point2::origin(), heading_rad: 0.0 };
        let mut ring = ring(0.1);
        let readings: Vec<f32> = (0..500).filter_map(|_| ring.scan(&world, robot, 0.0).range_m[0]).collect();
        let (low, high) =
            readings.iter().fold((f32::MAX, f32::MIN), |(low, high), &r| (low.min(r), high.max(r)));
        assert!((low - 0.09).abs() < 0.0026 && (high - 0.11).abs() < 0.0026, "{low} to {high}");
    }
}
