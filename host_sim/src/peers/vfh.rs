//! VFH+: a histogram of obstacle density over all directions, and the free one that costs least.
//!
//! Source: I. Ulrich and J. Borenstein, *VFH+: Reliable Obstacle Avoidance for Fast Mobile Robots*, ICRA 1998; the
//! certainty grid is that of J. Borenstein and Y. Koren, *Histogramic In-Motion Mapping for Mobile Robot Obstacle
//! Avoidance*, IEEE Trans. Robotics and Automation 7(4), 1991. In each period: the **primary** histogram of the active
//! window, in which each cell is enlarged by the robot's radius and a safety distance; the **binary** one with
//! hysteresis; the **masked** one, without what the robot cannot turn to at its speed; candidate directions in its
//! openings; the cheapest by `μ₁ |off target| + μ₂ |off heading| + μ₃ |off last choice|`.
//!
//! # Left open, and chosen
//!
//! * **Scale**: cells of a centimetre or less, sectors of 5°. A reading goes to the cell on the axis of its beam, and
//!   takes certainty from all cells within the beam that it has passed, not from those on the axis alone: phantoms
//!   beside the axis would close a doorway for good.
//! * **A cell inside the enlarged body** blocks half of the circle (asin is not defined there).
//! * **Turning circle**: a differential drive turns on the spot, if slow enough: the radius grows with the speed.
//!   Where that masks everything, the robot brakes and turns by the binary histogram.
//! * **Nothing free**: the robot turns on the spot towards the lowest density, and sees what is there.
//! * **Cells beyond the target** block nothing.
//! * **Speed** falls with the turn and with the free way ahead, see [`super::steering`].

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use controller_core::sensing::proximity::sensor_bearing;
use nalgebra::{Point2, Vector2};

use super::config::numbers;
use super::robot::{PeerRobot, Twist, turn};
use super::steering::Steering;
use super::{Navigator, View};
use crate::proximity_model::SENSORS;

numbers! {
    /// Numbers of VFH+.
    VfhConfig, "vfh" {
        /// Edge of a cell, in m.
        cell_m: 0.00586, 0.001 to 0.1, log(0.004, 0.015);
        /// Radius of the active window, in m.
        window_m: 0.5, 0.05 to 1.0, linear(0.08, 0.5);
        /// Distance that is added to the body's radius, in m.
        safety_m: 0.000774, 0.0 to 1.0, linear(0.0, 0.02);
        /// Certainty that a reading adds to its cell, of at most 1.
        hit: 0.113, 0.01 to 1.0, linear(0.1, 1.0);
        /// Certainty that it takes from each cell before it.
        miss: 0.0541, 0.0 to 1.0, linear(0.0, 0.6);
        /// a: weight of the nearest cells against 1 at the rim of the window.
        near_weight: 6.32, 1.0 to 1000.0, log(1.0, 30.0);
        /// Density below which a blocked sector becomes free.
        threshold_low: 1.67, 0.0 to 1000.0, log(0.03, 3.0);
        /// Density above which a free sector is blocked, as a multiple of the other.
        threshold_ratio: 4.0, 1.0 to 1000.0, linear(1.0, 4.0);
        /// Openings of more sectors than this are wide: the robot keeps half of it from their edges.
        wide_sectors: 21.1, 1.0 to 72.0, linear(4.0, 30.0);
        /// μ₁: off the target.
        target_cost: 5.0, 0.0 to 1000.0, given;
        /// μ₂: off the heading.
        heading_cost: 4.96, 0.0 to 1000.0, linear(0.0, 6.0);
        /// μ₃: off the last choice.
        change_cost: 0.0, 0.0 to 1000.0, linear(0.0, 6.0);
        /// Radius of the turning circle over the speed, in s.
        turning_s: 0.372, 0.0 to 100.0, linear(0.0, 0.5);
        /// Speed where nothing is near, as a share of c*.
        cruise_share: 0.405, 0.01 to 1.0, linear(0.3, 1.0);
        /// Time that the free way ahead must last, in s.
        headway_s: 0.649, 0.0 to 100.0, linear(0.1, 1.5);
        /// Within this distance of the body the speed falls, in m.
        near_m: 0.0119, 0.0001 to 20.0, log(0.001, 0.1);
        /// Beyond this bearing the robot turns on the spot, in rad.
        spot_rad: 1.13, 0.01 to 3.2, linear(0.3, 1.57);
        /// Time constant of a turn, in s.
        turn_time_s: 0.214, 0.01 to 10.0, linear(0.13, 0.6);
        /// Directions beyond this bearing are taken backwards, in rad.
        back_rad: 2.63, 0.0 to 3.2, linear(1.57, 3.2);
        /// How long a point is remembered that is not seen again, in s.
        memory_s: 6.52, 0.0 to 600.0, log(0.2, 20.0);
    }
}

/// Sectors of the histogram.
const SECTORS: usize = 72;
const SECTOR_RAD: f64 = TAU / 72.0;

/// Half the width of a beam in rad: 7.5°.
const BEAM_RAD: f64 = 0.131;
/// Share of a range by which a reading may be wrong: cells so much before it may be what it has seen.
const RANGE_NOISE: f64 = 0.1;
/// Cells from the middle to the rim, at most.
const HALF_MAX: i32 = 200;

/// The certainty grid: a square window of the world around the robot. Only cells with a certainty are held, since most
/// have none.
#[derive(Debug, Clone)]
struct Grid {
    cell_m: f64,
    /// Cells from the middle to the rim.
    half: i32,
    cells: Vec<((i32, i32), f64)>,
}

impl Grid {
    fn new(cell_m: f64, window_m: f64) -> Self {
        Self { cell_m, half: whole(window_m / cell_m).clamp(1, HALF_MAX), cells: Vec::new() }
    }

    /// The cell of a place.
    fn at(&self, place: Point2<f64>) -> (i32, i32) {
        (whole(place.x / self.cell_m), whole(place.y / self.cell_m))
    }

    /// Moves the window to the robot; what leaves it is forgotten, and so is what nothing speaks for any more.
    fn follow(&mut self, position: Point2<f64>) {
        let (x, y) = self.at(position);
        let half = self.half;
        self.cells.retain(|&((column, row), certainty)| {
            certainty > 0.0 && (column - x).abs() <= half && (row - y).abs() <= half
        });
    }

    fn add(&mut self, cell: (i32, i32), certainty: f64) {
        match self.cells.iter_mut().find(|(place, _)| *place == cell) {
            Some((_, known)) => *known = (*known + certainty).min(1.0),
            None => self.cells.push((cell, certainty.min(1.0))),
        }
    }

    /// A cell as the robot sees it.
    fn seen(&self, view: &View, (column, row): (i32, i32), certainty: f64) -> Seen {
        let middle = |cell: i32| (f64::from(cell) + 0.5) * self.cell_m;
        let to = Point2::new(middle(column), middle(row)) - view.position;
        Seen { direction_rad: libm::atan2(to.y, to.x), distance_m: to.norm(), certainty }
    }

    /// A scan: certainty for the cells where readings end, less for those that beams pass over. All cells as they are
    /// seen then.
    fn read(&mut self, config: &VfhConfig, view: &View, reach_m: f64) -> Vec<Seen> {
        let bearing = |sensor| f64::from(sensor_bearing::<f32>(sensor, SENSORS));
        for (sensor, range) in view.ranges.iter().enumerate() {
            let Some(range) = range else { continue };
            let (sin, cos) = libm::sincos(view.heading_rad + bearing(sensor));
            self.add(self.at(view.position + Vector2::new(cos, sin) * *range), config.hit);
        }
        let mut cells = Vec::with_capacity(self.cells.len());
        for index in 0..self.cells.len() {
            let (cell, certainty) = self.cells[index];
            let mut seen = self.seen(view, cell, certainty);
            let passed = view.ranges.iter().enumerate().any(|(sensor, range)| {
                let free = range.unwrap_or(reach_m) * (1.0 - RANGE_NOISE) - self.cell_m;
                seen.distance_m < free
                    && turn(view.heading_rad + bearing(sensor), seen.direction_rad).abs() < BEAM_RAD
            });
            if passed {
                seen.certainty = (certainty - config.miss).max(0.0);
                self.cells[index].1 = seen.certainty;
            }
            cells.push(seen);
        }
        cells
    }
}

/// More cells than any world has, and few enough for two numbers of them to be subtracted in 32 bits.
const FARTHEST: f64 = 1e9;

/// The whole part of a number of cells within ± [`FARTHEST`].
#[expect(
    clippy::cast_possible_truncation,
    reason = "clamped to ±1e9 before, within the type's ±2.1e9; NaN, which `as` takes for 0, is no place of a pose"
)]
fn whole(cells: f64) -> i32 {
    libm::floor(cells.clamp(-FARTHEST, FARTHEST)) as i32
}

/// A cell as the histograms see it.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// Direction in the world, rad.
    direction_rad: f64,
    distance_m: f64,
    certainty: f64,
}

/// VFH+ with its grid.
#[derive(Debug, Clone)]
pub struct Vfh {
    robot: PeerRobot,
    steering: Steering,
    config: VfhConfig,
    grid: Grid,
    /// The binary histogram, for its hysteresis.
    blocked: [bool; SECTORS],
    /// The direction of the last choice, world frame.
    last_rad: Option<f64>,
}

impl Vfh {
    /// For a robot.
    #[must_use]
    pub fn new(robot: PeerRobot, config: VfhConfig) -> Self {
        Self {
            robot,
            steering: Steering {
                cruise_share: config.cruise_share,
                headway_s: config.headway_s,
                near_m: config.near_m,
                margin_m: config.safety_m / 2.0,
                spot_rad: config.spot_rad,
                turn_time_s: config.turn_time_s,
                back_rad: config.back_rad,
            },
            grid: Grid::new(config.cell_m, config.window_m),
            blocked: [false; SECTORS],
            last_rad: None,
            config,
        }
    }

    fn look(&mut self, view: &View) -> Vec<Seen> {
        self.grid.follow(view.position);
        let farthest = self.config.window_m.min(view.target.distance_m + self.robot.body_radius_m);
        let mut cells = self.grid.read(&self.config, view, self.robot.reach_m);
        cells.retain(|cell| cell.distance_m < farthest);
        cells
    }

    /// The primary histogram: density of each sector.
    fn densities(&self, cells: &[Seen]) -> [f64; SECTORS] {
        let mut densities = [0.0; SECTORS];
        let enlarged = self.robot.body_radius_m + self.config.safety_m;
        let slope = (self.config.near_weight - 1.0) / (self.config.window_m * self.config.window_m);
        for cell in cells {
            let squared = cell.distance_m * cell.distance_m;
            let weight = self.config.near_weight - slope * squared;
            let magnitude = cell.certainty * cell.certainty * weight;
            let half =
                if cell.distance_m > enlarged { libm::asin(enlarged / cell.distance_m) } else { FRAC_PI_2 };
            for (sector, density) in densities.iter_mut().enumerate() {
                if turn(cell.direction_rad, direction(sector)).abs() <= half {
                    *density += magnitude;
                }
            }
        }
        densities
    }

    /// The masked histogram: what is blocked, or out of the robot's turning circles.
    fn masked(&self, view: &View, cells: &[Seen]) -> [bool; SECTORS] {
        let radius = self.config.turning_s * view.speed.forward_mps.abs();
        let enlarged = self.robot.body_radius_m + self.config.safety_m;
        // How far the robot may turn to the left and to the right.
        let (mut left, mut right) = (PI, -PI);
        for cell in cells.iter().filter(|cell| cell.certainty * cell.certainty > 0.2) {
            let bearing = turn(view.heading_rad, cell.direction_rad);
            let (sin, cos) = libm::sincos(bearing);
            let at = Vector2::new(cos, sin) * cell.distance_m;
            let hits = |centre: f64| (at - Vector2::new(0.0, centre)).norm() < radius + enlarged;
            if bearing >= 0.0 && bearing < left && hits(radius) {
                left = bearing;
            }
            if bearing <= 0.0 && bearing > right && hits(-radius) {
                right = bearing;
            }
        }
        core::array::from_fn(|sector| {
            let bearing = turn(view.heading_rad, direction(sector));
            self.blocked[sector] || bearing > left || bearing < right
        })
    }

    /// Candidate directions (world frame) of the openings of a histogram.
    fn candidates(&self, view: &View, blocked: &[bool; SECTORS]) -> Vec<f64> {
        let target = view.heading_rad + view.target.bearing_rad;
        let Some(first) = blocked.iter().position(|&blocked| blocked) else { return vec![target] };
        let wide = self.config.wide_sectors;
        let mut candidates = Vec::new();
        let (mut begin, mut width) = (0.0, 0.0);
        // Once around from a blocked sector, so that every opening has a beginning and an end.
        for step in 1..=SECTORS {
            let sector = (first + step) % SECTORS;
            if !blocked[sector] {
                if width == 0.0 {
                    begin = direction(sector);
                }
                width += 1.0;
                continue;
            }
            if width > 0.0 && width <= wide {
                candidates.push(begin + SECTOR_RAD * (width - 1.0) / 2.0);
            } else if width > wide {
                let keep = SECTOR_RAD * wide / 2.0;
                let end = begin + SECTOR_RAD * (width - 1.0);
                candidates.extend([begin + keep, end - keep]);
                let into = turn(begin, target).rem_euclid(TAU);
                if into > keep && into < end - begin - keep {
                    candidates.push(target);
                }
            }
            width = 0.0;
        }
        candidates
    }

    /// The cheapest candidate.
    fn choose(&self, view: &View, candidates: &[f64]) -> Option<f64> {
        let target = view.heading_rad + view.target.bearing_rad;
        let last = self.last_rad.unwrap_or(view.heading_rad);
        let config = &self.config;
        let cost = |candidate: f64| {
            config.target_cost * turn(target, candidate).abs()
                + config.heading_cost * turn(view.heading_rad, candidate).abs()
                + config.change_cost * turn(last, candidate).abs()
        };
        candidates.iter().copied().min_by(|&a, &b| cost(a).total_cmp(&cost(b)))
    }

    fn drive(&self, view: &View, direction: f64) -> Twist {
        self.steering.towards(&self.robot, view, turn(view.heading_rad, direction))
    }
}

/// The middle of a sector, world frame.
fn direction(sector: usize) -> f64 {
    let sector = u32::try_from(sector).unwrap_or(0);
    (f64::from(sector) + 0.5) * SECTOR_RAD - PI
}

impl Navigator for Vfh {
    fn decide(&mut self, view: &View) -> Twist {
        let cells = self.look(view);
        let densities = self.densities(&cells);
        let low = self.config.threshold_low;
        let high = low * self.config.threshold_ratio;
        for (blocked, density) in self.blocked.iter_mut().zip(densities) {
            *blocked = density > high || (*blocked && density >= low);
        }
        let masked = self.masked(view, &cells);
        if let Some(direction) = self.choose(view, &self.candidates(view, &masked)) {
            self.last_rad = Some(direction);
            return self.drive(view, direction);
        }
        // Out of reach at this speed, or blocked all around: turn on the spot.
        let open = self.choose(view, &self.candidates(view, &self.blocked));
        self.last_rad = open;
        let emptiest = || {
            let sectors = densities.iter().enumerate();
            let lowest = sectors.min_by(|a, b| a.1.total_cmp(b.1));
            lowest.map_or(view.heading_rad, |(sector, _)| direction(sector))
        };
        let motion = self.drive(view, open.unwrap_or_else(emptiest));
        Twist { forward_mps: 0.0, ..motion }
    }

    fn reset(&mut self) {
        self.grid.cells.clear();
        self.blocked = [false; SECTORS];
        self.last_rad = None;
    }

    fn memory_s(&self) -> f64 {
        self.config.memory_s
    }
}

#[cfg(test)]
mod tests {
    use super::{SECTORS, Vfh, VfhConfig};
    use crate::peers::Navigator;
    use crate::peers::testing::{ROBOT, view};

    #[test]
    fn what_is_seen_blocks_its_directions_until_it_is_gone() {
        // One reading is enough, whatever the search has found to be best.
        let prompt = VfhConfig { hit: 1.0, miss: 0.1, threshold_ratio: 2.0, ..VfhConfig::default() };
        let mut vfh = Vfh::new(ROBOT, prompt);
        let mut ranges = [None; 12];
        ranges[0] = Some(0.06);
        let motion = vfh.decide(&view(&ranges, &[], 0.0));
        let blocked = |vfh: &Vfh| vfh.blocked.iter().filter(|&&blocked| blocked).count();
        assert!((2..SECTORS / 2).contains(&blocked(&vfh)), "{} sectors", blocked(&vfh));
        assert!(vfh.blocked[SECTORS / 2] && !vfh.blocked[0], "ahead, not behind");
        assert!(motion.turn_radps.abs() > 0.1, "{motion:?} turns aside");
        for _ in 0..20 {
            vfh.decide(&view(&[None; 12], &[], 0.0));
        }
        assert_eq!(blocked(&vfh), 0, "beams have passed there");
    }

    #[test]
    fn narrow_openings_are_taken_in_the_middle_and_wide_ones_at_their_edges() {
        let vfh = Vfh::new(ROBOT, VfhConfig { wide_sectors: 10.0, ..VfhConfig::default() });
        let open = |from: usize, to: usize| core::array::from_fn(|sector| !(from..to).contains(&sector));
        let ranges = [None; 12];
        let view = view(&ranges, &[], 0.0);
        let narrow = vfh.candidates(&view, &open(40, 44));
        assert!(
            matches!(narrow[..], [middle] if (middle - super::direction(42) + super::SECTOR_RAD / 2.0).abs() < 1e-9)
        );
        assert_eq!(vfh.candidates(&view, &open(20, 60)).len(), 3, "both edges and the target ahead");
        assert_eq!(vfh.candidates(&view, &open(40, 60)).len(), 2, "the target is not in it");
        assert!(vfh.candidates(&view, &[true; SECTORS]).is_empty());
    }
}
