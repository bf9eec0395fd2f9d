//! Prints the page of a board's figures, as Markdown: `figures TARGET_FOLDER`, after `cargo xtask firmware`.

use hal_mock::{Constant, Sliding, SlidingScene};
use ridgetone_proto::telemetry::{Decoder, Event};
use rig::{Board, Image, Rig, Start};
use std::error::Error;
use std::path::Path;

/// Interrupts by their tasks. On the Nucleo the line's interrupt is USART2.
const TASKS: [(&str, [u16; 2]); 6] = [
    ("`drdy`", [10, 10]),
    ("`line`", [39, 38]),
    ("`detect`", [20, 20]),
    ("`report`", [19, 19]),
    ("`watch`", [30, 30]),
    ("`fit`", [21, 21]),
];

fn main() -> Result<(), Box<dyn Error>> {
    let target = std::env::args().nth(1).ok_or("figures TARGET_FOLDER")?;
    for (at, board) in [Board::FeatherF405, Board::NucleoF446re].into_iter().enumerate() {
        let path = Path::new(&target).join("firmware").join(board.name()).join("ridgetone-firmware.elf");
        print_board(board, at, &Image::read(&path)?)?;
    }
    Ok(())
}

fn print_board(board: Board, at: usize, image: &Image) -> Result<(), Box<dyn Error>> {
    println!("\n## {}\n", board.name());
    let mut rig = Rig::new(board, image, Constant::default(), Start::default())?;
    let mut decoder = Decoder::new();
    let greeting_ns = loop {
        rig.run_ns(100_000)?;
        let mut packets = rig.take_sent().into_iter().filter_map(|byte| decoder.push(byte));
        if packets.any(|packet| matches!(packet.event, Event::Hello(_))) {
            break rig.now_ns();
        }
    };
    let ms = |ns: u64| ns as f64 * 1e-6;
    println!("From power-up to START {:.1} ms,", ms(rig.started_ns().unwrap_or(0)));
    println!("to the first conversion that is read {:.1} ms,", ms(rig.readings()[0].edge_ns));
    println!("to the end of the greeting on the line {:.1} ms.", ms(greeting_ns));
    println!("Conversions lost at the start: {}.\n", rig.adc().counters().lost);

    let mut rig = Rig::new(board, image, SlidingScene::new(Sliding::default())?, Start::default())?;
    rig.run_ns(400_000_000)?;
    rig.forget_served();
    println!("| phase | awake, % | cycles an instruction |\n|---|---|---|");
    for (phase, s) in [("before the contact", 0.3), ("contact", 1.0), ("sliding, fits", 2.0), ("after the slide", 1.0)]
    {
        let (from, instructions) = (rig.cycles(), rig.instructions());
        rig.run_ns((s * 1e9) as u64)?;
        let (cycles, asleep) = (rig.cycles().0 - from.0, rig.cycles().1 - from.1);
        let awake = (cycles - asleep) as f64;
        let each = awake / (rig.instructions() - instructions) as f64;
        println!("| {phase} | {:.1} | {each:.2} |", awake / cycles as f64 * 100.0);
    }
    println!(
        "\n| task | runs | mean, us | longest, us | mean wait, us | longest wait, us |\n|---|---|---|---|---|---|"
    );
    for (task, irqs) in TASKS {
        let served = rig.served(irqs[at]);
        let us = |cycles: u64| cycles as f64 / 168.0;
        let mean = |sum: u64| us(sum) / served.times.max(1) as f64;
        println!(
            "| {task} | {} | {:.1} | {:.1} | {:.1} | {:.1} |",
            served.times,
            mean(served.run_cycles),
            us(served.longest_run_cycles),
            mean(served.wait_cycles),
            us(served.longest_wait_cycles),
        );
    }
    println!("\nRules broken:\n");
    for finding in rig.findings() {
        println!("- {finding}");
    }
    Ok(())
}
