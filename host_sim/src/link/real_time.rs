//! A board that runs on its own clock, with the simulator keeping up.
//!
//! The board computes a tick each millisecond and says what it led to. The simulated world is moved on to that tick,
//! and its readings are sent back, where the board's next tick takes them. If the host comes late the world catches up
//! on what it missed with the drive that stood; if it is early it waits. Such a run does not repeat bit for bit.

use core::time::Duration;
use std::collections::VecDeque;

use controller_core::config::Config;
use controller_core::controller::{Inputs, Outputs};
use controller_core::planning::checkpoint::Reached;
use controller_core::schedule::{Schedule, Tick};
use protocol::message::{FaultReport, FromBoard, FromHost, Outputs as WireOutputs, Readings};

use super::client::unexpected;
use super::error::LinkError;
use super::port::{outputs_of, schedule_of, send_order};
use super::session::Session;
use super::transport::Transport;
use crate::proximity_model::SENSORS;
use crate::sil::{Answer, ControllerPort, Order};

/// Without a word from the board the readings are sent again after so long: well before it thinks the host is gone.
const REPEAT: Duration = Duration::from_millis(20);

/// Every so many readings, the board is asked whether it has taken them …
const PROBE_EVERY: u32 = 8;

/// … and as long as it has not, no more than so many are sent. A line that is slower than a frame a millisecond would
/// else fill with readings that are old when they arrive.
const UNCONFIRMED_MAX: u32 = 16;

/// How well the two kept up with each other.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Pace {
    /// Outputs received.
    pub outputs: u64,
    /// Ticks of which no outputs came.
    pub missed: u64,
    /// Times that readings were held back because the board had not taken those before.
    pub held: u64,
    /// Most ticks that the world had to catch up at once.
    pub behind_ticks_max: u64,
    /// Stops that the board reported.
    pub faults: Vec<FaultReport>,
}

/// A board on its own clock.
#[derive(Debug)]
pub struct RealTimePort<'a, T> {
    session: &'a mut Session<T>,
    schedule: Schedule,
    /// What came last from the board.
    latest: Option<WireOutputs>,
    /// Checkpoints that were reached in ticks the world has not come to.
    reached: VecDeque<Reached>,
    /// What the board has not been sent yet.
    readings: Readings,
    /// Readings sent since the last probe.
    unconfirmed: u32,
    pace: Pace,
}

impl<'a, T: Transport> RealTimePort<'a, T> {
    /// Begins a run on a board whose session is one in real time, that has been configured, and has the map it is to
    /// drive with; `config` is its configuration.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn begin(session: &'a mut Session<T>, config: &Config) -> Result<Self, LinkError> {
        session.begin()?;
        // All of it is of ticks before this run.
        session.client.forget_unasked();
        Ok(Self {
            session,
            schedule: schedule_of(config),
            latest: None,
            reached: VecDeque::new(),
            readings: Readings::default(),
            unconfirmed: 0,
            pace: Pace::default(),
        })
    }

    /// How well the two keep up.
    #[must_use]
    pub fn pace(&self) -> &Pace {
        &self.pace
    }

    fn latest_tick(&self) -> Option<Tick> {
        self.latest.map(|latest| latest.tick)
    }

    /// Adds readings to what is to be sent; what is rare stays until it is.
    fn gather(&mut self, inputs: &Inputs<f32, SENSORS>) {
        let new = Readings::from_inputs(self.latest_tick().unwrap_or(0), inputs);
        let old = self.readings;
        self.readings = Readings {
            pose_fix: new.pose_fix.or(old.pose_fix),
            scan: new.scan.or(old.scan),
            exploration: new.exploration.or(old.exploration),
            ..new
        };
    }

    /// Sends the readings, unless the line is full: then they are gathered further.
    fn tell(&mut self) -> Result<(), LinkError> {
        let client = &mut self.session.client;
        if client.is_probing() && self.unconfirmed >= UNCONFIRMED_MAX {
            self.pace.held += 1;
            return Ok(());
        }
        client.tell(&FromHost::Sense(self.readings))?;
        // Encoders count on; pose, scan and draws are sent once.
        self.readings =
            Readings { tick: self.readings.tick, encoders: self.readings.encoders, ..Readings::default() };
        self.unconfirmed += 1;
        if self.unconfirmed >= PROBE_EVERY && !client.is_probing() {
            client.probe()?;
            self.unconfirmed = 0;
        }
        Ok(())
    }

    fn hear(&mut self, patience: Duration) -> Result<bool, LinkError> {
        match self.session.client.listen(patience)? {
            None => Ok(false),
            Some(FromBoard::Outputs(outputs)) => {
                let last = self.latest_tick();
                self.pace.outputs += 1;
                self.pace.missed += outputs.tick.saturating_sub(last.map_or(0, |last| last + 1));
                self.reached.extend(outputs.reached);
                self.latest = Some(outputs);
                Ok(true)
            }
            Some(FromBoard::Fault(fault)) => {
                self.pace.faults.push(fault);
                Ok(true)
            }
            Some(other) => Err(unexpected("outputs", &other)),
        }
    }

    /// Waits until the board has come to a tick.
    fn wait_for(&mut self, now: Tick) -> Result<(), LinkError> {
        self.tell()?;
        let mut waited = Duration::ZERO;
        loop {
            if self.hear(REPEAT)? {
                if self.latest_tick().is_some_and(|tick| tick >= now) {
                    break;
                }
                continue;
            }
            waited += REPEAT;
            if waited >= self.session.client.transport_mut().answer_max() {
                return Err(LinkError::Silent { request: "outputs in real time", waited });
            }
            self.tell()?;
        }
        // What has come with it: the world has to catch up on that.
        while self.hear(Duration::ZERO)? {}
        let behind = self.latest_tick().unwrap_or(now).saturating_sub(now);
        self.pace.behind_ticks_max = self.pace.behind_ticks_max.max(behind);
        Ok(())
    }
}

impl<T: Transport> ControllerPort for RealTimePort<'_, T> {
    type Error = LinkError;

    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Result<Outputs<f32>, LinkError> {
        self.gather(inputs);
        if self.latest_tick().is_none_or(|tick| tick < now) {
            self.wait_for(now)?;
        }
        let latest = self.latest.unwrap_or_default();
        Ok(Outputs {
            reached: self.reached.pop_front(),
            released: self.schedule.at(now),
            ..outputs_of(&latest, &self.schedule)
        })
    }

    fn schedule(&self) -> Schedule {
        self.schedule
    }

    fn order(&mut self, order: Order<'_>) -> Result<Answer, LinkError> {
        send_order(&mut self.session.client, order)
    }

    /// Digest of the last outputs; it depends on when the host's readings came.
    fn hash(&self) -> u64 {
        self.latest.map_or(0, |latest| latest.state_digest)
    }
}
