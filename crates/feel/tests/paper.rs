//! Tests against the paper's numbers and against closed forms.

use ridgetone_feel::{
    Absent, Firing, Indices, MeanFiring, Measured, PAPER_WINDOW_S, ROUGH, Receptor, Reference,
    SOFT, SpectralLine, Windows,
};

const fn measured(value: f32, sigma: f32) -> Measured {
    Measured { value, sigma }
}

const fn window(measured_s: f32) -> Windows {
    Windows {
        measured_s,
        wanted_s: measured_s,
    }
}

/// Windows of half a second, converted to the paper's three seconds.
const CONVERTED: Windows = Windows {
    measured_s: 0.5,
    wanted_s: PAPER_WINDOW_S,
};

/// Amplitude spectrum of a sine with a whole number of cycles under a Hamming window.
fn sine(bins: usize, cycles: usize, um: f32) -> Vec<f32> {
    let mut spectrum = vec![0.0; bins];
    spectrum[cycles] = um;
    (spectrum[cycles - 1], spectrum[cycles + 1]) = (um * 0.23 / 0.54, um * 0.23 / 0.54);
    spectrum
}

#[test]
fn thresholds_are_equations_1_to_4_and_table_1() {
    for (receptor, corners, [a, a_slope, b, b_slope]) in [
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
    ] {
        assert_eq!(receptor.corners_hz(), corners);
        let [from, bend, to] = corners;
        for (hz, factor, slope) in [
            (from * 1.0001, a, a_slope),
            (bend, a, a_slope),
            (bend * 1.0001, b, b_slope),
            (to, b, b_slope),
        ] {
            let found = receptor.threshold_um(hz).expect("in its range");
            let expected = factor * f64::from(hz).powf(slope);
            assert!(
                (f64::from(found) / expected - 1.0).abs() < 1e-5,
                "{receptor:?} at {hz} Hz"
            );
        }
        for outside in [from, to * 1.0001] {
            assert_eq!(receptor.threshold_um(outside), None, "{receptor:?}");
        }
        // The two threshold lines differ by up to 5 % where they meet, because the paper rounds.
        let [below, above] = [bend, bend * 1.0001].map(|hz| receptor.threshold_um(hz).unwrap());
        assert!((below / above - 1.0).abs() < 0.05, "{receptor:?}");
    }
}

/// A vibration of 30 um at 40 Hz fills three bins. Each adds the logarithm of its amplitude over
/// the threshold.
#[test]
fn a_vibration_of_known_amplitude_is_a_sum_of_logarithms() {
    let firing = Firing::new(&sine(512, 20, 30.0), window(0.5));
    for (m, receptor) in Receptor::ALL.into_iter().enumerate() {
        let lines = [
            (38.0, 30.0 * 0.23 / 0.54),
            (40.0, 30.0),
            (42.0, 30.0 * 0.23 / 0.54),
        ];
        let decades = lines.map(|(hz, um): (f32, f32)| {
            let threshold = receptor.threshold_um(hz).expect("in its range");
            (um / threshold).log10().max(0.0)
        });
        let found = firing.intensity[m].expect("the rate is high enough");
        assert!(
            (found - decades.iter().sum::<f32>()).abs() < 2e-5,
            "{receptor:?}: {decades:?}"
        );
    }
    // 30 um are below FA I's threshold of 54 um; only the middle line is above SA II's 28 um.
    assert_eq!(firing.above, [0.0, 3.0, 3.0, 1.0]);
}

#[test]
fn a_receptor_out_of_the_spectrum_has_a_reason_and_no_intensity() {
    let (short, slow) = (Some(Absent::WindowTooShort), |hz| {
        Some(Absent::RateTooLow(hz))
    });
    // Number of bins, and their spacing in hertz.
    for (bins, bin_hz, expected) in [
        (512, 1601.0 / 1024.0, [None; 4]),
        (512, 1600.0 / 1024.0, [None, slow(1600.0), None, None]),
        (512, 241.0 / 1024.0, [None, slow(1600.0), None, slow(800.0)]),
        // The first bin is at 156 Hz.
        (32, 1e4 / 64.0, [short, None, short, None]),
    ] {
        let found = Receptor::ALL.map(|receptor| Firing::absent(receptor, bins, bin_hz));
        assert_eq!(found, expected, "{bins} bins of {bin_hz} Hz");
        let firing = Firing::new(&vec![1.0; bins], window(1.0 / bin_hz));
        assert_eq!(
            firing.intensity.map(|value| value.is_none()),
            expected.map(|why| why.is_some())
        );
    }
}

/// Tests section 3.2, with equations 5 and 6.
#[test]
fn the_papers_conversion() {
    let reference = Reference {
        ra_um: measured(0.278, 0.0),
        rsm_mm: 0.121,
        speed_mm_s: 10.0,
    };
    assert!((reference.frequency_hz() - 82.8).abs() < 0.2);
    let found = reference.per_um(measured(0.313, 0.0969));
    assert!((found.value - 0.564).abs() < 0.002);
    assert!((found.sigma / found.value - 0.0969 / 0.313).abs() < 1e-6);
}

/// Tests equations 11 and 12.
#[test]
fn the_papers_scores() {
    let mut covariance = [[0.0; 5]; 5];
    (covariance[2][2], covariance[4][4]) = (100.0, 0.01);
    let values = [Some(10.0), Some(900.0), Some(1200.0), Some(5.0), Some(1.1)];
    let mut indices = Indices { values, covariance };
    for (score, value, sigma) in [
        (SOFT, 5.59 - 2.4, 0.002 * 10.0),
        (ROUGH, -16.075 + 9.9 + 12.7963, 11.633 * 0.1),
    ] {
        let found = score.of(&indices).expect("a score");
        assert!(
            (found.value - value).abs() < 1e-4 && (found.sigma - sigma).abs() < 1e-5,
            "{found:?}"
        );
    }
    indices.values[4] = None;
    assert_eq!(
        (ROUGH.of(&indices), ROUGH.missing(&indices)),
        (None, Some(4))
    );
    assert!(SOFT.of(&indices).is_some());
}

/// Converts from half a second to three. A tone keeps its intensities; noise has six times as many
/// bins, with amplitudes smaller by the root of six.
#[test]
fn tones_and_noise_change_by_their_own_laws_with_the_window() {
    let indices = |spectrum: &[f32], windows| {
        let mut mean = MeanFiring::default();
        mean.push(&Firing::new(spectrum, windows));
        Indices::new(&mean, 0.0, Some(measured(1.2, 0.1)))
    };
    let tone = sine(512, 20, 300.0);
    let [own, wanted] = [window(0.5), CONVERTED].map(|windows| indices(&tone, windows));
    assert_eq!(own.values, wanted.values);
    // Noise narrower than a bin would have more bins, so sigma is larger.
    let sigma = |indices: &Indices| indices.get(Receptor::Sa1 as usize).unwrap().sigma;
    assert!(sigma(&wanted) > 2.0 * sigma(&own));

    let noise = [1e4; 512];
    let [own, wanted] = [window(0.5), CONVERTED].map(|windows| Firing::new(&noise, windows));
    for m in 0..4 {
        let bins = own.above[m];
        let expected = 6.0 * (own.intensity[m].unwrap() - 0.5 * bins * 6f32.log10());
        assert!(
            (wanted.intensity[m].unwrap() / expected - 1.0).abs() < 1e-4,
            "{m}"
        );
        assert_eq!(wanted.above[m], 6.0 * bins);
    }
}

/// A line keeps its amplitude, noise its power per hertz. Leakage must not be taken for an
/// amplitude.
#[test]
fn the_reference_needs_a_line() {
    let line = |amplitude, spectrum: &[f32]| SpectralLine::new(amplitude, spectrum, 20.0);
    let spectrum = sine(512, 20, 0.3);
    let found = SpectralLine::mean(&[line(0.3, &spectrum); 9], CONVERTED).expect("an amplitude");
    assert!(
        (found.value - 0.3).abs() < 1e-6 && found.sigma < 1e-6,
        "{found:?}"
    );
    let noise = SpectralLine::mean(&[line(0.3, &[0.3; 512])], CONVERTED).expect("an amplitude");
    assert!(
        (noise.value - 0.3 / 6f32.sqrt()).abs() < 1e-5 && noise.sigma > 0.05,
        "{noise:?}"
    );
    // A strong line elsewhere leaks more than this amplitude.
    assert_eq!(
        SpectralLine::mean(&[line(1e-4, &sine(512, 300, 1.0))], CONVERTED),
        None
    );
    assert_eq!(SpectralLine::mean(&[], CONVERTED), None);
}
