//! A window: consecutive frames of the ring that are fitted together.

use crate::surface::odometry::Mark;
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
    /// What it covers.
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
    /// What is known of a robot's motion by now.
    pub odometry: Mark,
}

impl Window {
    /// The first frames of a plan at its nominal rate, by time; nothing is known of their touch.
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
            odometry: Mark::NONE,
        }
    }

    /// Follows what is known of a robot's motion. A fit along its path takes longer, and the oldest
    /// frames of a whole slide would be gone before its end: then the latest three quarters of what
    /// the ring holds are fitted.
    pub fn follow(&mut self, motion: Mark) {
        self.odometry = motion;
        if self.span == Span::Slide && motion.is_some() {
            let most = self.plan.window_frames_most() / 4 * 3;
            let early = self.frames.saturating_sub(most);
            self.first = self.first.wrapping_add(early);
            self.frames -= early;
        }
    }
}
