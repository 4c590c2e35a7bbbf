//! Few cells, each with a band through it, the passages between them, and the corners in them.
//!
//! A lattice column is cut into *runs*: intervals where the disc is clear. A **cell** is a row of runs, one per
//! column, that share a band of rows, its **core**. From any point of a cell the disc can go straight up or down to
//! the core, along it, and straight to any other point of the cell: that is what "any two points of a cell can be
//! joined by reactive motion" means here. The ragged outline of a rasterised wall stays inside of the cell, where
//! rectangles would need a sliver for each step.
//!
//! A cell ends where no row is left that is clear in all of its columns. Neighbouring runs of two cells that overlap
//! are a **passage**. Since each run is in a cell and each overlap is a core or a passage, the disc can go from cell
//! to cell exactly where it can go from lattice point to lattice point.
//!
//! A shortest way bends at **corners**: the ends of passages where a wall begins or ends, and, in a cell, the ends of
//! what hangs lowest into it from above or stands highest in it from below. Those have entries of their own in the
//! store of passages.

use core::cmp::Ordering;

use super::clearance::{Clearance, Spot};
use super::index::{Index, number, place};
use super::workspace::Workspace;
use super::{Overflow, lattice_index};

/// A cell, in lattice rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell<I> {
    /// The core: rows that are clear in every column of the cell.
    low: u16,
    high: u16,
    /// Where the numbers of its passages and corners begin; they end where those of the next cell begin.
    entries: I,
}

impl<I> Cell<I> {
    /// The nearest point of the core, same column.
    pub fn core(&self, spot: Spot) -> Spot {
        Spot { x: spot.x, y: spot.y.clamp(f32::from(self.low), f32::from(self.high.max(self.low))) }
    }
}

/// What kind of entry.
const CORNER_ONLY: u8 = 1;
/// The bend is at the high end.
const HIGH: u8 = 2;
/// The bend is in the column before `right`.
const LEFT: u8 = 4;
/// Only a corner in one cell: `slant` says how many columns beside the outline's corner the bend is. [`HIGH`] then
/// tells that the wall is above.
const BESIDE: u8 = 8;
/// And the wall is on the right of the bend.
const RIGHT: u8 = 16;

/// A door between two cells: rows `low ..= high` are clear in lattice column `right` and in the one before, and the
/// step between them is. Or a corner, in one cell or between two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage<I> {
    /// The cell on the left, then the one on the right; a corner in a cell has no second.
    cells: [I; 2],
    /// First column of the cell on the right.
    right: u16,
    low: u16,
    high: u16,
    /// What the rows of column `right` have more: 0, or ±1 for a slanting step between runs that do not overlap. Or see
    /// [`BESIDE`].
    slant: i8,
    /// [`CORNER_ONLY`], [`HIGH`], [`LEFT`].
    bits: u8,
}

impl<I: Index> Passage<I> {
    fn has(&self, bit: u8) -> bool {
        self.bits & bit != 0
    }

    /// One can go through, and more than one place is to choose from. A single place may as well count as a bend.
    pub fn is_wide(&self) -> bool {
        self.is_passage() && self.low < self.high
    }

    /// No mere corner.
    pub fn is_passage(&self) -> bool {
        !self.has(CORNER_ONLY)
    }

    /// The cells on both sides.
    pub fn cells(&self) -> [u32; 2] {
        self.cells.map(Index::get)
    }

    /// Where a way through or by here bends. Without a jump, since the search asks for little else.
    pub fn bend(&self) -> Spot {
        let (left, slant) = (i32::from(self.has(LEFT)), i32::from(self.slant));
        let row = i32::from(if self.has(HIGH) { self.high } else { self.low });
        let beside = i32::from(self.has(BESIDE));
        Spot::lattice(i32::from(self.right) - left + slant * beside, row + slant * (1 - left))
    }

    /// The lattice point of `cell` at the bend. Either cell may go on beside the other, so that only its own column is
    /// surely its own.
    pub fn bend_in(&self, cell: u32) -> Spot {
        self.at(if self.cells[0].get() == cell { self.right.saturating_sub(1) } else { self.right })
    }

    fn at(&self, column: u16) -> Spot {
        let row = if self.has(HIGH) { self.high } else { self.low };
        let slant = if column == self.right { f32::from(self.slant) } else { 0.0 };
        Spot { x: f32::from(column), y: f32::from(row) + slant }
    }

    /// Whether a way that bends here can be taut when it comes from, or goes to, a place that is `dx` and `dy` away:
    /// the wall must be in the inside of the bend. Of passages: always, since they are needed to get on at all.
    pub fn can_be_taut(&self, dx: f32, dy: f32, reach: f32) -> bool {
        let along = if self.has(RIGHT) { dx } else { -dx };
        let up = if self.has(HIGH) { dy } else { -dy };
        // A bend is beside the wall by about the disc's radius.
        let room = 2.0 * reach;
        !(self.has(BESIDE) & ((along > room) & (up > room) | (along < -room) & (up < -room)))
    }

    /// Where the shortest way between two places crosses the passage in column `x`, were nothing else in the way.
    pub fn crossing(&self, x: f32, a: Spot, b: Spot) -> Spot {
        let (from_a, from_b) = ((x - a.x).abs(), (x - b.x).abs());
        let sum = from_a + from_b;
        let share = if sum > 0.0 { from_a / sum } else { 0.5 };
        let y = a.y + share * (b.y - a.y);
        Spot { x, y: y.clamp(f32::from(self.low), f32::from(self.high)) }
    }
}

/// The run of an open cell in the last column.
#[derive(Clone, Copy, Debug)]
struct Run<I> {
    cell: I,
    low: u16,
    high: u16,
    /// Since how many columns the upper and the lower end are where they last came inwards to; or see [`NOTED`] and
    /// [`OUT`].
    since: [u8; 2],
}

/// What [`Run::since`] says of an end: it came inwards before this cell began or so long ago that it is noted already,
const NOTED: u8 = 127;
/// or it went outwards, so many columns less ago.
const OUT: u8 = 128;

impl<I> Run<I> {
    /// First and last row.
    fn rows(&self) -> (i32, i32) {
        (i32::from(self.low), i32::from(self.high))
    }
}

/// After the sweep: how many passages a cell has left, in `low`, and the exclusive or of their numbers, in `cell`,
/// which is the number of the last one.
impl<I: Index> Run<I> {
    fn counter() -> Self {
        Self { cell: I::of(0), low: 0, high: 0, since: [0; 2] }
    }

    fn count(&mut self, passage: u32, times: u16) {
        self.cell = I::of(self.cell.get() ^ passage);
        self.low = self.low.saturating_add(times);
    }

    fn discount(&mut self, passage: u32) {
        self.cell = I::of(self.cell.get() ^ passage);
        // More than can be counted stay so many: such a cell is no dead end.
        self.low -= u16::from(self.low != u16::MAX && self.low > 0);
    }

    /// The number of the only passage, which is then gone.
    fn take_last(&mut self) -> Option<u32> {
        let is_last = self.low == 1;
        if is_last {
            self.low = 0;
        }
        is_last.then_some(self.cell.get())
    }

    /// Whether a way may lead through the cell.
    fn is_alive(&self) -> bool {
        self.low > 0
    }
}

/// For a search: by which passage it goes on from a cell, in `cell`, and how far it is from there, in the rows; since
/// when is 0 where that is not known.
impl<I: Index> Run<I> {
    fn far() -> Self {
        Self { cell: I::LAST, low: 0, high: 0, since: [0; 2] }
    }

    fn set_distance(&mut self, passage: I, distance: f32) {
        let [a, b, c, d] = distance.to_bits().to_le_bytes();
        let (low, high) = (u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]));
        *self = Self { cell: passage, low, high, since: [1; 2] };
    }

    fn distance(&self) -> Option<(u32, f32)> {
        let bits = u32::from(self.low) | u32::from(self.high) << 16;
        (self.since != [0; 2]).then_some((self.cell.get(), f32::from_bits(bits)))
    }
}

/// The cells and passages of one raster, for one disc.
pub(super) struct Decomposition<I, const CELLS: usize, const PASSAGES: usize> {
    pub cells: heapless::Vec<Cell<I>, CELLS>,
    pub passages: heapless::Vec<Passage<I>, PASSAGES>,
    /// Numbers of the passages and corners, cell by cell.
    entries: [[I; 2]; PASSAGES],
    /// How many there are.
    linked: usize,
    previous: heapless::Vec<Run<I>, CELLS>,
    current: heapless::Vec<Run<I>, CELLS>,
}

/// Length of the overlap of two intervals of lattice points; 0 when they share none.
fn overlap(a: (i32, i32), b: (i32, i32)) -> i32 {
    (a.1.min(b.1) - a.0.max(b.0) + 1).max(0)
}

impl<I: Index, const CELLS: usize, const PASSAGES: usize> Decomposition<I, CELLS, PASSAGES> {
    pub const fn new() -> Self {
        Self {
            cells: heapless::Vec::new(),
            passages: heapless::Vec::new(),
            entries: [[I::LAST; 2]; PASSAGES],
            linked: 0,
            previous: heapless::Vec::new(),
            current: heapless::Vec::new(),
        }
    }

    /// Sweeps the raster from left to right, and says in which cells the lattice points of `anchors` are
    /// ([`Index::NONE`] where they are not clear).
    pub fn build<W: Workspace>(
        &mut self,
        clearance: &Clearance<'_, W>,
        anchors: [(i32, i32); 2],
    ) -> Result<[u32; 2], Overflow> {
        self.cells.clear();
        self.passages.clear();
        self.previous.clear();
        let mut found = [I::NONE; 2];
        for x in 0..=clearance.lattice_columns() {
            self.current.clear();
            let mut walk = clearance.column(x);
            let mut behind = 0;
            while let Some(run) = clearance.next_run(&mut walk) {
                self.add_run(clearance, x, run, &mut behind)?;
            }
            self.end_runs(clearance, x)?;
            for (cell, (_, y)) in found.iter_mut().zip(anchors).filter(|(_, anchor)| anchor.0 == x) {
                if let Some(run) = self.current.iter().find(|run| run.rows().0 <= y && y <= run.rows().1) {
                    *cell = run.cell.get();
                }
            }
            // Only what is there: to exchange both stores takes a large planner a third of its time. Both have the same
            // capacity, so that it fits.
            self.previous.clear();
            let _ = self.previous.extend_from_slice(&self.current);
        }
        self.link(found);
        Ok(found)
    }

    /// Puts a run of column `x` into the cell it continues, or a new one, and notes its passages. The runs of the last
    /// column before number `behind` end below.
    fn add_run<W: Workspace>(
        &mut self,
        clearance: &Clearance<'_, W>,
        x: i32,
        (low, high): (i32, i32),
        behind: &mut usize,
    ) -> Result<(), Overflow> {
        while self.previous.get(*behind).is_some_and(|run| run.rows().1 + 1 < low) {
            *behind += 1;
        }
        let mut best: Option<(i32, usize)> = None;
        for (index, run) in self.previous.iter().enumerate().skip(*behind) {
            if run.rows().0 > high {
                break;
            }
            let shared = overlap((low, high), run.rows());
            // Another run of this column can have taken the cell only if it overlaps the same run.
            let beside = |other: &&Run<I>| other.rows().1 >= run.rows().0;
            let taken = self.current.iter().rev().take_while(beside).any(|other| other.cell == run.cell);
            if !taken && self.continues(run, (low, high)) && best.is_none_or(|(most, _)| shared > most) {
                best = Some((shared, index));
            }
        }
        let run = if let Some((_, index)) = best {
            self.go_on(clearance, x, (low, high), index)?
        } else {
            let cell = I::of(number(self.cells.len()));
            let (low, high) = (lattice_index(low), lattice_index(high));
            self.cells.push(Cell { low, high, entries: I::of(0) }).map_err(|_| Overflow::Cells)?;
            Run { cell, low, high, since: [NOTED; 2] }
        };
        self.current.push(run).map_err(|_| Overflow::Cells)?;
        for index in *behind..self.previous.len() {
            let Some(other) = self.previous.get(index).copied().filter(|other| other.rows().0 <= high + 1)
            else {
                break;
            };
            if other.cell != run.cell {
                self.add_passage(clearance, x, &other, &run)?;
            }
        }
        Ok(())
    }

    /// The next run of the cell of run `index` of the last column, and the corners that it shows.
    fn go_on<W: Workspace>(
        &mut self,
        clearance: &Clearance<'_, W>,
        x: i32,
        (low, high): (i32, i32),
        index: usize,
    ) -> Result<Run<I>, Overflow> {
        let Some(run) = self.previous.get_mut(index) else { return Err(Overflow::Cells) };
        let last = *run;
        // So that [`Self::end_runs`] leaves it.
        run.since = [NOTED; 2];
        let (low, high) = (lattice_index(low), lattice_index(high));
        if let Some(cell) = self.cells.get_mut(place(last.cell.get())) {
            (cell.low, cell.high) = (cell.low.max(low), cell.high.min(high));
        }
        let [upper, lower] = last.since;
        let (upper_moves, lower_moves) = (last.high.cmp(&high), low.cmp(&last.low));
        let upper = self.follow_end(clearance, x, (last.high, true), last.cell, upper, upper_moves)?;
        let lower = self.follow_end(clearance, x, (last.low, false), last.cell, lower, lower_moves)?;
        Ok(Run { low, high, since: [upper, lower], ..last })
    }

    /// Follows the upper or lower end of a run from its row in the last column, inwards if greater, to column `x`;
    /// notes the corners that it shows, and says what [`Run::since`] becomes.
    #[inline]
    fn follow_end<W: Workspace>(
        &mut self,
        clearance: &Clearance<'_, W>,
        x: i32,
        (row, is_upper): (u16, bool),
        cell: I,
        since: u8,
        inwards: Ordering,
    ) -> Result<u8, Overflow> {
        if inwards.is_eq() && since >= NOTED {
            return Ok(if since == NOTED { NOTED } else { since.saturating_add(1) });
        }
        let begins = (1..NOTED).contains(&since);
        let columns = if since < OUT { since } else { since - OUT + 1 };
        // Shorter ones are those of the disc's own roundness at one corner.
        let has_stayed = columns >= clearance.corner_columns;
        let next = match inwards {
            Ordering::Greater => 1,
            Ordering::Equal => since + 1,
            Ordering::Less => OUT,
        };
        // A step of a staircase is a corner too, so that a way can be joined round it bend by bend.
        let is_noted = if inwards.is_eq() { next == NOTED } else { has_stayed };
        if begins && is_noted {
            self.add_corner(clearance, (x - i32::from(since), row), -1, is_upper, cell)?;
        }
        if inwards.is_lt() && (since < OUT || has_stayed) {
            self.add_corner(clearance, (x - 1, row), 1, is_upper, cell)?;
        }
        Ok(next)
    }

    /// Notes the corners of the runs of the last column that no run of column `x` goes on with.
    fn end_runs<W: Workspace>(&mut self, clearance: &Clearance<'_, W>, x: i32) -> Result<(), Overflow> {
        for index in 0..self.previous.len() {
            let Some(run) = self.previous.get(index).copied() else { break };
            let [upper, lower] = run.since;
            if (1..NOTED).contains(&upper) {
                self.add_corner(clearance, (x - i32::from(upper), run.high), -1, true, run.cell)?;
            }
            if (1..NOTED).contains(&lower) {
                self.add_corner(clearance, (x - i32::from(lower), run.low), -1, false, run.cell)?;
            }
        }
        Ok(())
    }

    /// Notes a corner of a cell at a lattice point, where what is above or below begins (`side` −1) or ends (1).
    ///
    /// There the disc touches the wall's end from above or below. Where there is room the bend is as far to the side as
    /// the disc must be to pass the wall's end beside it, so that both what is along the wall and what is round its end
    /// is in straight reach.
    fn add_corner<W: Workspace>(
        &mut self,
        clearance: &Clearance<'_, W>,
        (x, row): (i32, u16),
        side: i32,
        is_upper: bool,
        cell: I,
    ) -> Result<(), Overflow> {
        let mut beside = side * clearance.reach_columns;
        // Half of it goes round half of the bend.
        while beside != 0 && !clearance.is_level_clear(x, x + beside, i32::from(row)) {
            beside /= 2;
        }
        let corner = Passage {
            cells: [cell, I::of(I::NONE)],
            right: lattice_index(x + 1),
            low: row,
            high: row,
            slant: i8::try_from(beside).unwrap_or(0),
            bits: CORNER_ONLY
                | LEFT
                | BESIDE
                | if is_upper { HIGH } else { 0 }
                | if side < 0 { RIGHT } else { 0 },
        };
        self.passages.push(corner).map_err(|_| Overflow::Passages)
    }

    /// Notes the passage between a run of the last column and one of column `x` that overlap or meet at a corner.
    fn add_passage<W: Workspace>(
        &mut self,
        clearance: &Clearance<'_, W>,
        x: i32,
        left: &Run<I>,
        right: &Run<I>,
    ) -> Result<(), Overflow> {
        let ((left_low, left_high), (low, high)) = (left.rows(), right.rows());
        let (first, last) = (low.max(left_low), high.min(left_high));
        // Runs that only meet at a corner: a slanting gap that just lets the disc through.
        let slant = if last < first { (low - left_high).signum() } else { 0 };
        let row = if slant > 0 { left_high } else { left_low };
        let step = (Spot::lattice(x - 1, row), Spot::lattice(x, row + slant));
        if slant != 0 && !clearance.is_clear(step.0, step.1) {
            return Ok(());
        }
        let (first, last) = if slant == 0 { (first, last) } else { (row, row) };
        let mut entry = Passage {
            cells: [left.cell, right.cell],
            right: lattice_index(x),
            low: lattice_index(first),
            high: lattice_index(last),
            slant: i8::try_from(slant).unwrap_or(0),
            bits: 0,
        };
        // An end is a corner where one of the runs goes on beyond. The bend is in its column: from there both what is
        // along the wall and what is round its end is in straight reach.
        let low_bits = if left_low < low { LEFT } else { 0 };
        let high_bits = HIGH | if left_high > high { LEFT } else { 0 };
        let is_corner = [left_low != low, left_high != high];
        entry.bits = if is_corner[1] && !is_corner[0] { high_bits } else { low_bits };
        self.passages.push(entry).map_err(|_| Overflow::Passages)?;
        if is_corner == [true; 2] && first < last {
            entry.bits = CORNER_ONLY | high_bits;
            self.passages.push(entry).map_err(|_| Overflow::Passages)?;
        }
        Ok(())
    }

    /// Whether the cell of `run` may go on with the run `low ..= high` of the next column.
    fn continues(&self, run: &Run<I>, (low, high): (i32, i32)) -> bool {
        self.cells
            .get(place(run.cell.get()))
            .is_some_and(|cell| i32::from(cell.low).max(low) <= i32::from(cell.high).min(high))
    }

    /// Numbers the entries of each cell, except those of dead ends.
    fn link(&mut self, keep: [u32; 2]) {
        self.find_dead_ends(keep);
        let Self { cells, passages, entries, previous, .. } = self;
        let entries = entries.as_flattened_mut();
        let is_alive =
            |cell: I| cell.get() == I::NONE || previous.get(place(cell.get())).is_some_and(Run::is_alive);
        let in_use = |passage: &&Passage<I>| passage.cells.into_iter().all(is_alive);
        for cell in passages.iter().filter(in_use).flat_map(|passage| passage.cells) {
            if let Some(cell) = cells.get_mut(place(cell.get())) {
                cell.entries = I::of(cell.entries.get() + 1);
            }
        }
        let mut end = 0;
        for cell in cells.iter_mut() {
            end += cell.entries.get();
            cell.entries = I::of(end);
        }
        // From the end to the beginning of each cell's part.
        for (index, passage) in passages.iter().enumerate().rev().filter(|(_, passage)| in_use(passage)) {
            for cell in passage.cells {
                if let Some(cell) = cells.get_mut(place(cell.get())) {
                    cell.entries = I::of(cell.entries.get() - 1);
                    if let Some(entry) = entries.get_mut(place(cell.entries.get())) {
                        *entry = I::of(number(index));
                    }
                }
            }
        }
        self.linked = place(end);
    }

    /// Forgets how far the cells are from anywhere. The runs are not needed any more, and their store holds for each
    /// cell what [`Self::note_distance`] is told.
    pub fn forget_distances(&mut self) {
        self.previous.clear();
        for _ in 0..self.cells.len() {
            // One for each cell: the capacity is the same.
            let _ = self.previous.push(Run::far());
        }
    }

    /// Notes which passage leads out of a cell towards somewhere, and how far that is from there; `false` when that was
    /// noted before.
    pub fn note_distance(&mut self, cell: u32, passage: u32, distance: f32) -> bool {
        let run = self.previous.get_mut(place(cell)).filter(|run| run.distance().is_none());
        if let Some(run) = run {
            run.set_distance(I::of(passage), distance);
            return true;
        }
        false
    }

    /// What was noted of a cell: the passage, [`Index::NONE`] for none, and how far it is from there.
    pub fn distance(&self, cell: u32) -> Option<(u32, f32)> {
        self.previous.get(place(cell)).and_then(Run::distance)
    }

    /// Finds the cells that no way between the cells of `keep` needs, since it would have to leave by the passage that
    /// it came in by: one passage after the other is taken from cells that have no other. Of a maze this leaves little
    /// but the way.
    ///
    /// The runs are not needed any more, and their store holds a [`Run`] for each cell that counts its passages.
    fn find_dead_ends(&mut self, keep: [u32; 2]) {
        self.previous.clear();
        for _ in 0..self.cells.len() {
            // One for each cell: the capacity is the same.
            let _ = self.previous.push(Run::counter());
        }
        for (index, passage) in self.passages.iter().enumerate().filter(|(_, passage)| passage.is_passage()) {
            for cell in passage.cells {
                if let Some(counter) = self.previous.get_mut(place(cell.get())) {
                    counter.count(number(index), 1);
                }
            }
        }
        for cell in keep {
            if let Some(counter) = self.previous.get_mut(place(cell)) {
                // More than there are: never down to the last.
                counter.count(0, 2);
            }
        }
        for first in 0..self.cells.len() {
            let mut cell = first;
            while let Some(last) = self.previous.get_mut(cell).and_then(Run::take_last) {
                let Some(passage) = self.passages.get(place(last)) else { break };
                let [left, right] = passage.cells.map(|cell| place(cell.get()));
                cell = if left == cell { right } else { left };
                if let Some(counter) = self.previous.get_mut(cell) {
                    counter.discount(last);
                }
            }
        }
    }

    /// The entry of that number.
    pub fn passage(&self, number: u32) -> Option<&Passage<I>> {
        self.passages.get(place(number))
    }

    /// Numbers of the passages and corners of a cell, in order.
    pub fn entries_of(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        let own = self.entries.as_flattened().get(self.entries_at(cell));
        own.unwrap_or_default().iter().map(|entry| entry.get())
    }

    /// Where those are.
    fn entries_at(&self, cell: u32) -> core::ops::Range<usize> {
        let begin = |cell: usize| self.cells.get(cell).map_or(self.linked, |cell| place(cell.entries.get()));
        begin(place(cell))..begin(place(cell).saturating_add(1))
    }
}
