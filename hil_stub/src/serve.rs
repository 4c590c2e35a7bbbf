//! The stub as a process: behind a pseudo-terminal, a TCP connection, or its own standard input and output.

use core::time::Duration;
use std::io::{self, ErrorKind};
use std::net::TcpListener;
use std::os::fd::{AsFd, OwnedFd};
use std::time::Instant;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, fcntl_setfl, open};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

use crate::board::Stub;

/// Longest wait for a host that does not read; then the bytes are lost, as on a wire.
const SEND_PATIENCE: Duration = Duration::from_millis(100);

/// A pseudo-terminal: a serial line without the hardware.
///
/// It holds both ends open, so that its settings (raw: every byte as it is) outlive the hosts that come and go.
#[derive(Debug)]
pub struct Pty {
    master: OwnedFd,
    _slave: OwnedFd,
    path: String,
}

impl Pty {
    /// A new pseudo-terminal.
    ///
    /// # Errors
    /// If the system has none to give.
    pub fn open() -> io::Result<Self> {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let path = ptsname(&master, Vec::new())?;
        let slave = open(path.as_c_str(), OFlags::RDWR | OFlags::NOCTTY, Mode::empty())?;
        let mut settings = tcgetattr(&slave)?;
        settings.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &settings)?;
        // A host that does not read must not stop the board.
        fcntl_setfl(&master, OFlags::NONBLOCK)?;
        Ok(Self { master, _slave: slave, path: path.to_string_lossy().into_owned() })
    }

    /// The path that a host opens like a serial port.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Is the board behind it, for as long as the process lives: like a serial port, it cannot tell whether anyone
    /// listens.
    ///
    /// # Errors
    /// If the pseudo-terminal breaks.
    pub fn serve(&self, stub: &mut Stub) -> io::Result<()> {
        let clock = Instant::now();
        stub.announce(clock.elapsed());
        serve(stub, &self.master, &self.master, clock)
    }
}

/// Is the board for whoever connects, one host after the other, or for the first only; `left` hears of each that goes.
///
/// # Errors
/// If connections cannot be accepted any more.
pub fn serve_tcp(
    stub: &mut Stub,
    listener: &TcpListener,
    only_once: bool,
    mut left: impl FnMut(),
) -> io::Result<()> {
    let clock = Instant::now();
    stub.announce(clock.elapsed());
    loop {
        let (stream, _) = listener.accept()?;
        // A reply is one small write: it must not wait for company.
        stream.set_nodelay(true)?;
        serve(stub, &stream, &stream, clock)?;
        left();
        if only_once {
            return Ok(());
        }
        stub.replug();
    }
}

/// Is the board on standard input and output, until the input ends.
///
/// # Errors
/// If reading or writing fails.
pub fn serve_stdio(stub: &mut Stub) -> io::Result<()> {
    let clock = Instant::now();
    stub.announce(clock.elapsed());
    serve(stub, io::stdin(), io::stdout(), clock)
}

/// Serves one host until it goes away.
fn serve(stub: &mut Stub, reader: impl AsFd, writer: impl AsFd, clock: Instant) -> io::Result<()> {
    let mut buffer = [0; 1024];
    loop {
        let now = clock.elapsed();
        stub.advance(now);
        if !stub.output().is_empty() {
            let is_sent = send(stub.output(), &writer)?;
            stub.sent(usize::MAX);
            if !is_sent {
                return Ok(());
            }
        }
        let patience = stub.next_event().map(|event| event.saturating_sub(clock.elapsed()));
        if !is_ready(&reader, PollFlags::IN, patience)? {
            continue;
        }
        match rustix::io::read(&reader, &mut buffer) {
            Ok(0) | Err(Errno::CONNRESET | Errno::PIPE) => return Ok(()),
            Ok(count) => stub.receive(buffer.get(..count).unwrap_or_default(), clock.elapsed()),
            Err(Errno::AGAIN | Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
    }
}

/// `false` if the host has gone away.
fn send(mut bytes: &[u8], writer: &impl AsFd) -> io::Result<bool> {
    while !bytes.is_empty() {
        match rustix::io::write(writer, bytes) {
            Ok(count) => bytes = bytes.get(count..).unwrap_or_default(),
            Err(Errno::INTR) => {}
            Err(Errno::AGAIN) => {
                if !is_ready(writer, PollFlags::OUT, Some(SEND_PATIENCE))? {
                    return Ok(true);
                }
            }
            Err(Errno::PIPE | Errno::CONNRESET) => return Ok(false),
            Err(error) => return Err(error.into()),
        }
    }
    Ok(true)
}

/// Waits until bytes can be read or written, or until `patience` is over; `None` waits for ever.
fn is_ready(fd: &impl AsFd, what: PollFlags, patience: Option<Duration>) -> io::Result<bool> {
    let patience = patience.map(|patience| Timespec {
        tv_sec: i64::try_from(patience.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: patience.subsec_nanos().into(),
    });
    match poll(&mut [PollFd::new(fd, what)], patience.as_ref()) {
        Ok(count) => Ok(count > 0),
        Err(error) if io::Error::from(error).kind() == ErrorKind::Interrupted => Ok(false),
        Err(error) => Err(error.into()),
    }
}
