//! The map that is built into the image: the file is checked here, and becomes a table in the board's own weights.
//!
//! What does not fit fails the build, with what was found, what was expected and what to do. The board checks nothing.

use core::fmt::Write;
use std::fs;
use std::path::Path;

use controller_core::config::Config;
use controller_core::scalar::{Fixed, Scalar};
use protocol::map_file::{self, MapHeader, NeuronRecord};
use protocol::map_fit::Misfit;
use protocol::message::ScalarKind;

/// How a map is made for a board of this scalar.
fn command(scalar: ScalarKind) -> String {
    format!("`cargo run --release -- train --scalar {} --out FILE.ekm`", scalar.name())
}

/// The source text of the table that `src/flash_map.rs` includes; without a file it says that there is none.
pub fn source(file: Option<&Path>, scalar: ScalarKind) -> Result<String, String> {
    let Some(file) = file else {
        return Ok(String::from(
            "/// The map in flash: none.\npub const IN_FLASH: Option<&FlashMap> = None;\n",
        ));
    };
    let refused = |what: String| format!("{}: {what}", file.display());
    let bytes = fs::read(file)
        .map_err(|error| refused(format!("cannot be read ({error}); {} makes a map", command(scalar))))?;
    table(&bytes, scalar).map_err(refused)
}

/// As [`source`], of the bytes of a file.
pub fn table(file: &[u8], scalar: ScalarKind) -> Result<String, String> {
    let (header, neurons) =
        read(file).map_err(|error| format!("{error}; {} makes a map", command(scalar)))?;
    header.check_fit(scalar, &Config::default()).map_err(|misfit| {
        let remedy = match misfit {
            Misfit::Robot { .. } => {
                "firmware starts with the defaults of `controller_core::config`: train on that robot"
            }
            Misfit::Lattice { .. } | Misfit::Scalar { .. } => "train one for this board",
        };
        format!("{misfit}; {remedy}, with {}", command(scalar))
    })?;
    if !neurons.iter().any(|neuron| neuron.has_won) {
        return Err(format!("none of its neurons has learned anything; train one with {}", command(scalar)));
    }
    Ok(text(&header, &neurons))
}

fn read(file: &[u8]) -> Result<(MapHeader, Vec<NeuronRecord>), map_file::MapFileError> {
    let mut neurons = vec![NeuronRecord::default(); map_file::read_header(file)?.neuron_count()];
    map_file::decode(file, &mut neurons).map(|header| (header, neurons))
}

fn text(header: &MapHeader, neurons: &[NeuronRecord]) -> String {
    let (bits, from_bits) = match header.scalar {
        ScalarKind::F32 => ("u32", "f32::from_bits"),
        ScalarKind::Fixed => ("i16", "controller_core::scalar::FixedWeight::from_bits"),
    };
    let rows = usize::from(header.rows).max(1);
    let won = |column: &[NeuronRecord]| {
        column.iter().rev().fold(0_u32, |word, neuron| word << 1 | u32::from(neuron.has_won))
    };
    let won: Vec<u32> = neurons.chunks(rows).map(won).collect();
    let mut text = format!(
        "const fn neuron(bits: [{bits}; 6]) -> MapNeuron {{\n    \
             let [bearing, distance, a, b, c, d] = bits;\n    \
             let output = ControlMatrix {{ left: [{from_bits}(a), {from_bits}(b)], \
             right: [{from_bits}(c), {from_bits}(d)] }};\n    \
             MapNeuron {{ bearing: {from_bits}(bearing), distance: {from_bits}(distance), output }}\n}}\n\n\
         static LEARNED: FlashMap = FlashMap {{\n    \
             trained_steps: {steps},\n    won: {won:?},\n    neurons: [\n",
        steps = header.provenance.steps,
    );
    for column in neurons.chunks(rows) {
        text += "        [\n";
        for neuron in column {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "            neuron({}),", bits_of(neuron, header.scalar));
        }
        text += "        ],\n";
    }
    text += "    ],\n};\n\n/// The map in flash.\npub const IN_FLASH: Option<&FlashMap> = Some(&LEARNED);\n";
    text
}

/// Its six weights as the board holds them, bit for bit.
fn bits_of(neuron: &NeuronRecord, scalar: ScalarKind) -> String {
    let ([a, b], [c, d]) = (neuron.left, neuron.right);
    let weights = [neuron.bearing_rad, neuron.distance_per_reach, a, b, c, d];
    match scalar {
        ScalarKind::F32 => format!("{:?}", weights.map(f32::to_bits)),
        ScalarKind::Fixed => format!("{:?}", weights.map(|x| Fixed::from_f32(x).to_weight().to_bits())),
    }
}
