//! Faults of the chip, its bus and DRDY, and their effects while they last.

use super::Ads1258;

/// A fault. It lasts from [`Ads1258::begin_fault`] to [`Ads1258::end_fault`], or is scheduled by an
/// [`Injection`](super::Injection).
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the sentence of each variant names its fields")]
pub enum Fault {
    /// Inverts the bits of `mask` in the register at `address`, once, read-only bits too.
    RegisterFlip { address: u8, mask: u8 },
    /// Resets the chip once, as a dip of its digital supply does.
    Reset,
    /// Stops the converter: no conversion ends or begins. The end of the fault is a new start
    /// condition if START is high.
    Stall,
    /// Inverts the bits of `mask` once, in the byte from the chip that comes `bytes_ahead` bytes
    /// after the next one. After an edge of DRDY the next byte is the command of a read, and the
    /// following four are its result.
    DoutFlip { bytes_ahead: u64, mask: u8 },
    /// Inverts the bits of `mask` once in a byte to the chip, which obeys the changed byte: a read
    /// may become a register write.
    DinFlip { bytes_ahead: u64, mask: u8 },
    /// DOUT is stuck at one if `high`, else at zero. The chip still receives.
    DoutStuck { high: bool },
    /// SCLK, DIN or CS is cut: the chip receives nothing, and DOUT floats to one if `high`, else to
    /// zero.
    BusCut { high: bool },
    /// DRDY is stuck at one if `high`, else at zero.
    DrdyStuck { high: bool },
    /// Adds edges of DRDY without new results every `period_ns` nanoseconds, between the chip's
    /// own.
    Storm { period_ns: u64 },
    /// The next `count` edges of DRDY do not arrive.
    EdgesLost { count: u32 },
    /// Adds one edge of DRDY, `after_ns` nanoseconds from now.
    EdgeRepeated { after_ns: u64 },
    /// Changes the analogue supply AVDD - AVSS to `volts`. Below 4.3 V the chip sets SUPPLY, and
    /// its data are poison.
    Supply { volts: f64 },
    /// Changes the reference VREFP - VREFN to `volts`.
    Reference { volts: f64 },
    /// Changes the error of the clock, in parts per million; positive is fast.
    Clock { error_ppm: f64 },
    /// Holds AIN`input` at `volts` instead of the scene's voltage.
    Input { input: u8, volts: f64 },
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Faults {
    pub(crate) stalled: bool,
    /// An input and the voltage at which it is held.
    pub(crate) held: Option<(u8, f64)>,
    /// Constant level of DOUT at the processor, true for high.
    dout_stuck: Option<bool>,
    pub(crate) is_cut: bool,
    /// Bits of DIN and DOUT to invert in later bytes, by the count of bytes exchanged since
    /// construction.
    bit_errors: Vec<(u64, [u8; 2])>,
    exchanged: u64,
    /// Constant level of DRDY at the processor, true for high.
    pub(crate) drdy_stuck: Option<bool>,
    pub(crate) edges_lost: u32,
    pub(crate) edge_repeated_ns: Option<u64>,
    /// Beginning and period of a storm of DRDY edges.
    pub(crate) storm_ns: Option<(u64, u64)>,
    /// Supply, reference and clock error before the first fault.
    before: Option<(f64, f64, f64)>,
}

impl Faults {
    /// Bits of DIN and of DOUT to invert in the next byte.
    pub(crate) fn next(&mut self) -> [u8; 2] {
        let at = self.exchanged;
        self.exchanged += 1;
        let mut sum = [0; 2];
        self.bit_errors.retain(|(byte, [din, dout])| {
            if *byte == at {
                sum = [sum[0] ^ din, sum[1] ^ dout];
            }
            *byte > at
        });
        sum
    }

    /// Returns the byte that arrives at the processor instead of `dout`.
    pub(crate) fn on_dout(&self, dout: u8) -> u8 {
        self.dout_stuck
            .map_or(dout, |high| if high { 0xFF } else { 0x00 })
    }
}

impl Ads1258 {
    /// Begins a fault now.
    pub fn begin_fault(&mut self, fault: Fault) {
        let (analog, faults) = (&mut self.options.analog, &mut self.faults);
        faults.before.get_or_insert((
            analog.avdd_v,
            analog.reference_v,
            self.options.clock_error_ppm,
        ));
        match fault {
            Fault::RegisterFlip { address, mask } => self.registers.invert(address, mask),
            Fault::Reset => {
                self.forget();
                self.start_again();
            }
            Fault::Stall => (faults.stalled, self.conversion) = (true, None),
            Fault::DoutFlip { bytes_ahead, mask } => faults
                .bit_errors
                .push((faults.exchanged + bytes_ahead, [0, mask])),
            Fault::DinFlip { bytes_ahead, mask } => faults
                .bit_errors
                .push((faults.exchanged + bytes_ahead, [mask, 0])),
            Fault::DoutStuck { high } => faults.dout_stuck = Some(high),
            Fault::BusCut { high } => (faults.dout_stuck, faults.is_cut) = (Some(high), true),
            Fault::DrdyStuck { high } => faults.drdy_stuck = Some(high),
            Fault::Storm { period_ns } => faults.storm_ns = Some((self.now_ns, period_ns.max(1))),
            Fault::EdgesLost { count } => faults.edges_lost = count,
            Fault::EdgeRepeated { after_ns } => {
                faults.edge_repeated_ns = Some(self.now_ns + after_ns)
            }
            Fault::Supply { volts } => analog.avdd_v = volts,
            Fault::Reference { volts } => analog.reference_v = volts,
            Fault::Clock { error_ppm } => self.set_clock_error(error_ppm),
            Fault::Input { input, volts } => faults.held = Some((input, volts)),
        }
    }

    /// Ends a fault now. Supply, reference and clock return to their values before the first fault.
    pub fn end_fault(&mut self, fault: Fault) {
        let (analog, faults) = (&mut self.options.analog, &mut self.faults);
        let (supply_v, reference_v, error_ppm) = faults.before.unwrap_or_default();
        match fault {
            Fault::Stall => {
                let was_stalled = std::mem::take(&mut faults.stalled);
                if was_stalled {
                    self.start_again();
                }
            }
            Fault::DoutStuck { .. } | Fault::BusCut { .. } => {
                (faults.dout_stuck, faults.is_cut) = (None, false)
            }
            Fault::DrdyStuck { .. } => faults.drdy_stuck = None,
            Fault::Storm { .. } => faults.storm_ns = None,
            Fault::Supply { .. } => analog.avdd_v = supply_v,
            Fault::Reference { .. } => analog.reference_v = reference_v,
            Fault::Clock { .. } => self.set_clock_error(error_ppm),
            Fault::Input { .. } => faults.held = None,
            // All other faults are single events, so there is nothing to end.
            _ => {}
        }
    }

    /// Repeats the start condition if START is high.
    pub(crate) fn start_again(&mut self) {
        if self.start {
            self.start_condition();
        }
    }

    fn set_clock_error(&mut self, error_ppm: f64) {
        self.options.clock_error_ppm = error_ppm;
        self.take_clock();
    }
}
