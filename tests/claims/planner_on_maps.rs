//! The planner on grid maps of several kinds, against the shortest way of the same disc.
//!
//! Goal: a plan whenever the disc can go, at most 1.10 times as long as the shortest way.
//!
//! Method: a disc's shortest way among square cells touches walls at their corners only, on arcs of the disc's radius.
//! The reference puts a regular 16-gon *inside* the disc in its place; then the obstacles are the cells grown by it,
//! polygons, among which the shortest way goes from corner to corner: Dijkstra's search over all pairs of corners that
//! see each other finds it exactly. What it may touch is a part of what the disc may not, so it is never longer than
//! the disc's shortest way: a plan within 1.10 of it is within 1.10 of that. It shares no code with the planner.
//!
//! Ours: at most 1.10 on every map here; the test prints the figures of each kind.

use controller_core::planning::Footprint;
use host_sim::benchmark::Ground;
use host_sim::import::GridMap;
use host_sim::number::narrow;
use host_sim::world::KHEPERA_RADIUS_M;
use nalgebra::Point2;
use tests::maps::{Kind, draw};
use tests::visibility::cells_needed;

/// Rows and columns of a map.
const SIDE: usize = 18;
const SEEDS: u64 = 3;
const PAIRS: u64 = 2;

/// A place in cells.
type Place = (f64, f64);

/// The five corners of the 16-gon in a quarter of a turn.
const QUARTER: [Place; 5] = [
    (1.0, 0.0),
    (0.923_879_532_511_286_7, 0.382_683_432_365_089_8),
    (core::f64::consts::FRAC_1_SQRT_2, core::f64::consts::FRAC_1_SQRT_2),
    (0.382_683_432_365_089_8, 0.923_879_532_511_286_7),
    (0.0, 1.0),
];

/// Sides of a grown cell that meet by less than this only touch, in cells.
const HAIR: f64 = 1e-9;

struct Reference<'a> {
    map: &'a GridMap,
    reach: f64,
    /// Outward normals of a grown cell's sides, and their distance from the cell's middle.
    sides: Vec<(Place, f64)>,
}

fn float(count: usize) -> f64 {
    f64::from(u32::try_from(count).expect("a test's map is small"))
}

impl<'a> Reference<'a> {
    fn new(map: &'a GridMap, reach_m: f64) -> Self {
        let reach = reach_m / map.cell_m;
        let mut reference = Self { map, reach, sides: Vec::new() };
        let corners: Vec<Place> = reference.corners_of(0.0, 0.0).collect();
        for (index, &a) in corners.iter().enumerate() {
            let b = corners[(index + 1) % corners.len()];
            let length = (b.0 - a.0).hypot(b.1 - a.1);
            let normal = ((b.1 - a.1) / length, (a.0 - b.0) / length);
            reference.sides.push((normal, normal.0 * a.0 + normal.1 * a.1));
        }
        reference
    }

    /// The corners of the cell around a middle, grown by the 16-gon, anticlockwise.
    fn corners_of(&self, x: f64, y: f64) -> impl Iterator<Item = Place> + '_ {
        (0..4).flat_map(move |quarter| {
            QUARTER.iter().map(move |&(along, aside)| {
                let (dx, dy) = (0.5 + self.reach * along, 0.5 + self.reach * aside);
                let (dx, dy) = match quarter {
                    0 => (dx, dy),
                    1 => (-dy, dx),
                    2 => (-dx, -dy),
                    _ => (dy, -dx),
                };
                (x + dx, y + dy)
            })
        })
    }

    /// Whether the way between two places goes through the inside of the cell grown around a middle (Cyrus and Beck).
    fn crosses(&self, a: Place, b: Place, (x, y): Place) -> bool {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for &(normal, out) in &self.sides {
            let from = normal.0 * (a.0 - x) + normal.1 * (a.1 - y) - out + HAIR;
            let to = normal.0 * (b.0 - x) + normal.1 * (b.1 - y) - out + HAIR;
            if from >= 0.0 && to >= 0.0 {
                return false;
            }
            let share = from / (from - to);
            if from >= 0.0 {
                enter = enter.max(share);
            } else if to >= 0.0 {
                leave = leave.min(share);
            }
        }
        enter < leave
    }

    /// The middles of the cells that are not passable and near the box around two places, the map's rim among them.
    fn walls_near(&self, a: Place, b: Place) -> impl Iterator<Item = Place> + '_ {
        let room = self.reach + 0.5;
        let (low, high) = ((a.0.min(b.0), a.1.min(b.1)), (a.0.max(b.0), a.1.max(b.1)));
        let range = move |low: f64, high: f64, count: usize| {
            (0..count + 2).filter(move |&at| (low - room..=high + room).contains(&(float(at) - 0.5)))
        };
        range(low.0, high.0, self.map.columns).flat_map(move |column| {
            range(low.1, high.1, self.map.rows).filter_map(move |row| {
                let inside = column > 0 && row > 0;
                let free = inside && self.map.is_passable(column - 1, row - 1);
                (!free).then(|| (float(column) - 0.5, float(row) - 0.5))
            })
        })
    }

    fn sees(&self, a: Place, b: Place) -> bool {
        !self.walls_near(a, b).any(|wall| self.crosses(a, b, wall))
    }

    /// Length of the shortest way in cells; `None` where there is none.
    fn shortest(&self, from: Place, goal: Place) -> Option<f64> {
        let all = ((0.0, 0.0), (float(self.map.columns), float(self.map.rows)));
        let mut places = vec![from, goal];
        for wall in self.walls_near(all.0, all.1) {
            places.extend(self.corners_of(wall.0, wall.1).filter(|&corner| self.sees(corner, corner)));
        }
        let mut lengths = vec![f64::INFINITY; places.len()];
        let mut done = vec![false; places.len()];
        lengths[0] = 0.0;
        loop {
            let next = (0..places.len()).filter(|&index| !done[index] && lengths[index].is_finite());
            let next = next.min_by(|&a, &b| lengths[a].total_cmp(&lengths[b]))?;
            if next == 1 {
                return Some(lengths[1]);
            }
            done[next] = true;
            let here = places[next];
            for other in 0..places.len() {
                let there = places[other];
                let length = lengths[next] + (there.0 - here.0).hypot(there.1 - here.1);
                if length < lengths[other] && self.sees(here, there) {
                    lengths[other] = length;
                }
            }
        }
    }
}

/// The longest plan of a kind over the reference's, and how many there were.
fn compare(kind: Kind) -> (f64, u32) {
    let (mut most, mut plans) = (1.0_f64, 0);
    for seed in 0..SEEDS {
        let ground = Ground::new(draw(kind, SIDE, seed)).expect("the map fits");
        for (from, goal) in (0..PAIRS).filter_map(|pair| ground.draw(100 * seed + pair)) {
            let name = format!("{}, seed {seed}, from {from} to {goal}", kind.name());
            let route = ground.route(from, goal).unwrap_or_else(|error| panic!("{name}: {error}"));
            let reference = Reference::new(&ground.map, KHEPERA_RADIUS_M + f64::from(route.margin_m));
            let cells = |place: Point2<f64>| (place.x / ground.map.cell_m, place.y / ground.map.cell_m);
            let shortest = reference.shortest(cells(from), cells(goal)).expect("what is planned can be gone");
            let ratio = route.plan.length_m(from) / (shortest * ground.map.cell_m);
            assert!((1.0 - 1e-3..=1.10).contains(&ratio), "{name}: {ratio} times the shortest way");
            most = most.max(ratio);
            plans += 1;
        }
    }
    (most, plans)
}

/// Cells of decompositions beside what any one needs whose cells' places all see each other. Ours are joined along
/// their cores, round what is in the way, so that they may be fewer.
#[test]
fn cells_are_about_as_few_as_places_that_do_not_see_each_other() {
    for kind in [Kind::Discs(220.0), Kind::Rooms(3), Kind::Rooms(7), Kind::Maze(2), Kind::Random(0.1)] {
        let ground = Ground::new(draw(kind, 32, 0)).expect("the map fits");
        let (from, goal) = ground.draw(0).expect("the map has two places");
        let route = ground.route(from, goal).expect("they are joined");
        let robot = Footprint::new(narrow(KHEPERA_RADIUS_M), route.margin_m).expect("the robot is valid");
        let (cells, needed) = (route.plan.cells, cells_needed(&ground.planner.raster, &robot));
        let free = ground.planner.free_cells();
        println!("{:26} {cells} cells of {free} free, needed at least {needed}", kind.name());
        assert!(2 * cells <= 3 * needed, "{}: {cells} cells where {needed} places see no other", kind.name());
    }
}

/// At 512 × 512 cells there is room for what was beyond the planner's numbers, and the plan is short: at most a tenth
/// longer than the straight line and a detour that such maps need.
#[test]
fn full_maps_of_512_cells_have_a_plan() {
    for (kind, longest) in [(Kind::Random(0.02), 1.05), (Kind::Random(0.1), 1.08), (Kind::Random(0.3), 1.3)] {
        let ground = Ground::new(draw(kind, 512, 0)).expect("the map fits");
        let (from, goal) = ground.draw(0).expect("the map has two places");
        let route = ground.route(from, goal).unwrap_or_else(|error| panic!("{}: {error}", kind.name()));
        let ratio = route.plan.length_m(from) / (goal - from).norm();
        println!("{:26} {ratio:.3} times the straight line", kind.name());
        assert!(ratio <= longest, "{}: {ratio} times the straight line", kind.name());
    }
    for kind in [Kind::Maze(1), Kind::Random(0.4)] {
        let ground = Ground::new(draw(kind, 512, 0)).expect("the map fits");
        let (from, goal) = ground.draw(1).expect("the map has two places");
        assert!(ground.route(from, goal).is_ok(), "{}: {:?}", kind.name(), ground.route(from, goal));
    }
}

#[test]
fn plans_are_at_most_a_tenth_longer_than_the_shortest_way() {
    for kind in [
        Kind::Discs(60.0),
        Kind::Streets(100.0),
        Kind::Caves(0.4),
        Kind::Rooms(3),
        Kind::Rooms(6),
        Kind::Maze(1),
        Kind::Maze(2),
        Kind::Random(0.1),
        Kind::Random(0.2),
        Kind::Random(0.3),
    ] {
        let (most, plans) = compare(kind);
        println!("{:26} {plans} plans, at most {most:.3} times the shortest way", kind.name());
        assert!(plans >= 4, "{}: only {plans} plans", kind.name());
    }
}
