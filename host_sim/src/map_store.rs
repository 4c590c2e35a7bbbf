//! Learned maps as files: the core's map to and from [`protocol::map_file`].
//!
//! Weights pass through `f32`, which holds those of both scalars exactly: what is loaded drives bit for bit as what was
//! saved. Only indirect maps can be stored; the direct one is a baseline that nobody takes to a robot.

use controller_core::config::Config;
use controller_core::kohonen::lattice::NeuronIndex;
use controller_core::kohonen::map::Map;
use controller_core::scalar::{Fixed, Scalar};
use controller_core::state_hash::StateHash;
use protocol::map_file::{self, FORMAT_VERSION, MapFileError, MapHeader, NeuronRecord, Provenance, Robot};
use protocol::map_fit::{Misfit, units};
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
    /// Another lattice, the other scalar, or another robot.
    #[error("{0}; {remedy}", remedy = remedy(.0))]
    Misfit(Misfit),
}

fn remedy(misfit: &Misfit) -> String {
    match misfit {
        Misfit::Lattice { .. } => String::from("train a new map"),
        Misfit::Scalar { found, expected } => {
            format!("use `--scalar {}` or train a map with {}", found.name(), expected.name())
        }
        Misfit::Robot { .. } => String::from(
            "use the configuration it was learned with, train a new map, or drive this robot with it all the same: \
             `--map-of-another-robot`",
        ),
    }
}

/// Whose maps are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LearnedOn {
    /// Only the robot of the configuration may have learned it.
    ThisRobot,
    /// Any robot may: its distances, speeds and turns are then taken for this one's.
    AnyRobot,
}

impl From<MapFileError> for MapStoreError {
    fn from(error: MapFileError) -> Self {
        Self::File(error)
    }
}

impl From<Misfit> for MapStoreError {
    fn from(misfit: Misfit) -> Self {
        Self::Misfit(misfit)
    }
}

/// A map from a file, and where it comes from.
#[derive(Debug, Clone)]
pub struct StoredMap<S: Scalar> {
    /// The map.
    pub map: HostMap<S, Indirect<S>>,
    /// How it was made.
    pub provenance: Provenance,
    /// In what the robot that learned it is another, where any was welcome.
    pub another_robot: Option<Misfit>,
}

/// The commit that this program was built from: see `build.rs`.
pub const COMMIT: &str = env!("EKM_NAV_COMMIT");

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
        robot: Robot::of(config),
        provenance: Provenance {
            seed,
            steps,
            horizon_ms: config.schedule.step_ms,
            config_digest: training_digest(config),
            // All crates of the workspace have one version, and it is shorter than the field.
            core_version: env!("CARGO_PKG_VERSION").try_into().unwrap_or_default(),
            commit: COMMIT.try_into().unwrap_or_default(),
        },
    };
    let records: Vec<NeuronRecord> = lattice().map(|index| NeuronRecord::of(map, index)).collect();
    let mut bytes = vec![0; map_file::encoded_bytes_max(records.len())];
    let length = map_file::encode(&header, &records, &mut bytes)?.len();
    bytes.truncate(length);
    Ok(bytes)
}

/// A map from the bytes of a file, if it fits the scalar and, unless any will do, the robot.
///
/// # Errors
/// What is wrong with the file, or does not fit, and what to do.
pub fn from_bytes<S: StoredScalar>(
    bytes: &[u8],
    config: &Config,
    learned_on: LearnedOn,
) -> Result<StoredMap<S>, MapStoreError> {
    let another_robot = match map_file::read_header(bytes)?.check_fit(S::KIND, config) {
        Ok(()) => None,
        Err(misfit @ Misfit::Robot { .. }) if learned_on == LearnedOn::AnyRobot => Some(misfit),
        Err(misfit) => return Err(misfit.into()),
    };
    let mut records = vec![NeuronRecord::default(); COLUMNS * ROWS];
    let header = map_file::decode(bytes, &mut records)?;
    let mut map: HostMap<S, Indirect<S>> = Map::regular();
    for (index, record) in lattice().zip(&records) {
        record.put(&mut map, index);
    }
    Ok(StoredMap { map, provenance: header.provenance, another_robot })
}

#[cfg(test)]
mod tests {
    use super::{LearnedOn, MapStoreError, StoredScalar, from_bytes, to_bytes};
    use crate::sil::Indirect;
    use crate::sweep::learn;
    use crate::training::TrainingPlan;
    use controller_core::config::Config;
    use controller_core::scalar::Fixed;
    use protocol::map_fit::Misfit;
    use protocol::message::ScalarKind;

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
        let stored = from_bytes::<S>(&bytes, &Config::default(), LearnedOn::ThisRobot).unwrap();
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
        let load = |bytes: &[u8], config: &Config| from_bytes::<f32>(bytes, config, LearnedOn::ThisRobot);
        let scalar = from_bytes::<Fixed>(&bytes, &config, LearnedOn::AnyRobot).unwrap_err();
        let expected = Misfit::Scalar { found: ScalarKind::F32, expected: ScalarKind::Fixed };
        assert_eq!(scalar, MapStoreError::Misfit(expected));
        assert!(scalar.to_string().ends_with("use `--scalar f32` or train a map with fixed"), "{scalar}");
        let mut faster = Config::default();
        faster.robot.speed_limit_mps = 0.2;
        let error = load(&bytes, &faster).unwrap_err();
        assert!(error.to_string().contains("robot.speed_limit_mps = 0.16"), "{error}");
        let cut = load(&bytes[..100], &config).unwrap_err();
        assert!(matches!(cut, MapStoreError::File(_)), "{cut}");
    }

    #[test]
    fn a_map_of_another_robot_is_loaded_where_that_is_meant() {
        let (map, bytes) = trained::<f32>();
        let mut wider = Config::default();
        wider.robot.wheel_base_m = 0.06;
        let refused = from_bytes::<f32>(&bytes, &wider, LearnedOn::ThisRobot).unwrap_err();
        let text = refused.to_string();
        for word in ["robot.wheel_base_m = 0.053", "has 0.06", "`--map-of-another-robot`"] {
            assert!(text.contains(word), "{text}");
        }
        let stored = from_bytes::<f32>(&bytes, &wider, LearnedOn::AnyRobot).unwrap();
        assert_eq!(stored.map, map);
        assert_eq!(stored.another_robot.map(MapStoreError::Misfit), Some(refused));
        let own = from_bytes::<f32>(&bytes, &Config::default(), LearnedOn::AnyRobot).unwrap();
        assert_eq!(own.another_robot, None);
    }
}
