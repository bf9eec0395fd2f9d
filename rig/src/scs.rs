//! The system control space: interrupt controller, exceptions, processor control (DDI 0403E, B3.2 to B3.4).

/// Number of the first interrupt among the exceptions.
pub(crate) const FIRST_IRQ: u16 = 16;
/// Number of the HardFault exception.
pub(crate) const HARD_FAULT: u16 = 3;
/// Exceptions with a place here: 16 of the system and 97 interrupts, of which the STM32F405 has 82 (RM0090, table 61).
const EXCEPTIONS: usize = 113;

/// What masks exceptions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Masks {
    pub primask: bool,
    pub faultmask: bool,
    pub basepri: u8,
}

/// Counts of one interrupt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Served {
    /// How often it ran.
    pub times: u64,
    /// Longest wait from pending to its first instruction, cycles.
    pub longest_wait_cycles: u64,
    /// Sum of all waits, cycles.
    pub wait_cycles: u64,
}

/// Its state.
pub(crate) struct Scs {
    /// Bit n: exception n.
    enabled: u128,
    pending: u128,
    active: u128,
    /// Lines that peripherals hold high.
    lines: u128,
    /// Pended by a write to the controller.
    by_software: u128,
    priority: [u8; EXCEPTIONS],
    vtor: u32,
    pub cpacr: u32,
    fpccr: u32,
    /// FPCCR.LSPACT with FPCAR: where the interrupted code's floating-point registers belong.
    pub lazy_frame: Option<u32>,
    pub reset_requested: bool,
    pub cfsr: u32,
    pub hfsr: u32,
    pub bfar: u32,
    shcsr: u32,
    scr: u32,
    /// Time that each became pending, cycles.
    since: [u64; EXCEPTIONS],
    /// Of each exception.
    pub served: [Served; EXCEPTIONS],
    /// The present time, cycles.
    pub now: u64,
    /// Interrupts that were taken though nothing was pending in their peripheral.
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
            served: [Served::default(); EXCEPTIONS],
            now: 0,
            spurious: Vec::new(),
        }
    }

    /// As after a reset; the counts go on.
    pub fn reset(&mut self) {
        *self = Self { served: self.served, now: self.now, ..Self::new() };
    }

    /// Address of the vectors.
    pub fn vectors(&self) -> u32 {
        self.vtor
    }

    /// Whether code may use the floating-point unit.
    pub fn has_float(&self) -> bool {
        self.cpacr >> 20 & 15 == 15
    }

    /// FPCCR.LSPEN.
    pub fn is_lazy(&self) -> bool {
        self.fpccr & 1 << 30 != 0
    }

    /// Sets the level of an interrupt's line; a rising one makes it pending.
    pub fn set_line(&mut self, irq: u16, high: bool) {
        let bit = 1_u128 << (FIRST_IRQ + irq);
        if !high {
            self.lines &= !bit;
        } else if self.lines & bit == 0 {
            self.lines |= bit;
            self.pend(FIRST_IRQ + irq);
        }
    }

    /// Masks an interrupt, as NVIC_ICER does.
    pub fn mask(&mut self, irq: u16) {
        self.enabled &= !(1 << (FIRST_IRQ + irq));
    }

    fn pend(&mut self, number: u16) {
        let bit = 1_u128 << number;
        if self.pending & bit == 0 {
            self.pending |= bit;
            self.since[usize::from(number)] = self.now;
        }
    }

    /// The exception begins.
    pub fn begin(&mut self, number: u16) {
        let bit = 1_u128 << number;
        if number >= FIRST_IRQ && (self.lines | self.by_software) & bit == 0 {
            self.spurious.push(number - FIRST_IRQ);
        }
        let waited = self.now.saturating_sub(self.since[usize::from(number)]);
        let served = &mut self.served[usize::from(number)];
        served.times += 1;
        served.wait_cycles += waited;
        served.longest_wait_cycles = served.longest_wait_cycles.max(waited);
        self.pending &= !bit;
        self.by_software &= !bit;
        self.active |= bit;
    }

    /// The exception ends. A line that is still high makes it pending again.
    pub fn end(&mut self, number: u16) {
        let bit = 1_u128 << number;
        self.active &= !bit;
        if self.lines & bit != 0 {
            self.pend(number);
        }
    }

    /// The priority of what runs: a smaller number is higher; 256 is a thread.
    fn running(&self) -> i32 {
        numbers(self.active).map(|number| self.priority_of(number)).min().unwrap_or(256)
    }

    fn priority_of(&self, number: u16) -> i32 {
        match number {
            2 => -2,
            HARD_FAULT => -1,
            _ => self.priority[usize::from(number)].into(),
        }
    }

    /// Whether a fault of priority -1 can be taken; if not, the processor locks up.
    pub fn can_take_hard_fault(&self, masks: Masks) -> bool {
        self.running() > -1 && !masks.faultmask
    }

    /// The exception to take now, if any.
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
        // Of equal ones the first number wins.
        let best = numbers(ready).min_by_key(|number| self.priority_of(*number))?;
        (self.priority_of(best) < limit).then_some(best)
    }

    /// Whether WFI ends: PRIMASK does not count (DDI 0403E, B1.5.19).
    pub fn wakes(&self, masks: Masks) -> bool {
        self.next(Masks { primask: false, ..masks }).is_some()
    }

    /// Reads a word of the control space; none if it is not modelled.
    pub fn read(&self, address: u32) -> Option<u32> {
        let word = |bits: u128, from: u32| (bits >> FIRST_IRQ >> ((address - from) * 8)) as u32;
        Some(match address {
            0xE000_E100..=0xE000_E108 => word(self.enabled, 0xE000_E100),
            0xE000_E180..=0xE000_E188 => word(self.enabled, 0xE000_E180),
            0xE000_E200..=0xE000_E208 => word(self.pending, 0xE000_E200),
            0xE000_E280..=0xE000_E288 => word(self.pending, 0xE000_E280),
            0xE000_E300..=0xE000_E308 => word(self.active, 0xE000_E300),
            0xE000_E400..=0xE000_E45F => self.priorities(usize::from(FIRST_IRQ) + (address - 0xE000_E400) as usize),
            // CPUID of the r0p1 core in both chips (ST, PM0214).
            0xE000_ED00 => 0x410F_C241,
            0xE000_ED04 => {
                numbers(self.active).min_by_key(|number| self.priority_of(*number)).unwrap_or(0) as u32
                    | u32::from(self.pending >> FIRST_IRQ != 0) << 22
            }
            0xE000_ED08 => self.vtor,
            0xE000_ED0C => 0xFA05_0000,
            0xE000_ED10 => self.scr,
            // CCR: STKALIGN.
            0xE000_ED14 => 0x200,
            0xE000_ED18..=0xE000_ED23 => self.priorities(4 + (address - 0xE000_ED18) as usize),
            0xE000_ED24 => self.shcsr,
            0xE000_ED28 => self.cfsr,
            0xE000_ED2C => self.hfsr,
            0xE000_ED38 => self.bfar,
            0xE000_ED88 => self.cpacr,
            0xE000_EF34 => self.fpccr | u32::from(self.lazy_frame.is_some()),
            0xE000_EF38 => self.lazy_frame.unwrap_or(0),
            _ => return None,
        })
    }

    fn priorities(&self, at: usize) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|k| self.priority.get(at + k).copied().unwrap_or(0)))
    }

    /// Writes to the control space, a word or a byte of the priorities; none if it is not modelled.
    pub fn write(&mut self, address: u32, bytes: u32, value: u32) -> Option<()> {
        let bits = |from: u32| u128::from(value) << FIRST_IRQ << ((address - from) * 8);
        match address {
            0xE000_E100..=0xE000_E108 => self.enabled |= bits(0xE000_E100),
            0xE000_E180..=0xE000_E188 => self.enabled &= !bits(0xE000_E180),
            0xE000_E200..=0xE000_E208 => {
                self.by_software |= bits(0xE000_E200) & !self.pending;
                numbers(bits(0xE000_E200)).for_each(|number| self.pend(number));
            }
            0xE000_E280..=0xE000_E288 => self.pending &= !(bits(0xE000_E280) & !(self.lines & !self.active)),
            0xE000_E400..=0xE000_E45F => {
                self.set_priorities(usize::from(FIRST_IRQ) + (address - 0xE000_E400) as usize, bytes, value);
            }
            0xE000_ED08 => self.vtor = value & 0x3FFF_FF80,
            0xE000_ED0C if value >> 16 == 0x05FA => {
                // PRIGROUP must leave all bits to the group.
                if value & 0x700 > 0x300 {
                    return None;
                }
                self.reset_requested |= value & 4 != 0;
            }
            0xE000_ED0C => {}
            // SEVONPEND, SLEEPDEEP, SLEEPONEXIT.
            0xE000_ED10 if value == 0 => self.scr = value,
            0xE000_ED18..=0xE000_ED23 => self.set_priorities(4 + (address - 0xE000_ED18) as usize, bytes, value),
            0xE000_ED28 => self.cfsr &= !value,
            0xE000_ED2C => self.hfsr &= !value,
            0xE000_ED88 => self.cpacr = value & 0x00F0_0000,
            0xE000_EF34 => {
                self.fpccr = value & 0xC000_0000;
                if value & 1 == 0 {
                    self.lazy_frame = None;
                }
            }
            _ => return None,
        }
        Some(())
    }

    /// Four bits of each priority exist (PM0214).
    fn set_priorities(&mut self, at: usize, bytes: u32, value: u32) {
        for (k, byte) in value.to_le_bytes().into_iter().enumerate().take(bytes as usize) {
            if let Some(priority) = self.priority.get_mut(at + k) {
                *priority = byte & 0xF0;
            }
        }
    }

    /// SHCSR has a handler of its own for these faults; the images leave all of them to HardFault.
    pub fn note_fault(&mut self, cause: u32, address: Option<u32>) {
        self.cfsr |= cause;
        // FORCED.
        self.hfsr |= 1 << 30;
        self.bfar = address.unwrap_or(self.bfar);
    }
}

/// The numbers of the bits that are set.
fn numbers(mut bits: u128) -> impl Iterator<Item = u16> {
    std::iter::from_fn(move || {
        let number = (bits != 0).then(|| bits.trailing_zeros() as u16);
        bits &= bits.wrapping_sub(1);
        number
    })
}
