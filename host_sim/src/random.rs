//! Random numbers that mean the same for ever: one value-stable stream per seed and purpose.
//!
//! A run is (commit, seed, scenario). Each consumer of randomness has a stream of its own, so that an additional draw
//! of one, say a sensor more, does not shift all the others.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What a stream is for. The numbers are part of every run: never reuse one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Noise of the proximity sensors.
    Proximity = 1,
    /// Noise of the actuators.
    Slip = 2,
    /// Error of the pose fixes.
    PoseFix = 3,
    /// Where the robot starts.
    Start = 4,
    /// Exploration in training.
    Exploration = 5,
    /// Targets in training.
    TrainingTargets = 6,
    /// Targets in the positioning test.
    TestTargets = 7,
    /// Candidates of a search for parameters.
    Search = 8,
    /// Readings that are missing.
    Dropout = 9,
    /// Where movers begin their circles.
    Movers = 10,
    /// How late the slow tasks are.
    Lateness = 11,
    /// Starts and goals on maps of [`crate::benchmark`].
    BenchmarkPlaces = 20,
}

/// The seed of one robot of several; that of the first is the run's own.
#[must_use]
pub const fn seed_of_robot(seed: u64, robot: u64) -> u64 {
    if robot == 0 { seed } else { mix(seed) ^ mix(robot.wrapping_mul(0xD1B5_4A32_D192_ED03)) }
}

/// A stream of random numbers.
#[derive(Debug, Clone)]
pub struct Stream(Pcg64Mcg);

impl Stream {
    /// The stream of a seed for a purpose.
    #[must_use]
    pub fn new(seed: u64, purpose: Purpose) -> Self {
        // Two rounds of SplitMix64's finaliser keep neighbouring seeds and purposes apart.
        let purpose = purpose as u64;
        Self(Pcg64Mcg::seed_from_u64(mix(mix(seed) ^ purpose.wrapping_mul(0x9E37_79B9_7F4A_7C15))))
    }

    /// Uniform in ±1, with 53 bits.
    pub fn symmetric(&mut self) -> f64 {
        // The upper 53 bits as an integer are exact in f64.
        let bits = self.0.next_u64() >> 11;
        let (high, low) = ((bits >> 32) & 0xFFFF_FFFF, bits & 0xFFFF_FFFF);
        let narrow = |part: u64| f64::from(u32::try_from(part).unwrap_or(u32::MAX));
        let unit = (narrow(high) * 4_294_967_296.0 + narrow(low)) / 9_007_199_254_740_992.0;
        2.0 * unit - 1.0
    }

    /// Uniform between two bounds.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::midpoint(self.symmetric(), 1.0)
    }

    /// A whole number below `count`, uniform for all counts that occur; 0 of none.
    pub fn below(&mut self, count: usize) -> usize {
        // What 64 bits leave of a bias cannot be measured.
        let draw = self.0.next_u64() % u64::try_from(count.max(1)).unwrap_or(u64::MAX);
        usize::try_from(draw).unwrap_or(0)
    }

    /// A point of the unit disc, uniform.
    pub fn in_unit_disc(&mut self) -> (f64, f64) {
        // Rejection needs 1.3 pairs on average and no trigonometry; the bound is for form's sake.
        for _ in 0..64 {
            let (x, y) = (self.symmetric(), self.symmetric());
            if x * x + y * y <= 1.0 {
                return (x, y);
            }
        }
        (0.0, 0.0)
    }
}

/// `SplitMix64`'s finaliser.
const fn mix(value: u64) -> u64 {
    let z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::{Purpose, Stream};

    #[test]
    fn streams_are_stable_uniform_and_apart() {
        let mut stream = Stream::new(1, Purpose::Slip);
        let first = stream.symmetric();
        assert!((first - Stream::new(1, Purpose::Slip).symmetric()).abs() < f64::EPSILON);
        assert!((first - Stream::new(1, Purpose::Start).symmetric()).abs() > 1e-6);
        assert!((first - Stream::new(2, Purpose::Slip).symmetric()).abs() > 1e-6);
        let draws: Vec<f64> = (0..10_000).map(|_| stream.symmetric()).collect();
        let mean = draws.iter().sum::<f64>() / 10_000.0;
        let variance = draws.iter().map(|x| x * x).sum::<f64>() / 10_000.0;
        assert!(mean.abs() < 0.02, "mean {mean}");
        assert!((variance - 1.0 / 3.0).abs() < 0.01, "variance {variance}");
        assert!(draws.iter().all(|x| (-1.0..1.0).contains(x)));
    }
}
