//! Robot separation: other robots' positions, known by communication, become a third kind of field.
//!
//! P2 names the module beside target reaching and obstacle avoidance and says no more of it; what follows is ours. Each
//! robot tells the others now and then where it is and how it moves ([`Report`]); between two reports the others are
//! carried on along their way. The field of another robot is a Gaussian over the neurons around the bearing under which
//! it will be seen a step later, the stronger the narrower the gap between the bodies. Its centre is shifted to the
//! left, so that among equals the way to the right is freer: two robots head-on both give way to the right, and robots
//! that cross at one point go around it the same way, without a rule of who goes first.
//!
//! A report counts the less the older it is, and is forgotten after [`SeparationParameters::lifetime_ms`]. Sensors see
//! other robots as well, and avoid them like any obstacle.
//!
//! Tried and left out, since it made no difference beside the field: the swept path held against where the others will
//! be at each moment of a step.

use heapless::Vec;

use crate::config::Config;
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

/// How other robots are kept away from, in SI units. They are taken to be as large as this one.
#[derive(Clone, Debug, PartialEq)]
pub struct SeparationConfig {
    /// Reports older than this are forgotten, and count the less the older they are: four missed ones.
    pub lifetime_ms: u16,
    /// Peak of the field for bodies that touch; about that of the target field (`cooperative.target_amplitude`).
    pub amplitude: f32,
    /// σ of the field in bearing: wide enough to turn the robot in good time.
    pub bearing_sigma_rad: f32,
    /// σ of the gap between the bodies over which the field falls off: about a step.
    pub gap_sigma_m: f32,
    /// How far the centre of the field is shifted to the left, so that robots give way to the right. 0 works where
    /// starts are not quite symmetric, but takes half as long again.
    pub keep_right_rad: f32,
}

impl Default for SeparationConfig {
    fn default() -> Self {
        Self {
            lifetime_ms: 1000,
            amplitude: 0.04,
            bearing_sigma_rad: 0.7,
            gap_sigma_m: 0.15,
            keep_right_rad: 0.2,
        }
    }
}

/// The same in the controller's scalar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparationParameters<S> {
    /// As [`SeparationConfig::lifetime_ms`].
    pub lifetime_ms: u16,
    /// Peak of the field.
    pub amplitude: S,
    /// 1 / (√2 σ) of the field in bearing (per rad).
    pub bearing_steepness: S,
    /// 1 / (√2 σ) of the gap between the bodies (per m).
    pub gap_steepness: S,
    /// Shift of the centre to the left (rad).
    pub keep_right_rad: S,
    /// Distance between the centres of two bodies that touch (m).
    pub touch_m: S,
    /// Duration of a step of the map (s).
    pub step_s: S,
}

impl<S: Scalar> SeparationParameters<S> {
    /// With these numbers, for robots like that of `robot`. Sizes of a millimetre at least make sense; smaller and
    /// broken ones count as that.
    #[must_use]
    pub fn new(separation: &SeparationConfig, robot: &Config) -> Self {
        let s = S::from_f32;
        let steepness = |sigma: f32| s(core::f32::consts::FRAC_1_SQRT_2 / sigma.max(1e-3));
        Self {
            lifetime_ms: separation.lifetime_ms,
            amplitude: s(separation.amplitude),
            bearing_steepness: steepness(separation.bearing_sigma_rad),
            gap_steepness: steepness(separation.gap_sigma_m),
            keep_right_rad: s(separation.keep_right_rad),
            touch_m: s(2.0 * robot.robot.body_radius_m),
            step_s: s(f32::from(robot.schedule.step_ms) / 1000.0),
        }
    }
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
    parameters: SeparationParameters<S>,
    known: Vec<Other<S>, COUNT>,
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
    pub const NONE: Self = Self {
        parameters: SeparationParameters {
            lifetime_ms: 0,
            amplitude: S::ZERO,
            bearing_steepness: S::ZERO,
            gap_steepness: S::ZERO,
            keep_right_rad: S::ZERO,
            touch_m: S::ZERO,
            step_s: S::ZERO,
        },
        known: Vec::new(),
    };

    /// Nobody is known of yet.
    #[must_use]
    pub fn new(parameters: SeparationParameters<S>) -> Self {
        Self { parameters, known: Vec::new() }
    }

    /// How they are kept away from.
    #[must_use]
    pub fn parameters(&self) -> &SeparationParameters<S> {
        &self.parameters
    }

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
    pub fn forget(&mut self, now: Tick) {
        let lifetime_ms = self.parameters.lifetime_ms;
        self.known.retain(|other| age_ms(other, now) < lifetime_ms);
    }

    /// Nobody is known of.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// The others as they are by now, seen from `pose`.
    #[must_use]
    pub fn seen_from(&self, pose: Pose<S>, now: Tick) -> Vec<Moving<S>, COUNT> {
        let mut seen = Vec::new();
        let (sin, cos) = pose.heading_rad.sin_cos();
        let lifetime = S::from_i32(i32::from(self.parameters.lifetime_ms.max(1)));
        for other in &self.known {
            let age = S::from_i32(i32::from(age_ms(other, now)));
            let [x, y] = other.velocity_mps.map(S::from_weight);
            let age_s = age * S::from_f32(0.001);
            let at = Point { x_m: other.at.x_m + x * age_s, y_m: other.at.y_m + y * age_s };
            let moving = Moving {
                at: pose.to_robot_frame(at, (sin, cos)),
                velocity_mps: Point { x_m: x * cos + y * sin, y_m: y * cos - x * sin },
                weight: (S::ONE - age / lifetime).max(S::ZERO),
            };
            // As many as are known.
            let _ = seen.push(moving);
        }
        seen
    }

    /// The field of one of them.
    #[must_use]
    pub fn field(&self, other: &Moving<S>) -> SeparationField<S> {
        let p = &self.parameters;
        let soon = other.after(p.step_s).to_polar();
        let now = S::hypot(other.at.x_m, other.at.y_m);
        // Whichever is nearer: one that goes away matters until it is gone.
        let gap = (soon.distance_m.min(now) - p.touch_m).max(S::ZERO) * p.gap_steepness;
        SeparationField {
            bearing_rad: wrap(soon.bearing_rad + p.keep_right_rad),
            peak: p.amplitude * other.weight * (gap * gap).exp_neg(),
        }
    }

    /// Leaves out of what sensors see what may well be one of them: nearer to its centre than a body's diameter, half
    /// of which is left for noise and the width of a beam.
    pub fn leave_out<const SENSORS: usize>(
        &self,
        pose: Pose<S>,
        now: Tick,
        detections: &mut Vec<Polar<S>, SENSORS>,
    ) {
        let others = self.seen_from(pose, now);
        detections.retain(|place| {
            let point = place.to_point();
            !others.iter().any(|other| other.at.distance_to(point) < self.parameters.touch_m)
        });
    }
}

impl<S: Scalar> Moving<S> {
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

impl<S: Scalar> SeparationField<S> {
    /// What the field takes of a neuron whose unfolded place this is.
    #[must_use]
    pub fn activity(&self, p: &SeparationParameters<S>, place: Features<S>) -> S {
        let bearing = angle_between(self.bearing_rad, place.bearing) * p.bearing_steepness;
        self.peak * (bearing * bearing).exp_neg()
    }
}

#[cfg(test)]
mod tests {
    use super::{Moving, Others, Report, SeparationConfig, SeparationParameters};
    use crate::config::Config;
    use crate::kohonen::features::Features;
    use crate::scalar::{Fixed, Scalar};
    use crate::units::{Point, Polar, Pose};

    fn others<S: Scalar, const COUNT: usize>() -> Others<S, COUNT> {
        Others::new(SeparationParameters::new(&SeparationConfig::default(), &Config::default()))
    }

    fn report<S: Scalar>(robot: u8, x_m: f32, age_ms: u16) -> Report<S> {
        let velocity_mps = Point::from_metres(-0.1, 0.0);
        Report { robot, at: Point::from_metres(x_m, 0.0), velocity_mps, age_ms }
    }

    fn check_reports<S: Scalar>() {
        let here = Point::default();
        // Across the place where the stored bits of the tick wrap around.
        let now = 0x1_0010;
        let mut others = others::<S, 2>();
        others.hear(here, now, &report(1, 0.5, 0));
        others.hear(here, now + 100, &report(1, 0.4, 200));
        let quarter = Pose { heading_rad: S::PI * S::HALF, ..Pose::default() };
        let seen = others.seen_from(quarter, now + 100);
        assert_eq!(seen.len(), 1, "the last report of each counts");
        let Moving { at, velocity_mps, weight } = seen[0];
        // 0.4 m, and 0.2 s at 0.1 m/s towards us; the robot looks along y, so it is on the right.
        assert!((at.y_m.to_f32() + 0.38).abs() < 1e-3 && at.x_m.to_f32().abs() < 1e-3, "{at:?}");
        assert!((velocity_mps.y_m.to_f32() - 0.1).abs() < 1e-3, "{velocity_mps:?}");
        assert!((weight.to_f32() - 0.8).abs() < 1e-3, "{weight:?}");
        others.hear(here, now + 100, &report(2, 0.9, 0));
        others.hear(here, now + 100, &report(3, 0.6, 0));
        let nearest = |others: &Others<S, 2>| {
            others.seen_from(Pose::default(), now + 100).iter().fold(0.0, |most, other| {
                let x = other.at.x_m.to_f32();
                if x > most { x } else { most }
            })
        };
        assert!((nearest(&others) - 0.6).abs() < 1e-3, "of three, the nearest two");
        others.forget(now + 899);
        assert!(!others.is_empty());
        others.forget(now + 1100);
        assert!(others.is_empty());
    }

    #[test]
    fn reports_are_carried_on_fade_and_are_forgotten() {
        check_reports::<f32>();
        check_reports::<Fixed>();
    }

    fn check_field<S: Scalar>() {
        let (others, s) = (others::<S, 2>(), S::from_f32);
        let moving = |x, y, vx, vy| Moving {
            at: Point::from_metres(x, y),
            velocity_mps: Point::from_metres(vx, vy),
            weight: S::ONE,
        };
        let of = |other: &Moving<S>, bearing: f32| {
            let place = Features { bearing: s(bearing), distance: S::HALF };
            others.field(other).activity(others.parameters(), place).to_f32()
        };
        let oncoming = moving(0.3, 0.0, -0.125, 0.0);
        assert!(
            of(&oncoming, -0.5) < of(&oncoming, 0.0) && of(&oncoming, 0.0) < of(&oncoming, 0.2),
            "to the right"
        );
        // A step later it is at 0.172 m, and 0.122 m are left between the bodies.
        let peak = 0.04 * (-(0.122_f32 / 0.15).powi(2) / 2.0).exp();
        assert!((of(&oncoming, 0.2) - peak).abs() < 1e-4, "{} {peak}", of(&oncoming, 0.2));
        assert!(of(&moving(0.4, 0.0, -0.125, 0.0), 0.2) < peak, "weaker where there is more room");
        // One that crosses from the right to the left is passed behind.
        let crossing = moving(0.2, -0.1, 0.0, 0.2);
        assert!(of(&crossing, 0.5) > 1.5 * of(&crossing, -0.5));
        let stale = Moving { weight: S::HALF, ..oncoming };
        assert!((of(&stale, 0.2) - peak / 2.0).abs() < 1e-4);

        let mut told = super::Others::<S, 2>::new(*others.parameters());
        told.hear(
            Point::default(),
            0,
            &Report { robot: 1, at: Point::from_metres(0.1, 0.0), ..Report::default() },
        );
        let polar = |bearing, distance| Polar { bearing_rad: s(bearing), distance_m: s(distance) };
        let mut seen = heapless::Vec::<_, 4>::from_array([polar(0.05, 0.075), polar(0.6, 0.12)]);
        told.leave_out(Pose::default(), 0, &mut seen);
        assert_eq!(seen.as_slice(), [polar(0.6, 0.12)], "its near side is left out, a wall beside it is not");
    }

    #[test]
    fn gives_way_to_the_right_and_behind() {
        check_field::<f32>();
        check_field::<Fixed>();
    }
}
