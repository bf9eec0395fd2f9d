//! One JSON object a packet. f32 values keep their shortest form, which reads back to the same f32.

use crate::digits::seconds;
use crate::feel::event::JsonFeel;
use crate::frame::Frame;
use crate::names::name;
use crate::settings_form::{SettingsForm, plan_form};
use crate::texture::overtones as overtones_as_sines;
use crate::tone::{JsonBeside, JsonTone, period_f32};
use crate::utc::{Receipt, Relation, UtcClock};
use ridgetone_proto::boot::{BrownOut, Death, Oscillator, ResetCause, SettingsSource};
use ridgetone_proto::command::Outcome;
use ridgetone_proto::fault::{Fault, FaultSet};
use ridgetone_proto::plan::{Gives, Plan};
use ridgetone_proto::settings::{Settings, SettingsError, TAXELS};
use ridgetone_proto::telemetry::{
    Abscissa, Channel, Contact, Direction, Event, Health, Image, Packet, Raw, Release, Slide, Span,
    Status, Texture, Travel, TravelStatus,
};
use ridgetone_stimulus::{HARMONICS_MAX, Harmonic};
use serde::Serialize;

/// A packet's kind in lower case, its number, and its content.
#[derive(Serialize)]
struct JsonPacket<'a> {
    r#type: String,
    sequence: u16,
    #[serde(flatten)]
    body: Body<'a>,
    #[serde(flatten)]
    receipt: Option<JsonReceipt>,
}

/// When a packet was received, and its own time in UTC, seconds since 1970.
#[derive(Serialize)]
struct JsonReceipt {
    received_utc_s: f64,
    utc_s: Option<f64>,
    utc_sigma_s: Option<f64>,
    /// Once a second.
    #[serde(flatten)]
    relation: Option<Relation>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Body<'a> {
    Hello {
        protocol: u8,
        version: String,
        frame_rate_hz: f32,
        #[serde(with = "SettingsForm")]
        settings: Settings,
        settings_source: SettingsSource,
        reset_cause: ResetCause,
        oscillator: Oscillator,
        brown_out: BrownOut,
        record: Option<JsonRecord<'a>>,
    },
    Contact(&'a Contact),
    Slide {
        t_s: f64,
        #[serde(flatten)]
        slide: &'a Slide,
        state: State,
    },
    Estimate {
        t_s: f64,
        window_s: f32,
        span: Span,
        abscissa: Abscissa,
        #[serde(flatten)]
        tone: JsonTone<f32>,
        #[serde(flatten)]
        beside: JsonBeside,
        status: Status,
        harmonics: u8,
        frames_missing: u16,
        faults: FaultSet,
        #[serde(flatten)]
        travel: JsonTravel,
        channels: &'a [Channel],
    },
    Release(&'a Release),
    Health(&'a Health),
    Image {
        t_s: f64,
        #[serde(flatten)]
        image: &'a Image,
    },
    Fault {
        t_s: f64,
        #[serde(flatten)]
        fault: &'a Fault,
        state: State,
    },
    Reply {
        number: u16,
        #[serde(flatten, with = "JsonOutcome")]
        outcome: &'a Outcome,
        #[serde(flatten)]
        gives: Option<&'a Gives>,
    },
    Raw {
        #[serde(flatten)]
        raw: &'a Raw,
        /// None without the reference that the greeting has.
        #[serde(skip_serializing_if = "Option::is_none")]
        volts: Option<[Option<f32>; TAXELS]>,
    },
    Feel(JsonFeel),
    Texture(JsonTexture),
}

/// Whether a slide or an episode of a fault begins or is over.
#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
enum State {
    Start,
    End,
}

impl State {
    const fn of(end_us: Option<u64>) -> Self {
        if end_us.is_some() {
            Self::End
        } else {
            Self::Start
        }
    }
}

/// How the run before this one ended.
#[derive(Serialize)]
struct JsonRecord<'a> {
    death: Death,
    board_time_s: f64,
    pc: String,
    lr: String,
    file: &'a str,
    line: u32,
}

/// [`Outcome`] with its name beside its values.
#[derive(Serialize)]
#[serde(remote = "Outcome", tag = "outcome", rename_all = "snake_case")]
enum JsonOutcome {
    Done,
    Setting(SettingsError),
    Profile,
    NotStored,
    Busy,
    DoneErased,
}

/// Spatial period, speed and direction; null where they are not known.
#[derive(Serialize)]
struct JsonTravel {
    travel: TravelStatus,
    direction: Option<Direction>,
    spatial_period_mm: Option<f32>,
    spatial_period_sigma_mm: Option<f32>,
    speed_mm_s: Option<f32>,
    speed_sigma_mm_s: Option<f32>,
}

impl From<&Travel> for JsonTravel {
    fn from(travel: &Travel) -> Self {
        let known = |value| travel.is_known().then_some(value);
        Self {
            travel: travel.status,
            direction: travel.direction.known(),
            spatial_period_mm: known(travel.spatial_period_mm),
            spatial_period_sigma_mm: known(travel.spatial_period_sigma_mm),
            speed_mm_s: known(travel.speed_mm_s),
            speed_sigma_mm_s: known(travel.speed_sigma_mm_s),
        }
    }
}

/// A texture, with its plan by name.
#[derive(Serialize)]
struct JsonTexture {
    t_s: f64,
    #[serde(with = "plan_form")]
    plan: Plan,
    period_mm: f32,
    period_sigma_mm: f32,
    power_v2: f32,
    power_sigma_v2: f32,
    overtones: [Harmonic; HARMONICS_MAX - 1],
    level_v: Option<f32>,
}

impl From<&Texture> for JsonTexture {
    fn from(texture: &Texture) -> Self {
        let Texture {
            t_us,
            plan,
            period_mm,
            period_sigma_mm,
            power_v2,
            power_sigma_v2,
            overtones,
            level_v,
        } = *texture;
        let overtones = overtones_as_sines(&overtones);
        Self {
            t_s: seconds(t_us),
            plan,
            period_mm,
            period_sigma_mm,
            power_v2,
            power_sigma_v2,
            overtones,
            level_v,
        }
    }
}

/// A packet as one JSON object on one line, without the line's end.
pub fn json(packet: &Packet) -> serde_json::Result<String> {
    serde_json::to_string(&serializable(packet))
}

/// The packets of a board as [`json`] has them; raw frames with volts beside the codes. It needs
/// all packets: the reference is in the greeting.
#[derive(Clone, Debug)]
pub struct JsonLines {
    vref_v: f32,
    clock: UtcClock,
}

impl Default for JsonLines {
    fn default() -> Self {
        Self {
            vref_v: Settings::DEFAULT.vref_v,
            clock: UtcClock::default(),
        }
    }
}

impl JsonLines {
    /// A packet as one JSON object on one line, without the line's end.
    pub fn line(
        &mut self,
        packet: &Packet,
        receipt: Option<Receipt>,
    ) -> serde_json::Result<String> {
        serde_json::to_string(&self.serializable(packet, receipt))
    }

    /// The same for a serializer.
    pub fn serializable(&mut self, packet: &Packet, receipt: Option<Receipt>) -> impl Serialize {
        if let Event::Hello(hello) = &packet.event {
            self.vref_v = hello.settings.vref_v;
        }
        let receipt = receipt.map(|receipt| {
            self.clock.take(packet, receipt);
            let utc = packet
                .event
                .t_us()
                .and_then(|t_us| self.clock.utc(seconds(t_us)));
            let is_health = matches!(packet.event, Event::Health(_));
            JsonReceipt {
                received_utc_s: receipt.utc_s(),
                utc_s: utc.map(|utc| utc.utc_s()),
                utc_sigma_s: utc.map(|utc| utc.sigma_s),
                relation: utc.filter(|_| is_health).map(|utc| utc.relation),
            }
        });
        JsonPacket {
            receipt,
            ..with_reference(packet, Some(self.vref_v))
        }
    }
}

/// A packet in the form of [`json`], for a serializer.
pub fn serializable(packet: &Packet) -> impl Serialize {
    with_reference(packet, None)
}

fn with_reference(packet: &Packet, vref_v: Option<f32>) -> JsonPacket<'_> {
    let t_s = packet.event.t_us().map_or(0.0, seconds);
    let body = match &packet.event {
        Event::Hello(e) => Body::Hello {
            protocol: e.protocol,
            version: e.version.map(|part| part.to_string()).join("."),
            frame_rate_hz: e.frame_rate_hz,
            settings: e.settings,
            settings_source: e.source,
            reset_cause: e.boot.cause,
            oscillator: e.boot.oscillator,
            brown_out: e.boot.brown_out,
            record: e.boot.record.as_ref().map(|record| JsonRecord {
                death: record.death,
                board_time_s: f64::from(record.t_us) / 1e6,
                pc: format!("{:#010x}", record.pc),
                lr: format!("{:#010x}", record.lr),
                file: &record.file,
                line: record.line,
            }),
        },
        Event::Contact(contact) => Body::Contact(contact),
        Event::Slide(slide) => Body::Slide {
            t_s,
            slide,
            state: State::of(slide.end_us),
        },
        Event::Estimate(e) => Body::Estimate {
            t_s,
            window_s: e.window_s,
            span: e.span,
            abscissa: e.abscissa,
            tone: JsonTone::new(
                e.abscissa,
                e.status.has_tone().then_some((e.frequency, e.sigma)),
                period_f32,
            ),
            beside: JsonBeside::new(e.abscissa, &e.into()),
            status: e.status,
            harmonics: e.harmonics,
            frames_missing: e.frames_missing,
            faults: e.faults,
            travel: (&e.travel).into(),
            channels: &e.channels,
        },
        Event::Release(release) => Body::Release(release),
        Event::Health(health) => Body::Health(health),
        Event::Image(image) => Body::Image { t_s, image },
        Event::Fault(fault) => Body::Fault {
            t_s,
            fault,
            state: State::of(fault.until_us),
        },
        Event::Reply(e) => Body::Reply {
            number: e.number,
            outcome: &e.outcome,
            gives: e.gives.as_ref(),
        },
        Event::Feel(feel) => Body::Feel(feel.into()),
        Event::Texture(texture) => Body::Texture(texture.into()),
        Event::Raw(raw) => Body::Raw {
            raw,
            volts: vref_v.map(|vref_v| Frame::new(raw, vref_v).volts),
        },
    };
    JsonPacket {
        r#type: name(&packet.event).to_lowercase(),
        sequence: packet.sequence,
        body,
        receipt: None,
    }
}

#[cfg(test)]
mod tests;
