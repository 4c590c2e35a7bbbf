//! STM32F405RG: Cortex-M4F with a single-precision FPU. Numbers from the datasheet (DS8626) and RM0090.
//!
//! Boards: Olimex STM32-H405, Feather STM32F405 (with another crystal); in QEMU `netduinoplus2`.

use super::{Board, ClockSource, Clocks, PULSE_HZ, Tick, WATCHDOG_MS, pac, wait_until};

/// The board.
pub struct Stm32f405;

/// Crystal of the Olimex board; the Feather's has 12 MHz, and a [`CRYSTAL_DIVIDER`] of 12.
pub const CRYSTAL_HZ: u32 = 8_000_000;

/// The chip's own oscillator.
const INTERNAL_HZ: u32 = 16_000_000;

/// PLL M: oscillator to the input of the PLL.
pub const CRYSTAL_DIVIDER: u8 = 8;
const INTERNAL_DIVIDER: u8 = 16;

const PLL_INPUT_HZ: u32 = CRYSTAL_HZ / CRYSTAL_DIVIDER as u32;

/// PLL N: PLL input to oscillator.
const PLL_FACTOR: u16 = 336;

/// PLL P: oscillator to core.
const PLL_DIVIDER: u32 = 2;

/// PLL Q: oscillator to USB, which is not used but wants its 48 MHz.
const PLL_DIVIDER_USB: u8 = 7;

const OSCILLATOR_HZ: u32 = PLL_INPUT_HZ * PLL_FACTOR as u32;
const CORE_HZ: u32 = OSCILLATOR_HZ / PLL_DIVIDER;

/// Core to APB1 (TIM2, TIM3, whose clock is twice its) and to APB2 (USART1).
const APB1_DIVIDER: u32 = 4;
const APB2_DIVIDER: u32 = 2;

/// Wait states of the flash at [`CORE_HZ`] and 2.7 V or more.
const FLASH_WAIT_STATES: u8 = 5;

/// Low-speed oscillator of the watchdog, nominal; 17 to 47 kHz.
const WATCHDOG_HZ: u32 = 32_000;
/// `IWDG_PR` 3.
const WATCHDOG_DIVIDER: u32 = 32;

/// QEMU counts its timers at 1 GHz whatever the clocks are set to.
const EMULATED_TIMER_HZ: u32 = 1_000_000_000;

const _: () = {
    // RM0090, RCC_PLLCFGR: M 2 to 63, PLL input 1 to 2 MHz, N 50 to 432, oscillator 100 to 432 MHz; DS8626: core up
    // to 168 MHz, APB1 up to 42 MHz, APB2 up to 84 MHz.
    assert!(CRYSTAL_DIVIDER >= 2 && CRYSTAL_DIVIDER <= 63 && PLL_FACTOR >= 50 && PLL_FACTOR <= 432);
    assert!(PLL_INPUT_HZ * CRYSTAL_DIVIDER as u32 == CRYSTAL_HZ);
    assert!(PLL_INPUT_HZ * INTERNAL_DIVIDER as u32 == INTERNAL_HZ);
    assert!(PLL_INPUT_HZ >= 1_000_000 && PLL_INPUT_HZ <= 2_000_000);
    assert!(OSCILLATOR_HZ >= 100_000_000 && OSCILLATOR_HZ <= 432_000_000);
    assert!(OSCILLATOR_HZ == 48_000_000 * PLL_DIVIDER_USB as u32);
    assert!(
        CORE_HZ <= 168_000_000
            && CORE_HZ / APB1_DIVIDER <= 42_000_000
            && CORE_HZ / APB2_DIVIDER <= 84_000_000
    );
    let clocks = Stm32f405::CLOCKS;
    // The servo's period is a whole number of clocks, and so are a bit of the link and a pulse of the motors.
    assert!(clocks.core_hz.is_multiple_of(1000));
    assert!(clocks.usart_hz.is_multiple_of(Stm32f405::BAUD) && INTERNAL_HZ.is_multiple_of(Stm32f405::BAUD));
    // USART: 16 samples for each bit.
    assert!(clocks.usart_hz / Stm32f405::BAUD >= 16 && INTERNAL_HZ / Stm32f405::BAUD >= 16);
    assert!(clocks.timer_hz.is_multiple_of(PULSE_HZ) && clocks.timer_hz / PULSE_HZ <= 0xffff);
};

impl Board for Stm32f405 {
    /// The FPU does `f32` in hardware.
    type Real = f32;

    const ID: protocol::message::Board = protocol::message::Board::Stm32f405;
    const FLASH_BYTES: u32 = 1024 * 1024;
    const RAM_BYTES: u32 = (112 + 16) * 1024;
    const CLOCKS: Clocks = Clocks {
        source: ClockSource::Crystal,
        core_hz: CORE_HZ,
        usart_hz: CORE_HZ / APB2_DIVIDER,
        timer_hz: CORE_HZ / APB1_DIVIDER * 2,
    };
    /// 100 bytes in a millisecond: readings in, outputs out, with as much to spare.
    const BAUD: u32 = 1_000_000;
    const REPORT_MS: Tick = 1;
    const WATCHDOG: (u8, u16) = {
        let count = WATCHDOG_HZ / WATCHDOG_DIVIDER * WATCHDOG_MS / 1000;
        assert!(count <= 0xfff);
        #[expect(clippy::cast_possible_truncation, reason = "asserted above")]
        (3, count as u16)
    };

    fn start_clocks(peripherals: &pac::Peripherals) -> Clocks {
        let (rcc, flash) = (&peripherals.RCC, &peripherals.FLASH);
        if rcc.cr().read().bits() == 0 {
            return Clocks { source: ClockSource::Emulated, ..Self::CLOCKS };
        }
        rcc.ahb1enr().modify(|_, w| w.gpioaen().enabled().gpioben().enabled());
        rcc.apb1enr().modify(|_, w| w.tim2en().enabled().tim3en().enabled());
        rcc.apb2enr().modify(|_, w| w.usart1en().enabled());

        rcc.cr().modify(|_, w| w.hseon().on());
        let crystal = wait_until(|| rcc.cr().read().hserdy().is_ready());
        let (divider, source) = if crystal {
            (CRYSTAL_DIVIDER, ClockSource::Crystal)
        } else {
            (INTERNAL_DIVIDER, ClockSource::Internal)
        };
        rcc.pllcfgr().modify(|_, w| {
            let w = if crystal { w.pllsrc().hse() } else { w.pllsrc().hsi() };
            // SAFETY: the ranges of the manual, asserted above.
            #[expect(unsafe_code, reason = "the factors are plain numbers to the register crate")]
            unsafe {
                w.pllm().bits(divider).plln().bits(PLL_FACTOR).pllq().bits(PLL_DIVIDER_USB)
            };
            w.pllp().div2()
        });
        rcc.cr().modify(|_, w| w.pllon().on());
        if !wait_until(|| rcc.cr().read().pllrdy().is_ready()) {
            return SLOW;
        }
        // Before the core gets faster than the flash.
        flash.acr().modify(|_, w| {
            w.latency().set(FLASH_WAIT_STATES).prften().enabled().icen().enabled().dcen().enabled()
        });
        rcc.cfgr().modify(|_, w| w.ppre1().div4().ppre2().div2());
        rcc.cfgr().modify(|_, w| w.sw().pll());
        if wait_until(|| rcc.cfgr().read().sws().is_pll()) { Clocks { source, ..Self::CLOCKS } } else { SLOW }
    }

    fn route_pins(peripherals: &pac::Peripherals) {
        let (a, b) = (&peripherals.GPIOA, &peripherals.GPIOB);
        // Alternate functions: TIM3 is number 2, USART1 number 7 (DS8626, table 9).
        a.afrl().modify(|_, w| w.afrl6().af2().afrl7().af2());
        a.afrh().modify(|_, w| w.afrh9().af7().afrh10().af7());
        // An open receive line must not look like data.
        a.pupdr().modify(|_, w| w.pupdr10().pull_up());
        a.moder().modify(|_, w| {
            w.moder6().alternate().moder7().alternate().moder9().alternate().moder10().alternate()
        });
        b.bsrr().write(|w| w.br12().reset().br13().reset().br14().reset());
        b.moder().modify(|_, w| w.moder12().output().moder13().output().moder14().output());
    }

    fn start_stopwatch(peripherals: &pac::Peripherals, clocks: &Clocks) {
        let timer_hz = if clocks.is_emulated() { EMULATED_TIMER_HZ } else { clocks.timer_hz };
        let prescaler = u16::try_from(timer_hz / 1_000_000 - 1).unwrap_or(u16::MAX);
        let timer = &peripherals.TIM2;
        timer.psc().write(|w| w.psc().set(prescaler));
        timer.arr().write(|w| w.arr().set(u32::MAX));
        // The prescaler acts from the next update.
        timer.egr().write(|w| w.ug().update());
        timer.cr1().write(|w| w.cen().enabled());
    }

    fn micros() -> u32 {
        crate::drivers::stopwatch::tim2()
    }
}

/// Nothing multiplied: the internal oscillator everywhere, no divider set.
const SLOW: Clocks =
    Clocks { source: ClockSource::Slow, core_hz: INTERNAL_HZ, usart_hz: INTERNAL_HZ, timer_hz: INTERNAL_HZ };
