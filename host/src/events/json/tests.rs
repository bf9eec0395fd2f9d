//! Tests packets of each kind as lines of JSON.

use super::*;
use ridgetone_proto::fault::{FaultKind, FaultSet};
use ridgetone_proto::plan::Plan;
use ridgetone_proto::telemetry::{
    Contact, Direction, Estimate, Hold, Image, Movement, OtherTone, Pressed, Slide, Span, Status,
    Texture, Track, Travel, TravelStatus,
};

#[test]
fn f32_values_read_back_to_the_last_bit() {
    let height_v = 0.1f32 + f32::EPSILON;
    let contact = Event::Contact(Contact {
        t_us: 510_003,
        taxel: 3,
        height_v,
        onset_us: 0,
        reported_after_us: 0,
    });
    let line = json(&Packet {
        sequence: 7,
        event: contact,
    })
    .unwrap();
    assert_eq!(
        line,
        format!(
            r#"{{"type":"contact","sequence":7,"t_s":0.510003,"taxel":3,"height_v":{height_v},"onset_s":0.0,"reported_after_s":0.0}}"#
        )
    );
    let (_, text) = line.split_once("\"height_v\":").unwrap();
    let (text, _) = text.split_once(',').unwrap();
    assert_eq!(text.parse::<f32>().unwrap().to_bits(), height_v.to_bits());
}

#[test]
fn an_image_has_the_taxels_that_are_alive() {
    let taxels = [0, 2]
        .map(|taxel| Pressed {
            taxel,
            level_v: 0.5,
            sigma_v: 0.25,
        })
        .into_iter()
        .collect();
    let image = Image {
        start_us: 3_500_000,
        end_us: 4_500_000,
        frames: 240,
        hold: Hold::AfterSlide,
        taxels,
    };
    let line = json(&Packet {
        sequence: 9,
        event: Event::Image(image),
    })
    .unwrap();
    assert_eq!(
        line,
        r#"{"type":"image","sequence":9,"t_s":4.5,"start_s":3.5,"end_s":4.5,"frames":240,"hold":"after_slide","taxels":[{"taxel":0,"level_v":0.5,"sigma_v":0.25},{"taxel":2,"level_v":0.5,"sigma_v":0.25}]}"#
    );
}

#[test]
fn without_a_tone_there_is_no_frequency() {
    let estimate = Estimate {
        t_us: 2_000_000,
        window_s: 1.0,
        span: Span::Window,
        status: Status::NoTone,
        frequency: 0.0,
        sigma: 0.0,
        movement: Movement::default(),
        other_tone: None,
        interferer_hz: Some(50.5),
        harmonics: 0,
        frames_missing: 2,
        faults: FaultSet::NONE.with(FaultKind::Lost),
        travel: Travel::NONE,
        channels: Default::default(),
    };
    let line = json(&Packet {
        sequence: 0,
        event: Event::Estimate(estimate),
    })
    .unwrap();
    assert_eq!(
        line,
        r#"{"type":"estimate","sequence":0,"t_s":2.0,"window_s":1.0,"span":"window","frequency_hz":null,"sigma_hz":null,"wander_percent":null,"wander_sigma_percent":null,"chirp_hz_per_s":null,"chirp_sigma_hz_per_s":null,"other_tone_hz":null,"other_tone_fraction":null,"interferer_hz":50.5,"status":"no_tone","harmonics":0,"frames_missing":2,"faults":["lost"],"travel":"nothing","direction":null,"spatial_period_mm":null,"spatial_period_sigma_mm":null,"speed_mm_s":null,"speed_sigma_mm_s":null,"channels":[]}"#
    );
}

#[test]
fn a_tone_has_its_movement_and_its_travel() {
    let estimate = Estimate {
        t_us: 2_000_000,
        window_s: 1.0,
        span: Span::Window,
        status: Status::Good,
        frequency: 0.25,
        sigma: 0.0625,
        movement: Movement {
            wander: 0.03125,
            wander_sigma: 0.015625,
            chirp: -0.75,
            chirp_sigma: 0.125,
        },
        other_tone: Some(OtherTone {
            frequency: 0.375,
            fraction: 0.5,
        }),
        interferer_hz: None,
        harmonics: 1,
        frames_missing: 0,
        faults: FaultSet::NONE,
        travel: Travel {
            status: TravelStatus::Given,
            direction: Direction::Backward,
            spatial_period_mm: 4.0,
            spatial_period_sigma_mm: 1.0,
            speed_mm_s: 30.0,
            speed_sigma_mm_s: 0.0,
        },
        channels: Default::default(),
    };
    let line = json(&Packet {
        sequence: 0,
        event: Event::Estimate(estimate),
    })
    .unwrap();
    let tone = r#""span":"window","frequency_hz":0.25,"sigma_hz":0.0625,"wander_percent":3.125,"wander_sigma_percent":1.5625,"chirp_hz_per_s":-0.75,"chirp_sigma_hz_per_s":0.125,"other_tone_hz":0.375,"other_tone_fraction":0.5,"interferer_hz":null,"status""#;
    assert!(line.contains(tone), "{line}");
    let travel = r#""travel":"given","direction":"backward","spatial_period_mm":4.0,"spatial_period_sigma_mm":1.0,"speed_mm_s":30.0,"speed_sigma_mm_s":0.0,"channels""#;
    assert!(line.contains(travel), "{line}");
}

#[test]
fn a_texture_has_its_plan_by_name() {
    let texture = Texture {
        t_us: 2_500_000,
        plan: Plan::HAND,
        period_mm: 3.5,
        period_sigma_mm: 0.25,
        power_v2: 0.5,
        power_sigma_v2: 0.125,
        overtones: [[0.0, 0.5], [0.0; 2], [0.0, -0.25]],
        level_v: None,
    };
    let line = |texture| {
        json(&Packet {
            sequence: 4,
            event: Event::Texture(texture),
        })
        .unwrap()
    };
    assert_eq!(
        line(texture),
        r#"{"type":"texture","sequence":4,"t_s":2.5,"plan":"hand","period_mm":3.5,"period_sigma_mm":0.25,"power_v2":0.5,"power_sigma_v2":0.125,"overtones":[{"amplitude":0.5,"phase_cycles":0.0},{"amplitude":0.0,"phase_cycles":0.0},{"amplitude":0.25,"phase_cycles":0.0}],"level_v":null}"#
    );
    assert!(
        line(Texture {
            level_v: Some(0.75),
            ..texture
        })
        .ends_with(r#""level_v":0.75}"#)
    );
}

#[test]
fn a_track_has_a_frequency_if_there_is_a_tone() {
    let line = |status| {
        json(&Packet {
            sequence: 1,
            event: Event::Track(Track {
                t_us: 1_500_000,
                frequency: 8.25,
                sigma: 0.125,
                status,
            }),
        })
    };
    assert_eq!(
        line(Status::Good).unwrap(),
        r#"{"type":"track","sequence":1,"t_s":1.5,"frequency_hz":8.25,"sigma_hz":0.125,"status":"good"}"#
    );
    assert_eq!(
        line(Status::NoTone).unwrap(),
        r#"{"type":"track","sequence":1,"t_s":1.5,"frequency_hz":null,"sigma_hz":null,"status":"no_tone"}"#
    );
}

#[test]
fn a_slide_is_reported_at_its_start_and_its_end() {
    let line = |end_us| {
        json(&Packet {
            sequence: 1,
            event: Event::Slide(Slide {
                start_us: 1_500_000,
                end_us,
                reported_after_us: 250_000,
            }),
        })
    };
    assert_eq!(
        line(None).unwrap(),
        r#"{"type":"slide","sequence":1,"t_s":1.5,"start_s":1.5,"end_s":null,"state":"start","reported_after_s":0.25}"#
    );
    assert_eq!(
        line(Some(3_500_000)).unwrap(),
        r#"{"type":"slide","sequence":1,"t_s":3.5,"start_s":1.5,"end_s":3.5,"state":"end","reported_after_s":0.25}"#
    );
}
