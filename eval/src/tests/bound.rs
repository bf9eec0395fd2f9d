//! The fit on the bound: its error over many windows, against what no estimator can do better.

use crate::bound::Clue;
use crate::simulated::Simulated;
use hal_mock::Sliding;
use ridgetone_tone::{CYCLES_FOR_SLOPE, Fitter, FrameSpan, Status, Table};

/// RMS error over bound, greatest error over bound, and windows in which no tone was found.
fn measure(scene: &Sliding, window_s: f64, runs: u64) -> (f64, f64, u64) {
    let mut fitter = Box::new(Fitter::new(4));
    let (mut squares, mut greatest, mut lost) = (0.0, 0f64, 0);
    for run in 0..runs {
        let scene = Sliding { seed: scene.seed + run, ..scene.clone() };
        let window = Simulated::new(&scene, window_s).expect("a window");
        let valid = vec![u16::MAX; window.values.len()];
        let mut table = Table { values: &window.values, valid: &valid };
        let fit = fitter
            .fit(&mut FrameSpan::new(&mut table, 0, valid.len() as u32).with_quantization(1.0))
            .expect("all frames are there");
        if fit.status != Status::Good {
            lost += 1;
            continue;
        }
        let slope = window.frequency_hz * window_s >= f64::from(CYCLES_FOR_SLOPE);
        let bound_hz = Clue::sum(&window.clues(slope, usize::MAX).expect("clues")).sigma_hz();
        let off = (f64::from(fit.frequency) * window.frame_rate_hz - window.frequency_hz) / bound_hz;
        squares += off * off;
        greatest = greatest.max(off.abs());
    }
    ((squares / (runs - lost) as f64).sqrt(), greatest, lost)
}

#[test]
fn the_fit_is_on_the_bound() {
    // The ratio of so many windows has a standard deviation of 1 / sqrt(2 n), 2 %.
    const RUNS: u64 = 1250;
    let mut off_bound = Vec::new();
    let settings = [0.3, 0.6, 1.0].map(|window_s| [10.0, 20.0, 40.0].map(|snr_db| (window_s, snr_db)));
    for ((window_s, snr_db), number) in settings.into_iter().flatten().zip(0..) {
        // Every setting has scenes of its own, so that chance does not befall all of them alike.
        let scene = Sliding { snr_db: Some(snr_db), seed: number * RUNS, ..Sliding::default() };
        let (ratio, greatest, lost) = measure(&scene, window_s, RUNS);
        let figures = format!("{window_s} s, {snr_db} dB: ratio {ratio:.3}, worst {greatest:.1}, {lost} lost");
        println!("{figures}");
        if !(0.9..=1.10).contains(&ratio) || lost > 0 {
            off_bound.push(figures);
        }
    }
    assert!(off_bound.is_empty(), "{off_bound:#?}");
}

/// Near one cycle the likelihood has summits besides the true one: none of them is taken for it.
#[test]
fn few_cycles_have_no_outliers() {
    for snr_db in [10.0, 40.0] {
        let scene = Sliding { speed_mm_s: 15.0, period_mm: 4.1, snr_db: Some(snr_db), seed: 0, ..Sliding::default() };
        let (ratio, greatest, lost) = measure(&scene, 0.3, 500);
        assert!(ratio <= 1.10 && greatest < 6.0 && lost == 0, "{snr_db} dB: {ratio}, {greatest}, {lost} lost");
    }
}
