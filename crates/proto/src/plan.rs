//! A scan plan: which inputs a converter samples, how fast, and the resulting frames, windows and
//! touch detection. Other settings are specific to the converter, which alone can interpret them.

use crate::division::divide;
use crate::frame::{RING_FRAMES, TAXELS};
use serde::{Deserialize, Serialize};

/// Approximate frame rate of touch detection, as in the paper. Faster frames are averaged for it.
const TOUCH_RATE_HZ: f32 = 241.0;
/// Minimum frames per second: touch detection compares blocks of four frames, which must be shorter
/// than the changes to detect.
pub const FRAME_RATE_MIN_HZ: f32 = 180.0;
/// Maximum frames per second: the ADS1258's fastest scan (SBAS297G, rate table, 16 MHz).
pub const FRAME_RATE_MAX_HZ: f32 = 23_740.0;
/// Minimum duration of a conversion to read it twice, nanoseconds: two reads with their processing
/// take up to 48 us on the boards, and other tasks need the same again.
const READ_TWICE_NS: u32 = 96_000;
/// Maximum number of frames of a window: the size of the estimator's longest transform on the chip.
const TRANSFORM_FRAMES: u32 = 1024;
/// Maximum number of touch-detection frames from a window's end until the fit has read the window:
/// 0.4 s.
const LATE_TOUCH_FRAMES: u32 = 96;
/// Number of frames that a plan without averages reserves from a window's end until the fit has read
/// the window: 0.75 s.
const LATE_FRAMES: u32 = 180;
/// Minimum number of frames for four harmonics and their noise.
const WINDOW_FRAMES_MIN: u32 = 24;
/// Default window, seconds, if the plan allows it: the paper's longest.
const WINDOW_S: f32 = 1.0;
/// Duration of a full search with four harmonics, including interruptions at the chip's highest
/// rate, plus a tenth, seconds: a constant part, a part per frame, and a part per value in a frame
/// (`docs/results/trade.md`).
const FIT_S: f32 = 0.06;
const FIT_FRAME_S: f32 = 0.3e-3;
const FIT_VALUE_S: f32 = 16e-6;

/// Number of a converter's internal readings: supply, reference, temperature, offset and gain.
pub const READINGS: u32 = 5;

/// Times at which a converter measures its own supply, reference, temperature, offset and gain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HealthReadings {
    /// In every scan, after the inputs: five extra conversions.
    EveryScan,
    /// At the start, and twice a second while the finger is not touched: the scan pauses for less
    /// than a millisecond.
    BetweenTouches,
    /// Never: the converter has no such readings.
    Never,
}

/// Times at which the inputs of a scan are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// One after the other, one conversion each.
    InTurn,
    /// All at the same moment, the data-ready edge.
    AtOnce,
}

/// Numbers of the converters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Converters;

impl Converters {
    /// The ADS1258.
    pub const ADS1258: u8 = 0;
    /// The STM32's own ADC.
    pub const ONBOARD: u8 = 1;
    /// Plain frames from any other converter.
    pub const FRAMES: u8 = 255;
}

/// Part of a plan that is specific to its converter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Own {
    /// Converter: one of [`Converters`].
    pub converter: u8,
    /// Settings, in the converter's own packing. No two plans of a converter with the same inputs
    /// and clock may have the same lowest byte.
    pub bits: u16,
}

/// Which inputs a converter samples, and how fast.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Plan {
    /// Bit k: the scan includes input k, which is taxel k.
    pub inputs: u16,
    /// Times of the converter's internal readings.
    pub health: HealthReadings,
    /// Times at which the inputs of a scan are sampled.
    pub sampling: Sampling,
    /// The converter's clock, hertz.
    pub adc_clock_hz: u32,
    /// Periods of the converter's clock from one frame to the next.
    pub frame_ticks: u32,
    /// Settings specific to the converter.
    pub own: Own,
}

/// Rates and windows that follow from a plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
pub struct Gives {
    /// Frames per second at the converter's nominal clock.
    pub frame_rate_hz: f32,
    /// Half of the frame rate (hertz): tones above it alias.
    pub nyquist_hz: f32,
    /// The longest window, seconds.
    pub window_max_s: f32,
}

/// Reason why a plan cannot work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanError {
    /// Name of the field that is outside its bounds, or of a quantity derived from the fields.
    pub field: &'static str,
    /// Value of the field.
    pub value: f32,
    /// Minimum and maximum allowed value.
    pub bounds: (f32, f32),
}

impl Plan {
    /// All inputs at 241 Hz, as in the paper, with the health readings in every scan: 21
    /// conversions of 3106 clock periods.
    pub const PAPER: Self = Self {
        inputs: u16::MAX,
        health: HealthReadings::EveryScan,
        sampling: Sampling::InTurn,
        adc_clock_hz: ADS1258_CLOCK_HZ,
        frame_ticks: 21 * 3106,
        own: Own {
            converter: Converters::ADS1258,
            bits: 0x0d,
        },
    };
    /// All inputs at 1.46 kHz, for a hand that explores.
    pub const HAND: Self = Self::fastest(u16::MAX);
    /// The first piezoresistor of each unit at 5.8 kHz, for fine texture.
    pub const TEXTURE: Self = Self::fastest(0x1111);
    /// Two facing piezoresistors, one in each column of units, at 11.7 kHz.
    pub const VIBRATION: Self = Self::fastest(0x0011);
    /// One input at 23.3 kHz.
    pub const SINGLE: Self = Self::fastest(0x0001);

    /// Fourteen inputs of the STM32's own ADC at 237 Hz: the mean of 93 scans, 68 periods of 21 MHz
    /// per sample.
    pub const ONBOARD: Self = Self::onboard(93);
    /// The same fourteen inputs at 1.47 kHz.
    pub const ONBOARD_HAND: Self = Self::onboard(15);

    /// The usual plans and their names. The ADS1258's rates apply to its 15.72864 MHz crystal; with
    /// a clock of 16 MHz they are 1.48, 5.9, 11.9 and 23.7 kHz.
    pub const NAMED: [(&'static str, Self); 7] = [
        ("paper", Self::PAPER),
        ("hand", Self::HAND),
        ("texture", Self::TEXTURE),
        ("vibration", Self::VIBRATION),
        ("single", Self::SINGLE),
        ("onboard", Self::ONBOARD),
        ("onboard-hand", Self::ONBOARD_HAND),
    ];

    /// The usual plans of a converter, one of [`Converters`], and their names.
    pub fn usual(converter: u8) -> impl Iterator<Item = (&'static str, Self)> {
        let is_its = move |(_, plan): &(_, Self)| plan.own.converter == converter;
        Self::NAMED.into_iter().filter(is_its)
    }

    /// Plan with fourteen inputs and `scans` scans per frame.
    const fn onboard(scans: u8) -> Self {
        Self {
            inputs: 0x3fff,
            health: HealthReadings::Never,
            sampling: Sampling::AtOnce,
            adc_clock_hz: 21_000_000,
            frame_ticks: 14 * 68 * scans as u32,
            own: Own {
                converter: Converters::ONBOARD,
                bits: scans as u16,
            },
        }
    }

    /// Plan with `inputs` as fast as the ADS1258 converts them, 674 clock periods each.
    const fn fastest(inputs: u16) -> Self {
        Self {
            inputs,
            health: HealthReadings::BetweenTouches,
            frame_ticks: inputs.count_ones() * 674,
            own: Own {
                bits: 0x43,
                ..Self::PAPER.own
            },
            ..Self::PAPER
        }
    }

    /// Plan for plain frames of any converter, with `channels` inputs at `frame_rate_hz`.
    pub fn of_frames(frame_rate_hz: f32, channels: usize) -> Result<Self, PlanError> {
        within(&FRAME_BOUNDS, &[channels as f32, frame_rate_hz])?;
        let inputs = u16::MAX.checked_shr((TAXELS as u32).saturating_sub(channels as u32));
        Ok(Self {
            inputs: inputs.unwrap_or(0),
            health: HealthReadings::Never,
            sampling: Sampling::AtOnce,
            adc_clock_hz: (frame_rate_hz * FRAMES_TICKS as f32 + 0.5) as u32,
            frame_ticks: FRAMES_TICKS,
            own: Own {
                converter: Converters::FRAMES,
                bits: 0,
            },
        })
    }

    /// The same plan with a different converter clock.
    pub const fn with_clock(self, adc_clock_hz: u32) -> Self {
        Self {
            adc_clock_hz,
            ..self
        }
    }

    /// Finds a plan by its name, at its usual clock.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED
            .iter()
            .find(|(named, _)| *named == name)
            .map(|(_, plan)| *plan)
    }

    /// Name of the plan, if it is a usual plan at its usual clock.
    pub fn name(&self) -> Option<&'static str> {
        Self::NAMED
            .iter()
            .find(|(_, plan)| plan == self)
            .map(|(name, _)| *name)
    }

    /// Number of inputs.
    pub const fn channels(&self) -> usize {
        self.inputs.count_ones() as usize
    }

    /// Number of conversions of a scan.
    pub const fn slots(&self) -> u32 {
        let own = match self.health {
            HealthReadings::EveryScan => READINGS,
            HealthReadings::BetweenTouches | HealthReadings::Never => 0,
        };
        self.inputs.count_ones() + own
    }

    /// Period of a conversion at the nominal clock, nanoseconds: the scan's period over its slots.
    pub const fn conversion_ns(&self) -> u32 {
        let (frame_ns, _) = divide(self.frame_ticks as u64 * 1_000_000_000, self.adc_clock_hz);
        divide(frame_ns, self.slots()).0 as u32
    }

    /// Frames per second at the nominal clock.
    pub const fn frame_rate_hz(&self) -> f32 {
        if self.frame_ticks == 0 {
            return 0.0;
        }
        self.adc_clock_hz as f32 / self.frame_ticks as f32
    }

    /// True if there is time to read each conversion twice, which detects bit errors on the bus.
    pub const fn is_read_twice(&self) -> bool {
        self.conversion_ns() >= READ_TWICE_NS
    }

    /// Number of frames averaged for touch detection.
    pub const fn frames_averaged(&self) -> u32 {
        let frames = (self.frame_rate_hz() / TOUCH_RATE_HZ + 0.5) as u32;
        if frames > 1 { frames } else { 1 }
    }

    /// Number of frames that share a row of the ring, which has a sample for each of [`TAXELS`]
    /// taxels.
    pub const fn frames_a_row(&self) -> usize {
        match TAXELS.checked_div(self.channels()) {
            Some(frames) => frames,
            None => 1,
        }
    }

    /// Capacity of the ring, frames.
    pub const fn ring_frames(&self) -> u32 {
        (RING_FRAMES * self.frames_a_row()) as u32
    }

    /// Maximum number of frames in a window, limited by the ring and the transform.
    pub const fn window_frames_max(&self) -> u32 {
        let averaged = self.frames_averaged();
        let late = if averaged > 1 {
            LATE_TOUCH_FRAMES.saturating_mul(averaged)
        } else {
            LATE_FRAMES
        };
        let max = self.ring_frames().saturating_sub(late);
        if max < TRANSFORM_FRAMES {
            max
        } else {
            TRANSFORM_FRAMES
        }
    }

    /// Number of frames in a duration, rounded.
    pub const fn frames_in(&self, seconds: f32) -> u32 {
        (seconds * self.frame_rate_hz() + 0.5) as u32
    }

    /// Resolution of window bounds, in steps per second.
    const fn parts(&self) -> f32 {
        if self.frames_averaged() > 1 {
            1000.0
        } else {
            10.0
        }
    }

    /// Shortest window, seconds.
    pub const fn window_min_s(&self) -> f32 {
        let parts = (WINDOW_FRAMES_MIN as f32 - 0.5) / self.frame_rate_hz() * self.parts();
        (parts as u32).saturating_add(1) as f32 / self.parts()
    }

    /// Longest window, seconds.
    pub const fn window_max_s(&self) -> f32 {
        let parts = (self.window_frames_max() as f32 + 0.5) / self.frame_rate_hz() * self.parts();
        parts as u32 as f32 / self.parts()
    }

    /// Shortest stride, seconds: a frame, or the frames that touch detection averages, rounded down
    /// to tenths of a millisecond.
    pub const fn stride_min_s(&self) -> f32 {
        let frames = self.frames_averaged() as f32;
        (1e4 * frames / self.frame_rate_hz()) as u32 as f32 / 1e4
    }

    /// Default window and stride, seconds.
    pub const fn default_window(&self) -> (f32, f32) {
        let max_s = self.window_max_s();
        let window_s = if WINDOW_S < max_s { WINDOW_S } else { max_s };
        (window_s, self.default_stride(window_s))
    }

    /// Default stride of a window, seconds: a quarter of the window, or the duration of a full
    /// search if that is longer, in whole hundredths.
    pub const fn default_stride(&self, window_s: f32) -> f32 {
        let values = FIT_VALUE_S * self.channels() as f32;
        let fit_s = FIT_S + self.frames_in(window_s) as f32 * (FIT_FRAME_S + values);
        let quarter_s = 0.25 * window_s;
        let stride_s = if quarter_s > fit_s { quarter_s } else { fit_s };
        (100.0 * stride_s + 0.999) as u32 as f32 / 100.0
    }

    /// Rates and windows that follow from the plan.
    pub const fn gives(&self) -> Gives {
        let frame_rate_hz = self.frame_rate_hz();
        Gives {
            frame_rate_hz,
            nyquist_hz: 0.5 * frame_rate_hz,
            window_max_s: self.window_max_s(),
        }
    }

    /// Checks the rules common to all converters. The error is the first broken rule. Whether a
    /// converter can run the plan is checked by that converter.
    pub fn validate(&self) -> Result<(), PlanError> {
        within(&BOUNDS, &[self.channels() as f32, self.frame_rate_hz()])
    }

    /// Inputs and own settings in 24 bits, to distinguish plans. The clock is not included.
    pub const fn mark(&self) -> u32 {
        self.inputs as u32 | (self.own.bits as u32 & 0xff) << 16
    }
}

/// Name, minimum and maximum of a field.
pub type Bounds = (&'static str, f32, f32);

/// Clock of the ADS1258's crystal, hertz (SBAS297G).
const ADS1258_CLOCK_HZ: u32 = 15_728_640;
/// Clock periods of a plain frame. A power of two, so that multiplying a rate by it is exact; the
/// product, at least 2.9 million, is then rounded to a hertz.
const FRAMES_TICKS: u32 = 1 << 14;

/// Bounds of every plan, in the order of the values in [`Plan::validate`].
const BOUNDS: [Bounds; 2] = [
    ("plan.inputs", 1.0, TAXELS as f32),
    ("frame_rate_hz", FRAME_RATE_MIN_HZ, FRAME_RATE_MAX_HZ),
];

/// Bounds of the arguments of [`Plan::of_frames`].
const FRAME_BOUNDS: [Bounds; 2] = [
    ("channels", 1.0, TAXELS as f32),
    ("frame_rate_hz", FRAME_RATE_MIN_HZ, FRAME_RATE_MAX_HZ),
];

/// Checks values. The error is the first one outside its bounds.
pub fn within(bounds: &[Bounds], values: &[f32]) -> Result<(), PlanError> {
    for (&(field, min, max), &value) in bounds.iter().zip(values) {
        // A NaN is outside all bounds.
        if !(value >= min && value <= max) {
            return Err(PlanError {
                field,
                value,
                bounds: (min, max),
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_named_plans_have_their_rates() {
        // SBAS297G, rate formula, by hand: 15.72864 MHz / (128 x 5.265625) = 23,336.3 conversions a
        // second.
        for (name, rate_hz, channels, averaged, window_s) in [
            ("paper", 241.14, 16, 1, 3.9),
            ("hand", 1458.5, 16, 6, 0.373),
            ("texture", 5834.1, 4, 24, 0.175),
            ("vibration", 11_668.1, 2, 48, 0.087),
            ("single", 23_336.3, 1, 97, 0.043),
        ] {
            let plan = Plan::named(name).unwrap();
            assert_eq!((plan.validate(), plan.name()), (Ok(()), Some(name)));
            let gives = plan.gives();
            let off = gives.frame_rate_hz / rate_hz - 1.0;
            assert!(off.abs() < 3e-5, "{name}: {gives:?}");
            let found = (plan.channels(), plan.frames_averaged());
            assert_eq!(found, (channels, averaged), "{name}");
            // Stride at the rate of touch detection, 180 Hz or more, in whole frames.
            let stride = (plan.stride_min_s(), plan.frames_in(plan.stride_min_s()));
            assert!((0.0040..=0.0042).contains(&stride.0), "{name}: {stride:?}");
            assert!(averaged - stride.1 <= averaged / 50, "{name}: {stride:?}");
            let found = (gives.window_max_s, gives.nyquist_hz);
            assert_eq!(found, (window_s, gives.frame_rate_hz / 2.0), "{name}");
            assert_eq!(plan.is_read_twice(), name == "paper");
            // The ring holds the same number of samples for any number of channels.
            let samples = plan.ring_frames() as usize * channels;
            assert_eq!(samples, RING_FRAMES * TAXELS, "{name}");
        }
        let strides_s = Plan::NAMED.map(|(_, plan)| plan.default_window().1);
        assert_eq!(strides_s, [0.25, 0.37, 0.44, 0.4, 0.38, 0.25, 0.35]);
        let slots = [Plan::PAPER, Plan::HAND, Plan::SINGLE].map(|plan| plan.slots());
        assert_eq!(slots, [21, 16, 1]);
    }

    #[test]
    fn a_plan_that_cannot_work_is_refused_by_what_is_wrong() {
        let paper = Plan::PAPER;
        let with_ticks = |frame_ticks| Plan {
            frame_ticks,
            ..paper
        };
        for (plan, field) in [
            (Plan { inputs: 0, ..paper }, "plan.inputs"),
            (with_ticks(0), "frame_rate_hz"),
            (with_ticks(88_000), "frame_rate_hz"),
            (with_ticks(600), "frame_rate_hz"),
            (paper.with_clock(0), "frame_rate_hz"),
        ] {
            assert_eq!(plan.validate().map_err(|error| error.field), Err(field));
            // Derived values must still not panic.
            let _ = (plan.conversion_ns(), plan.frames_averaged(), plan.gives());
            let _ = (plan.default_window(), plan.frames_a_row());
        }
    }

    #[test]
    fn rates_follow_the_clock() {
        let slow = Plan::PAPER.with_clock(15_272_727);
        let fast = Plan::PAPER.with_clock(16_000_000);
        assert_eq!((slow.validate(), fast.validate()), (Ok(()), Ok(())));
        // SBAS297G, rate formula: 16 MHz / (128 x 24.265625 x 21).
        assert!((fast.frame_rate_hz() - 245.3).abs() < 0.01, "{fast:?}");
        assert_eq!((fast.conversion_ns(), fast.name()), (194_125, None));
        assert!((slow.frame_rate_hz() / fast.frame_rate_hz() - 0.954_545).abs() < 1e-6);
    }

    #[test]
    fn plain_frames_have_the_rate_that_was_asked_for() {
        for rate_hz in [180.0, 241.14, 1000.0, 23_740.0] {
            let plan = Plan::of_frames(rate_hz, 3).unwrap();
            assert_eq!((plan.validate(), plan.inputs), (Ok(()), 7));
            assert!((plan.frame_rate_hz() / rate_hz - 1.0).abs() < 1e-6);
            // The period is rounded down to a nanosecond for each of three inputs.
            let period_s = 1e-9 * f64::from(plan.conversion_ns() * plan.slots());
            let off_s = period_s - f64::from(rate_hz).recip();
            assert!(off_s.abs() < 4e-9, "{rate_hz}");
        }
    }
}
