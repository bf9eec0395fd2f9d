//! The benchmark's report: for people and as JSON, with the bars beside it.

use super::baselines::BaselineCell;
use super::fits::Cell;
use super::frames::Phase;
use crate::page::{self, Bar, Table, Tables, fixed};
use crate::trade::setups::{LEAN, SCENES_S};
use serde::Serialize;
use serde_json::Value;

/// Most instructions of a window of 0.2, 0.4, 1 and 3.9 s, by the number of the scene.
const FIT_BARS: [(usize, &str, [u64; 4]); 3] = [
    (LEAN, "lean scene", [60_000, 80_000, 130_000, 350_000]),
    (
        1,
        "default scene, one harmonic",
        [300_000, 350_000, 400_000, 850_000],
    ),
    (
        0,
        "default scene, four harmonics",
        [600_000, 800_000, 900_000, 1_600_000],
    ),
];
/// Most instructions of a window of 1 s whose tone is expected, in the default scene.
const TRACKED_BAR: u64 = 70_000;
/// Most instructions of frame assembly, contact and window: of any frame, and on average over a
/// touch.
const FRAME_BARS: (u64, u64) = (20_000, 1_300);
/// Most instructions to read, stamp and queue a conversion.
const INTAKE_BAR: u64 = 300;
/// Most bytes of the board's image, in flash and in its statics.
const FLASH_BAR: u64 = 224 * 1024;
const RAM_BAR: u64 = 112 * 1024;

/// All measurements. Instructions are those of the emulated Cortex-M4F, exact and repeatable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    pub fits: Vec<Cell>,
    /// Four lengths of windows in each of the scenes, scene by scene.
    pub scenes: Vec<Cell>,
    /// The baselines, on the windows of the fits of one harmonic.
    pub baselines: Vec<BaselineCell>,
    pub frames: Vec<Phase>,
    pub encode_instructions: u32,
    pub encode_bytes: u32,
    /// Instructions to read, stamp and queue a conversion.
    pub intake_instructions: u32,
    pub flash_bytes: u64,
    pub ram_bytes: u64,
    /// Stack of the whole firmware over a touch, if it was run.
    pub firmware_stack: Option<Stack>,
    pub bars: Vec<Bar>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Stack {
    pub deepest: u32,
    pub size: u32,
}

impl Stack {
    /// Reads the line that the emulated firmware prints at its end; none of any other line.
    pub fn parse(line: &str) -> Option<Self> {
        let (deepest, size) = line.trim().strip_prefix("stack: ")?.split_once(" of ")?;
        Some(Self {
            deepest: deepest.parse().ok()?,
            size: size.split_once(' ')?.0.parse().ok()?,
        })
    }
}

impl Report {
    /// The bars of fits, for the page about scenes.
    pub fn fit_bars(&self) -> Vec<Bar> {
        let mut all = Vec::new();
        let windows = |scene: usize| {
            let cells = self.scenes.chunks_exact(SCENES_S.len());
            cells.skip(scene).flatten().take(SCENES_S.len())
        };
        for (scene, what, limits) in FIT_BARS {
            let bars = windows(scene).zip(limits).map(|(cell, limit)| {
                let what = format!("{what}, {} s: instructions of a window", cell.window_s);
                Bar::at_most(&what, limit, cell.instructions_worst.into())
            });
            all.extend(bars);
        }
        let tracked = windows(0).filter(|cell| cell.window_s == 1.0).map(|cell| {
            let what = "default scene, 1 s, after a good window: instructions";
            Bar::at_most(what, TRACKED_BAR, cell.tracked_worst.into())
        });
        all.extend(tracked);
        all
    }
}

impl Report {
    pub fn with_bars(mut self) -> Self {
        let worst = self
            .frames
            .iter()
            .map(|phase| phase.instructions_worst)
            .max()
            .unwrap_or(0);
        let mean = self
            .frames
            .iter()
            .find(|phase| phase.name == "all")
            .map_or(0.0, |phase| phase.instructions_mean);
        self.bars.extend([
            Bar::at_most(
                "frames, contact and window, a frame at most",
                FRAME_BARS.0,
                worst.into(),
            ),
            Bar::at_most(
                "the same on average over a touch",
                FRAME_BARS.1,
                mean.round() as u64,
            ),
            Bar::at_most(
                "a conversion from interrupt to queue",
                INTAKE_BAR,
                self.intake_instructions.into(),
            ),
            Bar::at_most(
                "flash of the Feather's image, bytes",
                FLASH_BAR,
                self.flash_bytes,
            ),
            Bar::at_most(
                "static RAM of the Feather's image, bytes",
                RAM_BAR,
                self.ram_bytes,
            ),
        ]);
        self
    }
}

impl Report {
    /// The counts for a terminal.
    pub fn tables(&self) -> Tables {
        let mut fits = Table::new(
            "window, s|channels|harmonics there|set|good|windows|worst|passes|stack, bytes",
        );
        for cell in &self.fits {
            fits.row([
                Value::from(cell.window_s),
                cell.channels.into(),
                cell.carried.into(),
                cell.harmonics.into(),
                cell.good.into(),
                cell.windows.into(),
                cell.instructions_worst.into(),
                fixed(cell.passes_worst, 1),
                cell.stack_bytes.into(),
            ]);
        }
        let mut baselines =
            Table::new("method|window, s|channels|harmonics there|found|windows|worst");
        for cell in &self.baselines {
            baselines.row([
                Value::from(cell.method),
                cell.window_s.into(),
                cell.channels.into(),
                cell.carried.into(),
                cell.found.into(),
                cell.windows.into(),
                cell.instructions_worst.into(),
            ]);
        }
        let mut frames = Table::new("phase|frames|mean|worst");
        for phase in &self.frames {
            frames.row([
                Value::from(phase.name),
                phase.frames.into(),
                fixed(phase.instructions_mean, 0),
                phase.instructions_worst.into(),
            ]);
        }
        let mut others = Table::new("what|count");
        others.row(["longest packet, bytes".into(), self.encode_bytes.into()]);
        others.row([
            "its encoding, instructions".into(),
            self.encode_instructions.into(),
        ]);
        if let Some(Stack { deepest, size }) = self.firmware_stack {
            others.row(["stack over a touch, bytes".into(), deepest.into()]);
            others.row(["stack, bytes".into(), size.into()]);
        }
        let names = ["fits", "baselines", "frames", "others", "bars"];
        let tables = [fits, baselines, frames, others, page::bars(&self.bars)];
        names.map(str::to_owned).into_iter().zip(tables).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_met_up_to_its_limit_and_shown_when_it_is_not() {
        let cell = |window_s, instructions_worst| Cell {
            window_s,
            frames: 241,
            channels: 16,
            harmonics: 4,
            carried: 4,
            windows: 10,
            good: 9,
            instructions_mean: 1.0,
            instructions_worst,
            tracked_worst: 70_001,
            passes_worst: 1.0,
            stack_bytes: 5,
        };
        let windows = [600_000, 800_001, 900_000, 1_600_000];
        let scene = SCENES_S.into_iter().zip(windows);
        let frame = Phase {
            name: "all",
            frames: 1,
            instructions_mean: 1300.6,
            instructions_worst: 20_000,
        };
        let baseline = BaselineCell {
            method: "periodogram",
            window_s: 1.0,
            frames: 241,
            carried: 1,
            channels: 2,
            windows: 3,
            found: 2,
            instructions_mean: 1.0,
            instructions_worst: 1_234,
        };
        let report = Report {
            fits: Vec::new(),
            scenes: scene.map(|(s, count)| cell(s, count)).collect(),
            baselines: vec![baseline],
            frames: vec![frame],
            encode_instructions: 1,
            encode_bytes: 2,
            intake_instructions: 301,
            flash_bytes: FLASH_BAR,
            ram_bytes: RAM_BAR + 1,
            firmware_stack: Stack::parse("stack: 5678 of 32768 bytes used at most"),
            bars: Vec::new(),
        };
        let report = report.with_bars();
        let met: Vec<bool> = report.fit_bars().iter().map(|bar| bar.met).collect();
        assert_eq!(met[met.len() - 5..], [true, false, true, true, false]);
        let met: Vec<bool> = report.bars.iter().map(|bar| bar.met).collect();
        assert_eq!(met, [true, false, false, true, false]);
        let not_met = report.tables()["bars"]
            .rows
            .iter()
            .filter(|row| row[3] == false)
            .count();
        assert_eq!(not_met, 3);
        assert_eq!(
            report.firmware_stack,
            Some(Stack {
                deepest: 5678,
                size: 32_768
            })
        );
    }
}
