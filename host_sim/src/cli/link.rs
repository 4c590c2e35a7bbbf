//! `link`: what a board is, how it is doing, and its parameters.

use controller_core::config::{Config, PARAMETERS};
use protocol::message::{Health, Hello, MapSummary, ScalarKind, Telemetry, TimeBase};
use serde_json::{Value, json};

use super::args::InspectArgs;
use super::error::{CliError, Outcome};
use super::linked::{AnySession, connect};
use super::output::{hex, print, print_json};
use super::table::{facts, table};

/// Everything there is to show.
struct Shown {
    hello: Hello,
    map: MapSummary,
    health: Health,
    telemetry: Telemetry,
    parameters: Option<Vec<f32>>,
}

pub fn link(args: &InspectArgs) -> Result<Outcome, CliError> {
    let changes = args.set.iter().map(change).collect::<Result<Vec<_>, _>>()?;
    let mut session = connect(&args.address, &args.way, None, TimeBase::Lockstep)?;
    if !changes.is_empty() {
        for (index, value) in changes {
            session.set(index, value)?;
        }
        session.commit()?;
    }
    let shown = ask(&mut session, args.parameters)?;
    if args.json {
        print_json(&document(&shown))?;
    } else {
        print(&text(&shown))?;
    }
    Ok(Outcome::Ok)
}

/// A parameter by its name, with a value that it can have.
pub fn change((name, value): &(String, f32)) -> Result<(u8, f32), CliError> {
    let index = PARAMETERS.iter().position(|parameter| parameter.name == name).ok_or_else(|| {
        CliError::Request(format!("there is no parameter `{name}`; `config --print` shows all of them"))
    })?;
    Config::default().set(index, *value).map_err(|error| CliError::Request(error.to_string()))?;
    Ok((u8::try_from(index).unwrap_or(u8::MAX), *value))
}

fn ask(session: &mut AnySession, with_parameters: bool) -> Result<Shown, CliError> {
    session.renew()?;
    Ok(Shown {
        hello: session.board.clone(),
        map: session.map_summary()?,
        health: session.health()?,
        telemetry: session.telemetry()?,
        parameters: if with_parameters { Some(session.parameters()?) } else { None },
    })
}

fn text(shown: &Shown) -> String {
    let Shown { hello, map, health, telemetry, .. } = shown;
    let neurons = u16::from(map.columns) * u16::from(map.rows);
    let parameters = match hello.parameters_hash {
        Some(hash) if hash == Config::default().hash() => format!("{} (the defaults)", hex(hash)),
        Some(hash) => hex(hash),
        None => String::from("unknown"),
    };
    let board = facts([
        ("board", hello.board.map_or("unknown", |board| board.name()).to_owned()),
        ("scalar", hello.scalar.map_or("unknown", ScalarKind::name).to_owned()),
        ("firmware", hello.build_id.to_string()),
        ("protocol", format!("version {}, schema {}", hello.protocol_version, hex(hello.schema_hash))),
        ("start", hello.epoch.to_string()),
        (
            "map",
            format!(
                "{}, {} steps, {} of {neurons} neurons trained",
                hex(map.hash),
                map.trained_steps,
                map.trained_neurons
            ),
        ),
        ("parameters", parameters),
    ]);
    let doing = facts([
        ("tick", health.tick.to_string()),
        ("frames", format!("{} whole, {} damaged", health.frames_good, health.frames_bad)),
        ("dropped", format!("{} requests", health.requests_dropped)),
        ("stack", health.stack_bytes_max.map_or_else(|| String::from("-"), |bytes| format!("{bytes} bytes"))),
        ("mode", format!("{:?}", telemetry.mode).to_lowercase()),
        (
            "pose",
            format!(
                "x {:.3} m, y {:.3} m, heading {:.1}°",
                telemetry.pose.x_m,
                telemetry.pose.y_m,
                telemetry.pose.heading_rad.to_degrees()
            ),
        ),
        ("ahead", format!("{} checkpoints", telemetry.checkpoints_ahead)),
    ]);
    let parameters = shown
        .parameters
        .as_deref()
        .map_or_else(String::new, |values| format!("\n{}", parameters_table(values)));
    format!("{board}\n{doing}{parameters}")
}

fn parameters_table(values: &[f32]) -> String {
    let default = Config::default();
    let mut rows = vec![["parameter", "value", "default", "unit"].map(String::from).to_vec()];
    for (index, (parameter, value)) in PARAMETERS.iter().zip(values).enumerate() {
        rows.push(vec![
            parameter.name.to_owned(),
            value.to_string(),
            default.get(index).map_or_else(String::new, |value| value.to_string()),
            parameter.unit.to_owned(),
        ]);
    }
    table(&rows)
}

fn document(shown: &Shown) -> Value {
    let Shown { hello, map, health, telemetry, parameters } = shown;
    let parameters = parameters.as_deref().map(|values| {
        let named = PARAMETERS.iter().zip(values);
        named
            .map(|(parameter, value)| (parameter.name.to_owned(), json!(value)))
            .collect::<serde_json::Map<_, _>>()
    });
    json!({
        "board": hello.board.map(|board| board.name()),
        "scalar": hello.scalar.map(ScalarKind::name),
        "firmware": hello.build_id.as_str(),
        "protocol_version": hello.protocol_version,
        "schema_hash": hex(hello.schema_hash),
        "epoch": hello.epoch,
        "parameters_hash": hello.parameters_hash.map(hex),
        "map": {
            "hash": hex(map.hash),
            "trained_steps": map.trained_steps,
            "trained_neurons": map.trained_neurons,
        },
        "health": health,
        "telemetry": telemetry,
        "parameters": parameters,
    })
}
