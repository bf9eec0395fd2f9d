//! The whole configuration of the chip, checked before the driver writes it.

use crate::{Channel, ConfigError, DataRate, Delay, IdleMode, Register, SensorBias, Sysred, rate};

/// Clock from the 32.768 kHz crystal (CLKSEL low), which the chip's PLL multiplies by 480, in Hz
/// (SBAS297G, clock source).
pub const CRYSTAL_CLOCK_HZ: u32 = 15_728_640;

/// Lowest external clock in Hz (SBAS297G, electrical characteristics).
pub const CLOCK_MIN_HZ: u32 = 100_000;

/// Highest external clock in Hz (SBAS297G, electrical characteristics).
pub const CLOCK_MAX_HZ: u32 = 16_000_000;

/// STAT, bit 1 of CONFIG0: the status byte precedes the data of a direct read (SBAS297G, CONFIG0
/// register).
const STAT: u8 = 0x02;

/// Inputs of the multiplexer: MUXMOD and the registers that belong to it (SBAS297G, register map).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mux {
    /// All selected channels in ascending channel id, repeatedly.
    AutoScan {
        /// MUXDIF: bit n selects DIFFn, the pair AIN(2n) minus AIN(2n + 1).
        differential: u8,
        /// MUXSG1 and MUXSG0: bit n selects AINn against AINCOM.
        single: u16,
        /// SYSRED: the internal readings.
        internal: Sysred,
    },
    /// One pair of inputs, faster. Internal readings are not available in this mode. MUXSCH.
    Fixed {
        /// AINP: the number of the positive input, 0 to 15.
        ainp: u8,
        /// AINN: the number of the negative input, 0 to 15.
        ainn: u8,
    },
}

/// Bits of the longest transfer: a command and all ten registers.
const FRAME_BITS_MAX: u32 = 8 * 11;

/// The whole configuration of the chip (SBAS297G, register descriptions).
///
/// Fields may be added: end a literal with `..Config::RESET`.
///
/// ```compile_fail
/// # use ads1258::Config;
/// # let Config { clock_hz, mux, data_rate, delay, chop, idle_mode, sensor_bias, bypass, clock_output, short_spi_timeout, gpio_inputs, gpio_levels, .. } = Config::RESET;
/// let all = Config { clock_hz, mux, data_rate, delay, chop, idle_mode, sensor_bias, bypass, clock_output, short_spi_timeout, gpio_inputs, gpio_levels };
/// ```
///
/// The default is the chip's state after a reset, with the crystal as clock. STAT is always set;
/// nothing depends on it, because a read by command always sends the status byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// fCLK in Hz, [`CLOCK_MIN_HZ`] to [`CLOCK_MAX_HZ`]. No register holds it; it is used to
    /// compute the rates.
    pub clock_hz: u32,
    /// Inputs to convert.
    pub mux: Mux,
    /// DRATE: speed against noise.
    pub data_rate: DataRate,
    /// DLY: time between switching the multiplexer and converting.
    pub delay: Delay,
    /// CHOP: half the speed, noise divided by 1.4, offset drift by 25. Excludes REF, GAIN, TEMP and
    /// VCC.
    pub chop: bool,
    /// IDLMOD: state of the chip while START is low.
    pub idle_mode: IdleMode,
    /// SBCS: sensor bias current.
    pub sensor_bias: SensorBias,
    /// BYPAS: the converter measures at its own pins instead of the multiplexer's output, for an
    /// amplifier in between. If nothing is connected there, the codes read 0x7F_FFFF.
    pub bypass: bool,
    /// CLKENB: CLKIO outputs the clock when the crystal is in use.
    pub clock_output: bool,
    /// SPIRST: the SPI port drops a transfer when SCLK pauses for 256 tCLK (16 us at 16 MHz)
    /// instead of 4096 tCLK, or perhaps that long after its start: see
    /// [`sclk_min_hz`](Self::sclk_min_hz). Leave this off: a transfer that is interrupted for
    /// longer would be cut off.
    pub short_spi_timeout: bool,
    /// GPIOC: bit n makes GPIOn an input if set, an output if clear.
    pub gpio_inputs: u8,
    /// GPIOD: level of each GPIO pin that is an output.
    pub gpio_levels: u8,
    /// Nothing; it makes a literal without `..` an error.
    #[doc(hidden)]
    pub _more: (),
}

impl Default for Config {
    fn default() -> Self {
        Self::RESET
    }
}

impl Config {
    /// State of the chip after a reset, with the crystal as clock: AIN0 to AIN15 in turn at the
    /// highest data rate.
    pub const RESET: Self = Self {
        clock_hz: CRYSTAL_CLOCK_HZ,
        mux: Mux::AutoScan {
            differential: 0,
            single: 0xFFFF,
            internal: Sysred::NONE,
        },
        data_rate: DataRate::Drate3,
        delay: Delay::Dly0,
        chop: false,
        idle_mode: IdleMode::Sleep,
        sensor_bias: SensorBias::Off,
        bypass: false,
        clock_output: true,
        short_spi_timeout: false,
        gpio_inputs: 0xFF,
        gpio_levels: 0x00,
        _more: (),
    };

    /// Checks that the chip can work with this configuration. The error is the first broken rule.
    pub const fn validate(&self) -> Result<(), ConfigError> {
        if self.clock_hz < CLOCK_MIN_HZ || self.clock_hz > CLOCK_MAX_HZ {
            return Err(ConfigError::Clock {
                clock_hz: self.clock_hz,
            });
        }
        match self.mux {
            // All but OFFSET.
            Mux::AutoScan { internal, .. } if self.chop && internal.to_bits() > 1 => {
                Err(ConfigError::ChopWithInternalReadings)
            }
            Mux::AutoScan { .. } if self.channel_mask() == 0 => Err(ConfigError::EmptyScan),
            Mux::Fixed { ainp: number, .. } | Mux::Fixed { ainn: number, .. } if number > 15 => {
                Err(ConfigError::ChannelNumber { number })
            }
            Mux::AutoScan { .. } | Mux::Fixed { .. } => Ok(()),
        }
    }

    /// The bytes for the writable registers, CONFIG0 (0x00) to GPIOD (0x08).
    ///
    /// The registers of the unused multiplexer mode are 0. Fails like [`validate`](Self::validate).
    pub const fn registers(&self) -> Result<[u8; Register::WRITABLE], ConfigError> {
        if let Err(error) = self.validate() {
            return Err(error);
        }
        // 0 SPIRST MUXMOD BYPAS CLKENB CHOP STAT 0
        let config0 = (self.short_spi_timeout as u8) << 6
            | (matches!(self.mux, Mux::Fixed { .. }) as u8) << 5
            | (self.bypass as u8) << 4
            | (self.clock_output as u8) << 3
            | (self.chop as u8) << 2
            | STAT;
        // IDLMOD DLY[2:0] SBCS[1:0] DRATE[1:0]
        let config1 = (self.idle_mode as u8) << 7
            | (self.delay as u8) << 4
            | (self.sensor_bias as u8) << 2
            | self.data_rate as u8;
        let (muxsch, muxdif, single, sysred) = match self.mux {
            Mux::AutoScan {
                differential,
                single,
                internal,
            } => (0, differential, single, internal.to_bits()),
            Mux::Fixed { ainp, ainn } => (ainp << 4 | ainn, 0, 0, 0),
        };
        let [muxsg0, muxsg1] = single.to_le_bytes();
        Ok([
            config0,
            config1,
            muxsch,
            muxdif,
            muxsg0,
            muxsg1,
            sysred,
            self.gpio_inputs,
            self.gpio_levels,
        ])
    }

    /// The channels of the scan as a mask: bit n is channel id n. 0 in fixed mode.
    pub const fn channel_mask(&self) -> u32 {
        match self.mux {
            Mux::AutoScan {
                differential,
                single,
                internal,
            } => differential as u32 | (single as u32) << 8 | (internal.to_bits() as u32) << 24,
            Mux::Fixed { .. } => 0,
        }
    }

    /// Conversions per scan, 0 to 29; 1 in fixed mode.
    pub const fn slots(&self) -> usize {
        match self.mux {
            Mux::AutoScan { .. } => self.channel_mask().count_ones() as usize,
            Mux::Fixed { .. } => 1,
        }
    }

    /// The channels of one scan in order of arrival, by ascending channel id. Empty in fixed mode.
    ///
    /// ```
    /// use ads1258::{Channel, Config};
    /// let mut scan = Config::RESET.scan();
    /// assert_eq!(scan.next(), Some(Channel::Single(0)));
    /// assert_eq!(scan.last(), Some(Channel::Single(15)));
    /// ```
    pub fn scan(&self) -> impl Iterator<Item = Channel> {
        let mask = self.channel_mask();
        (0..u32::BITS as u8)
            .filter_map(Channel::from_id)
            .filter(move |channel| mask & channel.bit() != 0)
    }

    /// The channel that follows `channel` in the scan; after the last channel, the first.
    ///
    /// If `channel` is not in the scan, returns the next channel that is. In fixed mode, or with an
    /// empty scan, returns `channel`.
    pub const fn next_channel(&self, channel: Channel) -> Channel {
        let mask = self.channel_mask();
        let above = mask & u32::MAX.wrapping_shl((channel.id() as u32).wrapping_add(1));
        let next = if above == 0 { mask } else { above };
        // An empty mask has 32 trailing zeros, and no channel has that id.
        match Channel::from_id(next.trailing_zeros() as u8) {
            Some(next) => next,
            None => channel,
        }
    }

    /// Clock periods (tCLK) per conversion, exactly: 128 to 29764. On a fixed channel the delay
    /// counts only with `chop`.
    pub const fn conversion_ticks(&self) -> u32 {
        rate::ticks(
            matches!(self.mux, Mux::Fixed { .. }),
            self.data_rate,
            self.delay,
            self.chop,
        )
    }

    /// Clock periods (tCLK) per scan of all slots, exactly; 0 for an empty scan.
    pub const fn frame_ticks(&self) -> u32 {
        self.conversion_ticks().saturating_mul(self.slots() as u32)
    }

    /// Conversions per second in Hz, over all channels together.
    ///
    /// ```
    /// use ads1258::Config;
    /// const RATE_HZ: f32 = Config { clock_hz: 16_000_000, ..Config::RESET }.conversion_rate_hz();
    /// assert_eq!(RATE_HZ.round(), 23739.0);
    /// ```
    pub const fn conversion_rate_hz(&self) -> f32 {
        rate::per_second(self.clock_hz, self.conversion_ticks())
    }

    /// Scans per second in Hz, that is, conversions per second of each channel; 0 for an empty
    /// scan.
    pub const fn frame_rate_hz(&self) -> f32 {
        rate::per_second(self.clock_hz, self.frame_ticks())
    }

    /// Highest SCLK in Hz: half of the clock (SBAS297G, SPI timing: SCLK period of at least 2
    /// tCLK).
    pub const fn sclk_max_hz(&self) -> u32 {
        self.clock_hz / 2
    }

    /// Lowest SCLK in Hz at which each of the driver's transfers ends before the interface's
    /// time-out (SPIRST): 344 kHz at 16 MHz, and 5.5 MHz with
    /// [`short_spi_timeout`](Self::short_spi_timeout).
    ///
    /// In the datasheet the time-out begins when SCLK stops; users have found it counted from the
    /// start of a frame even while SCLK ran. The longest frame has 11 bytes. A slower SCLK may
    /// therefore read zeros or garbage, including at bring-up.
    pub const fn sclk_min_hz(&self) -> u32 {
        let timeout_ticks = if self.short_spi_timeout { 256 } else { 4096 };
        (FRAME_BITS_MAX as u64)
            .saturating_mul(self.clock_hz as u64)
            .div_ceil(timeout_ticks) as u32
    }
}
