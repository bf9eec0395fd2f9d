//! The bound against a likelihood that knows nothing of it, and against the textbook.

use super::{Channel, Clue, Harmonic, Window, clues};
use anyhow::Result;
use std::f64::consts::{PI, TAU};

/// The bound, hertz. Infinite where the window does not determine the frequency.
fn sigma_hz(window: &Window, frequency_hz: f64, channels: &[Channel]) -> Result<f64> {
    Ok(Clue::sum(&clues(window, frequency_hz, channels, &|_, _| 0.0)?).sigma_hz())
}

/// A scene of few channels whose likelihood is differentiated by numbers.
struct Scene {
    window: Window,
    frequency_hz: f64,
    channels: Vec<Channel>,
}

impl Scene {
    /// Unknowns of one channel, in their order: offset, slope, cosine and sine of each harmonic.
    fn unknowns_of(&self, channel: &Channel) -> usize {
        1 + usize::from(self.window.slope) + 2 * channel.harmonics.len()
    }

    /// The true parameters: frequency in Hz, then the unknowns channel after channel.
    fn truth(&self) -> Vec<f64> {
        let mut parameters = vec![self.frequency_hz];
        for (number, channel) in self.channels.iter().enumerate() {
            parameters.push(3.0 - number as f64);
            if self.window.slope {
                parameters.push(0.7);
            }
            parameters.extend(channel.harmonics.iter().flat_map(|h| [h.cos, h.sin]));
        }
        parameters
    }

    /// What channel `number` shows at a frame.
    fn model(&self, parameters: &[f64], number: usize, frame: usize) -> f64 {
        let first = 1 + self.channels[..number]
            .iter()
            .map(|channel| self.unknowns_of(channel))
            .sum::<usize>();
        let own = &parameters[first..first + self.unknowns_of(&self.channels[number])];
        // The centre by its definition, so that the amplitudes mean the same.
        let t_s =
            (frame as f64 - (self.window.frames - 1) as f64 / 2.0) / self.window.frame_rate_hz;
        let (line, waves) = own.split_at(1 + usize::from(self.window.slope));
        let mut value = line[0] + line.get(1).map_or(0.0, |slope| slope * t_s);
        for (index, wave) in waves.chunks(2).enumerate() {
            let theta = TAU * (index + 1) as f64 * parameters[0] * t_s;
            value += wave[0] * theta.cos() + wave[1] * theta.sin();
        }
        value
    }

    /// Negative log-likelihood of data without noise, but for a constant.
    fn cost(&self, parameters: &[f64], data: &[Vec<f64>]) -> f64 {
        let mut sum = 0.0;
        for (number, channel) in self.channels.iter().enumerate() {
            for (frame, value) in data[number].iter().enumerate() {
                let off = value - self.model(parameters, number, frame);
                sum += 0.5 * (off / channel.sigma).powi(2);
            }
        }
        sum
    }

    /// Square root of the frequency's place in the inverse of the Hessian, by central differences.
    fn sigma_by_differences(&self) -> f64 {
        let truth = self.truth();
        let data: Vec<Vec<f64>> = (0..self.channels.len())
            .map(|number| {
                (0..self.window.frames)
                    .map(|frame| self.model(&truth, number, frame))
                    .collect()
            })
            .collect();
        // The cost is a parabola but for the frequency, where the step is small against one over
        // the window.
        let window_s = self.window.frames as f64 / self.window.frame_rate_hz;
        let step = |i: usize| if i == 0 { 1e-4 / window_s } else { 1e-3 };
        let size = truth.len();
        let at = |i: usize, di: f64, j: usize, dj: f64| {
            let mut parameters = truth.clone();
            parameters[i] += di * step(i);
            parameters[j] += dj * step(j);
            self.cost(&parameters, &data)
        };
        let second = |i: usize, j: usize| {
            let bend = at(i, 1.0, j, 1.0) - at(i, 1.0, j, -1.0) - at(i, -1.0, j, 1.0)
                + at(i, -1.0, j, -1.0);
            bend / (4.0 * step(i) * step(j))
        };
        let hessian = (0..size)
            .map(|i| (0..size).map(|j| second(i, j)).collect())
            .collect();
        first_of_inverse(hessian).sqrt()
    }
}

/// Element (0, 0) of the inverse of a matrix: first unknown of the solution for (1, 0, 0, ...), by
/// elimination with pivots.
fn first_of_inverse(mut matrix: Vec<Vec<f64>>) -> f64 {
    let size = matrix.len();
    let mut right = vec![0.0; size];
    right[0] = 1.0;
    for k in 0..size {
        let pivot = (k..size)
            .max_by(|a, b| matrix[*a][k].abs().total_cmp(&matrix[*b][k].abs()))
            .unwrap();
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        assert!(matrix[k][k] != 0.0, "the matrix is singular");
        for i in (0..size).filter(|i| *i != k) {
            let factor = matrix[i][k] / matrix[k][k];
            let row = matrix[k].clone();
            matrix[i]
                .iter_mut()
                .zip(&row)
                .for_each(|(value, other)| *value -= factor * other);
            right[i] -= factor * right[k];
        }
    }
    right[0] / matrix[0][0]
}

fn whole(frames: usize, slope: bool) -> Window {
    Window {
        frames,
        frame_rate_hz: 241.14,
        slope,
    }
}

/// Channels of different noise, size and number of harmonics.
fn channels(harmonics: usize) -> Vec<Channel> {
    (0..3)
        .map(|number| {
            let c = f64::from(number);
            let wave = |h: usize| Harmonic::polar((1.0 + c) / h as f64, 0.9 * c + 2.0 * h as f64);
            Channel {
                sigma: 0.1 + 0.2 * c,
                harmonics: (1..=harmonics).map(wave).collect(),
            }
        })
        .collect()
}

#[test]
fn it_is_the_inverse_hessian_of_the_likelihood() {
    let cases = [
        (whole(72, true), 8.33, channels(4)),
        (whole(72, false), 8.33, channels(1)),
        (whole(241, true), 8.33, channels(2)),
        (whole(40, true), 7.0, channels(2)),
        (whole(30, false), 6.0, channels(3)),
        (whole(64, true), 118.0, channels(1)),
    ];
    for (window, frequency_hz, channels) in cases {
        let bound = sigma_hz(&window, frequency_hz, &channels).unwrap();
        let scene = Scene {
            window,
            frequency_hz,
            channels,
        };
        let expected = scene.sigma_by_differences();
        assert!(
            (bound / expected - 1.0).abs() < 1e-4,
            "{window:?}: {bound} Hz, by differences {expected} Hz"
        );
    }
}

#[test]
fn one_channel_over_many_cycles_is_the_textbooks() {
    let (sigma, amplitude, frames) = (0.3, 2.0, 2000);
    let window_s = f64::from(frames) / 241.14;
    // var(f) = 6 sigma^2 / (pi^2 A^2 T^2 N), Kay, equation 3.41 in hertz.
    let textbook = (6.0 * sigma * sigma / f64::from(frames)).sqrt() / (PI * amplitude * window_s);
    for phase_rad in [0.0, 0.7, 1.6] {
        let channel = Channel {
            sigma,
            harmonics: vec![Harmonic::polar(amplitude, phase_rad)],
        };
        let bound = sigma_hz(&whole(2000, true), 20.0, std::slice::from_ref(&channel)).unwrap();
        assert!(
            (bound / textbook - 1.0).abs() < 0.01,
            "{bound} Hz, textbook {textbook} Hz"
        );
        let sixteen = sigma_hz(&whole(2000, true), 20.0, &vec![channel; 16]).unwrap();
        assert!(
            (sixteen * 4.0 / bound - 1.0).abs() < 1e-12,
            "sixteen channels halve it twice"
        );
    }
}

/// To first order the best estimate moves as the data do: data made at a frequency a little off
/// move it by as much, whatever their offset and slope.
#[test]
fn the_score_is_how_far_the_frequency_is_off() {
    let (window, frequency_hz, off_hz) = (whole(72, true), 8.33, 1e-5);
    let channels = channels(3);
    let scene = Scene {
        window,
        frequency_hz,
        channels: channels.clone(),
    };
    let mut parameters = scene.truth();
    parameters[0] += off_hz;
    let value = |number: usize, frame: usize| scene.model(&parameters, number, frame);
    let found = clues(&window, frequency_hz, &channels, &value).unwrap();
    for clue in &found {
        assert!((clue.error_hz() / off_hz - 1.0).abs() < 1e-3, "{clue:?}");
    }
    let together = Clue::sum(&found);
    assert!(
        (together.error_hz() / off_hz - 1.0).abs() < 1e-3,
        "{together:?}"
    );
    assert_eq!(
        together.sigma_hz(),
        sigma_hz(&window, frequency_hz, &channels).unwrap()
    );
}

#[test]
fn what_determines_nothing_is_infinite() {
    let silent = Channel {
        sigma: 1.0,
        harmonics: vec![Harmonic::default(); 2],
    };
    let loud = Channel {
        sigma: 1.0,
        harmonics: vec![Harmonic::polar(1.0, 0.0); 4],
    };
    for (frames, channels) in [
        (0, vec![loud.clone()]),
        (9, vec![loud]),
        (241, vec![silent]),
        (241, vec![]),
    ] {
        let bound = sigma_hz(&whole(frames, false), 8.33, &channels).unwrap();
        assert_eq!(bound, f64::INFINITY, "{frames} frames, {channels:?}");
    }
}

#[test]
fn nonsense_is_an_error() {
    let refused = |window: Window, frequency_hz, channel| {
        sigma_hz(&window, frequency_hz, &[channel]).is_err()
    };
    let channel = || Channel {
        sigma: 1.0,
        harmonics: vec![Harmonic::polar(1.0, 0.0)],
    };
    assert!(refused(
        Window {
            frame_rate_hz: f64::NAN,
            ..whole(72, true)
        },
        8.33,
        channel()
    ));
    assert!(refused(whole(72, true), 0.0, channel()));
    assert!(refused(
        whole(72, true),
        8.33,
        Channel {
            sigma: 0.0,
            ..channel()
        }
    ));
    assert!(refused(
        whole(72, true),
        8.33,
        Channel {
            harmonics: vec![Harmonic::polar(f64::NAN, 0.0)],
            ..channel()
        }
    ));
}
