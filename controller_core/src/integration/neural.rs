//! Neural integration: the motor control EKM of cooperative EKMs (P2 Eq. 8–10).
//!
//! `e_i = a_i − Σ_j b_ij`; the winner k is the neuron with the largest `e_i`; the command is `M_k u_p` where k is the
//! target's own winner s and the command is realisable, else `M_k w_k`.
//!
//! # We changed
//!
//! * **Swept path**: candidates are taken from the highest `e_i` down and lose what [`crate::integration::sweep`] says
//!   of their way, until the best of those judged beats all others unjudged. The result is that of judging all
//!   225; usually fewer than ten are.

use crate::kohonen::features::{Command, Scaling};
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

/// `e_i` of every neuron; what is untrained or already judged counts as [`OUT`].
struct Activities<S: Scalar, const COLUMNS: usize, const ROWS: usize>([[S::Weight; ROWS]; COLUMNS]);

/// Below any activity: inhibition saturates at −8 in 16 bits.
const OUT: i32 = -8;

impl<S: Scalar, const COLUMNS: usize, const ROWS: usize> Activities<S, COLUMNS, ROWS> {
    /// Sets all of them; in place, since they are what the stack holds most of.
    fn set<O: Output<S>>(
        &mut self,
        map: &Map<S, O, COLUMNS, ROWS>,
        parameters: &NeuralParameters<S>,
        target: &TargetField<S>,
        obstacles: &ObstacleField<S, COLUMNS, ROWS>,
    ) {
        let out = S::from_i32(OUT);
        self.0.as_flattened_mut().fill(out.to_weight());
        for (index, place) in map.places(Eligible::Trained) {
            let e = target.activity(&parameters.target, place) - obstacles.inhibition(index);
            if let Some(stored) = self.at(usize::from(index.column), usize::from(index.row)) {
                *stored = e.max(out).to_weight();
            }
        }
    }

    fn at(&mut self, column: usize, row: usize) -> Option<&mut S::Weight> {
        self.0.get_mut(column).and_then(|rows| rows.get_mut(row))
    }

    /// Takes out the neuron with the largest activity, ties to the lower index.
    fn pop_best(&mut self) -> Option<(NeuronIndex, S)> {
        let mut best = (0, 0, S::from_i32(OUT));
        for (column, activities) in self.0.iter().enumerate() {
            for (row, &stored) in activities.iter().enumerate() {
                let e = S::from_weight(stored);
                if e > best.2 {
                    best = (column, row, e);
                }
            }
        }
        let (column, row, e) = best;
        if e <= S::from_i32(OUT) {
            return None;
        }
        *self.at(column, row)? = S::from_i32(OUT).to_weight();
        Some((NeuronIndex::new(column, row), e))
    }
}

/// Chooses the command; `sweep` gives the further inhibition of a way. `None` while nothing is trained.
pub fn integrate<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    parameters: &NeuralParameters<S>,
    reaching: &ReachingParameters<S>,
    scaling: &Scaling<S>,
    target: &TargetField<S>,
    obstacles: &ObstacleField<S, COLUMNS, ROWS>,
    sweep: impl Fn(Polar<S>) -> S,
) -> Option<Decision<S>> {
    let mut best: Option<Decision<S>> = None;
    let mut count = 0_u16;
    let mut activities = Activities([[S::WEIGHT_ZERO; ROWS]; COLUMNS]);
    activities.set(map, parameters, target, obstacles);
    while let Some((index, e)) = activities.pop_best() {
        if best.is_some_and(|decision| decision.activity >= e) {
            break;
        }
        count += 1;
        let activity = e - sweep(scaling.place(map.place(index)));
        if best.is_none_or(|decision| activity > decision.activity) {
            let is_target = index == target.winner;
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
