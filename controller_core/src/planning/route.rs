//! From a way through the passages to checkpoints: pull it taut, round its corners, move it to the middle of doors.

use super::clearance::{Clearance, Spot};
use super::workspace::Workspace;

/// A gap up to this many disc diameters wide is a doorway, and gets a checkpoint in its middle.
///
/// Chosen because the Khepera sees 0.175 m beyond its body: in a gap of three diameters both jambs are in view, and
/// both push. In wider ones the middle is worth nothing to the robot, and costs way.
const DOORWAY_DIAMETERS: f32 = 3.0;

/// The checkpoints in doorways may make the way longer by this factor, together.
///
/// Chosen to leave half of the 10 % that a plan may be longer than the best.
const DOORWAY_DETOUR: f32 = 1.05;

/// A corner is cut into two when that saves this share of the whole way; less is not worth a checkpoint.
const CORNER_SAVING: f32 = 0.005;

/// Or this share of the two joins that meet there: where a long way bends at each step, as in a maze, no single corner
/// is much of the whole.
const SHARP_SAVING: f32 = 0.02;

/// Places where the width of the way is taken, in radii of the disc: the middle of a doorway is as exact as this.
const SAMPLING: f32 = 0.25;
/// But at least so far apart, in quarter-cells: also the thinnest wall, one cell, has two in its doorway.
const SAMPLING_LEAST: f32 = 2.0;

/// Corners cut at most per plan and pass, so that the time is bounded whatever the map.
const CORNER_PASSES: usize = 3;

/// A checkpoint in the making.
#[derive(Clone, Copy, Debug)]
struct Bend {
    spot: Spot,
    /// In the middle of a doorway: not to be dropped or moved.
    door: bool,
    /// Cannot be moved while its neighbours stay where they are.
    tight: bool,
    /// Known not to be needless while its neighbours stay where they are.
    needed: bool,
}

impl Bend {
    fn at(spot: Spot) -> Self {
        Self { spot, door: false, tight: false, needed: false }
    }
}

/// No room for another checkpoint.
#[derive(Debug)]
pub(super) struct Full;

/// A doorway on the way: the bend after it, its middle, and how it is joined to the doorway before once that is known.
#[derive(Clone, Copy)]
struct Door {
    before: usize,
    middle: Spot,
    join: Option<Join>,
}

/// How the middle of a doorway, or the goal, is joined to that of the doorway before, or to the start.
#[derive(Clone, Copy)]
enum Join {
    Straight,
    /// Over these bends of the way without doorways, both included.
    Over(usize, usize),
}

impl Join {
    /// Bends that it takes, the end included.
    fn size(self) -> usize {
        match self {
            Self::Straight => 1,
            Self::Over(first, last) => last - first + 2,
        }
    }
}

/// Which bend below `until` is the last in sight of a place, from which one door after the other is tried.
#[derive(Clone, Copy, Default)]
struct Sight {
    until: usize,
    seen: Option<usize>,
}

/// The way from the start (left out) to the goal, as bends joined by straight clear segments.
pub(super) struct Route<'a, W, const N: usize> {
    clearance: &'a Clearance<'a, W>,
    start: Spot,
    bends: heapless::Vec<Bend, N>,
    /// The end of the way so far, not yet known to be a bend.
    pending: Option<Spot>,
}

impl<'a, W: Workspace, const N: usize> Route<'a, W, N> {
    pub fn new(clearance: &'a Clearance<'a, W>, start: Spot) -> Self {
        Self { clearance, start, bends: heapless::Vec::new(), pending: None }
    }

    /// Goes on to `spot`, straight from the last one; keeps only the bends that cannot be skipped.
    pub fn extend(&mut self, spot: Spot) -> Result<(), Full> {
        if let Some(pending) = self.pending
            && !self.clearance.is_clear(self.before(self.bends.len()), spot)
        {
            self.bends.push(Bend::at(pending)).map_err(|_| Full)?;
        }
        self.pending = Some(spot);
        Ok(())
    }

    /// Ends the way at the last spot, and makes it short and fit to drive.
    pub fn finish(mut self) -> Result<heapless::Vec<Spot, N>, Full> {
        if let Some(goal) = self.pending.take() {
            self.bends.push(Bend::at(goal)).map_err(|_| Full)?;
        }
        self.drop_needless();
        for _ in 0..CORNER_PASSES {
            self.tighten();
            self.drop_needless();
            self.cut_corners();
        }
        self.tighten();
        self.drop_needless();
        self.pass_doors_in_the_middle();
        Ok(self.bends.iter().map(|bend| bend.spot).collect())
    }

    /// The spot before bend `index`.
    fn before(&self, index: usize) -> Spot {
        index.checked_sub(1).and_then(|i| self.bends.get(i)).map_or(self.start, |bend| bend.spot)
    }

    /// The spot of bend `index`; of the last one beyond the end.
    fn spot(&self, index: usize) -> Spot {
        self.bends.get(index).or(self.bends.last()).map_or(self.start, |bend| bend.spot)
    }

    fn length(&self) -> f32 {
        (0..self.bends.len()).map(|i| self.before(i).distance_to(self.spot(i))).sum()
    }

    /// Drops bends whose neighbours see each other, doors excepted.
    fn drop_needless(&mut self) {
        let mut kept = 0;
        let mut has_dropped = false;
        for index in 0..self.bends.len() {
            let Some(bend) = self.bends.get(index).copied() else { break };
            let is_last = index + 1 == self.bends.len();
            let stays = is_last || bend.door || bend.needed && !has_dropped;
            has_dropped = !stays && self.clearance.is_clear(self.before(kept), self.spot(index + 1));
            if has_dropped {
                self.loosen(kept.saturating_sub(1));
                self.loosen(index + 1);
                continue;
            }
            if let Some(place) = self.bends.get_mut(kept) {
                *place = bend;
            }
            kept += 1;
        }
        self.bends.truncate(kept);
    }

    /// A neighbour of that bend has moved.
    fn loosen(&mut self, index: usize) {
        if let Some(bend) = self.bends.get_mut(index) {
            bend.tight = false;
        }
    }

    /// Moves each bend towards the line between its neighbours, as far as the way stays clear.
    fn tighten(&mut self) {
        for _ in 0..4 {
            for index in 0..self.bends.len().saturating_sub(1) {
                let (a, b, c) = (self.before(index), self.spot(index), self.spot(index + 1));
                if self.bends.get(index).is_some_and(|bend| bend.tight) {
                    continue;
                }
                let spot = self.clearance.tightened(a, b, c);
                let tight = spot == b;
                if let Some(bend) = self.bends.get_mut(index) {
                    (bend.spot, bend.tight) = (spot, tight);
                }
                if !tight {
                    self.loosen(index.saturating_sub(1));
                    self.loosen(index + 1);
                }
            }
        }
    }

    /// Cuts the corners that are worth another checkpoint, where there is room for one.
    fn cut_corners(&mut self) {
        let worth = CORNER_SAVING * self.length();
        let mut bends: heapless::Vec<Bend, N> = heapless::Vec::new();
        let mut room = N - self.bends.len();
        let mut a = self.start;
        let mut has_moved = false;
        for index in 0..self.bends.len() {
            let Some(mut bend) = self.bends.get(index).copied() else { break };
            bend.tight &= !has_moved;
            has_moved = false;
            let (b, c) = (bend.spot, self.spot(index + 1));
            let mut best = (worth.min(SHARP_SAVING * (a.distance_to(b) + b.distance_to(c))), None);
            if room > 0 && index + 1 < self.bends.len() {
                for share in [0.75, 0.5, 0.25, 0.125] {
                    let (first, second) = (b.towards(a, share), b.towards(c, share));
                    let saving = first.distance_to(b) + b.distance_to(second) - first.distance_to(second);
                    if saving > best.0 && self.clearance.is_clear(first, second) {
                        best = (saving, Some((first, second)));
                    }
                }
            }
            if let (_, Some((first, second))) = best {
                if let Some(before) = bends.last_mut() {
                    before.tight = false;
                }
                // There is room for both: `room` tells.
                let _ = bends.push(Bend::at(first));
                bend = Bend::at(second);
                room -= 1;
                has_moved = true;
            }
            a = bend.spot;
            let _ = bends.push(bend);
        }
        self.bends = bends;
    }

    /// Puts a checkpoint into the middle of each doorway on the way, as far as that costs little.
    ///
    /// All doors together, since one may be in straight reach only from the middle of the next; a door that cannot
    /// be joined, or the dearest when the way gets too long, is left out and the rest tried again.
    fn pass_doors_in_the_middle(&mut self) {
        let budget = DOORWAY_DETOUR * self.length();
        let mut doors = self.doors();
        if !doors.is_empty() {
            self.note_needed();
        }
        let mut last = None;
        while self.join_doors(&mut doors, &mut last) {
            let bends = self.through(&doors, last);
            let old = core::mem::replace(&mut self.bends, bends);
            self.drop_needless();
            if self.length() <= budget {
                return;
            }
            let dearest = self.dearest_door();
            self.bends = old;
            take_out(&mut doors, dearest, &mut last);
        }
    }

    /// Notes which bends have neighbours that do not see each other.
    fn note_needed(&mut self) {
        for index in 1..self.bends.len().saturating_sub(1) {
            let needed = !self.clearance.is_clear(self.spot(index - 1), self.spot(index + 1));
            if let Some(bend) = self.bends.get_mut(index) {
                bend.needed = needed;
            }
        }
    }

    /// Finds how each of these doors is joined to the one before, and the goal to the last, as far as that is not
    /// known. Doors that cannot be joined or have no room are taken out; `false` when none is left.
    fn join_doors(&self, doors: &mut heapless::Vec<Door, N>, last: &mut Option<Join>) -> bool {
        let goal = self.bends.len().saturating_sub(1);
        let mut index = 0;
        // Of the doors up to `index`, their bends.
        let mut size = 0;
        let mut sight = Sight::default();
        while !doors.is_empty() && index <= doors.len() {
            let before = index.checked_sub(1).and_then(|before| doors.get(before));
            let (from, first) = before.map_or((self.start, 0), |door| (door.middle, door.before));
            let door = doors.get_mut(index);
            let (to, end) = door.as_ref().map_or((self.spot(goal), goal), |door| (door.middle, door.before));
            let join = door.map_or(&mut *last, |door| &mut door.join);
            if join.is_none() {
                *join = self.join(from, to, first..end, &mut sight);
            }
            match *join {
                Some(join) if size + join.size() <= N => {
                    size += join.size();
                    index += 1;
                    sight = Sight::default();
                }
                _ => {
                    if index == doors.len() {
                        // The goal is not in reach of the last door.
                        index -= 1;
                        size -= doors.last().and_then(|door| door.join).map_or(0, |join| join.size());
                        sight = Sight::default();
                    }
                    take_out(doors, index, last);
                }
            }
        }
        !doors.is_empty()
    }

    /// How one place is joined to another over bends that are between them; `None` where it cannot be.
    fn join(
        &self,
        from: Spot,
        to: Spot,
        between: core::ops::Range<usize>,
        sight: &mut Sight,
    ) -> Option<Join> {
        if self.clearance.is_clear(from, to) {
            return Some(Join::Straight);
        }
        // As few of the old bends as it takes to see the first and be seen from the last.
        let new = between.start.max(sight.until)..between.end;
        let seen = new.rev().find(|&i| self.clearance.is_clear(from, self.spot(i))).or(sight.seen);
        *sight = Sight { until: between.end, seen };
        let end = (seen?..between.end).find(|&i| self.clearance.is_clear(self.spot(i), to))?;
        Some(Join::Over(seen?, end))
    }

    /// The way through all of these doors, each joined to the one before as told, and the goal likewise. There is room.
    fn through(&self, doors: &[Door], last: Option<Join>) -> heapless::Vec<Bend, N> {
        let mut bends = heapless::Vec::new();
        let goal = Bend::at(self.spot(self.bends.len()));
        let middles = doors.iter().map(|door| (door.join, Bend { door: true, ..Bend::at(door.middle) }));
        for (join, to) in middles.chain([(last, goal)]) {
            if let Some(Join::Over(seen, end)) = join {
                for (index, bend) in self.bends.iter().enumerate().take(end + 1).skip(seen) {
                    let needed = bend.needed && seen < index && index < end;
                    let _ = bends.push(Bend { needed, ..Bend::at(bend.spot) });
                }
            }
            let _ = bends.push(to);
        }
        bends
    }

    /// Which of the doors on the way makes it longest, counted from the start.
    fn dearest_door(&self) -> usize {
        let mut dearest = (0, 0.0);
        let doors = (0..self.bends.len()).filter(|&i| self.bends.get(i).is_some_and(|bend| bend.door));
        for (number, i) in doors.enumerate() {
            let (a, b, c) = (self.before(i), self.spot(i), self.spot(i + 1));
            let detour = a.distance_to(b) + b.distance_to(c) - a.distance_to(c);
            if detour > dearest.1 {
                dearest = (number, detour);
            }
        }
        dearest.0
    }

    /// The doorways on the way, in order.
    fn doors(&self) -> heapless::Vec<Door, N> {
        let mut doors = heapless::Vec::new();
        let reach = self.clearance.reach;
        let mut found: Option<Narrow> = None;
        for index in 0..self.bends.len() {
            let (a, b) = (self.before(index), self.spot(index));
            let length = a.distance_to(b);
            let mut at = 0.0;
            while at < length {
                let spot = a.towards(b, at / length);
                at += (SAMPLING * reach).max(SAMPLING_LEAST);
                let gap = self.gap(spot);
                match (&mut found, gap) {
                    (Some(narrow), Some((width, _))) => narrow.go_on(index, spot, width),
                    (None, Some((width, _))) => found = Some(Narrow::new(index, spot, width)),
                    // Two doorways closer than a disc diameter are one.
                    (Some(narrow), None) if narrow.last.distance_to(spot) > 2.0 * reach => {
                        self.close(&mut doors, found.take());
                    }
                    (_, None) => {}
                }
            }
        }
        self.close(&mut doors, found);
        doors
    }

    /// Finds the middle of a doorway and adds it, unless the start or the goal is in it.
    fn close(&self, doors: &mut heapless::Vec<Door, N>, found: Option<Narrow>) {
        let Some(narrow) = found else { return };
        let mut middle = narrow.narrowest.0.towards(narrow.narrowest.1, 0.5);
        // From a point in the gap to its middle; each step halves what the direction was off.
        for _ in 0..4 {
            if let Some((_, centre)) = self.gap(middle) {
                middle = centre;
            }
        }
        let near = 2.0 * self.clearance.reach;
        let goal = self.spot(self.bends.len());
        if middle.distance_to(self.start) > near && middle.distance_to(goal) > near {
            // More doors than checkpoints: the later ones go without.
            let _ = doors.push(Door { before: narrow.before, middle, join: None });
        }
    }

    /// Width and middle of the gap that a spot is in; `None` when it is wider than a doorway.
    fn gap(&self, spot: Spot) -> Option<(f32, Spot)> {
        let widest = DOORWAY_DIAMETERS * 2.0 * self.clearance.reach;
        let one = self.clearance.nearest_wall(spot, widest, None)?;
        let away = Spot { x: spot.x - one.x, y: spot.y - one.y };
        let other = self.clearance.nearest_wall(spot, widest, Some(away))?;
        let width = one.distance_to(other);
        (width <= widest).then(|| (width, one.towards(other, 0.5)))
    }
}

/// Takes a door out, so that what comes after it is to be joined anew: the next door, or the goal, whose join is
/// `last`.
fn take_out<const N: usize>(doors: &mut heapless::Vec<Door, N>, index: usize, last: &mut Option<Join>) {
    if index < doors.len() {
        doors.remove(index);
    }
    *doors.get_mut(index).map_or(last, |door| &mut door.join) = None;
}

/// A narrow stretch of the way.
struct Narrow {
    /// The bend after its narrowest part.
    before: usize,
    width: f32,
    /// First and last sample of the narrowest part.
    narrowest: (Spot, Spot),
    /// Last sample.
    last: Spot,
}

impl Narrow {
    fn new(before: usize, spot: Spot, width: f32) -> Self {
        Self { before, width, narrowest: (spot, spot), last: spot }
    }

    fn go_on(&mut self, before: usize, spot: Spot, width: f32) {
        self.last = spot;
        if width < self.width - 0.5 {
            (self.before, self.width, self.narrowest) = (before, width, (spot, spot));
        } else if width < self.width + 0.5 {
            self.narrowest.1 = spot;
        }
    }
}
