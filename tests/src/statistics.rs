//! Means and order statistics of small samples.

/// How many, as `f64`.
///
/// # Panics
/// If there are more than 2³² − 1.
#[must_use]
pub fn count<T>(sample: &[T]) -> f64 {
    f64::from(u32::try_from(sample.len()).expect("tests draw small samples"))
}

/// Arithmetic mean.
#[must_use]
pub fn mean(sample: &[f64]) -> f64 {
    sample.iter().sum::<f64>() / count(sample)
}

/// Largest value; −∞ of nothing.
#[must_use]
pub fn largest(sample: &[f64]) -> f64 {
    sample.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The value below which `hundredths` % of the sample lie (nearest rank).
///
/// # Panics
/// If the sample is empty.
#[must_use]
pub fn percentile(sample: &[f64], hundredths: usize) -> f64 {
    let mut sorted = sample.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (sorted.len() * hundredths).div_ceil(100).max(1);
    sorted[rank - 1]
}
