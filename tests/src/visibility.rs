//! How many cells a map needs at least, whatever the planner.

use controller_core::planning::{Footprint, is_straight_clear};
use controller_core::units::Point;
use host_sim::raster::Raster;

/// Places tried along a side of a raster cell.
const FINENESS: u16 = 2;

/// A number of places of which the disc can go straight from none to another: in a decomposition into cells whose
/// places all see each other, each of them needs a cell of its own.
///
/// A lower bound, found greedily: of the places twice as dense as the raster's cells, always the one that sees the
/// fewest of those that are left. Takes time with the fourth power of the map's side.
#[must_use]
pub fn cells_needed(raster: &Raster, robot: &Footprint) -> usize {
    let step_m = raster.cell_size_m() / f32::from(FINENESS);
    let along = |count: u16| (1..count * FINENESS).map(move |index| f32::from(index) * step_m);
    let (x_m, y_m) = raster.origin_m();
    let places: Vec<Point<f32>> = along(raster.columns())
        .flat_map(|x| along(raster.rows()).map(move |y| Point { x_m: x_m + x, y_m: y_m + y }))
        .filter(|&place| is_straight_clear(raster, robot, place, place))
        .collect();
    let mut seen = vec![Vec::new(); places.len()];
    for (a, &from) in places.iter().enumerate() {
        for (b, &to) in places.iter().enumerate().skip(a + 1) {
            if is_straight_clear(raster, robot, from, to) {
                seen[a].push(b);
                seen[b].push(a);
            }
        }
    }
    let mut left = vec![true; places.len()];
    let mut sees: Vec<usize> = seen.iter().map(Vec::len).collect();
    let mut chosen = 0;
    while let Some(place) = (0..places.len()).filter(|&place| left[place]).min_by_key(|&place| sees[place]) {
        chosen += 1;
        left[place] = false;
        for &gone in &seen[place] {
            if core::mem::replace(&mut left[gone], false) {
                seen[gone].iter().for_each(|&other| sees[other] -= 1);
            }
        }
    }
    chosen
}
