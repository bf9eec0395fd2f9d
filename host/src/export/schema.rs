//! JSON schemas from content: the fields and types of all messages of one kind in a recording.

use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// Types of the values seen so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schema {
    types: BTreeSet<&'static str>,
    properties: Vec<(String, Schema)>,
    items: Option<Box<Schema>>,
}

impl Schema {
    pub fn see(&mut self, value: &Value) {
        let name = match value {
            Value::Null => "null",
            Value::Bool(_) => "boolean",
            // Never "integer": the next value may have a fraction.
            Value::Number(_) => "number",
            Value::String(_) => "string",
            Value::Array(items) => {
                let schema = self.items.get_or_insert_default();
                items.iter().for_each(|item| schema.see(item));
                "array"
            }
            Value::Object(fields) => {
                for (name, value) in fields {
                    let at = self
                        .properties
                        .iter()
                        .position(|(known, _)| known == name)
                        .unwrap_or_else(|| {
                            self.properties.push((name.clone(), Self::default()));
                            self.properties.len() - 1
                        });
                    self.properties[at].1.see(value);
                }
                "object"
            }
        };
        self.types.insert(name);
    }

    /// The JSON schema. Null is listed only where it is the only type, because readers expect one
    /// type.
    pub fn json(&self) -> Value {
        let mut fields = Map::new();
        let types: Vec<_> = self.types.iter().filter(|name| **name != "null").collect();
        match types.as_slice() {
            [] => drop(fields.insert("type".into(), "null".into())),
            [one] => drop(fields.insert("type".into(), (**one).into())),
            several => drop(fields.insert("type".into(), json!(several))),
        }
        if !self.properties.is_empty() {
            let properties: Map<_, _> = self
                .properties
                .iter()
                .map(|(name, schema)| (name.clone(), schema.json()))
                .collect();
            fields.insert("properties".into(), properties.into());
        }
        if let Some(items) = &self.items {
            fields.insert("items".into(), items.json());
        }
        fields.into()
    }
}
