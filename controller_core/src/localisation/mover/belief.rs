//! What is believed of a mover: a Gaussian over place, velocity and rate of turn, in the world.
//!
//! An extended Kalman filter of a motion with constant speed and rate of turn, with one thing beside the textbook: what
//! a ring of beams says of a bearing is no Gaussian but a sector. So the belief along one direction is multiplied by
//! the likelihood of a scan, on a grid, and the Gaussian with the mean and the variance of the product is what goes on
//! (moment matching, as in assumed-density filtering).
//!
//! Lengths are in sixteenths of a metre here: the square of half a millimetre is no number of [`crate::scalar::Fixed`]
//! in metres.

use crate::scalar::Scalar;
use crate::units::Point;

/// Place (two), velocity (two), rate of turn.
const STATES: usize = 5;

/// Sixteenths in a metre.
const PER_METRE: f32 = 16.0;
/// Metres in a sixteenth.
const METRES: f32 = 0.0625;

/// How exactly something moves as it is believed to, and what is known of something new.
const PLACE_NOISE_M: f32 = 0.0005;
const VELOCITY_NOISE_MPS: f32 = 0.003;
const TURN_NOISE_RADPS: f32 = 0.04;
const VELOCITY_MPS: f32 = 0.07;
const TURN_RADPS: f32 = 0.75;

/// A Gaussian over the states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Belief<S> {
    mean: [S; STATES],
    covariance: [[S; STATES]; STATES],
}

fn square<S: Scalar>(x: S) -> S {
    x * x
}

impl<S: Scalar> Belief<S> {
    /// Something new at a place (m, world), with what it may err by (standard deviations, m) along the line of sight,
    /// whose direction in the world is given as (sine, cosine), and across it.
    pub(super) fn new(at: Point<S>, (sin, cos): (S, S), along_m: S, across_m: S) -> Self {
        let s = S::from_f32;
        let (along, across) = (square(along_m * s(PER_METRE)), square(across_m * s(PER_METRE)));
        let mut covariance = [[S::ZERO; STATES]; STATES];
        let mixed = cos * sin * (along - across);
        let variances = [
            square(cos) * along + square(sin) * across,
            square(sin) * along + square(cos) * across,
            s(VELOCITY_MPS * VELOCITY_MPS * PER_METRE * PER_METRE),
            s(VELOCITY_MPS * VELOCITY_MPS * PER_METRE * PER_METRE),
            s(TURN_RADPS * TURN_RADPS),
        ];
        for (row, (line, variance)) in covariance.iter_mut().zip(variances).enumerate() {
            line[row] = variance;
        }
        covariance[0][1] = mixed;
        covariance[1][0] = mixed;
        let mean = [at.x_m * s(PER_METRE), at.y_m * s(PER_METRE), S::ZERO, S::ZERO, S::ZERO];
        Self { mean, covariance }
    }

    /// Where (m).
    pub(super) fn at(&self) -> Point<S> {
        let [x, y, ..] = self.mean;
        Point { x_m: x * S::from_f32(METRES), y_m: y * S::from_f32(METRES) }
    }

    /// How fast (m/s).
    pub(super) fn velocity_mps(&self) -> Point<S> {
        let [_, _, x, y, _] = self.mean;
        Point { x_m: x * S::from_f32(METRES), y_m: y * S::from_f32(METRES) }
    }

    /// How it turns (rad/s).
    pub(super) fn turn_radps(&self) -> S {
        self.mean[4]
    }

    /// Goes on for some seconds, much less than a turn takes.
    pub(super) fn advance(&mut self, seconds: S) {
        let [x, y, vx, vy, turn] = self.mean;
        let half = seconds * seconds * S::HALF;
        let (sin, cos) = (turn * seconds).sin_cos();
        let (ux, uy) = (cos * vx - sin * vy, sin * vx + cos * vy);
        self.mean = [x + vx * seconds - vy * turn * half, y + vy * seconds + vx * turn * half, ux, uy, turn];
        let (o, i) = (S::ZERO, S::ONE);
        let jacobian = [
            [i, o, seconds, -turn * half, -vy * half],
            [o, i, turn * half, seconds, vx * half],
            [o, o, cos, -sin, -uy * seconds],
            [o, o, sin, cos, ux * seconds],
            [o, o, o, o, i],
        ];
        let before = self.covariance;
        let rows = jacobian.map(|row| {
            core::array::from_fn::<S, STATES, _>(|column| {
                sum(row.iter().zip(before.iter().map(|line| line[column])))
            })
        });
        let noise = [PLACE_NOISE_M, PLACE_NOISE_M, VELOCITY_NOISE_MPS, VELOCITY_NOISE_MPS]
            .map(|noise| noise * PER_METRE);
        for (index, line) in self.covariance.iter_mut().enumerate() {
            for (value, row) in line.iter_mut().zip(&jacobian) {
                *value = sum(rows[index].iter().zip(row.iter().copied()));
            }
            let noise = noise.get(index).copied().unwrap_or(TURN_NOISE_RADPS);
            line[index] += S::from_f32(noise * noise);
        }
    }

    /// The standard deviation (m) of the place along a direction.
    pub(super) fn deviation_m(&self, (x, y): (S, S)) -> S {
        self.variance((x, y)).sqrt() * S::from_f32(METRES)
    }

    fn variance(&self, (x, y): (S, S)) -> S {
        let [[xx, xy, ..], [_, yy, ..], ..] = self.covariance;
        // What rounding may leave of it.
        (x * x * xx + (x + x) * y * xy + y * y * yy).max(S::from_f32(1e-5))
    }

    /// The place along a direction is now believed to be `by_m` farther, and to vary by so much of what it did.
    pub(super) fn correct(&mut self, (x, y): (S, S), by_m: S, share: S) {
        let before = self.variance((x, y));
        let gain: [S; STATES] = core::array::from_fn(|state| {
            let line = &self.covariance[state];
            (line[0] * x + line[1] * y) / before
        });
        let by = by_m * S::from_f32(PER_METRE);
        let less = before * (S::ONE - share).clamp(S::ZERO, S::ONE);
        for ((mean, line), &of_row) in self.mean.iter_mut().zip(&mut self.covariance).zip(&gain) {
            *mean += of_row * by;
            for (value, &of_column) in line.iter_mut().zip(&gain) {
                *value -= of_row * of_column * less;
            }
        }
    }

    /// What the speed is at least (m/s), so many standard deviations below what is believed; negative where that is
    /// more than the speed.
    pub(super) fn speed_at_least_mps(&self, deviations: f32) -> S {
        let velocity = self.velocity_mps();
        let speed = S::hypot(velocity.x_m, velocity.y_m).max(S::from_f32(1e-3));
        let (x, y) = (velocity.x_m / speed, velocity.y_m / speed);
        let [_, _, [_, _, xx, xy, _], [_, _, _, yy, _], _] = self.covariance;
        let variance = (x * x * xx + (x + x) * y * xy + y * y * yy).max(S::ZERO);
        speed - variance.sqrt() * S::from_f32(METRES * deviations)
    }
}

fn sum<'a, S: Scalar>(pairs: impl Iterator<Item = (&'a S, S)>) -> S {
    pairs.fold(S::ZERO, |sum, (&a, b)| sum + a * b)
}
