extern crate std;

use super::*;
use std::vec::Vec;

const CLOCK_MHZ: u8 = 21;

fn averaging(channels: u32, scans: u32) -> Option<Averaging> {
    Averaging::new(channels, scans, CLOCK_MHZ)
}

/// Feeds a signal, a function of input and time in seconds, through the buffer's halves. Returns
/// the time and the codes of each frame.
fn frames(
    averaging: &Averaging,
    count: u32,
    reading: impl Fn(u32, f64) -> u16,
) -> Vec<(u32, [i32; 16])> {
    let (oversampler, buffer) = (Oversampler::new(), [const { AtomicU16::new(0) }; 2 * HALF]);
    oversampler.begin(averaging);
    let mut found = Vec::new();
    let half = averaging.half() as u32;
    for at in 0..count * u32::from(averaging.scans / averaging.half_scans) {
        let place = (at % 2 * half) as usize;
        for number in 0..half {
            let sample = at * half + number;
            let t_s = f64::from(sample * SAMPLE_TICKS) / (f64::from(averaging.clock_mhz) * 1e6);
            buffer[place + number as usize].store(
                reading(sample % u32::from(averaging.channels), t_s),
                Relaxed,
            );
        }
        let end_us =
            u64::from((at + 1) * half) * u64::from(SAMPLE_TICKS) / u64::from(averaging.clock_mhz);
        let filled = if at % 2 == 0 {
            Filled::First
        } else {
            Filled::Second
        };
        if oversampler.take(&buffer, filled, end_us as u32) {
            let codes =
                core::array::from_fn(|channel| oversampler.code(channel).map_or(0, |code| code.0));
            found.push((oversampler.frame_us(), codes));
        }
    }
    found
}

#[test]
fn frames_have_the_rates_of_the_plans() {
    // Inputs, scans, megahertz, frames a second, scans per half of the buffer.
    for (channels, scans, clock_mhz, rate_hz, half_scans) in [
        (14, 93, 21, 237.2, 3),
        (14, 15, 21, 1470.6, 3),
        (8, 160, 21, 241.3, 5),
        (8, 28, 21, 1378.7, 4),
        (8, 190, 25, 241.9, 5),
    ] {
        let averaging = Averaging::new(channels, scans, clock_mhz).unwrap();
        assert_eq!(averaging.half_scans, half_scans);
        let found_hz = 1e6 * f64::from(clock_mhz) / f64::from(averaging.frame_ticks());
        assert!((found_hz - rate_hz).abs() < 0.1, "{found_hz}");
    }
    // Refused: a half of 45 us, and more scans than fit a byte.
    assert_eq!(averaging(14, 91), None);
    assert_eq!(averaging(14, 256), None);
    assert_eq!(averaging(0, 92), None);
}

#[test]
fn a_code_of_780000h_is_the_reference() {
    let averaging = averaging(14, 15).unwrap();
    let found = frames(&averaging, 2, |_, _| 2048);
    assert!(
        found
            .iter()
            .all(|(_, codes)| codes[..14] == [0x3c_0000; 14]),
        "{found:?}"
    );
    let found = frames(&averaging, 2, |_, _| 4095);
    assert!((found[1].1[13] - 4095 * 1920).abs() <= 1, "{found:?}");
}

/// Tests that a ramp reads the same on all inputs, at the time of the frame.
#[test]
fn inputs_that_are_sampled_in_turn_are_as_if_at_once() {
    for (channels, scans) in [(14, 15), (14, 93), (8, 28)] {
        let averaging = averaging(channels, scans).unwrap();
        // 4000 steps in 0.1 s: 1.8 steps from the first input to the last.
        let found = frames(&averaging, 20, |_, t_s| (40_000.0 * t_s) as u16);
        for (t_us, codes) in &found[1..] {
            let steps = codes.map(|code| f64::from(code) / 1920.0);
            let expected = 40_000e-6 * f64::from(*t_us) - 0.5;
            for (channel, steps) in steps.iter().enumerate().take(channels as usize) {
                assert!(
                    (steps - expected).abs() < 0.3,
                    "{channel}: {steps} for {expected}"
                );
            }
        }
        // Without a previous frame, the last input still reads later.
        assert!(found[0].1[channels as usize - 1] > found[0].1[0] + 960);
    }
}

#[test]
fn halves_that_nobody_took_leave_a_whole_frame_out() {
    let averaging = averaging(14, 15).unwrap();
    let (oversampler, buffer) = (Oversampler::new(), [const { AtomicU16::new(9) }; 2 * HALF]);
    oversampler.begin(&averaging);
    // A half takes 136 us; a frame is five halves.
    let at_us = |half: u32| half * 136;
    let mut ends = Vec::new();
    for half in 1..=30 {
        // Service is late for halves 7 and 8, and for halves 16 to 20.
        if [7, 16, 17, 18, 19].contains(&half) {
            continue;
        }
        let filled = match half {
            8 | 20 => Filled::Overwritten,
            half if half % 2 == 1 => Filled::First,
            _ => Filled::Second,
        };
        if oversampler.take(&buffer, filled, at_us(half)) {
            ends.push(half);
            assert_eq!(oversampler.code(0), Some((9 * 1920, false)));
        }
    }
    assert_eq!(ends, [5, 15, 25, 30]);
}

#[test]
fn an_input_at_an_end_of_the_scale_is_marked() {
    let averaging = averaging(14, 15).unwrap();
    let (oversampler, buffer) = (Oversampler::new(), [const { AtomicU16::new(9) }; 2 * HALF]);
    oversampler.begin(&averaging);
    for (at, place) in buffer.iter().enumerate() {
        place.store([0, 4095, 1, 4094][at % 14 % 4], Relaxed);
    }
    let ends = [Filled::First; 5].map(|filled| oversampler.take(&buffer, filled, 0));
    assert_eq!(ends, [false, false, false, false, true]);
    let marks: Vec<bool> = (0..4)
        .filter_map(|channel| oversampler.code(channel))
        .map(|code| code.1)
        .collect();
    assert_eq!(marks, [true, true, false, false]);
    assert_eq!(oversampler.code(16), None);
}
