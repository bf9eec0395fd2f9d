//! Compares the state, folded from the packets of the default scene, with the truth of the scene.

use super::*;
use crate::input::Input;
use crate::{replay, static_image};
use ridgetone_proto::boot::{Boot, SettingsSource};
use ridgetone_proto::fault::FaultKind;
use ridgetone_proto::telemetry::{ConverterState, PROTOCOL, Raw, Status};

fn packets() -> Vec<Packet> {
    let mut packets = Vec::new();
    let mut sink = |packet: &Packet| {
        packets.push(packet.clone());
        Ok(())
    };
    replay::run(
        Input::default().open().unwrap(),
        Settings::DEFAULT,
        &mut sink,
        &mut |_, _| {},
    )
    .unwrap();
    packets
}

#[test]
fn a_touch_goes_through_its_phases_and_leaves_tone_period_and_images() {
    let mut live = Live::new("a scene");
    let truth = Input::default().open().unwrap().truth.unwrap();
    let mut phases = vec![live.now.phase];
    for packet in &packets() {
        live.take(packet);
        if phases.last() != Some(&live.now.phase) {
            phases.push(live.now.phase);
        }
    }
    use Phase::{Held, HeldAfter, Idle, Sliding, Unknown};
    assert_eq!(phases, [Unknown, Idle, Held, Sliding, HeldAfter, Idle]);
    assert!(
        (live.now.phase_since_s.unwrap() - truth.release_s).abs() < 0.05,
        "{:?} {truth:?}",
        live.now.phase_since_s
    );
    assert!((live.now.now_s.unwrap() - truth.end_s).abs() < 1.5);
    assert_eq!((live.now.touches, live.now.restarts), (1, 0));
    let slide = live.whole_slide().unwrap();
    assert_eq!(slide.status, Status::Good);
    assert!((f64::from(slide.frequency) / truth.frequency_hz - 1.0).abs() < 1e-3);
    let points: Vec<_> = live.history.iter().collect();
    assert!(
        points.len() > 3
            && points
                .iter()
                .all(|p| p.frequency_hz.is_some() && p.channels.is_empty()),
        "{points:?}"
    );
    assert!(
        points
            .windows(2)
            .all(|pair| pair[0].t_s <= pair[1].t_s + 1.0)
    );
    let (before, after) = (live.image_before().unwrap(), live.image_after().unwrap());
    assert!(before.end_us <= after.start_us);
    let image = live.image().unwrap();
    // The map's row 1 begins with taxel 3.
    let level_v = after
        .taxels
        .iter()
        .find(|found| found.taxel == 3)
        .map(|found| found.level_v);
    assert_eq!(
        (image.hold, static_image::map_v(image)[1][0]),
        (Hold::AfterSlide, level_v)
    );
    assert!(live.health().is_some() && live.strips.is_empty() && live.now.faults.is_empty());
    assert!(
        live.log.iter().any(|line| line.contains("contact"))
            && live.log.iter().all(|line| !line.contains('\n'))
    );
}

#[test]
fn it_can_be_serialised_with_the_names_that_json_lines_have() {
    let mut live = Live::new("a scene");
    packets().iter().for_each(|packet| live.take(packet));
    let mut codes = [0; ridgetone_proto::settings::TAXELS];
    codes[1] = 7_864_320;
    let raw = Raw {
        t_us: 5_000_000,
        number: 1200,
        present: 0b1011,
        good: 0b0111,
        codes,
    };
    live.take(&Packet {
        sequence: 99,
        event: Event::Raw(raw),
    });
    let json = serde_json::to_value(&live).unwrap();
    assert_eq!(
        (&json["phase"], &json["connection"]["state"]),
        (&"idle".into(), &"connected".into())
    );
    assert_eq!(json["latest"]["hello"]["type"], "hello");
    assert_eq!(json["latest"]["whole_slide"]["status"], "good");
    assert_eq!(json["latest"]["image_after"]["hold"], "after_slide");
    assert_eq!(
        json["history"].as_array().unwrap().len(),
        live.history.len()
    );
    // The reference's code converts to the reference voltage; taxel 2 was not read, taxel 3 is
    // doubtful.
    let strips = &json["strips"];
    assert_eq!(
        (&strips["t_s"][0], &strips["number"][0]),
        (&5.0.into(), &1200.into())
    );
    assert!((strips["volts"][1][0].as_f64().unwrap() - 4.096).abs() < 1e-6);
    assert_eq!(strips["volts"][0][0], 0.0);
    assert!(strips["volts"][2][0].is_null() && strips["volts"][3][0].is_null());
}

fn hello(sequence: u16, t_us: u64) -> Packet {
    let (settings, boot) = (
        Settings {
            vref_v: 2.5,
            ..Settings::DEFAULT
        },
        Boot::default(),
    );
    let source = SettingsSource::Stored;
    let hello = Hello {
        protocol: PROTOCOL,
        version: [0, 1, 0],
        frame_rate_hz: 241.14,
        settings,
        source,
        boot,
        t_us,
    };
    Packet {
        sequence,
        event: Event::Hello(hello),
    }
}

#[test]
fn a_restart_begins_a_new_axis_and_a_repeated_greeting_does_not() {
    let mut live = Live::new("a scene");
    packets().iter().for_each(|packet| live.take(packet));
    let lines = live.log.len();
    // After the sequence number wraps, a periodic greeting may also have number 0.
    live.take(&hello(0, 20_000_000));
    live.take(&hello(701, 30_000_000));
    assert_eq!((live.now.restarts, live.log.len()), (0, lines + 1));
    assert!(live.estimate().is_some() && live.settings().vref_v == 2.5);
    live.take(&hello(3, 0));
    assert_eq!(
        (live.now.restarts, live.now.phase, live.now.now_s),
        (1, Phase::Idle, None)
    );
    assert!(live.estimate().is_none() && live.history.is_empty());
}

#[test]
fn faults_stand_as_long_as_they_last_and_memory_is_bounded() {
    let mut live = Live::new("a board");
    let fault = |kind, until_us| Packet {
        sequence: 1,
        event: Event::Fault(Fault {
            kind,
            from_us: 1_000_000,
            until_us,
            count: 1,
        }),
    };
    live.take(&fault(FaultKind::Clock, None));
    live.take(&fault(FaultKind::Supply, None));
    live.take(&fault(FaultKind::Clock, Some(2_000_000)));
    let kinds: Vec<_> = live.now.faults.iter().map(|fault| fault.kind).collect();
    assert_eq!(kinds, [FaultKind::Supply]);
    let estimate = packets()
        .into_iter()
        .find(|packet| matches!(packet.event, Event::Estimate(_)))
        .unwrap();
    for number in 0..3000 {
        live.take(&estimate);
        let raw = Raw {
            t_us: 0,
            number,
            present: u16::MAX,
            good: u16::MAX,
            codes: [1; 16],
        };
        live.take(&Packet {
            sequence: 1,
            event: Event::Raw(raw),
        });
        live.take(&fault(FaultKind::Bus, Some(1)));
    }
    assert_eq!(
        (live.history.len(), live.strips.len(), live.log.len()),
        (2000, 965, 200)
    );
    assert_eq!(
        live.strips.iter().next().map(|frame| frame.number),
        Some(3000 - 965)
    );
}

#[test]
fn the_log_names_a_converter_that_does_not_answer() {
    let mut live = Live::new("a board");
    let mut take = |answers| {
        live.take(&Packet {
            sequence: 0,
            event: Event::Converter(ConverterState {
                name: "ADS1258".try_into().unwrap(),
                answers,
                ..ConverterState::default()
            }),
        });
        live.log.iter().cloned().collect::<Vec<_>>()
    };
    assert!(take(true).is_empty(), "every ten seconds");
    let lines = take(false);
    assert!(
        lines.len() == 1 && lines[0].contains("ADS1258 DOES NOT ANSWER"),
        "{lines:?}"
    );
}
