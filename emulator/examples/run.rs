//! Runs a board's image over the demo's grating: `run feather-f405 5`, seconds.

use hal_mock::{Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Start};
use ridgetone_proto::telemetry::{Decoder, Event};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, board, seconds] = &*arguments else {
        return Err("run BOARD SECONDS".into());
    };
    let board =
        Board::named(board).ok_or("feather-f405, nucleo-f446re, or one of these with -adc")?;
    let scene = SlidingScene::new(Sliding::default())?;
    let mut emulator = Emulator::new(board, &Image::built(board)?, scene, Start::default())?;
    let begun = Instant::now();
    let outcome = emulator.run_ns((seconds.parse::<f64>()? * 1e9) as u64);
    let passed_s = begun.elapsed().as_secs_f64();
    let mut decoder = Decoder::new();
    for packet in emulator
        .take_sent()
        .into_iter()
        .filter_map(|byte| decoder.push(byte))
    {
        match packet.event {
            Event::Image(_) | Event::Raw(_) => {}
            event => println!("{event:?}"),
        }
    }
    for finding in emulator.findings() {
        println!("{finding}");
    }
    println!("{:?}", emulator.resets());
    let (cycles, asleep) = emulator.cycles();
    let board_s = emulator.now_ns() as f64 * 1e-9;
    println!(
        "{board_s:.3} s of the board in {passed_s:.3} s, {:.1} million instructions a second, {:.3} cycles an instruction, \
         awake {:.2} %, {} conversions read, {:?} by the ADC",
        emulator.instructions() as f64 / passed_s * 1e-6,
        (cycles - asleep) as f64 / emulator.instructions() as f64,
        (cycles - asleep) as f64 / cycles as f64 * 100.0,
        emulator.readings().len(),
        emulator.adc().counters(),
    );
    for (name, irq) in [
        ("DRDY", 10),
        ("TIM4", 30),
        ("USART2", 38),
        ("USART3", 39),
        ("OTG_HS_EP1_OUT", 74),
        ("OTG_HS_EP1_IN", 75),
        ("OTG_HS_WKUP", 76),
    ] {
        println!("{name:<14} {:?}", emulator.served(irq));
    }
    outcome?;
    Ok(())
}
