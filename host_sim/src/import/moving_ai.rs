//! Moving AI grid maps (`.map`, type octile) and their problems (`.scen`, version 1).
//!
//! Row 0 is the topmost. `.` and `G` are passable, and `S` (swamp), which is for us like any ground; `@`, `O`, `T` and
//! `W` are not. Format: <https://movingai.com/benchmarks/formats.html> (Sturtevant, 2012).

use std::path::Path;

use super::json_world::file_stem;
use super::{GridMap, ImportError, MapFrame, Reader, SIDE_MAX, read_text};

/// Most problems of a `.scen` file.
const PROBLEMS_MAX: usize = 1_000_000;

/// One problem: cells from the left and from the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Problem {
    /// Problems of like length share a bucket.
    pub bucket: u32,
    /// Column and row of the start.
    pub start: (usize, usize),
    /// Column and row of the goal.
    pub goal: (usize, usize),
    /// Length of the shortest way of a point over the eight neighbours, without cutting corners, in cells.
    pub optimal_cells: f64,
}

/// Reads a map with cells of `cell_m`.
///
/// # Errors
/// If it cannot be read or is no such map.
pub fn load_map(path: &Path, cell_m: f64) -> Result<GridMap, ImportError> {
    parse_map(path, &read_text(path)?, cell_m)
}

/// A map from its text; `path` is what errors call it.
///
/// # Errors
/// As [`load_map`].
pub fn parse_map(path: &Path, text: &str, cell_m: f64) -> Result<GridMap, ImportError> {
    let reader = Reader::new(path);
    let cell_m = reader.length("cell size", cell_m)?;
    let mut lines = text.lines().zip(1_usize..);
    let mut head = |keyword: &str| {
        let (line, number) = lines.next().unwrap_or(("", 0));
        let place = format!("line {number}");
        match line.trim().strip_prefix(keyword) {
            Some(value) => Ok((place, value.trim().to_owned())),
            None => {
                let problem = format!("`{}` instead of `{keyword}`", super::error::shortened(line));
                Err(reader.error(&place, problem, "begin with type, height, width and map"))
            }
        }
    };
    let (place, kind) = head("type")?;
    if kind != "octile" {
        let problem = format!("type `{}`", super::error::shortened(&kind));
        return Err(reader.error(&place, problem, "give a map of type octile"));
    }
    let rows = side(&reader, &head("height")?)?;
    let columns = side(&reader, &head("width")?)?;
    head("map")?;
    let mut passable = vec![false; rows * columns];
    for row in (0..rows).rev() {
        let Some((line, number)) = lines.next() else {
            let problem = format!("{} rows instead of {rows}", rows - 1 - row);
            return Err(reader.error("end", problem, "complete the map"));
        };
        let place = format!("line {number}");
        let cells: Vec<char> = line.trim_end_matches('\r').chars().collect();
        if cells.len() != columns {
            let problem = format!("{} cells instead of {columns}", cells.len());
            return Err(reader.error(&place, problem, "correct the row, or the width"));
        }
        for (column, cell) in cells.into_iter().enumerate() {
            passable[row * columns + column] = match cell {
                '.' | 'G' | 'S' => true,
                '@' | 'O' | 'T' | 'W' => false,
                other => {
                    let problem = format!("`{other}` in column {column}");
                    return Err(reader.error(&place, problem, "use . G S @ O T W"));
                }
            };
        }
    }
    if let Some((line, number)) = lines.find(|(line, _)| !line.trim().is_empty()) {
        let problem = format!("`{}` behind the last row", super::error::shortened(line));
        return Err(reader.error(&format!("line {number}"), problem, "correct the height"));
    }
    let name = file_stem(path).unwrap_or_default();
    let source = String::from("Moving AI grid map");
    Ok(GridMap { name, source, columns, rows, cell_m, frame: MapFrame::IDENTITY, passable })
}

fn side(reader: &Reader, (place, text): &(String, String)) -> Result<usize, ImportError> {
    let side: usize = reader.number(place, text)?;
    if (1..=SIDE_MAX).contains(&side) {
        return Ok(side);
    }
    Err(reader.error(place, format!("{side} cells"), &format!("give 1 to {SIDE_MAX}")))
}

/// Reads the problems of a map.
///
/// # Errors
/// If they cannot be read, are none, or are of a map of another size.
pub fn load_problems(path: &Path, map: &GridMap) -> Result<Vec<Problem>, ImportError> {
    parse_problems(path, &read_text(path)?, map)
}

/// Problems from their text; `path` is what errors call it.
///
/// # Errors
/// As [`load_problems`].
pub fn parse_problems(path: &Path, text: &str, map: &GridMap) -> Result<Vec<Problem>, ImportError> {
    let reader = Reader::new(path);
    let mut lines = text.lines().zip(1_usize..);
    let first = lines.next().map_or("", |(line, _)| line.trim());
    if !matches!(first, "version 1" | "version 1.0") {
        let problem = format!("`{}` instead of `version 1`", super::error::shortened(first));
        return Err(reader.error("line 1", problem, "give problems of version 1"));
    }
    let mut problems = Vec::new();
    for (line, number) in lines.filter(|(line, _)| !line.trim().is_empty()) {
        let place = format!("line {number}");
        if problems.len() == PROBLEMS_MAX {
            return Err(reader.error(&place, format!("more than {PROBLEMS_MAX} problems"), "give fewer"));
        }
        problems.push(problem(&reader, &place, line, map)?);
    }
    Ok(problems)
}

fn problem(reader: &Reader, place: &str, line: &str, map: &GridMap) -> Result<Problem, ImportError> {
    // Tabs between the fields, so that the map's name may hold spaces; some files have spaces only.
    let fields: Vec<&str> = if line.contains('\t') {
        line.trim().split('\t').collect()
    } else {
        line.split_whitespace().collect()
    };
    let [bucket, _, width, height, start_x, start_y, goal_x, goal_y, optimal] = fields[..] else {
        let problem = format!("{} fields instead of 9", fields.len());
        return Err(reader.error(place, problem, "give bucket, map, width, height, start, goal and length"));
    };
    let size: (usize, usize) = (reader.number(place, width)?, reader.number(place, height)?);
    if size != (map.columns, map.rows) {
        let problem =
            format!("a map of {} x {}, this one has {} x {}", size.0, size.1, map.columns, map.rows);
        return Err(reader.error(place, problem, "give the problems of this map"));
    }
    let cell = |x: &str, y: &str| {
        let (x, y): (usize, usize) = (reader.number(place, x)?, reader.number(place, y)?);
        if x < map.columns && y < map.rows {
            return Ok((x, y));
        }
        Err(reader.error(place, format!("cell ({x}, {y}) is outside of the map"), "correct it"))
    };
    let optimal_cells: f64 = reader.number(place, optimal)?;
    if !(optimal_cells.is_finite() && optimal_cells >= 0.0) {
        return Err(reader.error(place, format!("a length of {optimal_cells}"), "give 0 or more"));
    }
    let (start, goal) = (cell(start_x, start_y)?, cell(goal_x, goal_y)?);
    Ok(Problem { bucket: reader.number(place, bucket)?, start, goal, optimal_cells })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::proptest;

    use super::{Problem, parse_map, parse_problems};

    const MAP: &str = "type octile\nheight 2\nwidth 3\nmap\n.@G\nSTW\n";

    fn map(text: &str) -> Result<super::GridMap, String> {
        parse_map(Path::new("a.map"), text, 0.1).map_err(|error| error.to_string())
    }

    #[test]
    fn the_first_row_is_the_topmost() {
        let map = map(MAP).unwrap();
        assert_eq!(map.passable, [true, false, false, true, false, true]);
        assert!(map.is_passable(0, 1) && !map.is_passable(1, 1));
    }

    #[test]
    fn problems_are_read_by_their_fields() {
        let map = map(MAP).unwrap();
        let text = "version 1\n3\ta b.map\t3\t2\t0\t0\t2\t0\t2.5\n\n";
        let problems = parse_problems(Path::new("a.scen"), text, &map).unwrap();
        assert_eq!(problems, [Problem { bucket: 3, start: (0, 0), goal: (2, 0), optimal_cells: 2.5 }]);
        for (line, said) in [
            ("3\ta\t3\t2\t0\t0\t2\t0", "8 fields"),
            ("3\ta\t4\t2\t0\t0\t2\t0\t1", "a map of 4 x 2"),
            ("3\ta\t3\t2\t0\t0\t3\t0\t1", "(3, 0)"),
            ("3\ta\t3\t2\t0\t-1\t2\t0\t1", "`-1`"),
            ("3\ta\t3\t2\t0\t0\t2\t0\tNaN", "NaN"),
        ] {
            let error = parse_problems(Path::new("a.scen"), &format!("version 1\n{line}"), &map).unwrap_err();
            let error = error.to_string();
            assert!(error.starts_with("a.scen: line 2: ") && error.contains(said), "{error}");
        }
        assert!(parse_problems(Path::new("a.scen"), "", &map).is_err());
    }

    #[test]
    fn a_broken_map_is_refused_with_its_line() {
        for (text, said) in [
            ("", "instead of `type`"),
            ("type hex\n", "line 1: type `hex`"),
            ("type octile\nheight x\n", "line 2: `x`"),
            ("type octile\nheight 5000\n", "line 2: 5000 cells"),
            ("type octile\nheight 0\n", "0 cells"),
            ("type octile\nheight 1\nwidth 2\nmap\n...\n", "line 5: 3 cells"),
            ("type octile\nheight 2\nwidth 2\nmap\n..\n", "1 rows instead of 2"),
            ("type octile\nheight 1\nwidth 2\nmap\n.x\n", "`x` in column 1"),
            ("type octile\nheight 1\nwidth 2\nmap\n..\n..\n", "line 6"),
        ] {
            let error = map(text).unwrap_err();
            assert!(error.contains(said), "{text}: {error}");
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(
            text in "(type octile\nheight [0-9]{1,2}\nwidth [0-9]\nmap\n)?[.@\n\t0-9é]{0,60}"
        ) {
            let _ = map(&text);
            let _ = parse_problems(Path::new("a.scen"), &text, &map(MAP).unwrap());
        }
    }
}
