//! What was asked for on the command line.

const HELP: &str = "\
cargo xtask: checks this repository and says what it needs.

Usage: cargo xtask <COMMAND> [OPTIONS]

Commands:
  test     Everything that CI checks: tools, format, tidiness, clippy, docs, embedded builds, tests
  doctor   What is present, what is missing, and how to get it; changes nothing

Options:
  -h, --help   This text; after a command, that command's

Exit codes: 0 all passed, 1 something failed or is missing, 2 wrong usage.
";

const HELP_TEST: &str = "\
Runs everything that CI checks and ends with a table. All steps run, whatever fails before them.

Usage: cargo xtask test [--quick]

Steps:
  doctor     clippy, rustfmt and the embedded targets; what is missing is asked from rustup
  format     cargo fmt --check
  tidy       the repository's own rules: line length, leftovers, licences, links
  clippy     no warning, on the host and for the boards
  docs       no warning in the documentation
  embedded   controller_core with every set of features, protocol and firmware, for both boards
  tests      all tests and doctests on the host
  unchanged  in CI only (CI is set): the run changed no file under version control

Options:
  --quick      Leave out docs, embedded and the boards' clippy: for use while editing, not before a commit
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
}

/// Reads the arguments after the program's name; an error is a sentence that says what to type instead.
pub fn parse(arguments: &[String]) -> Result<Asked, String> {
    let mut words = arguments.iter().map(String::as_str);
    let command = words.next().ok_or("no command: try `cargo xtask test`, or `cargo xtask --help`")?;
    let (mut asked, help) = match command {
        "test" => (Asked::Test { quick: false }, HELP_TEST),
        "doctor" => (Asked::Doctor, HELP_DOCTOR),
        "help" | "--help" | "-h" => (Asked::Help(HELP), HELP),
        option if option.starts_with('-') => {
            return Err(format!("unknown option `{option}`: see `cargo xtask --help`"));
        }
        other => return Err(format!("unknown command `{other}`: there are `test` and `doctor`")),
    };
    for word in words {
        asked = match (word, asked) {
            ("--help" | "-h", _) => return Ok(Asked::Help(help)),
            ("--quick", Asked::Test { .. }) => Asked::Test { quick: true },
            _ => {
                let kind = if word.starts_with('-') { "option" } else { "argument" };
                return Err(format!(
                    "unknown {kind} `{word}` of `{command}`: see `cargo xtask {command} --help`"
                ));
            }
        };
    }
    Ok(asked)
}

#[cfg(test)]
mod tests {
    use super::{Asked, HELP, HELP_DOCTOR, HELP_TEST, parse};

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
        ] {
            let message = parsed(line).unwrap_err();
            assert!(message.contains(named), "{line}: {message}");
        }
    }
}
