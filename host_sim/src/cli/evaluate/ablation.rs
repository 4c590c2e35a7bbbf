//! What each departure from the papers is worth: it alone is undone, and the maps are learned anew.

use controller_core::config::Config;
use controller_core::kohonen::features::Chart;
use controller_core::kohonen::map::Eligible;
use controller_core::kohonen::self_organisation::{Displacement, StepRule};
use controller_core::motor_control::Beyond;
use host_sim::learning_curve::CurvePlan;

use super::super::args::{MappingArg, ScalarArg};
use super::super::error::CliError;
use super::super::table::table;
use super::report::{RESULT_HEAD, result_cells};
use super::trials::{self, Subject};

/// A departure: what is done instead, and how.
struct Departure {
    instead: &'static str,
    undo: fn(&mut Config),
}

/// The list of `ARCHITECTURE.md`, as far as it concerns positioning.
const DEPARTURES: [Departure; 16] = [
    Departure { instead: "(nothing changed)", undo: |_| () },
    Departure { instead: "unsigned distances, full circle", undo: |c| c.learning.chart = Chart::Unsigned },
    Departure { instead: "v is the place reached", undo: |c| c.learning.displacement = Displacement::Place },
    Departure { instead: "plain gradient", undo: |c| c.learning.step = StepRule::Plain },
    Departure {
        instead: "constant η of 0.1",
        undo: |c| (c.learning.output_rate_first, c.learning.weight_rate_first) = (0.1, 0.06),
    },
    Departure {
        instead: "constant σ of 1",
        undo: |c| (c.learning.neighbourhood_first, c.learning.neighbourhood_last) = (1.0, 1.0),
    },
    Departure { instead: "hardly any exploration later", undo: |c| c.learning.exploration_last = 1e-4 },
    Departure { instead: "A(α) without tolerance", undo: |c| c.reaching.bearing_tolerance_rad = 0.0 },
    Departure { instead: "untrained neurons may win", undo: |c| c.reaching.eligible = Eligible::All },
    Departure { instead: "far targets as they are", undo: |c| c.reaching.far_share = 0.0 },
    Departure { instead: "near targets as they are", undo: |c| c.reaching.near_share = 0.0 },
    Departure { instead: "M w beyond c*", undo: |c| c.reaching.beyond = Beyond::OwnWeight },
    Departure { instead: "speeds in units of 8 mm/s", undo: |c| c.robot.command_unit_mps = 0.008 },
    Departure { instead: "stop within 1 mm", undo: |c| c.reaching.goal_tolerance_m = 0.001 },
    Departure { instead: "stop within 3 mm", undo: |c| c.reaching.goal_tolerance_m = 0.003 },
    Departure {
        instead: "8 mm/s and stop at rest within 3 mm",
        undo: |c| {
            c.robot.command_unit_mps = 0.008;
            (c.reaching.goal_tolerance_m, c.reaching.goal_speed_mps) = (0.003, 0.001);
        },
    },
];

/// Learns with each departure undone, and prints what comes of it.
pub fn ablate(
    base: &Config,
    (mapping, scalar): (MappingArg, ScalarArg),
    plan: &CurvePlan,
    seeds: &[u64],
) -> Result<String, CliError> {
    let configs = DEPARTURES.each_ref().map(|departure| {
        let mut config = base.clone();
        (departure.undo)(&mut config);
        config
    });
    let subjects = DEPARTURES.iter().zip(&configs).map(|(departure, config)| Subject {
        name: departure.instead.to_owned(),
        config_name: departure.instead,
        config,
        mapping,
        scalar,
    });
    let kinds = trials::run(subjects.collect(), plan, seeds)?;
    let head = core::iter::once("instead").chain(RESULT_HEAD).chain(["below 3 mm from step"]);
    let mut rows = vec![head.map(String::from).collect::<Vec<_>>()];
    for kind in &kinds {
        let learned = kind.steps_until_all_below(0.003);
        let learned = learned.map_or_else(|| String::from("–"), |steps| steps.to_string());
        rows.push([vec![kind.name().to_owned()], result_cells(kind), vec![learned]].concat());
    }
    Ok(table(&rows))
}
