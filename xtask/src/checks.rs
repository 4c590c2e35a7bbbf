//! `cargo xtask test`: everything that CI checks, step by step, with a table at the end.
//!
//! A failed step does not keep the others from running: the table shows all that is wrong at once.
//!
//! `firmware` is left out of what is built for the host, and checked for its targets instead: that is where it will
//! run, its log macros need a linker script, and with it in the selection cargo would unify its features into
//! everything else's builds.

use std::env;
use std::ffi::OsString;
use std::path::Path;
use std::time::Instant;

use crate::budget;
use crate::command;
use crate::doctor::{self, TARGETS};
use crate::firmware::{self, BOARDS};
use crate::pil;
use crate::tidy;

/// What is built for the host; the same selection each time, so that features and with them builds are shared.
const ON_HOST: [&str; 3] = ["--workspace", "--exclude", "firmware"];

/// The features of `controller_core`: none, each alone, all.
const CORE_FEATURES: [&str; 5] = ["", "serde", "schema", "defmt", "serde,schema,defmt"];

struct Context<'a> {
    root: &'a Path,
    quick: bool,
    in_ci: bool,
}

struct Step {
    name: &'static str,
    run: fn(&Context) -> Outcome,
}

/// How a step ended.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Outcome {
    Passed,
    Failed(String),
    LeftOut(&'static str),
}

impl From<Result<(), String>> for Outcome {
    fn from(result: Result<(), String>) -> Self {
        match result {
            Ok(()) => Self::Passed,
            Err(message) => Self::Failed(message),
        }
    }
}

/// Quick and telling first.
const STEPS: [Step; 10] = [
    Step { name: "doctor", run: |context| doctor::provide(context.root).into() },
    Step { name: "format", run: |context| context.cargo(&["fmt", "--all", "--check"]).into() },
    Step { name: "tidy", run: |context| tidy_files(context.root).into() },
    Step { name: "clippy", run: |context| clippy(context).into() },
    Step { name: "docs", run: |context| context.unless_quick(docs) },
    Step { name: "embedded", run: |context| context.unless_quick(embedded) },
    Step { name: "tests", run: |context| tests(context).into() },
    Step { name: "budget", run: |context| context.unless_quick(|context| budget::run(context.root)) },
    Step { name: "pil", run: |context| context.unless_quick(|context| pil::run(context.root, false)) },
    Step { name: "unchanged", run: unchanged },
];

/// Runs all steps; whether none failed.
pub fn run(root: &Path, quick: bool) -> bool {
    let context = Context { root, quick, in_ci: env::var_os("CI").is_some() };
    let mut results = Vec::new();
    for (number, step) in (1..).zip(&STEPS) {
        println!("\n==== {number}/{} {} ====", STEPS.len(), step.name);
        let start = Instant::now();
        let outcome = (step.run)(&context);
        match &outcome {
            Outcome::Passed => {}
            Outcome::Failed(message) => println!("FAILED: {message}"),
            Outcome::LeftOut(reason) => println!("left out: {reason}"),
        }
        results.push((step.name, outcome, start.elapsed().as_secs_f64()));
    }
    print!("\n{}", table(&results));
    !results.iter().any(|(_, outcome, _)| matches!(outcome, Outcome::Failed(_)))
}

/// Step, result, seconds; then what failed.
fn table(results: &[(&str, Outcome, f64)]) -> String {
    let mut text = format!("{:<10} {:<8} {:>8}\n", "step", "result", "seconds");
    for (name, outcome, seconds) in results {
        let result = match outcome {
            Outcome::Passed => "passed",
            Outcome::Failed(_) => "FAILED",
            Outcome::LeftOut(_) => "left out",
        };
        text += &format!("{name:<10} {result:<8} {seconds:>8.1}\n");
    }
    let total: f64 = results.iter().map(|(_, _, seconds)| seconds).sum();
    text += &format!("{:<10} {:<8} {total:>8.1}\n", "total", "");
    for (name, outcome, _) in results {
        if let Outcome::Failed(message) = outcome {
            text += &format!("\n{name}: {message}\n");
        }
    }
    text
}

impl Context<'_> {
    fn cargo(&self, arguments: &[&str]) -> Result<(), String> {
        command::run(self.root, &command::cargo(), arguments, &[])
    }

    fn unless_quick(&self, check: fn(&Self) -> Result<(), String>) -> Outcome {
        if self.quick { Outcome::LeftOut("--quick") } else { check(self).into() }
    }
}

/// `--target` for each board.
fn for_boards() -> [&'static str; 4] {
    ["--target", TARGETS[0], "--target", TARGETS[1]]
}

/// Fails with the remedy before cargo fails with E0463.
fn need_targets() -> Result<(), String> {
    let missing = doctor::missing_targets();
    if missing.is_empty() { Ok(()) } else { Err(missing.join("\n")) }
}

fn tidy_files(root: &Path) -> Result<(), String> {
    let problems = tidy::check(root).map_err(|error| format!("the repository could not be read: {error}"))?;
    for problem in &problems {
        println!("{problem}");
    }
    match problems.len() {
        0 => Ok(()),
        count => Err(format!("{count} problem(s) in the repository's files, listed in this step")),
    }
}

fn clippy(context: &Context) -> Result<(), String> {
    let strict = ["--", "-D", "warnings"];
    context.cargo(&[&["clippy"][..], &ON_HOST, &["--all-targets"], &strict].concat())?;
    if context.quick {
        println!("left out with --quick: clippy for the boards");
        return Ok(());
    }
    need_targets()?;
    // Its profile, so that what is checked is built again by nobody.
    context
        .cargo(&[&["clippy", "--profile", "firmware", "-p", "firmware"][..], &for_boards(), &strict].concat())
}

fn docs(context: &Context) -> Result<(), String> {
    let document = |arguments: &[&str]| {
        let strict = [("RUSTDOCFLAGS", "-Dwarnings")];
        command::run(context.root, &command::cargo(), &[&["doc", "--no-deps"], arguments].concat(), &strict)
    };
    document(&ON_HOST)?;
    need_targets()?;
    document(&["-p", "firmware", "--target", TARGETS[0]])
}

/// One package at a time: together cargo would unify their features and hide what is missing in one of them.
fn embedded(context: &Context) -> Result<(), String> {
    need_targets()?;
    let build =
        |package: &[&str]| context.cargo(&[&["build", "--release"][..], package, &for_boards()].concat());
    for features in CORE_FEATURES {
        build(&["-p", "controller_core", "--no-default-features", "--features", features])?;
    }
    build(&["-p", "protocol"])?;
    firmware::build_and_tell(context.root, &BOARDS, None)
}

fn tests(context: &Context) -> Result<(), String> {
    context.cargo(&[&["test", "--no-fail-fast"][..], &ON_HOST].concat())
}

/// Catches a lockfile that cargo had to bring up to date, and tests that write into the source tree.
fn unchanged(context: &Context) -> Outcome {
    if !context.in_ci {
        return Outcome::LeftOut("CI is not set: files may be in the middle of a change");
    }
    let git = OsString::from("git");
    let arguments = ["diff", "--exit-code", "--stat"];
    command::run(context.root, &git, &arguments, &[("GIT_PAGER", "cat")])
        .map_err(|message| {
            format!("{message}: the run changed the files listed above; commit what it made of them")
        })
        .into()
}

#[cfg(test)]
mod tests {
    use super::{Outcome, STEPS, table};

    #[test]
    fn the_table_tells_what_failed_and_why() {
        let results = [
            ("format", Outcome::Passed, 1.26),
            ("docs", Outcome::LeftOut("--quick"), 0.0),
            ("tests", Outcome::Failed("`cargo test` failed".to_owned()), 61.0),
        ];
        let expected = "\
step       result    seconds
format     passed        1.3
docs       left out      0.0
tests      FAILED       61.0
total                   62.3

tests: `cargo test` failed
";
        assert_eq!(table(&results), expected);
    }

    #[test]
    fn every_step_is_in_the_help() {
        let Ok(crate::cli::Asked::Help(help)) = crate::cli::parse(&["test".into(), "--help".into()]) else {
            panic!("no help");
        };
        for step in &STEPS {
            assert!(help.contains(&format!("\n  {} ", step.name)), "{} is not in the help", step.name);
        }
    }
}
