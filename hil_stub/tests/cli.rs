//! The stub as a program: what it prints, how it ends.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "helpers of tests are tests, which clippy.toml cannot know")]

use core::time::Duration;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Output, Stdio};

use protocol::frame::{Decoder, FRAME_BYTES_MAX, encode};
use protocol::message::{Board, FromBoard, FromHost, Refusal};

fn stub(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hil_stub"));
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn run(arguments: &[&str]) -> Output {
    stub(arguments).output().unwrap()
}

/// A stub that is ended with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts a stub and reads the line that says where it is.
fn start(arguments: &[&str]) -> (Running, String) {
    let mut child = stub(arguments).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    (Running(child), line.trim_end().to_owned())
}

/// The messages in a stream of frames.
fn messages(bytes: &[u8]) -> Vec<(u8, FromBoard)> {
    let mut decoder = Decoder::<FromBoard>::new();
    let frames = bytes.iter().filter_map(|&byte| decoder.push(byte));
    frames.map(|frame| frame.map(|frame| (frame.sequence, frame.message)).unwrap()).collect()
}

fn request(sequence: u8, message: &FromHost) -> Vec<u8> {
    encode(sequence, message, &mut [0; FRAME_BYTES_MAX]).unwrap().to_vec()
}

#[test]
fn help_names_the_links_and_wrong_usage_is_refused() {
    let help = run(&["--help"]);
    assert_eq!(help.status.code(), Some(0));
    let text = String::from_utf8(help.stdout).unwrap();
    for word in ["--pty", "--tcp", "--stdio", "--loss", "--corruption", "--delay-ms", "--reset-after"] {
        assert!(text.contains(word), "{word} is not in the help:\n{text}");
    }
    for arguments in [
        &[][..],
        &["--pty", "--stdio"],
        &["--pty", "--once"],
        &["--stdio", "--loss", "1.5"],
        &["--stdio", "--delay-ms", "9..3"],
        &["--stdio", "--scalar", "f64"],
    ] {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
    }
}

#[test]
fn an_address_that_is_not_ours_is_a_device_error_with_what_to_do() {
    let output = run(&["--tcp", "192.0.2.1:7000"]);
    assert_eq!(output.status.code(), Some(3));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("192.0.2.1:7000") && said.contains("port 0"), "{said}");
}

#[test]
fn on_stdio_it_introduces_itself_answers_and_ends_with_the_input() {
    let mut child = stub(&["--stdio", "--board", "stm32f100", "--scalar", "fixed"]).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    input.write_all(&request(1, &FromHost::Arm)).unwrap();
    input.write_all(b"\x00noise that is no frame\x00").unwrap();
    input.write_all(&request(2, &FromHost::EStop)).unwrap();
    drop(input);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let said = messages(&output.stdout);
    let (_, FromBoard::Hello(hello)) = &said[0] else { panic!("{said:?}") };
    assert_eq!(hello.board, Some(Board::Stm32f100));
    assert_eq!(said[1..], [(1, FromBoard::Refused(Refusal::Mismatch)), (2, FromBoard::Done)]);
}

#[test]
fn over_tcp_it_outlives_its_hosts_unless_asked_not_to() {
    let visit = |address: &str| {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(2))).unwrap();
        stream.write_all(&request(9, &FromHost::EStop)).unwrap();
        stream.shutdown(std::net::Shutdown::Write).unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        assert_eq!(messages(&bytes).last(), Some(&(9, FromBoard::Done)));
    };
    let (_running, address) = start(&["--tcp", "127.0.0.1:0"]);
    visit(&address);
    visit(&address);

    let (mut once, address) = start(&["--tcp", "127.0.0.1:0", "--once"]);
    visit(&address);
    assert_eq!(once.0.wait().unwrap().code(), Some(0));
    let mut said = String::new();
    once.0.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(said.contains("gone away"), "{said}");
}

#[test]
fn it_makes_a_pseudo_terminal_and_prints_its_path() {
    let (_running, path) = start(&["--pty"]);
    assert!(std::path::Path::new(&path).exists(), "{path}");
}
