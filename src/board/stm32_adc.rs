//! The STM32's own ADC as a [`converter::Converter`]: ADC1 scans the inputs continuously, DMA2
//! fills a buffer, and its interrupt sums each half of the buffer until a frame is complete.
//!
//! Clocks, resets, pins and the DMA's stream come from the HAL (0.23). Its `Adc` is not used: the
//! constructor converts the internal reference right after switching the ADC on, before that has
//! settled, and panics if there is no conversion. Its `Transfer` is not used either: it owns
//! buffers of a fixed length and swaps them at each end, but here the length of a half depends on
//! the plan.

use super::CLOCKS;
use super::chosen::{INPUTS, SCANS, channels};
use super::device::Interrupt as Task;
use core::sync::atomic::Ordering::Relaxed;
use core::sync::atomic::{AtomicBool, AtomicU16};
use embedded_hal::delay::DelayNs;
use ridgetone_finger::Wiring;
use ridgetone_finger::converter::oversampled::{Buffer, Filled, HALF, Oversampler};
use ridgetone_finger::converter::{self, Facts, OnboardPlan, REGISTERS, Sample, Scanned, Tag};
use ridgetone_finger::tasks::DrdyPin;
use ridgetone_proto::plan::{Plan, PlanError};
use stm32f4xx_hal::dma::config::Priority;
use stm32f4xx_hal::dma::traits::{DmaFlagExt, Stream};
use stm32f4xx_hal::dma::{DmaChannel, DmaDataSize, DmaDirection, Stream0, StreamsTuple};
use stm32f4xx_hal::gpio::{Analog, Pin};
use stm32f4xx_hal::hal_02::adc::Channel;
use stm32f4xx_hal::pac::{ADC_COMMON, ADC1, DMA2, FLASH, Interrupt, NVIC};
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};
use stm32f4xx_hal::{ClearFlags, ReadFlags, interrupt};

/// ADC_CCR: ADCPRE, divides by 4.
const CCR: u32 = 1 << 16;
/// Clock of the ADC, megahertz, at most 36 (ADC characteristics of the datasheets).
const CLOCK_MHZ: u8 = (CLOCKS.apb2_mhz / 4) as u8;
const _: () = assert!(CLOCK_MHZ <= 36 && CLOCKS.apb2_mhz.is_multiple_of(4));
/// SMP of each channel: 56 periods.
const SMP: u32 = 3;
/// ADC_CR1: SCAN. ADC_CR2: DDS, DMA, CONT; ADON; SWSTART.
const CR1: u32 = 1 << 8;
const CR2: u32 = 1 << 9 | 1 << 8 | 1 << 1;
const ADON: u32 = 1;
const SWSTART: u32 = 1 << 30;
/// ADC_SR: OVR.
const OVR: u32 = 1 << 5;
/// Time from ADON to the first conversion, microseconds: tSTAB, at most 3.
const SETTLING_US: u32 = 3;
/// Maximum number of reads of the stream's EN while its last transfer ends, which takes a few
/// cycles.
const STOP_READS: u32 = 1000;

/// Time from power-up to the first register access, microseconds, for the inputs' filters to
/// settle.
pub const POWER_UP_US: u32 = 5_000;

static BUFFER: Buffer = [const { AtomicU16::new(0) }; 2 * HALF];
static FRAMES: Oversampler = Oversampler::new();
/// True if there is a frame that the task has not seen.
static IS_OVER: AtomicBool = AtomicBool::new(false);

/// Wiring of the ADC, whose reference is the board's supply.
pub const WIRING: Wiring = Wiring {
    converter: &Facts {
        vref_v: 3.3,
        ..Facts::of::<Converter>()
    },
};

/// Makes a pin analogue and returns its channel.
pub fn channel<const PORT: char, const NUMBER: u8>(pin: Pin<PORT, NUMBER>) -> u8
where
    Pin<PORT, NUMBER, Analog>: Channel<ADC1, ID = u8>,
{
    let _ = pin.into_analog();
    Pin::<PORT, NUMBER, Analog>::channel()
}

/// ADC1 with its channels in the order of the inputs.
pub struct Converter {
    adc: ADC1,
    common: ADC_COMMON,
    stream: Stream0<DMA2>,
    channels: [u8; INPUTS],
    plan: OnboardPlan,
    /// Index of the scan's input to read next.
    at: u8,
    is_new: bool,
}

impl Converter {
    /// Bit k: input k exists.
    const PINS: u16 = ((1u32 << INPUTS) - 1) as u16;

    /// Switches the clocks on. The ADC stays off.
    pub fn new(adc: ADC1, common: ADC_COMMON, dma: DMA2, rcc: &mut Rcc) -> Self {
        quieten(rcc);
        ADC1::enable(rcc);
        let StreamsTuple(stream, ..) = StreamsTuple::new(dma, rcc);
        Self {
            adc,
            common,
            stream,
            channels: channels(),
            plan: OnboardPlan {
                inputs: 0,
                scans: 0,
                clock_mhz: CLOCK_MHZ,
            },
            at: 0,
            is_new: false,
        }
    }

    /// SQR1 to SQR3: the scan's channels, six to a register, the first in SQR3; SQR1 also has their
    /// number.
    fn sequence(&self) -> [u32; 3] {
        let mut registers = [self.plan.inputs.count_ones().saturating_sub(1) << 20, 0, 0];
        for (at, channel) in self.scanned().map(|(_, channel)| channel).enumerate() {
            if let Some(register) = registers.iter_mut().rev().nth(at / 6) {
                *register |= u32::from(channel) << (5 * (at % 6));
            }
        }
        registers
    }

    fn scanned(&self) -> impl Iterator<Item = (u8, u8)> {
        let inputs = (0..).zip(self.channels);
        inputs.filter(|(input, _)| self.plan.inputs >> input & 1 == 1)
    }

    /// Configures the stream, which must be off.
    fn set_up_stream(&mut self, half: usize) {
        let Self { adc, stream, .. } = self;
        stream.clear_all_flags();
        stream.set_channel(DmaChannel::Channel0);
        stream.set_direction(DmaDirection::PeripheralToMemory);
        stream.set_peripheral_address(adc.dr().as_ptr() as u32);
        stream.set_memory_address(BUFFER.as_ptr() as u32);
        stream.set_number_of_transfers((2 * half) as u16);
        // SAFETY: both sides are half words: DR's twelve bits, and the buffer's elements.
        unsafe {
            stream.set_memory_size(DmaDataSize::HalfWord);
            stream.set_peripheral_size(DmaDataSize::HalfWord);
        }
        stream.set_memory_increment(true);
        stream.set_circular_mode(true);
        stream.set_priority(Priority::High);
        stream.listen_half_transfer();
        stream.listen_transfer_complete();
    }

    /// True if the stream is on and no sample was missed.
    fn runs(&self) -> bool {
        let flags = self.stream.flags();
        self.stream.is_enabled()
            && !flags.is_transfer_error()
            && !flags.is_direct_mode_error()
            && self.adc.sr().read().bits() & OVR == 0
    }

    /// True if the registers have the values written to them.
    fn holds(&self) -> bool {
        let Self { adc, common, .. } = self;
        let found = [
            adc.cr1().read().bits(),
            // SWSTART is cleared when the conversion starts.
            adc.cr2().read().bits() & !SWSTART,
            adc.smpr1().read().bits(),
            adc.smpr2().read().bits(),
            adc.sqr1().read().bits(),
            adc.sqr2().read().bits(),
            adc.sqr3().read().bits(),
            common.ccr().read().bits(),
        ];
        let ([smpr1, smpr2], [sqr1, sqr2, sqr3]) = (sample_times(), self.sequence());
        found == [CR1, CR2 | ADON, smpr1, smpr2, sqr1, sqr2, sqr3, CCR]
    }
}

/// Reduces the noise that the flash adds to the samples: switches prefetch off and sets ADCDC1,
/// which requires prefetch off and a supply of at least 2.7 V (AN4073, option 1; RM0390, PWR_CR).
/// Option 2, ADC1DC2, is for ADC clocks of 30 MHz or more, and excludes ADCDC1 (RM0390,
/// SYSCFG_PMC). The STM32F405 has neither bit (crate `stm32f4` 0.16).
#[cfg_attr(
    feature = "feather-f405-adc",
    expect(unused_variables, reason = "PWR's clock")
)]
fn quieten(rcc: &mut Rcc) {
    // SAFETY: no task runs yet, and the other bits are unchanged.
    unsafe { (*FLASH::ptr()).acr().modify(|_, w| w.prften().clear_bit()) };
    #[cfg(not(feature = "feather-f405-adc"))]
    {
        use stm32f4xx_hal::pac::PWR;
        PWR::enable(rcc);
        // SAFETY: no task runs yet, and the other bits are unchanged.
        unsafe { (*PWR::ptr()).cr().modify(|_, w| w.adcdc1().set_bit()) };
    }
}

/// Values of SMPR1 (channels 10 to 18) and SMPR2 (channels 0 to 9).
const fn sample_times() -> [u32; 2] {
    [SMP * 0o111_111_111, SMP * 0o1_111_111_111]
}

impl converter::Converter for Converter {
    const NAME: &'static str = "STM32's ADC";
    const DEFAULT_PLAN: Plan = OnboardPlan {
        inputs: Self::PINS,
        scans: SCANS,
        clock_mhz: CLOCK_MHZ,
    }
    .plan();

    fn check(plan: &Plan) -> Result<(), PlanError> {
        OnboardPlan::check(plan, Self::PINS, CLOCK_MHZ..=CLOCK_MHZ)
    }

    fn stop(&mut self) -> bool {
        // No DMA requests follow, so the stream ends at once.
        self.adc.cr2().reset();
        // SAFETY: the buffer's elements are valid whenever the stream ends.
        unsafe { self.stream.disable() };
        (0..STOP_READS).any(|_| !self.stream.is_enabled())
    }

    fn set_up(&mut self, plan: &Plan, _: Scanned, wait: &mut impl DelayNs) -> bool {
        self.plan = OnboardPlan::of(plan);
        let Some(averaging) = self.plan.averaging() else {
            return false;
        };
        // SAFETY: the tasks reset nothing else, and `init` runs before them.
        unsafe { ADC1::reset_unchecked() };
        let [smpr1, smpr2] = sample_times();
        let [sqr1, sqr2, sqr3] = self.sequence();
        let Self { adc, common, .. } = self;
        // SAFETY: values of RM0090, 13.13: see the constants.
        unsafe {
            common.ccr().write(|w| w.bits(CCR));
            adc.cr1().write(|w| w.bits(CR1));
            adc.smpr1().write(|w| w.bits(smpr1));
            adc.smpr2().write(|w| w.bits(smpr2));
            adc.sqr1().write(|w| w.bits(sqr1));
            adc.sqr2().write(|w| w.bits(sqr2));
            adc.sqr3().write(|w| w.bits(sqr3));
            adc.cr2().write(|w| w.bits(CR2 | ADON));
        }
        wait.delay_us(SETTLING_US);
        self.set_up_stream(averaging.half());
        self.holds() && !self.stream.is_enabled()
    }

    fn start(&mut self) -> bool {
        let Some(averaging) = self.plan.averaging() else {
            return false;
        };
        FRAMES.begin(&averaging);
        IS_OVER.store(false, Relaxed);
        (self.at, self.is_new) = (0, true);
        // SAFETY: the buffer is a static of atomics, which may be written at any time.
        unsafe { self.stream.enable() };
        // SAFETY: see `set_up`.
        self.adc
            .cr2()
            .write(|w| unsafe { w.bits(CR2 | ADON | SWSTART) });
        self.stream.is_enabled()
    }

    fn read(&mut self) -> Option<Sample> {
        let at = usize::from(self.at);
        let (code, is_overloaded) = FRAMES.code(at)?;
        let (input, _) = self.scanned().nth(at)?;
        let mut tag = Tag::of_input(input);
        if is_overloaded {
            tag.0 |= Tag::OVERLOAD;
        }
        if !core::mem::take(&mut self.is_new) {
            tag.0 &= !Tag::NEW;
        }
        Some(Sample { tag, code })
    }

    fn go_on(&mut self) -> bool {
        let next = self.at + 1;
        let has_next = u32::from(next) < self.plan.inputs.count_ones();
        self.at = if has_next { next } else { 0 };
        self.is_new = true;
        has_next
    }

    fn behind_us(&self) -> u32 {
        self.plan
            .averaging()
            .map_or(0, |averaging| averaging.middle_us())
    }

    fn is_as_set_up(&mut self) -> bool {
        self.runs() && self.holds()
    }

    /// Returns SR; SCAN and RES of CR1; DMA and ADON of CR2; L; ADCPRE; flags and EN of the stream;
    /// and the number of transfers left.
    fn registers(&mut self) -> Option<[u8; REGISTERS]> {
        let Self { adc, common, .. } = self;
        let (cr1, cr2) = (adc.cr1().read().bits(), adc.cr2().read().bits());
        let [left_high, left_low] = self.stream.number_of_transfers().to_be_bytes();
        Some([
            adc.sr().read().bits() as u8,
            (cr1 >> 8) as u8,
            (cr1 >> 24) as u8,
            (cr2 >> 8) as u8,
            cr2 as u8,
            (adc.sqr1().read().bits() >> 16) as u8,
            (common.ccr().read().bits() >> 16) as u8,
            self.stream.flags().bits() as u8 | u8::from(self.stream.is_enabled()) << 7,
            left_high,
            left_low,
        ])
    }

    fn min_period_us(&mut self) -> u32 {
        // A stopped ADC makes no conversions.
        let running = self.plan.averaging().filter(|_| self.runs());
        running.map_or(u32::MAX, |averaging| averaging.input_us())
    }
}

/// Signals the end of a frame, in place of an edge of DRDY.
pub struct Drdy;

impl Drdy {
    /// Enables the DMA's interrupt, at the priority of the task to which it is forwarded.
    pub fn new(nvic: &mut NVIC) -> Self {
        // SAFETY: neither interrupt preempts the other: RTIC has set the priority before it calls
        // `init`, and serves no interrupt until `init` has ended.
        unsafe {
            nvic.set_priority(Interrupt::DMA2_STREAM0, NVIC::get_priority(Task::DRDY));
            NVIC::unmask(Interrupt::DMA2_STREAM0);
        }
        Self
    }
}

impl DrdyPin for Drdy {
    #[inline(always)]
    fn acknowledge(&mut self) -> Option<bool> {
        IS_OVER.swap(false, Relaxed).then_some(true)
    }

    fn edge_us(&self) -> u32 {
        FRAMES.frame_us()
    }

    fn mute(&mut self) {
        NVIC::mask(Interrupt::DMA2_STREAM0);
    }

    fn unmute(&mut self) {
        IS_OVER.store(false, Relaxed);
        // SAFETY: the task is not in a critical section that masks it.
        unsafe { NVIC::unmask(Interrupt::DMA2_STREAM0) };
    }
}

/// Sums the filled half of the buffer, and runs the task once a frame is complete.
#[interrupt]
fn DMA2_STREAM0() {
    // RTIC defines its handlers with Rust's ABI.
    unsafe extern "Rust" {
        fn DRDY();
    }
    let now_us = super::clock::now_us();
    // SAFETY: reads and clears two flags; the converter, at the same priority, uses other flags.
    let dma = unsafe { DMA2::steal() };
    let flags = dma.lisr().read();
    let filled = match (flags.htif0().bit_is_set(), flags.tcif0().bit_is_set()) {
        (true, false) => Filled::First,
        (false, true) => Filled::Second,
        (true, true) => Filled::Overwritten,
        (false, false) => return,
    };
    dma.lifcr().write(|w| w.chtif0().clear().ctcif0().clear());
    // The write must reach the DMA before the handler returns, or the interrupt fires twice.
    cortex_m::asm::dsb();
    if FRAMES.take(&BUFFER, filled, now_us) {
        IS_OVER.store(true, Relaxed);
        // SAFETY: the task cannot run at the same time: see `Drdy::new`.
        unsafe { DRDY() }
    }
}
