//! The lattice of the neurons and the neighbourhood `G(k, i)` on it (P1 Eq. 7, P2 Eq. 11).

use crate::scalar::Scalar;

/// Which neuron: its column (bearing) and row (distance) on the lattice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NeuronIndex {
    /// Column, along the bearing.
    pub column: u8,
    /// Row, along the distance.
    pub row: u8,
}

impl NeuronIndex {
    /// The index of a lattice of at most 255 × 255 neurons.
    #[must_use]
    pub fn new(column: usize, row: usize) -> Self {
        let narrow = |i: usize| u8::try_from(i).unwrap_or(u8::MAX);
        Self { column: narrow(column), row: narrow(row) }
    }
}

/// A Gaussian of the lattice distance, tabulated per axis: `G(k, i) = g(|Δcolumn|) · g(|Δrow|)`.
///
/// The bearing axis is an open interval, not a ring: a step ends at most half a turn of the body, that is a quarter
/// turn of bearing, to either side (see [`crate::kohonen::self_organisation`]), so its two ends are not neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Neighbourhood<S, const SPAN: usize> {
    gauss: [S; SPAN],
}

impl<S: Scalar, const SPAN: usize> Neighbourhood<S, SPAN> {
    /// Tabulates exp(−Δ² / 2σ²) for Δ in `0..SPAN`; σ in lattice units.
    #[must_use]
    pub fn new(sigma: S) -> Self {
        let scale = S::ONE / (sigma * sigma + sigma * sigma);
        let mut delta = S::ZERO;
        let gauss = core::array::from_fn(|_| {
            let value = (delta * delta * scale).exp_neg();
            delta += S::ONE;
            value
        });
        Self { gauss }
    }

    /// The factor of one axis for two positions on it.
    #[must_use]
    pub fn along_axis(&self, a: usize, b: usize) -> S {
        self.gauss.get(a.abs_diff(b)).copied().unwrap_or(S::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::Neighbourhood;
    use crate::scalar::{Fixed, Scalar};

    fn check<S: Scalar>() {
        let g = Neighbourhood::<S, 15>::new(S::from_f32(1.5));
        assert_eq!(g.along_axis(4, 4), S::ONE);
        let exact = (-4.0_f32 / 4.5).exp();
        assert!((g.along_axis(3, 5).to_f32() - exact).abs() < 1e-5);
        assert_eq!(g.along_axis(5, 3), g.along_axis(3, 5), "symmetric");
        assert_eq!(g.along_axis(0, 40), S::ZERO, "beyond the table");
    }

    #[test]
    fn is_a_gaussian_of_the_lattice_distance() {
        check::<f32>();
        check::<Fixed>();
    }
}
