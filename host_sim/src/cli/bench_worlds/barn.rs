//! `bench barn`: worlds of discs and walls.

use std::path::{Path, PathBuf};

use controller_core::scalar::Fixed;
use host_sim::benchmark::Course;
use host_sim::import::{VectorWorld, gazebo, json_world};
use host_sim::map_store::StoredScalar;

use super::args::BarnArgs;
use super::drive::drive;
use super::report::Report;
use crate::cli::args::ScalarArg;
use crate::cli::error::{CliError, Outcome};
use crate::cli::output::OutputFolder;

pub fn barn(args: &BarnArgs) -> Result<Outcome, CliError> {
    match args.runs.learning.scalar() {
        ScalarArg::F32 => barn_in::<f32>(args),
        ScalarArg::Fixed => barn_in::<Fixed>(args),
    }
}

fn barn_in<S: StoredScalar>(args: &BarnArgs) -> Result<Outcome, CliError> {
    let folder = args.runs.out.as_deref().map(|path| OutputFolder::open(path, &[])).transpose()?;
    let courses = files(&args.paths)?
        .iter()
        .map(|path| {
            let world = load(path, args.scale)?;
            let unusable = |error| CliError::Request(format!("{}: {error}", path.display()));
            Course::of_world(world).map_err(unusable)
        })
        .collect::<Result<Vec<_>, CliError>>()?;
    let driven = drive::<S>(&args.runs, &courses)?;
    let (courses, driven) = (&courses, &driven);
    Report { what: "barn", args: &args.runs, scalar: S::NAME, courses, driven, plans: None }.put(folder)
}

fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "json")
}

fn is_world(path: &Path) -> bool {
    is_json(path) || path.extension().is_some_and(|ending| ending == "world")
}

fn load(path: &Path, scale: f64) -> Result<VectorWorld, CliError> {
    Ok(if is_json(path) { json_world::load(path)? } else { gazebo::load(path, scale)? })
}

/// The files given, and the worlds of the folders given, by name.
fn files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    for path in paths {
        if !path.is_dir() {
            files.push(path.clone());
            continue;
        }
        let unreadable = |error| CliError::Request(format!("{}: cannot be read ({error})", path.display()));
        let mut found: Vec<PathBuf> = std::fs::read_dir(path)
            .map_err(unreadable)?
            .map(|entry| entry.map(|entry| entry.path()))
            .collect::<Result<_, _>>()
            .map_err(unreadable)?;
        found.retain(|path| is_world(path));
        if found.is_empty() {
            let message = format!("{}: holds no .json and no .world; name another folder", path.display());
            return Err(CliError::Request(message));
        }
        found.sort();
        files.extend(found);
    }
    Ok(files)
}
