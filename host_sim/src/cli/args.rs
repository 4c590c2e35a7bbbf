//! The command line as the user types it.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use host_sim::contender::Contender;
use host_sim::link::address::{Address, FORMS};
use protocol::message::ScalarKind;

use super::bench_worlds::BenchWorlds;
use super::evaluate::all::EvaluateAllArgs;
use super::evaluate::robots::EvaluateRobotsArgs;
use super::evaluate::scenes::SceneArgs;
use super::explain::ExplainArgs;
use super::search::SearchArgs;

/// Training steps after which the map is as good as it gets; P1 trains longer by chance encounters.
const STEPS: u32 = 2000;

const EXAMPLES: &str = "\
Examples (with cargo: `cargo run --release -- run p2_fig6`):
  host_sim                                      learn a map, cross three rooms, draw the way
  host_sim --seed 7                             the same with other noise and another start
  host_sim run p1_fig8 --runs 100               both controllers, 100 seeds, success rates
  host_sim run p2_fig6 --scalar fixed --json    fixed point instead of f32, result as JSON
  host_sim train --trials 5                     how precise is what was learned?
  host_sim explain p2_fig6 --at 12.5            why this command, then? In numbers, or as a picture
  host_sim map show out/map.ekm --out map.svg   what was learned, as numbers and as a picture
  host_sim evaluate positioning --out fig       and how does it become so? P1's figures
  host_sim scenarios p2_fig6 --print > my.toml  copy a scenario, edit it, then: run my.toml
  host_sim config --print > config.toml         every number of the controller, for --config

Exit codes: 0 ok; 1 the robot or a check failed; 2 the request cannot be carried out, and nothing was written; 3 the
board or the way to it failed.";

/// Simulates a Khepera that learns to move, then finds its way with cooperative Extended Kohonen Maps.
///
/// Without a command it does the main job: learn a map from scratch by motor babbling and online training, save it,
/// then cross the three rooms of P2 Fig. 6 among unforeseen obstacles, under the papers' 10 % noise. P1 is Low, Leow &
/// Ang, AAMAS 2002; P2 the same authors, ICRA 2003. A figure's scenario is called `p1_fig7`, `p2_fig6` and so on.
#[derive(Debug, Parser)]
#[command(name = "host_sim", version, after_help = EXAMPLES, args_conflicts_with_subcommands = true)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub main_job: MainJobArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scenario, once or with many seeds
    Run(RunArgs),
    /// Learn a map and measure how precisely it positions the robot
    Train(TrainArgs),
    /// Show a learned map, compare two, or make source text of one for flash
    Map(MapArgs),
    /// Repeat an experiment of the papers with its figures
    Evaluate(EvaluateArgs),
    /// Say why a robot did what it did at a moment of a run
    Explain(ExplainArgs),
    /// List the built-in scenarios, or show one
    Scenarios(ScenariosArgs),
    /// Show the planner's checkpoints for a scenario
    Plan(PlanArgs),
    /// Ask a board what it is and how it is doing, and set its parameters
    Link(InspectArgs),
    /// Measure the speed of the simulator on one core, or the robot on worlds that others drew
    Bench(BenchArgs),
    /// Show the configuration of the controller
    Config(ConfigArgs),
    /// Search for better numbers of a controller
    Search(SearchArgs),
}

/// What every command that learns needs to know.
#[derive(Debug, Args)]
pub struct LearningArgs {
    /// Training steps, each of 1.024 s unless the configuration says otherwise
    #[arg(long, value_name = "N", default_value_t = STEPS)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub steps: u32,
    /// Arithmetic of the controller; default: f32, or with --link the board's
    #[arg(long, value_enum)]
    pub scalar: Option<ScalarArg>,
    /// Seed of everything that is drawn: exploration, targets, start, noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Configuration of the controller, see the command `config`; `precise`, `p1`, `literal`, `large` and `boards` are
    /// built in
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub config: Option<PathBuf>,
}

impl LearningArgs {
    /// The arithmetic of a controller in this process.
    pub fn scalar(&self) -> ScalarArg {
        self.scalar.unwrap_or(ScalarArg::F32)
    }
}

/// A map that is there already.
#[derive(Debug, Args)]
pub struct SavedMapArgs {
    /// Use a saved map instead of learning one
    #[arg(long, value_name = "FILE.ekm", conflicts_with = "steps")]
    pub map: Option<PathBuf>,
    /// With --map: take a map that was learned on a robot of another wheel base, top speed or reach
    #[arg(long, requires = "map")]
    pub map_of_another_robot: bool,
}

/// How a board is reached.
#[derive(Debug, Args)]
pub struct WayArgs {
    /// Firmware image for `qemu:…`; default: where `cargo xtask firmware` puts it
    #[arg(long, value_name = "FILE")]
    pub image: Option<PathBuf>,
    /// Where the log of `qemu:…` goes, for `defmt-print -e IMAGE < FILE`; default: nowhere
    #[arg(long, value_name = "FILE")]
    pub log: Option<PathBuf>,
    /// Bits per second of `serial:…`
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    #[arg(value_parser = clap::value_parser!(u32).range(300..=12_000_000))]
    pub baud: u32,
}

/// Whether the controller runs in this process or on a board.
#[derive(Debug, Args)]
pub struct LinkArgs {
    // As text, since the forms of an address would pass for links in a doc comment.
    #[arg(long, value_name = "ADDRESS", help = format!("Drive a board instead of the core in this process: {FORMS}"))]
    pub link: Option<Address>,
    #[command(flatten)]
    pub way: WayArgs,
    /// With --link: run the core in this process as well, and fail at the first tick after which the two differ
    #[arg(long, requires = "link")]
    pub verify: bool,
}

#[derive(Debug, Args)]
pub struct MainJobArgs {
    #[command(flatten)]
    pub learning: LearningArgs,
    /// Folder for the map, the figure and the log
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim run p2_fig6 --out out                once, with figure (SVG) and log (CSV)
  host_sim run p2_fig7 --runs 100               both controllers with seeds 1 to 100
  host_sim run my.toml --controller fusion      a scenario of your own
  host_sim run p2_fig7 --controller vfh         a controller that people use instead; it needs no map
  host_sim run p2_fig6 --map out/map.ekm        with a map that was saved
  host_sim run p2_fig6 --runs 100 --fresh-maps --controller cooperative --require 95
  host_sim run p2_fig6 --link stub --verify     a board played by this process, behind real frames
  host_sim run p2_fig6 --link qemu:stm32f405 --verify
  host_sim run p2_fig6 --link serial:/dev/ttyACM0 --real-time

With --runs, run i has seed N + i; the hash over all runs does not depend on --threads.")]
pub struct RunArgs {
    /// A built-in scenario (see `scenarios`) or a TOML file
    pub scenario: String,
    /// Who drives; default: as the scenario says, or cooperative and fusion with --runs
    #[arg(long, value_enum)]
    pub controller: Option<Contender>,
    #[command(flatten)]
    pub learning: LearningArgs,
    /// How many runs, with consecutive seeds
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub runs: u32,
    #[command(flatten)]
    pub saved: SavedMapArgs,
    /// Learn a map for each run with the run's seed, instead of one for all with the first
    #[arg(long, conflicts_with = "map")]
    pub fresh_maps: bool,
    /// Exit with 1 unless at least so many percent of the runs of each controller succeed
    #[arg(long, value_name = "PERCENT", value_parser = clap::value_parser!(u8).range(0..=100))]
    pub require: Option<u8>,
    /// Threads for the runs; default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub link: LinkArgs,
    /// With --link: the board runs on its own clock and the simulator keeps up; such a run does not repeat exactly
    #[arg(long, requires = "link", conflicts_with = "verify")]
    pub real_time: bool,
    /// Write the figure (SVG) and the log (CSV) to this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim train --out map.ekm                  learn, save, measure
  host_sim train --trials 5                     indirect and direct mapping, five maps each
  host_sim train --mapping direct --steps 10000
  host_sim train --link qemu:stm32f405 --out map.ekm    the emulated board learns, and its map is read out

The test is P1's: 50 random targets in sequence, without further training, under 10 % noise.")]
pub struct TrainArgs {
    #[command(flatten)]
    pub learning: LearningArgs,
    /// Output layer of the map; default: indirect, or both with --trials
    #[arg(long, value_enum)]
    pub mapping: Option<MappingArg>,
    /// Train and test so many maps, with consecutive seeds
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub trials: Option<u32>,
    /// Threads for the trials; default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    #[command(flatten)]
    pub link: LinkArgs,
    /// Save the map to this file
    #[arg(long, value_name = "FILE.ekm", conflicts_with = "trials")]
    pub out: Option<PathBuf>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim map show out/map.ekm                 provenance, hash, what it spans
  host_sim map show out/map.ekm --out map.svg   and a picture of its neurons
  host_sim map diff a.ekm b.ekm --require-same  for scripts: 1 unless both drive alike, bit for bit
  host_sim map export out/map.ekm --to rust --out src/map.rs
  host_sim map export out/map.ekm --to c --out ekm_map.h

Maps of any robot, scalar and lattice can be shown and exported; no configuration is needed.")]
pub struct MapArgs {
    #[command(subcommand)]
    pub action: MapAction,
}

#[derive(Debug, Subcommand)]
pub enum MapAction {
    /// Print what a map file says of itself, its hash and its statistics, and draw its neurons
    Show(MapShowArgs),
    /// Print what differs between two maps of the same lattice
    Diff(MapDiffArgs),
    /// Write a map as a constant for flash, with every number as it is, bit for bit
    Export(MapExportArgs),
}

#[derive(Debug, Args)]
pub struct MapShowArgs {
    /// A map, as `train --out` and the main job save it
    #[arg(value_name = "FILE.ekm")]
    pub file: PathBuf,
    /// Draw the neurons in the robot's frame to this file
    #[arg(long, value_name = "FILE.svg")]
    pub out: Option<PathBuf>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct MapDiffArgs {
    /// The first map
    #[arg(value_name = "A.ekm")]
    pub a: PathBuf,
    /// The second map
    #[arg(value_name = "B.ekm")]
    pub b: PathBuf,
    /// Exit with 1 unless neurons, units and scalar are the same, bit for bit; how they were made does not count
    #[arg(long)]
    pub require_same: bool,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct MapExportArgs {
    /// A map, as `train --out` and the main job save it
    #[arg(value_name = "FILE.ekm")]
    pub file: PathBuf,
    /// Language of the text
    #[arg(long, value_enum)]
    pub to: LanguageArg,
    /// Write to this file instead of the standard output
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct EvaluateArgs {
    #[command(subcommand)]
    pub what: Evaluation,
}

#[derive(Debug, Subcommand)]
pub enum Evaluation {
    /// P1 Figs. 4 and 5: how precisely do maps position the robot while they learn?
    Positioning(EvaluatePositioningArgs),
    /// The robot changes under way: how well does its map follow, and how bad is one that does not learn?
    Calibration(EvaluateCalibrationArgs),
    /// The papers' seven figures: how often does who reach the goal without contact?
    Scenarios(SceneArgs),
    /// U-shaped traps and walls' ends, without a planner: how deep a trap does who leave?
    Traps(SceneArgs),
    /// Doors, corridors and rows of posts, without a planner: how narrow a door does who pass?
    Doors(SceneArgs),
    /// Discs that circle across the way, without a planner: how often is who touched?
    Traffic(SceneArgs),
    /// Success over two measures at once: traps by width and depth, doors by width, angle and what disturbs, discs by
    /// number and speed
    Surfaces(SceneArgs),
    /// Several robots in one world: do they get to their goals without touching each other?
    Robots(EvaluateRobotsArgs),
    /// Scenarios, traps, doors, traffic, surfaces and robots, one after the other
    All(EvaluateAllArgs),
}

/// What every experiment of `evaluate` needs to know.
#[derive(Debug, Args)]
pub struct TrialsArgs {
    /// Trials, with consecutive seeds; P1 has 5
    #[arg(long = "trials", value_name = "N", default_value_t = 5)]
    #[arg(value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub count: u32,
    /// First seed
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Targets of a test
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub targets: u32,
    /// Threads; default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

impl TrialsArgs {
    /// The seed of the last trial; the first one leaves room for all, once they have been counted.
    pub fn last_seed(&self) -> u64 {
        self.seed + u64::from(self.count) - 1
    }
}

#[derive(Debug, Args)]
pub struct EvaluateCalibrationArgs {
    #[command(flatten)]
    pub trials: TrialsArgs,
    /// Training steps before the change
    #[arg(long, value_name = "N", default_value_t = 3000)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub steps: u32,
    /// Training steps after it
    #[arg(long, value_name = "N", default_value_t = 500)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub further: u32,
    /// Training steps between two tests after it
    #[arg(long, value_name = "N", default_value_t = 100)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub every: u32,
    /// Arithmetic
    #[arg(long, value_enum, default_value_t = ScalarArg::F32)]
    pub scalar: ScalarArg,
    /// Configuration of the controller, by file or by name: `precise`, `p1`, `literal`, `large`, `boards`
    #[arg(long, value_name = "NAME|FILE.toml", default_value = "precise")]
    pub config: PathBuf,
    /// Write the figure (SVG) into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct EvaluatePositioningArgs {
    #[command(flatten)]
    pub trials: TrialsArgs,
    /// Training steps of each trial; P1 has 100,000
    #[arg(long, value_name = "N", default_value_t = 3000)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub steps: u32,
    /// Training steps between two tests; P1 has 10,000
    #[arg(long, value_name = "N", default_value_t = 250)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub every: u32,
    /// Only this arithmetic
    #[arg(long, value_enum)]
    pub scalar: Option<ScalarArg>,
    /// Only this output layer
    #[arg(long, value_enum)]
    pub mapping: Option<MappingArg>,
    /// Configuration of the controller, by file or by name: `precise`, `p1`, `literal`, `large`, `boards`; may be given
    /// several times
    #[arg(long, value_name = "NAME|FILE.toml", default_values = ["precise", "p1"])]
    pub config: Vec<PathBuf>,
    /// Instead: with the first configuration, undo each of what we changed in the papers' learning, one by one
    #[arg(long, conflicts_with_all = ["json", "out"])]
    pub ablate: bool,
    /// Write the figures (SVG) and the curves (CSV) into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct ScenariosArgs {
    /// Show this scenario only
    pub name: Option<String>,
    /// Print its file, to be copied and edited
    #[arg(long, requires = "name", conflicts_with = "json")]
    pub print: bool,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct PlanArgs {
    /// A built-in scenario (see `scenarios`) or a TOML file
    pub scenario: String,
    /// Draw world and checkpoints to this file
    #[arg(long, value_name = "FILE.svg")]
    pub out: Option<PathBuf>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim link stub                            a board played by this process
  host_sim link serial:/dev/ttyACM0 --parameters
  host_sim link pty:/dev/pts/3 --set servo.stall_share=0.3

Parameters have the names of the configuration file (`config --print`); they are set as a group or not at all.")]
pub struct InspectArgs {
    #[arg(help = format!("Where the board is: {FORMS}"))]
    pub address: Address,
    #[command(flatten)]
    pub way: WayArgs,
    /// List the parameters with their values
    #[arg(long)]
    pub parameters: bool,
    /// Set a parameter; may be given more than once
    #[arg(long, value_name = "NAME=VALUE", value_parser = assignment)]
    pub set: Vec<(String, f32)>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

/// `NAME=VALUE`, as `--set` takes it.
pub fn assignment(text: &str) -> Result<(String, f32), String> {
    let parts = text.split_once('=').map(|(name, value)| (name.trim(), value.trim().parse::<f32>()));
    match parts {
        Some((name, Ok(value))) => Ok((name.to_owned(), value)),
        _ => Err(String::from("must be a name, `=` and a number")),
    }
}

#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct BenchArgs {
    #[command(subcommand)]
    pub what: Option<BenchWorlds>,
    #[command(flatten)]
    pub learning: LearningArgs,
    /// Missions for each controller
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub runs: u32,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct ConfigArgs {
    /// Print every number as TOML (the default)
    #[arg(long)]
    pub print: bool,
    /// Check a file, or what is built in under a name, and print it with all that it leaves to the defaults
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub config: Option<PathBuf>,
    /// List every parameter with its number on the link, default, unit and range
    #[arg(long, conflicts_with_all = ["print", "config"])]
    pub list: bool,
    /// Print the list as one JSON document instead of text
    #[arg(long, requires = "list")]
    pub json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ScalarArg {
    /// 32-bit floating point, for processors that have it
    F32,
    /// 32-bit fixed point with 16-bit weights, for those that do not
    Fixed,
}

impl ScalarArg {
    pub fn kind(self) -> ScalarKind {
        match self {
            Self::F32 => ScalarKind::F32,
            Self::Fixed => ScalarKind::Fixed,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MappingArg {
    /// A 2×2 matrix per neuron: the command depends on the place (P1)
    Indirect,
    /// One command per neuron, P1's baseline
    Direct,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LanguageArg {
    /// A module that needs no crate but core
    Rust,
    /// A header in C99
    C,
}
