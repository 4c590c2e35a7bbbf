//! Bytes to and from a board.

use core::time::Duration;
use std::io;

/// A way to a board.
pub trait Transport {
    /// Sends all of it, at once.
    ///
    /// # Errors
    /// If the other side is gone, or takes nothing for a second.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// What has come, at least a byte; waits for it, but not longer than `patience`, and then gives 0.
    ///
    /// # Errors
    /// If the other side is gone; an end of file is [`io::ErrorKind::UnexpectedEof`].
    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize>;

    /// After how long without an answer the board counts as silent.
    fn answer_max(&self) -> Duration {
        ANSWER_MAX
    }

    /// Why the other side is gone, where the transport knows more than the system's error tells.
    fn post_mortem(&mut self) -> Option<String> {
        None
    }
}

impl<T: Transport + ?Sized> Transport for Box<T> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        (**self).receive(buffer, patience)
    }

    fn answer_max(&self) -> Duration {
        (**self).answer_max()
    }

    fn post_mortem(&mut self) -> Option<String> {
        (**self).post_mortem()
    }
}

/// Longest wait for an answer, unless the transport says otherwise. With the time that opening takes, whatever is amiss
/// is told within two seconds.
pub const ANSWER_MAX: Duration = Duration::from_millis(1500);

/// Longest wait for a transport to take bytes.
pub(crate) const SEND_PATIENCE: Duration = Duration::from_secs(1);

/// A system's read as [`Transport::receive`] has it: time over is 0, the end is an error.
pub(crate) fn received(result: io::Result<usize>) -> io::Result<usize> {
    match result {
        Ok(0) => Err(io::ErrorKind::UnexpectedEof.into()),
        Err(error) => match error.kind() {
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted => Ok(0),
            _ => Err(error),
        },
        Ok(count) => Ok(count),
    }
}

/// A read limit of a socket that is only told to the system when it changes.
#[derive(Debug, Default)]
pub(crate) struct ReadLimit(Option<Duration>);

impl ReadLimit {
    /// Sets the limit with `set`, unless it is set already. No limit of a socket is 0.
    pub(crate) fn set(
        &mut self,
        patience: Duration,
        set: impl FnOnce(Option<Duration>) -> io::Result<()>,
    ) -> io::Result<()> {
        let patience = Some(patience.max(Duration::from_millis(1)));
        if self.0 != patience {
            set(patience)?;
            self.0 = patience;
        }
        Ok(())
    }
}
