//! Passes each frame into the ring and through touch detection, to events and due windows.

use crate::event_builder::EventBuilder;
use crate::frame::{Frame, FrameClock};
use crate::ring::Ring;
use crate::scan::Scan;
use crate::schedule::{Frames, WindowScheduler};
use crate::surface::texture::image_level_v;
use crate::touch::averages::{Averager, Averages};
use crate::touch::contact::{ContactDetector, Observed};
use crate::window::Window;
use ads1258::reading;
use ridgetone_proto::division::divide;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::scan::TAXELS;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Raw};
use ridgetone_tone::Values;

#[derive(Clone, Debug)]
pub struct Tracker {
    pub contact: ContactDetector,
    pub clock: FrameClock,
    pub scheduler: WindowScheduler,
    pub events: EventBuilder,
    /// Number of frames that are still to be reported raw.
    pub raw_frames: u32,
    /// True if only raw frames are reported.
    is_stopped: bool,
    /// True if there has been a complete frame.
    has_begun: bool,
    /// Latest good value of each taxel.
    values: Values,
    plan: Plan,
    averager: Averager,
}

impl Tracker {
    pub const fn new(settings: &Settings) -> Self {
        Self {
            contact: contact(settings),
            clock: FrameClock::new(&Scan::new(&settings.plan)),
            scheduler: WindowScheduler::new(settings),
            events: EventBuilder::new(settings.vref_v),
            raw_frames: 0,
            is_stopped: false,
            has_begun: false,
            values: [0.0; TAXELS],
            plan: settings.plan,
            averager: Averager::new(&settings.plan),
        }
    }

    /// Begins again with the next complete frame, or stops.
    // Not inlined: the new detector would add to the stack of all callers.
    #[inline(never)]
    pub fn restart(&mut self, is_going: bool, settings: &Settings) {
        self.is_stopped = !is_going;
        self.has_begun = false;
        self.scheduler.whole = None;
        self.contact = contact(settings);
    }

    /// Begins again with frames of a different plan, that of `settings`.
    pub fn begin(&mut self, settings: &Settings) {
        let Settings { plan, .. } = settings;
        (self.plan, self.values) = (*plan, [0.0; TAXELS]);
        self.averager = Averager::new(plan);
        self.clock.change(&Scan::new(plan));
        self.scheduler = WindowScheduler::new(settings);
        self.events.volts_per_code = reading::volts(1, settings.vref_v);
        self.restart(!self.is_stopped, settings);
    }

    /// Applies new settings with the same plan. A slide under way goes on.
    pub fn change(&mut self, settings: &Settings) {
        self.contact.slide = settings.slide;
        self.contact.set_mains(settings.interferer_hz);
        self.events.volts_per_code = reading::volts(1, settings.vref_v);
        self.scheduler.change(
            settings,
            self.sliding().map(|(start, _)| start),
            self.clock.latest.0,
        );
    }

    /// First frame of the slide under way, and the frame up to which it is known to have lasted.
    fn sliding(&self) -> Option<(u32, u32)> {
        let grid = self.averager.grid();
        self.contact
            .sliding()
            .map(|(start, until)| (grid.first_frame(start), grid.first_frame(until)))
    }

    pub fn push(
        &mut self,
        frame: &Frame,
        ring: &mut Ring,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        let Self {
            contact,
            clock,
            scheduler,
            events,
            averager,
            plan,
            ..
        } = self;
        let inputs = plan.inputs;
        clock.latest = (frame.number, frame.t_us);
        if self.raw_frames > 0 {
            self.raw_frames -= 1;
            let Frame {
                number,
                t_us,
                present,
                good,
                codes,
            } = *frame;
            emit(Event::Raw(Raw {
                t_us,
                number,
                present,
                good,
                codes,
            }));
        }
        if self.is_stopped {
            return;
        }
        let is_complete = frame.present == inputs;
        if !self.has_begun {
            if !is_complete {
                return;
            }
            self.has_begun = true;
            scheduler
                .reference
                .iter_mut()
                .zip(frame.codes)
                .for_each(|(value, code)| *value = code as f32);
            clock.rate_from = Some(clock.latest);
            ring.change(plan, frame.number);
            averager.restart(frame.number);
        }
        fill_gap(frame, ring);
        // Touch detection uses a taxel's previous value in place of a bad one.
        frame.put(&scheduler.reference, &mut self.values);
        if is_complete && frame.good != inputs {
            contact.note_good(frame.good);
        }
        // No value of an incomplete frame is valid, because the fit needs one time for all
        // channels.
        let valid = if is_complete { frame.good } else { 0 };
        ring.push(&self.values, valid, frame.t_us as u32);
        let Some(number) = averager.push(frame.number, &self.values, inputs, valid != 0) else {
            return;
        };
        let (ring, grid) = (&*ring, &averager.grid());
        scheduler.give_whole(clock, ring, due);
        let (values, squares) = averager
            .latest()
            .map_or((&self.values, None), |(mean, squares)| {
                (mean, Some(squares))
            });
        let frame = Observed { values, squares };
        contact.push(number, frame, Averages::new(ring, *grid), &mut |change| {
            let change = change.in_frames(grid);
            scheduler.follow(&change, ring);
            let event = events.event(&change, clock, ring);
            if let Event::Image(image) = &event {
                scheduler.level_v = image_level_v(image);
            }
            emit(event);
        });
        if let Some((start, until)) = contact.sliding() {
            scheduler.stride(
                grid.first_frame(start),
                grid.first_frame(until),
                Frames { clock, ring },
                due,
            );
        }
    }

    /// Ends the signal, and a slide under way.
    pub fn finish(
        &mut self,
        ring: &Ring,
        emit: &mut dyn FnMut(Event),
        due: &mut dyn FnMut(Window),
    ) {
        let Self {
            contact,
            clock,
            scheduler,
            events,
            averager,
            ..
        } = self;
        let grid = &averager.grid();
        contact.finish(averager.next(), &mut |change| {
            let change = change.in_frames(grid);
            scheduler.follow(&change, ring);
            emit(events.event(&change, clock, ring));
        });
        scheduler.give_whole(clock, ring, due);
    }
}

const fn contact(settings: &Settings) -> ContactDetector {
    let mut contact = ContactDetector::new(settings.slide, &settings.plan);
    contact.set_mains(settings.interferer_hz);
    contact
}

/// Fills the places of missing scans with frames that have no valid taxel. Their times are spread
/// over the gap, since a window may end there and measure its rate.
fn fill_gap(frame: &Frame, ring: &mut Ring) {
    let missing = frame.number.wrapping_sub(ring.next());
    if missing == 0 {
        return;
    }
    if missing >= ring.frames() {
        ring.restart(frame.number);
        return;
    }
    let from_us = ring
        .t_us(ring.next().wrapping_sub(1))
        .unwrap_or(frame.t_us as u32);
    let passed_us = (frame.t_us as u32).wrapping_sub(from_us) as u64;
    for i in 1..=missing as u64 {
        let after_us = divide(passed_us * i, missing + 1).0 as u32;
        ring.push(&[0.0; TAXELS], 0, from_us.wrapping_add(after_us));
    }
}
