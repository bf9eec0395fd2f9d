//! Enabled, pending and active exceptions, and the choice of the next one.

/// Number of the first interrupt among the exceptions.
pub(crate) const FIRST_IRQ: u16 = 16;
/// Number of the non-maskable interrupt among the exceptions.
const NMI: u16 = 2;
pub(crate) const HARD_FAULT: u16 = 3;
/// Number of exceptions modelled: 16 of the system and 97 interrupts, of which the STM32F405 has 82
/// (RM0090, table 61).
const EXCEPTIONS: usize = 113;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Masks {
    pub primask: bool,
    pub faultmask: bool,
    pub basepri: u8,
}

/// Counts of one interrupt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// Number of runs.
    pub times: u64,
    /// Longest wait from the pending interrupt to its first instruction, cycles.
    pub longest_wait_cycles: u64,
    /// Sum of all waits, cycles.
    pub wait_cycles: u64,
    /// Longest run from the first instruction to the return, including higher-priority interrupts,
    /// cycles.
    pub longest_run_cycles: u64,
    /// Sum of all runs, cycles.
    pub run_cycles: u64,
    /// Cycles of the interrupt itself, without higher-priority interrupts.
    pub own_cycles: u64,
    /// Instructions of the interrupt itself.
    pub instructions: u64,
    /// Number of runs with nothing to do, because another run of the same priority had already
    /// served the cause.
    pub served_before: u64,
}

pub(crate) struct Scs {
    /// Bit n is exception n.
    pub enabled: u128,
    pub pending: u128,
    pub active: u128,
    /// Lines held high by peripherals.
    pub lines: u128,
    /// Exceptions set pending by a write to the controller.
    pub by_software: u128,
    /// Pending exceptions whose cause was served by a run of the same priority.
    served_before: u128,
    pub priority: [u8; EXCEPTIONS],
    pub vtor: u32,
    pub cpacr: u32,
    pub fpccr: u32,
    /// FPCCR.LSPACT with FPCAR: address for the interrupted code's floating-point registers.
    pub lazy_frame: Option<u32>,
    pub reset_requested: bool,
    pub cfsr: u32,
    pub hfsr: u32,
    pub bfar: u32,
    pub shcsr: u32,
    pub scr: u32,
    /// Cycle at which each exception became pending.
    since: [u64; EXCEPTIONS],
    /// Cycle at which each exception began.
    begun: [u64; EXCEPTIONS],
    pub served: [Served; EXCEPTIONS],
    /// Cycles and instructions already included in [`Self::served`].
    charged: [u64; 2],
    pub now: u64,
    /// Interrupts taken without a pending cause in their peripheral.
    pub spurious: Vec<u16>,
}

impl Scs {
    pub fn new() -> Self {
        Self {
            enabled: 0xFFFF,
            pending: 0,
            active: 0,
            lines: 0,
            by_software: 0,
            served_before: 0,
            priority: [0; EXCEPTIONS],
            vtor: 0,
            cpacr: 0,
            fpccr: 0xC000_0000,
            lazy_frame: None,
            reset_requested: false,
            cfsr: 0,
            hfsr: 0,
            bfar: 0,
            shcsr: 0,
            scr: 0,
            since: [0; EXCEPTIONS],
            begun: [0; EXCEPTIONS],
            served: [Served::default(); EXCEPTIONS],
            charged: [0; 2],
            now: 0,
            spurious: Vec::new(),
        }
    }

    /// Returns to the state after a reset, but keeps the counts.
    pub fn reset(&mut self) {
        *self = Self {
            served: self.served,
            charged: self.charged,
            now: self.now,
            ..Self::new()
        };
    }

    /// Charges exception `number` (0 for the thread) with the cycles and instructions since the
    /// last call. `now` is the cycles and instructions since power-up.
    pub fn charge(&mut self, number: u16, now: [u64; 2]) {
        let [cycles, instructions] = self.since_charged(now);
        let served = &mut self.served[usize::from(number)];
        served.own_cycles += cycles;
        served.instructions += instructions;
        self.charged = now;
    }

    pub fn since_charged(&self, now: [u64; 2]) -> [u64; 2] {
        [now[0] - self.charged[0], now[1] - self.charged[1]]
    }

    /// Skips cycles spent asleep, which are not charged.
    pub fn sleep(&mut self, cycles: u64) {
        self.charged[0] += cycles;
    }

    pub fn vectors(&self) -> u32 {
        self.vtor
    }

    /// True if code may use the floating-point unit.
    pub fn has_float(&self) -> bool {
        self.cpacr >> 20 & 15 == 15
    }

    pub fn is_lazy(&self) -> bool {
        self.fpccr & 1 << 30 != 0
    }

    /// Sets the level of an interrupt's line; a rising edge makes it pending.
    pub fn set_line(&mut self, irq: u16, high: bool) {
        let bit = 1_u128 << (FIRST_IRQ + irq);
        if high == (self.lines & bit != 0) {
            return;
        }
        if !high {
            let own = self.priority_of(FIRST_IRQ + irq);
            if self.pending & bit != 0
                && numbers(self.active).any(|number| self.priority_of(number) == own)
            {
                self.served_before |= bit;
            }
            self.lines &= !bit;
        } else {
            self.lines |= bit;
            self.pend(FIRST_IRQ + irq);
        }
    }

    /// Masks an interrupt, as NVIC_ICER does.
    pub fn mask(&mut self, irq: u16) {
        self.enabled &= !(1 << (FIRST_IRQ + irq));
    }

    /// Unmasks an interrupt, as NVIC_ISER does.
    pub fn unmask(&mut self, irq: u16) {
        self.enabled |= 1 << (FIRST_IRQ + irq);
    }

    /// Requests the NMI for the clock security system, which repeats the request until its flag is
    /// cleared.
    pub fn request_nmi(&mut self) {
        if self.active & 1 << NMI == 0 {
            self.pend(NMI);
        }
    }

    pub fn pend(&mut self, number: u16) {
        let bit = 1_u128 << number;
        if self.pending & bit == 0 {
            self.pending |= bit;
            self.since[usize::from(number)] = self.now;
        }
    }

    pub fn begin(&mut self, number: u16) {
        let bit = 1_u128 << number;
        let has_no_cause = number >= FIRST_IRQ && (self.lines | self.by_software) & bit == 0;
        // An interrupt stays pending even if another run serves its cause (DDI 0403E, B3.4.1).
        let is_served = has_no_cause && self.served_before & bit != 0;
        if has_no_cause && !is_served {
            self.spurious.push(number - FIRST_IRQ);
        }
        let waited = self.now.saturating_sub(self.since[usize::from(number)]);
        let served = &mut self.served[usize::from(number)];
        served.served_before += u64::from(is_served);
        served.times += 1;
        served.wait_cycles += waited;
        served.longest_wait_cycles = served.longest_wait_cycles.max(waited);
        self.begun[usize::from(number)] = self.now;
        self.pending &= !bit;
        self.by_software &= !bit;
        self.served_before &= !bit;
        self.active |= bit;
    }

    /// Ends an exception. A line that is still high makes it pending again.
    pub fn end(&mut self, number: u16) {
        let bit = 1_u128 << number;
        self.active &= !bit;
        let ran = self.now.saturating_sub(self.begun[usize::from(number)]);
        let served = &mut self.served[usize::from(number)];
        served.run_cycles += ran;
        served.longest_run_cycles = served.longest_run_cycles.max(ran);
        if self.lines & bit != 0 {
            self.pend(number);
        }
    }

    /// Priority of the running code: smaller numbers come first, and thread mode has 256.
    fn running(&self) -> i32 {
        numbers(self.active)
            .map(|number| self.priority_of(number))
            .min()
            .unwrap_or(256)
    }

    pub fn priority_of(&self, number: u16) -> i32 {
        match number {
            NMI => -2,
            HARD_FAULT => -1,
            _ => self.priority[usize::from(number)].into(),
        }
    }

    /// True if a fault of priority -1 can be taken; if not, the processor locks up.
    pub fn can_take_hard_fault(&self, masks: Masks) -> bool {
        self.running() > -1 && !masks.faultmask
    }

    /// Exception to take now, if any.
    pub fn next(&self, masks: Masks) -> Option<u16> {
        let ready = self.pending & self.enabled;
        if ready == 0 {
            return None;
        }
        let mut limit = self.running();
        if masks.basepri != 0 {
            limit = limit.min(masks.basepri.into());
        }
        if masks.primask {
            limit = limit.min(0);
        }
        if masks.faultmask {
            limit = limit.min(-1);
        }
        // Among equal priorities, the lowest number is taken first.
        let best = numbers(ready).min_by_key(|number| self.priority_of(*number))?;
        (self.priority_of(best) < limit).then_some(best)
    }

    /// True if WFI must end; PRIMASK is ignored for this (DDI 0403E, B1.5.19).
    pub fn wakes(&self, masks: Masks) -> bool {
        self.next(Masks {
            primask: false,
            ..masks
        })
        .is_some()
    }

    /// Records a fault. SHCSR could enable separate handlers, but the images leave all faults to
    /// HardFault.
    pub fn note_fault(&mut self, cause: u32, address: Option<u32>) {
        self.cfsr |= cause;
        // FORCED.
        self.hfsr |= 1 << 30;
        self.bfar = address.unwrap_or(self.bfar);
    }
}

/// Iterates over the numbers of the bits that are set.
pub fn numbers(mut bits: u128) -> impl Iterator<Item = u16> {
    std::iter::from_fn(move || {
        let number = (bits != 0).then(|| bits.trailing_zeros() as u16);
        bits &= bits.wrapping_sub(1);
        number
    })
}
