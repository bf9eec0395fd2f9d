//! Scenes that are declared to a fit, and the noise that each is judged with.

use ridgetone_proto::settings::Declared;

/// Windows, seconds.
pub const SCENES_S: [f64; 4] = [0.2, 0.4, 1.0, 3.9];

/// What is fitted.
pub struct Setup {
    /// How a user sets it.
    pub name: &'static str,
    pub declared: Declared,
    pub harmonics: u8,
    /// The name of a cell of noise that has what is left out, or what is added.
    pub cell: Option<&'static str>,
}

pub const DEFAULT: Setup = Setup {
    name: "default: four harmonics",
    declared: Declared::DEFAULT,
    harmonics: 4,
    cell: None,
};

/// All scenes that are measured.
pub const SCENES: [Setup; 8] = [
    DEFAULT,
    Setup {
        name: "`harmonics = 1`",
        harmonics: 1,
        cell: Some("white"),
        ..DEFAULT
    },
    Setup {
        name: "`scene.curved_baseline = false`",
        declared: Declared {
            curved_baseline: false,
            ..Declared::DEFAULT
        },
        cell: Some("white, logarithmic creep of 30 amplitudes"),
        ..DEFAULT
    },
    Setup {
        name: "`scene.coloured_noise = false`",
        declared: Declared {
            coloured_noise: false,
            ..Declared::DEFAULT
        },
        cell: Some("AR(1) of 0.9"),
        ..DEFAULT
    },
    Setup {
        name: "`scene.shared_noise = false`",
        declared: Declared {
            shared_noise: false,
            ..Declared::DEFAULT
        },
        cell: Some("pink, the same in all channels"),
        ..DEFAULT
    },
    Setup {
        name: "`scene.impulses = false`",
        declared: Declared {
            impulses: false,
            ..Declared::DEFAULT
        },
        cell: Some("impulses: 1 % of 20 sigma"),
        ..DEFAULT
    },
    Setup {
        name: "`scene.moving_speed = true`",
        declared: Declared {
            moving_speed: true,
            ..Declared::DEFAULT
        },
        cell: Some("wander of 0.5 %"),
        ..DEFAULT
    },
    Setup {
        name: "lean: one harmonic, all four false",
        declared: Declared {
            overtones: false,
            curved_baseline: false,
            coloured_noise: false,
            shared_noise: false,
            moving_speed: false,
            impulses: false,
        },
        harmonics: 1,
        cell: None,
    },
];
