//! A window: consecutive frames of the ring that are fitted together.

use ridgetone_proto::plan::Plan;
use ridgetone_proto::telemetry::Span;
use ridgetone_tone::{CHANNELS_MAX, Values};

/// Frames to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Number of the first frame.
    pub first: u32,
    /// Number of frames.
    pub frames: u32,
    /// Device time of the window's end, microseconds.
    pub end_us: u64,
    /// Frames per second by the board's clock, measured over the window.
    pub frame_rate_hz: f32,
    /// Code of each taxel to which the frames' values are relative. Whole numbers, so exact in f32.
    pub reference: Values,
    /// Span of the window.
    pub span: Span,
    /// Number of the first frame of the slide.
    pub slide_first: u32,
    /// Number of the first frame of the touch.
    pub touch_first: u32,
    /// Mean level of the taxels in the pressure map of the hold before the slide, volts; NaN
    /// without a hold.
    pub level_v: f32,
    /// Plan of the frames.
    pub plan: Plan,
}

impl Window {
    /// Creates a window of a plan's first frames, at its nominal rate and without a known touch.
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
