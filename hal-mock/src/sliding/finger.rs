//! Physical model of the fingertip: the response of its sixteen channels to a grating on its cover.
//!
//! Each ridge presses evenly on the cover over its width, under a contact of finite length, and
//! friction drags along with it. The strain at a sensor is the sum of the ridges' line loads
//! ([`line_load`](super::line_load)). For a periodic grating it is periodic in the grating's
//! position x: a Fourier series with the coefficients
//!
//! > c_h integral of strain(sensor - s) pressure(s) exp(i h k s) ds,
//!
//! where c_h are the coefficients of the ridges' profile. Overtones, the cover's low-pass and the
//! phase between the units follow from this. Under a long contact the coefficients approach the
//! strain of a sinusoidal load, which fades as exp(-h k depth).
//!
//! A ridged skin touches only with its ridges. Each ridge takes all pressure on its top and passes
//! it on evenly over its width: s in the exponent is then the middle of the skin's ridge, the
//! coefficients are averaged over its width, and nothing passes between two ridges. So the skin
//! samples the grating. If both periods are nearly equal, all ridges of the skin stand on ridges or
//! over grooves almost at once: the load varies along the skin with the beat of the two, which is
//! long enough to reach the sensors. The height is held, not the load: where the skin's ridges fall
//! into grooves all over the contact, there is little or no pressure.
//!
//! AIN 4 u + k is piezoresistor k + 1 of unit u + 1. Units 1 and 3 are half a pitch behind the
//! middle of the contact, 2 and 4 half a pitch ahead, seen along +x: the direction of the slide
//! unless `reverse`.

use super::channel::{Channel, Harmonic, PITCH_MM, Pattern};
use super::kelvin::KelvinBody;
use super::line_load::{Material, Strain};
use super::range::{Range, Rule};
use crate::random::{Random, Stream};
use crate::scene::INPUTS;
use core::f64::consts::{PI, TAU};

/// The fingertip, its load and its circuit. The defaults are from the paper or marked as plausible.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Finger {
    /// Seed of the differences between piezoresistors; the same seed makes the same finger. Default
    /// 1.
    pub finger_seed: u64,
    /// Thickness of the cover over the sensors in mm, > 0. Default 1.3 (paper, section 2.2).
    pub depth_mm: f64,
    /// Young's modulus of the cover in MPa, > 0. Default 1.7: shore A 40 (paper, section 2.2) by
    /// Gent's relation.
    pub modulus_mpa: f64,
    /// Poisson's ratio of the cover, 0 to 0.5. Default 0.5: rubber.
    pub poisson: f64,
    /// Time constants of the cover as a Kelvin body in seconds, > 0, relaxation <= creep. Default
    /// 2.85 and 3: the "very small viscoelastic effect" of a rubber layer (Moy et al., figure 29);
    /// plausible.
    pub relaxation_s: f64,
    /// See `relaxation_s`.
    pub creep_s: f64,
    /// Normal force in N, > 0. Default 1 (paper, section 3.1).
    pub force_n: f64,
    /// Relative overshoot of the force at the touch, >= 0. Default 0.6: plausible.
    pub overshoot: f64,
    /// Friction: tangential over normal force at full slip, >= 0. Default 0.5: plausible.
    pub friction: f64,
    /// Distance by which friction drags the middle of the contact along at full slip, in mm, 0 to
    /// half of `contact_mm`. It makes the units at the grating's leading edge the stronger ones, as
    /// in the paper (section 5). Default 0.5: plausible.
    pub lean_mm: f64,
    /// Length of the contact along the slide in mm, > 0, at least a groove's width. Default 8:
    /// plausible.
    pub contact_mm: f64,
    /// Width of the skin's ridges in mm, 0 to half of `contact_mm`. The grooves between them have
    /// the same width, and one ridge is over the middle of the array. Default 0: a smooth skin, as
    /// in the paper.
    pub skin_ridge_mm: f64,
    /// Relative change of resistance per unit of shear, > 0. Default 0.2: plausible, produces tones
    /// of a few millivolts.
    pub sensitivity: f64,
    /// Sensitivity to normal strain relative to shear, >= 0. Default 0.5: plausible.
    pub normal_share: f64,
    /// Maximum relative deviation of a sensitivity from nominal, 0 to 0.99. Default 0.15:
    /// plausible.
    pub spread: f64,
    /// Supply of the quarter bridges in V, > 0. Default 5 (paper, section 2.3).
    pub supply_v: f64,
    /// Completion resistor in ohm, > 0. Default 820 (paper, section 2.3), also the mean of the
    /// piezoresistors.
    pub resistor_ohm: f64,
    /// Maximum relative deviation of a piezoresistor from `resistor_ohm`, 0 to 0.99. Default 0.02:
    /// plausible.
    pub resistance_spread: f64,
    /// Capacitor of the bridge's filter in uF, > 0. Default 1 (paper, section 2.3): a pole near 390
    /// Hz.
    pub capacitor_uf: f64,
    /// White noise of the bridge in uV RMS, >= 0, used without `snr_db`. Default 0.064: thermal, (k
    /// T / C)^1/2.
    pub noise_uv: f64,
}

impl Default for Finger {
    fn default() -> Self {
        Self {
            finger_seed: 1,
            depth_mm: 1.3,
            modulus_mpa: 1.7,
            poisson: 0.5,
            relaxation_s: 2.85,
            creep_s: 3.0,
            force_n: 1.0,
            overshoot: 0.6,
            friction: 0.5,
            lean_mm: 0.5,
            contact_mm: 8.0,
            skin_ridge_mm: 0.0,
            sensitivity: 0.2,
            normal_share: 0.5,
            spread: 0.15,
            supply_v: 5.0,
            resistor_ohm: 820.0,
            resistance_spread: 0.02,
            capacitor_uf: 1.0,
            noise_uv: 0.064,
        }
    }
}

/// The grating on the finger, with the meanings and units of [`Sliding`](crate::Sliding).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grating {
    pub(crate) period_mm: f64,
    pub(crate) ridge_mm: f64,
    pub(crate) start_mm: f64,
    pub(crate) reverse: bool,
}

/// Harmonics of a channel. Higher ones are less than a thousandth of the fundamental for the
/// paper's gratings; under a ridged skin a hundredth of the load, at frequencies where the bridge's
/// filter removes most of them.
const HARMONICS: usize = 24;

/// Points of the integral over the contact: its error is a millionth of the tone.
const POINTS: u32 = 2000;

/// Fourier series of the strain at a sensor: real and imaginary parts of the coefficients, the mean
/// first.
type Series = [(Strain, Strain); HARMONICS + 1];

impl Finger {
    /// The skin as a viscoelastic body at rest.
    pub(crate) fn skin(&self) -> KelvinBody {
        KelvinBody::new(self.relaxation_s, self.creep_s)
    }

    /// Time constant of the bridge and its capacitor, seconds. The capacitor sees both resistors in
    /// parallel.
    pub(crate) fn filter_s(&self) -> f64 {
        0.5 * self.resistor_ohm * self.capacitor_uf * 1e-6
    }

    pub(crate) fn rules(&self) -> [Rule; 20] {
        [
            ("depth_mm", self.depth_mm, Range::Positive),
            ("modulus_mpa", self.modulus_mpa, Range::Positive),
            ("poisson", self.poisson, Range::Between(0.0, 0.5)),
            ("relaxation_s", self.relaxation_s, Range::Positive),
            ("creep_s", self.creep_s, Range::Positive),
            (
                "relaxation_s",
                self.relaxation_s,
                Range::UpTo(self.creep_s, "creep_s"),
            ),
            ("force_n", self.force_n, Range::Positive),
            ("overshoot", self.overshoot, Range::NotNegative),
            ("friction", self.friction, Range::NotNegative),
            ("contact_mm", self.contact_mm, Range::Positive),
            (
                "lean_mm",
                self.lean_mm,
                Range::UpTo(0.5 * self.contact_mm, "contact_mm / 2"),
            ),
            (
                "skin_ridge_mm",
                self.skin_ridge_mm,
                Range::UpTo(0.5 * self.contact_mm, "contact_mm / 2"),
            ),
            ("sensitivity", self.sensitivity, Range::Positive),
            ("normal_share", self.normal_share, Range::NotNegative),
            ("spread", self.spread, Range::Between(0.0, 0.99)),
            ("supply_v", self.supply_v, Range::Positive),
            ("resistor_ohm", self.resistor_ohm, Range::Positive),
            (
                "resistance_spread",
                self.resistance_spread,
                Range::Between(0.0, 0.99),
            ),
            ("capacitor_uf", self.capacitor_uf, Range::Positive),
            ("noise_uv", self.noise_uv, Range::NotNegative),
        ]
    }

    pub(crate) fn channels(&self, grating: Grating) -> [Channel; INPUTS] {
        let (slip, lean_mm) = if grating.reverse {
            (-self.friction, -self.lean_mm)
        } else {
            (self.friction, self.lean_mm)
        };
        let columns = [-0.5, 0.5].map(|pitches| {
            let at_mm = pitches * PITCH_MM;
            [
                self.series(grating, at_mm, 0.0, 0.0),
                self.series(grating, at_mm, slip, lean_mm),
            ]
        });
        let mut random = Random::new(self.finger_seed, Stream::Skin);
        std::array::from_fn(|input| {
            // Piezoresistors 1 and 3 are on opposite sides of the mesa: shear tilts it and
            // stretches one of them while it compresses the other. Pressure affects all four alike.
            let tilt = [1.0, 0.0, -1.0, 0.0][input % 4];
            let gain = self.sensitivity * (1.0 + self.spread * random.symmetric());
            let resistance = 1.0 + self.resistance_spread * random.symmetric();
            let offset_v = self.supply_v / (1.0 + resistance);
            // Change of the divider's voltage per relative change of one of its two nearly equal
            // resistors.
            let volts = 0.25 * self.supply_v * gain;
            let felt =
                |strain: Strain| volts * (tilt * strain.shear + self.normal_share * strain.normal);
            let [resting, sliding] = columns[(input / 4) % 2]
                .each_ref()
                .map(|series| pattern(series, felt));
            let mut channel = Channel {
                offset_v,
                drag: sliding.less(&resting),
                sliding,
                spike_v: 0.0,
            };
            channel.spike_v =
                self.overshoot * channel.loaded_v(grating.start_mm / grating.period_mm, 0.0);
            channel
        })
    }

    /// Series of the strain at a sensor `at_mm` ahead of the middle of the array, under a pressure
    /// with its middle at `lean_mm` and a tangential load of `slip` times the pressure.
    fn series(&self, grating: Grating, at_mm: f64, slip: f64, lean_mm: f64) -> Series {
        let material = Material {
            modulus_mpa: self.modulus_mpa,
            poisson: self.poisson,
        };
        let (half_mm, step_mm) = (0.5 * self.contact_mm, self.contact_mm / f64::from(POINTS));
        // Pressure of a round Hertzian contact, integrated across the slide: a parabola along it,
        // with the mean width of a circle.
        let peak_n_mm = 1.5 * self.force_n / (self.contact_mm * (0.25 * PI * self.contact_mm));
        let turn = TAU / grating.period_mm;
        let mut series = Series::default();
        for point in 0..POINTS {
            let off_mm = (f64::from(point) + 0.5) * step_mm - half_mm;
            let s_mm = lean_mm + off_mm;
            let load = peak_n_mm * (1.0 - (off_mm / half_mm) * (off_mm / half_mm)) * step_mm;
            let Some((felt_mm, fraction)) = self.borne(s_mm) else {
                continue;
            };
            let load = fraction * load;
            let pressed = material.pressed(at_mm - s_mm, self.depth_mm);
            let dragged = material.dragged(at_mm - s_mm, self.depth_mm);
            let normal = load * (pressed.normal + slip * dragged.normal);
            let shear = load * (pressed.shear + slip * dragged.shear);
            for (h, (real, imaginary)) in series.iter_mut().enumerate() {
                let averaged = |width_mm: f64| sinc(h as f64 * PI * width_mm / grating.period_mm);
                let profile = if h == 0 {
                    1.0
                } else {
                    2.0 * averaged(grating.ridge_mm) * averaged(self.skin_ridge_mm)
                };
                let (sin, cos) = libm::sincos(h as f64 * turn * felt_mm);
                real.normal += profile * cos * normal;
                real.shear += profile * cos * shear;
                imaginary.normal += profile * sin * normal;
                imaginary.shear += profile * sin * shear;
            }
        }
        series
    }

    /// Returns the position to which the skin passes on the load at a point, the middle of the
    /// skin's ridge, and the load relative to a smooth skin; `None` in a groove.
    fn borne(&self, s_mm: f64) -> Option<(f64, f64)> {
        if self.skin_ridge_mm == 0.0 {
            return Some((s_mm, 1.0));
        }
        let pitch_mm = 2.0 * self.skin_ridge_mm;
        let middle_mm = pitch_mm * libm::round(s_mm / pitch_mm);
        ((s_mm - middle_mm).abs() < 0.5 * self.skin_ridge_mm).then_some((middle_mm, 2.0))
    }
}

/// A channel's pattern from the strain's series: Re(c exp(-i h k x)) is Re(c) cos(h k x) + Im(c)
/// sin(h k x).
fn pattern(series: &Series, felt: impl Fn(Strain) -> f64) -> Pattern {
    let [mean, tone @ ..] = series;
    let harmonic = |(real, imaginary): &(Strain, Strain)| Harmonic {
        cos_v: felt(*real),
        sin_v: felt(*imaginary),
    };
    Pattern {
        mean_v: felt(mean.0),
        tone: tone.iter().map(harmonic).collect(),
    }
}

/// sin(x) / x for x >= 0.
fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::sin(x) / x }
}
