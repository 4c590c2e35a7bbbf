//! What the evaluations ask: lists of scenes, each a line of a table or a cell of a surface.
//!
//! A *question* is asked in all its scenes alike, such as a trap from all sides; its rate is over all of them.

use crate::lateness::LATENESS_MAX_MS;
use crate::limits::Measure;
use crate::scenario::{Route, Scenario, ScenarioError};
use crate::scenes::{Circling, Corridor, Disturbance, Door, Scene, Side, Slalom, Trap, WallEnd};

/// A line of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// What is asked.
    pub name: String,
    /// The scenes that ask it.
    pub scenarios: Vec<Scenario>,
    /// What it asks, where there is more or less of it.
    pub measure: Option<Measure>,
}

/// Rates over two measures.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// What is asked; also the stem of its files.
    pub name: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// What the columns are, with unit.
    pub columns: &'static str,
    /// What the rows are, with unit.
    pub rows: &'static str,
    /// Names of the columns.
    pub column_names: Vec<String>,
    /// Names of the rows.
    pub row_names: Vec<String>,
    /// The cells, row by row.
    pub cells: Vec<Question>,
}

/// Angles at which a trap is approached, in degrees.
const TRAP_ANGLES: [f64; 5] = [-60.0, -30.0, 0.0, 30.0, 60.0];
/// Angles at which a door is approached, in degrees.
const DOOR_ANGLES: [f64; 5] = [-45.0, -22.5, 0.0, 22.5, 45.0];

fn question(name: String, scenes: impl IntoIterator<Item = Scene>, disturbance: &Disturbance) -> Question {
    let scenarios = scenes.into_iter().map(|scene| scene.scenario(disturbance)).collect();
    Question { name, scenarios, measure: None }
}

fn trap(side: Side, width_cm: f64, depth_cm: f64, disturbance: &Disturbance) -> Question {
    let scene = |approach_deg| {
        Scene::Trap(Trap { width_m: width_cm / 100.0, depth_m: depth_cm / 100.0, side, approach_deg })
    };
    let name = format!("U {width_cm} x {depth_cm} cm {side}");
    let measure = Some(Measure::Trap { side, width_cm, depth_cm });
    Question { measure, ..question(name, TRAP_ANGLES.map(scene), disturbance) }
}

/// Traps that are asked for by name, and walls whose end hides the goal.
#[must_use]
pub fn traps(disturbance: &Disturbance) -> Vec<Question> {
    let outside = [(20.0, 10.0), (30.0, 20.0), (40.0, 40.0)];
    let inside = [(20.0, 15.0), (30.0, 25.0), (40.0, 40.0), (60.0, 60.0)];
    let mut questions: Vec<Question> =
        outside.map(|(width, depth)| trap(Side::Outside, width, depth, disturbance)).into();
    questions.extend(inside.map(|(width, depth)| trap(Side::Inside, width, depth, disturbance)));
    questions.extend([2.0, 5.0, 10.0].map(|past_cm| {
        let scene = |approach_deg| Scene::WallEnd(WallEnd { past_m: past_cm / 100.0, approach_deg });
        question(format!("wall that ends {past_cm} cm past"), [-45.0, 0.0, 45.0].map(scene), disturbance)
    }));
    questions
}

/// Traps by width and depth, from inside and from outside.
#[must_use]
pub fn trap_surfaces(disturbance: &Disturbance) -> Vec<Surface> {
    let sizes = [10.0, 20.0, 30.0, 40.0, 60.0, 80.0];
    let surface = |side, name, title| Surface {
        name,
        title,
        columns: "width of the U in cm",
        rows: "depth in cm",
        column_names: sizes.iter().map(f64::to_string).collect(),
        row_names: sizes.iter().map(f64::to_string).collect(),
        cells: sizes
            .iter()
            .flat_map(|&depth| sizes.iter().map(move |&width| trap(side, width, depth, disturbance)))
            .collect(),
    };
    vec![
        surface(Side::Outside, "traps_outside", "A U before the goal, approached from outside"),
        surface(Side::Inside, "traps_inside", "A U before the goal, started inside"),
    ]
}

fn door(width_cm: f64, angles: &[f64], approach: &str, disturbance: &Disturbance) -> Question {
    let scene = |&approach_deg: &f64| Scene::Door(Door { width_m: width_cm / 100.0, approach_deg });
    let measure = Measure::Door { approach: approach.to_owned(), width_cm };
    let name = format!("door {measure}, {approach}");
    Question { measure: Some(measure), ..question(name, angles.iter().map(scene), disturbance) }
}

/// Widths of doors, in cm.
const DOOR_WIDTHS_CM: [f64; 7] = [12.0, 10.0, 8.0, 7.0, 6.5, 6.0, 5.5];

/// Doors straight on and at 45 degrees, corridors, rows of posts.
#[must_use]
pub fn doors(disturbance: &Disturbance) -> Vec<Question> {
    let mut questions = Vec::new();
    for width in DOOR_WIDTHS_CM {
        questions.push(door(width, &[0.0], "straight", disturbance));
        questions.push(door(width, &[-45.0, 45.0], "±45°", disturbance));
    }
    questions.extend([12.0, 10.0, 8.0, 7.0].map(|width_cm| {
        let scene = Scene::Corridor(Corridor { width_m: width_cm / 100.0 });
        question(format!("corridor {width_cm} cm, two bends"), [scene], disturbance)
    }));
    questions.extend([12.0, 10.0, 8.0, 7.0].map(|gap_cm| {
        let scene = Scene::Slalom(Slalom { gap_m: gap_cm / 100.0 });
        question(format!("four rows of posts, gaps {gap_cm} cm"), [scene], disturbance)
    }));
    questions
}

/// Doors by width and angle; and by width and what disturbs the robot.
#[must_use]
pub fn door_surfaces(disturbance: &Disturbance) -> Vec<Surface> {
    let by_angle = Surface {
        name: "doors_angle",
        title: "A door in a closed wall",
        columns: "width of the door in cm",
        rows: "approach in degrees",
        column_names: DOOR_WIDTHS_CM.iter().map(f64::to_string).collect(),
        row_names: DOOR_ANGLES.iter().map(f64::to_string).collect(),
        cells: DOOR_ANGLES
            .iter()
            .flat_map(|&angle| {
                DOOR_WIDTHS_CM.map(|width| door(width, &[angle], &format!("at {angle}°"), disturbance))
            })
            .collect(),
    };
    let conditions = conditions(disturbance);
    let by_condition = Surface {
        name: "doors_condition",
        title: "A door in a closed wall, from all angles, and what disturbs the robot",
        columns: "width of the door in cm",
        rows: "what is changed",
        column_names: DOOR_WIDTHS_CM.iter().map(f64::to_string).collect(),
        row_names: conditions.iter().map(|(name, _)| name.clone()).collect(),
        cells: conditions
            .iter()
            .flat_map(|(name, condition)| {
                DOOR_WIDTHS_CM.map(|width| door(width, &DOOR_ANGLES, &format!("with {name}"), condition))
            })
            .collect(),
    };
    vec![by_angle, by_condition]
}

/// What can disturb a run more or less than usual.
fn conditions(usual: &Disturbance) -> Vec<(String, Disturbance)> {
    let changed = |name: String, change: &dyn Fn(&mut Disturbance)| {
        let mut disturbance = *usual;
        change(&mut disturbance);
        (name, disturbance)
    };
    let noise = |factor: f64| {
        let name = format!("{:.0} % noise", 100.0 * factor * usual.noise.sensor);
        changed(name, &|disturbance| {
            disturbance.noise.sensor *= factor;
            disturbance.noise.actuator *= factor;
        })
    };
    let dropout = |share: f64| {
        changed(format!("{:.0} % dropout", 100.0 * share), &|disturbance| disturbance.noise.dropout = share)
    };
    let late = |most_ms: u16| {
        let name = format!("tasks ≤ {most_ms} ms late");
        changed(name, &|disturbance| disturbance.noise.task_jitter_ms = most_ms)
    };
    let apart = changed(String::from("starts 3 × as far apart"), &|disturbance| disturbance.jitter *= 3.0);
    [0.0, 1.0, 2.0]
        .map(noise)
        .into_iter()
        .chain([0.05, 0.2].map(dropout))
        .chain([32, 64, LATENESS_MAX_MS].map(late))
        .chain([apart])
        .collect()
}

/// Discs that circle, by number and speed.
#[must_use]
pub fn traffic_surfaces(disturbance: &Disturbance) -> Vec<Surface> {
    let (speeds_cm, numbers) = ([2.5, 5.0, 10.0, 16.0], [1_u8, 2, 4, 6]);
    let cell = |discs, speed_cm: f64| {
        let scene = Scene::Circling(Circling { discs, speed_m_s: speed_cm / 100.0 });
        question(format!("{discs} discs at {speed_cm} cm/s"), [scene], disturbance)
    };
    vec![Surface {
        name: "traffic",
        title: "Discs of the robot's size that circle across the way and do not look",
        columns: "their speed in cm/s; the robot's is at most 16",
        rows: "discs",
        column_names: speeds_cm.iter().map(f64::to_string).collect(),
        row_names: numbers.iter().map(u8::to_string).collect(),
        cells: numbers.iter().flat_map(|&discs| speeds_cm.map(|speed| cell(discs, speed))).collect(),
    }]
}

/// The seven figures of the papers, with the noise of `disturbance`.
///
/// # Errors
/// Never, unless a built-in scenario is broken.
pub fn papers(disturbance: &Disturbance) -> Result<Vec<Question>, ScenarioError> {
    let question = |name: &str| {
        let mut scenario = Scenario::builtin(name)?;
        scenario.noise = disturbance.noise;
        Ok(Question { name: name.to_owned(), scenarios: vec![scenario], measure: None })
    };
    Scenario::builtin_names().map(question).collect()
}

/// How often each of the papers' figures is among the scenes of a search: they are few, and what users see first.
const FIGURES_COUNT: usize = 4;

/// The scenes in which controllers' numbers are searched for: some of each kind, none with a planner in the loop, since
/// that would be planned anew in each run. Of moving discs only two at a time: where everyone is touched, a search
/// would learn haste from luck.
///
/// # Errors
/// Never, unless a built-in scenario is broken.
pub fn search_scenes() -> Result<Vec<Scenario>, crate::route_planner::RouteError> {
    let usual = &Disturbance::PAPERS;
    let trap = |side, width_m, depth_m| {
        [-30.0, 0.0, 60.0].map(|approach_deg| Scene::Trap(Trap { width_m, depth_m, side, approach_deg }))
    };
    let mut scenes = Vec::new();
    for (width_m, depth_m) in [(0.2, 0.1), (0.3, 0.2), (0.4, 0.4)] {
        scenes.extend(trap(Side::Outside, width_m, depth_m));
    }
    for (width_m, depth_m) in [(0.2, 0.15), (0.3, 0.25), (0.4, 0.4), (0.6, 0.6)] {
        scenes.extend(trap(Side::Inside, width_m, depth_m));
    }
    for width_m in [0.1, 0.08, 0.07, 0.065, 0.06] {
        scenes.extend([0.0, 45.0].map(|approach_deg| Scene::Door(Door { width_m, approach_deg })));
    }
    for past_m in [0.05, 0.1] {
        scenes
            .extend([-45.0, 0.0, 45.0].map(|approach_deg| Scene::WallEnd(WallEnd { past_m, approach_deg })));
    }
    scenes.extend([0.08, 0.1].map(|width_m| Scene::Corridor(Corridor { width_m })));
    scenes.extend([0.08, 0.1].map(|gap_m| Scene::Slalom(Slalom { gap_m })));
    scenes.extend([0.05, 0.1].map(|speed_m_s| Scene::Circling(Circling { discs: 2, speed_m_s })));
    let mut scenarios: Vec<Scenario> = scenes.into_iter().map(|scene| scene.scenario(usual)).collect();
    for scenario in papers(usual).unwrap_or_default().into_iter().flat_map(|question| question.scenarios) {
        let planned = matches!(scenario.route, Route::Planned { .. });
        let scenario = if planned {
            let plan = crate::route_planner::plan(&scenario, scenario.start.position, 0.0)?;
            scenario.with_checkpoints(plan.checkpoints)
        } else {
            scenario
        };
        scenarios.extend(core::iter::repeat_n(scenario, FIGURES_COUNT));
    }
    Ok(scenarios)
}

#[cfg(test)]
mod tests {
    use super::{door_surfaces, doors, papers, search_scenes, traffic_surfaces, trap_surfaces, traps};
    use crate::scenes::Disturbance;

    #[test]
    fn surfaces_have_a_cell_for_each_pair_of_measures() {
        let usual = &Disturbance::PAPERS;
        for surface in [trap_surfaces(usual), door_surfaces(usual), traffic_surfaces(usual)].concat() {
            assert_eq!(surface.cells.len(), surface.column_names.len() * surface.row_names.len());
            assert!(surface.cells.iter().all(|cell| !cell.scenarios.is_empty()));
        }
    }

    #[test]
    fn questions_have_names_of_their_own() {
        let usual = &Disturbance::PAPERS;
        let mut names: Vec<String> = [traps(usual), doors(usual), papers(usual).unwrap()]
            .concat()
            .into_iter()
            .map(|question| question.name)
            .collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count);
        assert!(search_scenes().unwrap().len() > 30);
    }
}
