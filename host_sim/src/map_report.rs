//! What a map file holds, for people: its statistics, its differences from another, and constants for flash.
//!
//! [`crate::map_store`] loads a map to drive with, and therefore asks for the robot it was learned on. Here the records
//! are taken as they stand in the file, so that maps of any robot, scalar and lattice can be looked at.

pub mod comparison;
pub mod export;

use controller_core::scalar::{Fixed, Scalar};
use controller_core::state_hash::StateHash;
use nalgebra::Point2;
use protocol::map_file::{self, MapFileError, MapHeader, NeuronRecord};
use protocol::message::ScalarKind;
use serde::Serialize;

/// Wins that one word of the hash holds, as [`controller_core::kohonen::map::Map`] keeps them.
const WINS_PER_WORD: usize = 32;

/// Why bytes are not a map to report on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MapReportError {
    /// Not a whole map file of this version.
    #[error("{0}; train a new map with `train --out FILE`")]
    File(#[from] MapFileError),
    /// A lattice without neurons.
    #[error(
        "has a lattice of {columns} × {rows} neurons, that is none; train a new map with `train --out FILE`"
    )]
    NoNeurons {
        /// The file's columns.
        columns: u8,
        /// The file's rows.
        rows: u8,
    },
    /// A unit of the map's numbers, or a length of the robot, that is none.
    #[error("has {name} = {found}, which must be above 0; train a new map with `train --out FILE`")]
    Unit {
        /// Which number of the header.
        name: &'static str,
        /// The file's.
        found: f32,
    },
}

/// The contents of a map file: a header with units above 0, and at least one neuron.
#[derive(Debug, Clone, PartialEq)]
pub struct MapRecords {
    header: MapHeader,
    neurons: Vec<NeuronRecord>,
}

/// Where a neuron stands on the lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct LatticePlace {
    /// Along the bearing, from 0, which begins at the right.
    pub column: usize,
    /// Along the distance, from 0, which begins behind.
    pub row: usize,
}

/// A number, and the neuron that has it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extreme {
    /// The number.
    pub value: f64,
    /// The first neuron that has it.
    pub at: LatticePlace,
}

/// What the trained neurons of a map span.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Extent {
    /// Largest distance ahead, in m; 0 where none is ahead.
    pub ahead_m: f64,
    /// Largest distance behind, in m, not negative; 0 where none is behind.
    pub behind_m: f64,
    /// Least bearing, in degrees: the farthest to the right.
    pub bearing_low_deg: f64,
    /// Largest bearing, in degrees: the farthest to the left.
    pub bearing_high_deg: f64,
    /// Mean `M_i`: rows left and right, columns c* per radian and c* per reach.
    pub mean_matrix: [[f64; 2]; 2],
}

/// A map in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MapStatistics {
    /// Neurons of the lattice.
    pub neurons: usize,
    /// Those that have won in training.
    pub trained: usize,
    /// What the trained ones span; `None` where there are none.
    pub extent: Option<Extent>,
    /// Largest absolute sensory weight of all neurons, in rad or in reaches; 16-bit weights end at 8.
    pub largest_weight: Extreme,
    /// Largest absolute matrix element of all neurons, in c* per radian or per reach; 16-bit weights end at 8.
    pub largest_element: Extreme,
}

impl MapRecords {
    /// Reads the bytes of a map file.
    ///
    /// # Errors
    /// What is wrong with the file, and what to do.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, MapReportError> {
        let header = map_file::read_header(bytes)?;
        if header.neuron_count() == 0 {
            return Err(MapReportError::NoNeurons { columns: header.columns, rows: header.rows });
        }
        for (name, found) in header.reals() {
            if found <= 0.0 {
                return Err(MapReportError::Unit { name, found });
            }
        }
        let mut neurons = vec![NeuronRecord::default(); header.neuron_count()];
        let header = map_file::decode(bytes, &mut neurons)?;
        Ok(Self { header, neurons })
    }

    /// What the file says of itself.
    #[must_use]
    pub const fn header(&self) -> &MapHeader {
        &self.header
    }

    /// The neurons, column by column.
    #[must_use]
    pub fn neurons(&self) -> &[NeuronRecord] {
        &self.neurons
    }

    /// Neurons along the bearing, and along the distance; both at least 1.
    #[must_use]
    pub fn lattice(&self) -> (usize, usize) {
        (usize::from(self.header.columns), usize::from(self.header.rows))
    }

    /// Where on the lattice the neuron stands that has this place in [`Self::neurons`].
    #[must_use]
    pub fn lattice_place(&self, index: usize) -> LatticePlace {
        let (_, rows) = self.lattice();
        LatticePlace { column: index / rows, row: index % rows }
    }

    /// Name of the scalar it was learned with, as `--scalar` takes it.
    #[must_use]
    pub fn scalar_name(&self) -> &'static str {
        self.header.scalar.name()
    }

    /// Hash of the map in its own scalar: what [`controller_core::kohonen::map::Map::hash`] gives, and a board names.
    #[must_use]
    pub fn hash(&self) -> u64 {
        match self.header.scalar {
            ScalarKind::F32 => self.hash_in::<f32>(),
            ScalarKind::Fixed => self.hash_in::<Fixed>(),
        }
    }

    fn hash_in<S: Scalar>(&self) -> u64 {
        let mut hash = StateHash::default();
        let (_, rows) = self.lattice();
        for column in self.neurons.chunks(rows) {
            for weight in column.iter().flat_map(numbers) {
                hash.add(S::from_weight(S::from_f32(weight).to_weight()));
            }
            for wins in column.chunks(WINS_PER_WORD) {
                hash.add_word(
                    wins.iter().rev().fold(0, |word, neuron| word << 1 | u32::from(neuron.has_won)),
                );
            }
        }
        hash.value()
    }

    /// Where a neuron stands in the robot's frame, in m: x ahead, y to the left.
    #[must_use]
    pub fn position(&self, neuron: &NeuronRecord) -> Point2<f64> {
        let (sin, cos) = libm::sincos(f64::from(neuron.bearing_rad));
        let distance_m = self.distance_m(neuron);
        Point2::new(distance_m * cos, distance_m * sin)
    }

    fn distance_m(&self, neuron: &NeuronRecord) -> f64 {
        f64::from(neuron.distance_per_reach) * f64::from(self.header.reach_m)
    }

    /// The map in numbers.
    #[must_use]
    pub fn statistics(&self) -> MapStatistics {
        let of_weight = |neuron: &NeuronRecord| largest_absolute(&weights(neuron));
        let of_element = |neuron: &NeuronRecord| largest_absolute(&elements(neuron));
        MapStatistics {
            neurons: self.neurons.len(),
            trained: self.trained().count(),
            extent: self.extent(),
            largest_weight: self.extreme(self.neurons.iter().map(of_weight)),
            largest_element: self.extreme(self.neurons.iter().map(of_element)),
        }
    }

    fn trained(&self) -> impl Iterator<Item = &NeuronRecord> {
        self.neurons.iter().filter(|neuron| neuron.has_won)
    }

    fn extent(&self) -> Option<Extent> {
        let first = self.trained().next()?;
        let bearing_deg = |neuron: &NeuronRecord| f64::from(neuron.bearing_rad).to_degrees();
        let mut extent = Extent {
            ahead_m: 0.0,
            behind_m: 0.0,
            bearing_low_deg: bearing_deg(first),
            bearing_high_deg: bearing_deg(first),
            mean_matrix: [[0.0; 2]; 2],
        };
        let mut count = 0.0;
        for neuron in self.trained() {
            let (distance_m, bearing_deg) = (self.distance_m(neuron), bearing_deg(neuron));
            extent.ahead_m = extent.ahead_m.max(distance_m);
            extent.behind_m = extent.behind_m.max(-distance_m);
            extent.bearing_low_deg = extent.bearing_low_deg.min(bearing_deg);
            extent.bearing_high_deg = extent.bearing_high_deg.max(bearing_deg);
            for (sums, row) in extent.mean_matrix.iter_mut().zip([neuron.left, neuron.right]) {
                for (sum, element) in sums.iter_mut().zip(row) {
                    *sum += f64::from(element);
                }
            }
            count += 1.0;
        }
        extent.mean_matrix.iter_mut().flatten().for_each(|sum| *sum /= count);
        Some(extent)
    }

    /// The largest of numbers that are not negative, one for each neuron in turn.
    fn extreme(&self, values: impl Iterator<Item = f64>) -> Extreme {
        let first = Extreme { value: 0.0, at: self.lattice_place(0) };
        values.enumerate().fold(first, |largest, (index, value)| {
            if value > largest.value { Extreme { value, at: self.lattice_place(index) } } else { largest }
        })
    }
}

/// The sensory weights of a neuron, in rad and in reaches.
fn weights(neuron: &NeuronRecord) -> [f32; 2] {
    [neuron.bearing_rad, neuron.distance_per_reach]
}

/// The elements of its matrix, row by row.
fn elements(neuron: &NeuronRecord) -> [f32; 4] {
    let ([left_bearing, left_distance], [right_bearing, right_distance]) = (neuron.left, neuron.right);
    [left_bearing, left_distance, right_bearing, right_distance]
}

/// All its numbers, in the order of the file.
fn numbers(neuron: &NeuronRecord) -> [f32; 6] {
    let ([bearing, distance], [a, b, c, d]) = (weights(neuron), elements(neuron));
    [bearing, distance, a, b, c, d]
}

fn largest_absolute(values: &[f32]) -> f64 {
    values.iter().fold(0.0, |largest, value| f64::from(value.abs()).max(largest))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::{MapRecords, MapReportError};
    use crate::map_store::{StoredScalar, to_bytes};
    use crate::sil::Indirect;
    use crate::sweep::learn;
    use crate::training::TrainingPlan;
    use controller_core::config::Config;
    use controller_core::scalar::Fixed;
    use protocol::map_file::{self, FORMAT_VERSION, MapHeader, NeuronRecord, Provenance, Robot};
    use protocol::message::ScalarKind;

    /// A map that was learned in a few steps, and the hash that the core gives it.
    pub(crate) fn learned<S: StoredScalar>(seed: u64) -> (MapRecords, u64) {
        let config = Config::default();
        let plan = TrainingPlan { steps: 40, seed, ..TrainingPlan::default() };
        let map = learn::<S, Indirect<S>>(&config, &plan, &|| {}).unwrap().map;
        let bytes = to_bytes(&map, &config, plan.seed, plan.steps).unwrap();
        (MapRecords::from_bytes(&bytes).unwrap(), map.hash())
    }

    pub(crate) fn header(columns: u8, rows: u8) -> MapHeader {
        MapHeader {
            format_version: FORMAT_VERSION,
            scalar: ScalarKind::F32,
            columns,
            rows,
            reach_m: 0.5,
            speed_limit_mps: 0.25,
            robot: Robot { wheel_base_m: 0.125, body_radius_m: 0.0625, encoder_counts_per_m: 8192.0 },
            provenance: Provenance {
                seed: 7,
                steps: 2000,
                horizon_ms: 2000,
                config_digest: 0x0123_4567_89ab_cdef,
                core_version: "0.1.0".try_into().unwrap(),
                commit: "0123456789ab".try_into().unwrap(),
            },
        }
    }

    /// A map of any header and neurons, by way of a file.
    pub(crate) fn records(
        header: &MapHeader,
        neurons: &[NeuronRecord],
    ) -> Result<MapRecords, MapReportError> {
        let mut out = vec![0; map_file::encoded_bytes_max(neurons.len())];
        MapRecords::from_bytes(map_file::encode(header, neurons, &mut out).unwrap())
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-6
    }

    #[test]
    fn the_hash_is_the_cores() {
        let (records, hash) = learned::<f32>(1);
        assert_eq!(records.hash(), hash);
        let (records, hash) = learned::<Fixed>(1);
        assert_eq!(records.hash(), hash);
    }

    #[test]
    fn statistics_are_of_the_trained_neurons_and_extremes_of_all() {
        let mut neurons = [NeuronRecord::default(); 6];
        let ahead = NeuronRecord {
            bearing_rad: 0.5,
            distance_per_reach: 0.8,
            left: [-1.0, 2.0],
            right: [3.0, 4.0],
            has_won: true,
        };
        let behind = NeuronRecord { bearing_rad: -1.0, distance_per_reach: -0.2, left: [3.0, 2.0], ..ahead };
        let untrained =
            NeuronRecord { distance_per_reach: -6.0, right: [0.0, -7.0], has_won: false, ..ahead };
        (neurons[1], neurons[3], neurons[5]) = (ahead, behind, untrained);
        let map = records(&header(2, 3), &neurons).unwrap();
        let statistics = map.statistics();
        assert_eq!((statistics.neurons, statistics.trained), (6, 2));
        let extent = statistics.extent.unwrap();
        assert!(close(extent.ahead_m, 0.4) && close(extent.behind_m, 0.1), "{extent:?}");
        assert!(close(extent.bearing_low_deg, (-1.0_f64).to_degrees()), "{extent:?}");
        assert!(close(extent.bearing_high_deg, 0.5_f64.to_degrees()), "{extent:?}");
        let [[a, b], [c, d]] = extent.mean_matrix;
        assert!(close(a, 1.0) && close(b, 2.0) && close(c, 3.0) && close(d, 4.0), "{extent:?}");
        let (weight, element) = (statistics.largest_weight, statistics.largest_element);
        assert!(close(weight.value, 6.0) && close(element.value, 7.0), "{statistics:?}");
        assert_eq!((weight.at.column, weight.at.row), (1, 2));
        assert_eq!(element.at, weight.at);
        let place = map.position(&ahead);
        assert!(close(place.x, 0.4 * 0.5_f64.cos()) && close(place.y, 0.4 * 0.5_f64.sin()), "{place}");
    }

    #[test]
    fn a_map_without_a_trained_neuron_has_no_extent() {
        let statistics = records(&header(2, 3), &[NeuronRecord::default(); 6]).unwrap().statistics();
        assert_eq!((statistics.trained, statistics.extent), (0, None));
    }

    #[test]
    fn what_has_no_neurons_or_no_units_is_refused() {
        let none = records(&header(0, 3), &[]).unwrap_err();
        assert_eq!(none, MapReportError::NoNeurons { columns: 0, rows: 3 });
        let still = MapHeader { speed_limit_mps: 0.0, ..header(1, 1) };
        let error = records(&still, &[NeuronRecord::default()]).unwrap_err();
        assert!(error.to_string().contains("speed_limit_mps = 0"), "{error}");
        let mut baseless = header(1, 1);
        baseless.robot.wheel_base_m = -0.1;
        let error = records(&baseless, &[NeuronRecord::default()]).unwrap_err();
        assert!(error.to_string().contains("wheel_base_m = -0.1, which must be above 0"), "{error}");
        let error = MapRecords::from_bytes(b"EKM-MAP\n").unwrap_err();
        assert!(error.to_string().contains("has been cut"), "{error}");
    }
}
