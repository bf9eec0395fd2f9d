//! The first half of the pipeline: conversions in, events and due windows out.

use crate::contact::{Change, ContactDetector};
use crate::frame::{Assembler, CONVERSION_NS, Frame, TimedConversion};
use crate::settings::{FRAME_RATE_HZ, RING_FRAMES, Settings, TAXELS};
use crate::sine_fit::FRAMES_MIN;
use crate::telemetry::{Contact, Event, Health, Hello, PROTOCOL, Release, Slide, Span};
use crate::window::{Ring, Values, Window, reached};
use ads1258::reading;

/// Frames from one `health` to the next: one second.
const HEALTH_FRAMES: u32 = FRAME_RATE_HZ as u32;
/// The greeting is repeated after so many healths: who listens in later learns the protocol and the
/// settings too.
const GREETING_HEALTHS: u8 = 10;
/// Frames left out at either end of a whole slide: its ends are known to within a few frames.
pub const TRIM_FRAMES: u32 = 5;
/// Most frames of a window. Until a slide's end is noticed the ring goes on for 20 blocks of 4
/// frames; 80 more, a third of a second, are left for the fit to read the oldest of them.
pub const WINDOW_FRAMES_MAX: u32 = RING_FRAMES as u32 - 160;

/// What the caller counts and the detector reports in `health`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counters {
    /// Conversions lost between interrupt and queue.
    pub overruns: u32,
    /// Windows not fitted because the fit was busy.
    pub hops_skipped: u32,
    /// Messages dropped because the line was slow.
    pub messages_dropped: u32,
    /// Times the ADC was set up anew because its registers were not what they should be.
    pub chip_restarts: u32,
    /// Processor load, 0 to 1.
    pub load: f32,
}

/// Frames, contact and windows: the middle task.
#[derive(Clone, Debug)]
pub struct Detector {
    settings: Settings,
    assembler: Assembler,
    rest: Rest,
}

/// The detector but for its assembler, which calls it back with every frame.
#[derive(Clone, Debug)]
struct Rest {
    volts_per_code: f32,
    contact: ContactDetector,
    /// Code of every taxel in the first complete frame: what the ring's values are relative to.
    reference: Option<[i32; TAXELS]>,
    /// The latest values that could be trusted.
    values: Values,
    window_frames: u32,
    hop_frames: u32,
    /// Frame behind the window that falls due next.
    next_end: u32,
    health_due: u32,
    /// Healths until the greeting is said again.
    greeting_in: u8,
    /// Frame and time from which the rate is measured.
    rate_from: Option<(u32, u64)>,
    latest: (u32, u64),
}

impl Detector {
    /// A detector at rest. `settings` must have passed [`Settings::validate`].
    pub const fn new(settings: Settings) -> Self {
        Self {
            settings,
            assembler: Assembler::new(settings.vref_v),
            rest: Rest {
                volts_per_code: reading::volts(1, settings.vref_v),
                contact: ContactDetector::new(settings.slide),
                reference: None,
                values: [0.0; TAXELS],
                window_frames: frames_in(settings.window_s, WINDOW_FRAMES_MAX),
                hop_frames: frames_in(settings.hop_s, u32::MAX),
                next_end: 0,
                health_due: HEALTH_FRAMES,
                greeting_in: GREETING_HEALTHS,
                rate_from: None,
                latest: (0, 0),
            },
        }
    }

    /// The greeting to send before anything else.
    pub fn hello(&self) -> Event {
        hello(&self.settings)
    }

    /// Takes one conversion; events go to `emit`, windows that are due for a fit to `due`.
    pub fn push(
        &mut self,
        conversion: TimedConversion,
        ring: &mut Ring,
        counters: &Counters,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        let (rest, settings) = (&mut self.rest, &self.settings);
        self.assembler.push(&conversion, |assembler, frame| {
            rest.frame(frame, ring, emit, due);
            if reached(frame.number, rest.health_due) {
                rest.health_due = frame.number.wrapping_add(HEALTH_FRAMES);
                emit(Event::Health(rest.health(assembler, counters)));
                rest.greeting_in = rest.greeting_in.saturating_sub(1);
                if rest.greeting_in == 0 {
                    rest.greeting_in = GREETING_HEALTHS;
                    emit(hello(settings));
                }
            }
        });
    }

    /// The signal has ended: closes what is open (a slide that still runs) and reports health.
    pub fn finish(
        &mut self,
        ring: &Ring,
        counters: &Counters,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        let rest = &mut self.rest;
        let mut change = None;
        rest.contact.finish(rest.latest.0.wrapping_add(1), &mut |what| change = Some(what));
        if let Some(change) = change {
            rest.tell(change, ring, emit, due);
        }
        emit(Event::Health(rest.health(&self.assembler, counters)));
    }
}

fn hello(settings: &Settings) -> Event {
    let part = |text: &str| text.bytes().fold(0u8, |n, digit| n.wrapping_mul(10).wrapping_add(digit - b'0'));
    Event::Hello(Hello {
        protocol: PROTOCOL,
        version: [
            part(env!("CARGO_PKG_VERSION_MAJOR")),
            part(env!("CARGO_PKG_VERSION_MINOR")),
            part(env!("CARGO_PKG_VERSION_PATCH")),
        ],
        frame_rate_hz: FRAME_RATE_HZ,
        settings: *settings,
    })
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

impl Rest {
    fn frame(&mut self, frame: &Frame, ring: &mut Ring, emit: &mut dyn FnMut(Event), due: &mut dyn FnMut(Window)) {
        let complete = frame.present == u16::MAX;
        self.latest = (frame.number, frame.t_us);
        let Some(reference) = self.reference.or_else(|| complete.then_some(frame.codes)) else { return };
        if self.reference.is_none() {
            self.reference = Some(reference);
            self.rate_from = Some(self.latest);
            ring.restart(frame.number);
        }
        // Scans that never came leave frames without a valid taxel.
        let missing = frame.number.wrapping_sub(ring.next());
        if missing >= RING_FRAMES as u32 {
            ring.restart(frame.number);
        } else {
            let from_us = ring.t_us(ring.next().wrapping_sub(1)).unwrap_or(frame.t_us as u32);
            let passed_us = (frame.t_us as u32).wrapping_sub(from_us) as u64;
            // Spread over the time that passed: a window may end among them and measure its rate there.
            for i in 1..=missing {
                let t_us = from_us.wrapping_add((passed_us * i as u64 / (missing + 1) as u64) as u32);
                ring.push(&[0.0; TAXELS], 0, t_us);
            }
        }
        // A taxel whose code is not to be trusted stays where it was, for the sake of the detector.
        for c in 0..TAXELS {
            if frame.good & 1 << c != 0 {
                self.values[c] = (frame.codes[c] - reference[c]) as f32;
            }
        }
        // A frame counts only whole: the fit needs one abscissa for all channels.
        let valid = if complete { frame.good } else { 0 };
        ring.push(&self.values, valid, frame.t_us as u32);
        if valid == 0 {
            return;
        }
        let values = self.values;
        let mut changes: [Option<Change>; 4] = [None; 4];
        let mut count = 0;
        self.contact.push(frame.number, &values, ring, &mut |change| {
            if let Some(place) = changes.get_mut(count) {
                *place = Some(change);
                count += 1;
            }
        });
        for change in changes.into_iter().flatten() {
            self.tell(change, ring, emit, due);
        }
        self.hop(ring, due);
    }

    /// Gives the windows that the slide has filled by now.
    fn hop(&mut self, ring: &Ring, due: &mut dyn FnMut(Window)) {
        let Some((_, until)) = self.contact.sliding() else { return };
        while reached(until, self.next_end) {
            let first = self.next_end.wrapping_sub(self.window_frames);
            if let Some(window) = self.window(first, self.window_frames, Span::Window, ring) {
                due(window);
            }
            self.next_end = self.next_end.wrapping_add(self.hop_frames);
        }
    }

    fn tell(&mut self, change: Change, ring: &Ring, emit: &mut dyn FnMut(Event), due: &mut dyn FnMut(Window)) {
        match change {
            Change::Contact { frame, taxel, height } => emit(Event::Contact(Contact {
                t_us: self.time_us(frame, ring),
                taxel,
                height_v: height * self.volts_per_code,
            })),
            Change::SlideStart(start) => {
                self.next_end = start.wrapping_add(self.window_frames);
                emit(Event::Slide(Slide { start_us: self.time_us(start, ring), end_us: None }));
            }
            Change::SlideEnd(start, end) => {
                self.hop(ring, due);
                let end_us = Some(self.time_us(end, ring));
                emit(Event::Slide(Slide { start_us: self.time_us(start, ring), end_us }));
                let first = start.wrapping_add(TRIM_FRAMES);
                let last = end.wrapping_sub(TRIM_FRAMES);
                if reached(last, first) {
                    let frames = last.wrapping_sub(first);
                    // The latest part of a slide that is longer than a window can be.
                    let most = frames.min(WINDOW_FRAMES_MAX);
                    let first = first.wrapping_add(frames - most);
                    if let Some(window) = self.window(first, most, Span::Slide, ring) {
                        due(window);
                    }
                }
            }
            Change::Release(frame) => emit(Event::Release(Release { t_us: self.time_us(frame, ring) })),
        }
    }

    /// Device time of a frame's first slot. Frames that the ring does not hold are reckoned at the
    /// nominal rate.
    fn time_us(&self, frame: u32, ring: &Ring) -> u64 {
        let (number, t_us) = self.latest;
        match ring.t_us(frame) {
            Some(low) => t_us.wrapping_sub((t_us as u32).wrapping_sub(low) as u64),
            None => {
                let back = number.wrapping_sub(frame) as i32 as i64 * CONVERSION_NS as i64 * crate::frame::SLOTS as i64;
                t_us.saturating_add_signed(-(back / 1000))
            }
        }
    }

    fn window(&self, first: u32, frames: u32, span: Span, ring: &Ring) -> Option<Window> {
        if frames < FRAMES_MIN {
            return None;
        }
        let last = first.wrapping_add(frames - 1);
        let passed_us = ring.t_us(last)?.wrapping_sub(ring.t_us(first)?);
        Some(Window {
            first,
            frames,
            end_us: self.time_us(last, ring),
            frame_rate_hz: (frames - 1) as f32 * 1e6 / passed_us.max(1) as f32,
            reference: self.reference.unwrap_or_default(),
            span,
        })
    }

    fn health(&self, assembler: &Assembler, counters: &Counters) -> Health {
        let frame_rate_hz = match self.rate_from {
            Some((frame, t_us)) if self.latest.1 > t_us => {
                self.latest.0.wrapping_sub(frame) as f32 * 1e6 / (self.latest.1 - t_us) as f32
            }
            _ => 0.0,
        };
        let readings = &assembler.readings;
        Health {
            t_us: assembler.now_us(),
            frames: assembler.frames,
            // What overran the queue is missing in the scan too; it would count twice if added.
            conversions_lost: assembler.lost.max(counters.overruns),
            conversions_doubtful: assembler.doubtful,
            hops_skipped: counters.hops_skipped,
            messages_dropped: counters.messages_dropped,
            chip_restarts: counters.chip_restarts,
            frame_rate_hz,
            load: counters.load,
            supply_v: readings.supply_v,
            reference_v: readings.reference_v,
            temperature_c: readings.temperature_c,
            offset_v: readings.offset_v,
            gain: readings.gain,
        }
    }
}
