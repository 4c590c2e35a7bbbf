//! `config`: every number of the controller, as a file for `--config` or as a list with units and ranges.

use controller_core::config::{Kind, PARAMETERS, Parameter};
use host_sim::config_file;
use host_sim::settings::Settings;
use serde_json::{Value, json};

use super::args::ConfigArgs;
use super::error::{CliError, Outcome};
use super::output::{decimal, print, print_json};
use super::table::table;

const HEAD: &str = "\
# Configuration of the controller, for `--config`. SI units; a key that is left out keeps its default, with --link
# that of boards.
# `architecture` and `schedule.target_period_ms` are not used by `run`: the scenario or --controller says them.
# What each number does: the documentation of `controller_core::config`. Units and ranges: `config --list`.
# `[peers…]` are the controllers of others, for `run --controller apf` and so on: `host_sim::peers`.

";

pub fn config(args: &ConfigArgs) -> Result<Outcome, CliError> {
    if args.list {
        let printed = if args.json { print_json(&document()) } else { print(&list()) };
        return printed.map(|()| Outcome::Ok);
    }
    let config = args.config.as_deref().map_or_else(|| Ok(Settings::default()), config_file::load)?;
    let text = config_file::to_toml(&config)
        .map_err(|error| CliError::Request(format!("the configuration cannot be printed ({error})")))?;
    print(&format!("{HEAD}{text}"))?;
    Ok(Outcome::Ok)
}

fn list() -> String {
    let mut rows = vec![["no  parameter", "default", "unit", "range"].map(String::from).to_vec()];
    for (number, parameter) in PARAMETERS.iter().enumerate() {
        rows.push(vec![
            format!("{number:>2}  {}", parameter.name),
            defaults(number, parameter),
            parameter.unit.to_owned(),
            range(parameter),
        ]);
    }
    table(&rows)
}

/// The simulator's default, and that of boards where it is another.
fn defaults(number: usize, parameter: &Parameter) -> String {
    let (here, on_boards) = (default_here(number), parameter.default_value());
    // Both are constants of the program.
    if here.to_bits() == on_boards.to_bits() {
        here.to_string()
    } else {
        format!("{here} (boards {on_boards})")
    }
}

fn default_here(number: usize) -> f32 {
    Settings::default().core.get(number).unwrap_or_default()
}

fn range(parameter: &Parameter) -> String {
    let Parameter { low, high, .. } = parameter;
    match parameter.kind {
        Kind::Real => format!("{low} to {high}"),
        Kind::Count => format!("{low} to {high}, whole"),
        Kind::Choice(_) => parameter.must.to_owned(),
    }
}

fn document() -> Value {
    let of_parameter = |(number, parameter): (usize, &Parameter)| {
        let choices = if let Kind::Choice(names) = parameter.kind { names } else { &[] };
        json!({
            "number": number,
            "name": parameter.name,
            "default": decimal(default_here(number)),
            "default_on_boards": decimal(parameter.default_value()),
            "unit": parameter.unit,
            "low": decimal(parameter.low),
            "high": decimal(parameter.high),
            "whole": parameter.kind != Kind::Real,
            "choices": choices,
            "must_be": parameter.must,
        })
    };
    PARAMETERS.iter().enumerate().map(of_parameter).collect()
}
