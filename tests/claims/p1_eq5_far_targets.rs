//! P1 Eq. 5: what to do with a command beyond c*.
//!
//! * **Goal**: "saturating the wheels" loses the heading of a far target, the map's rules do not.
//! * **Method**: a trained map and a robot that does exactly what it is told (`f64`, no inertia, no noise), a target
//!   1 to 3 m away and 25° to 75° off the heading. The literal form of the map's rule (no rule for far targets, `M_k
//!   w_k` beyond c*) and the form that is used by default, against `M_k u` with each wheel cut at c*. After one step:
//!   how much of the bearing has been turned away? After at most 60 steps: is the target reached to 5 mm?
//! * **Paper**: no number; below Eq. 5 it says that saturation would drive the robot straight at far targets.
//! * **Ours**: `docs/numbers.md`.
//! * **Tolerance**: saturation turns by nothing at all, the rules by α or 2α (a step of `M_k w_k` ends at bearing α,
//!   its body turned by 2α); a quarter and a half of α separate them whatever the map's errors. Of the targets,
//!   saturation may reach a quarter (some are met by chance), the literal form misses up to a quarter (it turns by 2α
//!   and zig-zags), the default none.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use controller_core::config::Config;
use controller_core::kohonen::features::{Command, Features};
use controller_core::kohonen::map::Eligible;
use controller_core::motor_control::{self, Beyond, ReachingParameters};
use controller_core::scalar::Scalar;
use host_sim::arc::Place;
use host_sim::sil::HostMap;
use nalgebra::{Point2, Vector2};
use tests::learning::{Indirect, trained};
use tests::statistics::count;
use tests::{for_each_scalar, narrow, wide};

/// What is compared.
type Rule<S> = fn(&HostMap<S, Indirect<S>>, &ReachingParameters<S>, Features<S>) -> Command<S>;

fn by_the_map<S: Scalar>(
    map: &HostMap<S, Indirect<S>>,
    reaching: &ReachingParameters<S>,
    target: Features<S>,
) -> Command<S> {
    motor_control::reach(map, reaching, target).expect("the map is trained").1
}

/// `M_k u`, each wheel cut at c*.
fn by_saturation<S: Scalar>(
    map: &HostMap<S, Indirect<S>>,
    reaching: &ReachingParameters<S>,
    target: Features<S>,
) -> Command<S> {
    let k = map.winner(&reaching.winner, target, Eligible::Trained).expect("the map is trained");
    map.command_at(k, target).saturated()
}

struct Outcome {
    /// Heading change of the first step as a share of the target's bearing.
    turned: f64,
    /// Steps until nearer than 5 mm.
    steps: Option<u32>,
}

fn drive<S: Scalar>(
    map: &HostMap<S, Indirect<S>>,
    literal: Option<Beyond>,
    rule: Rule<S>,
    target: Point2<f64>,
) -> Outcome {
    let mut config = Config::default();
    if let Some(beyond) = literal {
        config.reaching.far_share = 0.0;
        config.reaching.beyond = beyond;
    }
    let p = config.build::<S, 12>().unwrap();
    let reach_m = wide(p.scaling.reach_m());
    let wheel_base_m = f64::from(config.robot.wheel_base_m);
    let start = Place { position: Point2::origin(), heading_rad: 0.0 };
    let (mut place, mut turned) = (start, None);
    for step in 1..=60 {
        let (bearing, distance) = place.see(target);
        let target_features = Features {
            bearing: S::from_f32(narrow(bearing)),
            distance: S::from_f32(narrow(distance / reach_m)),
        };
        let command = rule(map, &p.reaching, target_features);
        assert!(command.is_realisable(), "{command:?}");
        place = place.after((wide(command.left) * reach_m, wide(command.right) * reach_m), wheel_base_m);
        turned = turned.or(Some(place.heading_rad / start.see(target).0));
        if place.see(target).1 < 0.005 {
            return Outcome { turned: turned.unwrap_or_default(), steps: Some(step) };
        }
    }
    Outcome { turned: turned.unwrap_or_default(), steps: None }
}

fn saturating_the_wheels_loses_the_heading<S: Scalar>() {
    let map = trained::<S, Indirect<S>>(1, 1500);
    let targets: Vec<Point2<f64>> = [25.0_f64, 40.0, 55.0, 75.0]
        .into_iter()
        .flat_map(|degrees| [degrees, -degrees])
        .flat_map(|degrees| [1.0, 2.0, 3.0].map(|distance| (degrees.to_radians(), distance)))
        .map(|(bearing, distance)| Point2::origin() + Vector2::new(bearing.cos(), bearing.sin()) * distance)
        .collect();
    let run = |name: &str, literal, rule: Rule<S>| {
        let outcomes: Vec<Outcome> =
            targets.iter().map(|&target| drive(&map, literal, rule, target)).collect();
        let turned = outcomes.iter().map(|outcome| outcome.turned);
        let least = turned.clone().fold(f64::INFINITY, f64::min);
        let most = turned.fold(f64::NEG_INFINITY, f64::max);
        let steps: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.steps.map(f64::from)).collect();
        let reached = count(&steps);
        println!(
            "{} {name}: turned {least:.2} to {most:.2} of the bearing, reached {reached} of {}",
            S::NAME,
            targets.len()
        );
        (least, most, steps.len())
    };
    let (_, saturated_most, saturated_reached) =
        run("saturated", Some(Beyond::OwnWeight), by_saturation::<S>);
    let (literal_least, _, literal_reached) = run("literal Eq. 5", Some(Beyond::OwnWeight), by_the_map::<S>);
    let (default_least, _, default_reached) = run("default", None, by_the_map::<S>);
    assert!(saturated_most < 0.25, "saturation drives straight on: {saturated_most}");
    assert!(literal_least > 0.5, "M_k w_k turns towards the target: {literal_least}");
    assert!(default_least > 0.5, "half the bearing turns towards the target: {default_least}");
    assert_eq!(default_reached, targets.len(), "the default reaches all");
    assert!(literal_reached > targets.len() * 3 / 4, "the literal form reaches most: {literal_reached}");
    assert!(saturated_reached < targets.len() / 4, "saturation reaches few: {saturated_reached}");
}

for_each_scalar!(saturating_the_wheels_loses_the_heading);
