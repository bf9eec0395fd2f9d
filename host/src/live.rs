//! The state of a board, folded from the packets of a [`crate::feed`]: the model behind the
//! terminal's screen and the web page. It draws nothing.
//!
//! [`Live`] can be serialised. Packets in it have the same names as with `--json`
//! ([`crate::events::json`]).

mod bounded;
mod history;
mod strips;

pub use history::{History, POINTS, point};
pub use strips::{STRIP_FRAMES, Strips, columns};

use crate::digits::{seconds, time_s};
use crate::events;
use crate::frame::Frame;
use bounded::Bounded;
use ridgetone_proto::command::Outcome;
use ridgetone_proto::fault::Fault;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{
    Decoder, Estimate, Event, Health, Hello, Hold, Image, Packet, Span, Starts,
};
use serde::{Serialize, Serializer};

pub type Log = Bounded<String, 200>;

/// Phase of a touch (paper, section 3.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// No packet has shown the phase yet.
    #[default]
    Unknown,
    /// Nothing touches the finger.
    Idle,
    /// The finger is touched, but nothing has slid yet.
    Held,
    Sliding,
    /// The slide is over, but the finger is still touched.
    HeldAfter,
}

#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum Connection {
    /// Nothing has been received yet.
    #[default]
    Waiting,
    Connected,
    /// The board is unplugged; the source waits for it.
    Disconnected {
        why: String,
    },
    /// A recording or a scene is over.
    Over,
}

/// Counts of packets at this end of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub received: u64,
    /// Packets that never arrived, by their sequence numbers.
    pub missing: u32,
    /// Packets with a wrong checksum.
    pub damaged: u32,
    /// Number of times that the sequence number stepped back.
    pub stepped_back: u32,
}

impl Counts {
    /// Combines a decoder's counts with the number of packets that it returned.
    pub fn of(decoder: &Decoder, received: u64) -> Self {
        let Decoder {
            missing,
            damaged,
            stepped_back,
            ..
        } = *decoder;
        Self {
            received,
            missing,
            damaged,
            stepped_back,
        }
    }
}

/// A packet, serialised as with `--json`.
#[derive(Clone, Debug)]
struct Kept(Packet);

impl Serialize for Kept {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        events::serializable(&self.0).serialize(serializer)
    }
}

/// The latest packet of each kind that a screen shows.
#[derive(Clone, Debug, Default, Serialize)]
struct Latest {
    hello: Option<Kept>,
    estimate: Option<Kept>,
    whole_slide: Option<Kept>,
    image_before: Option<Kept>,
    image_after: Option<Kept>,
    health: Option<Kept>,
    texture: Option<Kept>,
}

/// The part of the state that is small enough for the web page to receive it as a whole.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Now {
    /// Name of the source: a port, a recording, the emulated board.
    pub source: String,
    pub connection: Connection,
    pub counts: Counts,
    /// Description of bytes on the line that are not packets.
    #[serde(skip)]
    pub strangers: Option<String>,
    /// The latest device time, seconds since the board's first conversion.
    pub now_s: Option<f64>,
    pub phase: Phase,
    /// Beginning of the phase, device time in seconds.
    pub phase_since_s: Option<f64>,
    pub touches: u32,
    /// The latest contact, device time in seconds.
    pub contact_s: Option<f64>,
    pub restarts: u32,
    latest: Latest,
    /// Faults that have not ended.
    #[serde(serialize_with = "fault_names")]
    pub faults: Vec<Fault>,
}

/// The state of a board, as far as its packets report it.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Live {
    #[serde(flatten)]
    pub now: Now,
    pub history: History,
    /// The latest raw frames; empty unless requested.
    #[serde(serialize_with = "columns")]
    pub strips: Strips,
    /// Events, one line each, oldest first: all packets except estimates, tracks, health, raw
    /// frames and completed requests.
    pub log: Log,
    #[serde(skip)]
    starts: Starts,
}

/// Makes a method for each kind that returns the event of the latest packet of that kind.
macro_rules! latest {
    ($($field:ident: $event:ident),*) => {
        $(pub fn $field(&self) -> Option<&$event> {
            match &self.now.latest.$field.as_ref()?.0.event {
                Event::$event(event) => Some(event),
                _ => None,
            }
        })*
    };
}

impl Live {
    /// Returns the state before the first packet from `source`.
    pub fn new(source: impl Into<String>) -> Self {
        let now = Now {
            source: source.into(),
            ..Now::default()
        };
        Self {
            now,
            ..Self::default()
        }
    }

    latest!(hello: Hello, estimate: Estimate, whole_slide: Estimate, image_before: Image, image_after: Image, health: Health);

    pub fn take(&mut self, packet: &Packet) {
        let has_restarted = self.starts.take(&packet.event);
        if has_restarted {
            self.restarted();
        }
        let now = &mut self.now;
        now.connection = Connection::Connected;
        if let Some(t_s) = time_s(&packet.event) {
            now.now_s = Some(now.now_s.map_or(t_s, |now_s| now_s.max(t_s)));
        }
        let kept = || Some(Kept(packet.clone()));
        match &packet.event {
            Event::Hello(hello) => self.greeted(packet, hello, has_restarted),
            Event::Contact(contact) => {
                now.touches += 1;
                now.contact_s = Some(seconds(contact.t_us));
                now.enter(Phase::Held, contact.t_us);
            }
            Event::Slide(slide) => match slide.end_us {
                None => now.enter(Phase::Sliding, slide.start_us),
                Some(end_us) => now.enter(Phase::HeldAfter, end_us),
            },
            Event::Release(release) => now.enter(Phase::Idle, release.t_us),
            Event::Estimate(estimate) => {
                self.history.push(point(estimate));
                now.latest.estimate = kept();
                if estimate.span == Span::Slide {
                    now.latest.whole_slide = kept();
                }
            }
            Event::Image(image) => match image.hold {
                // An image after a slide that is still kept belongs to the previous touch.
                Hold::BeforeSlide => {
                    (now.latest.image_before, now.latest.image_after) = (kept(), None)
                }
                Hold::AfterSlide => now.latest.image_after = kept(),
            },
            Event::Health(_) => now.latest.health = kept(),
            Event::Fault(fault) => {
                now.faults.retain(|lasting| lasting.kind != fault.kind);
                if fault.until_us.is_none() {
                    now.faults.push(*fault);
                }
            }
            Event::Raw(raw) => self.strips.push(Frame::new(raw, self.settings().vref_v)),
            Event::Texture(_) => now.latest.texture = kept(),
            _ => {}
        }
        // The log takes only what no other part of the screen shows. A request that succeeded, or a
        // converter that answers, is not logged.
        let is_usual = match &packet.event {
            Event::Estimate(_)
            | Event::Track(_)
            | Event::Health(_)
            | Event::Raw(_)
            | Event::Hello(_) => true,
            Event::Reply(reply) => reply.outcome == Outcome::Done,
            Event::Converter(state) => state.answers,
            _ => false,
        };
        if !is_usual {
            // Log only the first line of an image; the others are its map.
            self.note(events::text(packet).lines().next().unwrap_or_default());
        }
    }

    /// Handles a greeting. The board sends one after start-up, every ten seconds and on request;
    /// most change nothing.
    fn greeted(&mut self, packet: &Packet, hello: &Hello, has_restarted: bool) {
        let at_that_time = |before: &Hello| Hello {
            t_us: hello.t_us,
            ..before.clone()
        };
        let is_new = self.hello().map(at_that_time).as_ref() != Some(hello);
        if self.now.latest.hello.is_none() && hello.t_us == 0 {
            (self.now.phase, self.now.phase_since_s) = (Phase::Idle, Some(0.0));
        }
        self.now.latest.hello = Some(Kept(packet.clone()));
        if is_new || has_restarted {
            self.note(events::text(packet));
        }
    }

    /// Forgets earlier data: the board's clock starts at zero again.
    fn restarted(&mut self) {
        self.now.restarts += 1;
        self.clear();
        (self.now.now_s, self.now.contact_s, self.now.faults) = (None, None, Vec::new());
        (self.now.phase, self.now.phase_since_s) = (Phase::Idle, Some(0.0));
    }

    pub fn note(&mut self, text: impl Into<String>) {
        self.log.push(text.into());
    }

    /// Deletes estimates, strips, static images and the log.
    pub fn clear(&mut self) {
        let Latest { hello, health, .. } = std::mem::take(&mut self.now.latest);
        self.now.latest = Latest {
            hello,
            health,
            ..Latest::default()
        };
        *self = Self {
            now: std::mem::take(&mut self.now),
            starts: std::mem::take(&mut self.starts),
            ..Self::default()
        };
    }

    /// Returns the settings in force if the board has reported them, otherwise the defaults.
    pub fn settings(&self) -> Settings {
        self.hello()
            .map_or(Settings::DEFAULT, |hello| hello.settings)
    }

    /// True if an estimate belongs to an earlier touch.
    pub fn is_past(&self, estimate: &Estimate) -> bool {
        let contact_s = self.now.contact_s;
        contact_s.is_some_and(|contact_s| seconds(estimate.t_us) < contact_s)
    }

    pub fn image(&self) -> Option<&Image> {
        self.image_after().or_else(|| self.image_before())
    }
}

impl Now {
    fn enter(&mut self, phase: Phase, t_us: u64) {
        (self.phase, self.phase_since_s) = (phase, Some(seconds(t_us)));
    }
}

fn fault_names<S: Serializer>(faults: &[Fault], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(faults.iter().map(|fault| fault.kind))
}

#[cfg(test)]
mod tests;
