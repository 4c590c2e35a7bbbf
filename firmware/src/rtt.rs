//! Real-time transfer: a ring in RAM that a debug probe reads while the core runs.
//!
//! The layout is SEGGER's, for one channel to the host. Written with atomics alone, since probe and core access the
//! ring at the same time.
#![expect(unsafe_code, reason = "a probe finds the control block by its symbol, which must not be mangled")]

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// Bytes of the ring: some log lines, which are short, for the probe reads every few milliseconds, and RAM is scarce.
const RING_BYTES: u8 = 64;
const LENGTH: usize = RING_BYTES as usize;

/// Field for field as the probe expects it; its pointers are references, thin ones.
#[repr(C)]
struct ControlBlock {
    id: [u8; 16],
    channels_to_host: u32,
    channels_to_target: u32,
    name: &'static u8,
    ring: &'static [AtomicU8; LENGTH],
    ring_bytes: u32,
    /// Where the core writes next.
    write: AtomicU32,
    /// Where the probe reads next.
    read: AtomicU32,
    /// 0: what finds no room is skipped.
    mode: AtomicU32,
}

static RING: [AtomicU8; LENGTH] = [const { AtomicU8::new(0) }; LENGTH];

/// The name by which `probe-rs` knows what the bytes are.
static NAME: [u8; 6] = *b"defmt\0";

#[unsafe(export_name = "_SEGGER_RTT")]
static CONTROL: ControlBlock = ControlBlock {
    id: *b"SEGGER RTT\0\0\0\0\0\0",
    channels_to_host: 1,
    channels_to_target: 0,
    name: &NAME[0],
    ring: &RING,
    ring_bytes: RING_BYTES as u32,
    write: AtomicU32::new(0),
    read: AtomicU32::new(0),
    mode: AtomicU32::new(0),
};

/// Appends what there is room for. Nobody waits for a probe; a log line that is cut shows as such in the log.
///
/// To be called by one at a time.
pub fn write(bytes: &[u8]) {
    let mut at = index(&CONTROL.write);
    let read = index(&CONTROL.read);
    for &byte in bytes {
        let next = if at + 1 < LENGTH { at + 1 } else { 0 };
        if next == read {
            break;
        }
        if let Some(slot) = RING.get(at) {
            slot.store(byte, Ordering::Relaxed);
        }
        at = next;
    }
    // The bytes before the index that tells of them.
    CONTROL.write.store(u32::try_from(at).unwrap_or_default(), Ordering::Release);
}

fn index(of: &AtomicU32) -> usize {
    usize::try_from(of.load(Ordering::Acquire)).unwrap_or_default()
}
