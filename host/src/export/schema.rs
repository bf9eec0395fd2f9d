//! JSON schemas by content: what every message of a kind in a recording holds.

use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// What a value was seen to be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schema {
    types: BTreeSet<&'static str>,
    properties: Vec<(String, Schema)>,
    items: Option<Box<Schema>>,
}

impl Schema {
    /// Takes a value.
    pub fn see(&mut self, value: &Value) {
        let name = match value {
            Value::Null => "null",
            Value::Bool(_) => "boolean",
            // Whole numbers are numbers too: the next one may not be whole.
            Value::Number(_) => "number",
            Value::String(_) => "string",
            Value::Array(items) => {
                let schema = self.items.get_or_insert_default();
                items.iter().for_each(|item| schema.see(item));
                "array"
            }
            Value::Object(fields) => {
                for (name, value) in fields {
                    let at = self.properties.iter().position(|(known, _)| known == name).unwrap_or_else(|| {
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

    /// As JSON schema. A type of its own is what readers expect: that it may be null is said only where it is nothing else.
    pub fn json(&self) -> Value {
        let mut fields = Map::new();
        let types: Vec<_> = self.types.iter().filter(|name| **name != "null").collect();
        match types.as_slice() {
            [] => drop(fields.insert("type".into(), "null".into())),
            [one] => drop(fields.insert("type".into(), (**one).into())),
            several => drop(fields.insert("type".into(), json!(several))),
        }
        if !self.properties.is_empty() {
            let properties: Map<_, _> =
                self.properties.iter().map(|(name, schema)| (name.clone(), schema.json())).collect();
            fields.insert("properties".into(), properties.into());
        }
        if let Some(items) = &self.items {
            fields.insert("items".into(), items.json());
        }
        fields.into()
    }
}
