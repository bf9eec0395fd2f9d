//! JSON schemas of the topics: what the fields mean, and their units.

use super::topic::Topic;
use serde_json::{Map, Value, json};

/// A field: its name, its type (`[]`: a list), its unit and what it is.
type Field = (&'static str, &'static str, &'static str, &'static str);

/// Fields of all topics.
const COMMON: [Field; 7] = [
    ("type", "string", "", "kind of message"),
    (
        "index",
        "integer",
        "",
        "number of the message on its topic since the command started, from 0: a gap is a loss",
    ),
    (
        "sequence",
        "integer",
        "",
        "the board's number of the message since its start, modulo 65536",
    ),
    (
        "t_s",
        "number",
        "s",
        "board clock since its first conversion, of the end of what lasts",
    ),
    ("utc_s", "number", "s", "t_s in UTC, since 1970"),
    ("utc_sigma_s", "number", "s", "standard deviation of utc_s"),
    (
        "received_utc_s",
        "number",
        "s",
        "when this computer received the message, UTC since 1970",
    ),
];

const FRAMES: [Field; 5] = [
    (
        "number",
        "integer",
        "",
        "number of the frame since the board's start",
    ),
    (
        "present",
        "integer",
        "",
        "bit k: taxel k was converted and read",
    ),
    (
        "good",
        "integer",
        "",
        "bit k: the result of taxel k can be trusted; valid are those present and good",
    ),
    ("codes", "integer[]", "", "codes of the ADC by taxel"),
    (
        "volts",
        "number[]",
        "V",
        "the same in volts; null where not valid. Taxel k was converted 0.1975 ms x k after t_s",
    ),
];

const CONTACT: [Field; 8] = [
    (
        "taxel",
        "integer",
        "",
        "contact: taxel with the best defined spike",
    ),
    (
        "height_v",
        "number",
        "V",
        "contact: height of the spike over the level without touch",
    ),
    ("state", "string", "", "slide: start or end"),
    (
        "start_s",
        "number",
        "s",
        "slide, image: board clock of the beginning",
    ),
    (
        "end_s",
        "number",
        "s",
        "slide, image: board clock of the end",
    ),
    ("hold", "string", "", "image: before_slide or after_slide"),
    ("frames", "integer", "", "image: frames in the mean"),
    (
        "taxels",
        "object[]",
        "V",
        "image: taxel, level_v over the level before the touch, its standard error sigma_v",
    ),
];

const TONE: [Field; 32] = [
    ("window_s", "number", "s", "length of the window"),
    ("span", "string", "", "window or slide"),
    ("abscissa", "string", "", "time or place"),
    (
        "status",
        "string",
        "",
        "good, ambiguous, unsteady, doubtful, no_tone, too_short or nothing",
    ),
    ("frequency_hz", "number", "Hz", "common frequency by time"),
    ("sigma_hz", "number", "Hz", "its standard deviation"),
    (
        "frequency_per_mm",
        "number",
        "1/mm",
        "common frequency by place",
    ),
    ("sigma_per_mm", "number", "1/mm", "its standard deviation"),
    ("period_mm", "number", "mm", "spatial period by place"),
    ("period_sigma_mm", "number", "mm", "its standard deviation"),
    (
        "wander_percent",
        "number",
        "%",
        "how much the frequency differs from its mean, root mean square",
    ),
    (
        "wander_sigma_percent",
        "number",
        "%",
        "its standard deviation",
    ),
    (
        "sigma_mean_hz",
        "number",
        "Hz",
        "standard deviation as an estimate of the plain mean",
    ),
    ("sigma_mean_per_mm", "number", "1/mm", "the same by place"),
    (
        "chirp_hz_per_s",
        "number",
        "Hz/s",
        "change of the frequency with time",
    ),
    (
        "chirp_sigma_hz_per_s",
        "number",
        "Hz/s",
        "its standard deviation",
    ),
    (
        "chirp_per_mm2",
        "number",
        "1/mm^2",
        "change of the frequency with place",
    ),
    (
        "chirp_sigma_per_mm2",
        "number",
        "1/mm^2",
        "its standard deviation",
    ),
    (
        "other_tone_hz",
        "number",
        "Hz",
        "frequency of a second tone",
    ),
    ("other_tone_per_mm", "number", "1/mm", "the same by place"),
    (
        "other_tone_share",
        "number",
        "",
        "its power over that of the first",
    ),
    (
        "interferer_hz",
        "number",
        "Hz",
        "frequency of the interferer as fitted",
    ),
    ("harmonics", "integer", "", "harmonics in the fit"),
    (
        "frames_missing",
        "integer",
        "",
        "frames that the window lacks",
    ),
    ("faults", "string[]", "", "kinds of faults in the window"),
    (
        "travel",
        "string",
        "",
        "whether period, speed and direction are known",
    ),
    ("direction", "string", "", "forward or backward"),
    (
        "spatial_period_mm",
        "number",
        "mm",
        "spatial period by the lags between units",
    ),
    (
        "spatial_period_sigma_mm",
        "number",
        "mm",
        "its standard deviation",
    ),
    ("speed_mm_s", "number", "mm/s", "speed over the surface"),
    (
        "speed_sigma_mm_s",
        "number",
        "mm/s",
        "its standard deviation",
    ),
    (
        "channels",
        "object[]",
        "V, rad",
        "taxel, offset_v, amplitude_v, phase_rad and residual_v of each channel",
    ),
];

const FEEL: [Field; 9] = [
    ("window_s", "number", "s", "length of the window"),
    ("rate_hz", "number", "Hz", "values a second in it"),
    ("taxels", "integer", "", "bit k: taxel k counts"),
    ("faults", "string[]", "", "kinds of faults in the window"),
    ("m", "number", "", "tangential over normal force"),
    ("m_sigma", "number", "", "its standard deviation"),
    (
        "receptors",
        "object[]",
        "",
        "receptor (fa1, fa2, sa1, sa2), its firing intensity, the same by hertz, their standard deviations; or why it is absent",
    ),
    (
        "scores",
        "object[]",
        "",
        "name (soft, rough), score from 1 to 7 with its standard deviation; or why it is absent",
    ),
    (
        "spectrum",
        "object[]",
        "Hz, dB",
        "hz and level_db over 1 um from peak to peak of the strongest line in each third of an octave",
    ),
];

const TEXTURE: [Field; 7] = [
    (
        "plan",
        "string",
        "",
        "scan plan by its name; an object of its fields if it has none",
    ),
    ("period_mm", "number", "mm", "spatial period"),
    ("period_sigma_mm", "number", "mm", "its standard deviation"),
    (
        "power_v2",
        "number",
        "V^2",
        "half of the squared amplitude, mean of the channels",
    ),
    ("power_sigma_v2", "number", "V^2", "its standard deviation"),
    (
        "overtones",
        "object[]",
        "",
        "second to fourth harmonic: amplitude over the fundamental's, 0 to 1, and phase_cycles against as many turns of it, as sines",
    ),
    (
        "level_v",
        "number",
        "V",
        "mean level of the taxels in the hold before the slide, over that before the touch",
    ),
];

const DIAGNOSTICS: [Field; 27] = [
    (
        "protocol",
        "integer",
        "",
        "hello: version of the wire contract",
    ),
    ("version", "string", "", "hello: of the firmware"),
    (
        "frame_rate_hz",
        "number",
        "Hz",
        "hello, reply to settings: nominal frame rate",
    ),
    (
        "settings",
        "object",
        "",
        "hello: settings in force, with units in their names",
    ),
    (
        "settings_source",
        "string",
        "",
        "hello: where they come from",
    ),
    ("reset_cause", "string", "", "hello: why the board started"),
    (
        "oscillator",
        "string",
        "",
        "hello: external, internal or unknown",
    ),
    (
        "brown_out",
        "string",
        "",
        "hello: level below which the supply resets the board",
    ),
    (
        "record",
        "object",
        "",
        "hello: how the run before crashed, if it did",
    ),
    (
        "positions_mm",
        "number[][]",
        "mm",
        "hello: centre of each taxel's unit, along the sliding direction and across",
    ),
    ("kind", "string", "", "fault: which"),
    (
        "state",
        "string",
        "",
        "fault: start or end; connection: connected, disconnected, over or failed",
    ),
    (
        "from_s",
        "number",
        "s",
        "fault: board clock of its beginning",
    ),
    ("until_s", "number", "s", "fault: board clock of its end"),
    (
        "count",
        "integer",
        "",
        "fault: how often; missed: messages that a page's server has lost",
    ),
    ("number", "integer", "", "reply: number of the request"),
    ("outcome", "string", "", "reply: done, or why not"),
    (
        "nyquist_hz",
        "number",
        "Hz",
        "reply to settings: half their plan's frame rate",
    ),
    (
        "window_most_s",
        "number",
        "s",
        "reply to settings: longest window of their plan",
    ),
    (
        "source",
        "string",
        "",
        "connection: port, recording or address",
    ),
    ("why", "string", "", "connection: the system's message"),
    (
        "at",
        "string",
        "",
        "lost: line, or the receiver whose messages were lost",
    ),
    (
        "packets",
        "integer",
        "",
        "lost at the line: messages so far",
    ),
    (
        "damaged",
        "integer",
        "",
        "lost at the line: damaged messages so far",
    ),
    (
        "frames",
        "integer",
        "",
        "lost at a receiver: frames since the message before",
    ),
    (
        "events",
        "integer",
        "",
        "lost at a receiver: other messages since the message before",
    ),
    (
        "frames_unconfirmed",
        "integer",
        "",
        "lost at a receiver: frames given to a connection that broke",
    ),
];

const HEALTH: [Field; 23] = [
    ("frames", "integer", "", "frames since start-up"),
    ("conversions_lost", "integer", "", "conversions lost"),
    (
        "conversions_doubtful",
        "integer",
        "",
        "conversions that cannot be trusted",
    ),
    (
        "hops_skipped",
        "integer",
        "",
        "windows not fitted because the fit was busy",
    ),
    (
        "messages_dropped",
        "integer",
        "",
        "messages dropped because the line was slow",
    ),
    (
        "chip_restarts",
        "integer",
        "",
        "times that the ADC was set up again",
    ),
    (
        "faults",
        "object",
        "",
        "times that each kind of fault was seen",
    ),
    (
        "requests_damaged",
        "integer",
        "",
        "requests and messages of odometry that arrived damaged",
    ),
    (
        "bytes_overrun",
        "integer",
        "",
        "bytes of requests that the board read too late",
    ),
    (
        "odometry",
        "object",
        "",
        "messages of a robot: received, lost, late, doubled; windows fitted by time for want of them",
    ),
    (
        "adc_registers",
        "integer[]",
        "",
        "the ADC's registers, CONFIG0 to ID",
    ),
    (
        "stack_used_bytes",
        "integer",
        "byte",
        "most of the stack in use",
    ),
    ("stack_bytes", "integer", "byte", "size of the stack"),
    (
        "frame_rate_hz",
        "number",
        "Hz",
        "true frame rate by the board's clock",
    ),
    (
        "load",
        "number",
        "",
        "share of time that the processor was busy",
    ),
    ("supply_v", "number", "V", "the ADC's supply"),
    ("reference_v", "number", "V", "the ADC's reference"),
    ("temperature_c", "number", "degC", "the ADC's temperature"),
    ("offset_v", "number", "V", "the ADC's offset"),
    ("gain", "number", "", "the ADC's gain, ideally 1"),
    (
        "clock_offset_s",
        "number",
        "s",
        "UTC less board clock at board clock 0",
    ),
    (
        "clock_skew_ppm",
        "number",
        "ppm",
        "by how much the board's clock is slow",
    ),
    (
        "clock_skew_sigma_ppm",
        "number",
        "ppm",
        "its standard deviation",
    ),
];

fn fields(topic: Topic) -> &'static [Field] {
    match topic {
        Topic::Frames => &FRAMES,
        Topic::Contact => &CONTACT,
        Topic::Tone => &TONE,
        Topic::Feel => &FEEL,
        Topic::Texture => &TEXTURE,
        Topic::Diagnostics => &DIAGNOSTICS,
        Topic::Health => &HEALTH,
    }
}

/// The schema of a topic. Fields that a kind of message lacks are left out of it, values that are
/// not known are null.
pub fn json(topic: Topic) -> Value {
    let property = |(name, kind, unit, what): &Field| {
        let kind = match kind.strip_suffix("[]") {
            None => json!({"type": kind}),
            Some(item) => match item.strip_suffix("[]") {
                None => json!({"type": "array", "items": {"type": item}}),
                Some(item) => {
                    json!({"type": "array", "items": {"type": "array", "items": {"type": item}}})
                }
            },
        };
        let mut property = kind;
        property["description"] = if unit.is_empty() {
            (*what).into()
        } else {
            format!("{what} [{unit}]").into()
        };
        (name.to_string(), property)
    };
    let properties: Map<String, Value> = COMMON.iter().chain(fields(topic)).map(property).collect();
    json!({"title": format!("ridgetone.{topic}"), "type": "object", "properties": properties})
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::JsonLines;
    use crate::input::Input;
    use crate::serve::publisher::Publisher;
    use crate::serve::queue::Queue;
    use crate::utc::Receipt;
    use ridgetone_proto::command::{Outcome, Reply};
    use ridgetone_proto::fault::{Fault, FaultKind};
    use ridgetone_proto::settings::{Feeling, Settings};
    use ridgetone_proto::telemetry::{Event, Packet, Raw};
    use std::collections::BTreeSet;
    use std::sync::Arc;

    /// What the type of a value is called in a schema.
    fn fits(value: &Value, schema: &Value) -> bool {
        let kind = schema["type"].as_str().expect("a type");
        match value {
            Value::Null => true,
            Value::Array(items) => {
                kind == "array" && items.iter().all(|item| fits(item, &schema["items"]))
            }
            Value::Object(_) => kind == "object",
            Value::String(_) => kind == "string",
            Value::Number(number) => kind == "number" || kind == "integer" && !number.is_f64(),
            Value::Bool(_) => kind == "boolean",
        }
    }

    #[test]
    fn every_field_of_every_message_is_described_with_its_type() {
        let queue = Arc::new(Queue::new("test", 1));
        let mut publisher = Publisher::new(0, vec![Arc::clone(&queue)]);
        let mut lines = JsonLines::default();
        let mut sink = |packet: &Packet| {
            publisher.publish(lines.line(
                packet,
                Some(Receipt {
                    utc_ns: 1_769_862_605_000_000_000,
                    byte_s: 0.0,
                }),
            )?)
        };
        let feel = Feeling {
            volts_per_um: 2e-6,
            sigma_share: 0.1,
            force_ratio: 1.4,
        };
        let settings = Settings {
            feel,
            ..Settings::DEFAULT
        };
        crate::replay::run(
            Input::default().open().unwrap(),
            settings,
            None,
            &mut sink,
            &mut |_, _| {},
        )
        .unwrap();
        let raw = Raw {
            t_us: 1,
            number: 2,
            present: 3,
            good: 1,
            codes: [5; 16],
        };
        let fault = Fault {
            kind: FaultKind::Lost,
            from_us: 1,
            until_us: Some(2),
            count: 3,
        };
        let gives = Some(ridgetone_proto::plan::Plan::HAND.gives());
        let reply = Reply {
            gives,
            ..Reply::new(7, Outcome::Done)
        };
        for event in [Event::Raw(raw), Event::Fault(fault), Event::Reply(reply)] {
            sink(&Packet { sequence: 1, event }).unwrap();
        }
        publisher
            .note(json!({"type": "connection", "state": "failed", "source": "x", "why": "y"}))
            .unwrap();
        publisher
            .note(json!({"type": "lost", "at": "line", "packets": 1, "damaged": 2}))
            .unwrap();
        queue.push(Arc::new(crate::serve::message::lost(
            0,
            "test",
            Default::default(),
        )));
        queue.close();
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        let mut seen = BTreeSet::new();
        while let Some(taken) = runtime.block_on(queue.next()) {
            let topic = taken.message.topic;
            let (schema, message) = (
                json(topic),
                serde_json::from_str::<Value>(&taken.message.json).unwrap(),
            );
            for (name, value) in message.as_object().unwrap() {
                let property = &schema["properties"][name];
                assert!(
                    property.is_object() && fits(value, property),
                    "{topic}: {name}: {value} as {property}"
                );
                seen.insert((topic, name.clone()));
            }
        }
        assert!(
            seen.iter()
                .any(|(topic, name)| *topic == Topic::Feel && name == "receptors")
        );
        // And nothing is described that does not exist, but for what estimates by place and lines
        // of a page have.
        for topic in Topic::ALL {
            let absent: Vec<&str> = fields(topic)
                .iter()
                .map(|field| field.0)
                .filter(|name| !seen.contains(&(topic, (*name).to_owned())) && !name.contains("mm"))
                .collect();
            assert!(absent.is_empty(), "{topic}: {absent:?}");
        }
    }
}
