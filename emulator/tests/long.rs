//! Runs of minutes of virtual time, across the wrap of the microsecond counter, and at the chip's
//! top speed.

mod common;

use ads1258::Conversion;
use common::{BOARDS, Run, health, touches_and_tones};
use hal_mock::{Options, Repeated, Sliding, SlidingScene};
use ridgetone_emulator::{Board, ProcessorFault, Start};
use ridgetone_finger::Pipeline;
use ridgetone_finger::TimedConversion;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Event, Span};

/// Touches repeatedly for `seconds` seconds. The board must report, bit for bit, what the library
/// computes on this PC from the same conversions, and lose nothing. The microsecond counter starts
/// at `counter_us`.
fn touches(seconds: u32, counter_us: u32) {
    let scene = Repeated(SlidingScene::new(Sliding::default()).expect("the default scene"));
    let mut run = Run::new(Board::FeatherF405, scene, Start::default());
    // The firmware waits for the ADC's supply and sets it up until 0.21 s.
    run.run_s(0.1);
    run.emulator
        .inject(ProcessorFault::Microseconds(counter_us));
    let mut pipeline = Pipeline::new(Settings::DEFAULT);
    let (mut on_pc, mut wraps, mut latest_us) = (Vec::new(), 0, 0);
    for _ in 0..seconds {
        run.run_s(1.0);
        for reading in run.emulator.take_readings() {
            wraps += u32::from(reading.t_us < latest_us);
            latest_us = reading.t_us;
            let conversion = Conversion::from_bytes(reading.bytes);
            pipeline.push(
                TimedConversion::new(reading.t_us, conversion),
                &mut |event| on_pc.push(event),
            );
        }
    }
    assert_eq!(wraps, 1);
    run.assert_rules();
    let counters = run.emulator.adc().counters();
    assert!(
        run.emulator.resets().is_empty() && counters.lost == 0,
        "{:?}, {counters:?}",
        run.emulator.resets()
    );
    let there = touches_and_tones(&run.events);
    assert!(there == touches_and_tones(&on_pc), "to the bit");
    let is_whole =
        |event: &&Event| matches!(event, Event::Estimate(one) if one.span == Span::Slide);
    let (slides, each_s) = (there.iter().filter(is_whole).count(), 6);
    assert!(
        slides as u32 >= seconds / each_s - 1,
        "{slides} slides in {seconds} s"
    );
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn two_minutes_of_touches_over_the_wrap_of_the_counter_lose_nothing() {
    // The counter wraps half-way, during a slide.
    touches(120, u32::MAX - 63_200_000);
}

/// Run this by hand: no script does, because it takes 25 minutes.
#[test]
#[ignore = "75 minutes of virtual time"]
fn an_hour_and_a_quarter_of_touches_on_the_register_model_loses_nothing() {
    touches(4500, 100_000);
}

/// Clock of a simulated chip whose scan, planned for 15.72864 MHz and 5064 conversions a second,
/// makes 23,739 of them: the maximum of a real chip at any setting (SBAS297G: 16 MHz, DRATE 3, no
/// delay). No real chip tolerates this clock.
const FAST_CLOCK_HZ: u32 = 73_734_000;

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn at_the_chips_top_speed_every_loss_is_reported() {
    for board in BOARDS {
        let adc = Options {
            clock_hz: FAST_CLOCK_HZ,
            ..Start::default().adc
        };
        let scene = SlidingScene::new(Sliding::default()).expect("the default scene");
        let mut run = Run::new(
            board,
            scene,
            Start {
                adc,
                ..Start::default()
            },
        );
        // The slide with its fits has ended by then.
        run.run_s(4.0);
        let from = run.emulator.adc().counters().conversions;
        let report = run.run_to(2.0, health);
        let counters = run.emulator.adc().counters();
        // The firmware drops conversions that it has read only once, as nothing confirms them.
        let lost = counters.lost + run.emulator.read_once();
        println!(
            "{board:?}: {lost} of {} conversions are lost, {} unread",
            counters.conversions, counters.lost
        );
        assert!(from > 80_000, "{from}: 23,739 a second");
        // Nothing is lost between the report and its arrival.
        assert_eq!(u64::from(report.conversions_lost), lost, "{board:?}");
        let framed = u64::from(report.frames) * 21;
        assert!(
            framed + lost + 1000 > counters.conversions,
            "{board:?}: {framed} in frames, {counters:?}"
        );
        assert!(run.emulator.resets().is_empty(), "{board:?}");
        run.assert_rules();
    }
}
