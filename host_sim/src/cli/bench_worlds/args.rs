//! The arguments of `bench` on worlds.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use host_sim::benchmark::Following;
use host_sim::import::gazebo;

use crate::cli::args::LearningArgs;
use host_sim::contender::Contender;

#[derive(Debug, Subcommand)]
pub enum BenchWorlds {
    /// Cross worlds of discs and walls: BARN and the like
    Barn(BarnArgs),
    /// Plan the problems of a Moving AI map, and drive some of them
    #[command(name = "movingai")]
    MovingAi(MovingAiArgs),
    /// Plan and drive on a ROS `map_server` map
    Map(RosMapArgs),
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim bench movingai room.map room.map.scen
  host_sim bench movingai room.map room.map.scen --problems 0 --json     only plan
  host_sim bench movingai room.map room.map.scen --cell 0.2 --runs 3 --out out/room

Lengths are compared with the file's `optimal_length` in cells: that of a point which moves from middle to middle of the
eight neighbours. Ours is a disc's, and goes in any direction.")]
pub struct MovingAiArgs {
    /// The map
    #[arg(value_name = "FILE.map")]
    pub grid: PathBuf,
    /// Its problems
    #[arg(value_name = "FILE.scen")]
    pub problems_file: PathBuf,
    /// Side of a cell in m; the body's diameter is 0.05
    #[arg(long, value_name = "M", default_value_t = 0.1)]
    pub cell: f64,
    /// How many of the problems are driven, evenly taken from the file; all are planned
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub problems: u32,
    #[command(flatten)]
    pub goal: GoalArgs,
    #[command(flatten)]
    pub runs: WorldRunsArgs,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim bench map house.yaml --scale 0.2381                    ten random pairs of places
  host_sim bench map house.yaml --from=-1.2,0.3 --to=2,1.5        one of your own, in the scaled map's frame
  host_sim bench map house.yaml --pairs 50 --runs 3 --out out/house

Only what the map calls free is passable. Random places leave a centimetre beside the body and are joined.")]
pub struct RosMapArgs {
    /// The map's YAML file; the image is found from there
    #[arg(value_name = "FILE.yaml")]
    pub grid: PathBuf,
    /// Metres here for a metre of the map: radius of our robot (0.025) over that of the map's
    #[arg(long, value_name = "F", default_value_t = 1.0)]
    pub scale: f64,
    /// Where to start, in m in the scaled map's frame
    #[arg(long, value_name = "X,Y", value_parser = place, requires = "to", allow_hyphen_values = true)]
    pub from: Option<(f64, f64)>,
    /// Where to go
    #[arg(long, value_name = "X,Y", value_parser = place, requires = "from", allow_hyphen_values = true)]
    pub to: Option<(f64, f64)>,
    /// How many random pairs of places, by the seeds from --seed on
    #[arg(long, value_name = "N", default_value_t = 10, conflicts_with_all = ["from", "to"])]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub pairs: u32,
    #[command(flatten)]
    pub goal: GoalArgs,
    #[command(flatten)]
    pub runs: WorldRunsArgs,
}

#[derive(Debug, Args)]
pub struct GoalArgs {
    /// How near the centre must come to the goal, in m
    #[arg(long, value_name = "M", default_value_t = 0.05)]
    pub goal_tolerance: f64,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim bench barn worlds/                     every .json and .world of a folder, ten seeds each
  host_sim bench barn a.json b.json --runs 3      some of them
  host_sim bench barn world_0.world --scale c     a Gazebo world at the strict scale
  host_sim bench barn worlds/ --planned --out out/barn")]
pub struct BarnArgs {
    /// JSON worlds, Gazebo worlds (.world), or folders of them
    #[arg(required = true, value_name = "DIR|FILE")]
    pub paths: Vec<PathBuf>,
    /// Scale of .world files: `w` makes the width of BARN's robot our diameter, `c` the circle around it; or a factor
    #[arg(long, value_name = "w|c|FACTOR", default_value = "w", value_parser = scale)]
    pub scale: f64,
    #[command(flatten)]
    pub runs: WorldRunsArgs,
}

/// How worlds are driven.
#[derive(Debug, Args)]
pub struct WorldRunsArgs {
    #[command(flatten)]
    pub learning: LearningArgs,
    /// Runs on each world, with consecutive seeds
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub runs: u32,
    /// How target reaching and obstacle avoidance are integrated
    #[arg(long, value_enum, default_value = "cooperative")]
    pub controller: Contender,
    /// Only with the planner, which knows the world
    #[arg(long, conflicts_with = "decapitated")]
    pub planned: bool,
    /// Only without the planner: the goal is all that the controller knows
    #[arg(long)]
    pub decapitated: bool,
    /// How the planner's route is followed
    #[arg(long, value_enum, default_value_t = FollowingArg::Sight)]
    pub following: FollowingArg,
    /// Use a saved map instead of learning one
    #[arg(long, value_name = "FILE.ekm", conflicts_with_all = ["steps", "fresh_maps"])]
    pub map: Option<PathBuf>,
    /// With --map: take a map that was learned on a robot of another wheel base, top speed or reach
    #[arg(long, requires = "map")]
    pub map_of_another_robot: bool,
    /// Learn a map for each seed, instead of one for all with the first
    #[arg(long)]
    pub fresh_maps: bool,
    /// Threads; default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Write a line for each run (CSV) and a picture of each world with the first paths (SVG) to this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FollowingArg {
    /// Checkpoint by checkpoint, as in the papers
    Checkpoints,
    /// The planner moves the checkpoint ahead along the route, as far as the robot can go straight
    Sight,
}

impl FollowingArg {
    pub fn following(self) -> Following {
        match self {
            Self::Checkpoints => Following::Checkpoints,
            Self::Sight => Following::Sight,
        }
    }
}

/// A scale by its letter or as a number.
fn scale(text: &str) -> Result<f64, String> {
    match text {
        "w" | "W" => return Ok(gazebo::SCALE_WIDTH),
        "c" | "C" => return Ok(gazebo::SCALE_CIRCUMSCRIBED),
        _ => {}
    }
    let factor = text.parse().ok().filter(|factor: &f64| (1e-6..=1e6).contains(factor));
    factor.ok_or_else(|| String::from("give w, c, or a factor between 1e-6 and 1e6"))
}

/// A place as two numbers.
fn place(text: &str) -> Result<(f64, f64), String> {
    let number = |text: &str| text.trim().parse().ok().filter(|value: &f64| value.is_finite());
    let both = text.split_once(',').and_then(|(x, y)| Some((number(x)?, number(y)?)));
    both.ok_or_else(|| String::from("give x and y in m, such as 0.5,-1.2"))
}
