//! What an emulator offers: the command line that the host has given, a log file, and a link over two FIFOs.
//!
//! All of it is semihosting: the core stops at a breakpoint instruction, the emulator does what is asked, and the core
//! goes on. QEMU must be started with `-semihosting-config enable=on,target=native,arg=firmware` and further `arg=`s:
//!
//! | `arg=` | |
//! | --- | --- |
//! | `link=semihosting` | the link goes over FIFOs instead of USART1 |
//! | `in=PATH` | FIFO from the host to the board |
//! | `out=PATH` | FIFO from the board to the host |
//! | `log=PATH` | the log goes into this file instead of the emulator's standard output |
//!
//! Over FIFOs one trap moves a whole frame, and the core stands still while it waits for the next: so this link is for
//! lockstep alone, and two hundred times as fast as the emulated USART.

use core::ffi::CStr;
use core::mem::MaybeUninit;

use semihosting::fd::{AsFd, OwnedFd};
use semihosting::sys::arm_compat::{OpenMode, sys_get_cmdline_uninit, sys_open};
use semihosting::{process, sys};

/// Longest command line.
const COMMAND_LINE_BYTES: usize = 384;
/// Longest path.
const PATH_BYTES: usize = 128;

/// What the host has asked for.
pub struct Emulator {
    /// Where the log goes; `None` if it cannot be opened.
    pub log: Option<OwnedFd>,
    /// The link over FIFOs, where it was asked for.
    pub fifos: Option<Fifos>,
}

/// The link over two FIFOs.
pub struct Fifos {
    /// From the host.
    pub input: Input,
    /// To the host.
    pub output: Output,
}

/// Bytes from the host.
pub struct Input(OwnedFd);

/// Bytes to the host.
pub struct Output(OwnedFd);

impl Emulator {
    /// Reads the command line and opens what it names.
    ///
    /// A link that was asked for and cannot be opened ends the emulator: the host would wait for it in vain. Opening
    /// a FIFO waits for its other end, the input first.
    #[must_use]
    #[inline(never)]
    pub fn open() -> Self {
        let mut buffer = [MaybeUninit::uninit(); COMMAND_LINE_BYTES];
        let line: &[u8] = sys_get_cmdline_uninit(&mut buffer).map_or(&[], |line| line);
        let log = match word(line, b"log=") {
            Some(path) => open(path, OpenMode::WRONLY_TRUNC_BINARY),
            None => open(b":tt", OpenMode::WRONLY_TRUNC_BINARY),
        };
        let fifos = word(line, b"link=").filter(|kind| *kind == b"semihosting").map(|_| {
            let input = word(line, b"in=").and_then(|path| open(path, OpenMode::RDONLY_BINARY));
            let output = word(line, b"out=").and_then(|path| open(path, OpenMode::WRONLY_TRUNC_BINARY));
            match (input, output) {
                (Some(input), Some(output)) => Fifos { input: Input(input), output: Output(output) },
                _ => {
                    defmt::error!(
                        "link=semihosting: in=PATH or out=PATH is missing, too long, or cannot be opened"
                    );
                    end(false);
                }
            }
        });
        Self { log, fifos }
    }
}

impl Input {
    /// Waits until there is something to read, and gives what there is. Nothing means that the host has gone away.
    pub fn read<'a>(&mut self, buffer: &'a mut [u8]) -> &'a [u8] {
        let count = sys::read(self.0.as_fd(), buffer).unwrap_or_default();
        buffer.get(..count).unwrap_or_default()
    }
}

impl Output {
    /// Writes all; what the host does not take any more is lost.
    pub fn write(&mut self, bytes: &[u8]) {
        let _ = sys::write(self.0.as_fd(), bytes);
    }
}

/// Ends the emulator, with the host's exit status 0 or 1.
pub fn end(is_success: bool) -> ! {
    process::exit(i32::from(!is_success))
}

/// The word of the command line that begins so, without its beginning.
fn word<'a>(line: &'a [u8], key: &[u8]) -> Option<&'a [u8]> {
    line.split(|byte| *byte == b' ').find_map(|word| word.strip_prefix(key))
}

fn open(path: &[u8], mode: OpenMode) -> Option<OwnedFd> {
    let mut buffer = [0; PATH_BYTES];
    // One zero must be left at the end.
    if path.len() >= PATH_BYTES {
        return None;
    }
    for (to, from) in buffer.iter_mut().zip(path) {
        *to = *from;
    }
    sys_open(CStr::from_bytes_until_nul(&buffer).ok()?, mode).ok()
}
