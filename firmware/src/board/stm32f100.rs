//! STM32F100RB: Cortex-M3 without an FPU. Numbers from the datasheet (CD00251732) and RM0041.
//!
//! Board: STM32VLDISCOVERY; in QEMU `stm32vldiscovery`.

use crate::board::{Board, scalar_name};

/// The number type of this board's controller: without an FPU an `f32` operation is a library call.
pub type Real = controller_core::scalar::Fixed;

/// Flash of the RB part.
pub const FLASH_BYTES: u32 = 128 * 1024;

/// SRAM, all of it.
pub const RAM_BYTES: u32 = 8 * 1024;

/// Crystal of the STM32VLDISCOVERY.
pub const CRYSTAL_HZ: u32 = 8_000_000;

/// PLLMUL: crystal to core.
pub const PLL_FACTOR: u32 = 3;

/// Clock of the core.
pub const CORE_HZ: u32 = CRYSTAL_HZ * PLL_FACTOR;

const _: () = {
    // RM0041, RCC_CFGR: PLLMUL is 2 to 16; datasheet: PLL output 16 to 24 MHz, core up to 24 MHz.
    assert!(PLL_FACTOR >= 2 && PLL_FACTOR <= 16);
    assert!(CORE_HZ >= 16_000_000 && CORE_HZ <= 24_000_000);
    // The servo's period is a whole number of clocks.
    assert!(CORE_HZ.is_multiple_of(1000));
};

/// This board.
pub const BOARD: Board = Board {
    name: "stm32f100",
    scalar: scalar_name::<Real>(),
    flash_bytes: FLASH_BYTES,
    ram_bytes: RAM_BYTES,
    core_hz: CORE_HZ,
};
