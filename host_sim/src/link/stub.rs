//! A board that this process plays itself, behind real frames: nothing to build, start or plug in.

use core::time::Duration;
use std::io;
use std::time::Instant;

use controller_core::config::ConfigError;
use hil_stub::board::{Stub, StubOptions};

use super::transport::Transport;

/// A stub in this process. It computes in [`Transport::send`], in the caller's own thread, so that a run stays one
/// thread and repeats.
#[derive(Debug)]
pub struct InProcess {
    stub: Stub,
    clock: Instant,
}

impl InProcess {
    /// A board that has just been started.
    ///
    /// # Errors
    /// If the scalar cannot hold the default configuration, which both can.
    pub fn start(options: StubOptions) -> Result<Self, ConfigError> {
        let mut stub = Stub::new(options)?;
        stub.announce(Duration::ZERO);
        Ok(Self { stub, clock: Instant::now() })
    }
}

impl Transport for InProcess {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let now = self.clock.elapsed();
        self.stub.advance(now);
        self.stub.receive(bytes, now);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        // In lockstep the answer is there already, and the clock need not be asked.
        if self.stub.output().is_empty() {
            let end = self.clock.elapsed() + patience;
            loop {
                let now = self.clock.elapsed();
                self.stub.advance(now);
                if !self.stub.output().is_empty() {
                    break;
                }
                if now >= end {
                    return Ok(0);
                }
                let event = self.stub.next_event().unwrap_or(end).min(end);
                std::thread::sleep(event.saturating_sub(now));
            }
        }
        let count = self.stub.output().len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.stub.output()[..count]);
        self.stub.sent(count);
        Ok(count)
    }
}
