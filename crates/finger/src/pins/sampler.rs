//! When an update of the display is due, and what is pressed then: the part beside touch detection.

use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::PinDisplay;
use ridgetone_tone::Values;

/// What an update is computed from.
#[derive(Clone, Debug, PartialEq)]
pub struct Due {
    /// Device time, microseconds.
    pub t_us: u64,
    /// Taxels that were good in all complete frames since the last update that was taken; bit k is
    /// taxel k.
    good: u16,
    /// Those of them whose values count.
    pub taxels: u16,
    /// Updates that fell due after the last one that was taken, and were not taken in time; 255 for
    /// more.
    pub skipped: u8,
    /// Means over a block of frames, less the level without touch, codes; zero without touch, and
    /// where the air is not known.
    pub pressed: Values,
}

impl Due {
    /// One in which these taxels count.
    pub const fn new(t_us: u64, taxels: u16, pressed: Values) -> Self {
        Self {
            t_us,
            good: taxels,
            taxels,
            skipped: 0,
            pressed,
        }
    }
}

/// Counts frames of touch detection.
#[derive(Clone, Debug)]
pub struct Sampler {
    /// Frames from one update to the next; zero: no updates.
    every: u32,
    /// Taxels that were good in all complete frames since the last update.
    good: u16,
    /// Until it is taken.
    due: Option<Due>,
}

impl Sampler {
    /// Before the first frame.
    #[inline(never)]
    pub const fn new(display: &PinDisplay, plan: &Plan) -> Self {
        let mut sampler = Self {
            every: 0,
            good: u16::MAX,
            due: None,
        };
        sampler.change(display, plan);
        sampler
    }

    /// From now on the updates of this display.
    pub const fn change(&mut self, display: &PinDisplay, plan: &Plan) {
        self.every = if display.is_on() {
            let frame_rate_hz = plan.frame_rate_hz() / plan.frames_averaged() as f32;
            // Rounded up, to a thousandth of a frame: not more updates than the display can follow.
            (frame_rate_hz / display.rate_hz as f32 + 0.999) as u32
        } else {
            0
        };
    }

    /// Notes which taxels of a complete frame are good.
    #[inline(always)]
    pub const fn note(&mut self, good: u16) {
        self.good &= good;
    }

    /// One frame of touch detection further. `pressed` gives the values and which of them are
    /// alive. The frame's number counts, so that updates do not depend on when they were switched
    /// on.
    #[inline(always)]
    pub fn step(&mut self, number: u32, t_us: u64, pressed: impl FnOnce() -> (Values, u16)) {
        if self.every > 0 && number.is_multiple_of(self.every) {
            self.fall_due(t_us, pressed());
        }
    }

    #[inline(never)]
    fn fall_due(&mut self, t_us: u64, (pressed, alive): (Values, u16)) {
        // An update that was not taken in time is lost, but not which taxels were bad before it.
        let (before, skipped) = self.due.as_ref().map_or((u16::MAX, 0), |due| {
            (due.good, due.skipped.saturating_add(1))
        });
        let good = core::mem::replace(&mut self.good, u16::MAX) & before;
        self.due = Some(Due {
            t_us,
            good,
            taxels: good & alive,
            skipped,
            pressed,
        });
    }

    /// Whether an update waits.
    pub const fn is_due(&self) -> bool {
        self.due.is_some()
    }

    /// The update that waits.
    pub const fn take(&mut self) -> Option<Due> {
        self.due.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::settings::TAXELS;

    const ON: PinDisplay = PinDisplay {
        rate_hz: 50,
        ..PinDisplay::DEFAULT
    };

    fn dues(display: &PinDisplay, plan: &Plan, frames: u64) -> impl Iterator<Item = (u64, Due)> {
        let mut sampler = Sampler::new(display, plan);
        (0..frames).filter_map(move |frame| {
            sampler.note(if frame == 7 { !1 } else { u16::MAX });
            sampler.step(frame as u32 + 1, frame, || ([frame as f32; TAXELS], 0x0fff));
            sampler.take().map(|due| (frame, due))
        })
    }

    #[test]
    fn updates_are_never_more_than_the_display_can_follow() {
        for (name, plan) in Plan::NAMED {
            let frame_rate_hz = plan.frame_rate_hz() / plan.frames_averaged() as f32;
            for rate_hz in 8..=50 {
                let display = PinDisplay { rate_hz, ..ON };
                let found = dues(&display, &plan, 1000)
                    .map(|(frame, _)| frame)
                    .last()
                    .expect("updates")
                    + 1;
                let count = dues(&display, &plan, 1000).count() as f32;
                let found_hz = frame_rate_hz * count / found as f32;
                // A step of whole frames, and no slower than that.
                let slowest_hz = frame_rate_hz / (frame_rate_hz / f32::from(rate_hz) + 1.0);
                assert!(
                    found_hz <= 1.001 * f32::from(rate_hz) && found_hz >= slowest_hz,
                    "{name} {rate_hz} {found_hz}"
                );
            }
        }
        assert_eq!(dues(&PinDisplay::DEFAULT, &Plan::PAPER, 1000).count(), 0);
    }

    #[test]
    fn an_update_has_the_taxels_that_were_good_since_the_last_one() {
        let found: Vec<Due> = dues(&ON, &Plan::PAPER, 15).map(|(_, due)| due).collect();
        assert_eq!(
            found.iter().map(|due| due.taxels).collect::<Vec<_>>(),
            [0x0fff, 0x0ffe, 0x0fff]
        );
        assert!(
            found
                .iter()
                .all(|due| due.pressed == [due.t_us as f32; TAXELS])
        );
    }

    #[test]
    fn a_lost_update_does_not_lose_which_taxels_were_bad() {
        let mut sampler = Sampler::new(&ON, &Plan::PAPER);
        for frame in 0..10 {
            sampler.note(if frame == 2 { !4 } else { u16::MAX });
            // Without touch no taxel counts, and that is no fault of theirs.
            sampler.step(frame as u32 + 1, frame, || {
                ([0.0; TAXELS], if frame < 5 { 0 } else { u16::MAX })
            });
        }
        assert!(sampler.is_due());
        assert_eq!(
            sampler
                .take()
                .map(|due| (due.t_us, due.taxels, due.skipped)),
            Some((9, !4, 1))
        );
        assert_eq!(sampler.take(), None);
    }

    extern crate std;
    use std::vec::Vec;
}
