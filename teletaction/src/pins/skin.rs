//! Converts raw frames to strains under the sensor's skin.
//!
//! Pressure strains all four piezoresistors of a unit alike. Shear tilts the mesa, which stretches
//! piezoresistor 1 as much as it compresses 3 (Oddo et al. 2009, section 2.1), so their mean is
//! free of shear. A unit therefore has three values: the mean for both 1 and 3, and the values of 2
//! and 4.

use hal_mock::Finger;
use ridgetone_host::frame::Frame;
use ridgetone_host::static_image::{PLACES, SIDE};
use ridgetone_proto::settings::TAXELS;
use std::collections::VecDeque;

/// Number of frames averaged for the idle level, and of frames before a reported contact that may
/// already belong to the contact: 0.4 s and 0.1 s at 241 frames a second.
const LEVEL_FRAMES: usize = 96;
const LATE_FRAMES: usize = 24;

/// Volts per unit of normal strain in a channel of the simulated finger, a quarter bridge.
pub fn volts_per_strain() -> f64 {
    let finger = Finger::default();
    0.25 * finger.supply_v * finger.sensitivity * finger.normal_share
}

type Volts = [Option<f32>; TAXELS];

/// The sensor's skin, with the idle level of each channel.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    latest: VecDeque<Volts>,
    level: Option<Volts>,
    is_touched: bool,
}

impl Skin {
    pub fn touched(&mut self, is_touched: bool) {
        self.is_touched = is_touched;
        self.latest.clear();
    }

    /// Takes a frame; returns volts above the idle level, once the level is known.
    pub fn push(&mut self, frame: &Frame) -> Option<Volts> {
        if !self.is_touched {
            if self.latest.len() == LEVEL_FRAMES + LATE_FRAMES {
                self.latest.pop_front();
            }
            self.latest.push_back(frame.volts);
            // Average at least as many frames as may already belong to a contact.
            if self.latest.len() >= 2 * LATE_FRAMES {
                let frames = || self.latest.iter().take(self.latest.len() - LATE_FRAMES);
                self.level = Some(std::array::from_fn(|taxel| {
                    mean(frames().filter_map(|volts| volts[taxel]))
                }));
            }
        }
        let level = self.level.as_ref()?;
        Some(std::array::from_fn(|taxel| {
            Some(frame.volts[taxel]? - level[taxel]?)
        }))
    }
}

/// Map of strains, row by row, from volts above the idle level. A dead taxel takes the mean of its
/// unit, and a dead unit has no strain.
pub fn strains(volts: &Volts, volts_per_strain: f64) -> [f32; SIDE * SIDE] {
    let mut pressed = [0.0; TAXELS];
    for (pressed, unit) in pressed
        .as_chunks_mut()
        .0
        .iter_mut()
        .zip(volts.as_chunks().0)
    {
        *pressed = pressed_unit(unit);
    }
    std::array::from_fn(|position| {
        (f64::from(pressed[PLACES.as_flattened()[position]]) / volts_per_strain) as f32
    })
}

/// Volts of a unit's four piezoresistors caused by pressure alone.
fn pressed_unit(&[first, second, third, fourth]: &[Option<f32>; 4]) -> [f32; 4] {
    let pair = first.zip(third).map(|(first, third)| 0.5 * (first + third));
    let mean = mean([pair, second, fourth].into_iter().flatten()).unwrap_or(0.0);
    let [pair, second, fourth] = [pair, second, fourth].map(|value| value.unwrap_or(mean));
    [pair, second, pair, fourth]
}

fn mean(values: impl Iterator<Item = f32>) -> Option<f32> {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| {
        (sum + f64::from(value), count + 1)
    });
    (count > 0).then(|| (sum / f64::from(count)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shear_is_cancelled_and_the_dead_are_replaced() {
        // A pressure that strains by 0.01, and a shear that tilts each unit.
        let mut volts: Volts =
            std::array::from_fn(|taxel| Some(0.00125 + [0.007, 0.0, -0.007, 0.0][taxel % 4]));
        let is_even = |volts: &Volts| {
            strains(volts, 0.125)
                .iter()
                .all(|s| (s - 0.01).abs() < 1e-6)
        };
        assert!(is_even(&volts));
        // Without its pair, piezoresistor 1 is not usable.
        (volts[2], volts[5]) = (None, None);
        assert!(is_even(&volts));
        volts[8..12].fill(None);
        let strains = strains(&volts, 0.125);
        assert_eq!(strains.iter().filter(|strain| **strain == 0.0).count(), 4);
    }

    #[test]
    fn the_level_does_not_follow_a_touch() {
        let mut skin = Skin::default();
        let frame = |volts: f32| Frame {
            t_s: 0.0,
            number: 0,
            volts: [Some(volts); TAXELS],
        };
        assert!((0..47).all(|_| skin.push(&frame(2.5)).is_none()));
        assert_eq!(skin.push(&frame(2.5)), Some([Some(0.0); TAXELS]));
        // The contact is reported 20 frames late, and lasts.
        for n in 0..1000 {
            if n == 20 {
                skin.touched(true);
            }
            assert_eq!(
                skin.push(&frame(2.6)),
                Some([Some(2.6 - 2.5); TAXELS]),
                "{n}"
            );
        }
        skin.touched(false);
        let after = (0..100)
            .filter_map(|_| skin.push(&frame(2.51)))
            .last()
            .expect("a level");
        assert!(after[0].expect("alive").abs() < 1e-6);
    }
}
