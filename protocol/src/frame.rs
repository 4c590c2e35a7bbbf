//! Frames: where a message begins and ends in a stream of bytes, and proof that it is whole.
//!
//! ```text
//! COBS( key u16 | sequence u8 | body | CRC-32 u32 ) 0x00        integers little-endian
//! ```
//!
//! * **key**: [`crate::schema::key`] of the direction, so that another schema, or one's own echo, is told by name
//! * **sequence**: which request this is, or which it answers
//! * **body**: the message, as [`crate::codec`] writes it
//! * **CRC-32** (ISO-HDLC, as in zip) of key, sequence and body
//! * **COBS** (consistent overhead byte stuffing) takes every zero byte out, at the cost of one byte, and leaves 0x00
//!   to say where a frame ends. Whatever came before, reading is in step again after the next one.
//!
//! An empty frame says nothing and is no error: a sender begins with a lone 0x00 to cut off what noise may have left
//! in the receiver.
//!
//! A damaged frame is noticed but for one in 2³² (the CRC), and only itself is lost, unless its delimiter is what was
//! damaged: then the frame behind it is lost with it.

use core::fmt;
use core::marker::PhantomData;

use crate::codec::{DecodeError, EncodeError, Message, from_bytes, to_slice};
use crate::container::extend_crc;
use crate::message::{FromBoard, FromHost};
use crate::schema;

/// Ends each frame and occurs in none.
pub const DELIMITER: u8 = 0;

const KEY_BYTES: usize = 2;
const SEQUENCE_BYTES: usize = 1;
const CRC_BYTES: usize = 4;
const HEAD_BYTES: usize = KEY_BYTES + SEQUENCE_BYTES;
/// COBS takes one byte for up to 254.
const STUFFING_BYTES: usize = 1;

const BODY_BYTES_MAX: usize =
    if FromHost::MAX_BYTES > FromBoard::MAX_BYTES { FromHost::MAX_BYTES } else { FromBoard::MAX_BYTES };
/// Before stuffing.
const CONTENT_BYTES_MAX: usize = HEAD_BYTES + BODY_BYTES_MAX + CRC_BYTES;

/// Largest frame of either direction, delimiter included: what a buffer for sending must hold.
pub const FRAME_BYTES_MAX: usize = STUFFING_BYTES + CONTENT_BYTES_MAX + 1;

const _: () = {
    // One run of COBS can hold any frame, so the code 0xFF (254 bytes and no zero behind them) never occurs.
    assert!(CONTENT_BYTES_MAX < 254);
};

/// A whole and valid frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame<M> {
    /// Which request this is, or which it answers; 0 for what is neither asked nor answered.
    pub sequence: u8,
    /// What it says.
    pub message: M,
}

/// A whole frame whose message has not been read.
#[derive(Clone, Copy, Debug)]
pub struct RawFrame<'a, M> {
    /// As [`Frame::sequence`].
    pub sequence: u8,
    /// The message, as [`crate::codec`] writes it.
    pub body: &'a [u8],
    direction: PhantomData<fn() -> M>,
}

/// Why what stood before a delimiter is not a frame of this direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// More bytes than the largest frame has.
    TooLong {
        /// [`FRAME_BYTES_MAX`].
        limit_bytes: usize,
    },
    /// Fewer bytes than the smallest frame has.
    Truncated {
        /// Bytes left when the stuffing was taken out.
        found_bytes: usize,
    },
    /// The frame ends before its stuffing does: bytes were lost or added.
    Stuffing {
        /// Bytes that were still to come.
        missing_bytes: u8,
    },
    /// The bytes are not those that were sent.
    Checksum {
        /// CRC-32 that came with them.
        stored: u32,
        /// CRC-32 of the bytes that came.
        computed: u32,
    },
    /// Whole, but of other messages: another version, or what this end itself has sent.
    Key {
        /// [`crate::schema::key`] of this direction.
        expected: u16,
        /// The frame's.
        found: u16,
    },
    /// Whole and of this direction, but no message: written by a faulty program.
    Message(DecodeError),
}

/// How many frames have come. They stay at their largest value rather than begin again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Whole and valid.
    pub good: u32,
    /// Anything else between two delimiters, empty frames excepted.
    pub bad: u32,
}

/// Writes a frame to the front of `buffer` and gives back the part it takes, delimiter included.
///
/// ```
/// use protocol::frame::{Decoder, FRAME_BYTES_MAX, Frame, encode};
/// use protocol::message::FromHost;
///
/// let mut buffer = [0; FRAME_BYTES_MAX];
/// let bytes = encode(7, &FromHost::EStop, &mut buffer).unwrap();
/// let mut decoder = Decoder::<FromHost>::new();
/// let frame = bytes.iter().find_map(|&byte| decoder.push(byte));
/// assert_eq!(frame, Some(Ok(Frame { sequence: 7, message: FromHost::EStop })));
/// ```
///
/// # Errors
/// See [`EncodeError`]; [`FRAME_BYTES_MAX`] bytes always suffice. The contents of `buffer` then mean nothing.
pub fn encode<'a, M: Message>(
    sequence: u8,
    message: &M,
    buffer: &'a mut [u8],
) -> Result<&'a [u8], EncodeError> {
    let available_bytes = buffer.len();
    let too_small = EncodeError::BufferTooSmall { available_bytes };
    // What is larger than the largest frame could not be stuffed in one run.
    let usable = available_bytes.min(FRAME_BYTES_MAX);
    let (stuffing, rest) = buffer.get_mut(..usable).and_then(<[u8]>::split_first_mut).ok_or(too_small)?;
    let (head, rest) = rest.split_first_chunk_mut::<HEAD_BYTES>().ok_or(too_small)?;
    let [low, high] = schema::key::<M>().to_le_bytes();
    *head = [low, high, sequence];
    let body_bytes = match to_slice(message, rest) {
        Ok(body) => body.len(),
        Err(EncodeError::BufferTooSmall { .. }) => return Err(too_small),
        Err(invalid @ EncodeError::InvalidValue { .. }) => return Err(invalid),
    };
    let (body, rest) = rest.split_at_mut(body_bytes);
    let (crc, rest) = rest.split_first_chunk_mut::<CRC_BYTES>().ok_or(too_small)?;
    let delimiter = rest.first_mut().ok_or(too_small)?;
    *crc = extend_crc(extend_crc(0, head), body).to_le_bytes();
    *delimiter = DELIMITER;
    // Every zero gives way to the distance to the next one; the delimiter counts as the last.
    let mut distance = 1;
    for byte in head.iter_mut().chain(body).chain(crc).rev() {
        if *byte == 0 {
            *byte = distance;
            distance = 1;
        } else {
            distance += 1;
        }
    }
    *stuffing = distance;
    buffer.get(..STUFFING_BYTES + HEAD_BYTES + body_bytes + CRC_BYTES + 1).ok_or(too_small)
}

/// Where in a frame the last byte was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Behind a delimiter.
    Between,
    /// In a frame; so many bytes are to come before the next that stands for a zero, or ends the frame.
    Inside { run: u8 },
    /// In a frame that has become too long, whose rest is not looked at.
    Beyond,
}

/// Takes frames out of a stream, byte by byte: `Decoder<FromHost>` on the board, `Decoder<FromBoard>` on the host.
///
/// The work per byte is bounded: a step of the CRC, and at the delimiter one decoding of at most
/// a frame's bytes. It needs no other memory than its own.
#[derive(Clone, Debug)]
pub struct Decoder<M> {
    /// The present frame, stuffing taken out.
    content: [u8; CONTENT_BYTES_MAX],
    content_bytes: u8,
    place: Place,
    /// CRC of the content but for its last [`CRC_BYTES`], which are the CRC to compare with.
    crc: u32,
    counts: Counts,
    direction: PhantomData<fn() -> M>,
}

impl<M: Message> Default for Decoder<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M: Message> Decoder<M> {
    /// A decoder that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            content: [0; CONTENT_BYTES_MAX],
            content_bytes: 0,
            place: Place::Between,
            crc: 0,
            counts: Counts { good: 0, bad: 0 },
            direction: PhantomData,
        }
    }

    /// Takes one byte; a frame, or why it is none, comes with its delimiter.
    pub fn push(&mut self, byte: u8) -> Option<Result<Frame<M>, FrameError>> {
        let read = match self.push_raw(byte)? {
            Ok(raw) => raw.read(),
            Err(error) => return Some(Err(error)),
        };
        if read.is_err() {
            self.count_as_bad();
        }
        Some(read)
    }

    /// As [`Decoder::push`], but the message is left unread, for who has no room for it on the way. One that cannot
    /// be read is to be told by [`Decoder::count_as_bad`].
    pub fn push_raw(&mut self, byte: u8) -> Option<Result<RawFrame<'_, M>, FrameError>> {
        if byte == DELIMITER {
            return self.end();
        }
        self.place = match self.place {
            Place::Between => Place::Inside { run: byte - 1 },
            Place::Inside { run: 0 } => self.keep(0, byte - 1),
            Place::Inside { run } => self.keep(byte, run - 1),
            Place::Beyond => Place::Beyond,
        };
        None
    }

    /// The last whole frame had no valid message: it counts as bad after all.
    pub fn count_as_bad(&mut self) {
        self.counts.good = self.counts.good.saturating_sub(1);
        self.counts.bad = self.counts.bad.saturating_add(1);
    }

    /// Frames so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Appends to the content; afterwards the decoder is inside, with this run to come, unless the frame is too long.
    fn keep(&mut self, byte: u8, run: u8) -> Place {
        let at = usize::from(self.content_bytes);
        // The same limit for both directions, so that an echo is told by its key whatever its length.
        let Some(slot) = self.content.get_mut(at) else { return Place::Beyond };
        *slot = byte;
        self.content_bytes += 1;
        if let Some(covered) = at.checked_sub(CRC_BYTES).and_then(|at| self.content.get(at)) {
            self.crc = extend_crc(self.crc, &[*covered]);
        }
        Place::Inside { run }
    }

    fn end(&mut self) -> Option<Result<RawFrame<'_, M>, FrameError>> {
        let wrong = match self.place {
            Place::Between => return None,
            Place::Inside { run: 0 } => None,
            Place::Inside { run } => Some(FrameError::Stuffing { missing_bytes: run }),
            Place::Beyond => Some(FrameError::TooLong { limit_bytes: FRAME_BYTES_MAX }),
        };
        let found_bytes = usize::from(core::mem::take(&mut self.content_bytes));
        let crc = core::mem::take(&mut self.crc);
        self.place = Place::Between;
        let content = self.content.get(..found_bytes).unwrap_or_default();
        let result = wrong.map_or_else(|| check(content, crc), Err);
        let count = if result.is_ok() { &mut self.counts.good } else { &mut self.counts.bad };
        *count = count.saturating_add(1);
        Some(result)
    }
}

/// The parts of a frame, and whether they fit together; `crc` is that of the content without its own.
fn check<M: Message>(content: &[u8], crc: u32) -> Result<RawFrame<'_, M>, FrameError> {
    let (head, body, stored) = content
        .split_first_chunk::<HEAD_BYTES>()
        .and_then(|(head, rest)| rest.split_last_chunk::<CRC_BYTES>().map(|(body, crc)| (head, body, crc)))
        .ok_or(FrameError::Truncated { found_bytes: content.len() })?;
    let stored = u32::from_le_bytes(*stored);
    // The sum before the key: of a damaged key nothing can be told.
    if stored != crc {
        return Err(FrameError::Checksum { stored, computed: crc });
    }
    let [low, high, sequence] = *head;
    let (expected, found) = (const { schema::key::<M>() }, u16::from_le_bytes([low, high]));
    if found != expected {
        return Err(FrameError::Key { expected, found });
    }
    Ok(RawFrame { sequence, body, direction: PhantomData })
}

impl<M: Message> RawFrame<'_, M> {
    /// Reads the message.
    ///
    /// # Errors
    /// [`FrameError::Message`], where there is none.
    pub fn read(&self) -> Result<Frame<M>, FrameError> {
        let message = from_bytes(self.body).map_err(FrameError::Message)?;
        Ok(Frame { sequence: self.sequence, message })
    }
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLong { limit_bytes } => write!(f, "frame of more than {limit_bytes} bytes"),
            Self::Truncated { found_bytes } => {
                let least = HEAD_BYTES + CRC_BYTES;
                write!(f, "frame with {found_bytes} bytes, where {least} stand around the message alone")
            }
            Self::Stuffing { missing_bytes } => {
                write!(f, "frame cut {missing_bytes} bytes before its next zero")
            }
            Self::Checksum { stored, computed } => {
                write!(f, "frame damaged: its CRC-32 is {stored:08x}, that of its bytes {computed:08x}")
            }
            Self::Key { expected, found } => write!(
                f,
                "frame of other messages: its key is {found:04x}, {expected:04x} was expected; \
                 bring both ends to the same version, and look for an echo on the line"
            ),
            Self::Message(error) => write!(f, "whole frame without a valid message: {error}"),
        }
    }
}

impl core::error::Error for FrameError {}
