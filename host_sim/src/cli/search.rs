//! `search`: better numbers for a controller, by a seeded search over scenes.

use clap::Args;
use host_sim::contender::Contender;
use host_sim::questions;
use host_sim::search::{Candidate, SearchPlan};
use host_sim::sil::Indirect;
use host_sim::sweep::Maps;
use host_sim::training::TrainingPlan;
use host_sim::tuning::Tuning;
use serde_json::{Map, json};
use std::path::PathBuf;

use super::error::{CliError, Outcome};
use super::learning::{learn_each, seeds, settings_of, threads};
use super::output::{complain, print, print_json};
use super::progress::Progress;
use super::table::{facts, table};

/// Maps that our controllers drive with in turn, and the training steps of each.
const MAPS: u32 = 8;
const STEPS: u32 = 2000;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim search vfh                           as the defaults were found
  host_sim search bug2 --generations 4          a quick look
  host_sim search dwa --config my.toml          from other numbers on

Scenes: traps from inside and outside, doors, walls' ends, corridors, posts, moving discs, the figures of the papers.
The numbers found are printed as lines for a file of --config. Ours are tuned with eight maps in turn.")]
pub struct SearchArgs {
    /// Whose numbers
    #[arg(value_enum)]
    pub controller: Contender,
    /// Seed of what is drawn, and of the first run
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Generations
    #[arg(long, value_name = "N", default_value_t = 12)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub generations: u32,
    /// Candidates of each generation; a quarter of them survives
    #[arg(long, value_name = "N", default_value_t = 16)]
    #[arg(value_parser = clap::value_parser!(u32).range(4..=10_000))]
    pub candidates: u32,
    /// Runs of each scene for each candidate in a generation
    #[arg(long, value_name = "N", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub runs: u32,
    /// Threads; default: one per core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Where to begin, see the command `config`
    #[arg(long, value_name = "NAME|FILE.toml")]
    pub config: Option<PathBuf>,
    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

pub fn search(args: &SearchArgs) -> Result<Outcome, CliError> {
    let settings = settings_of(args.config.as_deref())?;
    let name = args.controller.name();
    let pool = threads(args.threads)?;
    let mut maps = Vec::new();
    if !args.controller.is_peer() {
        let (training, seeds) =
            (TrainingPlan { steps: STEPS, ..TrainingPlan::default() }, seeds(args.seed, MAPS)?);
        let learned = pool.install(|| learn_each::<f32, Indirect<f32>>(&settings.core, &training, seeds))?;
        maps.extend(learned.into_iter().map(|learned| learned.map));
    }
    let tuning = Tuning::new(args.controller, settings, questions::search_scenes()?, Maps::PerRun(maps));
    let plan = SearchPlan {
        seed: args.seed,
        generations: args.generations,
        candidates: args.candidates,
        survivors: args.candidates / 4,
        runs: args.runs,
    };
    let total = tuning.total_runs(&plan);
    let bar = Progress::new(name, total);
    let report = |generation: u32, best: &Candidate| {
        complain(&format!("generation {}: best score {:.3}", generation + 1, best.score));
    };
    let found = pool.install(|| tuning.run(&plan, &|| bar.advance(), report));
    drop(bar);
    let Some(best) = found.first() else { return Ok(Outcome::RobotFailed) };
    if args.json {
        let numbers: Map<_, _> =
            tuning.named(best).map(|(name, value)| (name.to_owned(), json!(value))).collect();
        let scenes: Map<_, _> = tuning
            .scene_names()
            .zip(best.means())
            .map(|(name, mean)| (name.to_owned(), json!(mean)))
            .collect();
        let document = json!({
            "controller": name, "runs": total, "score": best.score, "numbers": numbers, "scenes": scenes,
        });
        print_json(&document)?;
    } else {
        print(&text(&tuning, best, args.controller, total))?;
    }
    Ok(Outcome::Ok)
}

fn text(tuning: &Tuning, best: &Candidate, contender: Contender, total: u64) -> String {
    let (name, is_peer) = (contender.name(), contender.is_peer());
    let head = facts([
        ("# search", format!("{name}, {total} runs")),
        ("# score", format!("{:.3} (0.9 is success everywhere, the rest haste)", best.score)),
    ]);
    let rows: Vec<Vec<String>> = tuning
        .scene_names()
        .zip(best.means())
        .map(|(scene, mean)| vec![format!("# {scene}"), format!("{mean:.2}")])
        .collect();
    let numbers = tuning.named(best).map(|(number, value)| {
        let number = if is_peer { format!("peers.{number}") } else { number.to_owned() };
        format!("{number} = {}\n", four_digits(value))
    });
    format!("{head}{}\n{}", table(&rows), numbers.collect::<String>())
}

/// A number with four significant digits: gains of a millionth are numbers as well.
fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
