//! The converter: start conditions, the scan, results and DRDY.

use super::Ads1258;
use super::clock::Clock;
use super::code;
use super::registers::{BYPAS, CHOP, IDLMOD, Registers};
use super::slot::{OFFSET, Slot, next_slot};
use super::timing::Timing;

/// A running conversion, with the settings at its start: a register write affects only the next
/// one.
#[derive(Clone, Debug)]
pub(crate) struct Conversion {
    /// Time of the start condition, cycle 0.
    epoch_ns: u64,
    /// Cycle of the result, counted from the start condition so that no rounding error accumulates.
    pub(crate) end_cycle: u64,
    sample_cycle: u64,
    slot: Slot,
    registers: Registers,
}

impl Conversion {
    pub(crate) fn at_ns(&self, clock: Clock, cycle: u64) -> u64 {
        self.epoch_ns + clock.ns(cycle)
    }

    /// Counts the remaining cycles from `now_ns`, so that the clock may change.
    pub(crate) fn rebased(self, clock: Clock, now_ns: u64) -> Self {
        let passed = clock.cycles(now_ns.saturating_sub(self.epoch_ns));
        Self {
            epoch_ns: now_ns,
            end_cycle: self.end_cycle.saturating_sub(passed).max(1),
            sample_cycle: self.sample_cycle.saturating_sub(passed),
            ..self
        }
    }
}

/// The latest result, as a data read returns it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) new: bool,
    overflow: bool,
    supply: bool,
    chid: u8,
    pub(crate) code: i32,
}

impl Outcome {
    /// Status byte and the three data bytes.
    pub(crate) fn bytes(self) -> [u8; 4] {
        let [_, high, mid, low] = self.code.to_be_bytes();
        let status = u8::from(self.new) << 7
            | u8::from(self.overflow) << 6
            | u8::from(self.supply) << 5
            | (self.chid & 0x1F);
        [status, high, mid, low]
    }
}

/// Approximate analogue supply below which the SUPPLY flag is set.
const SUPPLY_V: f64 = 4.3;

impl Ads1258 {
    /// Acts on a rising START, pulse convert, or the end of a reset or stall while START is high.
    pub(crate) fn start_condition(&mut self) {
        let Some(powered_ns) = self.powered_ns.filter(|_| self.is_clocked()) else {
            return;
        };
        if self.reset_low || self.faults.stalled {
            return;
        }
        // A start during power-up takes effect at its end.
        let epoch_ns = self.now_ns.max(powered_ns);
        let timing = Timing::of(&self.registers);
        let wake = if self.registers.bit(IDLMOD) {
            self.options.sleep_wake_cycles
        } else {
            0
        };
        self.zero_ns.get_or_insert(epoch_ns);
        self.begin(
            epoch_ns,
            wake + timing.first_cycles(self.options.first_conversion_with_delay),
        );
    }

    fn begin(&mut self, epoch_ns: u64, end_cycle: u64) {
        self.conversion = next_slot(
            &self.registers,
            self.last_chid,
            self.options.chop_skips_internal,
        )
        .map(|slot| {
            if slot.chid().is_some() {
                self.last_chid = slot.chid();
            }
            Conversion {
                epoch_ns,
                end_cycle,
                sample_cycle: end_cycle
                    .saturating_sub(Timing::of(&self.registers).sample_delay_cycles()),
                slot,
                registers: self.registers.clone(),
            }
        });
    }

    /// Ends the running conversion at its DRDY edge and begins the next one if START is high.
    pub(crate) fn finish_conversion(&mut self, edge_ns: u64) {
        let Some(conversion) = self.conversion.take() else {
            return;
        };
        self.counters.conversions += 1;
        self.counters.lost += u64::from(self.outcome.new);
        self.outcome = self.measure(&conversion);
        self.latest = [self.outcome, self.latest[0]];
        self.drdy_low = true;
        self.latest_fall_ns = Some(edge_ns);
        if self.start {
            let period = Timing::of(&self.registers).period_cycles();
            self.begin(conversion.epoch_ns, conversion.end_cycle + period);
        }
    }

    fn measure(&mut self, c: &Conversion) -> Outcome {
        let zero_ns = self.zero_ns.unwrap_or(c.epoch_ns);
        // Take the time from cycles, not from rounded nanoseconds, so that it does not depend on
        // the duration of the start-up.
        let t_s = (c.epoch_ns - zero_ns) as f64 * 1e-9 + self.clock.seconds(c.sample_cycle);
        // With BYPAS the ADC's inputs come from pins that are not connected, so the codes clip. The
        // internal readings except OFFSET do not use these pins.
        let external = c.slot.chid().is_none_or(|chid| chid <= OFFSET);
        let (analog, chop) = (self.options.analog, c.registers.bit(CHOP));
        let (scene, held) = (&mut self.scene, self.faults.held);
        let mut ideal = code::ideal(c.slot, &analog, chop, |input| {
            let volts = scene.volts(input, t_s);
            held.filter(|(at, _)| *at == input)
                .map_or(volts, |(_, held_v)| held_v)
        });
        if c.registers.bit(BYPAS) && external {
            ideal = f64::INFINITY;
        }
        if self.options.noise {
            ideal += code::noise_sigma(c.registers.drate(), chop, &analog) * self.noise.gaussian();
        }
        // NaN: the recording lacks this reading, so there is no new result.
        if ideal.is_nan() {
            return Outcome {
                new: false,
                ..self.outcome
            };
        }
        let (mut code, overflow) = code::quantise(ideal);
        let supply = analog.avdd_v < SUPPLY_V;
        if supply || (chop && c.slot.excluded_by_chop()) {
            code = i32::from_be_bytes([
                0,
                self.poison_byte(),
                self.poison_byte(),
                self.poison_byte(),
            ]);
        }
        let chid = c
            .slot
            .chid()
            .or(self.options.fixed_channel_chid)
            .unwrap_or_else(|| self.poison_byte());
        Outcome {
            new: true,
            overflow,
            supply,
            chid,
            code,
        }
    }
}
