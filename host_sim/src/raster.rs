//! The planner's map: a grid over the known walls, in which a cell is free only if nothing known is in it.
//!
//! The map errs on the safe side. Thin walls block every cell they touch, also those they only run along, so that no
//! wall is lost between two cells. Solid shapes block every cell they share area with.

use nalgebra::Point2;

use crate::geometry::{Bounds, Segment};
use crate::number::narrow;
use crate::scenario::Shape;

/// Chosen to be far below any size that matters and far above rounding: a wall drawn along a cell's border touches it
/// whatever the last bit says, and a solid that merely borders on a cell does not.
const HAIR_M: f64 = 1e-9;

/// Most columns or rows; the planner's map types are 16 bits wide.
const SIDE_MAX: f64 = 65535.0;

/// Why a map cannot be drawn.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RasterError {
    /// The cell size makes no sense.
    #[error("cell size {0} m is not a positive number")]
    CellSize(f64),
    /// The grid would have too many cells.
    #[error("cells of {0} m make more than 65535 columns or rows; use larger cells")]
    TooManyCells(f64),
    /// There is nothing on the map, not even an edge.
    #[error("the scenario has no known walls to draw a map of; add walls around the robot and its goal")]
    NoWalls,
}

/// Bits of a word of [`Raster::walls`].
const WORD: usize = 64;

/// A grid of free and blocked cells; column 0, row 0 is at the lowest x and y.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    columns: u16,
    rows: u16,
    cell_size_m: f64,
    origin: Point2<f64>,
    /// Row by row from the bottom.
    free: Vec<bool>,
    /// Which cells are not free, one bit each, column by column, every column in whole words and one more: what the
    /// planner asks for most. Set as well are the bits above the map.
    walls: Vec<u64>,
}

impl Raster {
    /// The grid over the box around `shapes`, rounded up to whole cells at the far sides.
    ///
    /// # Errors
    ///
    /// If the cell size is not positive or too small, or there are no shapes.
    pub fn of<'a>(
        shapes: impl Iterator<Item = &'a Shape> + Clone,
        cell_size_m: f64,
    ) -> Result<Self, RasterError> {
        // Said first, since a wrong cell size is wrong for any map.
        check_cell_size(cell_size_m)?;
        let bounds = shapes.clone().filter_map(bounds_of).reduce(|all, next| all.union(&next));
        Self::within(bounds.ok_or(RasterError::NoWalls)?, shapes, cell_size_m)
    }

    /// The grid over a given box, rounded up to whole cells at the far sides; what reaches beyond is cut off.
    ///
    /// # Errors
    ///
    /// If the cell size is not positive or too small.
    pub fn within<'a>(
        bounds: Bounds,
        shapes: impl Iterator<Item = &'a Shape>,
        cell_size_m: f64,
    ) -> Result<Self, RasterError> {
        check_cell_size(cell_size_m)?;
        let size = bounds.high - bounds.low;
        let cells = |length_m: f64| whole(((length_m - HAIR_M) / cell_size_m).ceil().max(1.0));
        let (Some(columns), Some(rows)) = (cells(size.x), cells(size.y)) else {
            return Err(RasterError::TooManyCells(cell_size_m));
        };
        let free = vec![true; usize::from(columns) * usize::from(rows)];
        let mut raster = Self { columns, rows, cell_size_m, origin: bounds.low, free, walls: Vec::new() };
        for shape in shapes {
            raster.block(shape);
        }
        raster.index_walls();
        Ok(raster)
    }

    /// The same map with x and y exchanged.
    #[must_use]
    pub fn transposed(&self) -> Self {
        let cells = (0..self.columns).flat_map(|row| (0..self.rows).map(move |column| (row, column)));
        let mut transposed = Self {
            columns: self.rows,
            rows: self.columns,
            cell_size_m: self.cell_size_m,
            origin: Point2::new(self.origin.y, self.origin.x),
            free: cells.map(|(column, row)| self.is_free(column, row)).collect(),
            walls: Vec::new(),
        };
        transposed.index_walls();
        transposed
    }

    fn index_walls(&mut self) {
        let words = self.words();
        self.walls = vec![u64::MAX; usize::from(self.columns) * words];
        for (index, _) in self.free.iter().enumerate().filter(|(_, free)| **free) {
            let (row, column) = (index / usize::from(self.columns), index % usize::from(self.columns));
            self.walls[column * words + row / WORD] &= !(1 << (row % WORD));
        }
    }

    /// Words of a column; the last has none of its rows, so that a row's word is never the last.
    fn words(&self) -> usize {
        usize::from(self.rows) / WORD + 2
    }

    /// The first row from `row` upwards that is not free in a column of the raster; the number of rows when all are.
    #[must_use]
    pub fn next_wall(&self, column: u16, row: u16) -> u16 {
        let mut row = row;
        while row < self.rows {
            let walls = self.walls(column, row);
            if walls != 0 {
                return row.saturating_add(u16::try_from(walls.trailing_zeros()).unwrap_or(0)).min(self.rows);
            }
            row = row.saturating_add(64);
        }
        self.rows
    }

    /// Which of the 64 cells from `row` upwards in a column are not free, one bit each, that of `row` the lowest; those
    /// above the map are not.
    #[must_use]
    pub fn walls(&self, column: u16, row: u16) -> u64 {
        let (row, shift) = (usize::from(row) / WORD, row % 64);
        let first = usize::from(column) * self.words() + row;
        let Some(&[low, high]) = self.walls.get(first..first + 2).filter(|_| row + 1 < self.words()) else {
            return u64::MAX;
        };
        low >> shift | high << 1 << (63 - shift)
    }

    /// Number of columns, along x.
    #[must_use]
    pub const fn columns(&self) -> u16 {
        self.columns
    }

    /// Number of rows, along y.
    #[must_use]
    pub const fn rows(&self) -> u16 {
        self.rows
    }

    /// Side of a cell in m.
    #[must_use]
    pub fn cell_size_m(&self) -> f32 {
        narrow(self.cell_size_m)
    }

    /// The outer corner of column 0, row 0, in m.
    #[must_use]
    pub fn origin_m(&self) -> (f32, f32) {
        (narrow(self.origin.x), narrow(self.origin.y))
    }

    /// Whether nothing known is in the cell; cells outside the grid are not free.
    #[must_use]
    pub fn is_free(&self, column: u16, row: u16) -> bool {
        let inside = column < self.columns && row < self.rows;
        inside && self.free[self.index(column, row)]
    }

    /// The cell that a place is in; `None` outside of the grid.
    #[must_use]
    pub fn cell_at(&self, place: Point2<f64>) -> Option<(u16, u16)> {
        let index = |axis: usize| whole(((place[axis] - self.origin[axis]) / self.cell_size_m).floor());
        let (column, row) = (index(0)?, index(1)?);
        (column < self.columns && row < self.rows).then_some((column, row))
    }

    /// How many cells are free.
    #[must_use]
    pub fn free_cells(&self) -> usize {
        self.free.iter().filter(|free| **free).count()
    }

    /// The square that the cell covers.
    #[must_use]
    pub fn cell(&self, column: u16, row: u16) -> Bounds {
        let corner = |column: f64, row: f64| {
            Point2::new(self.origin.x + column * self.cell_size_m, self.origin.y + row * self.cell_size_m)
        };
        let (column, row) = (f64::from(column), f64::from(row));
        Bounds { low: corner(column, row), high: corner(column + 1.0, row + 1.0) }
    }

    fn index(&self, column: u16, row: u16) -> usize {
        usize::from(row) * usize::from(self.columns) + usize::from(column)
    }

    fn block(&mut self, shape: &Shape) {
        let Some(reach) = bounds_of(shape) else { return };
        let (columns, rows) =
            (self.span(reach.low.x, reach.high.x, 0), self.span(reach.low.y, reach.high.y, 1));
        for row in rows {
            for column in columns.clone() {
                if occupies(shape, &self.cell(column, row)) {
                    let index = self.index(column, row);
                    self.free[index] = false;
                }
            }
        }
    }

    /// The columns (axis 0) or rows (axis 1) that may reach from `low` to `high`, one more at each end for rounding.
    fn span(&self, low: f64, high: f64, axis: usize) -> core::ops::Range<u16> {
        let count = if axis == 0 { self.columns } else { self.rows };
        let place = |coordinate: f64| ((coordinate - self.origin[axis]) / self.cell_size_m).floor();
        let first = whole((place(low) - 1.0).max(0.0)).unwrap_or(count);
        let last = whole((place(high) + 2.0).max(0.0)).unwrap_or(count);
        first.min(count)..last.min(count)
    }
}

fn check_cell_size(cell_size_m: f64) -> Result<(), RasterError> {
    let sound = cell_size_m.is_finite() && cell_size_m > 0.0;
    sound.then_some(()).ok_or(RasterError::CellSize(cell_size_m))
}

/// The box around a shape; `None` of a line without points.
pub(crate) fn bounds_of(shape: &Shape) -> Option<Bounds> {
    match shape {
        Shape::Line(points) => Bounds::of_points(points),
        Shape::Polygon(polygon) => Some(*polygon.bounds()),
        Shape::Disc(disc) => Some(disc.bounds()),
    }
}

fn occupies(shape: &Shape, cell: &Bounds) -> bool {
    let inner = cell.grown(-HAIR_M);
    match shape {
        Shape::Line(points) => {
            let outer = cell.grown(HAIR_M);
            points.windows(2).any(|ends| touches(&Segment::new(ends[0], ends[1]), &outer))
        }
        Shape::Polygon(polygon) => {
            polygon.edges().iter().any(|edge| touches(edge, &inner)) || polygon.contains(inner.low)
        }
        Shape::Disc(disc) => inner.distance_squared(disc.centre) < disc.radius_m * disc.radius_m,
    }
}

/// Whether a segment and a box share a point: neither an axis nor the segment's own normal separates them.
fn touches(segment: &Segment, cell: &Bounds) -> bool {
    let span = segment.bounds();
    let apart_along = |axis: usize| span.high[axis] < cell.low[axis] || cell.high[axis] < span.low[axis];
    if apart_along(0) || apart_along(1) {
        return false;
    }
    let corners = [(cell.low.x, cell.low.y), (cell.high.x, cell.low.y), (cell.high.x, cell.high.y)];
    let corners = corners.into_iter().chain([(cell.low.x, cell.high.y)]);
    let sides = corners.map(|(x, y)| segment.edge().perp(&(Point2::new(x, y) - segment.start())));
    let (lowest, highest) =
        sides.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), side| (low.min(side), high.max(side)));
    lowest <= 0.0 && 0.0 <= highest
}

/// A whole number from a non-negative float without fraction; `None` beyond [`SIDE_MAX`].
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the range is checked, and within it the value of a whole float is kept exactly"
)]
fn whole(value: f64) -> Option<u16> {
    if (0.0..=SIDE_MAX).contains(&value) { Some(value as u16) } else { None }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use proptest::prelude::{prop_assert, proptest};

    use super::{Raster, RasterError};
    use crate::geometry::{Disc, Polygon};
    use crate::scenario::Shape;

    fn room(width: f64, height: f64) -> Shape {
        let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height), (0.0, 0.0)];
        Shape::Line(corners.map(|(x, y)| Point2::new(x, y)).to_vec())
    }

    fn block(low: (f64, f64), high: (f64, f64)) -> Shape {
        let corners = [low, (high.0, low.1), high, (low.0, high.1)];
        Shape::Polygon(Polygon::new(&corners.map(|(x, y)| Point2::new(x, y))).unwrap())
    }

    fn picture(raster: &Raster) -> Vec<String> {
        let row = |row| {
            (0..raster.columns()).map(|column| if raster.is_free(column, row) { '.' } else { '#' }).collect()
        };
        (0..raster.rows()).rev().map(row).collect()
    }

    #[test]
    fn a_room_with_a_block_looks_like_one() {
        let shapes = [room(0.6, 0.5), block((0.2, 0.2), (0.4, 0.3))];
        let raster = Raster::of(shapes.iter(), 0.1).unwrap();
        assert_eq!(picture(&raster), ["######", "#....#", "#.##.#", "#....#", "######"]);
    }

    #[test]
    fn a_thin_wall_between_two_cells_blocks_both() {
        let wall = Shape::Line(vec![Point2::new(0.3, 0.0), Point2::new(0.3, 0.3)]);
        let raster = Raster::of([room(0.6, 0.3), wall].iter(), 0.1).unwrap();
        assert_eq!(picture(&raster), ["######", "#.##.#", "######"]);
    }

    #[test]
    fn a_transposed_map_has_its_cells_exchanged() {
        let raster = Raster::of([room(0.6, 0.5), block((0.2, 0.2), (0.4, 0.3))].iter(), 0.1).unwrap();
        let transposed = raster.transposed();
        assert_eq!(picture(&transposed), ["#####", "#...#", "#.#.#", "#.#.#", "#...#", "#####"]);
        assert_eq!(transposed.transposed(), raster);
        assert_eq!((transposed.next_wall(2, 1), transposed.next_wall(1, 1)), (2, 5));
    }

    #[test]
    fn the_inside_of_a_large_solid_is_not_free() {
        let disc = Shape::Disc(Disc { centre: Point2::new(0.5, 0.5), radius_m: 0.3 });
        let raster =
            Raster::of([room(1.0, 1.0), disc, block((0.85, 0.05), (0.95, 0.95))].iter(), 0.01).unwrap();
        assert!(!raster.is_free(50, 50));
        assert!(!raster.is_free(90, 50));
        assert!(raster.is_free(10, 10));
    }

    #[test]
    fn cells_outside_the_grid_are_not_free() {
        let raster = Raster::of([room(0.6, 0.5)].iter(), 0.1).unwrap();
        assert!(raster.is_free(4, 3));
        assert!(!raster.is_free(6, 3) && !raster.is_free(4, 5) && !raster.is_free(u16::MAX, u16::MAX));
    }

    #[test]
    fn senseless_cell_sizes_and_empty_maps_are_refused() {
        let shapes = [room(0.6, 0.5)];
        for size in [0.0, -0.1, f64::INFINITY] {
            assert_eq!(Raster::of(shapes.iter(), size), Err(RasterError::CellSize(size)));
        }
        assert!(matches!(Raster::of(shapes.iter(), f64::NAN), Err(RasterError::CellSize(_))));
        assert_eq!(Raster::of(shapes.iter(), 1e-6), Err(RasterError::TooManyCells(1e-6)));
        assert_eq!(Raster::of([].iter(), 0.1), Err(RasterError::NoWalls));
    }

    proptest! {
        /// Whatever the walls, a point on one is never in a free cell.
        #[test]
        fn no_wall_point_lies_in_a_free_cell(
            ends in proptest::array::uniform4(0.0..1.0_f64),
            along in 0.0..=1.0_f64,
            size in 0.01..0.2_f64,
        ) {
            let (from, to) = (Point2::new(ends[0], ends[1]), Point2::new(ends[2], ends[3]));
            let raster = Raster::of([room(1.0, 1.0), Shape::Line(vec![from, to])].iter(), size).unwrap();
            let point = from + (to - from) * along;
            for row in 0..raster.rows() {
                for column in 0..raster.columns() {
                    prop_assert!(!(raster.is_free(column, row) && raster.cell(column, row).contains(point)));
                }
            }
        }

        /// A free cell has none of a solid's inside, and the cells that only border on a block stay free.
        #[test]
        fn no_inner_point_lies_in_a_free_cell(
            low in proptest::array::uniform2(0.1..0.5_f64),
            size in proptest::array::uniform2(0.001..0.4_f64),
            place in proptest::array::uniform2(0.001..0.999_f64),
        ) {
            let high = (low[0] + size[0], low[1] + size[1]);
            let raster = Raster::of([room(1.0, 1.0), block((low[0], low[1]), high)].iter(), 0.05).unwrap();
            let point = Point2::new(low[0] + size[0] * place[0], low[1] + size[1] * place[1]);
            for row in 0..raster.rows() {
                for column in 0..raster.columns() {
                    prop_assert!(!(raster.is_free(column, row) && raster.cell(column, row).contains(point)));
                }
            }
        }
    }
}
