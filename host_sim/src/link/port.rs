//! A board in lockstep as a controller that the simulator can drive: one step, one tick.

use controller_core::config::{Config, ScheduleConfig};
use controller_core::controller::{Inputs, Outputs};
use controller_core::schedule::{Schedule, Stamped, Tick};
use controller_core::state_hash::StateHash;
use controller_core::units::Point;
use protocol::message::{
    CHECKPOINTS_PER_MESSAGE, Checkpoints, FromBoard, FromHost, Outputs as WireOutputs, Readings, Refusal,
};

use super::client::{Client, unexpected};
use super::error::LinkError;
use super::session::Session;
use super::transport::Transport;
use crate::proximity_model::SENSORS;
use crate::sil::{Answer, ControllerPort, Order};

/// A board in lockstep.
#[derive(Debug)]
pub struct LinkPort<'a, T> {
    session: &'a mut Session<T>,
    schedule: Schedule,
    digest: u64,
}

impl<'a, T: Transport> LinkPort<'a, T> {
    /// Begins a run on a board that has been configured, and has the map it is to drive with; `config` is its
    /// configuration.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn begin(session: &'a mut Session<T>, config: &Config) -> Result<Self, LinkError> {
        session.begin()?;
        Ok(Self { session, schedule: schedule_of(config), digest: StateHash::default().value() })
    }

    /// The session, for what a run does not ask for.
    pub fn session_mut(&mut self) -> &mut Session<T> {
        self.session
    }
}

impl<T: Transport> ControllerPort for LinkPort<'_, T> {
    type Error = LinkError;

    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Result<Outputs<f32>, LinkError> {
        match self.session.client.request(&FromHost::Step(Readings::from_inputs(now, inputs)))? {
            FromBoard::Outputs(outputs) if outputs.tick == now => {
                self.digest = outputs.state_digest;
                Ok(outputs_of(&outputs, &self.schedule))
            }
            other => Err(unexpected("a step", &other)),
        }
    }

    fn schedule(&self) -> Schedule {
        self.schedule
    }

    fn order(&mut self, order: Order<'_>) -> Result<Answer, LinkError> {
        send_order(&mut self.session.client, order)
    }

    fn hash(&self) -> u64 {
        self.digest
    }
}

/// When a controller with this configuration reads what.
pub(crate) fn schedule_of(config: &Config) -> Schedule {
    let ScheduleConfig { avoidance_period_ms, target_period_ms, step_ms, .. } = config.schedule;
    Schedule { avoidance_period_ms, target_period_ms, step_ms }
}

/// What a tick led to, as the core says it. What was released follows from the tick.
pub(crate) fn outputs_of(outputs: &WireOutputs, schedule: &Schedule) -> Outputs<f32> {
    Outputs {
        drive: outputs.wheel_drive,
        command: Stamped { value: outputs.wheel_speed_command, renewed: outputs.commanded_at_tick },
        reached: outputs.reached,
        stopped: outputs.stopped,
        released: schedule.at(outputs.tick),
    }
}

/// Has an order carried out.
pub(crate) fn send_order<T: Transport>(
    client: &mut Client<T>,
    order: Order<'_>,
) -> Result<Answer, LinkError> {
    match order {
        Order::Mode { mode, .. } => client.command(&FromHost::Mode(mode)).map(Ok),
        Order::Arm => client.command(&FromHost::Arm).map(Ok),
        Order::Checkpoints(checkpoints) => send_checkpoints(client, checkpoints),
        Order::Append(checkpoints) => {
            send_parts(client, checkpoints.chunks(CHECKPOINTS_PER_MESSAGE).map(appended))
        }
        Order::Checkpoint { number, at } => {
            // No list is longer than a byte counts; a number beyond is refused as the largest.
            let index = u8::try_from(number).unwrap_or(u8::MAX);
            answer_to(client, Checkpoints::ReplaceOne { index, point: at })
        }
    }
}

/// Replaces all checkpoints; more than one message holds are sent in parts.
fn send_checkpoints<T: Transport>(
    client: &mut Client<T>,
    checkpoints: &[Point<f32>],
) -> Result<Answer, LinkError> {
    let mut parts = checkpoints.chunks(CHECKPOINTS_PER_MESSAGE);
    let first = match parts.next() {
        Some(part) => Checkpoints::ReplaceAll(part.iter().copied().collect()),
        None => Checkpoints::Clear,
    };
    send_parts(client, core::iter::once(first).chain(parts.map(appended)))
}

fn appended(part: &[Point<f32>]) -> Checkpoints {
    Checkpoints::Append(part.iter().copied().collect())
}

/// Sends changes in turn, up to the first that is refused.
fn send_parts<T: Transport>(
    client: &mut Client<T>,
    changes: impl Iterator<Item = Checkpoints>,
) -> Result<Answer, LinkError> {
    for change in changes {
        if let refused @ Err(_) = answer_to(client, change)? {
            return Ok(refused);
        }
    }
    Ok(Ok(()))
}

fn answer_to<T: Transport>(client: &mut Client<T>, change: Checkpoints) -> Result<Answer, LinkError> {
    match client.request(&FromHost::Checkpoints(change))? {
        FromBoard::Done => Ok(Ok(())),
        FromBoard::Refused(Refusal::Checkpoints(error)) => Ok(Err(error)),
        other => Err(unexpected("new checkpoints", &other)),
    }
}
