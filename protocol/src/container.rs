//! A block of bytes that proves itself whole: magic, length, body, CRC.
//!
//! ```text
//! offset  bytes
//! 0       8      magic: what this is
//! 8       4      length of the whole block, u32, little-endian
//! 12      n      body
//! 12+n    4      CRC-32 (ISO-HDLC, as in zip) of everything before it, little-endian
//! ```
//!
//! The frame around the body has no version, so that a reader of any version can tell damage from novelty: the
//! versions are the body's. The length is there so that a cut block is told from a damaged one.

const MAGIC_BYTES: usize = 8;
const BODY_OFFSET: usize = MAGIC_BYTES + 4;
const CRC_BYTES: usize = 4;

/// Bytes around the body.
pub(crate) const OVERHEAD_BYTES: usize = BODY_OFFSET + CRC_BYTES;

/// What half a byte does to the CRC: 64 bytes of flash, where a table of whole bytes takes a kilobyte.
static CRC_OF_HALF_BYTES: [u32; 16] = crc_of_half_bytes();

const fn crc_of_half_bytes() -> [u32; 16] {
    /// The polynomial of CRC-32, lowest bit first.
    const POLYNOMIAL: u32 = 0xEDB8_8320;
    let mut table = [0; 16];
    let mut half_byte: u32 = 0;
    let mut at = 0;
    while at < table.len() {
        let mut crc = half_byte;
        let mut bits = 0;
        while bits < 4 {
            crc = if crc & 1 == 1 { crc >> 1 ^ POLYNOMIAL } else { crc >> 1 };
            bits += 1;
        }
        table[at] = crc;
        at += 1;
        half_byte += 1;
    }
    table
}

/// The CRC of some bytes followed by `bytes`, from the CRC of those alone; 0 is that of none.
pub(crate) fn extend_crc(crc: u32, bytes: &[u8]) -> u32 {
    let low = |crc: u32| CRC_OF_HALF_BYTES[usize::from(crc.to_le_bytes()[0] & 15)];
    !bytes.iter().fold(!crc, |crc, &byte| {
        let crc = crc ^ u32::from(byte);
        let crc = crc >> 4 ^ low(crc);
        crc >> 4 ^ low(crc)
    })
}

/// Why a block is not whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Damage {
    BadMagic { found: [u8; MAGIC_BYTES] },
    Truncated { expected_bytes: usize, found_bytes: usize },
    TrailingBytes { expected_bytes: usize, found_bytes: usize },
    Checksum { stored: u32, computed: u32 },
}

/// Where the body of a block goes; `None` where `out` has no room for any.
pub(crate) fn body_mut(out: &mut [u8]) -> Option<&mut [u8]> {
    let end = out.len().checked_sub(CRC_BYTES)?;
    out.get_mut(BODY_OFFSET..end)
}

/// Puts magic, length and CRC around a body of `body_bytes` already written at [`body_mut`].
///
/// `None` where `out` is too small or the length exceeds 32 bits.
pub(crate) fn seal(magic: [u8; MAGIC_BYTES], out: &mut [u8], body_bytes: usize) -> Option<&mut [u8]> {
    let total = body_bytes.checked_add(OVERHEAD_BYTES)?;
    let block = out.get_mut(..total)?;
    let (covered, crc) = block.split_last_chunk_mut::<CRC_BYTES>()?;
    covered.get_mut(..MAGIC_BYTES)?.copy_from_slice(&magic);
    covered.get_mut(MAGIC_BYTES..BODY_OFFSET)?.copy_from_slice(&u32::try_from(total).ok()?.to_le_bytes());
    *crc = extend_crc(0, covered).to_le_bytes();
    Some(block)
}

/// The body of a whole block.
pub(crate) fn open(magic: [u8; MAGIC_BYTES], block: &[u8]) -> Result<&[u8], Damage> {
    let found_bytes = block.len();
    let truncated = |expected_bytes| Damage::Truncated { expected_bytes, found_bytes };
    let (found, rest) = block.split_first_chunk::<MAGIC_BYTES>().ok_or_else(|| truncated(OVERHEAD_BYTES))?;
    if *found != magic {
        return Err(Damage::BadMagic { found: *found });
    }
    let (length, _) = rest.split_first_chunk::<4>().ok_or_else(|| truncated(OVERHEAD_BYTES))?;
    // Where usize is narrower than 32 bits, the largest stands for "more than there can be".
    let expected_bytes = usize::try_from(u32::from_le_bytes(*length)).unwrap_or(usize::MAX);
    if found_bytes < expected_bytes.max(OVERHEAD_BYTES) {
        return Err(truncated(expected_bytes.max(OVERHEAD_BYTES)));
    }
    if found_bytes > expected_bytes {
        return Err(Damage::TrailingBytes { expected_bytes, found_bytes });
    }
    let (covered, stored) = block.split_last_chunk::<CRC_BYTES>().ok_or_else(|| truncated(OVERHEAD_BYTES))?;
    let (stored, computed) = (u32::from_le_bytes(*stored), extend_crc(0, covered));
    if stored != computed {
        return Err(Damage::Checksum { stored, computed });
    }
    covered.get(BODY_OFFSET..).ok_or_else(|| truncated(OVERHEAD_BYTES))
}
