//! `map`: what a learned map is, how two differ, and one as source text for flash.

use std::path::Path;

use host_sim::figure::draw_map;
use host_sim::map_report::comparison::{Comparison, Difference, compare};
use host_sim::map_report::{Extent, Extreme, MapRecords, MapStatistics, export};
use protocol::map_file::{MapHeader, Robot};
use serde_json::{Value, json};

use super::args::{LanguageArg, MapAction, MapArgs, MapDiffArgs, MapExportArgs, MapShowArgs};
use super::error::{CliError, Outcome};
use super::learning::read_map_file;
use super::output::{OutputFolder, decimal, hex, print, print_json};
use super::table::{facts, millimetres, table};

pub fn map(args: &MapArgs) -> Result<Outcome, CliError> {
    match &args.action {
        MapAction::Show(args) => show(args),
        MapAction::Diff(args) => diff(args),
        MapAction::Export(args) => export(args),
    }
}

/// A map to look at, of whatever robot.
fn read(path: &Path) -> Result<MapRecords, CliError> {
    let bytes = read_map_file(path)?;
    MapRecords::from_bytes(&bytes).map_err(|error| CliError::Request(format!("{}: {error}", path.display())))
}

/// Writes what was made of a map to a file, but not over the map, which may have taken a robot half an hour.
fn write(out: &Path, source: &Path, content: &str) -> Result<String, CliError> {
    let same = |out: &Path| Some(out.canonicalize().ok()? == source.canonicalize().ok()?);
    if same(out).unwrap_or(false) {
        let message = format!("--out {} would overwrite the map; choose another --out", out.display());
        return Err(CliError::Request(message));
    }
    let (folder, name) = OutputFolder::for_file(out)?;
    folder.write(&name, content.as_bytes())
}

fn wrote(file: Option<String>) -> String {
    file.map_or_else(String::new, |file| format!("wrote {file}\n"))
}

fn show(args: &MapShowArgs) -> Result<Outcome, CliError> {
    let map = read(&args.file)?;
    let figure = args.out.as_deref().map(|out| write(out, &args.file, &draw_map(&map))).transpose()?;
    let statistics = map.statistics();
    if args.json {
        print_json(&document(&args.file, &map, &statistics, figure.as_deref()))?;
    } else {
        print(&format!("{}{}", text(&args.file, &map, &statistics), wrote(figure)))?;
    }
    Ok(Outcome::Ok)
}

fn text(path: &Path, map: &MapRecords, statistics: &MapStatistics) -> String {
    let header = map.header();
    let made = &header.provenance;
    let (columns, rows) = map.lattice();
    let step_s = f64::from(made.horizon_ms) / 1000.0;
    let MapStatistics { neurons, trained, .. } = statistics;
    let about = facts([
        ("map", path.display().to_string()),
        ("format", format!("{}, scalar {}", header.format_version, map.scalar_name())),
        ("lattice", format!("{columns} columns (bearing) × {rows} rows (distance)")),
        ("reach", format!("{} m", header.reach_m)),
        ("speed limit", format!("{} m/s", header.speed_limit_mps)),
        ("robot", robot(header)),
        ("learned", format!("in {} steps of {step_s} s, seed {}", made.steps, made.seed)),
        ("by", format!("core {}, commit {}", made.core_version, made.commit)),
        ("config", format!("digest {}", hex(made.config_digest))),
        ("map hash", hex(map.hash())),
    ]);
    let at = |extreme: &Extreme| format!("at column {}, row {}", extreme.at.column, extreme.at.row);
    let (weight, element) = (&statistics.largest_weight, &statistics.largest_element);
    let largest = facts([
        ("trained", format!("{trained} of {neurons} neurons")),
        ("|weight|", format!("at most {:.3} rad or reaches, {}", weight.value, at(weight))),
        ("|element|", format!("at most {:.3} c* per rad or per reach, {}", element.value, at(element))),
    ]);
    let spanned = statistics.extent.as_ref().map_or_else(String::new, extent);
    format!("{about}\n{largest}{spanned}")
}

/// Which robot learned it.
fn robot(header: &MapHeader) -> String {
    let Robot { wheel_base_m, body_radius_m, encoder_counts_per_m } = header.robot;
    format!(
        "wheel base {wheel_base_m} m, body radius {body_radius_m} m, {encoder_counts_per_m} encoder counts per m"
    )
}

/// What the trained neurons span.
fn extent(extent: &Extent) -> String {
    let (ahead, behind) = (millimetres(extent.ahead_m), millimetres(extent.behind_m));
    let (low, high) = (extent.bearing_low_deg, extent.bearing_high_deg);
    let spanned = facts([
        ("extent", format!("{ahead} mm ahead, {behind} mm behind")),
        ("bearings", format!("{low:.1} to {high:.1} degrees")),
    ]);
    let mut rows = vec![["mean M of trained", "c* per rad", "c* per reach"].map(String::from).to_vec()];
    for (wheel, [bearing, distance]) in ["left", "right"].into_iter().zip(extent.mean_matrix) {
        rows.push(vec![wheel.to_owned(), format!("{bearing:.3}"), format!("{distance:.3}")]);
    }
    format!("{spanned}\n{}", table(&rows))
}

fn document(path: &Path, map: &MapRecords, statistics: &MapStatistics, figure: Option<&str>) -> Value {
    let header = map.header();
    let made = &header.provenance;
    json!({
        "map": path.display().to_string(),
        "format_version": header.format_version,
        "scalar": map.scalar_name(),
        "columns": header.columns,
        "rows": header.rows,
        "reach_m": decimal(header.reach_m),
        "speed_limit_mps": decimal(header.speed_limit_mps),
        "robot": {
            "wheel_base_m": decimal(header.robot.wheel_base_m),
            "body_radius_m": decimal(header.robot.body_radius_m),
            "encoder_counts_per_m": decimal(header.robot.encoder_counts_per_m),
        },
        "provenance": {
            "seed": made.seed,
            "steps": made.steps,
            "horizon_ms": made.horizon_ms,
            "config_digest": hex(made.config_digest),
            "core_version": made.core_version.as_str(),
            "commit": made.commit.as_str(),
        },
        "hash": hex(map.hash()),
        "statistics": statistics,
        "file": figure,
    })
}

fn diff(args: &MapDiffArgs) -> Result<Outcome, CliError> {
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let comparison = compare(&a, &b).map_err(|error| {
        CliError::Request(format!("{} and {}: {error}", args.a.display(), args.b.display()))
    })?;
    let same = comparison.is_same_map();
    if args.json {
        print_json(&json!({
            "a": { "map": args.a.display().to_string(), "hash": hex(a.hash()) },
            "b": { "map": args.b.display().to_string(), "hash": hex(b.hash()) },
            "same": same,
            "differences": comparison,
        }))?;
    } else {
        let side =
            |path: &Path, map: &MapRecords| format!("{}, map hash {}", path.display(), hex(map.hash()));
        let sides = facts([("a", side(&args.a, &a)), ("b", side(&args.b, &b))]);
        print(&format!("{sides}{}{}", differences(&comparison), verdict(args, same)))?;
    }
    Ok(if same || !args.require_same { Outcome::Ok } else { Outcome::RobotFailed })
}

/// What differs, as tables; nothing where nothing does.
fn differences(comparison: &Comparison) -> String {
    let mut text = String::from("\n");
    if !comparison.headers.is_empty() {
        let mut rows = vec![["header", "a", "b"].map(String::from).to_vec()];
        let line = |name: &str, a: &str, b: &str| [name, a, b].map(String::from).to_vec();
        rows.extend(comparison.headers.iter().map(|header| line(header.name, &header.a, &header.b)));
        text += &(table(&rows) + "\n");
    }
    let Comparison { neurons, differing, trained_only_in_a, trained_only_in_b, .. } = comparison;
    if *differing == 0 {
        return text;
    }
    text += &facts([
        ("neurons", format!("{differing} of {neurons} differ")),
        ("trained", format!("{trained_only_in_a} only in a, {trained_only_in_b} only in b")),
    ]);
    let mut rows = vec![["over all neurons", "RMS", "largest", "column", "row"].map(String::from).to_vec()];
    let mut add = |name: &str, difference: &Difference, format: &dyn Fn(f64) -> String| {
        let Difference { rms, largest } = difference;
        let place = [largest.at.column, largest.at.row].map(|index| index.to_string());
        rows.push([vec![name.to_owned(), format(*rms), format(largest.value)], place.to_vec()].concat());
    };
    add("place mm", &comparison.place_m, &|metres| small(metres * 1000.0));
    add("bearing degrees", &comparison.bearing_deg, &small);
    add("matrix element", &comparison.element, &small);
    text + "\n" + &table(&rows) + "\n"
}

/// Three places, or as many as it takes not to print a difference as none.
fn small(value: f64) -> String {
    if value > 0.0 && value < 0.0005 { format!("{value:.1e}") } else { format!("{value:.3}") }
}

fn verdict(args: &MapDiffArgs, same: bool) -> &'static str {
    match (same, args.require_same) {
        (true, _) => "the same map, bit for bit\n",
        (false, true) => "FAILED: the maps differ\n",
        (false, false) => "the maps differ\n",
    }
}

fn export(args: &MapExportArgs) -> Result<Outcome, CliError> {
    let map = read(&args.file)?;
    let text = match args.to {
        LanguageArg::Rust => export::to_rust(&map),
        LanguageArg::C => export::to_c(&map),
    };
    match &args.out {
        Some(out) => print(&wrote(Some(write(out, &args.file, &text)?)))?,
        None => print(&text)?,
    }
    Ok(Outcome::Ok)
}
