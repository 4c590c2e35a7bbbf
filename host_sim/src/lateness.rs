//! Slow tasks that run late: on a busy processor avoidance and target reaching are ready some time after their release.
//!
//! A task works on the moment that was latched at its release, scan and pose; what is late is its answer, and until
//! then the last one stands. That is what preemption does on a board, where `firmware` says who interrupts whom.

use controller_core::schedule::{Schedule, Tick};

use crate::random::{Purpose, Stream};

/// A task that takes longer would still be at work when it is released again.
pub const LATENESS_MAX_MS: u16 = 127;

/// Draws how late the slow tasks are.
#[derive(Debug, Clone)]
pub struct Lateness {
    stream: Stream,
    most_ms: u16,
    avoidance: Option<Tick>,
    target: Option<Tick>,
}

/// The slow tasks that have their answer in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Finished {
    /// Obstacle avoidance.
    pub avoidance: bool,
    /// Target reaching.
    pub target: bool,
}

impl Lateness {
    /// Tasks that are late by 0 to `most_ms`, uniformly and each time anew; `None` if nothing is ever late.
    #[must_use]
    pub fn new(most_ms: u16, seed: u64) -> Option<Self> {
        let stream = Stream::new(seed, Purpose::Lateness);
        (most_ms > 0).then(|| Self {
            stream,
            most_ms: most_ms.min(LATENESS_MAX_MS),
            avoidance: None,
            target: None,
        })
    }

    /// Which tasks are ready in this tick, which must be the one after the last that was asked about.
    pub fn at(&mut self, schedule: Schedule, tick: Tick) -> Finished {
        let released = schedule.at(tick);
        if released.avoidance {
            self.avoidance = Some(tick + self.draw());
        }
        if released.target {
            // It has the lower priority, so that avoidance comes first.
            let ready = tick + self.draw();
            self.target = Some(self.avoidance.map_or(ready, |avoidance| avoidance.max(ready)));
        }
        let is_due = |due: &mut Option<Tick>| due.take_if(|due| *due <= tick).is_some();
        Finished { avoidance: is_due(&mut self.avoidance), target: is_due(&mut self.target) }
    }

    fn draw(&mut self) -> Tick {
        let choices = usize::from(self.most_ms) + 1;
        Tick::try_from(self.stream.below(choices)).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use controller_core::schedule::Schedule;

    use super::{LATENESS_MAX_MS, Lateness};

    const SCHEDULE: Schedule = Schedule { avoidance_period_ms: 128, target_period_ms: 256, step_ms: 1024 };

    #[test]
    fn every_release_is_answered_once_before_the_next() {
        let mut late = Lateness::new(u16::MAX, 3).unwrap();
        let (mut avoidance, mut target) = (Vec::new(), Vec::new());
        for tick in 0..128_000 {
            let finished = late.at(SCHEDULE, tick);
            avoidance.extend(finished.avoidance.then_some(tick));
            target.extend(finished.target.then_some(tick));
        }
        assert_eq!((avoidance.len(), target.len()), (1000, 500));
        assert!((0..).zip(&avoidance).all(|(release, at)| at / 128 == release), "each within its period");
        let most = avoidance.iter().map(|at| at % 128).max().unwrap();
        let mean = avoidance.iter().map(|at| at % 128).sum::<u64>() / 1000;
        assert!(most == u64::from(LATENESS_MAX_MS) && (60..=67).contains(&mean), "{most} {mean}");
        // The lower priority waits for the higher one.
        assert!(
            target.iter().zip(avoidance.iter().step_by(2)).all(|(target, avoidance)| target >= avoidance)
        );
    }

    #[test]
    fn nothing_is_late_by_default() {
        assert!(Lateness::new(0, 1).is_none());
        let of = |seed| {
            let mut late = Lateness::new(50, seed).unwrap();
            (0..2048).map(move |tick| late.at(SCHEDULE, tick)).collect::<Vec<_>>()
        };
        assert_eq!(of(1), of(1));
        assert_ne!(of(1), of(2));
    }
}
