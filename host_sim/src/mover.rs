//! A robot that circles: the moving obstacle of both papers.

use nalgebra::{Point2, Vector2};

use crate::geometry::{Disc, Segment};
use crate::solids::Solids;

/// Which way round a mover goes, seen from above.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// Against the clock, as in the papers.
    #[default]
    Anticlockwise,
    /// With the clock.
    Clockwise,
}

/// A disc whose centre goes round a circle at constant speed, whatever it meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mover {
    /// Centre of the circle.
    pub centre: Point2<f64>,
    /// Radius of the circle in m, positive.
    pub orbit_radius_m: f64,
    /// Radius of the disc in m, positive.
    pub radius_m: f64,
    /// Signed angular speed in rad/s, anticlockwise positive.
    rate_rad_s: f64,
    /// Bearing of the disc from the circle's centre at time zero, in rad.
    phase_rad: f64,
    /// In each run the bearing is drawn uniformly from ± this angle around [`Mover::new`]'s, in rad; see
    /// [`World::of_run`](crate::world::World::of_run).
    pub phase_jitter_rad: f64,
}

impl Mover {
    /// A mover of the given speed along its circle, in m/s.
    #[must_use]
    pub fn new(
        centre: Point2<f64>,
        orbit_radius_m: f64,
        radius_m: f64,
        speed_m_s: f64,
        direction: Direction,
        phase_rad: f64,
    ) -> Self {
        let sign = match direction {
            Direction::Anticlockwise => 1.0,
            Direction::Clockwise => -1.0,
        };
        let rate_rad_s = sign * speed_m_s / orbit_radius_m;
        Self { centre, orbit_radius_m, radius_m, rate_rad_s, phase_rad, phase_jitter_rad: 0.0 }
    }

    /// The same, with a bearing at time zero that is drawn in each run.
    #[must_use]
    pub const fn with_phase_jitter(self, phase_jitter_rad: f64) -> Self {
        Self { phase_jitter_rad, ..self }
    }

    /// The same, further along its circle by an angle in rad, anticlockwise positive; it goes the same way round.
    #[must_use]
    pub fn turned_by(self, angle_rad: f64) -> Self {
        Self { phase_rad: self.phase_rad + angle_rad, ..self }
    }

    /// Whether both go round the same circle and never come nearer to each other.
    #[must_use]
    pub fn keeps_apart_from(&self, other: &Self) -> bool {
        let same = |a: f64, b: f64| a.to_bits() == b.to_bits();
        same(self.centre.x, other.centre.x)
            && same(self.centre.y, other.centre.y)
            && same(self.orbit_radius_m, other.orbit_radius_m)
            && same(self.rate_rad_s, other.rate_rad_s)
    }

    /// Speed along the circle in m/s.
    #[must_use]
    pub fn speed_m_s(&self) -> f64 {
        self.rate_rad_s.abs() * self.orbit_radius_m
    }

    /// Which way round it goes.
    #[must_use]
    pub fn direction(&self) -> Direction {
        if self.rate_rad_s < 0.0 { Direction::Clockwise } else { Direction::Anticlockwise }
    }

    /// The disc at time `t_s`.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Disc {
        let (sin, cos) = libm::sincos(self.phase_rad + self.rate_rad_s * t_s);
        Disc { centre: self.centre + Vector2::new(cos, sin) * self.orbit_radius_m, radius_m: self.radius_m }
    }

    /// Distance in m from `point` to the ring that the disc sweeps, negative inside the ring: the least clearance
    /// that the point ever has from this mover.
    #[must_use]
    pub fn least_clearance(&self, point: Point2<f64>) -> f64 {
        ((point - self.centre).norm() - self.orbit_radius_m).abs() - self.radius_m
    }

    /// Distance in m from the swept ring to the nearest of the shapes, not positive if the mover runs into one: how
    /// deeply is not told.
    #[must_use]
    pub fn least_clearance_from(&self, solids: &Solids) -> f64 {
        let to_segment = |segment: &Segment| self.ring_gap(segment.distance_range(self.centre));
        let thin = solids.segments.iter().map(to_segment);
        let outlines = solids.polygons.iter().flat_map(|polygon| polygon.edges().iter().map(to_segment));
        let discs = solids.discs.iter().map(|disc| {
            let distance = (disc.centre - self.centre).norm();
            self.ring_gap(((distance - disc.radius_m).max(0.0), distance + disc.radius_m))
        });
        // A ring that meets no outline is wholly inside or outside each polygon: any point of it tells which.
        let somewhere = self.at(0.0).centre;
        let swallowed = solids.polygons.iter().any(|polygon| polygon.contains(somewhere));
        let gap = thin.chain(outlines).chain(discs).fold(f64::INFINITY, f64::min);
        if swallowed { -gap.abs() } else { gap }
    }

    /// Gap between the ring and a connected shape whose points lie between two distances from the circle's centre.
    fn ring_gap(&self, (nearest_m, furthest_m): (f64, f64)) -> f64 {
        let off_orbit = if furthest_m < self.orbit_radius_m {
            self.orbit_radius_m - furthest_m
        } else {
            (nearest_m - self.orbit_radius_m).max(0.0)
        };
        off_orbit - self.radius_m
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::FRAC_PI_2;

    use nalgebra::Point2;

    use super::{Direction, Mover};

    fn mover(direction: Direction) -> Mover {
        Mover::new(Point2::new(1.0, 2.0), 0.1, 0.025, 0.05, direction, 0.0)
    }

    #[test]
    fn a_quarter_of_the_circle_takes_a_quarter_of_its_length_over_the_speed() {
        let quarter_s = FRAC_PI_2 * 0.1 / 0.05;
        for (direction, y) in [(Direction::Anticlockwise, 2.1), (Direction::Clockwise, 1.9)] {
            let mover = mover(direction);
            assert_eq!(mover.direction(), direction);
            assert!((mover.at(0.0).centre - Point2::new(1.1, 2.0)).norm() < 1e-12);
            assert!((mover.at(quarter_s).centre - Point2::new(1.0, y)).norm() < 1e-12);
        }
    }

    #[test]
    fn its_speed_is_what_was_asked_for() {
        let mover = mover(Direction::Clockwise);
        let step_m = (mover.at(3.001).centre - mover.at(3.0).centre).norm();
        assert!((mover.speed_m_s() - 0.05).abs() < 1e-12);
        assert!((step_m / 0.001 - 0.05).abs() < 1e-6);
    }
}
