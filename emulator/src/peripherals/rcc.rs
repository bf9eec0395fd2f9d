//! Reset and clock control (RM0090, 7.3).

use crate::board::Wiring;
use crate::findings::Rule;

/// Nominal frequency of the internal oscillator, hertz.
pub const HSI_HZ: u64 = 16_000_000;
/// Time from HSEON to HSERDY, nanoseconds: 2 ms for a typical crystal (DS8626, HSE oscillator
/// characteristics).
const HSE_START_NS: u64 = 2_000_000;
/// Time from PLLON to PLLRDY, nanoseconds: 75 to 200 us (DS8626, main PLL characteristics).
const PLL_LOCK_NS: u64 = 200_000;

const HSION: u32 = 1;
const HSEON: u32 = 1 << 16;
const HSEBYP: u32 = 1 << 18;
const CSSON: u32 = 1 << 19;
const PLLON: u32 = 1 << 24;
/// CIR: the flag of the clock security system, and the bit that clears it.
const CSSF: u32 = 1 << 7;
const CSSC: u32 = 1 << 23;

/// Causes of a reset, with their flags in CSR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetCause {
    /// Power-up: PORRSTF, BORRSTF, and PINRSTF, which every reset sets.
    Power = 0x0E00_0000,
    /// The NRST pin.
    Pin = 0x0400_0000,
    /// SYSRESETREQ.
    Software = 0x1400_0000,
    /// The independent watchdog.
    Watchdog = 0x2400_0000,
}

/// Clocks in hertz.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clocks {
    /// Processor and AHB.
    pub hclk: u64,
    /// APB1 and APB2.
    pub pclk: [u64; 2],
}

pub struct Rcc {
    cr: u32,
    pllcfgr: u32,
    cfgr: u32,
    /// AHB1, AHB2, AHB3, APB1, APB2.
    enabled: [u32; 5],
    resets: [u32; 5],
    csr: u32,
    bdcr: u32,
    /// Time at which HSE is ready, nanoseconds.
    hse_ready_ns: u64,
    pll_on_ns: u64,
    /// True if DCKCFGR exists: on the STM32F446 (RM0390, 6.3.25).
    has_dckcfgr: bool,
    /// True if the clock security system has detected that HSE failed.
    has_failed: bool,
    /// Actual frequency of the internal oscillator, hertz.
    pub hsi_hz: u64,
    /// True if HSE does not run and never starts.
    pub hse_is_dead: bool,
    /// True if HSE will not start after the next reset.
    pub hse_dies: bool,
}

#[derive(Default)]
pub struct Changed {
    pub clocks: bool,
    /// Peripherals to reset now: bus and bits.
    pub resets: Option<(usize, u32)>,
    pub broken: Option<(Rule, String)>,
}

impl Rcc {
    pub fn new(cause: ResetCause, has_dckcfgr: bool) -> Self {
        Self {
            cr: 0x83,
            pllcfgr: 0x2400_3010,
            cfgr: 0,
            // The CCM RAM's clock is on.
            enabled: [0x0010_0000, 0, 0, 0, 0],
            resets: [0; 5],
            csr: cause as u32,
            bdcr: 0,
            hse_ready_ns: 0,
            pll_on_ns: 0,
            has_dckcfgr,
            has_failed: false,
            hsi_hz: HSI_HZ,
            hse_is_dead: false,
            hse_dies: false,
        }
    }

    /// Returns to the state after a reset. CSR's flags accumulate until they are cleared; BDCR is
    /// in the backup domain, so it is kept.
    pub fn reset(&mut self, cause: ResetCause) {
        *self = Self {
            csr: self.csr & 0xFE00_0003 | cause as u32,
            bdcr: self.bdcr,
            hsi_hz: self.hsi_hz,
            hse_is_dead: self.hse_is_dead || self.hse_dies,
            ..Self::new(cause, self.has_dckcfgr)
        };
    }

    pub fn is_on(&self, bus: usize, bit: u32) -> bool {
        self.enabled[bus] >> bit & 1 != 0
    }

    /// Returns true if the processor runs from an external clock, false from a crystal; `None` if
    /// not from HSE.
    pub fn hse(&self) -> Option<bool> {
        let is_source = self.cfgr & 3 == 1 || self.cfgr & 3 == 2 && self.pllcfgr & 1 << 22 != 0;
        is_source.then_some(self.cr & HSEBYP != 0)
    }

    /// Responds to the loss of HSE as the clock security system does (RM0090, 7.2.7). Returns false
    /// if that system is off.
    pub fn secure(&mut self) -> bool {
        let is_on = self.cr & CSSON != 0;
        if is_on {
            let source_dies = self.hse().is_some();
            self.cr &= !(HSEON | CSSON);
            if self.pllcfgr & 1 << 22 != 0 {
                self.cr &= !PLLON;
            }
            if source_dies {
                self.cr |= HSION;
                self.cfgr &= !3;
            }
            self.has_failed = true;
        }
        is_on
    }

    /// True if the clock security system's flag requests the NMI.
    pub fn requests_nmi(&self) -> bool {
        self.has_failed
    }

    pub fn is_pll_on(&self) -> bool {
        self.cr & PLLON != 0
    }

    fn has_hse(&self, now_ns: u64) -> bool {
        self.cr & HSEON != 0
            && !self.hse_is_dead
            && (self.cr & HSEBYP != 0 || now_ns >= self.hse_ready_ns)
    }

    fn pll_source_works(&self, now_ns: u64) -> bool {
        if self.pllcfgr & 1 << 22 != 0 {
            self.has_hse(now_ns)
        } else {
            self.cr & HSION != 0
        }
    }

    fn has_pll(&self, now_ns: u64) -> bool {
        self.cr & PLLON != 0
            && self.pll_source_works(now_ns)
            && now_ns >= self.pll_on_ns + PLL_LOCK_NS
    }

    /// Returns the clocks selected by the registers and, if the PLL is the source, the frequencies
    /// of its input and VCO, hertz. `hsi_hz` is the frequency of the internal oscillator.
    pub fn clocks(&self, wiring: &Wiring, hsi_hz: u64) -> (Clocks, Option<[u64; 2]>) {
        let (m, n) = (
            u64::from(self.pllcfgr & 63).max(1),
            u64::from(self.pllcfgr >> 6 & 511),
        );
        let p = 2 * (1 + u64::from(self.pllcfgr >> 16 & 3));
        let source = if self.pllcfgr & 1 << 22 != 0 {
            wiring.hse_hz
        } else {
            hsi_hz
        };
        let (sysclk, pll) = match self.cfgr & 3 {
            0 => (hsi_hz, None),
            1 => (wiring.hse_hz, None),
            _ => (source * n / m / p, Some([source / m, source * n / m])),
        };
        let ahb = match self.cfgr >> 4 & 15 {
            0..=7 => 0,
            high @ 8..=11 => high - 7,
            high => high - 6,
        };
        let apb = |field: u32| if field & 4 == 0 { 0 } else { (field & 3) + 1 };
        let hclk = sysclk >> ahb;
        let pclk = [
            hclk >> apb(self.cfgr >> 10 & 7),
            hclk >> apb(self.cfgr >> 13 & 7),
        ];
        (Clocks { hclk, pclk }, pll)
    }

    pub fn read(&self, offset: u32, now_ns: u64) -> Option<u32> {
        let ready = |is: bool, bit: u32| u32::from(is) << bit;
        Some(match offset {
            0x00 => {
                self.cr & !0x0202_0002
                    | ready(self.cr & HSION != 0, 1)
                    | ready(self.has_hse(now_ns), 17)
                    | ready(self.has_pll(now_ns), 25)
            }
            0x04 => self.pllcfgr,
            0x08 => self.cfgr & !0xC | (self.cfgr & 3) << 2,
            0x0C => {
                if self.has_failed {
                    CSSF
                } else {
                    0
                }
            }
            0x10..=0x18 => self.resets[(offset as usize - 0x10) / 4],
            0x20 | 0x24 => self.resets[3 + (offset as usize - 0x20) / 4],
            0x30..=0x38 => self.enabled[(offset as usize - 0x30) / 4],
            0x40 | 0x44 => self.enabled[3 + (offset as usize - 0x40) / 4],
            0x70 => self.bdcr,
            0x74 => self.csr | (self.csr & 1) << 1,
            0x8C if self.has_dckcfgr => 0,
            _ => return None,
        })
    }

    pub fn write(&mut self, offset: u32, value: u32, now_ns: u64) -> Option<Changed> {
        let mut changed = Changed::default();
        match offset {
            0x00 => {
                // The current clock source cannot be switched off.
                let kept = match self.cfgr & 3 {
                    0 => HSION,
                    1 => HSEON,
                    _ => PLLON,
                };
                let value = value | self.cr & kept;
                if value & !self.cr & HSEON != 0 {
                    self.hse_ready_ns = now_ns + HSE_START_NS;
                }
                // HSEBYP can be written only while HSE is off.
                let changes_kind = (value ^ self.cr) & HSEBYP != 0 && self.cr & HSEON != 0;
                let value = if changes_kind { value ^ HSEBYP } else { value };
                if changes_kind {
                    changed.broken = Some((
                        Rule::HseOff,
                        format!("HSEBYP is written, {value:#010x}, while HSEON"),
                    ));
                }
                if value & !self.cr & PLLON != 0 {
                    self.pll_on_ns = now_ns;
                    if !self.pll_source_works(now_ns) {
                        changed.broken = Some((
                            Rule::ClockLimit,
                            "the PLL starts before its source is ready".into(),
                        ));
                    }
                }
                // The second PLL is not modelled.
                if value & 0xFCF0_0000 & !PLLON != 0 {
                    return None;
                }
                self.cr = value & 0x010D_00F9 | self.cr & 0xFF00;
            }
            0x04 => {
                if self.cr & PLLON != 0 {
                    changed.broken = Some((
                        Rule::PllOff,
                        format!("PLLCFGR is written, {value:#010x}, while PLLON"),
                    ));
                }
                self.pllcfgr = value;
            }
            0x08 => {
                if value & 0xFFE0_0000 != 0 {
                    return None;
                }
                let works = match value & 3 {
                    0 => true,
                    1 => self.has_hse(now_ns),
                    2 => self.has_pll(now_ns),
                    _ => return None,
                };
                if !works {
                    changed.broken = Some((
                        Rule::ClockLimit,
                        "a clock is chosen that is not ready".into(),
                    ));
                }
                self.cfgr = value;
                changed.clocks = true;
            }
            0x0C => self.has_failed &= value & CSSC == 0,
            0x10..=0x18 => {
                changed.resets = Some(self.set_resets((offset as usize - 0x10) / 4, value))
            }
            0x20 | 0x24 => {
                changed.resets = Some(self.set_resets(3 + (offset as usize - 0x20) / 4, value))
            }
            0x30..=0x38 => self.enabled[(offset as usize - 0x30) / 4] = value,
            0x40 | 0x44 => self.enabled[3 + (offset as usize - 0x40) / 4] = value,
            0x74 => {
                if value & 1 << 24 != 0 {
                    self.csr &= 3;
                }
                self.csr = self.csr & !1 | value & 1;
            }
            // Other prescalers of the timers, and clocks of unused peripherals, are not modelled.
            0x8C if self.has_dckcfgr && value == 0 => {}
            _ => return None,
        }
        Some(changed)
    }

    fn set_resets(&mut self, bus: usize, value: u32) -> (usize, u32) {
        self.resets[bus] = value;
        (bus, value)
    }

    /// Selects the PLL, running from HSI with its reset values at 96 MHz, as the processor's clock.
    /// HSE is on too, as a crystal.
    pub fn leave_pll_on(&mut self) {
        self.cr |= PLLON | HSEON;
        self.cfgr = 2 | 5 << 10 | 4 << 13;
    }
}
