//! `scenarios`: what there is to run.

use host_sim::scenario::{Route, Scenario};
use serde_json::{Value, json};

use super::args::ScenariosArgs;
use super::error::{CliError, Outcome};
use super::output::{print, print_json};
use super::table::facts;
use host_sim::contender::Contender;

pub fn scenarios(args: &ScenariosArgs) -> Result<Outcome, CliError> {
    match &args.name {
        Some(name) if args.print => print(Scenario::builtin_text(name)?)?,
        Some(name) => {
            let scenario = Scenario::load(name)?;
            if args.json { print_json(&document(&scenario))? } else { print(&text(&scenario))? }
        }
        None => {
            let names = Scenario::builtin_names().chain(Scenario::fleet_names());
            let all: Vec<Scenario> = names.map(Scenario::builtin).collect::<Result<_, _>>()?;
            if args.json {
                print_json(&all.iter().map(document).collect())?;
            } else {
                let line = |scenario: &Scenario| {
                    format!("{:<15}   {:<14}   {}\n", scenario.name, scenario.source, scenario.title)
                };
                print(&all.iter().map(line).collect::<String>())?;
            }
        }
    }
    Ok(Outcome::Ok)
}

fn route(scenario: &Scenario) -> String {
    match &scenario.route {
        Route::Checkpoints(checkpoints) => format!("{} checkpoint(s), given", checkpoints.len()),
        Route::Planned { .. } => String::from("planned on the known map"),
    }
}

fn text(scenario: &Scenario) -> String {
    let known = scenario.solids.iter().filter(|solid| solid.known).count();
    let unforeseen = scenario.solids.len() - known;
    let movers = scenario.world.movers.len();
    facts([
        ("scenario", scenario.name.clone()),
        ("title", scenario.title.clone()),
        ("source", scenario.source.clone()),
        ("robots", scenario.robot_count().to_string()),
        ("route", route(scenario)),
        ("world", format!("{known} known and {unforeseen} unforeseen solids, {movers} moving")),
        ("controller", Contender::of(scenario).name().to_owned()),
        ("time limit", format!("{} s", scenario.time_limit_s)),
        ("noise", format!("{} of a range, {} of a command", scenario.noise.sensor, scenario.noise.actuator)),
    ])
}

fn document(scenario: &Scenario) -> Value {
    json!({
        "name": scenario.name,
        "title": scenario.title,
        "source": scenario.source,
        "robots": scenario.robot_count(),
        "planned": matches!(scenario.route, Route::Planned { .. }),
        "controller": Contender::of(scenario).name(),
        "time_limit_s": scenario.time_limit_s,
    })
}
