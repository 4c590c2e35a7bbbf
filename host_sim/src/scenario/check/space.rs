//! Whether the parts of a scenario fit together: start, movers and checkpoints stand clear of what is solid.

use nalgebra::Point2;

use super::Checked;
use super::values::{Check, show};
use crate::scenario::{Route, Scenario};
use crate::world::{KHEPERA_RADIUS_M, World};

impl Check<'_> {
    pub(super) fn start_is_free(&self, key: &str, scenario: &Scenario) -> Checked<()> {
        let start = &scenario.start;
        let needed_m = KHEPERA_RADIUS_M + start.jitter_position_m;
        let clearance_m = scenario.world.clearance(start.position, 0.0);
        if clearance_m <= needed_m {
            let fix = "move the start away or make its jitter smaller";
            let problem = contact(clearance_m, needed_m);
            return Err(self.wrong(&format!("{key}.start"), show(start.position), problem, fix));
        }
        for (i, mover) in scenario.world.movers.iter().enumerate() {
            // The whole circle, not the moment: a robot that still stands cannot be blamed for being run over.
            let clearance_m = mover.least_clearance(start.position);
            if clearance_m <= needed_m {
                let problem = format!("hits the robot at its start, {}", show(start.position));
                let fix = "move the circle or the start";
                return Err(self.wrong(&format!("movers[{i}].centre"), show(mover.centre), problem, fix));
            }
        }
        Ok(())
    }

    pub(super) fn movers_are_free(&self, scenario: &Scenario) -> Checked<()> {
        for (i, mover) in scenario.world.movers.iter().enumerate() {
            if mover.least_clearance_from(&scenario.world.permanent) <= 0.0 {
                let key = format!("movers[{i}].orbit_radius_m");
                let problem = "the circle runs through a wall or obstacle";
                return Err(self.wrong(
                    &key,
                    mover.orbit_radius_m,
                    problem,
                    "move the circle or make it smaller",
                ));
            }
        }
        Ok(())
    }

    /// A checkpoint must be free when it counts: one that will be replaced at the start, any other at the end.
    pub(super) fn checkpoints_are_free(&self, table: &str, scenario: &Scenario) -> Checked<()> {
        let listed = matches!(scenario.route, Route::Checkpoints(_));
        let only_goal = scenario.route.checkpoints().len() == 1;
        for (i, checkpoint) in scenario.route.checkpoints().iter().enumerate() {
            let replaced = scenario.replacements.iter().any(|replacement| replacement.checkpoint == i);
            let key = if listed && !only_goal {
                format!("{table}checkpoints[{i}]")
            } else {
                format!("{table}goal")
            };
            let t_s = if replaced { 0.0 } else { scenario.time_limit_s };
            self.place_is_free(&key, *checkpoint, scenario, t_s)?;
        }
        for (i, replacement) in scenario.replacements.iter().enumerate() {
            self.place_is_free(&format!("replace[{i}].to"), replacement.to, scenario, scenario.time_limit_s)?;
        }
        Ok(())
    }

    /// Further robots stand and go where one may, and all of them have room for their bodies at start and goal.
    pub(super) fn robots_have_room(&self, scenario: &Scenario) -> Checked<()> {
        for i in 0..scenario.companions.len() {
            let one = scenario.of_robot(i + 1);
            self.start_is_free(&format!("robots[{i}]"), &one)?;
            self.checkpoints_are_free(&format!("robots[{i}]."), &one)?;
            for other in 0..=i {
                let before = scenario.of_robot(other);
                let jitter_m = one.start.jitter_position_m + before.start.jitter_position_m;
                let starts = (one.start.position, before.start.position, jitter_m);
                let goals = one.goal().zip(before.goal()).map(|(goal, other)| (goal, other, 0.0));
                for (name, pair) in [("start", Some(starts)), ("goal", goals)] {
                    let Some((place, of_other, jitter_m)) = pair else { continue };
                    let apart_m = (place - of_other).norm();
                    let needed_m = 2.0 * KHEPERA_RADIUS_M + jitter_m;
                    if apart_m <= needed_m {
                        let problem = format!(
                            "is {apart_m:.4} m from another robot's {name} and needs more than {needed_m:.4} m"
                        );
                        let fix = "move them apart or make the jitter smaller";
                        return Err(self.wrong(&format!("robots[{i}].{name}"), show(place), problem, fix));
                    }
                }
            }
        }
        Ok(())
    }

    fn place_is_free(&self, key: &str, place: Point2<f64>, scenario: &Scenario, t_s: f64) -> Checked<()> {
        let standing = World { movers: Vec::new(), ..scenario.world.clone() };
        let clearance_m = standing.clearance(place, t_s);
        if clearance_m <= KHEPERA_RADIUS_M {
            let problem = contact(clearance_m, KHEPERA_RADIUS_M);
            return Err(self.wrong(key, show(place), problem, "move it to where the robot fits"));
        }
        Ok(())
    }
}

fn contact(clearance_m: f64, needed_m: f64) -> String {
    if clearance_m <= 0.0 {
        String::from("is inside a wall or obstacle")
    } else {
        format!("is {clearance_m:.4} m from the nearest wall or obstacle and needs more than {needed_m:.4} m")
    }
}
