//! The world the robot drives in: solid shapes that stay, shapes that come and go, and robots that circle.
//!
//! Where things are is a function of the time asked for, so that a run can be repeated from any tick; only the bodies
//! of other driven robots are placed from outside. Every answer is exact and no call allocates.

use std::borrow::Cow;

use nalgebra::{Point2, Vector2};

use crate::beam::Beam;
use crate::geometry::{Disc, Nearest};
use crate::mover::Mover;
use crate::random::{Purpose, Stream};
use crate::solids::Solids;

/// Radius of the Khepera's body in m, the figure both papers use.
pub const KHEPERA_RADIUS_M: f64 = 0.025;

/// The span of time in which something is there: from `from_s` up to, but not at, `until_s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// First moment, in s from the start of the run.
    pub from_s: f64,
    /// First moment of absence, in s; may be infinite.
    pub until_s: f64,
}

impl Window {
    /// From the start of the run, without end.
    pub const ALWAYS: Self = Self { from_s: 0.0, until_s: f64::INFINITY };

    /// Whether the time lies in the window.
    #[must_use]
    pub fn contains(&self, t_s: f64) -> bool {
        self.from_s <= t_s && t_s < self.until_s
    }
}

/// Shapes that are there for part of the run, such as a door that closes.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed {
    /// When they are there.
    pub window: Window,
    /// The shapes.
    pub solids: Solids,
}

/// Everything the robot can touch or see.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct World {
    /// Shapes that are there from start to end.
    pub permanent: Solids,
    /// Shapes that come or go.
    pub timed: Vec<Timed>,
    /// Robots that circle.
    pub movers: Vec<Mover>,
    /// Bodies of other robots that are driven, where they are now: the one thing that is no function of time, placed
    /// anew by whoever moves them. Empty wherever a robot is alone.
    pub bodies: Vec<Disc>,
}

impl World {
    /// The world of the run with this seed: movers whose bearing is drawn begin where this run has them.
    ///
    /// Those that share a circle and a speed share the draw, so that they keep apart as they were placed.
    #[must_use]
    pub fn of_run(&self, seed: u64) -> Cow<'_, Self> {
        if self.movers.iter().all(|mover| mover.phase_jitter_rad <= 0.0) {
            return Cow::Borrowed(self);
        }
        let mut stream = Stream::new(seed, Purpose::Movers);
        let mut shifts: Vec<f64> = Vec::new();
        for mover in &self.movers {
            // Drawn for each, so that none depends on the others' jitter.
            let drawn = stream.symmetric();
            let companion = self.movers.iter().zip(&shifts).find(|(other, _)| other.keeps_apart_from(mover));
            shifts.push(companion.map_or(drawn * mover.phase_jitter_rad, |(_, &shift)| shift));
        }
        let mut world = self.clone();
        world.movers = self.movers.iter().zip(shifts).map(|(mover, shift)| mover.turned_by(shift)).collect();
        Cow::Owned(world)
    }

    /// Distance from `centre` to the nearest surface at time `t_s`, in m: negative inside something solid, infinite
    /// in an empty world.
    ///
    /// Exact outside. Inside, it is the depth in the solid that holds the point deepest; where solids overlap the way
    /// out may be longer.
    #[must_use]
    pub fn clearance(&self, centre: Point2<f64>, t_s: f64) -> f64 {
        self.static_clearance(centre).min(self.movers_clearance(centre, t_s))
    }

    /// The part of [`World::clearance`] that does not depend on time.
    ///
    /// It changes by at most the distance travelled, so a robot that has this much to spare need not ask again until
    /// it has gone that far.
    #[must_use]
    pub fn static_clearance(&self, centre: Point2<f64>) -> f64 {
        self.permanent.clearance(centre)
    }

    /// The part of [`World::clearance`] that depends on time: movers, and shapes that come or go.
    ///
    /// Between two [changes](World::next_change_s) it shrinks by at most the robot's travel plus
    /// [the movers'](World::fastest_mover_m_s).
    #[must_use]
    pub fn movers_clearance(&self, centre: Point2<f64>, t_s: f64) -> f64 {
        let timed = self.timed_at(t_s).map(|solids| solids.clearance(centre));
        let movers = self.movers.iter().map(|mover| mover.at(t_s).clearance(centre));
        let bodies = self.bodies.iter().map(|body| body.clearance(centre));
        timed.chain(movers).chain(bodies).fold(f64::INFINITY, f64::min)
    }

    /// Whether nothing in the world depends on time, so that [`World::movers_clearance`] is always infinite.
    #[must_use]
    pub const fn is_static(&self) -> bool {
        self.timed.is_empty() && self.movers.is_empty() && self.bodies.is_empty()
    }

    /// Speed of the fastest mover in m/s, zero without movers.
    #[must_use]
    pub fn fastest_mover_m_s(&self) -> f64 {
        self.movers.iter().map(Mover::speed_m_s).fold(0.0, f64::max)
    }

    /// The first time after `t_s` at which a shape appears or disappears, infinite if none will.
    #[must_use]
    pub fn next_change_s(&self, t_s: f64) -> f64 {
        let changes = self.timed.iter().flat_map(|timed| [timed.window.from_s, timed.window.until_s]);
        changes.filter(|change| *change > t_s).fold(f64::INFINITY, f64::min)
    }

    /// The nearest surface at time `t_s`; `None` in an empty world.
    #[must_use]
    pub fn nearest_surface(&self, centre: Point2<f64>, t_s: f64) -> Option<Nearest> {
        let timed = self.timed_at(t_s).filter_map(|solids| solids.nearest(centre));
        let movers = self.movers.iter().map(|mover| mover.at(t_s).nearest(centre));
        let permanent = self.permanent.nearest(centre);
        let bodies = self.bodies.iter().map(|body| body.nearest(centre));
        permanent
            .into_iter()
            .chain(timed)
            .chain(movers)
            .chain(bodies)
            .reduce(|best, next| best.nearer(Some(next)))
    }

    /// Unit vector away from the nearest surface at time `t_s`; `None` in an empty world.
    ///
    /// A robot in contact that removes from its velocity the part against this vector slides along the surface.
    #[must_use]
    pub fn nearest_surface_normal(&self, centre: Point2<f64>, t_s: f64) -> Option<Vector2<f64>> {
        self.nearest_surface(centre, t_s).map(|nearest| nearest.normal)
    }

    /// Exact smallest distance from `apex` to a surface point inside the beam at time `t_s`, in m; `None` beyond
    /// `range_max_m`.
    ///
    /// Surfaces are seen from both sides. For all of a robot's sensors at once, [`World::scan`] is several times
    /// cheaper.
    #[must_use]
    pub fn beam_range(&self, apex: Point2<f64>, beam: &Beam, range_max_m: f64, t_s: f64) -> Option<f64> {
        let [range] = self.scan(apex, core::array::from_ref(beam), range_max_m, t_s);
        range
    }

    /// [`World::beam_range`] for many beams from one apex: what is out of range is rejected once, not once per beam.
    #[must_use]
    pub fn scan<const BEAMS: usize>(
        &self,
        apex: Point2<f64>,
        beams: &[Beam; BEAMS],
        range_max_m: f64,
        t_s: f64,
    ) -> [Option<f64>; BEAMS] {
        let mut ranges = [f64::INFINITY; BEAMS];
        self.permanent.scan(apex, beams, range_max_m, &mut ranges);
        for solids in self.timed_at(t_s) {
            solids.scan(apex, beams, range_max_m, &mut ranges);
        }
        for mover in &self.movers {
            crate::solids::scan_disc(&mover.at(t_s), apex, beams, range_max_m, &mut ranges);
        }
        for body in &self.bodies {
            crate::solids::scan_disc(body, apex, beams, range_max_m, &mut ranges);
        }
        ranges.map(|range| (range <= range_max_m).then_some(range))
    }

    fn timed_at(&self, t_s: f64) -> impl Iterator<Item = &Solids> {
        self.timed.iter().filter(move |timed| timed.window.contains(t_s)).map(|timed| &timed.solids)
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;
    use std::borrow::Cow;

    use nalgebra::Point2;

    use super::{Timed, Window, World};
    use crate::beam::Beam;
    use crate::geometry::Segment;
    use crate::mover::{Direction, Mover};
    use crate::solids::Solids;

    /// A wall at x = 1 that is there from 2 s until 5 s.
    fn door() -> World {
        let wall = Segment::new(Point2::new(1.0, -1.0), Point2::new(1.0, 1.0));
        let solids = Solids { segments: vec![wall], ..Solids::default() };
        World {
            timed: vec![Timed { window: Window { from_s: 2.0, until_s: 5.0 }, solids }],
            ..World::default()
        }
    }

    #[test]
    fn an_empty_world_is_infinitely_wide() {
        let world = World::default();
        assert!(world.clearance(Point2::origin(), 0.0).is_infinite());
        assert_eq!(world.nearest_surface_normal(Point2::origin(), 0.0), None);
        assert_eq!(world.beam_range(Point2::origin(), &Beam::new(0.0, 0.1), 10.0, 0.0), None);
        assert!(world.is_static() && world.next_change_s(0.0).is_infinite());
    }

    #[test]
    fn a_door_is_felt_and_seen_only_while_it_is_there() {
        let world = door();
        for (t_s, there) in [(0.0, false), (1.999, false), (2.0, true), (4.999, true), (5.0, false)] {
            let range = world.beam_range(Point2::origin(), &Beam::new(0.0, 0.1), 2.0, t_s);
            assert_eq!(range.is_some(), there, "at {t_s} s");
            assert_eq!(world.clearance(Point2::origin(), t_s).is_finite(), there, "at {t_s} s");
            assert_eq!(world.nearest_surface(Point2::origin(), t_s).is_some(), there, "at {t_s} s");
        }
    }

    #[test]
    fn changes_are_announced_in_turn() {
        let mut t_s = 0.0;
        let changes: Vec<f64> = core::iter::from_fn(|| {
            t_s = door().next_change_s(t_s);
            t_s.is_finite().then_some(t_s)
        })
        .collect();
        assert_eq!(changes, [2.0, 5.0]);
    }

    fn mover(x: f64, phase_rad: f64, jitter_rad: f64) -> Mover {
        let mover = Mover::new(Point2::new(x, 0.0), 0.1, 0.025, 0.05, Direction::Clockwise, phase_rad);
        mover.with_phase_jitter(jitter_rad)
    }

    fn world(movers: impl Into<Vec<Mover>>) -> World {
        World { movers: movers.into(), ..World::default() }
    }

    #[test]
    fn a_world_without_jitter_is_the_same_in_every_run() {
        let world = world([mover(0.0, 0.0, 0.0)]);
        assert!(matches!(world.of_run(7), Cow::Borrowed(same) if core::ptr::eq(same, &raw const world)));
    }

    #[test]
    fn movers_begin_anywhere_on_their_circle_and_pairs_stay_opposite() {
        let world = world([mover(0.0, 0.0, PI), mover(0.0, PI, PI), mover(0.5, 0.0, PI)]);
        let mut quadrants = [0; 4];
        for seed in 0..200 {
            let [first, second, third] = <[Mover; 3]>::try_from(world.of_run(seed).movers.clone()).unwrap();
            assert_eq!(world.of_run(seed).movers[0], first, "the seed decides");
            let at = first.at(0.0).centre;
            assert!((second.at(0.0).centre + at.coords).coords.norm() < 1e-12, "opposite each other");
            assert!((third.at(0.0).centre.x - 0.5 - at.x).abs() > 1e-6, "another circle, another draw");
            assert_eq!(first.direction(), Direction::Clockwise);
            quadrants[usize::from(at.x > 0.0) + 2 * usize::from(at.y > 0.0)] += 1;
        }
        assert!(quadrants.iter().all(|count| (30..70).contains(count)), "{quadrants:?}");
    }

    #[test]
    fn jitter_bounds_the_draw() {
        let world = world([mover(0.0, 1.0, 0.2)]);
        for seed in 0..100 {
            let at = world.of_run(seed).movers[0].at(0.0).centre;
            assert!((libm::atan2(at.y, at.x) - 1.0).abs() <= 0.2 + 1e-12);
        }
    }
}
