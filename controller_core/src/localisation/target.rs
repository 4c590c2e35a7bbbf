//! Target localisation EKM: the target field `a_i` (P2 Eq. 1–5).
//!
//! The winner s for the target and an elongated Gaussian around its weight: narrow in distance, wide in bearing, so
//! that when the straight way is inhibited a place *aside at the same distance* takes over instead of one just
//! in front of the obstacle. This is what keeps the robot out of local minima.

use crate::kohonen::features::Features;
use crate::kohonen::lattice::NeuronIndex;
use crate::kohonen::map::Map;
use crate::kohonen::output::Output;
use crate::motor_control::{Aim, ReachingParameters};
use crate::scalar::Scalar;
use crate::units::angle_between;

/// The widths and the amplitude of the target field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetFieldParameters<S> {
    /// Peak of the field against an obstacle field's 1.
    pub amplitude: S,
    /// 1 / (√2 `σ_aα`), per radian.
    pub bearing_steepness: S,
    /// 1 / (√2 `σ_ad`), per reach.
    pub distance_steepness: S,
    /// From this distance (features) on the target counts as far. It is also where the field of a far target is
    /// centred, and so the speed at which the robot cruises.
    pub far: Option<S>,
}

/// How a target is approached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach<S> {
    /// From this distance (features) on it counts as far.
    pub far: Option<S>,
    /// It is turned towards on the spot first.
    pub turn_first: bool,
    /// 1 / (√2 `σ_ad`), per reach: the wider, the sooner a shorter step takes over where the wished one is inhibited.
    pub distance_steepness: S,
}

/// The target field: its centre stands for all of it, since every `a_i` follows from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetField<S> {
    /// Where the target itself is.
    pub target: Features<S>,
    /// Where the map is aimed (see [`crate::motor_control::Aim`]): the `u_p` of `M_k u_p`.
    pub aim: Features<S>,
    /// The winner s.
    pub winner: NeuronIndex,
    /// Its weight `w_s`, the centre of the field.
    pub centre: Features<S>,
    /// 1 / (√2 `σ_ad`), per reach.
    pub distance_steepness: S,
}

impl<S: Scalar> Approach<S> {
    /// As P2 has it: on the straight way, at one speed.
    #[must_use]
    pub fn plain(p: &TargetFieldParameters<S>) -> Self {
        Self { far: p.far, turn_first: false, distance_steepness: p.distance_steepness }
    }
}

impl<S: Scalar> TargetField<S> {
    /// Localises a target, or the turn on the spot towards it; `None` while no neuron is trained.
    #[must_use]
    pub fn localise<O: Output<S>, const COLUMNS: usize, const ROWS: usize>(
        map: &Map<S, O, COLUMNS, ROWS>,
        approach: Approach<S>,
        reaching: &ReachingParameters<S>,
        target: Features<S>,
    ) -> Option<Self> {
        let aim = if approach.turn_first {
            Aim::turning(target.bearing)
        } else {
            reaching.aim.at(approach.far, target)
        };
        let winner = map.winner(&reaching.winner, aim, reaching.winner.eligible)?;
        let distance_steepness = approach.distance_steepness;
        Some(Self { target, aim, winner, centre: map.place(winner), distance_steepness })
    }

    /// The activity `a_i` of a neuron with weight `place` (P2 Eq. 4, 5), amplitude included.
    #[must_use]
    pub fn activity(&self, p: &TargetFieldParameters<S>, place: Features<S>) -> S {
        let bearing = angle_between(self.centre.bearing, place.bearing) * p.bearing_steepness;
        let distance = (place.distance - self.centre.distance) * self.distance_steepness;
        p.amplitude * (bearing * bearing + distance * distance).exp_neg()
    }
}
