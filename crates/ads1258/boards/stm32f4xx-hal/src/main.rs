//! Sixteen inputs of an ADS1258 in volts, on a Nucleo-F446RE, with stm32f4xx-hal and RTIC.
//!
//! Wiring, ADS1258 to the Nucleo: SCLK D13 (PA5; open the solder bridge SB21, or the green LED loads
//! it), DOUT D12 (PA6), DIN D11 (PA7), CS D10 (PB6), DRDY A2 (PA4), START D9 (PC7); RESET, PWDN
//! and DVDD 3V3, DGND and CLKSEL GND, the chip's crystal at XTAL1 and XTAL2.
#![no_std]
#![no_main]

#[rtic::app(device = stm32f4xx_hal::pac)]
mod app {
    use ads1258::{Ads1258, CRYSTAL_CLOCK_HZ, Channel, Config, SettledCs, reading};
    use embedded_hal::delay::DelayNs;
    use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
    use stm32f4xx_hal::gpio::{Edge, Output, PA4, PB6, Speed};
    use stm32f4xx_hal::{pac::SPI1, prelude::*, rcc, spi::Spi};
    use {defmt_rtt as _, panic_probe as _};
    const SCLK_HZ: u32 = 5_250_000; // at most half of the chip's clock
    type Device = ExclusiveDevice<Spi<SPI1>, SettledCs<PB6<Output>, Cycles>, NoDelay>;

    /// Delays in cycles of the processor's clock, 84 MHz. CS is low for 0.2 us before SCLK, and
    /// high for as long between transfers: too short for a timer.
    pub struct Cycles;

    impl DelayNs for Cycles {
        fn delay_ns(&mut self, ns: u32) {
            cortex_m::asm::delay(ns.div_ceil(1000) * 84);
        }
    }

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        adc: Ads1258<Device>,
        drdy: PA4,
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        let mut p = cx.device;
        let mut rcc = p.RCC.freeze(rcc::Config::hsi().sysclk(84.MHz()));
        let (a, b) = (p.GPIOA.split(&mut rcc), p.GPIOB.split(&mut rcc));
        let mut start = p.GPIOC.split(&mut rcc).pc7.into_push_pull_output();
        // High before the bus starts: the chip must not be selected while SCLK and DIN change.
        let cs = b.pb6.into_push_pull_output_in_state(true.into());
        let cs = SettledCs::new(cs, Cycles, CRYSTAL_CLOCK_HZ, SCLK_HZ);
        let sck = a.pa5.into_alternate().speed(Speed::High); // slower, it may corrupt a bit (ES0298)
        let pins = (Some(sck), Some(a.pa6), Some(a.pa7));
        let bus = Spi::new(p.SPI1, pins, ads1258::MODE, SCLK_HZ.Hz(), &mut rcc);
        let mut adc = Ads1258::new(ExclusiveDevice::new_no_delay(bus, cs).unwrap());
        // DRDY falls when a conversion is ready. The pull-up keeps the pin from floating without a
        // chip.
        let mut drdy = a.pa4.into_pull_up_input();
        drdy.make_interrupt_source(&mut p.SYSCFG.constrain(&mut rcc));
        drdy.trigger_on_edge(&mut p.EXTI, Edge::Falling);
        drdy.enable_interrupt(&mut p.EXTI);
        Cycles.delay_ms(200); // the chip's crystal starts
        adc.reset().unwrap();
        adc.configure(&Config::RESET).unwrap(); // AIN0 to AIN15 in turn, 1,484 times a second
        adc.start(&mut start).unwrap();
        (Shared {}, Local { adc, drdy })
    }

    /// Handles the falling edge of DRDY. A read is one transfer of 5 bytes, and the next edge comes
    /// 42 us later.
    #[task(binds = EXTI4, local = [adc, drdy, volts: [f32; 16] = [0.0; 16], conversions: u32 = 0])]
    fn drdy(cx: drdy::Context) {
        cx.local.drdy.clear_interrupt_pending_bit();
        let conversion = cx.local.adc.read().unwrap();
        if let Some(Channel::Single(input)) = conversion.status.channel() {
            cx.local.volts[usize::from(input)] = reading::volts(conversion.code, 4.096);
        }
        *cx.local.conversions += 1;
        if cx.local.conversions.is_multiple_of(65_536) {
            defmt::info!("{} V", cx.local.volts);
            // Registers have been seen to change by themselves.
            cx.local.adc.verify().unwrap();
        }
    }
}
