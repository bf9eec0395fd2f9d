//! Start of a run.

use hal_mock::{Amplifier, Options};

/// The state of the board at power-up.
#[derive(Clone, Debug)]
pub struct Start {
    /// Options of the simulated ADC. By default it is powered together with the board and does not
    /// answer for 2^18 tCLK.
    pub adc: Options,
    /// Circuit between the sensors and the pins of the processor's own ADC. By default the wiring
    /// page's amplifiers, of gain 20.
    pub amplifier: Amplifier,
    /// The crystal does not start.
    pub hse_is_dead: bool,
    /// Error of the internal oscillator, parts per million of 16 MHz: within 10,000 at 25 C, and
    /// 80,000 over temperature (DS8626, HSI oscillator characteristics).
    pub hsi_ppm: i32,
    /// As the ROM's loader leaves the chip: PLL and HSE on, system memory at address 0, USB's
    /// interrupt requested, and a jump through the flash's vectors.
    pub after_rom_loader: bool,
    /// CLKIO is wired to the board's clock for the ADC, which has no other one.
    pub clkio_is_wired: bool,
    /// SPI's BSY clears half a bit before the last byte ends.
    pub bsy_is_early: bool,
    /// Error flags are set in FLASH_SR at power-up, as others have found them.
    pub flash_has_errors: bool,
    /// FLASH_OPTCR. By default as the chip is delivered: brown-out reset is off (RM0090, 3.9.10).
    pub option_bytes: u32,
}

impl Default for Start {
    fn default() -> Self {
        let adc = Options {
            power_up_cycles: 1 << 18,
            ..Options::default()
        };
        Self {
            adc,
            amplifier: Amplifier::Gain(20.0),
            hse_is_dead: false,
            hsi_ppm: 0,
            after_rom_loader: false,
            clkio_is_wired: false,
            bsy_is_early: false,
            flash_has_errors: false,
            option_bytes: 0x0FFF_AAED,
        }
    }
}
