//! Scenes that are questions: how deep a trap does a controller leave, how narrow a door does it pass?
//!
//! Each is drawn from its measures, so that they can be swept, and asks for one place, the goal, without a planner and
//! without a map. Which seed draws what is the scenario's affair: start, heading and noise.
//!
//! ```text
//!        ┌──────┐            │                    o  o
//!  →     │ trap    ·    →    door   ·        →   o  o   ·    posts in two rows, discs that circle,
//!        └──────┘            │                    o  o         a wall whose end hides the goal, a corridor
//! ```

mod build;
mod passages;
mod traffic;
mod traps;

use crate::scenario::Scenario;

pub use build::Disturbance;
pub use passages::{Corridor, Door, Slalom};
pub use traffic::Circling;
pub use traps::{Side, Trap, WallEnd};

/// A scene with its measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scene {
    /// A U between the robot and its goal.
    Trap(Trap),
    /// A door in a wall that closes a room.
    Door(Door),
    /// A corridor with two bends.
    Corridor(Corridor),
    /// Two rows of posts across the way.
    Slalom(Slalom),
    /// Discs that circle across the way.
    Circling(Circling),
    /// A wall whose end hides the goal.
    WallEnd(WallEnd),
}

impl Scene {
    /// The scene as an experiment.
    #[must_use]
    pub fn scenario(&self, disturbance: &Disturbance) -> Scenario {
        match self {
            Self::Trap(trap) => trap.scenario(disturbance),
            Self::Door(door) => door.scenario(disturbance),
            Self::Corridor(corridor) => corridor.scenario(disturbance),
            Self::Slalom(slalom) => slalom.scenario(disturbance),
            Self::Circling(circling) => circling.scenario(disturbance),
            Self::WallEnd(end) => end.scenario(disturbance),
        }
    }

    /// A name that says kind and measures, fit for files: `trap_in_40x40_+30`.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Trap(trap) => trap.name(),
            Self::Door(door) => door.name(),
            Self::Corridor(corridor) => corridor.name(),
            Self::Slalom(slalom) => slalom.name(),
            Self::Circling(circling) => circling.name(),
            Self::WallEnd(end) => end.name(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Circling, Corridor, Disturbance, Door, Scene, Side, Slalom, Trap, WallEnd};
    use crate::world::KHEPERA_RADIUS_M;

    fn all() -> Vec<Scene> {
        let mut scenes = Vec::new();
        for approach_deg in [-60.0, -45.0, 0.0, 20.0, 45.0] {
            for (width_m, depth_m) in [(0.10, 0.05), (0.2, 0.1), (0.4, 0.4), (0.8, 0.8)] {
                for side in [Side::Outside, Side::Inside] {
                    scenes.push(Scene::Trap(Trap { width_m, depth_m, side, approach_deg }));
                }
            }
            for width_m in [0.055, 0.08, 0.2] {
                scenes
                    .push(Scene::Door(Door { width_m, approach_deg: f64::clamp(approach_deg, -45.0, 45.0) }));
            }
            scenes.push(Scene::WallEnd(WallEnd { past_m: 0.1, approach_deg }));
        }
        scenes.extend([0.07, 0.2].map(|width_m| Scene::Corridor(Corridor { width_m })));
        scenes.extend([0.06, 0.2].map(|gap_m| Scene::Slalom(Slalom { gap_m })));
        for speed_m_s in [0.05, 0.16] {
            scenes.extend((1..=6).map(|discs| Scene::Circling(Circling { discs, speed_m_s })));
        }
        scenes
    }

    #[test]
    fn start_and_goal_are_free_wherever_the_start_is_drawn() {
        for scene in all() {
            let scenario = scene.scenario(&Disturbance::PAPERS);
            let room = |place| scenario.world.clearance(place, 0.0) - KHEPERA_RADIUS_M;
            let start = &scenario.start;
            assert!(room(start.position) > start.jitter_position_m, "start of {}", scene.name());
            assert!(room(scenario.goal().unwrap()) > 0.005, "goal of {}", scene.name());
        }
    }

    #[test]
    fn the_straight_way_is_closed_but_for_doors() {
        for scene in all() {
            let scenario = scene.scenario(&Disturbance::PAPERS);
            let (from, to) = (scenario.start.position, scenario.goal().unwrap());
            let clear = (0..=1000).all(|step| {
                let at = from + (to - from) * (f64::from(step) / 1000.0);
                scenario.world.clearance(at, 0.0) > KHEPERA_RADIUS_M
            });
            match scene {
                Scene::Door(door) if door.approach_deg.abs() < 1.0 => {
                    assert!(clear, "{} leads straight through", scene.name());
                }
                Scene::Circling(_) | Scene::Door(_) | Scene::Slalom(_) => {}
                Scene::Trap(_) | Scene::Corridor(_) | Scene::WallEnd(_) => {
                    assert!(!clear, "{} asks for nothing", scene.name());
                }
            }
        }
    }

    #[test]
    fn names_are_distinct_and_files_can_have_them() {
        let mut names: Vec<String> = all().iter().map(Scene::name).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        // Doors are clamped to 45 degrees above, so those at 60 repeat.
        assert_eq!(names.len(), count - 3);
        let fit = |c: char| c.is_ascii_alphanumeric() || "_+-.".contains(c);
        assert!(names.iter().all(|name| name.chars().all(fit)), "{names:?}");
    }
}
