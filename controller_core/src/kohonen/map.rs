//! The map itself: neurons, the winner with angular priority (P1 Eq. 2–4), and the command of a winner (P1 Eq. 5).

use crate::kohonen::features::{Chart, Command, Features};
use crate::kohonen::lattice::NeuronIndex;
use crate::kohonen::output::Output;
use crate::scalar::Scalar;
use crate::state_hash::StateHash;
use crate::units::angle_between;

/// One neuron: sensory weight `w_i` and output.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Neuron<W, O> {
    /// `α_i` in radians.
    pub bearing: W,
    /// `d_i` in units of the reach.
    pub distance: W,
    /// `M_i` or `c_i`.
    pub output: O,
}

/// How the winner of Eq. 2–4 is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WinnerParameters<S> {
    /// A(α) holds the neurons whose bearing differs by at most this much more than the closest one's (rad).
    ///
    /// *Open in the papers*; chosen because the exact nearest bearing alone, once the weights have left the grid,
    /// picks one neuron whatever its distance (prototype: 3.6 mm and 9 % never stopping,
    /// against 1.7 mm at 0.1 rad).
    pub bearing_tolerance: S,
    /// `γ_α` of Eq. 3.
    pub bearing_weight: S,
    /// `γ_d` of Eq. 3.
    pub distance_weight: S,
    /// Which neurons may win in control; in training all may.
    pub eligible: Eligible,
}

/// Which neurons may win.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Eligible {
    /// Those that have won in training at least once: the others' outputs mean nothing yet.
    #[default]
    Trained,
    /// All: in training, so that every neuron can be drawn to a place.
    All,
}

/// The least and the largest bearing of the eligible neurons of each column.
#[derive(Clone, Copy, Debug)]
pub struct Spans<S, const COLUMNS: usize> {
    eligible: Eligible,
    /// The least above the most where there is none.
    of_column: [(S, S); COLUMNS],
}

impl<S: Scalar, const COLUMNS: usize> Spans<S, COLUMNS> {
    fn of(&self, column: usize) -> Option<(S, S)> {
        self.of_column.get(column).copied().filter(|(least, most)| least <= most)
    }

    /// The middle of what a column spans, and how far to either side; `None` for a column without eligible neurons.
    #[must_use]
    pub fn middle(&self, column: usize) -> Option<(S, S)> {
        let (least, most) = self.of(column)?;
        Some(((least + most) * S::HALF, (most - least) * S::HALF))
    }

    /// A bound: no eligible neuron of the column has a bearing that differs by less from this one. `None` for a column
    /// without any, 0 where the way round the back might be shorter.
    ///
    /// Safe to the last bit: a rounded difference never falls when what it is taken from rises.
    #[inline]
    #[must_use]
    pub fn nearest(&self, column: usize, bearing: S) -> Option<S> {
        let (least, most) = self.of(column)?;
        let (above, below) = (bearing - most, bearing - least);
        let goes_round = above < -S::PI || below >= S::PI;
        Some(if goes_round { S::ZERO } else { above.max(-below).max(S::ZERO) })
    }
}

/// The map: `COLUMNS` bearings × `ROWS` distances; all static, no heap.
#[derive(Clone, Debug, PartialEq)]
pub struct Map<S: Scalar, O, const COLUMNS: usize, const ROWS: usize> {
    neurons: [[Neuron<S::Weight, O>; ROWS]; COLUMNS],
    /// One bit per row: the neuron has won in training.
    won: [u32; COLUMNS],
}

impl<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize> Default for Map<S, O, COLUMNS, ROWS> {
    fn default() -> Self {
        Self::regular()
    }
}

impl<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize> Map<S, O, COLUMNS, ROWS> {
    /// All neurons at the robot: not a map yet, but a constant, which [`Map::reset`] makes a map of in its place. A
    /// board with little memory has no room to build one elsewhere first.
    pub const BLANK: Self = Self {
        neurons: [[Neuron { bearing: S::WEIGHT_ZERO, distance: S::WEIGHT_ZERO, output: O::BLANK }; ROWS];
            COLUMNS],
        won: [0; COLUMNS],
    };

    /// The untrained map: weights at regularly spaced places of the sensory space (P1, section 3.1), outputs zero.
    ///
    /// Bearings cover ±90° and distances reach a little behind: the places that one step of at most half a turn leads
    /// to.
    #[must_use]
    pub fn regular() -> Self {
        const {
            assert!(COLUMNS > 1 && COLUMNS < 256, "a bearing axis of 2 to 255 columns");
            assert!(ROWS > 1 && ROWS <= 32, "one bit per row must fit into a u32");
        }
        Self {
            neurons: core::array::from_fn(|column| {
                core::array::from_fn(|row| Self::regular_neuron(Chart::Signed, column, row))
            }),
            won: [0; COLUMNS],
        }
    }

    fn regular_neuron(chart: Chart, column: usize, row: usize) -> Neuron<S::Weight, O> {
        let position = |i: usize, count: usize| {
            S::from_i32(i32::try_from(i).unwrap_or(0)) / S::from_i32(i32::try_from(count - 1).unwrap_or(1))
        };
        let (bearing, least) = chart.bounds::<S>();
        Neuron {
            bearing: ((position(column, COLUMNS) - S::HALF) * (bearing + bearing)).to_weight(),
            distance: (position(row, ROWS) * (S::ONE - least) + least).to_weight(),
            output: O::default(),
        }
    }

    /// Forgets everything learned, in place.
    pub fn reset(&mut self) {
        self.spread(Chart::Signed);
    }

    /// As [`Map::reset`], with the weights at regularly spaced places of another chart.
    pub fn spread(&mut self, chart: Chart) {
        for (column, neurons) in self.neurons.iter_mut().enumerate() {
            for (row, neuron) in neurons.iter_mut().enumerate() {
                *neuron = Self::regular_neuron(chart, column, row);
            }
        }
        self.won = [0; COLUMNS];
    }

    /// The neuron at an index; an index outside the lattice gives the nearest one.
    #[must_use]
    pub fn neuron(&self, index: NeuronIndex) -> &Neuron<S::Weight, O> {
        let column = usize::from(index.column).min(COLUMNS - 1);
        let row = usize::from(index.row).min(ROWS - 1);
        &self.neurons[column][row]
    }

    /// The sensory weight `w_i`.
    #[must_use]
    pub fn place(&self, index: NeuronIndex) -> Features<S> {
        let neuron = self.neuron(index);
        Features { bearing: S::from_weight(neuron.bearing), distance: S::from_weight(neuron.distance) }
    }

    /// Whether the neuron has won in training.
    #[must_use]
    pub fn has_won(&self, index: NeuronIndex) -> bool {
        self.won
            .get(usize::from(index.column))
            .is_some_and(|column| column >> (u32::from(index.row) % 32) & 1 == 1)
    }

    /// How many neurons have won in training.
    #[must_use]
    pub fn trained_count(&self) -> u32 {
        self.won.iter().map(|column| column.count_ones()).sum()
    }

    /// Whether any neuron has won in training.
    #[must_use]
    pub fn is_trained(&self) -> bool {
        self.won.iter().fold(0, |any, column| any | column) != 0
    }

    /// All eligible neurons with their index and weight, column by column.
    pub fn places(&self, eligible: Eligible) -> impl Iterator<Item = (NeuronIndex, Features<S>)> + '_ {
        (0..COLUMNS).flat_map(move |column| self.column_places(column, eligible))
    }

    /// The eligible neurons of one column with their index and weight; none beyond the last column.
    pub fn column_places(
        &self,
        column: usize,
        eligible: Eligible,
    ) -> impl Iterator<Item = (NeuronIndex, Features<S>)> + '_ {
        self.rows(column, eligible).map(move |(row, place)| (NeuronIndex::new(column, row), place))
    }

    /// The eligible neurons of one column, as row and weight: for the loops over all neurons.
    #[inline]
    pub(crate) fn rows(
        &self,
        column: usize,
        eligible: Eligible,
    ) -> impl Iterator<Item = (usize, Features<S>)> + '_ {
        let won = if eligible == Eligible::All {
            u32::MAX
        } else {
            self.won.get(column).copied().unwrap_or_default()
        };
        let neurons = self.neurons.get(column).map_or(&[][..], |neurons| &neurons[..]);
        neurons.iter().enumerate().filter(move |&(row, _)| won >> (row % 32) & 1 == 1).map(|(row, neuron)| {
            let place = Features {
                bearing: S::from_weight(neuron.bearing),
                distance: S::from_weight(neuron.distance),
            };
            (row, place)
        })
    }

    /// The bearings that the eligible neurons of each column span: what lets a search leave whole columns out.
    // Inlined: by way of a call there would be two of them on a small stack.
    #[inline(always)]
    #[must_use]
    pub fn spans(&self, eligible: Eligible) -> Spans<S, COLUMNS> {
        let mut spans = Spans { eligible, of_column: [(S::LIMIT, -S::LIMIT); COLUMNS] };
        for (column, (least, most)) in spans.of_column.iter_mut().enumerate() {
            for (_, place) in self.rows(column, eligible) {
                *least = least.min(place.bearing);
                *most = most.max(place.bearing);
            }
        }
        spans
    }

    /// The winner for a place (P1 Eq. 2–4, P2 Eq. 1–3); `None` where no neuron is eligible yet.
    #[must_use]
    pub fn winner(
        &self,
        parameters: &WinnerParameters<S>,
        place: Features<S>,
        eligible: Eligible,
    ) -> Option<NeuronIndex> {
        self.winner_among(&self.spans(eligible), parameters, place)
    }

    /// As [`Map::winner`], with the spans of the map as it is: for several places in a row.
    #[must_use]
    pub fn winner_among(
        &self,
        spans: &Spans<S, COLUMNS>,
        parameters: &WinnerParameters<S>,
        place: Features<S>,
    ) -> Option<NeuronIndex> {
        let offset = |at: Features<S>| angle_between(at.bearing, place.bearing);
        let nearest_in = |column| {
            let offsets = self.rows(column, spans.eligible).map(|(_, at)| offset(at).abs());
            offsets.reduce(S::min)
        };
        // The bearings of a column are no nearer than its span; so most columns are settled by that alone.
        // Beyond any angle where the column has none to offer.
        let mut bounds = [S::LIMIT; COLUMNS];
        let mut first = (0, S::LIMIT);
        for (column, slot) in bounds.iter_mut().enumerate() {
            if let Some(bound) = spans.nearest(column, place.bearing) {
                *slot = bound;
                if bound < first.1 {
                    first = (column, bound);
                }
            }
        }
        let first = first.0;
        let mut nearest = nearest_in(first)?;
        for (column, &bound) in bounds.iter().enumerate() {
            if bound < nearest && column != first {
                nearest = nearest_in(column).map_or(nearest, |offset| offset.min(nearest));
            }
        }
        let admitted = nearest + parameters.bearing_tolerance;
        let mut best: Option<(S, usize, usize)> = None;
        for (column, &bound) in bounds.iter().enumerate() {
            if bound > admitted {
                continue;
            }
            for (row, at) in self.rows(column, spans.eligible) {
                let bearing = offset(at);
                if bearing.abs() > admitted {
                    continue;
                }
                let distance = place.distance - at.distance;
                let difference = parameters.bearing_weight * bearing * bearing
                    + parameters.distance_weight * distance * distance;
                if best.is_none_or(|(least, ..)| difference < least) {
                    best = Some((difference, column, row));
                }
            }
        }
        best.map(|(_, column, row)| NeuronIndex::new(column, row))
    }

    /// `M_k u` (or `c_k`), not yet limited to c*.
    #[must_use]
    pub fn command_at(&self, index: NeuronIndex, place: Features<S>) -> Command<S> {
        let neuron = self.neuron(index);
        neuron.output.command(place.unwrapped_around(S::from_weight(neuron.bearing)))
    }

    /// `M_k w_k`: the command that takes the robot to the neuron's own place (P1 Eq. 5, second case).
    #[must_use]
    pub fn own_command(&self, index: NeuronIndex) -> Command<S> {
        self.neuron(index).output.command(self.place(index)).scaled_to_limit()
    }

    /// Replaces one neuron, as a map loaded from flash or from the link does; outside the lattice nothing happens.
    pub fn set_neuron(&mut self, index: NeuronIndex, neuron: Neuron<S::Weight, O>, has_won: bool) {
        let (column, row) = (usize::from(index.column), usize::from(index.row));
        let Some(place) = self.neurons.get_mut(column).and_then(|neurons| neurons.get_mut(row)) else {
            return;
        };
        *place = neuron;
        if has_won {
            self.won[column] |= 1 << row;
        } else {
            self.won[column] &= !(1 << row);
        }
    }

    /// Hash of all weights, outputs and wins, column by column: equal hashes, equal maps.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let mut hash = StateHash::default();
        for (neurons, &won) in self.neurons.iter().zip(&self.won) {
            for neuron in neurons {
                hash.add(S::from_weight(neuron.bearing));
                hash.add(S::from_weight(neuron.distance));
                neuron.output.hash_into(&mut hash);
            }
            hash.add_word(won);
        }
        hash.value()
    }

    pub(crate) fn mark_won(&mut self, index: NeuronIndex) {
        if let Some(column) = self.won.get_mut(usize::from(index.column)) {
            *column |= 1 << (u32::from(index.row) % 32);
        }
    }

    pub(crate) fn columns_mut(&mut self) -> impl Iterator<Item = &mut [Neuron<S::Weight, O>; ROWS]> {
        self.neurons.iter_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::{Eligible, Map, WinnerParameters};
    use crate::kohonen::features::Features;
    use crate::kohonen::lattice::NeuronIndex;
    use crate::kohonen::output::ControlMatrix;
    use crate::scalar::{Fixed, Scalar};

    fn parameters<S: Scalar>() -> WinnerParameters<S> {
        WinnerParameters {
            bearing_tolerance: S::from_f32(0.1),
            bearing_weight: S::ONE,
            distance_weight: S::ONE,
            eligible: Eligible::Trained,
        }
    }

    fn check<S: Scalar>() {
        let map = Map::<S, ControlMatrix<S::Weight>, 15, 15>::regular();
        let s = S::from_f32;
        // Every neuron wins its own place.
        for (index, place) in map.places(Eligible::All) {
            assert_eq!(map.winner(&parameters(), place, Eligible::All), Some(index), "{place:?}");
        }
        // Direction has priority over distance: a place straight ahead, beyond the workspace, is not given to a
        // neuron that is nearer but lies aside.
        let far = Features { bearing: s(0.05), distance: s(9.0) };
        assert_eq!(map.winner(&parameters(), far, Eligible::All), Some(NeuronIndex { column: 7, row: 14 }));
        // Beyond the last column: that column, and the row nearest in distance.
        let aside = Features { bearing: s(1.7), distance: s(0.0) };
        assert_eq!(map.winner(&parameters(), aside, Eligible::All), Some(NeuronIndex { column: 14, row: 3 }));
        assert_eq!(map.winner(&parameters(), far, Eligible::Trained), None, "nothing is trained yet");
    }

    #[test]
    fn winner_gives_direction_priority() {
        check::<f32>();
        check::<Fixed>();
    }

    #[test]
    fn a_trained_neuron_is_remembered() {
        let mut map = Map::<f32, ControlMatrix<f32>, 15, 15>::regular();
        let index = NeuronIndex { column: 3, row: 14 };
        map.mark_won(index);
        assert!(map.has_won(index));
        assert_eq!(map.trained_count(), 1);
        let place = Features { bearing: 1.0, distance: 0.0 };
        assert_eq!(map.winner(&parameters(), place, Eligible::Trained), Some(index));
    }
}
