//! `plan`: the planner's checkpoints on what a scenario knows.

use host_sim::figure::draw_run;
use host_sim::route_planner::{self, Plan};
use host_sim::scenario::{Route, Scenario};
use serde_json::{Value, json};

use super::args::PlanArgs;
use super::error::{CliError, Outcome};
use super::output::{OutputFolder, print, print_json};
use super::table::{facts, table};

pub fn plan(args: &PlanArgs) -> Result<Outcome, CliError> {
    let scenario = Scenario::load(&args.scenario)?;
    let target = args.out.as_deref().map(OutputFolder::for_file).transpose()?;
    let plan = route_planner::plan(&scenario, scenario.start.position, 0.0)?;
    let mut file = None;
    if let Some((folder, name)) = target {
        let planned = scenario.clone().with_checkpoints(plan.checkpoints.clone());
        file = Some(folder.write(&name, draw_run(&planned, &[]).as_bytes())?);
    }
    if args.json {
        print_json(&document(&scenario, &plan, file.as_deref()))?;
    } else {
        let wrote = file.map_or_else(String::new, |file| format!("wrote {file}\n"));
        print(&format!("{}{wrote}", text(&scenario, &plan)))?;
    }
    Ok(Outcome::Ok)
}

fn text(scenario: &Scenario, plan: &Plan) -> String {
    let mut about = facts([
        ("scenario", format!("{}: {} ({})", scenario.name, scenario.title, scenario.source)),
        ("planned on", format!("{} cells, {} passages between them", plan.cells, plan.passages)),
    ]);
    if let Route::Checkpoints(given) = &scenario.route {
        // Said before anybody wonders why `run` goes elsewhere.
        about += &facts([(
            "note",
            format!("`run` uses the {} checkpoint(s) of the scenario instead", given.len()),
        )]);
    }
    let mut rows = vec![["checkpoint", "x m", "y m"].map(String::from).to_vec()];
    for (i, place) in plan.checkpoints.iter().enumerate() {
        let name = if i + 1 == plan.checkpoints.len() { String::from("goal") } else { (i + 1).to_string() };
        rows.push(vec![name, format!("{:.3}", place.x), format!("{:.3}", place.y)]);
    }
    format!("{about}\n{}", table(&rows))
}

fn document(scenario: &Scenario, plan: &Plan, file: Option<&str>) -> Value {
    let checkpoints: Vec<_> = plan.checkpoints.iter().map(|place| [place.x, place.y]).collect();
    json!({
        "scenario": scenario.name,
        "cells": plan.cells,
        "passages": plan.passages,
        "checkpoints": checkpoints,
        "file": file,
    })
}
