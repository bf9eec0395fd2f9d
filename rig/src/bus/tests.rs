//! Each rule, broken on purpose by writes to registers, beside a set-up that keeps all of them.

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
        let adc = Adc::new(Box::new(Constant::default()), Options::default());
        Self(Bus::new(Board::FeatherF405.wiring(), adc, crate::Start::default().option_bytes))
    }

    fn set(&mut self, address: u32, value: u32) -> &mut Self {
        self.0.write(address, 4, value).expect("a register that is modelled");
        // As before the next instruction.
        self.0.catch_up();
        self
    }

    fn get(&mut self, address: u32) -> u32 {
        self.0.read(address, 4).expect("a register that is modelled")
    }

    fn wait_us(&mut self, us: u64) -> &mut Self {
        self.0.time.cycles += us * self.0.time.hz() / 1_000_000;
        self.0.catch_up();
        self
    }

    /// 168 MHz from 12 MHz, all clocks of peripherals on.
    fn clocks(&mut self) -> &mut Self {
        self.set(FLASH_ACR, 0x705).set(RCC_CR, 0x83 | 1 << 16).wait_us(2001);
        self.set(RCC_PLLCFGR, 6 | 168 << 6 | 1 << 22 | 7 << 24).set(RCC_CR, 0x83 | 1 << 16 | 1 << 24).wait_us(201);
        self.set(RCC_CFGR, 5 << 10 | 4 << 13 | 2);
        self.set(AHB1ENR, 7).set(APB1ENR, 1 | 1 << 2 | 1 << 18).set(APB2ENR, 1 << 12 | 1 << 14)
    }

    /// The pins of the Feather: CS, START and RESET driven, SPI1 and USART3 with fast pads.
    fn pins(&mut self) -> &mut Self {
        self.set(GPIOA + BSRR, 1 << 4).set(GPIOC + BSRR, 1 << 6);
        self.set(GPIOA + MODER, 0xA800_0000 | 1 << 8 | 0b10_1010 << 10).set(GPIOA + AFRL, 0x555 << 20);
        self.set(GPIOA + OSPEEDR, 2 << 10).set(GPIOC + MODER, 1 << 10 | 1 << 12);
        self.set(GPIOB + MODER, 0b1010 << 20).set(GPIOB + AFRH, 0x77 << 8)
    }

    fn ready() -> Self {
        let mut bench = Self::new();
        bench.clocks().pins().set(SPI1, SPI_ON).set(USART3 + 8, 46).set(USART3 + 0x0C, 0x200C);
        assert_eq!(bench.0.findings.0, [], "the set-up keeps every rule");
        bench
    }

    fn byte(&mut self, out: u8) -> u32 {
        self.set(SPI1 + 0x0C, out.into()).wait_us(2).get(SPI1 + 0x0C)
    }

    fn cs(&mut self, low: bool) -> &mut Self {
        self.set(GPIOA + BSRR, if low { 1 << 20 } else { 1 << 4 })
    }

    fn unlock(&mut self) -> &mut Self {
        self.set(FLASH_KEYR, 0x4567_0123).set(FLASH_KEYR, 0xCDEF_89AB)
    }

    #[track_caller]
    fn breaks(&self, rule: Rule) {
        let broken: Vec<Rule> = self.0.findings.0.iter().map(|finding| finding.rule).collect();
        assert_eq!(broken, [rule], "{:?}", self.0.findings.0);
    }

    #[track_caller]
    fn keeps_all(&self) {
        assert_eq!(self.0.findings.0, []);
    }
}

#[test]
fn a_peripheral_without_its_clock() {
    let mut bench = Bench::new();
    bench.get(SPI1);
    bench.breaks(Rule::ClockOn);
}

#[test]
fn the_pll_is_set_while_it_runs() {
    let mut bench = Bench::ready();
    bench.set(RCC_PLLCFGR, 6 | 168 << 6 | 1 << 22);
    bench.breaks(Rule::PllOff);
}

#[test]
fn hse_becomes_a_clock_while_it_runs() {
    let mut bench = Bench::ready();
    bench.set(RCC_CR, 0x83 | 5 << 16 | 1 << 24);
    bench.breaks(Rule::HseOff);
    assert_eq!(bench.get(RCC_CR) & 1 << 18, 0, "the write is lost");
    let mut right = Bench::new();
    right.set(RCC_CR, 0x83 | 1 << 18).set(RCC_CR, 0x83 | 5 << 16);
    right.keeps_all();
}

#[test]
fn too_few_wait_states() {
    let mut bench = Bench::ready();
    bench.set(RCC_CFGR, 0).set(FLASH_ACR, 4).set(RCC_CFGR, 5 << 10 | 4 << 13 | 2);
    bench.breaks(Rule::WaitStates);
}

#[test]
fn clocks_beyond_their_limits() {
    for cfgr in [4 << 10 | 4 << 13 | 2, 5 << 10 | 2] {
        let mut bench = Bench::ready();
        bench.set(RCC_CFGR, cfgr);
        bench.breaks(Rule::ClockLimit);
    }
    let mut too_early = Bench::new();
    too_early.set(FLASH_ACR, 5).set(RCC_CR, 0x83 | 1 << 16).wait_us(1000).set(RCC_CFGR, 1);
    too_early.breaks(Rule::ClockLimit);
}

#[test]
fn a_slow_pad_of_sck() {
    for (speed, is_broken) in [(0, true), (1, true), (2, false), (3, false)] {
        let mut bench = Bench::new();
        bench.clocks().pins().set(GPIOA + OSPEEDR, speed << 10).set(SPI1, SPI_ON);
        if is_broken { bench.breaks(Rule::PadSpeed) } else { bench.keeps_all() }
    }
}

#[test]
fn a_pin_with_another_function() {
    let mut bench = Bench::new();
    bench.clocks().pins().set(GPIOA + AFRL, 0x565 << 20).set(SPI1, SPI_ON);
    bench.breaks(Rule::PinFunction);
    let mut line = Bench::new();
    line.clocks().pins().set(GPIOB + MODER, 0b1000 << 20).set(USART3 + 0x0C, 0x200C).set(USART3 + 4, 0);
    line.breaks(Rule::PinFunction);
}

#[test]
fn another_mode_and_a_faster_clock() {
    for (cr1, rule) in [
        (SPI_ON | 1, Rule::SpiMode),
        (SPI_ON | 2, Rule::SpiMode),
        (SPI_ON | 1 << 7, Rule::SpiMode),
        (SPI_ON & !0x38 | 2 << 3, Rule::SpiClock),
    ] {
        let mut bench = Bench::new();
        bench.clocks().pins().set(SPI1, cr1);
        bench.breaks(rule);
    }
}

#[test]
fn cs_that_leaves_no_time() {
    let mut bench = Bench::ready();
    bench.wait_us(1).cs(true).wait_us(1).byte(0x30);
    bench.cs(false).wait_us(1).cs(true).wait_us(1).byte(0x30);
    bench.keeps_all();
    bench.cs(false).wait_us(1).cs(true).byte(0x30);
    bench.breaks(Rule::ChipSelect);

    let mut short = Bench::ready();
    short.wait_us(1).cs(true).wait_us(1).byte(0x30);
    short.cs(false).cs(true);
    short.breaks(Rule::ChipSelect);

    // The last bit is received half a clock, 16 cycles, before it ends.
    for (waits_for_busy, is_broken) in [(false, true), (true, false)] {
        let mut bench = Bench::ready();
        bench.wait_us(1).cs(true).wait_us(1).set(SPI1 + 0x0C, 0x30);
        while bench.get(SPI1 + 8) & 1 == 0 {}
        bench.get(SPI1 + 0x0C);
        while waits_for_busy && bench.get(SPI1 + 8) & 1 << 7 != 0 {}
        bench.cs(false);
        if is_broken { bench.breaks(Rule::ChipSelect) } else { bench.keeps_all() }
    }
}

#[test]
fn a_register_of_the_adc_written_while_it_scans() {
    let mut bench = Bench::ready();
    let write = |bench: &mut Bench| {
        bench.cs(true).wait_us(1);
        bench.byte(0x61);
        bench.byte(0x83);
        bench.cs(false).wait_us(1);
    };
    bench.wait_us(1);
    write(&mut bench);
    bench.keeps_all();
    bench.set(GPIOC + BSRR, 1 << 5);
    write(&mut bench);
    bench.breaks(Rule::AdcWrite);
}

#[test]
fn bytes_that_nobody_fetches() {
    let mut spi = Bench::ready();
    spi.set(SPI1 + 0x0C, 0).wait_us(2).set(SPI1 + 0x0C, 0).wait_us(2);
    spi.breaks(Rule::SpiOverrun);
    assert_eq!(spi.get(SPI1 + 8) & 1 << 6, 1 << 6, "OVR");

    let mut line = Bench::ready();
    let now = line.0.time.cycles;
    line.0.usart.arrive(b'a', now + 10);
    line.0.usart.arrive(b'b', now + 2000);
    line.wait_us(5);
    line.keeps_all();
    line.wait_us(10);
    line.breaks(Rule::UsartOverrun);
    assert_eq!(line.get(USART3) & 0x28, 0x28, "ORE and RXNE");
    assert_eq!(line.get(USART3 + 4), u32::from(b'a'), "the first byte is kept");
    assert_eq!(line.get(USART3) & 0x28, 0, "SR and then DR clear ORE");
}

#[test]
fn the_flash_against_its_rules() {
    let mut right = Bench::ready();
    right.unlock().set(FLASH_CR, 1 | 2 << 8).set(FREE, 0x1234_5678);
    right.keeps_all();
    assert_eq!(right.get(FREE), 0x1234_5678);
    right.set(FREE, 0x1234_0000);
    right.breaks(Rule::FlashWordTwice);

    let mut locked = Bench::ready();
    locked.set(FREE, 0);
    locked.breaks(Rule::FlashSequence);
    assert_eq!(locked.get(FREE), u32::MAX);

    let mut narrow = Bench::ready();
    narrow.unlock().set(FLASH_CR, 1);
    narrow.set(FREE, 0);
    narrow.breaks(Rule::FlashSequence);

    let mut wrong_key = Bench::ready();
    wrong_key.set(FLASH_KEYR, 0x4567_0124);
    wrong_key.breaks(Rule::FlashSequence);

    // LOCK in the write that chooses the sector: the next one, with STRT, is lost.
    let mut locks_itself = Bench::ready();
    locks_itself.unlock().set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 31);
    locks_itself.breaks(Rule::FlashSequence);
    locks_itself.set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 16);
    assert_eq!(locks_itself.0.flash.erased, 0);

    // Without keys at all.
    let mut locked = Bench::ready();
    locked.set(FLASH_CR, 1 | 2 << 8);
    locked.breaks(Rule::FlashSequence);
    assert_eq!(locked.get(FLASH_CR), 1 << 31, "the write is lost");

    let mut erases = Bench::ready();
    erases.unlock().set(FLASH_CR, 1 | 2 << 8).set(FREE, 0).set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 16);
    erases.keeps_all();
    assert_eq!(erases.get(FREE), u32::MAX);
}

#[test]
fn a_watchdog_that_nobody_feeds() {
    let mut bench = Bench::ready();
    bench.set(IWDG, 0xCCCC).set(IWDG, 0x5555).set(IWDG + 4, 0).set(IWDG + 8, 31).wait_us(160).set(IWDG, 0xAAAA);
    bench.wait_us(3900).set(IWDG, 0xAAAA).wait_us(3900);
    bench.keeps_all();
    bench.wait_us(200);
    bench.breaks(Rule::Watchdog);
    assert!(bench.0.has_bitten);
}

#[test]
fn a_timer_with_the_reload_value_of_the_reset() {
    let mut bench = Bench::ready();
    bench.set(TIM2 + 0x2C, u32::MAX).set(TIM2, 1);
    bench.keeps_all();
    let mut unset = Bench::ready();
    unset.set(TIM2, 1);
    unset.breaks(Rule::TimerReload);
}

#[test]
fn the_counter_counts_microseconds_and_wraps() {
    let mut bench = Bench::ready();
    bench.set(TIM2 + 0x2C, u32::MAX).set(TIM2 + 0x28, 83).set(TIM2 + 0x14, 1).set(TIM2, 1);
    let from = bench.get(TIM2 + 0x24);
    bench.wait_us(12_345);
    assert!(bench.get(TIM2 + 0x24) - from - 12_345 <= 1);
    bench.set(TIM2 + 0x24, u32::MAX - 10).wait_us(20);
    assert!((9..=10).contains(&bench.get(TIM2 + 0x24)));
}

#[test]
fn an_interrupt_whose_cause_is_gone() {
    let mut bench = Bench::ready();
    let scs = &mut bench.0.scs;
    scs.set_line(10, true);
    scs.set_line(10, false);
    scs.begin(26);
    assert_eq!(std::mem::take(&mut scs.spurious), [10]);
    scs.write(0xE000_E200, 4, 1 << 10).expect("ISPR");
    scs.begin(26);
    assert_eq!(scs.spurious, [], "software's own");
    // Its cause rises while it runs, or another of the same priority, and that run serves it.
    scs.set_line(10, true);
    scs.set_line(10, false);
    scs.begin(26);
    assert_eq!((std::mem::take(&mut scs.spurious), scs.served[26].served_before), (vec![], 1));
    // Somebody else takes the cause away between two runs.
    scs.end(26);
    scs.set_line(10, true);
    scs.set_line(10, false);
    scs.begin(26);
    assert_eq!((std::mem::take(&mut scs.spurious), scs.served[26].served_before), (vec![10], 1));
}

#[test]
fn what_is_not_modelled_ends_the_run() {
    let mut bench = Bench::ready();
    for address in [0x4000_0400, SPI1 + 4, 0xE000_E010, 0x4002_6400] {
        assert!(matches!(bench.0.write(address, 4, 0x80), Err(crate::stop::Stop::Failed(_))), "{address:#x}");
    }
    assert_eq!(bench.0.read(0x1FFF_FFFC, 4), Err(crate::stop::Stop::Bus(0x1FFF_FFFC)), "below the RAM is nothing");
}
