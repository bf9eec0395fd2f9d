//! Tests the player with frames of a known pressure.

use super::*;
use ridgetone_host::static_image::PLACES;
use ridgetone_proto::settings::{Settings, TAXELS};
use ridgetone_proto::telemetry::{Contact, Event, Packet, Raw};

const FRAME_US: u64 = 4147;

fn packet(event: Event) -> Packet {
    Packet { sequence: 1, event }
}

/// A frame with each taxel `volts` volts above 0.5 V.
fn raw(number: u32, volts: [f64; TAXELS]) -> Packet {
    // Full scale of 24 bits is 1.066 times the reference (SBAS297G, data format).
    let code =
        |volts: f64| (volts / f64::from(Settings::DEFAULT.vref_v) * f64::from(0x78_0000)) as i32;
    let codes = volts.map(|volts| code(0.5 + volts));
    packet(Event::Raw(Raw {
        t_us: u64::from(number) * FRAME_US,
        number,
        present: u16::MAX,
        good: u16::MAX,
        codes,
    }))
}

/// Plays one second without contact, then two with a strain of 2 % in the left half of the map, and
/// with shear.
fn touched(player: &mut Player) -> Vec<Update> {
    let mut updates = Vec::new();
    for number in 0..723u32 {
        if number == 245 {
            player
                .take(&packet(Event::Contact(Contact {
                    t_us: 241 * FRAME_US,
                    taxel: 0,
                    height_v: 0.004,
                    onset_us: 0,
                    reported_after_us: 0,
                })))
                .expect("a contact");
        }
        let volts = std::array::from_fn(|taxel| {
            let is_left = PLACES.iter().any(|row| row[..2].contains(&taxel));
            let tilt = [1.0, 0.0, -1.0, 0.0][taxel % 4];
            let pressed = if is_left {
                0.02 * volts_per_strain()
            } else {
                0.0
            };
            if number < 241 {
                0.0
            } else {
                pressed + 0.004 * tilt
            }
        });
        updates.extend(player.take(&raw(number, volts)).expect("a frame"));
    }
    updates
}

#[test]
fn a_pressed_half_is_felt_as_a_half() {
    let setup = Setup::new().expect("a setup");
    let mut player = Player::new(setup).expect("a player");
    let updates = touched(&mut player);
    // At most 20 Hz: an update every 13 frames, after the 48 frames of the level.
    assert_eq!(updates.len(), (723 - 48) / 13);
    let last = updates.last().expect("an update");
    for (n, strain) in last.sensor_strain.iter().enumerate() {
        let target = if n % 4 < 2 { 0.02 } else { 0.0 };
        assert!((strain - target).abs() < 1e-5, "{n}: {strain}");
    }
    let half = |values: &[f32], left: bool| -> f32 {
        values
            .iter()
            .enumerate()
            .filter(|(n, _)| (n % 4 < 2) == left)
            .map(|(_, value)| value)
            .sum()
    };
    assert!(
        half(&last.forces_n, true) > 5.0 * half(&last.forces_n, false),
        "{last:?}"
    );
    assert!(last.is_optimal && last.limited == 0 && last.forces_n.iter().all(|n| *n >= 0.0));
    // The layer limits the sharpness of an edge.
    assert!(
        last.error(1.0) < 0.3 * 0.02,
        "{}: {last:?}",
        last.error(1.0)
    );
    // A silent line releases the pins, within the slew limit.
    let before = last.forces_n.clone();
    let released = player.silent(SILENCE_S).expect("time").expect("they press");
    assert!(
        released
            .forces_n
            .iter()
            .zip(&before)
            .all(|(now, before)| now <= before)
    );
    for _ in 0..20 {
        player.silent(0.05).expect("time");
    }
    assert_eq!(player.silent(0.05).expect("time"), None);
}
