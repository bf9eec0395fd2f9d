//! Files that are generated from the views and checked in: `schema.json`, the lists of
//! `host/reference.md`, Python's classes. The test fails if a file differs from the views; `cargo
//! xtask events` rewrites them.

use super::schema::DIALECT;
use super::view::{Message, schemas};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Variable that `cargo xtask events` sets to write the files instead of comparing them.
const WRITE: &str = "RIDGETONE_WRITE";

const BEGIN: &str = "<!-- `cargo xtask events` writes what follows. -->\n";
const END: &str = "<!-- End of what `cargo xtask events` writes. -->\n";

/// Units by the end of a field's name; the first match counts.
const UNITS: [(&str, &str); 20] = [
    ("hz_per_s", "Hz/s"),
    ("per_mm2", "1/mm^2"),
    ("per_mm", "1/mm"),
    ("mm_s", "mm/s"),
    ("_hz", "Hz"),
    ("hz", "Hz"),
    ("_mm", "mm"),
    ("_ppm", "ppm"),
    ("percent", "%"),
    ("_bytes", "byte"),
    ("_cycles", "cycles"),
    ("_rad", "rad"),
    ("_v2", "V^2"),
    ("volts", "V"),
    ("_us", "us"),
    ("_s", "s"),
    ("_v", "V"),
    ("_n", "N"),
    ("_c", "degC"),
    ("", ""),
];

fn unit(name: &str) -> &'static str {
    let fits = UNITS.iter().find(|(end, _)| name.ends_with(end));
    fits.map_or("", |(_, unit)| unit)
}

pub fn schema<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let generator = settings.with(|settings| settings.inline_subschemas = true);
    let mut schema = generator.into_generator().into_root_schema_for::<T>();
    let mut schema = std::mem::take(schema.ensure_object()).into();
    simplify("", &mut schema);
    schema
}

/// Returns the schema of a message of the board.
pub fn with_envelope<T: JsonSchema>() -> Value {
    let (mut schema, envelope) = (schema::<T>(), schema::<Message>());
    let mut properties = Map::new();
    let (own, common) = (&schema["properties"], &envelope["properties"]);
    for name in ["type", "sequence"] {
        properties.insert(name.into(), common[name].clone());
    }
    for fields in [own, common] {
        for (name, property) in fields.as_object().into_iter().flatten() {
            properties.entry(name).or_insert_with(|| property.clone());
        }
    }
    let mut required = envelope["required"].as_array().cloned().unwrap_or_default();
    required.extend(schema["required"].as_array().into_iter().flatten().cloned());
    schema["properties"] = properties.into();
    schema["required"] = required.into();
    schema
}

/// Returns the schema of a message of this computer.
pub fn with_note<T: JsonSchema>() -> Value {
    let (mut schema, envelope) = (schema::<T>(), schema::<Message>());
    let common = &envelope["properties"];
    let mut properties = Map::new();
    properties.insert("type".into(), common["type"].clone());
    for (name, property) in schema["properties"].as_object().into_iter().flatten() {
        properties.insert(name.clone(), property.clone());
    }
    let received = "received_utc_s";
    properties.insert(received.into(), common[received].clone());
    schema["properties"] = properties.into();
    if let Some(required) = schema["required"].as_array_mut() {
        required.insert(0, "type".into());
    }
    schema
}

/// Simplifies a schema: plain types, one-line descriptions with their unit, values of enums as a
/// list.
fn simplify(name: &str, schema: &mut Value) {
    let Some(fields) = schema.as_object_mut() else {
        return;
    };
    for unwanted in ["title", "format", "$schema", "default"] {
        fields.remove(unwanted);
    }
    if let Some(Value::String(text)) = fields.get_mut("description") {
        let line = one_line(text);
        *text = match unit(name) {
            "" => line,
            unit => format!("{} [{unit}].", line.trim_end_matches('.')),
        };
    }
    // A value that may be null.
    if let Some(Value::Array(any)) = fields.remove("anyOf") {
        for (key, value) in any[0].as_object().into_iter().flatten() {
            if key != "description" || !fields.contains_key(key) {
                fields.insert(key.clone(), value.clone());
            }
        }
        flatten_enum(fields);
        if let Some(Value::Array(values)) = fields.get_mut("enum") {
            values.push(Value::Null);
        }
        fields["type"] = json!([fields["type"], "null"]);
    }
    flatten_enum(fields);
    if let Some(items) = fields.get_mut("items") {
        simplify("", items);
    }
    if let Some(Value::Object(properties)) = fields.get_mut("properties") {
        for (name, property) in properties {
            simplify(name, property);
        }
    }
}

/// Turns variants that are described one by one into a list of values.
fn flatten_enum(fields: &mut Map<String, Value>) {
    if let Some(Value::Array(variants)) = fields.remove("oneOf") {
        let values = |variant: &Value| match &variant["enum"] {
            Value::Array(values) => values.clone(),
            _ => vec![variant["const"].clone()],
        };
        let all: Vec<Value> = variants.iter().flat_map(values).collect();
        fields.insert("type".into(), "string".into());
        fields.insert("enum".into(), all.into());
    }
}

/// Returns a doc comment without line breaks and without links.
fn one_line(text: &str) -> String {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let text = text
        .replace("[`", "`")
        .replace("`](", "` (")
        .replace("`]", "`");
    let mut words: Vec<String> = text.split(' ').map(str::to_owned).collect();
    for word in &mut words {
        if let Some((path, rest)) = word.rsplit_once("::") {
            let before: String = path.chars().take_while(|c| !c.is_alphanumeric()).collect();
            *word = before + rest;
        }
    }
    words.join(" ")
}

/// Formats all schemas, one line per field.
fn schema_json() -> String {
    let mut out = "{\n".to_owned();
    let all = schemas();
    for (number, (kind, schema)) in all.iter().enumerate() {
        let described = &schema["description"];
        let _ = writeln!(
            out,
            "\"{kind}\": {{\"$schema\": \"{DIALECT}\", \"title\": \"ridgetone.{kind}\", \"description\": {described}, \"type\": \"object\", \"properties\": {{"
        );
        let fields = schema["properties"].as_object().expect("properties");
        for (at, (name, property)) in fields.iter().enumerate() {
            let mut property = property.clone();
            if name == "type" {
                property["enum"] = json!([kind]);
            }
            let gap = if at + 1 < fields.len() { "," } else { "" };
            let _ = writeln!(out, "  \"{name}\": {property}{gap}");
        }
        let gap = if number + 1 < all.len() { "," } else { "" };
        let _ = writeln!(out, "}}, \"required\": {}}}{gap}", schema["required"]);
    }
    out + "}\n"
}

/// Formats type and values of a field as Python.
fn python_type(name: &str, schema: &Value) -> String {
    let types = match &schema["type"] {
        Value::Array(types) => types.clone(),
        one => vec![one.clone()],
    };
    let one = |kind: &Value| match kind.as_str().unwrap_or_default() {
        "null" => "None".to_owned(),
        "number" => "float".to_owned(),
        "integer" => "int".to_owned(),
        "boolean" => "bool".to_owned(),
        "array" => format!("list[{}]", python_type("", &schema["items"])),
        "object" if name == "settings" => "Settings".to_owned(),
        "object" => "Object".to_owned(),
        _ => match &schema["enum"] {
            Value::Array(values) => {
                let values = values.iter().filter(|value| !value.is_null());
                let values: Vec<String> = values.map(Value::to_string).collect();
                format!("Literal[{}]", values.join(", "))
            }
            _ => "str".to_owned(),
        },
    };
    types.iter().map(one).collect::<Vec<_>>().join(" | ")
}

fn python() -> String {
    let head = r#""""The messages of a board, and the result of `fit`. `cargo xtask events` writes this file: do not edit it."""

from __future__ import annotations

import json
from typing import Literal

from ._objects import Object, Settings

__all__ = [ALL]


class Event(Object):
    """A message of a board."""

"#;
    let mut names: Vec<String> = schemas().iter().map(|(kind, _)| class(kind)).collect();
    names.push("Event".to_owned());
    names.sort();
    let names: String = names
        .iter()
        .map(|name| format!("\n    \"{name}\","))
        .collect();
    let mut out = head.replace("[ALL]", &format!("[{names}\n]"));
    let envelope = schema::<Message>();
    python_fields(&mut out, &envelope, &[]);
    let common: Vec<String> = envelope["properties"]
        .as_object()
        .into_iter()
        .flat_map(Map::keys)
        .cloned()
        .collect();
    let mut kinds = String::new();
    for (kind, schema) in schemas() {
        let class = class(kind);
        let base = if kind == "fit" { "Object" } else { "Event" };
        let described = schema["description"].as_str().unwrap_or_default();
        let _ = write!(
            out,
            "\n\nclass {class}({base}):\n{}\n",
            docstring(described)
        );
        let without: &[String] = if kind == "fit" { &[] } else { &common };
        python_fields(&mut out, &schema, without);
        if kind != "fit" {
            let _ = writeln!(kinds, "    \"{kind}\": {class},");
        }
    }
    out + "\n\n_KINDS: dict[str, type[Event]] = {\n"
        + &kinds
        + r#"}


def event(line: str) -> Event:
    """The event of one line of JSON."""
    fields = json.loads(line, object_hook=Object)
    return _KINDS.get(fields.get("type", ""), Event)(fields)
"#
}

fn class(kind: &str) -> String {
    let (first, rest) = kind.split_at(1);
    first.to_uppercase() + rest
}

fn python_fields(out: &mut String, schema: &Value, without: &[String]) {
    let required = schema["required"].as_array().cloned().unwrap_or_default();
    let fields = schema["properties"].as_object();
    for (name, property) in fields.into_iter().flatten() {
        if without.contains(name) {
            continue;
        }
        let mut kind = python_type(name, property);
        if !required.iter().any(|required| required == name) && !kind.ends_with("None") {
            kind += " | None";
        }
        let described = property["description"].as_str().unwrap_or_default();
        let _ = write!(out, "    {name}: {kind}\n{}", docstring(described));
    }
}

/// Formats a docstring in a class, in lines of at most 120 characters.
fn docstring(text: &str) -> String {
    let mut lines = vec!["    \"\"\"".to_owned()];
    for word in text.split(' ') {
        let last = lines.last_mut().expect("a line");
        if last.len() + word.len() > 112 {
            lines.push(format!("    {word}"));
        } else {
            let gap = if last.ends_with('"') { "" } else { " " };
            *last += &format!("{gap}{word}");
        }
    }
    lines.join("\n") + "\"\"\"\n"
}

/// Formats the reference's lists of fields: a section for each kind of message.
fn fields() -> String {
    let mut out = String::new();
    let envelope = schema::<Message>();
    let common = envelope["properties"].as_object().expect("properties");
    let _ = write!(out, "\n### Every message\n\n");
    for (name, property) in common {
        field(&mut out, name, property);
    }
    for (kind, schema) in schemas().iter().filter(|(kind, _)| *kind != "fit") {
        let described = schema["description"].as_str().unwrap_or_default();
        let _ = write!(out, "\n### `{kind}`\n\n{described}\n\n");
        let fields = schema["properties"].as_object().expect("properties");
        for (name, property) in fields {
            if !common.contains_key(name) {
                field(&mut out, name, property);
            }
        }
    }
    out + "\n"
}

/// Formats a line for a field, and one for each field within it.
fn field(out: &mut String, name: &str, schema: &Value) {
    let described = schema["description"].as_str().unwrap_or_default();
    let own = name.rsplit('.').next().unwrap_or(name);
    let unit = unit(own);
    let mut text = described.replace(&format!(" [{unit}]."), ".");
    if let Value::Array(values) = &schema["enum"] {
        let values = values.iter().filter_map(Value::as_str);
        let values: Vec<String> = values.map(|value| format!("`{value}`")).collect();
        text += &format!(" {}.", values.join(", "));
    }
    let _ = writeln!(out, "- `{name}`: {text}");
    for (inner, between) in [(schema, "."), (&schema["items"], "[].")] {
        // The kinds of faults have names of their own.
        let fields = inner["properties"].as_object().filter(|_| own != "faults");
        for (inside, property) in fields.into_iter().flatten() {
            field(out, &format!("{name}{between}{inside}"), property);
        }
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Compares a file, or writes it if [`WRITE`] is set.
fn compare_or_write(path: &str, wanted: &str) {
    let full = root().join(path);
    if std::env::var_os(WRITE).is_some() {
        std::fs::write(&full, wanted).expect("written");
        return;
    }
    let found = std::fs::read_to_string(&full).expect("a file");
    assert!(
        found == wanted,
        "{path} is not what the views say: run cargo xtask events"
    );
}

#[test]
fn what_is_made_from_the_views_is_up_to_date() {
    compare_or_write("host/src/events/schema.json", &schema_json());
    compare_or_write("host/python/package/ridgetone/_events.py", &python());
    let page = "host/reference.md";
    let text = std::fs::read_to_string(root().join(page)).expect("a page");
    let (before, rest) = text.split_once(BEGIN).expect("a beginning");
    let (_, after) = rest.split_once(END).expect("an end");
    compare_or_write(page, &format!("{before}{BEGIN}{}{END}{after}", fields()));
}

#[test]
fn every_field_is_described_and_has_one_type() {
    fn check(at: &str, schema: &Value) {
        let is_one = match &schema["type"] {
            Value::String(_) => true,
            Value::Array(types) => types.len() == 2 && types[1] == "null",
            _ => false,
        };
        assert!(is_one, "{at}: {schema}");
        if schema["type"] == "array" {
            check(&format!("{at}[]"), &schema["items"]);
        }
        let is_known = at.ends_with("settings") || at.ends_with("faults");
        for (name, property) in schema["properties"].as_object().into_iter().flatten() {
            let described = property["description"]
                .as_str()
                .is_some_and(|text| text.len() > 5);
            assert!(described || is_known, "{at}.{name} has no doc comment");
            check(&format!("{at}.{name}"), property);
        }
    }
    for (kind, schema) in schemas() {
        check(kind, &schema);
    }
}
