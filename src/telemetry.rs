//! The wire types and framing, used by both ends.

use crate::settings::{Settings, TAXELS};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of the wire contract; a reader refuses another one.
pub const PROTOCOL: u8 = 1;

/// First message after start-up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// [`PROTOCOL`].
    pub protocol: u8,
    /// Firmware version: major, minor, patch.
    pub version: [u8; 3],
    /// Nominal frames per second, from the chip's registers and its nominal clock.
    pub frame_rate_hz: f32,
    /// Settings in force.
    pub settings: Settings,
}

/// The contact spike (paper, equations 2 and 3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Device time of the spike, microseconds.
    pub t_us: u64,
    /// Taxel with the best defined spike, 0 to 15.
    pub taxel: u8,
    /// Its height over the idle level, volts, signed.
    pub height_v: f32,
}

/// The sliding phase begins or has ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slide {
    /// Device time of its start, microseconds.
    pub start_us: u64,
    /// Device time of its end, microseconds; none while it lasts.
    pub end_us: Option<u64>,
}

/// Unloading: the finger is off the stimulus again.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Release {
    /// Device time, microseconds.
    pub t_us: u64,
}

/// How far an estimate can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// A common tone, with its uncertainty.
    Good,
    /// The channels share no tone that stands out of their noise.
    NoTone,
    /// The window holds too little of a cycle to tell.
    TooShort,
    /// No valid channel or no valid frame.
    Nothing,
    /// Two readings an octave (or another harmonic step) apart explain the window about equally well.
    Ambiguous,
}

/// One channel of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Taxel, 0 to 15.
    pub taxel: u8,
    /// Offset in the window, volts.
    pub offset_v: f32,
    /// Amplitude of the fundamental, volts.
    pub amplitude_v: f32,
    /// Phase of the fundamental, radians, cosine at the window's centre, -pi to pi.
    pub phase_rad: f32,
    /// Standard deviation of what the fit leaves, volts.
    pub residual_v: f32,
}

/// What a window covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Span {
    /// One hop of the sliding window.
    Window,
    /// The whole sliding phase.
    Slide,
}

/// One fit over all valid channels of a window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Device time of the window's end, microseconds.
    pub t_us: u64,
    /// Length of the window, seconds.
    pub window_s: f32,
    /// What the window covers.
    pub span: Span,
    /// Whether to believe it.
    pub status: Status,
    /// The common frequency, hertz; zero unless the status is good or ambiguous.
    pub frequency_hz: f32,
    /// Its standard deviation, hertz; zero where there is no frequency.
    pub sigma_hz: f32,
    /// Harmonics fitted, the fundamental included.
    pub harmonics: u8,
    /// Frames of the window that were missing or damaged and were left out.
    pub frames_missing: u16,
    /// The valid channels.
    pub channels: Vec<Channel, TAXELS>,
}

/// Counters and readings, about once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// Device time, microseconds.
    pub t_us: u64,
    /// Frames assembled so far.
    pub frames: u32,
    /// Conversions lost: overruns of the queue and gaps in the scan.
    pub conversions_lost: u32,
    /// Conversions whose status had OVF or SUPPLY set.
    pub conversions_doubtful: u32,
    /// Windows not fitted because the fit was still busy.
    pub hops_skipped: u32,
    /// Telemetry messages dropped because the line was slow.
    pub messages_dropped: u32,
    /// True frame rate by the board's clock, hertz; zero until measured.
    pub frame_rate_hz: f32,
    /// Share of time the processor was not idle, 0 to 1; zero where nothing measures it (PC).
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
}

/// A message.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)]
pub enum Event {
    /// After start-up.
    Hello(Hello),
    /// The contact spike.
    Contact(Contact),
    /// The sliding phase begins or has ended.
    Slide(Slide),
    /// One fit.
    Estimate(Estimate),
    /// The finger is off.
    Release(Release),
    /// Counters and readings.
    Health(Health),
}

/// What travels: an event with its number, so that a reader sees every loss.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Packet {
    /// Number of the message since start-up, wrapping.
    pub sequence: u16,
    /// The message.
    pub event: Event,
}

/// Most bytes of a packet on the wire, checksum, stuffing and delimiter included.
pub const WIRE_MAX: usize = 512;

/// The packet could not be encoded: the buffer is shorter than [`WIRE_MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLong;

/// Encodes a packet: postcard, CRC-32 little endian, COBS, a zero byte. Returns the bytes used of `wire`.
pub fn encode(_packet: &Packet, _wire: &mut [u8; WIRE_MAX]) -> Result<usize, TooLong> {
    Err(TooLong)
}

/// Puts packets together from bytes as they come, counting what is damaged.
#[derive(Debug, Default)]
pub struct Decoder {
    buffer: Vec<u8, WIRE_MAX>,
    /// Frames that failed stuffing, checksum or content and were skipped.
    pub damaged: u32,
    /// Packets that never came, by their sequence numbers.
    pub missing: u32,
}

impl Decoder {
    /// Takes one byte; gives a packet when it was the last of one.
    pub fn push(&mut self, byte: u8) -> Option<Packet> {
        let _ = self.buffer.push(byte);
        None
    }
}
