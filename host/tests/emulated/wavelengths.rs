//! Gratings under a hand's speed with the plan `hand`, in the emulator and by the library on this PC: the same answers, bit for bit. What
//! docs/reproduction.md measures with the library is so what the image measures.

use hal_mock::Sliding;
use ridgetone::frame::TimedConversion;
use ridgetone::pipeline::Pipeline;
use ridgetone_host::emulator::{self, Options};
use ridgetone_host::input::{Input, Source};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Estimate, Event, Packet, Span, Status};

/// The mean of a hand's speed (Okamoto et al., section IV-A), mm/s.
const SPEED_MM_S: f64 = 125.4;

/// A conversion takes 197 us with the default plan and 43 us with `hand`.
const QUICK_US: u32 = 100;

fn estimate(event: &Event) -> Option<Estimate> {
    // The device's time begins with its first conversion, which is another on the PC.
    if let Event::Estimate(estimate) = event { Some(Estimate { t_us: 0, ..estimate.clone() }) } else { None }
}

#[test]
#[ignore = "needs the emulator: cargo xtask test"]
fn gratings_under_a_hands_speed_are_those_of_the_pc_bit_for_bit() {
    let elf = emulator::image::find().expect("an image");
    // Windows of the paper's length, and those that an accuracy of 0.5 % needs.
    for (wavelength_mm, window_s, accuracy) in [(0.8, 0.128, 0.005), (1.6, 0.032, 0.0), (2.5, 0.128, 0.005)] {
        let scene = Sliding {
            speed_mm_s: SPEED_MM_S,
            period_mm: wavelength_mm,
            ridge_mm: 0.5 * wavelength_mm,
            slide_mm: 80.0,
            hold_before_s: 0.6,
            hold_after_s: 0.5,
            ..Sliding::physical()
        };
        let input = Input { source: Source::Scene(scene), ..Input::default() };
        let settings =
            Settings { window_s, hop_s: 0.05, harmonics: 2, accuracy, ..Settings::DEFAULT.with_plan(Plan::HAND) };
        let mut on_chip = Vec::new();
        let mut sink = |packet: &Packet| {
            on_chip.extend(estimate(&packet.event));
            Ok(())
        };
        let options = Options { settings, keep_conversions: true, ..Options::new(&elf) };
        let opened = input.open_in(&Plan::HAND).expect("an input");
        let outcome = emulator::run(opened, options, &mut sink, &mut |_, _| {}).expect("a run");
        assert_eq!((outcome.counts.missing, outcome.counts.damaged, outcome.chip.lost), (0, 0, 0));
        // The very conversions, from where the plan is in force: the image begins with the default plan, whose conversions last longer.
        let is_quick = |pair: &[TimedConversion]| pair[1].t_us.wrapping_sub(pair[0].t_us) < QUICK_US;
        let first = outcome.conversions.windows(2).position(is_quick).expect("the plan's conversions");
        let (mut pipeline, mut on_pc) = (Pipeline::new(settings), Vec::new());
        for timed in &outcome.conversions[first..] {
            pipeline.push(*timed, &mut |event| on_pc.extend(estimate(&event)));
        }
        pipeline.finish(&mut |event| on_pc.extend(estimate(&event)));
        assert_eq!(on_chip, on_pc, "{wavelength_mm} mm");

        let frequency_hz = SPEED_MM_S / wavelength_mm;
        let windows = on_chip.iter().filter(|one| one.span == Span::Window && one.status == Status::Good);
        let good =
            windows.inspect(|one| assert!((f64::from(one.frequency) / frequency_hz - 1.0).abs() < 0.015, "{one:?}"));
        assert!(good.count() >= 5, "{wavelength_mm} mm: {on_chip:?}");
    }
}
