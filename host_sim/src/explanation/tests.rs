use controller_core::config::{Architecture, Config};
use controller_core::controller::{Mode, Outputs};
use controller_core::scalar::{Fixed, Scalar};

use super::{DecisionReport, NeuronActivity, decision_of, explain, wheels};
use crate::fleet::{Company, run_watched};
use crate::khepera::{KheperaModel, TruePose};
use crate::mission::{self, MissionOptions};
use crate::number::narrow_point;
use crate::scenario::Scenario;
use crate::scenes::{Circling, Disturbance, Scene};
use crate::settings::Settings;
use crate::sil::{ControllerPort, HostMap, Indirect, Sil};
use crate::simulation::Simulation;
use crate::sweep::learn;
use crate::training::TrainingPlan;

fn map<S: Scalar>() -> HostMap<S, Indirect<S>> {
    let plan = TrainingPlan { steps: 600, ..TrainingPlan::default() };
    learn::<S, Indirect<S>>(&Config::default(), &plan, &|| ()).unwrap().map
}

/// Drives towards the obstacle of P2 Fig. 4 and explains every decision of the first seconds, beside what was done.
fn decisions<S: Scalar>(architecture: Architecture) -> Vec<(DecisionReport, Sil<S>, [f32; 2])> {
    decisions_in(&Scenario::builtin("p2_fig4").unwrap(), &Config::default(), architecture)
}

fn decisions_in<S: Scalar>(
    scenario: &Scenario,
    config: &Config,
    architecture: Architecture,
) -> Vec<(DecisionReport, Sil<S>, [f32; 2])> {
    let config = mission::config_for(scenario, config, Some(architecture.into()));
    let sil = Sil::<S>::trained(&config, map(), 0).unwrap();
    let model = KheperaModel::new(&config.robot, &config.servo, scenario.noise.actuator);
    let start = TruePose { position: scenario.start.position, heading_rad: scenario.start.heading_rad };
    let mut simulation = Simulation::new(sil, &scenario.world, model, &scenario.noise, start, 1);
    let points: Vec<_> = scenario.route.checkpoints().iter().copied().map(narrow_point).collect();
    simulation.controller.set_checkpoints(&points).unwrap().unwrap();
    simulation.controller.arm().unwrap();
    simulation.controller.set_mode(Mode::Navigate, 0).unwrap();
    let mut decisions = Vec::new();
    for tick in 0..20_000 {
        let outputs = simulation.step().unwrap();
        if outputs.released.avoidance || outputs.released.target {
            let report = decision_of(&simulation.controller, tick);
            decisions.push((report, simulation.controller.clone(), wheels(outputs.command.value)));
        }
    }
    decisions
}

/// What is told of a decision is what the core decided and did; the winner, if there is one.
fn assert_told<S: Scalar>(
    report: &DecisionReport,
    sil: &Sil<S>,
    command: [f32; 2],
) -> Option<NeuronActivity> {
    let winner = report.winner?;
    let decision = sil.controller.decision();
    assert_eq!(winner.neuron, decision.winner, "tick {}", report.tick);
    assert!((winner.total - decision.activity.to_f32()).abs() < f32::EPSILON, "tick {}", report.tick);
    assert_eq!(report.is_target, decision.is_target);
    assert_eq!(report.command.map(f32::to_bits), command.map(f32::to_bits), "tick {}", report.tick);
    Some(winner)
}

fn check_cooperative<S: Scalar>() {
    let (mut blocked, mut inhibited) = (0, 0);
    for (report, sil, command) in decisions::<S>(Architecture::Cooperative) {
        let winner = assert_told(&report, &sil, command).unwrap();
        assert!(!report.verdict.is_empty());
        blocked += u32::from(report.neurons.iter().any(|neuron| neuron.way > 0.0));
        inhibited += u32::from(winner.neuron != report.field.unwrap().winner);
    }
    // Otherwise nothing was compared but the target field.
    assert!(blocked > 20 && inhibited > 20, "{blocked} {inhibited}");
}

#[test]
fn names_the_winner_and_the_command_that_was_carried_out() {
    check_cooperative::<f32>();
    check_cooperative::<Fixed>();
}

fn check_retreat<S: Scalar>() {
    let config = Settings::default().core;
    let (mut backwards, mut among) = (0, 0);
    for (discs, speed_m_s) in [(2, 0.1), (4, 0.1), (4, 0.16), (6, 0.16)] {
        let scene = Scene::Circling(Circling { discs, speed_m_s }).scenario(&Disturbance::PAPERS);
        for (report, sil, command) in decisions_in::<S>(&scene, &config, Architecture::Cooperative) {
            let Some(winner) = assert_told(&report, &sil, command) else { continue };
            among += u32::from(!report.movers.is_empty());
            backwards += u32::from(winner.backwards);
        }
    }
    assert!(backwards > 3 && among > 20, "{}: {backwards} of {among}", S::NAME);
}

#[test]
fn names_what_is_made_backwards_from_what_moves() {
    check_retreat::<f32>();
    check_retreat::<Fixed>();
}

fn check_fusion<S: Scalar>() {
    let mut avoided = 0;
    for (report, _, command) in decisions::<S>(Architecture::Fusion) {
        let fusion = report.fusion.unwrap();
        assert_eq!(fusion.sum.map(f32::to_bits), command.map(f32::to_bits), "tick {}", report.tick);
        avoided += u32::from(fusion.avoidance.is_some());
    }
    assert!(avoided > 5, "{avoided}");
}

#[test]
fn command_fusion_is_its_two_commands() {
    check_fusion::<f32>();
    check_fusion::<Fixed>();
}

#[test]
fn other_robots_are_part_of_the_decision() {
    let scenario = Scenario::builtin("robots_crossing").unwrap();
    let (config, map, options) = (Config::default(), map::<f32>(), MissionOptions { seed: 1, sample_ms: 0 });
    let (mut apart, mut checked) = (0, 0);
    let mut watch = |_: usize, tick, sil: &Sil<f32>, outputs: &Outputs<f32>| {
        if outputs.released.avoidance && sil.controller.checkpoints().remaining() > 0 && tick < 12_000 {
            let report = decision_of(sil, tick);
            assert_eq!(report.winner.unwrap().neuron, sil.controller.decision().winner, "tick {tick}");
            assert_eq!(report.command.map(f32::to_bits), wheels(outputs.command.value).map(f32::to_bits));
            let own = report.field.unwrap().winner;
            let own = report.neurons.iter().find(|neuron| neuron.neuron == own).unwrap();
            apart += u32::from(own.separation > 0.001 && report.winner.unwrap().neuron != own.neuron);
            checked += 1;
        }
    };
    run_watched(&scenario, &config, None, &map, (options, Company::Told), &mut watch).unwrap();
    assert!(apart > 20 && checked > 200, "{apart} of {checked}");
}

#[test]
fn a_tick_between_two_decisions_belongs_to_the_one_before() {
    let scenario = Scenario::builtin("p2_fig4").unwrap();
    let (config, map) = (Config::default(), map::<f32>());
    let options = MissionOptions { seed: 3, sample_ms: 0 };
    let (explanation, result) = explain(&scenario, &config, None, &map, options, 1300).unwrap();
    assert_eq!((explanation.decision.tick, explanation.standing.tick), (1280, 1300));
    let bits = |command: [f32; 2]| command.map(f32::to_bits);
    assert_eq!(bits(explanation.standing.command), bits(explanation.decision.command));
    assert_eq!(explanation.standing.command_age_ms, 20);
    let unwatched = crate::sweep::run_one(&scenario, &config.clone().into(), None, &map, options).unwrap();
    assert_eq!(result, unwatched, "watching changes nothing");
    let error = explain(&scenario, &config, None, &map, options, 10_000_000).unwrap_err();
    assert!(error.to_string().contains("earlier"), "{error}");
}
