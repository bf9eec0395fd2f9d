//! Phases of a touch.

use crate::touch::slide::{Moving, Sliding};

/// Phase of a touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// The idle level is learned: number of blocks so far.
    Learning(u32),
    Idle,
    /// The skin creeps back to where it was before the latest touch: the next block's mean is the
    /// idle level.
    CreepingBack,
    /// Touched since the block that ends with this frame; the spike's peak is looked for.
    Spike(u32),
    Hold,
    /// Something moves, a slide or only a step.
    Moving(Moving),
    /// The motion is a slide. Its start is looked for with the next frame: in this one the hold's
    /// pressure map is reported.
    Starting(Moving),
    Slide(Sliding),
    /// A slide by [`SlideRule::Always`]: nothing is looked for.
    ///
    /// [`SlideRule::Always`]: ridgetone_proto::settings::SlideRule::Always
    Always(Sliding),
}

/// Phase that ended when the levels became still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ended {
    Spike,
    /// A hold: the levels are back at idle.
    Hold,
    Slide(Sliding),
}
