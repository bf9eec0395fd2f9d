//! Lines for Teleplot (<https://github.com/nesnes/teleplot>): `>name:time_ms:value|g`, one for each
//! number.

use crate::digits::time_s;
use crate::feel::event::{Reading, ratings, receptors};
use crate::live::Point;
use ads1258::reading;
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Abscissa, Event, Packet};
use std::fmt::Write;

/// Turns packets into lines. It needs all packets: raw frames become volts by the reference in the
/// board's greeting.
#[derive(Clone, Copy, Debug)]
pub struct Teleplot {
    vref_v: f32,
}

impl Default for Teleplot {
    fn default() -> Self {
        Self {
            vref_v: Settings::DEFAULT.vref_v,
        }
    }
}

impl Teleplot {
    /// The lines of a packet at device time in milliseconds, without the last end of line; empty
    /// without numbers.
    pub fn lines(&mut self, packet: &Packet) -> String {
        let mut lines = String::new();
        let time_ms = 1e3 * time_s(&packet.event).unwrap_or(0.0);
        let mut put = |name: &str, value: f64| {
            let gap = if lines.is_empty() { "" } else { "\n" };
            // Writing to a string cannot fail.
            let _ = write!(lines, "{gap}>{name}:{time_ms:.3}:{value}|g");
        };
        match &packet.event {
            Event::Hello(hello) => self.vref_v = hello.settings.vref_v,
            Event::Estimate(estimate) => {
                let point = Point::new(estimate);
                let unit = if point.abscissa == Abscissa::Place {
                    "per_mm"
                } else {
                    "hz"
                };
                let values = [
                    (format!("frequency_{unit}"), point.frequency),
                    (format!("sigma_{unit}"), point.sigma),
                    ("wander_percent".into(), point.wander_percent),
                    ("spatial_period_mm".into(), point.spatial_period_mm),
                    ("speed_mm_s".into(), point.speed_mm_s),
                ];
                values
                    .iter()
                    .filter_map(|(name, value)| Some((name, (*value)?)))
                    .for_each(|(n, v)| put(n, v.into()));
            }
            Event::Raw(raw) => {
                for taxel in (0..TAXELS).filter(|taxel| raw.present & raw.good & 1 << taxel != 0) {
                    put(
                        &format!("ain{taxel}_v"),
                        reading::volts(raw.codes[taxel], self.vref_v).into(),
                    );
                }
            }
            Event::Texture(texture) => {
                put("texture_period_mm", texture.period_mm.into());
                put("texture_power_v2", texture.power_v2.into());
            }
            Event::Feel(feel) => {
                for Reading { key, found, .. } in receptors(feel) {
                    found
                        .into_iter()
                        .for_each(|found| put(&format!("{key}_per_hz"), found.value.into()));
                }
                for Reading { key, found, .. } in ratings(feel) {
                    found
                        .into_iter()
                        .for_each(|found| put(key, found.value.into()));
                }
            }
            Event::Health(health) => {
                put("load", health.load.into());
                put("temperature_c", health.temperature_c.into());
                put("supply_v", health.supply_v.into());
                put("conversions_lost", health.conversions_lost.into());
            }
            _ => {}
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::fault::FaultSet;
    use ridgetone_proto::plan::Plan;
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
        // A code of the reference's is the reference's voltage, in single precision.
        assert_eq!(line, format!(">ain3_v:2000.000:{}|g", f64::from(4.096f32)));
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
