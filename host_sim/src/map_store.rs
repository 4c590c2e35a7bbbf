//! Learned maps as files: the core's map to and from [`protocol::map_file`].
//!
//! Weights pass through `f32`, which holds those of both scalars exactly: what is loaded drives bit for bit as what was
//! saved. Only indirect maps can be stored; the direct one is a baseline that nobody takes to a robot.

use controller_core::config::Config;
use controller_core::kohonen::features::Scaling;
use controller_core::kohonen::lattice::NeuronIndex;
use controller_core::kohonen::map::Map;
use controller_core::scalar::{Fixed, Scalar};
use controller_core::state_hash::StateHash;
use protocol::map_file::{self, FORMAT_VERSION, MapFileError, MapHeader, NeuronRecord, Provenance};
use protocol::message::ScalarKind;

use crate::sil::{COLUMNS, HostMap, Indirect, ROWS};

/// A scalar that map files know.
pub trait StoredScalar: Scalar {
    /// What the file calls it.
    const KIND: ScalarKind;
}

impl StoredScalar for f32 {
    const KIND: ScalarKind = ScalarKind::F32;
}

impl StoredScalar for Fixed {
    const KIND: ScalarKind = ScalarKind::Fixed;
}

/// Why a file is not a map for this robot.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MapStoreError {
    /// Not a whole map file of this version.
    #[error("{0}; train a new map with `train --out FILE`")]
    File(MapFileError),
    /// Learned with the other scalar.
    #[error(
        "was learned with scalar {found}, not {expected}; use `--scalar {found}` or train a map with {expected}"
    )]
    Scalar {
        /// The file's.
        found: &'static str,
        /// The one asked for.
        expected: &'static str,
    },
    /// Another lattice.
    #[error(
        "has a lattice of {columns} × {rows} neurons, the controller one of {COLUMNS} × {ROWS}; train a new map"
    )]
    Lattice {
        /// The file's columns.
        columns: u8,
        /// The file's rows.
        rows: u8,
    },
    /// Another robot: the weights would mean other distances and speeds.
    #[error(
        "was learned with {name} = {found}, the configuration has {expected}; use the configuration it was learned \
         with, or train a new map"
    )]
    Robot {
        /// Which number.
        name: &'static str,
        /// The file's.
        found: f32,
        /// The configuration's.
        expected: f32,
    },
}

impl From<MapFileError> for MapStoreError {
    fn from(error: MapFileError) -> Self {
        Self::File(error)
    }
}

/// A map from a file, and where it comes from.
#[derive(Debug, Clone)]
pub struct StoredMap<S: Scalar> {
    /// The map.
    pub map: HostMap<S, Indirect<S>>,
    /// How it was made.
    pub provenance: Provenance,
}

/// Digest of what training depends on; maps with the same digest, seed and steps are the same.
#[must_use]
pub fn training_digest(config: &Config) -> u64 {
    let mut hash = StateHash::default();
    // `Debug` prints floats so that they can be read back exactly, and names the fields.
    let parts = (&config.robot, &config.servo, &config.schedule.step_ms, &config.learning, &config.reaching);
    for byte in format!("{parts:?}").bytes() {
        hash.add_word(u32::from(byte));
    }
    hash.value()
}

/// The two units of the map's numbers: the reach and the top speed.
fn units(config: &Config) -> (f32, f32) {
    let speed = config.robot.speed_limit_mps;
    let step_s = f32::from(config.schedule.step_ms) / 1000.0;
    (Scaling::<f32>::new(speed, step_s).reach_m(), speed)
}

/// All neurons, column by column, as the file has them.
pub(crate) fn lattice() -> impl Iterator<Item = NeuronIndex> {
    // The file counts columns and rows in a `u8` each, and `Map` asserts that they fit.
    let count = |count: usize| 0..u8::try_from(count).unwrap_or(u8::MAX);
    count(COLUMNS).flat_map(move |column| count(ROWS).map(move |row| NeuronIndex { column, row }))
}

/// A map as the bytes of a file.
///
/// # Errors
/// If a weight is not finite, which no training brings about.
pub fn to_bytes<S: StoredScalar>(
    map: &HostMap<S, Indirect<S>>,
    config: &Config,
    seed: u64,
    steps: u32,
) -> Result<Vec<u8>, MapFileError> {
    let (reach_m, speed_limit_mps) = units(config);
    let narrow = |count: usize| u8::try_from(count).unwrap_or(u8::MAX);
    let header = MapHeader {
        format_version: FORMAT_VERSION,
        scalar: S::KIND,
        columns: narrow(COLUMNS),
        rows: narrow(ROWS),
        reach_m,
        speed_limit_mps,
        provenance: Provenance {
            seed,
            steps,
            horizon_ms: config.schedule.step_ms,
            config_digest: training_digest(config),
            // All crates of the workspace have one version, and it is shorter than the field.
            core_version: env!("CARGO_PKG_VERSION").try_into().unwrap_or_default(),
        },
    };
    let records: Vec<NeuronRecord> = lattice().map(|index| NeuronRecord::of(map, index)).collect();
    let mut bytes = vec![0; map_file::encoded_bytes_max(records.len())];
    let length = map_file::encode(&header, &records, &mut bytes)?.len();
    bytes.truncate(length);
    Ok(bytes)
}

/// A map from the bytes of a file, if it fits the scalar and the robot.
///
/// # Errors
/// What is wrong with the file, or does not fit, and what to do.
pub fn from_bytes<S: StoredScalar>(bytes: &[u8], config: &Config) -> Result<StoredMap<S>, MapStoreError> {
    let header = map_file::read_header(bytes)?;
    if (usize::from(header.columns), usize::from(header.rows)) != (COLUMNS, ROWS) {
        return Err(MapStoreError::Lattice { columns: header.columns, rows: header.rows });
    }
    if header.scalar != S::KIND {
        let found = match header.scalar {
            ScalarKind::F32 => f32::NAME,
            ScalarKind::Fixed => Fixed::NAME,
        };
        return Err(MapStoreError::Scalar { found, expected: S::NAME });
    }
    let (reach_m, speed_limit_mps) = units(config);
    let fits = |name, found: f32, expected: f32| {
        // Bit for bit: the file holds the very number, not a measurement.
        if found.to_bits() == expected.to_bits() {
            Ok(())
        } else {
            Err(MapStoreError::Robot { name, found, expected })
        }
    };
    fits("robot.speed_limit_mps", header.speed_limit_mps, speed_limit_mps)?;
    fits("the reach of a step in m", header.reach_m, reach_m)?;
    let mut records = vec![NeuronRecord::default(); COLUMNS * ROWS];
    let header = map_file::decode(bytes, &mut records)?;
    let mut map: HostMap<S, Indirect<S>> = Map::regular();
    for (index, record) in lattice().zip(&records) {
        record.put(&mut map, index);
    }
    Ok(StoredMap { map, provenance: header.provenance })
}

#[cfg(test)]
mod tests {
    use super::{MapStoreError, StoredScalar, from_bytes, to_bytes};
    use crate::sil::Indirect;
    use crate::sweep::learn;
    use crate::training::TrainingPlan;
    use controller_core::config::Config;
    use controller_core::scalar::Fixed;

    fn trained<S: StoredScalar>() -> (crate::sil::HostMap<S, Indirect<S>>, Vec<u8>) {
        let config = Config::default();
        let plan = TrainingPlan { steps: 20, ..TrainingPlan::default() };
        let map = learn::<S, Indirect<S>>(&config, &plan, &|| {}).unwrap().map;
        let bytes = to_bytes(&map, &config, plan.seed, plan.steps).unwrap();
        (map, bytes)
    }

    fn check<S: StoredScalar>() {
        let (map, bytes) = trained::<S>();
        assert!(map.trained_count() > 0);
        let stored = from_bytes::<S>(&bytes, &Config::default()).unwrap();
        assert_eq!(stored.map, map);
        assert_eq!((stored.provenance.seed, stored.provenance.steps), (1, 20));
    }

    #[test]
    fn what_was_saved_is_loaded_bit_for_bit() {
        check::<f32>();
        check::<Fixed>();
    }

    #[test]
    fn what_does_not_fit_is_refused_with_its_name() {
        let (_, bytes) = trained::<f32>();
        let config = Config::default();
        let scalar = from_bytes::<Fixed>(&bytes, &config).unwrap_err();
        assert_eq!(scalar, MapStoreError::Scalar { found: "f32", expected: "fixed" });
        let mut faster = Config::default();
        faster.robot.speed_limit_mps = 0.2;
        let error = from_bytes::<f32>(&bytes, &faster).unwrap_err();
        assert!(error.to_string().contains("robot.speed_limit_mps = 0.16"), "{error}");
        let cut = from_bytes::<f32>(&bytes[..100], &config).unwrap_err();
        assert!(matches!(cut, MapStoreError::File(_)), "{cut}");
    }
}
