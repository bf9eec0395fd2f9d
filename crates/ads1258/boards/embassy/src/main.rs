//! Sixteen inputs of an ADS1258 in volts, on a Nucleo-F446RE, with embassy and async SPI.
//!
//! Wiring, ADS1258 to the Nucleo: SCLK D13 (PA5; open the solder bridge SB21, or the green LED loads
//! it), DOUT D12 (PA6), DIN D11 (PA7), CS D10 (PB6), DRDY A2 (PA4), START D9 (PC7), RESET D8 (PA9);
//! PWDN and DVDD 3V3, DGND and CLKSEL GND, the chip's crystal at XTAL1 and XTAL2.
#![no_std]
#![no_main]

use ads1258::{Ads1258, Channel, Config, DataRate, SettledCs, reading};
use embassy_stm32::exti::{self, ExtiInput};
use embassy_stm32::gpio::{Level, Output, Pull, Speed};
use embassy_stm32::peripherals::{DMA2_CH0, DMA2_CH3};
use embassy_stm32::spi::{self, Spi};
use embassy_stm32::{bind_interrupts, dma, interrupt, time::Hertz};
use embedded_hal::delay::DelayNs;
use embedded_hal_bus::spi::ExclusiveDevice;
use {defmt_rtt as _, panic_probe as _};

bind_interrupts!(struct Irqs {
    DMA2_STREAM0 => dma::InterruptHandler<DMA2_CH0>;
    DMA2_STREAM3 => dma::InterruptHandler<DMA2_CH3>;
    EXTI4 => exti::InterruptHandler<interrupt::typelevel::EXTI4>;
});

/// Reference voltage, V.
const VREF_V: f32 = 4.096;
/// SPI clock in Hz, at most half of the chip's clock.
const SCLK_HZ: u32 = 4_000_000;
/// AIN0 to AIN15 in turn, 379 times a second.
const CONFIG: Config = Config {
    data_rate: DataRate::Drate1,
    ..Config::RESET
};

/// Delays in cycles of the processor's clock, 16 MHz. CS is low for 0.2 us before SCLK, and high
/// for as long between transfers: too short for a timer.
struct Cycles;

impl DelayNs for Cycles {
    fn delay_ns(&mut self, ns: u32) {
        cortex_m::asm::delay(ns.div_ceil(1000) * 16);
    }
}

#[embassy_executor::main]
async fn main(_spawner: embassy_executor::Spawner) {
    let p = embassy_stm32::init(Default::default());
    let mut reset = Output::new(p.PA9, Level::High, Speed::Low);
    let mut start = Output::new(p.PC7, Level::Low, Speed::Low);
    // High before the bus starts: the chip must not be selected while SCLK and DIN change.
    let cs = Output::new(p.PB6, Level::High, Speed::Medium);
    let cs = SettledCs::new(cs, Cycles, CONFIG.clock_hz, SCLK_HZ);
    let mut bus = spi::Config::default(); // in mode 0, as the chip requires
    bus.frequency = Hertz(SCLK_HZ);
    let (tx, rx) = (p.DMA2_CH3, p.DMA2_CH0);
    let bus = Spi::new(p.SPI1, p.PA5, p.PA7, p.PA6, tx, rx, Irqs, bus);
    let mut adc = Ads1258::new(ExclusiveDevice::new_no_delay(bus, cs).unwrap());
    // DRDY falls when a conversion is ready; its interrupt, EXTI4, wakes the task. The pull-up
    // keeps the pin from floating without a chip.
    let mut drdy = ExtiInput::new(p.PA4, p.EXTI4, Pull::Up, Irqs);

    Cycles.delay_ms(200); // the chip's crystal starts
    adc.reset_by_pin(&mut reset, &mut Cycles).unwrap();
    let configured = adc.configure_async(&CONFIG).await;
    configured.expect("the ADS1258 answers");
    adc.start(&mut start).unwrap();
    let mut volts = [0.0; 16];
    // Registers have been seen to change by themselves; a restart rewrites them.
    while adc.verify_async().await.is_ok() {
        for _ in 0..4096 {
            let conversion = adc.read_next_async(&mut drdy).await.unwrap();
            if let Some(Channel::Single(input)) = conversion.status.channel() {
                volts[usize::from(input)] = reading::volts(conversion.code, VREF_V);
            }
        }
        defmt::info!("{} V", volts);
    }
    cortex_m::peripheral::SCB::sys_reset();
}
