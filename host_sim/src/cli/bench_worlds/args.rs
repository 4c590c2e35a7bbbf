//! The arguments of `bench` on worlds.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use host_sim::benchmark::Following;
use host_sim::import::gazebo;

use crate::cli::args::{ControllerArg, LearningArgs};

#[derive(Debug, Subcommand)]
pub enum BenchWorlds {
    /// Cross worlds of discs and walls: BARN and the like
    Barn(BarnArgs),
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
    #[arg(long, value_enum, default_value_t = ControllerArg::Cooperative)]
    pub controller: ControllerArg,
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
