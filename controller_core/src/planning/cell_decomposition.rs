//! Few cells, each with a band through it, and the passages between them.
//!
//! A lattice column is cut into *runs*: intervals where the disc is clear. A **cell** is a row of runs, one per
//! column, that share a band of rows, its **core**. From any point of a cell the disc can go straight up or down to
//! the core, along it, and straight to any other point of the cell: that is what "any two points of a cell can be
//! joined by reactive motion" means here. The ragged outline of a rasterised wall stays inside of the cell, where
//! rectangles would need a sliver for each step.
//!
//! A cell ends where its core would become thin against its widest run ([`CORE_SHARE`]): at a doorway in a wall
//! along y, at the end of a wall. Neighbouring runs of two cells that overlap are a **passage**. Since each run is
//! in a cell and each overlap is a core or a passage, the disc can go from cell to cell exactly where it can go from
//! lattice point to lattice point.

use super::clearance::{Clearance, Spot};
use super::workspace::Workspace;
use super::{Overflow, lattice_index};

/// A cell ends when its core would fall below one part in this many of its widest run.
///
/// Chosen because 3 gives about a third fewer cells than 2 on random worlds, and still tells a doorway from its rooms.
const CORE_SHARE: i32 = 3;

/// No cell, no passage.
pub(super) const NONE: u16 = u16::MAX;

/// A cell, in lattice rows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    /// The core: rows that are clear in every column of the cell.
    low: u16,
    high: u16,
    /// Head of the list of its passages.
    pub passage: u16,
}

/// A door between two cells: rows `low ..= high` are clear in lattice column `right` and in the one before, and the
/// step between them is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Passage {
    /// The cell on the left, then the one on the right.
    pub cells: [u16; 2],
    /// Next passage of either cell's list.
    next: [u16; 2],
    /// First column of the cell on the right.
    right: u16,
    /// The passage counts as being in this column: `right` or the one before.
    column: u16,
    low: u16,
    high: u16,
    /// What the rows of column `right` have more: 0, or ±1 for a slanting step between runs that do not overlap.
    slant: i16,
}

impl Passage {
    /// Both ends are the same.
    pub fn is_point(&self) -> bool {
        self.low == self.high
    }

    /// Lower (0) or upper end.
    pub fn end(&self, end: usize) -> Spot {
        self.at(end, self.column)
    }

    /// The lattice point of `cell` at an end of the passage. Either cell may go on beside the other, so that only its
    /// own column is surely its own.
    pub fn entry(&self, end: usize, cell: u16) -> Spot {
        self.at(end, if self.cells[0] == cell { self.right.saturating_sub(1) } else { self.right })
    }

    fn at(&self, end: usize, column: u16) -> Spot {
        let row = if end == 0 { self.low } else { self.high };
        let slant = if column == self.right { f32::from(self.slant) } else { 0.0 };
        Spot { x: f32::from(column), y: f32::from(row) + slant }
    }

    /// The passage after this one in the list of `cell`.
    pub fn next_of(&self, cell: u16) -> u16 {
        let [left, right] = self.next;
        if self.cells[0] == cell { left } else { right }
    }
}

impl Cell {
    /// The nearest point of the core, same column.
    pub fn core(&self, spot: Spot) -> Spot {
        Spot { x: spot.x, y: spot.y.clamp(f32::from(self.low), f32::from(self.high.max(self.low))) }
    }
}

/// The run of an open cell in the last column.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    cell: u16,
    low: u16,
    high: u16,
    /// Widest run of the cell so far.
    widest: u16,
}

impl Run {
    /// First and last row.
    fn rows(&self) -> (i32, i32) {
        (i32::from(self.low), i32::from(self.high))
    }
}

/// The cells and passages of one raster, for one disc.
pub(super) struct Decomposition<const CELLS: usize, const PASSAGES: usize> {
    pub cells: heapless::Vec<Cell, CELLS>,
    pub passages: heapless::Vec<Passage, PASSAGES>,
    previous: heapless::Vec<Run, CELLS>,
    current: heapless::Vec<Run, CELLS>,
}

/// Length of the overlap of two intervals of lattice points; 0 when they share none.
fn overlap(a: (i32, i32), b: (i32, i32)) -> i32 {
    (a.1.min(b.1) - a.0.max(b.0) + 1).max(0)
}

impl<const CELLS: usize, const PASSAGES: usize> Decomposition<CELLS, PASSAGES> {
    pub const fn new() -> Self {
        Self {
            cells: heapless::Vec::new(),
            passages: heapless::Vec::new(),
            previous: heapless::Vec::new(),
            current: heapless::Vec::new(),
        }
    }

    /// Sweeps the raster from left to right, and says in which cells the lattice points of `anchors` are
    /// ([`NONE`] where they are not clear).
    pub fn build<W: Workspace, const A: usize>(
        &mut self,
        clearance: &Clearance<'_, W>,
        anchors: [(i32, i32); A],
    ) -> Result<[u16; A], Overflow> {
        self.cells.clear();
        self.passages.clear();
        self.previous.clear();
        let mut found = [NONE; A];
        for x in 0..clearance.lattice_columns() {
            self.current.clear();
            let mut walk = clearance.column(x);
            while let Some(run) = clearance.next_run(&mut walk) {
                self.add_run(clearance, x, run)?;
            }
            for (cell, (_, y)) in found.iter_mut().zip(anchors).filter(|(_, anchor)| anchor.0 == x) {
                if let Some(run) = self.current.iter().find(|run| run.rows().0 <= y && y <= run.rows().1) {
                    *cell = run.cell;
                }
            }
            // Only what is there: to exchange both stores takes a large planner a third of its time. Both have the same
            // capacity, so that it fits.
            self.previous.clear();
            let _ = self.previous.extend_from_slice(&self.current);
        }
        self.link();
        Ok(found)
    }

    /// Puts a run of column `x` into the cell it continues, or a new one, and notes its passages.
    fn add_run<W: Workspace>(
        &mut self,
        clearance: &Clearance<'_, W>,
        x: i32,
        (low, high): (i32, i32),
    ) -> Result<(), Overflow> {
        let mut best: Option<(i32, Run)> = None;
        let before = |run: &&Run| run.rows().1 < low;
        let beside = |run: &&Run| run.rows().0 <= high;
        for run in self.previous.iter().skip_while(before).take_while(beside) {
            let shared = overlap((low, high), run.rows());
            let taken = self.current.iter().any(|other| other.cell == run.cell);
            if !taken && self.continues(run, (low, high)) && best.is_none_or(|(most, _)| shared > most) {
                best = Some((shared, *run));
            }
        }
        let length = lattice_index(high - low + 1);
        let run = if let Some((_, run)) = best {
            let cell = self.cells.get_mut(usize::from(run.cell)).ok_or(Overflow::Cells)?;
            cell.low = cell.low.max(lattice_index(low));
            cell.high = cell.high.min(lattice_index(high));
            Run { low: lattice_index(low), high: lattice_index(high), widest: run.widest.max(length), ..run }
        } else {
            let cell = u16::try_from(self.cells.len()).map_err(|_| Overflow::Cells)?;
            let new = Cell { low: lattice_index(low), high: lattice_index(high), passage: NONE };
            self.cells.push(new).map_err(|_| Overflow::Cells)?;
            Run { cell, low: lattice_index(low), high: lattice_index(high), widest: length }
        };
        self.current.push(run).map_err(|_| Overflow::Cells)?;
        for other in self.previous.iter().skip_while(|other| other.rows().1 + 1 < low) {
            let (other_low, other_high) = other.rows();
            if other_low > high + 1 {
                break;
            }
            let (first, last) = (low.max(other_low), high.min(other_high));
            // Runs that only meet at a corner: a slanting gap that just lets the disc through.
            let slant = if last < first { (low - other_high).signum() } else { 0 };
            let row = if slant > 0 { other_high } else { other_low };
            let step = (Spot::lattice(x - 1, row), Spot::lattice(x, row + slant));
            if other.cell == run.cell || (slant != 0 && !clearance.is_clear(step.0, step.1)) {
                continue;
            }
            let (first, last) = if slant == 0 { (first, last) } else { (row, row) };
            let new = Passage {
                cells: [other.cell, run.cell],
                next: [NONE; 2],
                right: lattice_index(x),
                // The corner to go round is at the end of the shorter run.
                column: lattice_index(if other_high - other_low < high - low { x - 1 } else { x }),
                low: lattice_index(first),
                high: lattice_index(last),
                slant: i16::try_from(slant).unwrap_or(0),
            };
            self.passages.push(new).map_err(|_| Overflow::Passages)?;
        }
        Ok(())
    }

    /// Whether the cell of `run` may go on with the run `low ..= high` of the next column.
    fn continues(&self, run: &Run, (low, high): (i32, i32)) -> bool {
        let Some(cell) = self.cells.get(usize::from(run.cell)) else { return false };
        let core = i32::from(cell.high).min(high) - i32::from(cell.low).max(low) + 1;
        core > 0 && CORE_SHARE * core >= i32::from(run.widest).max(high - low + 1)
    }

    /// Threads each passage on the lists of its two cells.
    fn link(&mut self) {
        for (index, passage) in self.passages.iter_mut().enumerate().rev() {
            for (next, cell) in passage.next.iter_mut().zip(passage.cells) {
                if let Some(cell) = self.cells.get_mut(usize::from(cell)) {
                    *next = cell.passage;
                    cell.passage = u16::try_from(index).unwrap_or(NONE);
                }
            }
        }
    }

    /// The passage of that index.
    pub fn passage(&self, index: u16) -> Option<&Passage> {
        self.passages.get(usize::from(index))
    }

    /// The passages of a cell, as indices.
    pub fn passages_of(&self, cell: u16) -> impl Iterator<Item = u16> + '_ {
        let head = self.cells.get(usize::from(cell)).map_or(NONE, |cell| cell.passage);
        core::iter::successors(Some(head), move |&index| Some(self.passage(index)?.next_of(cell)))
            .take_while(|&index| index != NONE)
    }
}
