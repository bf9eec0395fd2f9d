//! The first half of the pipeline: conversions in, events and due windows out.

mod commands;
mod episodes;
mod health;
mod image;
mod schedule;

use crate::faults::diagnostics::Diagnostics;
use crate::frame::{Assembler, Frame, TimedConversion};
use crate::ring::Ring;
use crate::touch::contact::ContactDetector;
use crate::window::Window;
use episodes::FaultEpisodes;
use health::HealthReporter;
use image::Imaging;
use ridgetone_proto::boot::{Boot, SettingsSource};
use ridgetone_proto::settings::{FRAME_RATE_HZ, RING_FRAMES, Settings, TAXELS};
use ridgetone_proto::telemetry::{Event, Hello, Image, PROTOCOL, Raw};
use ridgetone_tone::Values;
use schedule::WindowScheduler;
pub use schedule::{TRIM_FRAMES, WINDOW_FRAMES_MAX};

/// What the caller counts and the detector reports in `health`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counters {
    /// Conversions lost before the queue or at it, but for whole scans that were never read.
    pub overruns: u32,
    /// Conversions that the chip may have made besides, at most, while it ran with other registers.
    pub unseen: u32,
    /// Windows not fitted because the fit was busy.
    pub hops_skipped: u32,
    /// Messages dropped because the line was slow.
    pub messages_dropped: u32,
    /// Times the ADC was set up anew because its registers were not what they should be.
    pub chip_restarts: u32,
    /// Orders that came damaged.
    pub requests_damaged: u32,
    /// Processor load, 0 to 1.
    pub load: f32,
    /// The most of the stack that was in use since start-up, and its size, bytes.
    pub stack: [u32; 2],
}

/// Frames, contact and windows: the middle task.
#[derive(Clone, Debug)]
pub struct Detector {
    settings: Settings,
    assembler: Assembler,
    rest: Rest,
    health_reporter: HealthReporter,
    imaging: Imaging,
    episodes: FaultEpisodes,
    /// Where the settings come from.
    source: SettingsSource,
    /// How the run began.
    boot: Boot,
    /// Nothing is told but `health` and faults.
    stopped: bool,
    /// Frames still to be told raw.
    raw_frames: u32,
}

/// What takes the assembler's frames.
#[derive(Clone, Debug)]
struct Rest {
    contact: ContactDetector,
    /// Whether there has been a complete frame.
    begun: bool,
    /// The latest values that could be trusted.
    values: Values,
    scheduler: WindowScheduler,
}

impl Detector {
    /// A detector at rest. `settings` must have passed [`Settings::validate`].
    pub const fn new(settings: Settings) -> Self {
        Self::booted(settings, SettingsSource::Default, Boot::UNKNOWN)
    }

    /// The same, for a greeting that says where the settings come from and how the run began.
    pub const fn booted(settings: Settings, source: SettingsSource, boot: Boot) -> Self {
        Self {
            settings,
            assembler: Assembler::new(settings.vref_v),
            rest: Rest {
                contact: ContactDetector::new(settings.slide),
                begun: false,
                values: [0.0; TAXELS],
                scheduler: WindowScheduler::new(&settings),
            },
            health_reporter: HealthReporter::new(),
            imaging: Imaging::new(),
            episodes: FaultEpisodes::new(settings.vref_v),
            source,
            boot,
            stopped: false,
            raw_frames: 0,
        }
    }

    /// The greeting to send before anything else.
    #[inline(never)]
    pub fn hello(&self) -> Event {
        let part = |text: &str| text.bytes().fold(0u8, |n, digit| n.wrapping_mul(10).wrapping_add(digit - b'0'));
        Event::Hello(Hello {
            protocol: PROTOCOL,
            version: [
                part(env!("CARGO_PKG_VERSION_MAJOR")),
                part(env!("CARGO_PKG_VERSION_MINOR")),
                part(env!("CARGO_PKG_VERSION_PATCH")),
            ],
            frame_rate_hz: FRAME_RATE_HZ,
            settings: self.settings,
            source: self.source,
            boot: self.boot.clone(),
        })
    }

    /// The image that was told last.
    pub const fn image(&self) -> &Image {
        self.imaging.image()
    }

    /// Takes one conversion; events go to `emit`, windows that are due for a fit to `due`. What is wrong with it is
    /// added to `diagnostics`.
    #[inline(always)]
    pub fn push(
        &mut self,
        conversion: TimedConversion,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        if self.assembler.wait(&conversion) {
            self.scan_over(ring, diagnostics, emit, due);
        }
    }

    #[inline(never)]
    fn scan_over(
        &mut self,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        let is_followed = if self.assembler.whole() {
            self.rest.frame(self.assembler.frame(), ring, emit, due);
            true
        } else {
            self.one_by_one(false, ring, diagnostics, emit, due)
        };
        self.check_supply(diagnostics);
        // A frame in which something is dated has enough to do. Where no frame comes, stopped or for lack of a taxel, it
        // would be busy for ever.
        if is_followed && self.rest.contact.is_busy() {
            return;
        }
        if self.health_reporter.is_due(self.rest.scheduler.latest.0) {
            self.check(diagnostics, emit);
            return;
        }
        self.guard(diagnostics, emit);
        if self.rest.contact.has_time_for_image() {
            self.picture(ring, emit);
        }
    }

    /// Whether the contact's detector got a frame.
    #[inline(never)]
    fn one_by_one(
        &mut self,
        is_over: bool,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) -> bool {
        let Self { assembler, rest, stopped, raw_frames, .. } = self;
        let mut is_followed = false;
        assembler.deal_one_by_one(is_over, &mut |_: &Assembler, frame: &Frame| {
            if *raw_frames > 0 {
                *raw_frames -= 1;
                tell_raw(frame, emit);
            }
            if *stopped {
                rest.scheduler.latest = (frame.number, frame.t_us);
            } else {
                rest.frame(frame, ring, emit, due);
                is_followed |= frame.present == u16::MAX && frame.good != 0;
            }
        });
        episodes::note(assembler, diagnostics);
        self.choose_way();
        is_followed
    }

    /// The signal has ended: closes what is open (a slide that still runs) and reports health.
    pub fn finish(
        &mut self,
        ring: &mut Ring,
        diagnostics: &Diagnostics,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        self.one_by_one(true, ring, diagnostics, emit, due);
        let Rest { contact, scheduler, .. } = &mut self.rest;
        contact.finish(scheduler.latest.0.wrapping_add(1), ring, &mut |change| scheduler.tell(change, ring, emit));
        scheduler.give_whole(ring, due);
        while self.rest.contact.has_image() && self.picture(ring, emit) {}
        self.health_reporter.finish(&self.assembler, &self.rest.scheduler, diagnostics, emit);
    }
}

impl Rest {
    fn frame(&mut self, frame: &Frame, ring: &mut Ring, emit: &mut dyn FnMut(Event), due: &mut dyn FnMut(Window)) {
        let complete = frame.present == u16::MAX;
        let scheduler = &mut self.scheduler;
        scheduler.latest = (frame.number, frame.t_us);
        if !self.begun {
            if !complete {
                return;
            }
            self.begun = true;
            scheduler.begin(frame.taxels());
            ring.restart(frame.number);
        }
        // Scans that never came leave frames without a valid taxel.
        let missing = frame.number.wrapping_sub(ring.next());
        if missing > 0 {
            fill(missing, frame, ring);
        }
        // A taxel whose code is not to be trusted stays where it was, for the sake of the detector.
        frame.put(&scheduler.reference, &mut self.values);
        if complete && frame.good != u16::MAX {
            self.contact.doubt_all_but(frame.good);
        }
        // A frame counts only whole: the fit needs one abscissa for all channels.
        let valid = if complete { frame.good } else { 0 };
        ring.push(&self.values, valid, frame.t_us as u32);
        if valid == 0 {
            return;
        }
        let ring = &*ring;
        scheduler.give_whole(ring, due);
        self.contact.push(frame.number, &self.values, ring, &mut |change| scheduler.tell(change, ring, emit));
        if let Some((start, until)) = self.contact.sliding() {
            scheduler.hop(start, until, ring, due);
        }
    }
}

/// Tells a frame as it was read.
#[inline(never)]
fn tell_raw(frame: &Frame, emit: &mut dyn FnMut(Event)) {
    let Frame { number, t_us, present, good, .. } = *frame;
    emit(Event::Raw(Raw { t_us, number, present, good, codes: *frame.taxels() }));
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
