//! The latest raw frames, for strips of the channels.

use super::bounded::Bounded;
use crate::frame::Frame;
use ridgetone_proto::settings::TAXELS;
use serde::{Serialize, Serializer};

/// Frames kept: four seconds at 241.14 frames a second.
pub const STRIP_FRAMES: usize = 965;

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
        volts: (0..TAXELS)
            .map(|taxel| frames().map(|frame| frame.volts[taxel]).collect())
            .collect(),
    }
    .serialize(serializer)
}
