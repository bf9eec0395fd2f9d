//! Decides which windows of a slide are to be fitted, and when.

use crate::frame::FrameClock;
use crate::ring::{Ring, reached};
use crate::touch::change::Change;
use crate::window::Window;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::scan::TAXELS;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::Span;
use ridgetone_tone::{FRAMES_MIN, Values};

/// Number of touch-detection frames left out at either end of a whole slide, because the ends are
/// known only to within a few frames.
pub const TRIM_FRAMES: u32 = 5;
/// Number of frames by which a whole slide must be shorter than the ring, at 241 Hz. The ring
/// continues to fill for 20 blocks of 4 frames before a slide's end is noticed, for one more before
/// it is known what follows, and for up to 9 before the end is located. The other 56 frames, 0.23
/// s, are left for the fit to read the oldest frames: it may fit the slide twice.
const LATE_FRAMES: u32 = 176;
/// Minimum number of frames of a growing window, equal to that of the shortest window in the
/// settings.
pub const GROWING_FRAMES_MIN: u32 = 24;
/// Number of rows of the ring at either end of a window from which its rate is measured. An
/// interrupt may be served late, in a storm on DRDY by most of a conversion, which is 0.1 % of a
/// window of 43 ms, so the least delayed of several rows is used.
const DATED_ROWS: u32 = 8;
/// Time reserved for the fit to read the oldest frames while the ring takes in new ones, seconds.
const READING_S: f32 = 0.066;
/// `READING_S` for a fast plan, whose interrupts leave only half of the processor to a fit.
const READING_FAST_S: f32 = 0.3;

/// Maximum number of frames of a window, whole slides included.
pub const fn window_frames_max(plan: &Plan) -> u32 {
    if plan.frames_averaged() > 1 {
        plan.window_frames_max()
    } else {
        plan.ring_frames() - LATE_FRAMES
    }
}

/// Access to the times and values of frames by number.
#[derive(Clone, Copy)]
pub(crate) struct Frames<'a> {
    pub clock: &'a FrameClock,
    pub ring: &'a Ring,
}

/// A run of frames that belongs to one slide.
struct Extent {
    first: u32,
    count: u32,
    slide_first: u32,
    span: Span,
}

#[derive(Clone, Debug)]
pub(crate) struct WindowScheduler {
    /// Code of each taxel in the first complete frame, to which the ring's values are relative.
    pub reference: Values,
    plan: Plan,
    /// Number of frames that touch detection averages into one.
    averaged: u32,
    window_frames_max: u32,
    /// Maximum number of frames that a whole slide may reach back in the ring.
    reach: u32,
    window_frames: u32,
    /// True if windows grow until they are accurate enough.
    growing: bool,
    stride_frames: u32,
    /// True if the stride is short enough for tracks: windows then end at the latest frame.
    tracks: bool,
    /// Frame after the window that falls due next.
    next_end: u32,
    /// First frame and number of frames of a slide that is over and due as a whole.
    pub whole: Option<(u32, u32)>,
    touch_first: u32,
    /// Mean level of the taxels in the latest pressure map of this touch, volts; NaN without one.
    pub level_v: f32,
}

impl WindowScheduler {
    pub const fn new(settings: &Settings) -> Self {
        let mut scheduler = Self {
            reference: [0.0; TAXELS],
            plan: settings.plan,
            averaged: 1,
            window_frames_max: 0,
            reach: 0,
            window_frames: 0,
            growing: false,
            stride_frames: 0,
            tracks: false,
            next_end: 0,
            whole: None,
            touch_first: 0,
            level_v: f32::NAN,
        };
        scheduler.set(settings);
        scheduler
    }

    const fn set(&mut self, settings: &Settings) {
        let plan = &settings.plan;
        self.plan = *plan;
        (self.averaged, self.window_frames_max) = (plan.frames_averaged(), window_frames_max(plan));
        let reading_s = if self.averaged > 1 {
            READING_FAST_S
        } else {
            READING_S
        };
        self.reach = plan.ring_frames().saturating_sub(plan.frames_in(reading_s));
        let (window_frames, stride_frames) = (
            plan.frames_in(settings.window_s),
            plan.frames_in(settings.stride_s),
        );
        let max = self.window_frames_max;
        self.window_frames = if window_frames < max {
            window_frames
        } else {
            max
        };
        self.growing = settings.accuracy > 0.0;
        self.tracks = settings.tracks();
        self.stride_frames = if stride_frames > 0 { stride_frames } else { 1 };
    }

    /// Applies new settings. The windows of the slide that began with the frame `sliding`, if any,
    /// get the new length; none begins before the slide, and none is overdue. `latest` is the
    /// latest frame.
    pub fn change(&mut self, settings: &Settings, sliding: Option<u32>, latest: u32) {
        self.set(settings);
        if let Some(start) = sliding {
            let first = start.wrapping_add(self.first_frames());
            self.next_end = if reached(latest, first) {
                latest.wrapping_add(1)
            } else {
                first
            };
        }
    }

    /// Number of frames of a slide's first window.
    fn first_frames(&self) -> u32 {
        if self.growing {
            GROWING_FRAMES_MIN.min(self.window_frames)
        } else {
            self.window_frames
        }
    }

    /// Follows the start or the end of a slide.
    pub fn follow(&mut self, change: &Change, ring: &Ring) {
        match *change {
            Change::SlideStart(start) => self.next_end = start.wrapping_add(self.first_frames()),
            Change::SlideEnd(start, end) => {
                let trim = TRIM_FRAMES * self.averaged;
                let (first, last) = (start.wrapping_add(trim), end.wrapping_sub(trim));
                if reached(last, first) {
                    let frames = last.wrapping_sub(first);
                    // If the slide is longer than the longest window, take its last part.
                    let max = frames.min(self.window_frames_max);
                    let first = first.wrapping_add(frames - max);
                    // If the end was located late, the ring is about to lose the first frames.
                    let lost = ring.next().wrapping_sub(self.reach);
                    let late = if reached(lost, first) {
                        lost.wrapping_sub(first)
                    } else {
                        0
                    };
                    self.whole = Some((first.wrapping_add(late), max.saturating_sub(late)));
                }
            }
            // A touch whose start was not seen has no contact.
            Change::Contact { frame, .. } | Change::Release(frame) => {
                self.touch_first = frame;
                self.level_v = f32::NAN;
            }
            Change::HoldEnd(_) | Change::Moving(_) => {}
        }
    }

    /// Issues the windows that a slide has filled. The slide began with frame `start` and is known
    /// to have lasted until frame `until`. Windows for tracks end at the latest frame, which may
    /// not belong to the slide.
    pub fn stride(
        &mut self,
        start: u32,
        until: u32,
        frames: Frames<'_>,
        due: &mut dyn FnMut(Window),
    ) {
        let until = if self.tracks {
            frames.clock.latest.0.wrapping_add(1)
        } else {
            until
        };
        let late = until.wrapping_sub(self.next_end);
        let is_latest_alone = self.averaged > 1 || self.tracks;
        if is_latest_alone && reached(until, self.next_end) && late >= self.stride_frames {
            // Windows or strides may be shorter than the time it takes to detect a slide, so
            // several windows may be due: issue only the latest.
            self.next_end = until.wrapping_sub(late % self.stride_frames.max(1));
        }
        while reached(until, self.next_end) {
            let mut count = self.window_frames;
            if self.growing {
                count = count.min(self.next_end.wrapping_sub(start));
            }
            let extent = Extent {
                first: self.next_end.wrapping_sub(count),
                count,
                slide_first: start,
                span: Span::Window,
            };
            self.give(extent, frames, due);
            self.next_end = self.next_end.wrapping_add(self.stride_frames);
        }
    }

    /// Issues a slide that is over as one window.
    pub fn give_whole(&mut self, clock: &FrameClock, ring: &Ring, due: &mut dyn FnMut(Window)) {
        if let Some((first, frames)) = self.whole.take() {
            let extent = Extent {
                first,
                count: frames,
                slide_first: first,
                span: Span::Slide,
            };
            self.give(extent, Frames { clock, ring }, due);
        }
    }

    /// Issues frames of a slide as a window, if there are enough and all are in the ring.
    fn give(&self, extent: Extent, frames: Frames<'_>, due: &mut dyn FnMut(Window)) {
        let Extent {
            first,
            count,
            slide_first,
            span,
        } = extent;
        let Frames { clock, ring } = frames;
        let frames = count;
        if frames < FRAMES_MIN {
            return;
        }
        let last = first.wrapping_add(frames - 1);
        let row = self.plan.frames_a_row() as u32;
        let rows = (frames / (2 * row)).min(DATED_ROWS - 1);
        let behind = last.wrapping_sub(rows * row);
        let (Some(from), Some(until)) = (ring.min_delay(first, rows), ring.min_delay(behind, rows))
        else {
            return;
        };
        let passed_us =
            until.0.wrapping_sub(from.0) as f32 + until.1.wrapping_sub(from.1) as f32 * 1e-3;
        due(Window {
            first,
            frames,
            end_us: clock.time_us(last, ring),
            frame_rate_hz: behind.wrapping_sub(first) as f32 * 1e6 / passed_us.max(1.0),
            reference: self.reference,
            span,
            slide_first,
            touch_first: self.touch_first,
            level_v: self.level_v,
            plan: self.plan,
        });
    }
}
