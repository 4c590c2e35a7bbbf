//! Rates over two measures: text, CSV and picture.

use host_sim::evaluation::SceneResult;
use host_sim::figure::{HeatCell, HeatMap};
use host_sim::limits::{Limit, PASSED, limits};
use host_sim::questions::Surface;
use serde_json::{Value, json};

use super::super::super::table::percent;
use super::tables::limit;
use super::{SceneArgs, result_json};

/// A surface that was measured.
pub struct Measured {
    pub surface: Surface,
    /// Who drove.
    pub controller: &'static str,
    pub results: Vec<SceneResult>,
}

impl Measured {
    fn rows(&self) -> impl Iterator<Item = (&String, &[SceneResult])> {
        let width = self.surface.column_names.len().max(1);
        self.surface.row_names.iter().zip(self.results.chunks(width))
    }

    fn limits(&self) -> Vec<Limit> {
        limits(&self.surface.cells, &self.results)
    }

    pub fn csv(&self) -> String {
        let mut text = format!(
            "\"{}\",\"{}\",runs,success,success_low,success_high,contact,late\n",
            self.surface.rows, self.surface.columns
        );
        for (row, results) in self.rows() {
            for (column, result) in self.surface.column_names.iter().zip(results) {
                let (low, high) = result.success.wilson_95();
                text += &format!(
                    "{row},{column},{},{:.4},{low:.4},{high:.4},{:.4},{:.4}\n",
                    result.success.runs,
                    result.success.share(),
                    result.contact.share(),
                    result.late.share()
                );
            }
        }
        text
    }

    pub fn heat_map(&self, args: &SceneArgs) -> HeatMap {
        let cell = |result: &SceneResult| {
            let (low, high) = result.success.wilson_95();
            let hint = format!(
                "{} of {} [{}, {}], contact {} %, late {} %",
                result.success.count,
                result.success.runs,
                percent(low),
                percent(high),
                percent(result.contact.share()),
                percent(result.late.share())
            );
            let contact = result.contact.share();
            let note = if contact > 0.0 { format!("contact {:.0}", contact * 100.0) } else { String::new() };
            Some(HeatCell { share: result.success.share(), note, hint })
        };
        HeatMap {
            title: self.surface.title.to_owned(),
            under: format!(
                "success in % with {}; {} runs of each scene, seeds {} and up, {:.0} % noise",
                self.controller,
                args.runs,
                args.seed,
                args.noise * 100.0
            ),
            columns: self.surface.columns.to_owned(),
            rows: self.surface.rows.to_owned(),
            column_names: self.surface.column_names.clone(),
            row_names: self.surface.row_names.clone(),
            cells: self.rows().map(|(_, results)| results.iter().map(cell).collect()).collect(),
            passed: PASSED,
            legend: format!(
                "framed: at least {:.0} %; contact: % of the runs that touched something; other failures came late",
                PASSED * 100.0
            ),
        }
    }

    /// Where it ends: of each row, the columns that are passed; and of all of it, the hardest.
    pub fn text(&self) -> String {
        let mut text =
            format!("{}: {} in at least {} %\n", self.surface.title, self.controller, percent(PASSED));
        for (row, results) in self.rows() {
            let passed: Vec<&str> = self
                .surface
                .column_names
                .iter()
                .zip(results)
                .filter(|(_, result)| result.success.share() >= PASSED)
                .map(|(name, _)| name.as_str())
                .collect();
            let passed = if passed.is_empty() { String::from("none") } else { passed.join(", ") };
            text += &format!("  {} {row}: {} {passed}\n", self.surface.rows, self.surface.columns);
        }
        if let [only] = self.limits().as_slice() {
            text += &format!("  {}, the hardest: {}\n", only.group, limit(only));
        }
        text
    }

    pub fn document(&self) -> Value {
        let cells = self.surface.cells.iter().zip(&self.results);
        json!({
            "name": self.surface.name,
            "controller": self.controller,
            "rows": { "what": self.surface.rows, "names": self.surface.row_names },
            "columns": { "what": self.surface.columns, "names": self.surface.column_names },
            "cells": cells.map(|(cell, result)| result_json(&cell.name, result)).collect::<Vec<_>>(),
            "limits": self.limits(),
        })
    }
}
