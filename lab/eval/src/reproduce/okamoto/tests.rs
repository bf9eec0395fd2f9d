//! Single scales, the shipped figures, and the paper's own.

use super::errors::{Bound, Errors};
use super::motion::Motion;
use super::paper::{
    ACCURACY, FITTED_MM, LONGEST_S, POLYNOMIAL, SPEEDS_MM_S, WAVELENGTHS_MM, WINDOW_S,
};
use super::run::{FELT_LATE_S, Slid, settings};
use super::scan::{Scan, scan};
use super::skin::Skin;
use super::tables::polynomial;
use crate::tests::pages::tables;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::Status;
use serde_json::Value;

/// One scale at each kind of motion: the firmware is within half a percent where the window holds
/// 1.5 cycles, near the bound, and its intervals hold.
#[test]
fn a_scale_is_measured_within_half_a_percent() {
    for motion in [Motion::Steady(125.4), Motion::Hand] {
        let scans = scan(1.5, motion, Skin::Smooth).expect("a scan");
        let one_way = &scans[0];
        for errors in [one_way.short, one_way.long] {
            assert!(errors.good > 5 && errors.wrong == 0, "{one_way:?}");
            let rms = errors.rms().expect("an error");
            assert!(rms < 0.005, "{one_way:?}");
            // 24 windows or more: the root of 1 / (2 x 24) is 0.14. In two cycles a curved baseline
            // costs three quarters of the bound.
            assert!(
                errors
                    .bound()
                    .is_some_and(|bound| (0.7..2.0).contains(&(rms / bound))),
                "{one_way:?}"
            );
            assert!(
                errors.held_share().is_some_and(|share| share > 0.9),
                "{one_way:?}"
            );
        }
        assert!(one_way.fft.is_some_and(|rms| rms > 0.02), "{one_way:?}");
        assert_eq!(scans.len(), 1 + usize::from(motion == Motion::Hand));
        assert!(
            scans
                .iter()
                .all(|scan| scan.short.wrong + scan.long.wrong == 0)
        );
    }
}

/// At a constant speed, a bound of few windows is the closed form for a tone in white noise (Rife
/// and Boorstyn 1974, equation 21), but for some percent by the unknown offset and slope.
#[test]
fn the_bound_is_the_closed_form_of_a_tone() {
    let motion = Motion::Steady(177.4);
    let slid = Slid::new(2.0, motion, Skin::Smooth).expect("a scan");
    let bound = Bound::new(&slid).expect("a bound");
    let frames = 187.0;
    let (window_s, frequency_hz) = (frames / f64::from(Plan::HAND.frame_rate_hz()), 177.4 / 2.0);
    // Amplitudes by the root mean square of the frames about the mean of a cycle: no least squares.
    let cycle = (f64::from(Plan::HAND.frame_rate_hz()) / frequency_hz).round() as usize;
    let own: Vec<_> = slid
        .frames
        .iter()
        .filter(|(t_s, _)| (0.3..0.7).contains(t_s))
        .collect();
    let power = |taxel: usize| {
        let values: Vec<f64> = own.iter().map(|(_, values)| values[taxel]).collect();
        let squares: Vec<f64> = values
            .windows(cycle)
            .map(|cycle| {
                let mean = cycle.iter().sum::<f64>() / cycle.len() as f64;
                cycle
                    .iter()
                    .map(|value| (value - mean).powi(2))
                    .sum::<f64>()
                    / cycle.len() as f64
            })
            .collect();
        squares.iter().sum::<f64>() / squares.len() as f64
    };
    // The noise at DRATE 3, 12 uV.
    let eta: f64 = (0..16).map(|taxel| power(taxel) / 12e-6f64.powi(2)).sum();
    let omega = (12.0 / (eta * frames * (frames * frames - 1.0))).sqrt();
    let closed = omega * frames / window_s / (std::f64::consts::TAU * frequency_hz);
    let ratio = bound.share(motion, 0.3, 0.3 + window_s) / closed;
    assert!((0.97..1.05).contains(&ratio), "{ratio}");
}

/// What the finger's delay costs: over its speed v a finger with the acceleration a errs by a t /
/// v, so that a delay of 0.43 ms that nobody takes off is 0.3 % where a hand of 100 mm/s slows down
/// by 700 mm/s^2.
#[test]
fn places_have_to_be_those_that_the_finger_feels() {
    let slid = Slid::new(2.0, Motion::Hand, Skin::Smooth).expect("a scan");
    let bound = Bound::new(&slid).expect("a bound");
    let errors = |late_s: f64| {
        let answers = slid
            .answers(settings(slid.skin, WINDOW_S, 0.0), late_s)
            .expect("answers");
        Errors::new(&slid, &answers, &bound, false)
    };
    let (felt, as_they_are) = (errors(FELT_LATE_S), errors(0.0));
    assert!(
        felt.rms_over_sigma().is_some_and(|over| over < 1.3),
        "{felt:?}"
    );
    println!(
        "over sigma {:?}, of places as they are {:?}",
        felt.rms_over_sigma(),
        as_they_are.rms_over_sigma()
    );
    assert!(
        as_they_are.rms_over_sigma().is_some_and(|over| over > 5.0),
        "{as_they_are:?}"
    );
    assert!(
        as_they_are
            .rms()
            .is_some_and(|rms| (0.001..0.005).contains(&rms)),
        "{as_they_are:?}"
    );
}

/// Medians of a hand's errors over the bounds in the longer window, as they are and with the
/// low-pass's dispersion, which the fit takes off.
fn dispersed(wavelength_mm: f64, skin: Skin) -> [f64; 2] {
    let slid = Slid::new(wavelength_mm, Motion::Hand, skin).expect("a scan");
    let bound = Bound::new(&slid).expect("a bound");
    let answers = slid
        .answers(settings(skin, LONGEST_S, ACCURACY), FELT_LATE_S)
        .expect("answers");
    let mut over_bound = [Vec::new(), Vec::new()];
    for (off, from_s, until_s) in slid.one_way(&answers) {
        let dispersed = bound.dispersion_share(slid.motion, from_s, until_s);
        let share = bound.share(slid.motion, from_s, until_s);
        for (all, off) in over_bound.iter_mut().zip([off, off + dispersed]) {
            all.push((off / share).abs());
        }
    }
    let over_bound = over_bound.map(|mut all| {
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    });
    println!("{skin:?}, {wavelength_mm} mm: over the bound {over_bound:.2?}");
    over_bound
}

/// A hand's longer windows are near the bound at 3 mm too (the median of a normal deviate's size is
/// 0.67): the low-pass's delay gets shorter as the tone gets higher, and the fit knows.
#[test]
fn a_hands_tones_are_free_of_the_low_passes_dispersion() {
    for wavelength_mm in [2.5, 3.0] {
        let [as_it_is, with] = dispersed(wavelength_mm, Skin::Smooth);
        assert!(
            as_it_is < 1.3 && with > 1.1 * as_it_is,
            "{wavelength_mm} mm: {as_it_is:.2} {with:.2}"
        );
    }
}

/// Under the ridged skin a hand's tones are up to 60 times as strong, and the same dispersion would
/// be most of the error where tones are fast. The bound is a few millionths of the wavelength there,
/// and some windows are off by ten times as much: the amplitude moves too.
#[test]
fn under_ridges_the_dispersion_would_be_most_of_fast_tones_errors() {
    for wavelength_mm in [0.5, 1.0, 1.6] {
        let [as_it_is, with] = dispersed(wavelength_mm, Skin::Ridged);
        assert!(
            as_it_is < 2.0 && with > 1.9 * as_it_is,
            "{wavelength_mm} mm: {as_it_is:.2} {with:.2}"
        );
    }
}

/// The low-pass's delay and a turn in the first frames do not make a `good` window wrong; half a
/// cycle does in less than one of a hundred. Where the hand turns within the window friction's step
/// is no part of the model: errors are small, but intervals hold in some seven of ten windows only.
#[test]
fn by_hand_under_ridges_intervals_hold_and_nothing_is_wrong() {
    let (mut good, mut held, mut windows, mut wrong) = (0.0, 0.0, 0, 0);
    for wavelength_mm in [0.5, 1.4, 3.0] {
        for scan in scan(wavelength_mm, Motion::Hand, Skin::Ridged).expect("a scan") {
            for errors in [scan.short, scan.long] {
                assert!(errors.rms().is_none_or(|rms| rms < 0.0025), "{scan:?}");
                windows += errors.windows;
                wrong += errors.wrong;
                if scan.is_turning {
                    continue;
                }
                // If 95 % of 60 windows hold, 52 or fewer do in one of a hundred cells.
                assert!(
                    errors.held_share().is_none_or(|share| share > 0.87),
                    "{scan:?}"
                );
                good += errors.good as f64;
                held += errors.held_share().unwrap_or_default() * errors.good as f64;
            }
        }
    }
    println!("{held:.0} of {good} hold, {wrong} of {windows} good and wrong");
    assert!(held > 0.92 * good, "{held} of {good}");
    assert!(100 * wrong <= windows, "{wrong} of {windows}");
}

/// What else keeps errors under ridges above the bound: where the skin's and the grating's periods
/// meet, odd overtones reach the sensors too, and the fifth is beyond the four that are fitted.
#[test]
fn where_the_periods_meet_overtones_beyond_the_fourth_matter() {
    let slid = Slid::new(1.2, Motion::Steady(73.5), Skin::Ridged).expect("a scan");
    let bound = Bound::new(&slid).expect("a bound");
    let over_bound = |harmonics: u8| {
        let settings = Settings {
            harmonics,
            ..settings(Skin::Ridged, LONGEST_S, 0.0)
        };
        let answers = slid.answers(settings, FELT_LATE_S).expect("answers");
        let windows = answers.iter().filter(|one| one.status == Status::Good);
        let mut all: Vec<_> = windows
            .map(|one| {
                let off = 73.5 / (one.frequency * 1.2) - 1.0;
                (off / bound.share(slid.motion, one.from_s, one.until_s)).abs()
            })
            .collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    let (four, five) = (over_bound(4), over_bound(5));
    println!("{four:.2} bounds with four harmonics, {five:.2} with five");
    assert!(four > 1.5 && five < 0.7 * four, "{four} {five}");
}

/// The figures of this paper as the page has them.
fn shipped(name: &str) -> Vec<Vec<Value>> {
    tables("papers-runs")[name].rows.clone()
}

/// What the text of the page says of the firmware: within 1 % everywhere, where the paper's method
/// errs by 1 to 20 %; near the bound under the smooth skin but for one scale, in whose last window
/// it brakes; never wrong and good, and with intervals that hold.
#[test]
fn the_figures_are_as_the_text_says() {
    let rows = shipped("okamoto_wavelengths");
    assert_eq!(rows.len(), 2 * 5 * WAVELENGTHS_MM.len());
    let mut beyond_bound = Vec::new();
    for row in &rows {
        assert_eq!(row[16], 0, "wrong but good: {row:?}");
        let (skin, wavelength_mm) = (&row[0], row[2].as_f64().expect("mm"));
        let is_turning = row[1] == "hand, turning";
        for cells in [&row[4..10], &row[10..16]] {
            let (Some(bound), Some(firmware)) = (cells[0].as_f64(), cells[1].as_f64()) else {
                continue;
            };
            let (good, windows) = (cells[2].as_f64().expect("n"), cells[3].as_f64().expect("n"));
            assert!(firmware < 1.0, "{row:?}");
            if is_turning || skin == "ridged" {
                // Overtones and friction that are not fitted count: no bound has them.
                continue;
            }
            if wavelength_mm > 0.5 {
                // An RMS of 14 windows has a standard error of a fifth.
                assert!(good < 14.0 || firmware > 0.5 * bound, "{row:?}");
                if good >= 14.0 && firmware > 1.6 * bound {
                    beyond_bound.push(row);
                }
                assert!(good >= 0.8 * windows, "{row:?}");
            } else {
                // Ridges of 0.6 mm hide a grating of 0.5 mm: slides are seldom found.
                assert!(windows < 5.0, "{row:?}");
            }
        }
        // Fewer than 1.5 cycles in 32 ms: no window of the firmware counts either.
        let most = if row[7] == 0 { 42.0 } else { 20.0 };
        let is_fft =
            |fft: f64| (1.0..=most).contains(&fft) || skin == "smooth" && wavelength_mm == 0.5;
        assert!(row[3].as_f64().is_none_or(is_fft), "{row:?}");
    }
    for row in shipped("okamoto_motions") {
        for held in [&row[6], &row[10]] {
            assert!(held.as_f64().is_none_or(|held| held > 93.0), "{row:?}");
        }
    }
    let one = |row: &Vec<Value>| row[1] == "125.4 mm/s" && row[2] == 1.6;
    assert!(
        beyond_bound.len() == 1 && beyond_bound.into_iter().all(one),
        "the text names one scale"
    );
}

/// The maximum of power is where the page and the paper say, and only with ridges.
#[test]
fn the_figures_have_the_papers_maximum_under_the_ridged_skin_alone() {
    let powers = |skin: &str| -> Vec<(f64, f64)> {
        let rows = shipped("okamoto_powers")
            .into_iter()
            .filter(|row| row[0] == skin);
        rows.filter_map(|row| Some((row[1].as_f64()?, row[3].as_f64()?)))
            .collect()
    };
    let ridged = powers("ridged");
    let greatest = ridged
        .iter()
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .expect("powers");
    assert!([1.4, 1.6].contains(&greatest.0), "{ridged:?}");
    let at = |mm: f64| {
        ridged
            .iter()
            .find(|power| power.0 == mm)
            .expect("a power")
            .1
    };
    // Twice that of 1 mm, 2.7 times that of 2 mm, and the least beyond it at 2.5 mm.
    assert!(
        (2.0..2.4).contains(&(at(1.4) / at(1.0))) && (2.6..2.8).contains(&(at(1.4) / at(2.0))),
        "{ridged:?}"
    );
    assert!(at(2.5) < at(2.0) && at(2.5) < at(3.0), "{ridged:?}");
    assert!(
        powers("smooth")
            .windows(2)
            .all(|pair| pair[0].1 < pair[1].1)
    );
    let r2 = |row: usize| {
        shipped("okamoto_polynomials")[row][6]
            .as_f64()
            .expect("R^2")
    };
    assert!(
        (r2(1) - 0.9133).abs() < 5e-4 && r2(0) == 0.94,
        "{} {}",
        r2(0),
        r2(1)
    );
}

/// Against the powers that the paper gives for four of its gratings.
#[test]
fn the_papers_polynomial_has_its_maximum() {
    let of = |mm: f64| {
        POLYNOMIAL
            .iter()
            .rev()
            .fold(0.0, |sum, factor| sum * mm + factor)
    };
    for (mm, power) in [(0.8, 703.0), (1.4, 2740.0), (1.7, 2091.0), (2.0, 4410.0)] {
        assert!((of(mm) - power).abs() < 1.0, "{mm} mm: {}", of(mm));
    }
}

/// Powers that follow equation 2 at every speed give its polynomial again.
#[test]
fn powers_of_the_papers_equation_give_its_polynomial() {
    let of = |mm: f64| {
        30_770.0 * mm.powi(4) - 162_663.0 * mm.powi(3) + 309_743.0 * mm * mm - 248_938.0 * mm
            + 72_298.0
    };
    let scan = |wavelength_mm: f64, speed_mm_s: f64| Scan {
        wavelength_mm,
        motion: Motion::Steady(speed_mm_s),
        skin: Skin::Ridged,
        is_turning: false,
        fft: None,
        short: Errors::default(),
        long: Errors::default(),
        power_mv2: FITTED_MM
            .contains(&wavelength_mm)
            .then(|| 3e-5 * of(wavelength_mm)),
    };
    let all: Vec<Scan> = WAVELENGTHS_MM
        .iter()
        .flat_map(|mm| SPEEDS_MM_S.map(|speed| scan(*mm, speed)))
        .collect();
    let (factors, r2) = polynomial(&all, Skin::Ridged).expect("a polynomial");
    for (factor, paper) in factors.into_iter().zip(POLYNOMIAL) {
        assert!((factor / (3e-5 * paper) - 1.0).abs() < 1e-6, "{factors:?}");
    }
    assert!((r2 - 1.0).abs() < 1e-9, "{r2}");
}
