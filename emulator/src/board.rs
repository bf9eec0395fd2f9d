//! Pins and wiring of the boards, from the guide's wiring page rather than from the firmware.

/// A pin, by its port (0 is A) and its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin(pub(crate) u8, pub(crate) u8);

impl Pin {
    /// Parses the name of a pin of port A, B or C, such as `PC5`.
    pub fn named(name: &str) -> Option<Self> {
        let (port, number) = name.strip_prefix('P')?.split_at_checked(1)?;
        let port = match port {
            "A" => 0,
            "B" => 1,
            "C" => 2,
            _ => return None,
        };
        let number = number.parse().ok().filter(|number| *number < 16)?;
        Some(Self(port, number))
    }

    pub(crate) const fn number(self) -> u8 {
        self.1
    }
}

/// A board that has an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// Adafruit Feather STM32F405 Express.
    FeatherF405,
    /// ST Nucleo-F446RE.
    NucleoF446re,
    /// The Feather with sensors at the on-chip ADC instead of an ADS1258.
    FeatherF405Adc,
    /// The Nucleo with sensors at the on-chip ADC.
    NucleoF446reAdc,
    /// WeAct Black Pill with an STM32F411.
    BlackpillF411,
    /// The Black Pill with sensors at the on-chip ADC.
    BlackpillF411Adc,
    /// The Feather as a stylus, with an encoder and an actuator instead of the ADC.
    StylusF405,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct AdcPins {
    pub sck: Pin,
    pub miso: Pin,
    pub mosi: Pin,
    pub cs: Pin,
    pub start: Pin,
    pub reset: Pin,
    pub drdy: Pin,
}

/// Pins of an encoder's two channels and an actuator's amplifier.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StylusPins {
    pub channels: [Pin; 2],
    pub output: Pin,
}

/// Wiring and limits of a board.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wiring {
    pub adc: Option<AdcPins>,
    /// Pins of sensors at the on-chip ADC, in the order of the inputs.
    pub inputs: &'static [Pin],
    pub stylus: Option<StylusPins>,
    /// Pin on which TIM10 outputs a clock for the ADC.
    pub clock: Pin,
    pub tx: Pin,
    pub rx: Pin,
    /// The serial line's USART: 2 or 3.
    pub usart: u8,
    /// Frequency of the crystal or the external clock, hertz.
    pub hse_hz: u64,
    /// True if HSE is an external clock, not a crystal.
    pub is_bypassed: bool,
    pub flash_bytes: usize,
    pub ccm_bytes: usize,
    pub has_dckcfgr: bool,
    /// True if PWR_CR has ADCDC1, and SYSCFG_PMC ADC1DC2 (crate `stm32f4` 0.16).
    pub has_adc_accuracy: bool,
    /// Maximum clocks of the processor, APB1 and APB2, hertz (DS8626, DS10693 and DS10314, general
    /// operating conditions).
    pub limits_hz: [u64; 3],
    /// PWR_CR after a reset: VOS in bits 15 and 14 (from memory).
    pub pwr_cr: u32,
    /// DBGMCU_IDCODE: device and revision (RM0090 38.6.1, RM0390 33.6.1, RM0383 23.6.1).
    pub id_code: u32,
}

const PORT_A: u8 = 0;
const PORT_B: u8 = 1;
const PORT_C: u8 = 2;

/// Feather inputs: A0 to A5, D12, D11.
const FEATHER_INPUTS: [Pin; 8] = [
    Pin(PORT_A, 4),
    Pin(PORT_A, 5),
    Pin(PORT_A, 6),
    Pin(PORT_A, 7),
    Pin(PORT_C, 4),
    Pin(PORT_C, 5),
    Pin(PORT_C, 2),
    Pin(PORT_C, 3),
];

/// Nucleo inputs: PA0, PA1, PA4 to PA7, PB0, PB1, PC0 to PC5.
const NUCLEO_INPUTS: [Pin; 14] = [
    Pin(PORT_A, 0),
    Pin(PORT_A, 1),
    Pin(PORT_A, 4),
    Pin(PORT_A, 5),
    Pin(PORT_A, 6),
    Pin(PORT_A, 7),
    Pin(PORT_B, 0),
    Pin(PORT_B, 1),
    Pin(PORT_C, 0),
    Pin(PORT_C, 1),
    Pin(PORT_C, 2),
    Pin(PORT_C, 3),
    Pin(PORT_C, 4),
    Pin(PORT_C, 5),
];

/// Black Pill inputs: PA0, PA1, PA4 to PA7, PB0, PB1.
const BLACKPILL_INPUTS: [Pin; 8] = *NUCLEO_INPUTS
    .first_chunk()
    .expect("they are the Nucleo's first");

impl Board {
    /// Finger boards with an ADS1258.
    pub const ALL: [Self; 3] = [Self::FeatherF405, Self::NucleoF446re, Self::BlackpillF411];

    /// Finger boards with sensors at the on-chip ADC.
    pub const OWN_ADC: [Self; 3] = [
        Self::FeatherF405Adc,
        Self::NucleoF446reAdc,
        Self::BlackpillF411Adc,
    ];

    /// Finds a board by its name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .chain(Self::OWN_ADC)
            .chain([Self::StylusF405])
            .find(|board| board.name() == name)
    }

    /// Name of the image's file.
    pub(crate) const fn file(self) -> &'static str {
        match self {
            Self::StylusF405 => "ridgetone-stylus-firmware.elf",
            _ => "ridgetone-firmware.elf",
        }
    }

    /// Name of the board and of its image's folder.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FeatherF405 => "feather-f405",
            Self::NucleoF446re => "nucleo-f446re",
            Self::FeatherF405Adc => "feather-f405-adc",
            Self::NucleoF446reAdc => "nucleo-f446re-adc",
            Self::BlackpillF411 => "blackpill-f411",
            Self::BlackpillF411Adc => "blackpill-f411-adc",
            Self::StylusF405 => "stylus-f405",
        }
    }

    pub(crate) const fn wiring(self) -> Wiring {
        let spi1 = [Pin(PORT_A, 5), Pin(PORT_A, 6), Pin(PORT_A, 7)];
        match self {
            Self::FeatherF405 => Wiring {
                adc: Some(AdcPins {
                    sck: spi1[0],
                    miso: spi1[1],
                    mosi: spi1[2],
                    cs: Pin(PORT_A, 4),
                    start: Pin(PORT_C, 5),
                    reset: Pin(PORT_C, 6),
                    drdy: Pin(PORT_C, 4),
                }),
                inputs: &[],
                stylus: None,
                clock: Pin(PORT_B, 8),
                tx: Pin(PORT_B, 10),
                rx: Pin(PORT_B, 11),
                usart: 3,
                hse_hz: 12_000_000,
                is_bypassed: false,
                flash_bytes: 1 << 20,
                ccm_bytes: 64 << 10,
                has_dckcfgr: false,
                has_adc_accuracy: false,
                limits_hz: [168_000_000, 42_000_000, 84_000_000],
                pwr_cr: 0x4000,
                id_code: 0x1007_6413,
            },
            Self::FeatherF405Adc => Wiring {
                adc: None,
                inputs: &FEATHER_INPUTS,
                ..Self::FeatherF405.wiring()
            },
            Self::NucleoF446reAdc => Wiring {
                adc: None,
                inputs: &NUCLEO_INPUTS,
                ..Self::NucleoF446re.wiring()
            },
            Self::StylusF405 => Wiring {
                adc: None,
                stylus: Some(StylusPins {
                    channels: [Pin(PORT_C, 6), Pin(PORT_C, 7)],
                    output: Pin(PORT_A, 4),
                }),
                ..Self::FeatherF405.wiring()
            },
            Self::NucleoF446re => Wiring {
                adc: Some(AdcPins {
                    sck: spi1[0],
                    miso: spi1[1],
                    mosi: spi1[2],
                    cs: Pin(PORT_B, 6),
                    start: Pin(PORT_C, 7),
                    reset: Pin(PORT_A, 9),
                    drdy: Pin(PORT_A, 4),
                }),
                inputs: &[],
                stylus: None,
                clock: Pin(PORT_B, 8),
                tx: Pin(PORT_A, 2),
                rx: Pin(PORT_A, 3),
                usart: 2,
                hse_hz: 8_000_000,
                is_bypassed: true,
                flash_bytes: 512 << 10,
                ccm_bytes: 0,
                has_dckcfgr: true,
                has_adc_accuracy: true,
                limits_hz: [180_000_000, 45_000_000, 90_000_000],
                pwr_cr: 0xC000,
                id_code: 0x1000_6421,
            },
            Self::BlackpillF411 => Wiring {
                adc: Some(AdcPins {
                    sck: spi1[0],
                    miso: spi1[1],
                    mosi: spi1[2],
                    cs: Pin(PORT_B, 0),
                    start: Pin(PORT_B, 1),
                    reset: Pin(PORT_B, 10),
                    drdy: Pin(PORT_A, 4),
                }),
                hse_hz: 25_000_000,
                is_bypassed: false,
                has_dckcfgr: false,
                limits_hz: [100_000_000, 50_000_000, 100_000_000],
                pwr_cr: 0x8000,
                id_code: 0x1000_6431,
                ..Self::NucleoF446re.wiring()
            },
            Self::BlackpillF411Adc => Wiring {
                adc: None,
                inputs: &BLACKPILL_INPUTS,
                ..Self::BlackpillF411.wiring()
            },
        }
    }
}
