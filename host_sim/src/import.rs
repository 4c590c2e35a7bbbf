//! Worlds that others drew, for [`crate::benchmark`]: vector worlds and grid maps, at the scale of our robot.
//!
//! | kind | file | what comes of it |
//! | --- | --- | --- |
//! | [`json_world`] | JSON with circles and segments (BARN, Kheperax) | [`VectorWorld`] |
//! | [`gazebo`] | SDF `.world` with cylinders and boxes (BARN) | [`VectorWorld`] |
//! | [`moving_ai`] | octile `.map` with `.scen` | [`GridMap`] |
//! | [`map_server`] | ROS `map_server` YAML with a PGM image ([`pgm`]) | [`GridMap`] |
//!
//! Nothing is believed: sizes are limited before memory is taken, every number is finite and within ±1000 m, and what
//! is wrong is said with file, place and value ([`ImportError`]). A file never makes the reader panic.

mod error;
pub mod gazebo;
mod grid_map;
pub mod json_world;
pub mod map_server;
pub mod moving_ai;
pub mod pgm;
mod vector_world;

use std::path::Path;

pub use error::{ImportError, Reader};
pub use grid_map::{GridMap, MapFrame};
pub use vector_world::VectorWorld;

/// Largest file that is read, in bytes.
pub const FILE_BYTES_MAX: u64 = 64 << 20;

/// Most shapes of a vector world.
pub const SHAPES_MAX: usize = 100_000;

/// Most columns or rows of a grid: what the planner takes.
pub const SIDE_MAX: usize = controller_core::planning::SIDE_MAX as usize;

/// Coordinates beyond this, in m, are no world for a robot of centimetres.
pub const COORDINATE_MAX_M: f64 = 1000.0;

/// The bytes of a file of reasonable size.
///
/// # Errors
/// If it cannot be read or is too large.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, ImportError> {
    let reader = Reader::new(path);
    let unreadable = |error: std::io::Error| {
        reader.error("", format!("cannot be read ({error})"), "check the path, and that you may read it")
    };
    let size = std::fs::metadata(path).map_err(unreadable)?.len();
    if size > FILE_BYTES_MAX {
        let problem = format!("{size} bytes are more than the {FILE_BYTES_MAX} that are read");
        return Err(reader.error("", problem, "give a smaller world"));
    }
    std::fs::read(path).map_err(unreadable)
}

/// The text of a file of reasonable size.
///
/// # Errors
/// If it cannot be read, is too large or is no UTF-8.
pub fn read_text(path: &Path) -> Result<String, ImportError> {
    String::from_utf8(read_bytes(path)?).map_err(|error| {
        let place = format!("byte {}", error.utf8_error().valid_up_to());
        Reader::new(path).error(
            &place,
            "is no text in UTF-8".to_owned(),
            "give a text file of the right kind",
        )
    })
}
