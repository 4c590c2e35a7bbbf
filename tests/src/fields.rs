//! P2 Eq. 1–10 in `f64`, written from the papers' equations and not from the core.
//!
//! The core's additions (swept path, memory, movers, detour) are not here; it is the literal form. Where the papers
//! leave something open, the meaning is the core's documented one: A(α) admits neurons up to a tolerance beyond the
//! closest bearing, and distances are measured in units of the reach.

use core::f64::consts::{FRAC_PI_2, PI};

/// As the core's, a choice of ours: so far beyond ±90° a bearing still counts as ahead.
const STRAIGHT_ASIDE_RAD: f64 = 1e-3;

/// A place: bearing in rad, distance in units of the reach (negative: behind, see
/// `controller_core::kohonen::features`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// α.
    pub bearing: f64,
    /// d.
    pub distance: f64,
}

/// A neuron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Neuron {
    /// `w_i`.
    pub weight: Place,
    /// `M_i`, rows for the left and the right wheel.
    pub matrix: [[f64; 2]; 2],
}

/// The widths, in rad and units of the reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Widths {
    /// Peak of the target field.
    pub amplitude: f64,
    /// `σ_aα`.
    pub target_bearing: f64,
    /// `σ_ad`.
    pub target_distance: f64,
    /// `σ_bα`.
    pub obstacle_bearing: f64,
    /// `σ_bd` at and behind the obstacle.
    pub obstacle_behind: f64,
    /// `σ_bd` in front of it.
    pub obstacle_front: f64,
    /// How much farther than the closest bearing A(α) reaches, in rad.
    pub tolerance: f64,
}

/// An index, and by how much it won against the second best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winner {
    /// Which neuron.
    pub index: usize,
    /// The smallest change of a compared number that could have made another one win.
    pub margin: f64,
}

/// The angle from `from` to `to`, in ±π.
#[must_use]
pub fn turn(from: f64, to: f64) -> f64 {
    (to - from).sin().atan2((to - from).cos())
}

impl Place {
    /// The place with a distance ≥ 0, as an obstacle is seen.
    #[must_use]
    pub fn seen(self) -> Self {
        if self.distance < 0.0 {
            Self { bearing: turn(0.0, self.bearing + PI), distance: -self.distance }
        } else {
            self
        }
    }

    /// The place with a bearing within ±90°, as the map holds it: behind the robot with a distance < 0.
    #[must_use]
    pub fn charted(self) -> Self {
        if self.is_ahead() {
            self
        } else {
            Self { bearing: turn(0.0, self.bearing + PI), distance: -self.distance }
        }
    }

    /// Whether it is ahead, where the map's chart and the full circle agree; straight aside is.
    #[must_use]
    pub fn is_ahead(self) -> bool {
        self.bearing.abs() <= FRAC_PI_2 + STRAIGHT_ASIDE_RAD
    }
}

/// Eq. 1–3: of the neurons whose bearing is (nearly) closest, the one at the smallest distance.
///
/// # Panics
/// If there is no neuron.
#[must_use]
pub fn localise(neurons: &[Neuron], widths: &Widths, place: Place) -> Winner {
    let off = |neuron: &Neuron| turn(neuron.weight.bearing, place.bearing);
    let closest = neurons.iter().map(|neuron| off(neuron).abs()).fold(f64::INFINITY, f64::min);
    let limit = closest + widths.tolerance;
    let squared = |neuron: &Neuron| off(neuron).powi(2) + (place.distance - neuron.weight.distance).powi(2);
    let admitted = neurons.iter().enumerate().filter(|(_, neuron)| off(neuron).abs() <= limit);
    let (index, best) =
        admitted.min_by(|a, b| squared(a.1).total_cmp(&squared(b.1))).expect("some are closest");
    let least = squared(best);
    let rivals = neurons.iter().enumerate().filter(|&(rival, _)| rival != index);
    let margin = rivals.map(|(_, rival)| {
        // A rival needs to be admitted, and to be nearer; both must be missed by little for the winner to be in
        // doubt.
        (off(rival).abs() - limit).max(squared(rival) - least)
    });
    let doubt = (limit - off(best).abs()).min(margin.fold(f64::INFINITY, f64::min));
    Winner { index, margin: doubt }
}

/// Eq. 4, 5: the target field of a winner s at a neuron.
#[must_use]
pub fn target_field(widths: &Widths, s: Place, at: Place) -> f64 {
    let bearing = turn(s.bearing, at.bearing).powi(2) / (2.0 * widths.target_bearing.powi(2));
    let distance = (s.distance - at.distance).powi(2) / (2.0 * widths.target_distance.powi(2));
    widths.amplitude * (-(bearing + distance)).exp()
}

/// Eq. 6, 7: the obstacle field of a winner s at a neuron.
#[must_use]
pub fn obstacle_field(widths: &Widths, s: Place, at: Place) -> f64 {
    let at = at.seen();
    let sigma = if at.distance >= s.distance { widths.obstacle_behind } else { widths.obstacle_front };
    let bearing = turn(s.bearing, at.bearing).powi(2) / (2.0 * widths.obstacle_bearing.powi(2));
    let distance = (s.distance - at.distance).powi(2) / (2.0 * sigma.powi(2));
    (-(bearing + distance)).exp()
}

/// Eq. 8: `e_i` of all neurons, given the target's winner and the obstacles' centres.
#[must_use]
pub fn activities(neurons: &[Neuron], widths: &Widths, s: usize, obstacles: &[Place]) -> Vec<f64> {
    let centre = neurons[s].weight;
    let inhibition = |at| obstacles.iter().map(|&obstacle| obstacle_field(widths, obstacle, at)).sum::<f64>();
    neurons.iter().map(|i| target_field(widths, centre, i.weight) - inhibition(i.weight)).collect()
}

/// Eq. 9: `argmax e_i`.
///
/// # Panics
/// If there is no neuron.
#[must_use]
pub fn strongest(activities: &[f64]) -> Winner {
    let index =
        (0..activities.len()).max_by(|&a, &b| activities[a].total_cmp(&activities[b])).expect("not empty");
    let rivals = activities.iter().enumerate().filter(|&(rival, _)| rival != index);
    let second = rivals.map(|(_, &e)| e).fold(f64::NEG_INFINITY, f64::max);
    Winner { index, margin: activities[index] - second }
}

/// Eq. 10: `M_k u_p` where that is within ±1 and k = s, else `M_k w_k` (scaled into ±1, should it not be).
#[must_use]
pub fn command(neurons: &[Neuron], k: usize, s: usize, target: Place) -> [f64; 2] {
    let neuron = neurons[k];
    let times = |u: Place| neuron.matrix.map(|row| row[0] * u.bearing + row[1] * u.distance);
    let wished = times(target);
    if k == s && wished.iter().all(|wheel| wheel.abs() <= 1.0) {
        return wished;
    }
    let own = times(neuron.weight);
    let largest = own[0].abs().max(own[1].abs()).max(1.0);
    own.map(|wheel| wheel / largest)
}
