//! Lines for Teleplot (<https://github.com/nesnes/teleplot>): `>name:time_ms:value|g`, one for each
//! number.

use crate::digits::time_s;
use crate::events::{JsonLines, rows};
use ridgetone_proto::telemetry::Packet;
use std::fmt::Write;

/// What is plotted: the `type` of the messages, columns as in a table, and the names of the lines.
/// `*` stands for whatever is there, and is repeated in the name.
const PLOTTED: [(&str, &str, &str); 14] = [
    ("estimate", "frequency_hz", "frequency_hz"),
    ("estimate", "sigma_hz", "sigma_hz"),
    ("estimate", "wander_percent", "wander_percent"),
    ("estimate", "spatial_period_mm", "spatial_period_mm"),
    ("estimate", "speed_mm_s", "speed_mm_s"),
    ("raw", "volts_*", "ain*_v"),
    ("texture", "period_mm", "texture_period_mm"),
    ("texture", "power_v2", "texture_power_v2"),
    ("feel", "receptors_*_intensity_per_hz", "*_per_hz"),
    ("feel", "scores_*_score", "*"),
    ("health", "load", "load"),
    ("health", "temperature_c", "temperature_c"),
    ("health", "supply_v", "supply_v"),
    ("health", "conversions_lost", "conversions_lost"),
];

/// Turns packets into lines. It needs all packets: raw frames become volts by the reference in the
/// board's greeting.
#[derive(Clone, Debug, Default)]
pub struct Teleplot {
    json: JsonLines,
}

impl Teleplot {
    /// The lines of a packet at device time in milliseconds, without the last end of line; empty
    /// without numbers.
    pub fn lines(&mut self, packet: &Packet) -> String {
        // What cannot be JSON has no numbers.
        let message = serde_json::to_value(self.json.message(packet, None)).unwrap_or_default();
        let kind = message["type"].as_str().unwrap_or_default();
        let columns = rows::columns(kind, &message);
        let time_ms = 1e3 * time_s(&packet.event).unwrap_or(0.0);
        let mut lines = String::new();
        for (_, wanted, name) in PLOTTED.iter().filter(|plotted| plotted.0 == kind) {
            for column in &columns {
                let Some(part) = matched(wanted, &column.name) else {
                    continue;
                };
                if let Some(value) = column.number(&message) {
                    let gap = if lines.is_empty() { "" } else { "\n" };
                    let name = name.replace('*', part);
                    // Writing to a string cannot fail.
                    let _ = write!(lines, "{gap}>{name}:{time_ms:.3}:{value}|g");
                }
            }
        }
        lines
    }
}

/// What `*` in a pattern stands for in a name; empty if they are the same.
fn matched<'n>(pattern: &str, name: &'n str) -> Option<&'n str> {
    let Some((before, after)) = pattern.split_once('*') else {
        return (pattern == name).then_some("");
    };
    name.strip_prefix(before)?.strip_suffix(after)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::fault::FaultSet;
    use ridgetone_proto::plan::Plan;
    use ridgetone_proto::settings::TAXELS;
    use ridgetone_proto::telemetry::Event;
    use ridgetone_proto::telemetry::{BANDS, Feel, Health, Measured, Raw, Release, Texture};

    #[test]
    fn numbers_get_a_name_a_time_and_a_value_and_events_without_numbers_none() {
        let mut teleplot = Teleplot::default();
        let health = Health {
            t_us: 1_234_567,
            load: 0.5,
            temperature_c: 25.0,
            supply_v: 5.0,
            ..Health::default()
        };
        let lines = teleplot.lines(&Packet {
            sequence: 1,
            event: Event::Health(health),
        });
        let expected = [
            ">load:1234.567:0.5|g",
            ">temperature_c:1234.567:25|g",
            ">supply_v:1234.567:5|g",
            ">conversions_lost:1234.567:0|g",
        ];
        assert_eq!(lines.lines().collect::<Vec<_>>(), expected);
        let mut codes = [0; TAXELS];
        codes[3] = 7_864_320;
        let raw = Raw {
            t_us: 2_000_000,
            number: 1,
            present: 0b1001,
            good: 0b1110,
            codes,
        };
        let line = teleplot.lines(&Packet {
            sequence: 1,
            event: Event::Raw(raw),
        });
        // A code of the reference's is the reference's voltage.
        assert_eq!(line, ">ain3_v:2000.000:4.096|g");
        // What is absent has no line.
        let measured = |value| Some(Measured { value, sigma: 0.5 });
        let feel = Feel {
            t_us: 3_000_000,
            window_s: 1.0,
            rate_hz: 1024.0,
            taxels: 1,
            faults: FaultSet::NONE,
            per_hz: [measured(0.5), None, measured(0.25), measured(2.0)],
            force_ratio: None,
            soft: measured(5.5),
            rough: None,
            levels_db: [0; BANDS],
        };
        let lines = teleplot.lines(&Packet {
            sequence: 1,
            event: Event::Feel(feel),
        });
        let expected = [
            ">fa1_per_hz:3000.000:0.5|g",
            ">sa1_per_hz:3000.000:0.25|g",
            ">sa2_per_hz:3000.000:2|g",
            ">soft:3000.000:5.5|g",
        ];
        assert_eq!(lines.lines().collect::<Vec<_>>(), expected);
        let texture = Texture {
            t_us: 4_000_000,
            plan: Plan::PAPER,
            period_mm: 3.5,
            period_sigma_mm: 0.25,
            power_v2: 0.5,
            power_sigma_v2: 0.125,
            overtones: [[0.0; 2]; 3],
            level_v: None,
        };
        let lines = teleplot.lines(&Packet {
            sequence: 1,
            event: Event::Texture(texture),
        });
        assert_eq!(
            lines,
            ">texture_period_mm:4000.000:3.5|g\n>texture_power_v2:4000.000:0.5|g"
        );
        assert_eq!(
            teleplot.lines(&Packet {
                sequence: 1,
                event: Event::Release(Release { t_us: 5 })
            }),
            ""
        );
    }
}
