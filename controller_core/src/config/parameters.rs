//! The one list of all parameters: number, name, unit, range, and how each is read and written.
//!
//! [`Config::validate`], [`Config::get`], [`Config::set`] and [`Config::hash`] follow from it, and what people see when
//! they ask for the parameters. The link numbers parameters by their place in the list, so a new one goes to its end,
//! wherever its field stands in [`Config`], and none is ever taken out or moved.
//!
//! Rules between parameters are not here: the order in which parameters are set must not matter, so
//! [`Config::validate`] checks those when all are set.

use super::{Architecture, Config, ConfigError, Must, WiringKind, within};
use crate::kohonen::features::Chart;
use crate::kohonen::map::Eligible;
use crate::kohonen::self_organisation::{Displacement, StepRule};
use crate::localisation::obstacle::FieldCentre;
use crate::motor_control::Beyond;
use crate::state_hash::StateHash;

/// One number of the configuration, for whoever lists, reads and sets them without knowing them.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// As written in a configuration file: `servo.stall_share`.
    pub name: &'static str,
    /// SI, or milliseconds; `1` for shares, counts, lattice units and whatever else has none.
    pub unit: &'static str,
    /// Smallest value.
    pub low: f32,
    /// Largest value.
    pub high: f32,
    /// The range in words, to follow "must be".
    pub must: &'static str,
    /// Which of the numbers within the range are meant.
    pub kind: Kind,
    number: u8,
}

/// What is needed to read and set a parameter, without its words: those a microcontroller has no room for.
pub(super) struct Slot {
    low: f32,
    high: f32,
    is_whole: bool,
    pub(super) read: fn(&Config) -> f32,
    write: fn(&mut Config, f32),
}

impl Slot {
    /// As [`Parameter::check`]; this is the slot of parameter `number`.
    pub(super) fn check(&self, number: u8, value: f32) -> Result<(), ConfigError> {
        within(number, value, (self.low, self.high), Must::BeInRange)?;
        if !self.is_whole || value - f32::from(count(value)) == 0.0 {
            Ok(())
        } else {
            Err(ConfigError { number, value, must: Must::BeWhole })
        }
    }
}

/// Which numbers a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Any within the range.
    Real,
    /// Whole numbers.
    Count,
    /// The number of one of these names, counted from 0.
    Choice(&'static [&'static str]),
}

impl Parameter {
    /// The value in [`Config::default`].
    #[must_use]
    pub fn default_value(&self) -> f32 {
        Config::default().get(usize::from(self.number)).unwrap_or_default()
    }

    /// Whether the parameter may have this value, as far as it alone can tell.
    ///
    /// # Errors
    /// Not a number, out of range, or a fraction of what is counted or chosen.
    pub fn check(&self, value: f32) -> Result<(), ConfigError> {
        match SLOTS.get(usize::from(self.number)) {
            Some(slot) => slot.check(self.number, value),
            None => Ok(()),
        }
    }
}

impl Config {
    /// The parameter of this number, in the unit of the list; `None` beyond its end.
    #[must_use]
    pub fn get(&self, index: usize) -> Option<f32> {
        SLOTS.get(index).map(|slot| (slot.read)(self))
    }

    /// Sets the parameter of this number. Whether it goes with the others is for [`Config::validate`] to say.
    ///
    /// # Errors
    /// There is no such parameter, or the value is none that it may have; nothing is changed.
    pub fn set(&mut self, index: usize, value: f32) -> Result<(), ConfigError> {
        let Some((slot, number)) = SLOTS.get(index).zip(u8::try_from(index).ok()) else {
            let value = u16::try_from(index).map_or(f32::INFINITY, f32::from);
            return Err(ConfigError { number: ConfigError::NO_PARAMETER, value, must: Must::BeListed });
        };
        slot.check(number, value)?;
        (slot.write)(self, value);
        Ok(())
    }

    /// Hash over all parameters in the order of the list: two ends with the same hash work with the same numbers.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let mut hash = StateHash::default();
        for slot in &SLOTS {
            // −0 + 0 is 0: numbers that are equal and act alike must hash alike.
            hash.add((slot.read)(self) + 0.0);
        }
        hash.value()
    }
}

/// The number of the parameter of this name, for use in constants: a name that is none does not compile.
pub(super) const fn number_of(name: &str) -> u8 {
    let (mut number, mut found) = (0, 0);
    while !is_same(NAMES[found], name) {
        found += 1;
        number += 1;
    }
    number
}

const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut at = 0;
    while at < a.len() && at < b.len() && a[at] == b[at] {
        at += 1;
    }
    at == a.len() && at == b.len()
}

/// What a field of [`Config`] can be.
trait Value: Copy {
    const KIND: Kind;
    fn read(self) -> f32;
    /// From a number that [`Parameter::check`] has passed; any other gives some value, without panic.
    fn write(number: f32) -> Self;
}

impl Value for f32 {
    const KIND: Kind = Kind::Real;
    fn read(self) -> f32 {
        self
    }
    fn write(number: f32) -> Self {
        number
    }
}

impl Value for u16 {
    const KIND: Kind = Kind::Count;
    fn read(self) -> f32 {
        f32::from(self)
    }
    fn write(number: f32) -> Self {
        count(number)
    }
}

/// The whole part of a number that can be counted in 16 bits; NaN counts as 0.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "`as` from float to integer saturates, which is what is meant"
)]
fn count(number: f32) -> u16 {
    number as u16
}

/// Numbers the variants of enumerations, by the names that configuration files have for them.
macro_rules! choices {
    ($($kind:ident { 0 $first_name:literal $first:ident $(, $number:literal $name:literal $variant:ident)+ })+) => { $(
        impl $kind {
            const MUST: &str = concat!("0 (", $first_name, ")" $(, " or ", $number, " (", $name, ")")+);
        }

        impl Value for $kind {
            const KIND: Kind = Kind::Choice(&[$first_name $(, $name)+]);
            fn read(self) -> f32 {
                let number: u8 = match self { Self::$first => 0 $(, Self::$variant => $number)+ };
                f32::from(number)
            }
            fn write(number: f32) -> Self {
                match count(number) { $($number => Self::$variant,)+ _ => Self::$first }
            }
        }
    )+ };
}

choices! {
    Architecture { 0 "cooperative" Cooperative, 1 "fusion" Fusion }
    WiringKind { 0 "symmetric" Symmetric, 1 "asymmetric" Asymmetric }
    Beyond { 0 "nearer_on_bearing" NearerOnBearing, 1 "own_weight" OwnWeight }
    FieldCentre { 0 "sensed" Sensed, 1 "neuron" Neuron }
    StepRule { 0 "normalised" Normalised, 1 "plain" Plain }
    Displacement { 0 "half_turn" HalfTurn, 1 "place" Place }
    Chart { 0 "signed" Signed, 1 "unsigned" Unsigned }
    Eligible { 0 "trained" Trained, 1 "all" All }
}

/// Makes [`PARAMETERS`] and [`SLOTS`] of lines `field: type, "unit", low, high => "what it must be"`.
macro_rules! parameters {
    ($($group:ident $(. $field:ident)?: $type:ty, $unit:literal, $low:literal, $high:literal => $must:expr;)+) => {
        /// How many parameters there are.
        pub const PARAMETER_COUNT: usize = [$($low),+].len();

        const NAMES: [&str; PARAMETER_COUNT] =
            [$(concat!(stringify!($group) $(, ".", stringify!($field))?)),+];

        /// All parameters, each at its number. Only ever appended to.
        pub static PARAMETERS: [Parameter; PARAMETER_COUNT] = [$(Parameter {
            name: concat!(stringify!($group) $(, ".", stringify!($field))?),
            unit: $unit,
            low: $low,
            high: $high,
            must: $must,
            kind: <$type as Value>::KIND,
            number: number_of(concat!(stringify!($group) $(, ".", stringify!($field))?)),
        }),+];

        pub(super) static SLOTS: [Slot; PARAMETER_COUNT] = [$(Slot {
            low: $low,
            high: $high,
            is_whole: !matches!(<$type as Value>::KIND, Kind::Real),
            read: |config| <$type as Value>::read(config.$group$(.$field)?),
            write: |config, number| config.$group$(.$field)? = <$type as Value>::write(number),
        }),+];
    };
}

parameters! {
    architecture: Architecture, "1", 0.0, 1.0 => Architecture::MUST;

    robot.body_radius_m: f32, "m", 0.005, 2.0 => "between 5 mm and 2 m";
    robot.wheel_base_m: f32, "m", 0.005, 2.0 => "between 5 mm and 2 m";
    robot.speed_limit_mps: f32, "m/s", 0.005, 5.0 => "between 5 mm/s and 5 m/s";
    robot.encoder_counts_per_m: f32, "1/m", 100.0, 20_000.0
        => "between 100 and 20,000 per metre (divide finer encoders)";
    robot.sensor_range_m: f32, "m", 0.01, 20.0 => "between 1 cm and 20 m";

    servo.acceleration_mps2: f32, "m/s²", 0.01, 100.0 => "between 0.01 and 100 m/s²";
    servo.free_speed_mps: f32, "m/s", 0.005, 20.0 => "between 5 mm/s and 20 m/s";
    servo.proportional_per_mps: f32, "s/m", 0.0, 100.0 => "between 0 and 100";
    servo.integral_per_m: f32, "1/m", 0.0, 10_000.0 => "between 0 and 10,000";
    servo.lag_limit_m: f32, "m", 0.0, 0.1 => "between 0 and 0.1 m";
    servo.speed_filter_ms: f32, "ms", 1.0, 1000.0 => "between 1 and 1000 ms";
    servo.stall_reference_mps: f32, "m/s", 0.0, 5.0 => "between 0 and 5 m/s";
    servo.stall_share: f32, "1", 0.0, 1.0 => "between 0 and 1";
    servo.stall_ms: u16, "ms", 1.0, 60_000.0 => "between 1 and 60,000 ms";
    servo.stall_hold_ms: u16, "ms", 1.0, 60_000.0 => "between 1 and 60,000 ms";

    schedule.avoidance_period_ms: u16, "ms", 1.0, 10_000.0 => "between 1 and 10,000 ms";
    schedule.target_period_ms: u16, "ms", 1.0, 10_000.0 => "between 1 and 10,000 ms";
    schedule.step_ms: u16, "ms", 1.0, 10_000.0 => "between 1 and 10,000 ms";

    learning.annealing_steps: u16, "1", 1.0, 65_535.0 => "at least 1";
    learning.output_rate_first: f32, "1", 1e-4, 1.0 => "between 0.0001 and 1";
    learning.output_rate_last: f32, "1", 1e-4, 1.0 => "between 0.0001 and 1";
    learning.weight_rate_first: f32, "1", 1e-4, 1.0 => "between 0.0001 and 1";
    learning.weight_rate_last: f32, "1", 1e-4, 1.0 => "between 0.0001 and 1";
    learning.neighbourhood_first: f32, "1", 0.1, 20.0 => "between 0.1 and 20 lattice units";
    learning.neighbourhood_last: f32, "1", 0.1, 20.0 => "between 0.1 and 20 lattice units";
    learning.exploration_first: f32, "1", 1e-4, 2.0 => "between 0.0001 and 2";
    learning.exploration_last: f32, "1", 1e-4, 2.0 => "between 0.0001 and 2";
    learning.regularisation: f32, "1", 1e-4, 10.0 => "between 0.0001 and 10";
    learning.shortest_move: f32, "1", 0.0, 1.0 => "between 0 and 1";

    reaching.bearing_tolerance_rad: f32, "rad", 0.0, 6.3 => "between 0 and 2π";
    reaching.bearing_weight: f32, "1/rad²", 0.0, 100.0 => "between 0 and 100";
    reaching.distance_weight: f32, "1", 0.0, 100.0 => "between 0 and 100";
    reaching.far_share: f32, "1", 0.0, 100.0 => "0 (literal) or a positive share of the reach";
    reaching.beyond: Beyond, "1", 0.0, 1.0 => Beyond::MUST;
    reaching.checkpoint_tolerance_m: f32, "m", 1e-4, 1.0 => "between 0.1 mm and 1 m";
    reaching.goal_tolerance_m: f32, "m", 1e-4, 1.0 => "between 0.1 mm and 1 m";
    reaching.goal_speed_mps: f32, "m/s", 1e-3, 10.0 => "between 1 mm/s and 10 m/s";

    cooperative.target_amplitude: f32, "1", 1e-5, 100.0 => "between 0.00001 and 100";
    cooperative.target_bearing_sigma_rad: f32, "rad", 0.01, 100.0 => "between 0.01 and 100 rad";
    cooperative.target_distance_sigma_m: f32, "m", 1e-3, 100.0 => "between 1 mm and 100 m";
    cooperative.cruise_share: f32, "1", 0.0, 100.0 => "0 (literal) or a positive share of the reach";
    cooperative.obstacle_bearing_sigma_rad: f32, "rad", 0.01, 100.0 => "between 0.01 and 100 rad";
    cooperative.obstacle_behind_sigma_m: f32, "m", 1e-3, 100.0 => "between 1 mm and 100 m";
    cooperative.obstacle_front_sigma_m: f32, "m", 1e-3, 100.0 => "between 1 mm and 100 m";
    cooperative.obstacle_centre: FieldCentre, "1", 0.0, 1.0 => FieldCentre::MUST;
    cooperative.sweep_margin_m: f32, "m", 5e-4, 1.0 => "between 0.5 mm and 1 m";
    cooperative.sweep_strength: f32, "1", 0.0, 1000.0 => "between 0 and 1000";
    cooperative.sweep_look_ahead: f32, "1", 0.0, 1.0 => "between 0 and 1";
    cooperative.memory_ms: u16, "ms", 0.0, 60_000.0 => "between 0 and 60,000 ms";
    cooperative.memory_merge_m: f32, "m", 0.0, 1.0 => "between 0 and 1 m";
    cooperative.detour_patience_ms: u16, "ms", 0.0, 65_000.0 => "between 0 and 65,000 ms";
    cooperative.detour_progress_m: f32, "m", 1e-3, 1.0 => "between 1 mm and 1 m";
    cooperative.detour_follow_m: f32, "m", 5e-3, 10.0 => "between 5 mm and 10 m";
    cooperative.detour_free_rad: f32, "rad", 0.0, 3.2 => "between 0 and π";
    cooperative.detour_free_m: f32, "m", 1e-3, 10.0 => "between 1 mm and 10 m";
    cooperative.detour_side_ms: u16, "ms", 100.0, 65_000.0 => "between 100 and 65,000 ms";

    fusion.target_share: f32, "1", 0.0, 1.0 => "between 0 and 1";
    fusion.wiring: WiringKind, "1", 0.0, 1.0 => WiringKind::MUST;
    fusion.avoidance_gain: f32, "1", 0.0, 1000.0 => "between 0 and 1000";
    fusion.avoidance_range_m: f32, "m", 1e-3, 20.0 => "between 1 mm and 20 m";

    safety.scan_age_max_ms: u16, "ms", 1.0, 60_000.0 => "between 1 and 60,000 ms";
    safety.command_age_max_ms: u16, "ms", 1.0, 60_000.0 => "between 1 and 60,000 ms";

    robot.command_unit_mps: f32, "m/s", 0.0, 5.0 => "between 0 and 5 m/s";
    reaching.near_share: f32, "1", 0.0, 1.0 => "0 (literal) or a positive share of the reach";
    reaching.near_bearing_rad: f32, "rad", 0.0, 3.2 => "between 0 and π";
    reaching.eligible: Eligible, "1", 0.0, 1.0 => Eligible::MUST;
    learning.step: StepRule, "1", 0.0, 1.0 => StepRule::MUST;
    learning.displacement: Displacement, "1", 0.0, 1.0 => Displacement::MUST;
    learning.chart: Chart, "1", 0.0, 1.0 => Chart::MUST;
    learning.surprise_ratio: f32, "1", 0.0, 100.0 => "0 (never) or a ratio up to 100";
    learning.surprised_age: u16, "1", 0.0, 65_535.0 => "between 0 and 65,535";
    cooperative.opening_margin_m: f32, "m", 0.0, 1.0 => "between 0 and 1 m";
    cooperative.opening_flank_m: f32, "m", 0.0, 10.0 => "0 (none) or up to 10 m";
    cooperative.opening_length_m: f32, "m", 1e-3, 10.0 => "between 1 mm and 10 m";
    cooperative.opening_aside_rad: f32, "rad", 0.0, 3.2 => "between 0 and π";
    cooperative.opening_turn_rad: f32, "rad", 0.0, 3.2 => "between 0 and π";
    cooperative.opening_distance_sigma_m: f32, "m", 1e-3, 100.0 => "between 1 mm and 100 m";
    cooperative.opening_give_up_ms: u16, "ms", 0.0, 65_000.0 => "between 0 and 65,000 ms";
    cooperative.sweep_headway: f32, "1", 0.0, 1.0 => "between 0 and 1";
    cooperative.detour_clear_m: f32, "m", 0.0, 1.0 => "between 0 and 1 m";
    cooperative.mover_headway_s: f32, "s", 0.0, 10.0 => "0 (none) or up to 10 s";
    cooperative.mover_speed_mps: f32, "m/s", 1e-3, 5.0 => "between 1 mm/s and 5 m/s";
}

const _: () = assert!(PARAMETER_COUNT <= 255, "the link numbers parameters in a byte");

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{Config, Kind, PARAMETER_COUNT, PARAMETERS, Parameter};
    use std::collections::BTreeSet;
    use std::string::ToString;

    /// Two values that differ from each other and can be set.
    fn extremes(parameter: &Parameter) -> [f32; 2] {
        [parameter.low, parameter.high]
    }

    fn number_of(name: &str) -> usize {
        PARAMETERS.iter().position(|parameter| parameter.name == name).unwrap()
    }

    #[test]
    fn what_is_set_is_read_and_nothing_else_changes() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            for value in extremes(parameter) {
                let mut config = Config::default();
                config.set(index, value).unwrap();
                for (other, name) in PARAMETERS.iter().map(|parameter| parameter.name).enumerate() {
                    let expected = if other == index { Some(value) } else { Config::default().get(other) };
                    assert_eq!(config.get(other), expected, "{name} after {}", parameter.name);
                }
            }
        }
    }

    #[test]
    fn every_choice_can_be_set() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            if let Kind::Choice(names) = parameter.kind {
                for (number, name) in (0_u16..).zip(names) {
                    let mut config = Config::default();
                    config.set(index, f32::from(number)).unwrap();
                    assert_eq!(config.get(index), Some(f32::from(number)), "{} = {name}", parameter.name);
                }
                let last = u16::try_from(names.len()).unwrap() - 1;
                assert_eq!((parameter.low, parameter.high), (0.0, f32::from(last)), "{}", parameter.name);
            }
        }
    }

    #[test]
    fn what_cannot_be_is_refused_by_name_and_value_and_changes_nothing() {
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            let [low, high] = extremes(parameter);
            let mut wrong = std::vec![low - 1.0, high + 1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
            if parameter.kind != Kind::Real {
                wrong.push(low + 0.5);
            }
            for value in wrong {
                let mut config = Config::default();
                let error = config.set(index, value).unwrap_err();
                let text = std::format!("{} = {value}: must be ", parameter.name);
                assert!(error.to_string().starts_with(&text), "{error}, expected {text}");
                assert_eq!(error.index(), Some(index));
                assert_eq!(config, Config::default());
            }
        }
        let mut config = Config::default();
        let error = config.set(number_of("servo.stall_ms"), 2.5).unwrap_err();
        assert_eq!(error.to_string(), "servo.stall_ms = 2.5: must be a whole number");
        let error = config.set(number_of("fusion.wiring"), 2.0).unwrap_err();
        assert_eq!(error.to_string(), "fusion.wiring = 2: must be 0 (symmetric) or 1 (asymmetric)");
        let error = config.set(PARAMETER_COUNT, 1.0).unwrap_err();
        let text =
            std::format!("number of the parameter = {PARAMETER_COUNT}: must be in the list of parameters");
        assert_eq!((error.to_string(), error.index()), (text, None));
        assert_eq!(config.get(PARAMETER_COUNT), None);
    }

    #[test]
    fn rules_between_parameters_wait_until_all_are_set() {
        let mut config = Config::default();
        config.set(number_of("schedule.avoidance_period_ms"), 100.0).unwrap();
        let error = config.validate().unwrap_err();
        assert_eq!(error.index(), Some(number_of("schedule.target_period_ms")));
        config.set(number_of("schedule.target_period_ms"), 300.0).unwrap();
        config.set(number_of("schedule.step_ms"), 900.0).unwrap();
        config.validate().unwrap();
    }

    #[test]
    fn the_hash_tells_every_parameter_apart() {
        let mut hashes = BTreeSet::from([Config::default().hash()]);
        for (index, parameter) in PARAMETERS.iter().enumerate() {
            let mut config = Config::default();
            let [low, high] = extremes(parameter);
            let other = if parameter.default_value() > low { low } else { high };
            config.set(index, other).unwrap();
            assert!(hashes.insert(config.hash()), "{}", parameter.name);
            config.set(index, parameter.default_value()).unwrap();
            assert_eq!(config.hash(), Config::default().hash());
        }
    }

    #[test]
    fn equal_numbers_hash_alike() {
        let (mut zero, mut negative_zero) = (Config::default(), Config::default());
        zero.servo.lag_limit_m = 0.0;
        negative_zero.servo.lag_limit_m = -0.0;
        assert_eq!(zero.hash(), negative_zero.hash());
    }

    #[test]
    fn names_end_in_the_unit() {
        let endings = [
            ("per_mps", "s/m"),
            ("per_m", "1/m"),
            ("mps2", "m/s²"),
            ("mps", "m/s"),
            ("rad", "rad"),
            ("ms", "ms"),
            ("s", "s"),
            ("m", "m"),
        ];
        for parameter in &PARAMETERS {
            let ending =
                endings.iter().find(|(ending, _)| parameter.name.ends_with(&std::format!("_{ending}")));
            // γ_α is the one that is no quantity of its own.
            let unit = if parameter.name == "reaching.bearing_weight" { "1/rad²" } else { "1" };
            assert_eq!(parameter.unit, ending.map_or(unit, |(_, unit)| unit), "{}", parameter.name);
        }
    }
}
