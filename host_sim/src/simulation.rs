//! One robot in one world under one controller, tick by tick in virtual time; of several, see [`crate::fleet`].
//!
//! At tick t the sensors read the world of t, the controller steps, and its drive moves the robot to t + 1. There is no
//! wall time and no thread inside a run.

use controller_core::controller::{Inputs, Outputs};
use controller_core::schedule::Tick;
use controller_core::state_hash::StateHash;
use controller_core::units::Pose;
use nalgebra::Point2;

use crate::geometry::Disc;
use crate::khepera::{Khepera, KheperaModel, TICK_S, TruePose, wrapped};
use crate::lateness::Lateness;
use crate::number::{low_word, narrow};
use crate::proximity_model::{ProximityRing, SENSORS};
use crate::random::{Purpose, Stream};
use crate::scenario::NoiseLevels;
use crate::sil::ControllerPort;
use crate::world::World;

/// What disturbs nothing: for tests and references.
pub const QUIET: NoiseLevels = NoiseLevels {
    sensor: 0.0,
    actuator: 0.0,
    sensor_resolution_m: 0.0,
    dropout: 0.0,
    beam_half_width_rad: 0.0,
    pose_position_m: 0.0,
    pose_heading_rad: 0.0,
    task_jitter_ms: 0,
};

/// The papers' noise: 10 % white on sensors and actuators (P2), readings rounded to 5 mm, and beams of a real width.
pub const PAPERS: NoiseLevels = NoiseLevels {
    sensor: 0.1,
    actuator: 0.1,
    sensor_resolution_m: 0.005,
    dropout: 0.0,
    beam_half_width_rad: 0.130_899_693_899_574_72,
    pose_position_m: 0.0,
    pose_heading_rad: 0.0,
    task_jitter_ms: 0,
};

/// Whether the body touches something, tested at every tick.
///
/// The clearance shrinks by no more than what robot and movers have travelled since it was computed, so until they have
/// travelled that far there is nothing to compute, and the answer stays exact.
#[derive(Debug, Clone)]
struct ContactTest {
    spare_m: f64,
    /// First tick time at which shapes come or go.
    change_s: f64,
    touching: bool,
    count: u32,
}

/// Clearance above which a contact has ended; below it a robot that slides along a wall would count again and again.
const CONTACT_ENDS_M: f64 = 2e-4;

impl ContactTest {
    fn new() -> Self {
        Self { spare_m: 0.0, change_s: 0.0, touching: false, count: 0 }
    }

    /// Whether the body at `centre` is clear after robot and movers moved by at most `moved_m`.
    fn is_clear(
        &mut self,
        world: &World,
        centre: Point2<f64>,
        radius_m: f64,
        moved_m: f64,
        t_s: f64,
    ) -> bool {
        self.spare_m -= moved_m;
        // How far other driven robots go is not known beforehand.
        if self.spare_m > 0.0 && t_s < self.change_s && world.bodies.is_empty() {
            return true;
        }
        let clearance = world.clearance(centre, t_s) - radius_m;
        self.spare_m = clearance;
        self.change_s = world.next_change_s(t_s);
        if clearance <= 0.0 {
            if !self.touching {
                self.count += 1;
            }
            self.touching = true;
            return false;
        }
        if clearance > CONTACT_ENDS_M {
            self.touching = false;
        }
        true
    }
}

/// A run under way.
#[derive(Debug)]
pub struct Simulation<'w, C> {
    /// The controller.
    pub controller: C,
    world: &'w World,
    /// Way of the fastest mover in a tick.
    mover_way_m: f64,
    robot: Khepera,
    ring: ProximityRing,
    pose_noise: (f64, f64),
    pose_stream: Stream,
    exploration: Stream,
    /// Tasks that run late; `None` where they do not.
    lateness: Option<Lateness>,
    contact: ContactTest,
    tick: Tick,
    way_m: f64,
    hash: StateHash,
}

impl<'w, C: ControllerPort> Simulation<'w, C> {
    /// A robot at rest at `start`, with the streams of `seed`.
    #[must_use]
    pub fn new(
        controller: C,
        world: &'w World,
        model: KheperaModel,
        noise: &NoiseLevels,
        start: TruePose,
        seed: u64,
    ) -> Self {
        let ring = ProximityRing::new(
            model.body_radius_m,
            model.sensor_range_m,
            noise.beam_half_width_rad,
            noise.sensor_resolution_m,
            noise.sensor,
            Stream::new(seed, Purpose::Proximity),
        )
        .with_dropout(noise.dropout, Stream::new(seed, Purpose::Dropout));
        Self {
            controller,
            world,
            mover_way_m: world.fastest_mover_m_s() * TICK_S,
            robot: Khepera::new(model, start, Stream::new(seed, Purpose::Slip)),
            ring,
            pose_noise: (noise.pose_position_m, noise.pose_heading_rad),
            pose_stream: Stream::new(seed, Purpose::PoseFix),
            exploration: Stream::new(seed, Purpose::Exploration),
            lateness: Lateness::new(noise.task_jitter_ms, seed),
            contact: ContactTest::new(),
            tick: 0,
            way_m: 0.0,
            hash: StateHash::default(),
        }
    }

    /// One tick.
    ///
    /// # Errors
    /// If the controller cannot be reached any more; the world then stands where it was.
    pub fn step(&mut self) -> Result<Outputs<f32>, C::Error> {
        let outputs = self.decide_in(self.world)?;
        self.move_in(self.world, &outputs);
        Ok(outputs)
    }

    /// The first half of a tick: the sensors read `world`, the controller steps.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    #[inline]
    pub fn decide_in(&mut self, world: &World) -> Result<Outputs<f32>, C::Error> {
        let inputs = self.read(world);
        let Some(lateness) = &mut self.lateness else { return self.controller.step(self.tick, &inputs) };
        let finished = lateness.at(self.controller.schedule(), self.tick);
        self.controller.step_late(self.tick, &inputs, finished)
    }

    /// The second half of a tick: the robot moves in `world`.
    #[inline]
    pub fn move_in(&mut self, world: &World, outputs: &Outputs<f32>) {
        self.move_robot(world, outputs);
        self.tick += 1;
        let pose = self.robot.pose();
        for value in [pose.position.x, pose.position.y, pose.heading_rad] {
            let bits = value.to_bits();
            self.hash.add_word(low_word(bits ^ (bits >> 32)));
        }
    }

    fn read(&mut self, world: &World) -> Inputs<f32, SENSORS> {
        let due = self.controller.schedule().at(self.tick);
        let draw = |stream: &mut Stream| narrow(stream.symmetric());
        Inputs {
            encoders: self.robot.encoders(),
            pose_fix: (due.avoidance || due.step).then(|| self.pose_fix()),
            scan: due.avoidance.then(|| self.ring.scan(world, self.robot.pose(), self.time_s())),
            exploration: if due.step {
                [draw(&mut self.exploration), draw(&mut self.exploration)]
            } else {
                [0.0; 2]
            },
        }
    }

    /// The pose as a localisation system outside the robot would measure it.
    fn pose_fix(&mut self) -> Pose<f32> {
        let pose = self.robot.pose();
        let (position, heading) = self.pose_noise;
        let (x, y) = self.pose_stream.in_unit_disc();
        let turn = self.pose_stream.symmetric();
        Pose {
            x_m: narrow(pose.position.x + position * x),
            y_m: narrow(pose.position.y + position * y),
            heading_rad: narrow(wrapped(pose.heading_rad + heading * turn)),
        }
    }

    fn move_robot(&mut self, world: &World, outputs: &Outputs<f32>) {
        let before = self.robot.pose().position;
        let way = self.robot.tick(outputs.drive);
        let length = self.robot.way_m();
        let t_s = self.time_s() + TICK_S;
        let radius = self.robot.model().body_radius_m;
        let moved = length + self.mover_way_m;
        let wished = before + way;
        if self.contact.is_clear(world, wished, radius, moved, t_s) {
            self.way_m += length;
            self.robot.place(wished);
            return;
        }
        // Blocked: what remains of the way is its part along the surface, if that is free.
        let normal = world.nearest_surface_normal(wished, t_s).unwrap_or_default();
        let into = way.dot(&normal).min(0.0);
        let slid = before + (way - normal * into);
        let clearance = |position| world.clearance(position, t_s);
        // A robot that a mover has driven into may leave, but not go deeper: past the nearest point of something
        // round the
        // way leads away from the surface at its end only.
        if clearance(slid) >= radius || (into >= 0.0 && clearance(slid) >= clearance(before)) {
            self.way_m += (slid - before).norm();
            self.robot.place(slid);
        }
        // The next tick computes the clearance anew, whatever has become of the position.
        self.contact.spare_m = 0.0;
    }

    /// Time since the start in s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        seconds(self.tick)
    }

    /// Ticks since the start.
    #[must_use]
    pub fn tick(&self) -> Tick {
        self.tick
    }

    /// The physical robot, to change it under way as wear and damage do.
    pub fn model_mut(&mut self) -> &mut KheperaModel {
        self.robot.model_mut()
    }

    /// Where the robot really is.
    #[must_use]
    pub fn pose(&self) -> TruePose {
        self.robot.pose()
    }

    /// The robot's body as others see it.
    #[must_use]
    pub fn body(&self) -> Disc {
        Disc { centre: self.robot.pose().position, radius_m: self.robot.model().body_radius_m }
    }

    /// Way driven so far in m.
    #[must_use]
    pub fn way_m(&self) -> f64 {
        self.way_m
    }

    /// Contacts so far.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contact.count
    }

    /// Hash of everything so far: the controller's decisions and the robot's true poses.
    #[must_use]
    pub fn hash(&self) -> u64 {
        let mut hash = self.hash;
        let decisions = self.controller.hash();
        hash.add_word(low_word(decisions));
        hash.add_word(low_word(decisions >> 32));
        hash.value()
    }
}

/// Ticks as seconds; exact for 285,000 years.
#[allow(clippy::cast_precision_loss, reason = "exact below 2^53 ticks")]
#[must_use]
pub fn seconds(tick: Tick) -> f64 {
    tick.cast_signed() as f64 * TICK_S
}
