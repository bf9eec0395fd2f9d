//! The main loop: instructions, events, resets, interrupts, sleep.

use super::counts::Counts;
use super::start::Start;
use crate::board::Board;
use crate::bus::Bus;
use crate::cpu::Cpu;
use crate::findings::Rule;
use crate::image::Image;
use crate::peripherals::adc::Adc;
use crate::peripherals::rcc::{HSI_HZ, ResetCause};
use crate::scs::{FIRST_IRQ, HARD_FAULT};
use crate::stop::{Failure, Stop};
use hal_mock::{Constant, Scene, Stm32Adc};

/// A reset that has happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reset {
    /// Cause of the reset.
    pub cause: ResetCause,
    /// Time of the reset, nanoseconds since power-up.
    pub at_ns: u64,
}

/// A board with its firmware, a simulated ADC and a cable.
pub struct Emulator {
    pub(super) cpu: Cpu,
    pub(crate) bus: Bus,
    pub(super) asleep_cycles: u64,
    pub(super) resets: Vec<Reset>,
    pub(super) counts: Option<Counts>,
    /// Address of the instruction before which a run ends.
    pub(super) stops_at: Option<u32>,
    stack_end: u32,
}

/// Exception number of DRDY's interrupt, line 4 of EXTI.
const EXTI4: u16 = FIRST_IRQ + 10;

/// Frequency of the internal oscillator with an error of `ppm`.
fn hsi_hz(ppm: i32) -> u64 {
    let nominal = HSI_HZ as i64;
    (nominal + nominal * i64::from(ppm) / 1_000_000).max(1) as u64
}

impl Emulator {
    /// Creates a board that has just been powered, in front of `scene`.
    pub fn new(
        board: Board,
        image: &Image,
        scene: impl Scene + 'static,
        start: Start,
    ) -> Result<Self, Box<Failure>> {
        let wiring = board.wiring();
        let mut adc = start.adc;
        if start.clkio_is_wired {
            adc.clock_hz = 0;
        }
        let (chip, sensors): (Box<dyn Scene>, Box<dyn Scene>) = if wiring.inputs.is_empty() {
            (Box::new(scene), Box::new(Constant::default()))
        } else {
            (Box::new(Constant::default()), Box::new(scene))
        };
        let mut bus = Bus::new(wiring, Adc::new(chip, adc), start.option_bytes);
        let seed = 1;
        bus.sensors = Stm32Adc::new(sensors, start.amplifier, seed);
        for (place, data) in &image.segments {
            let at = place.wrapping_sub(0x0800_0000) as usize;
            if let Some(flash) = bus.flash.bytes.get_mut(at..at + data.len()) {
                flash.copy_from_slice(data);
            }
        }
        bus.rcc.hse_is_dead = start.hse_is_dead;
        bus.rcc.hsi_hz = hsi_hz(start.hsi_ppm);
        bus.change_clocks();
        bus.spi.bsy_is_early = start.bsy_is_early;
        bus.flash.set_errors(start.flash_has_errors);
        bus.clkio_is_wired = start.clkio_is_wired;
        let mut cpu = Cpu::new(wiring.flash_bytes);
        let failed = |stop| match stop {
            Stop::Failed(failure) => failure,
            _ => Box::new(Failure {
                what: "a reset vector".into(),
                address: 0,
                pc: 0,
                at_ns: 0,
            }),
        };
        cpu.reset(&mut bus).map_err(failed)?;
        if start.after_rom_loader {
            bus.leave_as_rom_loader();
        }
        let stack_end = image.symbol("_stack_end").unwrap_or(0);
        Ok(Self {
            cpu,
            bus,
            asleep_cycles: 0,
            resets: Vec::new(),
            counts: None,
            stops_at: None,
            stack_end,
        })
    }

    /// Runs for `ns` nanoseconds of virtual time.
    pub fn run_ns(&mut self, ns: u64) -> Result<(), Box<Failure>> {
        self.run_until(self.now_ns() + ns)
    }

    /// Runs until a virtual time, nanoseconds since power-up.
    pub fn run_until(&mut self, end_ns: u64) -> Result<(), Box<Failure>> {
        while self.now_ns() < end_ns {
            self.run_once(end_ns)?;
        }
        Ok(())
    }

    /// Runs until the next event of the peripherals, including events that an instruction causes,
    /// or until [`Self::stops_at`].
    pub(super) fn run_once(&mut self, end_ns: u64) -> Result<(), Box<Failure>> {
        if self.counts.is_some() || self.stops_at.is_some() {
            self.run_some::<true>(end_ns)
        } else {
            self.run_some::<false>(end_ns)
        }
    }

    #[inline(always)]
    fn run_some<const WATCHED: bool>(&mut self, end_ns: u64) -> Result<(), Box<Failure>> {
        if self.bus.time.cycles >= self.bus.deadline && !self.look_around(end_ns)? {
            return Ok(());
        }
        loop {
            let (pc, before) = (self.cpu.pc, self.bus.time.cycles);
            let outcome = self.cpu.step(&mut self.bus);
            if WATCHED && let Some(counts) = &mut self.counts {
                counts.add(pc, self.bus.time.cycles - before);
            }
            if let Err(stop) = outcome {
                self.fault(stop)?;
            }
            let is_there = WATCHED && Some(self.cpu.pc) == self.stops_at;
            if self.bus.time.cycles >= self.bus.deadline || is_there {
                return Ok(());
            }
        }
    }

    /// Handles events, resets, interrupts and sleep between instructions. Returns true if the
    /// processor continues.
    fn look_around(&mut self, end_ns: u64) -> Result<bool, Box<Failure>> {
        self.bus.time.settle();
        if self.bus.has_stopped && !self.stand_still(end_ns) {
            return Ok(false);
        }
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
                self.bus.scs.sleep(to - self.bus.time.cycles);
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
                self.bus.broke(
                    Rule::SpuriousInterrupt,
                    format!("interrupt {irq} without a cause"),
                );
            }
            // A higher-priority exception may already be pending.
            self.bus.attend();
            return Ok(false);
        }
        Ok(true)
    }

    /// Stops everything but the watchdog while the processor has no clock. Returns true if the
    /// watchdog expires by `end_ns`.
    fn stand_still(&mut self, end_ns: u64) -> bool {
        let bite_ns = self.bus.iwdg.next_event_ns().unwrap_or(u64::MAX);
        self.bus.time.stand_still_until(bite_ns.min(end_ns));
        bite_ns <= end_ns
    }

    fn check_stack(&mut self) {
        let sp = self.cpu.r[13];
        if sp < self.stack_end {
            self.bus
                .broke(Rule::StackEnd, format!("the stack pointer is {sp:#010x}"));
        }
    }

    /// Takes a HardFault for a fault of the processor, because the firmware enables no other
    /// handler.
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
        // The handler runs even if there is no memory for its frame (DDI 0403E, B1.5.15).
        match self.cpu.enter(HARD_FAULT, &mut self.bus) {
            Err(Stop::Failed(failure)) => Err(failure),
            _ => Ok(()),
        }
    }

    /// Resets the chip. RAM, the ADC and the cable keep their state.
    pub(super) fn reset(&mut self, cause: ResetCause) -> Result<(), Box<Failure>> {
        self.resets.push(Reset {
            cause,
            at_ns: self.now_ns(),
        });
        self.bus.reset(cause);
        self.cpu.reset(&mut self.bus).map_err(|_| {
            let (what, at_ns) = ("the reset vector".to_owned(), self.now_ns());
            Box::new(Failure {
                what,
                address: 0,
                pc: 0,
                at_ns,
            })
        })
    }
}
