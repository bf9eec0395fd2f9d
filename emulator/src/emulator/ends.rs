//! The far ends of the board's cables: what a test can do to the board and observe.

use super::run::{Emulator, Reset};
use crate::board::Pin;
use crate::findings::Finding;
use crate::peripherals::adc::Reading;
use crate::peripherals::dac::Output;
use crate::peripherals::rcc::ResetCause;
use crate::processor_fault::ProcessorFault;
use crate::scs::{FIRST_IRQ, Served};
use crate::stop::Failure;
use hal_mock::{Ads1258, Fault};

/// A fault of the on-chip ADC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnAdcFault {
    /// A sample is overwritten before it is fetched.
    Overrun,
    /// A DMA transfer fails on the bus.
    Transfer,
}

const DBGMCU_CR: u32 = 4;

/// Baud rate of the PC's end of the serial line.
const BAUD: u64 = 921_600;

/// Returns the bytes of `memory`, which begins at `first`, from `address` on; none if outside.
fn from(memory: &[u8], address: u32, first: u32) -> &[u8] {
    let at = address.wrapping_sub(first) as usize;
    memory.get(at..).unwrap_or(&[])
}

impl Emulator {
    /// Presses the reset button.
    pub fn press_reset(&mut self) -> Result<(), Box<Failure>> {
        self.reset(ResetCause::Pin)
    }

    /// Injects a fault into the processor now.
    pub fn inject(&mut self, fault: ProcessorFault) {
        match fault {
            ProcessorFault::JumpTo(address) => self.cpu.pc = address & !1,
            ProcessorFault::StackPointer(address) => self.cpu.r[13] = address & !3,
            ProcessorFault::Microseconds(value) => {
                self.bus.tim2.restart(value, self.bus.time.cycles)
            }
            ProcessorFault::Mask(irq) => self.bus.scs.mask(irq),
            ProcessorFault::Unmask(irq) => self.bus.scs.unmask(irq),
            ProcessorFault::Debugger(value) => {
                let _ = self.bus.dbgmcu.write(DBGMCU_CR, value);
            }
            ProcessorFault::OscillatorDies => self.bus.rcc.hse_dies = true,
            ProcessorFault::OscillatorStops => self.bus.stop_oscillator(),
        }
        // A sleeping processor would notice the fault only at its next interrupt.
        self.cpu.is_asleep = false;
        self.bus.attend();
    }

    /// Cuts the power of the flash after `words` more words: later words and erases are lost.
    pub fn cut_flash_after(&mut self, words: u64) {
        self.bus.flash.words_left = Some(words);
    }

    /// Cuts the power of the flash within the next erase. `remains` computes each byte left in the
    /// sector from its offset and old content; the content after an interrupted erase is undefined
    /// (RM0090, 3.6).
    pub fn cut_erase(&mut self, remains: fn(usize, u8) -> u8) {
        self.bus.flash.erase_remains = Some(remains);
    }

    /// Switches the power off and on: RAM loses its content, the flash and the cable do not.
    pub fn cycle_power(&mut self) -> Result<(), Box<Failure>> {
        self.bus.ram.fill(0xA5);
        (self.bus.flash.words_left, self.bus.flash.erase_remains) = (None, None);
        self.reset(ResetCause::Power)
    }

    /// Flash from `address` on, as a programmer reads it.
    pub fn flash(&self, address: u32) -> &[u8] {
        from(&self.bus.flash.bytes, address, 0x0800_0000)
    }

    /// Main RAM from `address` on, as a debugger reads it.
    pub fn ram(&self, address: u32) -> &[u8] {
        from(&self.bus.ram, address, 0x2000_0000)
    }

    /// Overwrites flash, as a programmer does.
    pub fn overwrite_flash(&mut self, address: u32, bytes: &[u8]) {
        let at = address.wrapping_sub(0x0800_0000) as usize;
        if let Some(place) = self.bus.flash.bytes.get_mut(at..at + bytes.len()) {
            place.copy_from_slice(bytes);
            self.cpu.forget();
        }
    }

    /// Numbers of words programmed and sectors erased.
    pub fn flash_counts(&self) -> (u64, u64) {
        (self.bus.flash.programmed, self.bus.flash.erased)
    }

    /// Queues bytes on the cable to the board, after those already on it.
    pub fn send(&mut self, bytes: &[u8]) {
        if self.bus.has_stopped {
            self.bus.usart.unheard += bytes.len() as u64;
            return;
        }
        let now = self.bus.time.cycles;
        let mut end = self.bus.usart.last_arrival().unwrap_or(now).max(now);
        for byte in bytes {
            // A byte takes ten bits. Round up, so that none is early.
            end += (10 * self.bus.time.hz()).div_ceil(BAUD);
            self.bus.usart.arrive(*byte, end);
        }
        self.bus.attend();
    }

    /// Takes the bytes that the board has sent.
    pub fn take_sent(&mut self) -> Vec<u8> {
        let timed = self.take_sent_timed();
        timed.into_iter().map(|(byte, _)| byte).collect()
    }

    /// Takes the bytes that the board has sent, with the time at which each ended, nanoseconds
    /// since power-up. The processor's clock must not have changed since they were sent.
    pub fn take_sent_timed(&mut self) -> Vec<(u8, u64)> {
        let (cycles, hz, now_ns) = (self.bus.time.cycles, self.bus.time.hz(), self.now_ns());
        let ago_ns = |end: u64| cycles.saturating_sub(end) * 1_000_000_000 / hz;
        let sent = self.bus.usart.sent.drain(..);
        sent.map(|(byte, end)| (byte, now_ns.saturating_sub(ago_ns(end))))
            .collect()
    }

    /// Virtual time, nanoseconds since power-up.
    pub fn now_ns(&self) -> u64 {
        self.bus.time.ns()
    }

    /// Broken rules.
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

    /// Number of results that the firmware read only once before the next was ready; the latest
    /// result is not counted.
    pub fn read_once(&self) -> u64 {
        self.bus.adc.read_once
    }

    /// Number of results that at least one read received unaltered. A result read only once counts
    /// only while it is the latest.
    pub fn arrived(&self) -> u64 {
        self.bus.adc.arrived
    }

    /// Takes the results read since the last call.
    pub fn take_readings(&mut self) -> Vec<Reading> {
        std::mem::take(&mut self.bus.adc.readings)
    }

    /// Time of the first rising START, nanoseconds since power-up.
    pub fn started_ns(&self) -> Option<u64> {
        self.bus.adc.started_ns
    }

    /// The simulated ADC.
    pub fn adc(&mut self) -> &mut Ads1258 {
        &mut self.bus.adc.chip
    }

    /// Frequency of the clock that the board outputs for the ADC, hertz; 0 without a clock.
    pub fn adc_clock_hz(&self) -> u32 {
        self.bus.clock_output_hz
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

    /// Injects a fault into the on-chip ADC now.
    pub fn own_adc_fault(&mut self, fault: OwnAdcFault) {
        match fault {
            OwnAdcFault::Overrun => self.bus.own_adc.overrun(),
            OwnAdcFault::Transfer => self.bus.dma.fail(),
        }
        self.bus.attend();
    }

    /// Time of the first sample of the on-chip ADC, nanoseconds since power-up.
    pub fn sensors_zero_ns(&self) -> Option<u64> {
        self.bus.scene_zero_ns
    }

    /// Moves the encoder by hand from now on: `place` returns the position in counts at a time in
    /// nanoseconds since power-up.
    pub fn move_hand(&mut self, place: impl Fn(u64) -> i64 + 'static) {
        let now_ns = self.bus.time.ns();
        let jump = place(now_ns) - (self.bus.encoder.hand)(now_ns);
        self.bus.encoder.hand = Box::new(move |ns| place(ns) - jump);
    }

    /// Times at which the firmware read the encoder, nanoseconds since power-up.
    pub fn encoder_reads_ns(&self) -> &[u64] {
        &self.bus.encoder.reads_ns
    }

    /// Voltages of the DAC's pin so far.
    pub fn outputs(&self) -> &[Output] {
        &self.bus.dac.outputs
    }

    /// Instructions executed.
    pub fn instructions(&self) -> u64 {
        self.cpu.instructions
    }

    /// Processor cycles since power-up: in total, and asleep.
    pub fn cycles(&self) -> (u64, u64) {
        (self.bus.time.cycles, self.asleep_cycles)
    }

    /// DBGMCU_CR: clocks that continue during sleep, for a debugger.
    pub fn debug_control(&self) -> Option<u32> {
        self.bus.dbgmcu.read(DBGMCU_CR)
    }

    /// True if ADCDC1 is set and flash prefetch is off, which lowers the noise of the on-chip ADC
    /// (AN4073, option 1).
    pub fn has_quiet_adc(&self) -> bool {
        self.bus.pwr.has_adcdc1() && !self.bus.flash.prefetches()
    }

    /// Registers R0 to R15 of the core; R15 is the address of the next instruction.
    pub fn registers(&self) -> [u32; 16] {
        let mut registers = [0; 16];
        registers.copy_from_slice(&self.cpu.r[..16]);
        registers[15] = self.cpu.pc;
        registers
    }

    /// Counts of an interrupt up to now.
    pub fn served(&self, irq: u16) -> Served {
        self.counts_of(FIRST_IRQ + irq)
    }

    /// Counts of the code outside interrupts up to now, without sleep; only `instructions` and
    /// `own_cycles` are meaningful.
    pub fn thread(&self) -> Served {
        self.counts_of(0)
    }

    fn counts_of(&self, number: u16) -> Served {
        let scs = &self.bus.scs;
        let mut served = scs.served[usize::from(number)];
        if self.cpu.ipsr == number {
            let [cycles, instructions] = scs.since_charged(self.now_counts());
            served.own_cycles += cycles;
            served.instructions += instructions;
        }
        served
    }

    fn now_counts(&self) -> [u64; 2] {
        [self.bus.time.cycles, self.cpu.instructions]
    }

    /// Clears the counts of all interrupts.
    pub fn forget_served(&mut self) {
        self.bus.scs.charge(self.cpu.ipsr, self.now_counts());
        self.bus.scs.served.fill(Served::default());
    }

    /// Clears the readings of the ADC, reads of the encoder and changes of the DAC's output: in a
    /// run of days they would fill the memory.
    pub fn forget_history(&mut self) {
        self.bus.adc.readings.clear();
        self.bus.encoder.reads_ns.clear();
        self.bus.dac.outputs.clear();
    }

    /// Level that the firmware drives on a pin; `None` if the pin is not an output.
    pub fn pin(&self, pin: Pin) -> Option<bool> {
        self.bus.port(pin).driven(pin.number())
    }

    /// Sets the level of a pin from outside. A falling edge reaches EXTI. DRDY's pin follows the
    /// simulated ADC instead.
    pub fn set_pin(&mut self, pin: Pin, high: bool) {
        self.bus.set_outside(pin, high);
        self.bus.attend();
    }

    /// Numbers of bytes from the cable: lost to overruns, arrived while the receiver was off, taken
    /// by the firmware.
    pub fn received(&self) -> [u64; 3] {
        [
            self.bus.usart.overruns,
            self.bus.usart.unheard,
            self.bus.usart.taken,
        ]
    }
}
