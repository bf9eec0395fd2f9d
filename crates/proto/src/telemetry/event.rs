//! The events, and the structs of the small ones.

use super::estimate::{Estimate, Status};
use super::image::Image;
use super::texture::Texture;
use crate::boot::{Boot, SettingsSource};
use crate::command::Reply;
use crate::fault::{Fault, KINDS};
use crate::settings::{Settings, TAXELS};
use heapless::String;
use serde::{Deserialize, Serialize};

/// Event that the board reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)]
pub enum Event {
    /// The board has started, or replies to a request for a greeting.
    Hello(Hello),
    /// The contact spike.
    Contact(Contact),
    /// The sliding phase begins or ends.
    Slide(Slide),
    /// Result of a fit.
    Estimate(Estimate),
    /// The finger is off the stimulus.
    Release(Release),
    /// Counters and readings.
    Health(Health),
    /// Pressure map of a hold.
    Image(Image),
    /// A fault begins or ends.
    Fault(Fault),
    /// Reply to a request.
    Reply(Reply),
    /// A frame as read from the converter.
    Raw(Raw),
    /// Surface under the finger.
    Texture(Texture),
    /// State of the converter.
    Converter(ConverterState),
    /// Frequency of a window in brief, if windows are close together.
    Track(Track),
    /// The first sign of tangential motion.
    Moving(Moving),
}

/// First event after start-up, and again about every ten seconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// [`PROTOCOL`](super::PROTOCOL).
    pub protocol: u8,
    /// Firmware version: major, minor, patch.
    pub version: [u8; 3],
    /// Nominal frames per second, from the plan and the converter's nominal clock.
    pub frame_rate_hz: f32,
    /// Current settings.
    pub settings: Settings,
    /// Source of the settings.
    pub source: SettingsSource,
    /// Reason for the board's start.
    pub boot: Boot,
    /// Device time, microseconds. Zero before the first conversion, and so in the first greeting
    /// after start-up.
    pub t_us: u64,
}

/// The contact spike (paper, equations 2 and 3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Device time of the spike, microseconds.
    pub t_us: u64,
    /// Taxel with the best defined spike, 0 to 15.
    pub taxel: u8,
    /// Height of the spike above the idle level, volts, signed.
    pub height_v: f32,
    /// Device time at which the load begins to rise, microseconds; for a slow contact, long before
    /// the spike.
    pub onset_us: u64,
    /// Delay from the spike until the event left the detector, microseconds.
    pub reported_after_us: u32,
}

/// The sliding phase begins or ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slide {
    /// Device time of the slide's start, microseconds.
    pub start_us: u64,
    /// Device time of the slide's end, microseconds; `None` while it lasts.
    pub end_us: Option<u64>,
    /// Delay from the slide's start, or from its end if it has ended, until the event left the
    /// detector, microseconds.
    pub reported_after_us: u32,
}

/// The finger is off the stimulus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Release {
    /// Device time of the release, microseconds.
    pub t_us: u64,
    /// Delay from the release until the event left the detector, microseconds.
    pub reported_after_us: u32,
}

/// The first sign of tangential motion in a hold. A [`Slide`] follows if the motion lasts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moving {
    /// Device time of the first frame that shows the motion, microseconds.
    pub t_us: u64,
    /// Delay from that frame until the event left the detector, microseconds.
    pub reported_after_us: u32,
}

/// Frequency of a window in brief, if windows are closer together than
/// [`TRACK_STRIDE_S`](crate::settings::TRACK_STRIDE_S): fitted, or tracked from the latest fit. At
/// most 32 bytes on the line.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Device time of the window's end, microseconds.
    pub t_us: u64,
    /// Mean of the common frequency over the window, hertz; zero without a tone
    /// ([`Status::has_tone`]).
    pub frequency: f32,
    /// Standard deviation of the frequency, hertz; zero without a tone.
    pub sigma: f32,
    /// Confidence in the fit.
    pub status: Status,
}

impl From<&Estimate> for Track {
    fn from(estimate: &Estimate) -> Self {
        let Estimate {
            t_us,
            frequency,
            sigma,
            status,
            ..
        } = *estimate;
        Self {
            t_us,
            frequency,
            sigma,
            status,
        }
    }
}

/// Counters and readings, about once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// Device time, microseconds.
    pub t_us: u64,
    /// Frames since start-up; wraps after 206 days.
    pub frames: u32,
    /// Conversions lost: overruns of the queue and gaps in the scan. A chip that ran with wrong
    /// registers may have converted faster, so the maximum possible number is added.
    pub conversions_lost: u32,
    /// Conversions with OVF or SUPPLY set, with NEW missing, or of a channel outside the scan.
    pub conversions_doubtful: u32,
    /// Windows that were not fitted because the fit was busy.
    pub overruns: u32,
    /// Events dropped because the line was too slow.
    pub messages_dropped: u32,
    /// Number of times that the ADC was set up again because its registers were wrong, or because
    /// the set-up failed.
    pub chip_restarts: u32,
    /// Number of times that each kind of fault was detected, in the order of
    /// [`crate::fault::FaultKind::ALL`].
    pub faults: [u32; KINDS],
    /// Requests that arrived damaged.
    pub requests_damaged: u32,
    /// Lower bound on the number of request bytes that were lost because the board read too late.
    pub bytes_overrun: u32,
    /// Maximum number of bytes of the stack in use since start-up; zero if not measured, as on a
    /// PC.
    pub stack_used_bytes: u32,
    /// Size of the stack, bytes; zero if not measured.
    pub stack_bytes: u32,
    /// Measured frame rate by the board's clock, hertz; zero until measured.
    pub frame_rate_hz: f32,
    /// Fraction of time that the processor was busy, 0 to 1; zero if not measured.
    pub load: f32,
    /// Analogue supply by the chip's own reading, volts.
    pub supply_v: f32,
    /// Reference by the chip's own reading, volts.
    pub reference_v: f32,
    /// Temperature by the chip's own reading, degrees Celsius.
    pub temperature_c: f32,
    /// Offset by the chip's own reading, volts.
    pub offset_v: f32,
    /// Gain by the chip's own reading, ideally 1.
    pub gain: f32,
    /// Raw frames not sent because the line had no room: all other events have priority.
    pub frames_thinned: u32,
}

/// Number of register bytes in a report of the converter.
pub const REGISTERS: usize = 10;

/// State of the converter, for diagnosis. Sent within half a second of each greeting and of each
/// change.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ConverterState {
    /// Device time, microseconds.
    pub t_us: u64,
    /// Name of the converter.
    pub name: String<16>,
    /// True if the registers hold the values written to them. If not, the board keeps trying.
    pub answers: bool,
    /// Registers as read back, followed by zeros; for an ADS1258 CONFIG0 to ID.
    pub registers: [u8; REGISTERS],
}

/// One frame as read from the converter, on request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Raw {
    /// Device time of the frame's first slot, microseconds.
    pub t_us: u64,
    /// Number of the frame since start-up, counting lost frames.
    pub number: u32,
    /// Bit k: taxel k was converted and read.
    pub present: u16,
    /// Bit k: the conversion of taxel k can be trusted.
    pub good: u16,
    /// Codes of the taxels; arbitrary for taxels that are not present.
    pub codes: [i32; TAXELS],
}

impl From<Raw> for Event {
    fn from(raw: Raw) -> Self {
        Self::Raw(raw)
    }
}

impl Event {
    /// Device time of the event, microseconds: its end, if it has a duration. A greeting and a
    /// reply have none, because they report nothing that happens on the finger.
    pub fn t_us(&self) -> Option<u64> {
        Some(match self {
            Self::Hello(_) | Self::Reply(_) => return None,
            Self::Contact(e) => e.t_us,
            Self::Slide(e) => e.end_us.unwrap_or(e.start_us),
            Self::Estimate(e) => e.t_us,
            Self::Release(e) => e.t_us,
            Self::Health(e) => e.t_us,
            Self::Image(e) => e.end_us,
            Self::Fault(e) => e.until_us.unwrap_or(e.from_us),
            Self::Raw(e) => e.t_us,
            Self::Texture(e) => e.t_us,
            Self::Converter(e) => e.t_us,
            Self::Track(e) => e.t_us,
            Self::Moving(e) => e.t_us,
        })
    }
}
