//! Adafruit Feather STM32F405 Express (product 4382), 168 MHz from its 12 MHz crystal.
//!
//! | ADS1258 | Feather | STM32F405 | |
//! |---|---|---|---|
//! | CS | A0 | PA4 | output, high at rest |
//! | SCLK | A1 | PA5 | SPI1 SCK, AF5, 5.25 MHz |
//! | DOUT | A2 | PA6 | SPI1 MISO, AF5 |
//! | DIN | A3 | PA7 | SPI1 MOSI, AF5 |
//! | DRDY | A4 | PC4 | EXTI4, falling edge |
//! | START | A5 | PC5 | output, low until the registers are written |
//! | RESET | D6 | PC6 | output, high at rest |
//!
//! Telemetry leaves on TX (PB10, USART3, AF7), orders come on RX (PB11), both at 921600 baud, 8N1; the baud rate
//! generator divides 42 MHz by 46 and is 0.93 % slow, which every receiver tolerates (8N1 allows about 4 %).
//!
//! The time of a DRDY edge is read first thing in its interrupt, so it is late by the interrupt's
//! entry: 12 cycles (0.07 us), up to a few microseconds when something masked interrupts. A timer's
//! input capture would be exact, but PC4 is on no timer channel of this chip; wiring DRDY to D6
//! (PC6, TIM3 CH1 or TIM8 CH1) and RESET to A4 would allow it.

use super::line::LINE_BAUD;
use super::{Board, Line, SettingsFlash, crash};
use core::convert::Infallible;
use defmt_rtt as _;
use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use ridgetone::boot::{Boot, Record, ResetCause};
use ridgetone::vitals::WATCHDOG_S;
use stm32f4xx_hal::gpio::{Edge, ExtiPin, Input, Output, PA4, PC4, PC5, PC6, PinState, Pull, Speed};
use stm32f4xx_hal::pac::{self, DBGMCU, EXTI, IWDG, RCC, SPI1};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial;
use stm32f4xx_hal::spi;

/// From power-up to the first register access, microseconds: 2^18 tCLK are 16.7 ms at 15.72864 MHz,
/// and the chip's own crystal may take 150 ms to start (SBAS297G, typical after power-down).
pub const POWER_UP_US: u32 = 200_000;

/// SPI clock, hertz: 84 MHz / 16, the fastest divider below half the chip's clock (7.86 MHz).
const SPI_HZ: u32 = 5_250_000;

/// Processor cycles to let CS settle: 190 ns at 168 MHz, over 2.5 tCLK (159 ns) and 2 tCLK (127 ns).
const CS_SETTLE_CYCLES: u32 = 32;

/// Clock of the timers on APB1 in MHz: twice PCLK1.
const TIMER_MHZ: u32 = 84;

/// SPI with CS.
pub type Spi = ExclusiveDevice<spi::Spi<SPI1>, SettledCs, NoDelay>;
/// The pin START.
pub type Start = PC5<Output>;
/// The pin RESET.
pub type Reset = PC6<Output>;

/// CS that gives the chip its set-up time after each edge.
pub struct SettledCs(PA4<Output>);

impl ErrorType for SettledCs {
    type Error = Infallible;
}

impl OutputPin for SettledCs {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set_low();
        cortex_m::asm::delay(CS_SETTLE_CYCLES);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set_high();
        cortex_m::asm::delay(CS_SETTLE_CYCLES);
        Ok(())
    }
}

/// The falling edge of DRDY.
pub struct Drdy {
    pin: PC4<Input>,
    exti: EXTI,
    edge_us: u32,
}

impl Drdy {
    /// Notes the time and clears the interrupt; call it first thing. Whether DRDY has fallen, and if so, whether there
    /// is data to read.
    #[inline(always)]
    pub fn acknowledge(&mut self) -> Option<bool> {
        self.edge_us = super::now_us();
        let has_fallen = self.pin.check_interrupt();
        self.pin.clear_interrupt_pending_bit();
        // The write must have reached EXTI before the handler returns, or the interrupt fires twice.
        cortex_m::asm::dsb();
        let is_low = self.pin.is_low();
        (has_fallen || is_low).then_some(is_low)
    }

    /// No more interrupts until [`Drdy::unmute`].
    pub fn mute(&mut self) {
        self.pin.disable_interrupt(&mut self.exti);
    }

    /// Edges from now on are served again; those meanwhile are forgotten (RM0090: a masked line's pending bit is set all
    /// the same).
    pub fn unmute(&mut self) {
        self.pin.clear_interrupt_pending_bit();
        self.pin.enable_interrupt(&mut self.exti);
    }

    /// Time of the edge whose data was read after [`Drdy::acknowledge`], microseconds, wrapping.
    pub fn edge_us(&self) -> u32 {
        self.edge_us
    }
}

/// Sets the board up.
pub fn init(device: pac::Peripherals, _core: cortex_m::Peripherals) -> Board {
    // First of all: a crystal that does not start is waited for without end.
    start_watchdog(&device.IWDG, &device.DBGMCU);
    let boot = Boot { cause: take_reset_cause(&device.RCC), record: crash::take_record() };
    if let Some(Record { file, line, pc, .. }) = &boot.record {
        defmt::error!("the run before died at {=str}:{=u32}, {=u32:#010x}", file.as_str(), *line, *pc);
    }

    let clocks = Config::hse(12.MHz()).sysclk(168.MHz()).pclk1(42.MHz()).pclk2(84.MHz());
    let mut rcc = device.RCC.freeze(clocks);

    // A debugger keeps its clock and the RTT buffer its memory while the processor sleeps.
    device.DBGMCU.cr().modify(|_, w| w.dbg_sleep().set_bit().dbg_stop().set_bit().dbg_standby().set_bit());

    super::clock::start(device.TIM2, &mut rcc, TIMER_MHZ);
    super::clock::start_heartbeat(device.TIM4, &mut rcc, TIMER_MHZ);

    let gpioa = device.GPIOA.split(&mut rcc);
    let gpiob = device.GPIOB.split(&mut rcc);
    let gpioc = device.GPIOC.split(&mut rcc);

    let start = gpioc.pc5.into_push_pull_output_in_state(PinState::Low);
    let reset = gpioc.pc6.into_push_pull_output_in_state(PinState::High);
    let mut cs = gpioa.pa4.into_push_pull_output_in_state(PinState::High);
    cs.set_speed(Speed::Medium);
    let cs = SettledCs(cs);

    let mut sck = gpioa.pa5.into_alternate::<5>();
    let miso = gpioa.pa6.into_alternate::<5>();
    let mut mosi = gpioa.pa7.into_alternate::<5>();
    // The slowest setting of the pins is too slow above 4 MHz (datasheet DS8626, I/O AC characteristics).
    sck.set_speed(Speed::Medium);
    mosi.set_speed(Speed::Medium);
    let bus = spi::Spi::new(device.SPI1, (Some(sck), Some(miso), Some(mosi)), ads1258::MODE, SPI_HZ.Hz(), &mut rcc);
    // CS is infallible, so there is no error to meet.
    let spi = match ExclusiveDevice::new_no_delay(bus, cs) {
        Ok(spi) => spi,
        Err(never) => match never {},
    };

    let mut exti = device.EXTI;
    let mut syscfg = device.SYSCFG.constrain(&mut rcc);
    // Up: without a chip the line would float, and every edge of noise would cost a read.
    let mut pin = Input::new(gpioc.pc4, Pull::Up);
    pin.make_interrupt_source(&mut syscfg);
    pin.trigger_on_edge(&mut exti, Edge::Falling);
    pin.enable_interrupt(&mut exti);

    let config = serial::Config::default().baudrate(LINE_BAUD.bps());
    // Up: without a PC the line would float, and noise would be taken for bytes.
    let rx = gpiob.pb11.into_alternate::<7>().internal_resistor(Pull::Up);
    #[allow(clippy::panic, reason = "at start-up, and never: both are constants")]
    let serial = match device.USART3.serial((gpiob.pb10, rx), config, &mut rcc) {
        Ok(serial) => serial,
        // Not met at run time: the divider of a fixed baud rate from a fixed clock.
        Err(_) => panic!("USART3 cannot do {LINE_BAUD} baud"),
    };

    let flash = SettingsFlash::new(device.FLASH);
    Board { spi, start, reset, drdy: Drdy { pin, exti, edge_us: 0 }, line: Line::new(serial), boot, flash }
}

/// Starts the independent watchdog (RM0090, 21.3). It stops for a debugger that halts the processor.
fn start_watchdog(watchdog: &IWDG, debug: &DBGMCU) {
    /// Divides by 64: a tick takes 2 ms of the nominal 32 kHz.
    const PRESCALER: u16 = 4;
    const TICKS: u32 = 500 * WATCHDOG_S;
    const { assert!(TICKS <= 4095, "the counter has 12 bits") };
    debug.apb1_fz().modify(|_, w| w.dbg_iwdg_stop().set_bit());
    // SAFETY: the keys that start it and open its registers.
    watchdog.kr().write(|w| unsafe { w.bits(0xcccc) });
    watchdog.kr().write(|w| unsafe { w.bits(0x5555) });
    // SAFETY: 0 to 6 are allowed.
    watchdog.pr().write(|w| unsafe { w.bits(PRESCALER) });
    // SAFETY: 12 bits, see above.
    watchdog.rlr().write(|w| unsafe { w.bits(TICKS as u16) });
    // Both values take some of its ticks to arrive; fed before, it would start from the old one.
    while watchdog.sr().read().bits() != 0 {}
    feed_watchdog();
}

/// Puts off the reset by the watchdog.
pub fn feed_watchdog() {
    // SAFETY: the key that reloads; it does nothing else, so no owner can mind.
    unsafe { (*IWDG::ptr()).kr().write(|w| w.bits(0xaaaa)) };
}

/// What the processor was reset by. The flags are cleared, or they would pile up.
fn take_reset_cause(rcc: &RCC) -> ResetCause {
    let flags = rcc.csr().read().bits();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    ResetCause::from_flags(flags)
}

/// Keeps what is known of the end for the next run's greeting and log, and starts that. Nothing is logged here: the panic
/// may come from the log.
pub fn die(record: &Record) -> ! {
    crash::keep(record);
    cortex_m::peripheral::SCB::sys_reset()
}

/// Formatting the message would take 9 KB of flash.
#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    die(&crash::record_of(info))
}

/// Sleeps until an interrupt is pending, masked or not.
pub fn sleep() {
    cortex_m::asm::wfi();
}

/// A board's signal never ends.
pub const fn ended() -> bool {
    false
}

/// Resets the processor.
pub fn restart() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}

/// Never called, as [`ended`] is never true.
pub const fn leave() {}
