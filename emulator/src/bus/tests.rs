//! Tests of a board driven by register writes: breaks each rule on purpose, and checks the
//! behaviour of the parts.

mod line;
mod own_adc;
mod parts;
mod rules;
mod stylus;

use super::state::Bus;
use crate::board::Board;
use crate::findings::Rule;
use crate::peripherals::adc::Adc;
use hal_mock::{Constant, Options};

const RCC_CR: u32 = 0x4002_3800;
const RCC_PLLCFGR: u32 = 0x4002_3804;
const RCC_CFGR: u32 = 0x4002_3808;
const AHB1ENR: u32 = 0x4002_3830;
const APB1ENR: u32 = 0x4002_3840;
const APB2ENR: u32 = 0x4002_3844;
const FLASH_ACR: u32 = 0x4002_3C00;
const FLASH_KEYR: u32 = 0x4002_3C04;
const FLASH_CR: u32 = 0x4002_3C10;
const GPIOA: u32 = 0x4002_0000;
const GPIOB: u32 = 0x4002_0400;
const GPIOC: u32 = 0x4002_0800;
const SPI1: u32 = 0x4001_3000;
const USART3: u32 = 0x4000_4800;
const TIM2: u32 = 0x4000_0000;
const TIM10: u32 = 0x4001_4400;
const PWR_CR: u32 = 0x4000_7000;
const SYSCFG_PMC: u32 = 0x4001_3804;
const IWDG: u32 = 0x4000_3000;
const MODER: u32 = 0x00;
const OSPEEDR: u32 = 0x08;
const BSRR: u32 = 0x18;
const AFRL: u32 = 0x20;
const AFRH: u32 = 0x24;
/// An erased word of the last sector.
const FREE: u32 = 0x080E_0000;

/// SPI1 as a master of mode 0 at APB2 / 16, on: MSTR, BR, SPE, SSI, SSM.
const SPI_ON: u32 = 0x0304 | 3 << 3 | 1 << 6;

struct Bench(Bus);

impl Bench {
    fn new() -> Self {
        Self::of(Board::FeatherF405)
    }

    fn of(board: Board) -> Self {
        let adc = Adc::new(Box::new(Constant::default()), Options::default());
        Self(Bus::new(
            board.wiring(),
            adc,
            crate::Start::default().option_bytes,
        ))
    }

    fn set(&mut self, address: u32, value: u32) -> &mut Self {
        self.0
            .write(address, 4, value)
            .expect("a register that is modelled");
        // Process events, as before each instruction.
        self.0.catch_up();
        self
    }

    fn get(&mut self, address: u32) -> u32 {
        self.0
            .read(address, 4)
            .expect("a register that is modelled")
    }

    fn wait_us(&mut self, us: u64) -> &mut Self {
        self.0.time.cycles += us * self.0.time.hz() / 1_000_000;
        self.0.catch_up();
        self
    }

    /// Sets the clock to 168 MHz from 12 MHz and switches all peripheral clocks on.
    fn clocks(&mut self) -> &mut Self {
        self.set(FLASH_ACR, 0x705)
            .set(RCC_CR, 0x83 | 1 << 16)
            .wait_us(2001);
        self.set(RCC_PLLCFGR, 6 | 168 << 6 | 1 << 22 | 7 << 24)
            .set(RCC_CR, 0x83 | 1 << 16 | 1 << 24)
            .wait_us(201);
        self.set(RCC_CFGR, 5 << 10 | 4 << 13 | 2);
        self.set(AHB1ENR, 7)
            .set(APB1ENR, 1 | 1 << 2 | 1 << 18)
            .set(APB2ENR, 1 << 12 | 1 << 14)
    }

    /// Sets up the pins of the Feather: CS, START and RESET driven, SPI1 and USART3 with fast pads.
    fn pins(&mut self) -> &mut Self {
        self.set(GPIOA + BSRR, 1 << 4).set(GPIOC + BSRR, 1 << 6);
        self.set(GPIOA + MODER, 0xA800_0000 | 1 << 8 | 0b10_1010 << 10)
            .set(GPIOA + AFRL, 0x555 << 20);
        self.set(GPIOA + OSPEEDR, 2 << 10)
            .set(GPIOC + MODER, 1 << 10 | 1 << 12);
        self.set(GPIOB + MODER, 0b1010 << 20)
            .set(GPIOB + AFRH, 0x77 << 8)
    }

    fn ready() -> Self {
        let mut bench = Self::new();
        bench
            .clocks()
            .pins()
            .set(SPI1, SPI_ON)
            .set(USART3 + 8, 46)
            .set(USART3 + 0x0C, 0x200C);
        assert_eq!(bench.0.findings.0, [], "the set-up keeps every rule");
        bench
    }

    fn byte(&mut self, out: u8) -> u32 {
        self.set(SPI1 + 0x0C, out.into())
            .wait_us(2)
            .get(SPI1 + 0x0C)
    }

    fn cs(&mut self, low: bool) -> &mut Self {
        self.set(GPIOA + BSRR, if low { 1 << 20 } else { 1 << 4 })
    }

    fn unlock(&mut self) -> &mut Self {
        self.set(FLASH_KEYR, 0x4567_0123)
            .set(FLASH_KEYR, 0xCDEF_89AB)
    }

    #[track_caller]
    fn breaks(&self, rule: Rule) {
        assert_eq!(self.broken(), [rule], "{:?}", self.0.findings.0);
    }

    fn broken(&self) -> Vec<Rule> {
        let findings = &self.0.findings.0;
        findings.iter().map(|finding| finding.rule).collect()
    }

    #[track_caller]
    fn keeps_all(&self) {
        assert_eq!(self.0.findings.0, []);
    }
}
