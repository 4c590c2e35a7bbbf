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
}

impl Bend {
    fn at(spot: Spot) -> Self {
        Self { spot, door: false, tight: false }
    }
}

/// No room for another checkpoint.
#[derive(Debug)]
pub(super) struct Full;

/// A doorway on the way: the bend after it, and its middle.
#[derive(Clone, Copy)]
struct Door {
    before: usize,
    middle: Spot,
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
        for index in 0..self.bends.len() {
            let Some(bend) = self.bends.get(index).copied() else { break };
            let is_last = index + 1 == self.bends.len();
            if !is_last && !bend.door && self.clearance.is_clear(self.before(kept), self.spot(index + 1)) {
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
        let mut index = 0;
        while index + 1 < self.bends.len() && self.bends.len() < N {
            let (a, b, c) = (self.before(index), self.spot(index), self.spot(index + 1));
            let local = SHARP_SAVING * (a.distance_to(b) + b.distance_to(c));
            let mut best = (worth.min(local), None);
            for share in [0.75, 0.5, 0.25, 0.125] {
                let (first, second) = (b.towards(a, share), b.towards(c, share));
                let saving = first.distance_to(b) + b.distance_to(second) - first.distance_to(second);
                if saving > best.0 && self.clearance.is_clear(first, second) {
                    best = (saving, Some((first, second)));
                }
            }
            if let (_, Some((first, second))) = best {
                if let Some(bend) = self.bends.get_mut(index) {
                    *bend = Bend::at(first);
                }
                self.loosen(index.saturating_sub(1));
                self.loosen(index + 1);
                // There is room: the loop's condition.
                let _ = self.bends.insert(index + 1, Bend::at(second));
                index += 1;
            }
            index += 1;
        }
    }

    /// Puts a checkpoint into the middle of each doorway on the way, as far as that costs little.
    ///
    /// All doors together, since one may be in straight reach only from the middle of the next; a door that cannot
    /// be joined, or the dearest when the way gets too long, is left out and the rest tried again.
    fn pass_doors_in_the_middle(&mut self) {
        let budget = DOORWAY_DETOUR * self.length();
        let mut doors = self.doors();
        while !doors.is_empty() {
            let out = match self.through(&doors) {
                Ok(bends) => {
                    let old = core::mem::replace(&mut self.bends, bends);
                    self.drop_needless();
                    if self.length() <= budget {
                        return;
                    }
                    let dearest = self.dearest_door();
                    self.bends = old;
                    dearest
                }
                Err(index) => index,
            };
            doors.remove(out.min(doors.len() - 1));
        }
    }

    /// The way through all of these doors, or the number of one that cannot be joined (or has no room).
    fn through(&self, doors: &[Door]) -> Result<heapless::Vec<Bend, N>, usize> {
        let mut bends = heapless::Vec::new();
        let goal = self.bends.len().saturating_sub(1);
        let (mut from, mut first) = (self.start, 0);
        for index in 0..=doors.len() {
            let door = doors.get(index);
            let (to, last) = door.map_or((self.spot(goal), goal), |door| (door.middle, door.before));
            if !self.clearance.is_clear(from, to) {
                // As few of the old bends as it takes to see the first and be seen from the last.
                let seen = (first..last)
                    .rev()
                    .find(|&i| self.clearance.is_clear(from, self.spot(i)))
                    .ok_or(index)?;
                let end = (seen..last).find(|&i| self.clearance.is_clear(self.spot(i), to)).ok_or(index)?;
                for i in seen..=end {
                    bends.push(Bend::at(self.spot(i))).map_err(|_| index)?;
                }
            }
            bends.push(Bend { door: door.is_some(), ..Bend::at(to) }).map_err(|_| index)?;
            (from, first) = (to, last);
        }
        Ok(bends)
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
                at += (SAMPLING * reach).max(1.0);
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
            let _ = doors.push(Door { before: narrow.before, middle });
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
