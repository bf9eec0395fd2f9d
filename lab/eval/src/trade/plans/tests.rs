//! The plans against closed forms, the simulated chip, and the datasheet's arithmetic.

use super::accuracy::{TONES_HZ, window};
use super::{Choice, EIGHT, measure, on_board};
use crate::simulated::{CODE_V, converter_noise_v};
use crate::tests::from_root;
use crate::trade::load;
use hal_mock::Constant;
use ridgetone_finger::converter::Ads1258Plan;
use ridgetone_host::input::{Input, Opened};
use ridgetone_host::replay::conversions_of;
use ridgetone_proto::plan::Plan;
use std::f64::consts::TAU;

/// Rife and Boorstyn (1974), equation 21, for real tones: var(omega) = 12 / (eta N (N^2 - 1)), eta
/// the sum over the channels of A^2 / (2 sigma^2). It leaves out the term of twice the frequency, a
/// share of 1 / (2 pi cycles), 1.2 % here; unknown offset and slope cost as much.
#[test]
fn the_bound_of_a_plan_is_the_closed_form_of_its_channels() {
    for plan in [Plan::HAND, EIGHT, Plan::TEXTURE, Plan::PAPER] {
        let (window, clue) = window(
            Choice {
                plan,
                window_s: 0.128,
            },
            100.0,
            7,
        )
        .expect("a window");
        let own = (0..16).filter(|taxel| plan.inputs >> taxel & 1 == 1);
        let eta: f64 = own
            .map(|taxel| {
                let channel = &window.channels[taxel];
                let fundamental = channel.harmonics[0];
                0.5 * (fundamental.cos.hypot(fundamental.sin) / channel.sigma).powi(2)
            })
            .sum();
        let n = window.values.len() as f64;
        let closed_hz = (12.0 / (eta * n * (n * n - 1.0))).sqrt() * window.frame_rate_hz / TAU;
        let ratio = clue.sigma_hz() / closed_hz;
        assert!((0.988..1.024).contains(&ratio), "{plan:?}: {ratio}");
    }
}

/// The tone is the same in volts for each plan: 20 dB over 12 uV, on average over all sixteen
/// taxels.
#[test]
fn the_tone_is_the_same_for_each_plan() {
    for plan in [Plan::PAPER, Plan::HAND, Plan::SINGLE] {
        let (window, _) = window(
            Choice {
                plan,
                window_s: 0.128,
            },
            80.0,
            3,
        )
        .expect("a window");
        let power =
            |harmonic: &crate::bound::Harmonic| 0.5 * (harmonic.cos.powi(2) + harmonic.sin.powi(2));
        let mean = window
            .channels
            .iter()
            .map(|channel| power(&channel.harmonics[0]))
            .sum::<f64>()
            / 16.0;
        assert!(
            (mean.sqrt() * CODE_V / 120e-6 - 1.0).abs() < 1e-9,
            "{plan:?}"
        );
        let is_used = |taxel: usize| plan.inputs >> taxel & 1 == 1;
        assert!((0..16).all(
            |taxel| window.values.iter().any(|values| values[taxel] != 0.0) == is_used(taxel)
        ));
    }
}

/// The simulated chip has the datasheet's table for itself.
#[test]
fn the_noise_is_that_of_the_simulated_chip() {
    for data_rate in 0..=3 {
        let plan = Ads1258Plan {
            data_rate,
            ..Ads1258Plan::of(&Plan::SINGLE)
        }
        .plan();
        let opened = Input::default().open_in(&plan).expect("an input");
        let input = Opened {
            scene: Box::new(Constant::default()),
            ..opened
        };
        let mut codes = Vec::new();
        // An error ends the scan, which would go on for ever.
        let _ = conversions_of(input, &plan, &mut |timed| {
            // AIN0 has the id 8 (SBAS297G).
            codes.extend((timed.status().chid() == 8).then(|| f64::from(timed.code())));
            anyhow::ensure!(codes.len() < 4000, "enough");
            Ok(())
        });
        let mean = codes.iter().sum::<f64>() / codes.len() as f64;
        let variance =
            codes.iter().map(|code| (code - mean).powi(2)).sum::<f64>() / codes.len() as f64;
        // The standard deviation of 4000 values has an error of 1.1 %.
        let ratio = variance.sqrt() * CODE_V / converter_noise_v(&plan);
        assert!((ratio - 1.0).abs() < 0.05, "DRATE {data_rate}: {ratio}");
    }
}

#[test]
fn every_choice_is_allowed_and_follows_every_tone() {
    let all = Choice::all();
    for choice in &all {
        assert_eq!(choice.settings().validate(), Ok(()), "{choice:?}");
        let nyquist_hz = f64::from(choice.plan.gives().nyquist_hz);
        assert!(
            TONES_HZ
                .iter()
                .all(|tone_hz| *tone_hz < 0.9 * nyquist_hz && tone_hz * choice.window_s >= 2.0)
        );
    }
    // Every fast plan makes the chip's most conversions by this crystal: 15.72864 MHz / (128 x
    // 5.265625).
    let fast = all.iter().filter(|choice| choice.plan != Plan::PAPER);
    for plan in fast.map(|choice| choice.plan) {
        let conversions_hz = f64::from(plan.frame_rate_hz()) * plan.channels() as f64;
        assert!((conversions_hz / 23_336.3 - 1.0).abs() < 1e-5, "{plan:?}");
    }
}

/// Near the bound in each choice, and the longer the window the less the error.
#[test]
fn errors_are_near_the_bound_and_fall_with_the_window() {
    let rows = measure(10, false).expect("rows");
    assert_eq!(rows.len(), Choice::all().len());
    for row in &rows {
        let error = row.accuracy.error.expect("an error");
        // A ratio of 40 windows has a standard deviation of 0.11. The shortest window has 2.9 cycles of
        // the slowest tone.
        let most = if row.window_s < 0.2 { 1.8 } else { 1.3 };
        assert!(
            row.accuracy.windows == 40 && (0.75..most).contains(&error.ratio),
            "{row:?}"
        );
        // One channel alone in three cycles may be ambiguous.
        let least = if row.channels == 1 { 36 } else { 39 };
        assert!(row.accuracy.good >= least, "{row:?}");
    }
    for (short, long) in rows
        .iter()
        .zip(&rows[1..])
        .filter(|(a, b)| a.plan == b.plan)
    {
        let rms_hz = |row: &super::Row| row.accuracy.error.map_or(f64::NAN, |error| error.rms_hz);
        assert!(
            short.window_s < long.window_s && rms_hz(long) < rms_hz(short),
            "{short:?}, {long:?}"
        );
    }
}

/// One row again; compilers differ a little.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_pages_load_and_latency_are_those_of_the_image() {
    let rows = load(&from_root("docs/results")).expect("the data").plans;
    let choice = Choice {
        plan: Plan::HAND,
        window_s: 0.064,
    };
    let row = rows
        .iter()
        .find(|row| row.plan == "hand" && row.window_s == choice.window_s)
        .expect("a row");
    let (page, fresh) = (
        row.board.expect("a board"),
        on_board::measure(&on_board::image().expect("an image"), choice),
    );
    let fresh = fresh.expect("a run");
    for (page, fresh) in [
        (page.load, fresh.load),
        (page.fit_s, fresh.fit_s),
        (page.late_s, fresh.late_s),
    ] {
        assert!(
            (page / fresh - 1.0).abs() < 0.05,
            "cargo xtask bench --plans: {page}, now {fresh}"
        );
    }
}
