//! A board's serial line as a port of this PC, in real time: `serve feather-f405` prints the port's path, and
//! `ridgetone monitor --port PATH` and all other commands work with it. The image runs on the register model, in front of the
//! demo's touch, again and again.

use hal_mock::{Repeated, Sliding, SlidingScene};
use rig::{Board, Image, Rig, Start};
use serialport::{ClearBuffer, SerialPort, TTYPort};
use std::error::Error;
use std::io::{Read, Write};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// From one look at the port to the next, nanoseconds of virtual time.
const STEP_NS: u64 = 1_000_000;

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or_default();
    let board = Board::named(&name).ok_or("serve feather-f405, or serve nucleo-f446re")?;
    let scene = Repeated(SlidingScene::new(Sliding::default())?);
    let mut rig = Rig::new(board, &Image::built(board)?, scene, Start::default())?;
    let (mut ours, theirs) = TTYPort::pair()?;
    ours.set_timeout(Duration::ZERO)?;
    println!("{}", theirs.name().ok_or("the port has no name")?);
    let begun = Instant::now();
    loop {
        rig.run_ns(STEP_NS)?;
        let mut bytes = [0; 256];
        if let Ok(length) = ours.read(&mut bytes) {
            rig.send(&bytes[..length]);
        }
        // A byte at a time never waits.
        let sent = rig.take_sent();
        if !sent.iter().all(|byte| matches!(ours.write(&[*byte]), Ok(1))) {
            // Nobody has read for long. A cable keeps nothing.
            theirs.clear(ClearBuffer::Input)?;
        }
        sleep(Duration::from_nanos(rig.now_ns()).saturating_sub(begun.elapsed()));
    }
}
