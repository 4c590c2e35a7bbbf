//! What leaves the program: results on stdout, complaints on stderr, files whole or not at all.

use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::NamedTempFile;

use super::error::CliError;

/// Prints a result. A reader that has seen enough (`| head`) is no error.
pub fn print(text: &str) -> Result<(), CliError> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Request(format!(
            "cannot write to the standard output ({error}); check where it goes"
        ))),
        _ => Ok(()),
    }
}

/// Prints a JSON document.
pub fn print_json(document: &Value) -> Result<(), CliError> {
    print(&format!("{document:#}\n"))
}

/// Says something that is not a result. If even stderr is closed, nobody listens.
pub fn complain(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// A hash as people compare it.
pub fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}

/// The number as people write it: widened to 64 bits, 0.16 would be printed as 0.1599999964237213.
pub fn decimal(value: f32) -> Value {
    value.to_string().parse().unwrap_or_default()
}

/// A folder that files will be written to.
///
/// [`OutputFolder::open`] is for before the long work: it proves that the files can be written and leaves nothing
/// behind but the folder itself. Each file is written beside its place and then moved there, so it is whole or absent.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
}

impl OutputFolder {
    /// Makes the folder if there is none, and checks that it takes files of these names.
    pub fn open(path: &Path, names: &[&str]) -> Result<Self, CliError> {
        let folder = Self { path: path.to_owned() };
        std::fs::create_dir_all(path).map_err(|error| folder.unwritable(path, &error))?;
        for name in names {
            let file = path.join(name);
            if file.is_dir() {
                let message =
                    format!("cannot write {}: it is a folder; choose another --out", file.display());
                return Err(CliError::Request(message));
            }
        }
        folder.temporary().map_err(|error| folder.unwritable(path, &error))?;
        Ok(folder)
    }

    /// The folder and name of a single file, checked likewise.
    pub fn for_file(file: &Path) -> Result<(Self, String), CliError> {
        let name = file.file_name().and_then(|name| name.to_str());
        // `Path` overlooks a separator at the end, by which the user says that a folder is meant.
        let name = name.filter(|name| file.as_os_str().as_encoded_bytes().ends_with(name.as_bytes()));
        let name = name.ok_or_else(|| {
            let message =
                format!("cannot write `{}`: not the name of a file; choose another --out", file.display());
            CliError::Request(message)
        })?;
        Ok((Self::open(file.parent().unwrap_or(Path::new("")), &[name])?, name.to_owned()))
    }

    /// Writes a file and returns its path as the user would type it.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<String, CliError> {
        let path = self.path.join(name);
        let written = self.temporary().and_then(|mut file| {
            file.write_all(content)?;
            file.as_file().sync_all()?;
            file.persist(&path).map_err(|error| error.error)
        });
        written.map_err(|error| self.unwritable(&path, &error))?;
        Ok(path.display().to_string())
    }

    /// A file that vanishes unless it is moved to its place; with the usual permissions, not those of a secret.
    fn temporary(&self) -> io::Result<NamedTempFile<File>> {
        let create = |path: &Path| File::create_new(path);
        tempfile::Builder::new().prefix(".host_sim-").suffix(".tmp").make_in(&self.path, create)
    }

    fn unwritable(&self, path: &Path, error: &io::Error) -> CliError {
        let message = format!(
            "cannot write {} ({error}); choose a folder that you may write to with --out",
            path.display()
        );
        CliError::Request(message)
    }
}
