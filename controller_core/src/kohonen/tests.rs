//! Laws of the map for any argument, in both scalars: chart, winner, learning, displacement, schedules.

extern crate std;

use std::vec::Vec;

use super::features::{Command, Features, STRAIGHT_ASIDE_RAD};
use super::lattice::NeuronIndex;
use super::map::{Eligible, Map, Neuron, WinnerParameters};
use super::output::{ControlMatrix, MotorVector, Output};
use super::self_organisation::{Annealing, displacement};
use crate::scalar::{Fixed, Scalar};
use crate::testing::{apart, narrow, wide};
use crate::units::Pose;
use proptest::prelude::*;

fn features<S: Scalar>((bearing, distance): (f32, f32)) -> Features<S> {
    Features { bearing: S::from_f32(bearing), distance: S::from_f32(distance) }
}

fn folding_keeps_the_place<S: Scalar>(bearing: f32, distance: f32) {
    let place = features::<S>((bearing, distance));
    let folded = place.folded();
    let aside = core::f64::consts::FRAC_PI_2 + f64::from(STRAIGHT_ASIDE_RAD);
    assert!(wide(folded.bearing.abs()) <= aside + 1e-5, "{folded:?}");
    let back = folded.unfolded();
    assert!(apart(wide(back.bearing), wide(place.bearing)).abs() < 1e-5, "{place:?} became {back:?}");
    assert_eq!(back.distance, place.distance);
    let point = |at: Features<S>| {
        let (bearing, distance) = (wide(at.bearing), wide(at.distance));
        (distance * bearing.cos(), distance * bearing.sin())
    };
    let ((x, y), (folded_x, folded_y)) = (point(place), point(folded));
    assert!((x - folded_x).hypot(y - folded_y) < 2e-5, "another point: {place:?}, {folded:?}");
}

fn the_winner_is_the_nearest_of_the_closest_bearings<S: Scalar>(
    weights: &[(f32, f32, bool)],
    place: (f32, f32),
    turns: i8,
) {
    let mut map = Map::<S, ControlMatrix<S::Weight>, 5, 4>::regular();
    let lattice = (0..5).flat_map(|column| (0..4).map(move |row| NeuronIndex { column, row }));
    for (index, &(bearing, distance, has_won)) in lattice.zip(weights) {
        let weight = |value| S::from_f32(value).to_weight();
        let neuron = Neuron { bearing: weight(bearing), distance: weight(distance), ..Neuron::default() };
        map.set_neuron(index, neuron, has_won);
    }
    let p = WinnerParameters {
        bearing_tolerance: S::from_f32(0.1),
        bearing_weight: S::from_f32(1.5),
        distance_weight: S::from_f32(0.75),
        eligible: Eligible::Trained,
    };
    // A whole turn more or less is the same place.
    let turned = place.0 + f32::from(turns) * core::f32::consts::TAU;
    let winner = map.winner(&p, features::<S>((turned, place.1)), Eligible::Trained);
    let off = |at: Features<S>| apart(f64::from(place.0), wide(at.bearing)).abs();
    let squared =
        |at: Features<S>| 1.5 * off(at).powi(2) + 0.75 * (f64::from(place.1) - wide(at.distance)).powi(2);
    let trained: Vec<Features<S>> = map.places(Eligible::Trained).map(|(_, at)| at).collect();
    let Some(winner) = winner else {
        assert!(trained.is_empty(), "somebody must win");
        return;
    };
    assert!(map.has_won(winner), "an untrained neuron has won");
    let limit = trained.iter().map(|&at| off(at)).fold(f64::INFINITY, f64::min) + 0.1;
    let chosen = map.place(winner);
    assert!(off(chosen) <= limit + 1e-5, "{chosen:?} is not in A(α)");
    for &rival in trained.iter().filter(|&&at| off(at) < limit - 1e-5) {
        assert!(squared(chosen) <= squared(rival) + 1e-4, "{rival:?} is nearer than {chosen:?}");
    }
}

fn learning_reduces_the_error<S: Scalar>(first: [f32; 4], at: (f32, f32), executed: (f32, f32), rate: f32) {
    let weight = |value: f32| S::from_f32(value).to_weight();
    let [a, b, c, d] = first.map(weight);
    let executed = Command { left: S::from_f32(executed.0), right: S::from_f32(executed.1) };
    let v = features::<S>(at);
    let error =
        |said: Command<S>| [wide(executed.left) - wide(said.left), wide(executed.right) - wide(said.right)];
    let power = f64::from(at.0).powi(2) + f64::from(at.1).powi(2);
    let regularisation = 0.02;
    // The normalised step takes away just this share of the error at v.
    let left_over = 1.0 - f64::from(rate) * power / (power + regularisation);
    let mut matrix = ControlMatrix { left: [a, b], right: [c, d] };
    let before = error(Output::<S>::command(&matrix, v));
    matrix.learn(v, executed, S::from_f32(rate), Some(S::from_f32(narrow(regularisation))));
    let after = error(Output::<S>::command(&matrix, v));
    // Two weights, each rounded to 2⁻¹³ in storage, times a |v| below 2.2.
    let tolerance = 8e-4;
    for (before, after) in before.iter().zip(after) {
        assert!((after - left_over * before).abs() < tolerance, "{before} became {after}, not × {left_over}");
    }
    let mut vector = MotorVector { left: a, right: b };
    let before = error(Output::<S>::command(&vector, v));
    vector.learn(v, executed, S::from_f32(rate), None);
    for (before, after) in before.iter().zip(error(Output::<S>::command(&vector, v))) {
        assert!((after - (1.0 - f64::from(rate)) * before).abs() < tolerance, "{before} became {after}");
    }
}

fn the_displacement_of_an_arc_is_its_chord<S: Scalar>(
    start: (f32, f32, f32),
    way: f32,
    turn: f32,
    drift: f32,
) {
    let pose = |x: f64, y: f64, heading: f64| Pose {
        x_m: S::from_f32(narrow(x)),
        y_m: S::from_f32(narrow(y)),
        heading_rad: crate::units::wrap(S::from_f32(narrow(heading))),
    };
    let (x, y, heading) = (f64::from(start.0), f64::from(start.1), f64::from(start.2));
    let half = f64::from(turn) / 2.0;
    let chord = if half.abs() < 1e-6 { f64::from(way) } else { f64::from(way) * half.sin() / half };
    let (sin, cos) = (heading + half).sin_cos();
    let end = pose(x + chord * cos, y + chord * sin, heading + 2.0 * half);
    // The encoders are off by some slip; the poses are right.
    let v = displacement(pose(x, y, heading), end, S::from_f32(turn + drift));
    assert!((wide(v.bearing_rad) - half).abs() < 1e-5, "half the turn: {} for {half}", wide(v.bearing_rad));
    if chord.abs() > 1e-4 {
        assert!(
            (wide(v.distance_m) - chord).abs() < 1e-5,
            "signed chord: {} for {chord}",
            wide(v.distance_m)
        );
    }
}

fn annealing_falls_from_first_to_last<S: Scalar>(first: f32, ratio: f32, steps: u16) {
    let last = first * ratio;
    let annealing = Annealing::<S>::new(first, last, steps);
    assert_eq!(annealing.at(0), S::from_f32(first));
    assert_eq!(annealing.at(u32::from(steps)), S::from_f32(last));
    assert_eq!(annealing.at(u32::MAX), S::from_f32(last));
    let rate = f64::from(ratio).ln() / f64::from(steps);
    let mut before = annealing.at(0);
    for step in (0..=u32::from(steps)).step_by(usize::from(steps / 200 + 1)) {
        let now = annealing.at(step);
        assert!(now <= before, "rises at {step} of {steps}");
        before = now;
        let exact = f64::from(first) * (rate * f64::from(step)).exp();
        let error = (wide(now) - exact).abs();
        assert!(error < 0.005 * exact + 1e-5, "{} at {step} of {steps}, not {exact}", wide(now));
    }
}

proptest! {
    #[test]
    fn chart(bearing in -3.1_f32..3.1, distance in 0.0_f32..8.0) {
        folding_keeps_the_place::<f32>(bearing, distance);
        folding_keeps_the_place::<Fixed>(bearing, distance);
    }

    #[test]
    fn winner(
        weights in proptest::collection::vec((-1.6_f32..1.6, -0.3_f32..1.1, any::<bool>()), 20),
        place in (-3.0_f32..3.0, -0.3_f32..4.0),
        turns in -1_i8..=1,
    ) {
        the_winner_is_the_nearest_of_the_closest_bearings::<f32>(&weights, place, turns);
        the_winner_is_the_nearest_of_the_closest_bearings::<Fixed>(&weights, place, turns);
    }

    #[test]
    fn learning(
        first in [-2.0_f32..2.0, -2.0_f32..2.0, -2.0_f32..2.0, -2.0_f32..2.0],
        at in (-1.57_f32..1.57, -0.3_f32..1.1),
        executed in (-1.0_f32..1.0, -1.0_f32..1.0),
        rate in 0.0_f32..1.0,
    ) {
        learning_reduces_the_error::<f32>(first, at, executed, rate);
        learning_reduces_the_error::<Fixed>(first, at, executed, rate);
    }

    #[test]
    fn arcs(
        start in (-2.0_f32..2.0, -2.0_f32..2.0, -3.1_f32..3.1),
        way in -0.2_f32..0.2,
        turn in -6.0_f32..6.0,
        drift in -0.6_f32..0.6,
    ) {
        the_displacement_of_an_arc_is_its_chord::<f32>(start, way, turn, drift);
        the_displacement_of_an_arc_is_its_chord::<Fixed>(start, way, turn, drift);
    }

    #[test]
    fn schedules(first in 0.01_f32..5.0, ratio in 0.02_f32..1.0, steps in 1_u16..=u16::MAX) {
        annealing_falls_from_first_to_last::<f32>(first, ratio, steps);
        annealing_falls_from_first_to_last::<Fixed>(first, ratio, steps);
    }
}
