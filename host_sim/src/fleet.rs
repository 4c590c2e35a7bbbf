//! Several robots in one world, each with a controller of its own, that tell each other where they are.
//!
//! Within a tick all robots first read the world as it stands and decide; then they move, one after the other in their
//! order, each held against the others where they are by then. To sensors and bodies another robot is a disc. A contact
//! between two robots counts once, for the one that ran into the other.
//!
//! Robot 0 has the run's seed and the others seeds that follow from it, so the first robot draws the same noise with
//! and without company.

use controller_core::config::{Architecture, Config};
use controller_core::controller::Outputs;
use controller_core::localisation::separation::Report;
use controller_core::planning::checkpoint::Reached;
use controller_core::scalar::Scalar;
use controller_core::schedule::Tick;
use serde::Serialize;

use crate::contender::Contender;
use crate::geometry::Disc;
use crate::mission::{self, Mission, MissionOptions, MissionResult, SETTLE_MS};
use crate::random::seed_of_robot;
use crate::scenario::Scenario;
use crate::sil::{HostMap, Indirect, Sil};
use crate::statistics::{Rate, quantile};
use crate::sweep::{self, Maps, SweepError, SweepPlan};
use crate::world::World;

/// Time between two reports of a robot in ms: P2's target-reaching period.
pub const REPORT_PERIOD_MS: Tick = 256;
/// Time between two robots' reports, since they share one channel.
const REPORT_SHIFT_MS: Tick = 64;
/// Time from the measurement to the other robots, in ms.
const REPORT_LATENCY_MS: u16 = 20;

/// Whether robots know of each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Company {
    /// They tell each other where they are, and keep apart.
    Told,
    /// Only sensors see the others, as they see any obstacle.
    Silent,
}

/// A report on its way.
struct Sent<S> {
    /// When it arrives.
    due: Tick,
    from: usize,
    report: Report<S>,
}

/// A robot of the fleet.
struct Member<'a, S: Scalar> {
    mission: Mission<'a, Sil<S>>,
    /// What it meets: the scenario's world, and the others.
    world: World,
    /// The goal that it has reached, when in s, and the tick at which it has come to rest.
    arriving: Option<(Reached, f64, Tick)>,
    done: bool,
}

/// Runs a scenario of several robots, all with the same map and configuration; the result of each in its order.
///
/// # Errors
/// If the configuration cannot be used, or a controller refuses its checkpoints.
pub fn run<S: Scalar>(
    scenario: &Scenario,
    base: &Config,
    architecture: Option<Architecture>,
    map: &HostMap<S, Indirect<S>>,
    options: MissionOptions,
    company: Company,
) -> Result<Vec<MissionResult>, SweepError> {
    run_watched(scenario, base, architecture, map, (options, company), &mut |_, _, _, _| ())
}

/// Who looks on: hears of each robot, the tick, its controller after it and what that gave.
pub type Watch<'a, S> = dyn FnMut(usize, Tick, &Sil<S>, &Outputs<f32>) + 'a;

/// As [`run`], with someone who looks on.
///
/// # Errors
/// As [`run`].
pub fn run_watched<S: Scalar>(
    scenario: &Scenario,
    base: &Config,
    architecture: Option<Architecture>,
    map: &HostMap<S, Indirect<S>>,
    (options, company): (MissionOptions, Company),
    watch: &mut Watch<S>,
) -> Result<Vec<MissionResult>, SweepError> {
    let config = mission::config_for(scenario, base, architecture.map(Contender::from));
    let scenarios: Vec<Scenario> =
        (0..scenario.robot_count()).map(|robot| scenario.of_robot(robot)).collect();
    let seeds: Vec<u64> =
        (0_u64..).zip(&scenarios).map(|(robot, _)| seed_of_robot(options.seed, robot)).collect();
    let world = scenario.world.of_run(options.seed);
    let mut members = Vec::new();
    for (scenario, &seed) in scenarios.iter().zip(&seeds) {
        let controller = Sil::trained(&config, map.clone(), 0)?;
        let mission = Mission::begin(scenario, &world, controller, &config, seed)?;
        members.push(Member { mission, world: World::clone(&world), arriving: None, done: false });
    }
    let mut fleet = Fleet { members, sent: Vec::new(), company, sample_ms: options.sample_ms };
    while fleet.members.iter().any(|member| !member.done) && fleet.time_s() < scenario.time_limit_s {
        fleet.tick(watch)?;
    }
    let results = fleet.members.into_iter().zip(seeds);
    Ok(results.map(|(member, seed)| member.mission.result(seed, member.done)).collect())
}

/// Runs a scenario of several robots with each seed, in parallel; `progress` hears of every run that is done.
///
/// # Errors
/// That of the first run, in their order, that cannot begin.
pub fn run_all<S: Scalar>(
    scenario: &Scenario,
    base: &Config,
    architecture: Option<Architecture>,
    maps: &Maps<S, Indirect<S>>,
    (plan, company): (&SweepPlan, Company),
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<Vec<MissionResult>>, SweepError> {
    let run =
        |map: &HostMap<S, Indirect<S>>, options| run(scenario, base, architecture, map, options, company);
    sweep::for_all(maps, plan, progress, run)
}

/// The figures of many runs of several robots.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FleetSummary {
    /// Runs in which all robots passed every checkpoint within the scenario's tolerance, and none touched anything.
    pub success: Rate,
    /// Runs in which all robots reached their goals in time.
    pub arrived: Rate,
    /// Runs with a contact or more.
    pub contact: Rate,
    /// Median time until the last robot was at its goal, over the runs in which all arrived, in s.
    pub time_median_s: Option<f64>,
    /// 95th percentile of it, in s.
    pub time_95_s: Option<f64>,
    /// Median way of a robot over the straight ways between its checkpoints, over the same runs.
    pub way_median: Option<f64>,
}

/// Summarises runs of a scenario.
#[must_use]
pub fn summarise(scenario: &Scenario, runs: &[Vec<MissionResult>]) -> FleetSummary {
    let all = |run: &&Vec<MissionResult>| run.iter().all(|result| result.reached);
    let arrived = || runs.iter().filter(all);
    let last = |run: &Vec<MissionResult>| run.iter().map(|result| result.duration_s).fold(0.0, f64::max);
    let times: Vec<f64> = arrived().map(last).collect();
    let straight: Vec<f64> = (0..scenario.robot_count()).map(|robot| straight_m(scenario, robot)).collect();
    let ways: Vec<f64> = arrived()
        .flat_map(|run| run.iter().zip(&straight).map(|(result, straight)| result.way_m / straight))
        .collect();
    FleetSummary {
        success: Rate::of(runs.iter().map(|run| run.iter().all(|result| result.success))),
        arrived: Rate::of(runs.iter().map(|run| all(&run))),
        contact: Rate::of(runs.iter().map(|run| run.iter().any(|result| result.contacts > 0))),
        time_median_s: quantile(&times, 0.5),
        time_95_s: quantile(&times, 0.95),
        way_median: quantile(&ways, 0.5),
    }
}

/// Straight from the start through the checkpoints of a robot, in m.
fn straight_m(scenario: &Scenario, robot: usize) -> f64 {
    let scenario = scenario.of_robot(robot);
    let mut from = scenario.start.position;
    scenario.route.checkpoints().iter().map(|&to| (to - core::mem::replace(&mut from, to)).norm()).sum()
}

/// All robots of a run.
struct Fleet<'a, S: Scalar> {
    members: Vec<Member<'a, S>>,
    sent: Vec<Sent<S>>,
    company: Company,
    sample_ms: u64,
}

impl<'a, S: Scalar> Fleet<'a, S> {
    fn time_s(&self) -> f64 {
        self.members.first().map_or(f64::INFINITY, |member| member.mission.simulation.time_s())
    }

    fn tick(&mut self, watch: &mut Watch<S>) -> Result<(), SweepError> {
        let now = self.members.first().map_or(0, |member| member.mission.simulation.tick());
        if self.company == Company::Told {
            self.send(now);
            self.deliver(now);
        }
        let mut decided = Vec::with_capacity(self.members.len());
        for robot in 0..self.members.len() {
            let member = self.surrounded(robot);
            member.mission.replace_checkpoints()?;
            let Ok(outputs) = member.mission.simulation.decide_in(&member.world);
            watch(robot, now, &member.mission.simulation.controller, &outputs);
            decided.push(outputs);
        }
        let sample_ms = self.sample_ms;
        for (robot, outputs) in decided.iter().enumerate() {
            let member = self.surrounded(robot);
            member.mission.simulation.move_in(&member.world, outputs);
            // The log ends at the goal.
            member.mission.note(outputs, if member.arriving.is_some() { 0 } else { sample_ms });
            member.heed(outputs.reached);
        }
        Ok(())
    }

    /// A robot whose world holds the others where they are now.
    fn surrounded(&mut self, robot: usize) -> &mut Member<'a, S> {
        let bodies: Vec<Disc> = self.members.iter().map(|member| member.mission.simulation.body()).collect();
        let member = &mut self.members[robot];
        member.world.bodies.clear();
        let others = bodies.into_iter().enumerate().filter(|(other, _)| *other != robot);
        member.world.bodies.extend(others.map(|(_, body)| body));
        member
    }

    /// Whoever's turn it is tells where it is.
    fn send(&mut self, now: Tick) {
        let mut shift: Tick = 0;
        for (from, member) in self.members.iter().enumerate() {
            if (now + REPORT_PERIOD_MS - shift % REPORT_PERIOD_MS).is_multiple_of(REPORT_PERIOD_MS) {
                let sil = &member.mission.simulation.controller;
                let report = sil.controller.report(&sil.parameters, u8::try_from(from).unwrap_or(u8::MAX));
                let report = Report { age_ms: REPORT_LATENCY_MS, ..report };
                self.sent.push(Sent { due: now + Tick::from(REPORT_LATENCY_MS), from, report });
            }
            shift += REPORT_SHIFT_MS;
        }
    }

    /// What arrives now reaches all but the sender.
    fn deliver(&mut self, now: Tick) {
        let (due, sent): (Vec<_>, Vec<_>) =
            core::mem::take(&mut self.sent).into_iter().partition(|sent| sent.due <= now);
        self.sent = sent;
        for Sent { from, report, .. } in due {
            for (to, member) in self.members.iter_mut().enumerate() {
                if to != from {
                    member.mission.simulation.controller.hear(now, &report);
                }
            }
        }
    }
}

impl<S: Scalar> Member<'_, S> {
    /// Takes note of a checkpoint that was reached in the tick that has just been run; of the goal when the robot has
    /// come to rest.
    fn heed(&mut self, reached: Option<Reached>) {
        let (tick, t_s) = (self.mission.simulation.tick(), self.mission.simulation.time_s());
        match reached {
            Some(reached) if reached.is_goal => self.arriving = Some((reached, t_s, tick + SETTLE_MS)),
            Some(reached) => self.mission.arrive(reached, t_s),
            None => {}
        }
        if let Some((reached, t_s, rest)) = self.arriving
            && !self.done
            && tick >= rest
        {
            self.mission.arrive(reached, t_s);
            self.done = true;
        }
    }
}

#[cfg(test)]
mod tests;
