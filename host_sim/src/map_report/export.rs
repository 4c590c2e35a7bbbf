//! A map as a constant for flash: source text that needs nothing but the language.
//!
//! Every number reads back to the same bits. The text depends on nothing but the file's contents: the same map gives
//! the same text, so that a committed one shows in `diff` what has changed.

use core::fmt::Write;

use protocol::map_file::NeuronRecord;

use super::MapRecords;

/// What both languages say at the top, with their sign of a comment in front of each line.
fn head(map: &MapRecords, comment: &str) -> String {
    let header = map.header();
    let made = &header.provenance;
    let mut lines = vec![
        format!(
            "A learned map (Extended Kohonen Map) of {} × {} neurons, hash {:016x}.",
            header.columns,
            header.rows,
            map.hash()
        ),
        format!(
            "Written by `host_sim map export`, version {}; write it anew rather than edit it.",
            env!("CARGO_PKG_VERSION")
        ),
        format!(
            "Learned with scalar {} in {} steps of {} ms, seed {}, by core {}, commit {}.",
            map.scalar_name(),
            made.steps,
            made.horizon_ms,
            made.seed,
            plain(&made.core_version),
            plain(&made.commit),
        ),
        format!(
            "On a robot with a wheel base of {:?} m, configuration digest {:016x}.",
            header.robot.wheel_base_m, made.config_digest,
        ),
    ];
    lines.extend(UNITS.lines().map(str::to_owned));
    lines.iter().fold(String::new(), |text, line| text + format!("{comment} {line}").trim_end() + "\n")
}

const UNITS: &str = "
Units:
  reach            metres: the longest way of one training step; the unit of distances
  speed limit      metres per second: the unit c* of wheel speeds
  bearing          radians, 0 ahead, positive to the left
  distance         reaches, negative behind; metres = distance * reach
  left, right      the matrix M: wheel speed in c* = [0] * bearing + [1] * distance,
                   [0] in c* per radian, [1] in c* per reach; m/s = c* * speed limit
  has won          whether the neuron has won in training; if not, its matrix means nothing
Order: column by column (bearings); neuron (column, row) has the index column * rows + row.";

/// The map as a Rust module without dependencies, also without `std`.
#[must_use]
pub fn to_rust(map: &MapRecords) -> String {
    let header = map.header();
    let made = &header.provenance;
    let mut text = head(map, "//");
    // Writing to a string cannot fail.
    let mut constant = |what: &str, name: &str, kind: &str, value: String| {
        let _ = writeln!(text, "\n/// {what}\npub const {name}: {kind} = {value};");
    };
    constant(
        "Format of the file it was read from.",
        "FORMAT_VERSION",
        "u16",
        header.format_version.to_string(),
    );
    constant(
        "Number type of the controller that learned it.",
        "SCALAR",
        "&str",
        format!("{:?}", map.scalar_name()),
    );
    constant("Neurons along the bearing.", "COLUMNS", "usize", header.columns.to_string());
    constant("Neurons along the distance.", "ROWS", "usize", header.rows.to_string());
    constant(
        "The unit of distances: the longest way of one training step, in m.",
        "REACH_M",
        "f32",
        rust_float(header.reach_m),
    );
    constant(
        "The unit c* of wheel speeds, in m/s.",
        "SPEED_LIMIT_MPS",
        "f32",
        rust_float(header.speed_limit_mps),
    );
    constant(
        "Wheel base of the robot that learned it, in m.",
        "WHEEL_BASE_M",
        "f32",
        rust_float(header.robot.wheel_base_m),
    );
    constant(
        "Radius of that robot's body, in m.",
        "BODY_RADIUS_M",
        "f32",
        rust_float(header.robot.body_radius_m),
    );
    constant(
        "Encoder counts per metre of its wheels' travel.",
        "ENCODER_COUNTS_PER_M",
        "f32",
        rust_float(header.robot.encoder_counts_per_m),
    );
    constant(
        "Hash of the map in its scalar, as a board that holds it names it.",
        "HASH",
        "u64",
        format!("0x{:016x}", map.hash()),
    );
    constant("Seed of the run that trained it.", "SEED", "u64", made.seed.to_string());
    constant("Training steps it has seen.", "STEPS", "u32", made.steps.to_string());
    constant("Length of a training step, in ms.", "HORIZON_MS", "u16", made.horizon_ms.to_string());
    constant(
        "Digest of the configuration it was trained with.",
        "CONFIG_DIGEST",
        "u64",
        format!("0x{:016x}", made.config_digest),
    );
    constant(
        "Version of the controller core that trained it.",
        "CORE_VERSION",
        "&str",
        format!("{:?}", made.core_version.as_str()),
    );
    constant(
        "Commit of the program that wrote the file it was read from.",
        "COMMIT",
        "&str",
        format!("{:?}", made.commit.as_str()),
    );
    text += RUST_NEURON;
    for_each_neuron(map, &mut text, |neuron| {
        let [bearing, distance, a, b, c, d] = super::numbers(neuron).map(rust_float);
        format!("neuron({bearing}, {distance}, [{a}, {b}], [{c}, {d}], {})", neuron.has_won)
    });
    text + "];\n"
}

const RUST_NEURON: &str = "
/// One neuron: the place that it stands for, and the matrix that gives the wheel speeds to a place near it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapNeuron {
    /// Bearing of its place in rad, 0 ahead, positive to the left.
    pub bearing_rad: f32,
    /// Distance of its place in units of `REACH_M`, negative behind.
    pub distance_per_reach: f32,
    /// Row of the left wheel: c* per radian, c* per reach.
    pub left: [f32; 2],
    /// Row of the right wheel: c* per radian, c* per reach.
    pub right: [f32; 2],
    /// Whether it has won in training; if not, its matrix means nothing.
    pub has_won: bool,
}

const fn neuron(
    bearing_rad: f32,
    distance_per_reach: f32,
    left: [f32; 2],
    right: [f32; 2],
    has_won: bool,
) -> MapNeuron {
    MapNeuron { bearing_rad, distance_per_reach, left, right, has_won }
}

/// The neurons, column by column: neuron (column, row) is `MAP[column * ROWS + row]`. Used by reference (`&MAP`), it
/// stays in flash.
#[rustfmt::skip]
pub const MAP: [MapNeuron; COLUMNS * ROWS] = [
";

/// The map as a C99 header.
#[must_use]
pub fn to_c(map: &MapRecords) -> String {
    let header = map.header();
    let made = &header.provenance;
    let mut text = head(map, "//");
    text += "\n#ifndef EKM_MAP_H\n#define EKM_MAP_H\n\n#include <stdbool.h>\n#include <stdint.h>\n";
    // Writing to a string cannot fail.
    let mut constant = |what: &str, name: &str, value: String| {
        let _ = writeln!(text, "\n// {what}\n#define EKM_MAP_{name} {value}");
    };
    let hexadecimal = |value: u64| format!("UINT64_C(0x{value:016x})");
    constant("Format of the file it was read from.", "FORMAT_VERSION", header.format_version.to_string());
    constant("Number type of the controller that learned it.", "SCALAR", c_string(map.scalar_name()));
    constant("Neurons along the bearing.", "COLUMNS", header.columns.to_string());
    constant("Neurons along the distance.", "ROWS", header.rows.to_string());
    constant(
        "The unit of distances: the longest way of one training step, in m.",
        "REACH_M",
        c_float(header.reach_m),
    );
    constant("The unit c* of wheel speeds, in m/s.", "SPEED_LIMIT_MPS", c_float(header.speed_limit_mps));
    constant(
        "Wheel base of the robot that learned it, in m.",
        "WHEEL_BASE_M",
        c_float(header.robot.wheel_base_m),
    );
    constant("Radius of that robot's body, in m.", "BODY_RADIUS_M", c_float(header.robot.body_radius_m));
    constant(
        "Encoder counts per metre of its wheels' travel.",
        "ENCODER_COUNTS_PER_M",
        c_float(header.robot.encoder_counts_per_m),
    );
    constant(
        "Hash of the map in its scalar, as a board that holds it names it.",
        "HASH",
        hexadecimal(map.hash()),
    );
    constant("Seed of the run that trained it.", "SEED", format!("UINT64_C({})", made.seed));
    constant("Training steps it has seen.", "STEPS", format!("UINT32_C({})", made.steps));
    constant("Length of a training step, in ms.", "HORIZON_MS", made.horizon_ms.to_string());
    constant(
        "Digest of the configuration it was trained with.",
        "CONFIG_DIGEST",
        hexadecimal(made.config_digest),
    );
    constant("Version of the controller core that trained it.", "CORE_VERSION", c_string(&made.core_version));
    constant("Commit of the program that wrote the file it was read from.", "COMMIT", c_string(&made.commit));
    text += C_NEURON;
    for_each_neuron(map, &mut text, |neuron| {
        let [bearing, distance, a, b, c, d] = super::numbers(neuron).map(c_float);
        format!("{{{bearing}, {distance}, {{{a}, {b}}}, {{{c}, {d}}}, {}}}", neuron.has_won)
    });
    text + "};\n\n#endif\n"
}

const C_NEURON: &str = "
// One neuron: the place that it stands for, and the matrix that gives the wheel speeds to a place near it.
struct ekm_map_neuron {
    // Bearing of its place in rad, 0 ahead, positive to the left.
    float bearing_rad;
    // Distance of its place in units of EKM_MAP_REACH_M, negative behind.
    float distance_per_reach;
    // Row of the left wheel: c* per radian, c* per reach.
    float left[2];
    // Row of the right wheel: c* per radian, c* per reach.
    float right[2];
    // Whether it has won in training; if not, its matrix means nothing.
    bool has_won;
};

// The neurons, column by column: neuron (column, row) is ekm_map[column * EKM_MAP_ROWS + row].
static const struct ekm_map_neuron ekm_map[EKM_MAP_COLUMNS * EKM_MAP_ROWS] = {
";

/// One line for each neuron, and one before each column.
fn for_each_neuron(map: &MapRecords, text: &mut String, line: impl Fn(&NeuronRecord) -> String) {
    let (_, rows) = map.lattice();
    for (column, neurons) in map.neurons().chunks(rows).enumerate() {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "    // Column {column}.");
        for neuron in neurons {
            let _ = writeln!(text, "    {},", line(neuron));
        }
    }
}

/// The shortest decimal that reads back to the same bits; it has a point or an exponent.
fn rust_float(value: f32) -> String {
    format!("{value:?}")
}

fn c_float(value: f32) -> String {
    format!("{value:?}f")
}

/// A string for C, whatever is in it: what might be a trigraph, an escape or no ASCII goes as octal bytes.
fn c_string(content: &str) -> String {
    let quoted = content.bytes().fold(String::from("\""), |text, byte| {
        if is_plain(char::from(byte)) {
            text + char::from(byte).encode_utf8(&mut [0; 4])
        } else {
            text + &format!("\\{byte:03o}")
        }
    });
    quoted + "\""
}

/// For a comment, which nothing in the file may end.
fn plain(content: &str) -> String {
    content.chars().map(|letter| if is_plain(letter) { letter } else { '_' }).collect()
}

fn is_plain(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || matches!(letter, '.' | '+' | '-' | '_' | ' ')
}

#[cfg(test)]
mod tests {
    use super::{to_c, to_rust};
    use crate::map_report::tests::{header, learned, records};
    use crate::map_report::{MapRecords, numbers};
    use controller_core::scalar::Fixed;
    use protocol::map_file::NeuronRecord;
    use std::path::Path;
    use std::process::{Command, Output};
    use tempfile::TempDir;

    /// Numbers that are hard to print, behind a core version that is hard to quote.
    fn awkward() -> MapRecords {
        let mut header = header(2, 1);
        header.provenance.core_version = "1\\n\"*/\n??/é%s".try_into().unwrap();
        header.provenance.commit = "2\\n\"*/\n??/é%s".try_into().unwrap();
        (header.provenance.seed, header.provenance.steps) = (u64::MAX, u32::MAX);
        let largest = NeuronRecord {
            bearing_rad: f32::MAX,
            distance_per_reach: f32::MIN,
            left: [f32::MIN_POSITIVE, -f32::from_bits(1)],
            right: [-0.0, 1e16],
            has_won: true,
        };
        let plain = NeuronRecord { left: [1.0, 1e-7], right: [0.1, 16_777_216.0], ..NeuronRecord::default() };
        records(&header, &[largest, plain]).unwrap()
    }

    fn maps() -> [MapRecords; 3] {
        [learned::<f32>(1).0, learned::<Fixed>(1).0, awkward()]
    }

    /// The numbers of the lines of neurons: six reals and whether it has won.
    fn read_back(text: &str, start: &str) -> Vec<([u32; 6], bool)> {
        let (_, neurons) = text.split_once(start).unwrap();
        let lines = neurons.lines().skip(1).map(str::trim).take_while(|line| !line.starts_with([']', '}']));
        let neuron = |line: &str| {
            let words: Vec<&str> =
                line.split(|c: char| " ,(){}[]".contains(c)).filter(|w| !w.is_empty()).collect();
            let words = words.strip_prefix(&["neuron"]).unwrap_or(&words);
            let number = |i: usize| words[i].trim_end_matches('f').parse::<f32>().unwrap().to_bits();
            (core::array::from_fn(number), words[6].parse().unwrap())
        };
        lines.filter(|line| !line.starts_with("//")).map(neuron).collect()
    }

    fn of_map(map: &MapRecords) -> Vec<([u32; 6], bool)> {
        map.neurons().iter().map(|neuron| (numbers(neuron).map(f32::to_bits), neuron.has_won)).collect()
    }

    fn assert_well(output: &Output, text: &str) {
        assert!(output.status.success(), "{}\n{text}", String::from_utf8_lossy(&output.stderr));
    }

    /// Runs a compiler on a file of this text; the error is that there is none.
    fn compile(
        compiler: &str,
        arguments: &[&str],
        folder: &Path,
        name: &str,
        text: &str,
    ) -> std::io::Result<Output> {
        std::fs::write(folder.join(name), text).unwrap();
        Command::new(compiler).current_dir(folder).args(arguments).arg(name).output()
    }

    #[test]
    fn what_was_written_reads_back_bit_for_bit() {
        for map in maps() {
            assert_eq!(read_back(&to_rust(&map), "pub const MAP"), of_map(&map));
            assert_eq!(read_back(&to_c(&map), "static const struct"), of_map(&map));
        }
    }

    #[test]
    fn the_rust_text_compiles_without_any_crate_and_without_a_warning() {
        let rustc = std::env::var("RUSTC").unwrap_or_else(|_| String::from("rustc"));
        let folder = TempDir::new().unwrap();
        let arguments = [
            "--edition",
            "2021",
            "--crate-type",
            "lib",
            "--crate-name",
            "map",
            "--emit",
            "metadata",
            "-D",
            "warnings",
        ];
        for map in maps() {
            let text = to_rust(&map);
            // As a crate of its own, with more asked of it than a module would be.
            let crate_text = format!("//! A map.\n#![no_std]\n#![deny(missing_docs)]\n{text}");
            let output = compile(&rustc, &arguments, folder.path(), "map.rs", &crate_text).unwrap();
            assert_well(&output, &text);
        }
    }

    #[test]
    fn the_c_text_is_c99_and_may_be_included_twice() {
        let folder = TempDir::new().unwrap();
        let user = "#include \"map.h\"\n#include \"map.h\"\n\
                    float first(void);\nfloat first(void) { return ekm_map[0].left[1] * EKM_MAP_REACH_M; }\n";
        for map in maps() {
            let text = to_c(&map);
            std::fs::write(folder.path().join("map.h"), &text).unwrap();
            let arguments = ["-fsyntax-only", "-std=c99", "-Wall", "-Wextra", "-Werror"];
            match compile("cc", &arguments, folder.path(), "user.c", user) {
                Ok(output) => assert_well(&output, &text),
                Err(error) => println!("skipped: no C compiler `cc` here ({error})"),
            }
        }
    }

    #[test]
    fn the_text_says_what_made_it() {
        let (map, hash) = learned::<f32>(3);
        for text in [to_rust(&map), to_c(&map)] {
            for words in [
                "15 × 15 neurons",
                &format!("{hash:016x}"),
                "scalar f32 in 40 steps of 1024 ms, seed 3",
                "bearing          radians",
                &format!("0x{hash:016x}"),
            ] {
                assert!(text.contains(words), "{words} is missing in\n{text}");
            }
            assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
        }
    }
}
