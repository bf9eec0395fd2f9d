//! Messages as rows of a table: a column for each value of the schema.
//!
//! A column is named after its field. The name of a nested object is a prefix; an item of a list of
//! fixed length has the list's name and its number: `registers_3`. Words in a list are joined.
//! Lists of objects whose length varies are omitted, and unknown values are empty.

use super::schema;
use serde_json::{Map, Value};

/// Fields of a JSON line that a row leaves out, because they are the same in all rows or do not
/// come from the board.
const LEFT_OUT: [&str; 8] = [
    "type",
    "sequence",
    "received_utc_s",
    "utc_s",
    "utc_sigma_s",
    "clock_offset_s",
    "clock_skew_ppm",
    "clock_skew_sigma_ppm",
];

/// Returns the columns of messages of this `type`.
pub fn columns(kind: &str) -> Vec<Column> {
    let mut columns = Vec::new();
    let root = Column {
        name: String::new(),
        pointer: String::new(),
    };
    if let Some(schema) = schema::of(kind) {
        extend(&mut columns, &root, schema);
    }
    columns.retain(|column| !LEFT_OUT.contains(&column.name.as_str()));
    columns
}

/// A column: its name, and the path to its value in a message (RFC 6901).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    pub name: String,
    pointer: String,
}

impl Column {
    /// Returns the value as text; empty if it is not known.
    pub fn text(&self, message: &Value) -> String {
        match message.pointer(&self.pointer) {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => text.clone(),
            Some(Value::Array(words)) => {
                let words: Vec<&str> = words.iter().filter_map(Value::as_str).collect();
                words.join(" ")
            }
            Some(value) => value.to_string(),
        }
    }

    pub fn number(&self, message: &Value) -> Option<f64> {
        message.pointer(&self.pointer)?.as_f64()
    }

    fn inner(&self, name: &str, key: &str) -> Self {
        let gap = if self.name.is_empty() { "" } else { "_" };
        Self {
            name: format!("{}{gap}{name}", self.name),
            pointer: format!("{}/{key}", self.pointer),
        }
    }
}

fn extend(columns: &mut Vec<Column>, at: &Column, schema: &Value) {
    match kind(schema) {
        "object" => {
            for (key, property) in properties(schema) {
                extend(columns, &at.inner(key, key), property);
            }
        }
        "array" if kind(&schema["items"]) == "string" => columns.push(at.clone()),
        "array" => {
            let (min, max) = (&schema["minItems"], &schema["maxItems"]);
            let length = min.as_u64().filter(|_| min == max).unwrap_or(0);
            for number in 0..length as usize {
                let key = number.to_string();
                extend(columns, &at.inner(&key, &key), &schema["items"]);
            }
        }
        _ => columns.push(at.clone()),
    }
}

fn properties(schema: &Value) -> impl Iterator<Item = (&String, &Value)> {
    schema["properties"]
        .as_object()
        .into_iter()
        .flat_map(Map::iter)
}

/// Returns the type of a value, ignoring null.
fn kind(schema: &Value) -> &str {
    match &schema["type"] {
        Value::Array(types) => types.first().and_then(Value::as_str).unwrap_or_default(),
        one => one.as_str().unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::events::serializable;
    use ridgetone_proto::telemetry::{Event, Health, Packet};

    #[test]
    fn what_is_within_a_field_has_its_name_in_front() {
        let mut health = Health {
            t_us: 1_500_000,
            load: 0.1,
            ..Health::default()
        };
        health.faults[1] = 4;
        let event = Event::Health(health);
        let message = serde_json::to_value(serializable(&Packet { sequence: 3, event })).unwrap();
        let columns = columns("health");
        let value = |name: &str| {
            let column = columns.iter().find(|column| column.name == name);
            column.expect("a column").text(&message)
        };
        for (name, wanted) in [("t_s", "1.5"), ("load", "0.1"), ("faults_repeated", "4")] {
            assert_eq!(value(name), wanted, "{name}");
        }
        assert_eq!(columns[0].name, "t_s", "the line's own fields are left out");
    }
}
