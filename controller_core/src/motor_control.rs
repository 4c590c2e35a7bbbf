//! Motor control: from a place to wheel speeds through the map (P1 Eq. 5, P2 Eq. 10).
//!
//! # We changed
//!
//! * **Far targets**: the map is asked for `(α/2, far)`. A step on an arc to bearing α turns the body by 2α; aiming at
//!   α itself overshoots the heading and zig-zags (5.8 mm against 1.9 mm in a prototype).
//! * **Near targets aside** are turned towards on the spot first. An arc to bearing α ends heading 2α off where it
//!   began, so a small miss leaves the target at a large bearing again: the robot circled between ±28° at 1 to 3 mm
//!   from every tenth target. A turn that is slightly wrong leaves it ahead.
//! * **Places behind**: near ones are driven to backwards, others are turned towards on the spot.
//! * **Commands beyond c\***: the farthest realisable distance *on the same bearing*, then the paper's `M_k w_k` where
//!   the bearing alone asks for too much. [`Beyond::OwnWeight`] is the paper's literal form.

use crate::kohonen::features::{BEHIND_SHARE, Chart, Command, Features};
use crate::kohonen::lattice::NeuronIndex;
use crate::kohonen::map::{Map, WinnerParameters};
use crate::kohonen::output::Output;
use crate::scalar::Scalar;
use crate::units::WheelSpeeds;

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
    /// From this distance (features) on a target of P1's target reaching is far.
    pub far: Option<S>,
    /// Where the map is aimed.
    pub aim: Aim<S>,
    /// What to do beyond c*.
    pub beyond: Beyond,
    /// How winners are chosen.
    pub winner: WinnerParameters<S>,
}

/// The resolution of wheel speeds, where the motors take no others: 8 mm/s on a Khepera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandUnit<S> {
    unit_mps: S,
    per_unit: S,
}

impl<S: Scalar> CommandUnit<S> {
    /// Speeds in whole units of this many m/s, above 0.
    #[must_use]
    pub fn new(unit_mps: f32) -> Self {
        Self { unit_mps: S::from_f32(unit_mps), per_unit: S::from_f32(1.0 / unit_mps) }
    }

    /// The nearest speeds that there are.
    #[must_use]
    pub fn rounded(&self, speeds: WheelSpeeds<S>) -> WheelSpeeds<S> {
        let round = |speed: S| (speed * self.per_unit).round() * self.unit_mps;
        WheelSpeeds { left_mps: round(speeds.left_mps), right_mps: round(speeds.right_mps) }
    }
}

/// Where the map is aimed, given where the target is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim<S> {
    /// Below this distance (features) a target is near; 0 in the literal form.
    pub near: S,
    /// A near target at a larger bearing (rad) than this is turned towards first.
    pub near_bearing: S,
    /// The coordinates of the map.
    pub chart: Chart,
}

impl<S: Scalar> Aim<S> {
    /// The place that a turn on the spot by `bearing` leads to: half of it, see `Displacement::HalfTurn`.
    #[must_use]
    pub fn turning(bearing: S) -> Features<S> {
        Features { bearing: bearing * S::HALF, distance: S::ZERO }
    }

    /// The place that the map is asked for, given where the target is (distance ≥ 0, bearing of the full circle), and
    /// from which distance on it is far; no limit in the literal form.
    #[must_use]
    pub fn at(&self, far: Option<S>, target: Features<S>) -> Features<S> {
        let turning = Self::turning;
        if let Some(far) = far.filter(|&far| target.distance > far) {
            return Features { bearing: target.bearing * S::HALF, distance: far };
        }
        if target.distance < self.near {
            let place = self.chart.coordinates(target);
            return if place.bearing.abs() > self.near_bearing { turning(place.bearing) } else { place };
        }
        let is_behind = target.bearing.abs() > S::PI * S::HALF;
        match self.chart {
            Chart::Signed if is_behind && target.distance > S::from_f32(BEHIND_SHARE) => {
                turning(target.bearing)
            }
            Chart::Signed if is_behind => target.folded(),
            _ => target,
        }
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
    let place = parameters.aim.at(parameters.far, target);
    let k = map.winner(&parameters.winner, place, parameters.winner.eligible)?;
    Some((k, command_of(map, parameters.beyond, k, place)))
}

#[cfg(test)]
mod tests {
    use super::{Aim, CommandUnit};
    use crate::kohonen::features::{Chart, Features};
    use crate::scalar::{Fixed, Scalar};
    use crate::units::WheelSpeeds;

    fn aimed<S: Scalar>(chart: Chart, bearing: f32, distance: f32) -> (f32, f32) {
        let s = S::from_f32;
        let aim = Aim { near: s(0.05), near_bearing: s(0.1), chart };
        let place = aim.at(Some(s(0.9)), Features { bearing: s(bearing), distance: s(distance) });
        (place.bearing.to_f32(), place.distance.to_f32())
    }

    fn assert_aim<S: Scalar>(chart: Chart, target: (f32, f32), expected: (f32, f32)) {
        let (bearing, distance) = aimed::<S>(chart, target.0, target.1);
        let (off, away) = (bearing - expected.0, distance - expected.1);
        assert!(off.abs() < 1e-5 && away.abs() < 1e-5, "{chart:?} {target:?}: {bearing}, {distance}");
    }

    fn check<S: Scalar>() {
        let signed = |target, expected| assert_aim::<S>(Chart::Signed, target, expected);
        signed((0.4, 3.0), (0.2, 0.9));
        signed((0.4, 0.5), (0.4, 0.5));
        // Near: ahead it is driven to, aside and behind the robot turns until it is ahead or straight behind.
        signed((0.09, 0.04), (0.09, 0.04));
        signed((0.4, 0.04), (0.2, 0.0));
        signed((3.1, 0.04), (3.1 - core::f32::consts::PI, -0.04));
        signed((2.5, 0.04), ((2.5 - core::f32::consts::PI) / 2.0, 0.0));
        // Behind: backed up to while the map reaches there.
        signed((3.0, 0.2), (3.0 - core::f32::consts::PI, -0.2));
        signed((3.0, 0.4), (1.5, 0.0));
        assert_aim::<S>(Chart::Unsigned, (3.0, 0.2), (3.0, 0.2));
        assert_aim::<S>(Chart::Unsigned, (3.0, 0.4), (3.0, 0.4));

        let unit = CommandUnit::<S>::new(0.008);
        let rounded = |speed: f32| {
            let speeds = WheelSpeeds { left_mps: S::from_f32(speed), right_mps: S::from_f32(-speed) };
            let rounded = unit.rounded(speeds);
            assert!((rounded.left_mps + rounded.right_mps).abs() < S::from_f32(1e-6), "odd: {rounded:?}");
            rounded.left_mps.to_f32()
        };
        for (speed, expected) in [(0.0, 0.0), (0.0039, 0.0), (0.0041, 0.008), (0.1599, 0.16)] {
            assert!((rounded(speed) - expected).abs() < 2e-5, "{speed} became {}", rounded(speed));
        }
    }

    #[test]
    fn aims_and_units_in_both_scalars() {
        check::<f32>();
        check::<Fixed>();
    }
}
