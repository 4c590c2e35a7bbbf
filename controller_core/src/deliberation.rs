//! The slow half of the controller: fields, integration and learning, on what [`crate::reflex`] has latched.
//!
//! One method per event: [`Deliberation::avoid`] (128 ms), [`Deliberation::reach`] (256 ms),
//! [`Deliberation::integrate`] (after either), [`Deliberation::learn`] (each training step). Each reads one moment and
//! returns within a bounded number of instructions; what it decides goes back through
//! [`crate::reflex::Reflex::take_command`].

use heapless::Vec;

use crate::config::{Architecture, Parameters};
use crate::controller::{MEMORY_POINTS, MOVERS};
use crate::integration::ways::Ways;
use crate::integration::{command_fusion, neural, neural::Decision, neural::Pressed};
use crate::kohonen::features::{Chart, Command};
use crate::kohonen::lattice::NeuronIndex;
use crate::kohonen::map::Map;
use crate::kohonen::output::{ControlMatrix, Output};
use crate::kohonen::self_organisation::{Displacement, Plasticity, displacement, place_reached, train};
use crate::list::first;
use crate::localisation::departure::Departure;
use crate::localisation::detour::Detour;
use crate::localisation::memory::ObstacleMemory;
use crate::localisation::mover::Movers;
use crate::localisation::obstacle::ObstacleField;
use crate::localisation::opening::Opening;
use crate::localisation::separation::Others;
use crate::localisation::target::{Approach, TargetField};
use crate::motor_control;
use crate::reflex::Latched;
use crate::scalar::Scalar;
use crate::schedule::{Stamped, Tick};
use crate::sensing::proximity::{Scan, detections};
use crate::units::{Point, Polar, Pose, WheelSpeeds};

/// Points that the swept path is checked against: those remembered, and one of each sensor of a ring of twelve.
pub const SWEEP_POINTS: usize = MEMORY_POINTS + 12;

/// A training step under way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TrainingStep<S> {
    start: Pose<S>,
    turn_counts: i32,
    command: Command<S>,
}

/// What the modules last said, standing until renewed.
#[derive(Clone, Debug)]
struct Standing<S: Scalar, const COLUMNS: usize, const ROWS: usize, const SENSORS: usize> {
    target: Stamped<Option<TargetField<S>>>,
    obstacles: Stamped<ObstacleField<S, COLUMNS, ROWS>>,
    /// Detected points of the last scan, robot frame.
    points: Vec<Point<S>, SENSORS>,
    /// P1: the command for the target, and away from obstacles.
    reaching: Command<S>,
    avoidance: Option<Command<S>>,
    decision: Decision<S>,
}

/// The state of the slow half: the map, the fields, what is remembered.
#[derive(Clone, Debug)]
pub struct Deliberation<
    S: Scalar,
    O = ControlMatrix<<S as Scalar>::Weight>,
    const COLUMNS: usize = 15,
    const ROWS: usize = 15,
    const SENSORS: usize = 12,
    const TRACKS: usize = MOVERS,
> {
    map: Map<S, O, COLUMNS, ROWS>,
    standing: Standing<S, COLUMNS, ROWS, SENSORS>,
    scan: Scan<S, SENSORS>,
    memory: ObstacleMemory<S, MEMORY_POINTS>,
    movers: Movers<S, SENSORS, TRACKS>,
    detour: Detour<S>,
    opening: Opening<S>,
    departure: Departure,
    arrivals: u16,
    goals: u16,
    trained_steps: u32,
    plasticity: Plasticity<S>,
    step: Option<TrainingStep<S>>,
}

impl<
    S: Scalar,
    O: Output<S>,
    const COLUMNS: usize,
    const ROWS: usize,
    const SENSORS: usize,
    const TRACKS: usize,
> Default for Deliberation<S, O, COLUMNS, ROWS, SENSORS, TRACKS>
{
    fn default() -> Self {
        Self::new(Map::regular(), 0)
    }
}

impl<
    S: Scalar,
    O: Output<S>,
    const COLUMNS: usize,
    const ROWS: usize,
    const SENSORS: usize,
    const TRACKS: usize,
> Deliberation<S, O, COLUMNS, ROWS, SENSORS, TRACKS>
{
    /// As [`Deliberation::default`], but without a map, which [`Map::reset`] makes: a constant, since on a board with
    /// little memory it has no room on the stack.
    pub const BLANK: Self = Self {
        map: Map::BLANK,
        standing: Standing {
            target: Stamped { value: None, renewed: 0 },
            obstacles: Stamped { value: ObstacleField::EMPTY, renewed: 0 },
            points: Vec::new(),
            reaching: Command { left: S::ZERO, right: S::ZERO },
            avoidance: None,
            decision: Decision {
                command: Command { left: S::ZERO, right: S::ZERO },
                winner: NeuronIndex { column: 0, row: 0 },
                activity: S::ZERO,
                is_target: false,
                judged: 0,
                pressed: Pressed::No,
            },
        },
        scan: Scan::EMPTY,
        memory: ObstacleMemory::EMPTY,
        movers: Movers::NONE,
        detour: Detour::NONE,
        opening: Opening::NONE,
        departure: Departure::NONE,
        arrivals: 0,
        goals: 0,
        trained_steps: 0,
        plasticity: Plasticity::NEW,
        step: None,
    };

    /// With a map that has been trained for `trained_steps` steps.
    #[inline]
    #[must_use]
    pub fn new(map: Map<S, O, COLUMNS, ROWS>, trained_steps: u32) -> Self {
        Self {
            map,
            standing: Standing {
                target: Stamped::default(),
                obstacles: Stamped::default(),
                points: Vec::new(),
                reaching: Command::default(),
                avoidance: None,
                decision: Decision::default(),
            },
            scan: Scan::EMPTY,
            memory: ObstacleMemory::default(),
            movers: Movers::NONE,
            detour: Detour::default(),
            opening: Opening::NONE,
            departure: Departure::NONE,
            arrivals: 0,
            goals: 0,
            trained_steps,
            plasticity: Plasticity::NEW,
            step: None,
        }
    }

    /// Everything but the map as at the start, in place: on a board with little memory a second state has no room.
    pub fn restart(&mut self) {
        self.standing.target = Stamped::default();
        self.standing.obstacles.value.clear();
        self.standing.obstacles.renewed = 0;
        self.standing.points.clear();
        self.standing.decision = Decision::default();
        self.scan = Scan::EMPTY;
        self.arrivals = 0;
        self.goals = 0;
        self.change_mode(0);
    }

    /// Forgets what stands: the robot changes its mode, and a training step under way is dropped.
    pub fn change_mode(&mut self, now: Tick) {
        self.step = None;
        self.standing.target = Stamped::new(None, now);
        self.standing.reaching = Command::default();
        self.standing.avoidance = None;
        self.memory.clear();
        self.movers.clear();
        self.detour.reset();
        self.opening.reset();
        self.departure = Departure::NONE;
    }

    /// Takes over a scan; it stands until the next.
    pub fn take_scan(&mut self, scan: Scan<S, SENSORS>) {
        self.scan = scan;
    }

    /// What has happened at checkpoints since the last event.
    fn heed_arrivals(&mut self, latched: &Latched<S>) {
        if latched.arrivals != self.arrivals {
            self.arrivals = latched.arrivals;
            self.detour.reset();
            self.opening.reset();
            self.departure.begin();
        }
        if latched.goals != self.goals {
            self.goals = latched.goals;
            self.standing.target = Stamped::new(None, latched.now);
            self.standing.reaching = Command::default();
        }
    }

    /// Obstacle avoidance: the latched scan renews the obstacle fields (P2), or the avoiding command (P1).
    pub fn avoid(&mut self, p: &Parameters<S, SENSORS>, latched: &Latched<S>) {
        self.avoid_among(p, latched, &Others::<S, 0>::NONE);
    }

    /// As [`Deliberation::avoid`], among other robots, whose fields are added (P2).
    #[inline]
    pub fn avoid_among<const COUNT: usize>(
        &mut self,
        p: &Parameters<S, SENSORS>,
        latched: &Latched<S>,
        others: &Others<S, COUNT>,
    ) {
        self.heed_arrivals(latched);
        if p.architecture == Architecture::Fusion {
            self.standing.avoidance = p.wiring.avoid(&p.avoidance, &self.scan);
            return;
        }
        self.movers.renew(&p.mover, &p.reflex.schedule, &p.proximity, &self.scan, latched.pose);
        let seen = detections(&p.proximity, &self.scan);
        self.remember(p, latched.pose, &seen);
        let field = &mut self.standing.obstacles;
        field.value.renew(&self.map, &p.neural.obstacle, &p.reaching.winner, &p.scaling, &seen);
        field.renewed = latched.now;
        if !others.is_empty() {
            self.keep_apart(p, latched, others);
        }
    }

    /// Adds the fields of other robots, which are followed no more.
    #[inline(never)]
    fn keep_apart<const COUNT: usize>(
        &mut self,
        p: &Parameters<S, SENSORS>,
        latched: &Latched<S>,
        others: &Others<S, COUNT>,
    ) {
        for other in others.seen_from(latched.pose, latched.now) {
            self.movers.leave_to_itself(p.proximity.body_radius_m, latched.pose, other.at);
            let field = others.field(&other);
            let inhibit = |place| field.activity(others.parameters(), place);
            self.standing.obstacles.value.add(&self.map, p.reaching.winner.eligible, inhibit);
        }
    }

    /// Keeps what is seen as points. Apart from [`Deliberation::avoid`], so that its stack is free again for the field.
    #[inline(never)]
    fn remember(&mut self, p: &Parameters<S, SENSORS>, pose: Pose<S>, seen: &[Polar<S>]) {
        self.standing.points = first(seen.iter().map(|place| place.to_point()));
        self.memory.age(p.reflex.schedule.avoidance_period_ms);
        let rotation = pose.heading_rad.sin_cos();
        for &point in &self.standing.points {
            self.memory.remember(&p.memory, pose.to_world_frame(point, rotation));
        }
    }

    /// Target reaching: the current checkpoint renews the target field (P2), or the command for it (P1).
    pub fn reach(&mut self, p: &Parameters<S, SENSORS>, latched: &Latched<S>) {
        self.reach_among(p, latched, &Others::<S, 0>::NONE);
    }

    /// As [`Deliberation::reach`], among other robots: what they hide is no wall to be followed, it will be gone before
    /// it is gone round.
    #[inline]
    pub fn reach_among<const COUNT: usize>(
        &mut self,
        p: &Parameters<S, SENSORS>,
        latched: &Latched<S>,
        others: &Others<S, COUNT>,
    ) {
        self.heed_arrivals(latched);
        let seen = latched.target.map(|at| latched.pose.see(at));
        match p.architecture {
            Architecture::Cooperative => {
                let field = seen.and_then(|target| {
                    let mut detections = detections(&p.proximity, &self.scan);
                    if TRACKS > 0 && !self.movers.seen_from(&p.mover, latched.pose).is_empty() {
                        self.detour.give_way();
                    }
                    self.movers.leave_out(&p.mover, p.proximity.body_radius_m, latched.pose, &mut detections);
                    if !others.is_empty() {
                        let all = detections.len();
                        others.leave_out(latched.pose, latched.now, &mut detections);
                        if detections.len() < all {
                            self.detour.give_way();
                        }
                    }
                    let period = p.reflex.schedule.target_period_ms;
                    let points = &self.standing.points;
                    let place =
                        self.detour.direct(&p.detour, latched.pose, target, &detections, points, period);
                    let way = self.opening.direct(
                        &p.opening,
                        place,
                        self.detour.side(),
                        latched.pose,
                        points,
                        period,
                    );
                    let departs = self.departure.turns(p.opening.turn_rad, way.place.bearing_rad, period);
                    let place = p.scaling.features(way.place);
                    let approach = Approach {
                        far: p.neural.target.far,
                        turn_first: way.turn_first || departs,
                        distance_steepness: if self.opening.is_passing() {
                            p.opening.distance_steepness
                        } else {
                            p.neural.target.distance_steepness
                        },
                    };
                    TargetField::localise(&self.map, approach, &p.reaching, place)
                });
                self.standing.target = Stamped::new(field, latched.now);
            }
            Architecture::Fusion => {
                let reached = seen.and_then(|target| {
                    motor_control::reach(&self.map, &p.reaching, p.scaling.features(target))
                });
                self.standing.reaching = reached.map_or_else(Command::default, |(_, command)| command);
                self.standing.target.renewed = latched.now;
            }
        }
    }

    /// Integration: what stands of the modules becomes one command. Without a checkpoint the robot stops.
    #[must_use]
    pub fn integrate(&mut self, p: &Parameters<S, SENSORS>, latched: &Latched<S>) -> WheelSpeeds<S> {
        self.heed_arrivals(latched);
        let command = if latched.target.is_none() {
            Command::default()
        } else {
            match p.architecture {
                Architecture::Cooperative => self.integrate_fields(p, latched.pose),
                Architecture::Fusion => match self.standing.avoidance {
                    Some(avoidance) => {
                        command_fusion::fuse(p.target_share, self.standing.reaching, avoidance)
                    }
                    None => self.standing.reaching,
                },
            }
        };
        speeds(p, command)
    }

    fn integrate_fields(&mut self, p: &Parameters<S, SENSORS>, pose: Pose<S>) -> Command<S> {
        let Some(target) = self.standing.target.value else { return Command::default() };
        let mut ways = self.ways(p, pose);
        let is_pressed = TRACKS > 0 && !ways.movers().is_empty();
        let pressed = if is_pressed { Pressed::after(self.standing.decision.command) } else { Pressed::No };
        let decision = neural::integrate::<_, _, _, _, TRACKS>(
            &self.map,
            &p.neural,
            &p.reaching,
            &p.scaling,
            &target,
            &self.standing.obstacles.value,
            pressed,
            ways.wishes(),
            |place, enough| ways.inhibition(&p.sweep, place, enough),
        );
        self.standing.decision = decision.unwrap_or_default();
        self.standing.decision.command
    }

    /// What integration holds the ways to candidate places against, for a robot at `pose`.
    #[inline]
    #[must_use]
    pub fn ways(&self, p: &Parameters<S, SENSORS>, pose: Pose<S>) -> Ways<S, SWEEP_POINTS, TRACKS> {
        let points = self.standing.points.iter().copied().chain(self.memory.seen_from(&p.memory, pose));
        let margin_m =
            self.opening.is_passing().then_some(p.opening.half_width_m - p.proximity.body_radius_m);
        let movers = self.movers.seen_from(&p.mover, pose);
        Ways::among(&p.sweep, margin_m, p.scaling.reach_m(), points, movers)
    }

    /// One training step ends, the next begins (P1 Eq. 6–8): the map learns from the way just made, then the
    /// current checkpoint and a random part give the next command.
    #[must_use]
    pub fn learn(
        &mut self,
        p: &Parameters<S, SENSORS>,
        latched: &Latched<S>,
        exploration: [S; 2],
    ) -> WheelSpeeds<S> {
        let here = latched.pose;
        if let Some(step) = self.step.take() {
            let counts = latched.turn_counts.wrapping_sub(step.turn_counts);
            let turned = S::from_i32(counts) / p.reflex.odometry.counts_per_radian;
            let reached = p.scaling.features(match p.learning.displacement {
                Displacement::HalfTurn => displacement(step.start, here, turned),
                Displacement::Place => place_reached(step.start, here),
            });
            // Half a turn and a signed chord are coordinates of the signed chart already.
            let reached = match p.learning.chart {
                Chart::Signed if p.learning.displacement == Displacement::HalfTurn => reached,
                chart => chart.coordinates(reached.unfolded()),
            };
            let winner = &p.reaching.winner;
            let age = self.plasticity.age(self.trained_steps);
            let lesson = train(&mut self.map, &p.learning, winner, age, reached, step.command);
            self.trained_steps = self.trained_steps.saturating_add(1);
            if let Some(surprise) = lesson.and_then(|lesson| lesson.surprise) {
                self.plasticity.heed(&p.learning, self.trained_steps, surprise);
            }
        } else if !self.map.is_trained() {
            self.map.spread(p.learning.chart);
        }
        let wished = latched
            .target
            .and_then(|at| motor_control::reach(&self.map, &p.reaching, p.scaling.features(here.see(at))))
            .map_or_else(Command::default, |(_, command)| command);
        let amplitude = p.learning.exploration.at(self.plasticity.age(self.trained_steps));
        let draw = |x: S| x.clamp(-S::ONE, S::ONE) * amplitude;
        let command =
            Command { left: wished.left + draw(exploration[0]), right: wished.right + draw(exploration[1]) }
                .saturated();
        let speeds = speeds(p, command);
        // The map learns what was carried out.
        let command = if p.command_unit.is_some() { p.scaling.command(speeds) } else { command };
        self.step = Some(TrainingStep { start: here, turn_counts: latched.turn_counts, command });
        speeds
    }

    /// The map.
    #[must_use]
    pub fn map(&self) -> &Map<S, O, COLUMNS, ROWS> {
        &self.map
    }

    /// The map, to be replaced neuron by neuron while the robot stands by; and the training steps it has seen.
    pub fn map_mut(&mut self) -> (&mut Map<S, O, COLUMNS, ROWS>, &mut u32) {
        self.plasticity = Plasticity::NEW;
        (&mut self.map, &mut self.trained_steps)
    }

    /// Training steps so far.
    #[must_use]
    pub fn trained_steps(&self) -> u32 {
        self.trained_steps
    }

    /// How surprised the map has been of late.
    #[must_use]
    pub fn plasticity(&self) -> &Plasticity<S> {
        &self.plasticity
    }

    /// Detected points of the last scan that obstacle avoidance has worked with, robot frame.
    #[must_use]
    pub fn points(&self) -> &[Point<S>] {
        &self.standing.points
    }

    /// The scan that stands.
    #[must_use]
    pub fn scan(&self) -> &Scan<S, SENSORS> {
        &self.scan
    }

    /// What is remembered of obstacles.
    #[must_use]
    pub fn memory(&self) -> &ObstacleMemory<S, MEMORY_POINTS> {
        &self.memory
    }

    /// The detour, if one is under way.
    #[must_use]
    pub fn detour(&self) -> &Detour<S> {
        &self.detour
    }

    /// P1: the command for the target, and the one away from obstacles where something is near.
    #[must_use]
    pub fn fused_commands(&self) -> (Command<S>, Option<Command<S>>) {
        (self.standing.reaching, self.standing.avoidance)
    }

    /// The last decision of neural integration.
    #[must_use]
    pub fn decision(&self) -> &Decision<S> {
        &self.standing.decision
    }

    /// The target field, with its age.
    #[must_use]
    pub fn target_field(&self) -> &Stamped<Option<TargetField<S>>> {
        &self.standing.target
    }

    /// The obstacle fields, with their age.
    #[must_use]
    pub fn obstacle_field(&self) -> &Stamped<ObstacleField<S, COLUMNS, ROWS>> {
        &self.standing.obstacles
    }
}

/// A command as wheel speeds that the motors take.
#[must_use]
pub fn speeds<S: Scalar, const SENSORS: usize>(
    p: &Parameters<S, SENSORS>,
    command: Command<S>,
) -> WheelSpeeds<S> {
    let speeds = p.scaling.speeds(command).saturated(p.speed_limit_mps);
    p.command_unit.map_or(speeds, |unit| unit.rounded(speeds))
}
