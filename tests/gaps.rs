//! Tests windows with consecutive frames missing: no estimate that the gap could bias may be good.

#[allow(dead_code, reason = "every test file uses a part of it")]
mod reference;

use reference::Tone;
use ridgetone_finger::{Estimator, Window, WindowFit};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Estimate, Status};
use ridgetone_tone::{Fitter, Table};

/// Frames in a window of the plan `single`, 43 ms.
const FRAMES: usize = 1003;

/// Returns the estimate of a window of one channel with some frames missing.
fn estimate(
    estimator: &mut Estimator,
    fitter: &mut Fitter,
    tone: &Tone,
    is_missing: impl Fn(usize) -> bool,
) -> Estimate {
    let plan = Plan::SINGLE;
    let valid: Vec<u16> = (0..FRAMES)
        .map(|frame| if is_missing(frame) { 0 } else { plan.inputs })
        .collect();
    let mut table = Table {
        values: &tone.values(),
        valid: &valid,
    };
    let window = Window {
        end_us: 1_000_000,
        ..Window::new(plan, FRAMES as u32)
    };
    match estimator.run(fitter, &window, &mut table) {
        Ok(WindowFit::Done(estimate)) => estimate,
        other => panic!("no estimate: {other:?}"),
    }
}

/// Fits 120 windows with 3 to 6 cycles. Returns the numbers of good fits, good but wrong fits, and
/// doubtful fits.
fn counts(is_missing: impl Fn(usize, usize) -> bool) -> (u32, u32, u32) {
    let mut estimator = Estimator::new(Settings::DEFAULT.with_plan(Plan::SINGLE));
    let mut fitter = Box::new(Fitter::new());
    let (mut good, mut wrong, mut doubtful) = (0, 0, 0);
    for seed in 0..120 {
        let cycles = 3.0 + 3.0 * (seed as f64 / 120.0);
        let frequency = cycles / FRAMES as f64;
        let mut tone = Tone::new(frequency, FRAMES, 30.0, seed as u64);
        tone.harmonics = 4;
        let is_missing = |frame| is_missing(seed, frame);
        let estimate = estimate(&mut estimator, &mut fitter, &tone, is_missing);
        let off =
            (f64::from(estimate.frequency / Plan::SINGLE.frame_rate_hz()) / frequency - 1.0).abs();
        good += u32::from(estimate.status == Status::Good);
        wrong += u32::from(estimate.status == Status::Good && off > 0.005);
        doubtful += u32::from(estimate.status == Status::Doubtful);
    }
    (good, wrong, doubtful)
}

/// Tests gaps shorter and longer than a tenth of the window, anywhere in it.
#[test]
fn a_window_with_a_long_gap_is_doubtful_and_one_with_a_short_gap_good() {
    for fraction in [0.0, 0.05, 0.09, 0.11, 0.2, 0.35, 0.45] {
        let length = (fraction * FRAMES as f64) as usize;
        let (good, wrong, doubtful) = counts(|seed, frame| {
            let first = (FRAMES - length) * (seed * 37 % 120) / 120;
            (first..first + length).contains(&frame)
        });
        let is_right = if fraction < 0.1 {
            good >= 118 && doubtful == 0
        } else {
            good == 0 && doubtful > 20
        };
        assert!(
            is_right && wrong == 0,
            "{fraction}: {good} {wrong} {doubtful}"
        );
    }
}

/// As many frames are missing as in a long gap, but scattered.
#[test]
fn frames_that_are_missing_here_and_there_leave_a_window_good() {
    let hash =
        |seed: usize, frame: usize| (seed * 1009 + frame).wrapping_mul(2_654_435_761) >> 7 & 0xff;
    let (good, wrong, doubtful) = counts(|seed, frame| hash(seed, frame) < 90);
    assert!(
        good >= 118 && wrong == 0 && doubtful == 0,
        "{good} {wrong} {doubtful}"
    );
}
