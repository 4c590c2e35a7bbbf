//! Neural integration: the motor control EKM of cooperative EKMs (P2 Eq. 8–10).
//!
//! `e_i = a_i − Σ_j b_ij`; the winner k is the neuron with the largest `e_i`; the command is `M_k u_p` where k is the
//! target's own winner s and the command is realisable, else `M_k w_k`.
//!
//! # We changed
//!
//! * **The target competes at its own place**: where s stands for a target that is not at `w_s`, the obstacle fields
//!   are asked at the target, not at `w_s`. Near a goal in a narrow corner the two differ by centimetres, and that
//!   decides whether the robot gets there ([`NeuralParameters::target_competes`]).
//! * **Swept path**: candidates are taken from the highest `e_i` down and lose what [`crate::integration::sweep`] says
//!   of their way, until the best of those judged beats all others unjudged. The result is that of judging all
//!   225; usually fewer than ten are.

use crate::kohonen::features::{Command, Features, Scaling};
use crate::kohonen::lattice::NeuronIndex;
use crate::kohonen::map::{Eligible, Map};
use crate::kohonen::output::Output;
use crate::localisation::obstacle::{ObstacleField, ObstacleFieldParameters};
use crate::localisation::target::{TargetField, TargetFieldParameters};
use crate::motor_control::{ReachingParameters, command_of};
use crate::scalar::Scalar;
use crate::units::Polar;

/// The numbers of neural integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NeuralParameters<S> {
    /// Target field.
    pub target: TargetFieldParameters<S>,
    /// Obstacle fields.
    pub obstacle: ObstacleFieldParameters<S>,
    /// Whether the target's own place is a candidate beside the neurons.
    pub target_competes: bool,
}

/// What integration decided, and why.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Decision<S> {
    /// The command, realisable.
    pub command: Command<S>,
    /// The winner k.
    pub winner: NeuronIndex,
    /// Its activity after all inhibition.
    pub activity: S,
    /// The command is `M_s u_p`: fine control of the target itself.
    pub is_target: bool,
    /// How many candidates had their way checked.
    pub judged: u16,
}

/// Where a candidate's command would take the robot.
fn place_of<S: Scalar>(scaling: &Scaling<S>, features: Features<S>) -> Polar<S> {
    scaling.place(features)
}

/// The neurons that have been judged: one bit each, like the map's.
struct Judged<const COLUMNS: usize>([u32; COLUMNS]);

impl<const COLUMNS: usize> Judged<COLUMNS> {
    fn contains(&self, index: NeuronIndex) -> bool {
        self.0[usize::from(index.column)] >> index.row & 1 == 1
    }

    fn insert(&mut self, index: NeuronIndex) {
        self.0[usize::from(index.column)] |= 1 << index.row;
    }
}

/// The best neuron that has not been judged: largest `e_i`, ties to the lower index.
fn best_unjudged<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize, const SENSORS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    parameters: &NeuralParameters<S>,
    target: &TargetField<S>,
    obstacles: &ObstacleField<S, COLUMNS, ROWS, SENSORS>,
    judged: &Judged<COLUMNS>,
) -> Option<(NeuronIndex, Features<S>, S)> {
    let mut best: Option<(NeuronIndex, Features<S>, S)> = None;
    for (index, place) in map.places(Eligible::Trained) {
        let inhibition = obstacles.inhibition(index);
        // e_i ≤ A − Σb: most neurons lose without their Gaussian being computed.
        if best.is_some_and(|(_, _, e)| parameters.target.amplitude - inhibition <= e)
            || judged.contains(index)
        {
            continue;
        }
        let e = target.activity(&parameters.target, place) - inhibition;
        if best.is_none_or(|(_, _, most)| e > most) {
            best = Some((index, place, e));
        }
    }
    best
}

/// Chooses the command; `sweep` gives the further inhibition of a way. `None` while nothing is trained.
pub fn integrate<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize, const SENSORS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    parameters: &NeuralParameters<S>,
    reaching: &ReachingParameters<S>,
    scaling: &Scaling<S>,
    target: &TargetField<S>,
    obstacles: &ObstacleField<S, COLUMNS, ROWS, SENSORS>,
    sweep: impl Fn(Polar<S>) -> S,
) -> Option<Decision<S>> {
    let mut best: Option<Decision<S>> = None;
    let mut count = 0_u16;
    if parameters.target_competes {
        let e = parameters.target.amplitude
            - obstacles.at(&parameters.obstacle, target.aim)
            - sweep(place_of(scaling, target.aim));
        count += 1;
        let command = command_of(map, reaching.beyond, target.winner, target.aim);
        best = Some(Decision { command, winner: target.winner, activity: e, is_target: true, judged: count });
    }
    let mut judged = Judged([0; COLUMNS]);
    while let Some((index, place, e)) = best_unjudged(map, parameters, target, obstacles, &judged) {
        if best.is_some_and(|decision| decision.activity >= e) {
            break;
        }
        judged.insert(index);
        count += 1;
        let activity = e - sweep(place_of(scaling, place));
        if best.is_none_or(|decision| activity > decision.activity) {
            let is_target = index == target.winner && !parameters.target_competes;
            let command = if is_target {
                command_of(map, reaching.beyond, index, target.aim)
            } else {
                map.own_command(index)
            };
            best = Some(Decision { command, winner: index, activity, is_target, judged: count });
        }
    }
    best.map(|decision| Decision { judged: count, ..decision })
}
