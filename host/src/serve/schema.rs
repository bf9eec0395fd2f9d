//! JSON schemas for streams and MCAP files. The schema of a topic joins those of its messages.
//!
//! Viewers such as Foxglove allow one type per field, so a field is never null here: a field
//! without a value is omitted from a message. Items of a list keep their positions and may be null.

use super::topic::Topic;
use crate::events::schema;
use serde_json::{Map, Value, json};

pub fn json(topic: Topic) -> Value {
    let kinds: Vec<_> = schema::messages()
        .filter(|(kind, _)| Topic::of(kind) == topic)
        .collect();
    let mut properties = Map::new();
    for (kind, schema) in &kinds {
        let own = schema["properties"].as_object();
        for (name, property) in own.into_iter().flatten() {
            let Some(mut property) = of_one_type(property) else {
                continue;
            };
            let description = property["description"].as_str().unwrap_or_default();
            let mut described = description.to_owned();
            match properties
                .get(name)
                .map(|known: &Value| &known["description"])
            {
                Some(Value::String(known)) if known.ends_with(description) => {
                    described.clone_from(known);
                }
                Some(Value::String(known)) => described = format!("{known} {kind}: {description}"),
                _ if kinds.len() > 1 => described = format!("{kind}: {description}"),
                _ => {}
            }
            property["description"] = described.into();
            if let Some(known) = properties.get(name) {
                property["enum"] = either(&known["enum"], &property["enum"]);
            }
            if property["enum"].is_null()
                && let Some(fields) = property.as_object_mut()
            {
                fields.remove("enum");
            }
            properties.insert(name.clone(), property);
        }
    }
    let (index, kind) = (
        "Number of the message on its topic since the command started, from 0: a gap is a loss.",
        "Kind of the message.",
    );
    let names: Vec<_> = kinds.iter().map(|(kind, _)| *kind).collect();
    properties.insert(
        "type".into(),
        json!({"type": "string", "enum": names, "description": kind}),
    );
    properties.insert(
        "index".into(),
        json!({"type": "integer", "minimum": 0, "description": index}),
    );
    json!({
        "$schema": schema::DIALECT,
        "title": format!("ridgetone.{topic}"),
        "type": "object",
        "properties": properties,
        "required": ["type"],
    })
}

/// Removes `null` from a schema that also has a proper type. Returns `None` for a list of lists,
/// which viewers cannot read.
fn of_one_type(schema: &Value) -> Option<Value> {
    let mut one = schema.clone();
    let fields = one.as_object_mut()?;
    if let Value::Array(types) = &fields["type"] {
        fields["type"] = types.iter().find(|found| *found != "null")?.clone();
    }
    if let Some(Value::Array(values)) = fields.get_mut("enum") {
        values.retain(|value| !value.is_null());
    }
    if let Some(items) = fields.get("items").cloned() {
        let item = of_one_type(&items)?;
        if item["type"] == "array" {
            return None;
        }
        let is_with_null = items["type"].is_array();
        if let Some(length) = fields.get("maxItems").and_then(Value::as_u64)
            && is_with_null
        {
            fields.insert("prefixItems".into(), vec![items; length as usize].into());
        }
        fields.insert("items".into(), item);
    }
    let mut optional = Vec::new();
    if let Some(Value::Object(properties)) = fields.get_mut("properties") {
        for (name, property) in properties {
            let found = of_one_type(property)?;
            if property["type"].is_array() {
                optional.push(name.clone());
            }
            *property = found;
        }
    }
    if let Some(Value::Array(required)) = fields.get_mut("required") {
        required.retain(|name| !optional.iter().any(|optional| name == optional));
    }
    Some(one)
}

/// Returns the values allowed by either schema; null if one of them allows any value.
fn either(one: &Value, other: &Value) -> Value {
    let (Value::Array(one), Value::Array(other)) = (one, other) else {
        return Value::Null;
    };
    let mut all = one.clone();
    all.extend(other.iter().filter(|value| !one.contains(value)).cloned());
    all.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::JsonLines;
    use crate::events::view::{self, Note};
    use crate::input::Input;
    use crate::serve::publisher::Publisher;
    use crate::serve::queue::Queue;
    use crate::utc::Receipt;
    use ridgetone_proto::command::{Outcome, Reply};
    use ridgetone_proto::fault::{Fault, FaultKind};
    use ridgetone_proto::settings::Settings;
    use ridgetone_proto::telemetry::{ConverterState, Event, Packet, Raw};
    use std::collections::BTreeSet;
    use std::sync::Arc;

    /// True if a value fits a schema. Every schema has one type, as viewers require.
    fn fits(value: &Value, schema: &Value) -> bool {
        let kind = schema["type"].as_str().expect("one type");
        match value {
            Value::Null => false,
            Value::Array(items) => {
                let first = schema["prefixItems"].as_array();
                let fits_item = |(number, item): (usize, &Value)| {
                    first.is_some_and(|first| number < first.len() && item.is_null())
                        || fits(item, &schema["items"])
                };
                kind == "array" && items.iter().enumerate().all(fits_item)
            }
            Value::Object(fields) => {
                kind == "object"
                    && fields.iter().all(|(name, value)| {
                        let property = &schema["properties"][name];
                        property.is_null() || fits(value, property)
                    })
            }
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
        let mut settings = Settings::DEFAULT;
        // A calibrated finger reports the direction.
        settings.array.edge_phase_sigma_rad = 0.01;
        crate::replay::run(
            Input::default().open().unwrap(),
            settings,
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
        let events = [
            Event::Raw(raw),
            Event::Fault(fault),
            Event::Reply(reply),
            Event::Converter(ConverterState::default()),
        ];
        for event in events {
            sink(&Packet { sequence: 1, event }).unwrap();
        }
        for note in notes() {
            publisher.note(note).unwrap();
        }
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
                // `positions_mm` has no schema, because viewers cannot read lists of lists.
                assert!(
                    name == "positions_mm" || property.is_object() && fits(value, property),
                    "{topic}: {name}: {value} as {property}"
                );
                seen.insert((topic, name.clone()));
            }
        }
        // Every field in a schema must occur in a message, except for those that no message has
        // here.
        for topic in Topic::ALL {
            let schema = json(topic);
            let absent: Vec<&String> = schema["properties"]
                .as_object()
                .unwrap()
                .keys()
                .filter(|name| !seen.contains(&(topic, (*name).clone())))
                .filter(|name| !name.contains("mm") && !name.starts_with("clock_"))
                .filter(|name| !["interferer_hz", "record"].contains(&name.as_str()))
                .filter(|name| !name.starts_with("other_tone"))
                .collect();
            assert!(absent.is_empty(), "{topic}: {absent:?}");
        }
    }

    fn notes() -> [Note; 3] {
        let connection = view::Connection {
            state: view::ConnectionState::Failed,
            source: Some("x".to_owned()),
            why: Some("y".to_owned()),
        };
        let lost = view::Lost {
            at: "line".to_owned(),
            packets: Some(1),
            damaged: Some(2),
            ..view::Lost::default()
        };
        let missed = view::Missed { count: 3 };
        [
            Note::Connection(connection),
            Note::Lost(lost),
            Note::Missed(missed),
        ]
    }
}
