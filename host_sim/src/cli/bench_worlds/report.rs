//! What is printed and written of runs on worlds.

use controller_core::planning::PlanError;
use host_sim::benchmark::{Course, CourseRun, End, GAP_CLASSES, Tally, gap_class};
use host_sim::import::gazebo::{SCALE_CIRCUMSCRIBED, SCALE_WIDTH};
use host_sim::run_log;
use host_sim::statistics::Rate;
use host_sim::world::KHEPERA_RADIUS_M;
use serde_json::{Value, json};

use super::args::WorldRunsArgs;
use super::drive::{Driven, Kind, kinds};
use super::plans::Plans;
use crate::cli::error::{CliError, Outcome};
use crate::cli::output::{OutputFolder, hex, print, print_json};
use crate::cli::table::{facts, percent, table};

pub struct Report<'a> {
    /// Name of the files.
    pub what: &'static str,
    pub args: &'a WorldRunsArgs,
    pub scalar: &'static str,
    pub courses: &'a [Course],
    pub driven: &'a [Driven],
    /// The plans of a map, of which some are driven.
    pub plans: Option<&'a Plans<'a>>,
}

impl Report<'_> {
    /// Writes and prints.
    pub fn put(&self, folder: Option<OutputFolder>) -> Result<Outcome, CliError> {
        let files = folder.map_or_else(|| Ok(Vec::new()), |folder| self.write(&folder))?;
        if self.args.json {
            print_json(&self.document(&files))?;
        } else {
            print(&self.text(&files))?;
        }
        Ok(Outcome::Ok)
    }

    fn write(&self, folder: &OutputFolder) -> Result<Vec<String>, CliError> {
        let mut files = vec![
            folder.write(&format!("{}_runs.csv", self.what), self.runs_csv().as_bytes())?,
            folder.write(&format!("{}_plans.csv", self.what), self.plans_csv().as_bytes())?,
        ];
        for (index, course) in self.courses.iter().enumerate() {
            let name = format!("{}.svg", course.scenario.name);
            files.push(folder.write(&name, self.picture(index, course).as_bytes())?);
        }
        Ok(files)
    }

    fn picture(&self, index: usize, course: &Course) -> String {
        let runs =
            self.driven.iter().filter(|driven| driven.course == index && !driven.run.samples.is_empty());
        let traces: Vec<_> =
            runs.map(|driven| run_log::trace(driven.kind.name(), &driven.run.samples)).collect();
        let planned = course.route.as_ref().map(|route| route.plan.checkpoints.clone());
        let checkpoints = planned.unwrap_or_else(|_| vec![course.goal]);
        host_sim::figure::draw_run(&course.scenario.clone().with_checkpoints(checkpoints), &traces)
    }

    /// A line for each run.
    fn runs_csv(&self) -> String {
        let mut text = String::from("world,kind,seed,end,time_s,time_share,score,way_m,x_m,y_m,hash\n");
        for Driven { course, kind, run } in self.driven {
            text += &format!(
                "{},{},{},{},{:.3},{:.4},{:.4},{:.4},{:.4},{:.4},{}\n",
                self.courses[*course].scenario.name,
                kind.name(),
                run.seed,
                end_name(run.end),
                run.time_s,
                run.time_share,
                run.score,
                run.way_m,
                run.at.0,
                run.at.1,
                hex(run.hash)
            );
        }
        text
    }

    /// A line for each world.
    fn plans_csv(&self) -> String {
        let mut text = String::from(
            "world,scale,gap_diameters,shortest_m,margin_mm,checkpoints,length_m,cells,passages,free,share,problem\n",
        );
        for course in self.courses {
            let or_empty = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.4}"));
            let gap = or_empty(course.gap_m.map(|gap| gap / (2.0 * KHEPERA_RADIUS_M)));
            let known =
                format!("{},{},{gap},{:.4}", course.scenario.name, or_empty(course.scale), course.shortest_m);
            text += &match &course.route {
                Ok(route) => format!(
                    "{known},{:.1},{},{:.4},{},{},{},{:.5},\n",
                    route.margin_m * 1000.0,
                    route.plan.checkpoints.len(),
                    route.plan.length_m(course.scenario.start.position),
                    route.plan.cells,
                    route.plan.passages,
                    course.map.free_cells(),
                    course.map.cell_share(&route.plan),
                ),
                Err(error) => format!("{known},,,,,,{},,\"{error}\"\n", course.map.free_cells()),
            };
        }
        text
    }

    fn text(&self, files: &[String]) -> String {
        let plans = self.plans.map_or_else(String::new, |plans| plans.text() + "\n");
        if self.courses.is_empty() {
            return plans;
        }
        let seeds = format!("{} to {}", self.args.learning.seed, self.last_seed());
        let mut head = facts([
            ("worlds", self.courses.len().to_string()),
            ("runs", format!("{} on each, seeds {seeds}, scalar {}", self.args.runs, self.scalar)),
            ("controller", self.args.controller.name().to_owned()),
            ("rates", String::from("in %, with Wilson's 95 % intervals")),
        ]);
        for (name, error) in self.without_route() {
            head += &facts([("no route", format!("{name}: {error}"))]);
        }
        let wrote = if files.is_empty() { String::new() } else { format!("\nwrote {}\n", files.join(", ")) };
        format!("{plans}{head}\n{}\n{}{wrote}", self.sums(), self.classes())
    }

    fn last_seed(&self) -> u64 {
        self.args.learning.seed + u64::from(self.args.runs) - 1
    }

    fn without_route(&self) -> impl Iterator<Item = (&str, &PlanError)> {
        self.courses.iter().filter_map(|course| {
            course.route.as_ref().err().map(|error| (course.scenario.name.as_str(), error))
        })
    }

    /// The scales that there are, in the order of their first world.
    fn scales(&self) -> Vec<Option<f64>> {
        let mut scales = Vec::new();
        for course in self.courses {
            if !scales.iter().any(|&scale| same(scale, course.scale)) {
                scales.push(course.scale);
            }
        }
        scales
    }

    fn tally(&self, kind: Kind, of: impl Fn(&Course) -> bool) -> Tally {
        let chosen = |driven: &&Driven| driven.kind == kind && of(&self.courses[driven.course]);
        let runs: Vec<&CourseRun> = self.driven.iter().filter(chosen).map(|driven| &driven.run).collect();
        Tally::of(&runs)
    }

    /// A row for each scale and kind.
    fn sums(&self) -> String {
        let head =
            ["scale", "kind", "runs", "success", "contact", "timeout", "no route", "score", "median AT/OT"];
        let mut rows = vec![head.map(String::from).to_vec()];
        for scale in self.scales() {
            for kind in kinds(self.args) {
                let tally = self.tally(kind, |course| same(course.scale, scale));
                let time =
                    tally.time_share_median.map_or_else(|| String::from("-"), |time| format!("{time:.2}"));
                rows.push(vec![
                    scale_name(scale),
                    kind.name().to_owned(),
                    tally.success.runs.to_string(),
                    rate(tally.success),
                    rate(tally.contact),
                    rate(tally.timeout),
                    rate(tally.no_route),
                    format!("{:.3}", tally.score),
                    time,
                ]);
            }
        }
        table(&rows)
    }

    /// A row for each class of gaps that there is.
    fn classes(&self) -> String {
        let kinds = kinds(self.args);
        let mut rows = vec![vec![String::from("tightest gap / diameter"), String::from("worlds")]];
        for kind in &kinds {
            let names = ["success", "contact", "score"].map(|figure| format!("{} {figure}", kind.name()));
            rows[0].extend(names);
        }
        for class in 0..=GAP_CLASSES.len() {
            let inside = |course: &Course| course.gap_m.is_some_and(|gap| gap_class(gap) == class);
            let worlds = self.courses.iter().filter(|course| inside(course)).count();
            if worlds == 0 {
                continue;
            }
            let mut row = vec![class_name(class), worlds.to_string()];
            for &kind in &kinds {
                let tally = self.tally(kind, inside);
                row.extend([rate(tally.success), rate(tally.contact), format!("{:.3}", tally.score)]);
            }
            rows.push(row);
        }
        if rows.len() == 1 { String::new() } else { table(&rows) }
    }

    fn document(&self, files: &[String]) -> Value {
        let tally = |kind: Kind, tally: Tally| {
            json!({
                "kind": kind.name(),
                "tally": tally,
                "wilson_95": {
                    "success": tally.success.wilson_95(),
                    "contact": tally.contact.wilson_95(),
                    "timeout": tally.timeout.wilson_95(),
                },
            })
        };
        let of_scale = |scale: Option<f64>| {
            let kinds = kinds(self.args).into_iter();
            let tallies: Vec<_> =
                kinds.map(|kind| tally(kind, self.tally(kind, |course| same(course.scale, scale)))).collect();
            json!({ "scale": scale_name(scale), "kinds": tallies })
        };
        let of_class = |class: usize| {
            let inside = |course: &Course| course.gap_m.is_some_and(|gap| gap_class(gap) == class);
            let kinds = kinds(self.args).into_iter();
            let tallies: Vec<_> = kinds.map(|kind| tally(kind, self.tally(kind, inside))).collect();
            json!({ "gap_diameters": class_name(class), "kinds": tallies })
        };
        let run = |driven: &Driven| {
            let mut value = json!(driven.run);
            value["hash"] = json!(hex(driven.run.hash));
            value["world"] = json!(self.courses[driven.course].scenario.name);
            value["kind"] = json!(driven.kind.name());
            value
        };
        json!({
            "scalar": self.scalar,
            "controller": self.args.controller.name(),
            "seed": self.args.learning.seed,
            "runs_per_world": self.args.runs,
            "plans": self.plans.map(Plans::json),
            "worlds": self.courses.iter().map(course_json).collect::<Vec<_>>(),
            "scales": self.scales().into_iter().map(of_scale).collect::<Vec<_>>(),
            "classes": (0..=GAP_CLASSES.len()).map(of_class).collect::<Vec<_>>(),
            "runs": self.driven.iter().map(run).collect::<Vec<_>>(),
            "files": files,
        })
    }
}

fn course_json(course: &Course) -> Value {
    let route = course.route.as_ref().map(|route| {
        json!({
            "margin_m": crate::cli::output::decimal(route.margin_m),
            "length_m": route.plan.length_m(course.scenario.start.position),
            "checkpoints": route.plan.checkpoints.iter().map(|place| [place.x, place.y]).collect::<Vec<_>>(),
            "cells": route.plan.cells,
            "passages": route.plan.passages,
        })
    });
    json!({
        "world": course.scenario.name,
        "source": course.scenario.source,
        "scale": course.scale,
        "gap_m": course.gap_m,
        "shortest_m": course.shortest_m,
        "goal_tolerance_m": course.goal_tolerance_m,
        "free_cells": course.map.free_cells(),
        "route": route.as_ref().ok(),
        "problem": route.as_ref().err().map(ToString::to_string),
    })
}

fn same(one: Option<f64>, other: Option<f64>) -> bool {
    one.map(f64::to_bits) == other.map(f64::to_bits)
}

/// BARN's two by their letters.
fn scale_name(scale: Option<f64>) -> String {
    const ALIKE: f64 = 1e-6;
    match scale {
        None => String::from("-"),
        Some(scale) if (scale - SCALE_WIDTH).abs() < ALIKE => String::from("W"),
        Some(scale) if (scale - SCALE_CIRCUMSCRIBED).abs() < ALIKE => String::from("C"),
        Some(scale) => format!("{scale:.4}"),
    }
}

fn class_name(class: usize) -> String {
    let end = GAP_CLASSES.get(class);
    match (class.checked_sub(1).and_then(|before| GAP_CLASSES.get(before)), end) {
        (None, Some(end)) => format!("below {end}"),
        (Some(from), Some(end)) => format!("{from} to {end}"),
        (Some(from), None) => format!("{from} and more"),
        (None, None) => String::from("all"),
    }
}

fn end_name(end: End) -> &'static str {
    match end {
        End::Goal => "goal",
        End::Contact => "contact",
        End::Timeout => "timeout",
        End::NoRoute => "no_route",
    }
}

fn rate(rate: Rate) -> String {
    let (low, high) = rate.wilson_95();
    format!("{} [{}, {}]", percent(rate.share()), percent(low), percent(high))
}
