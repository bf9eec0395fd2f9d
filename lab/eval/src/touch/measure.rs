//! What the detector reports of many traces of a cell, beside the truth.

use super::trace::{Recipe, SlideTruth, Trace, Truth};
use ads1258::{Conversion, Status as Flags};
use anyhow::Result;
use ridgetone_finger::Diagnostics;
use ridgetone_finger::Ring;
use ridgetone_finger::TimedConversion;
use ridgetone_finger::converter::SCAN;
use ridgetone_finger::{CONVERSION_NS, SLOTS};
use ridgetone_finger::{Detector, Outputs};
use ridgetone_finger::{Estimator, WindowFit};
use ridgetone_host::input::frame_rate_hz;
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Event, Status};
use serde::{Deserialize, Serialize};

/// The chip's own readings (SBAS297G): offset 0, supply 5 V, 25 degrees, gain 1, reference 4.096 V.
const OWN: [i32; 5] = [0, 3_932_160, 322_560, 7_864_320, 3_221_225];
/// A contact within this is that of the truth, seconds.
const CONTACT_S: f64 = 0.1;
/// A release within this is that of the truth; one that lags by as much as the skin needs to creep back is one too.
const RELEASE_S: (f64, f64) = (-0.05, 1.0);
/// Both ends of a slide should be as near as this, seconds.
pub const NEAR_S: f64 = 0.02;

/// What was found in the traces of a cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Found {
    pub traces: u32,
    /// Those with a slide, and those whose slide was found in one piece.
    pub slides: u32,
    pub slides_found: u32,
    /// Both ends within 20 ms; and within 20 ms of what can be seen of the motion.
    pub near: u32,
    pub near_visible: u32,
    /// Traces with slides that are not there, and pieces of a slide beside the longest.
    pub slides_false: u32,
    pub contacts: u32,
    pub contacts_found: u32,
    pub contacts_false: u32,
    pub releases_found: u32,
    /// Traces with a good estimate of a window that is for the most part outside of the slide.
    pub still_good: u32,
    /// Errors in milliseconds: 5 %, median and 95 % of contact, start, end and release.
    pub contact_ms: Option<[f64; 3]>,
    pub start_ms: Option<[f64; 3]>,
    pub end_ms: Option<[f64; 3]>,
    pub release_ms: Option<[f64; 3]>,
}

/// What was reported of a trace, seconds.
#[derive(Default)]
struct Reported {
    contacts_s: Vec<f64>,
    slides_s: Vec<(f64, f64)>,
    releases_s: Vec<f64>,
    still_good: bool,
}

/// Errors, seconds.
#[derive(Default)]
struct Errors {
    contact: Vec<f64>,
    start: Vec<f64>,
    end: Vec<f64>,
    release: Vec<f64>,
}

pub fn measure(recipe: &Recipe, traces: u32, seed: u64) -> Result<Found> {
    let (mut found, mut errors) = (Found::default(), Errors::default());
    for number in 0..u64::from(traces) {
        let trace = Trace::new(recipe, seed.wrapping_mul(1_000_003).wrapping_add(number))?;
        let truth = trace.truth();
        let reported = run(trace, recipe.hum == Some(true));
        found.add(&truth, &reported, &mut errors);
    }
    found.contact_ms = quantiles(errors.contact);
    found.start_ms = quantiles(errors.start);
    found.end_ms = quantiles(errors.end);
    found.release_ms = quantiles(errors.release);
    Ok(found)
}

/// Runs a trace through the detector, and fits the windows that are for the most part outside of
/// the slide.
fn run(mut trace: Trace, mains: bool) -> Reported {
    let settings = Settings {
        interferer_hz: if mains { 50.0 } else { 0.0 },
        ..Settings::DEFAULT
    };
    let (mut detector, mut estimator) = (
        Box::new(Detector::new(settings)),
        Box::new(Estimator::new(settings)),
    );
    let (mut ring, diagnostics) = (Box::new(Ring::new()), Diagnostics::default());
    let (mut events, mut windows, mut reported) = (Vec::new(), Vec::new(), Reported::default());
    let ids: Vec<u8> = (0..32)
        .filter(|id| SCAN.channel_mask() & 1 << id != 0)
        .collect();
    let slide = trace.truth().slide;
    let (frames, rate_hz) = (trace.frames(), frame_rate_hz());
    for frame in 0..=frames {
        for (slot, id) in (0u64..).zip(&ids).filter(|_| frame < frames) {
            let ns = (u64::from(frame) * u64::from(SLOTS) + slot) * CONVERSION_NS;
            let slot = slot as usize;
            let code = if slot < TAXELS {
                trace.code(slot, frame, 1e-9 * ns as f64)
            } else {
                OWN[slot - TAXELS]
            };
            // New, and of this channel.
            let conversion = Conversion {
                status: Flags(0x80 | id),
                code,
            };
            let timed = TimedConversion::new((ns / 1000) as u32, conversion);
            detector.push(
                timed,
                &mut ring,
                &diagnostics,
                &mut Outputs {
                    emit: &mut |event| events.push(event),
                    due: &mut |due| windows.push(due),
                },
            );
        }
        if frame == frames {
            detector.finish(
                &mut ring,
                &diagnostics,
                &mut |event| events.push(event),
                &mut |due| windows.push(due),
            );
        }
        for window in windows.drain(..) {
            let span_s = [window.first, window.first + window.frames]
                .map(|frame| f64::from(frame) / rate_hz);
            let within_s = slide.map_or(0.0, |slide| overlap(span_s, slide.start_s, slide.end_s));
            if within_s < 0.5 * (span_s[1] - span_s[0])
                && let Ok(WindowFit::Done(estimate)) = estimator.run(&window, &mut &*ring)
            {
                reported.still_good |= estimate.status == Status::Good;
            }
        }
    }
    let seconds = |us: u64| us as f64 * 1e-6;
    for event in events {
        match event {
            Event::Contact(contact) => reported.contacts_s.push(seconds(contact.t_us)),
            Event::Slide(slide) => {
                reported.slides_s.extend(
                    slide
                        .end_us
                        .map(|end_us| (seconds(slide.start_us), seconds(end_us))),
                );
            }
            Event::Release(release) => reported.releases_s.push(seconds(release.t_us)),
            _ => {}
        }
    }
    reported
}

fn overlap([from_s, to_s]: [f64; 2], start_s: f64, end_s: f64) -> f64 {
    (to_s.min(end_s) - from_s.max(start_s)).max(0.0)
}

impl Found {
    fn add(&mut self, truth: &Truth, reported: &Reported, errors: &mut Errors) {
        self.traces += 1;
        self.still_good += u32::from(reported.still_good);
        let is_contact = |at_s: &&f64| {
            truth
                .contact_s
                .is_some_and(|contact_s| (**at_s - contact_s).abs() < CONTACT_S)
        };
        let contact_s = reported.contacts_s.iter().find(is_contact);
        self.contacts += u32::from(truth.contact_s.is_some());
        self.contacts_found += u32::from(contact_s.is_some());
        self.contacts_false +=
            u32::from(reported.contacts_s.len() > usize::from(contact_s.is_some()));
        errors.contact.extend(
            contact_s
                .zip(truth.contact_s)
                .map(|(found_s, true_s)| found_s - true_s),
        );
        let is_release =
            |at_s: &&f64| (RELEASE_S.0..RELEASE_S.1).contains(&(**at_s - truth.release_s));
        if let Some(at_s) = reported.releases_s.iter().find(is_release) {
            self.releases_found += 1;
            errors.release.push(at_s - truth.release_s);
        }
        self.slides += u32::from(truth.slide.is_some());
        let found = truth.slide.and_then(|slide| {
            let shared =
                |(from_s, to_s): (f64, f64)| overlap([from_s, to_s], slide.start_s, slide.end_s);
            let most = reported
                .slides_s
                .iter()
                .copied()
                .max_by(|a, b| shared(*a).total_cmp(&shared(*b)))?;
            let half_of = |length_s: f64| shared(most) > 0.5 * length_s;
            (half_of(slide.end_s - slide.start_s) && half_of(most.1 - most.0))
                .then_some((slide, most))
        });
        self.slides_false += u32::from(reported.slides_s.len() > usize::from(found.is_some()));
        // A slide in pieces was not found.
        let Some((slide, (from_s, to_s))) = found.filter(|_| reported.slides_s.len() == 1) else {
            return;
        };
        self.slides_found += 1;
        errors.start.push(from_s - slide.start_s);
        errors.end.push(to_s - slide.end_s);
        self.near += u32::from(
            (from_s - slide.start_s)
                .abs()
                .max((to_s - slide.end_s).abs())
                <= NEAR_S,
        );
        let SlideTruth {
            start_s,
            end_s,
            visible_from_s,
            visible_to_s,
        } = slide;
        let start_off_s = (start_s - from_s).max(from_s - visible_from_s);
        let end_off_s = (visible_to_s - to_s).max(to_s - end_s);
        self.near_visible += u32::from(start_off_s.max(end_off_s) <= NEAR_S);
    }
}

/// 5 %, median and 95 %, in milliseconds.
fn quantiles(mut errors: Vec<f64>) -> Option<[f64; 3]> {
    errors.sort_by(f64::total_cmp);
    let most = errors.len().checked_sub(1)?;
    Some(
        [0.05, 0.5, 0.95]
            .map(|share| (1e4 * errors[(share * most as f64).round() as usize]).round() / 10.0),
    )
}
