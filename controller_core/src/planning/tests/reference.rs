//! A slow planner to compare with: shares no code with the fast one, computes in `f64`, stores everything.

extern crate std;

use std::collections::BinaryHeap;
use std::vec::Vec;

use super::super::Workspace;
use super::world::World;

/// Moves of the lattice search: all coprime steps up to 3 each way. A straight line in free space comes out at most
/// 1.4 % too long.
const STEPS: [(i32, i32); 32] = {
    let quarter = [(1, 0), (3, 1), (2, 1), (3, 2), (1, 1), (2, 3), (1, 2), (1, 3)];
    let mut steps = [(0, 0); 32];
    let mut i = 0;
    while i < 8 {
        let (x, y) = quarter[i];
        steps[4 * i] = (x, y);
        steps[4 * i + 1] = (-y, x);
        steps[4 * i + 2] = (-x, -y);
        steps[4 * i + 3] = (y, -x);
        i += 1;
    }
    steps
};

/// Distance from a point to a segment.
fn point_to_segment(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let squared = dx * dx + dy * dy;
    let share =
        if squared > 0.0 { ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / squared } else { 0.0 }.clamp(0.0, 1.0);
    (a.0 + share * dx - p.0).hypot(a.1 + share * dy - p.1)
}

/// Distance from a segment to the square of edge 1 at whole coordinates, both in cells.
fn segment_to_square(a: (f64, f64), b: (f64, f64), (column, row): (i32, i32)) -> f64 {
    let (left, bottom) = (f64::from(column), f64::from(row));
    // Does the segment meet the square? Clip it to both strips (Liang and Barsky).
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let mut misses = false;
    for (from, to, low) in [(a.0, b.0, left), (a.1, b.1, bottom)] {
        let step = to - from;
        if step == 0.0 {
            misses |= from < low || from > low + 1.0;
        } else {
            let (t0, t1) = ((low - from) / step, (low + 1.0 - from) / step);
            enter = enter.max(t0.min(t1));
            leave = leave.min(t0.max(t1));
        }
    }
    if !misses && enter <= leave {
        return 0.0;
    }
    let corners = [(left, bottom), (left + 1.0, bottom), (left, bottom + 1.0), (left + 1.0, bottom + 1.0)];
    let of_corners =
        corners.map(|corner| point_to_segment(corner, a, b)).into_iter().fold(f64::MAX, f64::min);
    let of_ends = [a, b].map(|end| {
        let (x, y) = (end.0.clamp(left, left + 1.0), end.1.clamp(bottom, bottom + 1.0));
        (end.0 - x).hypot(end.1 - y)
    });
    of_corners.min(of_ends[0]).min(of_ends[1])
}

/// The next whole number at or below.
#[expect(clippy::cast_possible_truncation, reason = "rasters of tests are a few hundred cells")]
fn whole(value: f64) -> i32 {
    value.floor() as i32
}

/// Distance in cells from a segment to the next wall, as far as `within`.
pub fn clearance(world: &World, a: (f64, f64), b: (f64, f64), within: f64) -> f64 {
    let low = |p: f64, q: f64| whole(p.min(q) - within) - 1;
    let high = |p: f64, q: f64| whole(p.max(q) + within) + 1;
    let mut least = within;
    for column in low(a.0, b.0)..=high(a.0, b.0) {
        for row in low(a.1, b.1)..=high(a.1, b.1) {
            let free = u16::try_from(column).is_ok_and(|column| {
                u16::try_from(row).is_ok_and(|row| {
                    column < world.columns() && row < world.rows() && world.is_free(column, row)
                })
            });
            if !free {
                least = least.min(segment_to_square(a, b, (column, row)));
            }
        }
    }
    least
}

/// Shortest way of a disc over a lattice with `fineness` points per cell edge; `None` when there is none.
///
/// All in cells. Start and goal must be lattice points.
pub fn shortest(
    world: &World,
    radius: f64,
    fineness: i32,
    start: (i32, i32),
    goal: (i32, i32),
) -> Option<f64> {
    let (columns, rows) = (i32::from(world.columns()) * fineness + 1, i32::from(world.rows()) * fineness + 1);
    let place = |(x, y): (i32, i32)| (f64::from(x) / f64::from(fineness), f64::from(y) / f64::from(fineness));
    let index = |(x, y): (i32, i32)| usize::try_from(y * columns + x).unwrap();
    let radius = radius * (1.0 - 1e-5);
    let clear: Vec<bool> = (0..rows)
        .flat_map(|y| (0..columns).map(move |x| (x, y)))
        .map(|at| clearance(world, place(at), place(at), radius + 1.0) >= radius)
        .collect();
    let mut cost = std::vec![f64::INFINITY; clear.len()];
    let mut queue = BinaryHeap::new();
    if !clear[index(start)] {
        return None;
    }
    cost[index(start)] = 0.0;
    queue.push((core::cmp::Reverse(0.0_f64.to_bits()), start));
    while let Some((_, at)) = queue.pop() {
        if at == goal {
            return Some(cost[index(at)]);
        }
        for step in STEPS {
            let next = (at.0 + step.0, at.1 + step.1);
            if next.0 < 0 || next.1 < 0 || next.0 >= columns || next.1 >= rows || !clear[index(next)] {
                continue;
            }
            let length = f64::from(step.0).hypot(f64::from(step.1)) / f64::from(fineness);
            let total = cost[index(at)] + length;
            if total + 1e-9 >= cost[index(next)]
                || clearance(world, place(at), place(next), radius + 0.1) < radius
            {
                continue;
            }
            cost[index(next)] = total;
            // The bits of numbers above 0 are in their order.
            queue.push((core::cmp::Reverse(total.to_bits()), next));
        }
    }
    None
}
