//! The picture of a run on the chip: sixteen strips, the results, and the fitted tone close up.

use crate::chart::strips::{Phases, Strip, Strips};
use crate::digits::{decimals, seconds, significant, uncertain};
use crate::names::name;
use crate::remarks::phrases;
use ridgetone_finger::TimedConversion;
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Channel, Estimate, Event, Packet, Span, Status};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

/// Channel id of AIN0, the first taxel (SBAS297G, channel ids).
const FIRST_CHID: u8 = 0x08;

/// Samples from which a channel's idle level is taken.
const IDLE_SAMPLES: usize = 48;

/// Periods of the tone in the close-up, and points of the fitted curve there.
const CLOSE_PERIODS: f64 = 4.0;
const CURVE_POINTS: u32 = 100;

/// Sixteen channels and the results. Times are device times in seconds: since the first conversion.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// Per taxel: time, and volts above its idle level.
    pub channels: [Vec<(f64, f64)>; TAXELS],
    /// Idle level per taxel, volts.
    pub idle_v: [f64; TAXELS],
    pub contacts_s: Vec<f64>,
    /// Slides that have ended, start and end.
    pub slides_s: Vec<(f64, f64)>,
    pub releases_s: Vec<f64>,
    /// The last fit over a whole slide.
    pub slide_fit: Option<Estimate>,
}

impl Recording {
    /// From the conversions that a board has read and the packets that it has sent.
    pub fn new(conversions: &[TimedConversion], packets: &[Packet]) -> Self {
        let mut recording = Self::default();
        let mut vref_v = Settings::default().vref_v;
        for packet in packets {
            match &packet.event {
                Event::Hello(e) => vref_v = e.settings.vref_v,
                Event::Contact(e) => recording.contacts_s.push(seconds(e.t_us)),
                Event::Slide(e) => recording
                    .slides_s
                    .extend(e.end_us.map(|end| (seconds(e.start_us), seconds(end)))),
                Event::Release(e) => recording.releases_s.push(seconds(e.t_us)),
                Event::Estimate(e) if e.span == Span::Slide => {
                    recording.slide_fit = Some(e.clone())
                }
                _ => {}
            }
        }
        let (mut t_us, mut before_us) = (0, conversions.first().map_or(0, |first| first.t_us));
        for c in conversions {
            t_us += u64::from(c.t_us.wrapping_sub(before_us));
            before_us = c.t_us;
            let taxel = usize::from(c.status().chid().wrapping_sub(FIRST_CHID));
            if let Some(channel) = recording.channels.get_mut(taxel) {
                // In f64: the idle level of volts is taken off millivolts below.
                let volts = f64::from(c.code()) * f64::from(vref_v)
                    / f64::from(ads1258::reading::CODES_PER_VREF);
                channel.push((seconds(t_us), volts));
            }
        }
        for (channel, idle_v) in recording.channels.iter_mut().zip(&mut recording.idle_v) {
            let head = &channel[..channel.len().min(IDLE_SAMPLES)];
            *idle_v = head.iter().map(|(_, v)| v).sum::<f64>() / head.len().max(1) as f64;
            channel.iter_mut().for_each(|(_, v)| *v -= *idle_v);
        }
        recording
    }

    fn span_s(&self) -> RangeInclusive<f64> {
        let times = self.channels.iter().flatten().map(|(t_s, _)| *t_s);
        let (from_s, to_s) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), t_s| {
            (t_s.min(from), t_s.max(to))
        });
        if from_s < to_s {
            from_s..=to_s
        } else {
            0.0..=1.0
        }
    }

    fn phases(&self) -> Phases {
        let contacts = self.contacts_s.iter().map(|t_s| (t_s, "contact"));
        let releases = self.releases_s.iter().map(|t_s| (t_s, "release"));
        let labelled = |(t_s, what): (&f64, &str)| (*t_s, format!("{what} {t_s:.2} s"));
        Phases {
            marks: contacts.chain(releases).map(labelled).collect(),
            slides: self.slides_s.iter().map(|(from, to)| *from..=*to).collect(),
            window: self.slide_fit.as_ref().map(window),
        }
    }

    fn strip(&self, taxel: usize, close: Option<&(Estimate, RangeInclusive<f64>)>) -> Strip {
        let mut strip = Strip {
            name: taxel.to_string(),
            readings: self.channels[taxel].clone(),
            ..Strip::default()
        };
        let found = close.and_then(|(fit, range)| {
            let mut channels = fit.channels.iter();
            let channel = channels.find(|channel| usize::from(channel.taxel) == taxel)?;
            Some((fit, range, channel))
        });
        if let Some((fit, range, channel)) = found {
            let amplitude_mv = 1e3 * f64::from(channel.amplitude_v);
            strip.amplitude = format!("{} mV", significant(amplitude_mv, 3));
            strip.curve = fundamental(fit, channel, range, self.idle_v[taxel]);
        }
        strip
    }
}

/// Draws a recording. `nominal_hz` is the true frequency where it is known.
pub fn draw(recording: &Recording, nominal_hz: Option<f64>) -> String {
    let fit = recording.slide_fit.as_ref();
    let (title, subtitle) = headline(fit, nominal_hz);
    let close = fit.filter(|fit| fit.status.has_tone()).map(|fit| {
        let slide = window(fit);
        let centre_s = 0.5 * (slide.start() + slide.end());
        let half_s = (0.5 * CLOSE_PERIODS / f64::from(fit.frequency)).min(slide.end() - centre_s);
        (fit.clone(), centre_s - half_s..=centre_s + half_s)
    });
    let strips = (0..TAXELS).map(|taxel| recording.strip(taxel, close.as_ref()));
    let strips = Strips {
        title,
        subtitle,
        warning: None,
        row: "taxel",
        headings: ["", "close up, with the fitted fundamental"],
        axis: "time, s",
        range: recording.span_s(),
        strips: strips.collect(),
        close: close.map(|(_, range)| range),
        is_in_volts: true,
        phases: Some(recording.phases()),
    };
    strips.picture(None)
}

fn headline(fit: Option<&Estimate>, nominal_hz: Option<f64>) -> (String, String) {
    let Some(fit) = fit else {
        return ("Sixteen taxels".into(), "No slide was found.".into());
    };
    if !fit.status.has_tone() {
        return (
            "Sixteen taxels".into(),
            format!("The whole slide gave no tone: {}.", name(fit.status)),
        );
    }
    let found = uncertain(fit.frequency.into(), fit.sigma.into());
    let title = format!("Sixteen taxels, one tone: {found} Hz");
    let mut subtitle = format!(
        "Least squares over {} channels and {:.2} s of sliding",
        fit.channels.len(),
        fit.window_s
    );
    if fit.status != Status::Good {
        subtitle += &format!("; {}", name(fit.status));
    }
    for phrase in phrases(fit) {
        subtitle += &format!("; {phrase}");
    }
    if let Some(nominal_hz) = nominal_hz {
        let error = 100.0 * (f64::from(fit.frequency) / nominal_hz - 1.0);
        let decimals = decimals(100.0 * f64::from(fit.sigma / fit.frequency)).unwrap_or(3);
        subtitle += &format!("; nominal {nominal_hz:.4} Hz, error {error:+.decimals$} %");
    }
    (title, subtitle)
}

fn window(fit: &Estimate) -> RangeInclusive<f64> {
    let end_s = seconds(fit.t_us);
    end_s - f64::from(fit.window_s)..=end_s
}

/// A channel's fitted fundamental, which has its phase at the window's centre.
fn fundamental(
    fit: &Estimate,
    channel: &Channel,
    range: &RangeInclusive<f64>,
    idle_v: f64,
) -> Vec<(f64, f64)> {
    let centre_s = 0.5 * (range.start() + range.end());
    let step_s = (range.end() - range.start()) / f64::from(CURVE_POINTS);
    let value = |t_s: f64| {
        let angle = TAU * f64::from(fit.frequency) * (t_s - centre_s);
        let wave = (angle + f64::from(channel.phase_rad)).cos();
        f64::from(channel.offset_v) - idle_v + f64::from(channel.amplitude_v) * wave
    };
    (0..=CURVE_POINTS)
        .map(|step| range.start() + step_s * f64::from(step))
        .map(|t_s| (t_s, value(t_s)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_recording_is_a_picture_too() {
        let svg = draw(&Recording::default(), None);
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
