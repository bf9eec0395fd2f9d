//! A window: consecutive frames of the ring that are fitted together.

use ridgetone_proto::plan::Plan;
use ridgetone_proto::telemetry::Span;
use ridgetone_tone::{CHANNELS_MAX, Values};

/// Frames to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Number of its first frame.
    pub first: u32,
    /// Frames in it.
    pub frames: u32,
    /// Device time of its end, microseconds.
    pub end_us: u64,
    /// Frames per second by the board's clock, measured over the window.
    pub frame_rate_hz: f32,
    /// The code of every taxel that the frames' values are relative to: whole numbers, exact in
    /// f32.
    pub reference: Values,
    /// Span of the window.
    pub span: Span,
    /// Number of the first frame of its slide.
    pub slide_first: u32,
    /// Number of the first frame of its touch.
    pub touch_first: u32,
    /// Mean level of the taxels by the static image of the hold before the slide, volts; NaN
    /// without one.
    pub level_v: f32,
    /// The plan of its frames.
    pub plan: Plan,
}

impl Window {
    /// The first frames of a plan at its nominal rate; nothing is known of their touch.
    pub const fn new(plan: Plan, frames: u32) -> Self {
        Self {
            first: 0,
            frames,
            end_us: 0,
            frame_rate_hz: plan.frame_rate_hz(),
            reference: [0.0; CHANNELS_MAX],
            span: Span::Window,
            slide_first: 0,
            touch_first: 0,
            level_v: f32::NAN,
            plan,
        }
    }
}
