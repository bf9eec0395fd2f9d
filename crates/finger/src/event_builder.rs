//! Converts touch changes, in frames and codes, to events in device time and volts.

use crate::frame::FrameClock;
use crate::ring::Ring;
use crate::touch::change::Change;
use crate::touch::image::image;
use ads1258::reading;
use ridgetone_proto::telemetry::{Contact, Event, Moving, Release, Slide};

#[derive(Clone, Debug)]
pub struct EventBuilder {
    /// Volts per code.
    pub volts_per_code: f32,
    /// Reported start of the latest slide, microseconds. The ring may lose it before the slide
    /// ends.
    slide_start_us: u64,
}

impl EventBuilder {
    /// Creates a builder for a reference of `vref_v` volts.
    pub const fn new(vref_v: f32) -> Self {
        Self {
            volts_per_code: reading::volts(1, vref_v),
            slide_start_us: 0,
        }
    }

    pub fn event(&mut self, change: &Change, clock: &FrameClock, ring: &Ring) -> Event {
        match *change {
            Change::Contact {
                frame,
                onset,
                taxel,
                height,
            } => {
                let t_us = clock.time_us(frame, ring);
                Event::Contact(Contact {
                    t_us,
                    taxel,
                    height_v: height * self.volts_per_code,
                    onset_us: clock.time_us(onset, ring),
                    reported_after_us: clock.since_us(t_us),
                })
            }
            Change::HoldEnd(hold) => {
                let (from, until) = hold.span;
                let [start_us, end_us] = [from, until].map(|frame| clock.time_us(frame, ring));
                Event::Image(image(&hold, start_us, end_us, self.volts_per_code))
            }
            Change::Moving(since) => {
                let t_us = clock.time_us(since, ring);
                Event::Moving(Moving {
                    t_us,
                    reported_after_us: clock.since_us(t_us),
                })
            }
            Change::SlideStart(start) => {
                self.slide_start_us = clock.time_us(start, ring);
                Event::Slide(Slide {
                    start_us: self.slide_start_us,
                    end_us: None,
                    reported_after_us: clock.since_us(self.slide_start_us),
                })
            }
            Change::SlideEnd(_, end) => {
                let end_us = clock.time_us(end, ring);
                Event::Slide(Slide {
                    start_us: self.slide_start_us,
                    end_us: Some(end_us),
                    reported_after_us: clock.since_us(end_us),
                })
            }
            Change::Release(frame) => {
                let t_us = clock.time_us(frame, ring);
                Event::Release(Release {
                    t_us,
                    reported_after_us: clock.since_us(t_us),
                })
            }
        }
    }
}
