//! What a run of the emulator gives, and how one talks to it meanwhile.

use crate::live::Counts;
use anyhow::Result;
use ridgetone_finger::TimedConversion;
use std::time::Duration;

#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Every byte of the telemetry line, if `Options::keep_serial`.
    pub serial: Vec<u8>,
    /// Messages of the firmware and of the emulator, line by line.
    pub messages: String,
    pub counts: Counts,
    pub conversions_served: u64,
    pub chip: hal_mock::Counters,
    /// Conversions that the board has read twice, or that are the last, and of which at least one
    /// read arrived as converted.
    pub arrived: u64,
    /// Conversions that the board read a single time, so that nothing confirms them: the next one
    /// was ready before.
    pub read_once: u64,
    /// When each injected fault acted, nanoseconds of board time.
    pub injected: Vec<hal_mock::Injected>,
    pub registers: [u8; hal_mock::chip::REGISTERS],
    /// Those read, with the board's time of their DRDY edge, if `Options::keep_conversions`.
    pub conversions: Vec<TimedConversion>,
    /// Board time at which START first rose, microseconds: zero of the scene's time.
    pub start_us: u64,
    /// Board time of the first DRDY edge, microseconds: zero of the device time.
    pub first_edge_us: u64,
    /// Board time at the end, microseconds.
    pub end_us: u64,
}

/// The PC's end of the line: takes the board's time and the received bytes, and gives the bytes to
/// send.
pub type Exchange<'a> = dyn FnMut(Duration, &[u8]) -> Result<Vec<u8>> + 'a;
