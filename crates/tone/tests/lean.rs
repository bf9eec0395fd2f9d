//! Tests the lean scene: accuracy reaches the Cramer-Rao bound, sensitivity is what the channels
//! allow, and a fit is never `Good` if the window violates the scene's assumptions.

mod common;

use common::{even, normal};
use ridgetone_tone::{Fit, Fitter, FrameSpan, Frames, Scene, Status};
use std::f64::consts::TAU;

/// What a window contains besides level, slope, tone and white noise of variance 1.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Extra {
    Nothing,
    /// The level creeps with the logarithm of time.
    Creep,
    /// The noise is autoregressive with this coefficient.
    Coloured(f64),
    /// Half of the noise is common to all channels.
    Shared,
    /// A second tone of the same amplitude, this many cycles above the first.
    Tone(f64),
    /// The tone starts within the window.
    Begins,
    /// The frequency rises by a tenth over the window.
    Chirp,
    /// A second harmonic at a third of the amplitude.
    Overtone,
}

#[derive(Clone, Copy, Debug)]
struct Case {
    frames: usize,
    channels: usize,
    snr_db: f64,
    extra: Extra,
    /// Amplitudes of harmonics 2, 3 and 4 relative to the fundamental's, if any. The total power is
    /// that of a single tone.
    overtones: Option<[f64; 3]>,
}

/// A window, its number of cycles, and the Cramer-Rao bound of that number.
struct Window {
    values: Vec<f32>,
    cycles: f64,
    bound: f64,
}

impl Case {
    fn window(&self, seed: u64) -> Window {
        let mut even = even(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + self.frames as u64);
        let mut normal = normal(seed * 104_729 + 17);
        let n = self.frames as f64;
        for _ in 0..4 {
            even();
        }
        let max = if self.overtones.is_some() {
            0.11
        } else if self.extra == Extra::Overtone {
            0.2
        } else {
            0.42
        };
        let overtones = self.overtones.unwrap_or_default();
        let cycles = 2.0 * (max * n / 2.0).powf(even());
        let power: f64 = 1.0 + overtones.iter().map(|x| x * x).sum::<f64>();
        let amplitude = (2.0 / power).sqrt() * 10f64.powf(self.snr_db / 20.0);
        let shared: Vec<f64> = (0..self.frames).map(|_| normal()).collect();
        let mut values = vec![0.0; self.frames * self.channels];
        for channel in 0..self.channels {
            let (gain, start) = (0.3 + 2.0 * even(), even());
            let (level, slope, creep) = (300.0 * normal(), normal(), 10.0 * normal());
            let other = even();
            let mut coloured = normal();
            for frame in 0..self.frames {
                let t = (frame as f64 + 0.5) / n;
                let phase = match self.extra {
                    Extra::Chirp => cycles * (t + 0.05 * (t * t - t)),
                    _ => cycles * t,
                };
                let wave = |turns: f64| amplitude * (TAU * turns).cos();
                let mut value = wave(phase + start);
                let mut noise = normal();
                match self.extra {
                    Extra::Creep => value += creep * (1.0 + 20.0 * t).ln(),
                    Extra::Coloured(a) => {
                        coloured = a * coloured + (1.0 - a * a).sqrt() * noise;
                        noise = coloured;
                    }
                    Extra::Shared => noise = 0.5f64.sqrt() * (noise + shared[frame]),
                    Extra::Tone(distance) => value += wave((cycles + distance) * t + other),
                    Extra::Begins if t < 0.4 => value = 0.0,
                    Extra::Overtone => value += wave(2.0 * phase + other) / 3.0,
                    _ => {}
                }
                if self.extra != Extra::Begins || t >= 0.4 {
                    for (order, ratio) in (2..).zip(overtones) {
                        let order = f64::from(order);
                        value += ratio * wave(order * phase + order * order * other);
                    }
                }
                values[frame * self.channels + channel] =
                    (gain * (value + noise) + level + slope * t) as f32;
            }
        }
        // Bound in radians per frame (D. C. Rife and R. R. Boorstyn, IEEE Trans. Inf. Theory 20
        // (1974) 591).
        let mut information = self.channels as f64 * amplitude * amplitude;
        let orders = (2..)
            .zip(overtones)
            .map(|(order, ratio)| (f64::from(order) * ratio).powi(2));
        information *= 1.0 + orders.sum::<f64>();
        let bound = (24.0 / (information * n * n * n)).sqrt() * n / TAU;
        Window {
            values,
            cycles,
            bound,
        }
    }

    fn scene(&self) -> Scene {
        let harmonics = if self.overtones.is_some() { 4 } else { 1 };
        Scene {
            harmonics,
            ..Scene::LEAN
        }
    }

    /// Fits a window; the frequency is in cycles per window.
    fn fit(&self, window: &Window, fitter: &mut Fitter, expected: Option<f32>) -> Fit {
        let mut frames = Frames::new(&window.values, self.channels).expect("1 to 16 channels");
        let span = FrameSpan::new(&mut frames, 0, self.frames as u32);
        let mut span = span.with_frame_rate(self.frames as f32);
        if let Some(expected) = expected {
            span = span.expecting(expected);
        }
        fitter
            .fit(&mut span, &self.scene())
            .expect("its frames are there")
    }
}

#[derive(Debug, Default)]
struct Counts {
    good: u64,
    covered: u64,
    /// Number of good fits that are off by more than five sigma.
    outliers: u64,
    /// Mean square error relative to that of the bound.
    ratio: f64,
}

fn count(case: Case, windows: u64) -> Counts {
    let (mut counts, mut fitter) = (Counts::default(), Box::new(Fitter::new()));
    for seed in 0..windows {
        let window = case.window(seed);
        let fit = case.fit(&window, &mut fitter, None);
        if fit.status == Status::Good {
            let error = f64::from(fit.frequency) - window.cycles;
            let sigmas = error.abs() / f64::from(fit.sigma);
            counts.good += 1;
            counts.covered += u64::from(sigmas < 1.96);
            counts.outliers += u64::from(sigmas > 5.0);
            counts.ratio += (error / window.bound).powi(2);
        }
    }
    counts.ratio /= counts.good.max(1) as f64;
    counts
}

/// With 300 windows, the mean square error relative to the bound has a standard deviation of 0.08,
/// and 285 +- 3.8 of the intervals are expected to cover.
#[test]
fn white_noise_is_fitted_as_well_as_the_bound_allows() {
    const WINDOWS: u64 = 300;
    let white = |frames, channels, snr_db| Case {
        frames,
        channels,
        snr_db,
        extra: Extra::Nothing,
        overtones: None,
    };
    for (case, ratio_max) in [
        (white(48, 16, 20.0), 1.5),
        (white(96, 16, 20.0), 1.35),
        (white(241, 16, 20.0), 1.3),
        (white(940, 16, 20.0), 1.3),
        (white(241, 4, 20.0), 1.3),
        (white(241, 16, 0.0), 1.3),
        (white(241, 16, 60.0), 1.6),
    ] {
        let counts = count(case, WINDOWS);
        assert!(
            counts.good >= 294
                && (273..=299).contains(&counts.covered)
                && counts.outliers == 0
                && counts.ratio < ratio_max,
            "{case:?}: {counts:?}"
        );
    }
}

/// Any of four harmonics may be strongest. Neither a harmonic nor a fraction of the fundamental
/// must be taken for it.
#[test]
fn harmonics_are_fitted_as_well_as_the_bound_allows() {
    const WINDOWS: u64 = 200;
    const RIDGES: [f64; 3] = [0.4, 0.2, 0.1];
    for (frames, channels, snr_db, overtones, ratio_max) in [
        (48, 16, 20.0, RIDGES, 1.6),
        (96, 16, 20.0, RIDGES, 1.45),
        (241, 16, 20.0, RIDGES, 1.4),
        (940, 16, 20.0, RIDGES, 1.4),
        (241, 4, 20.0, RIDGES, 1.4),
        (241, 16, 0.0, RIDGES, 1.7),
        (241, 16, 50.0, RIDGES, 1.6),
        (241, 16, 20.0, [0.0; 3], 1.4),
        (48, 16, 20.0, [2.0, 1.0, 0.5], 1.6),
        (96, 16, 20.0, [2.0, 1.0, 0.5], 1.5),
        (241, 16, 20.0, [2.0, 1.0, 0.5], 1.4),
        (48, 16, 20.0, [8.0, 3.0, 0.0], 1.6),
        (241, 16, 20.0, [20.0, 6.0, 0.0], 1.4),
        (241, 16, 20.0, [1.0, 0.0, 0.0], 1.4),
        (241, 16, 20.0, [0.0, 0.5, 0.0], 1.4),
    ] {
        let case = Case {
            frames,
            channels,
            snr_db,
            extra: Extra::Nothing,
            overtones: Some(overtones),
        };
        let counts = count(case, WINDOWS);
        assert!(
            counts.good >= 194
                && counts.covered as f64 >= 0.9 * counts.good as f64
                && counts.outliers == 0
                && counts.ratio < ratio_max,
            "{case:?}: {counts:?}"
        );
    }
}

/// The harmonics' common ratios to the fundamental must match the waveform and the fit in the
/// default scene.
#[test]
fn overtones_are_those_of_the_wave() {
    const RATIOS: [f64; 3] = [0.4, 0.2, 0.1];
    const TURNS: [f64; 3] = [0.1, 0.3, 0.7];
    let (mut even, mut normal) = (even(3), normal(4));
    let starts: Vec<f64> = (0..16).map(|_| even()).collect();
    let mut values = Vec::new();
    for frame in 0..241 {
        for start in &starts {
            let turns = 9.3 * f64::from(frame) / 241.0 + start;
            let mut value = (TAU * turns).cos();
            for ((order, ratio), turn) in (2..).zip(RATIOS).zip(TURNS) {
                value += ratio * (TAU * (f64::from(order) * turns + turn)).cos();
            }
            values.push((value + 0.02 * normal()) as f32);
        }
    }
    let scene = Scene {
        harmonics: 4,
        ..Scene::LEAN
    };
    for scene in [scene, Scene::DEFAULT] {
        let found = common::fit_scene(&values, 16, &scene, |span| span);
        assert_eq!(found.status, Status::Good);
        for ((got, ratio), turn) in found.overtones.iter().zip(RATIOS).zip(TURNS) {
            let (sin, cos) = (TAU * turn).sin_cos();
            let off = (f64::from(got[0]) - ratio * cos).hypot(f64::from(got[1]) - ratio * sin);
            assert!(off < 0.005, "{scene:?}: {:?}", found.overtones);
        }
    }
}

#[test]
fn more_channels_find_fainter_tones() {
    for (channels, snr_db, good_min) in [(1, -4.0, 160), (4, -10.0, 180), (16, -13.0, 180)] {
        let case = Case {
            frames: 241,
            channels,
            snr_db,
            extra: Extra::Nothing,
            overtones: None,
        };
        let counts = count(case, 200);
        assert!(
            counts.good >= good_min && counts.outliers == 0,
            "{case:?}: {counts:?}"
        );
    }
}

#[test]
fn what_the_scene_does_not_declare_is_not_good() {
    const WINDOWS: u64 = 100;
    const RIDGES: Option<[f64; 3]> = Some([0.4, 0.2, 0.1]);
    for (extra, overtones, good_max) in [
        (Extra::Creep, None, 0),
        (Extra::Coloured(0.9), None, 0),
        (Extra::Coloured(0.5), None, 3),
        (Extra::Shared, None, 10),
        (Extra::Tone(0.6), None, 0),
        (Extra::Tone(7.0), None, 0),
        (Extra::Begins, None, 0),
        (Extra::Chirp, None, 12),
        (Extra::Overtone, None, 0),
        (Extra::Coloured(0.9), Some([0.0; 3]), 0),
        (Extra::Creep, RIDGES, 0),
        (Extra::Coloured(0.9), RIDGES, 0),
        (Extra::Shared, RIDGES, 20),
        (Extra::Tone(0.6), RIDGES, 0),
        (Extra::Begins, RIDGES, 0),
        (Extra::Chirp, RIDGES, 12),
    ] {
        for frames in [96, 241, 940] {
            let case = Case {
                frames,
                channels: 16,
                snr_db: 20.0,
                extra,
                overtones,
            };
            let counts = count(case, WINDOWS);
            println!("{case:?}: {counts:?}");
            assert!(
                counts.good <= good_max && counts.outliers == 0,
                "{case:?}: {counts:?}"
            );
        }
    }
}

/// If a strong tone is known from the previous window, the fit must be the same to a fraction of
/// sigma.
#[test]
fn a_tracked_tone_has_the_same_answer() {
    let mut fitter = Box::new(Fitter::new());
    for (overtones, moved_max) in [(None, 0.1), (Some([0.4, 0.2, 0.1]), 0.3)] {
        let case = Case {
            frames: 241,
            channels: 16,
            snr_db: 20.0,
            extra: Extra::Nothing,
            overtones,
        };
        for seed in 0..40 {
            let window = case.window(seed);
            let searched = case.fit(&window, &mut fitter, None);
            for off in [0.05, 0.3, 3.0] {
                let expected = window.cycles as f32 + off;
                let tracked = case.fit(&window, &mut fitter, Some(expected));
                assert_eq!(tracked.status, searched.status, "{seed} {off}");
                let moved = (tracked.frequency - searched.frequency).abs();
                assert!(
                    moved < moved_max * searched.sigma,
                    "{seed} {off}: {tracked:?}"
                );
            }
        }
    }
}

/// Rescaling all values must not change the status.
#[test]
fn a_scale_changes_no_status() {
    let mut fitter = Box::new(Fitter::new());
    for snr_db in [-12.0, -6.0, 20.0] {
        let case = Case {
            frames: 96,
            channels: 16,
            snr_db,
            extra: Extra::Nothing,
            overtones: None,
        };
        for seed in 0..100 {
            let mut window = case.window(seed);
            let status = case.fit(&window, &mut fitter, None).status;
            for scale in [1.0 + 3e-6, 1e-12, 1e12] {
                let scaled = window.values.iter().map(|value| value * scale).collect();
                let before = std::mem::replace(&mut window.values, scaled);
                let after = case.fit(&window, &mut fitter, None).status;
                assert_eq!(after, status, "{snr_db} {seed} {scale}");
                window.values = before;
            }
        }
    }
}
