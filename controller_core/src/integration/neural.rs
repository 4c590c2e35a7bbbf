//! Neural integration: the motor control EKM of cooperative EKMs (P2 Eq. 8–10).
//!
//! `e_i = a_i − Σ_j b_ij`; the winner k is the neuron with the largest `e_i`; the command is `M_k u_p` where k is the
//! target's own winner s and the command is realisable, else `M_k w_k`.
//!
//! # We changed
//!
//! * **Swept path**: candidates are taken from the highest `e_i` down and lose what [`crate::integration::sweep`] says
//!   of their way, until the best of those judged beats all others unjudged. The result is that of judging all
//!   225; usually fewer than ten are. Where everything is in the way no more than [`JUDGED_MAX`] are: a board has a
//!   deadline. Among movers, which no board follows, all are.
//! * **Retreat**: the map reaches a quarter of a step backwards, for that is all that positioning needs; what moves is
//!   quicker. While something does, a step backwards is judged and made as fast as the wheels turn ([`Stride`]).

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

/// The neurons in the order of `e_i`, the largest first, ties to the lower index.
///
/// Only the first of each column is kept; when it is taken out, its column is computed again. That costs a fifteenth of
/// the map for each candidate, and spares the stack the activities of all neurons.
struct Ranking<'a, S: Scalar, O, const COLUMNS: usize, const ROWS: usize> {
    map: &'a Map<S, O, COLUMNS, ROWS>,
    parameters: &'a TargetFieldParameters<S>,
    target: &'a TargetField<S>,
    obstacles: &'a ObstacleField<S, COLUMNS, ROWS>,
    eligible: Eligible,
    /// Of each column: the activity, and the row where it was found.
    first: [S::Weight; COLUMNS],
    row: [u8; COLUMNS],
}

/// Most candidates whose way is judged where nothing moves, the most active first. On the slower board one takes some
/// 14,000 instructions of the million that a period leaves.
pub const JUDGED_MAX: u16 = 40;

/// Below any activity: inhibition saturates at −8 in 16 bits. What is untrained or taken out counts as this.
const OUT: i32 = -8;

/// `e_i = a_i − Σ_j b_ij` of a neuron with weight `place` (P2 Eq. 8), as it is ranked: with the bits of a weight.
#[inline]
#[must_use]
pub fn activity<S: Scalar>(
    parameters: &TargetFieldParameters<S>,
    target: &TargetField<S>,
    place: Features<S>,
    inhibition: S,
) -> S {
    let e = target.activity(parameters, place) - inhibition;
    S::from_weight(e.max(S::from_i32(OUT)).to_weight())
}

/// The command of a neuron if it wins with this haste (see [`Stride`]), and whether that is `M_s u_p`: fine control of
/// the target itself (P2 Eq. 10).
#[inline]
#[must_use]
pub fn command<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    reaching: &ReachingParameters<S>,
    target: &TargetField<S>,
    (index, haste): (NeuronIndex, S),
) -> (Command<S>, bool) {
    if haste > S::ONE {
        let own = map.own_command(index);
        return (Command { left: own.left * haste, right: own.right * haste }.saturated(), false);
    }
    let is_target = index == target.winner;
    let command =
        if is_target { command_of(map, reaching.beyond, index, target.aim) } else { map.own_command(index) };
    (command, is_target)
}

/// How a neuron's step is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stride<S> {
    /// Where it leads to.
    pub place: Features<S>,
    /// So many times as fast and as far as the neuron has it: 1 but for a retreat.
    pub haste: S,
}

/// A step backwards that is shorter than this, as a share of the reach, is a turn and no retreat.
const RETREAT_SHARE: f32 = 0.02;

/// No step is made more times as fast than this: what has been learned of the shortest ones is too coarse.
const HASTE_MAX: f32 = 16.0;

/// How a neuron's step is made; `is_pressed` where something moves nearby. An arc that is driven so many times as fast
/// leads so many times as far along the same circle.
#[inline]
#[must_use]
pub fn stride<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    index: NeuronIndex,
    is_pressed: bool,
) -> Stride<S> {
    let place = map.place(index);
    if !is_pressed || place.distance > -S::from_f32(RETREAT_SHARE) {
        return Stride { place, haste: S::ONE };
    }
    let own = map.own_command(index);
    let haste = (S::ONE / own.left.abs().max(own.right.abs())).clamp(S::ONE, S::from_f32(HASTE_MAX));
    Stride { place: Features { bearing: place.bearing * haste, distance: place.distance * haste }, haste }
}

impl<'a, S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize> Ranking<'a, S, O, COLUMNS, ROWS> {
    fn new(
        map: &'a Map<S, O, COLUMNS, ROWS>,
        parameters: &'a TargetFieldParameters<S>,
        target: &'a TargetField<S>,
        obstacles: &'a ObstacleField<S, COLUMNS, ROWS>,
        eligible: Eligible,
    ) -> Self {
        let (first, row) = ([S::WEIGHT_ZERO; COLUMNS], [0; COLUMNS]);
        let mut ranking = Self { map, parameters, target, obstacles, eligible, first, row };
        for column in 0..COLUMNS {
            ranking.rank(column, None);
        }
        ranking
    }

    /// Finds the first of a column behind the one taken out, if one was.
    fn rank(&mut self, column: usize, taken: Option<(usize, S)>) {
        let out = S::from_i32(OUT);
        let (mut first, mut first_row) = (out, 0);
        if let Some(inhibitions) = self.obstacles.column(column) {
            for (row, place) in self.map.rows(column, self.eligible) {
                let Some(&inhibition) = inhibitions.get(row) else { break };
                let e = activity(self.parameters, self.target, place, S::from_weight(inhibition));
                let is_behind = taken.is_none_or(|(of_row, of)| e < of || (e <= of && row > of_row));
                if is_behind && e > first {
                    (first, first_row) = (e, row);
                }
            }
        }
        if let (Some(stored), Some(row)) = (self.first.get_mut(column), self.row.get_mut(column)) {
            *stored = first.to_weight();
            *row = u8::try_from(first_row).unwrap_or(u8::MAX);
        }
    }

    /// The neuron with the largest activity, which stays until it is taken out.
    fn best(&self) -> Option<(NeuronIndex, S)> {
        let out = S::from_i32(OUT);
        let mut best = (0, 0, out);
        for (column, (&stored, &row)) in self.first.iter().zip(&self.row).enumerate() {
            let e = S::from_weight(stored);
            if e > best.2 {
                best = (column, row, e);
            }
        }
        let (column, row, e) = best;
        (e > out).then(|| (NeuronIndex::new(column, usize::from(row)), e))
    }

    fn take_out(&mut self, (index, e): (NeuronIndex, S)) {
        self.rank(usize::from(index.column), Some((usize::from(index.row), e)));
    }
}

/// Chooses the command; `sweep` gives the further inhibition of a way, `is_pressed` where something moves nearby.
/// `None` while nothing is trained.
#[allow(
    clippy::too_many_arguments,
    reason = "each is another module's; a struct for one call would hide that"
)]
pub fn integrate<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    parameters: &NeuralParameters<S>,
    reaching: &ReachingParameters<S>,
    scaling: &Scaling<S>,
    target: &TargetField<S>,
    obstacles: &ObstacleField<S, COLUMNS, ROWS>,
    is_pressed: bool,
    sweep: impl Fn(Polar<S>) -> S,
) -> Option<Decision<S>> {
    let mut best: Option<Decision<S>> = None;
    let mut count = 0_u16;
    let mut ranking = Ranking::new(map, &parameters.target, target, obstacles, reaching.winner.eligible);
    while let Some((index, e)) = ranking.best() {
        if best.is_some_and(|decision| decision.activity >= e) {
            break;
        }
        count += 1;
        let stride = stride(map, index, is_pressed);
        let inhibition = sweep(scaling.place(stride.place));
        let activity = e - inhibition;
        if best.is_none_or(|decision| activity > decision.activity) {
            let (command, is_target) = command(map, reaching, target, (index, stride.haste));
            best = Some(Decision { command, winner: index, activity, is_target, judged: count });
        }
        if inhibition <= S::ZERO || (count >= JUDGED_MAX && !is_pressed) {
            // None behind it can be better.
            break;
        }
        ranking.take_out((index, e));
    }
    best.map(|decision| Decision { judged: count, ..decision })
}
