//! Where the disc may be, asked of the raster each time: nothing inflated is stored.
//!
//! Everything here is measured in **quarter-cells** of the raster, from its lower left corner. The points with whole
//! coordinates form the *lattice*. It is exact where it matters:
//! - walls are unions of raster cells, so the middle of any gap (between two corners, a corner and an edge, or two
//!   edges) is a lattice point: the lattice sees every door at its full width. Half-cells would do for that; quarters
//!   halve what is lost on the way to the middle of a slanting gap, at twice the time of the sweep;
//! - the point of a wall nearest to a lattice edge or square is nearest to one of its lattice *corners*, since walls
//!   end at whole coordinates: four clear corners make the whole square clear, two make the edge clear.

use super::workspace::Workspace;
use crate::scalar::Scalar;

/// Lattice steps along the edge of a raster cell.
pub(super) const FINENESS: i32 = 4;

/// [`FINENESS`] for lengths.
const CELL: f32 = 4.0;

/// Largest radius of the disc in quarter-cells; with it the cursors of a column fit in a fixed array.
pub(super) const REACH_MAX: f32 = 96.0;

/// Largest radius of a disc, in quarter-cells, for which a lattice column is looked at 64 rows at a time. Walls are met
/// all along it where cells are as large as that, so that to go from wall to wall takes longer; with a larger disc,
/// which touches more columns, they are few.
const REACH_SMALL: f32 = 8.0;

/// Raster rows of 64 lattice rows.
const BLOCK: i32 = 16;

/// Rows below a block that are looked at with it: more than a disc of [`REACH_SMALL`] there can touch.
const BELOW: i32 = 4;

/// Columns of the raster that a disc of [`REACH_MAX`] can touch, with room for both ends.
const STENCIL: usize = 52;

/// By how much swept tests shrink the disc, in quarter-cells, to absorb the rounding of `f32` (at most 1e-3 on a raster
/// of 4096 cells). On a 10 mm raster this is 10 µm.
const TOLERANCE: f32 = 4e-3;

/// Halvings of the way that a bend can be moved.
pub(super) const HALVINGS: u8 = 6;

/// What [`HALVINGS`] leave of the way.
const LEAST_SHARE: f32 = 1.0 / 64.0;

/// How often all bends of a way through a cell are tightened.
const TIGHTENINGS: u8 = 3;

/// A point in quarter-cells from the lower left corner of the raster.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spot {
    pub x: f32,
    pub y: f32,
}

impl Spot {
    /// The lattice point.
    pub fn lattice(column: i32, row: i32) -> Self {
        Self { x: f32::from_i32(column), y: f32::from_i32(row) }
    }

    /// Distance to another spot.
    pub fn distance_to(self, other: Self) -> f32 {
        let (dx, dy) = (other.x - self.x, other.y - self.y);
        libm::sqrtf(dx * dx + dy * dy)
    }

    /// The spot at `share` (0 ..= 1) of the way to another.
    pub fn towards(self, other: Self, share: f32) -> Self {
        Self { x: self.x + share * (other.x - self.x), y: self.y + share * (other.y - self.y) }
    }
}

/// The next whole number at or below, of values within ±4 million. Asked so often that libm's would be a fifth of a
/// plan, and a conversion that saturates still a tenth.
pub(super) fn floor(value: f32) -> i32 {
    /// 1.5 · 2^23: whole numbers near it are the floats next to each other, so that a sum with it is rounded to one.
    const SHIFT: f32 = 12_582_912.0;
    let nearest = value + SHIFT;
    let whole = nearest.to_bits().wrapping_sub(SHIFT.to_bits()).cast_signed();
    whole.wrapping_sub(i32::from(nearest - SHIFT > value))
}

/// The raster seen by a disc.
pub(super) struct Clearance<'a, W> {
    workspace: &'a W,
    columns: i32,
    rows: i32,
    /// Radius of the disc, margin included, in quarter-cells.
    pub reach: f32,
    /// The same for swept tests, which are [`TOLERANCE`] more lenient.
    swept_reach: f32,
    /// How many lattice columns beside a wall's end the disc is clear of it.
    pub reach_columns: i32,
    /// How many lattice columns the end of a run must stay in a row to be more than the disc's roundness at a corner.
    pub corner_columns: u8,
    /// A lattice point is clear when every wall is at a squared distance of at least this, in quarter-cells².
    threshold: i32,
}

/// One raster column near a lattice column, and which of its wall cells is the next on the way up.
#[derive(Clone, Copy, Default)]
struct Cursor {
    column: i32,
    /// How far above and below a wall cell of this column the disc's centre must stay, in quarter-cells.
    extent: i32,
    /// Between these rows, both excluded, the disc touches that wall cell.
    from: i32,
    to: i32,
}

/// A walk up one lattice column from clear run to clear run.
pub(super) struct Column {
    cursors: heapless::Vec<Cursor, STENCIL>,
    /// No run left below this row.
    from: i32,
    /// Of a small disc: the clear rows from `base` up that are left, one bit each, the lowest first.
    clear: u64,
    base: i32,
}

impl<'a, W: Workspace> Clearance<'a, W> {
    /// `reach` (disc radius in quarter-cells) must be above 0 and at most [`REACH_MAX`].
    pub fn new(workspace: &'a W, reach: f32) -> Self {
        // Relative 1e-5: a disc that fits exactly must not fail by the rounding of metres to quarter-cells.
        let threshold = (-floor(-(reach * reach * (1.0 - 1e-5)))).max(1);
        let within = floor(reach);
        let reach_columns = if within * within >= threshold { within } else { within + 1 };
        let (columns, rows) = (i32::from(workspace.columns()), i32::from(workspace.rows()));
        let swept_reach = reach * (1.0 - 1e-5) - TOLERANCE;
        let corner_columns = u8::try_from((reach_columns / 4).clamp(2, 4)).unwrap_or(4);
        Self { workspace, columns, rows, reach, swept_reach, reach_columns, corner_columns, threshold }
    }

    /// Number of lattice columns.
    pub fn lattice_columns(&self) -> i32 {
        FINENESS * self.columns + 1
    }

    /// The first row from `row` up that is not free in a column of the raster; the row above the raster is not.
    fn next_wall(&self, column: i32, row: i32) -> i32 {
        match (u16::try_from(column), u16::try_from(row)) {
            (Ok(column), Ok(row)) if i32::from(row) < self.rows => {
                i32::from(self.workspace.next_wall(column, row)).min(self.rows)
            }
            _ => row,
        }
    }

    /// Which of the 64 raster cells from `row` up are not free, one bit each, that of `row` the lowest. What lies
    /// outside of the raster is not.
    fn walls(&self, column: i32, row: i32) -> u64 {
        if column >= self.columns || row >= self.rows {
            return u64::MAX;
        }
        let Ok(column) = u16::try_from(column) else { return u64::MAX };
        match u16::try_from(row) {
            Ok(row) => self.workspace.walls(column, row),
            Err(_) => {
                let below = row.unsigned_abs();
                let walls = self.workspace.walls(column, 0).checked_shl(below).unwrap_or(0);
                walls | !u64::MAX.checked_shl(below).unwrap_or(0)
            }
        }
    }

    /// Starts a walk up a lattice column.
    pub fn column(&self, x: i32) -> Column {
        let span = floor(self.reach) + 1;
        let mut cursors = heapless::Vec::new();
        for column in (x - span - FINENESS).div_euclid(FINENESS)..=(x + span).div_euclid(FINENESS) {
            let gap = (FINENESS * column - x).max(x - FINENESS * (column + 1)).max(0);
            if gap * gap >= self.threshold {
                continue;
            }
            let mut extent = 0;
            while gap * gap + extent * extent < self.threshold {
                extent += 1;
            }
            // Beside the raster everything is wall: no point of this lattice column is clear.
            let outside = column < 0 || column >= self.columns;
            let full = cursors.push(Cursor { column, extent, from: i32::MIN, to: i32::MIN }).is_err();
            if outside || full {
                return Column { cursors: heapless::Vec::new(), from: i32::MAX, clear: 0, base: i32::MAX };
            }
        }
        Column { cursors, from: 0, clear: 0, base: -FINENESS * BLOCK }
    }

    /// The next run of clear lattice points, first and last row, upwards.
    #[inline]
    pub fn next_run(&self, walk: &mut Column) -> Option<(i32, i32)> {
        if self.reach <= REACH_SMALL { self.next_run_in_words(walk) } else { self.next_run_by_walls(walk) }
    }

    /// [`Clearance::next_run`] of a small disc.
    fn next_run_in_words(&self, walk: &mut Column) -> Option<(i32, i32)> {
        while walk.clear == 0 {
            self.next_word(walk)?;
        }
        let low = walk.base + walk.clear.trailing_zeros().cast_signed();
        // All from the run's first row up to the first that is not clear.
        let mut above = !(walk.clear | ((walk.clear & walk.clear.wrapping_neg()) - 1));
        while above == 0 {
            // The rows of the last word end below the raster's edge, which is not clear.
            self.next_word(walk)?;
            above = !walk.clear;
        }
        let end = above.trailing_zeros();
        walk.clear &= u64::MAX << end;
        Some((low, walk.base + end.cast_signed() - 1))
    }

    /// Goes on to the next 64 rows of a lattice column.
    fn next_word(&self, walk: &mut Column) -> Option<()> {
        if walk.base >= FINENESS * self.rows {
            return None;
        }
        walk.base += FINENESS * BLOCK;
        walk.clear = !self.touched(&walk.cursors, walk.base / FINENESS);
        Some(())
    }

    /// Where a small disc touches a wall of the given columns: 64 rows of the lattice from the lower edge of a raster
    /// row, one bit each.
    fn touched(&self, near: &[Cursor], row: i32) -> u64 {
        // One for the rows on the edges of raster cells, and one each a quarter-cell higher.
        let mut touched = [0; 4];
        for cursor in near {
            let walls = self.walls(cursor.column, row - BELOW);
            if walls == 0 {
                continue;
            }
            for (up, touched) in (0..).zip(&mut touched) {
                // The first and last of the raster rows that reach within the extent of these.
                let first = (up - cursor.extent).div_euclid(FINENESS);
                let last = (up + cursor.extent - 1).div_euclid(FINENESS);
                for offset in BELOW + first..=BELOW + last {
                    *touched |= walls >> offset;
                }
            }
        }
        let [a, b, c, d] = touched.map(spread);
        a | b << 1 | c << 2 | d << 3
    }

    /// [`Clearance::next_run`] of a large disc.
    fn next_run_by_walls(&self, walk: &mut Column) -> Option<(i32, i32)> {
        let top = FINENESS * self.rows;
        let mut y = walk.from;
        while y <= top {
            let (mut blocked_until, mut clear_until) = (y, top);
            for cursor in &mut walk.cursors {
                if cursor.to <= y {
                    // The first row that is not left behind; a cursor only goes up, and stops above the raster.
                    let least = (y - FINENESS - cursor.extent).div_euclid(FINENESS) + 1;
                    let bottom = FINENESS * self.next_wall(cursor.column, least);
                    (cursor.from, cursor.to) = (bottom - cursor.extent, bottom + FINENESS + cursor.extent);
                }
                if cursor.from < y {
                    blocked_until = blocked_until.max(cursor.to);
                } else {
                    clear_until = clear_until.min(cursor.from);
                }
            }
            if blocked_until == y {
                walk.from = clear_until + 1;
                return Some((y, clear_until));
            }
            y = blocked_until;
        }
        walk.from = i32::MAX;
        None
    }

    /// Whether a lattice point is clear.
    pub fn is_clear_at(&self, x: i32, y: i32) -> bool {
        let mut walk = self.column(x);
        if self.reach <= REACH_SMALL {
            return !walk.cursors.is_empty()
                && y >= 0
                && self.touched(&walk.cursors, y.div_euclid(FINENESS)) >> (y % FINENESS) & 1 == 0;
        }
        walk.from = walk.from.max(y);
        self.next_run(&mut walk).is_some_and(|(low, _)| low == y)
    }

    /// Whether the disc can be moved straight from `a` to `b`: the swept capsule touches free cells only.
    ///
    /// Exact up to [`TOLERANCE`]. The capsule is convex, so in one raster column it covers one interval of rows; which
    /// is asked for only in columns with a wall in the box around the capsule.
    pub fn is_clear(&self, a: Spot, b: Spot) -> bool {
        let (a, b) = if a.x <= b.x { (a, b) } else { (b, a) };
        let reach = self.swept_reach;
        let (lower, upper) = if a.y <= b.y { (a.y, b.y) } else { (b.y, a.y) };
        let (first, last) = (floor((a.x - reach) / CELL), floor((b.x + reach) / CELL));
        let (low, high) = (floor((lower - reach) / CELL), floor((upper + reach) / CELL));
        if first < 0 || last >= self.columns || low < 0 || high >= self.rows {
            return false;
        }
        let mut capsule = None;
        // By the box's lowest row, as far as a word goes.
        let box_rows = u64::MAX.wrapping_shr((63 - (high - low).min(63)).cast_unsigned());
        let mut column = first;
        while column <= last {
            let walls = self.walls(column, low);
            if walls & box_rows != 0 || high - low >= 64 {
                let capsule = capsule.get_or_insert_with(|| Capsule::new(a, b, reach));
                let left = f32::from_i32(FINENESS * column).max(a.x - reach);
                let right = f32::from_i32(FINENESS * (column + 1)).min(b.x + reach);
                let (from, to) = capsule.rows(left, right);
                let (from, to) = (floor(from / CELL), floor(to / CELL));
                let is_wall = if to - low < 64 && low <= from && from <= to {
                    walls >> (from - low) << (63 - (to - from)) != 0
                } else {
                    self.has_wall(column, from, to)
                };
                if is_wall {
                    return false;
                }
            }
            column += 1;
        }
        true
    }

    /// [`Clearance::is_clear`] from one lattice point to another of the same row, which is asked for each corner.
    pub fn is_level_clear(&self, from: i32, to: i32, row: i32) -> bool {
        let (from, to) = (from.min(to), from.max(to));
        let reach = floor(self.swept_reach);
        for column in (from - reach - 1).div_euclid(FINENESS)..=(to + reach).div_euclid(FINENESS) {
            // Whole, as both ends are, so that the rows are those of the disc's whole height above it.
            let beside = (FINENESS * column - to).max(from - FINENESS * (column + 1)).max(0);
            let offset = f32::from_i32(beside);
            let height = libm::sqrtf((self.swept_reach * self.swept_reach - offset * offset).max(0.0));
            let (up, down) = (floor(height), -floor(-height));
            let (low, high) = ((row - down).div_euclid(FINENESS), (row + up).div_euclid(FINENESS));
            if low < 0 || self.has_wall(column, low, high) {
                return false;
            }
        }
        true
    }

    /// Whether any of the rows `low ..= high` is not free in a column of the raster.
    fn has_wall(&self, column: i32, low: i32, high: i32) -> bool {
        let mut row = low;
        while high - row >= 64 {
            if self.walls(column, row) != 0 {
                return true;
            }
            row += 64;
        }
        self.walls(column, row).wrapping_shl((63 - (high - row)).cast_unsigned()) != 0
    }

    /// The bend `b` between `a` and `c`, moved towards the line between them as far as the way stays clear.
    pub fn tightened(&self, a: Spot, b: Spot, c: Spot) -> Spot {
        let target = nearest_on(a, c, b);
        let (mut clear, mut blocked) = (0.0, 1.0);
        // Most bends are tight, and the least step tells.
        let least = b.towards(target, LEAST_SHARE);
        if !(self.is_clear(a, least) && self.is_clear(least, c)) {
            return b;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (clear + blocked);
            let moved = b.towards(target, middle);
            if self.is_clear(a, moved) && self.is_clear(moved, c) {
                clear = middle;
            } else {
                blocked = middle;
            }
        }
        b.towards(target, clear)
    }

    /// Tightens all bends of a way in turn; its ends stay.
    pub fn tighten(&self, way: &mut [Spot]) {
        for _ in 0..TIGHTENINGS {
            let mut has_moved = false;
            for index in 2..way.len() {
                if let Some([a, b, c]) = way.get_mut(index - 2..=index) {
                    let tightened = self.tightened(*a, *b, *c);
                    has_moved |= tightened != *b;
                    *b = tightened;
                }
            }
            if !has_moved {
                break;
            }
        }
    }

    /// The point of a wall that is nearest to `spot` and less than `within` away, of several the leftmost and lowest.
    /// With a direction (any length): only walls within 60° of it.
    pub fn nearest_wall(&self, spot: Spot, within: f32, direction: Option<Spot>) -> Option<Spot> {
        let mut search = WallSearch { spot, direction, best: within * within, nearest: None };
        let (first, last) = (floor((spot.x - within) / CELL), floor((spot.x + within) / CELL));
        let (low, high) = (floor((spot.y - within) / CELL), floor((spot.y + within) / CELL));
        // From the middle out, since what is near leaves little to look for.
        let middle = floor(spot.x / CELL);
        for column in (first..=middle).rev() {
            if !self.search_column(&mut search, column, low, high) {
                break;
            }
        }
        for column in middle + 1..=last {
            if !self.search_column(&mut search, column, low, high) {
                break;
            }
        }
        search.nearest.map(|(_, spot)| spot)
    }

    /// Looks for the nearest wall in the rows `low ..= high` of a column; `false` when none can be there, nor beyond.
    fn search_column(&self, search: &mut WallSearch, column: i32, low: i32, high: i32) -> bool {
        let left = f32::from_i32(FINENESS * column);
        let x = Scalar::clamp(search.spot.x, left, left + CELL);
        let dx = x - search.spot.x;
        if dx * dx > search.best {
            return false;
        }
        let middle = floor(search.spot.y / CELL);
        // Upwards, then downwards, in each case until what is left is too far. Most is within 32 rows.
        let near = self.walls(column, middle - 32);
        let (mut row, mut walls, mut next) = (middle, near >> 32, middle + 32);
        'up: loop {
            while walls != 0 {
                if !search.go_on(x, (column, row + walls.trailing_zeros().cast_signed())) {
                    break 'up;
                }
                walls &= walls - 1;
            }
            if next > high {
                break;
            }
            (row, walls, next) = (next, self.walls(column, next), next + 64);
        }
        (row, walls, next) = (middle - 64, near << 32, middle - 96);
        'down: loop {
            while walls != 0 {
                let bit = 63 - walls.leading_zeros();
                if !search.go_on(x, (column, row + bit.cast_signed())) {
                    break 'down;
                }
                walls &= !(1 << bit);
            }
            if next + 63 < low {
                break;
            }
            (row, walls, next) = (next, self.walls(column, next), next - 64);
        }
        true
    }
}

/// What is sought of walls, and what was found.
struct WallSearch {
    spot: Spot,
    direction: Option<Spot>,
    /// Squared distance of the nearest, or what it must be less than.
    best: f32,
    /// Cell and nearest point.
    nearest: Option<((i32, i32), Spot)>,
}

impl WallSearch {
    /// Takes a wall cell (column, row) with the given nearest x if it is nearer; `false` when none further in its
    /// column is.
    fn go_on(&mut self, x: f32, cell: (i32, i32)) -> bool {
        let bottom = f32::from_i32(FINENESS * cell.1);
        let y = Scalar::clamp(self.spot.y, bottom, bottom + CELL);
        let (dx, dy) = (x - self.spot.x, y - self.spot.y);
        let squared = dx * dx + dy * dy;
        if squared > self.best {
            return false;
        }
        let is_towards = |d| is_towards(dx, dy, squared, d);
        if !self.direction.is_none_or(is_towards) {
            return true;
        }
        let is_nearest = squared < self.best || self.nearest.is_some_and(|(other, _)| cell < other);
        if is_nearest {
            (self.best, self.nearest) = (squared, Some((cell, Spot { x, y })));
        }
        false
    }
}

/// The lowest 16 bits, three zeros after each.
fn spread(bits: u64) -> u64 {
    let bits = bits & 0xFFFF;
    let bits = (bits | bits << 24) & 0x0000_00FF_0000_00FF;
    let bits = (bits | bits << 12) & 0x000F_000F_000F_000F;
    let bits = (bits | bits << 6) & 0x0303_0303_0303_0303;
    (bits | bits << 3) & 0x1111_1111_1111_1111
}

/// Whether a vector of that squared length is within 60° of a direction.
fn is_towards(dx: f32, dy: f32, squared: f32, direction: Spot) -> bool {
    let along = dx * direction.x + dy * direction.y;
    along > 0.0 && along * along >= 0.25 * squared * (direction.x * direction.x + direction.y * direction.y)
}

/// The point of the segment `a`–`c` nearest to `b`.
fn nearest_on(a: Spot, c: Spot, b: Spot) -> Spot {
    let (dx, dy) = (c.x - a.x, c.y - a.y);
    let squared = dx * dx + dy * dy;
    if squared <= 0.0 {
        return a;
    }
    let share = ((b.x - a.x) * dx + (b.y - a.y) * dy) / squared;
    a.towards(c, share.clamp(0.0, 1.0))
}

/// A disc swept along a segment, `a.x ≤ b.x`.
struct Capsule {
    a: Spot,
    b: Spot,
    reach: f32,
    /// Unit vector from `a` to `b`, or zero.
    direction: Spot,
    /// Its outline above and below.
    above: Outline,
    below: Outline,
}

/// One side of a capsule's outline: a straight piece between two arcs.
struct Outline {
    /// The end of the capsule that is further out.
    extreme: Spot,
    /// Where the straight piece begins.
    start: Spot,
    /// x of its end.
    end_x: f32,
}

impl Capsule {
    fn new(a: Spot, b: Spot, reach: f32) -> Self {
        let length = a.distance_to(b);
        let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
        let direction = Spot { x: (b.x - a.x) * inverse, y: (b.y - a.y) * inverse };
        let (upper, lower) = if a.y > b.y { (a, b) } else { (b, a) };
        let (dx, dy) = (reach * direction.y, reach * direction.x);
        let above = Outline { extreme: upper, start: Spot { x: a.x - dx, y: a.y + dy }, end_x: b.x - dx };
        let below = Outline { extreme: lower, start: Spot { x: a.x + dx, y: a.y - dy }, end_x: b.x + dx };
        Self { a, b, reach, direction, above, below }
    }

    /// Lowest and highest y of the capsule over `left ..= right`. Its outline is concave above, convex below: each
    /// extreme is at the x nearest to that of the higher (lower) end.
    #[inline]
    fn rows(&self, left: f32, right: f32) -> (f32, f32) {
        (self.outermost(&self.below, -1.0, left, right), self.outermost(&self.above, 1.0, left, right))
    }

    /// The outermost y of the outline over `left ..= right`, above (`side` = 1) or below (−1).
    #[inline]
    fn outermost(&self, outline: &Outline, side: f32, left: f32, right: f32) -> f32 {
        let x = Scalar::clamp(outline.extreme.x, left, right);
        let (start, is_slanting) = (outline.start, self.direction.x > 0.0);
        if is_slanting && x >= start.x && x <= outline.end_x {
            return start.y + (x - start.x) * self.direction.y / self.direction.x;
        }
        let centre = if is_slanting { if x < start.x { self.a } else { self.b } } else { outline.extreme };
        let offset = x - centre.x;
        centre.y + side * libm::sqrtf((self.reach * self.reach - offset * offset).max(0.0))
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::super::workspace::{BitGrid, Workspace};
    use super::{Clearance, REACH_SMALL, Spot};

    const COLUMNS: u16 = 20;
    const ROWS: u16 = 150;

    /// A raster of which every so many cells are walls, strewn about.
    fn strewn(every: u32) -> BitGrid<96> {
        let mut grid = BitGrid::new(COLUMNS, ROWS, 0.01, (0.0, 0.0)).unwrap();
        let mut state = every;
        for column in 0..COLUMNS {
            for row in 0..ROWS {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                grid.set_free(column, row, !(state >> 8).is_multiple_of(every)).unwrap();
            }
        }
        grid
    }

    fn places() -> impl Iterator<Item = (i32, i32)> {
        (0..4 * i32::from(COLUMNS))
            .step_by(3)
            .flat_map(|x| (0..4 * i32::from(ROWS)).step_by(7).map(move |y| (x, y)))
    }

    #[test]
    fn rows_in_words_are_those_from_wall_to_wall() {
        for every in [2, 3, 10, 100, 2000] {
            let grid = strewn(every);
            for reach in [0.08, 1.0, 1.4, 2.0, 3.3, 5.0, 6.5, REACH_SMALL] {
                let clearance = Clearance::new(&grid, reach);
                for x in -1..=clearance.lattice_columns() {
                    let mut walk = clearance.column(x);
                    let words: Vec<_> =
                        core::iter::from_fn(|| clearance.next_run_in_words(&mut walk)).collect();
                    let mut walk = clearance.column(x);
                    let walls: Vec<_> =
                        core::iter::from_fn(|| clearance.next_run_by_walls(&mut walk)).collect();
                    assert_eq!(words, walls, "1 of {every} blocked, reach {reach}, column {x}");
                    for y in (-1..=4 * i32::from(ROWS) + 1).step_by(5) {
                        let inside = walls.iter().any(|run| run.0 <= y && y <= run.1);
                        assert_eq!(clearance.is_clear_at(x, y), inside, "reach {reach}, {x}, {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn level_moves_are_clear_as_others_are() {
        for every in [3, 20, 300] {
            let grid = strewn(every);
            for reach in [0.3, 1.4, 3.3, 6.5, 14.0, 40.0] {
                let clearance = Clearance::new(&grid, reach);
                for ((x, y), beside) in places().zip([-5, -2, -1, 0, 1, 2, 5].into_iter().cycle()) {
                    let expected = clearance.is_clear(Spot::lattice(x, y), Spot::lattice(x + beside, y));
                    let found = clearance.is_level_clear(x, x + beside, y);
                    assert_eq!(found, expected, "1 of {every} blocked, reach {reach}, {x} + {beside}, {y}");
                }
            }
        }
    }

    #[test]
    fn the_nearest_wall_is_the_nearest_of_all() {
        for (every, within) in [(3, 8.4), (20, 8.4), (300, 30.0), (2000, 400.0)] {
            let grid = strewn(every);
            let clearance = Clearance::new(&grid, 1.4);
            for (x, y) in places() {
                let spot = Spot {
                    x: 0.3 + f32::from(i16::try_from(x).unwrap()),
                    y: f32::from(i16::try_from(y).unwrap()),
                };
                for direction in [None, Some(Spot { x: 1.0, y: 0.5 }), Some(Spot { x: -0.2, y: -3.0 })] {
                    let found = clearance.nearest_wall(spot, within, direction);
                    let expected = nearest_of_all(&grid, spot, within, direction);
                    assert_eq!(found, expected, "1 of {every} blocked, {spot:?}, {direction:?}");
                }
            }
        }
    }

    /// [`Clearance::nearest_wall`] by looking at each cell in turn.
    fn nearest_of_all(grid: &BitGrid<96>, spot: Spot, within: f32, direction: Option<Spot>) -> Option<Spot> {
        let (mut best, mut nearest) = (within * within, None);
        let around = 110;
        for column in -around..i32::from(COLUMNS) + around {
            for row in -around..i32::from(ROWS) + around {
                let cell = u16::try_from(column).ok().zip(u16::try_from(row).ok());
                if cell.is_some_and(|(column, row)| grid.is_free(column, row)) {
                    continue;
                }
                let corner = Spot::lattice(4 * column, 4 * row);
                let (x, y) = (spot.x.clamp(corner.x, corner.x + 4.0), spot.y.clamp(corner.y, corner.y + 4.0));
                let (dx, dy) = (x - spot.x, y - spot.y);
                let squared = dx * dx + dy * dy;
                if squared < best && direction.is_none_or(|d| super::is_towards(dx, dy, squared, d)) {
                    (best, nearest) = (squared, Some(Spot { x, y }));
                }
            }
        }
        nearest
    }
}
