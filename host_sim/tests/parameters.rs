//! The list of parameters against the configuration as files have it: neither has what the other lacks.
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, which clippy.toml cannot know")]

use controller_core::config::{Config, Kind, PARAMETERS, Parameter};
use toml::{Table, Value};

/// The configuration as keys and values of a file, `servo.stall_share` and so on.
fn fields(config: &Config) -> Vec<(String, Value)> {
    fn walk(prefix: &str, table: Table, fields: &mut Vec<(String, Value)>) {
        for (key, value) in table {
            let name = format!("{prefix}{key}");
            match value {
                Value::Table(group) => walk(&format!("{name}."), group, fields),
                leaf => fields.push((name, leaf)),
            }
        }
    }
    let mut fields = Vec::new();
    walk("", Table::try_from(config).unwrap(), &mut fields);
    fields
}

fn field(config: &Config, name: &str) -> Value {
    let (_, value) = fields(config).into_iter().find(|(field, _)| field == name).unwrap();
    value
}

/// A value of the list as a file has it.
fn written(parameter: &Parameter, value: f32) -> Value {
    match parameter.kind {
        Kind::Real => Value::Float(value.into()),
        Kind::Count => Value::Integer(format!("{value}").parse().unwrap()),
        Kind::Choice(names) => Value::String(names[format!("{value}").parse::<usize>().unwrap()].to_owned()),
    }
}

#[test]
fn every_field_is_in_the_list_once_and_nothing_else() {
    let mut of_file: Vec<String> = fields(&Config::default()).into_iter().map(|(name, _)| name).collect();
    let mut of_list: Vec<&str> = PARAMETERS.iter().map(|parameter| parameter.name).collect();
    of_file.sort_unstable();
    of_list.sort_unstable();
    assert_eq!(of_list, of_file);
}

#[test]
fn list_and_file_mean_the_same_field_and_the_same_names() {
    for (index, parameter) in PARAMETERS.iter().enumerate() {
        let mut values = vec![parameter.default_value(), parameter.low, parameter.high];
        if let Kind::Choice(names) = parameter.kind {
            values = (0_u16..).take(names.len()).map(f32::from).collect();
        }
        for value in values {
            let mut config = Config::default();
            config.set(index, value).unwrap();
            assert_eq!(field(&config, parameter.name), written(parameter, value), "{}", parameter.name);
        }
    }
}
