//! The board as a process, for hosts without a board or an emulator: the controller core behind the serial protocol,
//! over a pseudo-terminal, TCP or stdio, with link faults on request and no physics.
//!
//! Not built yet: it needs the frames of the link, which come with the firmware. Until then it says so and fails, so
//! that no script takes its silence for a board.

use std::process::ExitCode;

/// "Used wrongly", like a command-line error: there is nothing here to use.
const NOT_BUILT_YET: u8 = 2;

fn main() -> ExitCode {
    eprintln!(
        "hil_stub will be the board as far as the link can tell: the controller core behind the serial protocol,\n\
         over a pseudo-terminal, TCP or stdio, with delay, loss and corruption on request.\n\
         It is not built yet; ARCHITECTURE.md says where it belongs. To run the controller today, use the simulator:\n\
         cargo run --release"
    );
    ExitCode::from(NOT_BUILT_YET)
}
