//! The link's USART: a byte at a time, both ways by interrupt.
#![expect(unsafe_code, reason = "divider and byte are plain numbers to the register crates")]

use crate::board::{Board, Clocks, This, pac};

/// USART1 with 8 bits, no parity, one stop bit.
pub struct Usart {
    registers: pac::USART1,
}

impl Usart {
    /// Starts the USART, with an interrupt for each byte received.
    #[must_use]
    pub fn start(registers: pac::USART1, clocks: &Clocks) -> Self {
        // In units of 1/16 of what gives 16 samples per bit.
        let [low, high] = u16::try_from(clocks.usart_hz / This::BAUD).unwrap_or(u16::MAX).to_le_bytes();
        // SAFETY: any divider of at least 16 is valid; the boards assert it.
        registers.brr().write(|w| unsafe {
            w.div_mantissa()
                .bits((u16::from(high) << 4) | (u16::from(low) >> 4))
                .div_fraction()
                .bits(low & 0xf)
        });
        registers.cr1().write(|w| w.ue().enabled().te().enabled().re().enabled().rxneie().enabled());
        Self { registers }
    }

    /// The byte that has come, if one has. Reading the status and then the byte also clears an overrun; the byte that
    /// was lost to it shows in the frame's checksum.
    pub fn receive(&mut self) -> Option<u8> {
        let status = self.registers.sr().read();
        if status.rxne().bit_is_clear() && status.ore().bit_is_clear() {
            return None;
        }
        let [byte, _] = self.registers.dr().read().dr().bits().to_le_bytes();
        status.rxne().bit_is_set().then_some(byte)
    }

    /// There is room for a byte to send.
    pub fn has_room(&self) -> bool {
        self.registers.sr().read().txe().bit_is_set()
    }

    /// Sends a byte, for which there must be room.
    pub fn send(&mut self, byte: u8) {
        // SAFETY: any byte may be sent.
        self.registers.dr().write(|w| unsafe { w.dr().bits(byte.into()) });
    }

    /// Whether to interrupt when there is room for another byte.
    pub fn notify_room(&mut self, on: bool) {
        self.registers.cr1().modify(|_, w| w.txeie().bit(on));
    }
}
