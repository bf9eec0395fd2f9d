//! The latest raw frames, for strips of the channels.

use super::bounded::Bounded;
use crate::digits::seconds;
use ads1258::reading;
use ridgetone_proto::settings::TAXELS;
use ridgetone_proto::telemetry::Raw;
use serde::{Serialize, Serializer};

/// Frames kept: four seconds at 241.14 frames a second.
pub const STRIP_FRAMES: usize = 965;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Device time of its first slot, seconds.
    pub t_s: f64,
    /// Its number since start-up, lost frames included.
    pub number: u32,
    /// Voltage of each taxel; none where it is missing or doubtful.
    pub volts: [Option<f32>; TAXELS],
}

impl Frame {
    /// A raw frame in volts, against a reference of `vref_v` volts.
    pub fn new(raw: &Raw, vref_v: f32) -> Self {
        let usable = raw.present & raw.good;
        let volts = |taxel: usize| (usable >> taxel & 1 != 0).then(|| reading::volts(raw.codes[taxel], vref_v));
        Self { t_s: seconds(raw.t_us), number: raw.number, volts: std::array::from_fn(volts) }
    }
}

/// The latest frames. Serialised by [`columns`].
pub type Strips = Bounded<Frame, STRIP_FRAMES>;

/// Serialises frames by columns: `t_s`, `number`, and a list of `volts` per taxel.
pub fn columns<S: Serializer>(strips: &Strips, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Columns {
        t_s: Vec<f64>,
        number: Vec<u32>,
        volts: Vec<Vec<Option<f32>>>,
    }
    let frames = || strips.iter();
    Columns {
        t_s: frames().map(|frame| frame.t_s).collect(),
        number: frames().map(|frame| frame.number).collect(),
        volts: (0..TAXELS).map(|taxel| frames().map(|frame| frame.volts[taxel]).collect()).collect(),
    }
    .serialize(serializer)
}
