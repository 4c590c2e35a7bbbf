//! A serial port, or a pseudo-terminal, which is one as far as a program can tell.

use core::time::Duration;
use std::io::{self, Read, Write};

use serialport::{ClearBuffer, SerialPort};

use super::transport::{SEND_PATIENCE, Transport, received};

/// An open serial port.
pub struct Serial {
    port: Box<dyn SerialPort>,
}

impl Serial {
    /// Opens a port, 8 data bits, no parity, one stop bit, no flow control.
    ///
    /// # Errors
    /// If there is none of that name, it is in use, or it cannot be as fast.
    pub fn open(path: &str, baud: u32) -> io::Result<Self> {
        let port = serialport::new(path, baud).timeout(SEND_PATIENCE).open()?;
        // What a board has said to nobody is of no use any more. Some ports cannot clear; then the client skips it.
        let _ = port.clear(ClearBuffer::Input);
        Ok(Self { port })
    }

    fn set_patience(&mut self, patience: Duration) -> io::Result<()> {
        Ok(self.port.set_timeout(patience)?)
    }
}

impl Transport for Serial {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.set_patience(SEND_PATIENCE)?;
        self.port.write_all(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.set_patience(patience)?;
        received(self.port.read(buffer))
    }
}
