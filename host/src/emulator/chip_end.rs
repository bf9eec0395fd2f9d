//! The bridge's PC end: requests of the emulated board, answered by the simulated chip.

use crate::input::Opened;
use ads1258::Conversion;
use hal_mock::Ads1258;
use hal_mock::bridge::{Crash, NEVER, Operation, Reply, Request};
use ridgetone::frame::TimedConversion;

/// First byte of the transfer that reads a result (SBAS297G, data read by command).
const READ_RESULT: u8 = 0x30;
/// NEW in the status byte: a result that had not been read before.
const NEW: u8 = 0x80;

/// Nanoseconds in a microsecond: the board counts these, the chip those.
const NS_PER_US: u64 = 1000;

/// A chip on the bridge.
pub struct ChipEnd {
    chip: Ads1258,
    end_s: f64,
    /// The board's counter, extended; it wraps every 71 minutes.
    now_us: u64,
    start_us: Option<u64>,
    /// Of the first result that was read.
    first_edge_us: Option<u64>,
    ended: bool,
    /// What is to happen to the board, and at what time of its, microseconds.
    crash: Option<(u64, Crash)>,
    keep: bool,
    conversions: Vec<TimedConversion>,
    served: u64,
    arrived: u64,
    /// Edge of the result that arrived last.
    arrived_ns: Option<u64>,
    line_blocked_s: Option<(f64, f64)>,
}

impl ChipEnd {
    /// A chip in front of an input. With `keep` every conversion that the board reads is kept.
    pub fn new(input: Opened, keep: bool) -> Self {
        Self {
            end_s: input.end_s,
            chip: Ads1258::new(input.scene, input.options),
            now_us: 0,
            start_us: None,
            first_edge_us: None,
            ended: false,
            crash: None,
            keep,
            conversions: Vec::new(),
            served: 0,
            arrived: 0,
            arrived_ns: None,
            line_blocked_s: None,
        }
    }

    /// Has something happen to the board with the first reply at or after `at_us` of its time, microseconds.
    pub fn arrange(&mut self, at_us: u64, crash: Crash) {
        self.crash = Some((at_us, crash));
    }

    /// With the telemetry line blocked from one scene time to another, seconds.
    #[must_use]
    pub fn blocking(self, line_blocked_s: Option<(f64, f64)>) -> Self {
        Self { line_blocked_s, ..self }
    }

    /// Does what the board asks; `payload` becomes what DOUT said.
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
            crash: self.crash.take_if(|(at_us, _)| *at_us <= self.now_us).map(|(_, crash)| crash),
            drdy_us: self.edge_us(),
            next_drdy_us: next_us.unwrap_or(NEVER),
        }
    }

    /// The board has read a result.
    fn read(&mut self, bytes: [u8; 4]) {
        let conversion = Conversion::from_bytes(bytes);
        let edge_ns = self.chip.latest_drdy_fall_ns();
        let is_right = (bytes[0] & !NEW, conversion.code) == self.chip.latest_results()[0];
        if is_right && edge_ns != self.arrived_ns {
            (self.arrived, self.arrived_ns) = (self.arrived + 1, edge_ns);
        }
        if bytes[0] & NEW == 0 {
            return;
        }
        self.served += 1;
        self.first_edge_us = self.first_edge_us.or_else(|| Some(self.chip.latest_drdy_fall_ns()? / NS_PER_US));
        if self.keep {
            self.conversions.push(TimedConversion { t_us: self.edge_us(), conversion });
        }
        // Decided by the edge, not by when the board gets round to reading: what it is given then does not depend on
        // how fast it is, and is what `replay` gets.
        let (Some(edge_ns), Some(zero_ns)) = (self.chip.latest_drdy_fall_ns(), self.chip.scene_zero_ns()) else {
            return;
        };
        self.ended |= edge_ns.saturating_sub(zero_ns) as f64 * 1e-9 >= self.end_s;
    }

    /// Board time of the latest edge, whole microseconds.
    fn edge_us(&self) -> u32 {
        (self.chip.latest_drdy_fall_ns().unwrap_or(0) / NS_PER_US) as u32
    }

    /// Board time, microseconds.
    pub fn now_us(&self) -> u64 {
        self.now_us
    }

    /// Board time of the first rising START, microseconds.
    pub fn start_us(&self) -> Option<u64> {
        self.start_us
    }

    /// Board time of the first edge whose result was read, microseconds: zero of the device time.
    pub fn first_edge_us(&self) -> Option<u64> {
        self.first_edge_us
    }

    /// Seconds of the input done, and those it has.
    pub fn progress_s(&self) -> (f64, f64) {
        (self.chip.scene_time_s().unwrap_or(0.0), self.end_s)
    }

    /// Whether the board has been told that the input is over.
    pub fn ended(&self) -> bool {
        self.ended
    }

    fn is_line_blocked(&self) -> bool {
        let now_s = self.chip.scene_time_s().unwrap_or(0.0);
        self.line_blocked_s.is_some_and(|(from_s, until_s)| (from_s..until_s).contains(&now_s))
    }

    /// The chip.
    pub fn chip(&self) -> &Ads1258 {
        &self.chip
    }

    /// Results of which at least one read arrived as they were converted.
    pub fn arrived(&self) -> u64 {
        self.arrived
    }

    /// Results read by the board, and results that were overwritten before it came.
    pub fn served_and_lost(&self) -> (u64, u64) {
        (self.served, self.chip.counters().lost)
    }

    /// The conversions kept.
    pub fn into_conversions(self) -> Vec<TimedConversion> {
        self.conversions
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_mock::{Constant, Options};

    fn end(end_s: f64) -> ChipEnd {
        let scene = Box::new(Constant { end_s, ..Constant::default() });
        ChipEnd::new(Opened { scene, options: Options::default(), end_s, truth: None, warning: None }, true)
    }

    fn request(operation: Operation, level: bool, length: u8, now_us: u32) -> Request {
        Request { operation, level, length, now_us }
    }

    #[test]
    fn the_interrupt_is_never_before_the_edge() {
        let mut end = end(1.0);
        let reply = end.answer(&request(Operation::Start, true, 0, 100), &mut []);
        assert!(reply.drdy_high && reply.next_drdy_us != NEVER);
        let early = end.answer(&request(Operation::Poll, false, 0, 100 + reply.next_drdy_us - 1), &mut []);
        assert!(early.drdy_high);
        let at = 100 + reply.next_drdy_us;
        let there = end.answer(&request(Operation::Poll, false, 0, at), &mut []);
        assert!(!there.drdy_high);
        assert!(there.drdy_us == at || there.drdy_us + 1 == at, "{} {at}", there.drdy_us);
    }

    #[test]
    fn the_boards_counter_may_wrap() {
        let mut end = end(f64::INFINITY);
        end.answer(&request(Operation::Poll, false, 0, u32::MAX), &mut []);
        let reply = end.answer(&request(Operation::Start, true, 0, 10), &mut []);
        assert_eq!(end.now_us(), (1 << 32) + 10);
        let reply = end.answer(&request(Operation::Poll, false, 0, 10 + reply.next_drdy_us), &mut []);
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
            reply = end.answer(&request(Operation::Transfer, false, 5, now_us), &mut payload);
        }
        assert!(now_us >= 10_000);
        assert_eq!(end.served_and_lost(), (end.conversions.len() as u64, 0));
        let t_us: Vec<u32> = end.conversions.iter().map(|c| c.t_us).collect();
        assert!(t_us.iter().rev().skip(1).all(|t_us| *t_us < 10_000), "{t_us:?}");
    }
}
