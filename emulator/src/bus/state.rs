//! State of the parts on the bus.

use crate::board::Wiring;
use crate::findings::{Findings, Rule};
use crate::peripherals::adc::Adc;
use crate::peripherals::dac::Dac;
use crate::peripherals::dma::Stream;
use crate::peripherals::encoder::Encoder;
use crate::peripherals::exti::{Exti, Syscfg};
use crate::peripherals::flash::Flash;
use crate::peripherals::gpio::Gpio;
use crate::peripherals::iwdg::Iwdg;
use crate::peripherals::own_adc::OwnAdc;
use crate::peripherals::pwm::Pwm;
use crate::peripherals::rcc::{Clocks, HSI_HZ, Rcc, ResetCause};
use crate::peripherals::small::{Dbgmcu, Pwr};
use crate::peripherals::spi::Spi;
use crate::peripherals::timer::Timer;
use crate::peripherals::usart::Usart;
use crate::scs::Scs;
use crate::stop::{Failure, Stop};
use crate::time::Time;
use hal_mock::{Amplifier, Constant, Stm32Adc};

/// Size of main RAM, bytes (DS8626, DS10693).
const RAM_BYTES: usize = 128 << 10;

pub(crate) struct Bus {
    pub time: Time,
    /// Cycle from which peripherals and interrupts must be polled.
    pub deadline: u64,
    pub pc: u32,
    pub ram: Vec<u8>,
    pub ccm: Vec<u8>,
    pub flash: Flash,
    pub scs: Scs,
    pub wiring: Wiring,
    pub clocks: Clocks,
    pub rcc: Rcc,
    pub gpio: [Gpio; 3],
    pub exti: Exti,
    pub syscfg: Syscfg,
    pub spi: Spi,
    pub usart: Usart,
    pub tim2: Timer,
    pub tim4: Timer,
    pub tim6: Timer,
    pub tim10: Pwm,
    pub encoder: Encoder,
    pub dac: Dac,
    pub iwdg: Iwdg,
    pub pwr: Pwr,
    pub dbgmcu: Dbgmcu,
    pub adc: Adc,
    pub clkio_is_wired: bool,
    /// Frequency of the clock pin at the latest check of its rules, hertz.
    pub clock_output_hz: u32,
    pub own_adc: OwnAdc,
    pub dma: Stream,
    /// Stream that fetches bytes from the serial line.
    pub line_dma: Stream,
    /// Sensors at the pins of the on-chip ADC.
    pub sensors: Stm32Adc,
    /// Time of the sensors' first sample, nanoseconds since power-up.
    pub scene_zero_ns: Option<u64>,
    pub findings: Findings,
    pub has_bitten: bool,
    /// True if the processor's clock has stopped: its oscillator failed without a clock security
    /// system.
    pub has_stopped: bool,
    /// True if the flash has changed, so that decoded instructions are out of date.
    pub flash_changed: bool,
    /// True if the serial line's pins were checked since it was switched on.
    pub is_line_checked: bool,
    /// Cycle at which USB requests its interrupt.
    pub usb_rises: Option<u64>,
    pub drdy_falls: Option<u64>,
    /// True if the next read of the microsecond counter is the timestamp of a DRDY edge.
    pub dates_edge: bool,
}

impl Bus {
    pub fn new(wiring: Wiring, adc: Adc, option_bytes: u32) -> Self {
        Self {
            time: Time::new(HSI_HZ),
            deadline: 0,
            pc: 0,
            // RAM has arbitrary content after power-up.
            ram: (0..RAM_BYTES)
                .map(|at| (at as u32).wrapping_mul(0x9E37_79B9).to_be_bytes()[0])
                .collect(),
            ccm: vec![0x55; wiring.ccm_bytes],
            flash: Flash::new(wiring.flash_bytes, option_bytes),
            scs: Scs::new(),
            wiring,
            clocks: Clocks {
                hclk: HSI_HZ,
                pclk: [HSI_HZ; 2],
            },
            rcc: Rcc::new(ResetCause::Power, wiring.has_dckcfgr),
            gpio: [Gpio::new(0), Gpio::new(1), Gpio::new(2)],
            exti: Exti::default(),
            syscfg: Syscfg::default(),
            spi: Spi::default(),
            usart: Usart::new(),
            tim2: Timer::new(u32::MAX),
            tim4: Timer::new(u16::MAX as u32),
            tim6: Timer::new(u16::MAX as u32),
            tim10: Pwm::default(),
            encoder: Encoder::new(),
            dac: Dac::default(),
            iwdg: Iwdg::new(),
            pwr: Pwr::new(wiring.pwr_cr),
            dbgmcu: Dbgmcu::new(wiring.id_code),
            adc,
            clkio_is_wired: false,
            clock_output_hz: 0,
            own_adc: OwnAdc::default(),
            dma: Stream::adc1(),
            line_dma: Stream::receiver(wiring.usart),
            sensors: Stm32Adc::new(Box::new(Constant::default()), Amplifier::Bare, 1),
            scene_zero_ns: None,
            findings: Findings::default(),
            has_bitten: false,
            has_stopped: false,
            flash_changed: false,
            is_line_checked: false,
            usb_rises: None,
            drdy_falls: None,
            dates_edge: false,
        }
    }

    /// Returns to the state after a reset. Memory, the ADC, the cable and the time are unchanged.
    pub fn reset(&mut self, cause: ResetCause) {
        self.rcc.reset(cause);
        self.scs.reset();
        self.flash.reset();
        self.gpio.iter_mut().for_each(Gpio::reset);
        self.exti = Exti::default();
        self.syscfg = Syscfg::default();
        self.spi.reset();
        self.usart.reset();
        self.tim2.reset();
        self.tim4.reset();
        self.tim6.reset();
        self.tim10 = Pwm::default();
        self.encoder.reset();
        self.dac.reset(self.time.ns());
        self.own_adc.reset();
        self.dma.reset();
        self.line_dma.reset();
        self.iwdg.reset();
        self.pwr = Pwr::new(self.wiring.pwr_cr);
        (self.has_bitten, self.has_stopped) = (false, false);
        (self.dates_edge, self.is_line_checked) = (false, false);
        self.change_clocks();
        self.pins_changed();
        self.attend();
    }

    /// Makes the loop poll peripherals and interrupts before the next instruction.
    pub fn attend(&mut self) {
        self.deadline = 0;
    }

    /// Returns the error for an access that is not modelled, which ends the run.
    pub fn unmodelled(&self, what: &str, address: u32) -> Stop {
        let what = format!("{what} that is not modelled");
        Stop::Failed(Box::new(Failure {
            what,
            address,
            pc: self.pc,
            at_ns: self.time.ns(),
        }))
    }

    pub fn note(&mut self, broken: Option<(Rule, String)>) {
        if let Some((rule, detail)) = broken {
            self.broke(rule, detail);
        }
    }

    pub fn broke(&mut self, rule: Rule, detail: impl Into<String>) {
        let (pc, at_ns) = (self.pc, self.time.ns());
        self.findings.add(rule, detail.into(), pc, at_ns);
        // `Emulator::run_to` checks the findings before the next instruction.
        self.attend();
    }
}
