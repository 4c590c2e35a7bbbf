//! Two maps neuron by neuron: whether they are the same, and if not, where and by how much.

use nalgebra::distance;
use protocol::map_file::NeuronRecord;
use serde::Serialize;

use super::{Extreme, MapRecords, elements, numbers};

/// Maps whose neurons have no counterparts in each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "the first has a lattice of {} × {} neurons, the second one of {} × {}; compare maps of the same lattice",
    a.0, a.1, b.0, b.1
)]
pub struct LatticesDiffer {
    /// Columns and rows of the first.
    pub a: (usize, usize),
    /// Columns and rows of the second.
    pub b: (usize, usize),
}

/// One thing that two headers say differently, as text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct HeaderDifference {
    /// What; numbers with their unit in the name.
    pub name: &'static str,
    /// What the first says.
    pub a: String,
    /// What the second says.
    pub b: String,
    /// Whether the map drives differently for it; if not, it only tells how the map was made.
    pub matters: bool,
}

/// How far one kind of number is apart, over all neurons, trained or not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Difference {
    /// Root of the mean square.
    pub rms: f64,
    /// The largest, without its sign.
    pub largest: Extreme,
}

/// What two maps of one lattice do not share.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// What the headers say differently.
    pub headers: Vec<HeaderDifference>,
    /// Neurons of each map.
    pub neurons: usize,
    /// Neurons of which at least one bit differs.
    pub differing: usize,
    /// Neurons that have won in training in the first map only.
    pub trained_only_in_a: usize,
    /// Neurons that have won in training in the second map only.
    pub trained_only_in_b: usize,
    /// Between the neurons' places in the plane, in m, each map in its own unit.
    pub place_m: Difference,
    /// Between their bearings, in degrees.
    pub bearing_deg: Difference,
    /// Between the elements of their matrices, in c* per radian or per reach.
    pub element: Difference,
}

impl Comparison {
    /// Whether a controller drives with both maps alike, bit for bit: the same neurons in the same units and scalar,
    /// for a robot of the same wheel base.
    ///
    /// How they were made does not count.
    #[must_use]
    pub fn is_same_map(&self) -> bool {
        self.differing == 0 && !self.headers.iter().any(|difference| difference.matters)
    }
}

/// Compares two maps.
///
/// # Errors
/// If their lattices differ: then no neuron has a counterpart.
pub fn compare(a: &MapRecords, b: &MapRecords) -> Result<Comparison, LatticesDiffer> {
    if a.lattice() != b.lattice() {
        return Err(LatticesDiffer { a: a.lattice(), b: b.lattice() });
    }
    let pairs = || a.neurons().iter().zip(b.neurons());
    let count = |which: &dyn Fn(&NeuronRecord, &NeuronRecord) -> bool| {
        pairs().filter(|(left, right)| which(left, right)).count()
    };
    let bearing_deg = |neuron: &NeuronRecord| f64::from(neuron.bearing_rad).to_degrees();
    Ok(Comparison {
        headers: header_differences(a, b),
        neurons: a.neurons().len(),
        differing: count(&|left, right| !is_same_neuron(left, right)),
        trained_only_in_a: count(&|left, right| left.has_won && !right.has_won),
        trained_only_in_b: count(&|left, right| right.has_won && !left.has_won),
        place_m: difference(
            a,
            pairs().map(|(left, right)| [distance(&a.position(left), &b.position(right))]),
        ),
        bearing_deg: difference(a, pairs().map(|(left, right)| [bearing_deg(left) - bearing_deg(right)])),
        element: difference(
            a,
            pairs().map(|(left, right)| {
                let (left, right) = (elements(left), elements(right));
                core::array::from_fn::<f64, 4, _>(|i| f64::from(left[i]) - f64::from(right[i]))
            }),
        ),
    })
}

/// Bit for bit: −0 is not 0.
fn is_same_neuron(a: &NeuronRecord, b: &NeuronRecord) -> bool {
    a.has_won == b.has_won && numbers(a).map(f32::to_bits) == numbers(b).map(f32::to_bits)
}

/// Sums up differences, so many for each neuron in turn.
fn difference<const N: usize>(map: &MapRecords, of_neurons: impl Iterator<Item = [f64; N]>) -> Difference {
    let (mut sum, mut count) = (0.0, 0.0);
    let absolute = of_neurons.map(|differences| {
        for difference in differences {
            sum += difference * difference;
            count += 1.0;
        }
        differences.iter().fold(0.0, |largest, difference| difference.abs().max(largest))
    });
    let largest = map.extreme(absolute);
    Difference { rms: libm::sqrt(sum / f64::max(count, 1.0)), largest }
}

fn header_differences(a: &MapRecords, b: &MapRecords) -> Vec<HeaderDifference> {
    let says = |map: &MapRecords| {
        let header = map.header();
        let made = &header.provenance;
        [
            ("format", header.format_version.to_string(), false),
            ("scalar", map.scalar_name().to_owned(), true),
            ("reach m", format!("{:?}", header.reach_m), true),
            ("speed limit m/s", format!("{:?}", header.speed_limit_mps), true),
            ("wheel base m", format!("{:?}", header.robot.wheel_base_m), true),
            ("body radius m", format!("{:?}", header.robot.body_radius_m), false),
            ("encoder counts/m", format!("{:?}", header.robot.encoder_counts_per_m), false),
            ("seed", made.seed.to_string(), false),
            ("steps", made.steps.to_string(), false),
            ("horizon ms", made.horizon_ms.to_string(), false),
            ("config digest", format!("{:016x}", made.config_digest), false),
            ("core version", made.core_version.as_str().to_owned(), false),
            ("commit", made.commit.as_str().to_owned(), false),
        ]
    };
    // Floats print so that different ones never look the same.
    let differs =
        |((name, a, matters), (_, b, _))| (a != b).then_some(HeaderDifference { name, a, b, matters });
    says(a).into_iter().zip(says(b)).filter_map(differs).collect()
}

#[cfg(test)]
mod tests {
    use super::{LatticesDiffer, compare};
    use crate::map_report::tests::{header, learned, records};
    use protocol::map_file::{MapHeader, NeuronRecord};
    use protocol::message::ScalarKind;

    #[test]
    fn a_map_is_the_same_as_itself_and_not_as_another() {
        let (one, _) = learned::<f32>(1);
        let same = compare(&one, &one).unwrap();
        assert!(same.is_same_map() && same.headers.is_empty(), "{same:?}");
        let (other, _) = learned::<f32>(2);
        let differs = compare(&one, &other).unwrap();
        assert!(!differs.is_same_map() && differs.differing > 0 && differs.place_m.rms > 0.0);
        assert_eq!(differs.headers.iter().map(|header| header.name).collect::<Vec<_>>(), ["seed"]);
    }

    #[test]
    fn provenance_does_not_make_another_map_but_units_and_scalar_do() {
        let neurons = [NeuronRecord::default(); 6];
        let map = |header: &MapHeader| records(header, &neurons).unwrap();
        let one = map(&header(2, 3));
        let mut elsewhere = header(2, 3);
        elsewhere.provenance.steps = 1;
        let comparison = compare(&one, &map(&elsewhere)).unwrap();
        assert!(comparison.is_same_map() && comparison.headers[0].name == "steps", "{comparison:?}");
        let faster = MapHeader { speed_limit_mps: 0.25_f32.next_up(), ..header(2, 3) };
        assert!(!compare(&one, &map(&faster)).unwrap().is_same_map());
        let mut wider = header(2, 3);
        wider.robot.wheel_base_m = 0.13;
        assert!(!compare(&one, &map(&wider)).unwrap().is_same_map());
        let mut rounder = header(2, 3);
        rounder.robot.body_radius_m = 0.07;
        rounder.provenance.commit = "ba9876543210".try_into().unwrap();
        let comparison = compare(&one, &map(&rounder)).unwrap();
        let names: Vec<_> = comparison.headers.iter().map(|header| header.name).collect();
        assert!(comparison.is_same_map() && names == ["body radius m", "commit"], "{comparison:?}");
        let fixed = MapHeader { scalar: ScalarKind::Fixed, ..header(2, 3) };
        assert!(!compare(&one, &map(&fixed)).unwrap().is_same_map());
    }

    #[test]
    fn differences_have_their_size_and_place() {
        let mut neurons = [NeuronRecord { distance_per_reach: 1.0, ..NeuronRecord::default() }; 6];
        let one = records(&header(2, 3), &neurons).unwrap();
        neurons[4].bearing_rad = core::f32::consts::PI;
        neurons[2].right[1] = -0.5;
        neurons[3].left[0] = -0.0;
        neurons[0].has_won = true;
        let other = records(&header(2, 3), &neurons).unwrap();
        let comparison = compare(&one, &other).unwrap();
        assert_eq!(comparison.differing, 4, "the sign of a zero counts");
        assert_eq!((comparison.trained_only_in_a, comparison.trained_only_in_b), (0, 1));
        let close = |a: f64, b: f64| (a - b).abs() < 1e-6;
        let place = comparison.place_m;
        // From 0.5 m ahead to 0.5 m behind.
        assert!(close(place.largest.value, 1.0) && close(place.rms, (1.0_f64 / 6.0).sqrt()), "{place:?}");
        assert_eq!((place.largest.at.column, place.largest.at.row), (1, 1));
        assert!((comparison.bearing_deg.largest.value - 180.0).abs() < 1e-4);
        let element = comparison.element;
        assert!(close(element.largest.value, 0.5) && close(element.rms, (0.25_f64 / 24.0).sqrt()));
        assert_eq!((element.largest.at.column, element.largest.at.row), (0, 2));
    }

    #[test]
    fn another_lattice_is_said_so() {
        let map = |columns, rows| records(&header(columns, rows), &[NeuronRecord::default(); 6]).unwrap();
        let error = compare(&map(2, 3), &map(3, 2)).unwrap_err();
        assert_eq!(error, LatticesDiffer { a: (2, 3), b: (3, 2) });
        assert!(error.to_string().contains("lattice of 2 × 3 neurons, the second one of 3 × 2"), "{error}");
    }
}
