//! What a firmware image takes of its board, read from the ELF file.

use std::fs;
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind, elf};

/// Sizes of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Code, constants, and what variables start with.
    pub flash_bytes: u64,
    /// Variables: what is left of the RAM is the stack's.
    pub static_ram_bytes: u64,
}

impl Image {
    /// Reads the sizes.
    pub fn read(path: &Path) -> Result<Self, String> {
        let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let file = object::File::parse(&*bytes).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut image = Self::default();
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
            if sh_flags & u64::from(elf::SHF_ALLOC) == 0 {
                continue;
            }
            let is_empty_at_start = matches!(section.kind(), SectionKind::UninitializedData);
            let is_written = sh_flags & u64::from(elf::SHF_WRITE) != 0;
            if !is_empty_at_start {
                image.flash_bytes += section.size();
            }
            if is_written {
                image.static_ram_bytes += section.size();
            }
        }
        Ok(image)
    }
}

/// The functions of an image that begin a panic, by name.
pub fn panics(path: &Path) -> Result<Vec<String>, String> {
    let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let file = object::File::parse(&*bytes).map_err(|error| format!("{}: {error}", path.display()))?;
    let names = file.symbols().filter_map(|symbol| symbol.name().ok().map(str::to_owned));
    let mut found: Vec<String> =
        names.filter(|name| name.contains("panicking") || name.contains("unwrap_failed")).collect();
    found.sort();
    found.dedup();
    Ok(found)
}
