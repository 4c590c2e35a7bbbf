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

/// The functions of an image that begin a panic, by their names in the file, but for those allowed, which are given as
/// paths.
pub fn panics(path: &Path, allowed: &[String]) -> Result<Vec<String>, String> {
    let bytes = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let file = object::File::parse(&*bytes).map_err(|error| format!("{}: {error}", path.display()))?;
    let names = file.symbols().filter_map(|symbol| symbol.name().ok().map(str::to_owned));
    let allowed: Vec<String> = allowed.iter().map(|path| mangled(path)).collect();
    let mut found: Vec<String> =
        names.filter(|name| begins_panic(name) && !allowed.iter().any(|end| name.ends_with(end))).collect();
    found.sort();
    found.dedup();
    Ok(found)
}

/// `core` has a function of its own for each way to panic, and calls it `panic…` or `…_fail…`.
fn begins_panic(name: &str) -> bool {
    name.contains("4core") && (name.contains("panicking") || name.contains("_fail"))
}

/// How the name of a function without parameters ends in the file: each part of its path behind its length.
fn mangled(path: &str) -> String {
    path.split("::").map(|part| format!("{}{part}", part.len())).collect()
}

#[cfg(test)]
mod tests {
    use super::{begins_panic, mangled};

    #[test]
    fn panics_are_told_by_their_names() {
        for name in [
            "_RNvNtCs7ldSeZOOJos_4core6option13unwrap_failed",
            "_RNvNtCs7ldSeZOOJos_4core9panicking18panic_bounds_check",
            "_RNvNtNtCs7ldSeZOOJos_4core5slice5index16slice_index_fail",
        ] {
            assert!(begins_panic(name), "{name}");
        }
        assert!(!begins_panic("_RNvMs_NtCs1_8firmware5panic4_fail"));
        let panic = "_RNvNtCs7ldSeZOOJos_4core9panicking5panic";
        assert!(panic.ends_with(&mangled("core::panicking::panic")));
        assert!(!format!("{panic}_fmt").ends_with(&mangled("core::panicking::panic")));
    }
}
