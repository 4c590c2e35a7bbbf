//! What was asked for on the command line.

use std::path::PathBuf;

use crate::firmware::{BOARDS, Board};

const HELP: &str = "\
cargo xtask: checks this repository, builds its firmware, and says what it needs.

Usage: cargo xtask <COMMAND> [OPTIONS]

Commands:
  test     Everything that CI checks: tools, format, tidiness, clippy, docs, embedded builds, tests
  doctor   What is present, what is missing, and how to get it; changes nothing
  firmware Build the images for the boards
  flash    Put the image on a board behind a debug probe, and show its log
  pil      Run the firmware in the emulator against the simulator, bit for bit
  budget   Flash, RAM, stack and instructions of the firmware, against their limits

Options:
  -h, --help   This text; after a command, that command's

Exit codes: 0 all passed, 1 something failed or is missing, 2 wrong usage.
";

const HELP_TEST: &str = "\
Runs everything that CI checks and ends with a table. All steps run, whatever fails before them.

Usage: cargo xtask test [--quick]

Steps:
  doctor     clippy, rustfmt, the embedded targets and QEMU; what is missing is installed where that needs no question
  format     cargo fmt --check
  tidy       the repository's own rules: line length, leftovers, licences, links
  clippy     no warning, on the host and for the boards
  docs       no warning in the documentation
  embedded   controller_core with every set of features, protocol and firmware, for both boards
  tests      all tests and doctests on the host
  budget     flash, RAM, stack and instructions of the firmware
  pil        the firmware in the emulator
  unchanged  in CI only (CI is set): the run changed no file under version control

Options:
  --quick      Leave out docs, embedded and the boards' clippy: for use while editing, not before a commit
  -h, --help   This text
";

const HELP_FIRMWARE: &str = "\
Builds the firmware and says where the images are and what they take.

Usage: cargo xtask firmware [BOARD [--map FILE]]

  BOARD        stm32f405 or stm32f100; both, if none is named

Options:
  --map FILE   Put this learned map into the image; without it the board knows nothing until it learns or is given one.
               For stm32f100 train it with --scalar fixed. A map that does not fit is refused
  -h, --help   This text
";

const HELP_FLASH: &str = "\
Builds the firmware, puts it on a board that is connected through a debug probe, and shows its log (probe-rs).

Usage: cargo xtask flash <BOARD> [--map FILE]

  BOARD        stm32f405 or stm32f100

Options:
  --map FILE   Put this learned map into the image, as for `cargo xtask firmware`
  -h, --help   This text
";

const HELP_PIL: &str = "\
Builds the firmware and runs it in QEMU against the simulator: whole missions, tick by tick the same bits as in the
simulator alone, over both ways of the link, and in real time.

Usage: cargo xtask pil [--long]

Options:
  --long       Also what takes minutes: learning on the emulated board
  -h, --help   This text
";

const HELP_BUDGET: &str = "\
Measures flash, RAM, stack and instructions of the firmware, and compares them with firmware/budgets.toml.

Usage: cargo xtask budget

Options:
  -h, --help   This text
";

const HELP_DOCTOR: &str = "\
Says what is present, what is missing, and how to get it. Changes nothing; `cargo xtask test` asks rustup itself.

Usage: cargo xtask doctor

Options:
  -h, --help   This text

Exit codes: 0 all present, 1 something is missing.
";

/// What to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Asked {
    /// Print this.
    Help(&'static str),
    /// Check everything, or with `quick` what is quick.
    Test {
        /// Leave out what takes long.
        quick: bool,
    },
    /// Say what is missing.
    Doctor,
    /// Build the firmware, of all boards or of one.
    Firmware {
        /// Which one.
        board: Option<Board>,
        /// A learned map for its image.
        map: Option<PathBuf>,
    },
    /// Put the firmware on a board.
    Flash {
        /// Which.
        board: Board,
        /// A learned map for its image.
        map: Option<PathBuf>,
    },
    /// Run the firmware's tests in the emulator.
    Pil {
        /// Also those that take minutes.
        long: bool,
    },
    /// Compare what the firmware takes with its limits.
    Budget,
}

/// Reads the arguments after the program's name; an error is a sentence that says what to type instead.
pub fn parse(arguments: &[String]) -> Result<Asked, String> {
    let mut words = arguments.iter().map(String::as_str);
    let command = words.next().ok_or("no command: try `cargo xtask test`, or `cargo xtask --help`")?;
    let rest: Vec<&str> = words.collect();
    let help = match command {
        "test" => HELP_TEST,
        "doctor" => HELP_DOCTOR,
        "firmware" => HELP_FIRMWARE,
        "flash" => HELP_FLASH,
        "pil" => HELP_PIL,
        "budget" => HELP_BUDGET,
        "help" | "--help" | "-h" => return Ok(Asked::Help(HELP)),
        option if option.starts_with('-') => {
            return Err(format!("unknown option `{option}`: see `cargo xtask --help`"));
        }
        other => {
            return Err(format!(
                "unknown command `{other}`: there are `test`, `doctor`, `firmware`, `flash`, `pil` and `budget`"
            ));
        }
    };
    if rest.iter().any(|word| matches!(*word, "--help" | "-h")) {
        return Ok(Asked::Help(help));
    }
    let unknown = |word: &str| {
        let kind = if word.starts_with('-') { "option" } else { "argument" };
        format!("unknown {kind} `{word}` of `{command}`: see `cargo xtask {command} --help`")
    };
    let board = |name: &str| {
        let boards = BOARDS.map(|board| format!("`{}`", board.name)).join(" and ");
        Board::named(name).ok_or_else(|| format!("unknown board `{name}`: there are {boards}"))
    };
    match (command, &rest[..]) {
        ("test", []) => Ok(Asked::Test { quick: false }),
        ("test", ["--quick"]) => Ok(Asked::Test { quick: true }),
        ("doctor", []) => Ok(Asked::Doctor),
        ("firmware" | "flash", [.., "--map"]) => {
            Err(format!("`--map` needs a file: see `cargo xtask {command} --help`"))
        }
        ("firmware", ["--map", _, ..]) => Err(
            "`--map` needs a board, since a map is learned for one number type: `firmware BOARD --map FILE`"
                .to_owned(),
        ),
        ("firmware", []) => Ok(Asked::Firmware { board: None, map: None }),
        ("firmware", [name]) if !name.starts_with('-') => {
            Ok(Asked::Firmware { board: Some(board(name)?), map: None })
        }
        ("firmware", [name, "--map", file]) => {
            Ok(Asked::Firmware { board: Some(board(name)?), map: Some(file.into()) })
        }
        ("flash", [name]) if !name.starts_with('-') => Ok(Asked::Flash { board: board(name)?, map: None }),
        ("flash", [name, "--map", file]) => Ok(Asked::Flash { board: board(name)?, map: Some(file.into()) }),
        ("flash", []) => Err("`flash` needs a board: see `cargo xtask flash --help`".to_owned()),
        ("pil", []) => Ok(Asked::Pil { long: false }),
        ("pil", ["--long"]) => Ok(Asked::Pil { long: true }),
        ("budget", []) => Ok(Asked::Budget),
        ("test", ["--quick", word, ..])
        | ("pil", ["--long", word, ..])
        | ("firmware" | "flash", [_, "--map", _, word, ..] | [_, word, ..])
        | (_, [word, ..]) => Err(unknown(word)),
        (_, []) => Err(format!("see `cargo xtask {command} --help`")),
    }
}

#[cfg(test)]
mod tests {
    use super::{Asked, HELP, HELP_DOCTOR, HELP_TEST, parse};
    use crate::firmware::Board;

    fn parsed(line: &str) -> Result<Asked, String> {
        parse(&line.split_whitespace().map(String::from).collect::<Vec<_>>())
    }

    #[test]
    fn commands_and_options_are_understood() {
        assert_eq!(parsed("test"), Ok(Asked::Test { quick: false }));
        assert_eq!(parsed("test --quick"), Ok(Asked::Test { quick: true }));
        assert_eq!(parsed("doctor"), Ok(Asked::Doctor));
        assert_eq!(parsed("--help"), Ok(Asked::Help(HELP)));
        assert_eq!(parsed("test --quick --help"), Ok(Asked::Help(HELP_TEST)));
        assert_eq!(parsed("doctor -h"), Ok(Asked::Help(HELP_DOCTOR)));
        let board = Board::named("stm32f100");
        assert_eq!(parsed("firmware"), Ok(Asked::Firmware { board: None, map: None }));
        assert_eq!(parsed("firmware stm32f100"), Ok(Asked::Firmware { board, map: None }));
        let map = Some("out/map.ekm".into());
        let with_map = Asked::Firmware { board, map: map.clone() };
        assert_eq!(parsed("firmware stm32f100 --map out/map.ekm"), Ok(with_map));
        let board = board.unwrap();
        assert_eq!(parsed("flash stm32f100"), Ok(Asked::Flash { board, map: None }));
        assert_eq!(parsed("flash stm32f100 --map out/map.ekm"), Ok(Asked::Flash { board, map }));
        assert_eq!(parsed("pil --long"), Ok(Asked::Pil { long: true }));
        assert_eq!(parsed("budget"), Ok(Asked::Budget));
    }

    #[test]
    fn what_is_not_understood_is_named() {
        for (line, named) in [
            ("", "no command"),
            ("tset", "unknown command `tset`"),
            ("--fast", "unknown option `--fast`"),
            ("test --fast", "unknown option `--fast` of `test`"),
            ("test quick", "unknown argument `quick` of `test`"),
            ("doctor --quick", "unknown option `--quick` of `doctor`"),
            ("firmware stm32", "unknown board `stm32`: there are `stm32f405` and `stm32f100`"),
            ("firmware stm32f405 x", "unknown argument `x` of `firmware`"),
            ("firmware --map map.ekm", "`--map` needs a board"),
            ("firmware stm32f405 --map", "`--map` needs a file"),
            ("firmware stm32f405 --map a.ekm b.ekm", "unknown argument `b.ekm` of `firmware`"),
            ("flash", "`flash` needs a board"),
            ("pil --quick", "unknown option `--quick` of `pil`"),
        ] {
            let message = parsed(line).unwrap_err();
            assert!(message.contains(named), "{line}: {message}");
        }
    }
}
