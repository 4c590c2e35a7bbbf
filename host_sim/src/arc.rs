//! The inverse that the map has to learn, worked out in `f64`: the arc that ends at the target. A reference, which no
//! controller uses.
//!
//! A differential drive at constant wheel speeds moves on a circle. The chord to a place at bearing α and distance d
//! belongs to an arc of length d · α / sin α on which the body turns by 2α. This robot has no inertia and no noise,
//! so it is a lower bound of what a trained map can do, under the same rules (half the bearing for far places,
//! turning on the spot for places behind or near and aside, nothing beyond c*, speeds in whole units).

use nalgebra::Point2;

use crate::positioning::{Approach, TargetResult};

/// What the reference needs to know of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcRobot {
    /// Distance between the wheels in m.
    pub wheel_base_m: f64,
    /// Longest way of a wheel in one step, in m.
    pub reach_m: f64,
    /// Places beyond this share of the reach are far.
    pub far_share: f64,
    /// Places behind within this share of the reach are backed up to.
    pub behind_share: f64,
    /// Places within this share of the reach are near.
    pub near_share: f64,
    /// A near place at a larger bearing than this is turned towards first.
    pub near_bearing_rad: f64,
    /// Ways are whole multiples of this, in m; 0 where there is no such unit.
    pub unit_m: f64,
    /// The goal is reached only where the centre's way in a step is at most this, in m.
    pub goal_way_m: f64,
}

/// Position and heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Centre of the body.
    pub position: Point2<f64>,
    /// Heading, anticlockwise from +x, in rad.
    pub heading_rad: f64,
}

/// An angle in ±π.
#[must_use]
pub fn wrapped(angle_rad: f64) -> f64 {
    angle_rad.sin().atan2(angle_rad.cos())
}

impl Place {
    /// Bearing and distance of a point.
    #[must_use]
    pub fn see(&self, target: Point2<f64>) -> (f64, f64) {
        let to = target - self.position;
        (wrapped(to.y.atan2(to.x) - self.heading_rad), to.norm())
    }

    /// The place after the wheels have rolled these ways, in m.
    #[must_use]
    pub fn after(&self, (left_m, right_m): (f64, f64), wheel_base_m: f64) -> Self {
        let turn = (right_m - left_m) / wheel_base_m;
        let way = f64::midpoint(left_m, right_m);
        let half = turn / 2.0;
        let chord = if half.abs() < 1e-9 { way } else { way * half.sin() / half };
        let (sin, cos) = (self.heading_rad + half).sin_cos();
        let position = self.position + nalgebra::Vector2::new(cos, sin) * chord;
        Self { position, heading_rad: wrapped(self.heading_rad + turn) }
    }
}

impl ArcRobot {
    /// The ways of the left and right wheel, in m, of one step towards a place seen at bearing and distance.
    #[must_use]
    pub fn ways(&self, bearing_rad: f64, distance_m: f64) -> (f64, f64) {
        let far_m = self.far_share * self.reach_m;
        let is_behind = bearing_rad.abs() > core::f64::consts::FRAC_PI_2;
        let (bearing, distance) = if distance_m > far_m {
            (bearing_rad / 2.0, far_m)
        } else if !is_behind {
            (bearing_rad, distance_m)
        } else if distance_m <= self.behind_share * self.reach_m {
            (wrapped(bearing_rad + core::f64::consts::PI), -distance_m)
        } else {
            (bearing_rad / 2.0, 0.0)
        };
        let is_near = distance_m < self.near_share * self.reach_m;
        let (bearing, distance) = if is_near && bearing.abs() > self.near_bearing_rad {
            (bearing / 2.0, 0.0)
        } else {
            (bearing, distance)
        };
        let stretch = if bearing.abs() < 1e-9 { 1.0 } else { bearing / bearing.sin() };
        let turning = bearing * self.wheel_base_m;
        let room = (self.reach_m - turning.abs()).max(0.0);
        let way = (distance * stretch).clamp(-room, room);
        (self.whole(way - turning), self.whole(way + turning))
    }

    /// The nearest way that there is.
    fn whole(&self, way_m: f64) -> f64 {
        if self.unit_m > 0.0 { (way_m / self.unit_m).round() * self.unit_m } else { way_m }
    }

    /// Drives to `target`, and stops as soon as it is slow and nearer than `stop_m`, or where its way is rounded to
    /// none; gives up after `steps_max` steps. With the place where it then is.
    #[must_use]
    pub fn approach(
        &self,
        from: Place,
        target: Point2<f64>,
        stop_m: f64,
        steps_max: u32,
    ) -> (TargetResult, Place) {
        /// Parts of a step at which the distance is looked at.
        const PARTS: u32 = 256;
        let straight_m = (target - from.position).norm();
        let (mut place, mut way) = (from, Approach::NEW);
        for step in 0..steps_max {
            let (bearing, distance) = place.see(target);
            let (left, right) = self.ways(bearing, distance);
            if left == 0.0 && right == 0.0 {
                return (way.end(distance, straight_m, f64::from(step), true), place);
            }
            let is_slow = f64::midpoint(left, right).abs() <= self.goal_way_m;
            for part in 0..=PARTS {
                let share = f64::from(part) / f64::from(PARTS);
                let here = place.after((left * share, right * share), self.wheel_base_m);
                let (distance, steps) = ((target - here.position).norm(), f64::from(step) + share);
                way.see(distance, steps);
                if is_slow && distance < stop_m {
                    return (way.end(distance, straight_m, steps, true), here);
                }
            }
            place = place.after((left, right), self.wheel_base_m);
        }
        let error_m = (target - place.position).norm();
        (way.end(error_m, straight_m, f64::from(steps_max), false), place)
    }
}
