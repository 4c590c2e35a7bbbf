//! The shortest way through the passages: A* over bends and passages, from the goal back to the start.
//!
//! A shortest path bends only at corners, which are the *bends* of the decomposition's entries. The way from one bend
//! to another is not looked for in the cell alone: as in Theta* (Nash, Daniel, Koenig, Felner, AAAI 2007) a bend may
//! be joined straight to the bend *before* its neighbour, and as in Lazy Theta* (Nash, Koenig, Tovey, AAAI 2010) the
//! swept test is made only for what is taken from the queue.
//!
//! Bends alone would not do: where a long passage is crossed in its middle, all of its bends may be far off the
//! shortest way, and nothing beyond would be found before some longer way is. So each wide passage has a second node,
//! *through* it: there the way does not bend, it crosses on the line from the bend before to the start. As in Polyanya
//! (Cui, Harabor, Grastien, IJCAI 2017) its priority is the length by that crossing, and a node that is beyond is
//! joined to the bend before, never to the crossing.
//!
//! Where neither is in straight reach, two bends of a cell are priced by the way along its core, which needs no test.
//!
//! The straight distance says little of the rest of a crooked way, so that nearly all of a maze would be searched. A
//! search that has become long without an end in sight is begun anew after a *survey*: how far each cell is by its
//! passages, from bend to bend (Dijkstra). It costs a fifth of such a search and leaves little of it but the way.
//!
//! It runs from the goal to the start, so that the way can be read off in driving order.

use super::cell_decomposition::{Decomposition, Passage};
use super::clearance::{Clearance, HALVINGS, Spot};
use super::index::{Index, number, place};
use super::workspace::Workspace;

/// By how much more the rest of the way counts for each node that has been settled, up to [`HASTE_MAX`].
///
/// Chosen because it leaves maps of few corners what they are, the shortest way; and where thousands of nodes are
/// shorter than the way, it is because the way is so crooked that the straight rest says little, and a search that
/// trusts it more loses little: at most 4 % on maps of 512 x 512 cells of which 10 to 40 % were blocked, for a third
/// of the time, with up to 1.15; with up to 1.3 another 0.4 % on average and 2.4 % at most where 30 % were blocked, for
/// half of the time of the slowest searches. More than that saves little.
const HASTE_STEP: f32 = 0.15 / 4000.0;
const HASTE_MAX: f32 = 1.3;

/// A search that has settled more nodes than this,
const FEW: usize = 2000;
/// and whose way would be longer than straight by this factor, is begun anew after a survey. Open worlds, where the
/// straight rest is a good guide, stay below it, also with 30 % of the cells blocked.
const CROOKED: f32 = 1.5;

/// What the rest of the way counts as the survey tells it.
///
/// From bend to bend it is mostly too short, by up to a tenth, since cells are not convex. With 1.05, searches on two
/// maps with 40 % of 512 x 512 cells blocked settle up to 8,000 nodes, with the straight rest up to 35,000; with 1
/// 19,000; with 1.1 the ways are no better.
const SURVEYED: f32 = 1.05;
/// How much further than the goal the survey goes.
const BEYOND: f32 = 1.1;

/// Start or goal, and how it is tied to the lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Terminal {
    pub spot: Spot,
    /// A clear lattice point in straight reach.
    pub anchor: Spot,
    /// The cell of the anchor.
    pub cell: u32,
}

/// What is known of a bend or of the way through a passage.
#[derive(Clone, Copy)]
struct Node<I> {
    /// Length of the way to the goal; a lower bound while not tested.
    cost: f32,
    /// The next node on the way to the goal, always a bend; while not tested, the node that offered the cost.
    parent: I,
    /// Where in the queue, or [`Numbers::UNSEEN`]; with [`Numbers::TESTED`].
    state: I,
}

/// The numbers with a meaning of their own. Nodes are `2 · entry` for a bend, one more for the way through.
struct Numbers<I>(core::marker::PhantomData<I>);

impl<I: Index> Numbers<I> {
    const GOAL: u32 = I::NONE - 1;
    const START: u32 = I::NONE - 2;
    /// The bit of a state that tells that the cost is true.
    const TESTED: u32 = I::NONE / 2 + 1;
    /// [`Index::UNSEEN`].
    const UNSEEN: u32 = Self::TESTED - 1;
}

impl<I: Index> Node<I> {
    const NEW: Self = Self { cost: f32::INFINITY, parent: I::LAST, state: I::UNSEEN };

    fn is_tested(&self) -> bool {
        self.state.get() & Numbers::<I>::TESTED != 0
    }

    /// Place in the queue, or the number of no place.
    fn position(&self) -> u32 {
        self.state.get() & !Numbers::<I>::TESTED
    }

    fn set(&mut self, position: u32, tested: bool) {
        self.state = I::of(position | if tested { Numbers::<I>::TESTED } else { 0 });
    }
}

/// Scratch of the search.
pub(super) struct Search<I, const PASSAGES: usize> {
    nodes: [[Node<I>; 2]; PASSAGES],
    /// Which of both nodes of an entry are settled, as bits: asked so often that it should be close together.
    settled: [u8; PASSAGES],
    /// Binary heap of nodes, least key first,
    queue: [[I; 2]; PASSAGES],
    /// and their keys: cost and straight distance to the start.
    keys: [[f32; 2]; PASSAGES],
    queued: usize,
    /// Cost and parent of the start.
    found: (f32, u32),
    /// How many nodes are settled.
    pub settled_count: usize,
    /// What the straight rest of the way counts in the keys of the queue.
    haste: f32,
    /// Whether it is the surveyed rest that counts.
    is_surveyed: bool,
}

/// The bends of a way within one cell, ends included.
pub(super) type Bends = heapless::Vec<Spot, 6>;

/// What the search looks at.
pub(super) struct Problem<'a, W, I, const CELLS: usize, const PASSAGES: usize> {
    pub clearance: &'a Clearance<'a, W>,
    pub map: &'a Decomposition<I, CELLS, PASSAGES>,
    pub start: Terminal,
    pub goal: Terminal,
}

impl<W: Workspace, I: Index, const CELLS: usize, const PASSAGES: usize> Problem<'_, W, I, CELLS, PASSAGES> {
    const START: u32 = Numbers::<I>::START;

    /// Where a bend is.
    fn spot(&self, bend: u32) -> Spot {
        if bend == Self::START {
            return self.start.spot;
        }
        // The goal has no entry either.
        self.map.passage(bend / 2).map_or(self.goal.spot, Passage::bend)
    }

    /// The lattice point of `cell` that a bend is tied to.
    fn entry(&self, bend: u32, cell: u32) -> Spot {
        if bend == Self::START {
            return self.start.anchor;
        }
        self.map.passage(bend / 2).map_or(self.goal.anchor, |passage| passage.bend_in(cell))
    }

    /// The one or two cells that a node belongs to.
    fn cells(&self, node: u32) -> [u32; 2] {
        if node == Self::START {
            return [self.start.cell, I::NONE];
        }
        self.map.passage(node / 2).map_or([self.goal.cell, I::NONE], Passage::cells)
    }

    /// The way between two bends of one cell: straight, or along the cell's core.
    fn join_in(&self, cell: u32, from: u32, to: u32) -> Bends {
        let mut bends = Bends::new();
        let (a, b) = (self.spot(from), self.spot(to));
        let (a_entry, b_entry) = (self.entry(from, cell), self.entry(to, cell));
        let Some(cell) = self.map.cells.get(place(cell)) else { return bends };
        let (mut a_core, mut b_core) = (cell.core(a_entry), cell.core(b_entry));
        // Along the core no further than needed: leave it, and reach it, where the straight line is clear.
        let a_far = self.furthest(a, a_core, b_core);
        a_core = a_far.unwrap_or(a_core);
        let b_far = self.furthest(b, b_core, a_core);
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
        self.clearance.tighten(&mut bends);
        bends
    }

    /// Length of the way between two bends of one cell along its core, which is clear whatever the cell.
    fn core_length(&self, cell: u32, a: u32, b: u32) -> f32 {
        let Some(core) = self.map.cells.get(place(cell)) else { return f32::INFINITY };
        let (a_entry, b_entry) = (self.entry(a, cell), self.entry(b, cell));
        let (a_core, b_core) = (core.core(a_entry), core.core(b_entry));
        let ends = self.spot(a).distance_to(a_entry) + self.spot(b).distance_to(b_entry);
        ends + a_entry.distance_to(a_core) + a_core.distance_to(b_core) + b_core.distance_to(b_entry)
    }

    /// The furthest point on the way from `near` to `far` that is found to be in straight reach of `eye`.
    fn furthest(&self, eye: Spot, near: Spot, far: Spot) -> Option<Spot> {
        if self.clearance.is_clear(eye, far) {
            return Some(far);
        }
        if !self.clearance.is_clear(eye, near) {
            return None;
        }
        let (mut clear, mut blocked) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (clear + blocked);
            if self.clearance.is_clear(eye, near.towards(far, middle)) {
                clear = middle;
            } else {
                blocked = middle;
            }
        }
        Some(near.towards(far, clear))
    }

    /// The way between two bends: straight where clear, else through a cell they share. Empty when they share none.
    fn join(&self, from: u32, to: u32) -> Bends {
        let (a, b) = (self.spot(from), self.spot(to));
        if self.clearance.is_clear(a, b) {
            return Bends::from_iter([a, b]);
        }
        let mut best = Bends::new();
        let theirs = self.cells(to);
        for cell in self.cells(from) {
            if cell != I::NONE && theirs.contains(&cell) {
                let bends = self.join_in(cell, from, to);
                if best.is_empty() || length(&bends) < length(&best) {
                    best = bends;
                }
            }
        }
        best
    }
}

/// Ways that a node may be joined by straight.
type Straights = heapless::Vec<Best, 32>;

/// Length of a way; infinite when there is none.
fn length(bends: &Bends) -> f32 {
    if bends.is_empty() {
        return f32::INFINITY;
    }
    bends.iter().zip(bends.iter().skip(1)).map(|(a, b)| a.distance_to(*b)).sum()
}

/// What a node can be reached by: key, cost and parent.
#[derive(Clone, Copy)]
struct Best {
    key: f32,
    cost: f32,
    parent: u32,
    /// Of equal keys the first counts.
    order: u32,
}

impl Best {
    const NONE: Self = Self { key: f32::INFINITY, cost: f32::INFINITY, parent: u32::MAX, order: u32::MAX };

    fn is_before(&self, other: &Self) -> bool {
        self.key < other.key || self.key <= other.key && self.order < other.order
    }
}

impl<I: Index, const PASSAGES: usize> Search<I, PASSAGES> {
    const GOAL: u32 = Numbers::<I>::GOAL;
    const START: u32 = Numbers::<I>::START;

    pub const fn new() -> Self {
        Self {
            nodes: [[Node::NEW; 2]; PASSAGES],
            settled: [0; PASSAGES],
            queue: [[I::LAST; 2]; PASSAGES],
            keys: [[f32::INFINITY; 2]; PASSAGES],
            queued: 0,
            found: (f32::INFINITY, 0),
            settled_count: 0,
            haste: 1.0,
            is_surveyed: false,
        }
    }

    /// Begins a search.
    pub fn begin<W: Workspace, const CELLS: usize>(&mut self, problem: &Problem<'_, W, I, CELLS, PASSAGES>) {
        self.clear(problem.map.passages.len());
        self.is_surveyed = false;
        self.expand(problem, Self::GOAL);
    }

    /// Begins a search anew after a [`Search::survey`] of the same problem.
    pub fn begin_surveyed<W: Workspace, const CELLS: usize>(
        &mut self,
        problem: &Problem<'_, W, I, CELLS, PASSAGES>,
    ) {
        self.clear(problem.map.passages.len());
        self.is_surveyed = true;
        self.expand(problem, Self::GOAL);
    }

    /// Forgets the last search or survey, of a map with so many entries.
    fn clear(&mut self, entries: usize) {
        self.nodes.iter_mut().take(entries).for_each(|pair| *pair = [Node::NEW; 2]);
        self.settled.iter_mut().take(entries).for_each(|settled| *settled = 0);
        self.haste = 1.0;
        self.queued = 0;
        self.settled_count = 0;
        self.found = (f32::INFINITY, I::NONE);
    }

    /// Surveys how far from the start the cells are, up to some way beyond the goal's: the way from bend to bend of
    /// passages up to the first passage into the cell.
    pub fn survey<const CELLS: usize>(
        &mut self,
        map: &mut Decomposition<I, CELLS, PASSAGES>,
        start: &Terminal,
        goal: &Terminal,
    ) {
        self.clear(map.passages.len());
        map.forget_distances();
        map.note_distance(start.cell, I::NONE, 0.0);
        self.survey_from(map, start.cell, start.spot, 0.0);
        let mut most = f32::INFINITY;
        while let Some((node, cost)) = self.pop().filter(|next| next.1 <= most) {
            let Some(passage) = map.passage(node / 2).copied() else { break };
            for cell in passage.cells() {
                if map.note_distance(cell, node / 2, cost) {
                    if cell == goal.cell {
                        most = BEYOND * cost;
                    }
                    self.survey_from(map, cell, passage.bend(), cost);
                }
            }
        }
    }

    /// Offers all passages of a cell the way from one of them.
    fn survey_from<const CELLS: usize>(
        &mut self,
        map: &Decomposition<I, CELLS, PASSAGES>,
        cell: u32,
        from: Spot,
        cost: f32,
    ) {
        for entry in map.entries_of(cell) {
            let Some(passage) = map.passage(entry).filter(|passage| passage.is_passage()) else { continue };
            let cost = cost + from.distance_to(passage.bend());
            if let Some(node) = self.node_mut(2 * entry).filter(|node| cost < node.cost) {
                node.cost = cost;
                self.push(2 * entry, cost);
            }
        }
    }

    /// What the rest of the way to the start counts from a place of an entry.
    fn rest<W: Workspace, const CELLS: usize>(
        &self,
        problem: &Problem<'_, W, I, CELLS, PASSAGES>,
        passage: &Passage<I>,
        spot: Spot,
    ) -> f32 {
        if !self.is_surveyed {
            return self.haste * spot.distance_to(problem.start.spot);
        }
        let by = |cell| {
            let (by, distance) = problem.map.distance(cell)?;
            let next = problem.map.passage(by).map_or(problem.start.spot, Passage::bend);
            Some(distance + spot.distance_to(next))
        };
        let [left, right] = passage.cells().map(|cell| by(cell).unwrap_or(f32::INFINITY));
        SURVEYED * left.min(right)
    }

    /// Whether the goal can be reached from the start; then [`Search::walk`] says how. `None` when it takes so long
    /// that a survey is worth its time.
    pub fn run<W: Workspace, const CELLS: usize>(
        &mut self,
        problem: &Problem<'_, W, I, CELLS, PASSAGES>,
    ) -> Option<bool> {
        let crooked = CROOKED * problem.start.spot.distance_to(problem.goal.spot);
        // Each round settles a node or tests one; a node is tested again only when a settled one offered better.
        loop {
            let next = self.pop().filter(|next| next.1 < self.found.0);
            let Some((node, key)) = next else { return Some(self.found.0 < f32::INFINITY) };
            if !self.is_surveyed && self.settled_count > FEW && key > crooked {
                return None;
            }
            let entry = self.node(node);
            if entry.is_tested() {
                self.expand(problem, node);
                continue;
            }
            let best = self.best_parent(problem, node);
            if let Some(entry) = self.node_mut(node) {
                (entry.cost, entry.parent) = (best.cost, I::of(best.parent));
                entry.set(Numbers::<I>::UNSEEN, true);
            }
            // What no bend reaches straight may be offered again. What is as good as was thought is still the first,
            // and so is what is better than all that is in the queue.
            if best.cost <= entry.cost || best.key < self.found.0 && self.is_first(node, best.key) {
                self.expand(problem, node);
            } else if best.key < f32::INFINITY {
                self.push(node, best.key);
            }
        }
    }

    /// Calls `visit` with each bend from start to goal, the start left out.
    pub fn walk<W: Workspace, const CELLS: usize, E>(
        &self,
        problem: &Problem<'_, W, I, CELLS, PASSAGES>,
        mut visit: impl FnMut(Spot) -> Result<(), E>,
    ) -> Result<(), E> {
        let (mut from, mut to) = (Self::START, self.found.1);
        for _ in 0..2 * PASSAGES + 2 {
            for &spot in problem.join(from, to).iter().skip(1) {
                visit(spot)?;
            }
            if to == Self::GOAL {
                break;
            }
            (from, to) = (to, self.parent(to));
        }
        Ok(())
    }

    /// Settles a node and offers it to all nodes of its cells.
    fn expand<W: Workspace, const CELLS: usize>(
        &mut self,
        problem: &Problem<'_, W, I, CELLS, PASSAGES>,
        node: u32,
    ) {
        if let Some(settled) = self.settled.get_mut(place(node / 2)) {
            *settled |= 1 << (node % 2);
        }
        self.settled_count += 1;
        self.haste = (self.haste + HASTE_STEP).min(HASTE_MAX);
        let root = self.root(node);
        let (cost, from) = (self.cost(root), problem.spot(root));
        for cell in problem.cells(node).into_iter().filter(|&cell| cell != I::NONE) {
            for entry in problem.map.entries_of(cell) {
                let settled = self.settled_of(entry);
                let Some(passage) = problem.map.passage(entry).filter(|_| settled != 3) else { continue };
                let (bend, reach) = (passage.bend(), problem.clearance.reach);
                // One jump, since each by itself would mostly be mispredicted.
                let is_taut = passage.can_be_taut(from.x - bend.x, from.y - bend.y, reach);
                let is_shorter = cost + from.distance_to(bend) < self.node(2 * entry).cost;
                if (settled & 1 == 0) & is_taut & is_shorter {
                    self.offer(problem, passage, (root, 2 * entry), cost, (from, bend));
                }
                if settled & 2 == 0 && passage.is_wide() {
                    let crossing = passage.crossing(bend.x, from, problem.start.spot);
                    self.offer(problem, passage, (root, 2 * entry + 1), cost, (from, crossing));
                }
            }
            if cell == problem.start.cell {
                self.try_start(problem, cell, node);
            }
        }
    }

    /// Offers a node `to` of an entry that is not settled the way over a settled bend `root`, whose cost is given, with
    /// the ends of the straight piece. A bend must not be known to have a shorter one.
    fn offer<W: Workspace, const CELLS: usize>(
        &mut self,
        problem: &Problem<'_, W, I, CELLS, PASSAGES>,
        passage: &Passage<I>,
        (root, to): (u32, u32),
        cost: f32,
        (from, spot): (Spot, Spot),
    ) {
        let entry = self.node(to);
        let cost = cost + from.distance_to(spot);
        let key = cost + self.rest(problem, passage, spot);
        if key < self.key_at(entry.position()) {
            if let Some(entry) = self.node_mut(to) {
                (entry.cost, entry.parent) = (cost, I::of(root));
                entry.set(entry.position(), false);
            }
            self.push(to, key);
        }
    }

    /// Takes the way from the start over a settled node of its cell if that is better: straight to it or, through a
    /// passage, to the bend before; or along the core.
    fn try_start<W: Workspace, const CELLS: usize>(
        &mut self,
        problem: &Problem<'_, W, I, CELLS, PASSAGES>,
        cell: u32,
        node: u32,
    ) {
        let (start, root) = (problem.start.spot, self.root(node));
        let to = problem.spot(root);
        let cost = self.cost(root) + to.distance_to(start);
        if cost < self.found.0 && problem.clearance.is_clear(start, to) {
            self.found = (cost, root);
        }
        if is_bend::<I>(node) {
            let cost = self.cost(node) + problem.core_length(cell, Self::START, node);
            if cost < self.found.0 {
                self.found = (cost, node);
            }
        }
    }

    /// The best bend to go on to from `node`, with the true cost.
    fn best_parent<W: Workspace, const CELLS: usize>(
        &self,
        problem: &Problem<'_, W, I, CELLS, PASSAGES>,
        node: u32,
    ) -> Best {
        let Some(passage) = problem.map.passage(node / 2) else { return Best::NONE };
        let (start, bend) = (problem.start.spot, passage.bend());
        let is_bend = is_bend::<I>(node);
        // Where the way over a bend leaves from.
        let leaving = |to| if is_bend { bend } else { passage.crossing(bend.x, to, start) };
        let rest = self.rest(problem, passage, bend);
        let straight = |root: u32, order: u32| {
            let to = problem.spot(root);
            let spot = leaving(to);
            let length = to.distance_to(spot);
            let cost = self.cost(root) + length;
            let rest = if is_bend { rest } else { self.rest(problem, passage, spot) };
            (Best { key: cost + rest, cost, parent: root, order }, length)
        };
        let is_clear = |root: u32| {
            let to = problem.spot(root);
            problem.clearance.is_clear(leaving(to), to)
        };
        // Nothing settled offered less: if that is clear, it is the best.
        let first = self.node(node).parent.get();
        if is_clear(first) {
            return straight(first, 0).0;
        }
        let mut best = Best::NONE;
        let mut straights = Straights::new();
        let mut order = 0;
        let mut consider = |cell: u32, candidate: u32| {
            let root = self.root(candidate);
            let (way, length) = straight(root, order);
            if root != first && way.is_before(&best) && straights.iter().all(|other| other.parent != root) {
                if straights.is_full() {
                    best = best_of(best, &mut straights, is_clear);
                }
                let _ = straights.push(way);
            }
            // Along the core it is no shorter than straight, but for rounding.
            if is_bend && root == candidate && self.cost(root) + 0.999 * length + rest <= best.key {
                let cost = self.cost(root) + problem.core_length(cell, node, root);
                let core = Best { key: cost + rest, cost, parent: root, order: order + 1 };
                if core.is_before(&best) {
                    best = core;
                }
            }
            order += 2;
        };
        for cell in passage.cells().into_iter().filter(|&cell| cell != I::NONE) {
            if cell == problem.goal.cell {
                consider(cell, Self::GOAL);
            }
            for entry in problem.map.entries_of(cell) {
                let settled = self.settled_of(entry);
                for other in [2 * entry, 2 * entry + 1] {
                    if settled >> (other % 2) & 1 != 0 && other != node {
                        consider(cell, other);
                    }
                }
            }
        }
        best_of(best, &mut straights, is_clear)
    }

    /// The bend that what is beyond a settled node can be joined to: itself or, through a passage, the one before.
    fn root(&self, node: u32) -> u32 {
        if is_bend::<I>(node) { node } else { self.node(node).parent.get() }
    }

    /// The next bend of a settled node; the goal's is itself.
    fn parent(&self, node: u32) -> u32 {
        if node == Self::GOAL { node } else { self.node(node).parent.get() }
    }

    fn cost(&self, node: u32) -> f32 {
        if node == Self::GOAL { 0.0 } else { self.node(node).cost }
    }

    fn node(&self, node: u32) -> Node<I> {
        self.nodes.get(place(node / 2)).map_or(Node::NEW, |pair| pair[place(node % 2)])
    }

    fn node_mut(&mut self, node: u32) -> Option<&mut Node<I>> {
        self.nodes.get_mut(place(node / 2)).map(|pair| &mut pair[place(node % 2)])
    }

    /// Which of the two nodes of an entry are settled, as bits.
    fn settled_of(&self, entry: u32) -> u8 {
        self.settled.get(place(entry)).copied().unwrap_or(0)
    }

    /// Node and key at a place in the queue.
    fn queue_at(&self, position: usize) -> (u32, f32) {
        let node = self.queue.as_flattened().get(position).map_or(I::NONE, |node| node.get());
        (node, self.keys.as_flattened().get(position).copied().unwrap_or(f32::INFINITY))
    }

    /// The key at a node's place in the queue; infinite where it is in none.
    fn key_at(&self, position: u32) -> f32 {
        if position == Numbers::<I>::UNSEEN { f32::INFINITY } else { self.queue_at(place(position)).1 }
    }

    /// Writes a node with its key into a place of the queue.
    fn place(&mut self, position: usize, (node, key): (u32, f32)) {
        if let Some(entry) = self.queue.as_flattened_mut().get_mut(position) {
            *entry = I::of(node);
        }
        if let Some(entry) = self.keys.as_flattened_mut().get_mut(position) {
            *entry = key;
        }
        let position = number(position);
        if let Some(entry) = self.node_mut(node) {
            entry.set(position, entry.is_tested());
        }
    }

    /// Whether a node that is not in the queue would be its first.
    fn is_first(&self, node: u32, key: f32) -> bool {
        self.queued == 0 || before((node, key), self.queue_at(0))
    }

    /// Puts a node into the queue, or moves it up after its key fell.
    fn push(&mut self, node: u32, key: f32) {
        let position = self.node(node).position();
        let mut position = if position == Numbers::<I>::UNSEEN {
            self.queued += 1;
            self.queued - 1
        } else {
            place(position)
        };
        while position > 0 {
            let above = (position - 1) / 2;
            let other = self.queue_at(above);
            if !before((node, key), other) {
                break;
            }
            self.place(position, other);
            position = above;
        }
        self.place(position, (node, key));
    }

    /// Takes the first node out of the queue, with its key.
    fn pop(&mut self) -> Option<(u32, f32)> {
        self.queued = self.queued.checked_sub(1)?;
        let first = self.queue_at(0);
        let last = self.queue_at(self.queued);
        let mut position = 0;
        loop {
            let below = 2 * position + 1;
            if below >= self.queued {
                break;
            }
            let (left, right) = (self.queue_at(below), self.queue_at(below + 1));
            // What is behind the queue's end does not count. Chosen without a jump, which would mostly be mispredicted.
            let is_right = (below + 1 < self.queued) & before(right, left);
            let other = if is_right { right } else { left };
            if !before(other, last) {
                break;
            }
            self.place(position, other);
            position = below + usize::from(is_right);
        }
        self.place(position, last);
        if let Some(entry) = self.node_mut(first.0) {
            entry.set(Numbers::<I>::UNSEEN, entry.is_tested());
        }
        Some(first)
    }
}

/// Order of the queue; ties go to the lower node number, so that a plan does not depend on history.
fn before((a, a_key): (u32, f32), (b, b_key): (u32, f32)) -> bool {
    (a_key < b_key) | ((a_key <= b_key) & (a < b))
}

/// The best of what is known and those of the straight ways that are clear; none is left. Tested from the best on, so
/// that few are.
fn best_of(known: Best, straights: &mut Straights, is_clear: impl Fn(u32) -> bool) -> Best {
    loop {
        let mut best = (known, None);
        for (index, way) in straights.iter().enumerate() {
            if way.is_before(&best.0) {
                best = (*way, Some(index));
            }
        }
        let (way, Some(index)) = best else { break };
        if is_clear(way.parent) {
            straights.clear();
            return way;
        }
        straights.swap_remove(index);
    }
    straights.clear();
    known
}

/// Whether a node is a bend: start, goal, or a corner.
fn is_bend<I: Index>(node: u32) -> bool {
    node.is_multiple_of(2) || node == Numbers::<I>::GOAL || node == Numbers::<I>::START
}
