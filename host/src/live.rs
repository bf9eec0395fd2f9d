//! What is known of a board at this moment, folded from its packets: the model behind the terminal's screen and the web
//! page. It draws nothing and knows no line; [`crate::feed`] brings the packets.
//!
//! [`Live`] can be serialised. Whatever is a packet there has the same names as with `--json` ([`crate::events::json`]).

pub mod analysis;
mod history;
mod strips;

pub use history::{History, POINTS, Point};
pub use strips::{Frame, STRIP_FRAMES, Strips};

use crate::events;
use crate::static_image;
use ridgetone_proto::command::Outcome;
use ridgetone_proto::fault::{Fault, FaultKind};
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Decoder, Estimate, Event, Health, Hello, Hold, Image, Packet, Span};
use serde::{Serialize, Serializer};
use std::collections::VecDeque;

/// Lines of the log that are kept.
pub const LOG_LINES: usize = 200;

/// Phase of a touch (paper, section 3.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Nothing was heard that tells.
    #[default]
    Unknown,
    /// Nothing touches the finger.
    Idle,
    /// It is touched, and nothing has slid yet.
    Held,
    /// The grating slides.
    Sliding,
    /// The slide is over, the finger is still touched.
    HeldAfter,
}

/// What happens on the line.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum Line {
    /// Nothing was heard yet.
    #[default]
    Waiting,
    /// The board is there.
    There,
    /// It was unplugged, and is waited for.
    Gone {
        /// What the system said.
        why: String,
    },
    /// A recording or a scene is over.
    Over,
}

/// What was counted at this end of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Packets received.
    pub received: u64,
    /// Packets that never came, by their numbers.
    pub missing: u32,
    /// Packets with a wrong checksum.
    pub damaged: u32,
    /// Times that the numbers went back.
    pub stepped_back: u32,
}

impl Counts {
    /// What a decoder has counted, and how many packets it gave.
    pub fn of(decoder: &Decoder, received: u64) -> Self {
        let Decoder { missing, damaged, stepped_back, .. } = *decoder;
        Self { received, missing, damaged, stepped_back }
    }
}

/// The latest packets of some kinds.
#[derive(Clone, Debug, Default, Serialize)]
struct Latest {
    #[serde(serialize_with = "as_json")]
    hello: Option<Packet>,
    #[serde(serialize_with = "as_json")]
    estimate: Option<Packet>,
    #[serde(serialize_with = "as_json")]
    whole_slide: Option<Packet>,
    #[serde(serialize_with = "as_json")]
    image_before: Option<Packet>,
    #[serde(serialize_with = "as_json")]
    image_after: Option<Packet>,
    #[serde(serialize_with = "as_json")]
    health: Option<Packet>,
}

/// Everything that is known of a board.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Live {
    /// What the packets come from: a port, a recording, the emulated board.
    pub source: String,
    /// What happens on the line.
    pub line: Line,
    /// What was counted at this end of it.
    pub counts: Counts,
    /// The latest device time that was told, seconds since the board's first conversion.
    pub now_s: Option<f64>,
    /// Phase of the touch.
    pub phase: Phase,
    /// Since when, device time in seconds.
    pub phase_since_s: Option<f64>,
    /// Touches since the beginning.
    pub touches: u32,
    /// Times that the board has started anew.
    pub restarts: u32,
    latest: Latest,
    /// Estimates, oldest first.
    pub history: History,
    /// The latest raw frames: empty unless they were asked for.
    pub strips: Strips,
    /// What is wrong now, as it was told.
    #[serde(serialize_with = "fault_names")]
    faults: Vec<Fault>,
    /// What happened, a line each, oldest first: all packets but estimates, health, raw frames and orders done.
    pub log: VecDeque<String>,
}

impl Live {
    /// Nothing is known of what comes from `source`.
    pub fn new(source: impl Into<String>) -> Self {
        Self { source: source.into(), ..Self::default() }
    }

    /// Takes a packet.
    pub fn take(&mut self, packet: &Packet) {
        self.line = Line::There;
        if let Some(t_s) = time_s(&packet.event) {
            self.now_s = Some(self.now_s.map_or(t_s, |now_s| now_s.max(t_s)));
        }
        let kept = || Some(packet.clone());
        match &packet.event {
            Event::Hello(hello) => self.greeted(packet, hello),
            Event::Contact(contact) => {
                self.touches += 1;
                self.enter(Phase::Held, contact.t_us);
            }
            Event::Slide(slide) => match slide.end_us {
                None => self.enter(Phase::Sliding, slide.start_us),
                Some(end_us) => self.enter(Phase::HeldAfter, end_us),
            },
            Event::Release(release) => self.enter(Phase::Idle, release.t_us),
            Event::Estimate(estimate) => {
                self.history.push(Point::new(estimate));
                self.latest.estimate = kept();
                if estimate.span == Span::Slide {
                    self.latest.whole_slide = kept();
                }
            }
            Event::Image(image) => match image.hold {
                // Of another touch than the one after a slide that is still kept.
                Hold::BeforeSlide => (self.latest.image_before, self.latest.image_after) = (kept(), None),
                Hold::AfterSlide => self.latest.image_after = kept(),
            },
            Event::Health(_) => self.latest.health = kept(),
            Event::Fault(fault) => {
                self.faults.retain(|lasting| lasting.kind != fault.kind);
                if fault.until_us.is_none() {
                    self.faults.push(*fault);
                }
            }
            Event::Raw(raw) => self.strips.push(raw, self.settings().vref_v),
            Event::Reply(_) => {}
        }
        // What goes on all the time has a place of its own; that an order was done is what was asked for.
        let is_usual = match &packet.event {
            Event::Estimate(_) | Event::Health(_) | Event::Raw(_) | Event::Hello(_) => true,
            Event::Reply(reply) => reply.outcome == Outcome::Done,
            _ => false,
        };
        if !is_usual {
            // An image has its map behind it.
            self.note(events::text(packet).lines().next().unwrap_or_default());
        }
    }

    /// A greeting comes after start-up, every ten seconds, and when asked: most of them say nothing new.
    fn greeted(&mut self, packet: &Packet, hello: &Hello) {
        let is_new = self.hello() != Some(hello);
        let has_begun = packet.sequence == 0;
        if has_begun && self.latest.hello.is_some() {
            self.restarts += 1;
            // Its clock begins at zero again: what was before has no place on the same axis.
            self.clear();
            (self.now_s, self.faults) = (None, Vec::new());
        }
        if has_begun {
            (self.phase, self.phase_since_s) = (Phase::Idle, Some(0.0));
        }
        self.latest.hello = Some(packet.clone());
        if is_new || has_begun {
            self.note(events::text(packet));
        }
    }

    fn enter(&mut self, phase: Phase, t_us: u64) {
        (self.phase, self.phase_since_s) = (phase, Some(seconds(t_us)));
    }

    /// Adds a line to the log.
    pub fn note(&mut self, text: impl Into<String>) {
        if self.log.len() == LOG_LINES {
            self.log.pop_front();
        }
        self.log.push_back(text.into());
    }

    /// Forgets estimates, strips and static images, and the log.
    pub fn clear(&mut self) {
        let hello = self.latest.hello.take();
        let health = self.latest.health.take();
        self.latest = Latest { hello, health, ..Latest::default() };
        (self.history, self.strips) = (History::default(), Strips::default());
        self.log.clear();
    }

    /// The same without estimates, raw frames and log: what is small, and changes as a whole.
    #[must_use]
    pub fn without_rows(&self) -> Self {
        let Self { source, line, latest, faults, .. } = self;
        let (source, line, latest, faults) = (source.clone(), line.clone(), latest.clone(), faults.clone());
        let Self { counts, now_s, phase, phase_since_s, touches, restarts, .. } = *self;
        let (history, strips, log) = (History::default(), Strips::default(), VecDeque::new());
        Self {
            source,
            line,
            counts,
            now_s,
            phase,
            phase_since_s,
            touches,
            restarts,
            latest,
            history,
            strips,
            faults,
            log,
        }
    }

    /// What the board said of itself last.
    pub fn hello(&self) -> Option<&Hello> {
        match &self.latest.hello.as_ref()?.event {
            Event::Hello(hello) => Some(hello),
            _ => None,
        }
    }

    /// The settings in force, as far as they are known: otherwise the defaults.
    pub fn settings(&self) -> Settings {
        self.hello().map_or(Settings::DEFAULT, |hello| hello.settings)
    }

    /// The latest estimate: of a window, or of a whole slide.
    pub fn estimate(&self) -> Option<&Estimate> {
        estimate(self.latest.estimate.as_ref())
    }

    /// The latest estimate of a whole slide.
    pub fn whole_slide(&self) -> Option<&Estimate> {
        estimate(self.latest.whole_slide.as_ref())
    }

    /// The latest readings and counters of the board.
    pub fn health(&self) -> Option<&Health> {
        match &self.latest.health.as_ref()?.event {
            Event::Health(health) => Some(health),
            _ => None,
        }
    }

    /// The static image of a hold of the latest touch.
    pub fn image(&self, hold: Hold) -> Option<&Image> {
        let kept = match hold {
            Hold::BeforeSlide => &self.latest.image_before,
            Hold::AfterSlide => &self.latest.image_after,
        };
        match &kept.as_ref()?.event {
            Event::Image(image) => Some(image),
            _ => None,
        }
    }

    /// What is wrong now.
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// Times that each kind of fault was seen since the board's start, of those that were seen, by the latest health.
    pub fn faults_seen(&self) -> impl Iterator<Item = (FaultKind, u32)> {
        let counts = self.health().map_or([0; ridgetone_proto::fault::KINDS], |health| health.faults);
        FaultKind::ALL.into_iter().zip(counts).filter(|(_, count)| *count > 0)
    }

    /// The latest static image as a map of 4 x 4, volts; none where there is none, or the taxel is dead.
    pub fn map_v(&self) -> Option<(Hold, [[Option<f32>; static_image::SIDE]; static_image::SIDE])> {
        let image = self.image(Hold::AfterSlide).or_else(|| self.image(Hold::BeforeSlide))?;
        let levels = static_image::by_taxel(image).map(|found| found.map(|pressed| pressed.level_v));
        Some((image.hold, static_image::map(&levels)))
    }
}

fn estimate(packet: Option<&Packet>) -> Option<&Estimate> {
    match &packet?.event {
        Event::Estimate(estimate) => Some(estimate),
        _ => None,
    }
}

/// Device time of an event, seconds: of its end if it lasts. Some have none.
pub fn time_s(event: &Event) -> Option<f64> {
    event.t_us().map(seconds)
}

fn seconds(t_us: u64) -> f64 {
    t_us as f64 / 1e6
}

fn as_json<S: Serializer>(packet: &Option<Packet>, serializer: S) -> Result<S::Ok, S::Error> {
    packet.as_ref().map(events::serializable).serialize(serializer)
}

fn fault_names<S: Serializer>(faults: &[Fault], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(faults.iter().map(|fault| fault.kind))
}

#[cfg(test)]
mod tests;
