//! A set of shapes that stand still.

use nalgebra::Point2;

use crate::beam::Beam;
use crate::geometry::{Bounds, Disc, Nearest, Polygon, Segment};

/// Walls and obstacles that do not move.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Solids {
    /// Walls of zero thickness.
    pub segments: Vec<Segment>,
    /// Round posts.
    pub discs: Vec<Disc>,
    /// Solid blocks and thick walls.
    pub polygons: Vec<Polygon>,
}

impl Solids {
    /// Signed distance from `point` to the nearest surface in m, infinite if there is none.
    #[must_use]
    pub fn clearance(&self, point: Point2<f64>) -> f64 {
        let squares = self.segments.iter().map(|segment| segment.distance_squared(point));
        let mut best = squares.fold(f64::INFINITY, f64::min).sqrt();
        for disc in &self.discs {
            best = best.min(disc.clearance(point));
        }
        for polygon in &self.polygons {
            // Inside a box the distance to it is zero, so a polygon that may hold the point is never skipped.
            let boxed = polygon.bounds().distance_squared(point);
            if boxed <= 0.0 || boxed < best * best {
                best = best.min(polygon.clearance(point));
            }
        }
        best
    }

    /// The surface nearest to `point`; `None` if there is none.
    #[must_use]
    pub fn nearest(&self, point: Point2<f64>) -> Option<Nearest> {
        let segments = self.segments.iter().map(|segment| segment.nearest(point));
        let discs = self.discs.iter().map(|disc| disc.nearest(point));
        let polygons = self.polygons.iter().map(|polygon| polygon.nearest(point));
        segments.chain(discs).chain(polygons).reduce(|best, next| best.nearer(Some(next)))
    }

    /// Lowers each beam's range to the nearest surface point inside that beam, if that is nearer and within
    /// `range_max_m`.
    pub fn scan(&self, apex: Point2<f64>, beams: &[Beam], range_max_m: f64, ranges: &mut [f64]) {
        for segment in &self.segments {
            scan_segment(segment, apex, beams, range_max_m, ranges);
        }
        for disc in &self.discs {
            scan_disc(disc, apex, beams, range_max_m, ranges);
        }
        for polygon in &self.polygons {
            if polygon.bounds().distance_squared(apex) > range_max_m * range_max_m {
                continue;
            }
            for edge in polygon.edges() {
                scan_segment(edge, apex, beams, range_max_m, ranges);
            }
        }
    }

    /// The box around everything; `None` if there is nothing.
    #[must_use]
    pub fn bounds(&self) -> Option<Bounds> {
        let segments = self.segments.iter().map(Segment::bounds);
        let discs = self.discs.iter().map(Disc::bounds);
        let polygons = self.polygons.iter().map(|polygon| *polygon.bounds());
        segments.chain(discs).chain(polygons).reduce(|all, next| all.union(&next))
    }
}

fn scan_segment(segment: &Segment, apex: Point2<f64>, beams: &[Beam], range_max_m: f64, ranges: &mut [f64]) {
    let closest = segment.closest_point(apex) - apex;
    let distance_squared = closest.norm_squared();
    if distance_squared > range_max_m * range_max_m {
        return;
    }
    for (beam, range) in beams.iter().zip(ranges) {
        if distance_squared < *range * *range {
            lower(range, beam.distance_to_segment(apex, segment, closest), range_max_m);
        }
    }
}

/// As [`Solids::scan`], for one disc that is not in a set because it moves.
pub(crate) fn scan_disc(
    disc: &Disc,
    apex: Point2<f64>,
    beams: &[Beam],
    range_max_m: f64,
    ranges: &mut [f64],
) {
    let distance = disc.clearance(apex).abs();
    if distance > range_max_m {
        return;
    }
    for (beam, range) in beams.iter().zip(ranges) {
        if distance < *range {
            lower(range, beam.distance_to_disc(apex, disc), range_max_m);
        }
    }
}

fn lower(range: &mut f64, candidate: f64, range_max_m: f64) {
    if candidate <= range_max_m && candidate < *range {
        *range = candidate;
    }
}
