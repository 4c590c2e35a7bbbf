//! A set of shapes that stand still.

mod index;

use nalgebra::Point2;

pub use index::Index;

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
    /// Which of them are near; none for few shapes, which are asked one by one. See [`Solids::indexed`].
    pub index: Option<Index>,
}

/// So many shapes are worth an index.
const MANY: usize = 100;

impl Solids {
    /// The same, with an index if there are many. To be made when all shapes are there.
    #[must_use]
    pub fn indexed(mut self) -> Self {
        let segments = self.segments.iter().map(Segment::bounds);
        let discs = self.discs.iter().map(Disc::bounds);
        let boxes: Vec<Bounds> =
            segments.chain(discs).chain(self.polygons.iter().map(|polygon| *polygon.bounds())).collect();
        self.index = if boxes.len() < MANY { None } else { Index::new(&boxes) };
        self
    }

    /// The shape of a number of the index: segments first, then discs, then polygons.
    fn numbered(&self, number: usize) -> Numbered<'_> {
        if let Some(segment) = self.segments.get(number) {
            return Numbered::Segment(segment);
        }
        let number = number - self.segments.len();
        self.discs
            .get(number)
            .map_or_else(|| Numbered::Polygon(&self.polygons[number - self.discs.len()]), Numbered::Disc)
    }

    /// Signed distance from `point` to the nearest surface in m, infinite if there is none.
    #[must_use]
    pub fn clearance(&self, point: Point2<f64>) -> f64 {
        if let Some(index) = &self.index {
            return index.least(point, |number| match self.numbered(number) {
                Numbered::Segment(segment) => segment.distance_squared(point).sqrt(),
                Numbered::Disc(disc) => disc.clearance(point),
                Numbered::Polygon(polygon) => polygon.clearance(point),
            });
        }
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
        if let Some(index) = &self.index {
            let around = Bounds::of_point(apex).grown(range_max_m);
            index.near(&around, |number| match self.numbered(number) {
                Numbered::Segment(segment) => scan_segment(segment, apex, beams, range_max_m, ranges),
                Numbered::Disc(disc) => scan_disc(disc, apex, beams, range_max_m, ranges),
                Numbered::Polygon(polygon) => scan_polygon(polygon, apex, beams, range_max_m, ranges),
            });
            return;
        }
        for segment in &self.segments {
            scan_segment(segment, apex, beams, range_max_m, ranges);
        }
        for disc in &self.discs {
            scan_disc(disc, apex, beams, range_max_m, ranges);
        }
        for polygon in &self.polygons {
            scan_polygon(polygon, apex, beams, range_max_m, ranges);
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

/// A shape by its number.
enum Numbered<'a> {
    Segment(&'a Segment),
    Disc(&'a Disc),
    Polygon(&'a Polygon),
}

fn scan_polygon(polygon: &Polygon, apex: Point2<f64>, beams: &[Beam], range_max_m: f64, ranges: &mut [f64]) {
    if polygon.bounds().distance_squared(apex) > range_max_m * range_max_m {
        return;
    }
    for edge in polygon.edges() {
        scan_segment(edge, apex, beams, range_max_m, ranges);
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

#[cfg(test)]
mod tests {
    use nalgebra::{Point2, Vector2};
    use proptest::prelude::{prop_assert_eq, proptest};

    use super::Solids;
    use crate::beam::Beam;
    use crate::geometry::{Disc, Polygon, Segment};

    /// Shapes of all kinds, over 8 m x 4 m.
    fn many(places: &[(f64, f64, f64)]) -> Solids {
        let mut solids = Solids::default();
        for (i, &(x, y, size)) in places.iter().enumerate() {
            let at = Point2::new(x, y);
            match i % 3 {
                0 => solids.segments.push(Segment::new(at, at + Vector2::new(3.0 * size, -size))),
                1 => solids.discs.push(Disc { centre: at, radius_m: size }),
                _ => {
                    let corners = [(0.0, 0.0), (size, 0.0), (size, 2.0 * size), (0.0, size)];
                    let corners = corners.map(|(dx, dy)| at + Vector2::new(dx, dy));
                    solids.polygons.extend(Polygon::new(&corners));
                }
            }
        }
        solids
    }

    proptest! {
        /// The index changes no bit of an answer, also for places outside of everything.
        #[test]
        fn with_an_index_the_answers_are_the_same(
            places in proptest::collection::vec((0.0..8.0_f64, 0.0..4.0_f64, 0.01..0.4_f64), 100..140),
            from in (-3.0..11.0_f64, -3.0..7.0_f64),
            range in 0.05..1.0_f64,
        ) {
            let plain = many(&places);
            let indexed = plain.clone().indexed();
            assert!(indexed.index.is_some());
            let point = Point2::new(from.0, from.1);
            prop_assert_eq!(indexed.clearance(point).to_bits(), plain.clearance(point).to_bits());
            let beams = [0.0, 0.8, 1.6, 2.4, 3.2, 4.0, 4.8, 5.6].map(|axis| Beam::new(axis, 0.13));
            let [mut with, mut without] = [[f64::INFINITY; 8]; 2];
            indexed.scan(point, &beams, range, &mut with);
            plain.scan(point, &beams, range, &mut without);
            prop_assert_eq!(with.map(f64::to_bits), without.map(f64::to_bits));
        }
    }

    #[test]
    fn few_shapes_have_no_index() {
        assert!(many(&[(0.0, 0.0, 0.1)]).indexed().index.is_none());
    }
}
