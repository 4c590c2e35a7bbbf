//! The stub itself: bytes and the time in, bytes out.

use core::time::Duration;

use controller_core::config::ConfigError;
use controller_core::scalar::Fixed;
use protocol::endpoint::{Identity, LocalBoard};
use protocol::frame::{Decoder, FRAME_BYTES_MAX, Frame, encode};
use protocol::message::{Board, FromBoard, FromHost, Outputs, ScalarKind, TimeBase};

use crate::faults::{Direction, Line, LinkFaults};

/// The tick of real time.
const TICK: Duration = Duration::from_millis(1);

/// A board this far behind its time has stood still (nobody served it): it goes on from now instead of catching up.
const STOOD_STILL: Duration = Duration::from_millis(100);

/// Which board to be.
#[derive(Clone, Debug, PartialEq)]
pub struct StubOptions {
    /// What it calls itself.
    pub board: Board,
    /// What its controller computes with.
    pub scalar: ScalarKind,
    /// Number of its first start; a reset adds one.
    pub epoch: u32,
    /// What is wrong with the link.
    pub faults: LinkFaults,
}

impl Default for StubOptions {
    fn default() -> Self {
        Self { board: Board::Stub, scalar: ScalarKind::F32, epoch: 1, faults: LinkFaults::default() }
    }
}

/// The core in either arithmetic.
#[derive(Debug)]
enum Core {
    F32(Box<LocalBoard<f32>>),
    Fixed(Box<LocalBoard<Fixed>>),
}

impl Core {
    fn start(options: &StubOptions, epoch: u32) -> Result<Self, ConfigError> {
        let identity =
            Identity { board: options.board, build_id: concat!("hil_stub ", env!("CARGO_PKG_VERSION")) };
        Ok(match options.scalar {
            ScalarKind::F32 => Self::F32(Box::new(LocalBoard::new(identity, epoch)?)),
            ScalarKind::Fixed => Self::Fixed(Box::new(LocalBoard::new(identity, epoch)?)),
        })
    }

    fn announce(&mut self) -> &[u8] {
        match self {
            Self::F32(board) => board.announce(),
            Self::Fixed(board) => board.announce(),
        }
    }

    fn serve(&mut self, frame: &Frame<FromHost>) -> &[u8] {
        match self {
            Self::F32(board) => board.serve(frame),
            Self::Fixed(board) => board.serve(frame),
        }
    }

    fn count_bad_frame(&mut self) {
        match self {
            Self::F32(board) => board.count_bad_frame(),
            Self::Fixed(board) => board.count_bad_frame(),
        }
    }

    fn time_base(&self) -> TimeBase {
        match self {
            Self::F32(board) => board.time_base(),
            Self::Fixed(board) => board.time_base(),
        }
    }

    fn tick(&mut self) -> Option<Outputs> {
        match self {
            Self::F32(board) => board.tick(),
            Self::Fixed(board) => board.tick(),
        }
    }
}

/// A board on the host. Times are counted from any moment that stays the same.
///
/// ```
/// use hil_stub::board::{Stub, StubOptions};
/// use protocol::frame::{FRAME_BYTES_MAX, encode};
/// use protocol::message::FromHost;
///
/// let mut stub = Stub::new(StubOptions::default()).unwrap();
/// let mut buffer = [0; FRAME_BYTES_MAX];
/// let stop = encode(1, &FromHost::EStop, &mut buffer).unwrap();
/// stub.receive(stop, core::time::Duration::ZERO);
/// assert_eq!(stub.output().last(), Some(&0)); // the frame that says it is done
/// ```
#[derive(Debug)]
pub struct Stub {
    options: StubOptions,
    core: Core,
    epoch: u32,
    decoder: Decoder<FromHost>,
    to_board: Line,
    to_host: Line,
    /// Whole frames received since the first start.
    frames: u64,
    /// When the next tick of real time is due.
    next_tick: Option<Duration>,
    output: Vec<u8>,
}

impl Stub {
    /// A board that has been started and not yet said anything.
    ///
    /// # Errors
    /// If the scalar cannot hold the default configuration, which both can.
    pub fn new(options: StubOptions) -> Result<Self, ConfigError> {
        Ok(Self {
            core: Core::start(&options, options.epoch)?,
            epoch: options.epoch,
            decoder: Decoder::new(),
            to_board: Line::new(&options.faults, Direction::ToBoard),
            to_host: Line::new(&options.faults, Direction::ToHost),
            frames: 0,
            next_tick: None,
            // Some frames of either size: never to grow in an ordinary run.
            output: Vec::with_capacity(8 * FRAME_BYTES_MAX),
            options,
        })
    }

    /// Says what board this is, as one does that has been started.
    pub fn announce(&mut self, now: Duration) {
        let Self { core, to_host, output, .. } = self;
        to_host.pass(core.announce(), now, |bytes| output.extend_from_slice(bytes));
    }

    /// Takes what the host sent.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        if self.options.faults.spares_frames() {
            self.take(bytes, now);
            return;
        }
        let mut arrived = Vec::new();
        self.to_board.pass(bytes, now, |bytes| arrived.extend_from_slice(bytes));
        self.take(&arrived, now);
    }

    /// Lets the time go on: bytes that were late arrive, and in real time the ticks that are due are computed.
    pub fn advance(&mut self, now: Duration) {
        while let Some(frame) = self.to_board.arrived(now) {
            self.take(&frame, now);
        }
        if self.core.time_base() == TimeBase::RealTime {
            self.tick(now);
        } else {
            self.next_tick = None;
        }
        while let Some(frame) = self.to_host.arrived(now) {
            self.output.extend_from_slice(&frame);
        }
    }

    /// When [`Stub::advance`] has something to do, if nothing is received before.
    #[must_use]
    pub fn next_event(&self) -> Option<Duration> {
        let events = [self.to_board.next_arrival(), self.to_host.next_arrival(), self.next_tick];
        events.into_iter().flatten().min()
    }

    /// What the host is to be sent.
    #[must_use]
    pub fn output(&self) -> &[u8] {
        &self.output
    }

    /// The output's first bytes have been sent.
    pub fn sent(&mut self, bytes: usize) {
        self.output.drain(..bytes.min(self.output.len()));
    }

    /// Another host listens now: what was on its way to the last one is gone. The board keeps its state.
    pub fn replug(&mut self) {
        self.to_board.clear();
        self.to_host.clear();
        self.output.clear();
        self.decoder = Decoder::new();
    }

    /// The number of the present start.
    #[must_use]
    pub fn epoch(&self) -> u32 {
        self.epoch
    }

    /// Bytes that have arrived at the board.
    fn take(&mut self, bytes: &[u8], now: Duration) {
        for &byte in bytes {
            match self.decoder.push(byte) {
                None => {}
                Some(Ok(frame)) => {
                    self.frames += 1;
                    if self.options.faults.reset_after == Some(self.frames) {
                        // The frame and all behind it find nobody.
                        self.reset(now);
                        return;
                    }
                    let Self { core, to_host, output, .. } = self;
                    to_host.pass(core.serve(&frame), now, |bytes| output.extend_from_slice(bytes));
                }
                Some(Err(_)) => self.core.count_bad_frame(),
            }
        }
        if self.core.time_base() == TimeBase::RealTime {
            self.next_tick.get_or_insert(now + TICK);
        }
    }

    fn reset(&mut self, now: Duration) {
        self.epoch = self.epoch.wrapping_add(1);
        // What could be started before can be started again.
        if let Ok(core) = Core::start(&self.options, self.epoch) {
            self.core = core;
        }
        self.replug();
        self.next_tick = None;
        self.announce(now);
    }

    fn tick(&mut self, now: Duration) {
        let mut due = self.next_tick.unwrap_or(now + TICK);
        if due + STOOD_STILL < now {
            due = now;
        }
        while due <= now {
            due += TICK;
            let Some(outputs) = self.core.tick() else { break };
            let mut buffer = [0; FRAME_BYTES_MAX];
            if let Ok(frame) = encode(0, &FromBoard::Outputs(outputs), &mut buffer) {
                let output = &mut self.output;
                self.to_host.pass(frame, now, |bytes| output.extend_from_slice(bytes));
            }
        }
        self.next_tick = Some(due);
    }
}
