//! What a bad line does: frames are lost, bits flip, bytes come late.
//!
//! Each direction is a [`Line`] with a random stream of its own. Every frame takes the same number of draws whatever
//! becomes of it, so that more loss does not shift what is corrupted. A line never reorders: bytes that come late delay
//! all behind them, as on a wire.

use core::ops::RangeInclusive;
use core::time::Duration;
use std::collections::VecDeque;

use protocol::frame::DELIMITER;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Longest run of bytes without a delimiter that is held back to be one frame; more is passed on as it comes.
const HELD_BYTES_MAX: usize = 1024;

/// What is wrong with a link and with the board behind it; by default nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkFaults {
    /// Seed of all that is drawn.
    pub seed: u64,
    /// Share of the frames that are lost, in either direction, 0 to 1.
    pub loss: f64,
    /// Share of the frames in which one bit flips, in either direction, 0 to 1.
    pub corruption: f64,
    /// How late a frame comes, in milliseconds, uniformly drawn.
    pub delay_ms: RangeInclusive<u32>,
    /// The board is reset, once, when it has received so many whole frames; it loses all it knew.
    pub reset_after: Option<u64>,
}

impl Default for LinkFaults {
    fn default() -> Self {
        Self { seed: 1, loss: 0.0, corruption: 0.0, delay_ms: 0..=0, reset_after: None }
    }
}

impl LinkFaults {
    /// Whether bytes pass as they are.
    #[must_use]
    pub fn spares_frames(&self) -> bool {
        self.loss <= 0.0 && self.corruption <= 0.0 && *self.delay_ms.end() == 0
    }
}

/// The two directions; the numbers are part of every run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Host to board.
    ToBoard,
    /// Board to host.
    ToHost,
}

/// One direction of a link.
#[derive(Clone, Debug)]
pub struct Line {
    faults: LinkFaults,
    spares_frames: bool,
    random: Pcg64Mcg,
    /// A frame that has not come to its end yet.
    held: Vec<u8>,
    /// Frames on the way, in their order, and when each arrives.
    late: VecDeque<(Duration, Vec<u8>)>,
}

impl Line {
    /// An empty line.
    #[must_use]
    pub fn new(faults: &LinkFaults, direction: Direction) -> Self {
        let stream = match direction {
            Direction::ToBoard => 0x9E37_79B9_7F4A_7C15,
            Direction::ToHost => 0xD1B5_4A32_D192_ED03,
        };
        Self {
            faults: faults.clone(),
            spares_frames: faults.spares_frames(),
            random: Pcg64Mcg::seed_from_u64(faults.seed ^ stream),
            held: Vec::new(),
            late: VecDeque::new(),
        }
    }

    /// Takes bytes at time `now` and hands on those that arrive at once.
    pub fn pass(&mut self, bytes: &[u8], now: Duration, mut deliver: impl FnMut(&[u8])) {
        if self.spares_frames {
            deliver(bytes);
            return;
        }
        for &byte in bytes {
            self.held.push(byte);
            if byte != DELIMITER && self.held.len() < HELD_BYTES_MAX {
                continue;
            }
            let mut frame = core::mem::take(&mut self.held);
            let Some(delay) = self.afflict(&mut frame) else { continue };
            let arrival = self.late.back().map_or(now + delay, |(last, _)| (now + delay).max(*last));
            if arrival <= now {
                deliver(&frame);
            } else {
                self.late.push_back((arrival, frame));
            }
        }
    }

    /// The next frame on the way, if it has arrived at time `now`.
    pub fn arrived(&mut self, now: Duration) -> Option<Vec<u8>> {
        let (arrival, _) = self.late.front()?;
        if *arrival <= now { self.late.pop_front().map(|(_, frame)| frame) } else { None }
    }

    /// When the next frame on the way arrives.
    #[must_use]
    pub fn next_arrival(&self) -> Option<Duration> {
        self.late.front().map(|(arrival, _)| *arrival)
    }

    /// Forgets what is on the way.
    pub fn clear(&mut self) {
        self.held.clear();
        self.late.clear();
    }

    /// What becomes of a frame: `None` if it is lost, else how late it is.
    fn afflict(&mut self, frame: &mut [u8]) -> Option<Duration> {
        let is_lost = self.unit() < self.faults.loss;
        let is_corrupted = self.unit() < self.faults.corruption;
        let bit = self.below(frame.len() * 8);
        let (from, to) = (*self.faults.delay_ms.start(), *self.faults.delay_ms.end());
        let share = self.unit();
        if is_corrupted && let Some(byte) = frame.get_mut(bit / 8) {
            *byte ^= 1 << (bit % 8);
        }
        let from = Duration::from_millis(u64::from(from));
        let spread = Duration::from_millis(u64::from(to)).saturating_sub(from);
        (!is_lost).then(|| from + spread.mul_f64(share))
    }

    /// Uniform in 0 to 1, without 1.
    fn unit(&mut self) -> f64 {
        f64::from(self.random.next_u32()) / 4_294_967_296.0
    }

    /// Uniform below `count`; 0 if that is 0. Frames are short, so the division favours nothing by more than 2⁻²⁰.
    fn below(&mut self, count: usize) -> usize {
        let drawn = usize::try_from(self.random.next_u32()).unwrap_or_default();
        drawn.checked_rem(count).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::{Direction, Line, LinkFaults};
    use core::time::Duration;

    const FRAME: [u8; 8] = [3, 17, 2, 9, 4, 8, 6, 0];

    /// What comes out of `count` frames sent at time 0, with the time of arrival in ms.
    fn sent(faults: &LinkFaults, count: usize) -> Vec<(u128, Vec<u8>)> {
        let mut line = Line::new(faults, Direction::ToBoard);
        let mut out = Vec::new();
        for _ in 0..count {
            line.pass(&FRAME, Duration::ZERO, |bytes| out.push((0, bytes.to_vec())));
        }
        while let Some(arrival) = line.next_arrival() {
            let frame = line.arrived(arrival).unwrap();
            out.push((arrival.as_millis(), frame));
        }
        out
    }

    #[test]
    fn a_good_line_changes_nothing() {
        let out = sent(&LinkFaults::default(), 3);
        assert_eq!(out, vec![(0, FRAME.to_vec()); 3]);
    }

    #[test]
    fn shares_are_kept_and_repeat() {
        let faults = LinkFaults { loss: 0.1, corruption: 0.2, ..LinkFaults::default() };
        let out = sent(&faults, 10_000);
        assert!((8_800..9_200).contains(&out.len()), "{} of 10,000 arrive", out.len());
        let damaged = out.iter().filter(|(_, frame)| *frame != FRAME).count();
        assert!((1_600..2_000).contains(&damaged), "{damaged} are damaged");
        assert_eq!(out, sent(&faults, 10_000));
        assert_ne!(out, sent(&LinkFaults { seed: 2, ..faults }, 10_000));
    }

    #[test]
    fn a_damaged_frame_differs_in_one_bit() {
        let faults = LinkFaults { corruption: 1.0, ..LinkFaults::default() };
        for (_, frame) in sent(&faults, 100) {
            let flipped: u32 = frame.iter().zip(FRAME).map(|(a, b)| (a ^ b).count_ones()).sum();
            assert_eq!(flipped, 1, "{frame:?}");
        }
    }

    #[test]
    fn late_frames_keep_their_order() {
        let faults = LinkFaults { delay_ms: 5..=20, ..LinkFaults::default() };
        let arrivals: Vec<u128> = sent(&faults, 50).into_iter().map(|(at, _)| at).collect();
        assert!(arrivals.is_sorted() && arrivals.iter().all(|at| (5..=20).contains(at)), "{arrivals:?}");
        let mut line = Line::new(&faults, Direction::ToHost);
        line.pass(&FRAME, Duration::ZERO, |_| panic!("5 ms early"));
        assert_eq!(line.arrived(Duration::from_millis(4)), None);
        line.clear();
        assert_eq!(line.arrived(Duration::from_secs(9)), None);
    }
}
