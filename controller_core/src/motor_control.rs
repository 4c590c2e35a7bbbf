//! Motor control: from a place to wheel speeds through the map (P1 Eq. 5, P2 Eq. 10).
//!
//! # We changed
//!
//! * **Far targets** (beyond `far_m`): the map is asked for `(α/2, far)`. A step on an arc to bearing α turns the body
//!   by 2α; aiming at α itself overshoots the heading and zig-zags (5.8 mm against 1.9 mm in a prototype).
//! * **Places behind**: near ones are driven to backwards, others are turned towards on the spot.
//! * **Commands beyond c\***: the farthest realisable distance *on the same bearing*, then the paper's `M_k w_k` where
//!   the bearing alone asks for too much. [`Beyond::OwnWeight`] is the paper's literal form.

use crate::kohonen::features::{BEHIND_SHARE, Command, Features};
use crate::kohonen::lattice::NeuronIndex;
use crate::kohonen::map::{Eligible, Map, WinnerParameters};
use crate::kohonen::output::Output;
use crate::scalar::Scalar;

/// What to do with a command beyond c*.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Beyond {
    /// The farthest realisable distance on the same bearing.
    #[default]
    NearerOnBearing,
    /// `M_k w_k`, the paper's literal Eq. 5.
    OwnWeight,
}

/// The numbers of motor control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReachingParameters<S> {
    /// From this distance (features) on the target of P1's target reaching counts as far.
    pub far: Option<S>,
    /// What to do beyond c*.
    pub beyond: Beyond,
    /// How winners are chosen.
    pub winner: WinnerParameters<S>,
}

/// The place that the map is asked for, given where the target is (distance ≥ 0, bearing of the full circle) and from
/// which distance on it is far; no limit in the literal form.
#[must_use]
pub fn aim<S: Scalar>(far: Option<S>, target: Features<S>) -> Features<S> {
    let is_behind = target.bearing.abs() > S::PI * S::HALF;
    match far {
        Some(far) if target.distance > far => Features { bearing: target.bearing * S::HALF, distance: far },
        _ if !is_behind => target,
        _ if target.distance <= S::from_f32(BEHIND_SHARE) => target.folded(),
        _ => Features { bearing: target.bearing * S::HALF, distance: S::ZERO },
    }
}

/// The command of neuron k for a place (P1 Eq. 5): `M_k u` where realisable, else as [`Beyond`] says.
#[must_use]
pub fn command_of<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    beyond: Beyond,
    k: NeuronIndex,
    place: Features<S>,
) -> Command<S> {
    let command = map.command_at(k, place);
    if command.is_realisable() {
        return command;
    }
    if beyond == Beyond::NearerOnBearing {
        let neuron = map.neuron(k);
        let unwrapped = place.unwrapped_around(S::from_weight(neuron.bearing));
        if let Some(distance) = neuron.output.feasible_distance(unwrapped) {
            return neuron.output.command(Features { distance, ..unwrapped }).scaled_to_limit();
        }
    }
    map.own_command(k)
}

/// Target reaching as in P1: the winner for the target and its command; `None` while nothing is trained.
#[must_use]
pub fn reach<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    parameters: &ReachingParameters<S>,
    target: Features<S>,
) -> Option<(NeuronIndex, Command<S>)> {
    let place = aim(parameters.far, target);
    let k = map.winner(&parameters.winner, place, Eligible::Trained)?;
    Some((k, command_of(map, parameters.beyond, k, place)))
}
