//! Grid maps of the kinds that planners are compared on, drawn by a seed: open, discs, streets, caves, rooms, mazes,
//! random cells.

use controller_core::planning::SIDE_MAX;
use host_sim::import::{GridMap, MapFrame};
use host_sim::random::{Purpose, Stream};

/// A kind of map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// Nothing in the way.
    Empty,
    /// A disc of 2 to 7 cells radius in every so many cells of the map.
    Discs(f64),
    /// A house in every so many cells of the map, all turned by about 20° as streets of a town are.
    Streets(f64),
    /// Rounded caves as in games: this share of the cells blocked at first, then four times what most neighbours are.
    Caves(f64),
    /// Square rooms of so many cells, with walls and doors of one cell; a tenth of the doors are shut.
    Rooms(usize),
    /// A maze without loops, of corridors so many cells wide.
    Maze(usize),
    /// This share of the cells blocked, each by itself.
    Random(f64),
}

impl Kind {
    /// The kinds that are measured: those of Moving AI's maps of 512 x 512 cells, and some more.
    pub const ALL: [Self; 19] = [
        Self::Empty,
        Self::Discs(2600.0),
        Self::Discs(220.0),
        Self::Streets(900.0),
        Self::Caves(0.4),
        Self::Rooms(63),
        Self::Rooms(31),
        Self::Rooms(15),
        Self::Rooms(7),
        Self::Maze(32),
        Self::Maze(8),
        Self::Maze(4),
        Self::Maze(2),
        Self::Maze(1),
        Self::Random(0.02),
        Self::Random(0.1),
        Self::Random(0.2),
        Self::Random(0.3),
        Self::Random(0.4),
    ];

    /// Name with its number.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::Empty => String::from("empty"),
            Self::Discs(cells) => format!("discs, one in {cells} cells"),
            Self::Streets(cells) => format!("streets, house in {cells} cells"),
            Self::Caves(share) => format!("caves from {:.0} %", share * 100.0),
            Self::Rooms(side) => format!("rooms of {side}"),
            Self::Maze(width) => format!("maze, corridors of {width}"),
            Self::Random(share) => format!("random, {:.0} %", share * 100.0),
        }
    }
}

/// Side of a cell in m: two robots wide.
pub const CELL_M: f64 = 0.1;

/// A square map, as large as asked for up to the planner's largest.
#[must_use]
pub fn draw(kind: Kind, side: usize, seed: u64) -> GridMap {
    let side = side.min(usize::from(SIDE_MAX));
    let mut stream = Stream::new(seed, Purpose::BenchmarkPlaces);
    let mut map = GridMap {
        name: kind.name(),
        source: format!("drawn with seed {seed}"),
        columns: side,
        rows: side,
        cell_m: CELL_M,
        frame: MapFrame::IDENTITY,
        passable: vec![!matches!(kind, Kind::Maze(_)); side * side],
    };
    match kind {
        Kind::Empty => {}
        Kind::Discs(cells) => discs(&mut map, &mut stream, cells),
        Kind::Streets(cells) => streets(&mut map, &mut stream, cells),
        Kind::Caves(share) => caves(&mut map, &mut stream, share),
        Kind::Rooms(room) => rooms(&mut map, &mut stream, room),
        Kind::Maze(width) => maze(&mut map, &mut stream, width),
        Kind::Random(share) => random(&mut map, &mut stream, share),
    }
    map
}

/// A whole number below a bound.
fn below(stream: &mut Stream, bound: usize) -> usize {
    let float = float(bound);
    let drawn = stream.between(0.0, float);
    (0..bound).rev().find(|&whole| self::float(whole) <= drawn).unwrap_or(0)
}

fn float(count: usize) -> f64 {
    u32::try_from(count).map_or(f64::INFINITY, f64::from)
}

fn set(map: &mut GridMap, column: usize, row: usize, passable: bool) {
    if column < map.columns && row < map.rows {
        map.passable[row * map.columns + column] = passable;
    }
}

fn discs(map: &mut GridMap, stream: &mut Stream, cells: f64) {
    let side = float(map.columns);
    let mut left = side * side / cells;
    while left >= 1.0 {
        left -= 1.0;
        let (x, y, radius) = (stream.between(0.0, side), stream.between(0.0, side), stream.between(2.0, 7.0));
        for row in 0..map.rows {
            let dy = float(row) + 0.5 - y;
            for column in 0..map.columns {
                if dy.abs() < radius && (float(column) + 0.5 - x).hypot(dy) < radius {
                    set(map, column, row, false);
                }
            }
        }
    }
}

fn random(map: &mut GridMap, stream: &mut Stream, share: f64) {
    map.passable.iter_mut().for_each(|passable| *passable = stream.between(0.0, 1.0) >= share);
}

fn streets(map: &mut GridMap, stream: &mut Stream, cells: f64) {
    let side = float(map.columns);
    let mut left = side * side / cells;
    while left >= 1.0 {
        left -= 1.0;
        let (x, y) = (stream.between(0.0, side), stream.between(0.0, side));
        let (long, wide) = (stream.between(4.0, 16.0), stream.between(3.0, 11.0));
        let turn = stream.between(0.3, 0.4);
        let (cos, sin) = (turn.cos(), turn.sin());
        for row in 0..map.rows {
            let dy = float(row) + 0.5 - y;
            for column in 0..map.columns {
                let dx = float(column) + 0.5 - x;
                if (cos * dx + sin * dy).abs() < long && (cos * dy - sin * dx).abs() < wide {
                    set(map, column, row, false);
                }
            }
        }
    }
}

fn caves(map: &mut GridMap, stream: &mut Stream, share: f64) {
    random(map, stream, share);
    for _ in 0..4 {
        let before = map.clone();
        for row in 0..map.rows {
            for column in 0..map.columns {
                let near = (0..9).filter(|index| {
                    let (column, row) = (column + index % 3, row + index / 3);
                    column > 0 && row > 0 && before.is_passable(column - 1, row - 1)
                });
                set(map, column, row, near.count() >= 5);
            }
        }
    }
}

fn rooms(map: &mut GridMap, stream: &mut Stream, room: usize) {
    let side = map.columns;
    let step = room + 1;
    for at in (room..side).step_by(step) {
        for along in 0..side {
            set(map, at, along, false);
            set(map, along, at, false);
        }
    }
    for at in (room..side).step_by(step) {
        for first in (0..side).step_by(step) {
            let length = room.min(side - first);
            for upright in [true, false] {
                let door = first + below(stream, length);
                if stream.between(0.0, 1.0) >= 0.1 {
                    let (column, row) = if upright { (at, door) } else { (door, at) };
                    set(map, column, row, true);
                }
            }
        }
    }
}

/// Carves corridors from a place to a random neighbour that is still solid, and back where there is none.
fn maze(map: &mut GridMap, stream: &mut Stream, width: usize) {
    let step = width + 1;
    let places = map.columns / step;
    let mut seen = vec![false; places * places];
    let mut way = vec![0];
    seen[0] = true;
    carve(map, (0, 0), (width, width));
    while let Some(&here) = way.last() {
        let (x, y) = (here % places, here / places);
        let mut sides = Vec::new();
        if x > 0 {
            sides.push(here - 1);
        }
        if x + 1 < places {
            sides.push(here + 1);
        }
        sides.extend(here.checked_sub(places));
        if y + 1 < places {
            sides.push(here + places);
        }
        sides.retain(|&next| !seen[next]);
        if sides.is_empty() {
            way.pop();
            continue;
        }
        let next = sides[below(stream, sides.len())];
        seen[next] = true;
        let low = (x.min(next % places) * step, y.min(next / places) * step);
        let is_along = next / places == y;
        let size = if is_along { (width + step, width) } else { (width, width + step) };
        carve(map, low, size);
        way.push(next);
    }
}

fn carve(map: &mut GridMap, low: (usize, usize), size: (usize, usize)) {
    for row in low.1..low.1 + size.1 {
        for column in low.0..low.0 + size.0 {
            set(map, column, row, true);
        }
    }
}
