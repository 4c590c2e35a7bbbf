//! Robot separation: other robots' positions, known by communication, become a third kind of field.
//!
//! P2 names the module beside target reaching and obstacle avoidance and says no more of it; what follows is ours. Each
//! robot tells the others now and then where it is and how it moves ([`Report`]). Between two reports the others are
//! carried on along their way. They act twice, like obstacles:
//!
//! * **Field** ([`field`]): a Gaussian over the neurons around the bearing under which the other will be seen shortly,
//!   the stronger the narrower the gap between the bodies. Its centre is shifted to the left, so that among equals
//!   the way to the right is freer: two robots head-on both give way to the right, and robots that cross at one
//!   point go around it the same way, without a rule of who goes first.
//! * **Swept path in time** ([`inhibition`]): where the other will be at each moment of a step is held against where the
//!   own body will be then. Sensors, too, see other robots, but take them for standing still.
//!
//! A report counts the less the older it is, and is forgotten after [`SeparationParameters::lifetime_ms`].

use heapless::Vec;

use crate::integration::sweep::way;
use crate::kohonen::features::Features;
use crate::scalar::Scalar;
use crate::schedule::Tick;
use crate::units::{Point, Polar, Pose, angle_between, wrap};

/// Other robots that are held at a time; of more, the nearest.
pub const OTHERS: usize = 3;

/// What a robot tells the others of itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Report<S> {
    /// Who: a number that no other robot has.
    pub robot: u8,
    /// Where its centre was (world).
    pub at: Point<S>,
    /// How it moved (world, m/s).
    pub velocity_mps: Point<S>,
    /// How long ago that was when the report is taken over.
    pub age_ms: u16,
}

/// How other robots are kept away from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparationParameters<S> {
    /// Reports older than this are forgotten (ms); 0 switches separation off.
    pub lifetime_ms: u16,
    /// 1 / lifetime (per ms).
    pub per_lifetime: S,
    /// The field is centred where the other will be in so many seconds.
    pub horizon_s: S,
    /// Peak of the field, for bodies that touch.
    pub amplitude: S,
    /// 1 / (√2 σ) of the field in bearing (per rad).
    pub bearing_steepness: S,
    /// 1 / (√2 σ) of the gap between the bodies (per m).
    pub gap_steepness: S,
    /// How far the centre of the field is shifted to the left (rad).
    pub keep_right_rad: S,
    /// Distance between the centres of two bodies that touch (m).
    pub touch_m: S,
    /// Clearance wished between two bodies (m).
    pub margin_m: S,
    /// 1 / margin (per m).
    pub per_margin: S,
    /// Inhibition for a lack of clearance as long as the margin; 0 switches this check off.
    pub strength: S,
    /// Duration of a step of the map (s).
    pub step_s: S,
}

/// Another robot as it was last heard of.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Other<S: Scalar> {
    at: Point<S>,
    /// World x and y, in the bits of a weight: a board has little memory, and no robot of this kind does 8 m/s.
    velocity_mps: [S::Weight; 2],
    /// The lowest bits of the tick at which it was there.
    tick: u16,
    robot: u8,
}

/// The other robots that are known of, at most `COUNT`.
#[derive(Clone, Debug, PartialEq)]
pub struct Others<S: Scalar, const COUNT: usize> {
    known: Vec<Other<S>, COUNT>,
}

impl<S: Scalar, const COUNT: usize> Default for Others<S, COUNT> {
    fn default() -> Self {
        Self::NONE
    }
}

/// Another robot, seen from this one: robot frame, where it is by now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moving<S> {
    /// Where its centre is.
    pub at: Point<S>,
    /// How it moves (m/s).
    pub velocity_mps: Point<S>,
    /// How much its report still counts, 1 to 0.
    pub weight: S,
}

/// The lowest 16 bits of a tick: ages up to a minute follow from them.
fn low_bits(tick: Tick) -> u16 {
    u16::try_from(tick & 0xFFFF).unwrap_or(u16::MAX)
}

fn age_ms<S: Scalar>(other: &Other<S>, now: Tick) -> u16 {
    low_bits(now).wrapping_sub(other.tick)
}

impl<S: Scalar, const COUNT: usize> Others<S, COUNT> {
    /// Nobody is known of.
    pub const NONE: Self = Self { known: Vec::new() };

    /// Takes over a report; the last of each robot counts. Where there is no room, the farthest from `here` goes.
    pub fn hear(&mut self, here: Point<S>, now: Tick, report: &Report<S>) {
        let velocity_mps = [report.velocity_mps.x_m.to_weight(), report.velocity_mps.y_m.to_weight()];
        let tick = low_bits(now).wrapping_sub(report.age_ms);
        let heard = Other { at: report.at, velocity_mps, tick, robot: report.robot };
        if let Some(other) = self.known.iter_mut().find(|other| other.robot == report.robot) {
            *other = heard;
        } else if let Err(heard) = self.known.push(heard) {
            let distance = |other: &Other<S>| other.at.distance_to(here);
            let others = self.known.iter_mut();
            if let Some(farthest) = others.reduce(|a, b| if distance(b) > distance(a) { b } else { a })
                && distance(&heard) < distance(farthest)
            {
                *farthest = heard;
            }
        }
    }

    /// Forgets what is too old; to be called more often than once a minute.
    pub fn forget(&mut self, p: &SeparationParameters<S>, now: Tick) {
        self.known.retain(|other| age_ms(other, now) < p.lifetime_ms);
    }

    /// Forgets everybody.
    pub fn clear(&mut self) {
        self.known.clear();
    }

    /// Nobody is known of.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// The others as they are by now, seen from `pose`.
    #[must_use]
    pub fn seen_from(&self, p: &SeparationParameters<S>, pose: Pose<S>, now: Tick) -> Vec<Moving<S>, COUNT> {
        let mut seen = Vec::new();
        let (sin, cos) = pose.heading_rad.sin_cos();
        for other in &self.known {
            let age = S::from_i32(i32::from(age_ms(other, now)));
            let [x, y] = other.velocity_mps.map(S::from_weight);
            let age_s = age * S::from_f32(0.001);
            let at = Point { x_m: other.at.x_m + x * age_s, y_m: other.at.y_m + y * age_s };
            let moving = Moving {
                at: pose.to_robot_frame(at, (sin, cos)),
                velocity_mps: Point { x_m: x * cos + y * sin, y_m: y * cos - x * sin },
                weight: (S::ONE - age * p.per_lifetime).max(S::ZERO),
            };
            // As many as are known.
            let _ = seen.push(moving);
        }
        seen
    }
}

impl<S: Scalar> Moving<S> {
    /// A point that a sensor sees may well be this robot: nearer to its centre than a body's diameter, half of which is
    /// left for noise and the width of a beam.
    #[must_use]
    pub fn is_at(&self, p: &SeparationParameters<S>, point: Point<S>) -> bool {
        self.at.distance_to(point) < p.touch_m
    }

    /// Where it will be after so many seconds.
    fn after(&self, seconds: S) -> Point<S> {
        Point {
            x_m: self.at.x_m + self.velocity_mps.x_m * seconds,
            y_m: self.at.y_m + self.velocity_mps.y_m * seconds,
        }
    }
}

/// The centre and the peak of another robot's field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparationField<S> {
    /// Bearing of the centre (rad).
    pub bearing_rad: S,
    /// The field there.
    pub peak: S,
}

/// The field of another robot.
#[must_use]
pub fn field<S: Scalar>(p: &SeparationParameters<S>, other: &Moving<S>) -> SeparationField<S> {
    let soon = other.after(p.horizon_s).to_polar();
    let now = S::hypot(other.at.x_m, other.at.y_m);
    // Whichever is nearer: one that goes away is no matter sooner than it is gone.
    let gap = (soon.distance_m.min(now) - p.touch_m).max(S::ZERO) * p.gap_steepness;
    SeparationField {
        bearing_rad: wrap(soon.bearing_rad + p.keep_right_rad),
        peak: p.amplitude * other.weight * (gap * gap).exp_neg(),
    }
}

impl<S: Scalar> SeparationField<S> {
    /// What the field takes of a neuron whose unfolded place this is.
    #[must_use]
    pub fn activity(&self, p: &SeparationParameters<S>, place: Features<S>) -> S {
        let bearing = angle_between(self.bearing_rad, place.bearing) * p.bearing_steepness;
        self.peak * (bearing * bearing).exp_neg()
    }
}

/// The lack of clearance from another robot on the way to `place`, as inhibition ≥ 0.
///
/// Only moments count at which the two are nearer to each other than now: robots that are too close may always part.
#[must_use]
pub fn inhibition<S: Scalar>(
    p: &SeparationParameters<S>,
    place: Polar<S>,
    look_ahead: S,
    other: &Moving<S>,
) -> S {
    let safe = p.touch_m + p.margin_m;
    let now = S::hypot(other.at.x_m, other.at.y_m);
    let (way, chord_s) = way(place, look_ahead);
    let mut elapsed_s = S::ZERO;
    let mut worst = S::ZERO;
    for at in way {
        elapsed_s += chord_s * p.step_s;
        let there = other.after(elapsed_s);
        let (dx, dy) = (there.x_m - at.x_m, there.y_m - at.y_m);
        if dx.abs() < safe && dy.abs() < safe {
            let distance = S::hypot(dx, dy);
            worst = worst.max((safe - distance).min(now - distance));
        }
    }
    worst * p.per_margin * p.strength * other.weight
}

#[cfg(test)]
mod tests {
    use super::{Moving, Others, Report, SeparationParameters, field, inhibition};
    use crate::kohonen::features::Features;
    use crate::scalar::{Fixed, Scalar};
    use crate::units::{Point, Polar, Pose};

    fn parameters<S: Scalar>() -> SeparationParameters<S> {
        let s = S::from_f32;
        SeparationParameters {
            lifetime_ms: 1000,
            per_lifetime: s(0.001),
            horizon_s: s(1.0),
            amplitude: s(0.04),
            bearing_steepness: s(1.0),
            gap_steepness: s(5.0),
            keep_right_rad: s(0.2),
            touch_m: s(0.05),
            margin_m: s(0.01),
            per_margin: s(100.0),
            strength: s(2.0),
            step_s: S::ONE,
        }
    }

    fn report<S: Scalar>(robot: u8, x_m: f32, age_ms: u16) -> Report<S> {
        let velocity_mps = Point::from_metres(-0.1, 0.0);
        Report { robot, at: Point::from_metres(x_m, 0.0), velocity_mps, age_ms }
    }

    fn check_reports<S: Scalar>() {
        let p = parameters::<S>();
        let here = Point::default();
        // Across the place where the stored bits of the tick wrap around.
        let now = 0x1_0010;
        let mut others = Others::<S, 2>::default();
        others.hear(here, now, &report(1, 0.5, 0));
        others.hear(here, now + 100, &report(1, 0.4, 200));
        let quarter = Pose { heading_rad: S::PI * S::HALF, ..Pose::default() };
        let seen = others.seen_from(&p, quarter, now + 100);
        assert_eq!(seen.len(), 1, "the last report of each counts");
        let Moving { at, velocity_mps, weight } = seen[0];
        // 0.4 m, and 0.2 s at 0.1 m/s towards us; the robot looks along y, so it is on the right.
        assert!((at.y_m.to_f32() + 0.38).abs() < 1e-3 && at.x_m.to_f32().abs() < 1e-3, "{at:?}");
        assert!((velocity_mps.y_m.to_f32() - 0.1).abs() < 1e-3, "{velocity_mps:?}");
        assert!((weight.to_f32() - 0.8).abs() < 1e-3, "{weight:?}");
        others.hear(here, now + 100, &report(2, 0.9, 0));
        others.hear(here, now + 100, &report(3, 0.6, 0));
        let nearest = |others: &Others<S, 2>| {
            others.seen_from(&p, Pose::default(), now + 100).iter().fold(0.0, |most, other| {
                let x = other.at.x_m.to_f32();
                if x > most { x } else { most }
            })
        };
        assert!((nearest(&others) - 0.6).abs() < 1e-3, "of three, the nearest two");
        others.forget(&p, now + 899);
        assert!(!others.is_empty());
        others.forget(&p, now + 1100);
        assert!(others.is_empty());
    }

    #[test]
    fn reports_are_carried_on_fade_and_are_forgotten() {
        check_reports::<f32>();
        check_reports::<Fixed>();
    }

    fn check_acts<S: Scalar>() {
        let (p, s) = (parameters::<S>(), S::from_f32);
        let moving = |x, y, vx, vy| Moving {
            at: Point::from_metres(x, y),
            velocity_mps: Point::from_metres(vx, vy),
            weight: S::ONE,
        };
        let oncoming = moving(0.3, 0.0, -0.1, 0.0);
        let of = |bearing: f32| {
            let place = Features { bearing: s(bearing), distance: S::HALF };
            field(&p, &oncoming).activity(&p, place).to_f32()
        };
        assert!(of(-0.5) < of(0.0) && of(0.0) < of(0.2), "freer to the right");
        let peak = 0.04 * (-(0.15_f32 * 5.0).powi(2)).exp();
        assert!((of(0.2) - peak).abs() < 1e-4, "{} {peak}", of(0.2));

        let to = |other: &Moving<S>, bearing, distance| {
            let place = Polar { bearing_rad: s(bearing), distance_m: s(distance) };
            inhibition(&p, place, S::ONE, other).to_f32()
        };
        // They meet at 0.1 m each: the centres would be in the same place but for the body.
        assert!(to(&moving(0.2, 0.0, -0.1, 0.0), 0.0, 0.1) > 5.0);
        // The same place after it has gone by is free, and so is going away.
        assert!(to(&moving(0.1, -0.06, 0.0, 0.2), 0.0, 0.1) <= 0.0);
        assert!(to(&moving(0.055, 0.0, 0.1, 0.0), 0.0, 0.1) <= 0.0);
        assert!(to(&moving(0.1, 0.1, 0.0, -0.1), 0.0, 0.1) > 5.0, "crosses the way just then");
    }

    #[test]
    fn gives_way_to_the_right_and_in_time() {
        check_acts::<f32>();
        check_acts::<Fixed>();
    }
}
