//! A board's serial line as a port of this PC, in real time: `serve feather-f405` prints the port's
//! path, and `ridgetone monitor --port PATH` and all other commands work with it. The image runs on
//! the register model, in front of the demo's touch, again and again, or at rest: `serve
//! feather-f405 rest`. `serve stylus-f405` is a stylus, whose hand goes to and fro by 40 mm once a
//! second.

use hal_mock::{Constant, Repeated, Scene, Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Start};
use serialport::{ClearBuffer, SerialPort, TTYPort};
use std::error::Error;
use std::io::{Read, Write};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// From one look at the port to the next, nanoseconds of virtual time.
const STEP_NS: u64 = 1_000_000;

fn main() -> Result<(), Box<dyn Error>> {
    let usage = "serve feather-f405, nucleo-f446re, one of these with -adc, or stylus-f405, with `rest` behind it for a finger that touches nothing, a hand that rests";
    let mut arguments = std::env::args().skip(1);
    let board = arguments
        .next()
        .and_then(|name| Board::named(&name))
        .ok_or(usage)?;
    let (rest, moves) = (arguments.next(), board == Board::StylusF405);
    let scene: Box<dyn Scene> = match rest.as_deref() {
        None => Box::new(Repeated(SlidingScene::new(Sliding::default())?)),
        // The middle of a bridge, which the processor's own ADC sees in the middle of its scale.
        Some("rest") if Board::OWN_ADC.contains(&board) => Box::new(Constant {
            volts: [2.5; 16],
            ..Constant::default()
        }),
        Some("rest") => Box::new(Constant::default()),
        Some(_) => return Err(usage.into()),
    };
    let mut emulator = Emulator::new(board, &Image::built(board)?, scene, Start::default())?;
    if moves && rest.is_none() {
        // Counts of 5 um.
        emulator.move_hand(|ns| (4000.0 * (std::f64::consts::TAU * ns as f64 * 1e-9).sin()) as i64);
    }
    let (mut ours, theirs) = TTYPort::pair()?;
    ours.set_timeout(Duration::ZERO)?;
    println!("{}", theirs.name().ok_or("the port has no name")?);
    let begun = Instant::now();
    loop {
        emulator.run_ns(STEP_NS)?;
        let mut bytes = [0; 256];
        if let Ok(length) = ours.read(&mut bytes) {
            emulator.send(&bytes[..length]);
        }
        // A byte at a time never waits.
        let sent = emulator.take_sent();
        if !sent
            .iter()
            .all(|byte| matches!(ours.write(&[*byte]), Ok(1)))
        {
            // Nobody has read for long. A cable keeps nothing.
            theirs.clear(ClearBuffer::Input)?;
        }
        sleep(Duration::from_nanos(emulator.now_ns()).saturating_sub(begun.elapsed()));
    }
}
