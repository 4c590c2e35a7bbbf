//! Planning: from a known map to a sparse list of **checkpoints**, the top of the architecture and its slowest part.
//!
//! The planner is asked when there is a new goal or a new map (seconds to minutes); target reaching takes its
//! checkpoints one after the other, and obstacle avoidance deals with all that the map does not show. Without a
//! planner ("decapitated") the rest still works, with the goal as the only checkpoint.
//!
//! Source: approximate cell decomposition of the workspace, P1 section 2.1 and P2 section II (Low, Leow, Ang, AAMAS
//! 2002 and ICRA 2003): few cells, any two points of a cell can be joined by reactive motion, checkpoints at the
//! doors between them.
//!
//! # Terms
//! - [`Workspace`]: the known map as a raster. *Quarter-cells* are the planner's unit of length.
//! - **disc**: the robot's body and a margin, [`Footprint`]. A place is *clear* when the disc there touches no wall.
//! - **lattice**: points a quarter of a raster cell apart.
//! - **cell**: neighbouring column pieces of clear lattice points that share a band of rows (`cell_decomposition.rs`).
//! - **passage**: where two cells touch; **doorway**: a place on the way between two walls that are close.
//! - **corner**: where a wall begins or ends in a cell or at a passage; a shortest way bends there and nowhere else.
//!
//! # Steps
//! 1. sweep the raster once from left to right into cells, passages and corners, and leave out dead ends;
//! 2. A* over corners and passages, from goal to start (`search.rs`), and back where that costs little; where it takes
//!    long and the way is crooked, anew after a survey of how far the cells are by their passages;
//! 3. pull the way taut, cut its corners, move it to the middle of doorways (`route.rs`).
//!
//! # What holds
//! Every straight join of start and checkpoints is tested by sweeping the disc over the raster, exactly up to 1/1000
//! of a raster cell. A plan is found whenever the disc can go from lattice point to lattice point; the lattice
//! holds the middle of every gap, so what is missed are doors that are wide enough by less than about a
//! quarter of a raster cell. The outcome depends on the arguments only: ties go to the lower index.
//!
//! # What does not
//! The way is not proven shortest: of all bends that a passage can be crossed from, the search keeps one; and where it
//! has settled thousands of nodes it trusts the straight or surveyed rest of the way more than it should. It may pick
//! the wrong side of an obstacle. `docs/numbers.md` says by how much ways were longer than the shortest.
//!
//! # Open in the papers, and we chose
//! - How the workspace is cut: into column pieces with a common band, which are fewer than rectangles.
//! - What makes a passage passable: the disc fits, tested on the raster.
//! - Which way through the cells: the shortest found for the disc.
//! - Where in a door the checkpoint lies: in its middle if the door is at most three discs wide.
//!
//! # We changed
//! - The papers' cells leave the robot's size to reactive motion. Ours hold only places where the disc is clear, since
//!   a plan through a door that is too narrow is no plan. Nothing inflated is stored.
//! - Corners that are not in a doorway get a checkpoint too where the straight join would touch a wall.

use core::fmt;

use crate::scalar::Scalar;
use crate::units::Point;

pub mod checkpoint;

mod cell_decomposition;
mod clearance;
mod index;
mod route;
mod search;
mod workspace;

#[cfg(test)]
mod tests;

pub use index::Index;
pub use workspace::{BitGrid, GridError, Workspace};

use cell_decomposition::Decomposition;
use clearance::{Clearance, FINENESS, REACH_MAX, Spot, floor};
use route::{Full, Route};
use search::{Problem, Search, Terminal};

/// A search that has settled no more nodes than this takes far less time than the sweep, and is made from both ends.
const QUICK: usize = 1000;

/// The way from the other end must be shorter by this factor to be worth a change.
const SHORTER: f32 = 0.999;

/// Columns and rows that a raster may have: coordinates stay exact to 1/1000 of a cell in `f32`.
pub const SIDE_MAX: u16 = 4096;

/// Radius of the disc in quarter-cells for which all bounds hold.
const REACH: core::ops::RangeInclusive<f32> = 0.08..=REACH_MAX;

/// The disc that must fit: the robot's body and what it should keep away from walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    radius_m: f32,
    margin_m: f32,
}

impl Footprint {
    /// A body of `radius_m` metres (above 0) that keeps `margin_m` metres (0 or more) away from walls.
    ///
    /// # Errors
    /// [`PlanError::BadFootprint`] when either is out of its range or not a number.
    pub fn new(radius_m: f32, margin_m: f32) -> Result<Self, PlanError> {
        let sum = radius_m + margin_m;
        if sum.is_finite() && radius_m > 0.0 && margin_m >= 0.0 {
            Ok(Self { radius_m, margin_m })
        } else {
            Err(PlanError::BadFootprint { radius_m, margin_m })
        }
    }

    /// Radius of the disc, margin included, in metres.
    #[must_use]
    pub fn reach_m(&self) -> f32 {
        self.radius_m + self.margin_m
    }
}

/// Why there is no plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanError {
    /// Radius not above 0, margin below 0, or not numbers.
    BadFootprint {
        /// Radius given.
        radius_m: f32,
        /// Margin given.
        margin_m: f32,
    },
    /// The disc covers too many raster cells, or too small a part of one.
    RasterMismatch {
        /// Radius and margin of the disc.
        reach_m: f32,
        /// Edge of a raster cell.
        cell_size_m: f32,
    },
    /// The raster has no cells, more than [`SIDE_MAX`] in a row or column, or no finite place in the world.
    BadMap {
        /// Columns of the raster.
        columns: u16,
        /// Rows of the raster.
        rows: u16,
    },
    /// The start is not on the raster.
    StartOutside {
        /// x of the start.
        x_m: f32,
        /// y of the start.
        y_m: f32,
    },
    /// The disc at the start touches a wall, or the edge of the raster.
    StartBlocked {
        /// x of the start.
        x_m: f32,
        /// y of the start.
        y_m: f32,
    },
    /// The goal is not on the raster.
    GoalOutside {
        /// x of the goal.
        x_m: f32,
        /// y of the goal.
        y_m: f32,
    },
    /// The disc at the goal touches a wall, or the edge of the raster.
    GoalBlocked {
        /// x of the goal.
        x_m: f32,
        /// y of the goal.
        y_m: f32,
    },
    /// No way from start to goal is wide enough for the disc.
    NoPassage {
        /// Radius and margin of the disc.
        reach_m: f32,
    },
    /// The map falls into more cells than the planner has room for.
    TooManyCells {
        /// Room for cells.
        capacity: usize,
    },
    /// The cells have more passages and corners than the planner has room for.
    TooManyPassages {
        /// Room for passages and corners.
        capacity: usize,
    },
    /// The way has more bends than the plan has room for.
    TooManyCheckpoints {
        /// Room for checkpoints.
        capacity: usize,
    },
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadFootprint { radius_m, margin_m } => {
                write!(
                    f,
                    "radius {radius_m} m, margin {margin_m} m: give a radius above 0 and a margin of 0 or more"
                )
            }
            Self::RasterMismatch { reach_m, cell_size_m } => write!(
                f,
                "a disc of radius {reach_m} m on raster cells of {cell_size_m} m: choose cells between 1/24 and 50 \
                 times the disc's radius"
            ),
            Self::BadMap { columns, rows } => write!(
                f,
                "a raster of {columns} x {rows} cells: give 1 to {SIDE_MAX} each way, a cell size above 0 and an \
                 origin within the scalar's range"
            ),
            Self::StartOutside { x_m, y_m } => {
                write!(f, "the start ({x_m}, {y_m}) m is outside of the map: move it, or enlarge the map")
            }
            Self::StartBlocked { x_m, y_m } => {
                write!(
                    f,
                    "the start ({x_m}, {y_m}) m is in a wall or too near: move it, or reduce the margin"
                )
            }
            Self::GoalOutside { x_m, y_m } => {
                write!(f, "the goal ({x_m}, {y_m}) m is outside of the map: move it, or enlarge the map")
            }
            Self::GoalBlocked { x_m, y_m } => {
                write!(f, "the goal ({x_m}, {y_m}) m is in a wall or too near: move it, or reduce the margin")
            }
            Self::NoPassage { reach_m } => write!(
                f,
                "no way to the goal is {} m wide: reduce the margin, or use a finer raster",
                2.0 * reach_m
            ),
            Self::TooManyCells { capacity } => {
                write!(f, "the map has more than {capacity} cells: raise CELLS, or coarsen the raster")
            }
            Self::TooManyPassages { capacity } => {
                write!(
                    f,
                    "the map has more than {capacity} passages and corners: raise PASSAGES, or coarsen the raster"
                )
            }
            Self::TooManyCheckpoints { capacity } => {
                write!(f, "the way has more than {capacity} checkpoints: raise CHECKPOINTS")
            }
        }
    }
}

impl core::error::Error for PlanError {}

/// Which of the planner's stores is full.
#[derive(Clone, Copy, Debug)]
enum Overflow {
    Cells,
    Passages,
}

/// A lattice coordinate for storage; rasters are at most 4096 cells, so all fit.
fn lattice_index(value: i32) -> u16 {
    u16::try_from(value).unwrap_or(0)
}

/// The planner with its scratch memory; what it holds between two plans is of no consequence.
///
/// It takes 22 bytes per cell and 45 per passage or corner (7 kB for 64 and 128), and on a 512 × 512 raster up to some
/// ten milliseconds of a desktop core, the more the fuller the map. Random worlds had less than one cell per obstacle,
/// and four to seven passages and corners per cell.
///
/// `I` is what cells and passages are numbered with. `u16` does for 16,382 passages and corners; for more there is
/// [`Planner::wide`].
///
/// ```
/// use controller_core::planning::{BitGrid, Footprint, Planner};
/// use controller_core::units::Point;
///
/// // A room of 0.32 m x 0.32 m, rasterised at 10 mm.
/// let room = BitGrid::<32>::new(32, 32, 0.01, (0.0, 0.0)).unwrap();
/// let robot = Footprint::new(0.025, 0.005).unwrap();
/// let (start, goal) = (Point::<f32>::from_metres(0.05, 0.05), Point::from_metres(0.25, 0.2));
/// let plan = Planner::<8, 8>::new().plan::<_, _, 4>(&room, &robot, start, goal).unwrap();
/// assert_eq!(plan.as_slice(), [goal]);
/// ```
pub struct Planner<const CELLS: usize, const PASSAGES: usize, I = u16> {
    map: Decomposition<I, CELLS, PASSAGES>,
    search: Search<I, PASSAGES>,
}

impl<const CELLS: usize, const PASSAGES: usize> Default for Planner<CELLS, PASSAGES> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const CELLS: usize, const PASSAGES: usize> Planner<CELLS, PASSAGES> {
    /// A planner with room for `CELLS` cells and `PASSAGES` passages and corners; fit for a `static`.
    #[must_use]
    pub const fn new() -> Self {
        Self::with_numbers()
    }
}

impl<const CELLS: usize, const PASSAGES: usize> Planner<CELLS, PASSAGES, u32> {
    /// A planner with room for more cells and passages than 16 bits can number; fit for a `static`.
    #[must_use]
    pub const fn wide() -> Self {
        Self::with_numbers()
    }
}

impl<const CELLS: usize, const PASSAGES: usize, I: Index> Planner<CELLS, PASSAGES, I> {
    const fn with_numbers() -> Self {
        const {
            assert!(CELLS <= I::PASSAGES_MAX && PASSAGES <= I::PASSAGES_MAX);
        }
        Self { map: Decomposition::new(), search: Search::new() }
    }

    /// Cells of the last plan.
    #[must_use]
    pub fn cell_count(&self) -> usize {
        self.map.cells.len()
    }

    /// Passages between the cells of the last plan, corners not among them.
    #[must_use]
    pub fn passage_count(&self) -> usize {
        self.map.passages.iter().filter(|passage| passage.is_passage()).count()
    }

    /// Checkpoints from `start` to `goal` (world frame) for the disc of `robot`; the last one is `goal` as given.
    ///
    /// The disc can be moved along the straight lines from the start over all checkpoints without touching a cell
    /// that is not free. Gaps of the map on that way that are at most three discs wide are passed in the middle.
    ///
    /// # Errors
    /// [`PlanError`]; each names what to change.
    pub fn plan<S: Scalar, W: Workspace, const CHECKPOINTS: usize>(
        &mut self,
        workspace: &W,
        robot: &Footprint,
        start: Point<S>,
        goal: Point<S>,
    ) -> Result<heapless::Vec<Point<S>, CHECKPOINTS>, PlanError> {
        self.map.cells.clear();
        self.map.passages.clear();
        let frame = Frame::new::<S, W>(workspace)?;
        let reach = robot.reach_m() / frame.quarter_cell_m;
        if !REACH.contains(&reach) {
            let (reach_m, cell_size_m) = (robot.reach_m(), workspace.cell_size_m());
            return Err(PlanError::RasterMismatch { reach_m, cell_size_m });
        }
        let clearance = Clearance::new(workspace, reach);
        let (x_m, y_m) = (start.x_m.to_f32(), start.y_m.to_f32());
        let from = frame.spot(x_m, y_m).ok_or(PlanError::StartOutside { x_m, y_m })?;
        let from_anchor = anchor(&clearance, from).ok_or(PlanError::StartBlocked { x_m, y_m })?;
        let (x_m, y_m) = (goal.x_m.to_f32(), goal.y_m.to_f32());
        let to = frame.spot(x_m, y_m).ok_or(PlanError::GoalOutside { x_m, y_m })?;
        let to_anchor = anchor(&clearance, to).ok_or(PlanError::GoalBlocked { x_m, y_m })?;

        let found = self.map.build(&clearance, [from_anchor, to_anchor]);
        let [from_cell, to_cell] = found.map_err(|overflow| match overflow {
            Overflow::Cells => PlanError::TooManyCells { capacity: CELLS },
            Overflow::Passages => PlanError::TooManyPassages { capacity: PASSAGES },
        })?;
        let terminal = |spot, (x, y), cell| Terminal { spot, anchor: Spot::lattice(x, y), cell };
        let (start, end) = (terminal(from, from_anchor, from_cell), terminal(to, to_anchor, to_cell));
        let mut problem = Problem { clearance: &clearance, map: &self.map, start, goal: end };
        let mut found = Some(false);
        if from_cell != I::NONE && to_cell != I::NONE {
            self.search.begin(&problem);
            found = self.search.run(&problem);
        }
        if found.is_none() {
            self.search.survey(&mut self.map, &start, &end);
            problem = Problem { clearance: &clearance, map: &self.map, start, goal: end };
            self.search.begin_surveyed(&problem);
            found = self.search.run(&problem);
        }
        if found != Some(true) {
            return Err(PlanError::NoPassage { reach_m: robot.reach_m() });
        }
        let quick = self.search.settled_count <= QUICK;
        let mut way = self.way::<W, CHECKPOINTS>(&problem).map_err(|_| too_many(CHECKPOINTS))?;
        if quick {
            // What a search gets wrong from one end it mostly gets right from the other.
            let problem = Problem { start: problem.goal, goal: problem.start, ..problem };
            self.search.begin(&problem);
            let found = self.search.run(&problem) == Some(true);
            if let Some(back) = found.then(|| self.way::<W, CHECKPOINTS>(&problem).ok()).flatten()
                && length(to, &back) < SHORTER * length(from, &way)
            {
                way = reversed(&back, to);
            }
        }
        let mut plan: heapless::Vec<_, CHECKPOINTS> = way.iter().map(|&spot| frame.point(spot)).collect();
        if let Some(last) = plan.last_mut() {
            *last = goal;
        }
        Ok(plan)
    }

    /// The way that the search has found, short and fit to drive.
    fn way<W: Workspace, const N: usize>(
        &self,
        problem: &Problem<'_, W, I, CELLS, PASSAGES>,
    ) -> Result<heapless::Vec<Spot, N>, Full> {
        let mut route = Route::<W, N>::new(problem.clearance, problem.start.spot);
        self.search.walk(problem, |spot| route.extend(spot))?;
        route.finish()
    }
}

fn too_many(capacity: usize) -> PlanError {
    PlanError::TooManyCheckpoints { capacity }
}

/// Length of a way from a spot over others.
fn length(from: Spot, way: &[Spot]) -> f32 {
    let befores = core::iter::once(&from).chain(way);
    befores.zip(way).map(|(before, spot)| before.distance_to(*spot)).sum()
}

/// The way back: from the end of `way`, left out, to where it began.
fn reversed<const N: usize>(way: &heapless::Vec<Spot, N>, from: Spot) -> heapless::Vec<Spot, N> {
    way.iter().rev().skip(1).copied().chain(core::iter::once(from)).collect()
}

/// Whether the disc of `robot` can be moved straight from one place to another without touching a cell that is not
/// free.
///
/// Exact up to 1/1000 of a raster cell. Also false where the disc does not suit the raster ([`Planner::plan`] says why)
/// or a place is not on it.
#[must_use]
pub fn is_straight_clear<S: Scalar, W: Workspace>(
    workspace: &W,
    robot: &Footprint,
    from: Point<S>,
    to: Point<S>,
) -> bool {
    let Ok(frame) = Frame::new::<S, W>(workspace) else { return false };
    let reach = robot.reach_m() / frame.quarter_cell_m;
    if !REACH.contains(&reach) {
        return false;
    }
    let spot = |place: Point<S>| frame.spot(place.x_m.to_f32(), place.y_m.to_f32());
    let (Some(from), Some(to)) = (spot(from), spot(to)) else { return false };
    Clearance::new(workspace, reach).is_clear(from, to)
}

/// Where the raster lies in the world.
struct Frame {
    origin_m: (f32, f32),
    quarter_cell_m: f32,
    /// Upper right corner in quarter-cells.
    size: Spot,
}

impl Frame {
    fn new<S: Scalar, W: Workspace>(workspace: &W) -> Result<Self, PlanError> {
        let (columns, rows) = (workspace.columns(), workspace.rows());
        let quarter_cell_m = 0.25 * workspace.cell_size_m();
        let origin_m = workspace.origin_m();
        let size = Spot { x: 4.0 * f32::from(columns), y: 4.0 * f32::from(rows) };
        let range = -S::LIMIT.to_f32()..=S::LIMIT.to_f32();
        let ends = [
            origin_m.0,
            origin_m.1,
            origin_m.0 + size.x * quarter_cell_m,
            origin_m.1 + size.y * quarter_cell_m,
        ];
        let sides = 1..=SIDE_MAX;
        let sound = quarter_cell_m > 0.0 && ends.iter().all(|end| range.contains(end));
        if !sound || !sides.contains(&columns) || !sides.contains(&rows) {
            return Err(PlanError::BadMap { columns, rows });
        }
        Ok(Self { origin_m, quarter_cell_m, size })
    }

    /// A world point on the raster, `None` outside of it (also when it is not a number).
    fn spot(&self, x_m: f32, y_m: f32) -> Option<Spot> {
        let spot = Spot {
            x: (x_m - self.origin_m.0) / self.quarter_cell_m,
            y: (y_m - self.origin_m.1) / self.quarter_cell_m,
        };
        let inside = (0.0..=self.size.x).contains(&spot.x) && (0.0..=self.size.y).contains(&spot.y);
        inside.then_some(spot)
    }

    /// A spot in the world.
    fn point<S: Scalar>(&self, spot: Spot) -> Point<S> {
        Point::from_metres(
            self.origin_m.0 + spot.x * self.quarter_cell_m,
            self.origin_m.1 + spot.y * self.quarter_cell_m,
        )
    }
}

/// The nearest clear lattice point in straight reach of `spot`; `None` when the disc does not fit there.
fn anchor<W: Workspace>(clearance: &Clearance<'_, W>, spot: Spot) -> Option<(i32, i32)> {
    if !clearance.is_clear(spot, spot) {
        return None;
    }
    let (x, y) = (floor(spot.x), floor(spot.y));
    let mut best = None;
    let mut nearest = f32::INFINITY;
    // One raster cell each way: a disc between walls that no nearer lattice point suits can still leave.
    for column in x - FINENESS..=x + FINENESS + 1 {
        for row in y - FINENESS..=y + FINENESS + 1 {
            let point = Spot::lattice(column, row);
            let distance = spot.distance_to(point);
            if distance < nearest && clearance.is_clear_at(column, row) && clearance.is_clear(spot, point) {
                nearest = distance;
                best = Some((column, row));
            }
        }
    }
    best
}
