//! Checks that an image contains code: without its link arguments, an empty image would link
//! without an error.

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection, ObjectSymbol, Symbol};
use std::fmt;

/// An interrupt: the symbol of its handler, and its number in the reference manual.
pub type Interrupt = (&'static str, usize);

/// Interrupt at DRDY's falling edge.
pub const DRDY: Interrupt = ("EXTI4", 10);
/// Interrupt when half a buffer is full of samples of the on-chip ADC.
pub const DMA: Interrupt = ("DMA2_STREAM0", 56);
/// Interrupts of the USARTs for the line.
pub const USART2: Interrupt = ("USART2", 38);
pub const USART3: Interrupt = ("USART3", 39);
/// Interrupts when half of the receive buffer of USART2 or USART3 is full.
pub const USART2_DMA: Interrupt = ("DMA1_STREAM5", 16);
pub const USART3_DMA: Interrupt = ("DMA1_STREAM1", 12);
/// Interrupt of the timer for the stylus's samples.
pub const TIM6: Interrupt = ("TIM6_DAC", 54);

/// Number of the processor's own vectors, before the first interrupt's.
const OWN_VECTORS: usize = 16;

/// Memory of an image, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Code, constants and initial values of statics.
    pub flash: u64,
    /// Flash available to the image.
    pub flash_size: u64,
    /// Statics.
    pub ram: u64,
    /// Main RAM of the chip.
    pub ram_size: u64,
    /// Reserved for the stack.
    pub stack: u64,
}

impl fmt::Display for Sizes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (flash, flash_size, ram, stack) = (self.flash, self.flash_size, self.ram, self.stack);
        write!(f, "flash {flash} of {flash_size} bytes, ")?;
        let ram_size = self.ram_size;
        write!(f, "RAM {ram} of {ram_size} bytes and {stack} for the stack")
    }
}

/// Checks an ELF image, which must handle `interrupts`, and returns its sizes.
pub fn check(image: &[u8], interrupts: &[Interrupt]) -> Result<Sizes> {
    let file = object::File::parse(image).context("no ELF file")?;
    let section = |name: &str| {
        let section = file
            .section_by_name(name)
            .with_context(|| format!("no section {name}"))?;
        ensure!(section.size() > 0, "section {name} is empty");
        Ok(section)
    };
    let symbol = |name: &str| {
        let is_it = |symbol: &Symbol| symbol.name() == Ok(name) && !symbol.is_undefined();
        let symbol = file
            .symbols()
            .find(is_it)
            .with_context(|| format!("no symbol {name}"))?;
        anyhow::Ok(symbol.address())
    };
    let text = section(".text")?;
    let code = text.address()..text.address() + text.size();

    let vectors = section(".vector_table")?;
    let table = vectors.data().context("the vector table has no content")?;
    let vector = |word: usize| {
        let bytes = table.get(4 * word..).and_then(|bytes| bytes.first_chunk());
        let bytes = bytes.context("the vector table is too short")?;
        anyhow::Ok(u64::from(u32::from_le_bytes(*bytes)))
    };
    ensure!(
        vector(0)? == symbol("_stack_start")?,
        "the vector table does not begin with the stack"
    );
    // Bit 0 of a vector marks Thumb.
    let reset = vector(1)?;
    ensure!(
        reset & 1 == 1 && code.contains(&(reset - 1)),
        "the reset vector {reset:#x} does not point to code"
    );
    for (name, number) in interrupts {
        if vector(OWN_VECTORS + number)? | 1 != symbol(name)? | 1
            || symbol(name)? == symbol("DefaultHandler")?
        {
            bail!("the interrupt {name} has no handler");
        }
    }

    let sum = |names: &[&str]| {
        let sections = names.iter().flat_map(|name| file.section_by_name(name));
        sections.map(|section| section.size()).sum()
    };
    Ok(Sizes {
        flash: sum(&[".vector_table", ".text", ".rodata", ".data"]),
        flash_size: symbol("_flash_size")?,
        ram: sum(&[".data", ".bss", ".uninit"]),
        ram_size: symbol("_ram_size")?,
        stack: symbol("_stack_start")?.saturating_sub(symbol("_stack_end")?),
    })
}

/// Returns the probe-rs name of an image's chip, which build.rs puts into a symbol's name.
pub fn chip(image: &[u8]) -> Result<String> {
    let file = object::File::parse(image).context("no ELF file")?;
    let mut names = file.symbols().filter_map(|symbol| symbol.name().ok());
    let chip = names.find_map(|name| Some(name.strip_prefix("_chip_")?.to_owned()));
    chip.context("it has no symbol _chip_...")
}

#[cfg(test)]
mod tests {
    use super::{DRDY, OWN_VECTORS, check, chip};
    use crate::elf;

    /// An image with `code` bytes of code, after its vector table at address 0.
    fn image(code: usize, drdy: u32, default: u32) -> Vec<u8> {
        let mut vectors = [default | 1; 98];
        vectors[0] = 0x2000_8000;
        vectors[1] = 1;
        vectors[OWN_VECTORS + DRDY.1] = drdy | 1;
        let table = vectors.iter().flat_map(|word| word.to_le_bytes()).collect();
        elf::image(
            &[(".vector_table", table), (".text", vec![0; code])],
            &[
                ("_stack_start", 0x2000_8000, 0),
                ("_stack_end", 0x2000_0000, 0),
                ("_flash_size", 0x8_0000, 0),
                ("_ram_size", 0x2_0000, 0),
                ("EXTI4", drdy.into(), 0),
                ("DefaultHandler", default.into(), 0),
                ("_chip_STM32F405RGTx", 0, 0),
            ],
        )
    }

    #[test]
    fn an_image_with_code_is_measured_and_others_are_refused() {
        let whole = image(1000, 64, 32);
        let sizes = check(&whole, &[DRDY]).expect("it passes");
        assert_eq!(chip(&whole).expect("a chip"), "STM32F405RGTx");
        assert_eq!(
            (sizes.flash, sizes.flash_size, sizes.ram, sizes.stack),
            (4 * 98 + 1000, 0x8_0000, 0, 0x8000)
        );
        let without_handler = image(1000, 32, 32);
        assert!(check(&without_handler, &[]).is_ok(), "if it needs none");
        for (image, words) in [
            (image(0, 64, 32), ".text is empty"),
            (without_handler, "EXTI4"),
            (Vec::new(), "no ELF file"),
            (vec![0x7f, b'E', b'L', b'F', 1, 1, 1, 0], ""),
        ] {
            let error = format!("{:#}", check(&image, &[DRDY]).expect_err(words));
            assert!(error.contains(words), "{error}");
        }
    }
}
