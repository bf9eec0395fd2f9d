//! The bridge's PC end: requests of the emulated board, answered by the simulated chip.

use super::options::Options;
use crate::input::Opened;
use ads1258::Conversion;
use hal_mock::Ads1258;
use hal_mock::bridge::{Crash, NEVER, Operation, Reply, Request};
use ridgetone_finger::TimedConversion;

/// First byte of the transfer that reads a result (SBAS297G, data read by command).
const READ_RESULT: u8 = 0x30;
/// NEW in the status byte: a result that was not read before.
const NEW: u8 = 0x80;

/// Nanoseconds in a microsecond: the board counts these, the chip those.
const NS_PER_US: u64 = 1000;

pub struct ChipEnd {
    pub(super) chip: Ads1258,
    end_s: f64,
    /// Board time, microseconds: the board's counter, extended; it wraps every 71 minutes.
    pub(super) now_us: u64,
    /// Board time of the first rising START.
    pub(super) start_us: Option<u64>,
    /// Board time of the first edge whose result was read: zero of the device time.
    pub(super) first_edge_us: Option<u64>,
    /// Whether the board was informed that the input is over.
    pub(super) ended: bool,
    /// What happens to the board with the first reply at or after this board time, microseconds.
    crash: Option<(u64, Crash)>,
    /// When the telemetry line is blocked, from and until, seconds of scene time.
    line_blocked_s: Option<(f64, f64)>,
    keep: bool,
    pub(super) conversions: Vec<TimedConversion>,
    /// Results read by the board.
    pub(super) served: u64,
    /// Results that the board has read twice, or that are the latest, and of which at least one
    /// read arrived as converted.
    pub(super) arrived: u64,
    /// Results that the board has read a single time, the latest one left out: the next was ready
    /// before a second read.
    pub(super) read_once: u64,
    /// Reads of the latest result.
    reads: u32,
    /// Edge of the result that arrived last.
    arrived_ns: Option<u64>,
    /// Edge of the result that the board read last.
    read_ns: Option<u64>,
}

impl ChipEnd {
    pub fn new(input: Opened, options: &Options<'_>) -> Self {
        Self {
            end_s: input.end_s,
            chip: Ads1258::new(input.scene, input.options),
            now_us: 0,
            start_us: None,
            first_edge_us: None,
            ended: false,
            crash: options.crash,
            line_blocked_s: options.line_blocked_s,
            keep: options.keep_conversions,
            conversions: Vec::new(),
            served: 0,
            arrived: 0,
            read_once: 0,
            reads: 0,
            arrived_ns: None,
            read_ns: None,
        }
    }

    /// Answers a request; `payload` becomes the bytes on DOUT.
    pub fn answer(&mut self, request: &Request, payload: &mut [u8]) -> Reply {
        self.now_us += u64::from(request.now_us.wrapping_sub(self.now_us as u32));
        let now_ns = self.now_us * NS_PER_US;
        match request.operation {
            Operation::Poll => self.chip.advance_to(now_ns),
            Operation::Transfer => {
                let reads = payload.first() == Some(&READ_RESULT);
                self.chip.transfer(now_ns, payload);
                if let (true, [_, status, high, middle, low, ..]) = (reads, &*payload) {
                    self.read([*status, *high, *middle, *low]);
                }
            }
            Operation::Start => {
                self.chip.set_start(now_ns, request.level);
                if request.level {
                    self.start_us.get_or_insert(self.now_us);
                }
            }
            Operation::Reset => self.chip.set_reset(now_ns, request.level),
        }
        let next_us = self.chip.next_drdy_fall_ns().map(|next_ns| {
            // Rounded up: an interrupt before the edge would find no data.
            u32::try_from(next_ns.saturating_sub(now_ns).div_ceil(NS_PER_US)).unwrap_or(NEVER)
        });
        Reply {
            drdy_high: self.chip.drdy_high(now_ns) || self.chip.is_drdy_stuck(),
            ended: self.ended,
            // Free at the end, so that the firmware can leave.
            line_blocked: !self.ended && self.is_line_blocked(),
            length: payload.len() as u8,
            crash: self
                .crash
                .take_if(|(at_us, _)| *at_us <= self.now_us)
                .map(|(_, crash)| crash),
            drdy_us: self.edge_us(),
            next_drdy_us: next_us.unwrap_or(NEVER),
        }
    }

    /// Counts a result that the board has read.
    fn read(&mut self, bytes: [u8; 4]) {
        let conversion = Conversion::from_bytes(bytes);
        let edge_ns = self.chip.latest_drdy_fall_ns();
        let is_right = (bytes[0] & !NEW, conversion.code) == self.chip.latest_results()[0];
        let is_new = bytes[0] & NEW != 0;
        if is_new && self.reads == 1 {
            self.read_once += 1;
            // The board counts it as lost: no second read has confirmed it.
            let had_arrived = self.arrived_ns.is_some() && self.arrived_ns == self.read_ns;
            if had_arrived && edge_ns != self.read_ns {
                self.arrived -= 1;
            }
        }
        if is_right && edge_ns != self.arrived_ns {
            (self.arrived, self.arrived_ns) = (self.arrived + 1, edge_ns);
        }
        if !is_new {
            self.reads += 1;
            return;
        }
        (self.reads, self.read_ns) = (1, edge_ns);
        self.served += 1;
        self.first_edge_us = self.first_edge_us.or_else(|| Some(edge_ns? / NS_PER_US));
        if self.keep {
            self.conversions
                .push(TimedConversion::new(self.edge_us(), conversion));
        }
        // Decided by the edge and not by the time of the read: then the board's speed does not
        // matter, and the board gets what `replay` gets.
        let (Some(edge_ns), Some(zero_ns)) = (edge_ns, self.chip.scene_zero_ns()) else {
            return;
        };
        self.ended |= edge_ns.saturating_sub(zero_ns) as f64 * 1e-9 >= self.end_s;
    }

    /// Board time of the latest edge, whole microseconds.
    fn edge_us(&self) -> u32 {
        (self.chip.latest_drdy_fall_ns().unwrap_or(0) / NS_PER_US) as u32
    }

    /// Seconds of the input done, and its length.
    pub fn progress_s(&self) -> (f64, f64) {
        (self.chip.scene_time_s().unwrap_or(0.0), self.end_s)
    }

    fn is_line_blocked(&self) -> bool {
        let now_s = self.progress_s().0;
        self.line_blocked_s
            .is_some_and(|(from_s, until_s)| (from_s..until_s).contains(&now_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_mock::Constant;

    fn end(end_s: f64) -> ChipEnd {
        let scene = Box::new(Constant {
            end_s,
            ..Constant::default()
        });
        let options = crate::emulator::Options {
            keep_conversions: true,
            ..crate::emulator::Options::new("".as_ref())
        };
        let chip = hal_mock::Options::default();
        ChipEnd::new(
            Opened {
                scene,
                options: chip,
                end_s,
                truth: None,
                warning: None,
            },
            &options,
        )
    }

    fn request(operation: Operation, level: bool, length: u8, now_us: u32) -> Request {
        Request {
            operation,
            level,
            length,
            now_us,
        }
    }

    #[test]
    fn the_interrupt_is_never_before_the_edge() {
        let mut end = end(1.0);
        let reply = end.answer(&request(Operation::Start, true, 0, 100), &mut []);
        assert!(reply.drdy_high && reply.next_drdy_us != NEVER);
        let early = end.answer(
            &request(Operation::Poll, false, 0, 100 + reply.next_drdy_us - 1),
            &mut [],
        );
        assert!(early.drdy_high);
        let at = 100 + reply.next_drdy_us;
        let there = end.answer(&request(Operation::Poll, false, 0, at), &mut []);
        assert!(!there.drdy_high);
        assert!(
            there.drdy_us == at || there.drdy_us + 1 == at,
            "{} {at}",
            there.drdy_us
        );
    }

    #[test]
    fn the_boards_counter_may_wrap() {
        let mut end = end(f64::INFINITY);
        end.answer(&request(Operation::Poll, false, 0, u32::MAX), &mut []);
        let reply = end.answer(&request(Operation::Start, true, 0, 10), &mut []);
        assert_eq!(end.now_us, (1 << 32) + 10);
        let reply = end.answer(
            &request(Operation::Poll, false, 0, 10 + reply.next_drdy_us),
            &mut [],
        );
        assert!(!reply.drdy_high && reply.drdy_us < 10_000);
    }

    #[test]
    fn the_end_comes_with_the_first_result_after_it() {
        let mut end = end(0.01);
        let mut reply = end.answer(&request(Operation::Start, true, 0, 0), &mut []);
        let mut now_us = 0;
        while !reply.ended {
            now_us += reply.next_drdy_us;
            assert!(now_us < 12_000);
            let poll = end.answer(&request(Operation::Poll, false, 0, now_us), &mut []);
            assert!(!poll.ended, "not before the result has been read");
            let mut payload = [READ_RESULT, 0, 0, 0, 0];
            reply = end.answer(
                &request(Operation::Transfer, false, 5, now_us),
                &mut payload,
            );
        }
        assert!(now_us >= 10_000);
        assert_eq!(
            (end.served, end.chip.counters().lost),
            (end.conversions.len() as u64, 0)
        );
        assert_eq!(end.read_once, end.served - 1, "each a single time");
        assert_eq!(end.arrived, 1, "the latest, which may still be confirmed");
        let t_us: Vec<u32> = end.conversions.iter().map(|c| c.t_us).collect();
        assert!(
            t_us.iter().rev().skip(1).all(|t_us| *t_us < 10_000),
            "{t_us:?}"
        );
    }
}
