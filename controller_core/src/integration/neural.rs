//! Neural integration: the motor control EKM of cooperative EKMs (P2 Eq. 8–10).
//!
//! `e_i = a_i − Σ_j b_ij`; the winner k is the neuron with the largest `e_i`; the command is `M_k u_p` where k is the
//! target's own winner s and the command is realisable, else `M_k w_k`.
//!
//! # We changed
//!
//! * **Swept path**: candidates are taken from the highest `e_i` down and lose what [`crate::integration::sweep`] says
//!   of their way, until the best of those judged beats all others unjudged. The result is that of judging all 225;
//!   usually fewer than ten are. After [`RANKED`] of them the order is no longer worth its price: everything is in the
//!   way, and the rest are judged as they come, each only as far as it takes to see that it is no better.
//! * **Retreat**: the map reaches a quarter of a step backwards, for that is all that positioning needs; what moves is
//!   quicker. While something does, and whatever is ahead is obstructed, the steps ahead are judged once more as they
//!   are if both wheels turn the other way; and those few that lead backwards as fast as the wheels turn ([`Stride`]).
//! * **Coarse wishes**: while something surely moves, activities count in steps of [`COARSE_SHARE`] of the target's
//!   own. Of places that lead nowhere near the target one is still a trace more active than another, and which one
//!   changes with every scan: the robot drove off here and there, into the way of what came. So all of these are worth
//!   nothing; of equals the first on the lattice wins, which is a turn on the spot, always the same way, until there is
//!   a way ahead.
//! * **Persistence**: while something moves, to turn back costs something. Else the robot dithers between two ways out,
//!   each a little better than the other in turn, and takes neither.

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
    /// Whether something moved nearby.
    pub pressed: Pressed,
}

/// How finely activities are told apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wishes {
    /// As finely as a weight is stored.
    #[default]
    Fine,
    /// In sixteenths of the target field's amplitude: something surely moves.
    Coarse,
}

/// Whether something moves nearby, and where the command before led to then. One byte, for boards with little memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pressed {
    /// Nothing moves.
    #[default]
    No,
    /// Something does, and the robot stood or turned on the spot.
    Standing,
    /// It was driven ahead,
    Ahead,
    /// or back.
    Back,
}

impl Pressed {
    /// Something moves after this command.
    #[must_use]
    pub fn after<S: Scalar>(command: Command<S>) -> Self {
        let driven = (command.left + command.right) * S::HALF;
        if driven > S::from_f32(DIRECTED_COMMAND) {
            Self::Ahead
        } else if driven < -S::from_f32(DIRECTED_COMMAND) {
            Self::Back
        } else {
            Self::Standing
        }
    }
}

/// The candidates: first in the order of `e_i`, the largest first, ties to the lower index; then as they come.
///
/// Of the order only the first of each column is kept; when it is taken out, its column is computed again. That costs a
/// fifteenth of the map for each candidate, and spares the stack the activities of all neurons.
struct Candidates<'a, S: Scalar, O, const COLUMNS: usize, const ROWS: usize, const TRACKS: usize> {
    map: &'a Map<S, O, COLUMNS, ROWS>,
    parameters: &'a TargetFieldParameters<S>,
    target: &'a TargetField<S>,
    obstacles: &'a ObstacleField<S, COLUMNS, ROWS>,
    eligible: Eligible,
    wishes: Wishes,
    /// Of each column: the activity, and the row where it was found.
    first: [S::Weight; COLUMNS],
    row: [u8; COLUMNS],
    /// The activities of the column that was kept last.
    column: [S::Weight; ROWS],
    /// What comes next where they come in no order: a column, and a row of it.
    next: (usize, usize),
}

/// So many candidates are judged in the order of their activity. To find the next one takes some 6,000 instructions on
/// the slower board, several times what it takes to see that one is no better than the best.
pub const RANKED: u16 = 8;

/// The best of those judged.
#[derive(Clone, Copy)]
struct Best<S> {
    index: NeuronIndex,
    haste: S,
    /// `e_i`, and what is left of it.
    e: S,
    activity: S,
}

impl<S: Scalar> Best<S> {
    /// Judges a candidate, which may be better; returns its inhibition, or more than matters.
    #[inline]
    fn judge(
        &mut self,
        index: NeuronIndex,
        stride: Stride<S>,
        e: S,
        pressed: Pressed,
        scaling: &Scaling<S>,
        sweep: &mut impl FnMut(Polar<S>, S) -> S,
    ) -> S {
        let inhibition =
            sweep(scaling.place(stride.place), e - self.activity) + reversal(pressed, stride.place);
        let activity = e - inhibition;
        if activity > self.activity || (activity >= self.activity && e > self.e) {
            *self = Self { index, haste: stride.haste, e, activity };
        }
        inhibition
    }
}

/// Below any activity: inhibition saturates at −8 in 16 bits. What is untrained or taken out counts as this.
const OUT: i32 = -8;

/// `e_i = a_i − Σ_j b_ij` of a neuron with weight `place` (P2 Eq. 8), as it is ranked: with the bits of a weight at
/// most.
#[inline]
#[must_use]
pub fn activity<S: Scalar>(
    parameters: &TargetFieldParameters<S>,
    target: &TargetField<S>,
    place: Features<S>,
    inhibition: S,
    wishes: Wishes,
) -> S {
    let mut e = target.activity(parameters, place) - inhibition;
    if wishes == Wishes::Coarse {
        let step = parameters.amplitude * S::from_f32(COARSE_SHARE);
        e = (e / step).round() * step;
    }
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
    if haste > S::ONE || haste < S::ZERO {
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
    /// So many times as fast and as far as the neuron has it: 1, more for a retreat, −1 for the step ahead backwards.
    pub haste: S,
}

/// A step backwards that is shorter than this, as a share of the reach, is a turn and no retreat.
const RETREAT_SHARE: f32 = 0.02;

/// No step is made more times as fast than this: what has been learned of the shortest ones is too coarse.
const HASTE_MAX: f32 = 16.0;

/// What makes a difference to coarse wishes, as a share of the target field's amplitude.
pub const COARSE_SHARE: f32 = 1.0 / 16.0;

/// What it costs to turn back while something moves: a third of what a target is worth.
const REVERSAL: f32 = 0.3;

/// Steps shorter than this, as a share of the reach, and commands slower, as a share of the fastest, have no direction
/// that could be turned back from.
const DIRECTED_SHARE: f32 = 0.1;
/// See [`DIRECTED_SHARE`].
const DIRECTED_COMMAND: f32 = 0.05;

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

/// The step to a place ahead, made backwards: with both wheels the other way it leads along the mirrored arc. `None`
/// for what is not ahead.
#[inline]
#[must_use]
pub fn backwards<S: Scalar>(place: Features<S>) -> Option<Stride<S>> {
    let mirrored = Features { bearing: -place.bearing, distance: -place.distance };
    (place.distance >= S::from_f32(RETREAT_SHARE)).then_some(Stride { place: mirrored, haste: -S::ONE })
}

/// What it costs to go to a place if that is to turn back.
#[inline]
#[must_use]
pub fn reversal<S: Scalar>(pressed: Pressed, place: Features<S>) -> S {
    let least = S::from_f32(DIRECTED_SHARE);
    let turns_back = match pressed {
        Pressed::Ahead => place.distance < -least,
        Pressed::Back => place.distance > least,
        Pressed::No | Pressed::Standing => false,
    };
    if turns_back { S::from_f32(REVERSAL) } else { S::ZERO }
}

impl<'a, S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize, const TRACKS: usize>
    Candidates<'a, S, O, COLUMNS, ROWS, TRACKS>
{
    fn new(
        map: &'a Map<S, O, COLUMNS, ROWS>,
        parameters: &'a TargetFieldParameters<S>,
        target: &'a TargetField<S>,
        obstacles: &'a ObstacleField<S, COLUMNS, ROWS>,
        eligible: Eligible,
        wishes: Wishes,
    ) -> Self {
        let (first, row, column) = ([S::WEIGHT_ZERO; COLUMNS], [0; COLUMNS], [S::WEIGHT_ZERO; ROWS]);
        let mut candidates =
            Self { map, parameters, target, obstacles, eligible, wishes, first, row, column, next: (0, 0) };
        for column in 0..COLUMNS {
            candidates.rank(column, None);
        }
        candidates
    }

    /// How finely to tell apart. Said to the compiler, which else keeps the code for what cannot be.
    fn wishes(&self) -> Wishes {
        if TRACKS == 0 { Wishes::Fine } else { self.wishes }
    }

    /// The first of a column behind the one taken out, if one was.
    fn first_of(&self, column: usize, taken: Option<(usize, S)>) -> (S, usize) {
        let mut first = (S::from_i32(OUT), 0);
        let Some(inhibitions) = self.obstacles.column(column) else { return first };
        // By value, so that they stay in registers.
        let (parameters, target) = (*self.parameters, *self.target);
        for (row, place) in self.map.rows(column, self.eligible) {
            let Some(&inhibition) = inhibitions.get(row) else { break };
            let e = activity(&parameters, &target, place, S::from_weight(inhibition), self.wishes());
            let is_behind = taken.is_none_or(|(of_row, of)| e < of || (e <= of && row > of_row));
            if is_behind && e > first.0 {
                first = (e, row);
            }
        }
        first
    }

    fn rank(&mut self, column: usize, taken: Option<(usize, S)>) {
        let (e, of_row) = self.first_of(column, taken);
        if let (Some(first), Some(row)) = (self.first.get_mut(column), self.row.get_mut(column)) {
            *first = e.to_weight();
            *row = u8::try_from(of_row).unwrap_or(u8::MAX);
        }
    }

    /// Keeps the activities of a column.
    #[inline(never)]
    fn keep(&mut self, column: usize) {
        let mut kept = [S::from_i32(OUT).to_weight(); ROWS];
        let Some(inhibitions) = self.obstacles.column(column) else { return };
        for (row, place) in self.map.rows(column, self.eligible) {
            let (Some(&inhibition), Some(stored)) = (inhibitions.get(row), kept.get_mut(row)) else { break };
            let e = activity(self.parameters, self.target, place, S::from_weight(inhibition), self.wishes());
            *stored = e.to_weight();
        }
        self.column = kept;
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

    /// The next in the order of the lattice that is more active than `least` and has not been taken out.
    fn next_above(&mut self, least: S) -> Option<(NeuronIndex, S)> {
        let (mut column, mut row) = self.next;
        while let Some(&first) = self.first.get(column) {
            let first = S::from_weight(first);
            if first > least {
                if row == 0 {
                    self.keep(column);
                }
                for (at, &stored) in self.column.iter().enumerate().skip(row) {
                    let e = S::from_weight(stored);
                    if e > least && e <= first {
                        self.next = (column, at + 1);
                        return Some((NeuronIndex::new(column, at), e));
                    }
                }
            }
            (column, row) = (column + 1, 0);
        }
        None
    }
}

/// Chooses the command; `sweep` gives the further inhibition of a way, or [`Scalar::LIMIT`] for more than the number it
/// is told. `None` while nothing is trained. Without `TRACKS` nothing moves.
#[expect(
    clippy::too_many_arguments,
    reason = "each is another module's; a struct for one call would hide that"
)]
pub fn integrate<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize, const TRACKS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    parameters: &NeuralParameters<S>,
    reaching: &ReachingParameters<S>,
    scaling: &Scaling<S>,
    target: &TargetField<S>,
    obstacles: &ObstacleField<S, COLUMNS, ROWS>,
    pressed: Pressed,
    wishes: Wishes,
    mut sweep: impl FnMut(Polar<S>, S) -> S,
) -> Option<Decision<S>> {
    let pressed = if TRACKS == 0 { Pressed::No } else { pressed };
    let mut candidates = Candidates::<'_, S, O, COLUMNS, ROWS, TRACKS>::new(
        map,
        &parameters.target,
        target,
        obstacles,
        reaching.winner.eligible,
        wishes,
    );
    let mut next = candidates.best();
    let mut best = Best { index: next?.0, haste: S::ONE, e: -S::LIMIT, activity: -S::LIMIT };
    let mut judged = 0_u16;
    while let Some((index, e)) = next {
        judged += 1;
        let stride = stride(map, index, pressed != Pressed::No);
        let inhibition = best.judge(index, stride, e, pressed, scaling, &mut sweep);
        if judged < RANKED {
            if inhibition <= S::ZERO {
                // None behind it can be better.
                break;
            }
            candidates.take_out((index, e));
            next = candidates.best().filter(|&(_, e)| e > best.activity);
        } else {
            next = candidates.next_above(best.activity);
        }
    }
    if pressed != Pressed::No && best.activity < best.e {
        for (index, place) in map.places(reaching.winner.eligible) {
            let Some(stride) = backwards(place) else { continue };
            // No field of an obstacle has been asked there: its way is held against all of them.
            let e = activity(&parameters.target, target, stride.place, S::ZERO, wishes);
            if e > best.activity {
                judged += 1;
                best.judge(index, stride, e, pressed, scaling, &mut sweep);
            }
        }
    }
    let (command, is_target) = command(map, reaching, target, (best.index, best.haste));
    Some(Decision { command, winner: best.index, activity: best.activity, is_target, judged, pressed })
}

#[cfg(test)]
mod tests {
    use super::{NeuralParameters, Pressed, RANKED, Wishes, activity, backwards, integrate, reversal};
    use crate::config::Config;
    use crate::kohonen::features::Features;
    use crate::kohonen::lattice::NeuronIndex;
    use crate::kohonen::map::{Eligible, Map};
    use crate::kohonen::output::ControlMatrix;
    use crate::localisation::obstacle::ObstacleField;
    use crate::localisation::target::{Approach, TargetField};
    use crate::motor_control::ReachingParameters;
    use crate::scalar::{Fixed, Scalar};
    use crate::units::Polar;

    /// A number in 0 to 1 that is another one for each place and case.
    fn scattered<S: Scalar>(place: Polar<S>, case: u32) -> f32 {
        let bits = place.bearing_rad.to_bits() ^ place.distance_m.to_bits().rotate_left(13) ^ (case << 20);
        let mixed = bits.wrapping_mul(0x9e37_79b1) ^ (bits >> 15);
        f32::from(u16::try_from(mixed.wrapping_mul(0x85eb_ca6b) >> 16).unwrap()) / 65_536.0
    }

    /// Judging in two orders, each way only as far as need be, gives what judging every way to its end gives.
    fn check<S: Scalar>() {
        let p = Config::default().build::<S, 12>().unwrap();
        let reaching = ReachingParameters {
            winner: crate::kohonen::map::WinnerParameters { eligible: Eligible::All, ..p.reaching.winner },
            ..p.reaching
        };
        let neural: &NeuralParameters<S> = &p.neural;
        let map = Map::<S, ControlMatrix<S::Weight>, 15, 15>::regular();
        let obstacles = ObstacleField::<S, 15, 15>::EMPTY;
        let (mut few, mut many) = (0, 0);
        for case in 0..300_u32 {
            let share = f32::from(u16::try_from(case).unwrap()) / 300.0;
            let target = Features {
                bearing: S::from_f32(3.0 * share - 1.5),
                distance: S::from_f32(0.1 + 2.0 * share),
            };
            let field =
                TargetField::localise(&map, Approach::plain(&neural.target), &reaching, target).unwrap();
            // Of some cases few ways are obstructed, of others all.
            let strength = 4.0 * share;
            let inhibition = |place: Polar<S>| {
                S::from_f32(strength * (scattered(place, case) - 0.3 * (1.0 - share))).max(S::ZERO)
            };
            let sweep = |place: Polar<S>, enough: S| {
                let inhibition = inhibition(place);
                if inhibition >= enough { S::LIMIT } else { inhibition }
            };
            let decision = integrate::<_, _, _, _, 1>(
                &map,
                neural,
                &reaching,
                &p.scaling,
                &field,
                &obstacles,
                Pressed::No,
                Wishes::Fine,
                sweep,
            )
            .unwrap();
            let mut best: Option<(S, NeuronIndex)> = None;
            for (index, place) in map.places(Eligible::All) {
                let e = activity(&neural.target, &field, place, S::ZERO, Wishes::Fine)
                    - inhibition(p.scaling.place(place));
                if best.is_none_or(|(most, _)| e > most) {
                    best = Some((e, index));
                }
            }
            let (most, winner) = best.unwrap();
            assert_eq!((decision.activity, decision.winner), (most, winner), "{}: case {case}", S::NAME);
            few += u32::from(decision.judged <= RANKED);
            many += u32::from(decision.judged > RANKED);
        }
        assert!(few > 20 && many > 20, "{}: {few} {many}", S::NAME);
    }

    #[test]
    fn the_best_of_all_wins_in_whatever_order_they_are_judged() {
        check::<f32>();
        check::<Fixed>();
    }

    fn check_retreat<S: Scalar>() {
        let s = S::from_f32;
        let p = Config::default().build::<S, 12>().unwrap();
        let reaching = ReachingParameters {
            winner: crate::kohonen::map::WinnerParameters { eligible: Eligible::All, ..p.reaching.winner },
            ..p.reaching
        };
        let mut map = Map::<S, ControlMatrix<S::Weight>, 15, 15>::regular();
        for column in 0..15 {
            for row in 0..15 {
                let index = NeuronIndex::new(column, row);
                let mut neuron = *map.neuron(index);
                let (half, one) = (S::HALF.to_weight(), S::ONE.to_weight());
                neuron.output = ControlMatrix { left: [(-S::HALF).to_weight(), one], right: [half, one] };
                map.set_neuron(index, neuron, true);
            }
        }
        let obstacles = ObstacleField::<S, 15, 15>::EMPTY;
        let target = Features { bearing: S::ZERO, distance: S::ONE };
        let field =
            TargetField::localise(&map, Approach::plain(&p.neural.target), &reaching, target).unwrap();
        // Whatever does not lead back by half a reach is met by something.
        let far = p.scaling.reach_m() * S::HALF;
        let sweep =
            |place: Polar<S>, _: S| if place.distance_m < -far { S::ZERO } else { s(3.0) + place.distance_m };
        let decide = |pressed| {
            integrate::<_, _, _, _, 1>(
                &map,
                &p.neural,
                &reaching,
                &p.scaling,
                &field,
                &obstacles,
                pressed,
                Wishes::Fine,
                sweep,
            )
            .unwrap()
        };
        let fast =
            |command: crate::kohonen::features::Command<S>| (command.left + command.right).to_f32() < -0.5;
        let decision = decide(Pressed::Standing);
        assert!(fast(decision.command), "{}: {decision:?}", S::NAME);
        assert_eq!(decision.pressed, Pressed::Standing);
        // Where nothing moves, the map's own steps must do.
        let decision = decide(Pressed::No);
        assert!(!fast(decision.command), "{}: {decision:?}", S::NAME);
    }

    #[test]
    fn what_is_pressed_goes_back_though_the_map_hardly_does() {
        check_retreat::<f32>();
        check_retreat::<Fixed>();
    }

    fn check_coarse<S: Scalar>() {
        let p = Config::default().build::<S, 12>().unwrap();
        let reaching = ReachingParameters {
            winner: crate::kohonen::map::WinnerParameters { eligible: Eligible::All, ..p.reaching.winner },
            ..p.reaching
        };
        let map = Map::<S, ControlMatrix<S::Weight>, 15, 15>::regular();
        let target = Features { bearing: S::ZERO, distance: S::HALF };
        let field =
            TargetField::localise(&map, Approach::plain(&p.neural.target), &reaching, target).unwrap();
        let of = |aside: f32, inhibition: f32, wishes| {
            let beyond = S::from_f32(aside) / field.distance_steepness;
            let place = Features { distance: field.centre.distance - beyond, ..field.centre };
            activity(&p.neural.target, &field, place, S::from_f32(inhibition), wishes)
        };
        // Far from where the target is, one place is a trace better than another; but not coarsely.
        let (nearer, farther) = (1.95, 2.4);
        assert!(of(nearer, 0.0, Wishes::Fine) > of(farther, 0.0, Wishes::Fine), "{}", S::NAME);
        assert_eq!(of(nearer, 0.0, Wishes::Coarse), of(farther, 0.0, Wishes::Coarse), "{}", S::NAME);
        // What matters stays as it is.
        for (aside, inhibition) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.4), (0.0, 3.0)] {
            let (exact, coarse) =
                (of(aside, inhibition, Wishes::Fine), of(aside, inhibition, Wishes::Coarse));
            assert!((exact - coarse).abs() < p.neural.target.amplitude * S::from_f32(0.04), "{}", S::NAME);
        }
    }

    #[test]
    fn only_what_matters_counts_for_coarse_wishes() {
        check_coarse::<f32>();
        check_coarse::<Fixed>();
    }

    #[test]
    fn a_step_ahead_is_mirrored_and_turning_back_costs() {
        let ahead = Features { bearing: 0.3_f32, distance: 0.8 };
        let back = backwards(ahead).unwrap();
        assert_eq!((back.place.bearing, back.place.distance, back.haste), (-0.3, -0.8, -1.0));
        assert_eq!(backwards(back.place), None, "what is behind is not ahead");
        for (pressed, place, costs) in [
            (Pressed::No, back.place, false),
            (Pressed::Ahead, ahead, false),
            (Pressed::Ahead, back.place, true),
            (Pressed::Back, ahead, true),
            (Pressed::Standing, ahead, false),
            (Pressed::Ahead, Features { distance: -0.05, ..ahead }, false),
        ] {
            assert_eq!(reversal(pressed, place) > 0.0, costs, "{pressed:?} {place:?}");
        }
    }
}
