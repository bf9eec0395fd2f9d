//! What the board says: the wire types, used by both ends. How they travel is in [`crate::framing`].

use crate::boot::{Boot, SettingsSource};
use crate::command::Reply;
use crate::fault::{Fault, FaultSet, KINDS};
use crate::framing as wire;
pub use crate::framing::TooLong;
use crate::framing::{Inbox, Pushed};
use crate::settings::{Settings, TAXELS};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of the wire contract; a reader refuses another one.
pub const PROTOCOL: u8 = 5;

/// First message after start-up, and again about every ten seconds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// [`PROTOCOL`].
    pub protocol: u8,
    /// Firmware version: major, minor, patch.
    pub version: [u8; 3],
    /// Nominal frames per second, from the chip's registers and its nominal clock.
    pub frame_rate_hz: f32,
    /// Settings in force.
    pub settings: Settings,
    /// Where they come from.
    pub source: SettingsSource,
    /// How this run began.
    pub boot: Boot,
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
    /// The window holds too little of a cycle, or too few frames, to tell.
    TooShort,
    /// No valid channel or no valid frame.
    Nothing,
    /// Two readings an octave (or another harmonic step) apart explain the window about equally well.
    Ambiguous,
    /// A common tone, but in a window in which something was wrong that may have changed it: see [`Estimate::faults`].
    Doubtful,
}

impl Status {
    /// Whether an estimate of this status has a frequency.
    pub const fn has_tone(self) -> bool {
        matches!(self, Self::Good | Self::Ambiguous | Self::Doubtful)
    }
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
    /// Phase of the fundamental, radians, cosine at the window's centre, -pi to pi; by place, half way
    /// between the window's ends on the surface.
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

/// What a frequency counts its cycles in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Abscissa {
    /// Time: cycles per second.
    Time,
    /// Place on the surface, by the host's speed profile: cycles per millimetre.
    Place,
}

/// Whether spatial period, speed and direction are known, and from what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TravelStatus {
    /// There is no tone, or it is not in two channels that respond alike in both columns of units.
    Nothing,
    /// The phases allow one answer within the periods that are possible.
    Unique,
    /// They allow more than one, or one at the edge of what is possible.
    Ambiguous,
    /// They allow none.
    OutOfRange,
    /// Speed, and with it the period, are by the host's word, and the phases agree.
    Given,
    /// Speed and period are by the host's word, and the phases say otherwise.
    Contradicted,
}

/// Which way the grating goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Direction {
    /// Not known.
    Unknown,
    /// Along +x: towards the column in front ([`crate::settings::Array::front`]).
    Forward,
    /// Back.
    Backward,
}

impl Direction {
    /// The other way.
    pub const fn reversed(self) -> Self {
        match self {
            Self::Unknown => Self::Unknown,
            Self::Forward => Self::Backward,
            Self::Backward => Self::Forward,
        }
    }
}

/// Spatial period, speed and direction; zeros where there are none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Travel {
    /// Whether to believe it.
    pub verdict: TravelStatus,
    /// Which way.
    pub direction: Direction,
    /// Spatial period of the grating, millimetres.
    pub spatial_period_mm: f32,
    /// Its standard deviation, millimetres.
    pub spatial_period_sigma_mm: f32,
    /// Speed over the surface, millimetres per second, not negative.
    pub speed_mm_s: f32,
    /// Its standard deviation, millimetres per second; zero where the host told it.
    pub speed_sigma_mm_s: f32,
}

impl Travel {
    /// Nothing is known.
    pub const NONE: Self = Self {
        verdict: TravelStatus::Nothing,
        direction: Direction::Unknown,
        spatial_period_mm: 0.0,
        spatial_period_sigma_mm: 0.0,
        speed_mm_s: 0.0,
        speed_sigma_mm_s: 0.0,
    };

    /// Whether there are a period and a speed.
    pub const fn is_known(&self) -> bool {
        matches!(self.verdict, TravelStatus::Unique | TravelStatus::Given | TravelStatus::Contradicted)
    }
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
    /// What the frequency counts its cycles in.
    pub abscissa: Abscissa,
    /// The common frequency, hertz, or cycles per millimetre by place; zero unless the status is good or
    /// ambiguous.
    pub frequency: f32,
    /// Its standard deviation, in the same unit; zero where there is no frequency.
    pub sigma: f32,
    /// Harmonics fitted, the fundamental included.
    pub harmonics: u8,
    /// Frames of the window that were left out: missing, or without a valid value of a taxel that has
    /// them otherwise.
    pub frames_missing: u16,
    /// What was wrong while it came.
    pub faults: FaultSet,
    /// Spatial period, speed and direction.
    pub travel: Travel,
    /// The valid channels.
    pub channels: Vec<Channel, TAXELS>,
}

/// Which hold of a touch (paper, section 3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Hold {
    /// Phase B: between the contact spike and the first slide.
    BeforeSlide,
    /// Phase D: since a slide.
    AfterSlide,
}

/// What a hold does to one taxel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pressed {
    /// Taxel, 0 to 15.
    pub taxel: u8,
    /// Mean over the hold less the level before the touch, volts.
    pub level_v: f32,
    /// Its standard deviation by the noise of the taxel's frames, in the hold and before the touch, volts.
    pub sigma_v: f32,
}

/// The static image: what a hold does to every taxel. It is told when the hold is over; a hold in which nothing moves
/// for less than 0.1 s on end has none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Image {
    /// Device time of the first frame that it is the mean of, microseconds.
    pub start_us: u64,
    /// Device time of the end of the last one, microseconds.
    pub end_us: u64,
    /// Frames that it is the mean of, without those that are missing.
    pub frames: u32,
    /// Which hold it is.
    pub hold: Hold,
    /// The taxels that are alive: dead ones had an untrustworthy conversion in the hold, or have no noise and the very
    /// code that they had before the touch.
    pub taxels: Vec<Pressed, TAXELS>,
}

/// Counters and readings, about once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// Device time, microseconds.
    pub t_us: u64,
    /// Frames assembled so far; wraps after 206 days.
    pub frames: u32,
    /// Conversions lost: overruns of the queue and gaps in the scan; and, where the chip ran with other registers and so
    /// perhaps faster, as many more as it can have made at most.
    pub conversions_lost: u32,
    /// Conversions whose status had OVF or SUPPLY set or NEW missing, or named a channel outside the scan.
    pub conversions_doubtful: u32,
    /// Windows not fitted because the fit was still busy.
    pub hops_skipped: u32,
    /// Telemetry messages dropped because the line was slow.
    pub messages_dropped: u32,
    /// Times the ADC was set up anew because its registers were not what they should be, or could not
    /// be set up.
    pub chip_restarts: u32,
    /// Times that each kind of fault was seen, by [`crate::fault::FaultKind::ALL`].
    pub faults: [u32; KINDS],
    /// Orders of the PC that were damaged on their way.
    pub requests_damaged: u32,
    /// The most of the stack that was in use since start-up, bytes; zero where nothing measures it (PC).
    pub stack_used_bytes: u32,
    /// The stack's size, bytes; zero where nothing measures it.
    pub stack_bytes: u32,
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

/// One frame as it was read, on request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Raw {
    /// Device time of its first slot, microseconds.
    pub t_us: u64,
    /// Its number since start-up, counting those that were lost.
    pub number: u32,
    /// Bit k: taxel k was converted and read.
    pub present: u16,
    /// Bit k: its conversion can be trusted.
    pub good: u16,
    /// Codes of the taxels; of those that are not present anything.
    pub codes: [i32; TAXELS],
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
    /// What a hold does to the taxels.
    Image(Image),
    /// Something is wrong, or is right again.
    Fault(Fault),
    /// The answer to an order.
    Reply(Reply),
    /// A frame as it was read.
    Raw(Raw),
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

/// Encodes a packet ([`crate::framing`]). Returns the bytes used of `wire`.
///
/// # Errors
/// It is longer than [`WIRE_MAX`] allows.
#[inline(never)]
pub fn encode(packet: &Packet, wire: &mut [u8; WIRE_MAX]) -> Result<usize, TooLong> {
    wire::encode(packet, wire)
}

/// Puts packets together from bytes as they come, counting what is damaged.
#[derive(Debug, Default)]
pub struct Decoder {
    inbox: Inbox<WIRE_MAX>,
    expected: Option<u16>,
    /// Frames that failed stuffing, checksum or content and were skipped.
    pub damaged: u32,
    /// Protocol of the device, if it is another than [`PROTOCOL`]: its packets are not given.
    pub foreign: Option<u8>,
    /// Packets that never came, by their sequence numbers: of a gap of 32,768 and more only the rest beyond whole
    /// multiples of 65,536, if that is less.
    pub missing: u32,
    /// Times that the numbers went back: the line repeated itself, or the device started anew and its first greeting was
    /// lost.
    pub stepped_back: u32,
}

impl Decoder {
    /// A decoder that has seen nothing; it finds its place at the next zero byte.
    pub const fn new() -> Self {
        Self { inbox: Inbox::new(), expected: None, damaged: 0, foreign: None, missing: 0, stepped_back: 0 }
    }

    /// Takes one byte; gives a packet when it was the last of one.
    pub fn push(&mut self, byte: u8) -> Option<Packet> {
        let packet = match self.inbox.push(byte) {
            Pushed::More => return None,
            Pushed::Whole => self.inbox.take().and_then(|mut frame| wire::decode::<Packet>(&mut frame)),
            Pushed::Damaged => None,
        };
        self.damaged = self.damaged.saturating_add(packet.is_none() as u32);
        if let Some(packet) = &packet {
            let gap = match self.expected {
                // A device that greets with number zero has started anew.
                Some(expected) if !(packet.sequence == 0 && matches!(packet.event, Event::Hello(_))) => {
                    packet.sequence.wrapping_sub(expected)
                }
                _ => 0,
            };
            // More than half the numbers ahead is taken for so much less back: were it a gap, a repetition would be
            // sixty thousand losses.
            if gap <= u16::MAX / 2 {
                self.missing = self.missing.saturating_add(gap as u32);
            } else {
                self.stepped_back = self.stepped_back.saturating_add(1);
            }
            self.expected = Some(packet.sequence.wrapping_add(1));
            if let Event::Hello(hello) = &packet.event {
                self.foreign = (hello.protocol != PROTOCOL).then_some(hello.protocol);
            }
        }
        packet.filter(|_| self.foreign.is_none())
    }
}

/// A packet whose every field takes as many bytes as it can.
pub fn longest_packet() -> Packet {
    let channel = |taxel| Channel { taxel, offset_v: 2.5, amplitude_v: 1e-3, phase_rad: -3.1, residual_v: 5e-6 };
    let estimate = Estimate {
        t_us: u64::MAX,
        window_s: 1.0,
        span: Span::Slide,
        status: Status::Good,
        abscissa: Abscissa::Place,
        frequency: 8.333_333,
        sigma: 1e-3,
        harmonics: 5,
        frames_missing: u16::MAX,
        faults: FaultSet::NONE,
        travel: Travel {
            verdict: TravelStatus::Contradicted,
            direction: Direction::Backward,
            spatial_period_mm: 3.6,
            spatial_period_sigma_mm: 1e-3,
            speed_mm_s: 30.0,
            speed_sigma_mm_s: 1e-2,
        },
        channels: (0..TAXELS as u8).map(channel).collect(),
    };
    Packet { sequence: u16::MAX, event: Event::Estimate(estimate) }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    fn estimate() -> Event {
        longest_packet().event
    }

    fn sent(sequence: u16, event: Event) -> std::vec::Vec<u8> {
        let mut wire = [0; WIRE_MAX];
        let used = encode(&Packet { sequence, event }, &mut wire).unwrap();
        wire[..used].to_vec()
    }

    #[test]
    fn the_longest_packet_comes_back() {
        let bytes = sent(u16::MAX, estimate());
        let mut decoder = Decoder::new();
        let packets: std::vec::Vec<_> = bytes.iter().filter_map(|b| decoder.push(*b)).collect();
        assert_eq!(packets, [Packet { sequence: u16::MAX, event: estimate() }]);
        assert_eq!((decoder.damaged, decoder.missing), (0, 0));
    }

    #[test]
    fn every_single_damaged_byte_is_noticed_and_the_next_packet_is_read() {
        let (bad, good) = (sent(7, estimate()), sent(8, Event::Release(Release { t_us: 5 })));
        for place in 0..bad.len() - 1 {
            let mut bytes = bad.clone();
            bytes[place] ^= 0x10;
            bytes.extend(&good);
            let mut decoder = Decoder::new();
            let packets: std::vec::Vec<_> = bytes.iter().filter_map(|b| decoder.push(*b)).collect();
            assert_eq!(packets.len(), 1, "byte {place}");
            assert_eq!(packets[0].sequence, 8);
            assert!(decoder.damaged >= 1);
        }
    }

    #[test]
    fn losses_are_counted_by_sequence_across_the_wrap() {
        let mut decoder = Decoder::new();
        for sequence in [65_533, 65_534, 2, 3] {
            for byte in sent(sequence, Event::Release(Release { t_us: 5 })) {
                decoder.push(byte);
            }
        }
        assert_eq!((decoder.damaged, decoder.missing), (0, 3));
    }

    #[test]
    fn a_repetition_and_an_unheard_restart_are_no_losses() {
        let mut decoder = Decoder::new();
        for sequence in [40_000, 40_000, 40_001, 2, 3, 7] {
            for byte in sent(sequence, Event::Release(Release { t_us: 5 })) {
                decoder.push(byte);
            }
        }
        // 2 is 25,537 numbers ahead of 40,002, which a gap may be; 4 to 6 are lost.
        assert_eq!((decoder.damaged, decoder.missing, decoder.stepped_back), (0, 25_536 + 3, 1));
    }

    #[test]
    fn another_protocol_is_told_and_not_taken_for_ours() {
        let hello = |protocol| {
            let (settings, source, boot) = (Settings::DEFAULT, SettingsSource::Default, Boot::default());
            Event::Hello(Hello { protocol, version: [0, 1, 0], frame_rate_hz: 241.14, settings, source, boot })
        };
        let mut decoder = Decoder::new();
        let given = |decoder: &mut Decoder, sequence, event| {
            sent(sequence, event).iter().filter_map(|byte| decoder.push(*byte)).count()
        };
        assert_eq!(given(&mut decoder, 0, hello(PROTOCOL + 1)), 0);
        assert_eq!(given(&mut decoder, 1, estimate()), 0);
        assert_eq!(decoder.foreign, Some(PROTOCOL + 1));
        assert_eq!(given(&mut decoder, 0, hello(PROTOCOL)), 1);
        assert_eq!(given(&mut decoder, 1, estimate()), 1);
        assert_eq!((decoder.foreign, decoder.missing, decoder.damaged), (None, 0, 0));
    }

    #[test]
    fn a_flood_of_anything_leaves_it_ready() {
        let mut decoder = Decoder::new();
        let mut x = 1u32;
        for _ in 0..1_000_000 {
            x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            assert_eq!(decoder.push((x >> 24) as u8), None);
        }
        decoder.push(0);
        let packets: std::vec::Vec<_> = sent(3, estimate()).iter().filter_map(|b| decoder.push(*b)).collect();
        assert_eq!(packets.len(), 1);
    }
}
