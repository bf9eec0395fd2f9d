//! Tests the screen's content, drawn into buffers of the smallest size and of larger sizes.

use super::screen::{SIZE_MIN, draw};
use super::view::{Action, View};
use crate::digits::time_s;
use crate::feed::RawFrames;
use crate::input::{Input, first_scene};
use crate::live::{Connection, Live};
use crate::replay;
use hal_mock::Sliding;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::buffer::Buffer;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use ratatui::layout::Size;
use ratatui::style::Color;
use ridgetone_finger::Pipeline;
use ridgetone_proto::fault::{Fault, FaultKind};
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Event, Movement, OtherTone, Packet, Raw, Status};

fn calibrated() -> Settings {
    let mut settings = Settings::DEFAULT;
    settings.array.edge_phase_sigma_rad = 0.01;
    settings
}

/// Runs the default scene with a calibrated finger: a tone of 8.3333 Hz, 3.6 mm at 30 mm/s.
fn touched() -> Live {
    let mut live = Live::new("/dev/ttyUSB0");
    let mut sink = |packet: &Packet| {
        live.take(packet);
        Ok(())
    };
    replay::run(
        Input::default().open().unwrap(),
        calibrated(),
        &mut sink,
        &mut |_, _| {},
    )
    .unwrap();
    live
}

/// Adds a second of raw frames. Each channel has a different amplitude; channel 5 is not read.
fn with_frames(mut live: Live) -> Live {
    for number in 0..241u32 {
        let swing = |taxel: usize| (1e4 * (1 + taxel) as f32 * (number as f32 * 0.2).sin()) as i32;
        let raw = Raw {
            t_us: 5_000_000 + u64::from(number) * 4147,
            number,
            present: !(1 << 5),
            good: u16::MAX,
            codes: std::array::from_fn(swing),
        };
        live.take(&Packet {
            sequence: 1,
            event: Event::Raw(raw),
        });
    }
    live
}

fn drawn(live: &Live, view: &View, size: impl Into<Size>) -> Buffer {
    let Size { width, height } = size.into();
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(|frame| draw(frame, live, view)).unwrap();
    terminal.backend().buffer().clone()
}

fn lines(buffer: &Buffer) -> Vec<String> {
    let area = buffer.area;
    let row = |y| (0..area.width).map(|x| buffer[(x, y)].symbol()).collect();
    (0..area.height).map(row).collect()
}

fn assert_shows(lines: &[String], parts: &[&str]) {
    for part in parts {
        assert!(
            lines.iter().any(|line| line.contains(part)),
            "{part:?} is not on\n{}",
            lines.join("\n")
        );
    }
}

fn view() -> View {
    View::new(RawFrames::On, true)
}

#[test]
fn at_80_by_24_everything_is_there() {
    let buffer = drawn(&with_frames(touched()), &view(), SIZE_MIN);
    let lines = lines(&buffer);
    assert_shows(
        &lines,
        &[
            "ridgetone  /dev/ttyUSB0  connected",
            concat!("firmware ", env!("CARGO_PKG_VERSION")),
            "frequency, Hz, last 30 s",
            "no contact",
            "good, 1.96 s, to",
            "period 3.4",
            "mm/s →",
            "slide 8.333",
            "channels, 0.5 s, ±",
            "static image after, mV",
            "health: OK",
            "241.14 frames/s",
            "line: 0 lost, 0 damaged, 0 dropped; ADC: 0 lost, 0 doubtful; 0 overruns",
            "q quit",
            "h help",
        ],
    );
    // There are two columns of eight strips; the channel without frames is labelled as such.
    for taxel in 0..TAXELS {
        let label = format!("{taxel:>2} ");
        assert!(lines.iter().any(|line| line.contains(&label)));
    }
    assert_shows(&lines, &["no valid frame"]);
    assert!(
        lines
            .iter()
            .filter(|line| line.contains('▁') && line.contains('█'))
            .count()
            >= 1
    );
    // The chart has a point for each window.
    assert!(lines.iter().any(|line| line.contains('•')));
    // The channel with the largest amplitude has the highest bars.
    let strip = |taxel: usize| {
        lines
            .iter()
            .find_map(|line| line.split(&format!("{taxel:>2} ")).nth(1))
            .unwrap()
            .to_owned()
    };
    assert!(
        strip(15).contains('█') && !strip(0).contains('█'),
        "{} {}",
        strip(15),
        strip(0)
    );
}

#[test]
fn it_uses_the_terminal_s_own_colours_and_red_only_for_alarms() {
    let mut live = with_frames(touched());
    // All estimates are good; a fault and a loss are alarms.
    live.strips = Default::default();
    let colours = |live: &Live, view: &View| {
        let buffer = drawn(live, view, (100, 40));
        let cells = buffer.content.iter();
        cells
            .map(|cell| (cell.fg, cell.bg))
            .filter(|colours| *colours != (Color::Reset, Color::Reset))
            .collect::<Vec<_>>()
    };
    assert_eq!(colours(&live, &view()), []);
    let fault = Fault {
        kind: FaultKind::Supply,
        from_us: 1,
        until_us: None,
        count: 3,
    };
    live.take(&Packet {
        sequence: 1,
        event: Event::Fault(fault),
    });
    live.now.counts.missing = 7;
    let buffer = drawn(&live, &view(), SIZE_MIN);
    assert_shows(&lines(&buffer), &["health: FAULT: supply", "7 lost"]);
    let red = colours(&live, &view());
    assert!(
        !red.is_empty()
            && red
                .iter()
                .all(|colours| *colours == (Color::Red, Color::Reset)),
        "{red:?}"
    );
    // Without colours, alarms are reversed instead of red.
    assert_eq!(colours(&live, &View::new(RawFrames::On, false)), []);
}

#[test]
fn larger_screens_show_a_strip_a_row_and_the_log() {
    let lines = lines(&drawn(&with_frames(touched()), &view(), (120, 48)));
    assert_shows(&lines, &["events", "contact", "the finger is off"]);
    let strips = lines.iter().filter(|line| {
        line.starts_with('│') && line.chars().filter(|c| "▁▂▃▄▅▆▇█".contains(*c)).count() > 40
    });
    assert_eq!(strips.count(), TAXELS - 1);
}

/// At 80 columns no line is cut, and at 200 no strip has holes.
#[test]
fn nothing_is_cut_when_narrow_and_strips_have_no_holes_when_wide() {
    let mut live = with_frames(touched());
    live.now.source =
        "/dev/serial/by-id/usb-Silicon_Labs_CP2102N_USB_to_UART_Bridge_0001-if00-port0".into();
    (live.now.counts.missing, live.now.counts.damaged) = (123_456, 12_345);
    let mut health = *live.health().expect("a reading");
    (health.messages_dropped, health.frames_thinned) = (65_432, 123_456);
    (health.conversions_lost, health.conversions_doubtful) = (54_321, 4321);
    (health.overruns, health.chip_restarts) = (321, 21);
    health.t_us = 6_000_000;
    live.take(&Packet {
        sequence: 2,
        event: Event::Health(health),
    });
    let mut view = view();
    view.is_paused = true;
    for size in [SIZE_MIN, (80, 48)] {
        let shown = lines(&drawn(&live, &view, size));
        assert_shows(&shown[..1], &["/dev/serial/", "…", "connected", "PAUSED"]);
        assert_shows(
            &shown,
            &[
                "123456 raw frames not sent",
                "321 overruns, 21 ADC restarts",
            ],
        );
    }
    let log = lines(&drawn(&live, &view, (80, 48)));
    let latest: Vec<&str> = live
        .log
        .iter()
        .last()
        .expect("an event")
        .split(' ')
        .collect();
    assert!(live.log.iter().any(|line| line.chars().count() > 78));
    assert_shows(&log, &[latest[latest.len() - 1]]);
    for line in log.iter().filter(|line| line.starts_with('│')) {
        assert!(line.ends_with('│'), "{line}");
    }
    let wide = lines(&drawn(&live, &view, (200, 60)));
    let strips = wide
        .iter()
        .filter(|line| line.contains('▂') && line.contains('▇'));
    let holes = |line: &str| {
        let strip: Vec<char> = line.chars().skip(4).take(160).collect();
        strip.iter().filter(|c| **c == ' ').count()
    };
    let found: Vec<usize> = strips.map(|line| holes(line)).collect();
    assert!(
        found.len() >= 6 && found.iter().all(|holes| *holes < 8),
        "{found:?}\n{}",
        wide.join("\n")
    );
}

#[test]
fn without_raw_frames_there_are_amplitudes_and_the_reason() {
    let shown = |raw| lines(&drawn(&touched(), &View::new(raw, true), SIZE_MIN));
    assert_shows(
        &shown(RawFrames::Unavailable),
        &["amplitudes in the window; no raw frames", " mV █"],
    );
    assert_shows(
        &shown(RawFrames::Refused("no answer".into())),
        &["no answer"],
    );
    assert_shows(&shown(RawFrames::Off), &["r: channels"]);
}

#[test]
fn an_empty_model_a_small_screen_and_the_help_are_drawn_too() {
    let mut live = Live::new("emulated board");
    assert_shows(
        &lines(&drawn(&live, &view(), SIZE_MIN)),
        &["nothing received yet", "no estimate yet", "none yet"],
    );
    assert_shows(&lines(&drawn(&live, &view(), (60, 20))), &["needs 80 x 24"]);
    for size in [(1, 1), (79, 24), (80, 23), (300, 100)] {
        drawn(&with_frames(touched()), &view(), size);
    }
    live.now.connection = Connection::Disconnected {
        why: "no such device".into(),
    };
    assert_shows(&lines(&drawn(&live, &view(), SIZE_MIN)), &["UNPLUGGED"]);
    let mut view = view();
    view.press(KeyEvent::from(KeyCode::Char('h')));
    assert_shows(
        &lines(&drawn(&live, &view, SIZE_MIN)),
        &["request raw frames of the board", "any key closes this"],
    );
}

/// Runs a scene with raw frames until `until_s`, during its slide.
fn sliding(scene: Sliding, until_s: f64) -> Live {
    let mut live = Live::new("emulated board");
    let mut pipeline = Box::new(Pipeline::new(Settings::DEFAULT));
    pipeline.report_raw(u32::MAX);
    let mut packets = vec![Packet {
        sequence: 0,
        event: pipeline.hello(),
    }];
    let input = Input {
        scene,
        ..Input::default()
    };
    replay::conversions(input.open().unwrap(), &mut |conversion| {
        pipeline.push(conversion, &mut |event| {
            packets.push(Packet {
                sequence: packets.len() as u16,
                event,
            })
        });
        Ok(())
    })
    .unwrap();
    for packet in packets
        .iter()
        .filter(|packet| time_s(&packet.event).is_none_or(|t_s| t_s <= until_s))
    {
        live.take(packet);
        live.now.counts.received += 1;
    }
    live
}

#[test]
fn what_helps_against_a_status_is_on_the_smallest_screen_too() {
    let mut live = sliding(Sliding::default(), 3.3);
    let mut estimate = live.estimate().unwrap().clone();
    let shown = |live: &Live, size| lines(&drawn(live, &view(), size));
    estimate.status = Status::Unsteady;
    estimate.movement = Movement {
        wander: 0.021,
        wander_sigma: 0.002,
        chirp: -0.31,
        chirp_sigma: 0.04,
    };
    live.take(&Packet {
        sequence: 9,
        event: Event::Estimate(estimate.clone()),
    });
    let parts = [
        "unsteady, wander 2.1 %",
        "shorten the window, or give",
        "speed  28.",
    ];
    assert_shows(&shown(&live, SIZE_MIN), &parts);
    assert_shows(
        &shown(&live, (80, 31)),
        &[&parts[..], &["chirp -0.310 +- 0.040 Hz/s"]].concat(),
    );
    estimate.status = Status::Ambiguous;
    estimate.movement = Movement::default();
    estimate.other_tone = Some(OtherTone {
        frequency: 12.31,
        fraction: 0.42,
    });
    live.take(&Packet {
        sequence: 10,
        event: Event::Estimate(estimate),
    });
    assert_shows(
        &shown(&live, SIZE_MIN),
        &[
            "ambiguous ",
            "use a longer window",
            "other tone 12.31 Hz, 42 % of",
        ],
    );
}

/// Asserts that the simulated touch draws the screen in `screen.txt`. If the screen changes, that
/// file is updated by hand.
#[test]
fn the_screen_of_a_slide_is_drawn_in_full() {
    let lines = lines(&drawn(
        &sliding(first_scene().unwrap(), 3.4),
        &view(),
        SIZE_MIN,
    ));
    let drawn: Vec<&str> = lines.iter().map(|line| line.trim_end()).collect();
    let expected: Vec<&str> = include_str!("screen.txt").lines().collect();
    assert_eq!(drawn, expected);
}

#[test]
fn keys_do_what_the_help_says() {
    let mut view = view();
    let key = |code| KeyEvent::from(code);
    assert_eq!(view.press(key(KeyCode::Char('q'))), Some(Action::Quit));
    assert_eq!(
        view.press(KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL)),
        Some(Action::Quit)
    );
    assert_eq!(view.press(key(KeyCode::Char('c'))), Some(Action::Clear));
    assert_eq!(view.press(key(KeyCode::Char('r'))), Some(Action::Raw));
    assert_eq!(
        (view.press(key(KeyCode::Char('p'))), view.is_paused),
        (None, true)
    );
    assert_eq!(
        (view.press(key(KeyCode::Char(' '))), view.is_paused),
        (None, false)
    );
    let (history_s, strips_s) = (view.history_s(), view.strips_s());
    for _ in 0..9 {
        view.press(key(KeyCode::Char('-')));
        view.press(key(KeyCode::Char('[')));
    }
    assert!(view.history_s() > history_s && view.strips_s() > strips_s);
    for _ in 0..9 {
        view.press(key(KeyCode::Char('+')));
        view.press(key(KeyCode::Char(']')));
    }
    assert!(view.history_s() < history_s && view.strips_s() < strips_s);
    view.press(key(KeyCode::Char('?')));
    assert!(view.shows_help);
    assert_eq!(
        (view.press(key(KeyCode::Char('q'))), view.shows_help),
        (None, false)
    );
}
