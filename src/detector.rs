//! The first half of the pipeline: conversions in, events and due windows out.

use crate::contact::{Change, ContactDetector};
use crate::frame::{Assembler, CONVERSION_NS, Frame, SLOTS, TimedConversion};
use crate::pipeline::GROWING_FRAMES_MIN;
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
/// Most frames of a window. Until a slide's end is noticed the ring goes on for 20 blocks of 4 frames, and for
/// about 13 until it is dated; 28 frames more, 0.12 s, are left for the fit to read the oldest of them.
pub const WINDOW_FRAMES_MAX: u32 = RING_FRAMES as u32 - 160;

/// Frames that the ring may take in before the fit has read its oldest, 66 ms.
const READING_FRAMES: u32 = 16;

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
    /// Whether there has been a complete frame.
    begun: bool,
    /// Code of every taxel in the first complete frame: what the ring's values are relative to.
    reference: Values,
    /// The latest values that could be trusted.
    values: Values,
    window_frames: u32,
    /// Whether windows grow until they are accurate enough.
    growing: bool,
    hop_frames: u32,
    /// Frame behind the window that falls due next.
    next_end: u32,
    health_due: u32,
    /// Healths until the greeting is said again.
    greeting_in: u8,
    /// Frame and time from which the rate is measured.
    rate_from: (u32, u64),
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
                begun: false,
                reference: [0.0; TAXELS],
                values: [0.0; TAXELS],
                window_frames: frames_in(settings.window_s, WINDOW_FRAMES_MAX),
                growing: settings.accuracy > 0.0,
                hop_frames: frames_in(settings.hop_s, u32::MAX),
                next_end: 0,
                health_due: HEALTH_FRAMES,
                greeting_in: GREETING_HEALTHS,
                rate_from: (0, 0),
                latest: (0, 0),
            },
        }
    }

    /// The greeting to send before anything else.
    pub fn hello(&self) -> Event {
        hello(&self.settings)
    }

    /// Takes one conversion; events go to `emit`, windows that are due for a fit to `due`.
    #[inline(always)]
    pub fn push(
        &mut self,
        conversion: TimedConversion,
        ring: &mut Ring,
        counters: &Counters,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        if self.assembler.wait(&conversion) {
            self.scan_over(ring, counters, emit, due);
        }
    }

    #[inline(never)]
    fn scan_over(
        &mut self,
        ring: &mut Ring,
        counters: &Counters,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        if !self.assembler.whole() {
            return self.one_by_one(ring, counters, emit, due);
        }
        self.rest.frame(self.assembler.frame(), ring, emit, due);
        if reached(self.rest.latest.0, self.rest.health_due) {
            self.rest.tell_health(&self.assembler, &self.settings, counters, emit);
        }
    }

    #[inline(never)]
    fn one_by_one(
        &mut self,
        ring: &mut Ring,
        counters: &Counters,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        let (rest, settings) = (&mut self.rest, &self.settings);
        self.assembler.deal_one_by_one(&mut |assembler: &Assembler, frame: &Frame| {
            rest.frame(frame, ring, emit, due);
            if reached(frame.number, rest.health_due) {
                rest.tell_health(assembler, settings, counters, emit);
            }
        });
    }

    /// The signal has ended: closes what is open (a slide that still runs) and reports health.
    pub fn finish(
        &mut self,
        ring: &mut Ring,
        counters: &Counters,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        self.one_by_one(ring, counters, emit, due);
        let rest = &mut self.rest;
        let mut changes = Changes::new();
        rest.contact.finish(rest.latest.0.wrapping_add(1), ring, &mut |change| note(&mut changes, change));
        for change in changes {
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

/// What changed with one frame. Four at most: a search that had to be ended gives two, and what ended it one or two.
type Changes = heapless::Vec<Change, 4>;

fn note(changes: &mut Changes, change: Change) {
    // There is room: see above.
    let _ = changes.push(change);
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

/// Scans that never came leave frames without a valid taxel.
#[inline(never)]
fn fill(missing: u32, frame: &Frame, ring: &mut Ring) {
    if missing >= RING_FRAMES as u32 {
        ring.restart(frame.number);
        return;
    }
    let from_us = ring.t_us(ring.next().wrapping_sub(1)).unwrap_or(frame.t_us as u32);
    let passed_us = (frame.t_us as u32).wrapping_sub(from_us);
    // Spread over the time that passed: a window may end among them and measure its rate there. In two
    // parts that 32 bits hold: a division of 64 bits is a kilobyte of code here.
    let (whole, rest) = (passed_us / (missing + 1), passed_us % (missing + 1));
    for i in 1..=missing {
        ring.push(&[0.0; TAXELS], 0, from_us.wrapping_add(whole * i + rest * i / (missing + 1)));
    }
}

impl Rest {
    fn frame(&mut self, frame: &Frame, ring: &mut Ring, emit: &mut dyn FnMut(Event), due: &mut dyn FnMut(Window)) {
        let complete = frame.present == u16::MAX;
        self.latest = (frame.number, frame.t_us);
        if !self.begun {
            if !complete {
                return;
            }
            self.begun = true;
            self.reference = frame.taxels().map(|code| code as f32);
            self.rate_from = self.latest;
            ring.restart(frame.number);
        }
        // Scans that never came leave frames without a valid taxel.
        let missing = frame.number.wrapping_sub(ring.next());
        if missing > 0 {
            fill(missing, frame, ring);
        }
        let codes = frame.taxels();
        // Exact: codes have 24 bits.
        let value = |c: usize| codes[c] as f32 - self.reference[c];
        if frame.good == u16::MAX {
            self.values = core::array::from_fn(value);
        } else {
            // A taxel whose code is not to be trusted stays where it was, for the sake of the detector.
            for c in (0..TAXELS).filter(|c| frame.good & 1 << c != 0) {
                self.values[c] = value(c);
            }
        }
        // A frame counts only whole: the fit needs one abscissa for all channels.
        let valid = if complete { frame.good } else { 0 };
        ring.push(&self.values, valid, frame.t_us as u32);
        if valid == 0 {
            return;
        }
        let mut changes = Changes::new();
        self.contact.push(frame.number, &self.values, ring, &mut |change| note(&mut changes, change));
        for change in changes {
            self.tell(change, ring, emit, due);
        }
        self.hop(ring, due);
    }

    /// Gives the windows that the slide has filled by now.
    fn hop(&mut self, ring: &Ring, due: &mut dyn FnMut(Window)) {
        let Some((start, until)) = self.contact.sliding() else { return };
        while reached(until, self.next_end) {
            let mut frames = self.window_frames;
            if self.growing {
                frames = frames.min(self.next_end.wrapping_sub(start));
            }
            if let Some(window) = self.window(self.next_end.wrapping_sub(frames), frames, Span::Window, ring) {
                due(window);
            }
            self.next_end = self.next_end.wrapping_add(self.hop_frames);
        }
    }

    #[inline(never)]
    fn tell(&mut self, change: Change, ring: &Ring, emit: &mut dyn FnMut(Event), due: &mut dyn FnMut(Window)) {
        match change {
            Change::Contact { frame, taxel, height } => emit(Event::Contact(Contact {
                t_us: self.time_us(frame, ring),
                taxel,
                height_v: height * self.volts_per_code,
            })),
            Change::SlideStart(start) => {
                let first = if self.growing { GROWING_FRAMES_MIN.min(self.window_frames) } else { self.window_frames };
                self.next_end = start.wrapping_add(first);
                emit(Event::Slide(Slide { start_us: self.time_us(start, ring), end_us: None }));
            }
            Change::SlideEnd(start, end) => {
                let end_us = Some(self.time_us(end, ring));
                emit(Event::Slide(Slide { start_us: self.time_us(start, ring), end_us }));
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
                    let (first, most) = (first.wrapping_add(late), most.saturating_sub(late));
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
    #[inline(never)]
    fn time_us(&self, frame: u32, ring: &Ring) -> u64 {
        let (number, t_us) = self.latest;
        match ring.t_us(frame) {
            Some(low) => t_us.wrapping_sub((t_us as u32).wrapping_sub(low) as u64),
            None => {
                const FRAME_NS: u32 = CONVERSION_NS as u32 * SLOTS;
                let back = number.wrapping_sub(frame) as i32;
                let frames = back.unsigned_abs();
                // In two parts, as in `fill`.
                let away_us = (frames / 1000) as u64 * FRAME_NS as u64 + (frames % 1000 * FRAME_NS / 1000) as u64;
                if back < 0 { t_us.wrapping_add(away_us) } else { t_us.saturating_sub(away_us) }
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
            reference: self.reference.map(|code| code as i32),
            span,
        })
    }

    #[inline(never)]
    fn tell_health(
        &mut self,
        assembler: &Assembler,
        settings: &Settings,
        counters: &Counters,
        emit: &mut dyn FnMut(Event),
    ) {
        self.health_due = self.latest.0.wrapping_add(HEALTH_FRAMES);
        emit(Event::Health(self.health(assembler, counters)));
        self.greeting_in = self.greeting_in.saturating_sub(1);
        if self.greeting_in == 0 {
            self.greeting_in = GREETING_HEALTHS;
            emit(hello(settings));
        }
    }

    fn health(&self, assembler: &Assembler, counters: &Counters) -> Health {
        let (frame, t_us) = self.rate_from;
        let frame_rate_hz = if self.begun && self.latest.1 > t_us {
            self.latest.0.wrapping_sub(frame) as f32 * 1e6 / (self.latest.1 - t_us) as f32
        } else {
            0.0
        };
        let readings = assembler.readings();
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
