//! Messages of a board as programs see them: one struct per event, made from the wire by a `From`.
//!
//! Everything else follows from these structs: lines of JSON, their schemas, the columns of tables,
//! the topics of streams, the lists of `host/reference.md` and Python's classes. Doc comments become
//! descriptions, and the end of a field's name is its unit. After a change run `cargo xtask events`.

use crate::digits::seconds;
use crate::names::name;
use crate::settings_form;
use crate::utc::Relation;
use ridgetone_proto::boot::{BrownOut, Death, Oscillator, ResetCause, SettingsSource};
use ridgetone_proto::command::Outcome;
use ridgetone_proto::fault::{FaultKind, FaultSet, KINDS};
use ridgetone_proto::plan::Gives;
use ridgetone_proto::settings::{Settings, SettingsError, TAXELS};
use ridgetone_proto::telemetry::{
    self as wire, Channel, Direction, Event, Hold, Packet, Pressed, Span, Status, TravelStatus,
};
#[cfg(test)]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Serialize, Serializer};

/// A packet's kind in lower case, its number, its content, and when it was received.
#[derive(Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Message {
    /// Kind of the message.
    r#type: String,
    /// Number of the message since the board's start, modulo 65536.
    sequence: u16,
    #[serde(flatten)]
    #[cfg_attr(test, schemars(skip))]
    body: View,
    #[serde(flatten)]
    pub receipt: Option<Received>,
}

/// When a message was received, and its own time in UTC: only in lines from a board, or from a
/// recording of one.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Received {
    /// When this computer received the message, UTC since 1970.
    pub received_utc_s: f64,
    /// `t_s` in UTC, since 1970; null before the relation of the clocks is known.
    pub utc_s: Option<f64>,
    /// Standard deviation of `utc_s`; null in the first quarter of a second, when it is not yet
    /// known.
    pub utc_sigma_s: Option<f64>,
    #[serde(flatten)]
    pub relation: Option<Relation>,
}

/// The content of a message, by its kind.
#[derive(Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(untagged)]
pub enum View {
    Hello(Box<Hello>),
    Contact(Contact),
    Slide(Slide),
    Estimate(Box<Estimate>),
    Release(Release),
    Health(Box<Health>),
    Image(Image),
    Fault(Fault),
    Reply(Reply),
    Raw(Box<Raw>),
    Texture(Texture),
    Converter(Converter),
    Track(Track),
    Moving(Moving),
}

impl Message {
    /// Makes a message. Voltages of raw frames need the reference, which is in the greeting.
    pub fn new(packet: &Packet, vref_v: Option<f32>) -> Self {
        let body = match &packet.event {
            Event::Hello(event) => View::Hello(Box::new(event.into())),
            Event::Contact(event) => View::Contact(event.into()),
            Event::Slide(event) => View::Slide(event.into()),
            Event::Estimate(event) => View::Estimate(Box::new(event.into())),
            Event::Release(event) => View::Release(event.into()),
            Event::Health(event) => View::Health(Box::new(event.into())),
            Event::Image(event) => View::Image(event.into()),
            Event::Fault(event) => View::Fault(event.into()),
            Event::Reply(event) => View::Reply(event.into()),
            Event::Raw(event) => View::Raw(Box::new(Raw::new(event, vref_v))),
            Event::Texture(event) => View::Texture(event.into()),
            Event::Converter(event) => View::Converter(event.into()),
            Event::Track(event) => View::Track(event.into()),
            Event::Moving(event) => View::Moving(event.into()),
        };
        Self {
            r#type: name(&packet.event).to_lowercase(),
            sequence: packet.sequence,
            body,
            receipt: None,
        }
    }
}

/// Beginning or end of a slide or of a fault's episode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum State {
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

/// The greeting: after start-up, every ten seconds, and on request.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Hello {
    /// Device time; 0 until the first conversion. A time below the previous one means that the
    /// board has restarted.
    pub t_s: f64,
    /// Version of the wire contract.
    pub protocol: u8,
    /// Version of the firmware.
    pub version: String,
    /// Nominal frames per second.
    pub frame_rate_hz: f32,
    /// Settings in force, by the names of the settings file.
    #[serde(serialize_with = "settings_form::serialize")]
    #[cfg_attr(test, schemars(schema_with = "any_object"))]
    pub settings: Settings,
    /// Where the settings come from.
    pub settings_source: SettingsSource,
    /// Cause of the processor's latest reset.
    pub reset_cause: ResetCause,
    /// Source of the processor's clock; `internal` if the external oscillator did not start.
    pub oscillator: Oscillator,
    /// Supply level that resets the board.
    pub brown_out: BrownOut,
    /// How the previous run ended, if it crashed.
    pub record: Option<Record>,
    /// Centre of each taxel's unit relative to the array's centre, along and across the sliding
    /// direction; only in streams.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub positions_mm: Option<[[f64; 2]; TAXELS]>,
}

/// How the previous run ended.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Record {
    /// Cause of the end.
    pub death: Death,
    /// The board's counter at the end; it wraps after 71.6 minutes.
    pub board_time_s: f64,
    /// Address of the faulting instruction, after a HardFault.
    pub pc: String,
    /// Return address of the function, after a HardFault.
    pub lr: String,
    /// End of the source file's name, after a panic.
    pub file: String,
    /// Line in the source file, after a panic.
    pub line: u32,
}

impl From<&wire::Hello> for Hello {
    fn from(event: &wire::Hello) -> Self {
        let record = event.boot.record.as_ref().map(|record| Record {
            death: record.death,
            board_time_s: f64::from(record.t_us) / 1e6,
            pc: format!("{:#010x}", record.pc),
            lr: format!("{:#010x}", record.lr),
            file: record.file.as_str().to_owned(),
            line: record.line,
        });
        Self {
            t_s: seconds(event.t_us),
            protocol: event.protocol,
            version: event.version.map(|part| part.to_string()).join("."),
            frame_rate_hz: event.frame_rate_hz,
            settings: event.settings,
            settings_source: event.source,
            reset_cause: event.boot.cause,
            oscillator: event.boot.oscillator,
            brown_out: event.boot.brown_out,
            record,
            positions_mm: None,
        }
    }
}

/// A contact: the spike is over.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Contact {
    /// Device time of the spike.
    pub t_s: f64,
    /// Taxel with the clearest spike, 0 to 15.
    pub taxel: u8,
    /// Height of the spike over the level without touch, signed.
    pub height_v: f32,
    /// When the load began to rise; for a load that creeps in, long before the spike.
    pub onset_s: f64,
    /// Time from `t_s` until the event left the board's detector.
    pub reported_after_s: f64,
}

impl From<&wire::Contact> for Contact {
    fn from(event: &wire::Contact) -> Self {
        Self {
            t_s: seconds(event.t_us),
            taxel: event.taxel,
            height_v: event.height_v,
            onset_s: seconds(event.onset_us),
            reported_after_s: seconds(event.reported_after_us.into()),
        }
    }
}

/// The first sign of a motion along the surface in a hold. A `slide` follows if the motion lasts; a
/// knock has none.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Moving {
    /// Device time of the first frame that shows the motion.
    pub t_s: f64,
    /// Time from `t_s` until the event left the board's detector.
    pub reported_after_s: f64,
}

impl From<&wire::Moving> for Moving {
    fn from(event: &wire::Moving) -> Self {
        Self {
            t_s: seconds(event.t_us),
            reported_after_s: seconds(event.reported_after_us.into()),
        }
    }
}

/// Start or end of the sliding phase. If the finger was already touching something at start-up, no
/// `contact` precedes it.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Slide {
    /// Device time of the beginning or, once it is over, of the end.
    pub t_s: f64,
    /// Device time of the beginning.
    pub start_s: f64,
    /// Device time of the end; null while it lasts.
    pub end_s: Option<f64>,
    /// Beginning or end of the slide.
    pub state: State,
    /// Time from `t_s` until the event left the board's detector.
    pub reported_after_s: f64,
}

impl From<&wire::Slide> for Slide {
    fn from(event: &wire::Slide) -> Self {
        Self {
            t_s: seconds(event.end_us.unwrap_or(event.start_us)),
            start_s: seconds(event.start_us),
            end_s: event.end_us.map(seconds),
            state: State::of(event.end_us),
            reported_after_s: seconds(event.reported_after_us.into()),
        }
    }
}

/// One fit: every stride of a slide, and for the whole of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Estimate {
    /// Device time of the window's end.
    pub t_s: f64,
    /// Length of the window.
    pub window_s: f32,
    /// What the window covers.
    pub span: Span,
    /// Common frequency, mean over the window; null without a tone, like all of its details.
    pub frequency_hz: Option<f32>,
    /// Standard deviation of the frequency.
    pub sigma_hz: Option<f32>,
    /// RMS deviation of the frequency from its mean over the window.
    pub wander_percent: Option<f32>,
    /// Standard deviation of the wander.
    pub wander_sigma_percent: Option<f32>,
    /// Change of the frequency with time.
    pub chirp_hz_per_s: Option<f32>,
    /// Standard deviation of the chirp.
    pub chirp_sigma_hz_per_s: Option<f32>,
    /// Frequency of a second tone that is significant next to the first.
    pub other_tone_hz: Option<f32>,
    /// Power of the second tone over that of the first.
    pub other_tone_fraction: Option<f32>,
    /// Frequency of the interferer as fitted; null if none is set, or if the window is too short
    /// to fit it.
    pub interferer_hz: Option<f32>,
    /// How far the estimate can be trusted.
    pub status: Status,
    /// Harmonics in the fit, the fundamental included.
    pub harmonics: u8,
    /// Frames that the window lacks.
    pub frames_missing: u16,
    /// Kinds of faults in the window that may have changed the frequency.
    #[cfg_attr(test, schemars(with = "Vec<FaultKind>"))]
    pub faults: FaultSet,
    /// Whether and how period, speed and direction are known.
    pub travel: TravelStatus,
    /// Direction in which the grating moves; null if it is not known.
    pub direction: Option<Direction>,
    /// Spatial period, from the lags between the units or from the speed in the settings. With
    /// `uncalibrated` only its uncertainty is right.
    pub spatial_period_mm: Option<f32>,
    /// Standard deviation of the spatial period.
    pub spatial_period_sigma_mm: Option<f32>,
    /// Speed over the surface, not negative.
    pub speed_mm_s: Option<f32>,
    /// Standard deviation of the speed; 0 if the settings have it.
    pub speed_sigma_mm_s: Option<f32>,
    /// The valid channels.
    pub channels: Vec<Channel>,
}

impl From<&wire::Estimate> for Estimate {
    fn from(event: &wire::Estimate) -> Self {
        let travel = &event.travel;
        let known = |value| travel.is_known().then_some(value);
        let of_tone = |value| event.status.has_tone().then_some(value);
        let (movement, other) = (&event.movement, event.other_tone);
        Self {
            t_s: seconds(event.t_us),
            window_s: event.window_s,
            span: event.span,
            frequency_hz: of_tone(event.frequency),
            sigma_hz: of_tone(event.sigma),
            wander_percent: of_tone(100.0 * movement.wander),
            wander_sigma_percent: of_tone(100.0 * movement.wander_sigma),
            chirp_hz_per_s: of_tone(movement.chirp),
            chirp_sigma_hz_per_s: of_tone(movement.chirp_sigma),
            other_tone_hz: other.map(|other| other.frequency),
            other_tone_fraction: other.map(|other| other.fraction),
            interferer_hz: event.interferer_hz,
            status: event.status,
            harmonics: event.harmonics,
            frames_missing: event.frames_missing,
            faults: event.faults,
            travel: travel.status,
            direction: travel.direction.known(),
            spatial_period_mm: known(travel.spatial_period_mm),
            spatial_period_sigma_mm: known(travel.spatial_period_sigma_mm),
            speed_mm_s: known(travel.speed_mm_s),
            speed_sigma_mm_s: known(travel.speed_sigma_mm_s),
            channels: event.channels.to_vec(),
        }
    }
}

/// Short form of an estimate, for every window if the stride is below 0.05 s. Whole estimates then
/// come at most twenty times a second.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Track {
    /// Device time of the window's end.
    pub t_s: f64,
    /// Common frequency, mean over the window; null without a tone.
    pub frequency_hz: Option<f32>,
    /// Standard deviation of the frequency.
    pub sigma_hz: Option<f32>,
    /// How far the fit can be trusted.
    pub status: Status,
}

impl From<&wire::Track> for Track {
    fn from(event: &wire::Track) -> Self {
        let of_tone = |value| event.status.has_tone().then_some(value);
        Self {
            t_s: seconds(event.t_us),
            frequency_hz: of_tone(event.frequency),
            sigma_hz: of_tone(event.sigma),
            status: event.status,
        }
    }
}

/// The finger has left the surface.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Release {
    /// Device time.
    pub t_s: f64,
    /// Time from `t_s` until the event left the board's detector.
    pub reported_after_s: f64,
}

impl From<&wire::Release> for Release {
    fn from(event: &wire::Release) -> Self {
        Self {
            t_s: seconds(event.t_us),
            reported_after_s: seconds(event.reported_after_us.into()),
        }
    }
}

/// Counters and readings, once a second.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Health {
    /// Device time.
    pub t_s: f64,
    /// Frames since start-up; wraps after 206 days.
    pub frames: u32,
    /// Conversions lost: overruns of the queue and gaps in the scan.
    pub conversions_lost: u32,
    /// Conversions that cannot be trusted.
    pub conversions_doubtful: u32,
    /// Windows that were not fitted because the fit was busy.
    pub overruns: u32,
    /// Messages that were dropped because the line was slow.
    pub messages_dropped: u32,
    /// Number of times that the ADC was set up again, or that setting it up failed.
    pub chip_restarts: u32,
    /// Number of times that each kind of fault was seen.
    pub faults: FaultCounts,
    /// Requests that arrived damaged.
    pub requests_damaged: u32,
    /// Bytes of requests that the board read too late.
    pub bytes_overrun: u32,
    /// Deepest stack since start-up; 0 if it is not measured, as on a PC.
    pub stack_used_bytes: u32,
    /// Size of the stack; 0 if it is not measured.
    pub stack_bytes: u32,
    /// True frame rate by the board's clock; 0 until measured.
    pub frame_rate_hz: f32,
    /// Fraction of time that the processor was busy, 0 to 1; 0 if it is not measured.
    pub load: f32,
    /// The ADC's reading of its supply.
    pub supply_v: f32,
    /// The ADC's reading of its reference.
    pub reference_v: f32,
    /// The ADC's reading of its temperature.
    pub temperature_c: f32,
    /// The ADC's reading of its offset.
    pub offset_v: f32,
    /// The ADC's reading of its gain, ideally 1.
    pub gain: f32,
    /// Raw frames that were not sent because the line was full.
    pub frames_thinned: u32,
}

impl From<&wire::Health> for Health {
    fn from(event: &wire::Health) -> Self {
        Self {
            t_s: seconds(event.t_us),
            frames: event.frames,
            conversions_lost: event.conversions_lost,
            conversions_doubtful: event.conversions_doubtful,
            overruns: event.overruns,
            messages_dropped: event.messages_dropped,
            chip_restarts: event.chip_restarts,
            faults: FaultCounts(event.faults),
            requests_damaged: event.requests_damaged,
            bytes_overrun: event.bytes_overrun,
            stack_used_bytes: event.stack_used_bytes,
            stack_bytes: event.stack_bytes,
            frame_rate_hz: event.frame_rate_hz,
            load: event.load,
            supply_v: event.supply_v,
            reference_v: event.reference_v,
            temperature_c: event.temperature_c,
            offset_v: event.offset_v,
            gain: event.gain,
            frames_thinned: event.frames_thinned,
        }
    }
}

/// The converter behind the inputs: after each greeting, and when it changes.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Converter {
    /// Device time.
    pub t_s: f64,
    /// Name of the converter.
    pub name: String,
    /// True if the converter holds the registers that were written; otherwise the board keeps
    /// trying.
    pub answers: bool,
    /// Registers as read back at the latest set-up, padded with zeros; of an ADS1258 CONFIG0 to ID.
    pub registers: [u8; 10],
}

impl From<&wire::ConverterState> for Converter {
    fn from(event: &wire::ConverterState) -> Self {
        Self {
            t_s: seconds(event.t_us),
            name: event.name.as_str().to_owned(),
            answers: event.answers,
            registers: event.registers,
        }
    }
}

/// A count for each kind of fault, by its name.
#[derive(Clone, Copy, Debug)]
pub struct FaultCounts([u32; KINDS]);

impl Serialize for FaultCounts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(FaultKind::ALL.into_iter().zip(self.0))
    }
}

#[cfg(test)]
impl JsonSchema for FaultCounts {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "FaultCounts".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let count = u32::json_schema(generator);
        let names = FaultKind::ALL.map(name);
        let counts: serde_json::Map<_, _> = names
            .into_iter()
            .map(|kind| (kind.to_owned(), count.clone().into()))
            .collect();
        json_schema!({"type": "object", "properties": counts, "required": names})
    }
}

/// Pressure map of a hold before, between or after slides, if nothing moved in it for 0.1 s.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Image {
    /// Device time of the end of the mean.
    pub t_s: f64,
    /// Device time of the first frame of the mean.
    pub start_s: f64,
    /// Device time of the end of its last frame.
    pub end_s: f64,
    /// Frames in the mean.
    pub frames: u32,
    /// Which hold it is.
    pub hold: Hold,
    /// The live taxels.
    pub taxels: Vec<Pressed>,
}

impl From<&wire::Image> for Image {
    fn from(event: &wire::Image) -> Self {
        Self {
            t_s: seconds(event.end_us),
            start_s: seconds(event.start_us),
            end_s: seconds(event.end_us),
            frames: event.frames,
            hold: event.hold,
            taxels: event.taxels.to_vec(),
        }
    }
}

/// A fault begins, or has ended.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Fault {
    /// Device time of the beginning or, once it is over, of the end.
    pub t_s: f64,
    /// Which fault.
    pub kind: FaultKind,
    /// Device time at which it was detected.
    pub from_s: f64,
    /// Device time at which it was last seen; null while it lasts.
    pub until_s: Option<f64>,
    /// Number of times that this kind was seen since start-up.
    pub count: u32,
    /// Beginning or end of the fault.
    pub state: State,
}

impl From<&ridgetone_proto::fault::Fault> for Fault {
    fn from(event: &ridgetone_proto::fault::Fault) -> Self {
        Self {
            t_s: seconds(event.until_us.unwrap_or(event.from_us)),
            kind: event.kind,
            from_s: seconds(event.from_us),
            until_s: event.until_us.map(seconds),
            count: event.count,
            state: State::of(event.until_us),
        }
    }
}

/// The answer to a command: carried out, or refused and why.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Reply {
    /// Number of the request.
    pub number: u16,
    /// Outcome of the request: `done`, `done_erased`, or why it was refused.
    pub outcome: &'static str,
    /// Name, value and bounds of a setting that is out of its bounds.
    #[serde(flatten)]
    #[cfg_attr(test, schemars(skip))]
    pub setting: Option<SettingsError>,
    #[serde(flatten)]
    pub gives: Option<Gives>,
}

impl From<&ridgetone_proto::command::Reply> for Reply {
    fn from(event: &ridgetone_proto::command::Reply) -> Self {
        let setting = match &event.outcome {
            Outcome::Setting(error) => Some(error.clone()),
            _ => None,
        };
        Self {
            number: event.number,
            outcome: name(&event.outcome),
            setting,
            gives: event.gives,
        }
    }
}

/// A frame as it was read, on request.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Raw {
    /// Device time at which taxel 0 was converted; taxel k follows 0.1975 ms x k later with the
    /// plan `paper`.
    pub t_s: f64,
    /// Number of the frame since start-up, lost ones included.
    pub number: u32,
    /// Bit k: taxel k was converted and read.
    pub present: u16,
    /// Bit k: the result of taxel k can be trusted. A taxel that is present and good is valid.
    pub good: u16,
    /// Codes of the ADC by taxel.
    pub codes: [i32; TAXELS],
    /// Voltages by taxel; null where the code is not valid. Absent without the reference, which
    /// `hello` has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volts: Option<[Option<f32>; TAXELS]>,
}

impl Raw {
    fn new(event: &wire::Raw, vref_v: Option<f32>) -> Self {
        Self {
            t_s: seconds(event.t_us),
            number: event.number,
            present: event.present,
            good: event.good,
            codes: event.codes,
            volts: vref_v.map(|vref_v| crate::frame::Frame::new(event, vref_v).volts),
        }
    }
}

/// The surface under the finger: once a touch, on request with `hello`, and after a change of more
/// than three standard deviations.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Texture {
    /// Device time of the end of the estimate's window.
    pub t_s: f64,
    /// Name of the window's scan plan; null if it has none. `hello` has its fields.
    pub plan: Option<&'static str>,
    /// Spatial period.
    pub period_mm: f32,
    /// Standard deviation of the period.
    pub period_sigma_mm: f32,
    /// Half of the squared amplitude of the fundamental, mean of the valid channels.
    pub power_v2: f32,
    /// Standard deviation of the power, from white noise.
    pub power_sigma_v2: f32,
    /// Second, third and fourth harmonic, common to the valid channels.
    pub overtones: [Overtone; 3],
    /// How hard the finger presses: mean level of the taxels in the hold before the slide, over
    /// that before the touch, signed; null without such a hold.
    pub level_v: Option<f32>,
}

/// A harmonic above the first; zeros if it was not fitted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Overtone {
    /// Amplitude over the fundamental's, 0 to 1.
    pub amplitude: f32,
    /// Phase relative to the fundamental's phase times the order of the harmonic, both as sines.
    pub phase_cycles: f32,
}

impl From<&wire::Texture> for Texture {
    fn from(event: &wire::Texture) -> Self {
        Self {
            t_s: seconds(event.t_us),
            plan: event.plan.name(),
            period_mm: event.period_mm,
            period_sigma_mm: event.period_sigma_mm,
            power_v2: event.power_v2,
            power_sigma_v2: event.power_sigma_v2,
            overtones: crate::overtones::overtones(&event.overtones),
            level_v: event.level_v,
        }
    }
}

/// Messages of this computer, only in streams.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Note {
    Connection(Connection),
    Lost(Lost),
    Missed(Missed),
}

/// A source of messages comes or goes.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Connection {
    /// What happened to the source.
    pub state: ConnectionState,
    /// Port, recording or address.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The system's message.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}

/// What happened to a source of messages.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ConnectionState {
    Connected,
    Disconnected,
    Failed,
    Over,
}

/// Messages were lost, at the line or at a receiver.
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Lost {
    /// `line`, or the receiver whose messages were lost.
    pub at: String,
    /// At the line: messages so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub packets: Option<u32>,
    /// At the line: damaged messages so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damaged: Option<u32>,
    /// At a receiver: frames so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<u64>,
    /// At a receiver: other messages so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub events: Option<u64>,
    /// At a receiver: frames handed to a connection that then broke.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames_unconfirmed: Option<u64>,
}

/// A reader fell behind and missed messages.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(JsonSchema))]
pub struct Missed {
    /// Number of messages.
    pub count: u64,
}

/// Returns the schema of each kind of message, in the order of the reference: messages of the
/// board, messages of this computer, and the object of `fit`.
#[cfg(test)]
pub fn schemas() -> Vec<(&'static str, serde_json::Value)> {
    use super::generated::{schema, with_envelope, with_note};
    vec![
        ("hello", with_envelope::<Hello>()),
        ("contact", with_envelope::<Contact>()),
        ("moving", with_envelope::<Moving>()),
        ("slide", with_envelope::<Slide>()),
        ("estimate", with_envelope::<Estimate>()),
        ("track", with_envelope::<Track>()),
        ("texture", with_envelope::<Texture>()),
        ("release", with_envelope::<Release>()),
        ("image", with_envelope::<Image>()),
        ("fault", with_envelope::<Fault>()),
        ("reply", with_envelope::<Reply>()),
        ("raw", with_envelope::<Raw>()),
        ("health", with_envelope::<Health>()),
        ("converter", with_envelope::<Converter>()),
        ("connection", with_note::<Connection>()),
        ("lost", with_note::<Lost>()),
        ("missed", with_note::<Missed>()),
        ("fit", schema::<crate::fit_report::Fit<'static>>()),
    ]
}

#[cfg(test)]
fn any_object(_: &mut SchemaGenerator) -> Schema {
    json_schema!({"type": "object", "properties": {}})
}
