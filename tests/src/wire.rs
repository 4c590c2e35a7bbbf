//! What must hold whatever bytes come over the link; shared by the fuzz targets and the test that replays their seeds.
//!
//! Nothing in here uses other crates than the core and `protocol`: the fuzz targets compile this file by itself.

use controller_core::scalar::{Fixed, Scalar};
use controller_core::units::WheelDrive;
use core::fmt::Debug;
use protocol::codec::{Message, from_bytes};
use protocol::endpoint::{Identity, LINK_SILENT_MS, LocalBoard};
use protocol::frame::{DELIMITER, Decoder, FRAME_BYTES_MAX, Frame, FrameError, encode};
use protocol::message::{
    Board, FromBoard, FromHost, Hello, Outputs, PROTOCOL_VERSION, Readings, Refusal, TimeBase,
};
use protocol::schema;
use std::sync::LazyLock;

/// Any bytes into the decoders of both directions.
///
/// # Panics
/// If a decoder takes for a frame what the encoder does not write, reports other than once for what stands between two
/// delimiters, or does not find the next frame.
pub fn any_bytes(bytes: &[u8]) {
    decode(bytes, &FromHost::Arm);
    decode(bytes, &FromBoard::Done);
}

fn decode<M: Message + Clone + Debug + PartialEq>(bytes: &[u8], next: &M) {
    let mut decoder = Decoder::<M>::new();
    let mut buffer = [0; FRAME_BYTES_MAX];
    let (mut good, mut bad) = (0, 0);
    for piece in bytes.split_inclusive(|&byte| byte == DELIMITER) {
        let mut result = None;
        for &byte in piece {
            assert!(result.is_none(), "a frame before its delimiter");
            result = decoder.push(byte);
        }
        let is_ended = piece.last() == Some(&DELIMITER);
        match result {
            Some(Ok(frame)) => {
                let again = encode(frame.sequence, &frame.message, &mut buffer);
                assert_eq!(again, Ok(piece), "accepted, but not what {frame:?} is written as");
                good += 1;
            }
            Some(Err(error)) => {
                assert!(!error.to_string().is_empty());
                bad += 1;
            }
            None => assert!(!is_ended || piece.len() == 1, "nothing said about {piece:?}"),
        }
    }
    assert_eq!((decoder.counts().good, decoder.counts().bad), (good, bad));
    let _ = decoder.push(DELIMITER);
    let bytes = encode(9, next, &mut buffer).expect("a buffer for every frame");
    let found = bytes.iter().find_map(|&byte| decoder.push(byte));
    assert_eq!(found, Some(Ok(Frame { sequence: 9, message: next.clone() })), "not in step again");
}

/// Any bodies in valid frames: to the decoder of the host, and as a conversation with a board of each scalar.
///
/// The first byte opens the conversation: bit 0 real time instead of lockstep, bit 1 no hello. Then come requests, each
/// of a control byte, a length, and as many bytes of body. Control: bit 7 the sequence number of the request before,
/// bit 6 the tick of readings as it stands instead of the right one, the low 4 bits how many ticks of real time pass
/// behind the request. What exceeds `REQUESTS_MAX` and `TICKS_MAX` is left out: more sessions find more than
/// longer ones.
///
/// # Panics
/// If what is accepted is not written in the same bytes, a request is not answered as it must be, or a board drives its
/// motors when it must not.
pub fn any_bodies(bytes: &[u8]) {
    let Some((&opening, rest)) = bytes.split_first() else { return };
    for request in requests(rest) {
        let (frame, result) = sealed::<FromBoard>(1, request.body);
        if let Some(Ok(accepted)) = result {
            let mut buffer = [0; FRAME_BYTES_MAX];
            assert_eq!(encode(1, &accepted.message, &mut buffer), Ok(&frame[..]), "{accepted:?}");
        }
    }
    // Made once: to start a board takes longer than to talk to it.
    static BOARDS: LazyLock<(LocalBoard<f32>, LocalBoard<Fixed>)> = LazyLock::new(|| (started(), started()));
    converse(BOARDS.0.clone(), opening, rest);
    converse(BOARDS.1.clone(), opening, rest);
}

/// Requests of a conversation.
const REQUESTS_MAX: usize = 64;
/// Ticks of real time in a conversation.
const TICKS_MAX: u32 = 400;

struct Request<'a> {
    control: u8,
    body: &'a [u8],
}

fn requests(mut bytes: &[u8]) -> impl Iterator<Item = Request<'_>> {
    let all = core::iter::from_fn(move || {
        let (&[control, length], rest) = bytes.split_first_chunk::<2>()?;
        let (body, rest) = rest.split_at(usize::from(length).min(rest.len()));
        bytes = rest;
        Some(Request { control, body })
    });
    all.take(REQUESTS_MAX)
}

/// A frame with the right key and CRC around any body, as another program may write it, and what the decoder says.
fn sealed<M: Message>(sequence: u8, body: &[u8]) -> (Vec<u8>, Option<Result<Frame<M>, FrameError>>) {
    let mut content = schema::key::<M>().to_le_bytes().to_vec();
    content.push(sequence);
    content.extend(body);
    content.extend(crc32(&content).to_le_bytes());
    let mut frame = vec![0];
    let mut code = 0;
    for byte in content {
        // A run ends at a zero, or when its length is as large as a code can say.
        if byte == 0 || frame.len() - code == 0xff {
            frame[code] = u8::try_from(frame.len() - code).expect("at most 255");
            code = frame.len();
            frame.push(0);
        }
        if byte != 0 {
            frame.push(byte);
        }
    }
    frame[code] = u8::try_from(frame.len() - code).expect("at most 255");
    frame.push(DELIMITER);
    let mut decoder = Decoder::<M>::new();
    let result = frame.iter().find_map(|&byte| decoder.push(byte));
    (frame, result)
}

/// CRC-32 (ISO-HDLC), bit by bit: written a second time, so that the frames here are not those of `protocol` alone.
fn crc32(bytes: &[u8]) -> u32 {
    // Without branches, each of which a fuzzer would follow.
    let bit = |crc: u32, _| crc >> 1 ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
    !bytes.iter().fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), bit))
}

/// A board, and what the host knows of it.
struct Conversation<S: Scalar> {
    board: LocalBoard<S>,
    sequence: u8,
    last: Option<(u8, Vec<u8>)>,
    is_open: bool,
    is_stopped: bool,
    next_tick: u64,
    silent_ms: u64,
}

fn started<S: Scalar>() -> LocalBoard<S> {
    LocalBoard::new(Identity { board: Board::Stub, build_id: "test" }, 1).expect("defaults are valid")
}

fn converse<S: Scalar>(board: LocalBoard<S>, opening: u8, rest: &[u8]) {
    let mut talk = Conversation {
        board,
        sequence: 0,
        last: None,
        is_open: false,
        is_stopped: false,
        next_tick: 0,
        silent_ms: 0,
    };
    let announced = decoded(talk.board.announce());
    assert!(matches!(announced, Frame { sequence: 0, message: FromBoard::Hello(_) }), "{announced:?}");
    if opening & 2 == 0 {
        let time_base = if opening & 1 == 0 { TimeBase::Lockstep } else { TimeBase::RealTime };
        talk.request(Frame { sequence: 1, message: FromHost::Hello(hello(time_base)) });
        assert!(talk.is_open && talk.board.time_base() == time_base);
    }
    let mut ticks_left = TICKS_MAX;
    for Request { control, body } in requests(rest) {
        let sequence = if control & 0x80 == 0 { talk.sequence % 255 + 1 } else { talk.sequence };
        let (bytes, result) = sealed::<FromHost>(sequence, body);
        match result {
            Some(Ok(mut frame)) => {
                let mut buffer = [0; FRAME_BYTES_MAX];
                assert_eq!(encode(sequence, &frame.message, &mut buffer), Ok(&bytes[..]), "{frame:?}");
                assert_eq!(from_bytes(body).as_ref(), Ok(&frame.message));
                if let FromHost::Step(readings) | FromHost::Sense(readings) = &mut frame.message
                    && control & 0x40 == 0
                {
                    *readings = Readings { tick: talk.next_tick, ..*readings };
                }
                talk.request(frame);
            }
            Some(Err(_)) => talk.board.count_bad_frame(),
            None => panic!("nothing said about a frame"),
        }
        let ticks = u32::from(control & 0xf);
        let ticks = if ticks < 8 { ticks } else { (ticks - 7) * 32 }.min(ticks_left);
        ticks_left -= ticks;
        talk.pass(ticks);
    }
}

/// A hello that any board answers.
#[must_use]
pub fn hello(time_base: TimeBase) -> Hello {
    Hello {
        protocol_version: PROTOCOL_VERSION,
        schema_hash: schema::HASH,
        build_id: heapless::String::new(),
        board: None,
        scalar: None,
        map_hash: None,
        parameters_hash: None,
        time_base,
        epoch: 0,
    }
}

fn decoded(bytes: &[u8]) -> Frame<FromBoard> {
    let mut decoder = Decoder::new();
    let mut results = bytes.iter().filter_map(|&byte| decoder.push(byte));
    let frame = results.next().expect("a frame").expect("a valid frame");
    assert!(results.next().is_none(), "more than one frame");
    frame
}

impl<S: Scalar> Conversation<S> {
    fn request(&mut self, frame: Frame<FromHost>) {
        self.silent_ms = 0;
        let base = self.board.time_base();
        let reply = self.board.serve(&frame).to_vec();
        if self.board.time_base() != base {
            // Like a `Begin`.
            self.next_tick = 0;
        }
        let Frame { sequence, message } = frame;
        if let FromHost::Sense(_) = message {
            assert!(reply.is_empty(), "readings were answered");
            return;
        }
        let answer = decoded(&reply);
        assert_eq!(answer.sequence, sequence, "{answer:?}");
        let is_always_done = matches!(message, FromHost::Hello(_) | FromHost::EStop | FromHost::Disarm);
        if let Some((last, bytes)) = &self.last
            && *last == sequence
            && sequence != 0
            && !is_always_done
        {
            assert_eq!(*bytes, reply, "a repeated request has another answer");
            return;
        }
        (self.sequence, self.last) = (sequence, Some((sequence, reply)));
        self.follow(&message, &answer.message);
    }

    /// Keeps up with what the board has said, and checks that it fits.
    fn follow(&mut self, request: &FromHost, answer: &FromBoard) {
        let is_refused = matches!(answer, FromBoard::Refused(_));
        match (request, answer) {
            (FromHost::Hello(ours), FromBoard::Hello(theirs)) => {
                self.is_open = ours.check_against(theirs).is_ok();
                assert_eq!(theirs.time_base, self.board.time_base());
            }
            (FromHost::EStop, FromBoard::Done) => self.is_stopped = true,
            (FromHost::Disarm, FromBoard::Done) => self.is_stopped = false,
            (FromHost::EStop | FromHost::Disarm | FromHost::Hello(_), _) => panic!("{request:?}: {answer:?}"),
            _ if !self.is_open => assert_eq!(*answer, FromBoard::Refused(Refusal::Mismatch)),
            (FromHost::Begin, _) => {
                assert_eq!(*answer, FromBoard::Done);
                // An emergency stop stays: only a disarm ends it.
                self.next_tick = 0;
            }
            (FromHost::Step(readings), FromBoard::Outputs(outputs)) => {
                assert_eq!(outputs.tick, readings.tick);
                self.next_tick = outputs.tick + 1;
                self.check(outputs);
            }
            (FromHost::Step(_), FromBoard::Refused(Refusal::Tick { expected, .. })) => {
                self.next_tick = *expected;
            }
            (FromHost::Arm, _) => assert_eq!(is_refused, self.is_stopped, "{answer:?}"),
            (FromHost::Mode(_), _) => assert_eq!(*answer, FromBoard::Done),
            (FromHost::Health, _) => assert!(matches!(answer, FromBoard::Health(_)), "{answer:?}"),
            _ => {}
        }
    }

    /// So many milliseconds of real time; none pass in lockstep.
    fn pass(&mut self, ticks: u32) {
        for _ in 0..ticks {
            let Some(outputs) = self.board.tick() else { return };
            self.silent_ms += 1;
            self.next_tick = outputs.tick + 1;
            self.check(&outputs);
            if self.silent_ms > LINK_SILENT_MS {
                assert_eq!(outputs.wheel_drive, WheelDrive::default(), "driving, and nobody is there");
            }
        }
    }

    fn check(&self, outputs: &Outputs) {
        let WheelDrive { left, right } = outputs.wheel_drive;
        assert!(left.abs() <= 1.0 && right.abs() <= 1.0, "{outputs:?}");
        if outputs.stopped.is_some() || self.is_stopped {
            assert_eq!(outputs.wheel_drive, WheelDrive::default(), "stopped, and driving");
        }
        assert!(outputs.stopped.is_some() || !self.is_stopped, "an emergency stop without effect");
    }
}
