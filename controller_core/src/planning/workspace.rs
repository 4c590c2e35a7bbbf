//! What the planner knows of the world: a raster of cells that are free or not.

use core::fmt;

/// The known map as a raster.
///
/// A raster cell is free when no wall touches it; what lies outside of the raster is not free. Column 0 is at the
/// smallest x, row 0 at the smallest y (REP-103: y grows upwards; an image has its rows the other way round).
pub trait Workspace {
    /// Number of raster columns (along x), 1 ..= 4096.
    fn columns(&self) -> u16;

    /// Number of raster rows (along y), 1 ..= 4096.
    fn rows(&self) -> u16;

    /// Edge of a raster cell in metres, above 0.
    fn cell_size_m(&self) -> f32;

    /// World coordinates of the lower left corner of raster cell (0, 0), in metres.
    fn origin_m(&self) -> (f32, f32);

    /// Whether no wall touches the raster cell; only asked for cells of the raster.
    fn is_free(&self, column: u16, row: u16) -> bool;

    /// The first row from `row` upwards that is not free in a column of the raster; [`Workspace::rows`] when all are.
    ///
    /// Where columns are stored as bits, an own version is several times faster.
    fn next_wall(&self, column: u16, row: u16) -> u16 {
        (row..self.rows()).find(|&row| !self.is_free(column, row)).unwrap_or(self.rows())
    }

    /// Which of the 64 cells from `row` upwards in a column of the raster are not free: one bit each, that of `row` the
    /// lowest. What lies above the raster is not free.
    ///
    /// The planner asks this most. Where columns are stored as bits, an own version is many times faster.
    fn walls(&self, column: u16, row: u16) -> u64 {
        let mut walls = 0;
        for bit in 0..64 {
            let row = row.saturating_add(bit);
            let is_wall = row >= self.rows() || !self.is_free(column, row);
            walls |= u64::from(is_wall) << bit;
        }
        walls
    }
}

/// A raster of one bit per cell in `WORDS` words of 32 bits: 192 words (768 bytes) hold 96 × 64 cells.
///
/// The bits of a column follow each other, since the planner asks for the walls up a column.
#[derive(Clone, Debug, PartialEq)]
pub struct BitGrid<const WORDS: usize> {
    columns: u16,
    rows: u16,
    cell_size_m: f32,
    origin_m: (f32, f32),
    /// A set bit is a wall, so that a new raster is free.
    walls: [u32; WORDS],
}

/// Why a [`BitGrid`] cannot be made or changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridError {
    /// The raster has no column or no row.
    Empty,
    /// The raster needs more bits than the type has.
    TooLarge {
        /// Raster cells asked for.
        cells: usize,
        /// Raster cells that `WORDS` words hold.
        capacity: usize,
    },
    /// The cell size is not a positive number, or the origin is not a number.
    BadGeometry,
    /// The cell is not of this raster.
    Outside {
        /// Column asked for.
        column: u16,
        /// Row asked for.
        row: u16,
    },
}

impl fmt::Display for GridError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "the raster has no cell: give at least one column and one row"),
            Self::TooLarge { cells, capacity } => {
                write!(f, "the raster has {cells} cells, room is for {capacity}: raise WORDS or coarsen it")
            }
            Self::BadGeometry => write!(f, "the cell size must be above 0 m and the origin finite"),
            Self::Outside { column, row } => {
                write!(f, "cell ({column}, {row}) is outside of the raster: check columns and rows")
            }
        }
    }
}

impl core::error::Error for GridError {}

impl<const WORDS: usize> BitGrid<WORDS> {
    /// A raster without walls.
    ///
    /// # Errors
    /// [`GridError`] when it is empty, needs more than `WORDS` words, or has a bad cell size or origin.
    pub fn new(columns: u16, rows: u16, cell_size_m: f32, origin_m: (f32, f32)) -> Result<Self, GridError> {
        if columns == 0 || rows == 0 {
            return Err(GridError::Empty);
        }
        let cells = usize::from(columns).saturating_mul(usize::from(rows));
        let capacity = WORDS.saturating_mul(32);
        if cells > capacity {
            return Err(GridError::TooLarge { cells, capacity });
        }
        let finite = cell_size_m.is_finite() && origin_m.0.is_finite() && origin_m.1.is_finite();
        if !finite || cell_size_m <= 0.0 {
            return Err(GridError::BadGeometry);
        }
        Ok(Self { columns, rows, cell_size_m, origin_m, walls: [0; WORDS] })
    }

    /// Marks one cell as free or as touched by a wall.
    ///
    /// # Errors
    /// [`GridError::Outside`] when the raster has no such cell.
    pub fn set_free(&mut self, column: u16, row: u16, free: bool) -> Result<(), GridError> {
        let outside = GridError::Outside { column, row };
        let (word, mask) = self.bit(column, row).ok_or(outside)?;
        let word = self.walls.get_mut(word).ok_or(outside)?;
        *word = if free { *word & !mask } else { *word | mask };
        Ok(())
    }

    /// Word and mask of a cell, `None` outside of the raster.
    fn bit(&self, column: u16, row: u16) -> Option<(usize, u32)> {
        if column >= self.columns || row >= self.rows {
            return None;
        }
        let index = usize::from(column) * usize::from(self.rows) + usize::from(row);
        Some((index / 32, 1 << (index % 32)))
    }
}

impl<const WORDS: usize> Workspace for BitGrid<WORDS> {
    fn columns(&self) -> u16 {
        self.columns
    }

    fn rows(&self) -> u16 {
        self.rows
    }

    fn cell_size_m(&self) -> f32 {
        self.cell_size_m
    }

    fn origin_m(&self) -> (f32, f32) {
        self.origin_m
    }

    fn is_free(&self, column: u16, row: u16) -> bool {
        let Some((word, mask)) = self.bit(column, row) else { return false };
        self.walls.get(word).is_some_and(|word| word & mask == 0)
    }

    fn next_wall(&self, column: u16, row: u16) -> u16 {
        let mut row = row;
        while row < self.rows {
            let Some((word, mask)) = self.bit(column, row) else { return self.rows };
            // A word may go on into the next column: the row is limited at the end.
            let above = self.walls.get(word).map_or(0, |word| word & !(mask - 1));
            let from = mask.trailing_zeros();
            let step = if above == 0 { 32 - from } else { above.trailing_zeros() - from };
            row = row.saturating_add(u16::try_from(step).unwrap_or(32));
            if above != 0 {
                break;
            }
        }
        row.min(self.rows)
    }

    fn walls(&self, column: u16, row: u16) -> u64 {
        let Some((first, mask)) = self.bit(column, row) else { return u64::MAX };
        let word = |place: usize| u128::from(self.walls.get(place).copied().unwrap_or(0));
        let words = word(first) | word(first + 1) << 32 | word(first + 2) << 64;
        let above = u64::MAX.checked_shl(u32::from(self.rows - row)).unwrap_or(0);
        #[expect(clippy::cast_possible_truncation, reason = "the bits that are asked for are the lowest 64")]
        let walls = (words >> mask.trailing_zeros()) as u64;
        // The words may go on into the next column.
        walls | above
    }
}
