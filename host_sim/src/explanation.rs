//! Why this command: what stood when a command was decided, and what decided.
//!
//! Every number is the core's own: [`decision_of`] asks the functions that integration itself works with, for every
//! neuron instead of only those that it needs to judge. So the winner and the command come out again, which a test
//! holds the two to; nothing here is a second controller.
//!
//! Places are of the robot frame at the moment of the decision: x ahead, y to the left, bearings left positive.

mod verdict;
mod witness;

use controller_core::config::Architecture;
use controller_core::controller::{Controller, MOVERS};
use controller_core::deliberation::{SWEEP_POINTS, speeds};
use controller_core::integration::neural::{Pressed, Stride};
use controller_core::integration::sweep::Obstacle;
use controller_core::integration::ways::Ways;
use controller_core::integration::{command_fusion, neural, sweep};
use controller_core::kohonen::features::{Command, Features};
use controller_core::kohonen::lattice::NeuronIndex;
use controller_core::localisation::mover::Mover;
use controller_core::localisation::obstacle;
use controller_core::localisation::separation::{Moving, OTHERS, Others};
use controller_core::localisation::target::TargetField;
use controller_core::reflex::Latched;
use controller_core::safety::StopCause;
use controller_core::scalar::Scalar;
use controller_core::schedule::Tick;
use controller_core::sensing::proximity::sensor_bearing;
use controller_core::units::{Point, Polar, Pose, WheelDrive, WheelSpeeds, wrap};
use serde::Serialize;

use crate::proximity_model::SENSORS;
use crate::sil::{COLUMNS, Indirect, ROWS, Sil};

use verdict::verdict;
pub use witness::{ExplainError, explain, explain_in_fleet};

/// The core that is explained.
type Core<S> = Controller<S, Indirect<S>, COLUMNS, ROWS, SENSORS>;

/// A place seen from the robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Place {
    /// Bearing in rad, left positive.
    pub bearing_rad: f32,
    /// Distance in m; negative for a place of the map behind the robot.
    pub distance_m: f32,
}

/// What one neuron has for it and against it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NeuronActivity {
    /// Column and row on the lattice.
    pub neuron: NeuronIndex,
    /// Its step is made backwards, away from what moves.
    pub backwards: bool,
    /// Its weight `w_i`: where its step leads to; mirrored if that is made backwards.
    pub place: Place,
    /// `a_i`: what the target field gives it.
    pub target: f32,
    /// `Σ_j b_ij`: what the fields of obstacles and other robots take.
    pub obstacles: f32,
    /// Of it, what the fields of other robots take.
    pub separation: f32,
    /// `e_i = a_i − Σ_j b_ij`, as it is ranked.
    pub activity: f32,
    /// What the way to its place takes.
    pub way: f32,
    /// What is left: the largest wins.
    pub total: f32,
}

/// What a sensor detects.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Detection {
    /// Which sensor, from 0 ahead, anticlockwise.
    pub sensor: usize,
    /// Where.
    pub place: Place,
    /// How much of the winner its field takes; none where no neuron has won.
    pub inhibits_winner: Option<f32>,
}

/// Something that the sensors see move.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SeenMover {
    /// Where its centre is, if it is as large as this robot.
    pub place: Place,
    /// How it moves, in m/s, robot frame.
    pub velocity_mps: Point<f32>,
    /// How fast it turns, in rad/s, anticlockwise positive.
    pub turn_radps: f32,
    /// How much it takes of the winner because of the way to its place; none where no neuron has won.
    pub inhibits_winner: Option<f32>,
}

/// Another robot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OtherRobot {
    /// Where it is by now, as far as is known.
    pub place: Place,
    /// How it moves, in m/s, robot frame.
    pub velocity_mps: Point<f32>,
    /// How much its report still counts, 1 to 0.
    pub weight: f32,
    /// How much of the winner its field takes; none where no neuron has won.
    pub inhibits_winner: Option<f32>,
}

/// The target field.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Field {
    /// The target's own winner s.
    pub winner: NeuronIndex,
    /// Its weight, the centre of the field.
    pub centre: Place,
    /// Where the map is aimed.
    pub aim: Place,
    /// Since when it stands, in ms.
    pub age_ms: Tick,
}

/// A wall that is followed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Wall {
    /// On which side it is kept.
    pub side: &'static str,
    /// Where it was when last seen.
    pub place: Place,
}

/// Command fusion: two commands and their sum, in m/s per wheel (left, right).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Fusion {
    /// β, the share of the target's command.
    pub target_share: f32,
    /// For the target.
    pub reaching: [f32; 2],
    /// Away from obstacles, where one is near.
    pub avoidance: Option<[f32; 2]>,
    /// β times the one and 1 − β times the other, within c*.
    pub sum: [f32; 2],
}

/// A command, and what it was decided from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DecisionReport {
    /// When, in ticks of 1 ms.
    pub tick: Tick,
    /// Where the robot took itself to be.
    pub pose: Pose<f32>,
    /// The checkpoint that it was on its way to, in the world.
    pub checkpoint: Option<Point<f32>>,
    /// The same, seen from the robot.
    pub target: Option<Place>,
    /// The target field, where there is one.
    pub field: Option<Field>,
    /// The wall that is followed, where one is.
    pub detour: Option<Wall>,
    /// What the sensors detect.
    pub detections: Vec<Detection>,
    /// Points that are remembered.
    pub remembered: Vec<Point<f32>>,
    /// What is seen to move.
    pub movers: Vec<SeenMover>,
    /// Other robots that are known of.
    pub others: Vec<OtherRobot>,
    /// Every neuron that may win; twice where its step may be made backwards too.
    pub neurons: Vec<NeuronActivity>,
    /// The winner k.
    pub winner: Option<NeuronActivity>,
    /// The best of the others.
    pub runner_up: Option<NeuronActivity>,
    /// The command is `M_s u_p`: fine control of the target itself.
    pub is_target: bool,
    /// Command fusion, where that is the architecture.
    pub fusion: Option<Fusion>,
    /// The command c in m/s, left and right.
    pub command: [f32; 2],
    /// In words, what decided.
    pub verdict: Vec<String>,
}

/// What is carried out at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Standing {
    /// The tick that was asked for.
    pub tick: Tick,
    /// The command that is carried out, in m/s, left and right.
    pub command: [f32; 2],
    /// Since when, in ms.
    pub command_age_ms: Tick,
    /// The motors may run.
    pub armed: bool,
    /// Why the safety gate stops the wheels, if it does.
    pub stopped: Option<StopCause>,
    /// The drive of the motors, left and right, within ±1.
    pub drive: [f32; 2],
}

/// An answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// What is carried out.
    pub standing: Standing,
    /// How it was decided.
    pub decision: DecisionReport,
}

impl Place {
    fn of<S: Scalar>(place: Polar<S>) -> Self {
        Self { bearing_rad: place.bearing_rad.to_f32(), distance_m: place.distance_m.to_f32() }
    }

    /// In Cartesian coordinates.
    #[must_use]
    pub fn to_point(self) -> Point<f32> {
        Polar { bearing_rad: self.bearing_rad, distance_m: self.distance_m }.to_point()
    }

    /// The same place with a distance that is not negative.
    #[must_use]
    pub fn unfolded(self) -> Self {
        if self.distance_m >= 0.0 {
            return self;
        }
        Self { bearing_rad: wrap(self.bearing_rad + core::f32::consts::PI), distance_m: -self.distance_m }
    }
}

fn metres<S: Scalar>(point: Point<S>) -> Point<f32> {
    Point { x_m: point.x_m.to_f32(), y_m: point.y_m.to_f32() }
}

fn wheels<S: Scalar>(speeds: WheelSpeeds<S>) -> [f32; 2] {
    [speeds.left_mps.to_f32(), speeds.right_mps.to_f32()]
}

fn drives(drive: WheelDrive<f32>) -> [f32; 2] {
    [drive.left, drive.right]
}

impl SeenMover {
    fn of<S: Scalar>(mover: &Mover<S>) -> Self {
        Self {
            place: Place::of(mover.at.to_polar()),
            velocity_mps: metres(mover.velocity_mps),
            turn_radps: mover.turn_radps.to_f32(),
            inhibits_winner: None,
        }
    }
}

/// A neuron with the core's own numbers, so that comparisons are the core's too.
struct Judged<S> {
    index: NeuronIndex,
    place: Features<S>,
    stride: Stride<S>,
    e: S,
    way: S,
}

impl<S: Scalar> Judged<S> {
    fn total(&self) -> S {
        self.e - self.way
    }
}

/// The best first. Equal activities go to the neuron that is ranked first, as in the core; sorting keeps the order of
/// equals.
fn rank<S: Scalar>(judged: &mut [Judged<S>]) {
    judged.sort_by(|a, b| by_size(b.e, a.e));
    judged.sort_by(|a, b| by_size(b.total(), a.total()));
}

/// What integration has to work with at a moment.
struct Moment<'a, S: Scalar> {
    core: &'a Core<S>,
    parameters: &'a controller_core::config::Parameters<S, SENSORS>,
    latched: Latched<S>,
    ways: Ways<S, SWEEP_POINTS, MOVERS>,
    others: heapless::Vec<Moving<S>, OTHERS>,
    separation: &'a Others<S, OTHERS>,
}

/// Explains the command that `sil` has decided at tick `now`; that tick has just been run, and something was released
/// in it.
#[must_use]
pub fn decision_of<S: Scalar>(sil: &Sil<S>, now: Tick) -> DecisionReport {
    let (core, p) = (&sil.controller, &sil.parameters);
    let latched = core.reflex.latch(&p.reflex, now);
    let ways = core.deliberation.ways(p, latched.pose);
    let others = sil.others.seen_from(latched.pose, now);
    let moment = Moment { core, parameters: p, latched, ways, others, separation: &sil.others };
    let mut report = moment.surroundings();
    if latched.target.is_some() {
        match p.architecture {
            Architecture::Cooperative => moment.integrate(&mut report),
            Architecture::Fusion => moment.fuse(&mut report),
        }
    }
    report.verdict = verdict(&moment, &report);
    report
}

impl<S: Scalar> Moment<'_, S> {
    /// Everything but the decision.
    fn surroundings(&self) -> DecisionReport {
        let (latched, deliberation) = (self.latched, &self.core.deliberation);
        let pose = latched.pose;
        DecisionReport {
            tick: latched.now,
            pose: Pose {
                x_m: pose.x_m.to_f32(),
                y_m: pose.y_m.to_f32(),
                heading_rad: pose.heading_rad.to_f32(),
            },
            checkpoint: latched.target.map(metres),
            target: latched.target.map(|at| Place::of(pose.see(at))),
            field: None,
            detour: deliberation
                .detour()
                .following()
                .map(|(side, place)| (side, latched.pose.see(place)))
                .map(|(side, place)| Wall {
                    side: if side > S::ZERO { "right" } else { "left" },
                    place: Place::of(place),
                }),
            detections: self
                .sensed()
                .map(|(sensor, place)| Detection { sensor, place: Place::of(place), inhibits_winner: None })
                .collect(),
            remembered: deliberation.memory().seen_from(&self.parameters.memory, pose).map(metres).collect(),
            movers: self.ways.movers().iter().map(SeenMover::of).collect(),
            others: self
                .others
                .iter()
                .map(|other| OtherRobot {
                    place: Place::of(other.at.to_polar()),
                    velocity_mps: metres(other.velocity_mps),
                    weight: other.weight.to_f32(),
                    inhibits_winner: None,
                })
                .collect(),
            neurons: Vec::new(),
            winner: None,
            runner_up: None,
            is_target: false,
            fusion: None,
            command: [0.0; 2],
            verdict: Vec::new(),
        }
    }

    /// Which sensor detects what.
    fn sensed(&self) -> impl Iterator<Item = (usize, Polar<S>)> {
        let (p, scan) = (self.parameters.proximity, *self.core.deliberation.scan());
        let seen = controller_core::sensing::proximity::detections(&p, &scan);
        let sensor_of = |place: &Polar<S>| {
            (0..SENSORS).find(|&sensor| sensor_bearing::<S>(sensor, SENSORS) == place.bearing_rad)
        };
        seen.into_iter().filter_map(move |place| Some((sensor_of(&place)?, place)))
    }

    /// What the field of an obstacle at a place takes of a neuron.
    fn field_inhibition(&self, sensed: Polar<S>, neuron: Features<S>) -> S {
        let (p, map) = (self.parameters, self.core.map());
        let (field, winner) = (&p.neural.obstacle, &p.reaching.winner);
        let spans = map.spans(winner.eligible);
        let centre = obstacle::centre(map, &spans, field, winner, p.scaling.features(sensed));
        obstacle::activity(field, centre, neuron.unfolded())
    }

    /// What the field of another robot takes of a neuron.
    fn separation(&self, other: &Moving<S>, neuron: Features<S>) -> S {
        self.separation.field(other).activity(self.separation.parameters(), neuron.unfolded())
    }

    /// What one obstacle point takes of a neuron because it is near the way to its place.
    fn point_inhibition(&self, point: Point<S>, neuron: Features<S>) -> S {
        let p = self.parameters;
        sweep::inhibition(&p.sweep, p.scaling.place(neuron), &mut [Obstacle::new(point)], &[], S::LIMIT)
    }

    /// What something that moves takes of a neuron because it will be near the way to its place.
    fn mover_inhibition(&self, mover: Mover<S>, neuron: Features<S>) -> S {
        let p = self.parameters;
        sweep::inhibition(&p.sweep, p.scaling.place(neuron), &mut [], &[mover], S::LIMIT)
    }

    /// What a way to a place loses because it ends too near to what is too near already.
    fn crowding(&self, neuron: Features<S>) -> S {
        self.ways.crowding(&self.parameters.sweep, self.parameters.scaling.place(neuron))
    }

    /// How a neuron's step is made.
    fn stride(&self, index: NeuronIndex) -> Stride<S> {
        neural::stride(self.core.map(), index, self.pressed() != Pressed::No)
    }

    /// Whether something moved nearby, as integration was told.
    fn pressed(&self) -> Pressed {
        self.core.deliberation.decision().pressed
    }

    fn judge(&self, field: &TargetField<S>) -> Vec<Judged<S>> {
        let (p, map) = (self.parameters, self.core.map());
        let mut ways = self.ways.clone();
        let mut judge = |index, place, stride: Stride<S>, inhibition| {
            let e = neural::activity(&p.neural.target, field, place, inhibition, self.ways.wishes());
            let way = ways.inhibition(&p.sweep, p.scaling.place(stride.place), S::LIMIT)
                + neural::reversal(self.pressed(), stride.place);
            Judged { index, place, stride, e, way }
        };
        let places = || map.places(p.reaching.winner.eligible);
        let mut judged: Vec<Judged<S>> = places()
            .map(|(index, place)| {
                judge(index, place, self.stride(index), self.core.obstacle_field().value.inhibition(index))
            })
            .collect();
        rank(&mut judged);
        if self.pressed() != Pressed::No && judged.first().is_some_and(|best| best.way > S::ZERO) {
            let backwards =
                |(index, place)| neural::backwards(place).map(|stride: Stride<S>| (index, stride));
            let backwards = places().filter_map(backwards);
            judged.extend(backwards.map(|(index, stride)| judge(index, stride.place, stride, S::ZERO)));
            rank(&mut judged);
        }
        judged
    }

    fn activity(&self, field: &TargetField<S>, judged: &Judged<S>) -> NeuronActivity {
        let p = self.parameters;
        let backwards = judged.stride.haste < S::ZERO;
        // No field has been asked at the end of a step that is made backwards.
        let fields = |inhibition: f32| if backwards { 0.0 } else { inhibition };
        NeuronActivity {
            neuron: judged.index,
            backwards,
            place: Place::of(p.scaling.place(judged.place)),
            target: field.activity(&p.neural.target, judged.place).to_f32(),
            obstacles: fields(self.core.obstacle_field().value.inhibition(judged.index).to_f32()),
            separation: fields(
                self.others.iter().map(|other| self.separation(other, judged.place).to_f32()).sum(),
            ),
            activity: judged.e.to_f32(),
            way: judged.way.to_f32(),
            total: judged.total().to_f32(),
        }
    }

    /// Neural integration once more, with every neuron judged.
    fn integrate(&self, report: &mut DecisionReport) {
        let standing = self.core.target_field();
        let (p, Some(field)) = (self.parameters, standing.value) else { return };
        let place = |features| Place::of(p.scaling.place(features));
        report.field = Some(Field {
            winner: field.winner,
            centre: place(field.centre),
            aim: place(field.aim),
            age_ms: standing.age_ms(self.latched.now),
        });
        let judged = self.judge(&field);
        report.neurons = judged.iter().map(|neuron| self.activity(&field, neuron)).collect();
        // In the order of the lattice.
        report.neurons.sort_by_key(|of| (of.backwards, of.neuron.column, of.neuron.row));
        let mut ranked = judged.iter();
        let Some(winner) = ranked.next() else { return };
        let (command, is_target) =
            neural::command(self.core.map(), &p.reaching, &field, (winner.index, winner.stride.haste));
        report.command = wheels(speeds(p, command));
        report.is_target = is_target;
        report.winner = Some(self.activity(&field, winner));
        report.runner_up = ranked.next().map(|neuron| self.activity(&field, neuron));
        let sensed: Vec<Polar<S>> = self.sensed().map(|(_, place)| place).collect();
        for (detection, place) in report.detections.iter_mut().zip(sensed) {
            detection.inhibits_winner = Some(self.field_inhibition(place, winner.place).to_f32());
        }
        for (told, mover) in report.movers.iter_mut().zip(self.ways.movers()) {
            told.inhibits_winner = Some(self.mover_inhibition(*mover, winner.stride.place).to_f32());
        }
        for (told, other) in report.others.iter_mut().zip(&self.others) {
            told.inhibits_winner = Some(self.separation(other, winner.place).to_f32());
        }
    }

    /// Command fusion once more.
    fn fuse(&self, report: &mut DecisionReport) {
        let p = self.parameters;
        let (reaching, avoidance) = self.core.deliberation.fused_commands();
        let fused: Command<S> =
            avoidance.map_or(reaching, |avoidance| command_fusion::fuse(p.target_share, reaching, avoidance));
        report.command = wheels(speeds(p, fused));
        report.fusion = Some(Fusion {
            target_share: p.target_share.to_f32(),
            reaching: wheels(p.scaling.speeds(reaching)),
            avoidance: avoidance.map(|avoidance| wheels(p.scaling.speeds(avoidance))),
            sum: report.command,
        });
    }
}

/// Numbers of the controller are never NaN.
fn by_size<S: Scalar>(a: S, b: S) -> core::cmp::Ordering {
    a.partial_cmp(&b).unwrap_or(core::cmp::Ordering::Equal)
}

#[cfg(test)]
mod tests;
