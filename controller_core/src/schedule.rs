//! What each millisecond releases.
//!
//! | module | period | priority on the target |
//! | --- | --- | --- |
//! | homeostatic control ([`crate::servo`]) | 1 ms | highest |
//! | obstacle avoidance | 128 ms | |
//! | target reaching | 256 ms (P2), 1024 ms (P1) | lowest |
//! | integration | when either of the two has renewed its part | with the one that renewed |
//! | planning | when asked | background |
//!
//! Within one tick the order is fixed, so that a run means the same on every platform: pose fix, servo and odometry,
//! arrival at checkpoints, avoidance, target reaching, integration. What integration decides acts from the next tick.

/// Milliseconds since start, simulated or real.
pub type Tick = u64;

/// The periods of the modules, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Obstacle avoidance (both papers: 128).
    pub avoidance_period_ms: u16,
    /// Target reaching (P1: 1024, P2: 256); a multiple of the avoidance period.
    pub target_period_ms: u16,
    /// One step of the map: the time after which a command has taken the robot to the place it stands for; a multiple
    /// of the avoidance period.
    pub step_ms: u16,
}

/// What a tick releases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Release {
    /// Obstacle avoidance.
    pub avoidance: bool,
    /// Target reaching.
    pub target: bool,
    /// A training step ends and the next begins.
    pub step: bool,
}

impl Schedule {
    /// What is released at a tick; tick 0 releases everything.
    #[must_use]
    pub fn at(&self, tick: Tick) -> Release {
        // All periods are multiples of the shortest, so most ticks are settled by one division; and in 32 bits, since
        // 64 are hundreds of instructions on a Cortex-M.
        let due = |period_ms: u16| match u32::try_from(tick) {
            Ok(tick) => tick.is_multiple_of(u32::from(period_ms.max(1))),
            Err(_) => tick.is_multiple_of(Tick::from(period_ms.max(1))),
        };
        if !due(self.avoidance_period_ms) {
            return Release::default();
        }
        Release { avoidance: true, target: due(self.target_period_ms), step: due(self.step_ms) }
    }
}

/// A value with the tick at which it was renewed: every output carries its age.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stamped<T> {
    /// The value, standing until renewed.
    pub value: T,
    /// When it was renewed.
    pub renewed: Tick,
}

impl<T> Stamped<T> {
    /// A value renewed now.
    pub fn new(value: T, now: Tick) -> Self {
        Self { value, renewed: now }
    }

    /// Milliseconds since it was renewed.
    #[must_use]
    pub fn age_ms(&self, now: Tick) -> Tick {
        now.saturating_sub(self.renewed)
    }
}

#[cfg(test)]
mod tests {
    use super::{Release, Schedule, Stamped, Tick};

    #[test]
    fn releases_follow_the_periods() {
        let schedule = Schedule { avoidance_period_ms: 128, target_period_ms: 256, step_ms: 1024 };
        let released = |tick| schedule.at(tick);
        assert_eq!(released(0), Release { avoidance: true, target: true, step: true });
        assert_eq!(released(127), Release::default());
        assert_eq!(released(128), Release { avoidance: true, target: false, step: false });
        assert_eq!(released(256), Release { avoidance: true, target: true, step: false });
        assert_eq!((0..10_240).filter(|&t| schedule.at(t).step).count(), 10);
        let later = Tick::from(u32::MAX) + 1;
        assert!(schedule.at(later).step && !schedule.at(later + 1).avoidance, "after 50 days");
    }

    #[test]
    fn values_age() {
        let value = Stamped::new(7, 100);
        assert_eq!((value.age_ms(100), value.age_ms(356), value.age_ms(5)), (0, 256, 0));
    }
}
