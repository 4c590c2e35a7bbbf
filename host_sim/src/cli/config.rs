//! `config`: every number of the controller as a file for `--config`.

use controller_core::config::Config;
use host_sim::config_file;

use super::args::ConfigArgs;
use super::error::{CliError, Outcome};
use super::output::print;

const HEAD: &str = "\
# Configuration of the controller, for `--config`. SI units; a key that is left out keeps its default.
# `architecture` and `schedule.target_period_ms` are not used by `run`: the scenario or --controller says them.
# What each number does: the documentation of `controller_core::config`.

";

pub fn config(args: &ConfigArgs) -> Result<Outcome, CliError> {
    let config = args.config.as_deref().map_or_else(|| Ok(Config::default()), config_file::load)?;
    let text = config_file::to_toml(&config)
        .map_err(|error| CliError::Request(format!("the configuration cannot be printed ({error})")))?;
    print(&format!("{HEAD}{text}"))?;
    Ok(Outcome::Ok)
}
