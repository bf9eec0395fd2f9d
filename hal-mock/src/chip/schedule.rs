//! Faults by a schedule, in the chip's virtual time: whatever drives the chip, they come at the same moments.
//!
//! A fault acts right behind an edge of DRDY, before its result is read: what a driver was promised about the next edge
//! when it read last still holds. While nothing is converted it acts at its own time.

use super::Ads1258;
use std::collections::VecDeque;

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Bits of a register fall over: once, and until the register is written.
    RegisterFlip {
        /// Its address, 00h to 09h.
        address: u8,
        /// Which bits.
        mask: u8,
    },
    /// The chip resets itself, once.
    Reset,
    /// The converter stands still.
    Stall,
    /// Bits of a byte from the chip fall over, once.
    DoutFlip {
        /// How many bytes ahead of the next one; the next is the command of a read, the four behind it its result.
        bytes_ahead: u64,
        /// Which bits.
        mask: u8,
    },
    /// Bits of a byte to the chip fall over, once.
    DinFlip {
        /// As in [`Self::DoutFlip`].
        bytes_ahead: u64,
        /// Which bits.
        mask: u8,
    },
    /// DOUT is stuck; the chip hears what it is told.
    DoutStuck {
        /// At ones.
        high: bool,
    },
    /// The chip hears nothing and DOUT floats.
    BusCut {
        /// To ones.
        high: bool,
    },
    /// DRDY is stuck.
    DrdyStuck {
        /// High.
        high: bool,
    },
    /// Edges of DRDY without new results.
    Storm {
        /// From one to the next, nanoseconds.
        period_ns: u64,
    },
    /// Edges of DRDY do not arrive.
    EdgesLost {
        /// How many.
        count: u32,
    },
    /// One edge of DRDY too many.
    EdgeRepeated {
        /// So long after the edge before, nanoseconds.
        after_ns: u64,
    },
    /// Another analogue supply. Below 4.3 V the chip sets SUPPLY, and its data are poison.
    Supply {
        /// AVDD - AVSS, volts.
        volts: f64,
    },
    /// Another reference.
    Reference {
        /// VREFP - VREFN, volts.
        volts: f64,
    },
    /// Another error of the clock.
    Clock {
        /// Parts per million; positive is fast.
        error_ppm: f64,
    },
    /// An input is held at a voltage.
    Input {
        /// AIN0 to AIN15.
        input: u8,
        /// Volts.
        volts: f64,
    },
}

/// A fault with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Injection {
    /// When it begins, seconds of scene time.
    pub at_s: f64,
    /// How long it lasts, seconds; does not matter for what happens once.
    pub lasts_s: f64,
    /// What it is.
    pub fault: Fault,
}

/// When an injection acted, in virtual nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Injected {
    /// It began.
    pub begun_ns: Option<u64>,
    /// It was over.
    pub over_ns: Option<u64>,
}

/// What is still to come, and what has been.
#[derive(Clone, Debug, Default)]
pub(crate) struct Schedule {
    /// Nanoseconds of scene time, the injection's number, whether it begins.
    steps: VecDeque<(u64, usize, bool)>,
    log: Vec<Injected>,
    /// What the injections under way changed, to be put back: supply, reference, clock.
    before: Option<(f64, f64, f64)>,
}

impl Schedule {
    pub(crate) fn new(injections: &[Injection]) -> Self {
        let ns = |seconds: f64| (seconds.max(0.0) * 1e9) as u64;
        let mut steps: Vec<_> = injections
            .iter()
            .enumerate()
            .flat_map(|(number, one)| [(ns(one.at_s), number, true), (ns(one.at_s + one.lasts_s), number, false)])
            .collect();
        // Stable: a fault of no duration begins before it ends.
        steps.sort_by_key(|step| step.0);
        Self { steps: steps.into(), log: vec![Injected::default(); injections.len()], before: None }
    }
}

impl Ads1258 {
    /// When each of [`Options::injections`](super::Options::injections) acted.
    pub fn injected(&self) -> &[Injected] {
        &self.schedule.log
    }

    /// Time of the next moment at which anything happens by itself: a result, or without one under way an injection.
    pub fn next_event_ns(&self) -> Option<u64> {
        self.next_result_ns().or_else(|| Some(self.next_step_ns()?.max(self.now_ns)))
    }

    fn next_step_ns(&self) -> Option<u64> {
        self.schedule.steps.front().and_then(|step| Some(self.zero_ns?.saturating_add(step.0)))
    }

    /// Begins and ends what is due.
    pub(crate) fn inject(&mut self) {
        while self.next_step_ns().is_some_and(|step_ns| step_ns <= self.now_ns) {
            let Some((_, number, begins)) = self.schedule.steps.pop_front() else { return };
            let Some(fault) = self.options.injections.get(number).map(|injection| injection.fault) else { return };
            let now_ns = self.now_ns;
            if let Some(log) = self.schedule.log.get_mut(number) {
                *(if begins { &mut log.begun_ns } else { &mut log.over_ns }) = Some(now_ns);
            }
            if begins {
                self.schedule.before.get_or_insert((
                    self.options.analog.avdd_v,
                    self.options.analog.reference_v,
                    self.options.clock_error_ppm,
                ));
            }
            self.act(fault, begins);
        }
    }

    fn act(&mut self, fault: Fault, begins: bool) {
        let now_ns = self.now_ns;
        let level = |high: bool| begins.then_some(high);
        let (supply_v, reference_v, error_ppm) = self.schedule.before.unwrap_or_default();
        let or_before = |during: f64, before: f64| if begins { during } else { before };
        match fault {
            Fault::RegisterFlip { address, mask } if begins => self.corrupt_register(address, mask),
            Fault::Reset if begins => self.reset_itself(now_ns),
            Fault::DoutFlip { bytes_ahead, mask } if begins => self.flip_dout(bytes_ahead, mask),
            Fault::DinFlip { bytes_ahead, mask } if begins => self.flip_din(bytes_ahead, mask),
            Fault::EdgesLost { count } if begins => self.lose_drdy_edges(count),
            Fault::EdgeRepeated { after_ns } if begins => self.repeat_drdy_edge(after_ns),
            // Over as soon as it has happened.
            Fault::RegisterFlip { .. }
            | Fault::Reset
            | Fault::DoutFlip { .. }
            | Fault::DinFlip { .. }
            | Fault::EdgesLost { .. }
            | Fault::EdgeRepeated { .. } => {}
            Fault::Stall => self.set_stalled(now_ns, begins),
            Fault::DoutStuck { high } => self.set_dout_stuck(level(high)),
            Fault::BusCut { high } => self.set_bus_cut(level(high)),
            Fault::DrdyStuck { high } => self.set_drdy_stuck(level(high)),
            Fault::Storm { period_ns } => self.set_drdy_storm(begins.then_some(period_ns)),
            Fault::Supply { volts } => self.options.analog.avdd_v = or_before(volts, supply_v),
            Fault::Reference { volts } => self.options.analog.reference_v = or_before(volts, reference_v),
            Fault::Clock { error_ppm: during_ppm } => {
                self.set_clock_error_ppm(now_ns, or_before(during_ppm, error_ppm));
            }
            Fault::Input { input, volts } => self.hold_input(begins.then_some((input, volts))),
        }
    }
}
