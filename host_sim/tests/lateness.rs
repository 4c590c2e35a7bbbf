//! Tasks that run late, in whole missions.
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, which clippy.toml cannot know")]

use core::convert::Infallible;

use controller_core::config::Config;
use controller_core::controller::{Inputs, Outputs};
use controller_core::schedule::{Schedule, Tick};
use host_sim::contender::Contender;
use host_sim::lateness::Finished;
use host_sim::mission::{self, MissionOptions, MissionResult};
use host_sim::proximity_model::SENSORS;
use host_sim::scenario::Scenario;
use host_sim::settings::Settings;
use host_sim::sil::{Answer, ControllerPort, Indirect, Order, Sil};
use host_sim::sweep::{learn, run_one};
use host_sim::training::TrainingPlan;

const OPTIONS: MissionOptions = MissionOptions { seed: 5, sample_ms: 0 };

/// A controller whose tasks may be late and never are.
struct OnTime(Sil<f32>);

impl ControllerPort for OnTime {
    type Error = Infallible;

    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Result<Outputs<f32>, Infallible> {
        self.0.step_late(now, inputs, Finished { avoidance: true, target: true })
    }

    fn schedule(&self) -> Schedule {
        self.0.schedule()
    }

    fn order(&mut self, order: Order<'_>) -> Result<Answer, Infallible> {
        self.0.order(order)
    }

    fn hash(&self) -> u64 {
        self.0.hash()
    }
}

fn scenario(task_jitter_ms: u16) -> Scenario {
    let mut scenario = Scenario::builtin("p2_fig5").unwrap();
    scenario.noise.task_jitter_ms = task_jitter_ms;
    scenario
}

#[test]
fn a_task_that_is_late_by_nothing_is_the_ordinary_one_bit_for_bit() {
    let plan = TrainingPlan { steps: 800, ..TrainingPlan::default() };
    let map = learn::<f32, Indirect<f32>>(&Config::default(), &plan, &|| ()).unwrap().map;
    for contender in Contender::PAPERS {
        let scenario = scenario(0);
        let config = mission::config_for(&scenario, &Config::default(), Some(contender));
        let sil = || Sil::trained(&config, map.clone(), 0).unwrap();
        let ordinary = mission::run(&scenario, sil(), &config, OPTIONS).unwrap();
        let on_time = mission::run(&scenario, OnTime(sil()), &config, OPTIONS).unwrap();
        assert!(ordinary.reached, "{contender:?}");
        assert_eq!(ordinary, on_time, "{contender:?}");
    }
}

#[test]
fn every_controller_drives_otherwise_with_late_tasks_and_still_arrives() {
    let plan = TrainingPlan { steps: 800, ..TrainingPlan::default() };
    let map = learn::<f32, Indirect<f32>>(&Config::default(), &plan, &|| ()).unwrap().map;
    let run = |contender, jitter_ms| -> MissionResult {
        run_one(&scenario(jitter_ms), &Settings::default(), Some(contender), &map, OPTIONS).unwrap()
    };
    for contender in Contender::ALL {
        let (punctual, late) = (run(contender, 0), run(contender, 40));
        assert_ne!(punctual.hash, late.hash, "{contender:?}");
        assert!(late.reached && late.stopped.is_none(), "{contender:?}: {late:?}");
    }
}
