//! The command and the very image of a stylus' board: the register model's serial line is a
//! pseudo-terminal, in real time.

use super::common::{directory, ridgetone, text};
use super::serial_board::raw_end;
use super::stylus_board::bytes_from;
use super::{counts, recorded_touch};
use hal_mock::Constant;
use ridgetone_emulator::{Board, Emulator, Image, Start};
use ridgetone_stimulus::Actuator;
use ridgetone_stylus::SAMPLE_HZ;
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Codes of the converter's rest, and the most of them from a sample to the next.
const REST_CODE: u16 = 2048;
fn step_most() -> f64 {
    let code_v = f64::from(Actuator::PIEZO.voltage_v) / 4095.0;
    f64::from(Actuator::PIEZO.slew_v_s) / f64::from(SAMPLE_HZ) / code_v + 1.0
}

/// What the model has done so far.
#[derive(Default)]
struct Seen {
    codes: Mutex<Vec<u16>>,
    findings: Mutex<Vec<String>>,
    ends: AtomicBool,
}

/// Runs the image until it gets a message to end: a millisecond at a time, and no faster than a
/// clock.
fn run_image(mut end: &File, seen: &Seen) {
    let image = Image::built(Board::StylusF405).unwrap_or_else(|error| panic!("{error}"));
    let mut emulator = Emulator::new(
        Board::StylusF405,
        &image,
        Constant::default(),
        Start::default(),
    )
    .expect("vectors");
    emulator.move_hand(|ns| counts(1e-9 * ns as f64));
    let (bytes, begun, mut read) = (bytes_from(end), Instant::now(), 0);
    while !seen.ends.load(Relaxed) {
        emulator
            .run_ns(1_000_000)
            .unwrap_or_else(|failure| panic!("{failure}"));
        bytes.try_iter().for_each(|bytes| emulator.send(&bytes));
        let _ = end.write_all(&emulator.take_sent());
        let outputs = emulator.outputs();
        seen.codes
            .lock()
            .expect("codes")
            .extend(outputs[read..].iter().filter_map(|output| output.code));
        read = outputs.len();
        sleep(Duration::from_nanos(emulator.now_ns()).saturating_sub(begun.elapsed()));
    }
    *seen.findings.lock().expect("findings") = emulator
        .findings()
        .iter()
        .map(|finding| format!("{finding:?}"))
        .collect();
}

/// A texture arrives, the converter's output follows the encoder over it, and without the command
/// it stops within its slew.
#[test]
#[ignore = "needs the boards' images, and a core: cargo xtask test --all"]
fn the_command_drives_the_image() {
    let folder = directory();
    let path = recorded_touch(&folder);
    let (end, name) = raw_end();
    let seen = Arc::new(Seen::default());
    let model = Arc::clone(&seen);
    let board = std::thread::spawn(move || run_image(&end, &model));
    let mut command = ridgetone()
        .args(["link", "--finger", text(&path), "--stylus", &name, "--json"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let reports = BufReader::new(command.stdout.take().expect("its output")).lines();
    let is_felt =
        |report: &Value| report["is_felt"] == true && report["stylus"]["state"] == "vibrating";
    let felt = reports
        .map(|line| serde_json::from_str::<Value>(&line.expect("a line")).expect("JSON"))
        .filter(is_felt)
        // A whole second of the one before has vibrated.
        .nth(1)
        .expect("a texture that is felt");
    let codes = seen.codes.lock().expect("codes").clone();
    command.kill().expect("it runs");
    command.wait().expect("it has ended");
    sleep(Duration::from_millis(2500));
    seen.ends.store(true, Relaxed);
    board.join().expect("the model runs");
    let period_mm = felt["period_mm"].as_f64().expect("a period");
    let last = &codes[codes.len() - SAMPLE_HZ as usize..];
    let rises = last
        .windows(2)
        .filter(|pair| pair[0] < REST_CODE && pair[1] >= REST_CODE)
        .count() as f64;
    println!("{period_mm} mm, {rises} rises in a second: {felt}");
    // 100 mm/s over the period: the encoder's hand, and not a clock, makes the frequency.
    assert!(
        (rises - 100.0 / period_mm).abs() < 1.5,
        "{rises} rises over {period_mm} mm"
    );
    let all = seen.codes.lock().expect("codes").clone();
    let step = all
        .windows(2)
        .map(|pair| pair[0].abs_diff(pair[1]))
        .max()
        .expect("codes");
    assert!(
        f64::from(step) <= step_most(),
        "a step of {step} codes, allowed are {}",
        step_most()
    );
    // At rest, and for a second: the last signs of life were within a tenth of a second before the
    // command was killed.
    let behind = &all[codes.len()..];
    let moving = behind
        .iter()
        .rposition(|code| *code != REST_CODE)
        .expect("it vibrated") as f64
        / f64::from(SAMPLE_HZ);
    println!("at rest {moving} s behind the command's end, greatest step {step} codes");
    assert!(moving < 1.3, "{moving} s");
    assert_eq!(*seen.findings.lock().expect("findings"), [""; 0]);
}
