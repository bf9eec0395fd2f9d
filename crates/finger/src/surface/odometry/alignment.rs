//! The robot's clock against the board's, from the stamps of messages and the times at which they
//! arrived.
//!
//! A message is some time under way, never less than the line takes. So the delays of many messages
//! have a straight line as their lower bound, and the line's slope is the difference of the clocks'
//! rates. Of each second only the quickest message is kept, in the first seconds of each part of
//! one. The slope is that from the quickest of the earlier ones to the quickest of the later ones
//! (Paxson, "On calibrating measurements of packet transit times", SIGMETRICS 1998, section 5: the
//! least delays of parts of a trace), and the line is as high as none of the delays is below it.

/// Blocks whose quickest messages are kept.
const LOWS: usize = 8;
/// Length of a block at first, microseconds of the robot. When all are full two become one, until a
/// block is a second.
const BLOCK_US: u32 = 125_000;
/// How often.
const DOUBLINGS: u8 = 3;
/// Time over which the quickest messages have to spread before a slope is taken from them,
/// microseconds.
const SLOPE_US: f32 = 3e6;
/// Time between the two that give it, if it is taken earlier, microseconds.
const EARLY_SLOPE_US: f32 = 5e5;
/// Greatest difference of two clocks' rates: five times what crystals have.
pub const FASTER_MOST: f32 = 500e-6;

/// A quick message.
#[derive(Clone, Copy, Debug)]
struct Low {
    /// Its stamp.
    t_us: u32,
    /// Its delay less that of the first message.
    delay_us: i32,
}

/// The alignment of the robot's clock with the board's.
#[derive(Debug)]
pub struct Alignment {
    /// The board's time less the stamp, of the first message.
    offset_us: u32,
    /// The quickest message of each of the latest blocks; the latest of them is number `latest`,
    /// the one before that comes before it, and so on around the end.
    lows: [Low; LOWS],
    /// How many there are.
    count: u8,
    latest: u8,
    /// How often blocks have become twice as long.
    doublings: u8,
    /// Stamp with which the latest of these blocks began.
    block_us: u32,
}

impl Alignment {
    /// Before the first message.
    pub const fn new() -> Self {
        Self {
            offset_us: 0,
            lows: [Low {
                t_us: 0,
                delay_us: 0,
            }; LOWS],
            count: 0,
            latest: 0,
            doublings: 0,
            block_us: 0,
        }
    }

    /// Begins again with this message.
    pub fn restart(&mut self, t_us: u32, board_us: u32) {
        self.offset_us = board_us.wrapping_sub(t_us);
        (self.count, self.doublings) = (0, 0);
        self.take(t_us, 0);
    }

    /// Delay of a message, microseconds; zero for the first one.
    pub fn delay_us(&self, t_us: u32, board_us: u32) -> i32 {
        board_us.wrapping_sub(t_us).wrapping_sub(self.offset_us) as i32
    }

    /// The least delay of the latest seconds, microseconds.
    pub fn least_us(&self) -> i32 {
        self.lows()
            .fold(i32::MAX, |least, low| least.min(low.delay_us))
    }

    /// Takes the delay of a message, which is later than all before.
    pub fn take(&mut self, t_us: u32, delay_us: i32) {
        let begins =
            self.count == 0 || t_us.wrapping_sub(self.block_us) >= BLOCK_US << self.doublings;
        if begins {
            if self.count == LOWS as u8 && self.doublings < DOUBLINGS {
                self.double();
            }
            (self.count, self.latest, self.block_us) = (
                (self.count + 1).min(LOWS as u8),
                (self.latest + 1) % LOWS as u8,
                t_us,
            );
        }
        if let Some(low) = self.lows.get_mut(self.latest as usize)
            && (begins || delay_us < low.delay_us)
        {
            *low = Low { t_us, delay_us };
        }
    }

    /// Makes one block of two: of each pair the quicker message stays.
    fn double(&mut self) {
        let mut kept = self.lows;
        // The oldest comes first.
        kept.iter_mut()
            .rev()
            .zip(self.lows())
            .for_each(|(kept, low)| *kept = *low);
        for (low, [one, other]) in self.lows.iter_mut().zip(kept.as_chunks().0) {
            *low = if other.delay_us < one.delay_us {
                *other
            } else {
                *one
            };
        }
        (self.count, self.latest) = (LOWS as u8 / 2, LOWS as u8 / 2 - 1);
        self.doublings += 1;
    }

    /// The quickest messages, from the latest back.
    fn lows(&self) -> impl Iterator<Item = &Low> {
        let latest = self.latest as usize + LOWS;
        (0..self.count as usize)
            .filter_map(move |back| self.lows.get(latest.wrapping_sub(back) % LOWS))
    }

    /// The robot's time at a board time, microseconds, and how many microseconds of the robot's
    /// clock pass in one of the board's, less 1.
    pub fn robot_us(&self, board_us: u32) -> (u32, f32) {
        let first_us = board_us.wrapping_sub(self.offset_us);
        let Some(latest) = self.lows().next() else {
            return (first_us, 0.0);
        };
        let (delay_us, slope) = self.line(latest);
        // The delay at that time, which a difference of the order of the delay does not change.
        let since_us = first_us
            .wrapping_sub(latest.t_us)
            .wrapping_sub(latest.delay_us as u32) as i32;
        let delay_us = delay_us + slope * since_us as f32;
        (
            first_us
                .wrapping_sub(latest.delay_us as u32)
                .wrapping_sub(libm::roundf(delay_us) as i32 as u32),
            -slope,
        )
    }

    /// The line below the delays: its delay at the latest low, less that low's own, and its slope.
    fn line(&self, latest: &Low) -> (f32, f32) {
        let at = |low: &Low| {
            (
                low.t_us.wrapping_sub(latest.t_us) as i32 as f32,
                low.delay_us.wrapping_sub(latest.delay_us) as f32,
            )
        };
        let halves = self.count.div_ceil(2) as usize;
        let none = (0.0, f32::INFINITY);
        let (mut least, mut first_us) = ([none; 2], 0.0);
        for (back, (x, y)) in self.lows().map(at).enumerate() {
            let least = &mut least[usize::from(back >= halves)];
            if y < least.1 {
                *least = (x, y);
            }
            first_us = x;
        }
        let [late, early] = least;
        let apart_us = late.0 - early.0;
        let is_known = first_us <= -SLOPE_US || halves > 1 && apart_us >= EARLY_SLOPE_US;
        let slope = if is_known {
            (late.1 - early.1) / apart_us
        } else {
            0.0
        };
        let slope = slope.clamp(-FASTER_MOST, FASTER_MOST);
        (
            self.lows()
                .map(at)
                .fold(0.0, |delay, (x, y)| f32::min(delay, y - slope * x)),
            slope,
        )
    }
}

impl Default for Alignment {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    /// A noise of its own, 0 to 1.
    fn noise(state: &mut u64) -> f64 {
        *state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f64 / (1u64 << 24) as f64
    }

    /// Board time of a robot's stamp, microseconds, without any delay.
    fn board_us(robot_us: f64, ppm: f64) -> f64 {
        4.29e9 + robot_us * (1.0 + ppm * 1e-6)
    }

    /// Delays of 0.3 ms and more, some of them ten times that; both counters wrap on the way.
    #[test]
    fn offset_and_skew_come_out_of_the_quickest_messages() {
        for ppm in [-200.0, -30.0, 0.0, 30.0, 200.0] {
            for rate_hz in [20.0, 250.0] {
                let (mut alignment, mut state) = (Alignment::new(), 5u64);
                let mut worst_us = 0f64;
                for n in 0..(60.0 * rate_hz) as u32 {
                    let robot_us = f64::from(n) * 1e6 / rate_hz;
                    let stamp = (4.2e9 + robot_us) as u64 as u32;
                    // Exponential, of 1 ms on average.
                    let delay_us = 300.0 - 1000.0 * (1.0 - noise(&mut state)).ln();
                    let arrives = (board_us(robot_us, ppm) + delay_us) as u64 as u32;
                    if n == 0 {
                        alignment.restart(stamp, arrives);
                    } else {
                        alignment.take(stamp, alignment.delay_us(stamp, arrives));
                    }
                    if robot_us > 10e6 {
                        // A window ends here, and another one ended a second before.
                        for back_us in [0.0, 1e6] {
                            let at_us = (board_us(robot_us - back_us, ppm) + 300.0) as u64 as u32;
                            let (found, faster) = alignment.robot_us(at_us);
                            let off_us = f64::from(found.wrapping_sub(stamp) as i32) + back_us;
                            worst_us = worst_us.max(off_us.abs());
                            assert!(
                                (f64::from(faster) * 1e6 + ppm).abs() < 100.0,
                                "{ppm} ppm: {faster}"
                            );
                        }
                    }
                }
                // The least of a second's delays is above 0.3 ms by 1 ms over their number on
                // average, and the line reaches on from two.
                std::println!(
                    "{ppm} ppm, {rate_hz} messages a second: {worst_us:.0} us off at most"
                );
                let bound_us = 20e3 / rate_hz + 20.0;
                assert!(
                    worst_us < bound_us,
                    "{ppm} ppm, {rate_hz} Hz: {worst_us} us"
                );
            }
        }
    }

    /// From the second second on the clocks' difference is known: until then it is off by what they
    /// drift apart.
    #[test]
    fn the_skew_is_known_after_a_second() {
        for ppm in [-200.0, 200.0] {
            let (mut alignment, mut state, mut worst_us) = (Alignment::new(), 7u64, [0f64; 2]);
            for n in 0..1000u32 {
                let robot_us = f64::from(n) * 4000.0;
                let delay_us = 300.0 - 500.0 * (1.0 - noise(&mut state)).ln();
                let (stamp, arrives) = (
                    robot_us as u32,
                    (board_us(robot_us, ppm) + delay_us) as u64 as u32,
                );
                if n == 0 {
                    alignment.restart(stamp, arrives);
                } else {
                    alignment.take(stamp, alignment.delay_us(stamp, arrives));
                }
                let found = alignment
                    .robot_us((board_us(robot_us, ppm) + 300.0) as u64 as u32)
                    .0;
                let worst_us = &mut worst_us[usize::from(robot_us > 1.2e6)];
                *worst_us = worst_us.max(f64::from(found.wrapping_sub(stamp) as i32).abs());
            }
            std::println!("{ppm} ppm: {worst_us:.0?} us off at most before and after");
            assert!(
                worst_us[1] < 100.0 && worst_us[0] < 1000.0,
                "{ppm}: {worst_us:?}"
            );
        }
    }

    #[test]
    fn one_message_is_an_offset() {
        let mut alignment = Alignment::new();
        alignment.restart(u32::MAX - 5, 700);
        assert_eq!(alignment.robot_us(800), (94, 0.0));
        assert_eq!(alignment.robot_us(600), (u32::MAX - 105, 0.0));
    }
}
