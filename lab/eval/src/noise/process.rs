//! Pink noise of sixteen channels, mean square 1 in each, at any frame rate.

use crate::draw::Draw;
use ridgetone_proto::settings::TAXELS;
use std::f64::consts::TAU;

/// Corner frequencies of the relaxations that add up to pink noise, hertz: half a decade apart.
const PINK_CORNERS_HZ: [f64; 7] = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0];

/// Frames of noise with a power of 1 / f, independent in each channel.
pub fn pink_frames(count: usize, rate_hz: f64, draw: &mut Draw) -> Vec<[f64; TAXELS]> {
    let mut channels: Vec<_> = (0..TAXELS).map(|_| pink(rate_hz, draw)).collect();
    (0..count)
        .map(|_| std::array::from_fn(|c| channels[c](draw)))
        .collect()
}

fn pink(rate_hz: f64, draw: &mut Draw) -> impl FnMut(&mut Draw) -> f64 + use<> {
    let factors = PINK_CORNERS_HZ.map(|corner_hz| (-TAU * corner_hz / rate_hz).exp());
    let mut states = factors.map(|_| draw.normal());
    let scale = (PINK_CORNERS_HZ.len() as f64).sqrt().recip();
    move |draw| {
        let sum: f64 = states.iter().sum();
        for (state, factor) in states.iter_mut().zip(factors) {
            *state = factor * *state + (1.0 - factor * factor).sqrt() * draw.normal();
        }
        scale * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Power in equal octaves is equal: 1 / f. By sums over Fourier bins of many windows.
    #[test]
    fn pink_noise_has_as_much_power_in_each_octave() {
        let (count, rate_hz) = (1024, 241.14);
        let mut draw = Draw::new(5);
        let mut octaves = [0.0; 6];
        for _ in 0..12 {
            let frames = pink_frames(count, rate_hz, &mut draw);
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
