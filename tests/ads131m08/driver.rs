//! The ADS131M08 as a [`Converter`] (SBAS950B): all there is to write for a chip of another family.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;
use ridgetone_finger::converter::{Converter, REGISTERS, Sample, Scanned, Tag};
use ridgetone_proto::plan::{HealthReadings, Own, Plan, PlanError, Sampling, within};

const CHANNELS: usize = 8;
const WORD_BYTES: usize = 3;
/// Bytes of a frame: response, channels, CRC.
const FRAME_BYTES: usize = (CHANNELS + 2) * WORD_BYTES;

const NULL: u16 = 0x0000;
const RESET: u16 = 0x0011;
const STANDBY: u16 = 0x0022;
const WAKEUP: u16 = 0x0033;
/// Answer to RESET.
const HAS_RESET: u16 = 0xff28;
/// Registers.
const ID: u16 = 0;
const MODE: u16 = 2;
const CLOCK: u16 = 3;
/// ID of a chip with eight channels, without its revision.
const EIGHT_CHANNELS: u16 = 0x2800;
/// 24-bit words, time-out on, RESET cleared.
const MODE_WRITTEN: u16 = 0x0110;
/// Time after a reset before the registers may be accessed, microseconds: t_REGACQ, 5.
const RESET_US: u32 = 10;

struct Frame {
    response: u16,
    codes: [i32; CHANNELS],
}

/// The converter's id in plans: no other has it.
const ID_OF_PLANS: u8 = 200;

/// A plan with an oversampling ratio of 128 << `osr` and a clock of 8.192 MHz.
pub const fn plan(osr: u16, inputs: u16) -> Plan {
    Plan {
        inputs,
        health: HealthReadings::Never,
        sampling: Sampling::AtOnce,
        adc_clock_hz: 8_192_000,
        frame_ticks: 256 << osr,
        own: Own {
            converter: ID_OF_PLANS,
            bits: osr,
        },
    }
}

/// The chip on its bus, with the clock on its CLKIN.
pub struct WiredAds131m08<SPI> {
    spi: SPI,
    clkin_hz: f32,
    clock_written: u16,
    /// The codes of the edge that is served. None: they could not be read.
    codes: Option<[i32; CHANNELS]>,
    /// The channel that is read next.
    at: usize,
    is_new: bool,
}

impl<SPI: SpiDevice> WiredAds131m08<SPI> {
    pub fn new(spi: SPI, clkin_hz: f32) -> Self {
        Self {
            spi,
            clkin_hz,
            clock_written: 0,
            codes: None,
            at: 0,
            is_new: false,
        }
    }

    /// Frames a second with this CLOCK.
    fn frame_rate_hz(&self, clock: u16) -> f32 {
        0.5 * self.clkin_hz / (128u32 << (clock >> 2 & 7)) as f32
    }

    /// Sends words, and takes the frame that comes meanwhile if its CRC is right.
    fn exchange(&mut self, words: &[u16]) -> Option<Frame> {
        let mut bytes = [0; FRAME_BYTES];
        for (at, word) in bytes.chunks_exact_mut(WORD_BYTES).zip(words) {
            at[..2].copy_from_slice(&word.to_be_bytes());
        }
        self.spi.transfer_in_place(&mut bytes).ok()?;
        let (data, crc) = bytes.split_at(FRAME_BYTES - WORD_BYTES);
        if crc16(data).to_be_bytes() != crc[..2] {
            return None;
        }
        let (words, _) = data.as_chunks::<WORD_BYTES>();
        let code =
            |[high, middle, low]: [u8; WORD_BYTES]| i32::from_be_bytes([high, middle, low, 0]) >> 8;
        Some(Frame {
            response: u16::from_be_bytes([words[0][0], words[0][1]]),
            codes: core::array::from_fn(|channel| code(words[1 + channel])),
        })
    }

    /// Sends a command; its answer is in the next frame.
    fn command(&mut self, words: &[u16]) -> Option<u16> {
        let _ = self.exchange(words);
        Some(self.exchange(&[NULL])?.response)
    }

    fn register(&mut self, address: u16) -> Option<u16> {
        self.command(&[0xa000 | address << 7])
    }

    /// The first enabled channel from one on.
    fn enabled_from(&self, channel: usize) -> Option<usize> {
        (channel..CHANNELS).find(|channel| self.clock_written >> (8 + channel) & 1 == 1)
    }
}

impl<SPI: SpiDevice> Converter for WiredAds131m08<SPI> {
    const NAME: &'static str = "ADS131M08";
    const DEFAULT_PLAN: Plan = plan(7, 0xff);

    fn check(plan: &Plan) -> Result<(), PlanError> {
        let bits = plan.own.bits;
        let own = Plan {
            adc_clock_hz: plan.adc_clock_hz,
            ..self::plan(bits & 7, plan.inputs)
        };
        let bounds = [
            ("plan.converter", ID_OF_PLANS.into(), ID_OF_PLANS.into()),
            ("plan.inputs", 1.0, 255.0),
            ("plan.bits", 0.0, 7.0),
            (
                "plan.frame_ticks",
                own.frame_ticks as f32,
                own.frame_ticks as f32,
            ),
        ];
        let values = [
            plan.own.converter.into(),
            plan.inputs.into(),
            bits as f32,
            plan.frame_ticks as f32,
        ];
        within(&bounds, &values)
    }

    fn stop(&mut self) -> bool {
        self.command(&[STANDBY]) == Some(STANDBY)
    }

    fn set_up(&mut self, plan: &Plan, _: Scanned, wait: &mut impl DelayNs) -> bool {
        // High resolution in the lowest bits.
        self.clock_written = plan.inputs << 8 | plan.own.bits << 2 | 2;
        self.at = self.enabled_from(0).unwrap_or(0);
        let _ = self.exchange(&[RESET]);
        wait.delay_us(RESET_US);
        let is_reset = self.exchange(&[NULL]).map(|frame| frame.response) == Some(HAS_RESET);
        let write_two = 0x6000 | MODE << 7 | 1;
        is_reset
            && self.register(ID).map(|id| id & 0xff00) == Some(EIGHT_CHANNELS)
            && self
                .command(&[write_two, MODE_WRITTEN, self.clock_written])
                .is_some()
            && self.is_as_set_up()
            && self.stop()
    }

    fn start(&mut self) -> bool {
        self.command(&[WAKEUP]) == Some(WAKEUP)
    }

    fn read(&mut self) -> Option<Sample> {
        if self.enabled_from(0) == Some(self.at) {
            let frame = self.exchange(&[NULL]);
            self.is_new = frame
                .as_ref()
                .is_some_and(|frame| frame.response as u8 != 0);
            self.codes = frame.map(|frame| frame.codes);
        }
        let code = self.codes?[self.at];
        let mut tag = Tag::of_input(self.at as u8);
        if !core::mem::take(&mut self.is_new) {
            tag.0 &= !Tag::NEW;
        }
        Some(Sample { tag, code })
    }

    fn go_on(&mut self) -> bool {
        let next = self.codes.and_then(|_| self.enabled_from(self.at + 1));
        self.is_new = next.is_some();
        self.at = next.or_else(|| self.enabled_from(0)).unwrap_or(0);
        next.is_some()
    }

    fn is_as_set_up(&mut self) -> bool {
        self.register(MODE) == Some(MODE_WRITTEN)
            && self.register(CLOCK) == Some(self.clock_written)
    }

    fn registers(&mut self) -> Option<[u8; REGISTERS]> {
        let mut found = [0; REGISTERS];
        for (address, bytes) in (ID..=CLOCK).zip(found.chunks_exact_mut(2)) {
            bytes.copy_from_slice(&self.register(address)?.to_be_bytes());
        }
        Some(found)
    }

    fn least_period_us(&mut self) -> u32 {
        // Unknown: as at OSR 128.
        let clock = self.register(CLOCK).unwrap_or(0);
        (1e6 / (self.frame_rate_hz(clock) * CHANNELS as f32)) as u32
    }
}

/// CRC-16-CCITT, seed FFFFh.
fn crc16(bytes: &[u8]) -> u16 {
    let mut crc = 0xffff_u16;
    for bit in (0..8 * bytes.len()).map(|at| bytes[at / 8] >> (7 - at % 8) & 1) {
        let is_set = crc >> 15 != u16::from(bit);
        crc <<= 1;
        if is_set {
            crc ^= 0x1021;
        }
    }
    crc
}
