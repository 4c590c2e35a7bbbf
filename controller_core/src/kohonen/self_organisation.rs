//! Online training of the map from the robot's own moves (P1 Eq. 6–8, P2 Eq. 11–13).
//!
//! After each step the displacement `v` that a command `c` really produced is taken as training input: the winner k
//! for v and its neighbours move their weights towards v (Eq. 6) and their outputs towards c (Eq. 8). Nothing is
//! taught from outside, so whatever the robot's wheels, base or noise are, they are in the map.
//!
//! # Open in the papers, and what we chose
//!
//! * **v** ([`Displacement`]): `(half of the heading change, signed chord)`. On a circular arc the chord points along
//!   half of the heading change, so this *is* the egocentric place that was reached, but it stays defined for a turn on
//!   the spot, where the direction of a chord of a millimetre is noise.
//! * **Which moves train**: those that turn by at most half a turn and end no farther behind the robot than the map
//!   reaches (see [`crate::kohonen::features`]), and are no longer than a step can be. The inverse is two-valued
//!   beyond that: the same place is reached by another arc backwards, and one map cannot hold both.
//! * **Schedules**: η, the rate of the weights and the width of G fall exponentially over the first
//!   `annealing_steps`, then stay: online learning goes on for ever.
//! * **Surprise** ([`Plasticity`]): where a map that has settled is wrong for long, the robot has changed, and the
//!   schedules go back some way. The papers' constant η follows a change as slowly as it once learned.
//! * **Normalised step** ([`StepRule`]), see [`crate::kohonen::output`].

use crate::kohonen::features::{Chart, Command, Features};
use crate::kohonen::lattice::{Neighbourhood, NeuronIndex};
use crate::kohonen::map::{Eligible, Map, WinnerParameters};
use crate::kohonen::output::Output;
use crate::scalar::Scalar;
use crate::units::{Point, Polar, Pose};

/// What a move taught: how the displacement v of Eq. 6–8 is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Displacement {
    /// Half of the heading change and the signed chord.
    #[default]
    HalfTurn,
    /// Bearing and distance of the place reached, seen from the start: the papers' literal form.
    Place,
}

/// How far a gradient step of Eq. 8 goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StepRule {
    /// The gradient divided by |v|² + ε.
    #[default]
    Normalised,
    /// The plain gradient: the papers' literal form.
    Plain,
}

/// A quantity that falls exponentially from a first to a last value over a number of steps and then stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Annealing<S> {
    first: S,
    last: S,
    /// ln(first / last) per block of steps.
    decay_per_block: S,
    /// A block has 2 to this power of steps: one, unless so many steps would leave the range of fixed point.
    block_exponent: u16,
    steps: u16,
}

/// Blocks of a schedule at most; a number that fixed point holds.
const SCHEDULE_BLOCKS: u16 = 2000;

impl<S: Scalar> Annealing<S> {
    /// From `first` to `last` (both positive) within `steps` steps.
    #[must_use]
    pub fn new(first: f32, last: f32, steps: u16) -> Self {
        let steps = steps.max(1);
        let mut block_exponent = 0;
        while steps >> block_exponent > SCHEDULE_BLOCKS {
            block_exponent += 1;
        }
        let block = f32::from(1_u16 << block_exponent);
        Self {
            first: S::from_f32(first),
            last: S::from_f32(last),
            decay_per_block: S::from_f32(libm::logf(first / last) * block / f32::from(steps)),
            block_exponent,
            steps,
        }
    }

    /// The value at a step.
    #[must_use]
    pub fn at(&self, step: u32) -> S {
        match u16::try_from(step) {
            Ok(step) if step < self.steps => {
                let block = S::from_i32(i32::from(step >> self.block_exponent));
                // A rounded decay must not pass the last value and then rise to it.
                (self.first * (self.decay_per_block * block).exp_neg()).max(self.last)
            }
            _ => self.last,
        }
    }
}

/// The numbers of online training; see [`crate::config::LearningConfig`] for units and reasons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearningParameters<S> {
    /// η of Eq. 8.
    pub output_rate: Annealing<S>,
    /// η of Eq. 6.
    pub weight_rate: Annealing<S>,
    /// Width of G in lattice units.
    pub neighbourhood: Annealing<S>,
    /// Amplitude of the random part of a command, in units of c*.
    pub exploration: Annealing<S>,
    /// ε of the normalised step.
    pub regularisation: S,
    /// A surprise this many times the usual one makes a settled map learn quickly again; 0 if none does.
    pub surprise_ratio: S,
    /// The age that a surprised map takes on.
    pub surprised_age: u16,
    /// How far a gradient step goes.
    pub step: StepRule,
    /// How a move is measured.
    pub displacement: Displacement,
    /// The coordinates of the map.
    pub chart: Chart,
    /// Moves with a smaller |v| (features) teach nothing but encoder noise.
    pub shortest_move: S,
}

/// The place that was reached, seen from the pose where the move began: [`Displacement::Place`].
#[must_use]
pub fn place_reached<S: Scalar>(start: Pose<S>, end: Pose<S>) -> Polar<S> {
    start.see(Point { x_m: end.x_m, y_m: end.y_m })
}

/// What a step taught.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lesson<S> {
    /// The winner for v.
    pub winner: NeuronIndex,
    /// By how much the winner was wrong: `|c − M_k v| / |c|`. `None` where it had nothing to say yet, or where c was
    /// too small to tell.
    pub surprise: Option<S>,
}

/// Commands shorter than this, of the two wheels together in c*, surprise nobody: encoders and slip are all they show.
const TELLING_COMMAND: f32 = 0.25;

/// Steps over which surprises are averaged: one odd move is not a changed robot.
const LATELY_STEPS: f32 = 32.0;

/// Steps over which what is usual is averaged.
const USUAL_STEPS: f32 = 256.0;

/// Where the schedules stand: at the number of trained steps, unless a surprise has put them back.
///
/// What surprises is a map that is wrong more often than it usually is: how wrong that is depends on the robot's slip
/// and inertia.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plasticity<S> {
    /// How wrong the map was lately.
    lately: S,
    /// How right it usually is: 1 less how wrong. So all of a new one is zero, which costs a board no flash.
    reliability: S,
    /// Steps that the schedules are behind.
    behind: u32,
}

impl<S: Scalar> Plasticity<S> {
    /// Never surprised. A map that comes from elsewhere is taken to be always wrong until it shows otherwise: nothing
    /// is known of what is usual.
    pub const NEW: Self = Self { lately: S::ZERO, reliability: S::ZERO, behind: 0 };

    /// The step at which the schedules stand after so many steps of training.
    #[must_use]
    pub fn age(&self, trained_steps: u32) -> u32 {
        trained_steps.saturating_sub(self.behind)
    }

    /// Takes in what a step taught.
    pub fn heed(&mut self, parameters: &LearningParameters<S>, trained_steps: u32, surprise: S) {
        let (age, settled_age) = (self.age(trained_steps), u32::from(parameters.output_rate.steps));
        // So bounded, not one odd move alone is enough.
        self.lately += (surprise.min(S::HALF) - self.lately) * S::from_f32(1.0 / LATELY_STEPS);
        // A map that has just begun is wrong all the time; what is usual shows when it is nearly done.
        let share = if age < settled_age / 2 { S::ONE } else { S::from_f32(1.0 / USUAL_STEPS) };
        self.reliability += (S::ONE - self.lately - self.reliability) * share;
        let ratio = parameters.surprise_ratio;
        if age >= settled_age && ratio > S::ZERO && self.lately > ratio * (S::ONE - self.reliability) {
            self.behind = trained_steps.saturating_sub(u32::from(parameters.surprised_age));
        }
    }

    /// By how much the map was wrong on average, see [`Lesson::surprise`]: lately, and usually.
    #[must_use]
    pub fn surprise(&self) -> (S, S) {
        (self.lately, S::ONE - self.reliability)
    }
}

/// The displacement `v` between two poses, given the heading change without wrapping: [`Displacement::HalfTurn`].
///
/// The encoders count whole turns where a pose cannot; the poses refine what the encoders drifted.
#[must_use]
pub fn displacement<S: Scalar>(start: Pose<S>, end: Pose<S>, turned_by_encoders_rad: S) -> Polar<S> {
    let drift = crate::units::angle_between(start.heading_rad + turned_by_encoders_rad, end.heading_rad);
    let half_turn = (turned_by_encoders_rad + drift) * S::HALF;
    let (dx, dy) = (end.x_m - start.x_m, end.y_m - start.y_m);
    let (sin, cos) = crate::units::wrap(start.heading_rad + half_turn).sin_cos();
    let along = dx * cos + dy * sin;
    let chord = S::hypot(dx, dy);
    Polar { bearing_rad: half_turn, distance_m: if along < S::ZERO { -chord } else { chord } }
}

/// A displacement longer than this (features) is no move but a jump of the pose: c\* for a whole step is 1, slip and
/// overshoot add a tenth or two. One such jump would carry a neighbourhood of neurons out of reach.
const LONGEST_MOVE: f32 = 1.5;

/// Whether a displacement may train the map, see the module docs.
fn teaches<S: Scalar>(parameters: &LearningParameters<S>, reached: Features<S>) -> bool {
    let (bearing, least) = parameters.chart.bounds::<S>();
    reached.bearing.abs() <= bearing
        && reached.distance >= least
        && reached.distance <= S::from_f32(LONGEST_MOVE)
        && S::hypot(reached.bearing, reached.distance) >= parameters.shortest_move
}

/// One step of online training, with the schedules at `step`; `None` where the move teaches nothing.
pub fn train<S: Scalar, O: Output<S>, const COLUMNS: usize, const ROWS: usize>(
    map: &mut Map<S, O, COLUMNS, ROWS>,
    parameters: &LearningParameters<S>,
    winner: &WinnerParameters<S>,
    step: u32,
    reached: Features<S>,
    executed: Command<S>,
) -> Option<Lesson<S>> {
    if !teaches(parameters, reached) {
        return None;
    }
    let k = map.winner(winner, reached, Eligible::All)?;
    let surprise = map.has_won(k).then(|| surprise(map.command_at(k, reached), executed)).flatten();
    map.mark_won(k);
    let sigma = parameters.neighbourhood.at(step);
    // Both axes fit the larger table: lattices are of tens of neurons a side.
    let g = Neighbourhood::<S, 32>::new(sigma);
    let (output_rate, weight_rate) = (parameters.output_rate.at(step), parameters.weight_rate.at(step));
    let normalisation = match parameters.step {
        StepRule::Normalised => Some(parameters.regularisation),
        StepRule::Plain => None,
    };
    // A gain this small moves no 16-bit weight and no f32 weight that matters; skipping it saves most of the work.
    let negligible = S::from_f32(1e-4);
    for (column, neurons) in map.columns_mut().enumerate() {
        let across = g.along_axis(usize::from(k.column), column);
        if across < negligible {
            continue;
        }
        for (row, neuron) in neurons.iter_mut().enumerate() {
            let gain = across * g.along_axis(usize::from(k.row), row);
            if gain < negligible {
                continue;
            }
            let pull = weight_rate * gain;
            let bearing = S::from_weight(neuron.bearing);
            let distance = S::from_weight(neuron.distance);
            // Δw = η G (v − w), Eq. 6.
            neuron.bearing = (bearing + pull * (reached.bearing - bearing)).to_weight();
            neuron.distance = (distance + pull * (reached.distance - distance)).to_weight();
            // ΔM = η G (c − M v) vᵀ, Eq. 8.
            neuron.output.learn(reached, executed, output_rate * gain, normalisation);
        }
    }
    Some(Lesson { winner: k, surprise })
}

fn surprise<S: Scalar>(said: Command<S>, executed: Command<S>) -> Option<S> {
    let length = S::hypot(executed.left, executed.right);
    let missed = S::hypot(executed.left - said.left, executed.right - said.right);
    (length >= S::from_f32(TELLING_COMMAND)).then(|| missed / length)
}

#[cfg(test)]
mod tests {
    use super::{Displacement, Plasticity, place_reached};
    use crate::config::Config;
    use crate::scalar::{Fixed, Scalar};
    use crate::units::Pose;

    fn check<S: Scalar>() {
        let parameters = Config::default().build::<S, 12>().unwrap().learning;
        let settled = u32::from(Config::default().learning.annealing_steps);
        let mut plasticity = Plasticity::NEW;
        let mut step = 0;
        let mut heed = |surprise: f32, steps: u32| {
            for _ in 0..steps {
                step += 1;
                plasticity.heed(&parameters, step, S::from_f32(surprise));
            }
            (step, plasticity.age(step))
        };
        // However wrong a young map is, its schedules run on.
        assert_eq!(heed(0.9, 500), (500, 500));
        assert_eq!(heed(0.04, 4500), (5000, 5000));
        // One odd move changes nothing; a changed robot puts the schedules back, once.
        assert_eq!(heed(1.0, 1), (5001, 5001));
        assert_eq!(heed(0.04, 500).1, 5501);
        let (now, age) = heed(0.2, 200);
        let surprised = u32::from(Config::default().learning.surprised_age);
        assert!(age < settled && age >= surprised, "{age} after {now} steps");
        // What has become usual surprises no longer.
        assert_eq!(heed(0.2, 3000).1, age + 3000);
    }

    #[test]
    fn only_lasting_surprise_puts_the_schedules_back() {
        check::<f32>();
        check::<Fixed>();
    }

    #[test]
    fn the_literal_displacement_is_the_place_seen_from_the_start() {
        assert_eq!(Displacement::default(), Displacement::HalfTurn);
        let pose = |x_m, y_m, heading_rad| Pose { x_m, y_m, heading_rad };
        let place = place_reached::<f32>(pose(1.0, 1.0, 1.0), pose(1.0, 1.5, 3.0));
        assert!((place.distance_m - 0.5).abs() < 1e-6, "{place:?}");
        assert!((place.bearing_rad - (core::f32::consts::FRAC_PI_2 - 1.0)).abs() < 1e-6, "{place:?}");
    }
}
