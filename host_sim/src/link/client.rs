//! One request, one answer.
//!
//! The client numbers its requests 1 to 255 and around, sends one, and waits for the answer with its number; if none
//! comes in good time it sends the same frame again, which a board answers without carrying it out twice. How long
//! "good time" is follows from what the answers took so far. After [`Transport::answer_max`] it gives up and says what
//! came instead. Lost and damaged frames therefore cost time and change nothing.

use core::time::Duration;
use std::collections::VecDeque;
use std::time::Instant;

use protocol::frame::{Counts, DELIMITER, Decoder, FRAME_BYTES_MAX, Frame, FrameError, encode};
use protocol::message::{FromBoard, FromHost, MapRequest, Parameters, Refusal};

use super::error::LinkError;
use super::transport::Transport;

/// Shortest wait before a request is sent again: below, a busy machine would be mistaken for a lost frame.
const REPEAT_MIN: Duration = Duration::from_millis(4);
/// Longest one.
const REPEAT_MAX: Duration = Duration::from_millis(256);

/// A probe not answered for so long is lost. In real time readings may be waiting for it, and the board may not wait as
/// long for them.
const PROBE_LOST: Duration = Duration::from_millis(50);

/// Messages that nobody asked for, kept until somebody does; of more, the oldest go.
const UNASKED_MAX: usize = 64;

/// How the link did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LinkCounts {
    /// Requests that were answered.
    pub answered: u64,
    /// Times that a request was sent again.
    pub repeated: u64,
    /// Frames from the board, whole and damaged.
    pub frames: Counts,
    /// Longest wait for an answer.
    pub answer_max: Duration,
}

/// The host's end of a session.
#[derive(Debug)]
pub struct Client<T> {
    transport: T,
    decoder: Decoder<FromBoard>,
    received: Received,
    sequence: u8,
    repeat_after: Duration,
    slowest: Duration,
    unasked: VecDeque<FromBoard>,
    counts: LinkCounts,
    last_error: Option<FrameError>,
    bytes: u64,
    /// Epoch of the board, once it has said hello in this session.
    epoch: Option<u32>,
    /// A probe under way: its number, and when it was sent.
    probe: Option<(u8, Instant)>,
}

/// Bytes that have come and have not been looked at.
#[derive(Debug)]
struct Received {
    buffer: [u8; 512],
    next: usize,
    end: usize,
}

impl<T: Transport> Client<T> {
    /// A client that has said nothing yet.
    pub fn new(transport: T) -> Self {
        Self {
            transport,
            decoder: Decoder::new(),
            received: Received { buffer: [0; 512], next: 0, end: 0 },
            sequence: 0,
            repeat_after: REPEAT_MAX / 2,
            slowest: Duration::ZERO,
            unasked: VecDeque::new(),
            counts: LinkCounts::default(),
            last_error: None,
            bytes: 0,
            epoch: None,
            probe: None,
        }
    }

    /// How the link did so far.
    pub fn counts(&self) -> LinkCounts {
        LinkCounts { frames: self.decoder.counts(), ..self.counts }
    }

    /// The way to the board.
    pub fn transport_mut(&mut self) -> &mut T {
        &mut self.transport
    }

    /// Says hello, and gives the board's.
    ///
    /// # Errors
    /// See [`LinkError`]; whether the two go together is for the caller to say.
    pub fn hello(&mut self, hello: protocol::message::Hello) -> Result<protocol::message::Hello, LinkError> {
        if self.epoch.is_none() {
            // Cuts off what noise has left in the board's decoder.
            self.send(&[DELIMITER])?;
        }
        match self.request(&FromHost::Hello(hello))? {
            FromBoard::Hello(hello) => {
                if let Some(before) = self.epoch
                    && before != hello.epoch
                {
                    return Err(LinkError::Restarted { before, after: hello.epoch });
                }
                self.epoch = Some(hello.epoch);
                Ok(hello)
            }
            other => Err(unexpected("hello", &other)),
        }
    }

    /// Asks, and waits for the answer, whatever it is.
    ///
    /// # Errors
    /// See [`LinkError`]; never later than [`Transport::answer_max`].
    pub fn request(&mut self, request: &FromHost) -> Result<FromBoard, LinkError> {
        self.sequence = self.sequence.checked_add(1).unwrap_or(1);
        let mut buffer = [0; FRAME_BYTES_MAX];
        let frame = encode(self.sequence, request, &mut buffer)?;
        let bytes_before = self.bytes;
        let (begin, answer_max) = (Instant::now(), self.transport.answer_max());
        let (mut sent, mut patience) = (begin, self.repeat_after);
        self.send(frame)?;
        loop {
            if let Some(answer) = self.frame(sent, patience)? {
                if answer.sequence == self.sequence && self.fits(request, &answer.message) {
                    self.note(begin.elapsed(), sent == begin);
                    return self.checked(request, answer.message);
                }
                if answer.sequence == 0 {
                    self.keep(answer.message)?;
                }
                // All else answers an earlier request a second time, or a probe.
                self.note_probe(answer.sequence);
                // A board that talks all the time must not keep the request from being sent again.
                if sent.elapsed() < patience {
                    continue;
                }
            }
            let waited = begin.elapsed();
            if waited >= answer_max {
                return Err(self.no_answer(name_of(request), waited, bytes_before));
            }
            self.counts.repeated += 1;
            patience = (2 * patience).min(REPEAT_MAX).min(answer_max.saturating_sub(waited)).max(REPEAT_MIN);
            sent = Instant::now();
            self.send(frame)?;
        }
    }

    /// Sends what is not answered: readings in real time.
    ///
    /// # Errors
    /// If the board has gone away.
    pub fn tell(&mut self, message: &FromHost) -> Result<(), LinkError> {
        // Readings are not answered, and must not use up the numbers by which requests are told apart.
        let sequence = if matches!(message, FromHost::Sense(_)) {
            0
        } else {
            self.sequence = self.sequence.checked_add(1).unwrap_or(1);
            self.sequence
        };
        let mut buffer = [0; FRAME_BYTES_MAX];
        let frame = encode(sequence, message, &mut buffer)?;
        self.send(frame)
    }

    /// Sends a small request whose answer is not waited for: when it comes, the board has taken all that was sent
    /// before. Nothing is sent while an earlier one is under way.
    ///
    /// # Errors
    /// If the board has gone away.
    pub fn probe(&mut self) -> Result<(), LinkError> {
        if !self.is_probing() {
            self.tell(&FromHost::Parameters(Parameters::Get { index: 0 }))?;
            self.probe = Some((self.sequence, Instant::now()));
        }
        Ok(())
    }

    /// Whether a probe is under way. One that is lost is given up.
    pub fn is_probing(&self) -> bool {
        self.probe.is_some_and(|(_, sent)| sent.elapsed() < PROBE_LOST)
    }

    fn note_probe(&mut self, sequence: u8) {
        if let Some((_, sent)) = self.probe.take_if(|(number, _)| *number == sequence) {
            self.counts.answered += 1;
            self.counts.answer_max = self.counts.answer_max.max(sent.elapsed());
        }
    }

    /// Forgets what the board has said unasked before it gave the last answer.
    pub fn forget_unasked(&mut self) {
        self.unasked.clear();
    }

    /// What the board says unasked; `None` if that is nothing for so long. Without patience only bytes that have been
    /// read already are looked at.
    ///
    /// # Errors
    /// If the board has gone away or was restarted.
    pub fn listen(&mut self, patience: Duration) -> Result<Option<FromBoard>, LinkError> {
        let begin = Instant::now();
        loop {
            if let Some(message) = self.unasked.pop_front() {
                return Ok(Some(message));
            }
            match self.frame(begin, patience)? {
                Some(frame) if frame.sequence == 0 => self.keep(frame.message)?,
                Some(frame) => self.note_probe(frame.sequence),
                None => return Ok(None),
            }
        }
    }

    /// Requests that are carried out and no more.
    ///
    /// # Errors
    /// See [`LinkError`].
    pub fn command(&mut self, request: &FromHost) -> Result<(), LinkError> {
        match self.request(request)? {
            FromBoard::Done => Ok(()),
            FromBoard::Refused(refusal) => Err(LinkError::Refused { request: name_of(request), refusal }),
            other => Err(unexpected(name_of(request), &other)),
        }
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.transport.send(bytes).map_err(|error| LinkError::gone(&error, self.transport.post_mortem()))
    }

    /// The next whole frame; `None` if there is none `patience` after `since`.
    fn frame(&mut self, since: Instant, patience: Duration) -> Result<Option<Frame<FromBoard>>, LinkError> {
        let mut left = patience;
        loop {
            while self.received.next < self.received.end {
                let byte = self.received.buffer[self.received.next];
                self.received.next += 1;
                match self.decoder.push(byte) {
                    None => {}
                    Some(Ok(frame)) => return Ok(Some(frame)),
                    Some(Err(error)) => self.last_error = Some(error),
                }
            }
            if patience.is_zero() {
                return Ok(None);
            }
            let received = self.transport.receive(&mut self.received.buffer, left);
            let count = received.map_err(|error| LinkError::gone(&error, self.transport.post_mortem()))?;
            self.bytes += u64::try_from(count).unwrap_or_default();
            (self.received.next, self.received.end) = (0, count);
            // Bytes of a whole frame, as nearly always, need not ask the clock.
            if count == 0 || self.received.buffer[count - 1] != DELIMITER {
                left = patience.saturating_sub(since.elapsed());
                if count == 0 && left.is_zero() {
                    return Ok(None);
                }
            }
        }
    }

    /// Whether this can be the answer. The number of a hello may be that of another session's request, whose answer
    /// was still on its way.
    fn fits(&self, request: &FromHost, answer: &FromBoard) -> bool {
        !matches!(request, FromHost::Hello(_))
            || self.epoch.is_some()
            || matches!(answer, FromBoard::Hello(_))
    }

    fn checked(&mut self, request: &FromHost, answer: FromBoard) -> Result<FromBoard, LinkError> {
        // A board that does not know this session any more has been restarted, and its announcement was lost.
        if answer == FromBoard::Refused(Refusal::Mismatch)
            && !matches!(request, FromHost::Hello(_))
            && let Some(before) = self.epoch
        {
            let after = self.announced_epoch().unwrap_or(before.wrapping_add(1));
            return Err(LinkError::Restarted { before, after });
        }
        Ok(answer)
    }

    /// The epoch that a board without a session says it has.
    fn announced_epoch(&mut self) -> Option<u32> {
        let before = self.epoch.take();
        let hello = self.hello(super::session::greeting(None, None, protocol::message::TimeBase::Lockstep));
        self.epoch = before;
        hello.ok().map(|hello| hello.epoch)
    }

    fn keep(&mut self, message: FromBoard) -> Result<(), LinkError> {
        if let FromBoard::Hello(hello) = &message {
            // Boards introduce themselves when they start, and lines keep order: after an answered hello, only a board
            // that was restarted does so.
            return match self.epoch {
                Some(before) => Err(LinkError::Restarted { before, after: hello.epoch }),
                None => Ok(()),
            };
        }
        if self.unasked.len() >= UNASKED_MAX {
            self.unasked.pop_front();
        }
        self.unasked.push_back(message);
        Ok(())
    }

    fn note(&mut self, took: Duration, is_first_try: bool) {
        self.counts.answered += 1;
        self.counts.answer_max = self.counts.answer_max.max(took);
        if is_first_try {
            // A maximum that fades in some hundred answers: rare slow ticks count, one hiccup does not for long.
            self.slowest = took.max(self.slowest - self.slowest / 128);
            let wished = (4 * self.slowest).clamp(REPEAT_MIN, REPEAT_MAX);
            // In powers of two, since some transports ask the system for every change.
            let mut rounded = REPEAT_MIN;
            while rounded < wished {
                rounded *= 2;
            }
            self.repeat_after = rounded;
        }
    }

    fn no_answer(&self, request: &'static str, waited: Duration, bytes_before: u64) -> LinkError {
        match (self.bytes - bytes_before, self.last_error) {
            (bytes @ 1.., Some(last)) => LinkError::Garbage { request, waited, bytes, last },
            _ => LinkError::Silent { request, waited },
        }
    }
}

/// An answer of the wrong kind as an error.
pub(crate) fn unexpected(request: &'static str, answer: &FromBoard) -> LinkError {
    match answer {
        FromBoard::Refused(refusal) => LinkError::Refused { request, refusal: *refusal },
        other => LinkError::Unexpected { request, reply: kind_of(other) },
    }
}

/// What a request is called in errors.
pub(crate) fn name_of(request: &FromHost) -> &'static str {
    match request {
        FromHost::Hello(_) => "hello",
        FromHost::Step(_) => "a step",
        FromHost::Checkpoints(_) => "new checkpoints",
        FromHost::Arm => "arm",
        FromHost::Disarm => "disarm",
        FromHost::EStop => "emergency stop",
        FromHost::Sense(_) => "readings",
        FromHost::Begin => "begin a run",
        FromHost::Mode(_) => "another mode",
        FromHost::Parameters(Parameters::Get { .. }) => "a parameter",
        FromHost::Parameters(Parameters::Set(_)) => "set a parameter",
        FromHost::Parameters(Parameters::Defaults) => "default parameters",
        FromHost::Parameters(Parameters::Commit) => "use the parameters",
        FromHost::Map(MapRequest::Describe) => "the map's hash",
        FromHost::Map(MapRequest::Read { .. }) => "neurons of the map",
        FromHost::Map(MapRequest::Write(_)) => "replace neurons",
        FromHost::Map(MapRequest::Confirm { .. }) => "use the new map",
        FromHost::Map(MapRequest::Forget) => "forget the map",
        FromHost::Health => "health",
        FromHost::Telemetry => "telemetry",
        FromHost::Fields { .. } => "the fields",
    }
}

fn kind_of(answer: &FromBoard) -> &'static str {
    match answer {
        FromBoard::Hello(_) => "hello",
        FromBoard::Outputs(_) => "outputs",
        FromBoard::Fault(_) => "fault",
        FromBoard::Done => "done",
        FromBoard::Refused(_) => "refused",
        FromBoard::Parameter(_) => "parameter",
        FromBoard::Map(_) => "map",
        FromBoard::Neurons(_) => "neurons",
        FromBoard::Health(_) => "health",
        FromBoard::Telemetry(_) => "telemetry",
        FromBoard::Fields(_) => "fields",
    }
}
