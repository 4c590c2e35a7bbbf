//! A grid map to drive on, with many starts and goals.

use controller_core::planning::PlanError;
use nalgebra::Point2;

use super::course::{Course, MARGINS_M, PlannedRoute, PlannerMap, length_of, start_at};
use crate::import::GridMap;
use crate::random::{Purpose, Stream};
use crate::raster::{Raster, RasterError};
use crate::scenario::{Scenario, Shape};
use crate::solids::Solids;
use crate::world::KHEPERA_RADIUS_M;

/// Pairs of places that are drawn until one is usable.
const DRAWS: u32 = 10_000;

/// A grid map with the planner's map of it and the simulator's shapes.
#[derive(Debug, Clone)]
pub struct Ground {
    /// The map.
    pub map: GridMap,
    /// What the planner knows: the same cells.
    pub planner: PlannerMap,
    shapes: Vec<Shape>,
    solids: Solids,
    /// Number of the connected part of each cell; 0 where the body and its margin do not fit in the middle.
    parts: Vec<u32>,
}

impl Ground {
    /// Of a map.
    ///
    /// # Errors
    /// See [`RasterError`].
    pub fn new(map: GridMap) -> Result<Self, RasterError> {
        let shapes = map.shapes();
        // Without the first, the border: beyond it the raster ends, and a thin wall would cost the cells along it.
        let solid = shapes.get(1..).unwrap_or_default();
        let raster = Raster::within(map.bounds(), solid.iter(), map.cell_m)?;
        let mut solids = Solids::default();
        shapes.iter().for_each(|shape| shape.add_to(&mut solids));
        let mut ground = Self {
            planner: PlannerMap::of_raster(raster),
            map,
            shapes,
            solids: solids.indexed(),
            parts: Vec::new(),
        };
        ground.find_parts();
        Ok(ground)
    }

    /// The route between two places of the grid's frame.
    ///
    /// # Errors
    /// See [`PlannerMap::route`].
    pub fn route(&self, from: Point2<f64>, goal: Point2<f64>) -> Result<PlannedRoute, PlanError> {
        self.planner.route(from, goal)
    }

    /// The course between two places of the grid's frame; the robot looks towards the goal.
    #[must_use]
    pub fn course(&self, name: &str, from: Point2<f64>, goal: Point2<f64>, goal_tolerance_m: f64) -> Course {
        let route = self.route(from, goal);
        let heading_rad = libm::atan2(goal.y - from.y, goal.x - from.x);
        let start = start_at(from, heading_rad);
        let shortest_m = length_of(&route, from, goal);
        Course {
            scenario: Scenario::of_known(name, &self.map.source, self.shapes.clone(), start, goal),
            map: self.planner.clone(),
            route,
            goal,
            goal_tolerance_m,
            shortest_m,
            gap_m: None,
            scale: None,
        }
    }

    /// Start and goal in the middle of cells, drawn by a seed: with the full margin beside the body, and joined by
    /// cells with as much. `None` if the map has hardly any.
    #[must_use]
    pub fn draw(&self, seed: u64) -> Option<(Point2<f64>, Point2<f64>)> {
        let mut stream = Stream::new(seed, Purpose::BenchmarkPlaces);
        let size = self.map.bounds().high;
        let mut draw = || self.cell_of(Point2::new(stream.between(0.0, size.x), stream.between(0.0, size.y)));
        (0..DRAWS).find_map(|_| {
            let (from, goal) = (draw()?, draw()?);
            let joined = from != goal && self.part(from) > 0 && self.part(from) == self.part(goal);
            joined.then(|| (self.map.middle(from.0, from.1), self.map.middle(goal.0, goal.1)))
        })
    }

    /// Numbers the parts of the map that are joined over the four neighbours of cells.
    fn find_parts(&mut self) {
        let needed = KHEPERA_RADIUS_M + f64::from(MARGINS_M[0]);
        let cells = (0..self.map.rows).flat_map(|row| (0..self.map.columns).map(move |column| (column, row)));
        let fits: Vec<bool> = cells
            .map(|(column, row)| {
                let middle = self.map.middle(column, row);
                self.map.is_passable(column, row) && self.solids.clearance(middle) >= needed
            })
            .collect();
        self.parts = vec![0; fits.len()];
        let columns = self.map.columns;
        let mut part = 0;
        for first in 0..fits.len() {
            if !fits[first] || self.parts[first] > 0 {
                continue;
            }
            part += 1;
            self.parts[first] = part;
            let mut ahead = vec![first];
            while let Some(cell) = ahead.pop() {
                let left = (cell % columns > 0).then(|| cell - 1);
                let right = (cell % columns + 1 < columns).then_some(cell + 1);
                let neighbours = [left, right, cell.checked_sub(columns), Some(cell + columns)];
                for next in neighbours.into_iter().flatten() {
                    if fits.get(next) == Some(&true) && self.parts[next] == 0 {
                        self.parts[next] = part;
                        ahead.push(next);
                    }
                }
            }
        }
    }

    fn part(&self, (column, row): (usize, usize)) -> u32 {
        self.parts.get(row * self.map.columns + column).copied().unwrap_or(0)
    }

    fn cell_of(&self, place: Point2<f64>) -> Option<(usize, usize)> {
        let raster = &self.planner.raster;
        let (column, row) = raster.cell_at(place)?;
        Some((usize::from(column), usize::from(row)))
    }
}
