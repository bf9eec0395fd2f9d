//! A behavioural ADS1258: SPI bytes and pin levels in, SPI bytes and DRDY out, in virtual
//! nanoseconds.
//!
//! All facts are from the TI datasheet SBAS297G, unless another source is named.

mod clock;
mod code;
mod convert;
mod faults;
mod interface;
mod options;
mod pin;
mod registers;
mod schedule;
mod slot;
mod timing;

pub use faults::Fault;
pub use options::{Analog, Counters, Options};
pub use registers::REGISTERS;
pub use schedule::{Injected, Injection};

use crate::random::{Random, Stream};
use crate::scene::Scene;
use clock::Clock;
use convert::{Conversion, Outcome};
use faults::Faults;
use interface::Interface;
use registers::Registers;
use schedule::Schedule;
use timing::Timing;

/// The simulated chip.
///
/// All times are virtual nanoseconds and must not decrease from call to call; a call with an
/// earlier time takes effect at the latest time. Scene time zero is the first start condition
/// (rising START or pulse convert) after construction, so measurements do not depend on the
/// duration of the start-up. Each conversion samples the scene once, at the middle of the filter's
/// aperture: [`sample_delay_ns`](Self::sample_delay_ns) before its DRDY edge.
pub struct Ads1258 {
    scene: Box<dyn Scene>,
    options: Options,
    clock: Clock,
    /// End of the power-up; `None` before the first clock.
    powered_ns: Option<u64>,
    registers: Registers,
    interface: Interface,
    faults: Faults,
    schedule: Schedule,
    noise: Random,
    poison: Random,
    now_ns: u64,
    start: bool,
    reset_low: bool,
    /// Time of scene zero.
    zero_ns: Option<u64>,
    conversion: Option<Conversion>,
    /// CHID of the slot begun last; `None` if the scan begins at the top.
    last_chid: Option<u8>,
    outcome: Outcome,
    /// The latest two results; a reset keeps them.
    latest: [Outcome; 2],
    /// True while a result is unread.
    drdy_low: bool,
    latest_fall_ns: Option<u64>,
    counters: Counters,
}

impl Ads1258 {
    /// Creates a chip in its power-up state at time 0: registers at their defaults, START low,
    /// RESET high.
    pub fn new(input: Box<dyn Scene>, options: Options) -> Self {
        let clock = Clock::new(options.clock_hz, options.clock_error_ppm);
        Self {
            scene: input,
            clock,
            powered_ns: (options.clock_hz > 0).then(|| clock.ns(options.power_up_cycles)),
            registers: Registers::new(options.id),
            interface: Interface::default(),
            faults: Faults::default(),
            schedule: Schedule::new(&options.injections),
            noise: Random::new(options.seed, Stream::ChipNoise),
            poison: Random::new(options.seed, Stream::Poison),
            now_ns: 0,
            start: false,
            reset_low: false,
            zero_ns: None,
            conversion: None,
            last_chid: None,
            outcome: Outcome::default(),
            latest: [Outcome::default(); 2],
            drdy_low: false,
            latest_fall_ns: None,
            counters: Counters::default(),
            options,
        }
    }

    /// Lets time pass until `now_ns`: finishes every conversion and applies every injection due by
    /// then.
    pub fn advance_to(&mut self, now_ns: u64) {
        while let Some(edge_ns) = self.next_event_ns().filter(|&event_ns| event_ns <= now_ns) {
            self.now_ns = self.now_ns.max(edge_ns);
            if self.conversion.is_some() {
                self.finish_conversion(edge_ns);
                self.faults.edges_lost = self.faults.edges_lost.saturating_sub(1);
            }
            self.inject();
        }
        self.now_ns = self.now_ns.max(now_ns);
    }

    /// Sets the START pin. High converts from where the scan stopped; low finishes the running
    /// conversion, then idles.
    pub fn set_start(&mut self, now_ns: u64, high: bool) {
        self.advance_to(now_ns);
        self.start = high;
        if high && self.conversion.is_none() {
            self.start_condition();
        }
    }

    /// Sets the RESET pin. Low resets registers and interface to their defaults and ends the
    /// running conversion; the chip is ready when it goes high again (and converts at once if START
    /// is high).
    pub fn set_reset(&mut self, now_ns: u64, high: bool) {
        self.advance_to(now_ns);
        let was_low = std::mem::replace(&mut self.reset_low, !high);
        if !high {
            self.forget();
        } else if was_low && self.start {
            self.start_condition();
        }
    }

    /// Resets registers and interface to their defaults. The result and the running conversion are
    /// lost.
    fn forget(&mut self) {
        self.registers.reset();
        self.interface = Interface::default();
        self.conversion = None;
        self.last_chid = None;
        self.outcome = Outcome::default();
        self.drdy_low = false;
    }

    /// Returns the time at which the running conversion ends.
    fn next_result_ns(&self) -> Option<u64> {
        self.conversion
            .as_ref()
            .map(|c| c.at_ns(self.clock, c.end_cycle))
    }

    /// True if the scene has ended by now. The chip still converts its voltages.
    pub fn ended(&self) -> bool {
        self.scene_time_s()
            .is_some_and(|t_s| t_s >= self.scene.end_s())
    }

    /// Current scene time, in seconds; `None` before the first start condition.
    pub fn scene_time_s(&self) -> Option<f64> {
        self.zero_ns
            .map(|zero_ns| self.now_ns.saturating_sub(zero_ns) as f64 * 1e-9)
    }

    /// Virtual time of scene time zero: the first start condition.
    pub fn scene_zero_ns(&self) -> Option<u64> {
        self.zero_ns
    }

    /// Time from the sampling of the input to the DRDY edge with the current settings, in
    /// nanoseconds (rounded down): 64 (N + 4) tCLK, half the length of the symmetric filter; with
    /// CHOP, half a pass more.
    pub fn sample_delay_ns(&self) -> u64 {
        self.clock
            .ns(Timing::of(&self.registers).sample_delay_cycles())
    }

    /// Time from one DRDY edge to the next with the current settings, in nanoseconds (rounded
    /// down).
    pub fn conversion_period_ns(&self) -> u64 {
        self.clock.ns(Timing::of(&self.registers).period_cycles())
    }

    /// Duration of `cycles` tCLK of this chip's own clock in nanoseconds, rounded down.
    pub fn cycles_ns(&self, cycles: u64) -> u64 {
        self.clock.ns(cycles)
    }

    /// The latest two results, newest first, unaffected by bus faults: flags and CHID with NEW
    /// cleared, and the code.
    pub fn latest_results(&self) -> [(u8, i32); 2] {
        // Extend the sign: a poisoned code has only its lower 24 bits.
        self.latest
            .map(|outcome| (outcome.bytes()[0] & 0x7F, outcome.code << 8 >> 8))
    }

    /// Counts of what the chip has done so far.
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// All registers, as a read over SPI would return them.
    pub fn registers(&self) -> [u8; REGISTERS] {
        std::array::from_fn(|address| self.registers.read(address as u8).unwrap_or(0))
    }

    /// Physical values, which may be changed while the chip runs.
    pub fn analog_mut(&mut self) -> &mut Analog {
        &mut self.options.analog
    }

    /// The options as constructed, with the current physical values.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Sets the external levels of the GPIO pins that are inputs (bit n: GPIOn); all low at
    /// construction.
    pub fn set_gpio_inputs(&mut self, levels: u8) {
        self.registers.gpio_inputs = levels;
    }

    fn poison_byte(&mut self) -> u8 {
        self.options.poison.unwrap_or_else(|| self.poison.byte())
    }
}
