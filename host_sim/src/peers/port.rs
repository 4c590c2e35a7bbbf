//! A peer as the simulator meets it: the core's fast half, with a navigator in the place of the slow one.
//!
//! Odometry, arrival at checkpoints, servo, safety gate and the order within a tick are the core's, so that a peer
//! differs from cooperative EKMs in its decisions only.

use core::convert::Infallible;

use controller_core::config::{Config, ConfigError, Parameters};
use controller_core::controller::{Inputs, Mode, Outputs};
use controller_core::reflex::{Latched, Reflex};
use controller_core::schedule::{Schedule, Tick};
use controller_core::sensing::proximity::Scan;
use controller_core::units::WheelSpeeds;
use nalgebra::Point2;

use super::approach::approach;
use super::config::{ApproachConfig, PeerConfig};
use super::robot::{PeerRobot, Twist};
use super::surroundings::Surroundings;
use super::{Navigator, Target, View};
use crate::arc::Place;
use crate::lateness::Finished;
use crate::proximity_model::SENSORS;
use crate::sil::{Answer, ControllerPort, Order};

/// A navigator on a robot.
#[derive(Debug, Clone)]
pub struct PeerPort<N> {
    parameters: Parameters<f32, SENSORS>,
    reflex: Reflex<f32>,
    robot: PeerRobot,
    approach: ApproachConfig,
    surroundings: Surroundings,
    /// The last scan.
    latest: Scan<f32, SENSORS>,
    navigator: N,
    /// What a task that runs late has yet to work on.
    pending: Option<(Latched<f32>, Scan<f32, SENSORS>)>,
}

impl<N: Navigator> PeerPort<N> {
    /// A robot at rest, not armed.
    ///
    /// # Errors
    /// If the configuration of the robot cannot be used; that of the peers must be valid.
    pub fn new(navigator: N, config: &Config, peers: &PeerConfig) -> Result<Self, ConfigError> {
        let robot = PeerRobot::new(config);
        Ok(Self {
            parameters: config.build()?,
            reflex: Reflex::default(),
            robot,
            approach: peers.approach.clone(),
            surroundings: Surroundings::new(peers.memory.clone(), navigator.memory_s(), robot.body_radius_m),
            latest: Scan::EMPTY,
            navigator,
            pending: None,
        })
    }

    /// The command for a latched moment; without a checkpoint the robot stands still.
    fn decide(&mut self, latched: &Latched<f32>, scan: &Scan<f32, SENSORS>) -> WheelSpeeds<f32> {
        let pose = latched.pose;
        let place = Place {
            position: Point2::new(pose.x_m.into(), pose.y_m.into()),
            heading_rad: pose.heading_rad.into(),
        };
        let (radius, reach) = (self.robot.body_radius_m, self.robot.reach_m);
        let distance = |range: f32| radius + f64::from(range).max(0.0);
        let ranges = scan.range_m.map(|range| range.map(distance).filter(|&distance| distance < reach));
        self.surroundings.see(place, &ranges, reach, self.robot.period_s);
        let Some(target) = latched.target else { return WheelSpeeds::STOP };
        let position = Point2::new(f64::from(target.x_m), f64::from(target.y_m));
        let to = position - place.position;
        let view = View {
            position: place.position,
            heading_rad: place.heading_rad,
            target: Target {
                position,
                bearing_rad: crate::khepera::wrapped(libm::atan2(to.y, to.x) - place.heading_rad),
                distance_m: to.norm(),
            },
            ranges: &ranges,
            points: self.surroundings.points(),
            speed: Twist::of_wheels(self.reflex.measured_speeds(), &self.robot),
        };
        let motion = approach(&self.approach, &self.robot, &view);
        let motion = motion.unwrap_or_else(|| self.navigator.decide(&view));
        let speeds = motion.wheels(&self.robot);
        self.parameters.command_unit.map_or(speeds, |unit| unit.rounded(speeds))
    }
}

impl<N: Navigator> ControllerPort for PeerPort<N> {
    type Error = Infallible;

    fn step(&mut self, now: Tick, inputs: &Inputs<f32, SENSORS>) -> Result<Outputs<f32>, Infallible> {
        // On time: ready in the tick of its release.
        self.step_late(now, inputs, Finished { avoidance: true, target: true })
    }

    fn step_late(
        &mut self,
        now: Tick,
        inputs: &Inputs<f32, SENSORS>,
        finished: Finished,
    ) -> Result<Outputs<f32>, Infallible> {
        let released = self.parameters.reflex.schedule.at(now);
        if let Some(pose) = inputs.pose_fix {
            self.reflex.fix_pose(pose);
        }
        if let Some(scan) = inputs.scan {
            self.reflex.note_scan(now);
            self.latest = scan;
        }
        let (drive, stopped) = self.reflex.tick(&self.parameters.reflex, now, inputs.encoders);
        let reached = self.reflex.arrive(&self.parameters.reflex, now);
        if self.reflex.mode() == Mode::Navigate && released.avoidance {
            self.pending = Some((self.reflex.latch(&self.parameters.reflex, now), self.latest));
        }
        if let Some((latched, scan)) = self.pending.take_if(|_| finished.avoidance) {
            let speeds = self.decide(&latched, &scan);
            self.reflex.take_command(latched.now, speeds);
        }
        Ok(Outputs { drive, command: self.reflex.command(), reached, stopped, released })
    }

    fn schedule(&self) -> Schedule {
        self.parameters.reflex.schedule
    }

    fn order(&mut self, order: Order<'_>) -> Result<Answer, Infallible> {
        match order {
            Order::Mode { mode, now } => {
                self.reflex.set_mode(mode, now);
                self.pending = None;
                self.surroundings.clear();
                self.navigator.reset();
            }
            Order::Arm => self.reflex.gate.arm(),
            Order::Checkpoints(checkpoints) => return Ok(self.reflex.checkpoints.replace_all(checkpoints)),
            Order::Append(checkpoints) => return Ok(self.reflex.checkpoints.append(checkpoints)),
            Order::Checkpoint { number, at } => return Ok(self.reflex.checkpoints.replace(number, at)),
        }
        Ok(Ok(()))
    }

    fn hash(&self) -> u64 {
        self.reflex.hash().value()
    }
}
