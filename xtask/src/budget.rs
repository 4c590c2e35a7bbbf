//! `cargo xtask budget`: what the firmware takes of its boards, against what it may take.
//!
//! | | measured by |
//! | --- | --- |
//! | flash, variables | the sections of the ELF file |
//! | stack | painted memory, over a whole mission in QEMU with parameters set, map sent and read back |
//! | instructions | the program `instructions` in QEMU, where a timer counts them exactly |
//! | panics | the names of functions in the ELF file |

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::Deserialize;

use crate::command;
use crate::doctor;
use crate::firmware::{self, BOARDS, Board};
use crate::image::{self, Image};

/// Where the budgets stand, from the root of the repository.
const FILE: &str = "firmware/budgets.toml";

/// What one board's firmware may take.
#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Budget {
    flash_bytes: u64,
    /// Variables and stack.
    ram_bytes: u64,
    /// By the name of what is counted.
    instructions: BTreeMap<String, u64>,
}

/// One figure beside its limit.
#[derive(Debug, PartialEq)]
struct Line {
    name: String,
    measured: u64,
    limit: u64,
}

impl Line {
    fn new(name: impl Into<String>, measured: u64, limit: u64) -> Self {
        Self { name: name.into(), measured, limit }
    }

    fn holds(&self) -> bool {
        self.measured <= self.limit
    }
}

/// Builds, measures, prints a table; an error names what is over its limit.
pub fn run(root: &Path) -> Result<(), String> {
    let path = root.join(FILE);
    let text = fs::read_to_string(&path).map_err(|error| format!("{FILE}: {error}"))?;
    let budgets: BTreeMap<String, Budget> =
        toml::from_str(&text).map_err(|error| format!("{FILE}: {error}"))?;
    if let Some(complaint) = doctor::missing_qemu() {
        return Err(complaint);
    }
    firmware::build(root, &BOARDS, &["firmware", "instructions"])?;
    let mut over = Vec::new();
    for board in BOARDS {
        let budget = budgets.get(board.name).ok_or_else(|| format!("{FILE}: no [{}]", board.name))?;
        let lines = measure(root, board, budget)?;
        print!("\n{}\n{}", board.name, table(&lines));
        over.extend(lines.iter().filter(|line| !line.holds()).map(|line| {
            format!("{}: {} is {}, at most {} in {FILE}", board.name, line.name, line.measured, line.limit)
        }));
        let panics = image::panics(&board.image(root, "firmware"))?;
        println!("functions that begin a panic: {}", if panics.is_empty() { "none" } else { "" });
        panics.iter().for_each(|name| println!("  {name}"));
    }
    if over.is_empty() { Ok(()) } else { Err(over.join("\n")) }
}

fn measure(root: &Path, board: Board, budget: &Budget) -> Result<Vec<Line>, String> {
    let image = Image::read(&board.image(root, "firmware"))?;
    let stack = stack(root, board)?;
    let mut lines = vec![
        Line::new("flash, bytes", image.flash_bytes, budget.flash_bytes),
        Line::new("variables and deepest stack, bytes", image.static_ram_bytes + stack, budget.ram_bytes),
        Line::new(
            "  of these the deepest stack",
            stack,
            budget.ram_bytes - image.static_ram_bytes.min(budget.ram_bytes),
        ),
    ];
    let counts = instructions(root, board)?;
    for (name, limit) in &budget.instructions {
        let measured = counts.get(name).ok_or_else(|| {
            format!("{FILE}: {}.instructions.{name} is not counted by the program", board.name)
        })?;
        lines.push(Line::new(name, *measured, *limit));
    }
    if let Some(name) = counts.keys().find(|name| !budget.instructions.contains_key(*name)) {
        return Err(format!("{FILE}: {}.instructions has no {name}", board.name));
    }
    Ok(lines)
}

/// Counts, by name.
fn instructions(root: &Path, board: Board) -> Result<BTreeMap<String, u64>, String> {
    let image = board.image(root, "instructions");
    let kernel = image.to_string_lossy();
    // The timer that counts is on this machine alone; it runs the code of both boards.
    let arguments = [
        "-M",
        "netduinoplus2",
        "-display",
        "none",
        "-monitor",
        "none",
        "-serial",
        "null",
        "-icount",
        "shift=0,sleep=off",
        "-semihosting-config",
        "enable=on,target=native",
        "-kernel",
        &kernel,
    ];
    let said = command::output(doctor::QEMU, &arguments)
        .ok_or_else(|| format!("{}: the counting program failed in {}", board.name, doctor::QEMU))?;
    Ok(counts(&said))
}

fn counts(said: &str) -> BTreeMap<String, u64> {
    let count = |line: &str| {
        let (name, number) = line.strip_prefix("count ")?.split_once(' ')?;
        Some((name.to_owned(), number.parse().ok()?))
    };
    said.lines().filter_map(count).collect()
}

/// The deepest stack, in bytes, of a mission on the emulated board.
fn stack(root: &Path, board: Board) -> Result<u64, String> {
    let link = format!("qemu:{}", board.name);
    let image = board.image(root, "firmware");
    let arguments = [
        "run",
        "--release",
        "--quiet",
        "-p",
        "host_sim",
        "--",
        "run",
        "p2_fig6",
        "--link",
        &link,
        "--image",
        &image.to_string_lossy(),
        "--json",
    ];
    let said = command::output_in(root, &command::cargo(), &arguments)?;
    let run: serde_json::Value = serde_json::from_str(&said).map_err(|error| format!("host_sim: {error}"))?;
    run.pointer("/board/health/stack_bytes_max")
        .and_then(serde_json::Value::as_u64)
        .ok_or_else(|| format!("{}: the run does not say how deep the stack was", board.name))
}

/// Name, measured, limit, share; what is over is marked.
fn table(lines: &[Line]) -> String {
    let mut text = format!("{:<36} {:>9} {:>9}\n", "", "measured", "limit");
    for line in lines {
        let mark = if line.holds() { "" } else { "  OVER" };
        text += &format!("{:<36} {:>9} {:>9}{mark}\n", line.name, line.measured, line.limit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Budget, FILE, Line, counts, table};
    use crate::firmware::BOARDS;
    use std::collections::BTreeMap;
    use std::path::Path;

    #[test]
    fn counts_are_read_from_what_the_program_says() {
        let said = "hello\ncount servo 590\ncount map_hash 7400\ncount broken x\n";
        assert_eq!(counts(said), BTreeMap::from([("servo".to_owned(), 590), ("map_hash".to_owned(), 7400)]));
    }

    #[test]
    fn what_is_over_is_marked() {
        let text = table(&[Line::new("servo", 10, 10), Line::new("flash", 11, 10)]);
        let marked: Vec<_> = text.lines().filter(|line| line.ends_with("OVER")).collect();
        assert_eq!(marked.len(), 1);
        assert!(marked[0].starts_with("flash"));
    }

    #[test]
    fn every_board_has_a_budget() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let text = std::fs::read_to_string(root.join(FILE)).unwrap();
        let budgets: BTreeMap<String, Budget> = toml::from_str(&text).unwrap();
        assert!(BOARDS.iter().all(|board| budgets.contains_key(board.name)));
        assert!(toml::from_str::<BTreeMap<String, Budget>>("[a]\nflash_byte = 1\n").is_err());
    }
}
