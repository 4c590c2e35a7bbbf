//! Rates over two measures as a table of colours.

use svg::Document;
use svg::node::element::{Rectangle, Title};

use super::canvas::{decimal, text};
use nalgebra::Point2;

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
    /// For each row, for each column: a share, 0 to 1, and what hovering tells; `None` where nothing was measured.
    pub shares: Vec<Vec<Option<(f64, String)>>>,
    /// Cells from this share on are framed.
    pub passed: f64,
}

const CELL_WIDTH: f64 = 64.0;
const CELL_HEIGHT: f64 = 34.0;
const LEFT: f64 = 120.0;
const TOP: f64 = 96.0;

/// Draws a table of rates; the same input gives the same text.
#[must_use]
pub fn draw_heat_map(map: &HeatMap) -> String {
    let (mut lefts, mut next) = (Vec::new(), 0.0);
    for _ in &map.column_names {
        lefts.push(next);
        next += CELL_WIDTH;
    }
    let width = (LEFT + next + 40.0).max(640.0);
    let mut top = TOP;
    let mut content = Vec::new();
    for (name, shares) in map.row_names.iter().zip(&map.shares) {
        content.push(text(Point2::new(LEFT - 12.0, top + 22.0), 14.0, name).set("text-anchor", "end").into());
        for (left, share) in lefts.iter().zip(shares) {
            let Some((share, hint)) = share else { continue };
            let cell = Rectangle::new()
                .set("x", decimal(LEFT + left))
                .set("y", decimal(top))
                .set("width", decimal(CELL_WIDTH - 2.0))
                .set("height", decimal(CELL_HEIGHT - 2.0))
                .set("fill", colour(*share))
                .add(Title::new(hint.clone()));
            content.push(Box::new(cell) as Box<dyn svg::Node>);
            let number = format!("{:.0}", share * 100.0);
            let middle = Point2::new(LEFT + left + CELL_WIDTH / 2.0, top + 22.0);
            let ink = if *share < 0.35 { "#ffffff" } else { "#111111" };
            content.push(text(middle, 14.0, &number).set("text-anchor", "middle").set("fill", ink).into());
        }
        top += CELL_HEIGHT;
    }
    for (left, name) in lefts.iter().zip(&map.column_names) {
        let middle = Point2::new(LEFT + left + CELL_WIDTH / 2.0, TOP - 10.0);
        content.push(text(middle, 14.0, name).set("text-anchor", "middle").into());
    }
    let height = top + 44.0;
    let mut document = Document::new()
        .set("viewBox", format!("0 0 {} {}", decimal(width), decimal(height)))
        .set("font-family", "sans-serif")
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "#ffffff"))
        .add(text(Point2::new(20.0, 28.0), 18.0, &map.title).set("font-weight", "bold"))
        .add(text(Point2::new(20.0, 48.0), 12.0, &map.under).set("fill", "#555555"))
        .add(text(Point2::new(LEFT, TOP - 30.0), 12.0, &format!("{} →", map.columns)).set("fill", "#555555"))
        .add(text(Point2::new(20.0, height - 16.0), 12.0, &format!("↑ {}", map.rows)).set("fill", "#555555"));
    for node in content {
        document = document.add(node);
    }
    document.to_string()
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
    use super::{HeatMap, colour, draw_heat_map};

    #[test]
    fn draws_what_was_measured_and_leaves_out_what_was_not() {
        let map = HeatMap {
            title: String::from("A & B"),
            under: String::from("10 runs"),
            columns: String::from("width cm"),
            rows: String::from("angle"),
            column_names: vec![String::from("10"), String::from("20")],
            row_names: vec![String::from("0"), String::from("45")],
            shares: vec![
                vec![Some((1.0, String::from("10 of 10"))), None],
                vec![Some((0.2, String::from("2 of 10"))); 2],
            ],
            passed: 0.99,
        };
        let drawn = draw_heat_map(&map);
        assert!(drawn.contains("A &amp; B"), "{drawn}");
        assert_eq!(drawn.matches("<title>").count(), 3);
        assert_eq!(drawn, draw_heat_map(&map));
    }

    #[test]
    fn better_is_greener() {
        let green = |share| -> i32 { colour(share).split(',').nth(1).unwrap().parse().unwrap() };
        assert!(green(0.0) < green(0.5) && green(0.5) < green(0.9));
        assert_ne!(colour(1.0), colour(0.98));
    }
}
