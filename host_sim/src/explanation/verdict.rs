//! What decided, in words.

use controller_core::integration::neural::backwards;
use controller_core::kohonen::lattice::NeuronIndex;
use controller_core::localisation::mover::Mover;
use controller_core::localisation::separation::Moving;
use controller_core::scalar::Scalar;
use controller_core::units::{Point, Polar};

use super::{DecisionReport, Moment, NeuronActivity, Place};

/// Says what decided: one sentence or two.
#[must_use]
pub(super) fn verdict<S: Scalar>(moment: &Moment<S>, report: &DecisionReport) -> Vec<String> {
    if report.checkpoint.is_none() {
        return vec![String::from("no checkpoint is ahead: the robot stands")];
    }
    if let Some(fusion) = report.fusion {
        return vec![match fusion.avoidance {
            None => {
                String::from("no obstacle is near enough to be avoided: the command for the target stands")
            }
            Some(_) => format!(
                "{:.0} % of the command for the target and {:.0} % of the command away from obstacles",
                fusion.target_share * 100.0,
                (1.0 - fusion.target_share) * 100.0
            ),
        }];
    }
    let Some(winner) = report.winner else {
        return vec![String::from("no neuron is trained: the robot stands")];
    };
    let mut sentences = Vec::new();
    let own = report.field.map(|field| field.winner);
    let own = own.and_then(|own| report.neurons.iter().find(|neuron| neuron.neuron == own));
    if let Some(own) = own.filter(|own| own.neuron != winner.neuron || winner.backwards) {
        sentences.push(format!("the target's own neuron {}", lost(moment, own)));
    }
    if let Some(second) = report.runner_up {
        sentences.push(against(moment, &winner, &second));
    }
    sentences
}

/// A neuron as people name it.
fn name(of: &NeuronActivity) -> String {
    let NeuronIndex { column, row } = of.neuron;
    format!("({column}, {row}){}", if of.backwards { " backwards" } else { "" })
}

/// A place as people say it.
pub(super) fn at(place: Place) -> String {
    let place = place.unfolded();
    format!("at {:.1} cm, {:.0}°", place.distance_m * 100.0, place.bearing_rad.to_degrees())
}

/// The winner against the second.
fn against(moment: &Moment<impl Scalar>, winner: &NeuronActivity, second: &NeuronActivity) -> String {
    let (winners, by) = (name(winner), winner.total - second.total);
    let nearer = winner.target - second.target;
    let inhibited = (second.obstacles - winner.obstacles).max(second.way - winner.way);
    if by <= 0.0 {
        return format!(
            "{winners} and {} are equal after all inhibition: the one with more activity before its way was checked, \
             or the first on the lattice, wins",
            name(second)
        );
    }
    let reason = if nearer >= inhibited {
        format!("{} has {nearer:.4} less of the target field", name(second))
    } else {
        lost(moment, second)
    };
    format!("{winners} wins by {by:.4}: the second, {reason}")
}

/// What took most of a neuron's activity.
fn lost<S: Scalar>(moment: &Moment<S>, neuron: &NeuronActivity) -> String {
    let place = moment.core.map().place(neuron.neuron);
    let who = name(neuron);
    let (fields, ways) = (neuron.obstacles - neuron.separation, neuron.way);
    let most = fields.max(ways).max(neuron.separation);
    if most <= 0.0 {
        format!("{who}, lost nothing to obstacles")
    } else if ways >= most {
        let ahead = moment.stride(neuron.neuron);
        let stride = if neuron.backwards { backwards(place) } else { None };
        let place = stride.unwrap_or(ahead).place;
        let to = |point: Point<S>| (point.to_polar(), moment.point_inhibition(point, place));
        let stands = moment.ways.points().map(to).reduce(larger);
        let to = |mover: &Mover<S>| (mover.at.to_polar(), moment.mover_inhibition(*mover, place));
        let moves = moment.ways.movers().iter().map(to).reduce(larger);
        let moves_more = match (stands, moves) {
            (Some(stands), Some(moves)) => moves.1 > stands.1,
            (stands, _) => stands.is_none(),
        };
        let crowding = moment.crowding(place);
        let other = [stands, moves].into_iter().flatten().map(|(_, taken)| taken).fold(S::ZERO, S::max);
        if crowding > other {
            format!("{who}, lost {ways:.4} because it ends as near to what is too near already")
        } else if moves_more {
            let at = worst(moves.into_iter());
            format!("{who}, lost {ways:.4} because its way would meet what moves{at}")
        } else {
            let at = worst(stands.into_iter());
            format!("{who}, lost {ways:.4} because its way passes too near to the obstacle{at}")
        }
    } else if neuron.separation >= most {
        let to = |other: &Moving<S>| (other.at.to_polar(), moment.separation(other, place));
        format!(
            "{who}, lost {most:.4} to the fields of other robots, most to the one{}",
            worst(moment.others.iter().map(to))
        )
    } else {
        let to = |(_, sensed)| (sensed, moment.field_inhibition(sensed, place));
        let at = worst(moment.sensed().map(to));
        format!("{who}, lost {fields:.4} to obstacle fields, most to the obstacle{at}")
    }
}

/// Which of two takes more.
fn larger<S: Scalar>(a: (Polar<S>, S), b: (Polar<S>, S)) -> (Polar<S>, S) {
    if b.1 > a.1 { b } else { a }
}

/// Where the one is that takes most.
fn worst<S: Scalar>(each: impl Iterator<Item = (Polar<S>, S)>) -> String {
    each.reduce(larger).map_or_else(String::new, |(place, _)| format!(" {}", at(Place::of(place))))
}
