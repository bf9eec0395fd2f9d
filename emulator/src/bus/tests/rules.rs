//! Tests each rule with an action that breaks it, and with others that keep all rules.

use super::line;
use super::own_adc::{
    self, BUFFER, CCR, CR2, EN, FLAGS, LIFCR, M0AR, NDTR, ON, OVERRUN, PAR, SMPR2, SQR1, SQR3, SR,
    START, STREAM, TO_MEMORY, converting,
};
use super::parts::clock;
use super::{
    AFRL, APB1ENR, APB2ENR, BSRR, Bench, FLASH_ACR, FLASH_CR, FLASH_KEYR, FREE, GPIOA, GPIOB,
    GPIOC, IWDG, MODER, OSPEEDR, PWR_CR, RCC_CFGR, RCC_CR, RCC_PLLCFGR, SPI_ON, SPI1, SYSCFG_PMC,
    TIM2, USART3,
};
use crate::board::Board;
use crate::emulator::{Emulator, Start};
use crate::findings::Rule::{self, *};
use crate::image::Image;
use crate::processor_fault::ProcessorFault;
use hal_mock::Constant;

type Act = fn(&mut Bench);

/// A case: its name, the rules that it must break, and the rules that it broke.
type Row = (String, Vec<Rule>, Vec<Rule>);

#[derive(Default)]
struct Table(Vec<Row>);

impl Table {
    fn breaks(&mut self, rule: Rule, what: &str, mut bench: Bench, act: impl FnOnce(&mut Bench)) {
        act(&mut bench);
        self.0.push((what.to_owned(), vec![rule], bench.broken()));
    }

    fn keeps(&mut self, what: &str, mut bench: Bench, act: impl FnOnce(&mut Bench)) {
        act(&mut bench);
        self.0.push((what.to_owned(), vec![], bench.broken()));
    }

    /// Adds a case that must break `rule`, if `is_broken`, and no other rule.
    fn row(&mut self, rule: Rule, is_broken: bool, what: &str, bench: Bench) {
        let expected = if is_broken { vec![rule] } else { vec![] };
        self.0.push((what.to_owned(), expected, bench.broken()));
    }
}

#[test]
fn each_rule_is_broken_on_purpose_and_by_nothing_else() {
    let mut table = Table::default();
    clocks(&mut table);
    pins_and_spi(&mut table);
    serial_line(&mut table);
    converter(&mut table);
    stream(&mut table);
    flash(&mut table);
    processor(&mut table);
    for (what, expected, broken) in &table.0 {
        assert_eq!(broken, expected, "{what}");
    }
    for rule in Rule::ALL {
        let has_row = table.0.iter().any(|(_, expected, _)| expected == &[*rule]);
        assert!(has_row, "nothing breaks {rule:?} on purpose");
    }
}

fn clocks(table: &mut Table) {
    table.breaks(ClockOn, "SPI1 without its clock", Bench::new(), |bench| {
        bench.get(SPI1);
    });
    let without = Bench::of(Board::FeatherF405Adc);
    table.breaks(ClockOn, "ADC1 without its clock", without, |bench| {
        bench.get(SR);
    });
    table.breaks(PllOff, "PLLCFGR while PLLON", Bench::ready(), |bench| {
        bench.set(RCC_PLLCFGR, 6 | 168 << 6 | 1 << 22);
    });
    table.breaks(HseOff, "HSEBYP while HSEON", Bench::ready(), |bench| {
        bench.set(RCC_CR, 0x83 | 5 << 16 | 1 << 24);
        assert_eq!(bench.get(RCC_CR) & 1 << 18, 0, "the write is lost");
    });
    table.keeps("HSEBYP before HSEON", Bench::new(), |bench| {
        bench
            .set(RCC_CR, 0x83 | 1 << 18)
            .set(RCC_CR, 0x83 | 5 << 16);
    });
    let slow = "four wait states at 168 MHz";
    table.breaks(WaitStates, slow, Bench::ready(), |bench| {
        bench
            .set(RCC_CFGR, 0)
            .set(FLASH_ACR, 4)
            .set(RCC_CFGR, 5 << 10 | 4 << 13 | 2);
    });
    for cfgr in [4 << 10 | 4 << 13 | 2, 5 << 10 | 2] {
        table.breaks(ClockLimit, "an APB too fast", Bench::ready(), |bench| {
            bench.set(RCC_CFGR, cfgr);
        });
    }
    let early = "HSE as the clock before it is ready";
    table.breaks(ClockLimit, early, Bench::new(), |bench| {
        bench
            .set(FLASH_ACR, 5)
            .set(RCC_CR, 0x83 | 1 << 16)
            .wait_us(1000)
            .set(RCC_CFGR, 1);
    });
    // The reset value of VOS allows the STM32F411 only 84 MHz.
    for (vos, is_broken) in [(2, true), (3, false)] {
        let mut bench = Bench::of(Board::BlackpillF411);
        bench
            .set(FLASH_ACR, 3)
            .set(APB1ENR, 1 << 28)
            .set(PWR_CR, vos << 14)
            .set(RCC_CR, 0x83 | 1 << 16)
            .wait_us(2100)
            .set(RCC_PLLCFGR, 25 | 200 << 6 | 1 << 22 | 5 << 24)
            .set(RCC_CR, 0x83 | 1 << 16 | 1 << 24)
            .wait_us(300)
            .set(RCC_CFGR, 4 << 10 | 2);
        table.row(ClockLimit, is_broken, "100 MHz by VOS", bench);
    }
    let mut bench = Bench::ready();
    bench.set(APB1ENR, 1 << 28);
    table.breaks(PllOff, "VOS while PLLON", bench, |bench| {
        bench.set(PWR_CR, 0);
    });
    for (period, high, is_broken) in [
        (11, 5, false),
        (11, 6, false),
        (11, 4, true),
        (11, 7, true),
        (10, 5, true),
    ] {
        let bench = clock(1, period, high);
        assert_eq!(bench.0.clock_output_hz, (168_000_000 + period / 2) / period);
        table.row(AdcClock, is_broken, "a clock for the ADC", bench);
    }
    table.row(PadSpeed, true, "a slow pad of the clock", clock(0, 11, 5));
    table.keeps("TIM2 with its reload", Bench::ready(), |bench| {
        bench.set(TIM2 + 0x2C, u32::MAX).set(TIM2, 1);
    });
    table.breaks(TimerReload, "TIM2 as reset", Bench::ready(), |bench| {
        bench.set(TIM2, 1);
    });
}

fn pins_and_spi(table: &mut Table) {
    let set_up = |register: u32, value: u32, cr1: u32| {
        let mut bench = Bench::new();
        bench.clocks().pins().set(register, value).set(SPI1, cr1);
        bench
    };
    for speed in 0..4 {
        let bench = set_up(GPIOA + OSPEEDR, speed << 10, SPI_ON);
        table.row(PadSpeed, speed < 2, "the pad of SCK", bench);
    }
    let other = set_up(GPIOA + AFRL, 0x565 << 20, SPI_ON);
    table.row(PinFunction, true, "another function of MISO", other);
    for (cr1, rule) in [
        (SPI_ON | 1, SpiMode),
        (SPI_ON | 2, SpiMode),
        (SPI_ON | 1 << 7, SpiMode),
        (SPI_ON & !0x38 | 2 << 3, SpiClock),
    ] {
        let bench = set_up(GPIOA + OSPEEDR, 2 << 10, cr1);
        table.row(rule, true, "another mode, a faster clock", bench);
    }
    let selected = || {
        let mut bench = Bench::ready();
        bench.wait_us(1).cs(true).wait_us(1);
        bench
    };
    table.keeps("CS with all its times", selected(), |bench| {
        bench.byte(0x30);
        bench.cs(false).wait_us(1).cs(true).wait_us(1).byte(0x30);
    });
    table.breaks(ChipSelect, "SCLK at once after CS", selected(), |bench| {
        bench.byte(0x30);
        bench.cs(false).wait_us(1).cs(true).byte(0x30);
    });
    table.breaks(ChipSelect, "CS high too shortly", selected(), |bench| {
        bench.byte(0x30);
        bench.cs(false).cs(true);
    });
    // The last bit is received half a clock, 16 cycles, before it ends.
    for waits in [false, true] {
        let mut bench = selected();
        bench.set(SPI1 + 0x0C, 0x30);
        while bench.get(SPI1 + 8) & 1 == 0 {}
        bench.get(SPI1 + 0x0C);
        while waits && bench.get(SPI1 + 8) & 1 << 7 != 0 {}
        bench.cs(false);
        table.row(ChipSelect, !waits, "CS high within the last bit", bench);
    }
    for scans in [false, true] {
        let mut bench = Bench::ready();
        if scans {
            bench.set(GPIOC + BSRR, 1 << 5);
        }
        bench.wait_us(1).cs(true).wait_us(1);
        bench.byte(0x61);
        bench.byte(0x83);
        bench.cs(false).wait_us(1);
        table.row(AdcWrite, scans, "a register of the ADC", bench);
    }
    table.breaks(SpiOverrun, "two bytes unread", Bench::ready(), |bench| {
        bench
            .set(SPI1 + 0x0C, 0)
            .wait_us(2)
            .set(SPI1 + 0x0C, 0)
            .wait_us(2);
        assert_eq!(bench.get(SPI1 + 8) & 1 << 6, 1 << 6, "OVR");
    });
}

fn serial_line(table: &mut Table) {
    table.breaks(
        PinFunction,
        "RX and TX without one",
        Bench::new(),
        |bench| {
            bench
                .clocks()
                .pins()
                .set(GPIOB + MODER, 0b1000 << 20)
                .set(USART3 + 0x0C, 0x200C)
                .set(USART3 + 4, 0);
        },
    );
    for (us, is_broken) in [(5, false), (15, true)] {
        let mut bench = Bench::ready();
        let now = bench.0.time.cycles;
        bench.0.usart.arrive(b'a', now + 10);
        bench.0.usart.arrive(b'b', now + 2000);
        bench.wait_us(us);
        table.row(UsartOverrun, is_broken, "two bytes unread", bench);
    }
    // A byte takes 10.85 us and a word of flash 16 us, so the processor must take a byte after each
    // word.
    for (back_to_back, is_broken) in [(false, false), (true, true)] {
        let mut bench = Bench::ready();
        bench.unlock().set(FLASH_CR, 1 | 2 << 8);
        for word in 0..8 {
            let now = bench.0.time.cycles;
            let arrivals = if back_to_back { 2 } else { 1 };
            for byte in 1..=arrivals {
                bench.0.usart.arrive(b'a', now + 1100 * byte);
            }
            bench.set(FREE + 4 * word, 0).get(USART3 + 4);
        }
        assert_eq!(bench.0.usart.overruns, if back_to_back { 8 } else { 0 });
        let what = "bytes back to back while flash is written";
        table.row(UsartOverrun, is_broken, what, bench);
    }
    let fetched = "the DMA fetches bytes while flash is written";
    table.keeps(fetched, line::receiving(), |bench| {
        bench.unlock().set(FLASH_CR, 1 | 2 << 8);
        line::arrive(bench, (1..=16).map(|byte| 1840 * byte));
        for word in 0..11 {
            bench.set(FREE + 4 * word, 0);
        }
        assert_eq!((bench.0.usart.taken, bench.0.usart.overruns), (16, 0));
    });
    let off = "bytes arrive while their stream is off";
    table.breaks(UsartOverrun, off, line::bench(), |bench| {
        line::arrive(bench, [1840, 3680]);
        bench.wait_us(25);
    });
    // The DMA fetches a byte a few cycles after its arrival.
    for (cycles, is_broken) in [(1839, false), (1843, true), (1860, false)] {
        let mut bench = line::receiving();
        line::arrive(&mut bench, [1840]);
        bench.0.time.cycles += cycles - 2;
        bench.get(USART3 + 4);
        bench.wait_us(25);
        assert_eq!(bench.get(line::NDTR), if is_broken { 16 } else { 15 });
        table.row(UsartData, is_broken, "a read of the data register", bench);
    }
    for wrong in [1 << 6, 1 << 11, 1 << 13, 1 << 10, 1 << 25] {
        let what = "another direction, size or channel of the line";
        table.breaks(DmaSetting, what, line::bench(), |bench| {
            bench.set(line::STREAM, line::ON ^ wrong);
        });
    }
    for (register, value) in [
        (line::PAR, USART3),
        (line::M0AR, 0x1000_0000),
        (line::NDTR, 15),
    ] {
        let what = "another source, place or length of the line";
        table.breaks(DmaSetting, what, line::bench(), |bench| {
            bench.set(register, value).set(line::STREAM, line::ON);
        });
    }
    table.breaks(
        DmaEnabled,
        "set while it runs",
        line::receiving(),
        |bench| {
            bench.set(line::M0AR, line::BUFFER + 64);
        },
    );
}

fn converter(table: &mut Table) {
    let digital = "an input that is not analogue";
    table.breaks(PinFunction, digital, own_adc::bench(), |bench| {
        bench
            .set(GPIOA + MODER, 0xA800_0300)
            .set(CR2, ON)
            .wait_us(4)
            .set(CR2, START);
    });
    table.breaks(ClockLimit, "ADC1 at 42 MHz", own_adc::bench(), |bench| {
        bench.set(CCR, 0).set(CR2, ON).wait_us(4).set(CR2, START);
    });
    table.breaks(AdcSettling, "a start at once", own_adc::bench(), |bench| {
        bench
            .set(STREAM, TO_MEMORY | EN)
            .set(CR2, ON)
            .wait_us(1)
            .set(CR2, START);
    });
    for (register, value) in [(SQR3, 0), (SQR1, 0), (SMPR2, 0), (CCR, 0)] {
        table.breaks(
            AdcSequence,
            "set while it converts",
            converting(),
            |bench| {
                bench.wait_us(10).set(register, value);
            },
        );
        table.keeps("set while it is off", converting(), |bench| {
            bench.wait_us(10).set(CR2, 0).set(register, value);
        });
    }
    accuracy(table);
    table.breaks(AdcOverrun, "the stream stops", converting(), |bench| {
        bench.wait_us(5).set(STREAM, TO_MEMORY).wait_us(10);
        assert_eq!(bench.get(SR) & OVERRUN, OVERRUN);
        // The overrun stays until the ADC is set up again.
        bench.set(CR2, START).wait_us(10);
        assert_eq!(bench.get(SR) & OVERRUN, OVERRUN);
    });
    let once = "no requests after a round: DDS is clear";
    table.breaks(AdcOverrun, once, own_adc::bench(), |bench| {
        bench
            .set(STREAM, TO_MEMORY | EN)
            .set(CR2, ON & !(1 << 9))
            .wait_us(4)
            .set(CR2, START & !(1 << 9))
            .wait_us(40);
    });
}

/// Breaks the rules for the bits that lower the ADC's noise, on a Nucleo at 16 MHz.
fn accuracy(table: &mut Table) {
    const PRFTEN: u32 = 1 << 8;
    const ADCDC1: u32 = 0xC000 | 1 << 13;
    const ADC1DC2: u32 = 1 << 16;
    type Writes = &'static [(u32, u32)];
    let rows: [(&str, bool, Writes); 8] = [
        ("ADCDC1", false, &[(PWR_CR, ADCDC1)]),
        (
            "prefetch off before it",
            false,
            &[(FLASH_ACR, PRFTEN), (FLASH_ACR, 0), (PWR_CR, ADCDC1)],
        ),
        (
            "prefetch on",
            true,
            &[(FLASH_ACR, PRFTEN), (PWR_CR, ADCDC1)],
        ),
        (
            "prefetch on after it",
            true,
            &[(PWR_CR, ADCDC1), (FLASH_ACR, PRFTEN)],
        ),
        (
            "both options",
            true,
            &[(PWR_CR, ADCDC1), (SYSCFG_PMC, ADC1DC2)],
        ),
        ("ADC1DC2, not converting", false, &[(SYSCFG_PMC, ADC1DC2)]),
        (
            "ADC1DC2 at 4 MHz",
            true,
            &[(SYSCFG_PMC, ADC1DC2), (CR2, START)],
        ),
        ("neither", false, &[(CR2, START)]),
    ];
    for (what, is_broken, writes) in rows {
        let mut bench = Bench::of(Board::NucleoF446reAdc);
        own_adc::configure(&mut bench);
        bench.set(APB1ENR, 1 << 28).set(APB2ENR, 1 << 8 | 1 << 14);
        bench.set(STREAM, TO_MEMORY | EN).set(CR2, ON).wait_us(4);
        for (register, value) in writes {
            bench.set(*register, *value);
        }
        table.row(AdcAccuracy, is_broken, what, bench);
    }
    let mut other = Bench::of(Board::FeatherF405Adc);
    other.set(APB1ENR, 1 << 28);
    assert!(
        other.0.write(PWR_CR, 4, ADCDC1).is_err(),
        "the STM32F405 has no ADCDC1"
    );
}

fn stream(table: &mut Table) {
    for (register, value) in [
        (NDTR, 16),
        (M0AR, BUFFER + 64),
        (PAR, SR),
        (STREAM, TO_MEMORY & !(1 << 8) | EN),
    ] {
        table.breaks(DmaEnabled, "set while it runs", converting(), |bench| {
            bench.set(register, value);
        });
    }
    table.keeps("interrupts while it runs", converting(), |bench| {
        bench.set(STREAM, TO_MEMORY & !(1 << 4) | EN);
    });
    for sees in [false, true] {
        let mut bench = converting();
        bench.set(CR2, 0).set(STREAM, TO_MEMORY).wait_us(1);
        if sees {
            assert_eq!(bench.get(STREAM) & EN, 0);
        }
        bench
            .set(LIFCR, FLAGS)
            .set(NDTR, 8)
            .set(STREAM, TO_MEMORY | EN);
        table.row(DmaStop, !sees, "on again before it has stopped", bench);
    }
    table.breaks(DmaFlags, "on again with old flags", converting(), |bench| {
        bench
            .wait_us(30)
            .set(CR2, 0)
            .set(STREAM, TO_MEMORY)
            .wait_us(1);
        assert_eq!(bench.get(STREAM) & EN, 0);
        bench.set(NDTR, 8).set(STREAM, TO_MEMORY | EN);
    });
    // Wrong: to the peripheral; bytes; words; no increment; a channel other than 0.
    for wrong in [1 << 6, 1 << 11, 1 << 12, 1 << 10, 1 << 25] {
        let what = "another direction, size or channel";
        table.breaks(DmaSetting, what, own_adc::bench(), |bench| {
            bench.set(STREAM, (TO_MEMORY | EN) ^ wrong);
        });
    }
    // Wrong: source register; CCM; an odd address; half a buffer that is not a whole number of
    // scans; no transfers.
    for (register, value) in [
        (PAR, SR),
        (M0AR, 0x1000_0000),
        (M0AR, BUFFER + 1),
        (NDTR, 6),
        (NDTR, 0),
    ] {
        let what = "another source, place or length";
        table.breaks(DmaSetting, what, own_adc::bench(), |bench| {
            bench.set(register, value).set(STREAM, TO_MEMORY | EN);
        });
    }
}

fn flash(table: &mut Table) {
    let words = 1 | 2 << 8;
    table.keeps("a word, and an erase", Bench::ready(), |bench| {
        bench
            .unlock()
            .set(FLASH_CR, words)
            .set(FREE, 0)
            .set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 16);
    });
    table.breaks(FlashWordTwice, "a word twice", Bench::ready(), |bench| {
        bench
            .unlock()
            .set(FLASH_CR, words)
            .set(FREE, 0x1234_5678)
            .set(FREE, 0x1234_0000);
    });
    let acts: [(&str, Act); 5] = [
        ("a word while it is locked", |bench| {
            bench.set(FREE, 0);
        }),
        ("another width than PSIZE", |bench| {
            bench.unlock().set(FLASH_CR, 1).set(FREE, 0);
        }),
        ("a wrong key", |bench| {
            bench.set(FLASH_KEYR, 0x4567_0124);
        }),
        ("LOCK as the sector is chosen", |bench| {
            bench.unlock().set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 31);
        }),
        ("FLASH_CR while it is locked", |bench| {
            bench.set(FLASH_CR, 1 | 2 << 8);
        }),
    ];
    for (what, act) in acts {
        table.breaks(FlashSequence, what, Bench::ready(), act);
    }
}

fn processor(table: &mut Table) {
    let watched = || {
        let mut bench = Bench::ready();
        bench
            .set(IWDG, 0xCCCC)
            .set(IWDG, 0x5555)
            .set(IWDG + 4, 0)
            .set(IWDG + 8, 31)
            .wait_us(160)
            .set(IWDG, 0xAAAA)
            .wait_us(3900);
        bench
    };
    table.keeps("a watchdog that is fed", watched(), |bench| {
        bench.set(IWDG, 0xAAAA).wait_us(3900);
    });
    table.breaks(Watchdog, "a watchdog unfed", watched(), |bench| {
        bench.wait_us(200);
        assert!(bench.0.has_bitten);
    });
    for (stack, expected) in [(STACK_END + 0x100, vec![]), (STACK_END - 8, vec![StackEnd])] {
        let broken = run(emulator(stack), |_| {});
        table
            .0
            .push(("the stack's end".to_owned(), expected, broken));
    }
    for (irqs, expected) in [(vec![], vec![]), (vec![10], vec![SpuriousInterrupt])] {
        let broken = run(emulator(STACK_END + 0x100), |emulator| {
            emulator.inject(ProcessorFault::JumpTo(0x0800_006E));
            for irq in irqs {
                emulator.bus.scs.unmask(irq);
                emulator.bus.scs.set_line(irq, true);
                emulator.bus.scs.set_line(irq, false);
            }
        });
        let what = "an interrupt without a cause";
        table.0.push((what.to_owned(), expected, broken));
    }
}

const STACK_END: u32 = 0x2000_1000;

/// Creates a board that executes an undefined instruction at once. HardFault and interrupt 10 loop.
fn emulator(stack: u32) -> Emulator {
    let mut words = [0; 28];
    // Vectors: stack, Reset, NMI, HardFault. Code: UDF, then a branch to itself.
    words[..4].copy_from_slice(&[stack, 0x0800_006D, 0, 0x0800_006F]);
    (words[26], words[27]) = (0x0800_006F, 0xE7FE_DE00);
    let image = Image::of_words(&words, "_stack_end", STACK_END);
    Emulator::new(
        Board::FeatherF405,
        &image,
        Constant::default(),
        Start::default(),
    )
    .expect("vectors")
}

fn run(mut emulator: Emulator, act: impl FnOnce(&mut Emulator)) -> Vec<Rule> {
    act(&mut emulator);
    emulator.run_ns(10_000).expect("a run");
    emulator.findings().iter().map(|one| one.rule).collect()
}
