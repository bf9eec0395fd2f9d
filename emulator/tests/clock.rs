//! Tests an ADS1258 clocked by the board: a timer's output is wired to CLKIO.

mod common;

use common::{BOARDS, Run, estimates, fault_of, health, hello, image};
use hal_mock::{Constant, Repeated, Sliding, SlidingScene};
use ridgetone_emulator::{Board, Start};
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Health, Status};

/// 168 MHz / 11.
const CLOCK_HZ: u32 = 15_272_727;

fn with_clock(clock_hz: u32) -> Settings {
    Settings::DEFAULT.with_plan(Plan::PAPER.with_clock(clock_hz))
}

fn set(run: &mut Run, number: u16, settings: Settings) {
    let keep = true;
    let outcome = run.command(number, Command::Set { settings, keep });
    assert_eq!(outcome, Outcome::Done);
}

fn last_health(run: &Run) -> Health {
    let last = run.events.iter().filter_map(health).next_back();
    last.expect("health")
}

/// Starts a board whose ADC has no clock except the board's.
fn wired(board: Board) -> Run {
    let scene = Sliding::default();
    let start = Start {
        clkio_is_wired: true,
        ..Start::default()
    };
    let scene = Repeated(SlidingScene::new(scene).expect("a scene"));
    Run::new(board, scene, start)
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_board_clocks_its_adc_from_reset_to_a_good_estimate() {
    for board in BOARDS {
        let mut run = wired(board);
        run.run_to(1.0, hello);
        run.run_s(0.5);
        assert_eq!(run.emulator.adc_clock_hz(), 0);
        assert!(run.emulator.readings().is_empty(), "without a clock");
        // The clock starts while the firmware runs, which powers up the chip.
        set(&mut run, 1, with_clock(CLOCK_HZ));
        run.run_s(0.5);
        assert!(run.emulator.readings().len() > 2000);
        run.assert_rules();
        run.emulator.press_reset().expect("a reset");
        assert_eq!(run.emulator.adc_clock_hz(), 0);

        // Power up a board in which these settings are stored.
        let place = image(board).symbol("_settings_start").expect("memory.x");
        let store = run.emulator.flash(place).to_vec();
        let mut run = wired(board);
        run.emulator.overwrite_flash(place, &store);
        let greeting = run.run_to(1.0, hello);
        assert_eq!(greeting.source, SettingsSource::Stored);
        assert_eq!(greeting.settings.plan.adc_clock_hz, CLOCK_HZ);
        run.run_s(8.0);
        assert_eq!(run.emulator.adc_clock_hz(), CLOCK_HZ);
        let good: Vec<_> = estimates(&run.events)
            .into_iter()
            .filter(|one| one.status == Status::Good)
            .collect();
        let Sliding {
            speed_mm_s,
            period_mm,
            ..
        } = Sliding::default();
        for one in &good {
            let off = f64::from(one.frequency) - speed_mm_s / period_mm;
            assert!(off.abs() < 6.0 * f64::from(one.sigma), "{one:?}");
        }
        let last = last_health(&run);
        println!(
            "{board:?}: {} good, {:.2} frames/s",
            good.len(),
            last.frame_rate_hz
        );
        assert!(good.len() > 3);
        // 16 inputs and 5 internal readings: 15.273 MHz / (128 x 24.265625 x 21).
        assert!((last.frame_rate_hz - 234.15).abs() < 0.01, "{last:?}");
        assert_eq!(last.faults.iter().sum::<u32>(), 0, "{last:?}");
        assert_eq!(run.events.iter().find_map(fault_of), None);
        // This plan sets the scan up again for each health reading; the clock must keep running.
        let hand = Plan::HAND.with_clock(CLOCK_HZ);
        set(&mut run, 2, Settings::DEFAULT.with_plan(hand));
        run.run_s(4.0);
        let last = last_health(&run);
        assert!(
            (last.frame_rate_hz / hand.frame_rate_hz() - 1.0).abs() < 1e-3,
            "{last:?}"
        );
        assert_eq!((last.conversions_lost, last.chip_restarts), (0, 0));
        run.assert_rules();
    }
}

/// The ADC's clock and the time stamps come from the same oscillator, so the frame rate cannot
/// reveal the oscillator's error.
#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn no_estimate_is_good_where_an_internal_oscillator_clocks_the_adc_too() {
    for (board, hsi_ppm) in BOARDS.into_iter().zip([4_000, -10_000]) {
        let start = Start {
            clkio_is_wired: true,
            hse_is_dead: true,
            hsi_ppm,
            ..Start::default()
        };
        let scene = Repeated(SlidingScene::new(Sliding::default()).expect("a scene"));
        let mut run = Run::new(board, scene, start);
        run.run_to(1.0, hello);
        set(&mut run, 1, with_clock(CLOCK_HZ));
        run.run_s(8.0);
        let found = estimates(&run.events);
        assert!(found.len() > 3, "{board:?}: {} estimates", found.len());
        for one in found {
            assert!(
                one.status != Status::Good && one.faults.has(FaultKind::Clock),
                "{board:?}: {one:?}"
            );
        }
    }
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn the_clocks_pin_is_off_unless_the_plan_names_its_clock() {
    for board in BOARDS {
        let mut run = Run::new(board, Constant::default(), Start::default());
        run.run_to(1.0, hello);
        for (number, clock_hz) in [(1, 16_000_000), (2, CLOCK_HZ + 1), (3, 15_728_640)] {
            assert_eq!(run.emulator.adc_clock_hz(), 0);
            set(&mut run, number, with_clock(clock_hz));
            run.run_s(1.0);
            assert_eq!(run.emulator.adc_clock_hz(), 0, "{clock_hz}");
        }
        // CLKIO is not wired, so the chip continues with its crystal. The firmware must detect the
        // mismatch.
        set(&mut run, 4, with_clock(CLOCK_HZ));
        run.run_s(5.0);
        assert_eq!(run.emulator.adc_clock_hz(), CLOCK_HZ);
        let mut faults = run.events.iter().filter_map(fault_of);
        assert!(faults.any(|fault| fault.kind == FaultKind::Clock));
        set(&mut run, 5, with_clock(15_728_640));
        run.run_s(0.1);
        assert_eq!(run.emulator.adc_clock_hz(), 0);
        run.assert_rules();
    }
}
