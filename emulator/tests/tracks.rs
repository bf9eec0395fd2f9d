//! Measures windows due in every frame, on the register model in the lean scene: how many are
//! fitted, the age of a result when its last byte leaves the board, and the times when events leave
//! it. `cargo test -p ridgetone-emulator --release --test tracks -- --ignored --nocapture` prints
//! the figures.

mod common;

use common::{BOARDS, Run, health, hello};
use hal_mock::{Sliding, SlidingScene};
use ridgetone_emulator::{Board, Start};
use ridgetone_proto::command::{Command, Outcome};
use ridgetone_proto::settings::{Declared, Settings};
use ridgetone_proto::telemetry::{Event, Health, Span, Status, Track};

/// Time between polls of the line, seconds.
const LOOK_S: f64 = 2e-4;

/// Returns the events of a touch with a single sine in white noise, each with the device time
/// (seconds) by which it had left the board.
fn touch(board: Board, window_s: f32) -> (Run, Vec<(f64, Event)>) {
    let scene = SlidingScene::new(Sliding {
        overtones: [0.0; 3],
        ..Sliding::default()
    });
    let mut run = Run::new(board, scene.expect("a scene"), Start::default());
    run.run_to(1.0, hello);
    let scene = Declared::LEAN;
    let (number, keep) = (1, false);
    let settings = Settings {
        window_s,
        stride_s: 0.0041,
        scene,
        ..Settings::DEFAULT
    };
    let outcome = run.command(number, Command::Set { settings, keep });
    assert_eq!(outcome, Outcome::Done);
    let outcome = run.command(2, Command::Raw { frames: u32::MAX });
    assert_eq!(outcome, Outcome::Done);
    let first_us = run.emulator.readings()[0].t_us;
    let (mut arrived, mut seen) = (Vec::new(), run.events.len());
    while run.emulator.now_ns() < 6_000_000_000 {
        run.run_s(LOOK_S);
        let now_us = run.emulator.readings().last().expect("a reading").t_us;
        let now_s = f64::from(now_us - first_us) * 1e-6;
        let new = run.events[seen..].iter().cloned();
        arrived.extend(new.map(|event| (now_s, event)));
        seen = run.events.len();
    }
    (run, arrived)
}

fn quantiles(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    [0.5, 0.95].map(|fraction| values[(fraction * (values.len() - 1) as f64) as usize])
}

#[test]
#[ignore = "needs the boards' images: cargo xtask test --all"]
fn a_window_for_each_frame_is_answered_within_fifteen_milliseconds() {
    let truth_hz = 30.0 / 3.6;
    for (board, window_s) in BOARDS
        .into_iter()
        .flat_map(|board| [(board, 0.2), (board, 0.4)])
    {
        let (run, arrived) = touch(board, window_s);
        run.assert_rules();
        let last: Health = arrived
            .iter()
            .filter_map(|(_, event)| health(event))
            .next_back()
            .expect("health");
        let lost = (
            last.conversions_lost,
            last.messages_dropped,
            last.frames_thinned,
        );
        assert_eq!((lost, run.missing()), ((0, 0, 0), 0), "{last:?}");
        let tracks: Vec<(f64, Track)> = arrived
            .iter()
            .filter_map(|(at_s, event)| match event {
                Event::Track(track) => Some((*at_s, *track)),
                _ => None,
            })
            .collect();
        let whole = arrived
            .iter()
            .filter(|(_, event)| matches!(event, Event::Estimate(one) if one.span == Span::Window))
            .count();
        let seconds = |us: u64| us as f64 * 1e-6;
        let lasts_s = seconds(tracks[tracks.len() - 1].1.t_us - tracks[0].1.t_us);
        let ages = tracks
            .iter()
            .map(|(at_s, track)| at_s - seconds(track.t_us))
            .collect();
        let [median_s, max_s] = quantiles(ages);
        let rate_hz = (tracks.len() - 1) as f64 / lasts_s;
        let good: Vec<_> = tracks
            .iter()
            .filter(|(_, track)| track.status == Status::Good)
            .collect();
        let load = arrived
            .iter()
            .filter_map(|(_, event)| health(event))
            .fold(0.0f32, |max, health| max.max(health.load));
        println!(
            "{board:?}, {window_s} s: {rate_hz:.0} tracks a second, {} of {} good, {} overruns, age {:.1} ms, 95 % {:.1} ms, \
             load up to {:.0} %, {:.0} estimates a second",
            good.len(),
            tracks.len(),
            last.overruns,
            1e3 * median_s,
            1e3 * max_s,
            100.0 * load,
            whole as f64 / lasts_s,
        );
        assert!(rate_hz > 200.0 && max_s < 0.015, "{rate_hz} {max_s}");
        assert!(whole as f64 <= 20.0 * lasts_s + 1.0, "{whole}");
        assert!(
            10 * good.len() > 8 * tracks.len(),
            "{} of {}",
            good.len(),
            tracks.len()
        );
        for (_, track) in good {
            let off = (f64::from(track.frequency) - truth_hz) / f64::from(track.sigma);
            assert!(off.abs() < 6.0, "{track:?}");
        }
        for (at_s, event) in &arrived {
            let (name, t_us, after_us) = match event {
                Event::Contact(one) => ("contact", one.t_us, one.reported_after_us),
                Event::Moving(one) => ("moving", one.t_us, one.reported_after_us),
                Event::Slide(one) => (
                    "slide",
                    one.end_us.unwrap_or(one.start_us),
                    one.reported_after_us,
                ),
                Event::Release(one) => ("release", one.t_us, one.reported_after_us),
                _ => continue,
            };
            let (t_s, after_s) = (seconds(t_us), seconds(after_us.into()));
            println!(
                "  {name:8} of {t_s:.3} s reported after {after_s:.3} s, left the board at {at_s:.3} s"
            );
            // Time on the line and in the queue in front of it.
            let waited_s = at_s - t_s - after_s;
            assert!((-0.001..0.03).contains(&waited_s), "{name}: {waited_s}");
        }
    }
}
