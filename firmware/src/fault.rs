//! When nothing works any more: motors first, then a word to the log, then stand still.
#![expect(
    unsafe_code,
    reason = "fault handlers are unsafe to define, and a count outlives resets outside of all sections"
)]

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m_rt::{ExceptionFrame, exception};
use firmware::drivers::{motors, stack};
use firmware::{emulator, log};

/// Starts of this board, as far as its RAM remembers: neither set nor cleared by the start-up code.
#[unsafe(link_section = ".uninit.STARTS")]
static STARTS: AtomicU32 = AtomicU32::new(0);

/// A number that differs from that of the last start.
pub fn epoch() -> u32 {
    let epoch = STARTS.load(Ordering::Relaxed).wrapping_add(1);
    STARTS.store(epoch, Ordering::Relaxed);
    epoch
}

/// Motors without power, and nothing more: an emulator ends with a failure, a board waits for its watchdog.
pub fn halt() -> ! {
    motors::stop();
    cortex_m::interrupt::disable();
    if log::is_to_file() {
        emulator::end(false);
    }
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    motors::stop();
    match info.location() {
        Some(at) => defmt::error!("panic at {=str}:{=u32}", at.file(), at.line()),
        None => defmt::error!("panic"),
    }
    halt();
}

/// A fault may be that of a stack that has grown out of the RAM: so the handler begins a new one.
#[unsafe(naked)]
#[unsafe(export_name = "HardFault")]
unsafe extern "C" fn hard_fault() -> ! {
    core::arch::naked_asm!(
        "mrs r0, msp",
        "ldr r1, =_stack_start",
        "msr msp, r1",
        "b {handler}",
        handler = sym fault,
    )
}

/// `frame` is where the core has put its registers, unless there was no room for them.
extern "C" fn fault(frame: *const ExceptionFrame) -> ! {
    motors::stop();
    if stack::holds(frame) {
        // SAFETY: within the stack, where the core has put it.
        let frame = unsafe { &*frame };
        defmt::error!("fault at {=u32:#010x}, called from {=u32:#010x}", frame.pc(), frame.lr());
    } else {
        defmt::error!("the stack has grown out of the RAM");
    }
    halt();
}

#[exception]
unsafe fn DefaultHandler(number: i16) {
    motors::stop();
    defmt::error!("interrupt {=i16} has no task", number);
    halt();
}
