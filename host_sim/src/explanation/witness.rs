//! A controller that is watched: it drives as always, and what it decides at one moment is explained.

use core::convert::Infallible;

use controller_core::config::{Architecture, Config};
use controller_core::controller::{Inputs, Outputs};
use controller_core::scalar::Scalar;
use controller_core::schedule::{Schedule, Tick};

use super::{Explanation, Standing, decision_of, drives, wheels};
use crate::contender::Contender;
use crate::fleet::{self, Company};
use crate::mission::{self, MissionOptions, MissionResult};
use crate::proximity_model::SENSORS;
use crate::scenario::Scenario;
use crate::sil::{Answer, ControllerPort, HostMap, Indirect, Order, Sil};
use crate::simulation::seconds;
use crate::sweep::SweepError;

/// Why there is nothing to explain.
#[derive(Debug, thiserror::Error)]
pub enum ExplainError {
    /// The run cannot begin.
    #[error(transparent)]
    Run(#[from] SweepError),
    /// The run was over by then.
    #[error(
        "tick {tick} is behind the end of the run, which has {ticks} ticks of 1 ms; ask for an earlier one"
    )]
    Over {
        /// What was asked for.
        tick: Tick,
        /// Ticks of the run.
        ticks: Tick,
    },
}

/// What is waited for.
struct Observation {
    /// The tick that is asked for.
    at: Tick,
    /// The tick of the decision that stands then.
    decided: Tick,
    explanation: Option<Explanation>,
    ticks: Tick,
}

impl Observation {
    fn new(schedule: Schedule, at: Tick) -> Self {
        let is_release = |&tick: &Tick| schedule.at(tick).avoidance || schedule.at(tick).target;
        // Both are released at tick 0.
        let decided = (0..=at).rev().find(is_release).unwrap_or_default();
        Self { at, decided, explanation: None, ticks: 0 }
    }

    /// Looks at a controller that has just run a tick.
    fn heed<S: Scalar>(&mut self, sil: &Sil<S>, now: Tick, outputs: &Outputs<f32>) {
        self.ticks = now + 1;
        if now != self.decided && now != self.at {
            return;
        }
        let standing = Standing {
            tick: now,
            command: wheels(outputs.command.value),
            command_age_ms: outputs.command.age_ms(now),
            armed: sil.controller.reflex.gate.is_armed(),
            stopped: outputs.stopped,
            drive: drives(outputs.drive),
        };
        if now == self.decided {
            self.explanation = Some(Explanation { standing, decision: decision_of(sil, now) });
        }
        if let Some(explanation) = &mut self.explanation {
            explanation.standing = standing;
        }
    }

    fn explanation(self) -> Result<Explanation, ExplainError> {
        let (tick, ticks) = (self.at, self.ticks);
        self.explanation.filter(|_| tick < ticks).ok_or(ExplainError::Over { tick, ticks })
    }
}

/// The core in this process, watched.
struct Witness<S: Scalar> {
    sil: Sil<S>,
    observation: Observation,
}

impl<S: Scalar> ControllerPort for Witness<S> {
    type Error = Infallible;

    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Result<Outputs<f32>, Infallible> {
        let outputs = self.sil.step(now, inputs)?;
        self.observation.heed(&self.sil, now, &outputs);
        Ok(outputs)
    }

    fn schedule(&self) -> Schedule {
        self.sil.schedule()
    }

    fn order(&mut self, order: Order<'_>) -> Result<Answer, Infallible> {
        self.sil.order(order)
    }

    fn hash(&self) -> u64 {
        self.sil.hash()
    }
}

/// Runs a scenario and explains the command that stands at a tick; what became of the run is given as well.
///
/// # Errors
/// If the run cannot begin, or was over by then.
pub fn explain<S: Scalar>(
    scenario: &Scenario,
    base: &Config,
    architecture: Option<Architecture>,
    map: &HostMap<S, Indirect<S>>,
    options: MissionOptions,
    tick: Tick,
) -> Result<(Explanation, MissionResult), ExplainError> {
    let config = mission::config_for(scenario, base, architecture.map(Contender::from));
    let sil = Sil::<S>::trained(&config, map.clone(), 0).map_err(SweepError::from)?;
    let observation = Observation::new(sil.schedule(), tick);
    let mut witness = Witness { sil, observation };
    let result = mission::run(scenario, &mut witness, &config, options).map_err(SweepError::from)?;
    Ok((witness.observation.explanation()?, result))
}

/// As [`explain`], for one of several robots in one world, counted from 0.
///
/// # Errors
/// As [`explain`].
pub fn explain_in_fleet<S: Scalar>(
    scenario: &Scenario,
    base: &Config,
    architecture: Option<Architecture>,
    map: &HostMap<S, Indirect<S>>,
    options: MissionOptions,
    (robot, tick): (usize, Tick),
) -> Result<(Explanation, MissionResult), ExplainError> {
    let config = mission::config_for(scenario, base, architecture.map(Contender::from));
    let schedule = Sil::<S>::untrained(&config).map_err(SweepError::from)?.schedule();
    let mut observation = Observation::new(schedule, tick);
    let mut watch = |who, now, sil: &Sil<S>, outputs: &Outputs<f32>| {
        if who == robot {
            observation.heed(sil, now, outputs);
        }
    };
    let results =
        fleet::run_watched(scenario, base, architecture, map, (options, Company::Told), &mut watch)?;
    let over = ExplainError::Over { tick, ticks: observation.ticks };
    let result = results.into_iter().nth(robot).ok_or(over)?;
    Ok((observation.explanation()?, result))
}

impl Explanation {
    /// When the command was decided, in s.
    #[must_use]
    pub fn decided_s(&self) -> f64 {
        seconds(self.decision.tick)
    }
}
