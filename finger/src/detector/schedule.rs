//! What changed, as events in device time, and the windows that fall due with it.

use crate::frame::{CONVERSION_NS, SLOTS};
use crate::pipeline::GROWING_FRAMES_MIN;
use crate::ring::{Ring, reached};
use crate::touch::contact::Change;
use crate::window::Window;
use ads1258::reading;
use ridgetone_proto::settings::{FRAME_RATE_HZ, RING_FRAMES, Settings, TAXELS};
use ridgetone_proto::telemetry::{Contact, Event, Release, Slide, Span};
use ridgetone_tone::{FRAMES_MIN, Values};

/// Frames left out at either end of a whole slide: its ends are known to within a few frames.
pub const TRIM_FRAMES: u32 = 5;
/// Most frames of a window. Until a slide's end is noticed the ring goes on for 20 blocks of 4 frames, for one more
/// until it is known what came after, and for up to 9 until it is dated; 40 frames more, 0.17 s, are left for the fit to
/// read the oldest of them.
pub const WINDOW_FRAMES_MAX: u32 = RING_FRAMES as u32 - 160;

/// Frames that the ring may take in before the fit has read its oldest, 66 ms.
const READING_FRAMES: u32 = 16;

/// Knows when frames were and which windows are wanted.
#[derive(Clone, Debug)]
pub(super) struct WindowScheduler {
    pub volts_per_code: f32,
    /// Code of every taxel in the first complete frame: what the ring's values are relative to.
    pub reference: Values,
    window_frames: u32,
    /// Whether windows grow until they are accurate enough.
    growing: bool,
    hop_frames: u32,
    /// Frame behind the window that falls due next.
    next_end: u32,
    /// When the latest slide began, as it was told: by its end the ring may not hold its start any more.
    slide_start_us: u64,
    /// A slide that is over and falls due as a whole: first frame, frames.
    whole: Option<(u32, u32)>,
    /// Frame and time from which the rate is measured, once there is one.
    rate_from: Option<(u32, u64)>,
    /// The latest frame and its time.
    pub latest: (u32, u64),
}

/// Frames in a stretch of time, at least one and at most `most`.
const fn frames_in(seconds: f32, most: u32) -> u32 {
    let frames = (seconds * FRAME_RATE_HZ + 0.5) as u32;
    if frames > most {
        most
    } else if frames < 1 {
        1
    } else {
        frames
    }
}

impl WindowScheduler {
    pub const fn new(settings: &Settings) -> Self {
        Self {
            volts_per_code: reading::volts(1, settings.vref_v),
            reference: [0.0; TAXELS],
            window_frames: frames_in(settings.window_s, WINDOW_FRAMES_MAX),
            growing: settings.accuracy > 0.0,
            hop_frames: frames_in(settings.hop_s, u32::MAX),
            next_end: 0,
            slide_start_us: 0,
            whole: None,
            rate_from: None,
            latest: (0, 0),
        }
    }

    /// From now on these settings are in force, and the windows of a slide that lasts since the frame `sliding` are of
    /// their length.
    pub fn change(&mut self, settings: &Settings, sliding: Option<u32>) {
        self.volts_per_code = reading::volts(1, settings.vref_v);
        self.window_frames = frames_in(settings.window_s, WINDOW_FRAMES_MAX);
        self.growing = settings.accuracy > 0.0;
        self.hop_frames = frames_in(settings.hop_s, u32::MAX);
        if let Some(start) = sliding {
            // None reaches back before the slide, or is late.
            let first = start.wrapping_add(self.first_frames());
            self.next_end = if reached(self.latest.0, first) { self.latest.0.wrapping_add(1) } else { first };
        }
    }

    /// Frames of a slide's first window.
    fn first_frames(&self) -> u32 {
        if self.growing { GROWING_FRAMES_MIN.min(self.window_frames) } else { self.window_frames }
    }

    /// Nothing is due any more.
    pub fn drop_due(&mut self) {
        self.whole = None;
    }

    /// The latest frame is the first complete one, with these codes.
    pub fn begin(&mut self, codes: &[i32; TAXELS]) {
        self.reference = codes.map(|code| code as f32);
        self.rate_from = Some(self.latest);
    }

    /// Frames per second by the board's clock; zero until there are two.
    pub fn frame_rate_hz(&self) -> f32 {
        match self.rate_from {
            Some((frame, t_us)) if self.latest.1 > t_us => {
                /// So many frames are 206 days: then their numbers wrap.
                const WRAP_FRAMES: f32 = 4_294_967_296.0;
                let passed_us = (self.latest.1 - t_us) as f32;
                let beyond_wraps = self.latest.0.wrapping_sub(frame) as f32;
                // The time says how often they have wrapped; the nominal rate is good enough for that.
                let nominal = passed_us * (FRAME_RATE_HZ * 1e-6);
                let wraps = ((nominal - beyond_wraps) / WRAP_FRAMES + 0.5) as u32 as f32;
                (beyond_wraps + wraps * WRAP_FRAMES) * 1e6 / passed_us
            }
            _ => 0.0,
        }
    }

    /// Gives the windows that a slide from frame `start` on has filled `until` now.
    pub fn hop(&mut self, start: u32, until: u32, ring: &Ring, due: &mut dyn FnMut(Window)) {
        while reached(until, self.next_end) {
            let mut frames = self.window_frames;
            if self.growing {
                frames = frames.min(self.next_end.wrapping_sub(start));
            }
            self.window(self.next_end.wrapping_sub(frames), frames, Span::Window, ring, due);
            self.next_end = self.next_end.wrapping_add(self.hop_frames);
        }
    }

    /// Gives the slide that is over, as a whole: with the frame after its end was told.
    pub fn give_whole(&mut self, ring: &Ring, due: &mut dyn FnMut(Window)) {
        if let Some((first, frames)) = self.whole {
            self.whole = None;
            self.window(first, frames, Span::Slide, ring, due);
        }
    }

    /// Tells what changed.
    #[inline(never)]
    pub fn tell(&mut self, change: Change, ring: &Ring, emit: &mut dyn FnMut(Event)) {
        match change {
            Change::Contact { frame, taxel, height } => emit(Event::Contact(Contact {
                t_us: self.time_us(frame, ring),
                taxel,
                height_v: height * self.volts_per_code,
            })),
            Change::SlideStart(start) => {
                self.next_end = start.wrapping_add(self.first_frames());
                self.slide_start_us = self.time_us(start, ring);
                emit(Event::Slide(Slide { start_us: self.slide_start_us, end_us: None }));
            }
            Change::SlideEnd(start, end) => {
                let end_us = Some(self.time_us(end, ring));
                emit(Event::Slide(Slide { start_us: self.slide_start_us, end_us }));
                let first = start.wrapping_add(TRIM_FRAMES);
                let last = end.wrapping_sub(TRIM_FRAMES);
                if reached(last, first) {
                    let frames = last.wrapping_sub(first);
                    // The latest part of a slide that is longer than a window can be.
                    let most = frames.min(WINDOW_FRAMES_MAX);
                    let first = first.wrapping_add(frames - most);
                    // An end that took long to be dated: the ring is about to lose what comes first.
                    let lost = ring.next().wrapping_sub(RING_FRAMES as u32 - READING_FRAMES);
                    let late = if reached(lost, first) { lost.wrapping_sub(first) } else { 0 };
                    self.whole = Some((first.wrapping_add(late), most.saturating_sub(late)));
                }
            }
            Change::Release(frame) => emit(Event::Release(Release { t_us: self.time_us(frame, ring) })),
        }
    }

    /// Device time of a frame's first slot. Frames that the ring does not hold are reckoned at the
    /// nominal rate.
    #[inline(never)]
    pub fn time_us(&self, frame: u32, ring: &Ring) -> u64 {
        let (number, t_us) = self.latest;
        match ring.t_us(frame) {
            Some(low) => t_us.wrapping_sub((t_us as u32).wrapping_sub(low) as u64),
            None => {
                const FRAME_NS: u32 = CONVERSION_NS as u32 * SLOTS;
                let back = number.wrapping_sub(frame) as i32;
                let frames = back.unsigned_abs();
                // In two parts that 32 bits hold: a division of 64 bits is a kilobyte of code here.
                let away_us = (frames / 1000) as u64 * FRAME_NS as u64 + (frames % 1000 * FRAME_NS / 1000) as u64;
                if back < 0 { t_us.wrapping_add(away_us) } else { t_us.saturating_sub(away_us) }
            }
        }
    }

    /// Gives a window, if it is long enough and in the ring.
    #[inline(never)]
    fn window(&self, first: u32, frames: u32, span: Span, ring: &Ring, due: &mut dyn FnMut(Window)) {
        if frames < FRAMES_MIN {
            return;
        }
        let last = first.wrapping_add(frames - 1);
        let (Some(first_us), Some(last_us)) = (ring.t_us(first), ring.t_us(last)) else { return };
        due(Window {
            first,
            frames,
            end_us: self.time_us(last, ring),
            frame_rate_hz: (frames - 1) as f32 * 1e6 / last_us.wrapping_sub(first_us).max(1) as f32,
            reference: self.reference,
            span,
        });
    }
}
