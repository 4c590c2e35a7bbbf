//! A message to bytes and back.
//!
//! Thin over [postcard]: it adds what postcard leaves open, namely that reals are finite, that nothing follows the
//! message, and errors that say what was wrong instead of where the decoder stood.
//!
//! [postcard]: https://postcard.jamesmunns.com

use core::fmt;
use postcard::ser_flavors::Size;
use postcard_schema::Schema;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// One direction's messages.
pub trait Message: Serialize + DeserializeOwned + Schema {
    /// How many variants there are; the first byte is below this.
    const KINDS: u8;

    /// Bytes of the largest body: what a buffer must hold.
    const MAX_BYTES: usize;

    /// The first field whose value the wire does not carry (not finite, or a negative range), by name.
    fn first_invalid(&self) -> Option<&'static str>;

    /// Reads a message that fills `bytes` exactly, its kind being known; for all else there is [`from_bytes`].
    ///
    /// Of the trait, so that this crate compiles it, small, instead of whoever asks for it.
    ///
    /// # Errors
    /// See [`DecodeError`].
    fn read(bytes: &[u8]) -> Result<Self, DecodeError>;
}

/// Why a message could not be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EncodeError {
    /// It does not fit; [`Message::MAX_BYTES`] always does.
    BufferTooSmall {
        /// What there was room for.
        available_bytes: usize,
    },
    /// A real is not finite, or a range is negative.
    InvalidValue {
        /// Its name.
        field: &'static str,
    },
}

/// Why bytes are not a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecodeError {
    /// The bytes end before the message does.
    Truncated {
        /// How many there were.
        found_bytes: usize,
    },
    /// Something follows the message.
    TrailingBytes {
        /// How many bytes too many.
        surplus_bytes: usize,
    },
    /// The first byte is no message of this direction.
    UnknownMessage {
        /// The first byte.
        key: u8,
        /// How many messages this direction has.
        known: u8,
    },
    /// A field's bytes stand for none of its values.
    Malformed {
        /// What was wrong.
        what: &'static str,
    },
    /// A real is not finite, or a range is negative.
    InvalidValue {
        /// Its name.
        field: &'static str,
    },
}

/// Writes a message to the front of `buffer` and gives back the part it takes.
///
/// ```
/// use protocol::codec::{Message, from_bytes, to_slice};
/// use protocol::message::FromHost;
///
/// let mut buffer = [0; FromHost::MAX_BYTES];
/// let bytes = to_slice(&FromHost::EStop, &mut buffer).unwrap();
/// assert_eq!(from_bytes(bytes), Ok(FromHost::EStop));
/// ```
///
/// # Errors
/// See [`EncodeError`]; the contents of `buffer` then mean nothing.
pub fn to_slice<'a, M: Message>(message: &M, buffer: &'a mut [u8]) -> Result<&'a mut [u8], EncodeError> {
    if let Some(field) = message.first_invalid() {
        return Err(EncodeError::InvalidValue { field });
    }
    let available_bytes = buffer.len();
    // Lists and strings of known length: a full buffer is all that can go wrong.
    postcard::to_slice(message, buffer).map_err(|_| EncodeError::BufferTooSmall { available_bytes })
}

/// Reads a message that fills `bytes` exactly.
///
/// One message, one encoding: what is accepted is what [`to_slice`] writes, byte by byte.
///
/// # Errors
/// See [`DecodeError`].
pub fn from_bytes<M: Message>(bytes: &[u8]) -> Result<M, DecodeError> {
    if let Some(&key) = bytes.first()
        && key >= M::KINDS
    {
        return Err(DecodeError::UnknownMessage { key, known: M::KINDS });
    }
    M::read(bytes)
}

/// Reads what fills `bytes` exactly, a message or a part of one.
// Not inlined, and the value handled once: on a small board every copy of it is felt on the stack.
#[inline(never)]
pub(crate) fn read<T: Serialize + DeserializeOwned>(
    bytes: &[u8],
    first_invalid: impl FnOnce(&T) -> Option<&'static str>,
) -> Result<T, DecodeError> {
    let mut deserializer = postcard::Deserializer::from_bytes(bytes);
    match T::deserialize(&mut deserializer) {
        Ok(value) => {
            let surplus_bytes = deserializer.finalize().unwrap_or_default().len();
            if surplus_bytes > 0 {
                return Err(DecodeError::TrailingBytes { surplus_bytes });
            }
            // All else has one encoding: what is longer than need be has an integer that is.
            let needed_bytes = postcard::serialize_with_flavor(&value, Size::default());
            if needed_bytes != Ok(bytes.len()) {
                return Err(DecodeError::Malformed { what: "an integer takes more bytes than it needs" });
            }
            match first_invalid(&value) {
                Some(field) => Err(DecodeError::InvalidValue { field }),
                None => Ok(value),
            }
        }
        Err(postcard::Error::DeserializeUnexpectedEnd) => {
            Err(DecodeError::Truncated { found_bytes: bytes.len() })
        }
        Err(other) => Err(DecodeError::Malformed { what: reason(&other) }),
    }
}

/// What postcard found wrong, in the words of the wire.
pub(crate) fn reason(error: &postcard::Error) -> &'static str {
    match error {
        postcard::Error::DeserializeBadVarint => "an integer is larger than its type",
        postcard::Error::DeserializeBadBool => "a truth value is neither 0 nor 1",
        postcard::Error::DeserializeBadOption => "the mark of an optional field is neither 0 nor 1",
        postcard::Error::DeserializeBadUtf8 => "a text is not UTF-8",
        // All that serde itself objects to; without a heap postcard keeps no more of it.
        postcard::Error::SerdeDeCustom => {
            "an unknown variant, a text beyond ASCII, or a list or text longer than its limit"
        }
        _ => "not the encoding of this type",
    }
}

/// The name of the first value that is not finite.
pub(crate) fn all_finite(fields: &[(&'static str, f32)]) -> Option<&'static str> {
    fields.iter().find(|(_, value)| !value.is_finite()).map(|(name, _)| *name)
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BufferTooSmall { available_bytes } => {
                write!(f, "the message does not fit into {available_bytes} bytes")
            }
            Self::InvalidValue { field } => write!(f, "{field} is not finite, or is a negative range"),
        }
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truncated { found_bytes } => write!(f, "the message goes on after its {found_bytes} bytes"),
            Self::TrailingBytes { surplus_bytes } => {
                write!(f, "{surplus_bytes} bytes follow the end of the message")
            }
            Self::UnknownMessage { key, known } => {
                write!(f, "message number {key}, where 0 to {} are known", known.saturating_sub(1))
            }
            Self::Malformed { what } => f.write_str(what),
            Self::InvalidValue { field } => write!(f, "{field} is not finite, or is a negative range"),
        }
    }
}

impl core::error::Error for EncodeError {}

impl core::error::Error for DecodeError {}
