//! What two elastic layers pass on: Table 1, Figures 12 and 16.

use ridgetone_teletaction::display::half_plane::{
    normal_wave, strain_without_shear, tangential_wave,
};
use std::f64::consts::{PI, TAU};

/// Poisson's ratio of an incompressible material (equation 3).
pub const RUBBER: f64 = 0.5;

/// Layers of Table 1: z = d/2 = 2, so d = 4, millimetres.
const TABLE_1_MM: f64 = 2.0;

/// Contacts of Table 1, each over its whole pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    Line,
    /// An even pressure.
    Block,
    /// A pressure like a semi-ellipse (Hertz).
    Cylinder,
}

/// Half of the block's and the cylinder's width, millimetres.
const HALF_WIDTH_MM: f64 = 10.0;

/// Rows of Table 1: contact, angle to the normal in degrees, the paper's signal-to-noise ratio in
/// decibels.
pub const TABLE_1: [(Contact, f64, f64); 6] = [
    (Contact::Line, 0.0, 16.0),
    (Contact::Line, 30.0, 11.0),
    (Contact::Block, 0.0, 19.0),
    (Contact::Block, 30.0, 7.0),
    (Contact::Cylinder, 0.0, 19.0),
    (Contact::Cylinder, 30.0, 8.0),
];

impl Contact {
    pub const fn name(self) -> &'static str {
        match self {
            Self::Line => "line",
            Self::Block => "block, 20 wide",
            Self::Cylinder => "cylinder, 20 wide",
        }
    }

    /// Share of the load at a wave number, radians per millimetre.
    fn spectrum(self, k: f64) -> f64 {
        let half = k * HALF_WIDTH_MM;
        match self {
            _ if half == 0.0 => 1.0,
            Self::Line => 1.0,
            Self::Block => libm::sin(half) / half,
            Self::Cylinder => 2.0 * libm::j1(half) / half,
        }
    }
}

/// Sum over wave numbers above 0, by the rule of midpoints: the domain is infinite, since under an
/// oblique load strain fades only as 1 / x.
fn over_waves(step: f64, most: f64, f: impl Fn(f64) -> f64) -> f64 {
    (0..(most / step) as usize)
        .map(|n| f((n as f64 + 0.5) * step) * step)
        .sum()
}

/// Signal-to-noise ratio (equation 12) in decibels, without sampling, if shear stress does not
/// cross the interface of two layers.
pub fn table_1(contact: Contact, degrees: f64, poisson: f64) -> f64 {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let (interface, depth) = (TABLE_1_MM, 2.0 * TABLE_1_MM);
    let parts = |k: f64| {
        let load = contact.spectrum(k);
        let whole = [
            cos * normal_wave(k, depth).strain(poisson),
            sin * tangential_wave(k, depth).strain(poisson),
        ];
        let second = normal_wave(k, interface).strain(poisson);
        let cut = [
            cos * normal_wave(k, interface).z * second,
            sin * tangential_wave(k, interface).z * second,
        ];
        (
            load * load * squared(whole),
            load * load * squared([whole[0] - cut[0], whole[1] - cut[1]]),
        )
    };
    let sum = |part: fn((f64, f64)) -> f64| over_waves(5e-4, 12.0, |k| part(parts(k)));
    decibels(sum(|parts| parts.0) / sum(|parts| parts.1))
}

fn squared([a, b]: [f64; 2]) -> f64 {
    a * a + b * b
}

fn decibels(ratio: f64) -> f64 {
    10.0 * libm::log10(ratio)
}

/// Layers of Figure 12: 1 mm and, with the 0.7 mm of skin over the receptors, 1.7 mm.
pub const FIGURE_12_MM: (f64, f64) = (1.0, 1.7);

/// Strain over the load, relative to that of an even load, at cycles per millimetre: with and
/// without shear.
pub fn figure_12(cycles_mm: f64) -> (f64, f64) {
    let k = TAU * cycles_mm;
    let (first, second) = FIGURE_12_MM;
    let even = normal_wave(0.0, first).strain(RUBBER);
    let with = normal_wave(k, first + second).strain(RUBBER);
    (
        with / even,
        strain_without_shear(k, first, second, RUBBER) / even,
    )
}

/// How a display makes a profile of samples: the paper's text does not say which.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// A line load at each sample.
    Impulses,
    /// Pins half as wide as their distance.
    HalfPins,
    /// Pins as wide as their distance.
    Hold,
    /// Straight lines from sample to sample.
    Linear,
    /// All below half of the sampling frequency, nothing above.
    LowPass,
}

impl Filter {
    pub const ALL: [Self; 5] = [
        Self::Linear,
        Self::Hold,
        Self::Impulses,
        Self::HalfPins,
        Self::LowPass,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Impulses => "line loads",
            Self::HalfPins => "pins of half the spacing",
            Self::Hold => "pins of the whole spacing",
            Self::Linear => "straight lines",
            Self::LowPass => "ideal low-pass",
        }
    }

    fn pass(self, k: f64, spacing: f64) -> f64 {
        let sinc = |x: f64| if x == 0.0 { 1.0 } else { libm::sin(x) / x };
        match self {
            Self::Impulses => 1.0,
            Self::HalfPins => sinc(0.25 * k * spacing),
            Self::Hold => sinc(0.5 * k * spacing),
            Self::Linear => sinc(0.5 * k * spacing) * sinc(0.5 * k * spacing),
            Self::LowPass => f64::from(k * spacing < PI),
        }
    }
}

/// Phases of sampling that are tried: half of a spacing, since the other half is its mirror image.
const PHASES: u32 = 8;

/// Wave numbers of the integral, per thickness of a layer: at the most exp(-14) of a load is left.
const WAVES: (f64, f64) = (0.02, 14.0);

/// Signal-to-noise ratio of a normal line load in decibels at the worst phase of sampling, for a
/// spacing over the thickness of one layer of two that are alike (Figure 16).
pub fn figure_16(ratio: f64, filter: Filter, with_shear: bool) -> f64 {
    let phases = (0..=PHASES).map(|phase| 0.5 * f64::from(phase) / f64::from(PHASES));
    phases
        .map(|phase| sampled(ratio, filter, with_shear, phase))
        .fold(f64::INFINITY, f64::min)
}

fn sampled(spacing: f64, filter: Filter, with_shear: bool, phase: f64) -> f64 {
    let turn = TAU / spacing;
    let images = (2.0 * WAVES.1 / turn) as i32 + 1;
    let noise = |k: f64| {
        // Complex amplitudes of the samples: of pressure, and of shear, which is a quarter of a
        // turn behind.
        let (mut pressure, mut shear) = ([0.0; 2], [0.0; 2]);
        for image in -images..=images {
            let stress = normal_wave(k + turn * f64::from(image), 1.0);
            let (sin, cos) = libm::sincos(TAU * phase * f64::from(image));
            pressure[0] += stress.z * cos;
            pressure[1] += stress.z * sin;
            shear[0] += stress.xz * cos;
            shear[1] += stress.xz * sin;
        }
        let pass = filter.pass(k, spacing);
        let by_pressure = pass * normal_wave(k, 1.0).strain(RUBBER);
        let by_shear = if with_shear {
            -pass * tangential_wave(k, 1.0).strain(RUBBER)
        } else {
            0.0
        };
        let made = [0, 1].map(|part| by_pressure * pressure[part] + by_shear * shear[part]);
        squared([made[0] - normal_wave(k, 2.0).strain(RUBBER), made[1]])
    };
    let signal = over_waves(WAVES.0, WAVES.1, |k| {
        normal_wave(k, 2.0).strain(RUBBER).powi(2)
    });
    decibels(signal / over_waves(WAVES.0, WAVES.1, noise))
}

/// Spacing over depth from which on shear stress is of no more use, up to 3; none if it always is.
pub fn crossing(filter: Filter) -> Option<f64> {
    let gain = |ratio: f64| figure_16(ratio, filter, true) - figure_16(ratio, filter, false);
    let (mut below, mut above) = (0.3, 0.3);
    while gain(above) > 0.0 {
        (below, above) = (above, above + 0.1);
        if above > 3.0 {
            return None;
        }
    }
    for _ in 0..12 {
        let middle = 0.5 * (below + above);
        if gain(middle) > 0.0 {
            below = middle
        } else {
            above = middle
        }
    }
    Some(0.5 * (below + above))
}
