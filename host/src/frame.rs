//! A raw frame in volts.

use crate::digits::seconds;
use ads1258::reading;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::Raw;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Device time of the frame's first slot, seconds.
    pub t_s: f64,
    /// Number of the frame since start-up, lost frames included.
    pub number: u32,
    /// Voltage of each taxel; `None` where it is missing or doubtful.
    pub volts: [Option<f32>; TAXELS],
}

impl Frame {
    /// Converts a raw frame to volts, with a reference of `vref_v` volts.
    pub fn new(raw: &Raw, vref_v: f32) -> Self {
        let usable = raw.present & raw.good;
        let volts = |taxel: usize| {
            (usable >> taxel & 1 != 0).then(|| reading::volts(raw.codes[taxel], vref_v))
        };
        Self {
            t_s: seconds(raw.t_us),
            number: raw.number,
            volts: std::array::from_fn(volts),
        }
    }
}
