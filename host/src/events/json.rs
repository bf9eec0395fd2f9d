//! One JSON object a packet. f32 values keep their shortest form, which reads back to the same f32.

use crate::names::{
    cause_name, death_name, direction_name, fault_name, hold_name, source_name, span_name, status_name, verdict_name,
};
use crate::settings_form::SettingsForm;
use crate::tone::{JsonTone, abscissa_name, period_f32};
use ridgetone_proto::boot::Record;
use ridgetone_proto::command::Outcome;
use ridgetone_proto::fault::{FaultKind, FaultSet};
use ridgetone_proto::telemetry::{Channel, Event, Packet, Pressed, Travel};
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
enum Body<'a> {
    Hello {
        sequence: u16,
        protocol: u8,
        version: String,
        frame_rate_hz: f32,
        settings: SettingsForm,
        settings_source: &'static str,
        reset_cause: &'static str,
        record: Option<JsonRecord<'a>>,
    },
    Contact {
        sequence: u16,
        t_s: f64,
        taxel: u8,
        height_v: f32,
    },
    Slide {
        sequence: u16,
        t_s: f64,
        start_s: f64,
        end_s: Option<f64>,
        state: &'static str,
    },
    Estimate {
        sequence: u16,
        t_s: f64,
        window_s: f32,
        span: &'static str,
        abscissa: &'static str,
        #[serde(flatten)]
        tone: JsonTone<f32>,
        status: &'static str,
        harmonics: u8,
        frames_missing: u16,
        faults: Vec<&'static str>,
        #[serde(flatten)]
        travel: JsonTravel,
        channels: &'a [Channel],
    },
    Release {
        sequence: u16,
        t_s: f64,
    },
    Health {
        sequence: u16,
        t_s: f64,
        frames: u32,
        conversions_lost: u32,
        conversions_doubtful: u32,
        hops_skipped: u32,
        messages_dropped: u32,
        chip_restarts: u32,
        faults: BTreeMap<&'static str, u32>,
        requests_damaged: u32,
        stack_used_bytes: u32,
        stack_bytes: u32,
        frame_rate_hz: f32,
        load: f32,
        supply_v: f32,
        reference_v: f32,
        temperature_c: f32,
        offset_v: f32,
        gain: f32,
    },
    Image {
        sequence: u16,
        t_s: f64,
        start_s: f64,
        end_s: f64,
        hold: &'static str,
        frames: u32,
        taxels: &'a [Pressed],
    },
    Fault {
        sequence: u16,
        t_s: f64,
        kind: &'static str,
        state: &'static str,
        from_s: f64,
        until_s: Option<f64>,
        count: u32,
    },
    Reply {
        sequence: u16,
        number: u16,
        #[serde(flatten)]
        outcome: JsonOutcome<'a>,
    },
    Raw {
        sequence: u16,
        t_s: f64,
        number: u32,
        present: u16,
        good: u16,
        codes: &'a [i32],
    },
}

/// What a run before this one died of.
#[derive(Serialize)]
struct JsonRecord<'a> {
    death: &'static str,
    board_time_s: f64,
    pc: String,
    lr: String,
    file: &'a str,
    line: u32,
}

impl<'a> From<&'a Record> for JsonRecord<'a> {
    fn from(record: &'a Record) -> Self {
        Self {
            death: death_name(record.death),
            board_time_s: seconds(record.t_us.into()),
            pc: format!("{:#010x}", record.pc),
            lr: format!("{:#010x}", record.lr),
            file: &record.file,
            line: record.line,
        }
    }
}

#[derive(Serialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
enum JsonOutcome<'a> {
    Done,
    Setting { field: &'a str, value: f32, least: f32, greatest: f32 },
    Profile,
    NotStored,
    Busy,
    DoneErased,
}

impl<'a> From<&'a Outcome> for JsonOutcome<'a> {
    fn from(outcome: &'a Outcome) -> Self {
        match outcome {
            Outcome::Done => Self::Done,
            Outcome::Setting { field, value, least, greatest } => {
                Self::Setting { field, value: *value, least: *least, greatest: *greatest }
            }
            Outcome::Profile => Self::Profile,
            Outcome::NotStored => Self::NotStored,
            Outcome::Busy => Self::Busy,
            Outcome::DoneErased => Self::DoneErased,
        }
    }
}

fn names(faults: FaultSet) -> Vec<&'static str> {
    faults.iter().map(fault_name).collect()
}

/// Spatial period, speed and direction; null where they are not known.
#[derive(Serialize)]
struct JsonTravel {
    travel: &'static str,
    direction: Option<&'static str>,
    spatial_period_mm: Option<f32>,
    spatial_period_sigma_mm: Option<f32>,
    speed_mm_s: Option<f32>,
    speed_sigma_mm_s: Option<f32>,
}

impl From<&Travel> for JsonTravel {
    fn from(travel: &Travel) -> Self {
        let known = |value| travel.is_known().then_some(value);
        Self {
            travel: verdict_name(travel.verdict),
            direction: direction_name(travel.direction),
            spatial_period_mm: known(travel.spatial_period_mm),
            spatial_period_sigma_mm: known(travel.spatial_period_sigma_mm),
            speed_mm_s: known(travel.speed_mm_s),
            speed_sigma_mm_s: known(travel.speed_sigma_mm_s),
        }
    }
}

fn seconds(t_us: u64) -> f64 {
    t_us as f64 / 1e6
}

/// A packet as one JSON object on one line, without the line's end.
///
/// # Errors
/// None that a packet could cause; those of the serializer.
pub fn json(packet: &Packet) -> serde_json::Result<String> {
    serde_json::to_string(&serializable(packet))
}

/// A packet as [`json`] has it, for a serializer.
pub fn serializable(packet: &Packet) -> impl Serialize {
    let sequence = packet.sequence;
    match &packet.event {
        Event::Hello(e) => Body::Hello {
            sequence,
            protocol: e.protocol,
            version: e.version.map(|part| part.to_string()).join("."),
            frame_rate_hz: e.frame_rate_hz,
            settings: (&e.settings).into(),
            settings_source: source_name(e.source),
            reset_cause: cause_name(e.boot.cause),
            record: e.boot.record.as_ref().map(Into::into),
        },
        Event::Contact(e) => Body::Contact { sequence, t_s: seconds(e.t_us), taxel: e.taxel, height_v: e.height_v },
        Event::Slide(e) => Body::Slide {
            sequence,
            t_s: seconds(e.end_us.unwrap_or(e.start_us)),
            start_s: seconds(e.start_us),
            end_s: e.end_us.map(seconds),
            state: if e.end_us.is_some() { "end" } else { "start" },
        },
        Event::Estimate(e) => Body::Estimate {
            sequence,
            t_s: seconds(e.t_us),
            window_s: e.window_s,
            span: span_name(e.span),
            abscissa: abscissa_name(e.abscissa),
            tone: JsonTone::new(e.abscissa, e.status.has_tone().then_some((e.frequency, e.sigma)), period_f32),
            status: status_name(e.status),
            harmonics: e.harmonics,
            frames_missing: e.frames_missing,
            faults: names(e.faults),
            travel: (&e.travel).into(),
            channels: &e.channels,
        },
        Event::Release(e) => Body::Release { sequence, t_s: seconds(e.t_us) },
        Event::Health(e) => Body::Health {
            sequence,
            t_s: seconds(e.t_us),
            frames: e.frames,
            conversions_lost: e.conversions_lost,
            conversions_doubtful: e.conversions_doubtful,
            hops_skipped: e.hops_skipped,
            messages_dropped: e.messages_dropped,
            chip_restarts: e.chip_restarts,
            faults: FaultKind::ALL.map(fault_name).into_iter().zip(e.faults).collect(),
            requests_damaged: e.requests_damaged,
            stack_used_bytes: e.stack_used_bytes,
            stack_bytes: e.stack_bytes,
            frame_rate_hz: e.frame_rate_hz,
            load: e.load,
            supply_v: e.supply_v,
            reference_v: e.reference_v,
            temperature_c: e.temperature_c,
            offset_v: e.offset_v,
            gain: e.gain,
        },
        Event::Image(e) => Body::Image {
            sequence,
            t_s: seconds(e.end_us),
            start_s: seconds(e.start_us),
            end_s: seconds(e.end_us),
            hold: hold_name(e.hold),
            frames: e.frames,
            taxels: &e.taxels,
        },
        Event::Fault(e) => Body::Fault {
            sequence,
            t_s: seconds(e.until_us.unwrap_or(e.from_us)),
            kind: fault_name(e.kind),
            state: if e.until_us.is_some() { "end" } else { "start" },
            from_s: seconds(e.from_us),
            until_s: e.until_us.map(seconds),
            count: e.count,
        },
        Event::Reply(e) => Body::Reply { sequence, number: e.number, outcome: (&e.outcome).into() },
        Event::Raw(e) => Body::Raw {
            sequence,
            t_s: seconds(e.t_us),
            number: e.number,
            present: e.present,
            good: e.good,
            codes: &e.codes,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::telemetry::{
        Abscissa, Contact, Direction, Estimate, Hold, Image, Slide, Span, Status, TravelStatus,
    };

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
            r#"{"type":"image","sequence":9,"t_s":4.5,"start_s":3.5,"end_s":4.5,"hold":"after_slide","frames":240,"taxels":[{"taxel":0,"level_v":0.5,"sigma_v":0.25},{"taxel":2,"level_v":0.5,"sigma_v":0.25}]}"#
        );
    }

    #[test]
    fn no_tone_no_frequency() {
        let estimate = Estimate {
            t_us: 2_000_000,
            window_s: 1.0,
            span: Span::Window,
            status: Status::NoTone,
            abscissa: Abscissa::Time,
            frequency: 0.0,
            sigma: 0.0,
            harmonics: 0,
            frames_missing: 2,
            faults: FaultSet::NONE.with(FaultKind::Lost),
            travel: Travel::NONE,
            channels: Default::default(),
        };
        let line = json(&Packet { sequence: 0, event: Event::Estimate(estimate) }).unwrap();
        assert_eq!(
            line,
            r#"{"type":"estimate","sequence":0,"t_s":2.0,"window_s":1.0,"span":"window","abscissa":"time","frequency_hz":null,"sigma_hz":null,"status":"no_tone","harmonics":0,"frames_missing":2,"faults":["lost"],"travel":"nothing","direction":null,"spatial_period_mm":null,"spatial_period_sigma_mm":null,"speed_mm_s":null,"speed_sigma_mm_s":null,"channels":[]}"#
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
            harmonics: 1,
            frames_missing: 0,
            faults: FaultSet::NONE,
            travel: Travel {
                verdict: TravelStatus::Given,
                direction: Direction::Backward,
                spatial_period_mm: 4.0,
                spatial_period_sigma_mm: 1.0,
                speed_mm_s: 30.0,
                speed_sigma_mm_s: 0.0,
            },
            channels: Default::default(),
        };
        let line = json(&Packet { sequence: 0, event: Event::Estimate(estimate) }).unwrap();
        let tone = r#""abscissa":"place","frequency_per_mm":0.25,"sigma_per_mm":0.0625,"period_mm":4.0,"period_sigma_mm":1.0,"status""#;
        assert!(line.contains(tone), "{line}");
        let travel = r#""travel":"given","direction":"backward","spatial_period_mm":4.0,"spatial_period_sigma_mm":1.0,"speed_mm_s":30.0,"speed_sigma_mm_s":0.0,"channels""#;
        assert!(line.contains(travel), "{line}");
    }

    #[test]
    fn a_slide_is_told_at_its_start_and_its_end() {
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
