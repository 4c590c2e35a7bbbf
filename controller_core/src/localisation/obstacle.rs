//! Obstacle localisation EKMs: the obstacle fields `b_ij` (P2 Eq. 6–7), one per sensor that detects something.
//!
//! A Gaussian around the obstacle, stretched away from the robot: what lies behind an obstacle is inhibited too. Only
//! the sum over the sensors is kept, since neural integration needs no more (P2 Eq. 8).
//!
//! # We changed
//!
//! * **Centre of the field**: the sensed place `u_j` itself instead of the nearest neuron's weight
//!   ([`FieldCentre::Sensed`]). The sensors see farther than a step reaches, so the literal winner pulls every far
//!   obstacle onto the outermost neurons (doors and rooms fell from 100 % to 0 % in a prototype).

use heapless::Vec;

use crate::kohonen::features::{Chart, Features, Scaling};
use crate::kohonen::lattice::NeuronIndex;
use crate::kohonen::map::{Eligible, Map, Spans, WinnerParameters};
use crate::kohonen::output::Output;
use crate::list::first;
use crate::scalar::Scalar;
use crate::units::{Polar, angle_between, wrap};

/// Where an obstacle field is centred.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FieldCentre {
    /// At the sensed place.
    #[default]
    Sensed,
    /// At the weight of the winning neuron, the paper's literal form.
    Neuron,
}

/// The widths of an obstacle field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObstacleFieldParameters<S> {
    /// 1 / (√2 `σ_bα`), per radian.
    pub bearing_steepness: S,
    /// 1 / (√2 `σ_bd`) for places at and beyond the obstacle, per reach.
    pub behind_steepness: S,
    /// 1 / (√2 `σ_bd`) for places in front of the obstacle, per reach.
    pub front_steepness: S,
    /// Where the field is centred.
    pub centre: FieldCentre,
    /// The coordinates of the map.
    pub chart: Chart,
}

/// exp(−16) is a ten-millionth: a field that weak decides nothing, so its exponential is not computed.
const NEGLIGIBLE_EXPONENT: i32 = 16;

/// Its root: so many times the inverse steepness aside, a field is negligible at any distance.
const NEGLIGIBLE_WIDTHS: i32 = 4;

/// Far above the rounding of either scalar where bearings are compared.
const SLACK_RAD: f32 = 1e-3;

/// The activity that one obstacle at `centre` gives to an unfolded place (P2 Eq. 6, 7).
#[must_use]
pub fn activity<S: Scalar>(p: &ObstacleFieldParameters<S>, centre: Features<S>, place: Features<S>) -> S {
    let bearing = angle_between(centre.bearing, place.bearing) * p.bearing_steepness;
    let across = bearing * bearing;
    let beyond = place.distance - centre.distance;
    let steepness = if beyond >= S::ZERO { p.behind_steepness } else { p.front_steepness };
    let along = beyond * steepness;
    let exponent = across + along * along;
    if exponent <= S::from_i32(NEGLIGIBLE_EXPONENT) { exponent.exp_neg_within_16() } else { S::ZERO }
}

/// Where the field of an obstacle sensed at a place is centred; `spans` are the map's as it is.
#[inline]
#[must_use]
pub fn centre<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize>(
    map: &Map<S, O, COLUMNS, ROWS>,
    spans: &Spans<S, COLUMNS>,
    p: &ObstacleFieldParameters<S>,
    winner: &WinnerParameters<S>,
    sensed: Features<S>,
) -> Features<S> {
    match p.centre {
        FieldCentre::Sensed => sensed,
        // The map knows places only in its own chart; the field is of the full circle.
        FieldCentre::Neuron => map
            .winner_among(spans, winner, p.chart.coordinates(sensed))
            .map_or(sensed, |index| map.place(index).unfolded()),
    }
}

/// `Σ_j b_ij` for every neuron i of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleField<S: Scalar, const COLUMNS: usize, const ROWS: usize> {
    sum: [[S::Weight; ROWS]; COLUMNS],
}

impl<S: Scalar, const COLUMNS: usize, const ROWS: usize> Default for ObstacleField<S, COLUMNS, ROWS> {
    fn default() -> Self {
        Self { sum: [[S::ZERO.to_weight(); ROWS]; COLUMNS] }
    }
}

impl<S: Scalar, const COLUMNS: usize, const ROWS: usize> ObstacleField<S, COLUMNS, ROWS> {
    /// No obstacle.
    pub const EMPTY: Self = Self { sum: [[S::WEIGHT_ZERO; ROWS]; COLUMNS] };

    /// Renews the fields from what the sensors detect.
    pub fn renew<O: Output<S>, const SENSORS: usize>(
        &mut self,
        map: &Map<S, O, COLUMNS, ROWS>,
        p: &ObstacleFieldParameters<S>,
        winner: &WinnerParameters<S>,
        scaling: &Scaling<S>,
        detections: &Vec<Polar<S>, SENSORS>,
    ) {
        let spans = map.spans(winner.eligible);
        let centre = |obstacle: &Polar<S>| centre(map, &spans, p, winner, scaling.features(*obstacle));
        let centres: Vec<Features<S>, SENSORS> = first(detections.iter().map(centre));
        // By value, so that they stay in registers.
        let p = &ObstacleFieldParameters { ..*p };
        let width = S::from_i32(NEGLIGIBLE_WIDTHS) / p.bearing_steepness + S::from_f32(SLACK_RAD);
        let mut deciding = Vec::<Features<S>, SENSORS>::new();
        for (column, sums) in self.sum.iter_mut().enumerate() {
            let Some((middle, half_span)) = spans.middle(column) else { continue };
            // Of a column's neurons, the obstacles farther aside decide nothing.
            let aside = half_span + width;
            // The map holds places behind turned by half a turn.
            for (middle, is_behind) in [(middle, false), (wrap(middle + S::PI), true)] {
                deciding.clear();
                for centre in &centres {
                    if angle_between(middle, centre.bearing).abs() <= aside {
                        // There is room for all of them.
                        let _ = deciding.push(*centre);
                    }
                }
                for (row, place) in map.rows(column, winner.eligible) {
                    if (place.distance < S::ZERO) != is_behind {
                        continue;
                    }
                    let place = place.unfolded();
                    let sum = deciding.iter().fold(S::ZERO, |sum, &centre| sum + activity(p, centre, place));
                    if let Some(stored) = sums.get_mut(row) {
                        *stored = sum.to_weight();
                    }
                }
            }
        }
    }

    /// Adds to the inhibition of every eligible neuron what `field` says of its unfolded place.
    pub fn add<O: Output<S>>(
        &mut self,
        map: &Map<S, O, COLUMNS, ROWS>,
        eligible: Eligible,
        field: impl Fn(Features<S>) -> S,
    ) {
        for (column, sums) in self.sum.iter_mut().enumerate() {
            for (row, place) in map.rows(column, eligible) {
                if let Some(stored) = sums.get_mut(row) {
                    *stored = (S::from_weight(*stored) + field(place.unfolded())).to_weight();
                }
            }
        }
    }

    /// No obstacle.
    pub fn clear(&mut self) {
        self.sum = [[S::ZERO.to_weight(); ROWS]; COLUMNS];
    }

    /// The summed inhibition of the neurons of a column, as stored.
    pub(crate) fn column(&self, column: usize) -> Option<&[S::Weight; ROWS]> {
        self.sum.get(column)
    }

    /// The summed inhibition of a neuron, as stored.
    #[must_use]
    pub fn inhibition(&self, index: NeuronIndex) -> S {
        let column = self.sum.get(usize::from(index.column));
        column.and_then(|rows| rows.get(usize::from(index.row))).map_or(S::ZERO, |&sum| S::from_weight(sum))
    }
}

#[cfg(test)]
mod tests {
    use super::{FieldCentre, ObstacleFieldParameters, activity};
    use crate::kohonen::features::Chart;
    use crate::kohonen::features::Features;
    use crate::scalar::{Fixed, Scalar};

    fn check<S: Scalar>() {
        let s = S::from_f32;
        let p = ObstacleFieldParameters {
            bearing_steepness: s(2.0),
            behind_steepness: s(0.03),
            front_steepness: s(8.0),
            centre: FieldCentre::Sensed,
            chart: Chart::Signed,
        };
        let at = |bearing, distance| Features { bearing: s(bearing), distance: s(distance) };
        let obstacle = at(0.3, 0.5);
        assert_eq!(activity(&p, obstacle, obstacle), S::ONE, "strongest at the obstacle");
        assert!(activity(&p, obstacle, at(0.3, 1.0)) > s(0.99), "what lies behind is inhibited too");
        assert!(activity(&p, obstacle, at(0.3, 0.2)) < s(0.01), "what lies in front is not");
        let exact = (-(0.4_f32 * 2.0).powi(2) - (0.1_f32 * 8.0).powi(2)).exp();
        assert!((activity(&p, obstacle, at(-0.1, 0.4)).to_f32() - exact).abs() < 1e-4);
        assert_eq!(activity(&p, obstacle, at(-2.8, 0.5)), S::ZERO, "behind the robot");
    }

    #[test]
    fn field_is_stretched_away_from_the_robot() {
        check::<f32>();
        check::<Fixed>();
    }
}
