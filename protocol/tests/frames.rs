//! Frames come back as they were sent; damage of any kind is noticed and costs no more than it must.
#![expect(
    clippy::unwrap_used,
    reason = "clippy.toml allows it in #[test] functions; the helpers here are part of them"
)]

mod common;

use common::{from_board, from_host, full_checkpoints, host_examples};
use core::fmt::Debug;
use proptest::prelude::{ProptestConfig, any, prop};
use proptest::test_runner::TestCaseError;
use proptest::{prop_assert, prop_assert_eq, proptest};
use protocol::codec::{DecodeError, EncodeError, Message};
use protocol::frame::{Counts, DELIMITER, Decoder, FRAME_BYTES_MAX, Frame, FrameError, encode};
use protocol::message::{Checkpoints, FromBoard, FromHost};
use protocol::schema;

type Received<M> = Vec<Result<Frame<M>, FrameError>>;

fn framed<M: Message>(sequence: u8, message: &M) -> Vec<u8> {
    encode(sequence, message, &mut [0; FRAME_BYTES_MAX]).unwrap().to_vec()
}

fn receive<M: Message>(bytes: &[u8]) -> Received<M> {
    let mut decoder = Decoder::new();
    bytes.iter().filter_map(|&byte| decoder.push(byte)).collect()
}

fn is_foreign<M: Message>(bytes: &[u8]) -> bool {
    matches!(receive::<M>(bytes)[..], [Err(FrameError::Key { .. })])
}

/// A frame around any content: the key, sequence number and CRC that it says, stuffed.
fn stuffed(content: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for run in content.split(|&byte| byte == 0) {
        bytes.push(u8::try_from(run.len() + 1).unwrap());
        bytes.extend(run);
    }
    bytes.push(DELIMITER);
    bytes
}

/// Key and sequence number, then the body, then the CRC-32 of both.
fn sealed(key: u16, sequence: u8, body: &[u8]) -> Vec<u8> {
    let covered = [&key.to_le_bytes()[..], &[sequence], body].concat();
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&covered);
    [covered, crc.to_le_bytes().to_vec()].concat()
}

/// Damages a frame, with two whole ones behind it, in every way that touches one place of it.
fn notices_damage<M: Message + Clone + Debug + PartialEq>(message: &M) -> Result<(), TestCaseError> {
    let first = framed(1, message);
    let (second, third) =
        (Frame { sequence: 2, message: message.clone() }, Frame { sequence: 3, message: message.clone() });
    let rest = [framed(2, message), framed(3, message)].concat();
    let check = |damaged: &[u8], joins_the_next: bool, what: &str| {
        let received = receive::<M>(&[damaged, &rest].concat());
        let good: Vec<_> = received.iter().flatten().collect();
        let expected = if joins_the_next { vec![&third] } else { vec![&second, &third] };
        prop_assert_eq!(&good, &expected, "{}", what);
        prop_assert!(received.len() > good.len(), "not reported: {}", what);
        Ok(())
    };
    let last = first.len() - 1;
    for at in 0..=last {
        for bit in 0..8 {
            let mut damaged = first.clone();
            damaged[at] ^= 1 << bit;
            check(&damaged, at == last, &format!("bit {bit} of byte {at} flipped"))?;
        }
        let mut shorter = first.clone();
        shorter.remove(at);
        check(&shorter, at == last, &format!("byte {at} lost"))?;
        if at > 0 {
            check(&first[..at], true, &format!("cut to {at} bytes"))?;
            let ended = [&first[..at], &[DELIMITER]].concat();
            // All but the delimiter is there: nothing is missing.
            if at < last {
                check(&ended, false, &format!("cut to {at} bytes and ended"))?;
            }
        }
        for byte in [1, 2, 0x55, 0xff] {
            let mut longer = first.clone();
            longer.insert(at, byte);
            check(&longer, false, &format!("{byte:#04x} inserted before byte {at}"))?;
        }
        let mut split = first.clone();
        split.insert(at, DELIMITER);
        // At either end it only makes an empty frame.
        if at > 0 && at < last {
            check(&split, false, &format!("delimiter inserted before byte {at}"))?;
        } else {
            prop_assert!(receive::<M>(&[split, rest.clone()].concat()).iter().all(Result::is_ok));
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn host_frames_come_back(sequence: u8, message in from_host()) {
        let bytes = framed(sequence, &message);
        prop_assert_eq!(bytes.iter().position(|&byte| byte == DELIMITER), Some(bytes.len() - 1));
        prop_assert_eq!(receive(&bytes), [Ok(Frame { sequence, message })]);
        prop_assert!(is_foreign::<FromBoard>(&bytes));
    }

    #[test]
    fn board_frames_come_back(sequence: u8, message in from_board()) {
        let bytes = framed(sequence, &message);
        prop_assert_eq!(bytes.iter().position(|&byte| byte == DELIMITER), Some(bytes.len() - 1));
        prop_assert_eq!(receive(&bytes), [Ok(Frame { sequence, message })]);
        prop_assert!(is_foreign::<FromHost>(&bytes));
    }

    #[test]
    fn garbage_costs_no_whole_frame(
        garbage in prop::collection::vec(any::<u8>(), 0..600),
        zeros in prop::collection::vec(0_usize..600, 0..9),
        message in from_host(),
    ) {
        let mut bytes = garbage;
        for at in zeros {
            if let Some(byte) = bytes.get_mut(at) {
                *byte = DELIMITER;
            }
        }
        bytes.push(DELIMITER);
        let pieces = bytes.split(|&byte| byte == DELIMITER).filter(|piece| !piece.is_empty()).count();
        bytes.extend(framed(9, &message));
        let received = receive(&bytes);
        prop_assert_eq!(received.len(), pieces + 1);
        prop_assert!(received[..pieces].iter().all(Result::is_err));
        prop_assert_eq!(received.last(), Some(&Ok(Frame { sequence: 9, message })));
    }

    #[test]
    fn whole_frames_with_any_body_are_messages_or_refused(
        kind in 0_u8..16,
        body in prop::collection::vec(any::<u8>(), 0..150),
        sequence: u8,
    ) {
        let body = [&[kind][..], &body[..]].concat();
        for result in receive::<FromHost>(&stuffed(&sealed(schema::key::<FromHost>(), sequence, &body))) {
            match result {
                Ok(frame) => prop_assert_eq!(frame.sequence, sequence),
                Err(FrameError::Message(_) | FrameError::TooLong { .. }) => {}
                Err(error) => prop_assert!(false, "{}", error),
            }
        }
    }
}

proptest! {
    // Each case tries every place of a frame.
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn damage_to_a_host_frame_is_noticed(message in from_host()) {
        notices_damage(&message)?;
    }

    #[test]
    fn damage_to_a_board_frame_is_noticed(message in from_board()) {
        notices_damage(&message)?;
    }
}

#[test]
fn what_is_wrong_is_named() {
    let error = |bytes: &[u8]| match &receive::<FromHost>(bytes)[..] {
        [Err(error)] => *error,
        other => panic!("{other:?}"),
    };
    let key = schema::key::<FromHost>();
    let whole = framed(1, &FromHost::Arm);

    assert_eq!(error(&[5, 1, 0]), FrameError::Stuffing { missing_bytes: 3 });
    assert_eq!(error(&[5, 1, 0]).to_string(), "frame cut 3 bytes before its next zero");
    assert_eq!(error(&[1, 0]), FrameError::Truncated { found_bytes: 0 });
    assert_eq!(error(&stuffed(&[7; 6])), FrameError::Truncated { found_bytes: 6 });

    let limit_bytes = FRAME_BYTES_MAX;
    assert_eq!(error(&[&[9; 1000][..], &[0]].concat()), FrameError::TooLong { limit_bytes });
    let just_too_long = sealed(key, 1, &[3; FromHost::MAX_BYTES + 1]);
    assert_eq!(error(&stuffed(&just_too_long)), FrameError::TooLong { limit_bytes });
    let just_not = sealed(key, 1, &[3; FromHost::MAX_BYTES]);
    let surplus = DecodeError::TrailingBytes { surplus_bytes: FromHost::MAX_BYTES - 1 };
    assert_eq!(error(&stuffed(&just_not)), FrameError::Message(surplus));

    let mut damaged = whole.clone();
    damaged[2] ^= 0x40;
    assert!(matches!(error(&damaged), FrameError::Checksum { .. }), "{:?}", error(&damaged));
    let foreign = FrameError::Key { expected: key, found: !key };
    assert_eq!(error(&stuffed(&sealed(!key, 1, &[3]))), foreign);
    assert!(foreign.to_string().contains(&format!("{key:04x} was expected")), "{foreign}");
    let empty = FrameError::Message(DecodeError::Truncated { found_bytes: 0 });
    assert_eq!(error(&stuffed(&sealed(key, 1, &[]))), empty);
    assert_eq!(
        error(&stuffed(&sealed(key, 1, &[99]))).to_string(),
        "whole frame without a valid message: message number 99, where 0 to 13 are known"
    );
}

#[test]
fn empty_frames_are_nothing_and_the_rest_is_counted() {
    let mut decoder = Decoder::<FromHost>::new();
    for byte in
        [&[0, 0, 0][..], &framed(1, &FromHost::Arm), &[0, 1, 0], &framed(2, &FromHost::Begin)].concat()
    {
        let _ = decoder.push(byte);
    }
    assert_eq!(decoder.counts(), Counts { good: 2, bad: 1 });
}

#[test]
fn buffers_are_as_large_as_they_must_be_and_no_larger() {
    let largest = FromHost::Checkpoints(Checkpoints::Append(full_checkpoints()));
    assert_eq!(framed(255, &largest).len(), FRAME_BYTES_MAX);
    for (name, message) in host_examples() {
        let bytes = framed(5, &message);
        let mut exact = vec![0xee; bytes.len()];
        assert_eq!(encode(5, &message, &mut exact), Ok(&bytes[..]), "{name}");
        for available_bytes in 0..bytes.len() {
            let short = &mut exact[..available_bytes];
            assert_eq!(
                encode(5, &message, short),
                Err(EncodeError::BufferTooSmall { available_bytes }),
                "{name}"
            );
        }
        assert_eq!(encode(5, &message, &mut vec![0xee; 1000]), Ok(&bytes[..]), "{name}");
    }
    // The smaller board has 8 KiB of RAM.
    assert!(size_of::<Decoder<FromHost>>() < 160, "{}", size_of::<Decoder<FromHost>>());
}
