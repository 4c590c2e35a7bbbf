//! Between the tasks and the protocol: what comes in, what goes out, and how a session reaches the controller.

use controller_core::safety::StopCause;
use firmware::board::{Real, pac::Interrupt};
use firmware::controller::{Fast, Slow};
use firmware::drivers::{motors, stack};
use firmware::emulator::Output;
use firmware::slot::Filler;
use firmware::watch::Watch;
use heapless::spsc::Producer;
use protocol::codec::{DecodeError, Message, from_bytes};
use protocol::endpoint::Access;
use protocol::frame::{self, Decoder, RawFrame};
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

/// A request as it came, to be read by who serves it: on the way there is no room for the largest message.
pub struct Request {
    /// Which it is.
    pub sequence: u8,
    length: usize,
    body: [u8; FromHost::MAX_BYTES],
}

impl Request {
    /// Of no meaning.
    pub const BLANK: Self = Self { sequence: 0, length: 0, body: [0; FromHost::MAX_BYTES] };

    fn set(&mut self, raw: &RawFrame<'_, FromHost>) {
        self.sequence = raw.sequence;
        self.length = raw.body.len();
        for (to, from) in self.body.iter_mut().zip(raw.body) {
            *to = *from;
        }
    }

    /// Reads it.
    ///
    /// # Errors
    /// Where it has no valid message.
    pub fn read(&self) -> Result<FromHost, DecodeError> {
        from_bytes(self.body.get(..self.length).unwrap_or_default())
    }
}

/// Takes a frame from the decoder. Readings and emergency stops act at once; `true` if there is a request to serve.
///
/// # Errors
/// Where readings cannot be read.
#[inline(never)]
pub fn deliver(
    raw: &RawFrame<'_, FromHost>,
    fast: &mut impl Mutex<T = &'static mut Fast>,
    watch: &mut impl Mutex<T = Watch>,
    request: &mut impl Mutex<T = Filler<Request>>,
) -> Result<bool, DecodeError> {
    fast.lock(|fast| {
        fast.heard = fast.tick;
        if raw.body == [FromHost::ESTOP] {
            fast.reflex.gate.emergency_stop();
            motors::stop();
        }
    });
    if raw.body.first() == Some(&FromHost::SENSE) {
        // In lockstep nobody waits for them, and below lies the stack of a whole tick.
        return if watch.lock(|watch| watch.is_real_time) {
            sense(raw.body, fast).map(|()| false)
        } else {
            Ok(false)
        };
    }
    let is_taken = request.lock(|request| request.fill(|request| request.set(raw)));
    if !is_taken {
        watch.lock(|watch| watch.requests_dropped = watch.requests_dropped.saturating_add(1));
    }
    Ok(is_taken)
}

/// Readings for the servo. Apart from [`deliver`], whose stack frame lies on those of all slower tasks.
#[inline(never)]
fn sense(body: &[u8], fast: &mut impl Mutex<T = &'static mut Fast>) -> Result<(), DecodeError> {
    match &FromHost::read_sense(body) {
        Some(Ok(readings)) => fast.lock(|fast| fast.sense(readings)),
        Some(Err(error)) => return Err(*error),
        None => {}
    }
    Ok(())
}

/// What the host is told unasked.
#[derive(Default)]
pub struct Reports {
    outputs: Option<Outputs>,
    fault: Option<FaultReport>,
    stopped: Option<StopCause>,
}

impl Reports {
    /// What is to be told next.
    pub fn next(&mut self) -> Option<FromBoard> {
        let fault = self.fault.take().map(FromBoard::Fault);
        fault.or_else(|| self.outputs.take().map(FromBoard::Outputs))
    }

    /// The motors have been stopped, and nobody has been told.
    pub fn has_fault(&self) -> bool {
        self.fault.is_some()
    }

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
