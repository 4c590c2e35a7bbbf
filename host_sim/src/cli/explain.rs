//! `explain`: why the robot did what it did at a moment of a run.

use std::path::PathBuf;

use clap::Args;
use controller_core::scalar::Fixed;
use controller_core::units::Point;
use host_sim::contender::Contender;
use host_sim::explanation::{self, Explanation, NeuronActivity, Place};
use host_sim::figure::draw_decision;
use host_sim::map_store::StoredScalar;
use host_sim::mission::{MissionOptions, MissionResult};
use host_sim::scenario::Scenario;
use host_sim::sil::Indirect;
use serde_json::json;

use super::args::{LearningArgs, SavedMapArgs, ScalarArg};
use super::error::{CliError, Outcome};
use super::learning::{configuration, learn, load_any_scenario, load_map, training_plan};
use super::output::{OutputFolder, print, print_json};
use super::single_run::{result_json, stop_text};
use super::table::{facts, table};

/// Neurons in the table unless all are asked for.
const SHOWN: usize = 8;

#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  host_sim explain p2_fig6 --at 12.5            the decision that stood 12.5 s after the start
  host_sim explain p2_fig6 --tick 12500 --out why.svg
  host_sim explain p1_fig8 --controller fusion --at 6 --json
  host_sim explain robots_crossing --robot 2 --at 6

The run is that of `run` with the same options, and all numbers are those of the controller that drove.")]
pub struct ExplainArgs {
    /// A built-in scenario (see `scenarios`) or a TOML file
    pub scenario: String,
    /// The moment, in seconds of the run
    #[arg(long, value_name = "SECONDS", value_parser = tick_of, required_unless_present = "tick")]
    pub at: Option<u64>,
    /// The moment, in ticks of a millisecond
    #[arg(long, value_name = "N", conflicts_with = "at")]
    pub tick: Option<u64>,
    /// Which of several robots, counted from 1
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub robot: usize,
    /// How target reaching and obstacle avoidance are integrated; default: as the scenario says
    #[arg(long, value_enum)]
    pub controller: Option<Contender>,
    #[command(flatten)]
    pub learning: LearningArgs,
    #[command(flatten)]
    pub saved: SavedMapArgs,
    /// List every neuron instead of the best
    #[arg(long, conflicts_with = "json")]
    pub all: bool,
    /// Draw the decision in the robot's frame to this file
    #[arg(long, value_name = "FILE.svg")]
    pub out: Option<PathBuf>,
    /// Print one JSON document instead of text, with every neuron
    #[arg(long)]
    pub json: bool,
}

/// Seconds of a run as ticks.
fn tick_of(text: &str) -> Result<u64, String> {
    let wrong = || String::from("must be a time in seconds from 0 to 1,000,000, such as 12.5");
    let seconds: f64 = text.parse().map_err(|_| wrong())?;
    if !(0.0..=1e6).contains(&seconds) {
        return Err(wrong());
    }
    format!("{:.0}", seconds * 1000.0).parse().map_err(|_| wrong())
}

pub fn explain(args: &ExplainArgs) -> Result<Outcome, CliError> {
    match args.learning.scalar() {
        ScalarArg::F32 => explain_in::<f32>(args),
        ScalarArg::Fixed => explain_in::<Fixed>(args),
    }
}

fn explain_in<S: StoredScalar>(args: &ExplainArgs) -> Result<Outcome, CliError> {
    let config = configuration(&args.learning)?;
    let scenario = load_any_scenario(&args.scenario)?;
    let robot = robot_of(args, &scenario)?;
    let loaded = load_map::<S>(&args.saved, &config)?;
    let file = args.out.as_deref().map(OutputFolder::for_file).transpose()?;
    let controller = args.controller.unwrap_or_else(|| Contender::of(&scenario));
    let plan = training_plan(&args.learning);
    let map = match loaded {
        Some(stored) => stored.map,
        None => learn::<S, Indirect<S>>(&config, &plan)?.map,
    };
    let options = MissionOptions { seed: plan.seed, sample_ms: 0 };
    // One of the two is there, or the arguments would have been refused.
    let tick = args.at.or(args.tick).unwrap_or_default();
    let architecture = controller.architecture();
    if architecture.is_none() {
        let name = controller.name();
        let message = format!("{name} has no fields to explain; choose --controller cooperative or fusion");
        return Err(CliError::Request(message));
    }
    let (explanation, result) = if scenario.robot_count() > 1 {
        let moment = (robot, tick);
        explanation::explain_in_fleet(&scenario, &config, architecture, &map, options, moment)?
    } else {
        explanation::explain(&scenario, &config, architecture, &map, options, tick)?
    };
    let figure = || draw_decision(&explanation, &config);
    let file = file.map(|(folder, name)| folder.write(&name, figure().as_bytes())).transpose()?;
    if args.json {
        print_json(&json!({
            "scenario": scenario.name,
            "robot": args.robot,
            "seed": plan.seed,
            "scalar": S::NAME,
            "controller": controller.name(),
            "explanation": explanation,
            "run": result_json(&result),
            "files": file.into_iter().collect::<Vec<_>>(),
        }))?;
        return Ok(Outcome::Ok);
    }
    let who = if scenario.robot_count() > 1 { format!(", robot {}", args.robot) } else { String::new() };
    let run = format!(
        "{}{who}, seed {}, scalar {}, controller {}: {}",
        scenario.name,
        plan.seed,
        S::NAME,
        controller.name(),
        outcome(&result)
    );
    print(&format!("{}{}", facts([("run", run)]), text(&explanation, args.all)))?;
    file.map_or(Ok(()), |file| print(&format!("wrote {file}\n")))?;
    Ok(Outcome::Ok)
}

/// The robot that was asked for, counted from 0.
fn robot_of(args: &ExplainArgs, scenario: &Scenario) -> Result<usize, CliError> {
    let count = scenario.robot_count();
    args.robot.checked_sub(1).filter(|&robot| robot < count).ok_or_else(|| {
        let message =
            format!("--robot {}: {} has robots 1 to {count}; name one of them", args.robot, scenario.name);
        CliError::Request(message)
    })
}

fn outcome(result: &MissionResult) -> String {
    let end = if result.reached { "reaches the goal after" } else { "is given up after" };
    let contacts = match result.contacts {
        0 => String::from("no contact"),
        1 => String::from("1 contact"),
        more => format!("{more} contacts"),
    };
    format!("{end} {:.1} s, {contacts}", result.duration_s)
}

fn text(explanation: &Explanation, all: bool) -> String {
    let (standing, decision) = (&explanation.standing, &explanation.decision);
    let mut lines = vec![("moment", moment(explanation))];
    let pose = decision.pose;
    lines.push((
        "pose",
        format!("{:.3} m, {:.3} m, heading {:.0}°", pose.x_m, pose.y_m, pose.heading_rad.to_degrees()),
    ));
    if let Some((checkpoint, target)) = decision.checkpoint.zip(decision.target) {
        let seen = format!("({:.3}, {:.3}) m, seen {}", checkpoint.x_m, checkpoint.y_m, at(target));
        lines.push(("target", seen));
    }
    if let Some(wall) = decision.detour {
        lines.push(("detour", format!("follows the wall {}, on its {}", at(wall.place), wall.side)));
    }
    if let Some(field) = decision.field {
        let centre = format!(
            "winner {}, centre {}, aim {}, renewed {} ms before",
            neuron_name(field.winner),
            at(field.centre),
            at(field.aim),
            field.age_ms
        );
        lines.push(("target field", centre));
    }
    if let Some(fusion) = decision.fusion {
        lines.push(("for target", speeds(fusion.reaching)));
        lines.push(("avoidance", fusion.avoidance.map_or_else(|| String::from("none"), speeds)));
        lines.push(("sum", format!("{}, target's share {}", speeds(fusion.sum), fusion.target_share)));
    }
    let fine = if decision.is_target { ", fine control of the target" } else { "" };
    lines.push(("command", format!("{}{fine}", speeds(decision.command))));
    lines.push(("gate", gate(standing.armed, standing.stopped.map(stop_text))));
    lines.push(("drive", format!("left {:.3}, right {:.3}", standing.drive[0], standing.drive[1])));
    for sentence in &decision.verdict {
        lines.push(("why", sentence.clone()));
    }
    format!(
        "{}\n{}{}{}{}",
        facts(lines),
        detections(explanation),
        movers(explanation),
        others(explanation),
        neurons(explanation, all)
    )
}

fn moment(explanation: &Explanation) -> String {
    let (standing, decision) = (&explanation.standing, &explanation.decision);
    let seconds = |tick: u64| host_sim::simulation::seconds(tick);
    format!(
        "{:.3} s; the command was decided at {:.3} s, {} ms before",
        seconds(standing.tick),
        seconds(decision.tick),
        standing.tick - decision.tick
    )
}

fn gate(armed: bool, stopped: Option<&str>) -> String {
    match (armed, stopped) {
        (_, Some(cause)) => format!("stops the wheels: {cause}"),
        (true, None) => String::from("open, armed"),
        (false, None) => String::from("open, not armed"),
    }
}

fn neuron_name(index: controller_core::kohonen::lattice::NeuronIndex) -> String {
    format!("({}, {})", index.column, index.row)
}

fn at(place: Place) -> String {
    let place = place.unfolded();
    format!("{:.1} cm at {:.0}°", place.distance_m * 100.0, place.bearing_rad.to_degrees())
}

fn speeds([left, right]: [f32; 2]) -> String {
    format!("left {left:.4}, right {right:.4} m/s")
}

fn detections(explanation: &Explanation) -> String {
    let decision = &explanation.decision;
    if decision.detections.is_empty() {
        return String::from("no sensor detects anything\n\n");
    }
    let mut rows = vec![["sensor", "cm", "°", "takes of winner"].map(String::from).to_vec()];
    for detection in &decision.detections {
        rows.push(vec![
            detection.sensor.to_string(),
            format!("{:.1}", detection.place.distance_m * 100.0),
            format!("{:.0}", detection.place.bearing_rad.to_degrees()),
            detection.inhibits_winner.map_or_else(|| String::from("-"), |part| format!("{part:.4}")),
        ]);
    }
    format!("{}\n", table(&rows))
}

fn others(explanation: &Explanation) -> String {
    let others = explanation.decision.others.iter();
    moving("other robot at cm", others.map(|other| (other.place, other.velocity_mps, other.inhibits_winner)))
}

fn movers(explanation: &Explanation) -> String {
    let movers = explanation.decision.movers.iter();
    moving("moves at cm", movers.map(|mover| (mover.place, mover.velocity_mps, mover.inhibits_winner)))
}

/// A table of places that move; nothing where there are none.
fn moving(what: &str, each: impl Iterator<Item = (Place, Point<f32>, Option<f32>)>) -> String {
    let mut rows =
        vec![[what, "°", "cm/s ahead", "to the left", "takes of winner"].map(String::from).to_vec()];
    rows.extend(each.map(|(place, velocity_mps, inhibits_winner)| {
        vec![
            format!("{:.1}", place.distance_m * 100.0),
            format!("{:.0}", place.bearing_rad.to_degrees()),
            format!("{:.1}", velocity_mps.x_m * 100.0),
            format!("{:.1}", velocity_mps.y_m * 100.0),
            inhibits_winner.map_or_else(|| String::from("-"), |part| format!("{part:.4}")),
        ]
    }));
    if rows.len() > 1 { format!("{}\n", table(&rows)) } else { String::new() }
}

fn neurons(explanation: &Explanation, all: bool) -> String {
    let decision = &explanation.decision;
    if decision.neurons.is_empty() {
        return String::new();
    }
    let mut sorted: Vec<&NeuronActivity> = decision.neurons.iter().collect();
    sorted.sort_by(|a, b| b.total.total_cmp(&a.total).then(b.activity.total_cmp(&a.activity)));
    let mut rows = vec![["neuron", "cm", "°", "a", "Σb", "e", "way", "left"].map(String::from).to_vec()];
    let own = decision.field.map(|field| field.winner);
    let is_own = |neuron: &&NeuronActivity| Some(neuron.neuron) == own && !neuron.backwards;
    let shown = if all { sorted.len() } else { SHOWN };
    // The target's own neuron is always of interest.
    let own_below = sorted.iter().skip(shown).copied().filter(is_own);
    for neuron in sorted.iter().take(shown).copied().chain(own_below) {
        let mark = match neuron {
            neuron if decision.winner == Some(*neuron) => " winner",
            neuron if is_own(&neuron) => " target's",
            _ => "",
        };
        let place = neuron.place.unfolded();
        let way = if neuron.backwards { " back" } else { "" };
        rows.push(vec![
            format!("{}{way}{mark}", neuron_name(neuron.neuron)),
            format!("{:.1}", place.distance_m * 100.0),
            format!("{:.0}", place.bearing_rad.to_degrees()),
            format!("{:.4}", neuron.target),
            format!("{:.4}", neuron.obstacles),
            format!("{:.4}", neuron.activity),
            format!("{:.4}", neuron.way),
            format!("{:.4}", neuron.total),
        ]);
    }
    let more = sorted.len().saturating_sub(shown);
    let more =
        if more > 0 { format!("and {more} more; --all or --json lists them\n") } else { String::new() };
    format!("{}{more}", table(&rows))
}

#[cfg(test)]
mod tests {
    use super::tick_of;

    #[test]
    fn seconds_become_ticks() {
        assert_eq!((tick_of("12.5"), tick_of("0")), (Ok(12_500), Ok(0)));
        for wrong in ["-1", "NaN", "1e9", "soon"] {
            assert!(tick_of(wrong).is_err(), "{wrong}");
        }
    }
}
