//! What travels between a host and a robot, and how a learned map is stored: the types, and their bytes.
//!
//! * [`message`]: what is said, one enum per direction ([`FromHost`], [`FromBoard`])
//! * [`codec`]: a message to bytes and back ([`to_slice`], [`from_bytes`]), as [postcard] bodies
//! * [`frame`]: where a message begins and ends in a stream of bytes, and that it is whole
//! * [`schema`]: the shape of all messages as a number, by which two ends know that they mean the same
//! * [`endpoint`]: the board's end, which says what a board does with each request
//! * [`map_file`]: a learned map with its provenance, as one self-checking block of bytes; [`map_fit`]: whether it is
//!   one for this controller
//!
//! Firmware, `hil_stub` and `host_sim` share this crate, so that the two ends cannot disagree about a field. It has
//! no heap, no I/O and no clock, and no argument makes it panic.
//!
//! # Rules of the wire
//!
//! * **SI units**, named last in the field: `x_m`, `left_mps`, `silent_ms`. Angles in radians, left positive
//!   ([`controller_core::units`] has the frames).
//! * **Reals are `f32`**, whatever the controller computes with: one wire for all boards. [`Fixed`] values below 16
//!   in magnitude pass through `f32` without loss (a test holds this); beyond, the nearest `f32` is sent.
//! * **Reals are finite.** NaN and infinity are refused on both sides, by [`to_slice`] and by [`from_bytes`], and
//!   the error names the field. What may be absent is an `Option`, never a special number.
//! * **Lists are bounded** by their type, so the largest body is known at compile time ([`Message::MAX_BYTES`]).
//! * **Variants are only ever appended**: the position of a variant is its number on the wire.
//! * **One message, one encoding**: what is accepted is what would be sent, byte by byte.
//! * **Damage is noticed**: by the CRC of the frame, and of the map file.
//!
//! `docs/wire_format.md` in the repository describes the wire for those who write another end.
//!
//! [postcard]: https://postcard.jamesmunns.com
//! [`Fixed`]: controller_core::scalar::Fixed
//! [`FromHost`]: message::FromHost
//! [`FromBoard`]: message::FromBoard
//! [`to_slice`]: codec::to_slice
//! [`from_bytes`]: codec::from_bytes
//! [`Message::MAX_BYTES`]: codec::Message::MAX_BYTES
#![no_std]
#![forbid(unsafe_code)]

pub mod message;

pub mod schema;

pub mod codec;

pub mod frame;

pub mod map_file;

pub mod map_fit;

mod container;

pub mod convert;

pub mod endpoint;
