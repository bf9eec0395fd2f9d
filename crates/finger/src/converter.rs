//! Interface to a converter: the trait [`Converter`] and its [`Sample`]s.
//!
//! [`Acquisition`](crate::Acquisition) serves the edges of a data-ready line and supervises the
//! converter behind it; everything after it sees [`Sample`]s. A converter of another family
//! implements [`Converter`]. [`WiredAds1258`] serves the boards with an ADS1258; [`oversampled`] has
//! the arithmetic for those that use the STM32's own ADC.

mod ads1258;
mod ads1258_plan;
mod onboard_plan;
pub mod oversampled;

pub use self::ads1258::{ChipClock, WiredAds1258};
pub use self::ads1258_plan::Ads1258Plan;
pub use self::onboard_plan::OnboardPlan;
use embedded_hal::delay::DelayNs;
use ridgetone_proto::plan::{Plan, PlanError};
use ridgetone_proto::settings::Settings;

pub use ridgetone_proto::telemetry::REGISTERS;

/// Default configuration of the ADS1258: 21 slots, 15.72864 MHz / (128 x 24.265625), which is
/// 241.14 scans a second (SBAS297G, rate formula).
pub const SCAN: ::ads1258::Config = Ads1258Plan::PAPER.config();

/// Scan that a converter runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scanned {
    /// The inputs of the plan, and the internal readings if the plan has them in every scan.
    Inputs,
    /// Only the internal readings, while nothing touches the finger.
    Health,
}

/// A sample's channel and flags, in one byte: NEW in bit 7, overload in bit 6, supply too low in
/// bit 5, the channel's id in bits 4 to 0. An input's id is its number plus 8; the internal
/// readings offset, supply, temperature, gain and reference are 18h, 1Ah, 1Bh, 1Ch and 1Dh. This
/// is the ADS1258's status byte, which that chip's implementation passes on unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tag(pub u8);

impl Tag {
    /// Flag: the sample has not been read before.
    pub const NEW: u8 = 0x80;
    /// Flag: the input exceeded what the converter can measure.
    pub const OVERLOAD: u8 = 0x40;
    /// Mask of NEW and the channel's id.
    pub(crate) const NEW_AND_ID: u8 = 0x9f;
    /// Id of the first input.
    pub(crate) const FIRST_INPUT: u8 = 0x08;

    /// Tag of a new, flawless sample of an input, 0 to 15.
    pub const fn of_input(input: u8) -> Self {
        Self(Self::NEW | (Self::FIRST_INPUT + input % 16))
    }

    /// True if the sample has not been read before.
    #[inline]
    pub const fn is_new(self) -> bool {
        self.0 & Self::NEW != 0
    }

    /// True if the input exceeded what the converter can measure.
    #[inline]
    pub const fn is_overload(self) -> bool {
        self.0 & Self::OVERLOAD != 0
    }

    /// True if the converter's supply was too low for this sample.
    #[inline]
    pub const fn is_supply_low(self) -> bool {
        self.0 & 0x20 != 0
    }

    /// Id of the channel.
    #[inline]
    pub const fn id(self) -> u8 {
        self.0 & 0x1f
    }
}

/// One sample of one channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Channel and flags of the sample.
    pub tag: Tag,
    /// Code, 24 bits; 780000h is the setting `vref_v`.
    pub code: i32,
}

/// A converter that pulls a data-ready line low after each sample, or after all of a scan.
///
/// Bus errors are return values and never cause panics: a method that returns `bool` returns false,
/// and [`Self::read`] returns `None`. [`Acquisition`](crate::Acquisition) then tries again, and
/// counts and reports the error.
pub trait Converter {
    /// Name of the converter, for messages.
    const NAME: &'static str;

    /// Default plan.
    const DEFAULT_PLAN: Plan = Plan::PAPER;

    /// Checks that the converter can run a plan that has passed [`Plan::validate`]. The error names
    /// what the converter cannot do, and what it can.
    fn check(plan: &Plan) -> Result<(), PlanError>;

    /// Stops the scan.
    fn stop(&mut self) -> bool;

    /// Resets the converter, writes the registers of a scan, whose plan has passed [`Self::check`],
    /// and reads them back. Returns false if they do not hold what was written. The scan is
    /// stopped. [`Scanned::Health`] is used only with a plan that has its health readings between
    /// touches.
    fn set_up(&mut self, plan: &Plan, scanned: Scanned, wait: &mut impl DelayNs) -> bool;

    /// Starts the scan at its first channel.
    fn start(&mut self) -> bool;

    /// Reads the latest sample or, with `Sampling::AtOnce`, the first sample of the edge. A second
    /// read returns the same sample with NEW cleared.
    fn read(&mut self) -> Option<Sample>;

    /// With `Sampling::AtOnce`, moves on to the next sample of the edge, which [`Self::read`] then
    /// reads. Returns false if there is none.
    fn go_on(&mut self) -> bool;

    /// Delay from a sample's time to its edge, microseconds: half of the averaging time, if the
    /// converter signals the end of averaging.
    fn behind_us(&self) -> u32 {
        0
    }

    /// Reads the registers back while the scan runs. Returns false if any differs from what was
    /// written.
    fn is_as_set_up(&mut self) -> bool;

    /// Returns the present registers, padded with zeros, for diagnosis.
    fn registers(&mut self) -> Option<[u8; REGISTERS]>;

    /// Minimum conversion time with the registers as they read back now, for when they no longer
    /// match what was written. Microseconds, rounded down, at least 1.
    fn min_period_us(&mut self) -> u32;
}

/// Facts about a converter that the tasks need without talking to it.
#[derive(Debug)]
pub struct Facts {
    /// [`Converter::NAME`].
    pub name: &'static str,
    /// Default plan.
    pub plan: Plan,
    /// Default reference, volts.
    pub vref_v: f32,
    /// [`Converter::check`].
    pub check: fn(&Plan) -> Result<(), PlanError>,
}

impl Facts {
    /// Facts of a converter that is wired as in the guide.
    pub const fn of<C: Converter>() -> Self {
        Self {
            name: C::NAME,
            plan: C::DEFAULT_PLAN,
            vref_v: Settings::DEFAULT.vref_v,
            check: C::check,
        }
    }

    /// Returns the settings. If this converter cannot run their plan, because nothing was stored or
    /// the settings were for a different converter, uses its default plan and reference.
    pub fn fitting(&self, settings: Settings) -> Settings {
        if (self.check)(&settings.plan).is_ok() {
            return settings;
        }
        Settings {
            vref_v: self.vref_v,
            ..settings.with_plan(self.plan)
        }
    }
}
