//! Which shapes are near: a grid of squares over a large set, each with the shapes whose boxes reach into it.
//!
//! It only spares work: what is asked through it is what asking all shapes would give, as the tests hold.

use core::ops::RangeInclusive;

use nalgebra::Point2;

use crate::geometry::Bounds;

/// Least side of a square in m: a sensor's range spans a few.
const SIDE_M: f64 = 0.1;

/// Most squares along a side.
const SQUARES_MAX: u16 = 256;

/// The grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Index {
    low: Point2<f64>,
    side_m: f64,
    columns: u16,
    rows: u16,
    /// Numbers of the shapes of each square, row by row.
    squares: Vec<Vec<u32>>,
}

impl Index {
    /// Over shapes with these boxes, which go by their numbers; `None` if there are none.
    pub(super) fn new(boxes: &[Bounds]) -> Option<Self> {
        let all = boxes.iter().copied().reduce(|all, next| all.union(&next))?;
        let size = all.high - all.low;
        let side_m = SIDE_M.max(size.max() / f64::from(SQUARES_MAX));
        let count = |length: f64| place(length, side_m, SQUARES_MAX).saturating_add(1).min(SQUARES_MAX);
        let (columns, rows) = (count(size.x), count(size.y));
        let squares = vec![Vec::new(); usize::from(columns) * usize::from(rows)];
        let mut index = Self { low: all.low, side_m, columns, rows, squares };
        for (bounds, number) in boxes.iter().zip(0_u32..) {
            let (columns, rows) = index.reach(bounds);
            for row in rows {
                for column in columns.clone() {
                    let square = index.number(column, row);
                    index.squares[square].push(number);
                }
            }
        }
        Some(index)
    }

    /// Calls `visit` with every shape whose box meets `bounds`, and with some others; with some more than once.
    pub(super) fn near(&self, bounds: &Bounds, mut visit: impl FnMut(usize)) {
        let (columns, rows) = self.reach(bounds);
        for row in rows {
            for column in columns.clone() {
                self.visit(column, row, &mut visit);
            }
        }
    }

    /// The least of `distance` over all shapes, where no shape is nearer to `point` than its box.
    ///
    /// Goes outwards in rings of squares until nothing nearer can be beyond.
    pub(super) fn least(&self, point: Point2<f64>, distance: impl Fn(usize) -> f64) -> f64 {
        let (x, y) = (self.column(point.x), self.row(point.y));
        let mut best = f64::INFINITY;
        for ring in 0..SQUARES_MAX {
            let (left, right) = (x.checked_sub(ring), x.checked_add(ring).filter(|&at| at < self.columns));
            let (bottom, top) = (y.checked_sub(ring), y.checked_add(ring).filter(|&at| at < self.rows));
            let mut visit =
                |column, row| self.visit(column, row, &mut |shape| best = best.min(distance(shape)));
            let columns = left.unwrap_or(0)..=right.unwrap_or(self.columns - 1);
            for row in [bottom, top.filter(|_| ring > 0)].into_iter().flatten() {
                columns.clone().for_each(|column| visit(column, row));
            }
            for row in y.saturating_sub(ring.saturating_sub(1))
                ..=(y.saturating_add(ring) - ring.min(1)).min(self.rows - 1)
            {
                for column in [left, right].into_iter().flatten().filter(|_| ring > 0) {
                    visit(column, row);
                }
            }
            let edge = |low: f64, at: Option<u16>, ahead: u16| {
                at.map(|at| low + f64::from(at + ahead) * self.side_m)
            };
            let beyond = [
                edge(self.low.x, left, 0).map(|edge| point.x - edge),
                edge(self.low.x, right, 1).map(|edge| edge - point.x),
                edge(self.low.y, bottom, 0).map(|edge| point.y - edge),
                edge(self.low.y, top, 1).map(|edge| edge - point.y),
            ];
            // A hair less, for what the edges of the squares lose by rounding.
            let covered = beyond.into_iter().flatten().fold(f64::INFINITY, f64::min) - 1e-9 * self.side_m;
            if best <= covered {
                break;
            }
        }
        best
    }

    fn visit(&self, column: u16, row: u16, visit: &mut impl FnMut(usize)) {
        for &shape in &self.squares[self.number(column, row)] {
            // Indices fit: they come from the length of a list.
            visit(usize::try_from(shape).unwrap_or(usize::MAX));
        }
    }

    fn number(&self, column: u16, row: u16) -> usize {
        usize::from(row) * usize::from(self.columns) + usize::from(column)
    }

    fn column(&self, x: f64) -> u16 {
        place(x - self.low.x, self.side_m, self.columns - 1)
    }

    fn row(&self, y: f64) -> u16 {
        place(y - self.low.y, self.side_m, self.rows - 1)
    }

    fn reach(&self, bounds: &Bounds) -> (RangeInclusive<u16>, RangeInclusive<u16>) {
        let hair = 1e-9 * self.side_m;
        let bounds = bounds.grown(hair);
        let columns = self.column(bounds.low.x)..=self.column(bounds.high.x);
        (columns, self.row(bounds.low.y)..=self.row(bounds.high.y))
    }
}

/// The square that a length reaches into, at most `last`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to the range of the type before"
)]
fn place(length_m: f64, side_m: f64, last: u16) -> u16 {
    (length_m / side_m).floor().clamp(0.0, f64::from(last)) as u16
}
