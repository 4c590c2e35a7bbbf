//! The board as a process, for hosts without a board or an emulator: the controller core behind the serial protocol,
//! over a pseudo-terminal, TCP or stdio, with link faults on request and no physics.
//!
//! Exit codes: 0 the host has gone away, 2 wrong usage, 3 the link cannot be opened or broke.
#![forbid(unsafe_code)]

use core::ops::RangeInclusive;
use core::str::FromStr;
use std::process::ExitCode;

use clap::{Args, Parser, ValueEnum};
use hil_stub::board::{Stub, StubOptions};
use hil_stub::faults::LinkFaults;
use protocol::message::{Board, ScalarKind};

const EXAMPLES: &str = "\
Examples:
  hil_stub --pty                      prints the path of a serial port, say /dev/pts/3, and is the board behind it;
                                      then, elsewhere: host_sim run p2_fig6 --link pty:/dev/pts/3
  hil_stub --tcp 127.0.0.1:0          prints the address with the port it was given; host_sim … --link tcp:ADDRESS
  hil_stub --stdio                    frames on standard input and output
  hil_stub --pty --loss 0.01 --corruption 0.01 --delay-ms 1..20 --fault-seed 7
  hil_stub --pty --reset-after 5000   a board that is reset in mid-run

Exit codes: 0 the host has gone away; 2 wrong usage; 3 the link cannot be opened, or broke.";

/// Is a board as far as the serial link can tell: the controller, the protocol, no physics and no motors.
///
/// State is kept while hosts come and go; only a reset, or a new start, loses it.
#[derive(Debug, Parser)]
#[command(name = "hil_stub", version, after_help = EXAMPLES)]
struct Cli {
    #[command(flatten)]
    link: Link,
    /// The board to be
    #[arg(long, value_enum, default_value_t = BoardArg::Stub)]
    board: BoardArg,
    /// Arithmetic of the controller
    #[arg(long, value_enum, default_value_t = ScalarArg::F32)]
    scalar: ScalarArg,
    /// With --tcp: end when the first host has gone away, instead of waiting for the next
    #[arg(long, conflicts_with_all = ["pty", "stdio"])]
    once: bool,
    #[command(flatten)]
    faults: Faults,
}

#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
struct Link {
    /// Make a pseudo-terminal and print its path
    #[arg(long)]
    pty: bool,
    /// Listen on this address and print it; port 0 takes any that is free
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
    /// Use standard input and output
    #[arg(long)]
    stdio: bool,
}

#[derive(Debug, Args)]
struct Faults {
    /// Seed of everything that goes wrong
    #[arg(long, value_name = "N", default_value_t = 1)]
    fault_seed: u64,
    /// Share of the frames that are lost, in each direction
    #[arg(long, value_name = "0..1", default_value_t = 0.0, value_parser = share)]
    loss: f64,
    /// Share of the frames in which one bit flips, in each direction
    #[arg(long, value_name = "0..1", default_value_t = 0.0, value_parser = share)]
    corruption: f64,
    /// How late frames come, in each direction, in ms: one number, or a range to draw from
    #[arg(long, value_name = "A..B", default_value = "0", value_parser = delay)]
    delay_ms: RangeInclusive<u32>,
    /// Reset the board, once, at the N-th frame from the host
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    reset_after: Option<u64>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum BoardArg {
    /// What it is
    Stub,
    /// Olimex STM32-H405 and its like
    Stm32f405,
    /// STM32VLDISCOVERY
    Stm32f100,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum ScalarArg {
    /// 32-bit floating point
    F32,
    /// 32-bit fixed point with 16-bit weights
    Fixed,
}

fn share(text: &str) -> Result<f64, String> {
    let share = f64::from_str(text).map_err(|error| error.to_string())?;
    if (0.0..=1.0).contains(&share) { Ok(share) } else { Err(String::from("must lie between 0 and 1")) }
}

/// Longest delay; more than a minute is a mistake.
const DELAY_MS_MAX: u32 = 60_000;

fn delay(text: &str) -> Result<RangeInclusive<u32>, String> {
    let (from, to) = text.split_once("..").unwrap_or((text, text));
    let number = |text: &str| u32::from_str(text.trim_start_matches('=').trim());
    match (number(from), number(to)) {
        (Ok(from), Ok(to)) if from <= to && to <= DELAY_MS_MAX => Ok(from..=to),
        _ => Err(format!("must be milliseconds up to {DELAY_MS_MAX}, as `20` or as a range, `5..20`")),
    }
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help on stdout, errors on stderr; neither can be reported if it cannot be printed.
            let _ = error.print();
            return if error.use_stderr() { ExitCode::from(2) } else { ExitCode::SUCCESS };
        }
    };
    match run(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(3)
        }
    }
}

fn options(cli: &Cli) -> StubOptions {
    StubOptions {
        board: match cli.board {
            BoardArg::Stub => Board::Stub,
            BoardArg::Stm32f405 => Board::Stm32f405,
            BoardArg::Stm32f100 => Board::Stm32f100,
        },
        scalar: match cli.scalar {
            ScalarArg::F32 => ScalarKind::F32,
            ScalarArg::Fixed => ScalarKind::Fixed,
        },
        // Differs from that of the last process, so that a host notices that this is another.
        epoch: std::process::id(),
        faults: LinkFaults {
            seed: cli.faults.fault_seed,
            loss: cli.faults.loss,
            corruption: cli.faults.corruption,
            delay_ms: cli.faults.delay_ms.clone(),
            reset_after: cli.faults.reset_after,
        },
    }
}

#[cfg(unix)]
fn run(cli: &Cli) -> Result<(), String> {
    use hil_stub::serve::{Pty, serve_stdio, serve_tcp};
    use std::io::Write;
    use std::net::TcpListener;

    let mut stub = Stub::new(options(cli)).map_err(|error| error.to_string())?;
    // Flushed, for whoever reads it through a pipe and waits for it.
    let say = |line: &str| {
        let mut stdout = std::io::stdout().lock();
        writeln!(stdout, "{line}")
            .and_then(|()| stdout.flush())
            .map_err(|error| format!("cannot write to the standard output ({error}); check where it goes"))
    };
    if cli.link.pty {
        let pty = Pty::open().map_err(|error| {
            format!("no pseudo-terminal can be opened ({error}); use --tcp instead, or close some programs")
        })?;
        say(pty.path())?;
        return pty.serve(&mut stub).map_err(|error| format!("{} broke ({error}); start again", pty.path()));
    }
    let Some(address) = &cli.link.tcp else {
        return serve_stdio(&mut stub)
            .map_err(|error| format!("standard input or output broke ({error}); start again"));
    };
    let bound = TcpListener::bind(address).and_then(|listener| Ok((listener.local_addr()?, listener)));
    let (local, listener) = bound.map_err(|error| {
        format!("cannot listen on `{address}` ({error}); give an address of this machine as HOST:PORT, port 0 for any")
    })?;
    say(&local.to_string())?;
    let left = || eprintln!("the host has gone away{}", if cli.once { "" } else { "; waiting for the next" });
    serve_tcp(&mut stub, &listener, cli.once, left)
        .map_err(|error| format!("{local} broke ({error}); start again"))
}

#[cfg(not(unix))]
fn run(cli: &Cli) -> Result<(), String> {
    Stub::new(options(cli)).map_err(|error| error.to_string())?;
    Err(String::from("pseudo-terminals and polling need a Unix; use host_sim's own `--link stub` here"))
}
