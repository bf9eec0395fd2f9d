//! The board under test: the processor with all that hangs on it, and the ends of its cables.

use crate::board::Board;
use crate::breakage::Breakage;
use crate::bus::Bus;
use crate::cpu::Cpu;
use crate::findings::{Finding, Rule};
use crate::image::Image;
use crate::peripherals::adc::{Adc, Reading};
use crate::peripherals::rcc::ResetCause;
use crate::scs::{FIRST_IRQ, HARD_FAULT, Served};
use crate::stop::{Failure, Stop};
use hal_mock::{Ads1258, Fault, Options, Scene};

/// How a run begins.
#[derive(Clone, Debug)]
pub struct Start {
    /// Options of the simulated ADC. By default it is powered together with the board, and deaf for 2^18 tCLK.
    pub adc: Options,
    /// The crystal does not start.
    pub hse_is_dead: bool,
    /// As the ROM's loader leaves the chip: PLL on, system memory at address 0, and a jump through the flash's vectors.
    pub after_rom_loader: bool,
}

impl Default for Start {
    fn default() -> Self {
        let adc = Options { power_up_cycles: 1 << 18, ..Options::default() };
        Self { adc, hse_is_dead: false, after_rom_loader: false }
    }
}

/// A reset that has happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reset {
    /// Its cause.
    pub cause: ResetCause,
    /// When, nanoseconds since power-up.
    pub at_ns: u64,
}

/// A board with its firmware, a simulated ADC and a cable.
pub struct Rig {
    cpu: Cpu,
    bus: Bus,
    asleep_cycles: u64,
    resets: Vec<Reset>,
    stack_end: u32,
    /// The cable's bit rate.
    baud: u64,
}

/// Bits per second of the PC's end of the serial line.
const BAUD: u64 = 921_600;
/// DRDY's interrupt, line 4 of EXTI, among the exceptions.
const EXTI4: u16 = FIRST_IRQ + 10;

impl Rig {
    /// A board that is just powered, in front of `scene`.
    pub fn new(board: Board, image: &Image, scene: impl Scene + 'static, start: Start) -> Result<Self, Box<Failure>> {
        let wiring = board.wiring();
        let mut bus = Bus::new(wiring, Adc::new(Box::new(scene), start.adc));
        for (place, data) in &image.segments {
            let at = place.wrapping_sub(0x0800_0000) as usize;
            if let Some(flash) = bus.flash.bytes.get_mut(at..at + data.len()) {
                flash.copy_from_slice(data);
            }
        }
        bus.rcc.hse_is_dead = start.hse_is_dead;
        let mut cpu = Cpu::new(wiring.flash_bytes);
        let failed = |stop| match stop {
            Stop::Failed(failure) => failure,
            _ => Box::new(Failure { what: "a reset vector".into(), address: 0, pc: 0, at_ns: 0 }),
        };
        cpu.reset(&mut bus).map_err(failed)?;
        if start.after_rom_loader {
            bus.leave_as_rom_loader();
        }
        let stack_end = image.symbol("_stack_end").unwrap_or(0);
        Ok(Self { cpu, bus, asleep_cycles: 0, resets: Vec::new(), stack_end, baud: BAUD })
    }

    /// Runs for this long in virtual time, nanoseconds.
    pub fn run_ns(&mut self, ns: u64) -> Result<(), Box<Failure>> {
        self.run_until(self.now_ns() + ns)
    }

    /// Runs until this virtual time, nanoseconds since power-up.
    pub fn run_until(&mut self, end_ns: u64) -> Result<(), Box<Failure>> {
        while self.now_ns() < end_ns {
            if self.bus.time.cycles >= self.bus.deadline && !self.look_around(end_ns)? {
                continue;
            }
            if let Err(stop) = self.cpu.step(&mut self.bus) {
                self.fault(stop)?;
            }
            while self.bus.time.cycles < self.bus.deadline {
                if let Err(stop) = self.cpu.step(&mut self.bus) {
                    self.fault(stop)?;
                }
            }
        }
        Ok(())
    }

    /// What happens between instructions: events, resets, interrupts, sleep. Whether the processor goes on.
    fn look_around(&mut self, end_ns: u64) -> Result<bool, Box<Failure>> {
        self.bus.catch_up();
        if self.bus.has_bitten {
            return self.reset(ResetCause::Watchdog).map(|()| false);
        }
        if self.bus.scs.reset_requested {
            return self.reset(ResetCause::Software).map(|()| false);
        }
        if std::mem::take(&mut self.bus.flash_changed) {
            self.cpu.forget();
        }
        let next = self.bus.next_event().min(self.bus.time.cycle_at(end_ns));
        self.bus.deadline = next;
        let masks = self.cpu.masks();
        if self.cpu.is_asleep {
            if !self.bus.scs.wakes(masks) {
                let to = next.max(self.bus.time.cycles + 1);
                self.asleep_cycles += to - self.bus.time.cycles;
                self.bus.time.cycles = to;
                return Ok(false);
            }
            self.cpu.is_asleep = false;
        }
        if let Some(number) = self.bus.scs.next(masks) {
            self.bus.dates_edge |= number == EXTI4;
            if let Err(stop) = self.cpu.enter(number, &mut self.bus) {
                self.fault(stop)?;
            }
            self.check_stack();
            for irq in std::mem::take(&mut self.bus.scs.spurious) {
                self.bus.note(Some((Rule::SpuriousInterrupt, format!("interrupt {irq} without a cause"))));
            }
            // A higher one may wait already.
            self.bus.attend();
            return Ok(false);
        }
        Ok(true)
    }

    fn check_stack(&mut self) {
        let sp = self.cpu.r[13];
        if sp < self.stack_end {
            self.bus.note(Some((Rule::StackEnd, format!("the stack pointer is {sp:#010x}"))));
        }
    }

    /// A fault of the processor becomes a HardFault, as no other handler is enabled.
    fn fault(&mut self, stop: Stop) -> Result<(), Box<Failure>> {
        let (cause, address) = match stop {
            Stop::Failed(failure) => return Err(failure),
            // PRECISERR with BFARVALID.
            Stop::Bus(address) => (1 << 9 | 1 << 15, Some(address)),
            Stop::Usage(usage) => (usage as u32, None),
        };
        if !self.bus.scs.can_take_hard_fault(self.cpu.masks()) {
            return Err(Box::new(Failure {
                what: "a fault within a fault (lockup)".into(),
                address: address.unwrap_or(0),
                pc: self.bus.pc,
                at_ns: self.now_ns(),
            }));
        }
        self.check_stack();
        self.bus.scs.note_fault(cause, address);
        // The frame holds the faulting instruction's address.
        self.cpu.pc = self.bus.pc;
        // Without memory for its frame the handler runs all the same (DDI 0403E, B1.5.15).
        match self.cpu.enter(HARD_FAULT, &mut self.bus) {
            Err(Stop::Failed(failure)) => Err(failure),
            _ => Ok(()),
        }
    }

    /// Resets the chip. RAM, the ADC and the cable go on.
    fn reset(&mut self, cause: ResetCause) -> Result<(), Box<Failure>> {
        self.resets.push(Reset { cause, at_ns: self.now_ns() });
        self.bus.reset(cause);
        self.cpu.reset(&mut self.bus).map_err(|_| {
            let (what, at_ns) = ("the reset vector".to_owned(), self.now_ns());
            Box::new(Failure { what, address: 0, pc: 0, at_ns })
        })
    }

    /// Presses the reset button.
    pub fn press_reset(&mut self) -> Result<(), Box<Failure>> {
        self.reset(ResetCause::Pin)
    }

    /// Does this to the processor now.
    pub fn suffer(&mut self, breakage: Breakage) {
        match breakage {
            Breakage::JumpTo(address) => self.cpu.pc = address & !1,
            Breakage::StackPointer(address) => self.cpu.r[13] = address & !3,
            Breakage::Microseconds(value) => self.bus.tim2.restart(value, self.bus.time.cycles),
            Breakage::Mask(irq) => self.bus.scs.mask(irq),
        }
        // Asleep it would only notice at the next interrupt.
        self.cpu.is_asleep = false;
        self.bus.attend();
    }

    /// Cuts the power of the flash after so many more words: what is written behind them is lost, and so is an erase.
    pub fn cut_flash_after(&mut self, words: Option<u64>) {
        self.bus.flash.words_left = words;
    }

    /// Switches the power off and on: RAM forgets, the flash and the cable do not.
    pub fn cycle_power(&mut self) -> Result<(), Box<Failure>> {
        self.bus.ram.fill(0xA5);
        self.bus.flash.words_left = None;
        self.reset(ResetCause::Power)
    }

    /// Overwrites flash from outside, as a programmer does.
    pub fn overwrite_flash(&mut self, address: u32, byte: u8, bytes: usize) {
        let at = address.wrapping_sub(0x0800_0000) as usize;
        if let Some(place) = self.bus.flash.bytes.get_mut(at..at + bytes) {
            place.fill(byte);
            self.cpu.forget();
        }
    }

    /// Words that the flash has programmed, and sectors that it has erased.
    pub fn flash_counts(&self) -> (u64, u64) {
        (self.bus.flash.programmed, self.bus.flash.erased)
    }

    /// Puts bytes on the cable to the board, one behind the other, from now on or behind those already on it.
    pub fn send(&mut self, bytes: &[u8]) {
        let now = self.bus.time.cycles;
        let mut end = self.bus.usart.last_arrival().unwrap_or(now).max(now);
        for byte in bytes {
            // Ten bits; rounded up, so that no byte is too early.
            end += (10 * self.bus.time.hz()).div_ceil(self.baud);
            self.bus.usart.arrive(*byte, end);
        }
        self.bus.attend();
    }

    /// Takes the bytes that the board has sent.
    pub fn take_sent(&mut self) -> Vec<u8> {
        self.bus.usart.sent.drain(..).map(|(byte, _)| byte).collect()
    }

    /// Virtual time, nanoseconds since power-up.
    pub fn now_ns(&self) -> u64 {
        self.bus.time.ns()
    }

    /// Rules that were broken.
    pub fn findings(&self) -> &[Finding] {
        &self.bus.findings.0
    }

    /// Resets since power-up.
    pub fn resets(&self) -> &[Reset] {
        &self.resets
    }

    /// Results that the firmware has read from the ADC.
    pub fn readings(&self) -> &[Reading] {
        &self.bus.adc.readings
    }

    /// When START rose first, nanoseconds since power-up.
    pub fn started_ns(&self) -> Option<u64> {
        self.bus.adc.started_ns
    }

    /// The simulated ADC.
    pub fn adc(&mut self) -> &mut Ads1258 {
        &mut self.bus.adc.chip
    }

    /// Begins or ends a fault of the ADC now.
    pub fn adc_fault(&mut self, fault: Fault, begins: bool) {
        let chip = &mut self.bus.adc.chip;
        chip.advance_to(self.bus.time.ns());
        if begins {
            chip.begin_fault(fault)
        } else {
            chip.end_fault(fault)
        }
        self.bus.expect_drdy();
        self.bus.attend();
    }

    /// Instructions executed.
    pub fn instructions(&self) -> u64 {
        self.cpu.instructions
    }

    /// Processor cycles since power-up, and those of them asleep.
    pub fn cycles(&self) -> (u64, u64) {
        (self.bus.time.cycles, self.asleep_cycles)
    }

    /// How an interrupt was served.
    pub fn served(&self, irq: u16) -> Served {
        self.bus.scs.served[usize::from(FIRST_IRQ + irq)]
    }

    /// Forgets how interrupts were served.
    pub fn forget_served(&mut self) {
        self.bus.scs.served.fill(Served::default());
    }

    /// Bytes from the cable: lost to overruns, arrived while the receiver was off, and taken by the firmware.
    pub fn received(&self) -> [u64; 3] {
        [self.bus.usart.overruns, self.bus.usart.unheard, self.bus.usart.taken]
    }
}
