//! A complete finger in one loop, on a Nucleo-F446RE: conversions in, contacts and frequencies out
//! as text on its serial port, 921600 baud. It has no settings, protocol or RTIC, and reads nothing
//! during a fit. It reports the number of conversions lost, which the priorities in `main.rs`
//! avoid.
#![no_std]
#![no_main]

use ads1258::{Ads1258, MODE, SettledCs};
use core::fmt::Write;
use defmt_rtt as _;
use embedded_hal::delay::DelayNs;
use embedded_hal_bus::spi::ExclusiveDevice;
use ridgetone_finger::{Detector, Diagnostics, Estimator, Outputs, Ring, TimedConversion};
use ridgetone_finger::{WindowFit, converter::SCAN};
use ridgetone_proto::{settings::Settings, telemetry::Event};
use ridgetone_tone::Fitter;
use stm32f4xx_hal::{gpio::Speed, pac, prelude::*, rcc, spi::Spi};

/// SPI clock in Hz, at most half of the chip's clock.
const SCLK_HZ: u32 = 6_000_000;

/// Delays in cycles of the processor's clock, 96 MHz.
struct Cycles;

impl DelayNs for Cycles {
    fn delay_ns(&mut self, ns: u32) {
        cortex_m::asm::delay((ns / 1000 + 1) * 96);
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut RING: Ring = Ring::new();
    static mut DETECTOR: Detector = Detector::new(Settings::DEFAULT);
    static mut FITTER: Fitter = Fitter::new();
    static DIAGNOSTICS: Diagnostics = Diagnostics::new();
    let p = pac::Peripherals::take().unwrap();
    let clocks = rcc::Config::hse(8.MHz()).bypass_hse_oscillator();
    let mut rcc = p.RCC.freeze(clocks.sysclk(96.MHz()));
    let a = p.GPIOA.split(&mut rcc);
    let b = p.GPIOB.split(&mut rcc);
    let c = p.GPIOC.split(&mut rcc);
    let line = (a.pa2, a.pa3);
    let mut tx = p.USART2.serial(line, 921_600.bps(), &mut rcc).unwrap();
    let mut counter = p.TIM2.counter_us(&mut rcc);
    counter.start(u32::MAX.micros()).unwrap();
    let mut start = c.pc7.into_push_pull_output();
    let mut reset = a.pa9.into_push_pull_output_in_state(true.into());
    let drdy = a.pa4.into_input();
    // Drive CS first: the chip must not be selected while SCK and MOSI change.
    let cs = b.pb6.into_push_pull_output_in_state(true.into());
    let sck = a.pa5.into_alternate().speed(Speed::High);
    let (miso, mosi) = (a.pa6.into_alternate(), a.pa7.into_alternate());
    let pins = (Some(sck), Some(miso), Some(mosi));
    let bus = Spi::new(p.SPI1, pins, MODE, SCLK_HZ.Hz(), &mut rcc);
    let cs = SettledCs::new(cs, Cycles, SCAN.clock_hz, SCLK_HZ);
    let mut adc = Ads1258::new(ExclusiveDevice::new_no_delay(bus, cs).unwrap());
    Cycles.delay_ms(200);
    adc.reset_by_pin(&mut reset, &mut Cycles).unwrap();
    adc.configure(&SCAN).unwrap();
    adc.start(&mut start).unwrap();
    let mut estimator = Estimator::new(Settings::DEFAULT);
    loop {
        while drdy.is_high() {}
        let t_us = counter.now().ticks();
        let Ok(conversion) = adc.read() else { continue };
        let (mut due, conversion) = (None, TimedConversion::new(t_us, conversion));
        let emit = &mut |event| {
            let _ = match event {
                Event::Contact(_) => write!(tx, "contact\r\n"),
                Event::Release(_) => write!(tx, "release\r\n"),
                Event::Health(now) => write!(tx, "{} conversions lost\r\n", now.conversions_lost),
                _ => Ok(()),
            };
        };
        let due_now = &mut |window| due = Some(window);
        let mut outputs = Outputs { emit, due: due_now };
        DETECTOR.push(conversion, RING, &DIAGNOSTICS, &mut outputs);
        let Some(window) = due else { continue };
        if let Ok(WindowFit::Done(mut one)) = estimator.run(FITTER, &window, &mut &*RING) {
            DIAGNOSTICS.qualify(&mut one, &window);
            let (mhz, sigma_uhz) = ((one.frequency * 1e3) as u32, (one.sigma * 1e6) as u32);
            let _ = write!(tx, "{:?}: {mhz} mHz +- {sigma_uhz} uHz\r\n", one.status);
        }
    }
}
