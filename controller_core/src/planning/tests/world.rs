//! Small worlds for the tests: drawn by hand, or by a seed.

extern crate std;

use std::vec::Vec;

use super::super::Workspace;

/// A raster with 10 mm cells.
#[derive(Clone)]
pub struct World {
    columns: u16,
    rows: u16,
    pub origin_m: (f32, f32),
    free: Vec<bool>,
}

pub const CELL_M: f32 = 0.01;

impl Workspace for World {
    fn columns(&self) -> u16 {
        self.columns
    }

    fn rows(&self) -> u16 {
        self.rows
    }

    fn cell_size_m(&self) -> f32 {
        CELL_M
    }

    fn origin_m(&self) -> (f32, f32) {
        self.origin_m
    }

    fn is_free(&self, column: u16, row: u16) -> bool {
        self.free[usize::from(row) * usize::from(self.columns) + usize::from(column)]
    }
}

/// A 64-bit linear congruential generator (Knuth's constants), high bits out.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(1))
    }

    /// A number in `low ..= high`.
    pub fn between(&mut self, low: u16, high: u16) -> u16 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + u16::try_from((self.0 >> 33) % u64::from(high - low + 1)).unwrap()
    }
}

impl World {
    pub fn empty(columns: u16, rows: u16) -> Self {
        let free = std::vec![true; usize::from(columns) * usize::from(rows)];
        Self { columns, rows, origin_m: (0.0, 0.0), free }
    }

    /// Makes the cells of a rectangle free or not, upper bounds excluded; what is outside is left out.
    pub fn fill(&mut self, columns: core::ops::Range<u16>, rows: core::ops::Range<u16>, free: bool) {
        for row in rows.start..rows.end.min(self.rows) {
            for column in columns.start..columns.end.min(self.columns) {
                self.free[usize::from(row) * usize::from(self.columns) + usize::from(column)] = free;
            }
        }
    }

    /// Makes the cells that a disc touches not free; all in cells.
    pub fn disc(&mut self, x: u16, y: u16, radius: f64) {
        // No disc here is larger than 8 cells.
        for row in y.saturating_sub(8)..(y + 8).min(self.rows) {
            for column in x.saturating_sub(8)..(x + 8).min(self.columns) {
                let gap = |at: u16, cell: u16| {
                    let (at, cell) = (f64::from(at), f64::from(cell));
                    (cell - at).max(at - cell - 1.0).max(0.0)
                };
                if gap(x, column).hypot(gap(y, row)) < radius {
                    self.fill(column..column + 1, row..row + 1, false);
                }
            }
        }
    }

    /// Discs and walls with doors.
    pub fn random(seed: u64, columns: u16, rows: u16, discs: u16, walls: u16) -> Self {
        let mut random = Random::new(seed);
        let mut world = Self::empty(columns, rows);
        for _ in 0..walls {
            let door = random.between(5, 12);
            if random.between(0, 1) == 0 {
                let (x, y) = (random.between(5, columns - 6), random.between(0, rows - door));
                let thickness = random.between(1, 3);
                world.fill(x..x + thickness, 0..y, false);
                world.fill(x..x + thickness, y + door..rows, false);
            } else {
                let (x, y) = (random.between(0, columns - door), random.between(5, rows - 6));
                let thickness = random.between(1, 3);
                world.fill(0..x, y..y + thickness, false);
                world.fill(x + door..columns, y..y + thickness, false);
            }
        }
        for _ in 0..discs {
            let (x, y) = (random.between(0, columns), random.between(0, rows));
            world.disc(x, y, f64::from(random.between(5, 70)) / 10.0);
        }
        world
    }

    pub fn free_cells(&self) -> usize {
        self.free.iter().filter(|&&free| free).count()
    }
}
