//! A world to cross, with the planner's map of it and the route on it.

use std::sync::Arc;

use controller_core::planning::{Footprint, PlanError};
use nalgebra::Point2;

use crate::geometry::Bounds;
use crate::import::VectorWorld;
use crate::number::narrow;
use crate::raster::{Raster, RasterError, bounds_of};
use crate::route_planner::{self, Plan};
use crate::scenario::{Scenario, Start};
use crate::world::KHEPERA_RADIUS_M;

/// Room beside the body that is tried in turn, in m: the first with a plan counts.
///
/// A centimetre is what the papers' scenarios have ([`route_planner::MARGIN_M`]); less only where the world leaves no
/// other way.
pub const MARGINS_M: [f32; 8] = [0.01, 0.0075, 0.005, 0.004, 0.003, 0.002, 0.001, 0.0];

/// Side of a cell of the planner's map of a vector world, in m. A wall takes up to a cell more than it is on both sides
/// of a gap, and BARN's tightest leave 3 mm beside the body.
const CELL_M: f64 = 0.002;

/// Most cells along a side of that map; larger worlds have larger cells.
const CELLS_MAX: f64 = 1024.0;

/// Room around the world on the planner's map, in m: a robot may go round what stands alone.
const SURROUNDINGS_M: f64 = 0.1;

/// Times the shortest time after which a run is given up: BARN's rule of 100 s for what takes 5.7 s.
pub const TIME_LIMIT: f64 = 17.5;

/// Where a plan has at most so many cells there is another with the cells cut across, so that a map of 512 x 512 cells
/// stays a matter of some ten milliseconds.
const FEW_CELLS: usize = 600;

/// What the planner knows: where a disc can be.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannerMap {
    /// The raster, shared by all courses on it.
    pub raster: Arc<Raster>,
    /// The same with x and y exchanged, which falls into other cells.
    across: Arc<Raster>,
}

/// A route, and how much room it leaves beside the body.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedRoute {
    /// The checkpoints.
    pub plan: Plan,
    /// Room beside the body in m.
    pub margin_m: f32,
}

impl PlannerMap {
    /// The map of a raster.
    #[must_use]
    pub fn of_raster(raster: Raster) -> Self {
        let across = Arc::new(raster.transposed());
        Self { raster: Arc::new(raster), across }
    }

    /// The map of a vector world.
    ///
    /// # Errors
    /// See [`RasterError`].
    pub fn of_world(world: &VectorWorld) -> Result<Self, RasterError> {
        let ends = Bounds::of_point(world.start).union(&Bounds::of_point(world.goal));
        let all = world.shapes.iter().filter_map(bounds_of).fold(ends, |all, next| all.union(&next));
        let all = all.grown(SURROUNDINGS_M);
        let side = (all.high - all.low).max();
        let raster = Raster::within(all, world.shapes.iter(), CELL_M.max(side / CELLS_MAX))?;
        Ok(Self::of_raster(raster))
    }

    /// Free cells of the raster.
    #[must_use]
    pub fn free_cells(&self) -> usize {
        self.raster.free_cells()
    }

    /// Cells of a plan's decomposition as a share of the raster's free cells.
    #[must_use]
    pub fn cell_share(&self, plan: &Plan) -> f64 {
        let float = |count: usize| u32::try_from(count).map_or(f64::INFINITY, f64::from);
        float(plan.cells) / float(self.free_cells().max(1))
    }

    /// The route with the most room beside the body.
    ///
    /// # Errors
    /// Why there is none even for the body alone, or what the planner has no room for.
    pub fn route(&self, from: Point2<f64>, goal: Point2<f64>) -> Result<PlannedRoute, PlanError> {
        let mut last = PlanError::NoPassage { reach_m: 0.0 };
        for margin_m in MARGINS_M {
            let footprint = footprint(margin_m)?;
            match self.shortest(&footprint, from, goal) {
                Ok(plan) => return Ok(PlannedRoute { plan, margin_m }),
                Err(
                    error @ (PlanError::NoPassage { .. }
                    | PlanError::StartBlocked { .. }
                    | PlanError::GoalBlocked { .. }),
                ) => last = error,
                Err(error) => return Err(error),
            }
        }
        Err(last)
    }

    /// The shorter of two plans of one disc, with the cells cut along and across, where they are few.
    ///
    /// The planner finds what bends at its cells' corners, and one passage is crossed from one bend only: it may take
    /// the wrong side of an obstacle, and with other cells it mostly does not.
    fn shortest(
        &self,
        footprint: &Footprint,
        from: Point2<f64>,
        goal: Point2<f64>,
    ) -> Result<Plan, PlanError> {
        let along = route_planner::plan_long(&self.raster, footprint, from, goal)?;
        if along.cells > FEW_CELLS {
            return Ok(along);
        }
        // One that fails, for its cells are more than there is room for, leaves the other.
        let across = route_planner::plan_long(&self.across, footprint, exchanged(from), exchanged(goal));
        let Ok(mut across) = across else { return Ok(along) };
        across.checkpoints.iter_mut().for_each(|place| *place = exchanged(*place));
        Ok(if across.length_m(from) < along.length_m(from) { across } else { along })
    }
}

/// x and y exchanged.
fn exchanged(place: Point2<f64>) -> Point2<f64> {
    Point2::new(place.y, place.x)
}

/// The body with so much room beside it.
pub(super) fn footprint(margin_m: f32) -> Result<Footprint, PlanError> {
    Footprint::new(narrow(KHEPERA_RADIUS_M), margin_m)
}

/// A world to cross and all that its runs share.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// World, start and goal.
    pub scenario: Scenario,
    /// The planner's map.
    pub map: PlannerMap,
    /// The route; or why there is none.
    pub route: Result<PlannedRoute, PlanError>,
    /// Where the robot shall go.
    pub goal: Point2<f64>,
    /// How near its centre must come, in m.
    pub goal_tolerance_m: f64,
    /// Length of the shortest way in m: the benchmark's if it says one, else the planned one, else the straight one.
    pub shortest_m: f64,
    /// Width of the tightest gap that no way avoids, in m.
    pub gap_m: Option<f64>,
    /// Metres here for a metre of the source.
    pub scale: Option<f64>,
}

impl Course {
    /// The course through a vector world.
    ///
    /// # Errors
    /// See [`RasterError`]; that there is no route is no error.
    pub fn of_world(world: VectorWorld) -> Result<Self, RasterError> {
        let map = PlannerMap::of_world(&world)?;
        let route = map.route(world.start, world.goal);
        let start = start_at(world.start, world.heading_rad);
        let scenario = Scenario::of_known(&world.name, &world.source, world.shapes, start, world.goal);
        let shortest_m =
            world.reference_length_m.unwrap_or_else(|| length_of(&route, world.start, world.goal));
        Ok(Self {
            scenario,
            map,
            route,
            goal: world.goal,
            goal_tolerance_m: world.goal_tolerance_m,
            shortest_m,
            gap_m: world.gap_m,
            scale: world.scale,
        })
    }

    /// OT: the time of the shortest way at the top speed, in s.
    #[must_use]
    pub fn shortest_s(&self, speed_limit_mps: f32) -> f64 {
        self.shortest_m / f64::from(speed_limit_mps)
    }
}

/// A start that is the same for all runs.
pub(super) fn start_at(position: Point2<f64>, heading_rad: f64) -> Start {
    Start { position, heading_rad, jitter_position_m: 0.0, jitter_heading_rad: 0.0 }
}

/// Length of a route, or of the straight way where there is none.
pub(super) fn length_of(
    route: &Result<PlannedRoute, PlanError>,
    start: Point2<f64>,
    goal: Point2<f64>,
) -> f64 {
    route.as_ref().map_or_else(|_| (goal - start).norm(), |route| route.plan.length_m(start))
}
