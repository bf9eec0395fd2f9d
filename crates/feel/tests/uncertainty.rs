//! Uncertainties beside what many runs scatter by, on seeded noise.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_feel::{
    Conversion, Firing, Indices, MeanFiring, Receptor, Reference, Score, SpectralLine, Windows,
    amplitude_spectrum,
};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 2048.0;
const UNIT: Conversion = Conversion {
    log_per_um: 0.0,
    log_sigma: 0.0,
};

#[derive(Clone, Copy, PartialEq)]
struct Tone {
    amplitude: f64,
    hz: f64,
}

impl Tone {
    const NONE: Self = Self::at_100_hz(0.0);

    const fn at_100_hz(amplitude: f64) -> Self {
        Self {
            amplitude,
            hz: 100.0,
        }
    }
}

struct Noise(ChaCha8Rng);

impl Noise {
    fn normal(&mut self) -> f64 {
        let mut uniform = || (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        (-2.0 * (1.0 - uniform()).ln()).sqrt() * (TAU * uniform()).cos()
    }

    /// A tone of `amplitude` at `hz` in white noise of `sigma`.
    fn samples(&mut self, count: usize, tone: Tone, sigma: f64) -> Vec<f32> {
        let Tone { amplitude, hz } = tone;
        let phase = TAU * self.normal();
        let tone = |i: usize| amplitude * (TAU * hz * i as f64 / RATE_HZ + phase).cos();
        (0..count)
            .map(|i| (tone(i) + sigma * self.normal()) as f32)
            .collect()
    }
}

fn noise(seed: u64) -> Noise {
    Noise(ChaCha8Rng::seed_from_u64(seed))
}

fn firing(mut samples: Vec<f32>, conversion: &Conversion) -> Firing {
    let windows = Windows::same((samples.len() as f64 / RATE_HZ) as f32);
    Firing::new(
        amplitude_spectrum(&mut samples).expect("a power of two"),
        windows,
        conversion,
    )
}

/// Mean and standard deviation.
fn spread(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / (values.len() - 1) as f64;
    (mean, variance.sqrt())
}

fn variance(covariance: &[[f32; 4]; 4], receptor: Receptor) -> f64 {
    covariance[receptor as usize][receptor as usize].into()
}

/// One window has only the closed form. It holds for noise far above the thresholds and for the
/// covariance of receptors that share bins, and is more than the scatter of noise near the
/// thresholds and of a tone.
#[test]
fn the_closed_form_of_one_window() {
    let runs = |sigma: f64, tone: Tone, seed: u64| -> Vec<MeanFiring> {
        let mut noise = noise(seed);
        let run = |_| {
            let mut mean = MeanFiring::default();
            mean.push(&firing(noise.samples(1024, tone, sigma), &UNIT));
            mean
        };
        (0..600).map(run).collect()
    };
    let (sa1, fa1, fa2) = (
        Receptor::Sa1 as usize,
        Receptor::Fa1 as usize,
        Receptor::Fa2 as usize,
    );
    let value =
        |run: &MeanFiring, m: usize| f64::from(run.mean().intensity[m].expect("an intensity"));
    let ratio = |runs: &[MeanFiring], m: usize| {
        let (_, scatter) = spread(&runs.iter().map(|run| value(run, m)).collect::<Vec<_>>());
        let given = runs
            .iter()
            .map(|run| variance(&run.covariance(0.0), Receptor::ALL[m]))
            .sum::<f64>();
        scatter / (given / runs.len() as f64).sqrt()
    };
    // Amplitudes in a bin of some 5000 um, above all thresholds.
    let loud = runs(1e5, Tone::NONE, 1);
    for m in 0..4 {
        let ratio = ratio(&loud, m);
        assert!(
            (0.92..1.08).contains(&ratio),
            "{:?}: {ratio}",
            Receptor::ALL[m]
        );
    }
    let sums: Vec<f64> = loud
        .iter()
        .map(|run| value(run, sa1) - value(run, fa1))
        .collect();
    let given = loud.iter().map(|run| {
        let covariance = run.covariance(0.0);
        f64::from(covariance[sa1][sa1] + covariance[fa1][fa1] - 2.0 * covariance[sa1][fa1])
    });
    let ratio_of_difference = spread(&sums).1 / (given.sum::<f64>() / loud.len() as f64).sqrt();
    assert!(
        (0.92..1.08).contains(&ratio_of_difference),
        "{ratio_of_difference}"
    );
    // About at SA I's threshold of some 10 um.
    let near = ratio(&runs(200.0, Tone::NONE, 2), sa1);
    assert!((0.5..1.05).contains(&near), "{near}");
    // A tone 40 dB above the noise is steady: the closed form is a bound.
    let steady = Tone {
        amplitude: 1.0,
        hz: 250.0,
    };
    let tone = ratio(&runs(0.001, steady, 3), fa2);
    assert!(tone < 0.3, "{tone}");
}

/// From eight windows on their scatter counts; windows that overlap by half are all but
/// independent.
#[test]
fn the_scatter_of_several_windows() {
    let mut noise = noise(4);
    let (mut means, mut given) = (Vec::new(), Vec::new());
    for _ in 0..150 {
        let samples = noise.samples(256 * 9, Tone::NONE, 1e5);
        let mut mean = MeanFiring::default();
        for window in 0..17 {
            mean.push(&firing(samples[128 * window..][..256].to_vec(), &UNIT));
        }
        means.push(f64::from(mean.mean().intensity[1].expect("an intensity")));
        given.push(variance(&mean.covariance(0.0), Receptor::Fa2));
    }
    let ratio = spread(&means).1 / spread(&given).0.sqrt();
    assert!((0.9..1.2).contains(&ratio), "{ratio}");
}

/// The reference's amplitude is uncertain, and moves all bins at once.
#[test]
fn the_conversion_and_the_scores_uncertainty() {
    let reference = Reference {
        ra_um: 0.5,
        ra_sigma_um: 0.0,
        rsm_mm: 0.1,
        speed_mm_s: 10.0,
    };
    let score = Score {
        residual_sigma: 0.3,
        ..Score::exact([1.0, 0.0, 0.002, -0.004, 0.0, 0.5])
    };
    for (tone, sigma) in [(1.0, 4.0), (0.0, 1.0)] {
        let mut noise = noise(5);
        let (mut logs, mut log_sigmas, mut scores, mut score_variances) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for _ in 0..600 {
            let mut samples = noise.samples(1024, Tone::at_100_hz(tone), sigma);
            let line = SpectralLine::measure(&mut samples, 50.0).expect("a power of two");
            let conversion = reference
                .conversion(line.amplitude, line.sigma)
                .expect("an amplitude");
            logs.push(f64::from(conversion.log_per_um));
            log_sigmas.push(f64::from(conversion.log_sigma).powi(2));
            let mut mean = MeanFiring::default();
            mean.push(&firing(noise.samples(1024, Tone::NONE, 1e5), &conversion));
            let m = (1.2 + 0.1 * noise.normal()) as f32;
            let indices = Indices::new(&mean, conversion.log_sigma, Some((m, 0.1)));
            let (value, sigma) = score.of(&indices).expect("a score");
            scores.push(f64::from(value) + 0.3 * noise.normal());
            score_variances.push(f64::from(sigma).powi(2));
        }
        // In noise alone an amplitude may come close to zero, and its logarithm anywhere: sigma is
        // that of the bulk.
        let middle = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            (values[values.len() * 84 / 100] - values[values.len() * 16 / 100]) / 2.0
        };
        let conversion = middle(logs) / {
            log_sigmas.sort_by(f64::total_cmp);
            log_sigmas[300].sqrt()
        };
        let range = if tone > 0.0 { 0.9..1.1 } else { 0.6..1.0 };
        assert!(range.contains(&conversion), "{tone}: {conversion}");
        let score = middle(scores) / {
            score_variances.sort_by(f64::total_cmp);
            score_variances[300].sqrt()
        };
        let range = if tone > 0.0 { 0.9..1.1 } else { 0.6..1.05 };
        assert!(range.contains(&score), "{tone}: {score}");
    }
}

/// One noisy surface near the thresholds with a strong tone and a weak one: as a window of
/// half a second it has one score, from windows of 31 ms to half a second.
#[test]
fn one_surface_has_one_score_from_windows_of_any_length() {
    let conversion = Conversion {
        log_per_um: 0.0,
        log_sigma: 0.01,
    };
    let score = Score::exact([1.0, 0.0, 0.011, 0.0, 0.0, 0.0]);
    let strong = Tone {
        amplitude: 3.0,
        hz: 256.0,
    };
    for (name, tone, sigma) in [
        ("far above", Tone::NONE, 100.0),
        ("near", Tone::NONE, 3.0),
        ("line in noise", strong, 3.0),
        ("line", strong, 1e-3),
    ] {
        let scores = [1024, 512, 256, 128, 64].map(|count| {
            let mut noise = noise(6);
            let windows = Windows {
                measured_s: (count as f64 / RATE_HZ) as f32,
                wanted_s: 0.5,
            };
            let mut mean = MeanFiring::default();
            for _ in 0..20 {
                let mut samples = noise.samples(count, tone, sigma);
                let amplitudes = amplitude_spectrum(&mut samples).expect("a power of two");
                mean.push(&Firing::new(amplitudes, windows, &conversion));
            }
            let indices = Indices::new(&mean, conversion.log_sigma, None);
            score.of(&indices).expect("a score")
        });
        let (expected, expected_sigma) = scores[0];
        for (value, sigma) in &scores[1..] {
            let off = (value - expected).abs();
            assert!(
                off < 3.0 * sigma.hypot(expected_sigma),
                "{name}: {scores:?}"
            );
        }
        // No line, no doubt about it: the uncertainty is that of the scatter.
        if tone == Tone::NONE {
            let (value, sigma) = scores[3];
            assert!(sigma < 0.06 * value, "{name}: {scores:?}");
        }
    }
}

/// In a longer window a bin has less of a reference of noise, and as much of a line.
#[test]
fn one_reference_has_one_conversion_from_windows_of_any_length() {
    for (name, tone) in [("line", 3.0), ("weak line", 0.3), ("noise", 0.0)] {
        let found = [1024, 256, 64].map(|count: usize| {
            let mut noise = noise(8);
            let cycles = (100.0 * count as f64 / RATE_HZ) as f32;
            let lines: Vec<SpectralLine> = (0..40)
                .map(|_| {
                    let mut samples = noise.samples(count, Tone::at_100_hz(tone), 1.0);
                    SpectralLine::measure(&mut samples, cycles).expect("a power of two")
                })
                .collect();
            let windows = Windows {
                measured_s: (count as f64 / RATE_HZ) as f32,
                wanted_s: 0.5,
            };
            SpectralLine::mean(lines.into_iter(), windows).expect("an amplitude")
        });
        let (expected, expected_sigma) = found[0];
        for (amplitude, sigma) in &found[1..] {
            let off = (amplitude - expected).abs();
            assert!(off < 3.0 * sigma.hypot(expected_sigma), "{name}: {found:?}");
        }
    }
}

/// The mean of windows, by what is beside the line and by their scatter.
#[test]
fn the_amplitude_of_several_windows() {
    for (windows, tone, range) in [
        (4, 1.0, 0.9..1.1),
        (4, 0.0, 0.55..0.9),
        (12, 1.0, 0.9..1.15),
        (12, 0.0, 0.9..1.15),
    ] {
        let mut noise = noise(7);
        let run = |_| {
            let lines: Vec<SpectralLine> = (0..windows)
                .map(|_| {
                    SpectralLine::measure(&mut noise.samples(256, Tone::at_100_hz(tone), 1.0), 12.5)
                        .expect("a power of two")
                })
                .collect();
            SpectralLine::mean(lines.into_iter(), Windows::same(0.125)).expect("an amplitude")
        };
        let (means, sigmas): (Vec<f64>, Vec<f64>) = (0..400)
            .map(run)
            .map(|(mean, sigma)| (f64::from(mean), f64::from(sigma).powi(2)))
            .unzip();
        let ratio = spread(&means).1 / spread(&sigmas).0.sqrt();
        assert!(range.contains(&ratio), "{windows} {tone}: {ratio}");
    }
}
