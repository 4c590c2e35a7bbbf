//! Figures over many runs: rates with their uncertainty, and quantiles.

use serde::Serialize;

/// 97.5 % quantile of the normal distribution: two-sided 95 %.
const Z_95: f64 = 1.959_963_984_540_054;

/// How often something happened in independent runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Rate {
    /// How often.
    pub count: u32,
    /// In how many runs.
    pub runs: u32,
}

impl Rate {
    /// Counts the runs for which it holds.
    pub fn of(outcomes: impl IntoIterator<Item = bool>) -> Self {
        let mut rate = Self { count: 0, runs: 0 };
        for happened in outcomes {
            rate.runs = rate.runs.saturating_add(1);
            rate.count = rate.count.saturating_add(u32::from(happened));
        }
        rate
    }

    /// The share, 0 to 1; 0 of no runs.
    #[must_use]
    pub fn share(self) -> f64 {
        f64::from(self.count) / f64::from(self.runs.max(1))
    }

    /// Wilson's 95 % interval of the true share.
    ///
    /// Chosen because rates here are near 0 or 1, where the textbook interval p ± 1.96 σ has no width.
    #[must_use]
    pub fn wilson_95(self) -> (f64, f64) {
        if self.runs == 0 {
            return (0.0, 1.0);
        }
        let (n, p) = (f64::from(self.runs), self.share());
        let z2 = Z_95 * Z_95;
        let centre = p + z2 / (2.0 * n);
        let half = Z_95 * libm::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n));
        let scale = 1.0 + z2 / n;
        (((centre - half) / scale).max(0.0), ((centre + half) / scale).min(1.0))
    }
}

/// 97.5 % quantiles of Student's t distribution for 1 to 30 degrees of freedom.
const T_95: [f64; 30] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
    2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
];

/// A mean with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Mean {
    /// The arithmetic mean; 0 of nothing.
    pub mean: f64,
    /// Half the width of Student's 95 % interval; infinite for a single value, which JSON shows as null.
    pub half_width_95: f64,
}

impl Mean {
    /// Of independent values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let values: Vec<f64> = values.into_iter().collect();
        let count = values.iter().map(|_| 1.0).sum::<f64>();
        let mean = values.iter().sum::<f64>() / count.max(1.0);
        let Some(freedom) = values.len().checked_sub(2) else {
            return Self { mean, half_width_95: f64::INFINITY };
        };
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let t = T_95.get(freedom).copied().unwrap_or(Z_95);
        Self { mean, half_width_95: t * libm::sqrt(squares / (count - 1.0) / count) }
    }
}

/// The value that a share `level` of the values does not exceed (nearest rank, so always one of the values); `None` of
/// no values.
#[must_use]
pub fn quantile(values: &[f64], level: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.iter().map(|_| 1.0).sum::<f64>();
    // Walking up the ranks needs no conversion between float and index.
    let mut rank = 0.0;
    for value in &sorted {
        rank += 1.0;
        if rank >= level * count {
            return Some(*value);
        }
    }
    sorted.last().copied()
}

#[cfg(test)]
mod tests {
    use super::{Mean, Rate, quantile};

    fn assert_interval(count: u32, runs: u32, expected: (f64, f64)) {
        let (low, high) = Rate { count, runs }.wilson_95();
        assert!((low - expected.0).abs() < 5e-5 && (high - expected.1).abs() < 5e-5, "{low} {high}");
    }

    #[test]
    fn wilson_intervals_agree_with_worked_examples() {
        // Worked out independently; 0 of 10 is z² / (10 + z²).
        assert_interval(0, 10, (0.0, 0.277_533));
        assert_interval(10, 10, (0.722_467, 1.0));
        assert_interval(95, 100, (0.888_250, 0.978_456));
        assert_interval(0, 0, (0.0, 1.0));
    }

    #[test]
    fn means_have_students_interval() {
        let mean = Mean::of([1.0, 2.0, 3.0, 4.0, 5.0]);
        // 2.776 · √2.5 / √5
        assert!((mean.mean - 3.0).abs() < 1e-12 && (mean.half_width_95 - 1.963).abs() < 1e-3, "{mean:?}");
        assert!(Mean::of([1.0]).half_width_95.is_infinite());
    }

    #[test]
    fn quantiles_are_values_that_occurred() {
        let values = [3.0, 1.0, 2.0, 5.0, 4.0];
        assert_eq!(quantile(&values, 0.5), Some(3.0));
        assert_eq!(quantile(&values, 0.95), Some(5.0));
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[f64::NAN, 1.0], 0.5), Some(1.0));
    }
}
