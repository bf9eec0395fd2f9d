//! Rewords the command's messages for Python: options become arguments.

/// Value of an option.
#[derive(Clone, Copy)]
enum Value {
    Number,
    Text,
    /// The option is a switch without a value.
    On,
}

/// Options of the command that occur in messages, and the corresponding arguments.
const ARGUMENTS: [(&str, &str, Value); 25] = [
    ("--rate", "rate_hz", Value::Number),
    ("--from", "from_s", Value::Number),
    ("--to", "to_s", Value::Number),
    ("--min-hz", "min_hz", Value::Number),
    ("--max-hz", "max_hz", Value::Number),
    ("--harmonics", "harmonics", Value::Number),
    ("--mains", "mains_hz", Value::Number),
    ("--mm-per-count", "mm_per_count", Value::Number),
    ("--scale", "scale", Value::Number),
    ("--window", "window_s", Value::Number),
    ("--stride", "stride_s", Value::Number),
    ("--time-column", "time_column", Value::Text),
    ("--speed-column", "speed_column", Value::Text),
    ("--position-column", "position_column", Value::Text),
    ("--columns", "columns", Value::Text),
    ("--exclude", "exclude", Value::Text),
    ("--reference", "reference", Value::Text),
    ("--port", "source", Value::Text),
    ("--usb-serial", "usb_serial", Value::Text),
    ("--elf", "elf", Value::Text),
    ("--settings", "settings", Value::Text),
    ("--whole", "whole", Value::On),
    ("--flatten", "flatten", Value::On),
    ("--raw", "raw", Value::On),
    ("--emulated", "source=\"emulated\"", Value::Text),
];

/// Replaces options in a message by arguments, except in commands that the user is to type.
pub fn of_python(message: &str) -> String {
    let part = |part: &str| match part.starts_with("ridgetone ") {
        true => part.to_owned(),
        false => with_arguments(part),
    };
    message.split('`').map(part).collect::<Vec<_>>().join("`")
}

fn with_arguments(message: &str) -> String {
    let (mut out, mut ahead) = (String::new(), message);
    while let Some(at) = ahead.find("--") {
        let (before, from) = ahead.split_at(at);
        out += before;
        let end = from[2..]
            .find(|c: char| !c.is_ascii_lowercase() && c != '-')
            .map_or(from.len(), |end| end + 2);
        let (option, after) = from.split_at(end);
        let found = ARGUMENTS.iter().find(|(known, ..)| *known == option);
        let Some((_, argument, value)) = found else {
            out += option;
            ahead = after;
            continue;
        };
        out += argument;
        ahead = after;
        let Some(Token { text, after }) = Token::of(after) else {
            if matches!(value, Value::On) {
                out += "=True";
            }
            continue;
        };
        match value {
            Value::On => out += "=True",
            // Skips a placeholder in capitals, such as HZ.
            _ if text.chars().all(|c| c.is_ascii_uppercase()) => ahead = after,
            Value::Number if text.parse::<f64>().is_ok() => {
                out += &format!("={text}");
                // Drop the unit, which is part of the argument's name.
                let unit = [" Hz", " s"].into_iter();
                let mut without = unit.filter_map(|unit| after.strip_prefix(unit));
                ahead = without
                    .find(|ahead| !ahead.starts_with(|c: char| c.is_alphanumeric()))
                    .unwrap_or(after);
            }
            Value::Text if text.contains(':') || after.starts_with(',') => {
                out += &format!("={text:?}");
                ahead = after;
            }
            _ => {}
        }
    }
    out + ahead
}

/// The word after an option, without quotes, and the remaining text.
struct Token<'a> {
    text: &'a str,
    after: &'a str,
}

impl<'a> Token<'a> {
    fn of(text: &'a str) -> Option<Self> {
        let text = text.strip_prefix(' ')?;
        if let Some((quoted, after)) = text.strip_prefix('\'').and_then(|t| t.split_once('\'')) {
            return Some(Self {
                text: quoted,
                after,
            });
        }
        let end = text.find([' ', ',', ';', ')']).unwrap_or(text.len());
        let token = text[..end].strip_suffix(':').unwrap_or(&text[..end]);
        (!token.is_empty()).then_some(Self {
            text: token,
            after: &text[token.len()..],
        })
    }
}
