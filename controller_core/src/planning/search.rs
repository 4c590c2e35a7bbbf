//! The shortest way through the passages: A* over their ends, from the goal back to the start.
//!
//! A shortest path bends only where a wall makes it, and the ends of the passages are where walls begin and end. The
//! way from one end to another is not looked for in the cell alone: as in Theta* (Nash, Daniel, Koenig, Felner,
//! AAAI 2007) an end may be joined straight to the bend *before* its neighbour, and as in Lazy Theta* (Nash, Koenig,
//! Tovey, AAAI 2010) the swept test is made only for ends that are taken from the queue.
//!
//! It runs from the goal to the start, so that the way can be read off in driving order.

use super::cell_decomposition::{Decomposition, NONE, Passage};
use super::clearance::{Clearance, Effort, Spot};
use super::workspace::Workspace;

/// The node of the goal; nodes below are `2 · passage + end`.
const GOAL: u16 = u16::MAX - 1;

/// The node of the start.
const START: u16 = u16::MAX - 2;

/// Passages that the node numbers have room for.
pub(super) const PASSAGES_MAX: usize = 32_766;

/// Position in the queue of a node that is settled, or not seen yet.
const SETTLED: u16 = u16::MAX - 1;
const UNSEEN: u16 = u16::MAX;

/// Start or goal, and how it is tied to the lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Terminal {
    pub spot: Spot,
    /// A clear lattice point in straight reach.
    pub anchor: Spot,
    /// The cell of the anchor.
    pub cell: u16,
}

/// What is known of one end of a passage.
#[derive(Clone, Copy)]
struct Node {
    /// Length of the way to the goal; a lower bound while not `tested`.
    cost: f32,
    /// The next node on the way to the goal.
    parent: u16,
    /// Where in the queue.
    position: u16,
    tested: bool,
}

const NEW: Node = Node { cost: f32::INFINITY, parent: NONE, position: UNSEEN, tested: false };

/// Scratch of the search.
pub(super) struct Search<const PASSAGES: usize> {
    nodes: [[Node; 2]; PASSAGES],
    /// Binary heap of nodes, least cost + distance first.
    queue: [[u16; 2]; PASSAGES],
    queued: usize,
    /// Cost and parent of the start.
    found: (f32, u16),
}

/// The bends of a way within one cell, ends included.
pub(super) type Bends = heapless::Vec<Spot, 6>;

/// What the search looks at.
pub(super) struct Problem<'a, W, const CELLS: usize, const PASSAGES: usize> {
    pub clearance: &'a Clearance<'a, W>,
    pub map: &'a Decomposition<CELLS, PASSAGES>,
    pub start: Terminal,
    pub goal: Terminal,
}

impl<W: Workspace, const CELLS: usize, const PASSAGES: usize> Problem<'_, W, CELLS, PASSAGES> {
    /// Where a node is.
    fn spot(&self, node: u16) -> Spot {
        match node {
            START => self.start.spot,
            GOAL => self.goal.spot,
            _ => self.map.passage(node / 2).map_or(self.goal.spot, |p| p.end(usize::from(node % 2))),
        }
    }

    /// The lattice point of `cell` that a node is tied to.
    fn entry(&self, node: u16, cell: u16) -> Spot {
        match node {
            START => self.start.anchor,
            GOAL => self.goal.anchor,
            _ => {
                self.map.passage(node / 2).map_or(self.goal.anchor, |p| p.entry(usize::from(node % 2), cell))
            }
        }
    }

    /// The nodes of a cell: both ends of its passages, or the only one.
    fn ends_of(&self, cell: u16) -> impl Iterator<Item = u16> + '_ {
        self.map.passages_of(cell).flat_map(|passage| {
            let ends = if self.map.passage(passage).is_some_and(Passage::is_point) { 1 } else { 2 };
            (0..ends).map(move |end| 2 * passage + end)
        })
    }

    /// The one or two cells that a node belongs to.
    fn cells(&self, node: u16) -> [u16; 2] {
        match node {
            START => [self.start.cell, NONE],
            GOAL => [self.goal.cell, NONE],
            _ => self.map.passage(node / 2).map_or([NONE; 2], |passage| passage.cells),
        }
    }

    /// The way between two nodes of one cell: straight, or along the cell's core.
    fn join_in(&self, cell: u16, from: u16, to: u16, effort: Effort) -> Bends {
        let mut bends = Bends::new();
        let (a, b) = (self.spot(from), self.spot(to));
        let (a_entry, b_entry) = (self.entry(from, cell), self.entry(to, cell));
        let Some(cell) = self.map.cells.get(usize::from(cell)) else { return bends };
        let (mut a_core, mut b_core) = (cell.core(a_entry), cell.core(b_entry));
        // Along the core no further than needed: leave it, and reach it, where the straight line is clear.
        let a_far = self.furthest(a, a_core, b_core, effort);
        a_core = a_far.unwrap_or(a_core);
        let b_far = self.furthest(b, b_core, a_core, effort);
        b_core = b_far.unwrap_or(b_core);
        let from_a = [a, a_entry];
        let from_b = [b_entry, b];
        let from_a = if a_far.is_some() { &from_a[..1] } else { &from_a[..] };
        let from_b = if b_far.is_some() { &from_b[1..] } else { &from_b[..] };
        for &spot in from_a.iter().chain(&[a_core, b_core]).chain(from_b) {
            if bends.last() != Some(&spot) {
                // Six places, at most six spots.
                let _ = bends.push(spot);
            }
        }
        // The core may be far off the shortest way; the search needs an honest length to choose a side by.
        self.clearance.tighten(&mut bends, effort);
        bends
    }

    /// The furthest point on the way from `near` to `far` that is found to be in straight reach of `eye`.
    fn furthest(&self, eye: Spot, near: Spot, far: Spot, effort: Effort) -> Option<Spot> {
        if self.clearance.is_clear(eye, far) {
            return Some(far);
        }
        if !self.clearance.is_clear(eye, near) {
            return None;
        }
        let (mut clear, mut blocked) = (0.0, 1.0);
        for _ in 0..effort.halvings {
            let middle = 0.5 * (clear + blocked);
            if self.clearance.is_clear(eye, near.towards(far, middle)) {
                clear = middle;
            } else {
                blocked = middle;
            }
        }
        Some(near.towards(far, clear))
    }

    /// The way between two nodes: straight where clear, else through a cell they share. Empty when they share none.
    fn join(&self, from: u16, to: u16, effort: Effort) -> Bends {
        let (a, b) = (self.spot(from), self.spot(to));
        if self.clearance.is_clear(a, b) {
            return Bends::from_iter([a, b]);
        }
        let mut best = Bends::new();
        let theirs = self.cells(to);
        for cell in self.cells(from) {
            if cell != NONE && theirs.contains(&cell) {
                let bends = self.join_in(cell, from, to, effort);
                if best.is_empty() || length(&bends) < length(&best) {
                    best = bends;
                }
            }
        }
        best
    }
}

/// Nodes that a node has no straight clear way to.
type Blocked = heapless::Vec<u16, 8>;

/// Length of a way; infinite when there is none.
fn length(bends: &Bends) -> f32 {
    if bends.is_empty() {
        return f32::INFINITY;
    }
    bends.iter().zip(bends.iter().skip(1)).map(|(a, b)| a.distance_to(*b)).sum()
}

impl<const PASSAGES: usize> Search<PASSAGES> {
    pub const fn new() -> Self {
        Self {
            nodes: [[NEW; 2]; PASSAGES],
            queue: [[NONE; 2]; PASSAGES],
            queued: 0,
            found: (f32::INFINITY, NONE),
        }
    }

    /// Whether the goal can be reached from the start; then [`Search::walk`] says how.
    pub fn run<W: Workspace, const CELLS: usize>(
        &mut self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
    ) -> bool {
        for pair in self.nodes.iter_mut().take(problem.map.passages.len()) {
            *pair = [NEW; 2];
        }
        self.queued = 0;
        self.found = (f32::INFINITY, NONE);
        self.expand(problem, GOAL);
        // Each round settles a node or tests one; a node is tested again only when a settled one offered better.
        while let Some(node) = self.pop(problem) {
            if self.node(node).cost + self.heuristic(problem, node) >= self.found.0 {
                break;
            }
            if self.node(node).tested {
                self.expand(problem, node);
                continue;
            }
            let (cost, parent) = self.best_parent(problem, node);
            if let Some(entry) = self.node_mut(node) {
                *entry = Node { cost, parent, position: UNSEEN, tested: true };
            }
            self.push(problem, node);
        }
        self.found.0 < f32::INFINITY
    }

    /// Calls `visit` with each bend from start to goal, the start left out.
    pub fn walk<W: Workspace, const CELLS: usize, E>(
        &self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
        mut visit: impl FnMut(Spot) -> Result<(), E>,
    ) -> Result<(), E> {
        let (mut from, mut to) = (START, self.found.1);
        for _ in 0..2 * PASSAGES + 2 {
            for &spot in problem.join(from, to, Effort::FINE).iter().skip(1) {
                visit(spot)?;
            }
            if to == GOAL {
                break;
            }
            (from, to) = (to, self.node(to).parent);
        }
        Ok(())
    }

    /// Settles a node and offers it to all nodes of its cells.
    fn expand<W: Workspace, const CELLS: usize>(
        &mut self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
        node: u16,
    ) {
        if let Some(entry) = self.node_mut(node) {
            entry.position = SETTLED;
        }
        let grandparent = self.parent(node);
        for cell in problem.cells(node).into_iter().filter(|&cell| cell != NONE) {
            for other in problem.ends_of(cell) {
                let entry = self.node(other);
                if entry.position == SETTLED {
                    continue;
                }
                let bound = self.cost(grandparent) + distance(problem, grandparent, other);
                if bound < entry.cost {
                    if let Some(entry) = self.node_mut(other) {
                        (entry.cost, entry.tested, entry.parent) = (bound, false, node);
                    }
                    self.push(problem, other);
                }
            }
            if cell == problem.start.cell {
                let mut found = self.found;
                self.try_straight(problem, START, node, &mut found, &mut Blocked::new());
                self.try_join(problem, START, node, &mut found);
                self.found = found;
            }
        }
    }

    /// The best of the settled neighbours of `node` as its next node, with the true cost.
    ///
    /// First over the straight ways, which cost a swept test each, then over the ways through a cell, which cost
    /// dozens:
    /// few of those are still below what the first found.
    fn best_parent<W: Workspace, const CELLS: usize>(
        &self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
        node: u16,
    ) -> (f32, u16) {
        let mut best = (f32::INFINITY, NONE);
        let mut blocked = Blocked::new();
        self.for_each_settled(problem, node, |candidate| {
            self.try_straight(problem, node, candidate, &mut best, &mut blocked);
        });
        self.for_each_settled(problem, node, |candidate| self.try_join(problem, node, candidate, &mut best));
        best
    }

    /// Calls `consider` with each settled neighbour of `node`.
    fn for_each_settled<W: Workspace, const CELLS: usize>(
        &self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
        node: u16,
        mut consider: impl FnMut(u16),
    ) {
        // The one that offered the lowest bound first: it is the likeliest, and a low cost spares the swept tests.
        consider(self.node(node).parent);
        for cell in problem.cells(node).into_iter().filter(|&cell| cell != NONE) {
            if cell == problem.goal.cell {
                consider(GOAL);
            }
            for other in problem.ends_of(cell) {
                if other != node && self.node(other).position == SETTLED {
                    consider(other);
                }
            }
        }
    }

    /// Takes the way from `node` straight to the next node of `candidate`, a settled node of one of its cells, if that
    /// is better and clear.
    fn try_straight<W: Workspace, const CELLS: usize>(
        &self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
        node: u16,
        candidate: u16,
        best: &mut (f32, u16),
        blocked: &mut Blocked,
    ) {
        let grandparent = self.parent(candidate);
        let straight = self.cost(grandparent) + distance(problem, grandparent, node);
        if straight >= best.0 || blocked.contains(&grandparent) {
            return;
        }
        if problem.clearance.is_clear(problem.spot(node), problem.spot(grandparent)) {
            *best = (straight, grandparent);
        } else {
            // Neighbours mostly share their next node. Beyond the room of the list it is tested again.
            let _ = blocked.push(grandparent);
        }
    }

    /// Takes the way from `node` to `candidate` through their cell, if that is better.
    fn try_join<W: Workspace, const CELLS: usize>(
        &self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
        node: u16,
        candidate: u16,
        best: &mut (f32, u16),
    ) {
        if self.cost(candidate) + distance(problem, candidate, node) >= best.0 {
            return;
        }
        let cost = self.cost(candidate) + length(&problem.join(node, candidate, Effort::COARSE));
        if cost < best.0 {
            *best = (cost, candidate);
        }
    }

    /// The next node of a node; the goal's is itself.
    fn parent(&self, node: u16) -> u16 {
        if node == GOAL { GOAL } else { self.node(node).parent }
    }

    fn cost(&self, node: u16) -> f32 {
        if node == GOAL { 0.0 } else { self.node(node).cost }
    }

    fn node(&self, node: u16) -> Node {
        self.nodes.get(usize::from(node / 2)).map_or(NEW, |pair| pair[usize::from(node % 2)])
    }

    fn node_mut(&mut self, node: u16) -> Option<&mut Node> {
        self.nodes.get_mut(usize::from(node / 2)).map(|pair| &mut pair[usize::from(node % 2)])
    }

    /// Lower bound of the rest of the way, from a node to the start.
    fn heuristic<W: Workspace, const CELLS: usize>(
        &self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
        node: u16,
    ) -> f32 {
        distance(problem, node, START)
    }

    fn queue_at(&self, position: usize) -> u16 {
        self.queue.get(position / 2).map_or(NONE, |pair| pair[position % 2])
    }

    /// Writes a node into a place of the queue.
    fn place(&mut self, position: usize, node: u16) {
        if let Some(pair) = self.queue.get_mut(position / 2) {
            pair[position % 2] = node;
        }
        let position = u16::try_from(position).unwrap_or(UNSEEN);
        if let Some(entry) = self.node_mut(node) {
            entry.position = position;
        }
    }

    /// Order of the queue; ties go to the lower node number, so that a plan does not depend on history.
    fn before<W: Workspace, const CELLS: usize>(
        &self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
        a: u16,
        b: u16,
    ) -> bool {
        let a_key = self.node(a).cost + self.heuristic(problem, a);
        let b_key = self.node(b).cost + self.heuristic(problem, b);
        a_key < b_key || (a_key <= b_key && a < b)
    }

    /// Puts a node into the queue, or moves it up after its cost fell.
    fn push<W: Workspace, const CELLS: usize>(
        &mut self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
        node: u16,
    ) {
        let mut position = match self.node(node).position {
            UNSEEN | SETTLED => {
                self.queued += 1;
                self.queued - 1
            }
            position => usize::from(position),
        };
        while position > 0 {
            let above = (position - 1) / 2;
            let other = self.queue_at(above);
            if !self.before(problem, node, other) {
                break;
            }
            self.place(position, other);
            position = above;
        }
        self.place(position, node);
    }

    /// Takes the first node out of the queue.
    fn pop<W: Workspace, const CELLS: usize>(
        &mut self,
        problem: &Problem<'_, W, CELLS, PASSAGES>,
    ) -> Option<u16> {
        self.queued = self.queued.checked_sub(1)?;
        let first = self.queue_at(0);
        let last = self.queue_at(self.queued);
        let mut position = 0;
        loop {
            let mut below = 2 * position + 1;
            if below >= self.queued {
                break;
            }
            if below + 1 < self.queued && self.before(problem, self.queue_at(below + 1), self.queue_at(below))
            {
                below += 1;
            }
            let other = self.queue_at(below);
            if !self.before(problem, other, last) {
                break;
            }
            self.place(position, other);
            position = below;
        }
        self.place(position, last);
        if let Some(entry) = self.node_mut(first) {
            entry.position = UNSEEN;
        }
        Some(first)
    }
}

/// Straight distance between two nodes.
fn distance<W: Workspace, const CELLS: usize, const PASSAGES: usize>(
    problem: &Problem<'_, W, CELLS, PASSAGES>,
    a: u16,
    b: u16,
) -> f32 {
    problem.spot(a).distance_to(problem.spot(b))
}
