//! A TCP connection, to the stub or to a serial port server.

use core::time::Duration;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};

use super::transport::{ReadLimit, SEND_PATIENCE, Transport, received};

/// Longest wait for a connection.
const CONNECT_PATIENCE: Duration = Duration::from_secs(1);

/// An open connection.
#[derive(Debug)]
pub struct Tcp {
    stream: TcpStream,
    limit: ReadLimit,
}

impl Tcp {
    /// Connects to `host:port`.
    ///
    /// # Errors
    /// If there is no such host, or nobody listens there.
    pub fn connect(address: &str) -> io::Result<Self> {
        let mut last = io::Error::new(ErrorKind::NotFound, "no such host");
        for address in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, CONNECT_PATIENCE) {
                Ok(stream) => {
                    // A request is one small write: it must not wait for company.
                    stream.set_nodelay(true)?;
                    stream.set_write_timeout(Some(SEND_PATIENCE))?;
                    return Ok(Self { stream, limit: ReadLimit::default() });
                }
                Err(error) => last = error,
            }
        }
        Err(last)
    }
}

impl Transport for Tcp {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.write_all(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.limit.set(patience, |patience| self.stream.set_read_timeout(patience))?;
        received(self.stream.read(buffer))
    }
}
