//! Conditions at the start of a run.

use hal_mock::{Amplifier, Options};

/// The state of the board at power-up.
#[derive(Clone, Debug)]
pub struct Start {
    /// Options of the simulated ADC. By default it is powered together with the board and does not
    /// answer for 2^18 tCLK.
    pub adc: Options,
    /// Circuit between the sensors and the pins of the on-chip ADC. The default is the
    /// wiring page's amplifiers, with a gain of 20.
    pub amplifier: Amplifier,
    /// True if the crystal does not start.
    pub hse_is_dead: bool,
    /// Error of the internal oscillator, parts per million of 16 MHz: up to 10,000 at 25 C, and
    /// 80,000 over temperature (DS8626, HSI oscillator characteristics).
    pub hsi_ppm: i32,
    /// True for the state left by the ROM's loader: PLL and HSE on, system memory at address 0,
    /// USB's interrupt requested, and a jump through the flash's vectors.
    pub after_rom_loader: bool,
    /// True if CLKIO is wired to the board's clock for the ADC; the ADC then has no crystal.
    pub clkio_is_wired: bool,
    /// True if SPI's BSY clears half a bit before the last byte ends.
    pub bsy_is_early: bool,
    /// True if error flags are set in FLASH_SR at power-up, as users have reported.
    pub flash_has_errors: bool,
    /// FLASH_OPTCR. The default is the factory setting: brown-out reset is off (RM0090, 3.9.10).
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
