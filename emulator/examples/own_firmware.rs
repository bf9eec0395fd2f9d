//! Runs your own firmware on a supported board: `own_firmware feather-f405 FIRMWARE.elf 2` runs it
//! for two seconds. Prints the bytes sent on the serial line, the time at which START rises, the
//! costliest functions and the broken rules.

use hal_mock::{Sliding, SlidingScene};
use ridgetone_emulator::{Board, Emulator, Image, Pin, Start, Until};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, board, path, seconds] = &*arguments else {
        return Err("own_firmware BOARD FIRMWARE.elf SECONDS".into());
    };
    let kind = Board::named(board).ok_or("feather-f405, nucleo-f446re, or one with -adc")?;
    let image = Image::read(Path::new(path))?;
    // A finger that slides over a grating, at the inputs of the ADS1258.
    let scene = SlidingScene::new(Sliding::default())?;
    let mut board = Emulator::new(kind, &image, scene, Start::default())?;
    board.count_functions();

    let start = Pin::named("PC5").ok_or("no such pin")?;
    while board.pin(start) != Some(true) && board.run_to(Until::Pin(start), 1_000_000_000)? {}
    println!(
        "START is {:?} after {} us",
        board.pin(start),
        board.now_ns() / 1000
    );

    // Sends bytes to the board: a request of your own protocol.
    board.send(&[0]);
    board.run_until((seconds.parse::<f64>()? * 1e9) as u64)?;
    let sent = board.take_sent();
    println!(
        "{} bytes, {:02x?} ...",
        sent.len(),
        &sent[..sent.len().min(16)]
    );

    let [cycles, asleep] = [board.cycles().0, board.cycles().1].map(|cycles| cycles as f64);
    println!(
        "awake for {:.1} % of the time",
        100.0 * (1.0 - asleep / cycles)
    );
    for function in board.function_counts(&image).iter().take(10) {
        println!("{:>12} {}", function.instructions, function.name);
    }
    for finding in board.findings() {
        println!("{finding}");
    }
    Ok(())
}
