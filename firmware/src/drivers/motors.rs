//! Two motors by sign and magnitude: pulse width, direction, and one line that enables the driver.
#![expect(unsafe_code, reason = "the motors must stop from anywhere, whoever owns the timer")]

use controller_core::units::WheelDrive;

use crate::board::{Clocks, PULSE_HZ, pac};

/// The motors, without power until the first [`Motors::drive`].
pub struct Motors {
    timer: pac::TIM3,
    /// Timer counts of one pulse.
    period: u16,
}

impl Motors {
    /// Starts the pulses, of no width.
    #[must_use]
    pub fn start(timer: pac::TIM3, clocks: &Clocks) -> Self {
        let period = u16::try_from(clocks.timer_hz / PULSE_HZ).unwrap_or(u16::MAX);
        // SAFETY: any period is valid; of the counter's 32 or 16 bits the lower 16 are used.
        timer.arr().write(|w| unsafe { w.bits(u32::from(period) - 1) });
        timer
            .ccmr1_output()
            .write(|w| w.oc1m().pwm_mode1().oc1pe().enabled().oc2m().pwm_mode1().oc2pe().enabled());
        timer.ccer().write(|w| w.cc1e().set_bit().cc2e().set_bit());
        timer.egr().write(|w| w.ug().update());
        timer.cr1().write(|w| w.cen().enabled());
        Self { timer, period }
    }

    /// Drives the motors, in ±1 of the supply; what is beyond is cut, and no number stops.
    pub fn drive(&mut self, drive: WheelDrive<f32>) {
        let width = |share: f32| {
            let counts = share.abs().min(1.0) * f32::from(self.period);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "within the period, which has 16 bits; a number that is none becomes 0"
            )]
            let counts = counts as u16;
            u32::from(counts)
        };
        let (left, right) = (width(drive.left), width(drive.right));
        // SAFETY: any width is valid.
        self.timer.ccr1().write(|w| unsafe { w.bits(left) });
        // SAFETY: likewise.
        self.timer.ccr2().write(|w| unsafe { w.bits(right) });
        // SAFETY: BSRR sets and clears single pins without reading; the others are not touched.
        let pins = unsafe { pac::GPIOB::steal() };
        pins.bsrr().write(|w| {
            let w = if drive.left < 0.0 { w.bs13().set_() } else { w.br13().reset() };
            let w = if drive.right < 0.0 { w.bs14().set_() } else { w.br14().reset() };
            w.bs12().set_()
        });
    }
}

/// Takes the power off both motors, from anywhere: a task, a panic, a fault.
pub fn stop() {
    // SAFETY: BSRR clears the one pin without reading; widths of 0 are valid. Whoever drives the motors at this moment
    // is preempted by the caller or is the caller, and what it writes afterwards the gate has let pass.
    let (pins, timer) = unsafe { (pac::GPIOB::steal(), pac::TIM3::steal()) };
    pins.bsrr().write(|w| w.br12().reset());
    // SAFETY: as above.
    timer.ccr1().write(|w| unsafe { w.bits(0) });
    // SAFETY: as above.
    timer.ccr2().write(|w| unsafe { w.bits(0) });
}
