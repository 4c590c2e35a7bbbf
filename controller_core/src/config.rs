//! Every number of the controller, in SI units, with its reason.
//!
//! [`Config`] is what people write and read: `f32`, one field per number, validated once by [`Config::build`], which
//! gives the [`Parameters`] in the controller's own scalar and units. Nothing is validated again at run time.
//! [`PARAMETERS`] lists the same numbers with unit and range, for those who handle them by number.
//!
//! "Measured" in a reason means the experiments of `host_sim`; "prototype" an earlier throw-away simulator.

use crate::baseline::braitenberg::{AvoidanceParameters, Wiring};
use crate::integration::neural::NeuralParameters;
use crate::integration::sweep::SweepParameters;
use crate::kohonen::features::{Chart, Scaling};
use crate::kohonen::map::{Eligible, WinnerParameters};
use crate::kohonen::self_organisation::{Annealing, Displacement, LearningParameters, StepRule};
use crate::localisation::detour::DetourParameters;
use crate::localisation::memory::MemoryParameters;
use crate::localisation::mover::MoverParameters;
use crate::localisation::obstacle::{FieldCentre, ObstacleFieldParameters};
use crate::localisation::opening::OpeningParameters;
use crate::localisation::target::TargetFieldParameters;
use crate::motor_control::{Aim, Beyond, CommandUnit, ReachingParameters};
use crate::planning::checkpoint::CheckpointParameters;
use crate::reflex::ReflexParameters;
use crate::scalar::Scalar;
use crate::schedule::Schedule;
use crate::sensing::odometry::OdometryParameters;
use crate::sensing::proximity::ProximityParameters;
use crate::servo::ServoParameters;

mod parameters;

use parameters::{SLOTS, number_of};

pub use parameters::{Kind, PARAMETER_COUNT, PARAMETERS, Parameter};

/// Which architecture drives the robot between checkpoints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Architecture {
    /// Cooperative EKMs with neural integration (P2).
    #[default]
    Cooperative,
    /// Target reaching EKM and Braitenberg avoidance with command fusion (P1).
    Fusion,
}

/// The elements of the Braitenberg matrix Z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WiringKind {
    /// The literal reading of P1, section 2.4.
    #[default]
    Symmetric,
    /// An obstacle straight ahead turns the robot on the spot.
    Asymmetric,
}

/// The robot.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct RobotConfig {
    /// Radius of the body; Khepera: 25 mm in the papers.
    pub body_radius_m: f32,
    /// Distance between the wheels' points of contact; Khepera: 53 mm.
    pub wheel_base_m: f32,
    /// c*: the largest speed that may be commanded per wheel; 0.16 m/s makes the longest 1.024 s move of P1 Fig. 6.
    pub speed_limit_mps: f32,
    /// Encoder counts per metre of wheel travel; Khepera: 12 per millimetre.
    pub encoder_counts_per_m: f32,
    /// Range of the proximity sensors beyond the body; P2: 17.5 cm.
    pub sensor_range_m: f32,
    /// Resolution of wheel speeds; 0 for continuous ones. A Khepera takes multiples of 8 mm/s.
    pub command_unit_mps: f32,
}

/// The 1 ms servo; laws in [`crate::servo`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct ServoConfig {
    /// Largest acceleration of a wheel: the robot stops from c* within 9 mm. At 1 m/s² its inertia cost 3 % of the time
    /// to a target, at 1.5 it costs 0.6 %.
    pub acceleration_mps2: f32,
    /// Wheel speed of a free motor at full drive; its inverse is the feedforward.
    pub free_speed_mps: f32,
    /// Drive per m/s of speed error.
    pub proportional_per_mps: f32,
    /// Drive per metre of lag.
    pub integral_per_m: f32,
    /// Bound of the lag (anti-windup): 4 mm is what a blocked wheel may catch up after it is freed.
    pub lag_limit_m: f32,
    /// Time constant of the measured speed; one count per tick is 83 mm/s, so it must span many ticks.
    pub speed_filter_ms: f32,
    /// A wheel asked for less than this is never called stalled.
    pub stall_reference_mps: f32,
    /// A wheel slower than this share of what is asked does not follow.
    pub stall_share: f32,
    /// How long it may not follow before the servo reports a stall.
    pub stall_ms: u16,
    /// How long the motors then rest before they try again.
    pub stall_hold_ms: u16,
}

/// Periods, see [`crate::schedule`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct ScheduleConfig {
    /// Obstacle avoidance: 128 in both papers.
    pub avoidance_period_ms: u16,
    /// Target reaching: 256 in P2, 1024 in P1.
    pub target_period_ms: u16,
    /// One step of the map: 1024 in P1. Commands are renewed sooner, but a map of long steps looks farther ahead.
    pub step_ms: u16,
}

/// Online training, see [`crate::kohonen::self_organisation`]. Schedules run over `annealing_steps`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct LearningConfig {
    /// Steps after which the schedules stand still.
    pub annealing_steps: u16,
    /// η of Eq. 8 at first.
    pub output_rate_first: f32,
    /// η of Eq. 8 at last; small, for online learning must not wander.
    pub output_rate_last: f32,
    /// η of Eq. 6 at first.
    pub weight_rate_first: f32,
    /// η of Eq. 6 at last.
    pub weight_rate_last: f32,
    /// σ of G in lattice units at first: the whole map learns from the first moves.
    pub neighbourhood_first: f32,
    /// σ of G at last: each neuron its own place. In the prototype a constant σ of 1 costs a factor 2 in error, ½ from
    /// the start 25.
    pub neighbourhood_last: f32,
    /// Random part of a command at first, as a share of c*: with `M = 0` nothing else moves the robot.
    pub exploration_first: f32,
    /// Random part at last; without any, the map forgets what it does not use.
    pub exploration_last: f32,
    /// ε of the normalised step, in squared features.
    pub regularisation: f32,
    /// Shorter moves teach nothing, in features (1 = a radian, or the reach).
    pub shortest_move: f32,
    /// A settled map that lately is wrong by so many times what is usual takes the robot for changed, and learns
    /// quickly again; 0 switches it off.
    pub surprise_ratio: f32,
    /// The schedules then go back to this step.
    pub surprised_age: u16,
    /// How far a gradient step goes.
    pub step: StepRule,
    /// How a move is measured.
    pub displacement: Displacement,
    /// The coordinates of the map.
    pub chart: Chart,
}

/// Target reaching: winner and motor control.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct ReachingConfig {
    /// How many neurons A(α) admits beyond the closest bearing.
    pub bearing_tolerance_rad: f32,
    /// `γ_α` of Eq. 3, per rad².
    pub bearing_weight: f32,
    /// `γ_d` of Eq. 3, per squared reach.
    pub distance_weight: f32,
    /// From this share of the reach on a target is far and aimed at by half its bearing; 0 is the paper's literal form.
    pub far_share: f32,
    /// Below this share of the reach a target is near, and turned towards on the spot before it is driven to; 0 is the
    /// paper's literal form. Chosen wider than the millimetres at which the robot otherwise circles a target.
    pub near_share: f32,
    /// A near target within this bearing is driven to at once: the arc then ends within the tolerance.
    pub near_bearing_rad: f32,
    /// Which neurons may win in control.
    pub eligible: Eligible,
    /// Commands beyond c*.
    pub beyond: Beyond,
    /// A checkpoint on the way is reached within this. The papers say 5 mm; 1 mm is left for dead reckoning.
    pub checkpoint_tolerance_m: f32,
    /// The goal is reached, and the robot stops, within this.
    pub goal_tolerance_m: f32,
    /// Fastest speed of the robot's centre with which the goal may be reached: at 10 mm/s the robot rolls on for a
    /// twentieth of a millimetre.
    pub goal_speed_mps: f32,
}

/// Cooperative EKMs: fields and neural integration (P2 Eq. 4–10), and what we added.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct CooperativeConfig {
    /// Peak of the target field against an obstacle field's 1. The hidden key of P2: with equal peaks the robot
    /// drives into what it wants to go around.
    pub target_amplitude: f32,
    /// `σ_aα`.
    pub target_bearing_sigma_rad: f32,
    /// `σ_ad`, much smaller (P2).
    pub target_distance_sigma_m: f32,
    /// From this share of the reach on a target is far (see `reaching.far_share`) and its field is centred here: the
    /// robot cruises at this share of c*. 0 is the literal form, in which the outermost neurons win.
    pub cruise_share: f32,
    /// `σ_bα`.
    pub obstacle_bearing_sigma_rad: f32,
    /// `σ_bd` behind an obstacle; P2: 3.5.
    pub obstacle_behind_sigma_m: f32,
    /// `σ_bd` in front of an obstacle; P2: 0.035.
    pub obstacle_front_sigma_m: f32,
    /// Where obstacle fields are centred.
    pub obstacle_centre: FieldCentre,
    /// Swept path: clearance wished beyond the body.
    pub sweep_margin_m: f32,
    /// Swept path: inhibition per margin of lacking clearance; 0 switches it off.
    pub sweep_strength: f32,
    /// Swept path: share of a step that is checked.
    pub sweep_look_ahead: f32,
    /// Further clearance wished beyond `sweep_margin_m`, per length of the step (m/m).
    pub sweep_headway: f32,
    /// Obstacle memory: how long a point stays; 0 switches it off.
    pub memory_ms: u16,
    /// Obstacle memory: points nearer to each other are one.
    pub memory_merge_m: f32,
    /// Movers: what moves is given so many seconds of its way; 0, the default: nothing is taken to move, as on boards,
    /// which have no room for it ([`crate::localisation::mover`]). Where there is, 0.6 with a `cruise_share` of 0.75 is
    /// what was measured best; the simulator has that by default.
    pub mover_headway_s: f32,
    /// Movers: what is slower beside the body counts as standing.
    pub mover_speed_mps: f32,
    /// Detour: time without progress after which a wall is followed; 0 switches it off.
    pub detour_patience_ms: u16,
    /// Detour: coming nearer to the target by this much is progress.
    pub detour_progress_m: f32,
    /// Detour: distance of the robot's centre from the wall it follows.
    pub detour_follow_m: f32,
    /// Detour: it ends only when this much to either side of the target is free.
    pub detour_free_rad: f32,
    /// Detour: obstacles farther than this do not hide the target.
    pub detour_free_m: f32,
    /// Detour: time after which the other side is tried, doubled each time.
    pub detour_side_ms: u16,
    /// The way along a wall must be free for so far, or it is turned away from the wall (m); 0: it need not.
    pub detour_clear_m: f32,
    /// Opening: clearance on either side of the body that makes a way through, and that is kept on it.
    pub opening_margin_m: f32,
    /// Opening: a way with something this near on both sides is one; 0 switches openings off.
    pub opening_flank_m: f32,
    /// Opening: how far ahead it is looked for.
    pub opening_length_m: f32,
    /// Opening: how far from the wanted direction.
    pub opening_aside_rad: f32,
    /// Beyond this bearing an opening is turned towards on the spot, and so is the next checkpoint where one has just
    /// been reached; π and more: nothing is.
    pub opening_turn_rad: f32,
    /// Opening: `σ_ad` on the way through.
    pub opening_distance_sigma_m: f32,
    /// Opening: how long one is tried.
    pub opening_give_up_ms: u16,
}

/// Command fusion with Braitenberg avoidance (P1 Eq. 9, 10).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct FusionConfig {
    /// β: the target's share in 0..=1.
    pub target_share: f32,
    /// Z.
    pub wiring: WiringKind,
    /// Factor on Z.
    pub avoidance_gain: f32,
    /// Obstacles farther than this beyond the body are not avoided.
    pub avoidance_range_m: f32,
}

/// Limits after which the wheels stop, see [`crate::safety`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct SafetyConfig {
    /// Oldest scan the robot may drive on: three missed ones.
    pub scan_age_max_ms: u16,
    /// Oldest motor command that is still carried out, beyond its own period.
    pub command_age_max_ms: u16,
}

/// All of it. `Config::default()` is the Khepera of the papers with our best settings.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Config {
    /// Which architecture drives.
    pub architecture: Architecture,
    /// The robot.
    pub robot: RobotConfig,
    /// The servo.
    pub servo: ServoConfig,
    /// Periods.
    pub schedule: ScheduleConfig,
    /// Online training.
    pub learning: LearningConfig,
    /// Target reaching.
    pub reaching: ReachingConfig,
    /// Cooperative EKMs.
    pub cooperative: CooperativeConfig,
    /// Command fusion.
    pub fusion: FusionConfig,
    /// Safety.
    pub safety: SafetyConfig,
}

impl Default for RobotConfig {
    fn default() -> Self {
        Self {
            body_radius_m: 0.025,
            wheel_base_m: 0.053,
            speed_limit_mps: 0.16,
            encoder_counts_per_m: 12_000.0,
            sensor_range_m: 0.175,
            command_unit_mps: 0.0,
        }
    }
}

impl Default for ServoConfig {
    fn default() -> Self {
        Self {
            acceleration_mps2: 1.5,
            free_speed_mps: 0.25,
            proportional_per_mps: 4.0,
            integral_per_m: 60.0,
            lag_limit_m: 0.004,
            speed_filter_ms: 12.0,
            stall_reference_mps: 0.02,
            stall_share: 0.2,
            stall_ms: 300,
            stall_hold_ms: 1000,
        }
    }
}

impl Default for ScheduleConfig {
    fn default() -> Self {
        Self { avoidance_period_ms: 128, target_period_ms: 256, step_ms: 1024 }
    }
}

impl Default for LearningConfig {
    fn default() -> Self {
        Self {
            annealing_steps: 1500,
            output_rate_first: 0.5,
            output_rate_last: 0.1,
            weight_rate_first: 0.3,
            weight_rate_last: 0.06,
            neighbourhood_first: 3.0,
            neighbourhood_last: 0.5,
            exploration_first: 1.0,
            exploration_last: 0.12,
            regularisation: 0.02,
            shortest_move: 0.025,
            surprise_ratio: 1.7,
            surprised_age: 500,
            step: StepRule::Normalised,
            displacement: Displacement::HalfTurn,
            chart: Chart::Signed,
        }
    }
}

impl Default for ReachingConfig {
    fn default() -> Self {
        Self {
            bearing_tolerance_rad: 0.1,
            bearing_weight: 1.0,
            distance_weight: 1.0,
            far_share: 0.92,
            near_share: 0.05,
            near_bearing_rad: 0.1,
            eligible: Eligible::Trained,
            beyond: Beyond::NearerOnBearing,
            checkpoint_tolerance_m: 0.004,
            goal_tolerance_m: 0.001,
            goal_speed_mps: 0.01,
        }
    }
}

impl Default for CooperativeConfig {
    fn default() -> Self {
        // Found by seeded random searches over the papers' scenes, traps and doors; see docs/numbers.md.
        Self {
            target_amplitude: 0.0307,
            target_bearing_sigma_rad: 1.46,
            target_distance_sigma_m: 0.0129,
            cruise_share: 0.7,
            obstacle_bearing_sigma_rad: 0.221,
            obstacle_behind_sigma_m: 2.5,
            obstacle_front_sigma_m: 0.00618,
            obstacle_centre: FieldCentre::Sensed,
            sweep_margin_m: 0.0025,
            sweep_strength: 8.0,
            sweep_look_ahead: 1.0,
            sweep_headway: 0.0648,
            memory_ms: 500,
            memory_merge_m: 0.014,
            mover_headway_s: 0.0,
            mover_speed_mps: 0.02,
            detour_patience_ms: 4300,
            detour_progress_m: 0.0131,
            detour_follow_m: 0.0462,
            detour_free_rad: 0.394,
            detour_free_m: 0.085,
            detour_side_ms: 19_000,
            detour_clear_m: 0.04,
            opening_margin_m: 0.0018,
            opening_flank_m: 0.0483,
            opening_length_m: 0.128,
            opening_aside_rad: 1.02,
            opening_turn_rad: 0.298,
            opening_distance_sigma_m: 0.0405,
            opening_give_up_ms: 9000,
        }
    }
}

impl Default for FusionConfig {
    fn default() -> Self {
        // Drawn at random for the three figures of P1, which command fusion is the architecture of; see
        // docs/numbers.md.
        Self {
            target_share: 0.42,
            wiring: WiringKind::Symmetric,
            avoidance_gain: 4.85,
            avoidance_range_m: 0.039,
        }
    }
}

impl Default for SafetyConfig {
    fn default() -> Self {
        Self { scan_age_max_ms: 400, command_age_max_ms: 400 }
    }
}

/// A number that cannot be used: which, what it is, and what it must be.
///
/// Held as numbers, so that a program that shows it to nobody need not hold the words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfigError {
    number: u8,
    value: f32,
    must: Must,
}

/// What a number must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Must {
    BeInRange,
    BeWhole,
    BeListed,
    ReachSpeedLimit,
    BeCoarse,
    BeMultipleOfPeriod,
    BeNoneOnBoards,
    ExceedPeriod,
    FitFixedPoint,
}

impl ConfigError {
    const NO_PARAMETER: u8 = u8::MAX;

    /// Number of the parameter that cannot be used; `None` where there is no such parameter.
    #[must_use]
    pub fn index(&self) -> Option<usize> {
        Some(usize::from(self.number)).filter(|&index| index < PARAMETER_COUNT)
    }

    /// The field, as written in a configuration file: `servo.stall_share`.
    #[must_use]
    pub fn field(&self) -> &'static str {
        self.parameter().map_or("number of the parameter", |parameter| parameter.name)
    }

    /// Its value.
    #[must_use]
    pub fn value(&self) -> f32 {
        self.value
    }

    /// What it must be.
    #[must_use]
    pub fn must(&self) -> &'static str {
        match self.must {
            Must::BeInRange => self.parameter().map_or("", |parameter| parameter.must),
            Must::BeWhole => "a whole number",
            Must::BeListed => "in the list of parameters",
            Must::ReachSpeedLimit => "at least robot.speed_limit_mps",
            Must::BeCoarse => "0 (continuous) or between a thousandth of robot.speed_limit_mps and all of it",
            Must::BeMultipleOfPeriod => "a multiple of schedule.avoidance_period_ms",
            Must::BeNoneOnBoards => "0: boards do not follow what moves",
            Must::ExceedPeriod => "longer than schedule.avoidance_period_ms",
            Must::FitFixedPoint => {
                "at most 2,000 / robot.wheel_base_m in fixed point (divide finer encoders)"
            }
        }
    }

    fn parameter(&self) -> Option<&'static Parameter> {
        PARAMETERS.get(usize::from(self.number))
    }
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} = {}: must be {}", self.field(), self.value, self.must())
    }
}

impl core::error::Error for ConfigError {}

/// A share where there is one; 0 switches it off.
fn positive<S: Scalar>(share: f32) -> Option<S> {
    (share > 0.0).then(|| S::from_f32(share))
}

/// `Ok` where the value is a number within `low..=high`.
fn within(number: u8, value: f32, (low, high): (f32, f32), must: Must) -> Result<(), ConfigError> {
    if value >= low && value <= high { Ok(()) } else { Err(ConfigError { number, value, must }) }
}

impl Config {
    /// Checks every number.
    ///
    /// # Errors
    /// The first field that cannot be used, with its value and what it must be.
    pub fn validate(&self) -> Result<(), ConfigError> {
        for (number, slot) in (0..).zip(&SLOTS) {
            slot.check(number, (slot.read)(self))?;
        }
        self.validate_rules()
    }

    /// Checks what one number demands of another; each alone is within its range.
    fn validate_rules(&self) -> Result<(), ConfigError> {
        within(
            const { number_of("servo.free_speed_mps") },
            self.servo.free_speed_mps,
            (self.robot.speed_limit_mps, f32::MAX),
            Must::ReachSpeedLimit,
        )?;
        if self.robot.command_unit_mps != 0.0 {
            within(
                const { number_of("robot.command_unit_mps") },
                self.robot.command_unit_mps,
                (self.robot.speed_limit_mps / 1000.0, self.robot.speed_limit_mps),
                Must::BeCoarse,
            )?;
        }
        let period = self.schedule.avoidance_period_ms;
        // A field renewed between two scans would be integrated with one of another moment.
        let multiple = |number, value: u16| {
            if value.is_multiple_of(period) {
                Ok(())
            } else {
                Err(ConfigError { number, value: f32::from(value), must: Must::BeMultipleOfPeriod })
            }
        };
        multiple(const { number_of("schedule.target_period_ms") }, self.schedule.target_period_ms)?;
        multiple(const { number_of("schedule.step_ms") }, self.schedule.step_ms)?;
        within(
            const { number_of("safety.scan_age_max_ms") },
            f32::from(self.safety.scan_age_max_ms),
            (f32::from(period), f32::MAX),
            Must::ExceedPeriod,
        )
    }

    /// Checks what a controller without room for tracks cannot do.
    ///
    /// # Errors
    /// Movers are to be followed.
    pub fn check_without_movers(&self) -> Result<(), ConfigError> {
        within(
            const { number_of("cooperative.mover_headway_s") },
            self.cooperative.mover_headway_s,
            (0.0, 0.0),
            Must::BeNoneOnBoards,
        )
    }

    /// Validates, and converts into the controller's scalar and units.
    ///
    /// # Errors
    /// As [`Config::validate`], and where the scalar cannot hold the robot's counts per radian.
    pub fn build<S: Scalar, const SENSORS: usize>(&self) -> Result<Parameters<S, SENSORS>, ConfigError> {
        self.check::<S>()?;
        Ok(Parameters {
            architecture: self.architecture,
            reflex: self.reflex_parameters(),
            scaling: self.scaling(),
            speed_limit_mps: S::from_f32(self.robot.speed_limit_mps),
            proximity: self.proximity_parameters(),
            learning: self.learning_parameters(),
            reaching: self.reaching_parameters(),
            neural: self.neural_parameters(),
            sweep: self.sweep_parameters(),
            memory: self.memory_parameters(),
            mover: self.mover_parameters(),
            detour: self.detour_parameters(),
            opening: self.opening_parameters(),
            wiring: self.wiring(),
            avoidance: self.avoidance_parameters(),
            target_share: S::from_f32(self.fusion.target_share),
            command_unit: self.command_unit(),
        })
    }

    /// As [`Config::build`], but over parameters that there are already, and group by group: on a board with little
    /// memory there is no room for a second set.
    ///
    /// # Errors
    /// As [`Config::build`]; then nothing is changed.
    pub fn build_over<S: Scalar, const SENSORS: usize>(
        &self,
        parameters: &mut Parameters<S, SENSORS>,
    ) -> Result<(), ConfigError> {
        self.check::<S>()?;
        // All are named, so that none can be forgotten.
        let Parameters {
            architecture,
            reflex,
            scaling,
            speed_limit_mps,
            proximity,
            learning,
            reaching,
            neural,
            sweep,
            memory,
            mover,
            detour,
            opening,
            wiring,
            avoidance,
            target_share,
            command_unit,
        } = parameters;
        *architecture = self.architecture;
        *reflex = self.reflex_parameters();
        *scaling = self.scaling();
        *speed_limit_mps = S::from_f32(self.robot.speed_limit_mps);
        *proximity = self.proximity_parameters();
        *learning = self.learning_parameters();
        *reaching = self.reaching_parameters();
        *neural = self.neural_parameters();
        *sweep = self.sweep_parameters();
        *memory = self.memory_parameters();
        *mover = self.mover_parameters();
        *detour = self.detour_parameters();
        *opening = self.opening_parameters();
        *wiring = self.wiring();
        *avoidance = self.avoidance_parameters();
        *target_share = S::from_f32(self.fusion.target_share);
        *command_unit = self.command_unit();
        Ok(())
    }

    /// Checks every number, and that the scalar can hold what follows from them.
    fn check<S: Scalar>(&self) -> Result<(), ConfigError> {
        self.validate()?;
        let counts_per_radian = self.counts_per_radian();
        // The only number that valid fields can bring beyond what fixed point holds in a robot one could build.
        if S::from_f32(counts_per_radian).to_f32() < 0.99 * counts_per_radian {
            return Err(ConfigError {
                number: const { number_of("robot.encoder_counts_per_m") },
                value: self.robot.encoder_counts_per_m,
                must: Must::FitFixedPoint,
            });
        }
        Ok(())
    }

    fn command_unit<S: Scalar>(&self) -> Option<CommandUnit<S>> {
        let unit_mps = self.robot.command_unit_mps;
        (unit_mps > 0.0).then(|| CommandUnit::new(unit_mps))
    }

    /// The bearing within which a near target is driven to at once: `reaching.near_bearing_rad`, or what half a unit of
    /// speed turns the robot by. Nothing is left of a smaller turn, and the robot would stand aside of its target for
    /// ever.
    #[must_use]
    pub fn near_bearing_rad(&self) -> f32 {
        let step_s = f32::from(self.schedule.step_ms) / 1000.0;
        let least_turn_rad = self.robot.command_unit_mps * step_s / self.robot.wheel_base_m;
        self.reaching.near_bearing_rad.max(least_turn_rad)
    }

    /// Where the map is aimed.
    fn aim<S: Scalar>(&self) -> Aim<S> {
        Aim {
            near: S::from_f32(self.reaching.near_share),
            near_bearing: S::from_f32(self.near_bearing_rad()),
            chart: self.learning.chart,
        }
    }

    fn scaling<S: Scalar>(&self) -> Scaling<S> {
        Scaling::new(self.robot.speed_limit_mps, f32::from(self.schedule.step_ms) / 1000.0)
    }

    fn proximity_parameters<S: Scalar>(&self) -> ProximityParameters<S> {
        ProximityParameters {
            body_radius_m: S::from_f32(self.robot.body_radius_m),
            range_m: S::from_f32(self.robot.sensor_range_m),
        }
    }

    fn memory_parameters<S: Scalar>(&self) -> MemoryParameters<S> {
        MemoryParameters {
            lifetime_ms: self.cooperative.memory_ms,
            merge_m: S::from_f32(self.cooperative.memory_merge_m),
        }
    }

    fn mover_parameters<S: Scalar>(&self) -> MoverParameters<S> {
        MoverParameters {
            headway_s: S::from_f32(self.cooperative.mover_headway_s),
            speed_mps: S::from_f32(self.cooperative.mover_speed_mps),
        }
    }

    fn wiring<S: Scalar, const SENSORS: usize>(&self) -> Wiring<S, SENSORS> {
        match self.fusion.wiring {
            WiringKind::Symmetric => Wiring::symmetric(),
            WiringKind::Asymmetric => Wiring::asymmetric(),
        }
    }

    fn avoidance_parameters<S: Scalar>(&self) -> AvoidanceParameters<S> {
        let f = &self.fusion;
        AvoidanceParameters {
            range_m: S::from_f32(f.avoidance_range_m.min(self.robot.sensor_range_m)),
            per_range: S::from_f32(1.0 / f.avoidance_range_m),
            gain: S::from_f32(f.avoidance_gain),
        }
    }

    /// The longest way of one step of the map.
    fn reach_m(&self) -> f32 {
        self.robot.speed_limit_mps * f32::from(self.schedule.step_ms) / 1000.0
    }

    /// Counts of difference between the wheels for one radian of heading.
    fn counts_per_radian(&self) -> f32 {
        self.robot.encoder_counts_per_m * self.robot.wheel_base_m
    }

    fn reflex_parameters<S: Scalar>(&self) -> ReflexParameters<S> {
        let s = S::from_f32;
        ReflexParameters {
            schedule: Schedule {
                avoidance_period_ms: self.schedule.avoidance_period_ms,
                target_period_ms: self.schedule.target_period_ms,
                step_ms: self.schedule.step_ms,
            },
            odometry: OdometryParameters {
                half_counts_per_5_cm: s(self.robot.encoder_counts_per_m * 0.1),
                counts_per_radian: s(self.counts_per_radian()),
            },
            servo: self.servo_parameters(),
            checkpoints: CheckpointParameters {
                tolerance_m: s(self.reaching.checkpoint_tolerance_m),
                goal_tolerance_m: s(self.reaching.goal_tolerance_m),
                goal_speed_mps: s(self.reaching.goal_speed_mps),
            },
            scan_age_max_ms: self.safety.scan_age_max_ms,
            command_age_max_ms: self.safety.command_age_max_ms,
        }
    }

    fn servo_parameters<S: Scalar>(&self) -> ServoParameters<S> {
        let s = S::from_f32;
        let tick_s = f32::from(crate::servo::TICK_MS) / 1000.0;
        let counts_per_tick = self.robot.encoder_counts_per_m * tick_s;
        ServoParameters {
            acceleration_per_tick_mps: s(self.servo.acceleration_mps2 * tick_s),
            counts_per_tick_per_mps: s(counts_per_tick),
            mps_per_count_per_tick: s(1.0 / counts_per_tick),
            feedforward: s(1.0 / self.servo.free_speed_mps),
            proportional: s(self.servo.proportional_per_mps),
            integral: s(self.servo.integral_per_m / self.robot.encoder_counts_per_m),
            lag_limit: s(self.servo.lag_limit_m * self.robot.encoder_counts_per_m),
            speed_filter: s(1.0 / self.servo.speed_filter_ms),
            stall_reference_mps: s(self.servo.stall_reference_mps),
            stall_share: s(self.servo.stall_share),
            stall_ms: self.servo.stall_ms,
            stall_hold_ms: self.servo.stall_hold_ms,
        }
    }

    fn learning_parameters<S: Scalar>(&self) -> LearningParameters<S> {
        let l = &self.learning;
        let annealing = |first, last| Annealing::new(first, last, l.annealing_steps);
        LearningParameters {
            output_rate: annealing(l.output_rate_first, l.output_rate_last),
            weight_rate: annealing(l.weight_rate_first, l.weight_rate_last),
            neighbourhood: annealing(l.neighbourhood_first, l.neighbourhood_last),
            exploration: annealing(l.exploration_first, l.exploration_last),
            regularisation: S::from_f32(l.regularisation),
            surprise_ratio: S::from_f32(l.surprise_ratio),
            surprised_age: l.surprised_age,
            step: l.step,
            displacement: l.displacement,
            chart: l.chart,
            shortest_move: S::from_f32(l.shortest_move),
        }
    }

    fn reaching_parameters<S: Scalar>(&self) -> ReachingParameters<S> {
        let r = &self.reaching;
        ReachingParameters {
            far: positive(r.far_share),
            aim: self.aim(),
            beyond: r.beyond,
            winner: WinnerParameters {
                bearing_tolerance: S::from_f32(r.bearing_tolerance_rad),
                bearing_weight: S::from_f32(r.bearing_weight),
                distance_weight: S::from_f32(r.distance_weight),
                eligible: r.eligible,
            },
        }
    }

    fn neural_parameters<S: Scalar>(&self) -> NeuralParameters<S> {
        let (c, reach_m) = (&self.cooperative, self.reach_m());
        // exp(−x² / 2σ²) = exp(−(x · steepness)²).
        let steepness = |sigma: f32| S::from_f32(core::f32::consts::FRAC_1_SQRT_2 / sigma);
        NeuralParameters {
            target: TargetFieldParameters {
                amplitude: S::from_f32(c.target_amplitude),
                bearing_steepness: steepness(c.target_bearing_sigma_rad),
                distance_steepness: steepness(c.target_distance_sigma_m / reach_m),
                far: positive(c.cruise_share),
            },
            obstacle: ObstacleFieldParameters {
                bearing_steepness: steepness(c.obstacle_bearing_sigma_rad),
                behind_steepness: steepness(c.obstacle_behind_sigma_m / reach_m),
                front_steepness: steepness(c.obstacle_front_sigma_m / reach_m),
                centre: c.obstacle_centre,
                chart: self.learning.chart,
            },
        }
    }

    fn sweep_parameters<S: Scalar>(&self) -> SweepParameters<S> {
        let c = &self.cooperative;
        SweepParameters {
            body_radius_m: S::from_f32(self.robot.body_radius_m),
            margin_m: S::from_f32(c.sweep_margin_m),
            strength_per_m: S::from_f32(c.sweep_strength / c.sweep_margin_m),
            look_ahead: S::from_f32(c.sweep_look_ahead),
            headway: S::from_f32(c.sweep_headway),
            step_s: S::from_f32(f32::from(self.schedule.step_ms) / 1000.0),
        }
    }

    fn detour_parameters<S: Scalar>(&self) -> DetourParameters<S> {
        let c = &self.cooperative;
        DetourParameters {
            patience_ms: c.detour_patience_ms,
            progress_m: S::from_f32(c.detour_progress_m),
            follow_m: S::from_f32(c.detour_follow_m),
            per_follow: S::from_f32(1.0 / c.detour_follow_m),
            free_rad: S::from_f32(c.detour_free_rad),
            free_m: S::from_f32(c.detour_free_m),
            side_ms: c.detour_side_ms,
            clear_m: S::from_f32(c.detour_clear_m),
            half_width_m: S::from_f32(self.robot.body_radius_m + c.opening_margin_m),
        }
    }

    fn opening_parameters<S: Scalar>(&self) -> OpeningParameters<S> {
        let c = &self.cooperative;
        let sigma = c.opening_distance_sigma_m / self.reach_m();
        OpeningParameters {
            distance_steepness: S::from_f32(core::f32::consts::FRAC_1_SQRT_2 / sigma),
            half_width_m: S::from_f32(self.robot.body_radius_m + c.opening_margin_m),
            flank_m: S::from_f32(c.opening_flank_m),
            length_m: S::from_f32(c.opening_length_m),
            aside_rad: S::from_f32(c.opening_aside_rad),
            turn_rad: S::from_f32(c.opening_turn_rad),
            give_up_ms: c.opening_give_up_ms,
        }
    }
}

/// The configuration in the controller's scalar and units: immutable, shared by every step.
#[derive(Clone, Debug)]
pub struct Parameters<S, const SENSORS: usize> {
    /// Which architecture drives.
    pub architecture: Architecture,
    /// What the fast half needs.
    pub reflex: ReflexParameters<S>,
    /// SI units ↔ features.
    pub scaling: Scaling<S>,
    /// c*.
    pub speed_limit_mps: S,
    /// Sensor ring.
    pub proximity: ProximityParameters<S>,
    /// Online training.
    pub learning: LearningParameters<S>,
    /// Winner and motor control.
    pub reaching: ReachingParameters<S>,
    /// Fields and integration.
    pub neural: NeuralParameters<S>,
    /// Swept path.
    pub sweep: SweepParameters<S>,
    /// Obstacle memory.
    pub memory: MemoryParameters<S>,
    /// Movers.
    pub mover: MoverParameters<S>,
    /// Detour.
    pub detour: DetourParameters<S>,
    /// Openings.
    pub opening: OpeningParameters<S>,
    /// Z of Eq. 9.
    pub wiring: Wiring<S, SENSORS>,
    /// How Z is applied.
    pub avoidance: AvoidanceParameters<S>,
    /// β of Eq. 10.
    pub target_share: S,
    /// The resolution of wheel speeds; `None` for continuous ones.
    pub command_unit: Option<CommandUnit<S>>,
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::Config;
    use crate::scalar::{Fixed, Scalar};
    use std::string::ToString;

    #[test]
    fn the_default_is_valid_for_both_scalars() {
        Config::default().build::<f32, 12>().unwrap();
        Config::default().build::<Fixed, 12>().unwrap();
    }

    #[test]
    fn what_fixed_point_cannot_hold_is_refused() {
        let mut config = Config::default();
        config.robot.wheel_base_m = 0.5;
        config.build::<f32, 12>().unwrap();
        assert_eq!(config.build::<Fixed, 12>().unwrap_err().field(), "robot.encoder_counts_per_m");
        config.robot.encoder_counts_per_m = 3900.0;
        config.build::<Fixed, 12>().unwrap();
    }

    #[test]
    fn no_count_saturates_in_fixed_point() {
        for counts_per_m in [100.0, 12_000.0, 20_000.0] {
            let mut config = Config::default();
            config.robot.encoder_counts_per_m = counts_per_m;
            let odometry = config.build::<Fixed, 12>().unwrap().reflex.odometry;
            let five_cm = counts_per_m * 2.0 * 0.05;
            assert!((odometry.half_counts_per_5_cm.to_f32() - five_cm).abs() < 1e-3 * five_cm);
        }
    }

    #[test]
    fn an_error_names_field_value_and_range() {
        let mut config = Config::default();
        config.servo.stall_share = 1.5;
        let error = config.validate().unwrap_err();
        assert_eq!(error.to_string(), "servo.stall_share = 1.5: must be between 0 and 1");
        let mut config = Config::default();
        config.robot.wheel_base_m = f32::NAN;
        assert_eq!(config.validate().unwrap_err().field(), "robot.wheel_base_m");
        let mut config = Config::default();
        config.schedule.target_period_ms = 300;
        assert_eq!(config.validate().unwrap_err().field(), "schedule.target_period_ms");
        let mut config = Config::default();
        config.safety.scan_age_max_ms = 100;
        assert_eq!(config.validate().unwrap_err().field(), "safety.scan_age_max_ms");
    }
}
