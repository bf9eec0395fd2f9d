//! One line per packet: time, type, and values with units. A static image has its map below.

use super::rows::{self, Column};
use super::serializable;
use crate::digits::{hex, seconds, significant, with_sigma};
use crate::names::name;
use crate::overtones::overtones;
use crate::remarks::{phrases, remedy};
use crate::static_image;
use ridgetone_proto::boot::{BrownOut, Death, Oscillator, ResetCause, SettingsSource};
use ridgetone_proto::command::{Outcome, Reply};
use ridgetone_proto::fault::{Fault, FaultKind};
use ridgetone_proto::plan::Gives;
use ridgetone_proto::settings::SlideRule;
use ridgetone_proto::telemetry::{
    Channel, ConverterState, Estimate, Event, Health, Hello, Hold, Image, Packet, Span, Texture,
    Track, Travel, TravelStatus,
};

/// Formats a packet as one line, without its end; an image as five lines.
pub fn text(packet: &Packet) -> String {
    match &packet.event {
        Event::Hello(e) => format!("{:>10}  hello     {}", "", hello(e)),
        Event::Contact(e) => line(
            e.t_us,
            "contact",
            &format!("taxel {}, spike of {:.2} mV", e.taxel, 1e3 * e.height_v),
        ),
        Event::Moving(e) => line(e.t_us, "moving", "first sign of a slide"),
        Event::Slide(e) => match e.end_us {
            None => line(e.start_us, "slide", "begins"),
            Some(end_us) => {
                let length_s = seconds(end_us) - seconds(e.start_us);
                line(
                    end_us,
                    "slide",
                    &format!("ends; {length_s:.3} s since {:.3} s", seconds(e.start_us)),
                )
            }
        },
        Event::Estimate(e) => line(e.t_us, "estimate", &estimate(e, &on_taxel)),
        Event::Track(e) => line(e.t_us, "track", &track(e)),
        Event::Release(e) => line(e.t_us, "release", "the finger is off"),
        Event::Health(e) => line(e.t_us, "health", &health(e)),
        Event::Image(e) => line(e.end_us, "image", &image(e)),
        Event::Fault(e) => line(e.until_us.unwrap_or(e.from_us), "fault", &fault(e)),
        Event::Reply(e) => format!("{:>10}  reply     {}", "", reply(e)),
        Event::Texture(e) => line(e.t_us, "texture", &texture(e)),
        Event::Converter(e) => line(e.t_us, "converter", &converter(e)),
        Event::Raw(e) => line(
            e.t_us,
            "raw",
            &format!("frame {}, codes {:?}", e.number, e.codes),
        ),
        // Events without a format of their own.
        #[allow(unreachable_patterns)]
        event => line(event.t_us().unwrap_or(0), &kind(packet), &values(packet)),
    }
}

fn kind(packet: &Packet) -> String {
    name(&packet.event).to_lowercase()
}

/// Formats the values of a packet by the names of their fields.
fn values(packet: &Packet) -> String {
    // A message that cannot be serialised has no values.
    let message = serde_json::to_value(serializable(packet)).unwrap_or_default();
    let columns = rows::columns(&kind(packet));
    let value = |column: &Column| format!("{} {}", column.name, column.text(&message));
    columns.iter().map(value).collect::<Vec<_>>().join(", ")
}

fn line(t_us: u64, name: &str, values: &str) -> String {
    format!("{:>8.3} s  {name:<8}  {values}", seconds(t_us))
}

fn hello(e: &Hello) -> String {
    let [major, minor, patch] = e.version;
    let s = &e.settings;
    let slide = match s.slide.rule {
        SlideRule::Found => "slide found in the signal".to_owned(),
        SlideRule::Always => "all of it a slide".to_owned(),
        SlideRule::Protocol => format!(
            "slide by protocol: {} s after contact, {} mm at {} mm/s",
            s.slide.delay_s, s.slide.length_mm, s.slide.speed_mm_s
        ),
    };
    let tone = match s.scene.overtones {
        true => format!("up to {} harmonics", s.harmonics),
        false => "a single sine".to_owned(),
    };
    let accuracy = match s.accuracy {
        0.0 => String::new(),
        accuracy => format!(", to {} %", 100.0 * accuracy),
    };
    let interferer = match s.interferer_hz {
        0.0 => String::new(),
        hz => format!(", interferer of {hz} Hz"),
    };
    let source = match e.source {
        SettingsSource::Default => String::new(),
        source => format!(", settings {}", name(source)),
    };
    let cause = match e.boot.cause {
        ResetCause::Unknown => String::new(),
        cause => format!(", started by {}", name(cause)),
    };
    let oscillator = match e.boot.oscillator {
        Oscillator::Internal => {
            ", INTERNAL OSCILLATOR: the external one does not start, all times are off by up to 8 %"
        }
        Oscillator::External | Oscillator::Unknown => "",
    };
    let brown_out = match e.boot.brown_out {
        BrownOut::Unknown => String::new(),
        level => format!(", brown-out {}", name(level)),
    };
    let record = e
        .boot
        .record
        .as_ref()
        .map_or_else(String::new, |r| match r.death {
            Death::Panic | Death::HardFault => format!(
                ", after a {} in {} line {}, pc {:#010x}, lr {:#010x}",
                name(r.death),
                r.file,
                r.line,
                r.pc,
                r.lr
            ),
            Death::Oscillator => ", after a run in which the external one stopped".to_owned(),
        });
    format!(
        "firmware {major}.{minor}.{patch}, protocol {}, {:.2} frames/s, windows of {} s every {} s, {tone}, reference {} V{accuracy}{interferer}, {slide}{source}{cause}{oscillator}{brown_out}{record}",
        e.protocol, e.frame_rate_hz, s.window_s, s.stride_s, s.vref_v
    )
}

/// Columns of a table that were read as channels.
#[derive(Clone, Debug)]
pub struct Columns {
    pub names: Vec<String>,
    /// Unit of each column, if the file names it.
    pub units: Vec<Option<String>>,
    pub volts_per_unit: f64,
}

impl Columns {
    /// Formats a value of a channel with its unit and its column.
    fn level(&self, volts: f32, channel: u8) -> String {
        let value = significant(f64::from(volts) / self.volts_per_unit, 4);
        let unit = self
            .units
            .get(usize::from(channel))
            .and_then(Option::as_deref);
        let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
        let name = self.names.get(usize::from(channel));
        format!("{value}{unit} in {}", name.map_or("?", String::as_str))
    }
}

/// Like [`text`], with the columns and units of a table in place of taxels and volts.
pub fn text_of_columns(packet: &Packet, columns: &Columns) -> String {
    let level = |volts, channel| columns.level(volts, channel);
    match &packet.event {
        Event::Contact(e) => {
            let spike = level(e.height_v, e.taxel);
            line(e.t_us, "contact", &format!("spike of {spike}"))
        }
        Event::Estimate(e) => line(e.t_us, "estimate", &estimate(e, &level)),
        _ => text(packet),
    }
}

fn on_taxel(volts: f32, taxel: u8) -> String {
    format!("{:.3} mV on taxel {taxel}", 1e3 * volts)
}

/// Formats an estimate; `level` formats the amplitude of a channel.
fn estimate(e: &Estimate, level: &dyn Fn(f32, u8) -> String) -> String {
    let span = match e.span {
        Span::Window => "window",
        Span::Slide => "SLIDE",
    };
    let tone = tone(&Track::from(e));
    let mut out = format!("{span:<6} {:.3} s  {tone}  {}", e.window_s, name(e.status));
    if let Some(remedy) = remedy(e.status) {
        out += &format!(" ({remedy})");
    }
    for phrase in phrases(e) {
        out += &format!(", {phrase}");
    }
    if e.status.has_tone() {
        out += &format!(", harmonics {}", e.harmonics);
        let strongest = |a: &&Channel, b: &&Channel| a.amplitude_v.total_cmp(&b.amplitude_v);
        if let Some(c) = e.channels.iter().max_by(strongest) {
            out += &format!(
                ", {} channels, most {}",
                e.channels.len(),
                level(c.amplitude_v, c.taxel)
            );
        }
    }
    if e.travel.status != TravelStatus::Nothing {
        out += &format!("; {}", travel(&e.travel));
    }
    if !e.faults.is_none() {
        let names: Vec<_> = e.faults.iter().map(name).collect();
        out += &format!(", faults: {}", names.join(", "));
    }
    if e.frames_missing > 0 {
        out += &format!(", {} frames missing", e.frames_missing);
    }
    out
}

fn track(e: &Track) -> String {
    format!("{}  {}", tone(e), name(e.status))
}

/// Formats frequency and standard deviation, if there is a tone.
fn tone(e: &Track) -> String {
    if e.status.has_tone() {
        let (value, sigma) = with_sigma(e.frequency.into(), e.sigma.into());
        format!("{value:>9} Hz +- {sigma} Hz")
    } else {
        format!("{:>9} Hz", "-")
    }
}

fn image(e: &Image) -> String {
    let hold = match e.hold {
        Hold::BeforeSlide => "before the slide",
        Hold::AfterSlide => "after the slide",
    };
    let sigma = match static_image::max_sigma_v(e) {
        Some(sigma_v) => {
            let sigma_mv = significant(f64::from(1e3 * sigma_v), 2);
            format!("mV, sigma at most {sigma_mv} mV")
        }
        None => "every taxel is dead".into(),
    };
    let length_s = seconds(e.end_us) - seconds(e.start_us);
    let map = static_image::text(e, &format!("{:22}", ""));
    format!(
        "{hold}: mean over {length_s:.3} s from {:.3} s; {sigma}\n{}",
        seconds(e.start_us),
        map.trim_end()
    )
}

fn travel(e: &Travel) -> String {
    let status = name(e.status);
    if !e.is_known() {
        return format!("period {status}");
    }
    let direction = e.direction.known().map_or("either way", name);
    let (period_mm, period_sigma_mm) =
        with_sigma(e.spatial_period_mm.into(), e.spatial_period_sigma_mm.into());
    let (speed_mm_s, speed_sigma_mm_s) = with_sigma(e.speed_mm_s.into(), e.speed_sigma_mm_s.into());
    format!(
        "period {period_mm} mm +- {period_sigma_mm} mm, {direction} at {speed_mm_s} mm/s +- {speed_sigma_mm_s} mm/s ({status})"
    )
}

fn converter(e: &ConverterState) -> String {
    let ConverterState { name, .. } = e;
    let registers = hex(&e.registers);
    if e.answers {
        format!("{name} answers; registers {registers}")
    } else {
        format!(
            "{name} DOES NOT ANSWER: look at its supply, clock and wiring; the board tries on. Registers read {registers}"
        )
    }
}

fn texture(e: &Texture) -> String {
    let (period_mm, period_sigma_mm) = with_sigma(e.period_mm.into(), e.period_sigma_mm.into());
    let (power_mv2, power_sigma_mv2) = with_sigma(
        1e6 * f64::from(e.power_v2),
        1e6 * f64::from(e.power_sigma_v2),
    );
    let level = e.level_v.map_or(String::new(), |level_v| {
        format!(", pressed to {:.3} mV", 1e3 * level_v)
    });
    let overtones = overtones(&e.overtones)
        .map(|overtone| format!("{:.1}", 100.0 * overtone.amplitude))
        .join(" ");
    format!(
        "period {period_mm} mm +- {period_sigma_mm} mm, power {power_mv2} mV^2 +- {power_sigma_mv2} mV^2, overtones {overtones} %{level}"
    )
}

fn fault(e: &Fault) -> String {
    let kind = name(e.kind);
    match e.until_us {
        None => format!("{kind} begins; seen {} times since start-up", e.count),
        Some(until_us) => {
            let length_s = seconds(until_us) - seconds(e.from_us);
            format!(
                "{kind} is over; {length_s:.3} s since {:.3} s; seen {} times",
                seconds(e.from_us),
                e.count
            )
        }
    }
}

fn reply(e: &Reply) -> String {
    let gives = e
        .gives
        .as_ref()
        .map_or(String::new(), |gives| format!("; {}", given(gives)));
    format!("request {}: {}{gives}", e.number, outcome(&e.outcome))
}

/// Formats the rates and windows of a plan.
pub fn given(gives: &Gives) -> String {
    let Gives {
        frame_rate_hz,
        nyquist_hz,
        window_max_s,
    } = gives;
    format!(
        "{frame_rate_hz:.2} frames/s, tones below {nyquist_hz:.1} Hz, windows up to {window_max_s} s"
    )
}

pub fn outcome(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Done => "done".to_owned(),
        Outcome::Setting(error) => format!("refused: {error}"),
        Outcome::NotStored => {
            "in force, but not stored: repeat it while nothing is touched; if it fails again the flash is worn".into()
        }
        Outcome::Busy => "refused: busy with another request; repeat it".into(),
        Outcome::DoneErased => "done; the flash was erased for it, which cost one or two seconds of conversions".into(),
    }
}

fn health(e: &Health) -> String {
    let load = if e.load > 0.0 {
        format!(", load {:.1} %", 100.0 * e.load)
    } else {
        String::new()
    };
    let stack = match e.stack_bytes {
        0 => String::new(),
        bytes => format!(", stack {} of {bytes} bytes", e.stack_used_bytes),
    };
    let seen = FaultKind::ALL
        .into_iter()
        .zip(e.faults)
        .filter(|(_, count)| *count > 0);
    let faults: String = seen
        .map(|(kind, count)| format!(", {} {count} times", name(kind)))
        .collect();
    let thinned = match e.frames_thinned {
        0 => String::new(),
        count => format!(", {count} raw frames not sent"),
    };
    format!(
        "{} frames at {:.3} Hz; conversions: {} lost, {} doubtful; {} overruns, {} messages dropped{thinned}, {} restarts of the ADC{faults}{load}{stack}; supply {:.3} V, reference {:.4} V, {:.1} C, offset {:.1} uV, gain {:.6}",
        e.frames,
        e.frame_rate_hz,
        e.conversions_lost,
        e.conversions_doubtful,
        e.overruns,
        e.messages_dropped,
        e.chip_restarts,
        e.supply_v,
        e.reference_v,
        e.temperature_c,
        1e6 * e.offset_v,
        e.gain
    )
}
