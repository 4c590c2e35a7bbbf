//! The board's end of the link: what a board does with each request, whatever the board is.
//!
//! Firmware and `hil_stub` run this same code. The controller's two halves lie in [`Fast`] and [`Slow`], which firmware
//! guards with the priorities of its tasks; a [`Session`] reaches them through [`Access`], and holds neither for longer
//! than it must.
//!
//! What a request needs is kept out of the others' stack frames (`inline(never)`): one of the boards has 8 KiB of RAM.
//!
//! | | lockstep | real time |
//! | --- | --- | --- |
//! | a tick is computed | by [`Session::serve`], on [`FromHost::Step`] | by tasks: [`Fast::tick`], [`Slow::avoid`] … |
//! | readings come with | the step | [`FromHost::Sense`], the latest counts |
//! | silence of the host | means nothing | stops the motors after [`LINK_SILENT_MS`] |

use controller_core::config::{Config, ConfigError, PARAMETER_COUNT, Parameters as CoreParameters};
use controller_core::controller::{self, Inputs, Mode};
use controller_core::deliberation::Deliberation;
use controller_core::kohonen::lattice::NeuronIndex;
use controller_core::kohonen::map::Map;
use controller_core::kohonen::output::ControlMatrix;
use controller_core::planning::checkpoint::CheckpointError;
use controller_core::reflex::{Latched, Reflex, ReflexParameters};
use controller_core::scalar::Scalar;
use controller_core::schedule::Tick;
use controller_core::sensing::proximity::Scan;
use controller_core::units::{Point, Polar, Pose, WheelSpeeds};
use heapless::{String, Vec};

use crate::convert::neuron_index;
use crate::frame::{self, FRAME_BYTES_MAX, Frame};
use crate::map_file::NeuronRecord;
use crate::message::{
    Board, CHECKPOINTS_PER_MESSAGE, COLUMNS, Checkpoints, Fields, FromBoard, FromHost, Health, Hello,
    MapRequest, MapSummary, NEURONS_PER_MESSAGE, Neurons, Outputs, PROTOCOL_VERSION, ParameterValue,
    Parameters, ROWS, Readings, Refusal, SENSORS, ScalarKind, Telemetry, TimeBase,
};
use crate::schema;

/// In real time the motors stop when nothing valid has come for so long.
pub const LINK_SILENT_MS: Tick = 100;

/// The controller's slow half as the boards run it.
pub type BoardDeliberation<S> =
    Deliberation<S, ControlMatrix<<S as Scalar>::Weight>, COLUMNS, ROWS, SENSORS, 0>;

/// The learned map as the boards hold it.
pub type BoardMap<S> = Map<S, ControlMatrix<<S as Scalar>::Weight>, COLUMNS, ROWS>;

/// The controller's fast half, with what it reads.
#[derive(Clone, Debug)]
pub struct Fast<S> {
    /// The state.
    pub reflex: Reflex<S>,
    /// Its numbers.
    pub parameters: ReflexParameters<S>,
    /// The next tick: milliseconds since [`FromHost::Begin`].
    pub tick: Tick,
    /// Real time: the tick at which something valid last came from the host.
    pub heard: Tick,
    /// Real time: what came last from the host; pose and scan until they are taken over.
    inputs: Inputs<S, SENSORS>,
    /// Real time: the board's tick that these readings answer.
    answers: Tick,
}

/// The controller's slow half, with what it reads.
#[derive(Clone, Debug)]
pub struct Slow<S: Scalar> {
    /// The state.
    pub deliberation: BoardDeliberation<S>,
    /// Its numbers.
    pub parameters: CoreParameters<S, SENSORS>,
}

/// Who is to work on a tick of the fast half, in real time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// The tick.
    pub now: Tick,
    /// Obstacle avoidance, or in its place learning.
    pub avoids: bool,
    /// Target reaching.
    pub reaches: bool,
}

/// What a tick of the fast half leaves to obstacle avoidance, in real time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job<S> {
    /// The moment to work on.
    pub latched: Latched<S>,
    /// A scan that has come since the last job.
    pub scan: Option<Scan<S, SENSORS>>,
    /// Draws for exploration.
    pub exploration: [S; 2],
    /// Learn instead of navigating.
    pub learns: bool,
}

impl<S: Scalar> Fast<S> {
    /// Disarmed, standing by, at tick 0.
    #[must_use]
    pub fn new(parameters: ReflexParameters<S>) -> Self {
        Self {
            reflex: Reflex::default(),
            parameters,
            tick: 0,
            heard: 0,
            inputs: Inputs::default(),
            answers: 0,
        }
    }

    /// One millisecond of real time: what goes out, and the work that is released, if any.
    pub fn tick(&mut self) -> (Outputs, Option<Work>) {
        let now = self.tick;
        let (p, reflex) = (&self.parameters, &mut self.reflex);
        let released = p.schedule.at(now);
        if let Some(pose) = self.inputs.pose_fix.take() {
            reflex.fix_pose(pose);
        }
        reflex.supervision.link_silent = now.saturating_sub(self.heard) >= LINK_SILENT_MS;
        let (drive, stopped) = reflex.tick(p, now, self.inputs.encoders);
        let reached = reflex.arrive(p, now);
        let learns = reflex.mode() == Mode::Learn && released.step;
        let navigates = reflex.mode() == Mode::Navigate && (released.avoidance || released.target);
        let work = Work {
            now,
            avoids: learns || (navigates && released.avoidance),
            reaches: navigates && released.target,
        };
        if work.avoids && self.inputs.scan.is_some() {
            reflex.note_scan(now);
        }
        let outputs = controller::Outputs { drive, command: reflex.command(), reached, stopped, released };
        self.tick += 1;
        let outputs = Outputs::from_core(now, &outputs, reflex.hash().value());
        (outputs, (learns || navigates).then_some(work))
    }

    /// What the tick just computed leaves to obstacle avoidance; the scan is handed over.
    pub fn job(&mut self, work: Work) -> Job<S> {
        Job {
            latched: self.latch(work),
            scan: self.inputs.scan.take(),
            exploration: self.inputs.exploration,
            learns: self.reflex.mode() == Mode::Learn,
        }
    }

    /// What the tick just computed leaves to target reaching.
    #[must_use]
    pub fn latch(&self, work: Work) -> Latched<S> {
        self.reflex.latch(&self.parameters, work.now)
    }

    /// Takes readings from the host, in real time. The latest counts; a pose or scan stays until it is taken over.
    ///
    /// Field by field, not as a whole that is converted first: on a small board that would be the deepest stack.
    #[inline(never)]
    pub fn sense(&mut self, readings: &Readings) {
        self.inputs.encoders = readings.encoders;
        if let Some(pose) = readings.pose_fix {
            self.inputs.pose_fix = Some(Pose {
                x_m: S::from_f32(pose.x_m),
                y_m: S::from_f32(pose.y_m),
                heading_rad: S::from_f32(pose.heading_rad),
            });
        }
        if let Some(scan) = &readings.scan {
            let kept = &mut self.inputs.scan.get_or_insert(Scan::EMPTY).range_m;
            for (kept, range_m) in kept.iter_mut().zip(&scan.ranges_m) {
                *kept = range_m.map(S::from_f32);
            }
        }
        if let Some(draws) = readings.exploration {
            self.inputs.exploration = draws.map(S::from_f32);
        }
        self.answers = readings.tick;
    }

    /// One tick of lockstep, both halves.
    fn step(&mut self, slow: &mut Slow<S>, readings: &Readings) -> Result<Outputs, Refusal> {
        let now = self.tick;
        if readings.tick != now {
            return Err(Refusal::Tick { expected: now, found: readings.tick });
        }
        // Here nothing stands from one tick to the next.
        self.inputs.pose_fix = None;
        self.inputs.scan = None;
        self.inputs.exploration = [S::ZERO; 2];
        self.sense(readings);
        let Slow { deliberation, parameters } = slow;
        let outputs = controller::tick(&mut self.reflex, deliberation, parameters, now, &self.inputs);
        self.tick += 1;
        Ok(Outputs::from_core(now, &outputs, self.reflex.hash().value()))
    }

    /// Age of the readings that the next tick will work with.
    #[must_use]
    pub fn readings_age_ms(&self) -> Tick {
        self.tick.saturating_sub(self.answers)
    }

    /// Takes over what a job released at `now` has decided; not if the controller has begun anew since.
    pub fn take_command(&mut self, now: Tick, speeds: WheelSpeeds<S>, is_trained: bool) {
        if now < self.tick {
            self.reflex.supervision.untrained = !is_trained;
            self.reflex.take_command(now, speeds);
        }
    }

    /// As after a start, but for an emergency stop: only a disarm ends that.
    fn begin(&mut self) {
        let is_emergency = self.reflex.gate.is_emergency();
        self.reflex = Reflex::default();
        if is_emergency {
            self.reflex.gate.emergency_stop();
        }
        self.tick = 0;
        self.heard = 0;
        self.inputs = Inputs::default();
        self.answers = 0;
    }
}

impl<S: Scalar> Slow<S> {
    /// With an untrained map.
    #[inline]
    #[must_use]
    pub fn new(parameters: CoreParameters<S, SENSORS>) -> Self {
        Self { deliberation: Deliberation::default(), parameters }
    }

    /// The job of the task of obstacle avoidance: renew the obstacle fields and integrate, or learn.
    #[must_use]
    pub fn avoid(&mut self, job: &Job<S>) -> WheelSpeeds<S> {
        let p = &self.parameters;
        if let Some(scan) = job.scan {
            self.deliberation.take_scan(scan);
        }
        if job.learns {
            return self.deliberation.learn(p, &job.latched, job.exploration);
        }
        self.deliberation.avoid(p, &job.latched);
        self.deliberation.integrate(p, &job.latched)
    }

    /// The map says something.
    #[must_use]
    pub fn is_trained(&self) -> bool {
        self.deliberation.map().is_trained()
    }

    /// The job of the task of target reaching: renew the target field and integrate.
    #[must_use]
    pub fn reach(&mut self, latched: &Latched<S>) -> WheelSpeeds<S> {
        self.deliberation.reach(&self.parameters, latched);
        self.deliberation.integrate(&self.parameters, latched)
    }

    fn summary(&self) -> MapSummary {
        let map = self.deliberation.map();
        let small = |count: usize| u8::try_from(count).unwrap_or(u8::MAX);
        MapSummary {
            hash: map.hash(),
            trained_steps: self.deliberation.trained_steps(),
            columns: small(COLUMNS),
            rows: small(ROWS),
            trained_neurons: u16::try_from(map.trained_count()).unwrap_or(u16::MAX),
        }
    }

    fn neurons(&self, first: u16) -> Neurons {
        let map = self.deliberation.map();
        let numbers = usize::from(first)..;
        let indices = numbers.map_while(neuron_index::<COLUMNS, ROWS>).take(NEURONS_PER_MESSAGE);
        let mut neurons = Vec::new();
        for index in indices {
            // There is room: so many were taken.
            let _ = neurons.push(NeuronRecord::of(map, index));
        }
        Neurons { first, neurons }
    }

    /// `false`, and nothing changed, where the lattice has no such neurons.
    fn write(&mut self, neurons: &Neurons) -> bool {
        let (first, count) = (usize::from(neurons.first), neurons.neurons.len());
        if first + count > COLUMNS * ROWS {
            return false;
        }
        let (map, _) = self.deliberation.map_mut();
        let indices = (first..).map_while(neuron_index::<COLUMNS, ROWS>);
        for (index, record) in indices.zip(&neurons.neurons) {
            record.put(map, index);
        }
        true
    }

    #[inline(never)]
    fn fields(&self, column: u8) -> Fields {
        let row = |row: usize| NeuronIndex::new(usize::from(column), row);
        let (map, p) = (self.deliberation.map(), &self.parameters.neural.target);
        let target = self.deliberation.target_field().value;
        let obstacles = &self.deliberation.obstacle_field().value;
        Fields {
            column,
            target: core::array::from_fn(|i| {
                target.map_or(0.0, |field| field.activity(p, map.place(row(i))).to_f32())
            }),
            obstacles: core::array::from_fn(|i| {
                if map.has_won(row(i)) { obstacles.inhibition(row(i)).to_f32() } else { 0.0 }
            }),
        }
    }
}

/// How a session reaches the controller. Firmware locks, a process borrows.
pub trait Access<S: Scalar> {
    /// The fast half alone; keep it short, for the servo waits.
    fn fast<R>(&mut self, f: impl FnOnce(&mut Fast<S>) -> R) -> R;

    /// The slow half alone.
    fn slow<R>(&mut self, f: impl FnOnce(&mut Slow<S>) -> R) -> R;

    /// Both, for what must change at one tick boundary.
    fn both<R>(&mut self, f: impl FnOnce(&mut Fast<S>, &mut Slow<S>) -> R) -> R;

    /// How link and tasks are doing.
    fn health(&mut self) -> Health;
}

/// What a board says of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// The board.
    pub board: Board,
    /// The build, for people to read; what exceeds [`crate::message::BUILD_ID_BYTES`] is cut.
    pub build_id: &'static str,
}

/// A frame that was sent, kept to be sent again.
#[derive(Clone, Debug)]
struct Sent {
    frame: [u8; FRAME_BYTES_MAX],
    length: usize,
    sequence: u8,
}

/// The board's end of a session: answers requests, once each.
#[derive(Clone, Debug)]
pub struct Session {
    identity: Identity,
    epoch: u32,
    time_base: TimeBase,
    /// A hello has come that fits.
    is_open: bool,
    /// Parameters with the changes staged since the last commit.
    staged: Config,
    /// Hash of the parameters in use.
    parameters_hash: u64,
    sent: Sent,
}

impl Session {
    /// A board that has been started; `epoch` differs from that of its last start. Parameters are
    /// [`Config::default`], and so must be those in [`Fast`] and [`Slow`].
    #[must_use]
    pub fn new(identity: Identity, epoch: u32) -> Self {
        let staged = Config::default();
        Self {
            identity,
            epoch,
            time_base: TimeBase::Lockstep,
            is_open: false,
            parameters_hash: staged.hash(),
            staged,
            sent: Sent { frame: [0; FRAME_BYTES_MAX], length: 0, sequence: 0 },
        }
    }

    /// Who advances the tick at present.
    #[must_use]
    pub fn time_base(&self) -> TimeBase {
        self.time_base
    }

    /// The frame with which a board that has started introduces itself, under sequence number 0.
    pub fn announce<S: Scalar>(&mut self, access: &mut impl Access<S>) -> &[u8] {
        let hello = self.hello(access);
        self.sent.put(0, &FromBoard::Hello(hello))
    }

    /// Carries a request out and gives the frame to send back.
    ///
    /// A sequence number that comes twice in a row is the same request again, because the answer was lost: it gets the
    /// same answer and is not carried out twice. Always carried out are a hello, since with it begins a host that knows
    /// nothing of what was before; what stops the wheels, whoever sends it and however it counts; and whatever comes
    /// under 0, the number of what the board says unasked. What is not answered gives an empty slice.
    pub fn serve<S: Scalar>(&mut self, access: &mut impl Access<S>, frame: &Frame<FromHost>) -> &[u8] {
        self.serve_message(access, frame.sequence, &frame.message)
    }

    /// As [`Session::serve`], for who has the parts of the frame.
    pub fn serve_message<S: Scalar>(
        &mut self,
        access: &mut impl Access<S>,
        sequence: u8,
        message: &FromHost,
    ) -> &[u8] {
        let is_always_done =
            matches!(message, FromHost::Hello(_) | FromHost::Sense(_) | FromHost::EStop | FromHost::Disarm);
        if sequence == self.sent.sequence && sequence != 0 && !is_always_done {
            return self.sent.bytes();
        }
        match message {
            FromHost::Step(readings) if self.is_open => {
                let outcome = self.step(access, readings);
                self.sent.put_outcome(sequence, outcome);
            }
            request => {
                if !self.reply(access, sequence, request) {
                    return &[];
                }
            }
        }
        self.sent.bytes()
    }

    /// Answers; `false` where there is no answer.
    #[inline(never)]
    fn reply<S: Scalar>(&mut self, access: &mut impl Access<S>, sequence: u8, request: &FromHost) -> bool {
        let reply = self.answer(access, request);
        if let Some(reply) = &reply {
            self.sent.put(sequence, reply);
        }
        reply.is_some()
    }

    fn answer<S: Scalar>(&mut self, access: &mut impl Access<S>, request: &FromHost) -> Option<FromBoard> {
        if !self.is_open && !matches!(request, FromHost::Hello(_) | FromHost::EStop | FromHost::Disarm) {
            // Nobody waits for an answer to readings.
            let is_answered = !matches!(request, FromHost::Sense(_));
            return is_answered.then_some(FromBoard::Refused(Refusal::Mismatch));
        }
        Some(match request {
            FromHost::Hello(theirs) => FromBoard::Hello(self.welcome(access, theirs)),
            FromHost::Step(readings) => {
                self.step(access, readings).map_or_else(FromBoard::Refused, FromBoard::Outputs)
            }
            FromHost::Sense(readings) => {
                access.fast(|fast| fast.sense(readings));
                return None;
            }
            FromHost::Checkpoints(change) => done(access.fast(|fast| change_checkpoints(fast, change))),
            FromHost::Arm => done(access.fast(|fast| {
                fast.reflex.gate.arm();
                if fast.reflex.gate.is_emergency() { Err(Refusal::EmergencyStop) } else { Ok(()) }
            })),
            FromHost::Disarm => {
                access.fast(|fast| {
                    fast.reflex.gate.release();
                    fast.reflex.gate.disarm();
                });
                FromBoard::Done
            }
            FromHost::EStop => {
                access.fast(|fast| fast.reflex.gate.emergency_stop());
                FromBoard::Done
            }
            FromHost::Begin => {
                access.both(|fast, slow| {
                    fast.begin();
                    slow.deliberation.restart();
                    fast.reflex.supervision.untrained = !slow.deliberation.map().is_trained();
                });
                FromBoard::Done
            }
            FromHost::Mode(mode) => {
                access.both(|fast, slow| {
                    fast.reflex.set_mode(*mode, fast.tick);
                    fast.reflex.supervision.untrained = !slow.deliberation.map().is_trained();
                    slow.deliberation.change_mode(fast.tick);
                });
                FromBoard::Done
            }
            FromHost::Parameters(request) => self.parameters(access, *request),
            FromHost::Map(request) => map(access, request),
            FromHost::Health => FromBoard::Health(access.health()),
            FromHost::Telemetry => FromBoard::Telemetry(telemetry(access)),
            FromHost::Fields { column } if usize::from(*column) >= COLUMNS => no_such_neurons(),
            FromHost::Fields { column } => FromBoard::Fields(access.slow(|slow| slow.fields(*column))),
        })
    }

    fn hello<S: Scalar>(&self, access: &mut impl Access<S>) -> Hello {
        let mut build_id = String::new();
        // What does not fit is cut: it is for people to read.
        self.identity.build_id.chars().all(|c| build_id.push(c).is_ok());
        let map_hash = access.slow(|slow| {
            let map = slow.deliberation.map();
            map.is_trained().then(|| map.hash())
        });
        Hello {
            protocol_version: PROTOCOL_VERSION,
            schema_hash: schema::HASH,
            build_id,
            board: Some(self.identity.board),
            scalar: ScalarKind::of::<S>(),
            map_hash,
            parameters_hash: Some(self.parameters_hash),
            time_base: self.time_base,
            epoch: self.epoch,
        }
    }

    /// The host says what it expects; it is answered with what is, and so can name what does not fit.
    #[inline(never)]
    fn welcome<S: Scalar>(&mut self, access: &mut impl Access<S>, theirs: &Hello) -> Hello {
        let ours = Hello { time_base: theirs.time_base, ..self.hello(access) };
        self.is_open = ours.check_against(theirs).is_ok();
        if !self.is_open {
            return self.hello(access);
        }
        if self.time_base != theirs.time_base {
            self.time_base = theirs.time_base;
            // Nothing may go on moving across the change.
            access.both(|fast, slow| {
                fast.begin();
                slow.deliberation.restart();
                fast.reflex.supervision.untrained = !slow.deliberation.map().is_trained();
            });
        }
        ours
    }

    #[inline(never)]
    fn step<S: Scalar>(&self, access: &mut impl Access<S>, readings: &Readings) -> Result<Outputs, Refusal> {
        if self.time_base != TimeBase::Lockstep {
            return Err(Refusal::TimeBase { present: self.time_base });
        }
        access.both(|fast, slow| fast.step(slow, readings))
    }

    #[inline(never)]
    fn parameters<S: Scalar>(&mut self, access: &mut impl Access<S>, request: Parameters) -> FromBoard {
        let count = u8::try_from(PARAMETER_COUNT).unwrap_or(u8::MAX);
        match request {
            Parameters::Get { index } => match self.staged.get(usize::from(index)) {
                Some(value) => FromBoard::Parameter(ParameterValue { index, value }),
                None => FromBoard::Refused(Refusal::NoSuchParameter { count }),
            },
            Parameters::Set(ParameterValue { index, .. }) if index >= count => {
                FromBoard::Refused(Refusal::NoSuchParameter { count })
            }
            Parameters::Set(ParameterValue { index, value }) => {
                let set = self.staged.set(usize::from(index), value);
                done(set.map_err(|_| Refusal::BadParameter { index }))
            }
            Parameters::Commit => self.commit(access),
            Parameters::Defaults => {
                self.staged = Config::default();
                FromBoard::Done
            }
        }
    }

    /// Builds in place, between two jobs; the fast half takes its share over between two ticks.
    #[inline(never)]
    fn commit<S: Scalar>(&mut self, access: &mut impl Access<S>) -> FromBoard {
        let staged = &self.staged;
        let built = staged.check_without_movers().and_then(|()| {
            access
                .slow(|slow| staged.build_over(&mut slow.parameters).map(|()| slow.parameters.reflex.clone()))
        });
        match built {
            Ok(reflex) => {
                self.parameters_hash = self.staged.hash();
                access.fast(|fast| fast.parameters = reflex);
                FromBoard::Done
            }
            Err(error) => {
                let index = error.index().unwrap_or_default();
                FromBoard::Refused(Refusal::BadParameter { index: u8::try_from(index).unwrap_or(u8::MAX) })
            }
        }
    }
}

impl Sent {
    fn bytes(&self) -> &[u8] {
        self.frame.get(..self.length).unwrap_or_default()
    }

    /// As [`Sent::put`]. The reply is made here and not where the step is computed, on the deepest stack.
    #[inline(never)]
    fn put_outcome(&mut self, sequence: u8, outcome: Result<Outputs, Refusal>) {
        self.put(sequence, &outcome.map_or_else(FromBoard::Refused, FromBoard::Outputs));
    }

    #[inline(never)]
    fn put(&mut self, sequence: u8, reply: &FromBoard) -> &[u8] {
        self.sequence = sequence;
        let refused = FromBoard::Refused(Refusal::NotFinite);
        self.length = match frame::encode(sequence, reply, &mut self.frame) {
            Ok(bytes) => bytes.len(),
            // The buffer has room for every message: only a number can be the cause.
            Err(_) => frame::encode(sequence, &refused, &mut self.frame).map_or(0, <[u8]>::len),
        };
        self.bytes()
    }
}

fn done(result: Result<(), Refusal>) -> FromBoard {
    result.map_or_else(FromBoard::Refused, |()| FromBoard::Done)
}

fn no_such_neurons() -> FromBoard {
    FromBoard::Refused(Refusal::NoSuchNeurons { count: u16::try_from(COLUMNS * ROWS).unwrap_or(u16::MAX) })
}

#[inline(never)]
fn change_checkpoints<S: Scalar>(fast: &mut Fast<S>, change: &Checkpoints) -> Result<(), Refusal> {
    let place = |point: &Point<f32>| Point::<S>::from_metres(point.x_m, point.y_m);
    let places = |points: &[Point<f32>]| {
        let mut places: Vec<Point<S>, CHECKPOINTS_PER_MESSAGE> = Vec::new();
        for point in points {
            // A message has no more than there is room for.
            let _ = places.push(place(point));
        }
        places
    };
    let ahead = &mut fast.reflex.checkpoints;
    let changed: Result<(), CheckpointError> = match change {
        Checkpoints::ReplaceAll(points) => ahead.replace_all(&places(points)),
        Checkpoints::Append(points) => ahead.append(&places(points)),
        Checkpoints::ReplaceOne { index, point } => ahead.replace(usize::from(*index), place(point)),
        Checkpoints::Clear => {
            ahead.clear();
            Ok(())
        }
    };
    changed.map_err(Refusal::Checkpoints)
}

#[inline(never)]
fn map<S: Scalar>(access: &mut impl Access<S>, request: &MapRequest) -> FromBoard {
    let changes = matches!(request, MapRequest::Write(_) | MapRequest::Confirm { .. } | MapRequest::Forget);
    if changes && access.fast(|fast| fast.reflex.mode()) != Mode::Standby {
        return FromBoard::Refused(Refusal::NotStandingBy);
    }
    match request {
        MapRequest::Describe => FromBoard::Map(access.slow(|slow| slow.summary())),
        MapRequest::Read { first } if usize::from(*first) >= COLUMNS * ROWS => no_such_neurons(),
        MapRequest::Read { first } => FromBoard::Neurons(access.slow(|slow| slow.neurons(*first))),
        MapRequest::Write(neurons) => {
            if access.slow(|slow| slow.write(neurons)) {
                FromBoard::Done
            } else {
                no_such_neurons()
            }
        }
        MapRequest::Confirm { trained_steps, hash } => access.slow(|slow| {
            let (map, steps) = slow.deliberation.map_mut();
            let found = map.hash();
            if found != *hash {
                return FromBoard::Refused(Refusal::MapHash { found });
            }
            *steps = *trained_steps;
            FromBoard::Done
        }),
        MapRequest::Forget => access.slow(|slow| {
            let (map, steps) = slow.deliberation.map_mut();
            map.reset();
            *steps = 0;
            FromBoard::Done
        }),
    }
}

#[inline(never)]
fn telemetry<S: Scalar>(access: &mut impl Access<S>) -> Telemetry {
    let (tick, mode, pose, ahead) = access.fast(|fast| {
        let pose = fast.reflex.pose(&fast.parameters);
        (fast.tick, fast.reflex.mode(), pose, fast.reflex.checkpoints.remaining())
    });
    access.slow(|slow| {
        let deliberation = &slow.deliberation;
        let (target, decision) = (deliberation.target_field(), deliberation.decision());
        let rows = u16::try_from(ROWS).unwrap_or(u16::MAX);
        let age = |age: Tick| u32::try_from(age).unwrap_or(u32::MAX);
        let place = |field: controller_core::localisation::target::TargetField<S>| {
            let place = slow.parameters.scaling.place(field.target);
            Polar { bearing_rad: place.bearing_rad.to_f32(), distance_m: place.distance_m.to_f32() }
        };
        Telemetry {
            tick,
            mode,
            pose: Pose {
                x_m: pose.x_m.to_f32(),
                y_m: pose.y_m.to_f32(),
                heading_rad: pose.heading_rad.to_f32(),
            },
            checkpoints_ahead: u8::try_from(ahead).unwrap_or(u8::MAX),
            trained_steps: deliberation.trained_steps(),
            target: target.value.map(place),
            target_age_ms: age(target.age_ms(tick)),
            obstacles_age_ms: age(deliberation.obstacle_field().age_ms(tick)),
            winner: u16::from(decision.winner.column) * rows + u16::from(decision.winner.row),
            activity: decision.activity.to_f32(),
            judged: decision.judged,
            is_target: decision.is_target,
            detections: u8::try_from(deliberation.points().len()).unwrap_or(u8::MAX),
        }
    })
}

/// A board in one thread: for `hil_stub` and for tests.
#[derive(Clone, Debug)]
pub struct LocalBoard<S: Scalar> {
    session: Session,
    parts: Parts<S>,
}

#[derive(Clone, Debug)]
struct Parts<S: Scalar> {
    fast: Fast<S>,
    slow: Slow<S>,
    health: Health,
}

impl<S: Scalar> Access<S> for Parts<S> {
    fn fast<R>(&mut self, f: impl FnOnce(&mut Fast<S>) -> R) -> R {
        f(&mut self.fast)
    }

    fn slow<R>(&mut self, f: impl FnOnce(&mut Slow<S>) -> R) -> R {
        f(&mut self.slow)
    }

    fn both<R>(&mut self, f: impl FnOnce(&mut Fast<S>, &mut Slow<S>) -> R) -> R {
        f(&mut self.fast, &mut self.slow)
    }

    fn health(&mut self) -> Health {
        Health { tick: self.fast.tick, ..self.health }
    }
}

impl<S: Scalar> LocalBoard<S> {
    /// A board that has just been started.
    ///
    /// # Errors
    /// If the scalar cannot hold [`Config::default`], which both of the core can.
    pub fn new(identity: Identity, epoch: u32) -> Result<Self, ConfigError> {
        let parameters = Config::default().build::<S, SENSORS>()?;
        let fast = Fast::new(parameters.reflex.clone());
        let parts = Parts { fast, slow: Slow::new(parameters), health: Health::default() };
        Ok(Self { session: Session::new(identity, epoch), parts })
    }

    /// As [`Session::announce`].
    pub fn announce(&mut self) -> &[u8] {
        self.session.announce(&mut self.parts)
    }

    /// As [`Session::serve`].
    pub fn serve(&mut self, frame: &Frame<FromHost>) -> &[u8] {
        self.parts.health.frames_good = self.parts.health.frames_good.wrapping_add(1);
        self.parts.fast.heard = self.parts.fast.tick;
        self.session.serve(&mut self.parts, frame)
    }

    /// Counts a frame that came damaged.
    pub fn count_bad_frame(&mut self) {
        self.parts.health.frames_bad = self.parts.health.frames_bad.wrapping_add(1);
    }

    /// Who advances the tick at present.
    #[must_use]
    pub fn time_base(&self) -> TimeBase {
        self.session.time_base()
    }

    /// One millisecond of real time, all tasks in the order of their priority; nothing in lockstep.
    pub fn tick(&mut self) -> Option<Outputs> {
        if self.session.time_base() != TimeBase::RealTime {
            return None;
        }
        let Parts { fast, slow, health } = &mut self.parts;
        health.readings_age_ms_max =
            health.readings_age_ms_max.max(u32::try_from(fast.readings_age_ms()).unwrap_or(u32::MAX));
        health.releases.servo = health.releases.servo.wrapping_add(1);
        let (outputs, work) = fast.tick();
        if let Some(work) = work {
            let job = work.avoids.then(|| fast.job(work));
            let latched = work.reaches.then(|| fast.latch(work));
            if let Some(job) = job {
                health.releases.avoidance = health.releases.avoidance.wrapping_add(1);
                let speeds = slow.avoid(&job);
                fast.take_command(work.now, speeds, slow.is_trained());
            }
            if let Some(latched) = latched {
                health.releases.target = health.releases.target.wrapping_add(1);
                let speeds = slow.reach(&latched);
                fast.take_command(work.now, speeds, slow.is_trained());
            }
        }
        Some(outputs)
    }
}
