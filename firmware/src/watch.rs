//! Keeps an eye on the tasks: what was released, what is late, how long it takes.

use protocol::endpoint::LINK_SILENT_MS;
use protocol::message::{Health, TaskCounts};

/// After a missed deadline the motors rest for so many ticks without another.
const HOLD_TICKS: u32 = 1000;

const _: () =
    assert!(LINK_SILENT_MS < 1000, "whoever is silent is stopped before a missed deadline is forgotten");

/// One task.
#[derive(Clone, Copy, Debug, Default)]
pub struct TaskWatch {
    releases: u32,
    missed: u32,
    response_us_max: u32,
    released_us: u32,
    /// Released and not done.
    is_busy: bool,
}

impl TaskWatch {
    /// The task is to run. `false` if the job before is not done yet: its deadline is missed, and this one is left out.
    pub fn release(&mut self, now_us: u32) -> bool {
        self.releases = self.releases.wrapping_add(1);
        if self.is_busy {
            self.missed = self.missed.wrapping_add(1);
            return false;
        }
        self.is_busy = true;
        self.released_us = now_us;
        true
    }

    /// The job is done.
    pub fn done(&mut self, now_us: u32) {
        self.is_busy = false;
        self.response_us_max = self.response_us_max.max(now_us.wrapping_sub(self.released_us));
    }
}

/// All tasks with a period, and the link.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    /// Homeostatic control.
    pub servo: TaskWatch,
    /// Obstacle avoidance.
    pub avoidance: TaskWatch,
    /// Target reaching.
    pub target: TaskWatch,
    /// The board advances the tick.
    pub is_real_time: bool,
    /// Requests lost because another was still being answered.
    pub requests_dropped: u32,
    started_us: Option<u32>,
    period_us: Option<(u32, u32)>,
    readings_age_ms_max: u32,
    /// Rest of the time for which a missed deadline stops the motors.
    hold_ticks: u32,
    missed_before: u32,
}

impl Watch {
    /// A session in real time begins: what was measured across the pause between two means nothing.
    pub fn begin_real_time(&mut self) {
        self.started_us = None;
        self.hold_ticks = 0;
        self.is_real_time = true;
    }

    /// The servo begins its tick.
    pub fn servo_begins(&mut self, now_us: u32, readings_age_ms: u64) {
        if let Some(before_us) = self.started_us.replace(now_us) {
            let period_us = now_us.wrapping_sub(before_us);
            let (min, max) = self.period_us.unwrap_or((period_us, period_us));
            self.period_us = Some((min.min(period_us), max.max(period_us)));
        }
        self.servo.release(now_us);
        let age_ms = u32::try_from(readings_age_ms).unwrap_or(u32::MAX);
        self.readings_age_ms_max = self.readings_age_ms_max.max(age_ms);
    }

    /// The servo has ended its tick; `overran` if the next was due meanwhile.
    pub fn servo_ends(&mut self, now_us: u32, overran: bool) {
        self.servo.done(now_us);
        if overran {
            self.servo.missed = self.servo.missed.wrapping_add(1);
        }
    }

    /// Whether a deadline was missed less than a second ago; to be asked once each tick. `true` in the second place if
    /// one has been missed since the last time.
    pub fn missed_recently(&mut self) -> (bool, bool) {
        let missed = self.servo.missed.wrapping_add(self.avoidance.missed).wrapping_add(self.target.missed);
        let is_new = missed != self.missed_before;
        self.missed_before = missed;
        self.hold_ticks = if is_new { HOLD_TICKS } else { self.hold_ticks.saturating_sub(1) };
        (self.hold_ticks > 0, is_new)
    }

    /// Every job that was released is done or still within its time; the watchdog may be fed.
    #[must_use]
    pub fn all_in_time(&self) -> bool {
        self.hold_ticks == 0 || !(self.avoidance.is_busy || self.target.is_busy)
    }

    /// What the host gets to see.
    #[must_use]
    pub fn health(&self) -> Health {
        let counts = |of: fn(&TaskWatch) -> u32| TaskCounts {
            servo: of(&self.servo),
            avoidance: of(&self.avoidance),
            target: of(&self.target),
        };
        let (servo_period_us_min, servo_period_us_max) = self.period_us.unwrap_or_default();
        Health {
            requests_dropped: self.requests_dropped,
            deadlines_missed: counts(|task| task.missed),
            releases: counts(|task| task.releases),
            response_us_max: counts(|task| task.response_us_max),
            servo_period_us_min,
            servo_period_us_max,
            readings_age_ms_max: self.readings_age_ms_max,
            ..Health::default()
        }
    }
}
