//! The benchmark's table: for people and as JSON, with the bars beside it.

use super::{BaselineCell, Cell, Phase, baselines};
use serde::Serialize;
use std::fmt;

/// Harmonics and most instructions of a fit of 16 channels and 241 frames.
const FIT_BARS: [(u8, &str, u64); 2] =
    [(1, "fit, 16 channels x 241 frames, one harmonic", 150_000), (4, "fit, the same with three overtones", 350_000)];
/// Most instructions of frame assembly, contact and window for one frame.
const FRAME_BAR: u64 = 1_500;
/// Most instructions to read, stamp and queue a conversion.
const INTAKE_BAR: u64 = 300;
/// Most bytes of the board's image, in flash and in its statics each: 96 KiB.
const IMAGE_BAR: u64 = 96 * 1024;

/// A limit and what was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bar {
    /// Of what.
    pub what: &'static str,
    /// Most that is allowed.
    pub limit: u64,
    /// What it is.
    pub measured: u64,
    /// Whether it is kept.
    pub met: bool,
}

impl Bar {
    fn new(what: &'static str, limit: u64, measured: u64) -> Self {
        Self { what, limit, measured, met: measured <= limit }
    }
}

/// All that was measured. Instructions are those of the emulated Cortex-M4F, exact and repeatable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Fits.
    pub fits: Vec<Cell>,
    /// What one would otherwise pick, on the windows of the fits of one harmonic.
    pub baselines: Vec<BaselineCell>,
    /// Frames.
    pub frames: Vec<Phase>,
    /// Instructions to encode the longest packet.
    pub encode_instructions: u32,
    /// Its bytes on the wire.
    pub encode_bytes: u32,
    /// Instructions to read, stamp and queue a conversion.
    pub intake_instructions: u32,
    /// Flash that the Feather's image takes, bytes.
    pub flash_bytes: u64,
    /// RAM that its statics take, bytes.
    pub ram_bytes: u64,
    /// Most stack that a fit took, bytes.
    pub stack_bytes: u32,
    /// Stack of the whole firmware over a touch, if it was run.
    pub firmware_stack: Option<Stack>,
    /// The bars.
    pub bars: Vec<Bar>,
}

/// Use of a stack, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Stack {
    /// The most in use.
    pub deepest: u32,
    /// What there is.
    pub size: u32,
}

impl Stack {
    /// Reads what the emulated firmware says when it leaves; none of any other line.
    pub fn parse(line: &str) -> Option<Self> {
        let (deepest, size) = line.trim().strip_prefix("stack: ")?.split_once(" of ")?;
        Some(Self { deepest: deepest.parse().ok()?, size: size.split_once(' ')?.0.parse().ok()? })
    }
}

impl Report {
    /// Puts it together. `encode` is instructions and bytes of the longest packet, `intake_instructions` those of a
    /// conversion, the last flash and RAM of the Feather's image, bytes.
    pub fn new(
        fits: Vec<Cell>,
        baselines: Vec<BaselineCell>,
        frames: Vec<Phase>,
        encode: (u32, u32),
        intake_instructions: u32,
        firmware_stack: Option<Stack>,
        (flash_bytes, ram_bytes): (u64, u64),
    ) -> Self {
        let mut bars = Vec::new();
        for (harmonics, what, limit) in FIT_BARS {
            let cells = fits
                .iter()
                .filter(|c| (c.channels, c.frames, c.harmonics, c.carried) == (16, 241, harmonics, harmonics));
            bars.extend(cells.map(|cell| Bar::new(what, limit, u64::from(cell.instructions_worst))));
        }
        let frame = frames.iter().map(|phase| phase.instructions_worst).max().unwrap_or(0);
        bars.push(Bar::new("frames, contact and window, a frame at most", FRAME_BAR, u64::from(frame)));
        bars.push(Bar::new("a conversion from interrupt to queue", INTAKE_BAR, u64::from(intake_instructions)));
        bars.push(Bar::new("flash of the Feather's image, bytes", IMAGE_BAR, flash_bytes));
        bars.push(Bar::new("static RAM of the Feather's image, bytes", IMAGE_BAR, ram_bytes));
        let stack_bytes = fits.iter().map(|cell| cell.stack_bytes).max().unwrap_or(0);
        let (encode_instructions, encode_bytes) = encode;
        Self {
            fits,
            baselines,
            frames,
            encode_instructions,
            encode_bytes,
            intake_instructions,
            flash_bytes,
            ram_bytes,
            stack_bytes,
            firmware_stack,
            bars,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Instructions on the emulated Cortex-M4F, exact. In brackets: passes of 14,300 each.\n")?;
        writeln!(f, "A fit, the costliest window of the paper's Table 2 with a cycle in it, 20 dB, by harmonics:")?;
        write!(f, "{:>8} {:>7} {:>9}", "window s", "frames", "channels")?;
        for harmonics in 1..=4 {
            write!(f, " {harmonics:>17}")?;
        }
        writeln!(f)?;
        let as_carried: Vec<&Cell> = self.fits.iter().filter(|cell| cell.carried == cell.harmonics).collect();
        for row in as_carried.chunk_by(|a, b| (a.frames, a.channels) == (b.frames, b.channels)) {
            let Some(Cell { window_s, frames, channels, .. }) = row.first() else { continue };
            write!(f, "{window_s:>8} {frames:>7} {channels:>9}")?;
            for cell in row {
                let passes = format!("({:.1})", cell.passes_worst);
                write!(f, " {:>9} {passes:>7}", grouped(cell.instructions_worst.into()))?;
            }
            writeln!(f)?;
        }
        let (windows, good) = self.fits.iter().fold((0, 0), |(w, g), cell| (w + cell.windows, g + cell.good));
        writeln!(f, "The tone was found in {good} of {windows} windows. Stack: {} bytes at most.\n", self.stack_bytes)?;

        baselines::write(&self.baselines, &self.fits, f)?;

        writeln!(f, "Frame assembly, contact and window, a frame (21 conversions):")?;
        writeln!(f, "{:>8} {:>7} {:>9} {:>9}", "phase", "frames", "mean", "worst")?;
        for Phase { name, frames, instructions_mean, instructions_worst } in &self.frames {
            let (mean, worst) = (grouped(instructions_mean.round() as u64), grouped((*instructions_worst).into()));
            writeln!(f, "{name:>8} {frames:>7} {mean:>9} {worst:>9}")?;
        }
        let (encode, bytes) = (grouped(self.encode_instructions.into()), self.encode_bytes);
        writeln!(f, "\nThe longest packet, {bytes} bytes, encoded: {encode}")?;
        writeln!(f, "A conversion read, stamped and queued: {}", self.intake_instructions)?;
        if let Some(Stack { deepest, size }) = self.firmware_stack {
            let (deepest, size) = (grouped(deepest.into()), grouped(size.into()));
            writeln!(f, "The whole firmware's stack over a touch: {deepest} of {size} bytes at most")?;
        }
        writeln!(f)?;

        writeln!(f, "{:<45} {:>9} {:>9}", "bar", "limit", "measured")?;
        for Bar { what, limit, measured, met } in &self.bars {
            let verdict = if *met { "met" } else { "NOT MET" };
            writeln!(f, "{what:<45} {:>9} {:>9} {verdict}", grouped(*limit), grouped(*measured))?;
        }
        Ok(())
    }
}

/// 1234567 as 1,234,567.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
    }

    #[test]
    fn a_bar_is_met_up_to_its_limit_and_shown_when_it_is_not() {
        let cell = |harmonics, instructions_worst| Cell {
            window_s: 1.0,
            frames: 241,
            channels: 16,
            harmonics,
            carried: harmonics,
            windows: 10,
            good: 9,
            instructions_mean: 1.0,
            instructions_worst,
            passes_worst: 1.0,
            stack_bytes: 5,
        };
        let frame = Phase { name: "all", frames: 1, instructions_mean: 1.0, instructions_worst: 1500 };
        let fits = vec![cell(1, 150_001), cell(4, 350_000)];
        let baselines = vec![BaselineCell {
            method: "parabolic",
            window_s: 1.0,
            frames: 241,
            carried: 1,
            channels: 2,
            windows: 3,
            found: 2,
            instructions_mean: 1.0,
            instructions_worst: 1_234,
        }];
        let stack = Stack::parse("stack: 5678 of 32768 bytes used at most");
        let report = Report::new(fits, baselines, vec![frame], (1, 2), 301, stack, (IMAGE_BAR, IMAGE_BAR + 1));
        assert_eq!(report.bars.iter().map(|bar| bar.met).collect::<Vec<_>>(), [false, true, true, false, true, false]);
        let text = report.to_string();
        assert_eq!(text.matches("NOT MET").count(), 3);
        for part in ["150,001 NOT MET", "18 of 20 windows", "1,234", "2 of 3 windows", "5,678 of 32,768"] {
            assert!(text.contains(part), "{part} in {text}");
        }
    }
}
