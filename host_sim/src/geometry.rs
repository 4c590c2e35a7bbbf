//! Plane shapes and the two questions asked of each: how far is a point from the surface, and which way is out.
//!
//! Everything is `f64` in metres. Distances to solid shapes (discs, polygons) are signed: negative inside. Only
//! `+ − × ÷` and `sqrt` are used, all correctly rounded, so that every platform computes the same bits.

use nalgebra::{Point2, Vector2};

/// The surface of a shape that is nearest to some point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Distance to the surface, in m; negative inside a solid shape.
    pub clearance_m: f64,
    /// Unit vector along which the clearance grows fastest: away from the surface, or out of the solid.
    pub normal: Vector2<f64>,
}

impl Nearest {
    /// The nearer of two surfaces, where inside counts as nearer than outside.
    #[must_use]
    pub fn nearer(self, other: Option<Self>) -> Self {
        match other {
            Some(candidate) if candidate.clearance_m < self.clearance_m => candidate,
            Some(_) | None => self,
        }
    }
}

/// A box along the axes around a shape, for rejecting the shape cheaply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Corner with the smallest coordinates.
    pub low: Point2<f64>,
    /// Corner with the largest coordinates.
    pub high: Point2<f64>,
}

impl Bounds {
    /// The box around one point.
    #[must_use]
    pub const fn of_point(point: Point2<f64>) -> Self {
        Self { low: point, high: point }
    }

    /// The smallest box around all `points`; `None` if there are none.
    #[must_use]
    pub fn of_points(points: &[Point2<f64>]) -> Option<Self> {
        let (first, rest) = points.split_first()?;
        Some(rest.iter().fold(Self::of_point(*first), |bounds, point| bounds.union(&Self::of_point(*point))))
    }

    /// The smallest box around both boxes.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    /// The box with every side moved outwards by `margin_m`.
    #[must_use]
    pub fn grown(&self, margin_m: f64) -> Self {
        let margin = Vector2::new(margin_m, margin_m);
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// The point of the box that is nearest to `point`.
    #[must_use]
    pub fn closest_point(&self, point: Point2<f64>) -> Point2<f64> {
        point.sup(&self.low).inf(&self.high)
    }

    /// Square of the distance from `point` to the box, in m²; zero inside.
    #[must_use]
    pub fn distance_squared(&self, point: Point2<f64>) -> f64 {
        (self.closest_point(point) - point).norm_squared()
    }

    /// Whether `point` lies in the box or on its edge.
    #[must_use]
    pub fn contains(&self, point: Point2<f64>) -> bool {
        self.low.x <= point.x && point.x <= self.high.x && self.low.y <= point.y && point.y <= self.high.y
    }
}

/// A straight wall of zero thickness, or one edge of a polygon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    start: Point2<f64>,
    /// Kept although `start + edge` comes close: neighbouring edges of a polygon must share their corner exactly.
    end: Point2<f64>,
    edge: Vector2<f64>,
    /// 1 / |edge|², zero for a segment of no length: division is the dearest step of the inner loop.
    inverse_length_squared: f64,
}

impl Segment {
    /// The segment between two points, which may be equal.
    #[must_use]
    pub fn new(start: Point2<f64>, end: Point2<f64>) -> Self {
        let edge = end - start;
        let length_squared = edge.norm_squared();
        let inverse_length_squared = if length_squared > 0.0 { 1.0 / length_squared } else { 0.0 };
        Self { start, end, edge, inverse_length_squared }
    }

    /// First end.
    #[must_use]
    pub const fn start(&self) -> Point2<f64> {
        self.start
    }

    /// Second end.
    #[must_use]
    pub const fn end(&self) -> Point2<f64> {
        self.end
    }

    /// Vector from the first end to the second.
    #[must_use]
    pub const fn edge(&self) -> Vector2<f64> {
        self.edge
    }

    /// The box around the segment.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds::of_point(self.start).union(&Bounds::of_point(self.end()))
    }

    /// The point of the segment that is nearest to `point`.
    #[must_use]
    pub fn closest_point(&self, point: Point2<f64>) -> Point2<f64> {
        let along = ((point - self.start).dot(&self.edge) * self.inverse_length_squared).clamp(0.0, 1.0);
        self.start + self.edge * along
    }

    /// Square of the distance from `point` to the segment, in m².
    #[must_use]
    pub fn distance_squared(&self, point: Point2<f64>) -> f64 {
        (self.closest_point(point) - point).norm_squared()
    }

    /// The surface as seen from `point`. A point exactly on the segment is sent to its left.
    #[must_use]
    pub fn nearest(&self, point: Point2<f64>) -> Nearest {
        let away = point - self.closest_point(point);
        let clearance_m = away.norm();
        let left = Vector2::new(-self.edge.y, self.edge.x);
        Nearest { clearance_m, normal: unit_or(away, left) }
    }

    /// Whether two segments share at least one point.
    ///
    /// Touching counts. Parallel overlap is found through the ends.
    #[must_use]
    pub fn meets(&self, other: &Self) -> bool {
        let side = |of: &Self, point: Point2<f64>| of.edge.perp(&(point - of.start));
        let crosses = |of: &Self, by: &Self| side(of, by.start) * side(of, by.end()) < 0.0;
        let touches = |of: &Self, point: Point2<f64>| of.distance_squared(point) <= 0.0;
        (crosses(self, other) && crosses(other, self))
            || touches(self, other.start)
            || touches(self, other.end())
            || touches(other, self.start)
            || touches(other, self.end())
    }

    /// Smallest and largest distance from `point` to the segment's points, in m.
    #[must_use]
    pub fn distance_range(&self, point: Point2<f64>) -> (f64, f64) {
        let nearest = self.distance_squared(point).sqrt();
        let furthest = (self.start - point).norm().max((self.end() - point).norm());
        (nearest, furthest)
    }
}

/// A solid disc: a round post, or another robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Centre.
    pub centre: Point2<f64>,
    /// Radius in m, positive.
    pub radius_m: f64,
}

impl Disc {
    /// The box around the disc.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds::of_point(self.centre).grown(self.radius_m)
    }

    /// Signed distance from `point` to the edge, in m.
    #[must_use]
    pub fn clearance(&self, point: Point2<f64>) -> f64 {
        (point - self.centre).norm() - self.radius_m
    }

    /// The surface as seen from `point`. The centre, which has no nearest surface, is sent along +x.
    #[must_use]
    pub fn nearest(&self, point: Point2<f64>) -> Nearest {
        Nearest { clearance_m: self.clearance(point), normal: unit_or(point - self.centre, Vector2::x()) }
    }
}

/// A solid simple polygon, convex or not.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Edges in anticlockwise order, so that the outside is always on the right.
    edges: Vec<Segment>,
    bounds: Bounds,
}

impl Polygon {
    /// The polygon through `vertices` (either order, closed by itself); `None` if it encloses no area.
    #[must_use]
    pub fn new(vertices: &[Point2<f64>]) -> Option<Self> {
        let bounds = Bounds::of_points(vertices)?;
        let doubled_area: f64 = ring(vertices).map(|(from, to)| from.coords.perp(&to.coords)).sum();
        let edges = if doubled_area > 0.0 {
            ring(vertices).map(|(from, to)| Segment::new(from, to)).collect()
        } else if doubled_area < 0.0 {
            ring(vertices).map(|(from, to)| Segment::new(to, from)).rev().collect()
        } else {
            return None;
        };
        Some(Self { edges, bounds })
    }

    /// The edges, anticlockwise.
    #[must_use]
    pub fn edges(&self) -> &[Segment] {
        &self.edges
    }

    /// The corners, anticlockwise.
    pub fn vertices(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        self.edges.iter().map(Segment::start)
    }

    /// The box around the polygon.
    #[must_use]
    pub const fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Whether no two edges meet, except neighbours at their common corner.
    #[must_use]
    pub fn is_simple(&self) -> bool {
        let count = self.edges.len();
        let neighbours = |i: usize, j: usize| j - i == 1 || (i == 0 && j == count - 1);
        self.edges.iter().enumerate().all(|(i, edge)| {
            let rest = self.edges.iter().enumerate().skip(i + 1);
            rest.filter(|(j, _)| !neighbours(i, *j)).all(|(_, other)| !edge.meets(other))
        })
    }

    /// Whether `point` is inside. Points on an edge may be counted either way.
    #[must_use]
    pub fn contains(&self, point: Point2<f64>) -> bool {
        self.bounds.contains(point)
            && self.edges.iter().filter(|edge| crosses_rightward_ray(edge, point)).count() % 2 == 1
    }

    /// Signed distance from `point` to the outline, in m.
    #[must_use]
    pub fn clearance(&self, point: Point2<f64>) -> f64 {
        let squares = self.edges.iter().map(|edge| edge.distance_squared(point));
        let distance = squares.fold(f64::INFINITY, f64::min).sqrt();
        if self.contains(point) { -distance } else { distance }
    }

    /// The surface as seen from `point`. A point exactly on an edge is sent outwards.
    #[must_use]
    pub fn nearest(&self, point: Point2<f64>) -> Nearest {
        let closer =
            |a: &&Segment, b: &&Segment| a.distance_squared(point).total_cmp(&b.distance_squared(point));
        let Some(edge) = self.edges.iter().min_by(closer) else {
            return Nearest { clearance_m: f64::INFINITY, normal: Vector2::x() };
        };
        let away = point - edge.closest_point(point);
        let outward = Vector2::new(edge.edge.y, -edge.edge.x);
        if self.contains(point) {
            Nearest { clearance_m: -away.norm(), normal: unit_or(-away, outward) }
        } else {
            Nearest { clearance_m: away.norm(), normal: unit_or(away, outward) }
        }
    }
}

/// Each vertex with the next one, the last with the first.
fn ring(
    vertices: &[Point2<f64>],
) -> impl DoubleEndedIterator<Item = (Point2<f64>, Point2<f64>)> + ExactSizeIterator + '_ {
    let next = |i: usize| if i + 1 == vertices.len() { 0 } else { i + 1 };
    (0..vertices.len()).map(move |i| (vertices[i], vertices[next(i)]))
}

/// Whether the ray from `point` along +x crosses the edge; half-open in y, so that a shared corner counts once.
fn crosses_rightward_ray(edge: &Segment, point: Point2<f64>) -> bool {
    let (from, to) = (edge.start(), edge.end());
    if (from.y > point.y) == (to.y > point.y) {
        return false;
    }
    let side = edge.edge().perp(&(point - from));
    if to.y > from.y { side > 0.0 } else { side < 0.0 }
}

/// `direction` at length one, or `fallback` at length one if `direction` has none, or +x if neither has.
fn unit_or(direction: Vector2<f64>, fallback: Vector2<f64>) -> Vector2<f64> {
    let unit = |v: Vector2<f64>| v.try_normalize(0.0);
    unit(direction).or_else(|| unit(fallback)).unwrap_or_else(Vector2::x)
}
