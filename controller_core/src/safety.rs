//! The last line before the motors: every drive passes [`Gate::check`], and what must not move, does not.
//!
//! | cause | ends |
//! | --- | --- |
//! | emergency stop | by [`Gate::release`], then armed anew: latched |
//! | not armed | by [`Gate::arm`] |
//! | nothing learnt | when the map has its first trained neuron |
//! | scan too old | with the next scan |
//! | command too old | with the next command |
//! | stalled | by itself after a second: the servo starts again from rest |
//! | link silent | with the next valid frame |
//! | deadline missed | after a second in which every task was in time |
//! | drive invalid | with the next drive that is a number within ±1 |

use crate::schedule::Tick;

/// Why the wheels stand still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "schema", derive(postcard_schema::Schema))]
pub enum StopCause {
    /// Someone asked for an emergency stop.
    EmergencyStop,
    /// Nobody has armed the motors.
    NotArmed,
    /// The robot is to navigate, but its map is untrained.
    UntrainedMap,
    /// The proximity sensors have been silent for too long.
    ScanTooOld,
    /// Integration has decided nothing for too long.
    CommandTooOld,
    /// A wheel did not follow its reference.
    Stalled,
    /// Nothing valid has come over the link for too long.
    LinkSilent,
    /// A task was not done when it was to begin again.
    DeadlineMissed,
    /// The servo's drive is no number within ±1.
    DriveInvalid,
}

/// What the gate looks at besides its own state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Conditions {
    /// Age and limit of the scan, where one is needed.
    pub scan_age_ms: Option<(Tick, u16)>,
    /// Age and limit of the command, where one is expected.
    pub command_age_ms: Option<(Tick, u16)>,
    /// The servo reports a stall.
    pub stalled: bool,
    /// What is noticed elsewhere.
    pub supervision: Supervision,
    /// The drive that is to be gated is no number within ±1.
    pub drive_invalid: bool,
}

/// What is noticed elsewhere: by the slow half, and by the firmware around the controller. Nothing is amiss by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Supervision {
    /// The map cannot say anything yet although it is asked.
    pub untrained: bool,
    /// Nothing valid has come over the link for longer than its limit.
    pub link_silent: bool,
    /// A task missed its deadline less than a second ago.
    pub deadline_missed: bool,
}

/// Armed or not, stopped or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gate {
    armed: bool,
    emergency: bool,
}

impl Gate {
    /// Lets the motors run, unless an emergency stop is latched.
    pub fn arm(&mut self) {
        self.armed = !self.emergency;
    }

    /// Cuts the motors until armed again.
    pub fn disarm(&mut self) {
        self.armed = false;
    }

    /// Cuts the motors and keeps them cut.
    pub fn emergency_stop(&mut self) {
        self.emergency = true;
        self.armed = false;
    }

    /// Ends an emergency stop; the motors stay cut until armed.
    pub fn release(&mut self) {
        self.emergency = false;
    }

    /// The motors may run.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.armed
    }

    /// An emergency stop is latched.
    #[must_use]
    pub fn is_emergency(&self) -> bool {
        self.emergency
    }

    /// Why the wheels must stand still, the gravest cause first; `None` lets them run.
    #[must_use]
    pub fn check(&self, conditions: &Conditions) -> Option<StopCause> {
        let too_old = |age: Option<(Tick, u16)>| age.is_some_and(|(age, limit)| age > Tick::from(limit));
        if self.emergency {
            Some(StopCause::EmergencyStop)
        } else if !self.armed {
            Some(StopCause::NotArmed)
        } else if conditions.drive_invalid {
            Some(StopCause::DriveInvalid)
        } else if conditions.supervision.link_silent {
            Some(StopCause::LinkSilent)
        } else if conditions.supervision.deadline_missed {
            Some(StopCause::DeadlineMissed)
        } else if conditions.supervision.untrained {
            Some(StopCause::UntrainedMap)
        } else if too_old(conditions.scan_age_ms) {
            Some(StopCause::ScanTooOld)
        } else if too_old(conditions.command_age_ms) {
            Some(StopCause::CommandTooOld)
        } else if conditions.stalled {
            Some(StopCause::Stalled)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Conditions, Gate, StopCause, Supervision};

    #[test]
    fn an_emergency_stop_is_latched() {
        let mut gate = Gate::default();
        let fine = Conditions::default();
        assert_eq!(gate.check(&fine), Some(StopCause::NotArmed));
        gate.arm();
        assert_eq!(gate.check(&fine), None);
        gate.emergency_stop();
        gate.arm();
        assert_eq!(gate.check(&fine), Some(StopCause::EmergencyStop), "arming does not end it");
        gate.release();
        assert_eq!(gate.check(&fine), Some(StopCause::NotArmed));
        gate.arm();
        assert_eq!(gate.check(&fine), None);
    }

    #[test]
    fn stale_inputs_stop_and_clear_by_themselves() {
        let mut gate = Gate::default();
        gate.arm();
        let scan = |age| Conditions { scan_age_ms: Some((age, 400)), ..Conditions::default() };
        assert_eq!(gate.check(&scan(401)), Some(StopCause::ScanTooOld));
        assert_eq!(gate.check(&scan(400)), None);
        let command = Conditions { command_age_ms: Some((401, 400)), stalled: true, ..Conditions::default() };
        assert_eq!(gate.check(&command), Some(StopCause::CommandTooOld));
        let silent = Supervision { link_silent: true, deadline_missed: true, untrained: true };
        let silent = Conditions { supervision: silent, ..Conditions::default() };
        assert_eq!(gate.check(&silent), Some(StopCause::LinkSilent));
        let late = Supervision { deadline_missed: true, ..Supervision::default() };
        let late = Conditions { supervision: late, ..Conditions::default() };
        assert_eq!(gate.check(&late), Some(StopCause::DeadlineMissed));
        let invalid = Conditions { drive_invalid: true, stalled: true, ..Conditions::default() };
        assert_eq!(gate.check(&invalid), Some(StopCause::DriveInvalid));
        let stalled = Conditions { stalled: true, ..Conditions::default() };
        assert_eq!(gate.check(&stalled), Some(StopCause::Stalled));
    }
}
