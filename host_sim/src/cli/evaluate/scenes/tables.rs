//! Rates over scenes as text and as CSV.

use host_sim::evaluation::SceneResult;
use host_sim::limits::{Limit, PASSED};
use host_sim::questions::Question;
use host_sim::route_planner;
use host_sim::statistics::Rate;

use super::super::super::table::{percent, table};
use super::{Column, What};

pub const WHAT_IT_MEANS: &str = "\
success: the goal within 5 mm, in time, without contact; in %, [Wilson's 95 % interval]
";

/// What [`in_full`] adds.
pub const WHAT_IT_ADDS: &str = "\
time, way over the shortest that the body fits along, and turning (rad/m, the less the smoother): medians of \
those that arrived
";

fn rate(rate: Rate) -> String {
    let (low, high) = rate.wilson_95();
    format!("{} [{}, {}]", percent(rate.share()), percent(low), percent(high))
}

fn or_dash(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(|| String::from("-"), |value| format!("{value:.decimals$}"))
}

pub fn rates(what: What, questions: &[Question], columns: &[Column]) -> String {
    if what == What::Papers { in_full(questions, columns) } else { beside_each_other(questions, columns) }
}

/// A line for each scene and controller.
fn in_full(questions: &[Question], columns: &[Column]) -> String {
    let head = ["scene", "controller", "success", "contact", "late", "time s", "way", "turning"];
    let mut rows = vec![head.map(String::from).to_vec()];
    for (index, question) in questions.iter().enumerate() {
        let shortest = shortest(question);
        for (number, column) in columns.iter().enumerate() {
            let Some(result) = column.results.get(index) else { continue };
            rows.push(vec![
                if number == 0 { question.name.clone() } else { String::new() },
                column.entrant.name().to_owned(),
                rate(result.success),
                percent(result.contact.share()),
                percent(result.late.share()),
                or_dash(result.time_median_s, 1),
                or_dash(way_over(result, shortest), 2),
                or_dash(result.turn_median_rad_per_m, 1),
            ]);
        }
    }
    table(&rows)
}

/// The first controller in full; of the others success and contact.
fn beside_each_other(questions: &[Question], columns: &[Column]) -> String {
    let mut rows = vec![vec![String::from("scene")]];
    for (number, column) in columns.iter().enumerate() {
        rows[0].push(format!("{}: success", column.entrant.name()));
        rows[0].push(String::from("contact"));
        if number == 0 {
            rows[0].extend(["late", "median s"].map(String::from));
        }
    }
    for (index, question) in questions.iter().enumerate() {
        let mut row = vec![question.name.clone()];
        for (number, column) in columns.iter().enumerate() {
            let Some(result) = column.results.get(index) else { continue };
            row.push(if number == 0 { rate(result.success) } else { percent(result.success.share()) });
            row.push(percent(result.contact.share()));
            if number == 0 {
                row.push(percent(result.late.share()));
                row.push(or_dash(result.time_median_s, 1));
            }
        }
        rows.push(row);
    }
    table(&rows)
}

/// A limit in words: what is passed and how often, and what is missed though it is easier.
pub fn limit(limit: &Limit) -> String {
    let Some(passed) = &limit.passed else { return String::from("none") };
    let mut text = format!("{}: {}", passed.measure, rate(passed.success));
    let missed: Vec<String> = limit.missed.iter().map(ToString::to_string).collect();
    if !missed.is_empty() {
        text += &format!(" (not {})", missed.join("; "));
    }
    text
}

/// The deepest trap and the narrowest door, a line for each controller; nothing where there is no limit to tell.
pub fn limits(columns: &[Column]) -> String {
    let Some(first) = columns.first().filter(|column| !column.limits.is_empty()) else {
        return String::new();
    };
    let mut rows = vec![vec![format!("hardest passed in at least {:.0} %", PASSED * 100.0)]];
    rows[0].extend(first.limits.iter().map(|limit| limit.group.clone()));
    for column in columns {
        let name = column.entrant.name().to_owned();
        rows.push(core::iter::once(name).chain(column.limits.iter().map(limit)).collect());
    }
    format!("{}\n", table(&rows))
}

/// One line for each scene and controller.
pub fn rates_csv(questions: &[Question], columns: &[Column]) -> String {
    let mut text = String::from(
        "scene,controller,runs,success,success_low,success_high,contact,late,time_median_s,way_median_m,\
         way_over_shortest,turn_median_rad_per_m\n",
    );
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.4}"));
    for (index, question) in questions.iter().enumerate() {
        let shortest = shortest(question);
        for column in columns {
            let Some(result) = column.results.get(index) else { continue };
            let (low, high) = result.success.wilson_95();
            text += &format!(
                "\"{}\",{},{},{:.4},{low:.4},{high:.4},{:.4},{:.4},{},{},{},{}\n",
                question.name,
                column.entrant.name(),
                result.success.runs,
                result.success.share(),
                result.contact.share(),
                result.late.share(),
                number(result.time_median_s),
                number(result.way_median_m),
                number(way_over(result, shortest)),
                number(result.turn_median_rad_per_m),
            );
        }
    }
    text
}

/// One line for each group and controller.
pub fn limits_csv(columns: &[Column]) -> String {
    let mut text =
        String::from("group,controller,hardest_passed,runs,success,success_low,success_high,missed\n");
    for column in columns {
        for limit in &column.limits {
            let passed = limit.passed.as_ref().map_or_else(
                || String::from(",,,,"),
                |passed| {
                    let (share, (low, high)) = (passed.success.share(), passed.success_wilson_95);
                    let runs = passed.success.runs;
                    format!("\"{}\",{runs},{share:.4},{low:.4},{high:.4}", passed.measure)
                },
            );
            let missed: Vec<String> = limit.missed.iter().map(ToString::to_string).collect();
            text += &format!(
                "\"{}\",{},{passed},\"{}\"\n",
                limit.group,
                column.entrant.name(),
                missed.join("; ")
            );
        }
    }
    text
}

/// The shortest way that the body fits along, where all is known; only of a question with one scene.
fn shortest(question: &Question) -> Option<f64> {
    let [scenario] = question.scenarios.as_slice() else { return None };
    route_planner::shortest_m(scenario)
}

fn way_over(result: &SceneResult, shortest: Option<f64>) -> Option<f64> {
    Some(result.way_median_m? / shortest?)
}
