//! What one range sensor sees: the nearest surface point inside a cone.
//!
//! A pencil ray misses a thin post beside it; a real sensor does not. A [`Beam`] therefore has a width, and a range is
//! the exact smallest distance from the apex to any surface point within that width, not a sample over rays.

use nalgebra::{Point2, Vector2};

use crate::geometry::{Disc, Segment};

/// The cone of a sensor: a direction and a half-width below 90°, with its two edge rays worked out once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    axis: Vector2<f64>,
    left: Vector2<f64>,
    right: Vector2<f64>,
}

impl Beam {
    /// The beam along `axis_rad` (anticlockwise from +x) that is `2 * half_width_rad` wide; zero is a pencil ray.
    ///
    /// # Panics
    ///
    /// If the half-width is not in `0 .. π/2`: a wider cone is not convex, which the range computation relies on.
    #[must_use]
    pub fn new(axis_rad: f64, half_width_rad: f64) -> Self {
        let valid = (0.0..core::f64::consts::FRAC_PI_2).contains(&half_width_rad);
        assert!(valid, "half-width {half_width_rad} rad is not in 0 .. pi/2");
        let along = |angle: f64| Vector2::new(libm::cos(angle), libm::sin(angle));
        let (axis, left) = (along(axis_rad), along(axis_rad + half_width_rad));
        Self { axis, left, right: along(axis_rad - half_width_rad) }
    }

    /// The same beam turned anticlockwise by an angle given by its cosine and sine.
    ///
    /// A robot's beams are made once in its body frame and turned by its heading: one pair of trigonometric calls per
    /// scan instead of three per beam.
    #[must_use]
    pub fn turned(&self, cos: f64, sin: f64) -> Self {
        let turn = |v: Vector2<f64>| Vector2::new(v.x * cos - v.y * sin, v.x * sin + v.y * cos);
        Self { axis: turn(self.axis), left: turn(self.left), right: turn(self.right) }
    }

    /// Unit vector along the middle of the beam.
    #[must_use]
    pub const fn axis(&self) -> Vector2<f64> {
        self.axis
    }

    /// Whether a vector from the apex lies within the cone, edges included.
    #[must_use]
    pub fn covers(&self, offset: Vector2<f64>) -> bool {
        // The last test tells the cone from its mirror image behind the apex when the width is zero.
        self.right.perp(&offset) >= 0.0 && offset.perp(&self.left) >= 0.0 && self.axis.dot(&offset) >= 0.0
    }

    /// Smallest distance from `apex` to a point of the segment inside the beam, infinite if there is none.
    ///
    /// `closest` is the offset from the apex to the segment's nearest point, which a caller with many beams at one apex
    /// computes once.
    #[must_use]
    pub fn distance_to_segment(&self, apex: Point2<f64>, segment: &Segment, closest: Vector2<f64>) -> f64 {
        if self.covers(closest) {
            return closest.norm();
        }
        // The part of the segment inside the cone is one piece, since the cone is convex. It does not hold the closest
        // point, and distance grows away from that point: so its nearest end is where the segment enters the cone.
        let start = segment.start() - apex;
        ray_to_segment(self.left, start, segment.edge()).min(ray_to_segment(
            self.right,
            start,
            segment.edge(),
        ))
    }

    /// Smallest distance from `apex` to a point of the disc's edge inside the beam, infinite if there is none.
    #[must_use]
    pub fn distance_to_disc(&self, apex: Point2<f64>, disc: &Disc) -> f64 {
        let centre = disc.centre - apex;
        let distance = centre.norm();
        let inside = distance < disc.radius_m;
        // Seen from outside the edge is nearest towards the centre, from inside it is nearest away from the centre;
        // further off that direction it only recedes, so that otherwise an edge ray of the cone meets it first.
        if self.covers(if inside { -centre } else { centre }) {
            return (distance - disc.radius_m).abs();
        }
        ray_to_circle(self.left, centre, disc.radius_m).min(ray_to_circle(self.right, centre, disc.radius_m))
    }
}

/// Distance along the unit `ray` to the segment that begins at offset `start`, infinite if they do not cross.
fn ray_to_segment(ray: Vector2<f64>, start: Vector2<f64>, edge: Vector2<f64>) -> f64 {
    let denominator = ray.perp(&edge);
    // along · denominator is the position on the ray, across · denominator that on the segment: compared before the
    // division, which most pairs never reach. A parallel pair fails the strict comparison with zero.
    let (along, across) = (start.perp(&edge), start.perp(&ray));
    let crosses = if denominator > 0.0 {
        along >= 0.0 && across >= 0.0 && across <= denominator
    } else {
        denominator < 0.0 && along <= 0.0 && across <= 0.0 && across >= denominator
    };
    if crosses { along / denominator } else { f64::INFINITY }
}

/// Distance along the unit `ray` to the first crossing with the circle around `centre`, infinite if it misses.
fn ray_to_circle(ray: Vector2<f64>, centre: Vector2<f64>, radius_m: f64) -> f64 {
    let along = ray.dot(&centre);
    let aside = ray.perp(&centre);
    let half_chord_squared = radius_m * radius_m - aside * aside;
    if half_chord_squared < 0.0 {
        return f64::INFINITY;
    }
    let half_chord = half_chord_squared.sqrt();
    let (enters, leaves) = (along - half_chord, along + half_chord);
    if enters >= 0.0 {
        enters
    } else if leaves >= 0.0 {
        leaves
    } else {
        f64::INFINITY
    }
}
