//! A board in the emulator, which this starts and ends.
//!
//! Two ways lead to it. Over **semihosting** the firmware reads and writes two named pipes through the debugger's
//! door, one system call a frame: fast, and strictly lockstep, since the emulated processor stands still while it
//! waits. Over the **USART** every byte takes the way it takes on the board, interrupt by interrupt.

use core::time::Duration;
use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use protocol::message::Board;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{CWD, Mode, OFlags, mkfifoat};
use rustix::io::Errno;
use tempfile::TempDir;

use super::error::LinkError;
use super::transport::{ReadLimit, Transport, received};

/// The emulator.
const PROGRAM: &str = "qemu-system-arm";

/// Longest wait for a living emulator, to open its serial port, to take bytes, to answer. One that ends is noticed at
/// once, but one that counts instructions stands still for seconds where the machine does.
const PATIENCE: Duration = Duration::from_secs(10);

/// Longest path that the firmware has room for.
const PATH_BYTES_MAX: usize = 100;

/// How to the emulated board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Two pipes through semihosting: lockstep only.
    Semihosting,
    /// The serial port, byte for byte.
    Usart,
}

/// What to emulate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QemuOptions {
    /// The board.
    pub board: Board,
    /// Its firmware image.
    pub image: PathBuf,
    /// Where its log goes, as defmt frames; `None` is nowhere.
    pub log: Option<PathBuf>,
    /// The way to it.
    pub way: Way,
    /// The emulator's `-icount`: how its time goes. `None` is as fast as it can, by the host's clock, which loses timer
    /// interrupts; in real time give a `shift`.
    pub icount: Option<String>,
}

/// An emulated board under way. Dropped, it ends.
#[derive(Debug)]
pub struct Qemu {
    child: Child,
    channel: Channel,
    folder: TempDir,
}

#[derive(Debug)]
enum Channel {
    Pipes { to_board: File, from_board: File },
    Socket(Socket),
}

/// The emulated serial port.
#[derive(Debug)]
struct Socket {
    stream: UnixStream,
    limit: ReadLimit,
    /// What came while something was being sent.
    early: VecDeque<u8>,
}

impl Socket {
    /// Sends all of it, and meanwhile takes what comes.
    ///
    /// The emulator writes a byte at a time, of which a socket holds few hundred; while one finds no room, it does
    /// nothing else, and does not read either. Two ends that wait to write would wait for good.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let end = Instant::now() + PATIENCE;
        loop {
            let mut ready = [PollFd::new(&self.stream, PollFlags::IN | PollFlags::OUT)];
            match poll(&mut ready, Some(&timespec(end.saturating_duration_since(Instant::now())))) {
                Ok(0) => return Err(ErrorKind::TimedOut.into()),
                Ok(_) => {}
                Err(Errno::INTR) => continue,
                Err(error) => return Err(error.into()),
            }
            let events = ready[0].revents();
            if events.contains(PollFlags::OUT) {
                return self.stream.write_all(bytes);
            }
            let mut buffer = [0; 512];
            let count = received(self.stream.read(&mut buffer))?;
            self.early.extend(buffer.iter().take(count));
        }
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        if self.early.is_empty() {
            self.limit.set(patience, |patience| self.stream.set_read_timeout(patience))?;
            return received(self.stream.read(buffer));
        }
        self.early.read(buffer)
    }
}

fn timespec(duration: Duration) -> Timespec {
    Timespec {
        tv_sec: i64::try_from(duration.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: duration.subsec_nanos().into(),
    }
}

/// A process that has not been handed over yet, and ends if it never is.
struct Starting(Option<Child>);

impl Drop for Starting {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            end(child);
        }
    }
}

/// Ends a process for good. If it has ended by itself there is nothing to do.
fn end(child: &mut Child) {
    let _ = child.kill();
    let _ = child.wait();
}

fn machine_of(board: Board) -> Option<&'static str> {
    match board {
        Board::Stm32f405 => Some("netduinoplus2"),
        Board::Stm32f100 => Some("stm32vldiscovery"),
        Board::Stub => None,
    }
}

fn absent(what: impl Into<String>, reason: impl Into<String>, remedy: impl Into<String>) -> LinkError {
    LinkError::Absent { what: what.into(), reason: reason.into(), remedy: remedy.into() }
}

impl Qemu {
    /// Starts an emulated board.
    ///
    /// # Errors
    /// If there is no image or no emulator, or it does not start.
    pub fn start(options: &QemuOptions) -> Result<Self, LinkError> {
        let machine = machine_of(options.board).ok_or_else(|| {
            absent(options.board.name(), "not a board of the emulator", "use the address `stub` for the stub")
        })?;
        if !options.image.is_file() {
            let image = options.image.display().to_string();
            let remedy = "build it with `cargo xtask firmware`, or name another with --image";
            return Err(absent(image, "no such firmware image", remedy));
        }
        let no_folder = |error: io::Error| {
            absent("a temporary folder", error.to_string(), "set TMPDIR to a folder that can be written to")
        };
        let folder = tempfile::Builder::new().prefix("ekm-").tempdir().map_err(no_folder)?;
        let in_folder = |name: &str| folder.path().join(name);
        let (input, output, socket) = (in_folder("in"), in_folder("out"), in_folder("usart"));
        let text = input.to_string_lossy();
        if output.as_os_str().len() > PATH_BYTES_MAX || text.contains([' ', ',']) {
            let remedy = "set TMPDIR to a short path without spaces and commas";
            return Err(absent(text, "the firmware cannot be told this path", remedy));
        }

        let mut command = Command::new(PROGRAM);
        command.args(["-M", machine, "-display", "none", "-monitor", "none", "-kernel"]).arg(&options.image);
        let mut semihosting = String::from("enable=on,target=native,arg=firmware");
        match options.way {
            Way::Semihosting => {
                for pipe in [&input, &output] {
                    mkfifoat(CWD, pipe, Mode::RUSR | Mode::WUSR).map_err(|error| no_folder(error.into()))?;
                }
                semihosting +=
                    &format!(",arg=link=semihosting,arg=in={},arg=out={}", input.display(), output.display());
                command.args(["-serial", "null"]);
            }
            Way::Usart => {
                command.arg("-serial").arg(format!("unix:{},server=on,wait=on", socket.display()));
            }
        }
        if let Some(log) = &options.log {
            semihosting += &format!(",arg=log={}", writable_log(log)?);
        }
        command.args(["-semihosting-config", &semihosting]);
        if let Some(icount) = &options.icount {
            command.args(["-icount", icount]);
        }
        let said = File::create(in_folder("stderr")).map_err(no_folder)?;
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(said);
        let child = command.spawn().map_err(|error| {
            absent(PROGRAM, error.to_string(), "install the emulator: Debian's package is `qemu-system-arm`")
        })?;
        let mut starting = Starting(Some(child));
        let channel = match options.way {
            Way::Semihosting => open_pipes(&input, &output).map_err(no_folder)?,
            Way::Usart => {
                let said = || std::fs::read_to_string(in_folder("stderr")).unwrap_or_default();
                connect(&socket, starting.0.as_mut(), said)?
            }
        };
        match starting.0.take() {
            Some(child) => Ok(Self { child, channel, folder }),
            None => Err(absent(PROGRAM, "it has ended", "start again")),
        }
    }

    /// Why the emulator has ended; `None` while it runs.
    fn obituary(&mut self) -> Option<String> {
        let status = self.child.try_wait().ok().flatten()?;
        let said = std::fs::read_to_string(self.folder.path().join("stderr")).unwrap_or_default();
        Some(ended(&status.to_string(), &said))
    }
}

fn ended(status: &str, said: &str) -> String {
    let said = said.trim();
    let quote = if said.is_empty() { String::new() } else { format!(": {said}") };
    format!("the emulator has ended, {status}{quote}")
}

/// The path of a log as the firmware can be told it, once the file is there.
fn writable_log(log: &Path) -> Result<String, LinkError> {
    let text = log.to_string_lossy();
    let remedy = "name a file that can be written to, with --log";
    File::create(log).map_err(|error| absent(text.clone(), error.to_string(), remedy))?;
    if log.as_os_str().len() > PATH_BYTES_MAX || text.contains([' ', ',']) {
        let remedy = "name a file with a short path without spaces and commas, with --log";
        return Err(absent(text, "the firmware cannot be told this path", remedy));
    }
    Ok(text.into_owned())
}

/// Opens this side of both pipes, neither of which waits for the emulator.
fn open_pipes(input: &Path, output: &Path) -> io::Result<Channel> {
    let nonblocking = i32::try_from(OFlags::NONBLOCK.bits()).unwrap_or_default();
    let from_board = OpenOptions::new().read(true).custom_flags(nonblocking).open(output)?;
    let to_board = OpenOptions::new().read(true).write(true).open(input)?;
    Ok(Channel::Pipes { to_board, from_board })
}

/// Connects to the emulator's serial port as soon as it is there; the emulator waits for it.
fn connect(
    socket: &Path,
    mut child: Option<&mut Child>,
    said: impl Fn() -> String,
) -> Result<Channel, LinkError> {
    let begin = Instant::now();
    loop {
        match UnixStream::connect(socket) {
            Ok(stream) => {
                let limited = stream.set_write_timeout(Some(PATIENCE));
                limited.map_err(|error| LinkError::gone(&error, None))?;
                let early = VecDeque::new();
                return Ok(Channel::Socket(Socket { stream, limit: ReadLimit::default(), early }));
            }
            Err(error) => {
                let status = child.as_mut().and_then(|child| child.try_wait().ok().flatten());
                if let Some(status) = status {
                    return Err(LinkError::Gone { reason: ended(&status.to_string(), &said()) });
                }
                if begin.elapsed() > PATIENCE {
                    return Err(absent(PROGRAM, error.to_string(), "see whether the machine is overloaded"));
                }
                std::thread::sleep(Duration::from_millis(2));
            }
        }
    }
}

impl Transport for Qemu {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        match &mut self.channel {
            Channel::Pipes { to_board, .. } => to_board.write_all(bytes),
            Channel::Socket(socket) => socket.send(bytes),
        }
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let count = match &mut self.channel {
            Channel::Pipes { from_board, .. } => {
                match poll(&mut [PollFd::new(from_board, PollFlags::IN)], Some(&timespec(patience))) {
                    Ok(0) | Err(Errno::INTR) => 0,
                    Ok(_) => received(from_board.read(buffer))?,
                    Err(error) => return Err(error.into()),
                }
            }
            Channel::Socket(socket) => socket.receive(buffer, patience)?,
        };
        // A pipe that nobody has opened yet does not tell that nobody will.
        if count == 0 && self.obituary().is_some() {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        Ok(count)
    }

    fn answer_max(&self) -> Duration {
        PATIENCE
    }

    fn post_mortem(&mut self) -> Option<String> {
        // The pipe closes a moment before the process has ended.
        for _ in 0..50 {
            if let Some(obituary) = self.obituary() {
                return Some(obituary);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        None
    }
}

impl Drop for Qemu {
    fn drop(&mut self) {
        end(&mut self.child);
    }
}
