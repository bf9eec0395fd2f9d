//! Settings, with units, bounds and the source of each default.

use crate::plan::{Bounds, Plan, PlanError, within};
pub use crate::scan::{FRAME_RATE_HZ, RING_FRAMES, SCAN, TAXELS};
use core::f32::consts::PI;
use heapless::String;
use serde::{Deserialize, Serialize};

/// Where the sliding phase comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum SlideRule {
    /// From the signal: the slide starts when the held signals begin to change together, and ends
    /// when they stop.
    Found,
    /// From the stimulus's protocol (paper, equations 4 and 5): `delay_s` after the spike,
    /// `length_mm` at `speed_mm_s`.
    Protocol {
        /// Hold time between the contact spike and the slide, seconds.
        delay_s: f32,
        /// Speed of the stimulus, millimetres per second.
        speed_mm_s: f32,
        /// Length of the slide to use, millimetres (paper: 55 of 60).
        length_mm: f32,
    },
}

/// Positions of the piezoresistors, and what is known of the gratings. With it phases give a
/// spatial period.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Array {
    /// Distance between the two columns of units along the motion, millimetres, as it appears in
    /// the phases: turns of lag over cycles per millimetre. It is the units' pitch if the contact
    /// is much longer.
    pub pitch_mm: f32,
    /// Phase by which the contact's ends reduce the lag between the columns, radians. The lag is 2
    /// pi `pitch_mm` / period - `edge_phase_rad`; both are measured with gratings of known period.
    pub edge_phase_rad: f32,
    /// Standard deviation of true lags around that straight line, radians.
    pub edge_phase_sigma_rad: f32,
    /// Shortest possible spatial period, millimetres.
    pub period_least_mm: f32,
    /// Longest possible spatial period, millimetres.
    pub period_most_mm: f32,
    /// Whether the grating may move along +x.
    pub may_go_forward: bool,
    /// Whether it may move against +x. If only one direction is possible, every period above one
    /// pitch is unique.
    pub may_go_backward: bool,
    /// Bit k: taxel k is in the front column, further along +x.
    pub front: u16,
    /// Masks of taxels that respond alike: the same piezoresistor of every unit. A taxel in no mask
    /// is not used.
    pub alike: [u16; 4],
}

impl Array {
    /// Four units of four piezoresistors (paper, section 2.1): AIN 4 u + k is piezoresistor k + 1
    /// of unit u + 1; units 2 and 4 are in front, at a pitch of 2.3 mm. `pitch_mm` and the edge
    /// phase were measured on the simulated finger with a contact 8 mm long
    /// (`host/tests/calibrate.rs`). **Measure them on your own finger**: they change with the
    /// force. The possible periods are those of the paper's gratings with a margin, as far as the
    /// answer is unique.
    pub const DEFAULT: Self = Self {
        pitch_mm: 2.364,
        edge_phase_rad: 0.41,
        edge_phase_sigma_rad: 0.01,
        period_least_mm: 2.3,
        period_most_mm: 4.2,
        may_go_forward: true,
        may_go_backward: true,
        front: 0xf0f0,
        alike: [0x1111, 0x2222, 0x4444, 0x8888],
    };
}

/// What turns a vibration into what a finger feels (Sensors 18 (2018) 1588; the crate
/// `ridgetone-feel`). **Measure it with your own finger** on a surface of known roughness:
/// `ridgetone feel`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Feeling {
    /// Amplitude of a taxel's reading over the displacement from peak to peak, volts per micrometre
    /// (equation 6), measured in windows as long as those of the events. Zero: no event `feel`.
    pub volts_per_um: f32,
    /// Its standard deviation over it.
    pub sigma_share: f32,
    /// Tangential over normal force. Zero: that of the static image before the slide.
    pub force_ratio: f32,
}

impl Feeling {
    /// No event `feel`: nobody knows the conversion of a finger that was not measured.
    pub const DEFAULT: Self = Self {
        volts_per_um: 0.0,
        sigma_share: 0.0,
        force_ratio: 0.0,
    };

    /// Whether events `feel` are reported.
    pub fn is_on(&self) -> bool {
        self.volts_per_um > 0.0
    }
}

/// Everything that a user can set.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Length of a window, seconds.
    pub window_s: f32,
    /// From the start of one window to the start of the next, seconds.
    pub hop_s: f32,
    /// Most harmonics of the tone that are fitted, the fundamental included.
    pub harmonics: u8,
    /// Required accuracy: standard deviation over frequency. Windows then grow hop by hop until the
    /// estimate meets it or the window has `window_s`; only this last estimate is sent. Zero: every
    /// window has `window_s`.
    pub accuracy: f32,
    /// Frequency of a known interferer in all channels (mains hum), hertz; zero: none.
    pub interferer_hz: f32,
    /// Reference voltage of the ADC, volts.
    pub vref_v: f32,
    /// Where the sliding phase comes from. The protocol's speed gives the spatial period too.
    pub slide: SlideRule,
    /// Positions of the piezoresistors.
    pub array: Array,
    /// What turns a vibration into what a finger feels.
    pub feel: Feeling,
    /// What the chip converts, and how fast.
    pub plan: Plan,
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// A setting outside its bounds; NaN is outside all of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[error("{field} = {value}: choose a value from {least} to {greatest}")]
pub struct SettingsError {
    /// Name of the field, with its unit.
    pub field: String<24>,
    /// The requested value.
    pub value: f32,
    /// Least allowed value.
    pub least: f32,
    /// Greatest allowed value.
    pub greatest: f32,
}

impl Settings {
    /// The defaults. A window of one second is the paper's longest. The paper saw the fundamental
    /// and three overtones in its gratings (section 5). 4.096 V is the usual reference for a chip
    /// on 5 V.
    pub const DEFAULT: Self = Self {
        window_s: 1.0,
        hop_s: 0.25,
        harmonics: 4,
        accuracy: 0.0,
        interferer_hz: 0.0,
        vref_v: 4.096,
        slide: SlideRule::Found,
        array: Array::DEFAULT,
        feel: Feeling::DEFAULT,
        plan: Plan::PAPER,
    };

    /// These settings for another plan, with its default window and hop.
    pub const fn with_plan(self, plan: Plan) -> Self {
        let (window_s, hop_s) = plan.default_window();
        Self {
            plan,
            window_s,
            hop_s,
            ..self
        }
    }

    /// Checks every bound. The error is the first field outside its own.
    #[inline(never)]
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.check().map_err(
            |PlanError {
                 field,
                 value,
                 bounds: (least, greatest),
             }| {
                // A test shows that every name fits.
                SettingsError {
                    field: String::try_from(field).unwrap_or_default(),
                    value,
                    least,
                    greatest,
                }
            },
        )
    }

    fn check(&self) -> Result<(), PlanError> {
        self.plan.validate()?;
        let most_s = self.plan.window_most_s();
        let hop_most_s = if most_s > HOP_LEAST_MOST_S {
            most_s
        } else {
            HOP_LEAST_MOST_S
        };
        let windows = [
            ("window_s", self.plan.window_least_s(), most_s),
            ("hop_s", HOP_LEAST_S, hop_most_s),
        ];
        within(&windows, &[self.window_s, self.hop_s])?;
        let Array {
            pitch_mm,
            edge_phase_rad,
            edge_phase_sigma_rad,
            period_least_mm,
            period_most_mm,
            ..
        } = self.array;
        let Array {
            may_go_forward,
            may_go_backward,
            alike,
            ..
        } = self.array;
        // A taxel in two masks would count twice. The error reports the mask of such taxels.
        let (_, twice) = alike.iter().fold((0, 0), |(seen, twice), mask| {
            (seen | mask, twice | seen & mask)
        });
        // Fields that are not used get a value within their bounds.
        let unless_zero = |value: f32, least: f32| if value == 0.0 { least } else { value };
        let (delay_s, speed_mm_s, length_mm) = match self.slide {
            SlideRule::Found => (0.0, 1.0, 1.0),
            SlideRule::Protocol {
                delay_s,
                speed_mm_s,
                length_mm,
            } => (delay_s, speed_mm_s, length_mm),
        };
        let values = [
            self.harmonics as f32,
            unless_zero(self.accuracy, 1e-6),
            unless_zero(self.interferer_hz, 5.0),
            self.vref_v,
            delay_s,
            speed_mm_s,
            length_mm,
            pitch_mm,
            edge_phase_rad,
            edge_phase_sigma_rad,
            period_least_mm,
            period_most_mm,
            (may_go_forward || may_go_backward) as u8 as f32,
            twice as f32,
            unless_zero(self.feel.volts_per_um, 1e-9),
            self.feel.sigma_share,
            self.feel.force_ratio,
        ];
        within(&BOUNDS, &values)?;
        within(
            &[("period_most_mm", period_least_mm, PERIOD_GREATEST_MM)],
            &[period_most_mm],
        )
    }
}

/// Least hop, seconds.
pub const HOP_LEAST_S: f32 = 0.02;
/// Least bound of the longest hop, seconds: short windows may be far apart.
const HOP_LEAST_MOST_S: f32 = 1.0;
/// Greatest possible spatial period, millimetres.
const PERIOD_GREATEST_MM: f32 = 100.0;

/// Names, least and greatest values, in the order of the values in `Settings::check`. A table,
/// because one call for each field takes a kilobyte of flash more.
const BOUNDS: [Bounds; 17] = [
    ("harmonics", 1.0, 5.0),
    // With a tenth the fit calls the window too short; no crystal has a millionth.
    ("accuracy", 1e-6, 0.1),
    // Mains are 50 or 60 Hz; below 5 Hz an interferer cannot be distinguished from drift.
    ("interferer_hz", 5.0, 1000.0),
    ("vref_v", 0.5, 5.5),
    ("delay_s", 0.0, 60.0),
    ("speed_mm_s", 0.1, 2000.0),
    ("length_mm", 0.1, 2000.0),
    ("pitch_mm", 0.1, 100.0),
    ("edge_phase_rad", -PI, PI),
    ("edge_phase_sigma_rad", 0.0, PI),
    ("period_least_mm", 0.1, PERIOD_GREATEST_MM),
    ("period_most_mm", 0.1, PERIOD_GREATEST_MM),
    // With neither direction possible no travel has an answer.
    ("may_go_forward", 1.0, 1.0),
    ("alike", 0.0, 0.0),
    // From below a nanovolt, which is no reading, to the whole range.
    ("volts_per_um", 1e-9, 10.0),
    ("sigma_share", 0.0, 1.0),
    ("force_ratio", 0.0, 100.0),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_within_their_own_bounds() {
        assert_eq!(Settings::default().validate(), Ok(()));
    }

    #[test]
    fn the_field_outside_its_bounds_is_named() {
        let with = |array| Settings {
            array,
            ..Settings::DEFAULT
        };
        let feeling = |feel| Settings {
            feel,
            ..Settings::DEFAULT
        };
        for (settings, field) in [
            (
                Settings {
                    window_s: 5.0,
                    ..Settings::DEFAULT
                },
                "window_s",
            ),
            (
                Settings {
                    window_s: f32::NAN,
                    ..Settings::DEFAULT
                },
                "window_s",
            ),
            (
                Settings {
                    hop_s: 0.0,
                    ..Settings::DEFAULT
                },
                "hop_s",
            ),
            (
                Settings {
                    harmonics: 6,
                    ..Settings::DEFAULT
                },
                "harmonics",
            ),
            (
                Settings {
                    accuracy: 0.2,
                    ..Settings::DEFAULT
                },
                "accuracy",
            ),
            (
                Settings {
                    accuracy: f32::NAN,
                    ..Settings::DEFAULT
                },
                "accuracy",
            ),
            (
                Settings {
                    interferer_hz: -50.0,
                    ..Settings::DEFAULT
                },
                "interferer_hz",
            ),
            (
                Settings {
                    vref_v: 9.0,
                    ..Settings::DEFAULT
                },
                "vref_v",
            ),
            (
                with(Array {
                    pitch_mm: 0.0,
                    ..Array::DEFAULT
                }),
                "pitch_mm",
            ),
            (
                with(Array {
                    edge_phase_rad: 4.0,
                    ..Array::DEFAULT
                }),
                "edge_phase_rad",
            ),
            (
                with(Array {
                    edge_phase_sigma_rad: f32::NAN,
                    ..Array::DEFAULT
                }),
                "edge_phase_sigma_rad",
            ),
            (
                with(Array {
                    period_least_mm: 0.0,
                    ..Array::DEFAULT
                }),
                "period_least_mm",
            ),
            (
                with(Array {
                    period_least_mm: 5.0,
                    ..Array::DEFAULT
                }),
                "period_most_mm",
            ),
            (
                with(Array {
                    may_go_forward: false,
                    may_go_backward: false,
                    ..Array::DEFAULT
                }),
                "may_go_forward",
            ),
            (
                with(Array {
                    alike: [0x1111, 0x2222, 0x4444, 0x8889],
                    ..Array::DEFAULT
                }),
                "alike",
            ),
            (
                feeling(Feeling {
                    volts_per_um: -1.0,
                    ..Feeling::DEFAULT
                }),
                "volts_per_um",
            ),
            (
                feeling(Feeling {
                    sigma_share: f32::NAN,
                    ..Feeling::DEFAULT
                }),
                "sigma_share",
            ),
            (
                feeling(Feeling {
                    force_ratio: f32::INFINITY,
                    ..Feeling::DEFAULT
                }),
                "force_ratio",
            ),
            (
                Settings {
                    slide: SlideRule::Protocol {
                        delay_s: 1.0,
                        speed_mm_s: 0.0,
                        length_mm: 55.0,
                    },
                    ..Settings::DEFAULT
                },
                "speed_mm_s",
            ),
        ] {
            assert_eq!(
                settings
                    .validate()
                    .map_err(|error| error.field)
                    .unwrap_err(),
                field
            );
        }
        assert!(
            BOUNDS
                .iter()
                .all(|(field, ..)| String::<24>::try_from(*field).is_ok())
        );
    }

    #[test]
    fn windows_are_bounded_by_the_plan() {
        for (name, plan) in Plan::NAMED {
            let settings = Settings::DEFAULT.with_plan(plan);
            assert_eq!(settings.validate(), Ok(()), "{name}");
            let longer = Settings {
                window_s: plan.window_most_s() + 0.002,
                ..settings
            };
            assert_eq!(longer.validate().unwrap_err().field, "window_s", "{name}");
        }
        let settings = Settings {
            plan: Plan {
                inputs: 0,
                ..Plan::PAPER
            },
            ..Settings::DEFAULT
        };
        assert_eq!(settings.validate().unwrap_err().field, "inputs");
        assert_eq!(Settings::DEFAULT.with_plan(Plan::PAPER), Settings::DEFAULT);
    }
}
