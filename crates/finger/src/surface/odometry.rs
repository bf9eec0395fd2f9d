//! A robot's odometry: its messages are numbered, their stamps aligned with the board's clock, and
//! their places kept, so that a window can be fitted by place while the speed varies and turns.
//!
//! | step | module |
//! |---|---|
//! | number a message, count what is lost, late and doubled | [`Odometer::take`], [`counters`] |
//! | the robot's clock against the board's | [`alignment`] |
//! | places of the latest seconds | [`track`] |
//! | what is known when a window falls due | [`Odometer::mark`] |
//! | the place of every frame of a window | [`trajectory`] |

pub mod alignment;
pub mod counters;
pub mod track;
pub mod trajectory;

use crate::faults::diagnostics::Diagnostics;
use alignment::Alignment;
use ridgetone_proto::odometry::{Odometry, PLACE_PER_MM, Reading, SPEED_MAX_MM_S};
use track::{ENTRIES, Entry, Track};

/// Without a message for so long places are stale, microseconds: a hand that goes to and fro at
/// 1.07 Hz (197 mm/s at most) is by then 7 mm from where its speed would lead.
pub const STALE_US: u32 = 100_000;
/// A message that took so much longer than the quickest ones is late, microseconds.
const LATE_US: i32 = 20_000;
/// A stamp whose delay differs by so much from the quickest ones is of another clock, microseconds:
/// the robot has started again.
const JUMP_US: u32 = 1_000_000;
/// Fastest motion, tenths of a micrometre in a microsecond: [`SPEED_MAX_MM_S`].
const STEPS_A_US: u32 = 20;
/// Without a message for so long there is no robot, microseconds. Much shorter than half the range
/// of the clocks, beyond which an old stamp would look new.
const GONE_US: u32 = 60_000_000;
/// Entries that a window may use, enough for a full ring of frames. The others are for those that
/// come while it is fitted.
const USABLE: u16 = ENTRIES as u16 - 4;

/// Unit of the difference of the clocks' rates in a [`Mark`]: 0.1 us in a full ring;
/// [`alignment::FASTER_MOST`] is 16,777 of it.
const FASTER_UNIT: f32 = 1.0 / (1u32 << 25) as f32;
/// Only every eighth message's delay is looked at, because that takes time. The mean is over about
/// eight of these.
const DELAY_EVERY: u16 = 8;
const DELAY_MESSAGES: f32 = 8.0;
/// Standard deviation of the quickest messages' delay over the mean delay beyond theirs. Stamps and
/// times of arrival show the one and not the other; what makes messages late, such as a scheduler
/// or a bus, makes the quickest ones late by about as much.
const DELAY_SHARE: f32 = 0.5;

/// What is known of the robot's motion when a window falls due.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mark {
    /// Number of the entry behind the newest one; that of the oldest if no robot streams.
    until: u16,
    /// Number of the oldest entry that may be used.
    oldest: u16,
    /// The newest entry. In the track it may have moved on by the time of the fit.
    newest: Entry,
    /// The robot's time at the window's end, microseconds.
    end_us: u32,
    /// Microseconds of the robot's clock in one of the board's, less 1, in units of
    /// [`FASTER_UNIT`].
    faster: i16,
    /// Standard deviation of the delay of the quickest messages, microseconds: all places may be
    /// that late.
    delay_sigma_us: u16,
}

impl Mark {
    /// No robot streams.
    pub const NONE: Self = Self {
        until: 0,
        oldest: 0,
        newest: Entry { t_us: 0, place: 0 },
        end_us: 0,
        faster: 0,
        delay_sigma_us: 0,
    };

    /// Whether a robot streams.
    pub const fn is_some(&self) -> bool {
        self.until != self.oldest
    }

    /// Microseconds of the robot's clock in one of the board's, less 1.
    fn faster(&self) -> f32 {
        self.faster as f32 * FASTER_UNIT
    }

    /// Standard deviation of the delay of the quickest messages, seconds.
    pub const fn delay_sigma_s(&self) -> f32 {
        self.delay_sigma_us as f32 * 1e-6
    }
}

/// The newest message.
#[derive(Clone, Copy, Debug)]
struct Newest {
    number: u16,
    t_us: u32,
    /// Place, and the part of a unit that rounding has left where it follows from speeds.
    place: i32,
    rest: f32,
    /// NaN for a place.
    speed_mm_s: f32,
}

/// Takes a robot's messages.
#[derive(Debug)]
pub struct Odometer {
    alignment: Alignment,
    newest: Option<Newest>,
    /// Bit k: the message k numbers before the newest has arrived.
    arrived: u32,
    /// Mean delay of the latest messages beyond that of the quickest ones, microseconds.
    over_us: f32,
}

/// A message of a robot and when it was sent.
pub struct SentOdometry<'a> {
    pub message: &'a Odometry,
    /// Board time without the line's delay, microseconds, wrapping.
    pub sent_us: u32,
}

impl Odometer {
    /// Before the first message.
    pub const fn new() -> Self {
        Self {
            alignment: Alignment::new(),
            newest: None,
            arrived: 0,
            over_us: 0.0,
        }
    }

    /// Takes a message. The track is to last for `ring_us`.
    pub fn take(
        &mut self,
        received: SentOdometry<'_>,
        ring_us: u32,
        track: &Track,
        diagnostics: &Diagnostics,
    ) {
        let Odometry {
            number,
            t_us,
            reading,
        } = *received.message;
        let sent_us = received.sent_us;
        let speed_mm_s = if let Reading::Speed(mm_s) = reading {
            mm_s
        } else {
            f32::NAN
        };
        if speed_mm_s.abs() > SPEED_MAX_MM_S
            || matches!(reading, Reading::Speed(mm_s) if mm_s.is_nan())
        {
            return diagnostics.requests_damaged.add(1);
        }
        let counters = &diagnostics.odometry;
        counters.received.add(1);
        let delay_us = self.alignment.delay_us(t_us, sent_us);
        // Beside the quickest of late: clocks drift apart by seconds in an hour.
        let over_us = delay_us.wrapping_sub(self.alignment.least_us());
        let begins = self.newest.is_none() || over_us.unsigned_abs() >= JUMP_US;
        let newest = self.newest.unwrap_or(Newest {
            number,
            t_us,
            place: 0,
            rest: 0.0,
            speed_mm_s,
        });
        let passed_us = t_us.wrapping_sub(newest.t_us) as i32;
        let ahead = number.wrapping_sub(newest.number) as i16;
        if begins {
            self.alignment.restart(t_us, sent_us);
            self.over_us = 0.0;
        } else if ahead <= 0 && (ahead > -(u32::BITS as i16) || passed_us <= 0) {
            let bit = 1u32.checked_shl(ahead.unsigned_abs().into()).unwrap_or(0);
            let counter = if self.arrived & bit != 0 {
                &counters.doubled
            } else {
                &counters.late
            };
            self.arrived |= bit;
            return counter.add(1);
        } else {
            if over_us > LATE_US {
                counters.late.add(1);
            }
            self.alignment.take(t_us, delay_us);
            if number.is_multiple_of(DELAY_EVERY) {
                let over_us = self.alignment.robot_us(sent_us).0.wrapping_sub(t_us) as i32;
                self.over_us +=
                    (over_us.clamp(0, LATE_US) as f32 - self.over_us) * (1.0 / DELAY_MESSAGES);
            }
        }
        // Numbers that go back, or on by more than can have been sent since, are those of a program
        // that has started again.
        let is_new_run = ahead < 0 || i32::from(ahead) > passed_us / 1000 + 32;
        let steps = if begins || is_new_run {
            1
        } else {
            u32::from(ahead.unsigned_abs())
        };
        counters.numbers.add(steps);
        self.arrived = self.arrived.checked_shl(steps).unwrap_or(0) | 1;
        if !begins && passed_us <= 0 {
            // From a time that stands still nothing follows but that the message was there.
            self.newest = Some(Newest { number, ..newest });
            return;
        }
        let passed_us = passed_us as u32;
        let (mut place, mut rest) = (newest.place, 0.0);
        if let Reading::Place(sent) = reading {
            place = sent;
        } else {
            let way =
                0.5 * (speed_mm_s + newest.speed_mm_s) * (PLACE_PER_MM * 1e-6) * passed_us as f32
                    + newest.rest;
            let whole = libm::roundf(way);
            // After a place it is none.
            (place, rest) = (
                place.wrapping_add(whole as i32),
                if way.is_nan() { 0.0 } else { way - whole },
            );
        }
        let is_other = newest.speed_mm_s.is_nan() != speed_mm_s.is_nan();
        let way = place.wrapping_sub(newest.place).unsigned_abs();
        if begins || is_other || passed_us > STALE_US || way > STEPS_A_US * (passed_us + 1) {
            track.clear();
        }
        self.newest = Some(Newest {
            number,
            t_us,
            place,
            rest,
            speed_mm_s,
        });
        track.put(Entry { t_us, place }, ring_us / u32::from(USABLE));
    }

    /// Frames are of another plan from now on: the track begins again.
    pub fn change_plan(&mut self, track: &Track) {
        self.newest = None;
        track.clear();
    }

    /// What is known for a window that ends at a board time, microseconds, wrapping.
    pub fn mark(&self, board_us: u32, track: &Track) -> Mark {
        let (Some((until, newest)), Some(_)) = (track.newest(), self.newest) else {
            return Mark::NONE;
        };
        let (end_us, faster) = self.alignment.robot_us(board_us);
        let oldest = until.wrapping_sub(USABLE.min(until.wrapping_sub(track.oldest())));
        let (faster, delay_sigma_us) = (
            (faster * (1.0 / FASTER_UNIT)) as i16,
            (self.over_us * DELAY_SHARE) as u16,
        );
        Mark {
            until,
            oldest,
            newest,
            end_us,
            faster,
            delay_sigma_us,
        }
    }

    /// Forgets a robot that has been silent for a minute, `board_us` being now. To be called every
    /// few minutes at least.
    pub fn forget(&mut self, board_us: u32, track: &Track) {
        let Some(newest) = self.newest else { return };
        if self
            .alignment
            .robot_us(board_us)
            .0
            .wrapping_sub(newest.t_us) as i32
            > GONE_US as i32
        {
            self.newest = None;
            track.clear();
        }
    }
}

impl Default for Odometer {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ridgetone_proto::telemetry::OdometryCounts;

    /// A robot whose clock is coarser than its messages: 8 and 10 ms for one in 4 ms.
    #[test]
    fn a_clock_that_stands_still_loses_nothing() {
        for step_us in [8_000, 10_000] {
            let (mut odometer, track, diagnostics) =
                (Odometer::new(), Track::new(), Diagnostics::new());
            for (number, sent_us) in (0u16..2500).zip((5_000u32..).step_by(4_000)) {
                let t_us = sent_us / step_us * step_us;
                let message = Odometry {
                    number,
                    t_us,
                    reading: Reading::Place(i32::from(number)),
                };
                let received = SentOdometry {
                    message: &message,
                    sent_us: sent_us + 300,
                };
                odometer.take(received, 4_000_000, &track, &diagnostics);
            }
            let OdometryCounts {
                received,
                lost,
                doubled,
                ..
            } = diagnostics.odometry.get();
            assert_eq!((received, lost, doubled), (2500, 0, 0), "{step_us}");
        }
    }

    /// The robot's program starts again, and its clock goes on.
    #[test]
    fn numbers_that_begin_anew_are_no_loss() {
        for (until, again) in [(40_000u16, 0u16), (30_000, 0), (10, 30_000)] {
            let (mut odometer, track, diagnostics) =
                (Odometer::new(), Track::new(), Diagnostics::new());
            let numbers = (until - 10..until).chain(again..again + 10);
            for (number, t_us) in numbers.zip((5_000u32..).step_by(4_000)) {
                let message = Odometry {
                    number,
                    t_us,
                    reading: Reading::Place(0),
                };
                let received = SentOdometry {
                    message: &message,
                    sent_us: t_us + 300,
                };
                odometer.take(received, 4_000_000, &track, &diagnostics);
            }
            let counts = diagnostics.odometry.get();
            let expected = OdometryCounts {
                received: 20,
                lost: 0,
                late: 0,
                doubled: 0,
                windows_by_time: 0,
            };
            assert_eq!(counts, expected, "{until} {again}");
        }
    }
}
