//! What was seen lately: the readings of the last scans as points, carried along by odometry.
//!
//! Twelve beams of 15° leave half of the circle unseen, and 10 % noise moves a wall 15 cm away by ±1.5 cm. So each
//! reading becomes a point on the axis of its beam, which is kept for a while, replaced by a nearer (more precise)
//! reading of the same place, and dropped when a later beam sees through it, as after a moving robot has passed.

use controller_core::sensing::proximity::sensor_bearing;
use nalgebra::{Point2, Vector2};

use super::config::MemoryConfig;
use crate::arc::Place;
use crate::proximity_model::SENSORS;

/// Points kept at most; a ring fills up to twelve with each scan, most of which it has seen before.
const POINTS: usize = 96;
/// Half the width of a beam within which a point would be seen again, in rad: 7.5°.
const BEAM_RAD: f64 = 0.131;
/// Share of a range by which a reading may be wrong, and the rounding of its own, in m.
const RANGE_NOISE: f64 = 0.1;
const ROUNDING_M: f64 = 0.003;

/// A place where something was seen.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Remembered {
    /// World frame.
    at: Point2<f64>,
    /// By how much its distance may be wrong, in m.
    doubt_m: f64,
    /// Since it was last seen, in s.
    age_s: f64,
}

/// The short memory.
#[derive(Debug, Clone)]
pub struct Surroundings {
    config: MemoryConfig,
    memory_s: f64,
    body_radius_m: f64,
    remembered: Vec<Remembered>,
    points: Vec<Point2<f64>>,
}

impl Surroundings {
    /// Nothing seen yet; a point is kept for `memory_s` after it was last seen.
    #[must_use]
    pub fn new(config: MemoryConfig, memory_s: f64, body_radius_m: f64) -> Self {
        Self { config, memory_s, body_radius_m, remembered: Vec::new(), points: Vec::new() }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.remembered.clear();
        self.points.clear();
    }

    /// Takes over a scan (distances from the robot's centre) made at a pose, `elapsed_s` after the last.
    pub fn see(&mut self, place: Place, ranges: &[Option<f64>; SENSORS], reach_m: f64, elapsed_s: f64) {
        for point in &mut self.remembered {
            point.age_s += elapsed_s;
        }
        let memory_s = self.memory_s;
        self.remembered.retain(|point| point.age_s < memory_s);
        for (sensor, range) in ranges.iter().enumerate() {
            self.see_beam(place, f64::from(sensor_bearing::<f32>(sensor, SENSORS)), *range, reach_m);
        }
        if self.remembered.len() > POINTS {
            let far = |point: &Remembered| (point.at - place.position).norm_squared();
            self.remembered.sort_by(|a, b| far(a).total_cmp(&far(b)));
            self.remembered.truncate(POINTS);
        }
        let (sin, cos) = libm::sincos(place.heading_rad);
        let seen = |point: &Remembered| {
            let to = point.at - place.position;
            Point2::new(to.x * cos + to.y * sin, to.y * cos - to.x * sin)
        };
        self.points = self.remembered.iter().map(seen).collect();
    }

    /// One beam: what it contradicts goes, what it confirms stays, what is new is added.
    fn see_beam(&mut self, place: Place, bearing_rad: f64, range: Option<f64>, reach_m: f64) {
        let (sin, cos) = libm::sincos(place.heading_rad + bearing_rad);
        let axis = Vector2::new(cos, sin);
        let doubt = |distance: f64| RANGE_NOISE * (distance - self.body_radius_m).max(0.0) + ROUNDING_M;
        let (distance, doubt_m) = range.map_or((reach_m, doubt(reach_m)), |range| (range, doubt(range)));
        let mut is_known = false;
        let merge_m = self.config.merge_m;
        self.remembered.retain_mut(|point| {
            let to = point.at - place.position;
            let (along, aside) = (to.dot(&axis), to.perp(&axis).abs());
            if along <= 0.0 || aside > along * BEAM_RAD {
                return true;
            }
            let off = to.norm() - distance;
            let doubts = point.doubt_m + doubt_m;
            if off < -doubts {
                return false;
            }
            if range.is_some() && off < doubts && aside < merge_m {
                if point.doubt_m < doubt_m {
                    point.age_s = 0.0;
                    is_known = true;
                } else {
                    return false;
                }
            }
            true
        });
        if range.is_some() && !is_known {
            let at = place.position + axis * distance;
            self.remembered.push(Remembered { at, doubt_m, age_s: 0.0 });
        }
    }

    /// The points in the robot frame of the last scan.
    #[must_use]
    pub fn points(&self) -> &[Point2<f64>] {
        &self.points
    }
}

#[cfg(test)]
mod tests {
    use super::{MemoryConfig, SENSORS, Surroundings};
    use crate::arc::Place;
    use nalgebra::Point2;

    const REACH_M: f64 = 0.2;

    fn at(x: f64, heading_rad: f64) -> Place {
        Place { position: Point2::new(x, 0.0), heading_rad }
    }

    fn ahead(range: Option<f64>) -> [Option<f64>; SENSORS] {
        core::array::from_fn(|sensor| if sensor == 0 { range } else { None })
    }

    fn seen() -> Surroundings {
        let mut surroundings = Surroundings::new(MemoryConfig::default(), 3.0, 0.025);
        surroundings.see(at(0.0, 0.0), &ahead(Some(0.15)), REACH_M, 0.128);
        surroundings
    }

    #[test]
    fn a_point_stays_where_it_was_while_the_robot_moves() {
        let mut surroundings = seen();
        surroundings.see(at(0.1, 0.26), &ahead(None), REACH_M, 0.128);
        let [point] = surroundings.points() else { panic!("{:?}", surroundings.points()) };
        let expected = Point2::new(0.05 * libm::cos(0.26), -0.05 * libm::sin(0.26));
        assert!((point - expected).norm() < 1e-9, "{point} between two beams, expected {expected}");
    }

    #[test]
    fn a_nearer_reading_replaces_a_farther_one_and_a_free_beam_clears() {
        let mut surroundings = seen();
        surroundings.see(at(0.05, 0.0), &ahead(Some(0.103)), REACH_M, 0.128);
        assert_eq!(surroundings.points().len(), 1, "the same wall");
        assert!((surroundings.points()[0].x - 0.103).abs() < 1e-9, "the nearer reading is the better one");
        surroundings.see(at(0.05, 0.0), &ahead(None), REACH_M, 0.128);
        assert!(surroundings.points().is_empty(), "seen through");
    }

    #[test]
    fn what_is_not_seen_again_is_forgotten() {
        let mut surroundings = seen();
        surroundings.see(at(0.1, 0.26), &ahead(None), REACH_M, 3.0);
        assert!(surroundings.points().is_empty());
    }
}
