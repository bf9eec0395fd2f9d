//! The robot's clock against the board's, from the stamps of messages and the times at which they arrived.
//!
//! A message is some time under way, never less than the line takes. So the delays of many messages have a straight line as their
//! lower bound, and the line's slope is the difference of the clocks' rates: of all lines below the delays, the one that is
//! nearest to them (Moon, Skelly and Towsley, "Estimation and removal of clock skew from network delay measurements", INFOCOM
//! 1999, section IV). It is an edge of the lower convex hull, the one above the middle of the times. Of each second only the
//! quickest message counts.

use heapless::Vec;

/// Seconds whose quickest messages are kept.
const LOWS: usize = 9;
/// Time from one of them to the next, at least, microseconds of the robot.
const BLOCK_US: u32 = 1_000_000;
/// Time over which the quickest messages have to spread before a slope is taken from them, microseconds.
const SLOPE_US: u32 = 3_000_000;
/// Greatest difference of two clocks' rates: five times what crystals have.
const FASTER_MOST: f32 = 500e-6;

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
    /// The first message: its stamp, and the board's time less that.
    offset_us: u32,
    /// The quickest message of each of the latest seconds, in their order.
    lows: Vec<Low, LOWS>,
    /// Stamp with which the latest of these seconds began.
    block_us: u32,
}

impl Alignment {
    /// Before the first message.
    pub const fn new() -> Self {
        Self { offset_us: 0, lows: Vec::new(), block_us: 0 }
    }

    /// Begins again with this message.
    pub fn restart(&mut self, t_us: u32, board_us: u32) {
        *self = Self { offset_us: board_us.wrapping_sub(t_us), lows: Vec::new(), block_us: t_us };
        self.take(t_us, 0);
    }

    /// Delay of a message, microseconds; zero for the first one.
    pub fn delay_us(&self, t_us: u32, board_us: u32) -> i32 {
        board_us.wrapping_sub(t_us).wrapping_sub(self.offset_us) as i32
    }

    /// The least delay of the latest seconds, microseconds.
    pub fn least_us(&self) -> i32 {
        self.lows.iter().map(|low| low.delay_us).min().unwrap_or(0)
    }

    /// Takes the delay of a message, which is later than all before.
    pub fn take(&mut self, t_us: u32, delay_us: i32) {
        let low = Low { t_us, delay_us };
        let is_old = t_us.wrapping_sub(self.block_us) >= BLOCK_US;
        match self.lows.last_mut() {
            Some(latest) if !is_old => {
                if delay_us < latest.delay_us {
                    *latest = low;
                }
            }
            _ => {
                if self.lows.is_full() {
                    self.lows.remove(0);
                }
                // There is room now.
                let _ = self.lows.push(low);
                self.block_us = t_us;
            }
        }
    }

    /// The robot's time at a board time, microseconds, and how many microseconds of the robot's clock pass in one of the board's,
    /// less 1.
    pub fn robot_us(&self, board_us: u32) -> (u32, f32) {
        let Some(latest) = self.lows.last() else { return (board_us.wrapping_sub(self.offset_us), 0.0) };
        let first_us = board_us.wrapping_sub(self.offset_us);
        let (delay_us, slope) = self.line(latest);
        // The delay at that time, which a difference of the order of the delay does not change.
        let since_us = first_us.wrapping_sub(latest.t_us).wrapping_sub(latest.delay_us as u32) as i32;
        let delay_us = delay_us + slope * since_us as f32;
        (first_us.wrapping_sub(latest.delay_us as u32).wrapping_sub(libm::roundf(delay_us) as i32 as u32), -slope)
    }

    /// The line below the delays: its delay at the latest low, less that low's own, and its slope.
    fn line(&self, latest: &Low) -> (f32, f32) {
        let at = |low: &Low| {
            (low.t_us.wrapping_sub(latest.t_us) as i32 as f32, low.delay_us.wrapping_sub(latest.delay_us) as f32)
        };
        let spread_us = self.lows.first().map_or(0, |first| latest.t_us.wrapping_sub(first.t_us));
        if spread_us < SLOPE_US {
            return (self.lows.iter().map(|low| at(low).1).fold(0.0, f32::min), 0.0);
        }
        let middle = self.lows.iter().map(|low| at(low).0).sum::<f32>() / self.lows.len() as f32;
        let (mut from, mut slope) = (0, 0.0);
        // Along the hull from its first point on.
        while let Some((x, y)) = self.lows.get(from).map(at) {
            let mut next = None;
            for (number, low) in self.lows.iter().enumerate().skip(from + 1) {
                let (to_x, to_y) = at(low);
                let to = (to_y - y) / (to_x - x);
                if next.is_none_or(|(_, least)| to <= least) {
                    next = Some((number, to));
                }
            }
            let Some((number, least)) = next else { break };
            slope = least.clamp(-FASTER_MOST, FASTER_MOST);
            if self.lows.get(number).is_none_or(|low| at(low).0 >= middle) {
                return (y - slope * x, slope);
            }
            from = number;
        }
        (0.0, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;

    /// A noise of its own, 0 to 1.
    fn noise(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
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
                            assert!((f64::from(faster) * 1e6 + ppm).abs() < 100.0, "{ppm} ppm: {faster}");
                        }
                    }
                }
                // The least of a second's delays is above 0.3 ms by 1 ms over their number on average.
                let bound_us = 8e3 / rate_hz + 20.0;
                assert!(worst_us < bound_us, "{ppm} ppm, {rate_hz} Hz: {worst_us} us");
            }
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
