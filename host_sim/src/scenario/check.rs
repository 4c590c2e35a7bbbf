//! From what a file says to what can be run: every value is checked, and every complaint names its key and the way out.

mod space;
mod values;

use super::error::ScenarioError;
use super::raw::{
    RawCompanion, RawController, RawDirection, RawJitter, RawMover, RawNoise, RawPoint, RawReplacement,
    RawScenario, RawSolid,
};
use super::{
    AVOIDANCE_PERIOD_MS, Companion, ControllerKind, NoiseLevels, Replacement, Route, Scenario, Shape, Solid,
    Start, Trigger,
};
use crate::geometry::{Disc, Polygon};
use crate::mover::{Direction, Mover};
use crate::world::{KHEPERA_RADIUS_M, Timed, Window, World};
use values::{Check, list};

/// "If it was less than 5 mm from the checkpoint" (both papers).
const TOLERANCE_M: f64 = 0.005;
/// P2's target-reaching period.
const TARGET_PERIOD_MS: u32 = 256;
/// P2's noise, on sensors and actuators.
const NOISE_FRACTION: f64 = 0.1;
/// P2's sensors "have a resolution of 0.5cm".
const SENSOR_RESOLUTION_M: f64 = 0.005;
/// Chosen because two neighbours of twelve sensors then leave a gap as wide as themselves between their cones.
const BEAM_HALF_WIDTH_DEG: f64 = 7.5;
/// Wider cones would overlap beyond the next sensor's axis, which no sensor of a ring of twelve does.
const BEAM_HALF_WIDTH_MAX_DEG: f64 = 30.0;

type Checked<T> = Result<T, ScenarioError>;

/// Checks everything and builds the world.
pub(super) fn scenario(file: &str, raw: &RawScenario) -> Checked<Scenario> {
    let check = Check { file };
    let solids = check.solids(raw)?;
    let movers = check.all("movers", &raw.movers, |check, key, mover| check.mover(key, mover))?;
    let route = check.route(raw)?;
    let time_limit_s = check.positive("time_limit_s", raw.time_limit_s)?;
    let checked = Scenario {
        name: check.name("name", &raw.name)?,
        title: check.filled("title", &raw.title)?,
        source: check.filled("source", &raw.source)?,
        start: check.start("robot", raw.robot.start, raw.robot.heading_deg, raw.robot.jitter)?,
        companions: check.all("robots", &raw.robots, |check, key, robot| check.companion(key, robot))?,
        replacements: check.replacements(&raw.replace, &route, time_limit_s)?,
        route,
        tolerance_m: check.positive("tolerance_m", raw.tolerance_m.unwrap_or(TOLERANCE_M))?,
        time_limit_s,
        controller: match raw.control.controller {
            Some(RawController::Fusion) => ControllerKind::Fusion,
            Some(RawController::Cooperative) | None => ControllerKind::Cooperative,
        },
        target_period_ms: check.period(raw.control.target_period_ms.unwrap_or(TARGET_PERIOD_MS))?,
        noise: check.noise(&raw.noise)?,
        world: world(&solids, movers),
        solids,
    };
    check.start_is_free("robot", &checked)?;
    check.movers_are_free(&checked)?;
    check.checkpoints_are_free("", &checked)?;
    check.robots_have_room(&checked)?;
    Ok(checked)
}

/// The simulator's world of these solids and movers.
pub(super) fn world(solids: &[Solid], movers: Vec<Mover>) -> World {
    let mut world = World { movers, ..World::default() };
    for solid in solids {
        if solid.window == Window::ALWAYS {
            solid.shape.add_to(&mut world.permanent);
        } else {
            let mut timed = Timed { window: solid.window, solids: crate::solids::Solids::default() };
            solid.shape.add_to(&mut timed.solids);
            world.timed.push(timed);
        }
    }
    world
}

/// Tables of the file.
impl Check<'_> {
    fn start(&self, key: &str, start: RawPoint, heading_deg: f64, jitter: RawJitter) -> Checked<Start> {
        let key = |name: &str| format!("{key}.{name}");
        let heading_deg = self.finite(&key("heading_deg"), heading_deg)?;
        let jitter_deg = self.not_negative(&key("jitter.heading_deg"), jitter.heading_deg)?;
        Ok(Start {
            position: self.point(&key("start"), start)?,
            heading_rad: heading_deg.to_radians(),
            jitter_position_m: self.not_negative(&key("jitter.position_m"), jitter.position_m)?,
            jitter_heading_rad: jitter_deg.to_radians(),
        })
    }

    fn companion(&self, key: &str, raw: &RawCompanion) -> Checked<Companion> {
        let start = self.start(key, raw.start, raw.heading_deg, raw.jitter)?;
        let goal = raw.goal.map(|goal| self.point(&format!("{key}.goal"), goal)).transpose()?;
        let list_key = format!("{key}.checkpoints");
        let checkpoints = raw.checkpoints.as_deref().map(|list| self.points(&list_key, list)).transpose()?;
        let checkpoints = match (goal, checkpoints) {
            (Some(goal), None) => vec![goal],
            (None, Some(checkpoints)) if !checkpoints.is_empty() => checkpoints,
            _ => {
                let fix = "give it `goal = [x, y]`, or `checkpoints = [[x, y], ...]` whose last is the goal";
                return Err(self.wrong(key, "these keys", "must say in one way where the robot goes", fix));
            }
        };
        Ok(Companion { start, checkpoints })
    }

    fn noise(&self, raw: &RawNoise) -> Checked<NoiseLevels> {
        let half_width_key = "noise.beam_half_width_deg";
        let half_width_deg =
            self.not_negative(half_width_key, raw.beam_half_width_deg.unwrap_or(BEAM_HALF_WIDTH_DEG))?;
        if half_width_deg > BEAM_HALF_WIDTH_MAX_DEG {
            let problem =
                format!("is wider than {BEAM_HALF_WIDTH_MAX_DEG} degrees, the angle between two sensors");
            return Err(self.wrong(half_width_key, half_width_deg, problem, "write a smaller half-width"));
        }
        let resolution_m = raw.sensor_resolution_m.unwrap_or(SENSOR_RESOLUTION_M);
        let pose_heading_deg = raw.pose_heading_deg.unwrap_or(0.0);
        Ok(NoiseLevels {
            sensor: self.fraction("noise.sensor", raw.sensor.unwrap_or(NOISE_FRACTION))?,
            actuator: self.fraction("noise.actuator", raw.actuator.unwrap_or(NOISE_FRACTION))?,
            sensor_resolution_m: self.not_negative("noise.sensor_resolution_m", resolution_m)?,
            dropout: self.fraction("noise.dropout", raw.dropout.unwrap_or(0.0))?,
            beam_half_width_rad: half_width_deg.to_radians(),
            pose_position_m: self
                .not_negative("noise.pose_position_m", raw.pose_position_m.unwrap_or(0.0))?,
            pose_heading_rad: self.not_negative("noise.pose_heading_deg", pose_heading_deg)?.to_radians(),
            // No part of a file: a board that runs one has tasks of its own.
            task_jitter_ms: 0,
        })
    }

    fn solids(&self, raw: &RawScenario) -> Checked<Vec<Solid>> {
        let mut solids = self.all("walls", &raw.walls, |check, key, wall| check.solid(key, wall, true))?;
        solids.extend(
            self.all("obstacles", &raw.obstacles, |check, key, block| check.solid(key, block, false))?,
        );
        Ok(solids)
    }

    fn solid(&self, key: &str, raw: &RawSolid, known_by_default: bool) -> Checked<Solid> {
        let from_s = self.not_negative(&format!("{key}.from_s"), raw.from_s.unwrap_or(0.0))?;
        let until_key = format!("{key}.until_s");
        let until_s = raw.until_s.map_or(Ok(f64::INFINITY), |until_s| self.positive(&until_key, until_s))?;
        if until_s <= from_s {
            let fix = "let it disappear after it has appeared";
            return Err(self.wrong(&until_key, until_s, format!("is not after from_s = {from_s}"), fix));
        }
        let window = Window { from_s, until_s };
        Ok(Solid { shape: self.shape(key, raw)?, known: raw.known.unwrap_or(known_by_default), window })
    }

    fn shape(&self, key: &str, raw: &RawSolid) -> Checked<Shape> {
        let radius_key = format!("{key}.radius_m");
        match (&raw.line, raw.rectangle, &raw.polygon, raw.centre, raw.radius_m) {
            (Some(line), None, None, None, None) => self.line(&format!("{key}.line"), line),
            (None, Some([[x0, y0], [x1, y1]]), None, None, None) => {
                self.polygon(&format!("{key}.rectangle"), &[[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
            }
            (None, None, Some(polygon), None, None) => self.polygon(&format!("{key}.polygon"), polygon),
            (None, None, None, Some(centre), Some(radius_m)) => Ok(Shape::Disc(Disc {
                centre: self.point(&format!("{key}.centre"), centre)?,
                radius_m: self.positive(&radius_key, radius_m)?,
            })),
            (None, None, None, Some(_), None) => {
                Err(self.wrong(&radius_key, "nothing", "a disc needs a radius", "add `radius_m = ...`"))
            }
            _ => {
                let problem = "must have exactly one shape";
                let fix = "give it `line`, `rectangle`, `polygon`, or `centre` with `radius_m`";
                Err(self.wrong(key, "these keys", problem, fix))
            }
        }
    }

    fn line(&self, key: &str, raw: &[RawPoint]) -> Checked<Shape> {
        let points = self.points(key, raw)?;
        if points.len() < 2 {
            return Err(self.wrong(key, list(&points), "has fewer than two points", "add where it ends"));
        }
        Ok(Shape::Line(points))
    }

    fn polygon(&self, key: &str, raw: &[RawPoint]) -> Checked<Shape> {
        let points = self.points(key, raw)?;
        match Polygon::new(&points) {
            Some(polygon) if polygon.is_simple() => Ok(Shape::Polygon(polygon)),
            Some(_) => {
                Err(self.wrong(key, list(&points), "crosses or touches itself", "list the corners in turn"))
            }
            None => {
                let fix = "give at least three corners that are not in a line";
                Err(self.wrong(key, list(&points), "encloses no area", fix))
            }
        }
    }

    fn mover(&self, key: &str, raw: &RawMover) -> Checked<Mover> {
        let direction = match raw.direction {
            RawDirection::Anticlockwise => Direction::Anticlockwise,
            RawDirection::Clockwise => Direction::Clockwise,
        };
        let jitter_deg = self.not_negative(&format!("{key}.phase_jitter_deg"), raw.phase_jitter_deg)?;
        let mover = Mover::new(
            self.point(&format!("{key}.centre"), raw.centre)?,
            self.positive(&format!("{key}.orbit_radius_m"), raw.orbit_radius_m)?,
            self.positive(&format!("{key}.radius_m"), raw.radius_m.unwrap_or(KHEPERA_RADIUS_M))?,
            self.not_negative(&format!("{key}.speed_m_s"), raw.speed_m_s)?,
            direction,
            self.finite(&format!("{key}.phase_deg"), raw.phase_deg)?.to_radians(),
        );
        Ok(mover.with_phase_jitter(jitter_deg.to_radians()))
    }

    fn route(&self, raw: &RawScenario) -> Checked<Route> {
        let goal = raw.goal.map(|goal| self.point("goal", goal)).transpose()?;
        let checkpoints =
            raw.checkpoints.as_deref().map(|list| self.points("checkpoints", list)).transpose()?;
        match (goal, checkpoints, raw.plan) {
            (Some(goal), None, true) => Ok(Route::Planned { goal }),
            (Some(goal), None, false) => Ok(Route::Checkpoints(vec![goal])),
            (None, Some(checkpoints), false) if !checkpoints.is_empty() => {
                Ok(Route::Checkpoints(checkpoints))
            }
            (None, None, _) | (None, Some(_), false) => {
                let fix = "add `goal = [x, y]`, or `checkpoints = [[x, y], ...]` whose last is the goal";
                Err(self.wrong("goal", "nothing", "the robot has nowhere to go", fix))
            }
            (Some(_), Some(given), _) => {
                let problem = "is given beside `goal`";
                Err(self.wrong("checkpoints", list(&given), problem, "make the goal the last checkpoint"))
            }
            (None, Some(_), true) => {
                let problem = "the planner finds checkpoints, so they cannot also be given";
                Err(self.wrong("plan", true, problem, "write `goal` alone, or leave `plan` out"))
            }
        }
    }

    fn replacements(&self, raw: &[RawReplacement], route: &Route, limit_s: f64) -> Checked<Vec<Replacement>> {
        self.all("replace", raw, |check, key, raw| check.replacement(key, raw, route, limit_s))
    }

    fn replacement(
        &self,
        key: &str,
        raw: &RawReplacement,
        route: &Route,
        limit_s: f64,
    ) -> Checked<Replacement> {
        let Route::Checkpoints(checkpoints) = route else {
            let problem = "which checkpoints a planner finds is not known beforehand";
            return Err(self.wrong(key, "a replacement", problem, "give `checkpoints` instead of `plan`"));
        };
        let index = |key: String, number: usize| {
            let fix = "count from 1, as the figures do";
            let problem = format!("there are {} checkpoints", checkpoints.len());
            let index = number.checked_sub(1).filter(|index| *index < checkpoints.len());
            index.ok_or_else(|| self.wrong(&key, number, problem, fix))
        };
        let checkpoint = index(format!("{key}.checkpoint"), raw.checkpoint)?;
        let trigger = match (raw.at_s, raw.after_checkpoint) {
            (Some(t_s), None) => {
                let key = format!("{key}.at_s");
                if self.not_negative(&key, t_s)? >= limit_s {
                    let fix = "make it earlier or raise time_limit_s";
                    return Err(self.wrong(&key, t_s, "is not before the time limit", fix));
                }
                Trigger::At { t_s }
            }
            (None, Some(number)) => {
                let key_after = format!("{key}.after_checkpoint");
                let after = index(key_after.clone(), number)?;
                if after >= checkpoint {
                    let fix = "name an earlier checkpoint";
                    return Err(self.wrong(
                        &key_after,
                        number,
                        "is not before the one that is replaced",
                        fix,
                    ));
                }
                let delay_s = self.not_negative(&format!("{key}.delay_s"), raw.delay_s.unwrap_or(0.0))?;
                Trigger::AfterCheckpoint { checkpoint: after, delay_s }
            }
            (None, None) | (Some(_), Some(_)) => {
                let fix = "give either `at_s` or `after_checkpoint`";
                return Err(self.wrong(key, "these keys", "must have exactly one trigger", fix));
            }
        };
        Ok(Replacement { trigger, checkpoint, to: self.point(&format!("{key}.to"), raw.to)? })
    }
}
