//! Noise processes of sixteen channels, mean square 1 in each, at any frame rate.

use super::autoregressions::Autoregressions;
use crate::bound::{orthonormal, remove};
use crate::draw::Draw;
use ridgetone_proto::settings::TAXELS;
use std::f64::consts::TAU;

/// Corner frequencies of the relaxations that add up to pink noise, hertz: half a decade apart.
const PINK_CORNERS_HZ: [f64; 7] = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0];
/// Share of the power that is white and independent under a disturbance that all channels share.
const FLOOR: f64 = 0.01;
/// Share of samples that an impulse hits, and its size in standard deviations.
const IMPULSES: (f64, f64) = (0.01, 20.0);

/// What the channels' noise is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    White,
    /// White, and one sample of a hundred is off by twenty standard deviations.
    Impulses,
    /// Power as 1 / f, independent in each channel.
    Pink,
    /// Autoregressive of the first order, independent in each channel.
    Ar(f64),
    /// A pink disturbance, the same in all channels but for a gain of 0.5 to 1.5.
    SharedPink,
    /// A pink disturbance that reaches each channel with a phase of its own.
    SharedPhases,
    /// A random walk, the same in all channels but for a gain.
    SharedWalk,
    /// A vibration of 3 to 30 Hz, a tenth of its frequency wide, with a phase of its own in each
    /// channel.
    NarrowBand,
    /// What some recordings without a tone hold, less level and slope: each window from a place of
    /// its own.
    Real(&'static [Vec<[f64; TAXELS]>]),
}

/// The covariance of the channels' noise.
#[derive(Clone, Debug, PartialEq)]
pub enum Covariance {
    /// Each channel has its own.
    Independent(Autoregressions),
    /// Two disturbances of one process reach each channel with gains; beside them white noise of a
    /// variance.
    Shared {
        process: Autoregressions,
        gains: Box<[[f64; 2]; TAXELS]>,
        white: f64,
    },
}

/// A process of one channel, sample after sample.
type Process<'a> = Box<dyn FnMut(&mut Draw) -> f64 + 'a>;

/// Frames of the noise, and their covariance where it has a closed form.
pub fn frames(
    noise: Noise,
    count: usize,
    rate_hz: f64,
    draw: &mut Draw,
) -> (Vec<[f64; TAXELS]>, Option<Covariance>) {
    type Make<'a> = &'a dyn Fn(&mut Draw) -> Process<'static>;
    let independent = |process: Make, parts: Vec<(f64, f64)>, white: f64, draw: &mut Draw| {
        let mut channels: Vec<_> = (0..TAXELS).map(|_| process(draw)).collect();
        let frames = (0..count)
            .map(|_| std::array::from_fn(|c| channels[c](draw)))
            .collect();
        (
            frames,
            Some(Covariance::Independent(Autoregressions { parts, white })),
        )
    };
    let shared = |process: Make, parts: Vec<(f64, f64)>, phases: bool, draw: &mut Draw| {
        let mut both = [process(draw), process(draw)];
        let gains: [[f64; 2]; TAXELS] = std::array::from_fn(|_| {
            let (gain, phase) = (draw.even(0.5, 1.5), draw.even(0.0, TAU));
            if phases {
                [gain * phase.cos(), gain * phase.sin()]
            } else {
                [gain, 0.0]
            }
        });
        let frame = |_| {
            let [a, b] = both.each_mut().map(|process| process(draw));
            std::array::from_fn(|c| {
                (1.0 - FLOOR).sqrt() * (gains[c][0] * a + gains[c][1] * b)
                    + FLOOR.sqrt() * draw.normal()
            })
        };
        let frames = (0..count).map(frame).collect();
        let parts: Vec<_> = parts
            .iter()
            .map(|(factor, variance)| (*factor, (1.0 - FLOOR) * variance))
            .collect();
        let process = Autoregressions { parts, white: 0.0 };
        let covariance = Covariance::Shared {
            gains: Box::new(gains),
            white: FLOOR,
            process,
        };
        (
            frames,
            Some(covariance).filter(|_| matches!(noise, Noise::SharedPink | Noise::SharedPhases)),
        )
    };
    let pink_parts = || {
        pink_factors(rate_hz)
            .map(|factor| (factor, 1.0 / PINK_CORNERS_HZ.len() as f64))
            .to_vec()
    };
    match noise {
        Noise::White => independent(&|_| Box::new(Draw::normal), Vec::new(), 1.0, draw),
        // The covariance of what is left without the impulses: they are known from the rest at a
        // glance.
        Noise::Impulses => independent(&|_| Box::new(impulses), Vec::new(), 1.0, draw),
        Noise::Pink => independent(&|draw| pink(rate_hz, draw), pink_parts(), 0.0, draw),
        Noise::Ar(phi) => independent(
            &|draw| autoregressive(phi, draw),
            vec![(phi, 1.0)],
            0.0,
            draw,
        ),
        Noise::SharedPink => shared(&|draw| pink(rate_hz, draw), pink_parts(), false, draw),
        Noise::SharedPhases => shared(&|draw| pink(rate_hz, draw), pink_parts(), true, draw),
        // Its mean square grows; over the window it is about 1.
        Noise::SharedWalk => {
            let step = (6.0 / count as f64).sqrt();
            shared(&|_| walk(step), Vec::new(), false, draw)
        }
        Noise::NarrowBand => {
            let centre = draw.log(3.0, 30.0) / rate_hz;
            shared(
                &|draw| resonance(centre, 0.1 * centre, draw),
                Vec::new(),
                true,
                draw,
            )
        }
        Noise::Real(recordings) => (real(recordings, count, draw), None),
    }
}

/// A piece of one of the recordings that are long enough, less level and slope, of mean square one
/// in each channel.
fn real(recordings: &[Vec<[f64; TAXELS]>], count: usize, draw: &mut Draw) -> Vec<[f64; TAXELS]> {
    let long: Vec<_> = recordings
        .iter()
        .filter(|recording| recording.len() >= count)
        .collect();
    let mut frames = vec![[0.0; TAXELS]; count];
    let Some(recording) = long.get(draw.whole(0, long.len().max(1) as u64 - 1) as usize) else {
        return frames;
    };
    let first = draw.whole(0, (recording.len() - count) as u64) as usize;
    let line = orthonormal(vec![
        vec![1.0; count],
        (0..count).map(|n| n as f64).collect(),
    ]);
    for c in 0..TAXELS {
        let mut column: Vec<f64> = recording[first..first + count]
            .iter()
            .map(|frame| frame[c])
            .collect();
        remove(&mut column, &line);
        let rms = (column.iter().map(|value| value * value).sum::<f64>() / count as f64).sqrt();
        frames
            .iter_mut()
            .zip(&column)
            .for_each(|(frame, value)| frame[c] = value / rms.max(f64::MIN_POSITIVE));
    }
    frames
}

fn impulses(draw: &mut Draw) -> f64 {
    let (share, size) = IMPULSES;
    let hit = if draw.even(0.0, 1.0) < share {
        if draw.coin() { size } else { -size }
    } else {
        0.0
    };
    draw.normal() + hit
}

fn autoregressive(phi: f64, draw: &mut Draw) -> Process<'static> {
    let mut state = draw.normal();
    Box::new(move |draw| {
        let value = state;
        state = phi * state + (1.0 - phi * phi).sqrt() * draw.normal();
        value
    })
}

/// Factors of the autoregressions that add up to pink noise.
fn pink_factors(rate_hz: f64) -> [f64; PINK_CORNERS_HZ.len()] {
    PINK_CORNERS_HZ.map(|corner_hz| (-TAU * corner_hz / rate_hz).exp())
}

fn pink(rate_hz: f64, draw: &mut Draw) -> Process<'static> {
    let mut parts = pink_factors(rate_hz).map(|phi| autoregressive(phi, draw));
    let scale = (PINK_CORNERS_HZ.len() as f64).sqrt().recip();
    Box::new(move |draw| scale * parts.iter_mut().map(|part| part(draw)).sum::<f64>())
}

fn walk(step: f64) -> Process<'static> {
    let mut place = 0.0;
    Box::new(move |draw| {
        place += step * draw.normal();
        place
    })
}

/// White noise through a resonance: `centre` and `width` in cycles per frame.
fn resonance(centre: f64, width: f64, draw: &mut Draw) -> Process<'static> {
    let (radius, turn) = (
        (-std::f64::consts::PI * width).exp(),
        (TAU * centre).sin_cos(),
    );
    let mut state = (draw.normal(), draw.normal());
    Box::new(move |draw| {
        let kick = (1.0 - radius * radius).sqrt();
        let (sin, cos) = turn;
        state = (
            radius * (cos * state.0 - sin * state.1) + kick * draw.normal(),
            radius * (sin * state.0 + cos * state.1) + kick * draw.normal(),
        );
        state.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean square, and correlation with the frame before and with the next channel.
    fn moments(noise: Noise) -> [f64; 3] {
        let mut draw = Draw::new(3);
        let mut sums = [0.0; 4];
        for _ in 0..40 {
            let (frames, _) = frames(noise, 1000, 241.14, &mut draw);
            for pair in frames.windows(2) {
                for c in 0..TAXELS {
                    sums[0] += pair[0][c].powi(2);
                    sums[1] += pair[0][c] * pair[1][c];
                    sums[2] += pair[0][c] * pair[0][(c + 1) % TAXELS];
                    sums[3] += 1.0;
                }
            }
        }
        [sums[0] / sums[3], sums[1] / sums[0], sums[2] / sums[0]]
    }

    /// Closed forms: an autoregression correlates by its factor, impulses add 1 % of 400; a shared
    /// disturbance correlates channels by its share and the mean of their gains, squared, over the
    /// mean of their squares.
    #[test]
    fn each_process_has_the_moments_of_its_definition() {
        let near = |got: f64, expected: f64, within: f64| {
            assert!((got - expected).abs() < within, "{got}, {expected}")
        };
        for (noise, square, next, other) in [
            (Noise::White, 1.0, 0.0, 0.0),
            (Noise::Impulses, 5.0, 0.0, 0.0),
            (Noise::Ar(0.9), 1.0, 0.9, 0.0),
            (Noise::Ar(0.6), 1.0, 0.6, 0.0),
        ] {
            let [got_square, got_next, got_other] = moments(noise);
            near(got_square, square, 0.03 * square);
            near(got_next, next, 0.01);
            near(got_other, other, 0.01);
        }
        let [square, next, other] = moments(Noise::SharedPink);
        near(square, 13.0 / 12.0, 0.2);
        assert!(next > 0.6);
        near(other, 12.0 / 13.0, 0.05);
        near(moments(Noise::SharedPhases)[2], 0.0, 0.1);
        assert!(moments(Noise::Pink)[2].abs() < 0.05);
    }

    /// Power in equal octaves is equal: 1 / f. By sums over Fourier bins of many windows.
    #[test]
    fn pink_noise_has_as_much_power_in_each_octave() {
        let (count, rate_hz) = (1024, 241.14);
        let mut draw = Draw::new(5);
        let mut octaves = [0.0; 6];
        for _ in 0..12 {
            let (frames, _) = frames(Noise::Pink, count, rate_hz, &mut draw);
            for (octave, power) in octaves.iter_mut().enumerate() {
                for bin in 8 << octave..16 << octave {
                    let angle = TAU * bin as f64 / count as f64;
                    let (mut re, mut im) = (0.0, 0.0);
                    for (n, frame) in frames.iter().enumerate() {
                        let (sin, cos) = (angle * n as f64).sin_cos();
                        (re, im) = (re + cos * frame[0], im + sin * frame[0]);
                    }
                    *power += re * re + im * im;
                }
            }
        }
        let [first, .., last] = octaves;
        assert!((0.4..2.5).contains(&(first / last)), "{octaves:?}");
        let mean = octaves.iter().sum::<f64>() / 6.0;
        assert!(
            octaves
                .iter()
                .all(|power| (0.5..2.0).contains(&(power / mean))),
            "{octaves:?}"
        );
    }
}
