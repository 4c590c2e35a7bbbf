//! STM32F405RG: Cortex-M4F with a single-precision FPU. Numbers from the datasheet (DS8626) and RM0090.
//!
//! Boards: Olimex STM32-H405, Feather STM32F405; in QEMU `netduinoplus2`.

use crate::board::{Board, scalar_name};

/// The number type of this board's controller: the FPU does `f32` in hardware.
pub type Real = f32;

/// Flash of the RG part.
pub const FLASH_BYTES: u32 = 1024 * 1024;

/// SRAM1 and SRAM2, which are adjacent.
pub const RAM_BYTES: u32 = (112 + 16) * 1024;

/// Core-coupled memory: a region of its own that DMA cannot reach, so no part of [`RAM_BYTES`].
pub const CORE_COUPLED_BYTES: u32 = 64 * 1024;

/// Crystal of the Olimex board; the Feather's 12 MHz needs [`PLL_DIVIDER_IN`] 12 for the same clock.
pub const CRYSTAL_HZ: u32 = 8_000_000;

/// PLL M: crystal to PLL input.
pub const PLL_DIVIDER_IN: u32 = 8;

/// PLL N: PLL input to oscillator.
pub const PLL_FACTOR: u32 = 336;

/// PLL P: oscillator to core.
pub const PLL_DIVIDER_OUT: u32 = 2;

const PLL_INPUT_HZ: u32 = CRYSTAL_HZ / PLL_DIVIDER_IN;
const OSCILLATOR_HZ: u32 = PLL_INPUT_HZ * PLL_FACTOR;

/// Clock of the core.
pub const CORE_HZ: u32 = OSCILLATOR_HZ / PLL_DIVIDER_OUT;

const _: () = {
    // RM0090, RCC_PLLCFGR: PLL input 1 to 2 MHz, oscillator 100 to 432 MHz; DS8626: core up to 168 MHz.
    assert!(
        CRYSTAL_HZ.is_multiple_of(PLL_DIVIDER_IN) && OSCILLATOR_HZ.is_multiple_of(PLL_DIVIDER_OUT),
        "the clock is exact"
    );
    assert!(PLL_INPUT_HZ >= 1_000_000 && PLL_INPUT_HZ <= 2_000_000);
    assert!(OSCILLATOR_HZ >= 100_000_000 && OSCILLATOR_HZ <= 432_000_000);
    assert!(CORE_HZ <= 168_000_000);
    // The servo's period is a whole number of clocks.
    assert!(CORE_HZ.is_multiple_of(1000));
};

/// This board.
pub const BOARD: Board = Board {
    name: "stm32f405",
    scalar: scalar_name::<Real>(),
    flash_bytes: FLASH_BYTES,
    ram_bytes: RAM_BYTES,
    core_hz: CORE_HZ,
};
