//! What has a closed form: spectra of sines, thresholds, intensities of a vibration of known
//! amplitude, forces, scores.

use ridgetone_feel::{
    Absent, Conversion, Firing, Indices, MeanFiring, ROUGH, Receptor, Reference, SOFT,
    SpectralLine, Windows, amplitude_at, amplitude_spectrum, force_ratio, points,
};
use std::f64::consts::TAU;

/// The samples are in micrometres.
const UNIT: Conversion = Conversion {
    log_per_um: 0.0,
    log_sigma: 0.0,
};

fn sine(count: usize, cycles: f64, amplitude: f64, offset: f64) -> Vec<f32> {
    (0..count)
        .map(|i| (offset + amplitude * (TAU * cycles * i as f64 / count as f64 + 0.7).cos()) as f32)
        .collect()
}

#[test]
fn a_sine_has_its_amplitude_in_its_bin_and_hammings_share_beside() {
    for count in [64, 128, 256, 512, 1024] {
        let cycles = count as f64 / 8.0 + 1.0;
        let mut samples = sine(count, cycles, 0.3, 2.5);
        assert!((amplitude_at(&samples, cycles as f32) - 0.3).abs() < 1e-5);
        let amplitudes = amplitude_spectrum(&mut samples).expect("a power of two");
        assert_eq!(amplitudes.len(), count / 2);
        for (k, amplitude) in amplitudes.iter().enumerate() {
            let expected = match (k as f64 - cycles).abs() {
                0.0 => 0.3,
                1.0 => 0.3 * 0.23 / 0.54,
                _ => 0.0,
            };
            assert!(
                (f64::from(*amplitude) - expected).abs() < 2e-6,
                "{count} {k}: {amplitude} {expected}"
            );
        }
    }
}

#[test]
fn an_amplitude_between_two_bins_is_found() {
    for cycles in [20.0, 20.3, 20.5, 77.77] {
        let found = amplitude_at(&sine(1024, cycles, 2.0, -1.0), cycles as f32);
        // What is left is the mean of a part of a cycle.
        assert!((found - 2.0).abs() < 4e-3, "{cycles}: {found}");
    }
}

/// What leaks from a line between two bins is no amplitude: not even 80 dB below the line.
#[test]
fn leakage_is_no_amplitude() {
    let mean = |mut samples: Vec<f32>| {
        SpectralLine::mean(
            [SpectralLine::measure(&mut samples, 20.0).expect("a power of two")].into_iter(),
            Windows::same(1.0),
        )
    };
    assert_eq!(mean(sine(1024, 300.5, 1.0, 2.5)), None);
    assert_eq!(
        (
            mean(vec![2.5; 1024]),
            SpectralLine::mean([].into_iter(), Windows::same(1.0))
        ),
        (None, None)
    );
    let faint: Vec<f32> = sine(1024, 300.5, 1.0, 2.5)
        .iter()
        .zip(sine(1024, 20.0, 1e-3, 0.0))
        .map(|(a, b)| a + b)
        .collect();
    let (amplitude, sigma) = mean(faint).expect("an amplitude");
    assert!(
        (amplitude - 1e-3).abs() < 2e-4 && sigma < 2e-4,
        "{amplitude} {sigma}"
    );
}

#[test]
fn the_ends_of_the_spectrum_are_right() {
    // A cycle a window, and one less than Nyquist's: their neighbours are bin 0 and the Nyquist
    // bin.
    for cycles in [1.0, 127.0] {
        let mut samples = sine(256, cycles, 1.0, 0.0);
        let amplitudes = amplitude_spectrum(&mut samples).expect("a power of two");
        assert!(
            (amplitudes[cycles as usize] - 1.0).abs() < 1e-5,
            "{amplitudes:?}"
        );
    }
}

#[test]
fn windows_are_powers_of_two() {
    assert_eq!(
        [63, 64, 127, 1023, 1024, 1 << 30].map(points),
        [
            None,
            Some(64),
            Some(64),
            Some(512),
            Some(1024),
            Some(ridgetone_feel::POINTS_MAX)
        ]
    );
    assert_eq!(amplitude_spectrum(&mut [0.0; 100]), None);
    assert_eq!(amplitude_spectrum(&mut []), None);
}

/// The paper's own numbers, equations 1 to 4 and Table 1.
#[test]
fn thresholds_at_their_corners() {
    let table = [
        (
            Receptor::Fa1,
            [0.5, 12.2, 67.0],
            [499.0, -0.890, 52.1, 0.0119],
        ),
        (
            Receptor::Fa2,
            [20.0, 241.0, 800.0],
            [1690.0, -1.93, 2.00e-5, 1.39],
        ),
        (
            Receptor::Sa1,
            [0.5, 26.2, 120.0],
            [43.5, -0.545, 0.787, 0.683],
        ),
        (
            Receptor::Sa2,
            [0.5, 91.2, 400.0],
            [501.0, -0.783, 17.1, -0.0340],
        ),
    ];
    for (receptor, corners, [a, a_slope, b, b_slope]) in table {
        assert_eq!(
            receptor
                .corners_hz()
                .map(f64::from)
                .map(|hz| (hz * 1e3).round() / 1e3),
            corners
        );
        let [from, bend, to] = corners.map(|hz: f64| hz as f32);
        let close = |found: Option<f32>, factor: f64, slope: f64, hz: f32| {
            let expected = factor * f64::from(hz).powf(slope);
            let found = f64::from(found.expect("in its range"));
            assert!(
                (found / expected - 1.0).abs() < 1e-5,
                "{receptor:?} at {hz} Hz: {found} {expected}"
            );
        };
        assert_eq!(
            (
                receptor.threshold_um(from),
                receptor.threshold_um(to * 1.0001)
            ),
            (None, None)
        );
        close(
            receptor.threshold_um(from * 1.0001),
            a,
            a_slope,
            from * 1.0001,
        );
        close(receptor.threshold_um(bend), a, a_slope, bend);
        close(
            receptor.threshold_um(bend * 1.0001),
            b,
            b_slope,
            bend * 1.0001,
        );
        close(receptor.threshold_um(to), b, b_slope, to);
    }
    // Where the two lines meet, they differ by at most 5 %: the paper rounds.
    for receptor in Receptor::ALL {
        let bend = receptor.corners_hz()[1];
        let [below, above] =
            [bend, bend * 1.0001].map(|hz| receptor.threshold_um(hz).expect("in its range"));
        assert!((below / above - 1.0).abs() < 0.05, "{receptor:?}");
    }
}

/// A vibration of 30 um at 40 Hz: three bins, and the sum of their logarithms over the threshold,
/// each.
#[test]
fn a_vibration_of_known_amplitude_is_a_sum_of_logarithms() {
    let (count, rate_hz) = (1024, 2048.0);
    let bin_hz = rate_hz / count as f32;
    let mut samples = sine(count, 20.0, 30.0, 0.0);
    let amplitudes = amplitude_spectrum(&mut samples).expect("a power of two");
    let firing = Firing::new(amplitudes, Windows::same(1.0 / bin_hz), &UNIT);
    for (m, receptor) in Receptor::ALL.into_iter().enumerate() {
        let lines = [
            (38.0, 30.0 * 0.23 / 0.54),
            (40.0, 30.0),
            (42.0, 30.0 * 0.23 / 0.54),
        ];
        let decades = lines.map(|(hz, um): (f32, f64)| {
            let threshold = receptor.threshold_um(hz).expect("in its range");
            (um / f64::from(threshold)).log10().max(0.0)
        });
        let found = f64::from(firing.intensity[m].expect("the rate is high enough"));
        assert!(
            (found - decades.iter().sum::<f64>()).abs() < 2e-5,
            "{receptor:?}: {found} {decades:?}"
        );
        assert_eq!(
            firing.above[m] as usize,
            decades.iter().filter(|decades| **decades > 0.0).count()
        );
    }
    // 30 um are below FA I's 54 um, the middle line is above SA II's 28 um.
    assert_eq!(
        Receptor::ALL.map(|receptor| firing.above[receptor as usize]),
        [0.0, 3.0, 3.0, 1.0]
    );
    // A sensor of another unit with its own conversion feels the same.
    let mut samples = sine(count, 20.0, 30.0 * 0.564, 0.0);
    let conversion = Conversion {
        log_per_um: 0.564f32.log10(),
        log_sigma: 0.0,
    };
    let scaled = Firing::new(
        amplitude_spectrum(&mut samples).expect("a power of two"),
        Windows::same(1.0 / bin_hz),
        &conversion,
    );
    for m in 0..4 {
        let [a, b] = [firing, scaled].map(|firing| firing.intensity[m].expect("an intensity"));
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
}

#[test]
fn a_rate_too_low_for_a_receptor_gives_no_intensity() {
    let mut samples = sine(1024, 20.0, 1000.0, 0.0);
    let amplitudes = amplitude_spectrum(&mut samples).expect("a power of two");
    let absent = |rate_hz: f32| {
        Receptor::ALL.map(|receptor| Firing::absent(receptor, 512, rate_hz / 1024.0))
    };
    assert_eq!(absent(1601.0), [None; 4]);
    assert_eq!(
        absent(1600.0),
        [None, Some(Absent::RateTooLow(1600.0)), None, None]
    );
    let firing = Firing::new(amplitudes, Windows::same(1.024), &UNIT);
    assert_eq!(
        firing.intensity.map(|value| value.is_some()),
        [true, false, true, true]
    );
    let firing = Firing::new(amplitudes, Windows::same(1024.0 / 241.0), &UNIT);
    assert_eq!(
        firing.intensity.map(|value| value.is_some()),
        [true, false, true, false]
    );
    // 64 samples at 10 kHz: the first bin is at 156 Hz.
    let too_short = Some(Absent::WindowTooShort);
    let absent = Receptor::ALL.map(|receptor| Firing::absent(receptor, 32, 1e4 / 64.0));
    assert_eq!(absent, [too_short, None, too_short, None]);
}

/// Equations 5 and 6 with the paper's figures of section 3.2.
#[test]
fn the_papers_conversion() {
    let reference = Reference {
        ra_um: 0.278,
        ra_sigma_um: 0.0,
        rsm_mm: 0.121,
        speed_mm_s: 10.0,
    };
    assert!((reference.frequency_hz() - 82.8).abs() < 0.2);
    let conversion = reference.conversion(0.313, 0.0969).expect("an amplitude");
    assert!((conversion.per_um() - 0.564).abs() < 0.002);
    assert!((conversion.log_sigma - 0.134).abs() < 0.001);
    for amplitude in [0.0, f32::NAN, f32::INFINITY] {
        assert!(reference.conversion(amplitude, 0.0).is_err());
    }
    assert!(
        Reference {
            ra_um: 0.0,
            ..reference
        }
        .conversion(0.3, 0.0)
        .is_err()
    );
}

#[test]
fn forces_of_units_on_crosses() {
    // 0.2 tangential, 1.0 normal a unit; the second unit is dead.
    let unit = [0.25 + 0.1, 0.25, 0.25 - 0.1, 0.25];
    let sigmas = [[0.01; 4]; 2];
    let (ratio, sigma) = force_ratio(&[unit, [f32::NAN; 4]], &sigmas, 1.5).expect("a unit");
    assert!((ratio - 0.3).abs() < 1e-6);
    // 0.2 +- 0.01 sqrt 2 over 1 +- 0.02, times 1.5.
    assert!(
        (sigma - 1.5 * (2e-4f32 + 4e-4 * 0.04).sqrt()).abs() < 1e-6,
        "{sigma}"
    );
    assert_eq!(force_ratio(&[[f32::NAN; 4]], &[[0.0; 4]], 1.0), None);
    assert_eq!(force_ratio(&[[0.0; 4]], &[[0.0; 4]], 1.0), None);
}

/// Equations 11 and 12, with intensities of the paper's own window.
#[test]
fn the_papers_scores() {
    let values = [Some(10.0), Some(900.0), Some(1200.0), Some(5.0), Some(1.1)];
    let indices = Indices {
        values,
        covariance: [[0.0; 5]; 5],
    };
    let (soft, rough) = (
        SOFT.of(&indices).expect("a score"),
        ROUGH.of(&indices).expect("a score"),
    );
    assert!((soft.0 - 3.19).abs() < 1e-4 && soft.1 == 0.0);
    assert!(
        (rough.0 - (-16.075 + 9.9 + 12.7963)).abs() < 1e-4,
        "{rough:?}"
    );
    let without_m = Indices {
        values: [values[0], values[1], values[2], values[3], None],
        ..indices
    };
    assert_eq!(
        (ROUGH.of(&without_m), ROUGH.missing(&without_m)),
        (None, Some(4))
    );
    assert!(SOFT.of(&without_m).is_some());
}

/// A tone is three bins in a window of any length, and its reference has one amplitude: in half a
/// second as in three.
#[test]
fn a_tone_in_another_window_has_no_more_bins() {
    let mut samples = sine(1024, 20.0, 300.0, 0.0);
    let amplitudes = amplitude_spectrum(&mut samples).expect("a power of two");
    let [own, wanted] = [0.5, 3.0].map(|wanted_s| {
        let windows = Windows {
            measured_s: 0.5,
            wanted_s,
        };
        let mut mean = MeanFiring::default();
        mean.push(&Firing::new(amplitudes, windows, &UNIT));
        Indices::new(&mean, 0.0, Some((1.2, 0.1)))
    });
    assert_eq!(own.values, wanted.values);
    assert!((wanted.get(4).expect("M").1 - 0.1).abs() < 1e-6);
    let sigma = |indices: &Indices| indices.get(Receptor::Sa1 as usize).expect("SA I").1;
    // Noise no wider than a bin would be as many bins more as there are.
    assert!(sigma(&wanted) > 2.0 * sigma(&own));

    let line = |samples: &mut [f32]| SpectralLine::measure(samples, 20.0).expect("a power of two");
    let lines = [line(&mut sine(1024, 20.0, 0.3, 0.0))];
    let windows = Windows {
        measured_s: 0.5,
        wanted_s: 3.0,
    };
    let (amplitude, _) = SpectralLine::mean(lines.into_iter(), windows).expect("an amplitude");
    assert!((amplitude - 0.3).abs() < 1e-5);
}
