//! What the emulator runs, and how.

use hal_mock::bridge::Crash;
use ridgetone_proto::settings::Settings;
use std::path::Path;
use std::time::Duration;

/// 8 ns an instruction: 125 MIPS, about what the STM32F405 does at 168 MHz.
const ICOUNT_SHIFT: u8 = 3;

/// What to run, and how long to wait for it.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    pub elf: &'a Path,
    /// Wall time without a sign of life after which the emulator is given up.
    pub silence: Duration,
    /// Whether to fill [`Outcome::conversions`](super::Outcome::conversions).
    pub keep_conversions: bool,
    /// Whether to fill [`Outcome::serial`](super::Outcome::serial).
    pub keep_serial: bool,
    /// What happens to the board, and at which board time, microseconds.
    pub crash: Option<(u64, Crash)>,
    /// An instruction takes two to the power of this nanoseconds: 3 is 125 million a second.
    pub icount_shift: u8,
    /// When the telemetry line is blocked, from and until, seconds of scene time.
    pub line_blocked_s: Option<(f64, f64)>,
    /// Settings of the firmware: [`run`](super::run) sends others than its own after the greeting.
    pub settings: Settings,
    /// Takes each line of the firmware's log: board time in seconds, level, text.
    pub log: Option<fn(&str)>,
}

impl<'a> Options<'a> {
    /// Default options: at most half a minute of silence, no bytes kept, no crash, and the usual
    /// speed of the board.
    pub fn new(elf: &'a Path) -> Self {
        Self {
            elf,
            silence: Duration::from_secs(30),
            keep_conversions: false,
            keep_serial: false,
            crash: None,
            icount_shift: ICOUNT_SHIFT,
            line_blocked_s: None,
            settings: Settings::DEFAULT,
            log: None,
        }
    }
}
