//! The repository's own rules about its files, which no other tool checks.
//!
//! * no line of Rust over 120 columns: rustfmt leaves long texts and macros as they are
//! * no leftovers of work in progress, and no path of the machine it was done on
//! * every crate says its licence, and the texts are there
//! * no link of the documentation to a file that is not there

use core::fmt;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

const COLUMNS_MAX: usize = 120;

const LICENCE: &str = "MIT OR Apache-2.0";

// In two halves, so that this file does not break its own rules.
const LEFTOVERS: [&str; 2] = [concat!("FIX", "ME"), concat!("XX", "X")];
const DEBUG_MACRO: &str = concat!("dbg", "!");
const FOREIGN_PATH: &str = concat!("/wo", "rk/");

/// One rule broken at one place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The file, from the root of the repository.
    path: String,
    /// Counted from 1; `None` where the file as a whole is meant.
    line: Option<usize>,
    what: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}: {}", self.path, self.what),
            None => write!(f, "{}: {}", self.path, self.what),
        }
    }
}

/// Checks all files below the root of the repository; files that are not text are left alone.
pub fn check(root: &Path) -> io::Result<Vec<Problem>> {
    let mut problems = Vec::new();
    for file in files(root)? {
        let bytes = fs::read(&file)?;
        let Ok(text) = String::from_utf8(bytes) else { continue };
        let path = file.strip_prefix(root).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        problems.extend(check_lines(&path, &text));
        if path == "Cargo.toml" || path.ends_with("/Cargo.toml") {
            problems.extend(check_manifest(&path, &text));
        }
        if has_checked_links(&path) {
            problems.extend(check_links(root, &path, &text));
        }
    }
    for (name, needle) in
        [("LICENSE-MIT", "Permission is hereby granted"), ("LICENSE-APACHE", "Apache License")]
    {
        if !fs::read_to_string(root.join(name)).is_ok_and(|text| text.contains(needle)) {
            problems.push(Problem { path: name.to_owned(), line: None, what: "no licence text".to_owned() });
        }
    }
    Ok(problems)
}

/// All files that are source: not what cargo, git or a run has made, and nothing behind a symbolic link.
fn files(root: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder)? {
            let (entry, path) = entry.map(|entry| (entry.file_type(), entry.path()))?;
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let made = matches!(name.as_str(), ".git" | "target") || (folder == root && name == "out");
            let kind = entry?;
            if kind.is_dir() && !made {
                folders.push(path);
            } else if kind.is_file() && !made {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The rules about single lines.
fn check_lines(path: &str, text: &str) -> Vec<Problem> {
    let is_rust = path.ends_with(".rs");
    let mut problems = Vec::new();
    for (line, content) in (1..).zip(text.lines()) {
        let mut report =
            |what: String| problems.push(Problem { path: path.to_owned(), line: Some(line), what });
        let columns = content.chars().count();
        if is_rust && columns > COLUMNS_MAX {
            report(format!("{columns} columns, at most {COLUMNS_MAX}"));
        }
        for word in LEFTOVERS {
            if has_word(content, word) {
                report(format!("`{word}`: do it, or open an issue and name it"));
            }
        }
        if is_rust && has_word(content, DEBUG_MACRO) {
            report(format!("`{DEBUG_MACRO}` left behind"));
        }
        if has_word(content, FOREIGN_PATH) {
            report(format!("`{FOREIGN_PATH}` is a path of somebody's machine"));
        }
    }
    problems
}

/// Whether `word` stands in the line by itself, not as part of a longer name.
fn has_word(line: &str, word: &str) -> bool {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    line.match_indices(word).any(|(at, _)| {
        let joins_before = word.starts_with(|c| is_name(c) || c == '/') && line[..at].ends_with(is_name);
        let joins_after = word.ends_with(is_name) && line[at + word.len()..].starts_with(is_name);
        !joins_before && !joins_after
    })
}

/// A crate says its licence, itself or through the workspace; and the workspace's is the right one.
fn check_manifest(path: &str, text: &str) -> Vec<Problem> {
    let mut section = "";
    let (mut has_package, mut says_licence, mut says_authors) = (false, false, false);
    let mut problems = Vec::new();
    for line in text.lines().map(str::trim) {
        if line.starts_with('[') {
            section = line;
            has_package |= section == "[package]";
        }
        if !matches!(section, "[package]" | "[workspace.package]") {
            continue;
        }
        let Some((key, value)) = line.split_once('=').map(|(key, value)| (key.trim(), value.trim())) else {
            continue;
        };
        says_authors |= matches!(key, "authors" | "authors.workspace");
        says_licence |= matches!(key, "license" | "license.workspace");
        if key == "license" && value != format!("\"{LICENCE}\"") {
            problems.push(Problem {
                path: path.to_owned(),
                line: None,
                what: format!("license {value}, not {LICENCE}"),
            });
        }
    }
    for (present, field) in [(says_licence, "license"), (says_authors, "authors")] {
        if has_package && !present {
            let what = format!("no `{field}`: write `{field}.workspace = true`");
            problems.push(Problem { path: path.to_owned(), line: None, what });
        }
    }
    problems
}

/// The documents whose links are checked: those a newcomer reads.
fn has_checked_links(path: &str) -> bool {
    matches!(path, "README.md" | "ARCHITECTURE.md") || (path.starts_with("docs/") && path.ends_with(".md"))
}

/// Every relative link leads to a file or folder inside the repository.
fn check_links(root: &Path, path: &str, text: &str) -> Vec<Problem> {
    let folder = Path::new(path).parent().unwrap_or(Path::new(""));
    let mut problems = Vec::new();
    for (line, target) in links(text) {
        let file = target.split(['#', '?']).next().unwrap_or_default();
        let is_elsewhere = target.contains("://") || target.starts_with("mailto:");
        if is_elsewhere || file.is_empty() {
            continue;
        }
        let mut report =
            |what: String| problems.push(Problem { path: path.to_owned(), line: Some(line), what });
        match inside(&folder.join(file.replace("%20", " "))) {
            Some(file) if root.join(&file).exists() => {}
            Some(_) => report(format!("link to `{target}`, which is not there")),
            None => report(format!("link to `{target}`, which is not in this repository")),
        }
    }
    problems
}

/// The path with `.` and `..` resolved; `None` where it leads out of the repository or begins outside.
fn inside(path: &Path) -> Option<PathBuf> {
    let mut resolved = PathBuf::new();
    for component in path.components() {
        match component {
            Component::Normal(name) => resolved.push(name),
            Component::CurDir => {}
            Component::ParentDir => {
                if !resolved.pop() {
                    return None;
                }
            }
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(resolved)
}

/// The links of a Markdown text with their lines: `[a](b)`, `![a](b "c")`, `[a](<b c>)` and `[a]: b`; not in code.
fn links(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut fence: Option<&str> = None;
    for (line, content) in (1..).zip(text.lines()) {
        let start = content.trim_start();
        let mark = ["```", "~~~"].into_iter().find(|mark| start.starts_with(mark));
        if mark.is_some() && (fence.is_none() || fence == mark) {
            fence = if fence.is_some() { None } else { mark };
            continue;
        }
        if fence.is_some() {
            continue;
        }
        let prose = without_code_spans(content);
        for (at, _) in prose.match_indices("](") {
            found.extend(destination(&prose[at + 2..]).map(|target| (line, target)));
        }
        let definition = prose.trim_start().strip_prefix('[').and_then(|rest| rest.split_once("]:"));
        if let Some((label, target)) = definition
            && !label.contains(']')
        {
            found.extend(destination(target.trim_start()).map(|target| (line, target)));
        }
    }
    found
}

/// The address at the front of what follows `](` or `]:`.
fn destination(text: &str) -> Option<String> {
    let target = match text.strip_prefix('<') {
        Some(rest) => rest.split('>').next(),
        None => text.split([')', ' ', '\t']).next(),
    };
    target.filter(|target| !target.is_empty()).map(str::to_owned)
}

/// The line without what stands between backticks.
fn without_code_spans(line: &str) -> String {
    let parts: Vec<&str> = line.split('`').collect();
    let closed = parts.len() % 2 == 1;
    let keep = |(i, part): (usize, &&str)| {
        (i % 2 == 0 || (!closed && i + 1 == parts.len())).then(|| (*part).to_owned())
    };
    parts.iter().enumerate().filter_map(keep).collect()
}

#[cfg(test)]
mod tests {
    use super::{
        DEBUG_MACRO, FOREIGN_PATH, LEFTOVERS, check, check_lines, check_links, check_manifest, files,
        has_checked_links, inside, links,
    };
    use std::path::{Path, PathBuf};

    fn root() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
    }

    fn said(problems: &[super::Problem]) -> Vec<String> {
        problems.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn long_lines_of_rust_are_found_by_columns_not_bytes() {
        let text = format!("{}\n{}\n{}\n", "a".repeat(120), "ä".repeat(120), "ä".repeat(121));
        assert_eq!(said(&check_lines("a.rs", &text)), ["a.rs:3: 121 columns, at most 120"]);
        assert_eq!(check_lines("a.md", &text), []);
    }

    #[test]
    fn leftovers_are_found_as_words() {
        for word in LEFTOVERS {
            assert_eq!(check_lines("a.toml", &format!("# {word}: later")).len(), 1);
            assert_eq!(check_lines("a.toml", &format!("# mktemp {word}{word}")), []);
        }
        let debug = format!("    {DEBUG_MACRO}(x);");
        assert_eq!(check_lines("a.rs", &debug).len(), 1);
        assert_eq!(check_lines("a.md", &debug), []);
        assert_eq!(check_lines("a.rs", &format!("    my{debug}").replace(' ', "")), []);
    }

    #[test]
    fn paths_of_a_machine_are_found_in_any_file() {
        assert_eq!(check_lines("a.svg", &format!("see {FOREIGN_PATH}main")).len(), 1);
        assert_eq!(check_lines("a.svg", &format!("net{FOREIGN_PATH}main")), []);
    }

    #[test]
    fn a_crate_without_a_licence_is_found() {
        let good = "[package]\nname = \"a\"\nlicense.workspace = true\nauthors.workspace = true\n";
        assert_eq!(check_manifest("a/Cargo.toml", good), []);
        let none = "[package]\nname = \"a\"\nauthors = []\n[lints]\nlicense.workspace = true\n";
        let expected = ["a/Cargo.toml: no `license`: write `license.workspace = true`"];
        assert_eq!(said(&check_manifest("a/Cargo.toml", none)), expected);
        let other = "[workspace.package]\nlicense = \"GPL-2.0\"\n";
        assert_eq!(check_manifest("Cargo.toml", other).len(), 1);
    }

    #[test]
    fn links_are_found_where_markdown_has_them() {
        let text = "\
[a](one.md) and ![b](two.svg \"title\"), [c](<three four.md>), `[not](code.md)`
```sh
[not](fenced.md)
```
[d]: five.md
";
        let found = links(text);
        let expected = [(1, "one.md"), (1, "two.svg"), (1, "three four.md"), (5, "five.md")];
        assert_eq!(found, expected.map(|(line, target)| (line, target.to_owned())));
    }

    #[test]
    fn links_to_nowhere_are_found() {
        let text = "\
[](src/main.rs) [](../Cargo.toml#x) [](#here) [](https://example.org/no) [](src/)
[](src/no.rs)
[](../../elsewhere)
[](/etc/hostname)
";
        let problems = said(&check_links(&root(), "xtask/README.md", text));
        assert_eq!(
            problems,
            [
                "xtask/README.md:2: link to `src/no.rs`, which is not there",
                "xtask/README.md:3: link to `../../elsewhere`, which is not in this repository",
                "xtask/README.md:4: link to `/etc/hostname`, which is not in this repository",
            ]
        );
        assert!(has_checked_links("README.md") && has_checked_links("docs/deep/a.md"));
        assert!(!has_checked_links("docs/a.svg"));
        assert_eq!(inside(Path::new("docs/../a/./b")), Some(PathBuf::from("a/b")));
    }

    #[test]
    fn what_was_made_is_not_checked() {
        let found = files(&root()).unwrap();
        assert!(found.contains(&root().join("xtask/src/tidy.rs")));
        assert!(found.contains(&root().join(".cargo/config.toml")), "hidden folders are source too");
        assert!(!found.iter().any(|file| file.starts_with(root().join("target"))));
    }

    /// The rules apply to the file that holds them: they must be written so that they do not find themselves.
    #[test]
    fn the_rules_do_not_find_themselves() {
        let here = check(&root()).unwrap();
        assert_eq!(
            said(&here).into_iter().filter(|line| line.contains("tidy.rs")).collect::<Vec<_>>(),
            [""; 0]
        );
    }
}
