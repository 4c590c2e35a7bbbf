//! The core's planner on the simulator's maps: a scenario's known walls become checkpoints.

use std::sync::{Mutex, PoisonError};

use controller_core::planning::{Footprint, Index, PlanError, Planner, Workspace};
use controller_core::units::Point;
use nalgebra::Point2;

use crate::number::{narrow, narrow_point};
use crate::raster::{Raster, RasterError};
use crate::scenario::Scenario;

/// Side of a cell of the planner's map; a tenth of a doorway.
pub const CELL_SIZE_M: f64 = 0.01;

/// Room that a plan leaves beside the body.
pub const MARGIN_M: f32 = 0.01;

/// Most checkpoints of a plan: what the controller holds.
const CHECKPOINTS: usize = controller_core::controller::CHECKPOINTS;

impl Workspace for Raster {
    fn columns(&self) -> u16 {
        Self::columns(self)
    }

    fn rows(&self) -> u16 {
        Self::rows(self)
    }

    fn cell_size_m(&self) -> f32 {
        Self::cell_size_m(self)
    }

    fn origin_m(&self) -> (f32, f32) {
        Self::origin_m(self)
    }

    fn is_free(&self, column: u16, row: u16) -> bool {
        Self::is_free(self, column, row)
    }

    fn next_wall(&self, column: u16, row: u16) -> u16 {
        Self::next_wall(self, column, row)
    }

    fn walls(&self, column: u16, row: u16) -> u64 {
        Self::walls(self, column, row)
    }
}

/// Why there is no plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RouteError {
    /// There is no map to plan on.
    #[error("no map to plan on: {0}")]
    Map(#[from] RasterError),
    /// The planner found no way.
    #[error("no plan: {0}")]
    Plan(#[from] PlanError),
}

/// A plan and what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The checkpoints; the last is the goal.
    pub checkpoints: Vec<Point2<f64>>,
    /// Cells of the decomposition.
    pub cells: usize,
    /// Passages between them.
    pub passages: usize,
}

impl Plan {
    /// Length of the way from `from` over all checkpoints, in m.
    #[must_use]
    pub fn length_m(&self, from: Point2<f64>) -> f64 {
        let befores = core::iter::once(&from).chain(&self.checkpoints);
        befores.zip(&self.checkpoints).map(|(before, place)| (place - before).norm()).sum()
    }
}

/// Plans from a place to a scenario's goal on what is known at `t_s`.
///
/// # Errors
/// If there is no map, or no way on it.
pub fn plan(scenario: &Scenario, from: Point2<f64>, t_s: f64) -> Result<Plan, RouteError> {
    let raster = scenario.known_raster_at(CELL_SIZE_M, t_s)?;
    let goal = scenario.goal().unwrap_or(from);
    let footprint = Footprint::new(narrow(crate::world::KHEPERA_RADIUS_M), MARGIN_M)?;
    let mut planner = Box::new(SmallPlanner::new());
    Ok(planner.plan_on::<CHECKPOINTS>(&raster, &footprint, from, goal)?)
}

/// Large enough for the rooms of the papers, and for most of what is tried.
type SmallPlanner = Planner<1024, 4096>;

/// For maps of 512 x 512 cells of which any are obstacles: at most one cell for four raster cells and six passages or
/// corners for a cell were seen where 40 % are strewn about, and in mazes with corridors of one cell. One for all
/// threads: made on a thread's stack it would be more than the stack.
static LARGE: Mutex<Planner<65_536, 262_144, u32>> = Mutex::new(Planner::wide());

/// Most checkpoints of a route through few cells.
const SMALL_ROUTE: usize = 2048;

/// Most checkpoints of a long route, which goes to the controller in parts: the longest ways through such mazes.
const LONG_ROUTE: usize = 16_384;

/// Plans a route of any length on a map of any size; what it is too large for is a [`PlanError`].
///
/// # Errors
/// If there is no way for the disc, or the map is beyond the largest planner.
pub fn plan_long(
    raster: &Raster,
    footprint: &Footprint,
    from: Point2<f64>,
    goal: Point2<f64>,
) -> Result<Plan, PlanError> {
    let mut planner = Box::new(SmallPlanner::new());
    match planner.plan_on::<SMALL_ROUTE>(raster, footprint, from, goal) {
        Err(
            PlanError::TooManyCells { .. }
            | PlanError::TooManyPassages { .. }
            | PlanError::TooManyCheckpoints { .. },
        ) => on_large_stack(|| {
            // Each plan begins anew, also after one that a panic has cut short.
            let mut large = LARGE.lock().unwrap_or_else(PoisonError::into_inner);
            large.plan_on::<LONG_ROUTE>(raster, footprint, from, goal)
        }),
        done => done,
    }
}

/// Does something on a thread with room for long routes, several of which a search has on its stack.
///
/// # Panics
/// If the system has no thread to spare.
fn on_large_stack<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    const STACK_BYTES: usize = 16 << 20;
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work);
        match thread.expect("the system has a thread to spare").join() {
            Ok(done) => done,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// A planner of some size, with places and plans as the simulator has them.
trait PlanOn {
    fn plan_on<const N: usize>(
        &mut self,
        raster: &Raster,
        footprint: &Footprint,
        from: Point2<f64>,
        goal: Point2<f64>,
    ) -> Result<Plan, PlanError>;
}

impl<const CELLS: usize, const PASSAGES: usize, I: Index> PlanOn for Planner<CELLS, PASSAGES, I> {
    fn plan_on<const N: usize>(
        &mut self,
        raster: &Raster,
        footprint: &Footprint,
        from: Point2<f64>,
        goal: Point2<f64>,
    ) -> Result<Plan, PlanError> {
        let (from, goal) = (narrow_point(from), narrow_point(goal));
        let route = self.plan::<f32, Raster, N>(raster, footprint, from, goal)?;
        let widen = |point: &Point<f32>| Point2::new(f64::from(point.x_m), f64::from(point.y_m));
        Ok(Plan {
            checkpoints: route.iter().map(widen).collect(),
            cells: self.cell_count(),
            passages: self.passage_count(),
        })
    }
}

/// Length of the shortest way from the start to the goal that the body fits along, over all checkpoints that are given,
/// in m: as a planner would find it that knows all that is there at the start; where checkpoints are replaced under
/// way, by those that replace them, and with what is there in the end. `None` where it finds none.
#[must_use]
pub fn shortest_m(scenario: &Scenario) -> Option<f64> {
    let at_s = if scenario.replacements.is_empty() { 0.0 } else { scenario.time_limit_s };
    let there = scenario.solids.iter().filter(|solid| solid.window.contains(at_s)).map(|solid| &solid.shape);
    let mut planner = Box::new(Planner::<1024, 4096>::new());
    let footprint = Footprint::new(narrow(crate::world::KHEPERA_RADIUS_M), 0.0).ok()?;
    let raster = Raster::of(there, CELL_SIZE_M / 2.0).ok();
    let mut at = scenario.start.position;
    let mut length_m = 0.0;
    let mut checkpoints = scenario.route.checkpoints().to_vec();
    for replacement in &scenario.replacements {
        if let Some(checkpoint) = checkpoints.get_mut(replacement.checkpoint) {
            *checkpoint = replacement.to;
        }
    }
    for checkpoint in checkpoints {
        let Some(raster) = &raster else {
            length_m += (checkpoint - at).norm();
            at = checkpoint;
            continue;
        };
        let (from, to) = (narrow_point(at), narrow_point(checkpoint));
        let route = planner.plan::<f32, Raster, 64>(raster, &footprint, from, to).ok()?;
        for point in &route {
            let next = Point2::new(f64::from(point.x_m), f64::from(point.y_m));
            length_m += (next - at).norm();
            at = next;
        }
    }
    Some(length_m)
}

#[cfg(test)]
mod tests {
    use controller_core::planning::Workspace;

    use crate::scenario::Scenario;

    #[test]
    fn the_shortest_way_goes_by_the_checkpoint_that_counts_in_the_end() {
        let scenario = Scenario::builtin("p1_fig9").unwrap();
        let mut unchanged = scenario.clone();
        unchanged.replacements.clear();
        let (shortest, before) =
            (super::shortest_m(&scenario).unwrap(), super::shortest_m(&unchanged).unwrap());
        assert!(shortest < 0.95 * before, "{shortest} {before}");
    }

    #[test]
    fn the_index_of_walls_agrees_with_the_cells() {
        let raster = Scenario::builtin("p2_fig6").unwrap().known_raster(0.01).unwrap();
        for column in 0..raster.columns() {
            for row in 0..=raster.rows() {
                let searched = (row..raster.rows()).find(|&row| !raster.is_free(column, row));
                assert_eq!(Workspace::next_wall(&raster, column, row), searched.unwrap_or(raster.rows()));
                let is_wall = |row: u16| row >= raster.rows() || !raster.is_free(column, row);
                let walls: u64 = (0..64).map(|bit| u64::from(is_wall(row + bit)) << bit).sum();
                assert_eq!(Workspace::walls(&raster, column, row), walls, "column {column}, row {row}");
            }
        }
    }
}
