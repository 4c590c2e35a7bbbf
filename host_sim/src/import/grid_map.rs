//! A map of square cells, passable or not.

use nalgebra::{Point2, Vector2};

use crate::geometry::{Bounds, Polygon};
use crate::scenario::Shape;

/// Where a grid's lower left corner lies in the frame of its file, and how it is turned there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFrame {
    /// The corner, in m.
    pub origin: Point2<f64>,
    /// Anticlockwise, in rad.
    pub yaw_rad: f64,
}

impl MapFrame {
    /// Corner at zero, not turned.
    pub const IDENTITY: Self = Self { origin: Point2::new(0.0, 0.0), yaw_rad: 0.0 };

    /// A place of the file's frame in the grid's: from its lower left corner, x along rows, y up columns.
    #[must_use]
    pub fn to_grid(&self, place: Point2<f64>) -> Point2<f64> {
        let (cos, sin) = (libm::cos(self.yaw_rad), libm::sin(self.yaw_rad));
        let d = place - self.origin;
        Point2::new(cos * d.x + sin * d.y, cos * d.y - sin * d.x)
    }

    /// The other way round.
    #[must_use]
    pub fn from_grid(&self, place: Point2<f64>) -> Point2<f64> {
        let (cos, sin) = (libm::cos(self.yaw_rad), libm::sin(self.yaw_rad));
        self.origin + Vector2::new(cos * place.x - sin * place.y, sin * place.x + cos * place.y)
    }
}

/// A map of square cells. Its own frame has the lower left corner at zero; `frame` says where that is.
#[derive(Debug, Clone, PartialEq)]
pub struct GridMap {
    /// Its name.
    pub name: String,
    /// Where it comes from.
    pub source: String,
    /// Along x.
    pub columns: usize,
    /// Along y.
    pub rows: usize,
    /// Side of a cell in m.
    pub cell_m: f64,
    /// Where it lies.
    pub frame: MapFrame,
    /// Row by row from the bottom.
    pub passable: Vec<bool>,
}

impl GridMap {
    /// Whether the robot may be there; what is outside is not passable.
    #[must_use]
    pub fn is_passable(&self, column: usize, row: usize) -> bool {
        let inside = column < self.columns && row < self.rows;
        inside && self.passable.get(row * self.columns + column).copied().unwrap_or(false)
    }

    /// How many cells are passable.
    #[must_use]
    pub fn passable_cells(&self) -> usize {
        self.passable.iter().filter(|passable| **passable).count()
    }

    /// The middle of a cell in the grid's frame.
    #[must_use]
    pub fn middle(&self, column: usize, row: usize) -> Point2<f64> {
        Point2::new((float(column) + 0.5) * self.cell_m, (float(row) + 0.5) * self.cell_m)
    }

    /// The box around all cells in the grid's frame.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        let high = Point2::new(float(self.columns) * self.cell_m, float(self.rows) * self.cell_m);
        Bounds { low: Point2::origin(), high }
    }

    /// What is not passable as few rectangles, and the border of the map as walls.
    ///
    /// Each run of a row is joined with equal runs above it: not the fewest rectangles, but few, and found in one pass.
    #[must_use]
    pub fn shapes(&self) -> Vec<Shape> {
        let mut shapes = vec![self.border()];
        let mut open: Vec<Run> = Vec::new();
        for row in 0..=self.rows {
            let runs = self.runs(row);
            let (kept, done): (Vec<Run>, Vec<Run>) =
                open.into_iter().partition(|run| runs.contains(&(run.from, run.to)));
            shapes.extend(done.iter().filter_map(|run| self.rectangle(run, row)));
            let new =
                runs.iter().filter(|&&(from, to)| !kept.iter().any(|run| (run.from, run.to) == (from, to)));
            let new: Vec<Run> = new.map(|&(from, to)| Run { from, to, bottom: row }).collect();
            open = kept;
            open.extend(new);
            open.sort_by_key(|run| run.from);
        }
        shapes
    }

    fn border(&self) -> Shape {
        let Bounds { low, high } = self.bounds();
        let corners = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y), (low.x, low.y)];
        Shape::Line(corners.map(|(x, y)| Point2::new(x, y)).to_vec())
    }

    /// The runs of a row that are not passable, first column and the one behind the last; none above the map.
    fn runs(&self, row: usize) -> Vec<(usize, usize)> {
        let mut runs = Vec::new();
        let mut from = None;
        for column in 0..=self.columns {
            let blocked = row < self.rows && column < self.columns && !self.is_passable(column, row);
            match (blocked, from) {
                (true, None) => from = Some(column),
                (false, Some(first)) => {
                    runs.push((first, column));
                    from = None;
                }
                _ => {}
            }
        }
        runs
    }

    fn rectangle(&self, run: &Run, top: usize) -> Option<Shape> {
        let at =
            |column: usize, row: usize| Point2::new(float(column) * self.cell_m, float(row) * self.cell_m);
        let corners = [at(run.from, run.bottom), at(run.to, run.bottom), at(run.to, top), at(run.from, top)];
        Polygon::new(&corners).map(Shape::Polygon)
    }
}

/// A run of columns that goes up from `bottom`.
struct Run {
    from: usize,
    to: usize,
    bottom: usize,
}

/// Exact: grids have at most [`super::SIDE_MAX`] columns and rows.
fn float(index: usize) -> f64 {
    u32::try_from(index).map_or(f64::from(u32::MAX), f64::from)
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use proptest::prelude::{prop_assert, prop_assert_eq, proptest};

    use super::{GridMap, MapFrame};
    use crate::raster::Raster;
    use crate::scenario::Shape;

    fn map(columns: usize, rows: usize, passable: Vec<bool>) -> GridMap {
        let (name, source) = (String::new(), String::new());
        GridMap { name, source, columns, rows, cell_m: 0.1, frame: MapFrame::IDENTITY, passable }
    }

    #[test]
    fn equal_runs_above_each_other_are_one_rectangle() {
        let passable: Vec<bool> = "####.##.".chars().map(|cell| cell == '.').collect();
        let shapes = map(2, 4, passable).shapes();
        // The border, two full rows, one cell at the right, one at the left.
        assert_eq!(shapes.len(), 4, "{shapes:?}");
    }

    #[test]
    fn a_turned_frame_leads_there_and_back() {
        let frame = MapFrame { origin: Point2::new(-3.0, 2.0), yaw_rad: 0.7 };
        let place = Point2::new(1.5, -0.25);
        assert!((frame.from_grid(frame.to_grid(place)) - place).norm() < 1e-12);
        let quarter = MapFrame { origin: Point2::new(1.0, 0.0), yaw_rad: core::f64::consts::FRAC_PI_2 };
        assert!((quarter.from_grid(Point2::new(2.0, 0.0)) - Point2::new(1.0, 2.0)).norm() < 1e-12);
    }

    proptest! {
        /// Drawn again at the same cells, the rectangles give the map; in the simulator they are solid where it is not
        /// passable.
        #[test]
        fn the_rectangles_are_the_map(passable in proptest::collection::vec(proptest::bool::ANY, 7 * 5)) {
            let map = map(7, 5, passable);
            let shapes = map.shapes();
            let solid = &shapes[1..];
            let raster = Raster::within(map.bounds(), solid.iter(), 0.1).unwrap();
            for column in 0..7_u16 {
                for row in 0..5_u16 {
                    let (x, y) = (usize::from(column), usize::from(row));
                    prop_assert_eq!(raster.is_free(column, row), map.is_passable(x, y));
                    let holds = |shape: &Shape| matches!(shape, Shape::Polygon(p) if p.contains(map.middle(x, y)));
                    prop_assert_eq!(solid.iter().filter(|shape| holds(shape)).count() == 1, !map.is_passable(x, y));
                }
            }
            prop_assert!(map.passable_cells() <= 35);
        }
    }
}
