//! How the planner does on many pairs of places of a map.

use std::time::Instant;

use controller_core::planning::PlanError;
use host_sim::benchmark::{Ground, PlannedRoute};
use host_sim::statistics::{Rate, quantile};
use nalgebra::Point2;
use serde_json::{Value, json};

use crate::cli::table::{facts, percent};

/// One pair and its plan.
pub struct Planned {
    pub from: Point2<f64>,
    pub goal: Point2<f64>,
    pub route: Result<PlannedRoute, PlanError>,
    pub real_ms: f64,
    /// What others take for the length of the shortest way, in m.
    pub reference_m: Option<f64>,
}

/// Plans a pair, and measures how long that takes.
pub fn plan(ground: &Ground, from: Point2<f64>, goal: Point2<f64>, reference_m: Option<f64>) -> Planned {
    let start = Instant::now();
    let route = ground.route(from, goal);
    Planned { from, goal, route, real_ms: start.elapsed().as_secs_f64() * 1e3, reference_m }
}

/// All plans of a map.
pub struct Plans<'a> {
    pub ground: &'a Ground,
    pub plans: &'a [Planned],
}

impl Plans<'_> {
    fn found(&self) -> Rate {
        Rate::of(self.plans.iter().map(|planned| planned.route.is_ok()))
    }

    /// A figure of all plans that there are.
    fn figures(&self, of: impl Fn(&Planned, &PlannedRoute) -> Option<f64>) -> Vec<f64> {
        let routes = self.plans.iter().filter_map(|planned| Some((planned, planned.route.as_ref().ok()?)));
        routes.filter_map(|(planned, route)| of(planned, route)).collect()
    }

    fn ratios(&self) -> Vec<f64> {
        self.figures(|planned, route| {
            let reference = planned.reference_m.filter(|reference| *reference > 0.0)?;
            Some(route.plan.length_m(planned.from) / reference)
        })
    }

    fn shares(&self) -> Vec<f64> {
        self.figures(|_, route| Some(self.ground.planner.cell_share(&route.plan)))
    }

    fn times_ms(&self) -> Vec<f64> {
        self.plans.iter().map(|planned| planned.real_ms).collect()
    }

    /// Why there are pairs without a plan, each reason once.
    fn problems(&self) -> Vec<String> {
        let mut problems: Vec<String> = self
            .plans
            .iter()
            .filter_map(|planned| planned.route.as_ref().err().map(ToString::to_string))
            .collect();
        problems.sort();
        problems.dedup();
        problems
    }

    pub fn text(&self) -> String {
        let map = &self.ground.map;
        let found = self.found();
        let of = |values: &[f64], share: f64| quantile(values, share);
        let two = |values: &[f64], decimals: usize| match (of(values, 0.5), of(values, 1.0)) {
            (Some(median), Some(most)) => format!("median {median:.decimals$}, most {most:.decimals$}"),
            _ => String::from("-"),
        };
        let mut text = facts([
            ("map", format!("{}: {} x {} cells of {:.4} m", map.name, map.columns, map.rows, map.cell_m)),
            ("passable", format!("{} cells", map.passable_cells())),
            ("plans", format!("{} of {} ({} %)", found.count, found.runs, percent(found.share()))),
        ]);
        if !self.ratios().is_empty() {
            text += &facts([("length", format!("{} times the reference", two(&self.ratios(), 3)))]);
        }
        text += &facts([
            ("cells", format!("{} % of the passable ones", two(&percents(&self.shares()), 2))),
            ("checkpoints", two(&self.figures(|_, route| Some(count(route.plan.checkpoints.len()))), 0)),
            ("time", format!("{} ms on one core", two(&self.times_ms(), 1))),
        ]);
        for problem in self.problems() {
            text += &facts([("no plan", problem)]);
        }
        text
    }

    pub fn json(&self) -> Value {
        let map = &self.ground.map;
        let two = |values: &[f64]| json!({ "median": quantile(values, 0.5), "most": quantile(values, 1.0) });
        json!({
            "map": map.name,
            "columns": map.columns,
            "rows": map.rows,
            "cell_m": map.cell_m,
            "passable_cells": map.passable_cells(),
            "found": self.found(),
            "length_over_reference": two(&self.ratios()),
            "cell_share": two(&self.shares()),
            "time_ms": two(&self.times_ms()),
            "problems": self.problems(),
        })
    }
}

fn count(count: usize) -> f64 {
    u32::try_from(count).map_or(f64::INFINITY, f64::from)
}

fn percents(shares: &[f64]) -> Vec<f64> {
    shares.iter().map(|share| share * 100.0).collect()
}
