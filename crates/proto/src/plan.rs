//! A scan plan: which inputs the chip converts, how fast, and what follows from it for frames,
//! windows and touches.

use crate::division::divide;
use crate::frame::{RING_FRAMES, TAXELS};
use ads1258::{CRYSTAL_CLOCK_HZ, Config, DataRate, Delay, IdleMode, Mux, Sysred};
use serde::{Deserialize, Serialize};

/// Frames per second that touch detection works at, nearly: the paper's. Faster frames are averaged
/// for it.
const TOUCH_RATE_HZ: f32 = 241.0;
/// Least frames per second: touch detection compares blocks of four of them, which have to be
/// shorter than the changes that it looks for.
pub const FRAME_RATE_LEAST_HZ: f32 = 180.0;
/// Most frames per second: the chip's fastest scan (SBAS297G, rate table, 16 MHz).
pub const FRAME_RATE_MOST_HZ: f32 = 23_740.0;
/// Least clock of the chip, hertz: with a slower one 190 ns, which the boards give CS to settle, are
/// less than 2.5 of its periods (SBAS297G, SPI timing), and half of it is soon below SCLK.
const CLOCK_LEAST_HZ: f32 = 13_200_000.0;
/// Most clock of the chip, hertz (SBAS297G).
const CLOCK_MOST_HZ: f32 = 16_000_000.0;
/// A conversion is read twice where it lasts this long, nanoseconds: two reads with all that
/// belongs to them take up to 48 us on the boards, and other tasks need as much again.
const READ_TWICE_NS: u32 = 96_000;
/// Most frames of a window: the estimator's longest transform on the chip has as many points.
const TRANSFORM_FRAMES: u32 = 1024;
/// Frames of touch detection that pass after a window's end before it is fitted, at most, and until
/// the fit has read it: 0.4 s.
const LATE_TOUCH_FRAMES: u32 = 96;
/// Frames that a plan without averages leaves for that: 0.75 s.
const LATE_FRAMES: u32 = 180;
/// Fewest frames that hold four harmonics and their noise.
const WINDOW_LEAST_FRAMES: u32 = 24;
/// Default window, seconds, where the plan allows it: the paper's longest.
const WINDOW_S: f32 = 1.0;
/// How long a fit of four harmonics takes with all that interrupts it at the chip's fastest, and a tenth
/// more, seconds: any fit, for each frame, and for each value in it (`docs/results/trade.md`).
const FIT_S: f32 = 0.06;
const FIT_FRAME_S: f32 = 0.3e-3;
const FIT_VALUE_S: f32 = 16e-6;

/// When the chip converts its own supply, reference, temperature, offset and gain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HealthReadings {
    /// In every scan, behind the inputs: five conversions more.
    EveryScan,
    /// At the start, and twice a second while nothing touches the finger: a pause of the scan of
    /// less than a millisecond.
    BetweenTouches,
}

/// Which inputs the chip converts, and how. The fields are those of the chip's registers
/// (SBAS297G).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Bit k: the scan converts AINk, which is taxel k.
    pub inputs: u16,
    /// DRATE, 0 to 3: the chip's data rate.
    pub data_rate: u8,
    /// DLY, 0 to 7: how long an input settles before it is converted.
    pub delay: u8,
    /// CHOP: each conversion is two with the inputs exchanged. It excludes health readings in every
    /// scan.
    pub chop: bool,
    /// When the chip converts its own readings.
    pub health: HealthReadings,
    /// The chip's clock, hertz: 15,728,640 of its crystal, or that of an oscillator on CLKIO.
    pub adc_clock_hz: u32,
}

/// What a plan gives.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemars", derive(schemars::JsonSchema))]
pub struct Gives {
    /// Frames per second at the chip's nominal clock.
    pub frame_rate_hz: f32,
    /// Half of it: tones from there on alias, hertz.
    pub nyquist_hz: f32,
    /// The longest window, seconds.
    pub window_most_s: f32,
}

/// Why a plan cannot work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanError {
    /// Name of the field that is outside its bounds, or of the quantity derived from the fields.
    pub field: &'static str,
    /// Its value.
    pub value: f32,
    /// Least and greatest possible value.
    pub bounds: (f32, f32),
}

impl Plan {
    /// All inputs at 241 Hz, as in the paper, with the health readings in every scan.
    pub const PAPER: Self = Self {
        inputs: u16::MAX,
        data_rate: 1,
        delay: 3,
        chop: false,
        health: HealthReadings::EveryScan,
        adc_clock_hz: CRYSTAL_CLOCK_HZ,
    };
    /// All inputs at 1.46 kHz: a hand that explores.
    pub const HAND: Self = Self::fastest(u16::MAX);
    /// The first piezoresistor of each unit at 5.8 kHz: fine texture.
    pub const TEXTURE: Self = Self::fastest(0x1111);
    /// Two facing piezoresistors, one of each column of units, at 11.7 kHz.
    pub const VIBRATION: Self = Self::fastest(0x0011);
    /// One input at 23.3 kHz.
    pub const SINGLE: Self = Self::fastest(0x0001);

    /// The usual plans and their names. Their rates are those of the 15.72864 MHz crystal; with a
    /// clock of 16 MHz the chip would make 1.48, 5.9, 11.9 and 23.7 kHz.
    pub const NAMED: [(&'static str, Self); 5] = [
        ("paper", Self::PAPER),
        ("hand", Self::HAND),
        ("texture", Self::TEXTURE),
        ("vibration", Self::VIBRATION),
        ("single", Self::SINGLE),
    ];

    /// Some inputs as fast as the chip converts them.
    const fn fastest(inputs: u16) -> Self {
        Self {
            inputs,
            data_rate: 3,
            delay: 0,
            chop: false,
            health: HealthReadings::BetweenTouches,
            adc_clock_hz: CRYSTAL_CLOCK_HZ,
        }
    }

    /// A plan for plain frames of another converter: `channels` inputs, frames a second as given.
    /// It is for touch detection and windows; no ADS1258 has the clock that gives this rate.
    pub fn of_frames(frame_rate_hz: f32, channels: usize) -> Result<Self, PlanError> {
        let inputs = u16::MAX.checked_shr((TAXELS as u32).saturating_sub(channels as u32));
        let plan = Self::fastest(inputs.unwrap_or(0));
        let ticks = plan.config().frame_ticks() as f32;
        let values = [channels as f32, frame_rate_hz];
        within(&FRAME_BOUNDS, &values)?;
        Ok(plan.with_clock((frame_rate_hz * ticks + 0.5) as u32))
    }

    /// The plan with another clock of the chip.
    pub const fn with_clock(self, adc_clock_hz: u32) -> Self {
        Self {
            adc_clock_hz,
            ..self
        }
    }

    /// The plan of this name, by the crystal's clock.
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED
            .iter()
            .find(|(named, _)| *named == name)
            .map(|(_, plan)| *plan)
    }

    /// Its name, if it is a usual one by the crystal's clock.
    pub fn name(&self) -> Option<&'static str> {
        Self::NAMED
            .iter()
            .find(|(_, plan)| plan == self)
            .map(|(name, _)| *name)
    }

    /// The chip's configuration. Standby in place of sleep makes the first conversion after START
    /// come at once.
    pub const fn config(&self) -> Config {
        let internal = match self.health {
            HealthReadings::EveryScan => Sysred::ALL,
            HealthReadings::BetweenTouches => Sysred::NONE,
        };
        self.config_of(self.inputs, internal, self.chop)
    }

    /// The chip's configuration for its own readings alone. CHOP excludes them (SBAS297G).
    pub const fn health_config(&self) -> Config {
        self.config_of(0, Sysred::ALL, false)
    }

    const fn config_of(&self, single: u16, internal: Sysred, chop: bool) -> Config {
        Config {
            clock_hz: self.adc_clock_hz,
            mux: Mux::AutoScan {
                differential: 0,
                single,
                internal,
            },
            data_rate: match self.data_rate {
                0 => DataRate::Drate0,
                1 => DataRate::Drate1,
                2 => DataRate::Drate2,
                _ => DataRate::Drate3,
            },
            delay: match self.delay {
                0 => Delay::Dly0,
                1 => Delay::Dly1,
                2 => Delay::Dly2,
                3 => Delay::Dly3,
                4 => Delay::Dly4,
                5 => Delay::Dly5,
                6 => Delay::Dly6,
                _ => Delay::Dly7,
            },
            chop,
            idle_mode: IdleMode::Standby,
            // Nothing is connected to these pins: an open input would float and take current, and
            // the clock's output would switch for nobody.
            gpio_inputs: 0,
            clock_output: false,
            ..Config::RESET
        }
    }

    /// Inputs that are converted. Not inlined, as others below: it is called in many places, but
    /// seldom.
    pub const fn channels(&self) -> usize {
        self.inputs.count_ones() as usize
    }

    /// Conversions of a scan.
    pub const fn slots(&self) -> u32 {
        self.config().slots() as u32
    }

    /// A conversion's period at the nominal clock, nanoseconds.
    pub const fn conversion_ns(&self) -> u32 {
        divide(
            self.config().conversion_ticks() as u64 * 1_000_000_000,
            self.adc_clock_hz,
        )
        .0 as u32
    }

    /// Frames per second at the nominal clock.
    pub const fn frame_rate_hz(&self) -> f32 {
        self.config().frame_rate_hz()
    }

    /// Whether there is time to read each conversion twice, which shows bit errors on the bus.
    pub const fn is_read_twice(&self) -> bool {
        self.conversion_ns() >= READ_TWICE_NS
    }

    /// Frames that are averaged for touch detection.
    pub const fn frames_averaged(&self) -> u32 {
        let frames = (self.frame_rate_hz() / TOUCH_RATE_HZ + 0.5) as u32;
        if frames > 1 { frames } else { 1 }
    }

    /// Frames that share a row of the ring, which holds a sample for each of [`TAXELS`] taxels.
    pub const fn frames_a_row(&self) -> usize {
        match TAXELS.checked_div(self.channels()) {
            Some(frames) => frames,
            None => 1,
        }
    }

    /// Frames that the ring holds.
    pub const fn ring_frames(&self) -> u32 {
        (RING_FRAMES * self.frames_a_row()) as u32
    }

    /// Most frames of a window that can be set.
    pub const fn window_frames_most(&self) -> u32 {
        let averaged = self.frames_averaged();
        let late = if averaged > 1 {
            LATE_TOUCH_FRAMES * averaged
        } else {
            LATE_FRAMES
        };
        let most = self.ring_frames().saturating_sub(late);
        if most < TRANSFORM_FRAMES {
            most
        } else {
            TRANSFORM_FRAMES
        }
    }

    /// Frames in a time, rounded.
    pub const fn frames_in(&self, seconds: f32) -> u32 {
        (seconds * self.frame_rate_hz() + 0.5) as u32
    }

    /// Parts of a second in which the bounds of windows are whole numbers.
    const fn parts(&self) -> f32 {
        if self.frames_averaged() > 1 {
            1000.0
        } else {
            10.0
        }
    }

    /// Shortest window, seconds.
    pub const fn window_least_s(&self) -> f32 {
        let parts = (WINDOW_LEAST_FRAMES as f32 - 0.5) / self.frame_rate_hz() * self.parts();
        (parts as u32 + 1) as f32 / self.parts()
    }

    /// Longest window, seconds.
    pub const fn window_most_s(&self) -> f32 {
        let parts = (self.window_frames_most() as f32 + 0.5) / self.frame_rate_hz() * self.parts();
        parts as u32 as f32 / self.parts()
    }

    /// The window and the hop that are used unless others are set, seconds.
    pub const fn default_window(&self) -> (f32, f32) {
        let most_s = self.window_most_s();
        let window_s = if WINDOW_S < most_s { WINDOW_S } else { most_s };
        (window_s, self.default_hop(window_s))
    }

    /// The hop of a window unless another is set, seconds: a quarter of the window, or what a fit
    /// takes if that is longer, in whole hundredths.
    pub const fn default_hop(&self, window_s: f32) -> f32 {
        let values = FIT_VALUE_S * self.channels() as f32;
        let fit_s = FIT_S + self.frames_in(window_s) as f32 * (FIT_FRAME_S + values);
        let quarter_s = 0.25 * window_s;
        let hop_s = if quarter_s > fit_s { quarter_s } else { fit_s };
        (100.0 * hop_s + 0.999) as u32 as f32 / 100.0
    }

    /// What it gives.
    pub const fn gives(&self) -> Gives {
        let frame_rate_hz = self.frame_rate_hz();
        Gives {
            frame_rate_hz,
            nyquist_hz: 0.5 * frame_rate_hz,
            window_most_s: self.window_most_s(),
        }
    }

    /// Checks that it can work. The error is the first rule that is broken.
    pub fn validate(&self) -> Result<(), PlanError> {
        let is_chopped_with_health = self.chop && self.health == HealthReadings::EveryScan;
        let values = [
            self.channels() as f32,
            self.data_rate as f32,
            self.delay as f32,
            is_chopped_with_health as u8 as f32,
            self.adc_clock_hz as f32,
            self.frame_rate_hz(),
        ];
        within(&BOUNDS, &values)
    }

    /// All of it but the clock in 23 bits.
    pub const fn to_bits(self) -> u32 {
        self.inputs as u32
            | (self.data_rate as u32 & 3) << 16
            | (self.delay as u32 & 7) << 18
            | (self.chop as u32) << 21
            | (matches!(self.health, HealthReadings::BetweenTouches) as u32) << 22
    }

    /// The plan of these bits, with the chip's clock.
    pub const fn from_bits(bits: u32, adc_clock_hz: u32) -> Self {
        Self {
            inputs: bits as u16,
            data_rate: (bits >> 16) as u8 & 3,
            delay: (bits >> 18) as u8 & 7,
            chop: bits >> 21 & 1 == 1,
            health: if bits >> 22 & 1 == 1 {
                HealthReadings::BetweenTouches
            } else {
                HealthReadings::EveryScan
            },
            adc_clock_hz,
        }
    }
}

/// A field's name, its least and its greatest value.
pub(crate) type Bounds = (&'static str, f32, f32);

/// Bounds of a plan's fields, in the order of the values in [`Plan::validate`].
const BOUNDS: [Bounds; 6] = [
    ("plan.inputs", 1.0, TAXELS as f32),
    ("plan.data_rate", 0.0, 3.0),
    ("plan.delay", 0.0, 7.0),
    ("plan.chop", 0.0, 0.0),
    ("plan.adc_clock_hz", CLOCK_LEAST_HZ, CLOCK_MOST_HZ),
    ("frame_rate_hz", FRAME_RATE_LEAST_HZ, FRAME_RATE_MOST_HZ),
];

/// Bounds of what [`Plan::of_frames`] takes.
const FRAME_BOUNDS: [Bounds; 2] = [
    ("channels", 1.0, TAXELS as f32),
    ("frame_rate_hz", FRAME_RATE_LEAST_HZ, FRAME_RATE_MOST_HZ),
];

/// Checks values. The error is the first one outside its bounds.
pub(crate) fn within(bounds: &[Bounds], values: &[f32]) -> Result<(), PlanError> {
    for (&(field, least, greatest), &value) in bounds.iter().zip(values) {
        // A NaN is outside all bounds.
        if !(value >= least && value <= greatest) {
            return Err(PlanError {
                field,
                value,
                bounds: (least, greatest),
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
            assert!(
                (gives.frame_rate_hz / rate_hz - 1.0).abs() < 3e-5,
                "{name}: {gives:?}"
            );
            assert_eq!(
                (plan.channels(), plan.frames_averaged()),
                (channels, averaged),
                "{name}"
            );
            assert_eq!(
                (gives.window_most_s, gives.nyquist_hz),
                (window_s, gives.frame_rate_hz / 2.0),
                "{name}"
            );
            assert_eq!(plan.is_read_twice(), name == "paper");
            assert_eq!(plan.config().validate(), Ok(()));
            assert_eq!(plan.health_config().validate(), Ok(()));
            assert_eq!(Plan::from_bits(plan.to_bits(), plan.adc_clock_hz), plan);
            // The ring holds as many samples of a few channels as of all.
            assert_eq!(
                plan.ring_frames() as usize * channels,
                RING_FRAMES * TAXELS,
                "{name}"
            );
        }
        assert_eq!(
            Plan::NAMED.map(|(_, plan)| plan.default_window().1),
            [0.25, 0.37, 0.44, 0.4, 0.38]
        );
        assert_eq!(
            (
                Plan::PAPER.slots(),
                Plan::HAND.slots(),
                Plan::SINGLE.slots()
            ),
            (21, 16, 1)
        );
    }

    #[test]
    fn a_plan_that_cannot_work_is_refused_by_what_is_wrong() {
        let paper = Plan::PAPER;
        for (plan, field) in [
            (Plan { inputs: 0, ..paper }, "plan.inputs"),
            (
                Plan {
                    data_rate: 4,
                    ..paper
                },
                "plan.data_rate",
            ),
            (Plan { delay: 8, ..paper }, "plan.delay"),
            (
                Plan {
                    chop: true,
                    data_rate: 3,
                    delay: 0,
                    ..paper
                },
                "plan.chop",
            ),
            (
                Plan {
                    data_rate: 0,
                    ..paper
                },
                "frame_rate_hz",
            ),
            (Plan { delay: 7, ..paper }, "frame_rate_hz"),
            (paper.with_clock(8_000_000), "plan.adc_clock_hz"),
            (paper.with_clock(16_000_001), "plan.adc_clock_hz"),
        ] {
            assert_eq!(plan.validate().map_err(|error| error.field), Err(field));
        }
        // SBAS297G, section "Chop": 16 MHz, CHOP 1, DRATE 2, DLY 4 make 240.15 Hz of sixteen
        // inputs; here by the crystal.
        let chopped = Plan {
            data_rate: 2,
            delay: 4,
            chop: true,
            health: HealthReadings::BetweenTouches,
            ..Plan::PAPER
        };
        assert_eq!(chopped.validate(), Ok(()));
        assert!(
            (chopped.frame_rate_hz() - 236.08).abs() < 0.01,
            "{}",
            chopped.frame_rate_hz()
        );
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
        let registers = |plan: Plan| plan.config().registers();
        assert_eq!(registers(slow), registers(Plan::PAPER));
    }

    #[test]
    fn every_valid_plan_has_a_window_and_survives_its_bits() {
        for bits in (0..1 << 7).map(|bits| bits << 16) {
            for channels in 1..=TAXELS {
                let plan = Plan {
                    inputs: (0xffff_u32 >> (TAXELS - channels)) as u16,
                    ..Plan::from_bits(bits, CRYSTAL_CLOCK_HZ)
                };
                assert_eq!(Plan::from_bits(plan.to_bits(), plan.adc_clock_hz), plan);
                if plan.validate().is_err() {
                    continue;
                }
                let (window_s, hop_s) = plan.default_window();
                assert!(
                    plan.window_least_s() <= window_s && window_s <= plan.window_most_s(),
                    "{plan:?}"
                );
                assert!(
                    hop_s >= crate::settings::HOP_LEAST_S && plan.window_frames_most() > 60,
                    "{plan:?}"
                );
                // Touch detection works at 180 to 362 frames a second.
                let touch_hz = plan.frame_rate_hz() / plan.frames_averaged() as f32;
                assert!(
                    (FRAME_RATE_LEAST_HZ..=362.0).contains(&touch_hz),
                    "{plan:?}: {touch_hz}"
                );
            }
        }
    }
}
