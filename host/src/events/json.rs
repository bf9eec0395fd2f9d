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
    Abscissa, Channel, Contact, Direction, Event, Health, Image, Packet, Pins, Raw, Release, Slide, Span, Status,
    Texture, Travel, TravelStatus,
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
    Pins(PinForces),
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
        if end_us.is_some() { Self::End } else { Self::Start }
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
        let Texture { t_us, plan, period_mm, period_sigma_mm, power_v2, power_sigma_v2, overtones, level_v } = *texture;
        let overtones = overtones_as_sines(&overtones);
        Self { t_s: seconds(t_us), plan, period_mm, period_sigma_mm, power_v2, power_sigma_v2, overtones, level_v }
    }
}

/// Forces of a display, the board's and those that `ridgetone pins` computes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PinForces {
    /// Device time, seconds.
    pub t_s: f64,
    pub rows: usize,
    pub columns: usize,
    /// Row by row, newtons.
    pub forces_n: Vec<f32>,
    /// Force of a level, newtons.
    pub level_n: f32,
    /// Pins whose wanted force is beyond the display's limits.
    pub limited: usize,
    /// Updates that were left out before this one.
    pub skipped: u8,
    pub is_optimal: bool,
    /// Bit k: taxel k counts.
    pub taxels: u16,
}

impl From<&Pins> for PinForces {
    fn from(pins: &Pins) -> Self {
        let Pins { t_us, taxels, limited, skipped, is_optimal, level_n, .. } = *pins;
        let (side, limited) = (pins.side(), limited.into());
        let forces_n = pins.forces_n().collect();
        Self { t_s: seconds(t_us), rows: side, columns: side, forces_n, level_n, limited, skipped, is_optimal, taxels }
    }
}

/// A packet as one JSON object on one line, without the line's end.
pub fn json(packet: &Packet) -> serde_json::Result<String> {
    serde_json::to_string(&serializable(packet))
}

/// The packets of a board as [`json`] has them; raw frames with volts beside the codes. It needs all packets: the reference is
/// in the greeting.
#[derive(Clone, Debug)]
pub struct JsonLines {
    vref_v: f32,
    clock: UtcClock,
}

impl Default for JsonLines {
    fn default() -> Self {
        Self { vref_v: Settings::DEFAULT.vref_v, clock: UtcClock::default() }
    }
}

impl JsonLines {
    /// A packet as one JSON object on one line, without the line's end.
    pub fn line(&mut self, packet: &Packet, receipt: Option<Receipt>) -> serde_json::Result<String> {
        serde_json::to_string(&self.serializable(packet, receipt))
    }

    /// The same for a serializer.
    pub fn serializable(&mut self, packet: &Packet, receipt: Option<Receipt>) -> impl Serialize {
        if let Event::Hello(hello) = &packet.event {
            self.vref_v = hello.settings.vref_v;
        }
        let receipt = receipt.map(|receipt| {
            self.clock.take(packet, receipt);
            let utc = packet.event.t_us().and_then(|t_us| self.clock.utc(seconds(t_us)));
            let is_health = matches!(packet.event, Event::Health(_));
            JsonReceipt {
                received_utc_s: receipt.utc_s(),
                utc_s: utc.map(|utc| utc.utc_s()),
                utc_sigma_s: utc.map(|utc| utc.sigma_s),
                relation: utc.filter(|_| is_health).map(|utc| utc.relation),
            }
        });
        JsonPacket { receipt, ..with_reference(packet, Some(self.vref_v)) }
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
        Event::Slide(slide) => Body::Slide { t_s, slide, state: State::of(slide.end_us) },
        Event::Estimate(e) => Body::Estimate {
            t_s,
            window_s: e.window_s,
            span: e.span,
            abscissa: e.abscissa,
            tone: JsonTone::new(e.abscissa, e.status.has_tone().then_some((e.frequency, e.sigma)), period_f32),
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
        Event::Fault(fault) => Body::Fault { t_s, fault, state: State::of(fault.until_us) },
        Event::Reply(e) => Body::Reply { number: e.number, outcome: &e.outcome, gives: e.gives.as_ref() },
        Event::Feel(feel) => Body::Feel(feel.into()),
        Event::Texture(texture) => Body::Texture(texture.into()),
        Event::Pins(pins) => Body::Pins(pins.into()),
        Event::Raw(raw) => Body::Raw { raw, volts: vref_v.map(|vref_v| Frame::new(raw, vref_v).volts) },
    };
    JsonPacket { r#type: name(&packet.event).to_lowercase(), sequence: packet.sequence, body, receipt: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::fault::FaultKind;
    use ridgetone_proto::telemetry::{BANDS, Estimate, Feel, Hold, Measured, Movement, NO_LEVEL, OtherTone, Pressed};

    #[test]
    fn f32_values_read_back_to_the_last_bit() {
        let height_v = 0.1f32 + f32::EPSILON;
        let contact = Event::Contact(Contact { t_us: 510_003, taxel: 3, height_v });
        let line = json(&Packet { sequence: 7, event: contact }).unwrap();
        assert_eq!(
            line,
            format!(r#"{{"type":"contact","sequence":7,"t_s":0.510003,"taxel":3,"height_v":{height_v}}}"#)
        );
        let text = line.rsplit(':').next().unwrap().trim_end_matches('}');
        assert_eq!(text.parse::<f32>().unwrap().to_bits(), height_v.to_bits());
    }

    #[test]
    fn an_image_has_the_taxels_that_are_alive() {
        let taxels = [0, 2].map(|taxel| Pressed { taxel, level_v: 0.5, sigma_v: 0.25 }).into_iter().collect();
        let image = Image { start_us: 3_500_000, end_us: 4_500_000, frames: 240, hold: Hold::AfterSlide, taxels };
        let line = json(&Packet { sequence: 9, event: Event::Image(image) }).unwrap();
        assert_eq!(
            line,
            r#"{"type":"image","sequence":9,"t_s":4.5,"start_s":3.5,"end_s":4.5,"frames":240,"hold":"after_slide","taxels":[{"taxel":0,"level_v":0.5,"sigma_v":0.25},{"taxel":2,"level_v":0.5,"sigma_v":0.25}]}"#
        );
    }

    #[test]
    fn without_a_tone_there_is_no_frequency() {
        let estimate = Estimate {
            t_us: 2_000_000,
            window_s: 1.0,
            span: Span::Window,
            status: Status::NoTone,
            abscissa: Abscissa::Time,
            frequency: 0.0,
            sigma: 0.0,
            movement: Movement::default(),
            other_tone: None,
            interferer_hz: Some(50.5),
            harmonics: 0,
            frames_missing: 2,
            faults: FaultSet::NONE.with(FaultKind::Lost),
            travel: Travel::NONE,
            channels: Default::default(),
        };
        let line = json(&Packet { sequence: 0, event: Event::Estimate(estimate) }).unwrap();
        assert_eq!(
            line,
            r#"{"type":"estimate","sequence":0,"t_s":2.0,"window_s":1.0,"span":"window","abscissa":"time","frequency_hz":null,"sigma_hz":null,"wander_percent":null,"wander_sigma_percent":null,"sigma_mean_hz":null,"chirp_hz_per_s":null,"chirp_sigma_hz_per_s":null,"other_tone_hz":null,"other_tone_share":null,"interferer_hz":50.5,"status":"no_tone","harmonics":0,"frames_missing":2,"faults":["lost"],"travel":"nothing","direction":null,"spatial_period_mm":null,"spatial_period_sigma_mm":null,"speed_mm_s":null,"speed_sigma_mm_s":null,"channels":[]}"#
        );
    }

    #[test]
    fn by_place_it_is_cycles_per_millimetre_and_the_period() {
        let estimate = Estimate {
            t_us: 2_000_000,
            window_s: 1.0,
            span: Span::Window,
            status: Status::Good,
            abscissa: Abscissa::Place,
            frequency: 0.25,
            sigma: 0.0625,
            movement: Movement {
                wander: 0.03125,
                wander_sigma: 0.015625,
                sigma_mean: 0.5,
                chirp: -0.75,
                chirp_sigma: 0.125,
            },
            other_tone: Some(OtherTone { frequency: 0.375, share: 0.5 }),
            interferer_hz: None,
            harmonics: 1,
            frames_missing: 0,
            faults: FaultSet::NONE,
            travel: Travel {
                status: TravelStatus::Given,
                direction: Direction::Backward,
                spatial_period_mm: 4.0,
                spatial_period_sigma_mm: 1.0,
                speed_mm_s: 30.0,
                speed_sigma_mm_s: 0.0,
            },
            channels: Default::default(),
        };
        let line = json(&Packet { sequence: 0, event: Event::Estimate(estimate) }).unwrap();
        let tone = r#""abscissa":"place","frequency_per_mm":0.25,"sigma_per_mm":0.0625,"period_mm":4.0,"period_sigma_mm":1.0,"wander_percent":3.125,"wander_sigma_percent":1.5625,"sigma_mean_per_mm":0.5,"chirp_per_mm2":-0.75,"chirp_sigma_per_mm2":0.125,"other_tone_per_mm":0.375,"other_tone_share":0.5,"interferer_hz":null,"status""#;
        assert!(line.contains(tone), "{line}");
        let travel = r#""travel":"given","direction":"backward","spatial_period_mm":4.0,"spatial_period_sigma_mm":1.0,"speed_mm_s":30.0,"speed_sigma_mm_s":0.0,"channels""#;
        assert!(line.contains(travel), "{line}");
    }

    /// The forms that Python, the page and the topic `feel` read: a receptor that fires, and one that the rate is too low for.
    #[test]
    fn what_a_finger_feels_has_values_or_the_reason_why_not() {
        let measured = |value| Some(Measured { value, sigma: 0.5 });
        let mut levels_db = [NO_LEVEL; BANDS];
        levels_db[3] = -7;
        let feel = Feel {
            t_us: 2_000_000,
            window_s: 0.5,
            rate_hz: 512.0,
            taxels: 0b101,
            faults: FaultSet::NONE.with(FaultKind::Lost),
            per_hz: [measured(4.0), None, measured(2.0), None],
            force_ratio: None,
            soft: measured(5.5),
            rough: None,
            levels_db,
        };
        let line = json(&Packet { sequence: 4, event: Event::Feel(feel) }).unwrap();
        let fires = |name: &str, value: f32| {
            let half = 0.5 * value;
            format!(
                r#"{{"receptor":"{name}","intensity":{half:?},"intensity_sigma":0.25,"intensity_per_hz":{value:?},"intensity_per_hz_sigma":0.5}}"#
            )
        };
        let absent = |name: &str, why: &str| {
            format!(
                r#"{{"receptor":"{name}","intensity":null,"intensity_sigma":null,"intensity_per_hz":null,"intensity_per_hz_sigma":null,"absent":"{why}, here are 512.00"}}"#
            )
        };
        let receptors = [
            fires("fa1", 4.0),
            absent("fa2", "FA II needs more than 1600 rows a second"),
            fires("sa1", 2.0),
            absent("sa2", "SA II needs more than 800 rows a second"),
        ];
        // The middle of the fourth third of an octave from 0.5 Hz on: half a third above 1 Hz.
        let hz = 2f32.powf(0.5 / 3.0);
        let level = format!(r#""spectrum":[{{"hz":{hz},"level_db":-7}}]}}"#);
        let scores = r#""scores":[{"name":"soft","score":5.5,"score_sigma":0.5},{"name":"rough","score":null,"score_sigma":null,"absent":"needs the intensity of FA II"}],"#;
        let head = r#"{"type":"feel","sequence":4,"t_s":2.0,"window_s":0.5,"rate_hz":512.0,"taxels":5,"faults":["lost"],"m":null,"m_sigma":null,"#;
        assert_eq!(line, format!(r#"{head}"receptors":[{}],{scores}{level}"#, receptors.join(",")));
    }

    #[test]
    fn a_texture_has_its_plan_by_name() {
        let texture = Texture {
            t_us: 2_500_000,
            plan: Plan::HAND,
            period_mm: 3.5,
            period_sigma_mm: 0.25,
            power_v2: 0.5,
            power_sigma_v2: 0.125,
            overtones: [[0.0, 0.5], [0.0; 2], [0.0, -0.25]],
            level_v: None,
        };
        let line = |texture| json(&Packet { sequence: 4, event: Event::Texture(texture) }).unwrap();
        assert_eq!(
            line(texture),
            r#"{"type":"texture","sequence":4,"t_s":2.5,"plan":"hand","period_mm":3.5,"period_sigma_mm":0.25,"power_v2":0.5,"power_sigma_v2":0.125,"overtones":[{"amplitude":0.5,"phase_cycles":0.0},{"amplitude":0.0,"phase_cycles":0.0},{"amplitude":0.25,"phase_cycles":0.0}],"level_v":null}"#
        );
        assert!(line(Texture { level_v: Some(0.75), ..texture }).ends_with(r#""level_v":0.75}"#));
    }

    #[test]
    fn pins_have_their_forces_in_newtons() {
        let levels = [0, 4, 250, 1].iter().copied().collect();
        let pins =
            Pins { t_us: 2_500_000, taxels: 0xf0ff, limited: 1, skipped: 2, is_optimal: true, level_n: 0.25, levels };
        assert_eq!(
            json(&Packet { sequence: 4, event: Event::Pins(pins) }).unwrap(),
            r#"{"type":"pins","sequence":4,"t_s":2.5,"rows":2,"columns":2,"forces_n":[0.0,1.0,62.5,0.25],"level_n":0.25,"limited":1,"skipped":2,"is_optimal":true,"taxels":61695}"#
        );
    }

    #[test]
    fn a_slide_is_reported_at_its_start_and_its_end() {
        let line = |end_us| json(&Packet { sequence: 1, event: Event::Slide(Slide { start_us: 1_500_000, end_us }) });
        assert_eq!(
            line(None).unwrap(),
            r#"{"type":"slide","sequence":1,"t_s":1.5,"start_s":1.5,"end_s":null,"state":"start"}"#
        );
        assert_eq!(
            line(Some(3_500_000)).unwrap(),
            r#"{"type":"slide","sequence":1,"t_s":3.5,"start_s":1.5,"end_s":3.5,"state":"end"}"#
        );
    }
}
