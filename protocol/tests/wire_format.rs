//! `docs/wire_format.md` says what the code does: its tables, numbers and example are compared with it.
use controller_core::units::EncoderCounts;
use core::fmt::Write;
use postcard_schema::Schema;
use postcard_schema::schema::{DataModelType, DataModelVariant, NamedType, NamedValue};
use protocol::codec::Message;
use protocol::endpoint::LINK_SILENT_MS;
use protocol::frame::{FRAME_BYTES_MAX, encode};
use protocol::map_file::{self, COMMIT_BYTES, CORE_VERSION_BYTES, FORMAT_VERSION, MapHeader};
use protocol::message::{
    BUILD_ID_BYTES, CHECKPOINTS_PER_MESSAGE, FromBoard, FromHost, NEURONS_PER_MESSAGE, PROTOCOL_VERSION,
    Readings,
};
use protocol::schema;

const DOCUMENT: &str = include_str!("../../docs/wire_format.md");

/// What a heading stands over, up to the next of its level or above.
fn section(heading: &str) -> Option<&'static str> {
    let (_, rest) = DOCUMENT.split_once(&format!("\n{heading}\n"))?;
    let end = rest.find("\n## ").into_iter().chain(rest.find("\n### ")).min().unwrap_or(rest.len());
    Some(&rest[..end])
}

/// A type as the tables name it.
fn name(shape: &NamedType) -> String {
    match shape.ty {
        DataModelType::Bool => "bool".into(),
        DataModelType::U8 => "u8".into(),
        DataModelType::U16 => "u16".into(),
        DataModelType::U32 => "u32".into(),
        DataModelType::U64 => "u64".into(),
        DataModelType::I32 => "i32".into(),
        DataModelType::F32 => "f32".into(),
        DataModelType::String => "text".into(),
        DataModelType::Option(item) => format!("option of {}", name(item)),
        DataModelType::Seq(item) => format!("list of {}", name(item)),
        DataModelType::Tuple(items) => format!("{} × {}", items.len(), name(items[0])),
        DataModelType::Struct(_) | DataModelType::Enum(_) => shape.name.into(),
        other => panic!("{other:?} has no row in the table of types"),
    }
}

fn content(variant: &DataModelVariant) -> String {
    match variant {
        DataModelVariant::UnitVariant => "–".into(),
        DataModelVariant::NewtypeVariant(item) => name(item),
        DataModelVariant::TupleVariant(items) => panic!("{items:?}: name the fields"),
        DataModelVariant::StructVariant(fields) => {
            let fields: Vec<_> =
                fields.iter().map(|field| format!("`{}` {}", field.name, name(field.ty))).collect();
            fields.join(", ")
        }
    }
}

/// The rows of a type's table as they must begin, and the types it is made of.
fn rows(shape: &NamedType) -> (Vec<String>, Vec<&'static NamedType>) {
    let of = |fields: &[&NamedValue]| fields.iter().map(|field| field.ty).collect::<Vec<_>>();
    match shape.ty {
        DataModelType::Struct(fields) => {
            let row = |field: &&NamedValue| format!("| `{}` | {} |", field.name, name(field.ty));
            (fields.iter().map(row).collect(), of(fields))
        }
        DataModelType::Enum(variants) => {
            let row = |(number, name, content): (usize, _, _)| format!("| {number} | `{name}` | {content} |");
            let numbered =
                variants.iter().enumerate().map(|(i, variant)| (i, variant.name, content(variant.ty)));
            let parts = variants.iter().flat_map(|variant| match variant.ty {
                DataModelVariant::UnitVariant => Vec::new(),
                DataModelVariant::NewtypeVariant(item) => vec![*item],
                DataModelVariant::TupleVariant(items) => items.to_vec(),
                DataModelVariant::StructVariant(fields) => of(fields),
            });
            (numbered.map(row).collect(), parts.collect())
        }
        DataModelType::Option(item) | DataModelType::Seq(item) => (Vec::new(), vec![*item]),
        DataModelType::Tuple(items) => (Vec::new(), vec![items[0]]),
        _ => (Vec::new(), Vec::new()),
    }
}

#[test]
fn the_tables_are_those_of_the_types() {
    let mut open = vec![FromHost::SCHEMA, FromBoard::SCHEMA, MapHeader::SCHEMA];
    let mut seen = Vec::new();
    let mut wrong = String::new();
    while let Some(shape) = open.pop() {
        let (expected, parts) = rows(shape);
        open.extend(parts);
        if expected.is_empty() || seen.contains(&shape.name) {
            continue;
        }
        seen.push(shape.name);
        let table = section(&format!("### {}", shape.name)).unwrap_or_default();
        // Heading and rule are the first two.
        let found: Vec<_> = table.lines().filter(|line| line.starts_with('|')).skip(2).collect();
        let fits = |(row, expected): (&&str, &String)| row.starts_with(expected.as_str());
        if found.len() != expected.len() || !found.iter().zip(&expected).all(fits) {
            writeln!(wrong, "### {}\n{}", shape.name, expected.join(" …\n")).unwrap();
        }
    }
    assert!(wrong.is_empty(), "tables of docs/wire_format.md that should begin otherwise:\n{wrong}");
    let headings = DOCUMENT.lines().filter_map(|line| line.strip_prefix("### "));
    assert!(headings.clone().all(|heading| seen.contains(&heading)), "a table of no type");
    assert_eq!(headings.count(), seen.len());
}

#[test]
fn the_numbers_are_those_of_the_code() {
    let says = |text: &str| assert!(DOCUMENT.contains(text), "docs/wire_format.md does not say: {text}");
    says(&format!("# Wire format, version {PROTOCOL_VERSION}\n"));
    says(&format!("protocol/tests/golden/v{PROTOCOL_VERSION}.txt"));
    let (host, board) = (schema::key::<FromHost>(), schema::key::<FromBoard>());
    says(&format!(
        "In version {PROTOCOL_VERSION} it is\n   `{host:#06x}` from the host and `{board:#06x}` from the board."
    ));
    says(&format!("| `protocol_version` | u16 | {PROTOCOL_VERSION} |"));
    says(&format!("| `schema_hash` | u64 | `{:#018x}`", schema::HASH));
    says(&format!("The largest frame has {FRAME_BYTES_MAX} bytes"));
    says(&format!("| bytes of a frame, 0x00 included | {FRAME_BYTES_MAX} |"));
    says(&format!("| bytes of a body from the host | {} |", FromHost::MAX_BYTES));
    says(&format!("| bytes of a body from the board | {} |", FromBoard::MAX_BYTES));
    says(&format!("| checkpoints of a message | {CHECKPOINTS_PER_MESSAGE} |"));
    says(&format!("| neurons of a message | {NEURONS_PER_MESSAGE} |"));
    says(&format!("| bytes of `build_id` | {BUILD_ID_BYTES} |"));
    says(&format!("| `format_version` | u16 | {FORMAT_VERSION};"));
    says(&format!("| `core_version` | text | at most {CORE_VERSION_BYTES} bytes"));
    says(&format!("| `commit` | text | at most {COMMIT_BYTES} bytes"));
    says(&format!("| bytes of a map file of 15 × 15 neurons | {} |", map_file::encoded_bytes_max(225)));
    says(&format!("| silence in real time until the motors stop | {LINK_SILENT_MS} ms |"));
}

#[test]
fn the_example_is_what_the_encoder_writes() {
    let step = FromHost::Step(Readings {
        tick: 300,
        encoders: EncoderCounts { left: -1, right: 2 },
        ..Readings::default()
    });
    let mut buffer = [0; FRAME_BYTES_MAX];
    let frame = encode(7, &step, &mut buffer).unwrap();
    let hex = frame.iter().fold(String::new(), |text, byte| format!("{text} {byte:02x}"));
    let example = section("## An example").unwrap();
    assert!(example.contains(&format!("\nframe      {hex}\n")), "frame      {hex}");

    // The content, step by step: what stands there with the stuffing taken out.
    let mut content = Vec::new();
    let mut zero = usize::from(frame[0]);
    for (at, &byte) in frame.iter().enumerate().take(frame.len() - 1).skip(1) {
        content.push(if at == zero { 0 } else { byte });
        zero += if at == zero { usize::from(byte) } else { 0 };
    }
    let hex = content.iter().fold(String::new(), |text, byte| format!("{text} {byte:02x}"));
    assert!(example.contains(&format!("\ncontent    {hex}\n")), "content    {hex}");
    let crc = u32::from_le_bytes(*content.last_chunk::<4>().unwrap());
    assert!(example.contains(&format!("the CRC `{crc:#010x}`:")), "{crc:#010x}");
}
