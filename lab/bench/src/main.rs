//! Runs the bench image on the emulator and prints its table: `ridgetone-bench bench-image.elf`. If
//! the Feather's image follows, compares the default scene with the flashed one over the demo's
//! touch, and measures load and latency of the scan plans; `--json FILE` saves all of it for
//! `lab/trade.py`. With `--words` it prints the bits of the results instead, for `qemu.py`.

mod layout;
mod plans;

use hal_mock::{Constant, Sliding, SlidingScene};
use layout::{FRAMES, ROOTS, ROWS, SCENES, WINDOW_ROWS, WORDS};
use ridgetone_emulator::{Board, Emulator, Image, Start, Until};
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;

/// Board time in nanoseconds without a new row after which the image counts as hung.
const ROW_NS: u64 = 60_000_000_000;

/// Interrupts of the tasks `detect` and `fit`: OTG_HS_EP1_OUT and OTG_HS_WKUP.
const DETECT_IRQ: u16 = 74;
const FIT_IRQ: u16 = 76;

/// Frequency of the windows, cycles per frame.
const TRUTH: f64 = 30.0 / 3.6 / 241.14;

struct Row {
    instructions: u64,
    status: u32,
    frequency: f32,
    sigma: f32,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [bench, option] = &*arguments
        && option == "--words"
    {
        for row in run(Path::new(bench))? {
            let bits = [row.status, row.frequency.to_bits(), row.sigma.to_bits()];
            println!("{}", bits.map(|word| format!("{word:08x}")).join(" "));
        }
        return Ok(());
    }
    let (bench, flashed, file) = match &*arguments {
        [bench] => (bench, None, None),
        [bench, flashed] => (bench, Some(flashed), None),
        [bench, flashed, option, file] if option == "--json" => (bench, Some(flashed), Some(file)),
        _ => return Err("ridgetone-bench BENCH.elf [FEATHER.elf [--json FILE] | --words]".into()),
    };
    let rows = run(Path::new(bench))?;
    println!("instructions, thousands: untracked / tracked; error of the untracked one, sigma");
    println!(
        "{:<36}{:>22}{:>22}{:>22}{:>22}",
        "", "0.2 s", "0.4 s", "1 s", "3.9 s"
    );
    for ((scene, _), own) in SCENES.iter().zip(rows.chunks(2 * FRAMES.len())) {
        let cells = own.chunks(2).map(|pair| {
            let off = (f64::from(pair[0].frequency) - TRUTH) / f64::from(pair[0].sigma);
            let [first, then] = [&pair[0], &pair[1]].map(|row| row.instructions / 1000);
            format!(
                "{first} / {then}; {}{off:.1}",
                if pair[0].status == 0 { "" } else { "?" }
            )
        });
        println!(
            "{scene:<36}{}",
            cells.map(|cell| format!("{cell:>22}")).collect::<String>()
        );
    }
    let rivals = rows
        .get(2 * FRAMES.len() * SCENES.len()..)
        .unwrap_or_default();
    for (name, own) in ["Hann FFT; error, %", "IEEE 1057; error, %"]
        .iter()
        .zip(rivals.chunks(FRAMES.len()))
    {
        let cells = own.iter().map(|row| {
            let off = 100.0 * (f64::from(row.frequency) / TRUTH - 1.0);
            format!("{}; {off:.4}", row.instructions / 1000)
        });
        println!(
            "{name:<36}{}",
            cells.map(|cell| format!("{cell:>22}")).collect::<String>()
        );
    }
    if let [instruction, library] = &rows[WINDOW_ROWS..] {
        let each = |row: &Row| row.instructions / u64::from(ROOTS);
        let (own, libm) = (each(instruction), each(library));
        println!("a square root, with its loop: {own}; by libm {libm}");
        if instruction.frequency.to_bits() != library.frequency.to_bits() {
            return Err("square roots differ from libm's".into());
        }
    }
    if let Some(flashed) = flashed {
        let Flashed { fits, frames } = Flashed::over_the_demo(Path::new(flashed))?;
        println!("flashed image, 1 s windows of the demo in order, thousands: {fits:?}");
        let mean = frames.iter().sum::<u64>() / (frames.len() as u64).max(1);
        let max = frames.iter().max().unwrap_or(&0);
        println!("a frame of the demo: {mean} on average, {max} at most");
        let whole = |row: usize| rows.get(row).map_or(0, |row| row.instructions / 1000);
        println!("here: {} untracked, {} tracked", whole(4), whole(5));
    }
    if let Some((file, flashed)) = file.zip(flashed) {
        let plans = plans::measure(&Image::read(Path::new(flashed))?, FIT_IRQ)?;
        std::fs::write(file, json(&rows, plans)? + "\n")?;
    }
    Ok(())
}

/// Returns the instructions per scene or method and window, and the plans, as JSON with one line
/// per row.
fn json(rows: &[Row], plans: Vec<Value>) -> serde_json::Result<String> {
    let mut lines = Vec::new();
    let fits = rows.chunks(2 * FRAMES.len());
    for ((scene, _), own) in SCENES.iter().zip(fits) {
        for (frames, pair) in FRAMES.iter().zip(own.chunks(2)) {
            let [untracked, tracked] = [&pair[0], &pair[1]].map(|row| row.instructions);
            let cell = json!({"untracked": untracked, "tracked": tracked});
            lines.push(format!(
                "{}: {cell}",
                json!(format!("{scene}/{frames} frames"))
            ));
        }
    }
    let others = rows.get(2 * FRAMES.len() * SCENES.len()..);
    let others = others.unwrap_or_default().chunks(FRAMES.len());
    for (name, own) in ["Hann FFT", "IEEE 1057"].iter().zip(others) {
        for (frames, row) in FRAMES.iter().zip(own) {
            let cell = json!({"untracked": row.instructions});
            lines.push(format!(
                "{}: {cell}",
                json!(format!("{name}/{frames} frames"))
            ));
        }
    }
    let plans: serde_json::Result<Vec<String>> = plans.iter().map(serde_json::to_string).collect();
    Ok(format!(
        "{{\n\"detail\": {{\n\"cells\": {{\n{}\n}},\n\"plans\": [\n{}\n]\n}}\n}}",
        lines.join(",\n"),
        plans?.join(",\n")
    ))
}

fn run(path: &Path) -> Result<Vec<Row>, Box<dyn Error>> {
    let image = Image::read(path)?;
    let place = |name: &str| {
        image
            .function(name)
            .ok_or(format!("{}: no {name}", path.display()))
    };
    let (mark, results) = (place("bench_image4mark")?, place("bench_image7RESULTS")?);
    let mut board = Emulator::new(
        Board::FeatherF405,
        &image,
        Constant::default(),
        Start::default(),
    )?;
    let mut counts = Vec::new();
    for row in 0..ROWS {
        let mut at = || -> Result<u64, Box<dyn Error>> {
            if !board.run_to(Until::Address(mark), ROW_NS)? {
                let pc = board.registers()[15];
                return Err(format!("the image stands still in row {row}, at {pc:#010x}").into());
            }
            Ok(board.instructions())
        };
        let from = at()?;
        counts.push(at()? - from);
    }
    board.run_ns(1_000_000)?;
    let mut words = board
        .ram(results)
        .chunks(4)
        .map(|word| word.try_into().map(u32::from_le_bytes).unwrap_or_default());
    let mut row = |instructions| {
        let [status, frequency, sigma] = [(); WORDS].map(|()| words.next().unwrap_or_default());
        Row {
            instructions,
            status,
            frequency: f32::from_bits(frequency),
            sigma: f32::from_bits(sigma),
        }
    };
    Ok(counts.into_iter().map(&mut row).collect())
}

/// Instructions that the flashed image executes during the demo's touch.
struct Flashed {
    /// Instructions per run of the task `fit`, thousands.
    fits: Vec<u64>,
    /// Instructions per run of the task `detect`, one run per frame.
    frames: Vec<u64>,
}

impl Flashed {
    fn over_the_demo(path: &Path) -> Result<Self, Box<dyn Error>> {
        let scene = SlidingScene::new(Sliding::default())?;
        let mut board = Emulator::new(
            Board::FeatherF405,
            &Image::read(path)?,
            scene,
            Start::default(),
        )?;
        let (mut fits, mut frames) = (Vec::new(), Vec::new());
        let mut before = [DETECT_IRQ, FIT_IRQ].map(|irq| board.served(irq));
        while board.now_ns() < 6_000_000_000 {
            board.run_ns(1_000_000)?;
            let now = [DETECT_IRQ, FIT_IRQ].map(|irq| board.served(irq));
            for ((now, before), done) in now.iter().zip(&mut before).zip([&mut frames, &mut fits]) {
                if now.run_cycles > before.run_cycles {
                    done.push(now.instructions - before.instructions);
                    *before = *now;
                }
            }
        }
        fits.iter_mut().for_each(|fit| *fit /= 1000);
        Ok(Self { fits, frames })
    }
}
