//! Where a board is, as the user types it.

use core::fmt;
use core::str::FromStr;
use std::path::PathBuf;

use hil_stub::board::StubOptions;
use protocol::message::{Board, ScalarKind};

use super::error::LinkError;
use super::serial::Serial;
use super::stub::InProcess;
use super::tcp::Tcp;
use super::transport::Transport;

/// The forms there are, for errors and help.
pub const FORMS: &str = "stub, qemu:stm32f405[:usart], qemu:stm32f100[:usart], serial:/dev/tty…, pty:/dev/pts/…, \
                         tcp:HOST:PORT";

/// Where a board is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Address {
    /// In this process.
    Stub,
    /// In the emulator.
    Qemu {
        /// Which.
        board: Board,
        /// Over its serial port, byte for byte, instead of semihosting.
        usart: bool,
    },
    /// At a serial port or pseudo-terminal.
    Serial(String),
    /// Behind a TCP connection.
    Tcp(String),
}

/// How to get there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OpenOptions {
    /// Bits per second of serial ports.
    pub baud: u32,
    /// The emulator's image; `None` is where the build puts it.
    pub image: Option<PathBuf>,
    /// Where the emulated board's log goes; `None` is nowhere.
    pub log: Option<PathBuf>,
    /// What the stub in this process computes with.
    pub stub_scalar: ScalarKind,
    /// The board is to run on its own clock.
    pub real_time: bool,
}

impl Default for OpenOptions {
    fn default() -> Self {
        Self { baud: 1_000_000, image: None, log: None, stub_scalar: ScalarKind::F32, real_time: false }
    }
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let unknown = || format!("not the address of a board; there are {FORMS}");
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        match (kind, rest) {
            ("stub", "") => Ok(Self::Stub),
            ("qemu", board) => {
                let (name, usart) = match board.strip_suffix(":usart") {
                    Some(name) => (name, true),
                    None => (board, false),
                };
                let emulated = [Board::Stm32f405, Board::Stm32f100];
                let board = emulated.into_iter().find(|board| board.name() == name).ok_or_else(unknown)?;
                Ok(Self::Qemu { board, usart })
            }
            ("serial" | "pty", path) if !path.is_empty() => Ok(Self::Serial(path.to_owned())),
            ("tcp", address) if address.contains(':') => Ok(Self::Tcp(address.to_owned())),
            _ => Err(unknown()),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stub => f.write_str("stub"),
            Self::Qemu { board, usart } => {
                write!(f, "qemu:{}{}", board.name(), if *usart { ":usart" } else { "" })
            }
            Self::Serial(path) => write!(f, "serial:{path}"),
            Self::Tcp(address) => write!(f, "tcp:{address}"),
        }
    }
}

impl Address {
    /// The board that must be there, where the address says so.
    #[must_use]
    pub fn board(&self) -> Option<Board> {
        match self {
            Self::Stub => Some(Board::Stub),
            Self::Qemu { board, .. } => Some(*board),
            Self::Serial(_) | Self::Tcp(_) => None,
        }
    }

    /// Opens the way to the board, and starts it where it runs on this machine.
    ///
    /// # Errors
    /// If nothing is there, with what to do.
    pub fn open(&self, options: &OpenOptions) -> Result<Box<dyn Transport>, LinkError> {
        let absent = |what: &str, error: std::io::Error, remedy: &str| LinkError::Absent {
            what: what.to_owned(),
            reason: error.to_string(),
            remedy: remedy.to_owned(),
        };
        Ok(match self {
            Self::Stub => {
                let stub = StubOptions { scalar: options.stub_scalar, ..StubOptions::default() };
                Box::new(InProcess::start(stub).map_err(|error| LinkError::Absent {
                    what: self.to_string(),
                    reason: error.to_string(),
                    remedy: String::from("report this"),
                })?)
            }
            Self::Serial(path) => Box::new(Serial::open(path, options.baud).map_err(|error| {
                let remedy = "check that the board is plugged in, that no other program has the port, and that you \
                              may use it";
                absent(path, error, remedy)
            })?),
            Self::Tcp(address) => Box::new(Tcp::connect(address).map_err(|error| {
                absent(address, error, "start what listens there, for example `hil_stub --tcp 127.0.0.1:7000`")
            })?),
            Self::Qemu { board, usart } => open_emulator(*board, *usart, options)?,
        })
    }
}

/// Where the build puts the image of a board.
#[must_use]
pub fn default_image(board: Board) -> PathBuf {
    let triple = match board {
        Board::Stm32f405 | Board::Stub => "thumbv7em-none-eabihf",
        Board::Stm32f100 => "thumbv7m-none-eabi",
    };
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
    target.join(triple).join("firmware").join("firmware")
}

/// The emulator's clock in real time: so many nanoseconds an instruction, as a power of two, 8 and 64. By the host's
/// own clock the emulator loses timer interrupts; by counted instructions it does not. Slower than the boards, so that
/// what is in time there is in time on them.
#[cfg(unix)]
fn real_time_clock(board: Board) -> &'static str {
    match board {
        Board::Stm32f405 | Board::Stub => "shift=3",
        Board::Stm32f100 => "shift=6,align=on",
    }
}

#[cfg(unix)]
fn open_emulator(board: Board, usart: bool, options: &OpenOptions) -> Result<Box<dyn Transport>, LinkError> {
    use super::qemu::{Qemu, QemuOptions, Way};
    if options.real_time && !usart {
        return Err(LinkError::Absent {
            what: format!("qemu:{} in real time", board.name()),
            reason: String::from("over semihosting the emulated processor stands still while it waits"),
            remedy: format!("use `qemu:{}:usart`", board.name()),
        });
    }
    Ok(Box::new(Qemu::start(&QemuOptions {
        board,
        image: options.image.clone().unwrap_or_else(|| default_image(board)),
        log: options.log.clone(),
        way: if usart { Way::Usart } else { Way::Semihosting },
        icount: options.real_time.then(|| real_time_clock(board).to_owned()),
    })?))
}

#[cfg(not(unix))]
fn open_emulator(board: Board, _: bool, _: &OpenOptions) -> Result<Box<dyn Transport>, LinkError> {
    Err(LinkError::Absent {
        what: format!("qemu:{}", board.name()),
        reason: String::from("it is reached over named pipes and Unix sockets"),
        remedy: String::from("use a Unix system, or `stub`"),
    })
}

#[cfg(test)]
mod tests {
    use super::Address;
    use protocol::message::Board;

    #[test]
    fn addresses_are_read_and_written() {
        let qemu = |usart| Address::Qemu { board: Board::Stm32f100, usart };
        for (text, address) in [
            ("stub", Address::Stub),
            ("qemu:stm32f100", qemu(false)),
            ("qemu:stm32f100:usart", qemu(true)),
            ("serial:/dev/ttyACM0", Address::Serial("/dev/ttyACM0".into())),
            ("tcp:localhost:7000", Address::Tcp("localhost:7000".into())),
        ] {
            assert_eq!(text.parse(), Ok(address.clone()));
            assert_eq!(address.to_string(), text);
        }
        assert_eq!("pty:/dev/pts/3".parse(), Ok(Address::Serial("/dev/pts/3".into())));
        for text in ["", "stub:1", "qemu", "qemu:stub", "qemu:stm32f405:uart", "serial:", "tcp:7000", "usb:1"]
        {
            let error = text.parse::<Address>().unwrap_err();
            assert!(error.contains("qemu:stm32f405"), "{text}: {error}");
        }
    }
}
