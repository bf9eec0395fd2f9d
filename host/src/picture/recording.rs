//! Data of the picture: sixteen channels over time, and the results.

use crate::digits::seconds;
use ridgetone_finger::TimedConversion;
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Estimate, Event, Packet, Span};

/// Channel id of AIN0, the first taxel (SBAS297G, channel ids).
const FIRST_CHID: u8 = 0x08;

/// Number of first samples whose mean is a channel's idle level.
const IDLE_SAMPLES: usize = 48;

/// Sixteen channels and the results. Times are device time: seconds since the first conversion.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// Time in seconds and volts above the idle level, for each taxel.
    pub channels: [Vec<(f64, f64)>; TAXELS],
    pub contacts_s: Vec<f64>,
    /// Start and end of each slide that has ended.
    pub slides_s: Vec<(f64, f64)>,
    pub releases_s: Vec<f64>,
    /// Last fit over a whole slide.
    pub slide_fit: Option<Estimate>,
}

impl Recording {
    /// Creates the data from conversions that a board has read and packets that it has sent.
    pub fn new(conversions: &[TimedConversion], packets: &[Packet]) -> Self {
        let (mut recording, mut vref_v) = (Self::default(), Settings::default().vref_v);
        for packet in packets {
            if let Event::Hello(hello) = &packet.event {
                vref_v = hello.settings.vref_v;
            }
            recording.take(&packet.event);
        }
        let (mut t_us, mut before_us) = (0, conversions.first().map_or(0, |first| first.t_us));
        for c in conversions {
            t_us += u64::from(c.t_us.wrapping_sub(before_us));
            before_us = c.t_us;
            let taxel = usize::from(c.status().chid().wrapping_sub(FIRST_CHID));
            if let Some(channel) = recording.channels.get_mut(taxel) {
                channel.push((seconds(t_us), volts(c.code(), vref_v)));
            }
        }
        recording.level()
    }

    pub fn of_frames(packets: &[Packet], vref_v: f32) -> Self {
        let mut recording = Self::default();
        for packet in packets {
            recording.take(&packet.event);
            let Event::Raw(raw) = &packet.event else {
                continue;
            };
            for (taxel, channel) in recording.channels.iter_mut().enumerate() {
                if raw.present & raw.good & 1 << taxel != 0 {
                    channel.push((seconds(raw.t_us), volts(raw.codes[taxel], vref_v)));
                }
            }
        }
        recording.level()
    }

    fn take(&mut self, event: &Event) {
        match event {
            Event::Contact(e) => self.contacts_s.push(seconds(e.t_us)),
            Event::Slide(e) => self
                .slides_s
                .extend(e.end_us.map(|end| (seconds(e.start_us), seconds(end)))),
            Event::Release(e) => self.releases_s.push(seconds(e.t_us)),
            Event::Estimate(e) if e.span == Span::Slide => self.slide_fit = Some(e.clone()),
            _ => {}
        }
    }

    /// Subtracts each channel's idle level.
    fn level(mut self) -> Self {
        for channel in &mut self.channels {
            let head = &channel[..channel.len().min(IDLE_SAMPLES)];
            let idle_v = head.iter().map(|(_, v)| v).sum::<f64>() / head.len().max(1) as f64;
            channel.iter_mut().for_each(|(_, v)| *v -= idle_v);
        }
        self
    }

    pub fn span_s(&self) -> (f64, f64) {
        let all = || self.channels.iter().flatten().map(|(t_s, _)| *t_s);
        let (from_s, to_s) = (
            all().fold(f64::INFINITY, f64::min),
            all().fold(f64::NEG_INFINITY, f64::max),
        );
        if from_s < to_s {
            (from_s, to_s)
        } else {
            (0.0, 1.0)
        }
    }
}

/// Converts a code to volts in f64, because subtracting an idle level of volts leaves millivolts.
fn volts(code: i32, vref_v: f32) -> f64 {
    f64::from(code) * f64::from(vref_v) / f64::from(ads1258::reading::CODES_PER_VREF)
}
