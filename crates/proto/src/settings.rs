//! Settings: one table from which everything else is derived.
//!
//! A setting is one row of the table below. The checks of values from a PC or the flash, TOML and
//! JSON, the command's options, the page's form, the guide's list and Python's class are generated
//! from it.

pub(crate) mod record;
mod table;

use crate::plan::{Plan, PlanError};
pub use crate::scan::{FRAME_RATE_HZ, RING_FRAMES, TAXELS};
use Bounds::{Any, Between, By, ZeroOr};
use core::f32::consts::PI;
use heapless::String;
pub use record::Kept;
use serde::{Deserialize, Serialize};
pub use table::{Bounds, Field, Kind, Limits, Setting, Value};

// A row is a sentence, the id in flash, name, type, default, unit and bounds. An id never changes
// its meaning: a setting of a different type or meaning gets a new id, 31 or above. The plan comes
// first, because the bounds of windows depend on it.
table::settings! {
    /// Everything that a user can set.
    Settings "Windows and fit" {
        /// Inputs that the chip converts, and how fast; a new plan brings its default window and
        /// stride.
        30 plan: Plan = Plan::PAPER, "", Any, option "plan";
        /// Length of a window.
        2 window_s: f32 = 1.0, "s", By(window), option "window",
            because "24 frames are the fewest that hold four harmonics; the longest is what the board has memory for with this plan";
        /// Time from the start of one window to the start of the next; below 0.05 s each window is
        /// reported as a short `track`.
        3 stride_s: f32 = 0.25, "s", By(stride), option "stride",
            because "the minimum is one frame of the plan, or in a fast plan the frames that touch detection averages; a stride longer than a window leaves frames out";
        /// Maximum number of harmonics to fit, the fundamental included.
        4 harmonics: u8 = 4, "", Between(1.0, 5.0), option "harmonics",
            because "the fundamental counts as one";
        /// Required standard deviation as a fraction of the frequency: windows grow by a stride
        /// until they meet it; 0 for windows of one length.
        5 accuracy: f32 = 0.0, "fraction", ZeroOr(1e-6, 0.1), option "accuracy",
            because "a fraction of the frequency, or 0 for windows of one length; no crystal is better than a millionth";
        /// Frequency of a known interferer in all channels, such as mains hum; 0 for none.
        6 interferer_hz: f32 = 0.0, "Hz", ZeroOr(5.0, 1000.0), option "mains",
            because "0 for none; below 5 Hz it cannot be distinguished from drift";
        /// Reference voltage of the ADC.
        7 vref_v: f32 = 4.096, "V", Between(0.5, 5.5),
            because "the ADS1258 takes a reference of 0.5 V up to its supply";
    }

    /// Source of the sliding phase. By the protocol of the stimulus (paper, equations 4 and 5), the
    /// phase starts `delay_s` after the contact spike and covers `length_mm` at `speed_mm_s`.
    slide: Slide "Slides" {
        /// Source of slides: found in the signal, timed by the protocol of the stimulus, or always
        /// (every frame is part of a slide, without contact and hold).
        8 rule: SlideRule = SlideRule::Found, "", Any;
        /// With the protocol: hold time between the contact spike and the slide.
        9 delay_s: f32 = 1.0, "s", Between(0.0, 60.0),
            because "the protocol that the stimulus follows";
        /// Speed of the stimulus, which also gives the spatial period. Used with the rule
        /// `protocol` and, unless 0, with `always`.
        10 speed_mm_s: f32 = 0.0, "mm/s", By(speed), option "speed",
            because "slide.rule = \"protocol\" needs the speed of the stimulus";
        /// With the protocol: length of the slide to use (paper: 55 of 60).
        11 length_mm: f32 = 55.0, "mm", Between(0.1, 2000.0),
            because "the protocol that the stimulus follows";
    }

    /// Positions of the piezoresistors, and prior knowledge of the gratings. With these, the phases
    /// determine a spatial period.
    ///
    /// The default has four units of four piezoresistors (paper, section 2.1): AIN 4 u + k is
    /// piezoresistor k + 1 of unit u + 1; units 2 and 4 are in front. Pitch and edge phase were
    /// measured on the simulated finger with a contact 8 mm long (`host/tests/calibrate.rs`); their
    /// uncertainty is that of an uncalibrated finger ([`Array::is_calibrated`]). **Measure them on
    /// your own finger**: they change with the force. The possible periods are those of the paper's
    /// gratings with a margin, limited to the range in which the answer is unique.
    array: Array "Array" {
        /// Effective spacing of the two sensor columns along the motion, from phase.
        12 pitch_mm: f32 = 2.364, "mm", Between(0.1, 100.0),
            because "`ridgetone calibrate` finds it";
        /// Phase by which the contact's ends reduce the lag between the columns: the lag is 2 pi
        /// pitch / period less this.
        13 edge_phase_rad: f32 = 0.41, "rad", Between(-PI, PI),
            because "`ridgetone calibrate` finds it";
        /// Standard deviation of true lags about those of pitch and edge phase; 0.3 or more means
        /// that the array is not calibrated.
        14 edge_phase_sigma_rad: f32 = UNCALIBRATED_RAD, "rad", Between(0.0, PI),
            because "`ridgetone calibrate` finds it";
        /// Shortest possible spatial period.
        15 period_min_mm: f32 = 2.3, "mm", Between(0.1, PERIOD_MAX_MM);
        /// Longest possible spatial period; between one pitch and two the answer is unique.
        16 period_max_mm: f32 = 4.2, "mm", By(longest_period),
            because "the longest possible period is not below the shortest";
        /// The grating may move along +x.
        17 may_go_forward: bool = true, "", By(forward),
            because "one of array.may_go_forward and array.may_go_backward must be true";
        /// The grating may move against +x; if only one direction is possible, every period above
        /// one pitch is unique.
        18 may_go_backward: bool = true, "", Any;
        /// Taxels of the front column, further along +x: bit k is taxel k.
        19 front: u16 = 0xf0f0, "mask", Any;
        /// Four masks of taxels that respond alike, the same piezoresistor of every unit; a taxel
        /// in none of them is not used.
        20 alike: [u16; 4] = [0x1111, 0x2222, 0x4444, 0x8888], "masks", Between(0.0, 0.0),
            because "a taxel may be in one mask; these bits are in two";
    }

    /// Content of a window in addition to the tone. Effects that are not declared are not modelled:
    /// the fit takes fewer instructions, and is wrong or refuses if they are present
    /// (`docs/results/trade.md`). If none is declared, the scene is lean and has its own, short
    /// fit.
    scene: Declared "Scene" {
        /// The tone may have overtones, up to `harmonics`; otherwise it is a single sine.
        31 overtones: bool = true, "", Any;
        /// Levels may bend over a window, as under a skin that creeps; otherwise they have only a
        /// slope.
        25 curved_baseline: bool = true, "", Any;
        /// Noise may have any spectrum; otherwise it is white.
        26 coloured_noise: bool = true, "", Any;
        /// Noise may be correlated between channels.
        27 shared_noise: bool = true, "", Any;
        /// The speed changes with a probability of one half; otherwise it is most likely steady.
        28 moving_speed: bool = false, "", Any;
        /// Single values may be outliers.
        29 impulses: bool = true, "", Any;
    }
}

/// Standard deviation of the edge phase of an array that was never calibrated, radians: on the
/// simulated finger the phase is 0 under a contact much longer than the array, and up to 1.13 rad
/// under one of 5 mm (`hal-mock/README.md`).
const UNCALIBRATED_RAD: f32 = 0.3;

/// Stride below which each window is reported as a [`Track`](crate::telemetry::Track), and minimum
/// interval between [`Estimate`](crate::telemetry::Estimate)s then, seconds.
pub const TRACK_STRIDE_S: f32 = 0.05;
/// Lower limit of the longest stride, seconds: short windows may be far apart.
const STRIDE_MAX_FLOOR_S: f32 = 1.0;
/// Maximum spatial period, millimetres.
const PERIOD_MAX_MM: f32 = 100.0;

fn window(settings: &Settings) -> Limits {
    Limits::new(settings.plan.window_min_s(), settings.plan.window_max_s())
}

fn stride(settings: &Settings) -> Limits {
    let max_s = settings.plan.window_max_s();
    Limits::new(settings.plan.stride_min_s(), max_s.max(STRIDE_MAX_FLOOR_S))
}

fn speed(settings: &Settings) -> Limits {
    match settings.slide.rule {
        SlideRule::Found | SlideRule::Always => Limits::new(0.0, 2000.0),
        SlideRule::Protocol => Limits::new(0.1, 2000.0),
    }
}

fn longest_period(settings: &Settings) -> Limits {
    Limits::new(settings.array.period_min_mm, PERIOD_MAX_MM)
}

/// At least one direction must be possible, or no travel can be determined.
fn forward(settings: &Settings) -> Limits {
    let min = if settings.array.may_go_backward {
        0.0
    } else {
        1.0
    };
    Limits::new(min, 1.0)
}

/// Source of slides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SlideRule {
    /// From the signal: a slide starts when the held signals begin to change together, and ends
    /// when they stop.
    Found,
    /// From the protocol of the stimulus.
    Protocol,
    /// Always: every frame is part of a slide, without contact and hold.
    Always,
}

impl Field for SlideRule {
    const KIND: Kind = Kind::Word(&["found", "protocol", "always"]);

    fn number(self) -> f32 {
        0.0
    }

    fn value(self) -> Value {
        Value::Word(match self {
            Self::Found => "found",
            Self::Protocol => "protocol",
            Self::Always => "always",
        })
    }

    fn of(value: Value) -> Option<Self> {
        match value {
            Value::Word("found") => Some(Self::Found),
            Value::Word("protocol") => Some(Self::Protocol),
            Value::Word("always") => Some(Self::Always),
            _ => None,
        }
    }
}

impl Declared {
    /// Only a single sine in white noise: the lean scene.
    pub const LEAN: Self = Self {
        overtones: false,
        curved_baseline: false,
        coloured_noise: false,
        shared_noise: false,
        moving_speed: false,
        impulses: false,
    };
}

impl Default for Declared {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Array {
    /// True if pitch and edge phase were measured on this finger.
    pub fn is_calibrated(&self) -> bool {
        self.edge_phase_sigma_rad < UNCALIBRATED_RAD
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A setting outside its bounds; NaN always is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[error("{field} = {value}: choose a value from {min} to {max}")]
pub struct SettingsError {
    /// Name of the setting, or of a quantity derived from a plan.
    pub field: String<32>,
    /// The requested value.
    pub value: f32,
    /// Minimum allowed value.
    pub min: f32,
    /// Maximum allowed value.
    pub max: f32,
}

impl SettingsError {
    fn new(name: &str, value: f32, limits: Limits) -> Self {
        Self {
            // A test checks that every name fits.
            field: String::try_from(name).unwrap_or_default(),
            value,
            min: limits.min,
            max: limits.max,
        }
    }
}

impl From<PlanError> for SettingsError {
    fn from(error: PlanError) -> Self {
        let (min, max) = error.bounds;
        Self::new(error.field, error.value, Limits::new(min, max))
    }
}

impl Settings {
    /// Changes the plan, with its default window and stride.
    pub const fn with_plan(self, plan: Plan) -> Self {
        let (window_s, stride_s) = plan.default_window();
        Self {
            plan,
            window_s,
            stride_s,
            ..self
        }
    }

    /// True if windows are so close together that each is reported as a
    /// [`Track`](crate::telemetry::Track).
    pub const fn tracks(&self) -> bool {
        self.stride_s < TRACK_STRIDE_S
    }

    /// Checks all bounds. The error is the first setting outside its bounds.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.plan.validate()?;
        for ((name, bounds), value) in CHECKS.iter().zip(self.numbers()) {
            if let Some(limits) = bounds.broken(value, self) {
                return Err(SettingsError::new(name, value, limits));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
