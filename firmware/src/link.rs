//! Between the tasks and the protocol: what comes in, what goes out, and how a session reaches the controller.

use controller_core::safety::StopCause;
use firmware::board::{Real, pac::Interrupt};
use firmware::controller::{Fast, Slow};
use firmware::drivers::{motors, stack};
use firmware::emulator::Output;
use firmware::slot::Filler;
use firmware::watch::Watch;
use heapless::spsc::Producer;
use protocol::codec::{DecodeError, from_bytes};
use protocol::endpoint::Access;
use protocol::frame::{self, Decoder, Frame, RawFrame};
use protocol::message::{FaultReport, FromBoard, FromHost, Health, Outputs};
use rtic::Mutex;

/// Room for any report: outputs are the longest, of which two ticks and a digest have up to ten bytes each.
const REPORT_BYTES: usize = 80;

/// How a session reaches the controller: by RTIC's locks.
pub struct Locked<F, S, W, D> {
    pub fast: F,
    pub slow: S,
    pub watch: W,
    pub decoder: D,
}

impl<F, S, W, D> Access<Real> for Locked<F, S, W, D>
where
    F: Mutex<T = &'static mut Fast>,
    S: Mutex<T = &'static mut Slow>,
    W: Mutex<T = Watch>,
    D: Mutex<T = &'static mut Decoder<FromHost>>,
{
    fn fast<R>(&mut self, f: impl FnOnce(&mut Fast) -> R) -> R {
        self.fast.lock(|fast| f(fast))
    }

    fn slow<R>(&mut self, f: impl FnOnce(&mut Slow) -> R) -> R {
        self.slow.lock(|slow| f(slow))
    }

    fn both<R>(&mut self, f: impl FnOnce(&mut Fast, &mut Slow) -> R) -> R {
        let fast = &mut self.fast;
        self.slow.lock(|slow| fast.lock(|fast| f(fast, slow)))
    }

    fn health(&mut self) -> Health {
        let frames = self.decoder.lock(|decoder| decoder.counts());
        Health {
            tick: self.fast.lock(|fast| fast.tick),
            frames_good: frames.good,
            frames_bad: frames.bad,
            stack_bytes_max: Some(stack::bytes_max()),
            ..self.watch.lock(|watch| watch.health())
        }
    }
}

/// Takes a frame from the decoder. Readings and emergency stops act at once; `true` if there is a request to serve.
///
/// # Errors
/// Where the frame has no valid message.
#[inline(never)]
pub fn deliver(
    raw: RawFrame<'_, FromHost>,
    fast: &mut impl Mutex<T = &'static mut Fast>,
    watch: &mut impl Mutex<T = Watch>,
    request: &mut impl Mutex<T = Filler<Frame<FromHost>>>,
) -> Result<bool, DecodeError> {
    let message = from_bytes::<FromHost>(raw.body)?;
    let is_real_time = watch.lock(|watch| watch.is_real_time);
    fast.lock(|fast| {
        fast.heard = fast.tick;
        match &message {
            FromHost::EStop => {
                fast.reflex.gate.emergency_stop();
                motors::stop();
            }
            FromHost::Sense(readings) if is_real_time => fast.sense(readings),
            _ => {}
        }
    });
    if matches!(message, FromHost::Sense(_)) {
        return Ok(false);
    }
    let is_taken = request.lock(|request| request.put(Frame { sequence: raw.sequence, message }));
    if !is_taken {
        watch.lock(|watch| watch.requests_dropped = watch.requests_dropped.saturating_add(1));
    }
    Ok(is_taken)
}

/// What the host is told unasked.
#[derive(Default)]
pub struct Reports {
    pub outputs: Option<Outputs>,
    pub fault: Option<FaultReport>,
    stopped: Option<StopCause>,
}

impl Reports {
    /// The outputs of a tick; a report that has not been sent yet is replaced, but for what happens only once.
    pub fn put(&mut self, outputs: &Outputs) {
        if outputs.stopped != self.stopped {
            self.stopped = outputs.stopped;
            self.fault = outputs.stopped.map(|cause| FaultReport {
                tick: outputs.tick,
                cause,
                // These two end only when the host acts.
                latched: matches!(cause, StopCause::EmergencyStop | StopCause::NotArmed),
            });
        }
        let unsent = self.outputs.and_then(|outputs| outputs.reached);
        self.outputs = Some(Outputs { reached: outputs.reached.or(unsent), ..*outputs });
    }
}

/// The way to the USART.
pub struct Line {
    ring: Producer<'static, u8>,
    /// A reply is under way in parts: nothing may come between.
    is_taken: bool,
}

impl Line {
    /// With a ring that the USART's task empties.
    pub fn new(ring: Producer<'static, u8>) -> Self {
        Self { ring, is_taken: false }
    }

    /// Sends a message unasked if there is room for all of it at once.
    pub fn try_send(&mut self, message: &FromBoard) {
        let mut buffer = [0; REPORT_BYTES];
        let Ok(bytes) = frame::encode(0, message, &mut buffer) else { return };
        if self.is_taken || self.ring.capacity() - self.ring.len() < bytes.len() {
            return;
        }
        for &byte in bytes {
            let _ = self.ring.enqueue(byte);
        }
    }
}

/// Where replies go.
pub enum Sink {
    /// Byte by byte to the USART.
    Usart,
    /// In one piece to the host's FIFO.
    Fifo(Output),
}

impl Sink {
    /// Sends a frame; waits for room, so it belongs into a task that keeps nobody waiting.
    pub fn send(&mut self, line: &mut impl Mutex<T = Line>, bytes: &[u8]) {
        match self {
            Self::Fifo(output) => output.write(bytes),
            Self::Usart => {
                line.lock(|line| line.is_taken = true);
                for &byte in bytes {
                    while line.lock(|line| line.ring.enqueue(byte)).is_err() {
                        rtic::pend(Interrupt::USART1);
                    }
                }
                line.lock(|line| line.is_taken = false);
                rtic::pend(Interrupt::USART1);
            }
        }
    }
}
