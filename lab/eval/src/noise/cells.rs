//! The cells: what is in the windows, and what share of the answers may be wrong.

use super::parts::{Extra, Speed, Tone};
use super::process::Noise;
use super::window::Recipe;
use ridgetone_host::names::name;
use serde::{Deserialize, Serialize};

/// Windows that every group is measured on, seconds.
pub const WINDOWS_S: [f64; 4] = [0.2, 0.4, 1.0, 3.9];

/// What a group's answers are judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// There is no tone: a good answer is wrong.
    NoTone,
    /// A tone and something else: a good answer off by more than 5 % is wrong.
    Something,
    /// A tone in noise: intervals hold the truth.
    Sigma,
    /// Few cycles: a good answer off by more than 5 % is wrong.
    FewCycles,
    /// The speed is not steady: intervals hold the mean, or the answer is `unsteady`.
    Unsteady,
    /// White noise: the error over the bound by cycles in the window, with and without a drift.
    Accuracy,
}

impl Group {
    pub const ALL: [Self; 6] = [
        Self::NoTone,
        Self::Something,
        Self::Sigma,
        Self::Accuracy,
        Self::FewCycles,
        Self::Unsteady,
    ];

    /// As in the data and in arguments.
    pub fn name(self) -> &'static str {
        name(self)
    }
}

/// One row of a table.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    pub group: Group,
    pub name: &'static str,
    pub recipe: Recipe,
    /// The number of its windows over that of the other cells.
    pub times: u32,
}

/// The cell of recordings that the user names.
pub const REAL: &str = "a recording without a tone";

/// One harmonic.
const SINE: [f64; 5] = [1.0, 0.0, 0.0, 0.0, 0.0];
/// The simulated finger's.
const RIDGES: [f64; 5] = [1.0, 0.4, 0.2, 0.1, 0.0];
/// Least and most cycles of a tone that only its noise makes hard.
const CYCLES: (f64, f64) = (1.6, f64::INFINITY);

const fn tone(harmonics: [f64; 5], snr_db: f64) -> Tone {
    Tone {
        cycles: CYCLES,
        harmonics,
        snr_db,
        speed: Speed::Steady,
    }
}

/// All cells; of real noise where there are recordings.
pub fn cells(real: Option<Noise>) -> Vec<Cell> {
    let cell = |group, name, noise, tone, extra| Cell {
        group,
        name,
        recipe: Recipe { noise, tone, extra },
        times: 1,
    };
    let without = |name, noise, extra| cell(Group::NoTone, name, noise, None, extra);
    let with = |group, name, noise, tone, extra| cell(group, name, noise, Some(tone), extra);
    let something = |name, harmonics, extra| {
        with(
            Group::Something,
            name,
            Noise::White,
            tone(harmonics, 20.0),
            extra,
        )
    };
    let mut cells = vec![
        without("white", Noise::White, Extra::Nothing),
        without("impulses: 1 % of 20 sigma", Noise::Impulses, Extra::Nothing),
        Cell {
            times: 10,
            ..without(
                "one relaxation of 100 sigma",
                Noise::White,
                Extra::Relaxations(1, 100.0),
            )
        },
        without(
            "two relaxations of 100 sigma",
            Noise::White,
            Extra::Relaxations(2, 100.0),
        ),
        without(
            "logarithmic creep of 30 sigma",
            Noise::White,
            Extra::LogCreep(30.0),
        ),
        without("one step of 10 sigma", Noise::White, Extra::Step(10.0)),
        without("one bump of 10 sigma", Noise::White, Extra::Bump(10.0)),
        without(
            "a contact spike's tail of 30 sigma",
            Noise::White,
            Extra::Spike(30.0),
        ),
        without("pink", Noise::Pink, Extra::Nothing),
        without("AR(1) of 0.9", Noise::Ar(0.9), Extra::Nothing),
        without(
            "pink, the same in all channels",
            Noise::SharedPink,
            Extra::Nothing,
        ),
        without(
            "pink, shared with random phases",
            Noise::SharedPhases,
            Extra::Nothing,
        ),
        without(
            "random walk, the same in all channels",
            Noise::SharedWalk,
            Extra::Nothing,
        ),
        without(
            "narrow band, shared with random phases",
            Noise::NarrowBand,
            Extra::Nothing,
        ),
        without(
            "mains of 30 sigma at 49.5 Hz, 50 Hz given",
            Noise::White,
            Extra::Mains(30.0),
        ),
        something("nothing else", RIDGES, Extra::Nothing),
        something("a step of 3 amplitudes", RIDGES, Extra::Step(3.0)),
        something("a bump of 3 amplitudes", RIDGES, Extra::Bump(3.0)),
        something("a contact spike of 3 amplitudes", RIDGES, Extra::Spike(3.0)),
        something(
            "a relaxation of 10 amplitudes",
            RIDGES,
            Extra::Relaxations(1, 10.0),
        ),
        something("the tone begins halfway", RIDGES, Extra::HalfTone),
        something("the tone falls tenfold", RIDGES, Extra::Decay),
        something("a second tone as strong", SINE, Extra::SecondTone),
        something(
            "mains of 3 amplitudes at 49.5 Hz, 50 Hz given",
            RIDGES,
            Extra::Mains(3.0),
        ),
        something(
            "harmonics 1, 3, 5 of 0.3, 1, 0.4",
            [0.3, 0.0, 1.0, 0.0, 0.4],
            Extra::Nothing,
        ),
        something(
            "two tones as strong, 0.4 to 0.8 cycles a window apart",
            SINE,
            Extra::CloseTone(0.4, 0.8),
        ),
        something(
            "a fundamental of 0.05 of the second",
            [0.05, 1.0, 0.2, 0.1, 0.0],
            Extra::Nothing,
        ),
        something(
            "harmonics 1, 2, 4 of 0.03, 1, 0.4",
            [0.03, 1.0, 0.0, 0.4, 0.0],
            Extra::Nothing,
        ),
        something(
            "harmonics 1, 2, 4 of 0.02, 1, 0.4",
            [0.02, 1.0, 0.0, 0.4, 0.0],
            Extra::Nothing,
        ),
    ];
    cells.extend(real.map(|noise| without(REAL, noise, Extra::Nothing)));
    let real = real.map(|noise| (REAL, noise, Extra::Nothing));
    let sigma = [
        ("white", Noise::White, Extra::Nothing),
        (
            "white, logarithmic creep of 30 amplitudes",
            Noise::White,
            Extra::LogCreep(30.0),
        ),
        ("impulses: 1 % of 20 sigma", Noise::Impulses, Extra::Nothing),
        ("pink", Noise::Pink, Extra::Nothing),
        ("AR(1) of 0.6", Noise::Ar(0.6), Extra::Nothing),
        ("AR(1) of 0.9", Noise::Ar(0.9), Extra::Nothing),
        (
            "pink, the same in all channels",
            Noise::SharedPink,
            Extra::Nothing,
        ),
        (
            "pink, shared with random phases",
            Noise::SharedPhases,
            Extra::Nothing,
        ),
        (
            "rounded to a third of the amplitude",
            Noise::White,
            Extra::Rounded(0.33),
        ),
        ("gains over four decades", Noise::White, Extra::Gains),
        (
            "three dead channels, two without a tone",
            Noise::White,
            Extra::DeadChannels,
        ),
        (
            "three channels clipped at a rail, two that stay there",
            Noise::White,
            Extra::Saturated,
        ),
    ];
    for (name, noise, extra) in sigma.into_iter().chain(real) {
        cells.push(with(Group::Sigma, name, noise, tone(RIDGES, 20.0), extra));
        cells.push(with(Group::Sigma, name, noise, tone(RIDGES, 10.0), extra));
    }
    let relaxation = Extra::Relaxations(1, 2.0 / 3.0);
    for (name, cycles, extra) in [
        ("1 to 1.5 cycles", (1.0, 1.5), Extra::Nothing),
        (
            "1 to 1.5 cycles, a relaxation of up to one amplitude",
            (1.0, 1.5),
            relaxation,
        ),
        ("from 1.5 cycles on", (1.5, f64::INFINITY), Extra::Nothing),
        (
            "from 1.5 cycles on, a relaxation of up to one amplitude",
            (1.5, f64::INFINITY),
            relaxation,
        ),
    ] {
        for snr_db in [20.0, 10.0] {
            let tone = Tone {
                cycles,
                ..tone(RIDGES, snr_db)
            };
            cells.push(with(Group::Accuracy, name, Noise::White, tone, extra));
        }
    }
    for (name, cycles) in [
        ("0.5", 0.5),
        ("0.6", 0.6),
        ("0.7", 0.7),
        ("0.8", 0.8),
        ("0.9", 0.9),
        ("1", 1.0),
        ("1.25", 1.25),
        ("1.5", 1.5),
    ] {
        let tone = Tone {
            cycles: (cycles, cycles),
            ..tone(RIDGES, 20.0)
        };
        cells.push(with(
            Group::FewCycles,
            name,
            Noise::White,
            tone,
            Extra::Nothing,
        ));
    }
    for (name, cycles, channels) in [
        ("0.4, four channels", 0.4, 4),
        ("0.5, four channels", 0.5, 4),
        ("0.7, four channels", 0.7, 4),
        ("0.9, four channels", 0.9, 4),
        ("2, four channels", 2.0, 4),
        ("0.4, one channel", 0.4, 1),
        ("0.5, one channel", 0.5, 1),
        ("0.7, one channel", 0.7, 1),
        ("0.9, one channel", 0.9, 1),
        ("2, one channel", 2.0, 1),
    ] {
        let tone = Tone {
            cycles: (cycles, cycles),
            ..tone(RIDGES, 20.0)
        };
        cells.push(with(
            Group::FewCycles,
            name,
            Noise::White,
            tone,
            Extra::Channels(channels),
        ));
    }
    for (name, speed) in [
        ("wander of 0.5 %", Speed::Wander(0.005)),
        ("wander of 2 %", Speed::Wander(0.02)),
        ("wander of 5 %", Speed::Wander(0.05)),
        ("chirp of 5 %", Speed::Chirp(0.05)),
        ("chirp of 15 %", Speed::Chirp(0.15)),
    ] {
        cells.push(with(
            Group::Unsteady,
            name,
            Noise::White,
            Tone {
                speed,
                ..tone(RIDGES, 20.0)
            },
            Extra::Nothing,
        ));
    }
    cells
}
