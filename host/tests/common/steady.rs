//! Repeats a touch on the emulated chip, and asserts that nothing drifts, leaks or gets lost.

use hal_mock::{Options, Sliding, SlidingScene};
use ridgetone_finger::converter::SCAN;
use ridgetone_host::emulator;
use ridgetone_host::input::Opened;
use ridgetone_host::output::Progress;
use ridgetone_host::touches::Again;
use ridgetone_proto::settings::FRAME_RATE_HZ;
use ridgetone_proto::telemetry::{Event, Health, Packet, Span, Status};
use std::time::Instant;

/// Time between the starts of two touches, seconds; longer than a touch.
const EVERY_S: f64 = 6.0;

/// Tolerances of contact and slide (seconds) and frequency, as in `emulated.rs`.
const OFF_S: f64 = 0.020;
const OFF: f64 = 0.002;

/// Allowed growth of the stack after two touches, bytes. Tasks may preempt the fit at its deepest
/// point only later, each with a frame of up to 104 bytes in addition to its own stack.
const STACK_GROWTH_BYTES: u32 = 2048;

#[derive(Default)]
struct Seen {
    hellos: u64,
    contacts: u64,
    slides: u64,
    estimates: u64,
    releases: u64,
    healths: u64,
    first: Option<Health>,
    last: Option<Health>,
    /// Health after two touches, when every kind of event has occurred.
    after_two: Option<Health>,
}

/// Runs touches for `end_s` seconds of virtual time and checks all of them.
pub fn run(end_s: f64) {
    let elf = emulator::image::find().expect("an image");
    let scene = SlidingScene::new(Sliding::default()).expect("a scene");
    let truth = scene.truth();
    assert!(truth.end_s < EVERY_S);
    let input = Opened {
        scene: Box::new(Again {
            scene,
            every_s: EVERY_S,
            end_s,
        }),
        options: Options {
            power_up_cycles: ads1258::POWER_UP_TICKS.into(),
            ..Options::default()
        },
        end_s,
        truth: None,
        warning: None,
    };
    // The start of the scene is known only after the run, so collect the extremes and compare them
    // then.
    let [mut contact_off, mut start_off, mut end_off] = [Spread::default(); 3];
    let mut seen = Seen::default();
    let mut sink = |packet: &Packet, _| {
        match &packet.event {
            Event::Hello(_) => seen.hellos += 1,
            Event::Contact(contact) => {
                contact_off.take(contact.t_us, seen.contacts, truth.contact_s);
                seen.contacts += 1;
            }
            Event::Slide(slide) => {
                if let Some(end_us) = slide.end_us {
                    start_off.take(slide.start_us, seen.slides, truth.slide_start_s);
                    end_off.take(end_us, seen.slides, truth.slide_end_s);
                    seen.slides += 1;
                }
            }
            Event::Estimate(fit) => {
                assert_eq!(fit.status, Status::Good, "{fit:?}");
                if fit.span == Span::Slide {
                    let off = f64::from(fit.frequency) / truth.frequency_hz - 1.0;
                    assert!(off.abs() < OFF, "{fit:?}");
                    seen.estimates += 1;
                }
            }
            Event::Release(_) => seen.releases += 1,
            Event::Health(health) => seen.health(*health),
            _ => {}
        }
        Ok(())
    };
    let (begun, mut progress) = (Instant::now(), Progress::default());
    let outcome = emulator::run(
        input,
        emulator::Options::new(&elf),
        &mut sink,
        &mut |done_s, all_s| progress.show(format_args!("{done_s:.1} of {all_s:.1} s")),
    );
    progress.end();
    let outcome = outcome.expect("a run");
    println!(
        "{end_s} s of virtual time in {:.1} s of wall time",
        begun.elapsed().as_secs_f64()
    );

    // One greeting at the start and one after ten health messages each. A restart would add one.
    assert_eq!(
        seen.hellos,
        1 + seen.healths / 10,
        "a restart would greet once more"
    );
    let touches = (end_s / EVERY_S).floor() as u64;
    let found = [seen.contacts, seen.slides, seen.estimates, seen.releases];
    assert_eq!(
        found, [touches; 4],
        "contacts, slides, estimates of them and releases"
    );
    assert_eq!(
        (
            outcome.counts.missing,
            outcome.counts.damaged,
            outcome.chip.lost
        ),
        (0, 0, 0)
    );

    // Device time begins with the first result, scene time when START rises.
    let zero_s = outcome.zero_s();
    for (what, spread) in [
        ("contacts", contact_off),
        ("starts of slides", start_off),
        ("ends of slides", end_off),
    ] {
        println!(
            "{what}: off by {:.6} to {:.6} s",
            spread.min_s + zero_s,
            spread.max_s + zero_s
        );
        assert!(
            spread.min_s + zero_s > -OFF_S && spread.max_s + zero_s < OFF_S,
            "{what}: {spread:?}"
        );
    }

    let (first, last) = (seen.first.expect("health"), seen.last.expect("health"));
    println!("first and last health:\n{first:?}\n{last:?}");
    // There is one health message per second, and one at the end.
    let seconds = u64::from(last.frames) / FRAME_RATE_HZ as u64;
    assert!(
        seen.healths.abs_diff(seconds + 1) <= 1,
        "{} healths in {seconds} s",
        seen.healths
    );
    let quiet = |health: &Health| {
        let lost = health.conversions_lost + health.conversions_doubtful;
        lost + health.overruns + health.messages_dropped + health.chip_restarts
    };
    assert_eq!(quiet(&last), 0, "{last:?}");
    // Measured since the start, with an error of up to a microsecond at either end.
    let rate_hz = f64::from(SCAN.clock_hz) / f64::from(SCAN.frame_ticks());
    assert!(
        (f64::from(last.frame_rate_hz) / rate_hz - 1.0).abs() < 2.0 / last.t_us as f64 + 1e-6,
        "{last:?}"
    );
    let after_two = seen.after_two.expect("two touches").stack_used_bytes;
    println!(
        "stack: {after_two} bytes after two touches, {} at last, of {}",
        last.stack_used_bytes, last.stack_bytes
    );
    assert!(
        last.stack_used_bytes.abs_diff(after_two) < STACK_GROWTH_BYTES,
        "{after_two} bytes, then {last:?}"
    );
    // Compares the last time stamp with the chip's own count of results, which includes conversions
    // after the last health message.
    let reported_s = last.t_us as f64 / 1e6;
    let served_s = outcome.conversions_served as f64 * f64::from(SCAN.conversion_ticks())
        / f64::from(SCAN.clock_hz);
    assert!(
        (0.0..1.1).contains(&(served_s - reported_s)),
        "{reported_s} s reported, {served_s} s of conversions read"
    );
    let board_us = outcome.end_us - outcome.first_edge_us;
    assert!(
        board_us.abs_diff((served_s * 1e6) as u64) < 20_000,
        "{board_us} us, {served_s} s"
    );
}

impl Seen {
    fn health(&mut self, health: Health) {
        self.healths += 1;
        self.first.get_or_insert(health);
        self.last = Some(health);
        // The latest conversion must be a whole number of the chip's periods after the first, in
        // exact arithmetic.
        let (ticks, clock_hz) = (
            u128::from(SCAN.conversion_ticks()),
            u128::from(SCAN.clock_hz),
        );
        let number = (u128::from(health.t_us) * clock_hz + ticks * 500_000) / (ticks * 1_000_000);
        let exact_us = number * ticks * 1_000_000 / clock_hz;
        assert!(
            exact_us.abs_diff(health.t_us.into()) <= 1,
            "{health:?} is not the time of conversion {number}"
        );
        // Compare whole scans, because the last health message comes in the middle of a scan.
        assert_eq!(
            (number + 1) / SCAN.slots() as u128,
            health.frames.into(),
            "{health:?}"
        );
        if (health.t_us as f64) < 2e6 * EVERY_S {
            return;
        }
        self.after_two.get_or_insert(health);
    }
}

/// Minimum and maximum error of times, seconds.
#[derive(Clone, Copy, Debug)]
struct Spread {
    min_s: f64,
    max_s: f64,
}

impl Default for Spread {
    fn default() -> Self {
        Self {
            min_s: f64::INFINITY,
            max_s: f64::NEG_INFINITY,
        }
    }
}

impl Spread {
    /// Takes device time `t_us` of an event in touch `number`, which was at `truth_s` in its scene.
    fn take(&mut self, t_us: u64, number: u64, truth_s: f64) {
        let off_s = t_us as f64 / 1e6 - (number as f64 * EVERY_S + truth_s);
        (self.min_s, self.max_s) = (self.min_s.min(off_s), self.max_s.max(off_s));
    }
}
