//! Tests that the fit never returns NaN or infinity. A code is never NaN, but a recording may
//! contain it.

use crate::case::Case;
use crate::reference::Tone;
use ridgetone_tone::Status;

const STRANGE: [f32; 5] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e25];

/// NaN in frames and taxels that are marked invalid must change nothing.
#[test]
fn behind_the_mask_they_change_nothing() {
    let mut clean = Case::new(Tone::default().values());
    clean.valid[17] = 0;
    clean.valid[100..120].fill(0);
    clean.valid.iter_mut().for_each(|valid| *valid &= !(1 << 5));
    clean.valid[60] &= 0x00ff;
    let expected = clean.assert_good("clean", 0.0346);
    for strange in STRANGE {
        let mut case = clean.clone();
        for (values, valid) in case.values.iter_mut().zip(&case.valid) {
            for (c, value) in values.iter_mut().enumerate() {
                if valid & 1 << c == 0 {
                    *value = strange;
                }
            }
        }
        let fit = case.fit();
        assert_eq!(
            (fit.status, fit.frames, fit.usable),
            (expected.status, expected.frames, expected.usable)
        );
        assert_eq!(
            (fit.frequency, fit.sigma, fit.channels),
            (expected.frequency, expected.sigma, expected.channels)
        );
    }
}

/// NaN in the input may cost its channel or the fit, but must not be returned: [`Case::fit`] checks
/// every field.
#[test]
fn in_valid_values_they_stay_inside() {
    for strange in STRANGE {
        for frames in [24, 145, 241, 965] {
            let tone = Tone {
                frames,
                frequency: 0.1,
                ..Tone::default()
            };
            let (middle, last) = (frames / 2, frames - 1);
            for (at, channels) in [
                (0, 1u16),
                (middle, 1 << 15),
                (last, 0b1010),
                (frames / 3, u16::MAX),
            ] {
                let mut case = Case::new(tone.values());
                for c in (0..16).filter(|c| channels & 1 << c != 0) {
                    case.values[at][c] = strange;
                }
                let fit = case.fit();
                let finite = strange.is_finite();
                assert!(
                    finite || fit.status != Status::Good || fit.usable & channels == 0,
                    "{strange} {fit:?}"
                );
            }
        }
    }
}

#[test]
fn a_channel_of_nothing_else_is_left_out() {
    for strange in [f32::NAN, f32::INFINITY] {
        let mut case = Case::new(Tone::default().values());
        case.values.iter_mut().for_each(|frame| frame[4] = strange);
        let fit = case.fit();
        assert_eq!(
            (fit.status, fit.usable),
            (Status::Good, !(1 << 4)),
            "{fit:?}"
        );
    }
}

/// The interferer's frequency is a setting, so the fit must cope with any value.
#[test]
fn in_the_interferer_they_stay_inside() {
    for cycles in [f32::NAN, f32::INFINITY, -0.2, 0.0, 1e30] {
        let mut case = Case::new(Tone::default().values());
        case.interferer = Some(cycles);
        case.fit();
    }
}
