//! What can go wrong between host and board, each with what to do about it.

use core::time::Duration;
use std::io;

use protocol::codec::EncodeError;
use protocol::frame::FrameError;
use protocol::message::{Mismatch, Refusal};

/// Why a board does not, or does no longer, do its part.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// There is nothing at that address.
    #[error("{what}: cannot be opened ({reason}); {remedy}")]
    Absent {
        /// The address, or what was missing.
        what: String,
        /// What the system said.
        reason: String,
        /// What to do.
        remedy: String,
    },
    /// Nothing comes.
    #[error(
        "the board has been silent for {} ms (asked for: {request}); check power, cable, baud rate and that it runs \
         this firmware",
        waited.as_millis()
    )]
    Silent {
        /// What was asked for.
        request: &'static str,
        /// How long the answer was waited for.
        waited: Duration,
    },
    /// Something comes, but no frame.
    #[error(
        "no answer in {} ms (asked for: {request}), only {bytes} bytes that are none, the last of them: {last}; check \
         the baud rate, and that firmware and host are of the same version",
        waited.as_millis()
    )]
    Garbage {
        /// What was asked for.
        request: &'static str,
        /// How long the answer was waited for.
        waited: Duration,
        /// How many bytes came.
        bytes: u64,
        /// What the decoder said last.
        last: FrameError,
    },
    /// The board is another than the one expected, or speaks otherwise.
    #[error("{mismatch}; {}", remedy_for(mismatch))]
    Mismatch {
        /// In what.
        mismatch: Mismatch,
    },
    /// The board says no.
    #[error("the board refuses ({request}): {}", refusal_text(refusal))]
    Refused {
        /// What was asked for.
        request: &'static str,
        /// Why it refuses.
        refusal: Refusal,
    },
    /// The board answers something else.
    #[error("the board answers `{request}` with `{reply}`; bring firmware and host to the same version")]
    Unexpected {
        /// What was asked for.
        request: &'static str,
        /// What came.
        reply: &'static str,
    },
    /// The other side has gone away in mid-session.
    #[error("the board has gone away ({reason}); plug it in or start it again, then repeat the run")]
    Gone {
        /// What the system, or the emulator, said.
        reason: String,
    },
    /// The board has been reset in mid-session and knows nothing of the run any more.
    #[error(
        "the board was restarted in mid-run (start {before} became start {after}); its state is lost: check its supply \
         and its log, then repeat the run"
    )]
    Restarted {
        /// The epoch that the session began with.
        before: u32,
        /// The one now.
        after: u32,
    },
    /// The board's map is not the one that was sent, or that was to be read.
    #[error("the map on the board has hash {found:016x}, not {expected:016x}; send it again, or report this")]
    Map {
        /// Hash of what there is.
        found: u64,
        /// Hash of what there should be.
        expected: u64,
    },
    /// What was to be sent is no number.
    #[error("a message cannot be sent ({0}); report this")]
    Encode(EncodeError),
}

impl From<EncodeError> for LinkError {
    fn from(error: EncodeError) -> Self {
        Self::Encode(error)
    }
}

impl From<Mismatch> for LinkError {
    fn from(mismatch: Mismatch) -> Self {
        Self::Mismatch { mismatch }
    }
}

impl LinkError {
    /// From a transport that failed under way.
    pub(crate) fn gone(error: &io::Error, post_mortem: Option<String>) -> Self {
        let reason = post_mortem.unwrap_or_else(|| {
            if error.kind() == io::ErrorKind::UnexpectedEof {
                String::from("the connection was closed")
            } else {
                error.to_string()
            }
        });
        Self::Gone { reason }
    }
}

fn remedy_for(mismatch: &Mismatch) -> &'static str {
    match mismatch {
        Mismatch::ProtocolVersion { .. } | Mismatch::Schema { .. } => {
            "build and flash the firmware from the same commit as this program"
        }
        Mismatch::Board { .. } => "connect that board, or name the one that is there",
        Mismatch::Scalar { .. } => "leave out --scalar, or connect a board that computes so",
        Mismatch::MapHash { .. } => "send the map again",
        Mismatch::ParametersHash { .. } => "send the parameters again",
        Mismatch::TimeBase { .. } => "start the session again",
    }
}

/// A refusal in words.
fn refusal_text(refusal: &Refusal) -> String {
    match refusal {
        Refusal::Mismatch => {
            String::from("it has not been greeted by a host that fits; start the session again")
        }
        Refusal::TimeBase { present } => format!("not while its time base is {}", present.name()),
        Refusal::Tick { expected, found } => {
            format!("the next tick is {expected}, not {found}; begin the run again")
        }
        Refusal::Checkpoints(error) => error.to_string(),
        Refusal::NoSuchParameter { count } => format!("it has {count} parameters, counted from 0"),
        Refusal::BadParameter { index } => {
            let named = controller_core::config::PARAMETERS.get(usize::from(*index));
            match named {
                Some(parameter) => format!("{} must be {}", parameter.name, parameter.must),
                None => format!("parameter {index} has a value that it cannot have"),
            }
        }
        Refusal::NoSuchNeurons { count } => format!("its map has {count} neurons, counted from 0"),
        Refusal::MapHash { found } => format!("the map as it arrived has hash {found:016x}; send it again"),
        Refusal::EmergencyStop => String::from("an emergency stop is latched; disarm first"),
        Refusal::NotStandingBy => String::from("not while the robot learns or navigates; stop it first"),
        Refusal::NotFinite => String::from("the answer would hold a number that is not finite"),
    }
}
