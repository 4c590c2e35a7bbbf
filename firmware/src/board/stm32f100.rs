//! STM32F100RB: Cortex-M3 without an FPU. Numbers from the datasheet (CD00251732) and RM0041.
//!
//! Board: STM32VLDISCOVERY; in QEMU `stm32vldiscovery`.

use super::{Board, ClockSource, Clocks, PULSE_HZ, Tick, WATCHDOG_MS, pac, wait_until};

/// The board.
pub struct Stm32f100;

/// Crystal of the STM32VLDISCOVERY.
pub const CRYSTAL_HZ: u32 = 8_000_000;

/// The chip's own oscillator, of which the PLL takes half.
const INTERNAL_HZ: u32 = 8_000_000;

/// Core, buses and timers alike; flash needs no wait states.
const CORE_HZ: u32 = 24_000_000;

/// Low-speed oscillator of the watchdog, nominal; 30 to 60 kHz.
const WATCHDOG_HZ: u32 = 40_000;
/// `IWDG_PR` 3.
const WATCHDOG_DIVIDER: u32 = 32;

const _: () = {
    // The factors set below. RM0041: PLL output 16 to 24 MHz, which is the limit of the core.
    assert!(CRYSTAL_HZ * 3 == CORE_HZ && INTERNAL_HZ / 2 * 6 == CORE_HZ);
    assert!(CORE_HZ >= 16_000_000 && CORE_HZ <= 24_000_000);
    let clocks = Stm32f100::CLOCKS;
    // The servo's period is a whole number of clocks, and so are a bit of the link and a pulse of the motors.
    assert!(clocks.core_hz.is_multiple_of(1000));
    assert!(clocks.usart_hz.is_multiple_of(Stm32f100::BAUD) && INTERNAL_HZ.is_multiple_of(Stm32f100::BAUD));
    // USART: 16 samples for each bit.
    assert!(clocks.usart_hz / Stm32f100::BAUD >= 16 && INTERNAL_HZ / Stm32f100::BAUD >= 16);
    assert!(clocks.timer_hz.is_multiple_of(PULSE_HZ) && clocks.timer_hz / PULSE_HZ <= 0xffff);
};

impl Board for Stm32f100 {
    /// Without an FPU an `f32` operation is a library call.
    type Real = controller_core::scalar::Fixed;

    const ID: protocol::message::Board = protocol::message::Board::Stm32f100;
    const FLASH_BYTES: u32 = 128 * 1024;
    const RAM_BYTES: u32 = 8 * 1024;
    const CLOCKS: Clocks =
        Clocks { source: ClockSource::Crystal, core_hz: CORE_HZ, usart_hz: CORE_HZ, timer_hz: CORE_HZ };
    /// 50 bytes in a millisecond: readings in, outputs out, just; and 480 clocks for each byte.
    const BAUD: u32 = 500_000;
    // With both each millisecond there is no time left for the slow tasks.
    const REPORT_MS: Tick = 8;
    const WATCHDOG: (u8, u16) = {
        let count = WATCHDOG_HZ / WATCHDOG_DIVIDER * WATCHDOG_MS / 1000;
        assert!(count <= 0xfff);
        #[expect(clippy::cast_possible_truncation, reason = "asserted above")]
        (3, count as u16)
    };

    fn start_clocks(peripherals: &pac::Peripherals) -> Clocks {
        let rcc = &peripherals.RCC;
        if rcc.cr().read().bits() == 0 {
            return Clocks { source: ClockSource::Emulated, ..Self::CLOCKS };
        }
        rcc.apb1enr().modify(|_, w| w.tim3en().enabled());
        rcc.apb2enr().modify(|_, w| w.iopaen().enabled().iopben().enabled().usart1en().enabled());

        rcc.cr().modify(|_, w| w.hseon().on());
        let crystal = wait_until(|| rcc.cr().read().hserdy().is_ready());
        let source = if crystal { ClockSource::Crystal } else { ClockSource::Internal };
        rcc.cfgr().modify(|_, w| {
            if crystal {
                w.pllsrc().hse_div_prediv().pllmul().mul3()
            } else {
                w.pllsrc().hsi_div2().pllmul().mul6()
            }
        });
        rcc.cr().modify(|_, w| w.pllon().on());
        if !wait_until(|| rcc.cr().read().pllrdy().is_ready()) {
            return SLOW;
        }
        rcc.cfgr().modify(|_, w| w.sw().pll());
        if wait_until(|| rcc.cfgr().read().sws().is_pll()) { Clocks { source, ..Self::CLOCKS } } else { SLOW }
    }

    fn route_pins(peripherals: &pac::Peripherals) {
        let (a, b) = (&peripherals.GPIOA, &peripherals.GPIOB);
        a.crl()
            .modify(|_, w| w.cnf6().alt_push_pull().mode6().output().cnf7().alt_push_pull().mode7().output());
        // An open receive line must not look like data: input with a pull-up, which ODR chooses.
        a.odr().modify(|_, w| w.odr10().high());
        a.crh().modify(|_, w| {
            w.cnf9().alt_push_pull().mode9().output50().cnf10().alt_push_pull().mode10().input()
        });
        b.bsrr().write(|w| w.br12().reset().br13().reset().br14().reset());
        b.crh().modify(|_, w| {
            w.cnf12().push_pull().mode12().output();
            w.cnf13().push_pull().mode13().output().cnf14().push_pull().mode14().output()
        });
    }

    fn start_stopwatch(_: &pac::Peripherals, clocks: &Clocks) {
        crate::drivers::stopwatch::start_by_systick(clocks.core_hz);
    }

    /// By `SysTick`: the timers of this chip have 16 bits, and QEMU does not have them at all.
    fn micros() -> u32 {
        crate::drivers::stopwatch::by_systick()
    }
}

/// Nothing multiplied.
const SLOW: Clocks =
    Clocks { source: ClockSource::Slow, core_hz: INTERNAL_HZ, usart_hz: INTERNAL_HZ, timer_hz: INTERNAL_HZ };
