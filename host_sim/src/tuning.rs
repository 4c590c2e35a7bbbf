//! What a search for a contender's numbers is about: which numbers, on which scenes, and what a run is worth.
//!
//! The same scenes, score and budget for every contender, so that a comparison is of ideas and not of patience. Tests
//! and tables use other measures, angles and seeds besides those tuned on.

use controller_core::config::{Kind, PARAMETERS};

use crate::contender::Contender;
use crate::mission::{MissionOptions, MissionResult};
use crate::number::narrow;
use crate::peers::config::PeerConfig;
use crate::scenario::Scenario;
use crate::search::{Candidate, Dimension, SearchPlan, search};
use crate::settings::Settings;
use crate::sil::Indirect;
use crate::sweep::{Maps, run_one};

/// Numbers of cooperative EKMs that a search may tune.
const COOPERATIVE: [Dimension; 24] = [
    Dimension::log("cooperative.target_amplitude", 0.03, 0.12),
    Dimension::linear("cooperative.target_bearing_sigma_rad", 1.0, 2.4),
    Dimension::log("cooperative.target_distance_sigma_m", 0.008, 0.02),
    Dimension::linear("cooperative.cruise_share", 0.45, 0.92),
    Dimension::linear("cooperative.obstacle_bearing_sigma_rad", 0.08, 0.3),
    Dimension::log("cooperative.obstacle_front_sigma_m", 0.005, 0.012),
    Dimension::log("cooperative.sweep_margin_m", 0.002, 0.006),
    Dimension::log("cooperative.sweep_headway", 0.04, 0.1),
    Dimension::log("cooperative.sweep_strength", 10.0, 100.0),
    Dimension::linear("cooperative.memory_ms", 0.0, 900.0),
    Dimension::log("cooperative.detour_patience_ms", 2500.0, 9000.0),
    Dimension::log("cooperative.detour_progress_m", 0.004, 0.03),
    Dimension::linear("cooperative.detour_follow_m", 0.035, 0.07),
    Dimension::linear("cooperative.detour_free_rad", 0.05, 0.8),
    Dimension::linear("cooperative.detour_free_m", 0.06, 0.22),
    Dimension::log("cooperative.detour_side_ms", 6000.0, 30_000.0),
    Dimension::linear("cooperative.detour_clear_m", 0.035, 0.08),
    Dimension::log("cooperative.opening_margin_m", 0.0015, 0.0045),
    Dimension::linear("cooperative.opening_flank_m", 0.045, 0.06),
    Dimension::linear("cooperative.opening_length_m", 0.09, 0.13),
    Dimension::linear("cooperative.opening_aside_rad", 0.6, 1.3),
    Dimension::linear("cooperative.opening_turn_rad", 0.25, 0.7),
    Dimension::log("cooperative.opening_distance_sigma_m", 0.015, 0.06),
    Dimension::linear("cooperative.opening_give_up_ms", 3000.0, 9000.0),
];

/// Numbers of command fusion.
const FUSION: [Dimension; 3] = [
    Dimension::linear("fusion.target_share", 0.1, 0.9),
    Dimension::log("fusion.avoidance_gain", 0.5, 20.0),
    Dimension::log("fusion.avoidance_range_m", 0.01, 0.175),
];

/// What of a contender a search may tune, by names as in a file; those of peers without the `peers.`.
#[must_use]
pub fn space(contender: Contender) -> Vec<Dimension> {
    match contender {
        Contender::Cooperative => COOPERATIVE.to_vec(),
        Contender::Fusion => FUSION.to_vec(),
        peer => PeerConfig::searched(peer),
    }
}

fn read(settings: &Settings, name: &str) -> Option<f64> {
    if let Some(value) = settings.peers.clone().number_mut(name) {
        return Some(*value);
    }
    let index = PARAMETERS.iter().position(|parameter| parameter.name == name)?;
    settings.core.get(index).map(f64::from)
}

/// Sets a number, whole where it counts something; one that does not exist or is out of range stays.
fn write(settings: &mut Settings, name: &str, value: f64) {
    if let Some(number) = settings.peers.number_mut(name) {
        *number = value;
    } else if let Some(index) = PARAMETERS.iter().position(|parameter| parameter.name == name) {
        let is_whole = PARAMETERS.get(index).is_some_and(|parameter| parameter.kind != Kind::Real);
        // Ranges lie within what is allowed; a test holds that.
        let _ = settings.core.set(index, narrow(if is_whole { value.round() } else { value }));
    }
}

/// What a run is worth: success, and a tenth of it for haste; a little for arriving with a contact, or for none.
#[must_use]
pub fn score(result: &MissionResult, time_limit_s: f64) -> f64 {
    let haste = 0.1 * (1.0 - result.duration_s / time_limit_s).max(0.0);
    match (result.success, result.reached, result.contacts) {
        (true, ..) => 0.9 + haste,
        (false, true, _) => 0.3,
        (false, false, 0) => 0.1,
        (false, false, _) => 0.0,
    }
}

/// A search for the numbers of a contender.
#[derive(Debug)]
pub struct Tuning {
    contender: Contender,
    settings: Settings,
    space: Vec<Dimension>,
    scenes: Vec<Scenario>,
    maps: Maps<f32, Indirect<f32>>,
}

impl Tuning {
    /// From these settings on, with these maps in turn for those that drive with one.
    #[must_use]
    pub fn new(
        contender: Contender,
        settings: Settings,
        scenes: Vec<Scenario>,
        maps: Maps<f32, Indirect<f32>>,
    ) -> Self {
        Self { contender, settings, space: space(contender), scenes, maps }
    }

    /// Runs of the whole search.
    #[must_use]
    pub fn total_runs(&self, plan: &SearchPlan) -> u64 {
        plan.total_runs(self.scenes.len())
    }

    /// Names of the scenes.
    pub fn scene_names(&self) -> impl Iterator<Item = &str> {
        self.scenes.iter().map(|scene| scene.name.as_str())
    }

    /// The settings with these values in the place of what is searched for.
    #[must_use]
    pub fn with_values(&self, values: &[f64]) -> Settings {
        let mut settings = self.settings.clone();
        for (dimension, &value) in self.space.iter().zip(values) {
            write(&mut settings, dimension.name, value);
        }
        settings
    }

    /// Names and values of a candidate.
    pub fn named<'a>(&'a self, candidate: &'a Candidate) -> impl Iterator<Item = (&'static str, f64)> + 'a {
        self.space.iter().map(|dimension| dimension.name).zip(candidate.values.iter().copied())
    }

    /// Searches; `progress` hears of every run, `report` of every generation with its best.
    pub fn run(
        &self,
        plan: &SearchPlan,
        progress: &(dyn Fn() + Sync),
        mut report: impl FnMut(u32, &Candidate),
    ) -> Vec<Candidate> {
        let start = self.space.iter().map(|dimension| {
            let value = read(&self.settings, dimension.name).unwrap_or(dimension.low);
            value.clamp(dimension.low, dimension.high)
        });
        let start: Vec<f64> = start.collect();
        let score = |values: &[f64], scene: usize, seed: u64| {
            let Some(scene) = self.scenes.get(scene) else { return 0.0 };
            let options = MissionOptions { seed, sample_ms: 0 };
            let settings = self.with_values(values);
            let number = usize::try_from(seed % 1024).unwrap_or(0);
            let run =
                self.maps.with(number, |map| run_one(scene, &settings, Some(self.contender), map, options));
            progress();
            // A run that cannot begin is worth nothing.
            run.map_or(0.0, |result| score(&result, scene.time_limit_s))
        };
        search(&self.space, &start, self.scenes.len(), plan, score, |generation, survivors| {
            if let Some(best) = survivors.first() {
                report(generation, best);
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{SearchPlan, Settings, Tuning, read, space, write};
    use crate::contender::Contender;
    use crate::scenes::{Disturbance, Door, Scene};
    use crate::sweep::Maps;

    #[test]
    fn a_search_says_the_same_twice_and_stays_within_what_is_valid() {
        let door = Scene::Door(Door { width_m: 0.08, approach_deg: 0.0 }).scenario(&Disturbance::PAPERS);
        let plan = SearchPlan { seed: 5, generations: 2, candidates: 3, survivors: 2, runs: 1 };
        for contender in Contender::ALL {
            let maps = Maps::PerRun(Vec::new());
            let tuning = Tuning::new(contender, Settings::default(), vec![door.clone()], maps);
            let find = || tuning.run(&plan, &|| (), |_, _| ());
            let found = find();
            assert_eq!(found, find(), "{contender:?}");
            let settings = tuning.with_values(&found[0].values);
            settings.peers.validate().unwrap();
            settings.core.validate().unwrap();
        }
    }

    #[test]
    fn all_that_is_tuned_exists_and_may_have_any_value_of_its_range() {
        for contender in Contender::ALL {
            assert!(!space(contender).is_empty());
            for number in space(contender) {
                let mut settings = Settings::default();
                for wished in [number.low, number.high] {
                    write(&mut settings, number.name, wished);
                    let is = read(&settings, number.name).unwrap();
                    assert!((is - wished).abs() < 1e-6 * wished.abs().max(1.0), "{}: {is}", number.name);
                }
            }
        }
    }
}
