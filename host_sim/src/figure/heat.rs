//! Rates over two measures as a table of colours.

use nalgebra::Point2;
use svg::Document;
use svg::node::element::{Group, Rectangle, Title};

use super::canvas::{decimal, text};

/// A table of rates.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// What it shows.
    pub title: String,
    /// Conditions, seeds, what the numbers are.
    pub under: String,
    /// What the columns are, with unit.
    pub columns: String,
    /// What the rows are, with unit.
    pub rows: String,
    /// Names of the columns, from the left.
    pub column_names: Vec<String>,
    /// Names of the rows, from the top.
    pub row_names: Vec<String>,
    /// For each row, for each column: what was measured; `None` where nothing was.
    pub cells: Vec<Vec<Option<HeatCell>>>,
    /// Cells from this share on are framed.
    pub passed: f64,
    /// What frame and small print mean.
    pub legend: String,
}

/// What was measured in one place.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatCell {
    /// The rate, 0 to 1.
    pub share: f64,
    /// Small print below it.
    pub note: String,
    /// What hovering tells.
    pub hint: String,
}

const CELL_WIDTH: f64 = 64.0;
const CELL_HEIGHT: f64 = 38.0;
const GAP: f64 = 3.0;
const EDGE: f64 = 20.0;
const TOP: f64 = 104.0;
/// Widths of letters over the size of their fonts: generous, since fonts differ.
const LETTER: f64 = 0.58;
const BOLD_LETTER: f64 = 0.66;

/// What a text takes at most, in pixels.
fn width_of(text: &str, size: f64, letter: f64) -> f64 {
    text.chars().map(|_| size * letter).sum()
}

/// Draws a table of rates; the same input gives the same text.
#[must_use]
pub fn draw_heat_map(map: &HeatMap) -> String {
    let names = map.row_names.iter().map(|name| width_of(name, 14.0, LETTER));
    let left = names.chain([width_of(&map.rows, 12.0, LETTER)]).fold(0.0, f64::max) + EDGE + 12.0;
    let places = |count: usize, first: f64, step: f64| {
        core::iter::successors(Some(first), move |at| Some(at + step)).take(count)
    };
    let lefts: Vec<f64> = places(map.column_names.len(), left, CELL_WIDTH).collect();
    let tops: Vec<f64> = places(map.row_names.len(), TOP, CELL_HEIGHT).collect();
    let right = lefts.last().map_or(left, |last| last + CELL_WIDTH);
    let bottom = tops.last().map_or(TOP, |last| last + CELL_HEIGHT);
    let texts = [(&map.title, 18.0, BOLD_LETTER), (&map.under, 12.0, LETTER), (&map.legend, 12.0, LETTER)];
    let texts = texts.map(|(text, size, letter)| width_of(text, size, letter));
    let width = texts.into_iter().fold(right, f64::max) + EDGE;
    let height = bottom + 34.0;

    let grey = |at, text_: &str| text(at, 12.0, text_).set("fill", "#555555");
    let mut document = Document::new()
        .set("viewBox", format!("0 0 {} {}", decimal(width), decimal(height)))
        .set("width", decimal(width))
        .set("height", decimal(height))
        .set("font-family", "sans-serif")
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "#ffffff"))
        .add(text(Point2::new(EDGE, 28.0), 18.0, &map.title).set("font-weight", "bold"))
        .add(grey(Point2::new(EDGE, 48.0), &map.under))
        .add(grey(Point2::new(left, TOP - 30.0), &format!("{} →", map.columns)))
        .add(grey(Point2::new(left - 12.0, TOP - 10.0), &format!("{} ↓", map.rows)).set("text-anchor", "end"))
        .add(grey(Point2::new(EDGE, height - 12.0), &map.legend));
    for (&x, name) in lefts.iter().zip(&map.column_names) {
        document = document.add(centred(x, TOP - 10.0, 14.0, name));
    }
    for ((&top, name), cells) in tops.iter().zip(&map.row_names).zip(&map.cells) {
        let at = Point2::new(left - 12.0, top + CELL_HEIGHT / 2.0 + 4.0);
        document = document.add(text(at, 14.0, name).set("text-anchor", "end"));
        for (&x, cell) in lefts.iter().zip(cells) {
            let Some(cell) = cell else { continue };
            document = document.add(draw_cell(cell, Point2::new(x, top), map.passed));
        }
    }
    document.to_string()
}

/// A text in the middle of a column.
fn centred(left: f64, y: f64, size: f64, content: &str) -> svg::node::element::Text {
    text(Point2::new(left + (CELL_WIDTH - GAP) / 2.0, y), size, content).set("text-anchor", "middle")
}

fn draw_cell(cell: &HeatCell, at: Point2<f64>, passed: f64) -> Group {
    let mut field = Rectangle::new()
        .set("x", decimal(at.x))
        .set("y", decimal(at.y))
        .set("width", decimal(CELL_WIDTH - GAP))
        .set("height", decimal(CELL_HEIGHT - GAP))
        .set("fill", colour(cell.share));
    if cell.share >= passed {
        field = field.set("stroke", "#14532d").set("stroke-width", 2);
    }
    let ink = if cell.share < 0.35 { "#ffffff" } else { "#111111" };
    let middle = if cell.note.is_empty() { 22.0 } else { 17.0 };
    // One decimal only where it tells something: 99.6 must not look like 100.
    let number = format!("{:.1}", cell.share * 100.0);
    let number = number.strip_suffix(".0").unwrap_or(&number);
    let mut group = Group::new()
        .add(Title::new(cell.hint.clone()))
        .add(field)
        .add(centred(at.x, at.y + middle, 14.0, number).set("fill", ink));
    if !cell.note.is_empty() {
        group = group.add(centred(at.x, at.y + 29.0, 9.5, &cell.note).set("fill", ink));
    }
    group
}

/// From dark red over yellow to green; what is short of all is told from all.
fn colour(share: f64) -> String {
    let stops = [
        (0.0, (122.0, 20.0, 40.0)),
        (0.5, (230.0, 120.0, 60.0)),
        (0.9, (250.0, 220.0, 120.0)),
        (0.99, (160.0, 205.0, 130.0)),
        (1.0, (90.0, 170.0, 110.0)),
    ];
    let mut mixed = stops[0].1;
    for pair in stops.windows(2) {
        let ((from, a), (to, b)) = (pair[0], pair[1]);
        if share >= from {
            let t = ((share - from) / (to - from)).clamp(0.0, 1.0);
            let mix = |a: f64, b: f64| a + (b - a) * t;
            mixed = (mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2));
        }
    }
    format!("rgb({:.0},{:.0},{:.0})", mixed.0, mixed.1, mixed.2)
}

#[cfg(test)]
mod tests {
    use super::{HeatCell, HeatMap, colour, draw_heat_map};

    fn cell(share: f64, note: &str) -> Option<HeatCell> {
        Some(HeatCell { share, note: note.to_owned(), hint: format!("{share} of all") })
    }

    fn map() -> HeatMap {
        HeatMap {
            title: String::from("A & B"),
            under: String::from("10 runs"),
            columns: String::from("width cm"),
            rows: String::from("angle"),
            column_names: vec![String::from("10"), String::from("20")],
            row_names: vec![String::from("0"), String::from("45")],
            cells: vec![vec![cell(0.996, ""), None], vec![cell(0.2, "contact 5"), cell(0.2, "")]],
            passed: 0.99,
            legend: String::from("framed: passed"),
        }
    }

    #[test]
    fn draws_what_was_measured_and_leaves_out_what_was_not() {
        let drawn = draw_heat_map(&map());
        assert!(drawn.contains("A &amp; B") && drawn.contains("contact 5"), "{drawn}");
        assert_eq!(drawn.matches("<title>").count(), 3);
        assert_eq!(drawn.matches("stroke=").count(), 1, "one is passed");
        assert!(drawn.contains("\n99.6\n") && drawn.contains("\n20\n"), "{drawn}");
        assert_eq!(drawn, draw_heat_map(&map()));
    }

    #[test]
    fn is_wide_enough_for_its_texts() {
        let width = |map: &HeatMap| -> f64 {
            let drawn = draw_heat_map(map);
            drawn.split("viewBox=\"0 0 ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
        };
        let longer = HeatMap { title: "A long title ".repeat(10), ..map() };
        assert!(width(&longer) > 1000.0 && width(&map()) < 400.0, "{} {}", width(&longer), width(&map()));
    }

    #[test]
    fn better_is_greener() {
        let green = |share| -> i32 { colour(share).split(',').nth(1).unwrap().parse().unwrap() };
        assert!(green(0.0) < green(0.5) && green(0.5) < green(0.9));
        assert_ne!(colour(1.0), colour(0.98));
    }
}
