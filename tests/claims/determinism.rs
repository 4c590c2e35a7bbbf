//! Bar: a run is (commit, seed, scenario), whatever else the machine does.
//!
//! * **Goal**: the same seed gives the same state hash, on one thread and on two; another seed, or one other input,
//!   another.
//! * **Method**: P2 Fig. 6 under noise, from a map that was trained in the same run. The hash covers every command,
//!   every drive and every true pose. The canary reads one encoder wrong by one count at one tick: a hash that does not
//!   notice hashes nothing.
//! * **Tolerance**: none.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use controller_core::config::Config;
use controller_core::controller::{Inputs, Outputs};
use controller_core::scalar::Scalar;
use controller_core::schedule::{Schedule, Tick};
use host_sim::mission::{self, MissionOptions, config_for};
use host_sim::scenario::Scenario;
use host_sim::sil::{Answer, ControllerPort, HostMap, Order, Sil};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use tests::for_each_scalar;
use tests::learning::{Indirect, trained};

/// Training steps: enough to move with sense.
const STEPS: u32 = 600;

/// A controller that reads one thing wrong once.
struct Canary<C> {
    inner: C,
    /// At this tick the left encoder is read one count too high.
    at: Tick,
}

impl<C: ControllerPort> ControllerPort for Canary<C> {
    type Error = C::Error;

    fn step(&mut self, now: Tick, inputs: &Inputs<f32, 12>) -> Result<Outputs<f32>, C::Error> {
        let mut inputs = *inputs;
        if now == self.at {
            inputs.encoders.left += 1;
        }
        self.inner.step(now, &inputs)
    }

    fn schedule(&self) -> Schedule {
        self.inner.schedule()
    }

    fn order(&mut self, order: Order<'_>) -> Result<Answer, C::Error> {
        self.inner.order(order)
    }

    fn hash(&self) -> u64 {
        self.inner.hash()
    }
}

/// The hash of a mission; `wrong_at` is the canary's tick.
fn hash_of<S: Scalar>(map: &HostMap<S, Indirect<S>>, seed: u64, wrong_at: Tick) -> u64 {
    let mut scenario = Scenario::builtin("p2_fig6").unwrap();
    scenario.time_limit_s = scenario.time_limit_s.min(30.0);
    let config = config_for(&scenario, &Config::default(), None);
    let inner = Sil::trained(&config, map.clone(), STEPS).unwrap();
    let controller = Canary { inner, at: wrong_at };
    mission::run(&scenario, controller, &config, MissionOptions { seed, sample_ms: 0 }).unwrap().hash
}

/// A tick that no run reaches.
const NEVER: Tick = Tick::MAX;

fn same_seed_same_hash_and_one_reading_matters<S: Scalar>() {
    let map = trained::<S, Indirect<S>>(1, STEPS);
    assert!(map == trained::<S, Indirect<S>>(1, STEPS), "training itself repeats");
    assert!(map != trained::<S, Indirect<S>>(2, STEPS), "and depends on its seed");
    let first = hash_of(&map, 1, NEVER);
    println!("{} seed 1: {first:016x}", S::NAME);
    assert_eq!(first, hash_of(&map, 1, NEVER), "same seed");
    assert_ne!(first, hash_of(&map, 2, NEVER), "another seed");
    assert_ne!(first, hash_of(&map, 1, 1234), "the canary");
}

fn threads_do_not_matter<S: Scalar>() {
    let on_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let hash = |seed: u64| hash_of(&trained::<S, Indirect<S>>(seed, 200), seed, NEVER);
            (1..=4_u64).into_par_iter().map(hash).collect::<Vec<u64>>()
        })
    };
    assert_eq!(on_threads(1), on_threads(2));
}

for_each_scalar!(same_seed_same_hash_and_one_reading_matters, threads_do_not_matter);
