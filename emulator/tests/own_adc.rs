//! Tests boards without an ADS1258: the on-chip ADC, its DMA, and the firmware's results.

mod common;

use common::{Run, converter, estimates, fault_of, health, hello};
use hal_mock::{Amplifier, Constant, Repeated, Sliding, SlidingScene};
use ridgetone_emulator::{Board, OwnAdcFault, ProcessorFault, Rule, Start};
use ridgetone_finger::converter::OnboardPlan;
use ridgetone_proto::boot::ResetCause;
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::telemetry::{Estimate, Span, Status};

/// The demo's grating: 3.6 mm at 30 mm/s.
const TONE_HZ: f32 = 30.0 / 3.6;

fn whole_slide(run: &Run) -> Estimate {
    let whole = estimates(&run.events)
        .into_iter()
        .find(|one| one.span == Span::Slide);
    whole.expect("an estimate of the whole slide")
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test"]
fn the_demo_is_good_without_another_chip() {
    // Field L of ADC_SQR1 (bits 23 to 16) is one less than the number of inputs in a scan, eight or
    // fourteen.
    for (board, sequence) in Board::OWN_ADC.into_iter().zip([0x70, 0xd0, 0x70]) {
        let mut run = Run::sliding(board);
        let greeting = run.run_to(1.0, hello);
        assert_eq!(greeting.boot.cause, ResetCause::Power, "{board:?}");
        let state = run.run_to(1.0, converter);
        assert_eq!(
            (state.answers, state.registers[5]),
            (true, sequence),
            "{board:?}: {state:?}"
        );
        // The STM32F405 does not have ADCDC1.
        let has_bit = board != Board::FeatherF405Adc;
        assert_eq!(run.emulator.has_quiet_adc(), has_bit, "{board:?}");
        run.run_s(5.5);
        run.assert_rules();
        assert!(
            run.emulator.resets().is_empty(),
            "{:?}",
            run.emulator.resets()
        );
        let estimate = whole_slide(&run);
        let off = (estimate.frequency - TONE_HZ).abs() / estimate.sigma;
        assert_eq!(estimate.status, Status::Good, "{board:?}: {estimate:?}");
        assert!(off < 4.0, "{board:?}: {estimate:?}");
        let last = run.events.iter().filter_map(health).next_back();
        let last = last.expect("health");
        println!(
            "{board:?}: {:.3} Hz +- {:.4}, {:.2} frames/s, load {:.1} %, stack {} of {}",
            estimate.frequency,
            estimate.sigma,
            last.frame_rate_hz,
            100.0 * last.load,
            last.stack_used_bytes,
            last.stack_bytes
        );
        assert_eq!(
            (
                last.conversions_lost,
                last.conversions_doubtful,
                last.chip_restarts
            ),
            (0, 0, 0),
            "{last:?}"
        );
        assert!(last.stack_used_bytes + 1024 <= last.stack_bytes, "{last:?}");
        assert_eq!(run.events.iter().find_map(fault_of), None, "{board:?}");
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn an_overrun_and_a_failed_transfer_are_found_and_mended() {
    for (board, fault) in Board::OWN_ADC
        .into_iter()
        .zip([OwnAdcFault::Overrun, OwnAdcFault::Transfer])
    {
        let scene = Sliding {
            idle_s: 3.0,
            ..Sliding::default()
        };
        let scene = SlidingScene::new(scene).expect("a scene");
        let mut run = Run::new(board, scene, Start::default());
        run.run_to(1.0, hello);
        run.run_s(0.5);
        run.emulator.own_adc_fault(fault);
        let found = run.run_to(1.0, fault_of);
        assert_eq!(found.kind, FaultKind::Registers, "{board:?}: {found:?}");
        run.run_s(6.5);
        let estimate = whole_slide(&run);
        let off = (estimate.frequency - TONE_HZ).abs() / estimate.sigma;
        assert!(off < 4.0, "{board:?}: {estimate:?}");
        let report = run.run_to(2.0, health);
        assert_eq!(report.chip_restarts, 1, "{board:?}: {report:?}");
        // Samples missed until the watch task ran must be reported as lost.
        let channels = if board == Board::FeatherF405Adc {
            8.0
        } else {
            14.0
        };
        let accounted = f64::from(report.frames) * channels + f64::from(report.conversions_lost);
        let made = f64::from(report.frame_rate_hz) * channels * report.t_us as f64 * 1e-6;
        assert!(
            (accounted / made - 1.0).abs() < 0.01,
            "{board:?}: {accounted} of {made}, {report:?}"
        );
        assert!(run.emulator.resets().is_empty(), "{board:?}");
        // If the stream stops, the next sample is not fetched.
        let broken: Vec<Rule> = run.emulator.findings().iter().map(|one| one.rule).collect();
        let expected = if fault == OwnAdcFault::Transfer {
            vec![Rule::AdcOverrun]
        } else {
            vec![]
        };
        assert_eq!(broken, expected, "{board:?}");
    }
}

/// Halves of the buffer are overwritten, as during an erase of the flash. Whole frames are lost,
/// but the frames after them must keep their times.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn an_interrupt_that_is_held_off_costs_whole_frames() {
    const DMA2_STREAM0: u16 = 56;
    for (board, channels) in Board::OWN_ADC.into_iter().zip([8, 14]) {
        let rest = Constant {
            volts: [2.5; 16],
            ..Constant::default()
        };
        let mut run = Run::new(board, rest, Start::default());
        let before = run.run_to(2.0, health);
        assert_eq!(before.conversions_lost, 0, "{board:?}: {before:?}");
        for held_s in [0.0003, 0.001, 0.0062] {
            run.emulator.inject(ProcessorFault::Mask(DMA2_STREAM0));
            run.run_s(held_s);
            run.emulator.inject(ProcessorFault::Unmask(DMA2_STREAM0));
            run.run_s(0.1);
        }
        run.run_to(2.0, health);
        let after = run.run_to(2.0, health);
        // A frame takes 4.1 to 4.2 ms, so one, one, and two or three frames are lost.
        let lost = after.conversions_lost / channels;
        assert_eq!(after.conversions_lost % channels, 0, "{board:?}: {after:?}");
        assert!((3..=5).contains(&lost), "{board:?}: {after:?}");
        assert_eq!(
            (after.chip_restarts, after.conversions_doubtful),
            (0, 0),
            "{board:?}: {after:?}"
        );
        let passed_s = (after.t_us - before.t_us) as f64 * 1e-6;
        let expected = passed_s * f64::from(after.frame_rate_hz);
        let frames = f64::from(after.frames - before.frames + lost);
        assert!(
            (frames - expected).abs() < 1.5,
            "{board:?}: {frames} of {expected}"
        );
        run.assert_rules();
    }
}

/// A stroke of 60 mm at 200 mm/s over a grating of 1 mm.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_fast_plan_follows_a_hand_and_the_ads1258s_are_refused() {
    let eight = OnboardPlan {
        inputs: 0xff,
        scans: 28,
        clock_mhz: 21,
    };
    let plans = [eight.plan(), Plan::ONBOARD_HAND];
    for (board, plan) in Board::OWN_ADC.into_iter().zip(plans) {
        let scene = Sliding {
            speed_mm_s: 200.0,
            period_mm: 1.0,
            ..Sliding::default()
        };
        let scene = Repeated(SlidingScene::new(scene).expect("a scene"));
        let mut run = Run::new(board, scene, Start::default());
        let own = run.run_to(1.0, hello).settings;
        assert_eq!(own.vref_v, 3.3, "{board:?}");
        let set = |plan| Command::Set {
            settings: own.with_plan(plan),
            keep: false,
        };
        let Outcome::Setting(error) = run.command(1, set(Plan::HAND)) else {
            panic!("{board:?} takes a plan of the ADS1258");
        };
        assert_eq!(error.field, "plan.converter", "{error:?}");
        assert_eq!(run.command(2, set(plan)), Outcome::Done, "{board:?}");
        run.run_s(0.1);
        let from = run.events.len();
        run.run_s(8.0);
        run.assert_rules();
        let events = &run.events[from..];
        let good: Vec<Estimate> = estimates(events)
            .into_iter()
            .filter(|one| one.status == Status::Good)
            .collect();
        assert!(!good.is_empty(), "{board:?}");
        for one in &good {
            assert!((one.frequency - 200.0).abs() < 6.0 * one.sigma, "{one:?}");
        }
        let last = events.iter().filter_map(health).next_back();
        let last = last.expect("health");
        println!(
            "{board:?}: {:.1} frames/s, load {:.1} %",
            last.frame_rate_hz,
            100.0 * last.load
        );
        assert_eq!(
            (
                last.conversions_lost,
                last.conversions_doubtful,
                last.chip_restarts
            ),
            (0, 0, 0),
            "{board:?}: {last:?}"
        );
    }
}

/// The signals of bare bridges are a few steps of 0.8 mV: tones are found, but less certain.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn bare_bridges_are_less_sure_than_amplified_ones() {
    let sigma = |amplifier| {
        let scene = SlidingScene::new(Sliding::physical()).expect("a scene");
        let start = Start {
            amplifier,
            ..Start::default()
        };
        let mut run = Run::new(Board::NucleoF446reAdc, Repeated(scene), start);
        run.run_s(6.0);
        run.assert_rules();
        let estimate = whole_slide(&run);
        println!("{amplifier:?}: {estimate:?}");
        estimate.sigma
    };
    let (amplified, bare) = (sigma(Amplifier::Gain(20.0)), sigma(Amplifier::Bare));
    assert!(bare > 1.2 * amplified, "{bare} and {amplified}");
}
