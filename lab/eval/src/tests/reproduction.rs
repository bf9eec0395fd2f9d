//! The reproduction: that its figures are those of the scenes, and that the page is what was
//! measured.

use super::from_root;
use crate::page::{self, Figures, fixed};
use crate::parallel;
use crate::reproduce;
use crate::reproduce::measure::{combinations, firmware};
use crate::reproduce::paper::{LENGTH_MM, TABLE_3};
use crate::reproduce::protocol::{Imperfect, scene};
use crate::reproduce::results::{Combination, Reproduction, Run, Windows, rms};
use crate::reproduce::taken::{Place, Taken};
use hal_mock::{Sliding, SlidingScene, TABLE_2};
use std::sync::OnceLock;

fn shipped() -> Reproduction {
    page::load(&from_root("docs/results"), reproduce::TOPIC)
        .expect("the data")
        .detail
}

/// C7 and C10, the two shortest, one run each.
fn reduced() -> &'static Reproduction {
    static REDUCED: OnceLock<Reproduction> = OnceLock::new();
    REDUCED.get_or_init(|| reproduce::measure_some(&[6, 9], 1, Place::Pc).expect("a run"))
}

/// Straight line through the ten least-squares errors of the paper's Table 3, percent, by numpy's
/// polyfit.
fn speed_error_percent(speed_mm_s: f64) -> f64 {
    0.591_111 + 0.019_053_95 * speed_mm_s
}

fn runs(reproduction: &Reproduction) -> impl Iterator<Item = (&Combination, &Run)> {
    reproduction
        .combinations
        .iter()
        .flat_map(|combination| combination.runs.iter().map(move |run| (combination, run)))
}

#[test]
fn every_method_finds_the_scenes_own_frequency() {
    for (combination, run) in runs(reduced()) {
        let Combination {
            speed_mm_s,
            period_mm,
            ..
        } = combination;
        // The scene's truth: speed over period, too fast by the line, and by a scatter of 0.17 % at
        // most 1.35 times.
        let nominal_hz = speed_mm_s / period_mm;
        let off_percent = 100.0 * (run.true_hz / nominal_hz - 1.0);
        assert!(
            (off_percent - speed_error_percent(*speed_mm_s)).abs() < 1.35 * 0.17,
            "{off_percent}"
        );
        let near = |hz: f64, percent: f64| (hz / run.true_hz - 1.0).abs() < 0.01 * percent;
        for pair in run.pairs {
            assert!(
                near(pair.least_squares_hz.expect("an estimate"), 0.1),
                "{run:?}"
            );
            // Naive Fourier analysis: within half a line, and an average of two lines (equation 6).
            let line_hz = speed_mm_s / 55.0;
            assert!(
                (pair.fft_hz.expect("an estimate") - run.true_hz).abs() < 0.55 * line_hz,
                "{run:?}"
            );
        }
        let (hz, sigma_hz) = run.all_fit_hz.expect("an estimate");
        assert!(near(hz, 0.05) && sigma_hz < 0.001 * hz, "{run:?}");
        let firmware = run.firmware.expect("a slide");
        assert!(near(firmware.tone_hz.expect("a tone").0, 0.05), "{run:?}");
        assert!(
            (firmware.slide_s.0 - run.true_slide_s.0).abs() < 0.02,
            "{run:?}"
        );
        // One run has nothing to be compared with.
        assert_eq!(combination.repeatability, None);
    }
}

#[test]
fn without_imperfections_there_is_no_error_to_speak_of() {
    let causes = &reduced().causes;
    let of = |name: &str| {
        causes
            .iter()
            .find(|cause| cause.name == name)
            .expect("a cause")
    };
    let (nothing, speed, all) = (of("nothing"), of("mean speed"), of("all of it"));
    assert!(
        nothing.least_squares_percent < 0.05 && nothing.all_percent < 0.05,
        "{nothing:?}"
    );
    // Both are at 48 mm/s, in the run whose scatter is -1 / sqrt(5) of 0.166 %.
    let put_in = speed_error_percent(48.0) - 0.1664 / 5f64.sqrt();
    for percent in [
        speed.least_squares_percent,
        speed.all_percent,
        all.least_squares_percent,
        all.all_percent,
    ] {
        assert!((percent - put_in).abs() < 0.1, "{percent} of {put_in}");
    }
}

#[test]
fn a_longer_window_errs_less_and_windows_are_counted() {
    for combination in &reduced().combinations {
        assert_eq!(combination.windows.len(), 17);
        let (first, last) = (&combination.windows[0], &combination.windows[16]);
        assert_eq!((first.window_s, last.window_s), (0.2, 1.0));
        // Starts every 50 ms in 55 mm at 48 mm/s, 1.1458 s: up to 0.9458 s and up to 0.1458 s after
        // the first.
        assert_eq!((first.windows, last.windows), (19, 3));
        assert!(last.own_least_squares_hz < first.own_least_squares_hz);
        assert!(last.own_all_hz < first.own_all_hz);
    }
}

#[test]
fn static_images_are_what_the_grating_at_rest_makes() {
    for (combination, run) in runs(reduced()) {
        let Combination {
            speed_mm_s,
            period_mm,
            ..
        } = *combination;
        let scene = Sliding {
            speed_mm_s,
            period_mm,
            reverse: true,
            ..Sliding::physical()
        };
        let scene = SlidingScene::new(scene).expect("a scene");
        let truth = scene.truth();
        // The imperfect stimulator slides 60 mm too, so that the grating comes to rest at the same
        // place.
        for (image, t_s) in run
            .images_v
            .iter()
            .zip([truth.slide_start_s - 0.1, truth.release_s - 0.1])
        {
            assert_eq!(image.len(), 16);
            for (taxel, volts) in (0..).zip(image) {
                let elastic_v =
                    scene.clean_volts(taxel, t_s) - scene.channels()[usize::from(taxel)].offset_v;
                // The skin has crept by up to 5 %; the noise of 0.9 mV is a mean of 72 readings or
                // more, less one of 48.
                let room_v =
                    0.06 * elastic_v.abs() + 4.0 * 0.9e-3 * (1.0 / 72.0 + 1.0 / 48.0_f64).sqrt();
                assert!(
                    (volts - elastic_v).abs() < room_v,
                    "{taxel}: {volts} V, not {elastic_v} V"
                );
            }
        }
        // Piezoresistors 1 and 3 of unit 1 at rest under a ridge ahead of them: opposite signs
        // (Figure 10).
        assert!(run.images_v[0][0] < 0.0 && run.images_v[0][2] > 0.0);
    }
}

/// The figures in the text of the page.
#[test]
fn the_text_is_right() {
    let shipped = shipped();
    let nothing = &shipped.causes[0];
    assert!(
        nothing.least_squares_percent < 0.05 && nothing.all_percent < 0.05,
        "the error is the stimulator's"
    );
    let mut sums = [0.0; 2];
    for (c, combination) in shipped.combinations.iter().enumerate() {
        let percent = |hz: Option<f64>| combination.percent(hz.expect("an estimate"));
        let least_squares = |run: &Run| run.pairs[0].least_squares_hz;
        for (pair, paper) in TABLE_3.iter().enumerate() {
            let here = percent(combination.rms_hz(|run| run.pairs[pair].least_squares_hz));
            assert!(
                (here - paper.least_squares.percent[c]).abs() < 0.4,
                "C{}",
                c + 1
            );
        }
        let (two, all) = (least_squares, |run: &Run| run.all_fit_hz.map(|fit| fit.0));
        let own = [
            percent(combination.own_rms_hz(two)),
            percent(combination.own_rms_hz(all)),
        ];
        assert!(own.iter().all(|own| *own < 0.1), "C{}: {own:?}", c + 1);
        sums = [0, 1].map(|i| sums[i] + own[i]);
        let [one, two] = combination.repeatability.expect("four runs");
        assert!((0.86..0.98).contains(&one) && two < one, "C{}", c + 1);
        let at_04 = combination
            .windows
            .iter()
            .find(|window| window.window_s == 0.4)
            .expect("a window");
        assert!(percent(Some(at_04.least_squares_hz)) < 2.0, "C{}", c + 1);
        // One and a half cycles and more.
        assert!(
            10 * at_04.all_found > 9 * at_04.windows,
            "C{}: {at_04:?}",
            c + 1
        );
        for run in &combination.runs {
            let firmware = run.firmware.expect("a slide");
            let (hz, _) = firmware.tone_hz.expect("a tone");
            assert!((hz / run.true_hz - 1.0).abs() < 0.0005, "{firmware:?}");
            let ((start_s, end_s), (true_start_s, true_end_s)) =
                (firmware.slide_s, run.true_slide_s);
            assert!(
                (start_s - true_start_s).abs() < 0.01 && (end_s - true_end_s).abs() < 0.05,
                "{firmware:?}"
            );
        }
    }
    assert!(sums[1] < sums[0], "sixteen channels are nearer: {sums:?}");
    for cell in &shipped.expected {
        let nominal_hz = cell.speed_mm_s / cell.period_mm;
        assert!(
            (cell.firmware_hz.expect("a tone") / nominal_hz - 1.0).abs() < 1e-5,
            "{cell:?}"
        );
    }
    for (pair, paper) in TABLE_3.iter().enumerate() {
        let is_close = |(c, combination): &(usize, &Combination)| {
            let here_hz = combination
                .rms_hz(|run| run.pairs[pair].fft_hz)
                .expect("an estimate");
            (here_hz - paper.fft.hz[*c]).abs() * LENGTH_MM / combination.speed_mm_s < 0.2
        };
        assert!(
            shipped
                .combinations
                .iter()
                .enumerate()
                .filter(is_close)
                .count()
                >= 7
        );
    }
}

#[test]
fn static_images_depend_on_the_grating_and_not_on_the_speed() {
    let shipped = shipped();
    let (mut same_mv, mut other_mv) = (Vec::new(), Vec::new());
    for (n, a) in shipped.combinations.iter().enumerate() {
        for b in &shipped.combinations[..n] {
            let [one, two] = [a, b].map(|combination| &combination.runs[0].images_v[0]);
            let apart = rms(one.iter().zip(two).map(|(a, b)| Some(1e3 * (a - b)))).expect("images");
            if a.period_mm == b.period_mm {
                same_mv.push(apart)
            } else {
                other_mv.push(apart)
            }
        }
    }
    assert!(same_mv.iter().all(|apart| *apart < 0.3) && other_mv.iter().all(|apart| *apart > 0.6));
}

#[test]
fn the_tables_have_what_was_measured() {
    let figures = reproduce::figures(reduced().clone(), Figures::default());
    let rows = &figures.tables["oddo_table_3"].rows;
    for ((combination, run), row) in runs(reduced()).zip(rows) {
        let nominal_hz = combination.nominal_hz();
        let percent = |hz: Option<f64>| {
            let hz = hz.expect("an estimate");
            fixed(100.0 * (hz - nominal_hz).abs() / nominal_hz, 2)
        };
        assert_eq!(row[0], combination.name());
        assert_eq!(row[3], percent(run.pairs[0].fft_hz));
        assert_eq!(row[5], percent(run.pairs[0].least_squares_hz));
    }
    assert_eq!(rows.len(), 2);
    let svg = reproduce::picture(reduced());
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    let shipped = shipped();
    let runs = shipped
        .combinations
        .iter()
        .map(|combination| combination.runs.len());
    assert_eq!((shipped.expected.len(), runs.sum::<usize>()), (12, 40));
}

/// The last digits may differ between platforms.
fn close(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-6
}

#[test]
fn the_shipped_data_are_what_a_run_gives() {
    // The first runs of the two shortest combinations stand for all: whatever changes the scenes,
    // the path or the methods over a whole slide changes them.
    let shipped = shipped();
    for (combination, run) in runs(reduced()) {
        let own = shipped
            .combinations
            .iter()
            .find(|own| own.nominal_hz() == combination.nominal_hz());
        let own = &own.expect("the same combination").runs[0];
        let figures = |run: &Run| -> Vec<f64> {
            let pairs = run
                .pairs
                .into_iter()
                .flat_map(|pair| [pair.fft_hz, pair.least_squares_hz]);
            let firmware = run.firmware.expect("a slide");
            let all = [
                run.all_fft_hz,
                run.all_fit_hz.map(|fit| fit.0),
                firmware.tone_hz.map(|tone| tone.0),
            ];
            let times = [firmware.contact_s, firmware.slide_s.0, firmware.slide_s.1].map(Some);
            pairs
                .chain(all)
                .chain(times)
                .map(|figure| figure.expect("an estimate"))
                .collect()
        };
        for (now, then) in figures(run).into_iter().zip(figures(own)) {
            assert!(
                now == then || close(now, then),
                "{now} is not {then}: run `cargo xtask reproduce`"
            );
        }
    }
}

#[test]
fn the_firmware_finds_the_slides_of_all_forty_runs() {
    let runs: Vec<(usize, u32)> = (0..TABLE_2.len())
        .flat_map(|c| (0..4).map(move |run| (c, run)))
        .collect();
    let found = parallel::map("runs", &runs, |(c, run)| {
        let (speed_mm_s, period_mm) = TABLE_2[*c];
        let scene = scene(speed_mm_s, period_mm, *run, Imperfect::ALL);
        let taken = Taken::new(scene, Place::Pc)?;
        Ok((firmware(&taken), taken.truth))
    });
    for ((c, run), (found, truth)) in runs.iter().zip(found.expect("runs")) {
        let found = found.unwrap_or_else(|| panic!("C{} run {run}: no slide", c + 1));
        let (start_s, end_s) = found.slide_s;
        assert!(
            (start_s - truth.slide_start_s).abs() < 0.02,
            "C{} run {run}: {found:?}",
            c + 1
        );
        assert!(
            (end_s - truth.slide_end_s).abs() < 0.03,
            "C{} run {run}: {found:?}",
            c + 1
        );
        let (tone_hz, _) = found.tone_hz.expect("a tone");
        assert!(
            (tone_hz / truth.frequency_hz - 1.0).abs() < 5e-4,
            "C{} run {run}: {found:?}",
            c + 1
        );
    }
}

#[test]
fn the_shipped_windows_are_what_runs_give() {
    // Whole slides do not show short windows: C3 has 0.7 to 3.7 cycles in them, C7 3.1 to 15.5.
    let shipped = shipped();
    let runs = shipped.combinations[2].runs.len() as u32;
    let measured = combinations(&[2, 6], runs, Place::Pc).expect("runs");
    for now in measured {
        let then = shipped
            .combinations
            .iter()
            .find(|then| then.nominal_hz() == now.nominal_hz());
        let then = then.expect("the same combination");
        assert_eq!(now.windows.len(), then.windows.len());
        for (now, then) in now.windows.iter().zip(&then.windows) {
            let counts = |w: &Windows| (w.windows, w.all_found);
            assert_eq!(
                counts(now),
                counts(then),
                "{then:?}: run `cargo xtask reproduce`"
            );
            let figures = |w: &Windows| {
                let all = [w.all_hz, w.own_all_hz].map(|hz| hz.unwrap_or(0.0));
                [
                    w.window_s,
                    w.fft_hz,
                    w.least_squares_hz,
                    w.own_least_squares_hz,
                    all[0],
                    all[1],
                ]
            };
            for (now, then) in figures(now).into_iter().zip(figures(then)) {
                assert!(
                    now == then || close(now, then),
                    "{now} is not {then}: run `cargo xtask reproduce`"
                );
            }
        }
        let correlations = now
            .repeatability
            .into_iter()
            .flatten()
            .zip(then.repeatability.into_iter().flatten());
        assert_eq!(correlations.clone().count(), 2);
        for (now, then) in correlations {
            assert!(
                now == then || close(now, then),
                "{now} is not {then}: run `cargo xtask reproduce`"
            );
        }
    }
}
