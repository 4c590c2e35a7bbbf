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

use controller_core::units::{EncoderCounts, Pose};
use protocol::codec::Message;
use protocol::frame::{self, FRAME_BYTES_MAX};
use protocol::message::{FromBoard, FromHost, Outputs, Readings, SENSORS, Scan};
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

/// What frames may take of the line, in bytes, delimiter included.
#[derive(Debug, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Frames {
    /// The largest of either direction: what buffers hold.
    largest_bytes: u64,
    /// Readings of a tick without pose and scan, an hour after the start: most of what goes to the board.
    readings_bytes: u64,
    /// The same with pose and scan, each 128 ms.
    scan_bytes: u64,
    /// What a tick led to: most of what comes back.
    outputs_bytes: u64,
}

/// The whole file.
#[derive(Debug, Deserialize, PartialEq)]
struct Budgets {
    /// Functions of `core` that begin a panic and may be in an image.
    panics: Vec<String>,
    frames: Frames,
    #[serde(flatten)]
    boards: BTreeMap<String, Budget>,
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
    let budgets: Budgets = toml::from_str(&text).map_err(|error| format!("{FILE}: {error}"))?;
    if let Some(complaint) = doctor::missing_qemu() {
        return Err(complaint);
    }
    firmware::build(root, &BOARDS, &["firmware", "instructions"], None)?;
    let mut over = Vec::new();
    let lines = frames(&budgets.frames);
    print!("\nframes\n{}", table(&lines));
    over.extend(complaints("frames", &lines));
    for board in BOARDS {
        let budget = budgets.boards.get(board.name).ok_or_else(|| format!("{FILE}: no [{}]", board.name))?;
        let lines = measure(root, board, budget)?;
        print!("\n{}\n{}", board.name, table(&lines));
        over.extend(complaints(board.name, &lines));
        let panics = image::panics(&board.image(root, "firmware"), &budgets.panics)?;
        over.extend(panics.iter().map(|name| format!("{}: {name} begins a panic, see {FILE}", board.name)));
    }
    if over.is_empty() { Ok(()) } else { Err(over.join("\n")) }
}

fn complaints(of: &str, lines: &[Line]) -> Vec<String> {
    let over = lines.iter().filter(|line| !line.holds());
    over.map(|line| format!("{of}: {} is {}, at most {} in {FILE}", line.name, line.measured, line.limit))
        .collect()
}

fn frames(budget: &Frames) -> Vec<Line> {
    fn bytes<M: Message>(message: &M) -> u64 {
        let mut buffer = [0; FRAME_BYTES_MAX];
        // What cannot be sent takes more than any limit allows.
        frame::encode(1, message, &mut buffer).map_or(u64::MAX, |frame| as_u64(frame.len()))
    }
    let tick = 3_600_000;
    let readings = Readings {
        tick,
        encoders: EncoderCounts { left: 1_000_000, right: -1_000_000 },
        ..Readings::default()
    };
    let scan = Readings {
        pose_fix: Some(Pose { x_m: 1.0, y_m: 2.0, heading_rad: 3.0 }),
        scan: Some(Scan { ranges_m: [Some(0.1); SENSORS] }),
        ..readings
    };
    let outputs = Outputs {
        tick,
        commanded_at_tick: tick,
        state_digest: u64::MAX,
        stopped: None,
        ..Outputs::default()
    };
    vec![
        Line::new("largest, bytes", as_u64(FRAME_BYTES_MAX), budget.largest_bytes),
        Line::new("readings, bytes", bytes(&FromHost::Sense(readings)), budget.readings_bytes),
        Line::new("readings with pose and scan, bytes", bytes(&FromHost::Sense(scan)), budget.scan_bytes),
        Line::new("outputs, bytes", bytes(&FromBoard::Outputs(outputs)), budget.outputs_bytes),
    ]
}

fn as_u64(bytes: usize) -> u64 {
    u64::try_from(bytes).unwrap_or(u64::MAX)
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
    use super::{Budgets, FILE, Line, complaints, counts, frames, table};
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
        let budgets: Budgets = toml::from_str(&text).unwrap();
        assert!(BOARDS.iter().all(|board| budgets.boards.contains_key(board.name)));
        assert_eq!(complaints("frames", &frames(&budgets.frames)), [""; 0]);
        assert!(toml::from_str::<Budgets>(&text.replace("flash_bytes", "flesh_bytes")).is_err());
    }
}
