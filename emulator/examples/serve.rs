//! A board's serial line as a port of this PC, in real time: `serve feather-f405` prints the port's
//! path, and `ridgetone monitor --port PATH` and all other commands work with it. In front of it is the
//! demo's touch, again and again, or nothing: `serve feather-f405 rest`. `serve stylus-f405` is a
//! stylus, whose hand goes to and fro by 40 mm once a second.

use hal_mock::{Constant, Repeated, Scene, Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Session, Start};
use serialport::{ClearBuffer, SerialPort, TTYPort};
use std::error::Error;
use std::io::{Read, Write};
use std::time::Duration;

const USAGE: &str = "serve feather-f405, nucleo-f446re, one of these with -adc, or stylus-f405, with `rest` behind it for a finger that touches nothing, a hand that rests";

fn board(board: Board, rests: bool) -> Result<Emulator, Box<dyn Error + Send + Sync>> {
    let scene: Box<dyn Scene> = if !rests {
        Box::new(Repeated(SlidingScene::new(Sliding::default())?))
    } else if Board::OWN_ADC.contains(&board) {
        // The middle of a bridge, which the processor's own ADC sees in the middle of its scale.
        Box::new(Constant {
            volts: [2.5; 16],
            ..Constant::default()
        })
    } else {
        Box::new(Constant::default())
    };
    let image = Image::built(board).map_err(|error| error.to_string())?;
    let mut emulator = Emulator::new(board, &image, scene, Start::default())?;
    if board == Board::StylusF405 && !rests {
        // Counts of 5 um.
        emulator.move_hand(|ns| (4000.0 * (std::f64::consts::TAU * ns as f64 * 1e-9).sin()) as i64);
    }
    Ok(emulator)
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_default();
    let kind = Board::named(&name).ok_or(USAGE)?;
    let rests = match arguments.next().as_deref() {
        None => false,
        Some("rest") => true,
        Some(_) => return Err(USAGE.into()),
    };
    let (mut ours, theirs) = TTYPort::pair()?;
    ours.set_timeout(Duration::ZERO)?;
    println!("{}", theirs.name().ok_or("the port has no name")?);
    let session = Session::start(1.0, move || board(kind, rests));
    while let Some(sent) = session.receive(Duration::from_millis(1)) {
        let mut bytes = [0; 256];
        if let Ok(length) = ours.read(&mut bytes) {
            session.send(&bytes[..length]);
        }
        // A byte at a time never waits.
        if !sent
            .iter()
            .all(|byte| matches!(ours.write(&[*byte]), Ok(1)))
        {
            // Nobody has read for long. A cable keeps nothing.
            theirs.clear(ClearBuffer::Input)?;
        }
    }
    session.end().map(drop)
}
