//! The scenarios that are part of the program: one for every experiment figure of the papers, and some of several
//! robots.

use super::error::{ScenarioError, most_similar};

/// Name and text of each, in the papers' order.
pub(super) const ALL: [(&str, &str); 7] = [
    ("p1_fig7", include_str!("../../scenarios/p1_fig7.toml")),
    ("p1_fig8", include_str!("../../scenarios/p1_fig8.toml")),
    ("p1_fig9", include_str!("../../scenarios/p1_fig9.toml")),
    ("p2_fig4", include_str!("../../scenarios/p2_fig4.toml")),
    ("p2_fig5", include_str!("../../scenarios/p2_fig5.toml")),
    ("p2_fig6", include_str!("../../scenarios/p2_fig6.toml")),
    ("p2_fig7", include_str!("../../scenarios/p2_fig7.toml")),
];

/// Those of several robots.
pub(super) const FLEETS: [(&str, &str); 2] = [
    ("robots_crossing", include_str!("../../scenarios/robots_crossing.toml")),
    ("robots_corridor", include_str!("../../scenarios/robots_corridor.toml")),
];

pub(super) fn not_found(name: &str) -> ScenarioError {
    let names: Vec<&str> = ALL.iter().chain(&FLEETS).map(|(builtin, _)| *builtin).collect();
    let hint = most_similar(name, names.iter().copied())
        .map_or_else(String::new, |like| format!("; did you mean `{like}`?"));
    ScenarioError::NotFound { name: name.to_owned(), hint, known: names.join(", ") }
}
