//! What a neuron says when it wins: indirect mapping (`M_i`, the architecture's) or direct mapping (`c_i`, baseline).
//!
//! Both stand behind [`Output`], so that an experiment changes one type.

use core::fmt::Debug;

use crate::kohonen::features::{Command, Features};
use crate::scalar::Scalar;
use crate::state_hash::StateHash;

/// The output layer of a map.
pub trait Output<S: Scalar>: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// The name users type and read: `indirect` or `direct`.
    const NAME: &'static str;

    /// Of a neuron that has learned nothing: the same as its default, where a constant is needed.
    const BLANK: Self;

    /// The command for a place `u` near this neuron's weight; not yet limited to c*.
    fn command(&self, place: Features<S>) -> Command<S>;

    /// The distance nearest to `place.distance`, between it and 0, whose command on the same bearing is realisable;
    /// `None` where the bearing alone already asks for more than c*.
    fn feasible_distance(&self, place: Features<S>) -> Option<S>;

    /// One gradient step towards `executed` at the place really reached; `rate` is η·G in 0..=1, and `normalisation`
    /// the ε of the normalised step, or `None` for the plain gradient.
    fn learn(&mut self, reached: Features<S>, executed: Command<S>, rate: S, normalisation: Option<S>);

    /// Adds the stored numbers to a hash.
    fn hash_into(&self, hash: &mut StateHash);
}

/// Indirect mapping: the 2×2 control parameter matrix `M_i` of `c = M_i u` (P1 Eq. 1).
///
/// Units: c* per radian and c* per reach.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ControlMatrix<W> {
    /// Left wheel per bearing, left wheel per distance.
    pub left: [W; 2],
    /// Right wheel per bearing, right wheel per distance.
    pub right: [W; 2],
}

/// A row of `M` times u.
fn dot<S: Scalar>(row: [S::Weight; 2], u: Features<S>) -> S {
    S::from_weight(row[0]) * u.bearing + S::from_weight(row[1]) * u.distance
}

/// The x between 0 and `limit`, nearest to `limit`, with |offset + slope·x| ≤ 1, given |offset| ≤ 1.
fn largest_within_unit<S: Scalar>(offset: S, slope: S, limit: S) -> S {
    let end = offset + slope * limit;
    if end.abs() <= S::ONE {
        return limit;
    }
    let bound = if end > S::ZERO { S::ONE } else { -S::ONE };
    ((bound - offset) / slope).clamp(limit.min(S::ZERO), limit.max(S::ZERO))
}

impl<S: Scalar> Output<S> for ControlMatrix<S::Weight> {
    const NAME: &'static str = "indirect";

    const BLANK: Self = Self { left: [S::WEIGHT_ZERO; 2], right: [S::WEIGHT_ZERO; 2] };

    fn command(&self, u: Features<S>) -> Command<S> {
        Command { left: dot(self.left, u), right: dot(self.right, u) }
    }

    fn feasible_distance(&self, u: Features<S>) -> Option<S> {
        let turn = Output::<S>::command(self, Features { distance: S::ZERO, ..u });
        if !turn.is_realisable() {
            return None;
        }
        let left = largest_within_unit(turn.left, S::from_weight(self.left[1]), u.distance);
        Some(largest_within_unit(turn.right, S::from_weight(self.right[1]), left))
    }

    fn learn(&mut self, v: Features<S>, executed: Command<S>, rate: S, normalisation: Option<S>) {
        // P1 Eq. 8, divided by |v|² + ε (normalised LMS): the plain gradient diverges for far and starves for near
        // moves with the same η (prototype: 154 mm against 2 mm).
        let gain = match normalisation {
            Some(epsilon) => rate / (v.bearing * v.bearing + v.distance * v.distance + epsilon),
            None => rate,
        };
        let update = |row: &mut [S::Weight; 2], error: S| {
            let step = gain * error;
            row[0] = (S::from_weight(row[0]) + step * v.bearing).to_weight();
            row[1] = (S::from_weight(row[1]) + step * v.distance).to_weight();
        };
        let said = Output::<S>::command(self, v);
        update(&mut self.left, executed.left - said.left);
        update(&mut self.right, executed.right - said.right);
    }

    fn hash_into(&self, hash: &mut StateHash) {
        self.left.iter().chain(&self.right).for_each(|&weight| hash.add(S::from_weight(weight)));
    }
}

/// Direct mapping, P1's baseline: one motor vector `c_i`, whatever the exact place. Units: c*.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MotorVector<W> {
    /// Left wheel.
    pub left: W,
    /// Right wheel.
    pub right: W,
}

impl<S: Scalar> Output<S> for MotorVector<S::Weight> {
    const NAME: &'static str = "direct";

    const BLANK: Self = Self { left: S::WEIGHT_ZERO, right: S::WEIGHT_ZERO };

    fn command(&self, _: Features<S>) -> Command<S> {
        Command { left: S::from_weight(self.left), right: S::from_weight(self.right) }
    }

    fn feasible_distance(&self, u: Features<S>) -> Option<S> {
        Output::<S>::command(self, u).is_realisable().then_some(u.distance)
    }

    fn learn(&mut self, _: Features<S>, executed: Command<S>, rate: S, _: Option<S>) {
        let update = |stored: &mut S::Weight, target: S| {
            let old = S::from_weight(*stored);
            *stored = (old + rate * (target - old)).to_weight();
        };
        update(&mut self.left, executed.left);
        update(&mut self.right, executed.right);
    }

    fn hash_into(&self, hash: &mut StateHash) {
        hash.add(S::from_weight(self.left));
        hash.add(S::from_weight(self.right));
    }
}

#[cfg(test)]
mod tests {
    use super::{ControlMatrix, MotorVector, Output};
    use crate::kohonen::features::{Command, Features};
    use crate::scalar::{Fixed, Scalar};

    fn check<S: Scalar>() {
        let s = S::from_f32;
        let teacher = |u: Features<S>| Command {
            left: u.distance - u.bearing * s(0.3),
            right: u.distance + u.bearing * s(0.3),
        };
        let mut matrix = ControlMatrix::<S::Weight>::default();
        let mut vector = MotorVector::<S::Weight>::default();
        let places = [(0.5, 0.4), (-0.7, 0.6), (0.2, 0.9), (-0.1, 0.2)];
        for _ in 0..200 {
            for (bearing, distance) in places {
                let u = Features { bearing: s(bearing), distance: s(distance) };
                Output::<S>::learn(&mut matrix, u, teacher(u), s(0.5), Some(s(0.02)));
                Output::<S>::learn(&mut vector, u, teacher(u), s(0.5), Some(s(0.02)));
            }
        }
        let u = Features { bearing: s(0.4), distance: s(0.7) };
        let (said, exact) = (Output::<S>::command(&matrix, u), teacher(u));
        assert!((said.left - exact.left).abs() < s(5e-3), "{}: {said:?} {exact:?}", S::NAME);
        assert!((said.right - exact.right).abs() < s(5e-3), "{}: {said:?} {exact:?}", S::NAME);

        // Right wheel reaches c* first: d + 0.12 = 1.
        let far = Features { distance: s(3.0), ..u };
        let feasible = Output::<S>::feasible_distance(&matrix, far).unwrap();
        assert!((feasible - s(0.88)).abs() < s(0.02), "{feasible:?}");
        assert!(Output::<S>::command(&matrix, Features { distance: feasible, ..far }).left <= S::ONE);
        let spin = Features { bearing: s(4.0), distance: S::ZERO };
        assert_eq!(Output::<S>::feasible_distance(&matrix, spin), None);

        // The direct map says the same whatever the place.
        assert_eq!(Output::<S>::command(&vector, u), Output::<S>::command(&vector, far));
    }

    #[test]
    fn outputs_learn_what_was_executed() {
        check::<f32>();
        check::<Fixed>();
    }
}
