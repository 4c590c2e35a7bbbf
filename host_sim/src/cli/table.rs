//! Plain tables: the first column to the left, numbers to the right.

/// Lines of cells, the first one being the head.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
            let gap = if column == 0 { "" } else { "   " };
            let aligned = if column == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") };
            line = line + gap + &aligned;
        }
        text = text + line.trim_end() + "\n";
    }
    text
}

/// Names and values below each other.
pub fn facts<'a>(facts: impl IntoIterator<Item = (&'a str, String)>) -> String {
    facts.into_iter().map(|(name, value)| format!("{name:<12} {value}\n")).collect()
}

/// A length in mm with one decimal.
pub fn millimetres(metres: f64) -> String {
    format!("{:.1}", metres * 1000.0)
}

/// A share as a percentage.
pub fn percent(share: f64) -> String {
    format!("{:.1}", share * 100.0)
}

#[cfg(test)]
mod tests {
    use super::table;

    #[test]
    fn columns_are_aligned_by_characters_and_lines_do_not_trail() {
        let row = |cells: [&str; 3]| cells.map(String::from).to_vec();
        let text = table(&[row(["name", "t s", "d"]), row(["réf", "1.5", "10"]), row(["b", "20.25", ""])]);
        assert_eq!(text, "name     t s    d\nréf      1.5   10\nb      20.25\n");
    }
}
