//! Checks the stack frames of an image's functions: a large value that is built on the stack,
//! instead of in place, shows up as a frame of its size.

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection, ObjectSymbol};

/// Maximum frame, bytes: a fifth of the stack.
const FRAME_MAX: u32 = 4096;

/// A function and its stack frame, bytes.
type Frame = (String, u32);

/// Fails if a function's frame is larger than [`FRAME_MAX`]; returns the largest.
pub fn check(image: &[u8]) -> Result<Frame> {
    let mut frames = frames(image)?;
    frames.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
    let large = frames.iter().filter(|(_, bytes)| *bytes > FRAME_MAX);
    let large: Vec<_> = large
        .map(|(name, bytes)| format!("{bytes} in {name}"))
        .collect();
    ensure!(
        large.is_empty(),
        "stack frames of more than {FRAME_MAX} bytes: {}: make the large value in a static, in place",
        large.join(", ")
    );
    frames.into_iter().next().context("no function")
}

/// Stack frames of functions that use `sub sp` (Thumb-2). Pushed registers add at most 100 bytes.
fn frames(image: &[u8]) -> Result<Vec<Frame>> {
    let file = object::File::parse(image).context("no ELF file")?;
    let text = file.section_by_name(".text").context("no section .text")?;
    let code = text.data().context(".text has no content")?;
    let mut frames = Vec::new();
    for symbol in file.symbols().filter(|one| one.size() > 0) {
        // Bit 0 of a function's address marks Thumb.
        let from = (symbol.address() & !1).checked_sub(text.address());
        let range = from.map(|from| from as usize..(from + symbol.size()) as usize);
        let Some(body) = range.and_then(|range| code.get(range)) else {
            continue;
        };
        let (halves, _) = body.as_chunks::<2>();
        let halves: Vec<u16> = halves.iter().copied().map(u16::from_le_bytes).collect();
        // A frame whose size does not fit an immediate takes two consecutive instructions.
        let mut bytes: u32 = 0;
        let (mut at, mut in_a_row) = (0, 0);
        while at < halves.len() {
            let (taken, length) = taken(&halves[at..]);
            in_a_row = if taken > 0 { in_a_row + taken } else { 0 };
            bytes = bytes.max(in_a_row);
            at += length;
        }
        if bytes > 0 {
            let name = rustc_demangle::demangle(symbol.name().unwrap_or_default());
            frames.push((format!("{name:#}"), bytes));
        }
    }
    Ok(frames)
}

/// Bytes that the first instruction subtracts from the stack pointer, and its length in half words
/// (DDI 0403E, A7.7.176: SUB (SP minus immediate), encodings T1, T2 and T3).
fn taken(code: &[u16]) -> (u32, usize) {
    let (first, second) = (code[0], code.get(1).copied().unwrap_or(0));
    if first & 0xFF80 == 0xB080 {
        return (u32::from(first & 0x7F) * 4, 1);
    }
    if first >> 11 < 0b11101 {
        return (0, 1);
    }
    let imm = u32::from(first >> 10 & 1) << 11
        | u32::from(second >> 12 & 7) << 8
        | u32::from(second & 0xFF);
    let is_to_sp = second & 0x8F00 == 0x0D00;
    let taken = match first & !0x0400 {
        0xF2AD if is_to_sp => imm,
        0xF1AD if is_to_sp => expanded(imm),
        _ => 0,
    };
    (taken, 2)
}

/// Expands a modified immediate (DDI 0403E, A5.3.2).
fn expanded(imm: u32) -> u32 {
    let byte = imm & 0xFF;
    match imm >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte * 0x0101_0101,
        _ => (imm & 0x7F | 0x80).rotate_right(imm >> 7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf;

    /// Encodings from `llvm-mc -triple=thumbv7em -show-encoding`.
    #[test]
    fn frames_are_read_from_code_and_large_ones_refused() {
        let cases: [(&str, &[u16], u32); 7] = [
            ("sub sp, #508", &[0xB0FF], 508),
            ("sub.w sp, sp, #4096", &[0xF5AD, 0x5D80], 4096),
            ("sub.w sp, sp, #18432", &[0xF5AD, 0x4D90], 18432),
            ("subw sp, sp, #4095", &[0xF6AD, 0x7DFF], 4095),
            ("one after the other", &[0xF5AD, 0x5D80, 0xB082], 4104),
            ("in two branches", &[0xB082, 0xBF00, 0xB083], 12),
            ("within another instruction", &[0xF04F, 0xB0FF], 0),
        ];
        for (what, code, bytes) in cases {
            let text: Vec<u8> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
            let size = text.len() as u64;
            // The function follows one with a small frame.
            let text = [&[0x81, 0xB0, 0x00, 0xBF][..], &text].concat();
            let image = elf::image(&[(".text", text)], &[("small", 1, 4), ("what", 5, size)]);
            let checked = check(&image);
            if bytes > FRAME_MAX {
                let error = checked.expect_err(what).to_string();
                assert!(error.contains(&format!("{bytes} in what")), "{error}");
            } else {
                let (_, largest) = checked.expect(what);
                assert_eq!(largest, bytes.max(4), "{what}");
            }
        }
    }
}
