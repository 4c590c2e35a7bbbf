//! The way over the last centimetres: to a target that is near, and to which nothing blocks the way.
//!
//! No source of the peers says how to stop within a millimetre. Here all do it alike, on the arc that ends at the
//! target (the exact inverse, as in [`crate::arc`]), in a time that stands: the speed falls with the distance.

use core::f64::consts::{FRAC_PI_2, PI};

use super::View;
use super::config::ApproachConfig;
use super::robot::{PeerRobot, Twist, free_way};
use crate::khepera::wrapped;

/// A target at a larger bearing than this is turned towards on the spot, in rad: an arc to it would end turned away.
const TURN_FIRST_RAD: f64 = 0.1;
/// Targets behind are backed up to within this distance, in m.
const BACK_UP_M: f64 = 0.02;

/// The motion towards the target; `None` where it is far or something is in between.
#[must_use]
pub fn approach(config: &ApproachConfig, robot: &PeerRobot, view: &View) -> Option<Twist> {
    let target = view.target;
    let radius_m = robot.body_radius_m + config.margin_m;
    let is_near = target.distance_m < config.distance_m;
    // The way there is free if the disc comes as far as the target, less what rounding costs.
    let is_free =
        || free_way(view.points, target.bearing_rad, radius_m, target.distance_m) >= target.distance_m - 1e-9;
    (is_near && is_free()).then(|| towards(config, target.bearing_rad, target.distance_m))
}

fn towards(config: &ApproachConfig, bearing_rad: f64, distance_m: f64) -> Twist {
    let backs_up = distance_m < BACK_UP_M && bearing_rad.abs() > FRAC_PI_2;
    let (bearing, distance) =
        if backs_up { (wrapped(bearing_rad + PI), -distance_m) } else { (bearing_rad, distance_m) };
    if bearing.abs() > TURN_FIRST_RAD {
        return Twist { forward_mps: 0.0, turn_radps: bearing / config.time_s };
    }
    // An arc to bearing α turns the body by 2α on its way.
    Twist { forward_mps: distance / config.time_s, turn_radps: 2.0 * bearing / config.time_s }
}

#[cfg(test)]
mod tests {
    use super::approach;
    use crate::peers::config::ApproachConfig;
    use crate::peers::robot::Twist;
    use crate::peers::testing::{ROBOT, view};
    use nalgebra::Point2;

    fn at(bearing_rad: f64, distance_m: f64, points: &[Point2<f64>]) -> Option<Twist> {
        let mut view = view(&[None; 12], points, bearing_rad);
        view.target.distance_m = distance_m;
        approach(&ApproachConfig::default(), &ROBOT, &view)
    }

    #[test]
    fn only_what_is_near_and_free_is_approached() {
        assert_eq!(at(0.0, 0.2, &[]), None);
        assert_eq!(at(0.0, 0.08, &[Point2::new(0.06, 0.01)]), None);
        assert!(at(0.0, 0.08, &[Point2::new(0.06, 0.04)]).is_some(), "beside the way");
        assert!(at(0.0, 0.02, &[Point2::new(0.06, 0.0)]).is_some(), "behind the target");
    }

    #[test]
    fn it_drives_ahead_turns_aside_and_backs_up() {
        let ahead = at(0.05, 0.01, &[]).unwrap();
        assert!(ahead.forward_mps > 0.0 && ahead.turn_radps > 0.0, "{ahead:?}");
        let aside = at(-1.0, 0.01, &[]).unwrap();
        assert!(aside.forward_mps.abs() < 1e-12 && aside.turn_radps < 0.0, "{aside:?}");
        let behind = at(3.1, 0.01, &[]).unwrap();
        assert!(behind.forward_mps < 0.0, "{behind:?}");
    }
}
