//! The trade of channels against frame rate: a scan plan and a window, with error, latency and
//! load.
//!
//! Every fast plan makes the same conversions a second. The scene is the same for all: a pure tone
//! that each plan can follow, and the converter's own noise at the plan's data rate. So the
//! information of a second is nearly the same, and the rows show what else a choice costs.

mod accuracy;
mod on_board;

use crate::accuracy::{Accuracy, rounded};
use crate::page::{Bar, Table, figure, fixed, percent};
use crate::parallel;
use anyhow::Result;
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Lengths of windows, seconds; a plan has those that it allows, and its longest up to the last of
/// these.
const WINDOWS_S: [f64; 5] = [0.032, 0.064, 0.128, 0.4, 1.0];

/// The first and third piezoresistor of each unit: those along the sliding direction, which feel it
/// most.
const EIGHT: Plan = Ads1258Plan {
    inputs: 0x5555,
    ..Ads1258Plan::HAND
}
.plan();

/// Most time from a window's end to the last byte of its estimate on the line, ms.
const LATE_BAR_MS: f64 = 100.0;
/// Most share of time in which the processor is awake, percent.
const LOAD_BAR_PERCENT: f64 = 90.0;

/// Windows of each tone for a row, for the page.
pub const WINDOWS: u32 = 250;

/// A plan and a window.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Choice {
    plan: Plan,
    window_s: f64,
}

impl Choice {
    /// All of them, from the most channels on.
    fn all() -> Vec<Self> {
        let [
            (_, paper),
            (_, hand),
            (_, texture),
            (_, vibration),
            (_, single),
            ..,
        ] = Plan::NAMED;
        let of = |plan: Plan| {
            let most_s = (f64::from(plan.window_max_s()) * 1e3).round() * 1e-3;
            let least_s = f64::from(plan.window_min_s());
            let [.., last_s] = WINDOWS_S;
            let mut windows_s: Vec<f64> = WINDOWS_S
                .into_iter()
                .filter(|window_s| (least_s..most_s).contains(window_s))
                .collect();
            windows_s.push(most_s.min(last_s));
            windows_s.dedup();
            windows_s
                .into_iter()
                .map(move |window_s| Self { plan, window_s })
        };
        [paper, hand, EIGHT, texture, vibration, single]
            .into_iter()
            .flat_map(of)
            .collect()
    }

    /// The settings of the firmware: up to four harmonics, as by default, and the stride by the rule
    /// of a plan's default window.
    fn settings(self) -> Settings {
        let window_s = self.window_s as f32;
        Settings {
            window_s,
            stride_s: self.plan.default_stride(window_s),
            ..Settings::DEFAULT.with_plan(self.plan)
        }
    }
}

/// What a choice brings and costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the plan, or its inputs in hexadecimal.
    pub plan: String,
    pub channels: usize,
    pub frame_rate_hz: f64,
    pub window_s: f64,
    pub stride_s: f64,
    pub accuracy: Accuracy,
    /// On the register model; none if it was not run.
    pub board: Option<OnBoard>,
}

/// What the register model shows while the finger slides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OnBoard {
    /// Share of time in which the processor is awake.
    pub load: f64,
    /// The longest run of the task `fit`, with all that interrupts it, seconds.
    pub fit_s: f64,
    /// From a window's end to the last byte of its estimate on the line, at most, seconds.
    pub late_s: f64,
}

impl Row {
    /// From the first frame of the window to the last byte of its estimate on the line, at most,
    /// seconds.
    pub fn latency_s(&self) -> Option<f64> {
        self.board.map(|board| self.window_s + board.late_s)
    }
}

/// What must hold on the register model; nothing where it was not run.
pub fn bars(rows: &[Row]) -> Vec<Bar> {
    let most = |figure: fn(&OnBoard) -> f64| {
        let boards = rows.iter().filter_map(|row| row.board.as_ref());
        boards.map(figure).reduce(f64::max)
    };
    let bar = |what: &str, limit, unit, most: Option<f64>| {
        most.map(|most| Bar {
            bar: what.into(),
            limit: format!("at most {limit} {unit}"),
            measured: format!("{:.0} {unit}", most),
            met: most <= limit,
        })
    };
    let late = most(|board| 1e3 * board.late_s);
    let load = most(|board| 1e2 * board.load);
    let bars = [
        bar(
            "a plan's estimate after its window",
            LATE_BAR_MS,
            "ms",
            late,
        ),
        bar(
            "a plan's load while the finger slides",
            LOAD_BAR_PERCENT,
            "%",
            load,
        ),
    ];
    bars.into_iter().flatten().collect()
}

/// Measures each choice, with `windows` windows of each tone; `board` says whether to run the image
/// on the register model too.
pub fn measure(windows: u32, board: bool) -> Result<Vec<Row>> {
    let choices = Choice::all();
    let accuracies = accuracy::measure(&choices, windows)?;
    let boards = match board {
        true => {
            let image = on_board::image()?;
            parallel::map("plans on the register model", &choices, |choice| {
                on_board::measure(&image, *choice).map(Some)
            })?
        }
        false => vec![None; choices.len()],
    };
    let row = |((choice, accuracy), board): ((&Choice, Accuracy), Option<OnBoard>)| Row {
        plan: choice
            .plan
            .name()
            .map_or_else(|| format!("0x{:04x}", choice.plan.inputs), str::to_owned),
        channels: choice.plan.channels(),
        frame_rate_hz: choice.plan.frame_rate_hz().into(),
        window_s: choice.window_s,
        stride_s: rounded(choice.settings().stride_s.into()),
        accuracy,
        board,
    };
    Ok(choices
        .iter()
        .zip(accuracies)
        .zip(boards)
        .map(row)
        .collect())
}

/// The table: by window, then by channels.
pub fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "window, ms|plan|channels|frames a second|RMS, Hz|RMS, %|RMS over bound|not good, %|stride, ms|fit, ms|\
         latency, ms|load, %",
    );
    // A page has room for the plans that have a name.
    let mut rows: Vec<&Row> = rows
        .iter()
        .filter(|row| !row.plan.starts_with("0x"))
        .collect();
    rows.sort_by(|a, b| a.window_s.total_cmp(&b.window_s));
    for row in rows {
        let Accuracy {
            windows,
            good,
            error,
            ..
        } = row.accuracy;
        table.row([
            fixed(1e3 * row.window_s, 0),
            Value::from(format!("`{}`", row.plan)),
            row.channels.into(),
            figure(row.frame_rate_hz, 5),
            figure(error.map(|error| error.rms_hz), 2),
            figure(error.map(|error| error.rms_percent), 2),
            fixed(error.map(|error| error.ratio), 2),
            percent(windows - good, windows),
            fixed(1e3 * row.stride_s, 0),
            fixed(row.board.map(|board| 1e3 * board.fit_s), 1),
            fixed(row.latency_s().map(|latency_s| 1e3 * latency_s), 0),
            fixed(row.board.map(|board| 1e2 * board.load), 1),
        ]);
    }
    table
}

#[cfg(test)]
mod tests;
