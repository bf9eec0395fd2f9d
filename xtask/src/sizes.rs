//! What an image takes of flash by crate and of RAM by static, against budgets: a step that grows
//! is seen where it grows.
//!
//! The compiler merges functions across crates: a function counts for the crate that it was merged
//! into.

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSymbol};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Where RAM begins.
const RAM_ADDRESS: u64 = 0x2000_0000;

/// What is in no row of its own.
const OTHER: &str = "all else";

/// Constants without a name.
const CONSTANTS: &str = "constants";

/// Most bytes of an image.
pub struct Budgets {
    /// Flash by crate.
    flash: &'static [(&'static str, u64)],
    /// RAM by static, without the stack's 17 KiB.
    ram: &'static [(&'static str, u64)],
}

/// A finger's.
pub const FINGER: Budgets = Budgets {
    flash: &FLASH,
    ram: &RAM,
};

/// The emulated finger's budget. Its chip is simulated on a PC, which takes more code than a
/// board's peripherals, and no board has to hold it.
pub const EMULATED: Budgets = Budgets {
    flash: &[
        ("ridgetone_tone", 89_000),
        ("ridgetone_finger", 62_000),
        ("ridgetone_firmware", 46_000),
        ("ridgetone_proto", 13_500),
        ("microfft", 6_600),
        ("ridgetone_feel", 3_000),
        (CONSTANTS, 6_000),
        (OTHER, 22_000),
    ],
    ram: &[
        ("ring", 78_432),
        ("estimator_place", 23_400),
        ("detector_place", 4_280),
        ("outbox", 3_416),
        ("samples", 712),
        (OTHER, 4_256),
    ],
};

/// The stylus's budget: what it takes and a tenth. The chip has room for more; a step that grows is
/// noticed.
pub const STYLUS: Budgets = Budgets {
    flash: &[
        ("ridgetone_teletaction", 3_200),
        ("ridgetone_finger", 300),
        ("ridgetone_proto", 700),
        ("ridgetone_firmware", 13_000),
        (CONSTANTS, 900),
        (OTHER, 7_300),
    ],
    // What tasks share holds a robot's places too, which a stylus does not use: 600 bytes.
    ram: &[("outbox", 1_200), ("bytes", 624), (OTHER, 2_500)],
};

/// Most bytes of flash by crate. Together they are the 224 KiB that an image may take; the smaller
/// board has 256.
const FLASH: [(&str, u64); 8] = [
    ("ridgetone_tone", 89_000),
    ("ridgetone_finger", 60_000),
    ("ridgetone_firmware", 35_000),
    ("ridgetone_proto", 14_000),
    ("microfft", 6_600),
    ("ridgetone_feel", 3_000),
    (CONSTANTS, 6_000),
    (OTHER, 15_000),
];

/// Most bytes of RAM by static, without the stack's 17 KiB. Together they are no more than 111 KiB,
/// what the stack leaves of the smaller board's 128.
const RAM: [(&str, u64); 6] = [
    ("ring", 78_432),
    ("estimator_place", 23_400),
    ("detector_place", 4_280),
    ("outbox", 3_416),
    ("samples", 712),
    (OTHER, 4_108),
];

/// A table of both, by line, or an error that says which budget is exceeded.
pub fn table(image: &[u8], budgets: &Budgets) -> Result<String> {
    let file = object::File::parse(image).context("no ELF file")?;
    let (mut flash, mut ram) = (BTreeMap::new(), BTreeMap::new());
    // Functions with the same code are one; so are a function and its aliases.
    let mut places: Vec<_> = file
        .symbols()
        .filter(|one| one.size() > 0 && !one.is_undefined())
        .collect();
    places.sort_by_key(|one| (one.address() & !1, !one.is_global()));
    places.dedup_by_key(|one| one.address() & !1);
    for symbol in places {
        let name = format!(
            "{:#}",
            rustc_demangle::demangle(symbol.name().unwrap_or_default())
        );
        if symbol.address() < RAM_ADDRESS {
            *flash
                .entry(known(crate_of(&name), budgets.flash))
                .or_default() += symbol.size();
        } else {
            *ram.entry(known(static_of(&name), budgets.ram)).or_default() += symbol.size();
        }
    }
    Ok(rows("flash", &flash, budgets.flash)? + &rows("RAM", &ram, budgets.ram)?)
}

fn rows(memory: &str, used: &BTreeMap<&str, u64>, budgets: &[(&str, u64)]) -> Result<String> {
    let mut rows = String::new();
    for (name, budget) in budgets {
        let bytes = used.get(name).copied().unwrap_or_default();
        ensure!(
            bytes <= *budget,
            "{name} takes {bytes} bytes of {memory}, its budget is {budget}: make it smaller, or raise the budget in \
             xtask/src/sizes.rs and say why in the commit"
        );
        writeln!(
            rows,
            "{memory:>19}  {name:<18} {bytes:>6} of {budget:>6} bytes"
        )?;
    }
    Ok(rows)
}

/// A name, if it has a row.
fn known(name: &str, rows: &[(&'static str, u64)]) -> &'static str {
    rows.iter()
        .find(|(row, _)| *row == name)
        .map_or(OTHER, |(row, _)| row)
}

/// The crate of a function or constant: the first name before `::`. Those without are handlers of
/// interrupts, in capitals, nameless constants, and what compiler and linker add.
fn crate_of(name: &str) -> &str {
    if name.starts_with(".L") {
        return CONSTANTS;
    }
    let is_part = |character: char| character.is_ascii_alphanumeric() || character == '_';
    match name.find("::") {
        Some(end) => match &name[name[..end]
            .rfind(|character| !is_part(character))
            .map_or(0, |at| at + 1)..end]
        {
            // A stylus's binary has the same part as a finger's.
            "ridgetone_stylus_firmware" => "ridgetone_firmware",
            name => name,
        },
        None if name.starts_with(|first: char| first.is_ascii_uppercase()) => "ridgetone_firmware",
        None => OTHER,
    }
}

/// The name of a static, without what RTIC puts before it.
fn static_of(name: &str) -> &str {
    let name = name.rsplit("::").next().unwrap_or(name);
    let rtic = [
        "__rtic_internal_local_init_",
        "__rtic_internal_local_",
        "__rtic_internal_shared_resource_",
    ];
    rtic.iter()
        .find_map(|prefix| name.strip_prefix(prefix))
        .unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use object::write::{Object, Symbol, SymbolSection};
    use object::{Architecture, BinaryFormat, Endianness, SymbolFlags, SymbolKind, SymbolScope};

    /// An image with these symbols: name, address, bytes.
    fn image(symbols: &[(&str, u64, u64)]) -> Vec<u8> {
        let mut object = Object::new(BinaryFormat::Elf, Architecture::Arm, Endianness::Little);
        for (name, value, size) in symbols {
            object.add_symbol(Symbol {
                name: name.bytes().collect(),
                value: *value,
                size: *size,
                kind: SymbolKind::Text,
                scope: SymbolScope::Linkage,
                weak: false,
                section: SymbolSection::Absolute,
                flags: SymbolFlags::None,
            });
        }
        object.write().expect("an ELF file")
    }

    fn row(table: &str, memory: &str, name: &str) -> u64 {
        let row = table.lines().find(|line| {
            let mut words = line
                .trim_start()
                .strip_prefix(memory)
                .unwrap_or_default()
                .split("  ")
                .filter(|w| !w.is_empty());
            words.next().is_some_and(|word| {
                word.trim_start().starts_with(&format!("{name} ")) || word.trim() == name
            })
        });
        let row = row.unwrap_or_else(|| panic!("no row {name} in\n{table}"));
        row.split(" of ")
            .next()
            .and_then(|row| row.rsplit(' ').next())
            .and_then(|bytes| bytes.parse().ok())
            .expect(row)
    }

    /// Names as the compiler mangles them: a function, a method of a trait, its alias, a handler, a
    /// constant, a static.
    #[test]
    fn bytes_count_for_the_crate_or_static_whose_they_are() {
        let table = table(&image(&[
            ("_ZN14ridgetone_tone6refine6refine17h2b82fad203c35ef4E", 0x0800_0101, 100),
            (
                "_ZN93_$LT$ridgetone_proto..store..FlashStore$LT$F$GT$$u20$as$u20$ridgetone_proto..store..Store$GT$4load17h05fdca9fd8eadb85E",
                0x0800_0201,
                200,
            ),
            ("an_alias_of_it", 0x0800_0201, 200),
            ("EXTI4", 0x0800_0301, 30),
            (".Lanon.279d436c5c270687ae19ea2501ec2b3f.23", 0x0800_0401, 4),
            ("__aeabi_memcpy4", 0x0800_0501, 5),
            ("_ZN18ridgetone_firmware3app31__rtic_internal_local_init_ring17he4817fb32e12982dE", 0x2000_8000, 6000),
            ("_ZN9defmt_rtt6BUFFER17he4817fb32e12982dE", 0x2000_0000, 512),
        ]), &FINGER)
        .expect("within the budgets");
        let expected = [
            ("ridgetone_tone", 100),
            ("ridgetone_proto", 200),
            ("ridgetone_firmware", 30),
            ("constants", 4),
            (OTHER, 5),
        ];
        for (name, bytes) in expected {
            assert_eq!(row(&table, "flash", name), bytes, "{name}\n{table}");
        }
        assert_eq!(
            (row(&table, "RAM", "ring"), row(&table, "RAM", OTHER)),
            (6000, 512),
            "{table}"
        );
    }

    #[test]
    fn a_crate_above_its_budget_is_refused_by_name() {
        let name = "_ZN14ridgetone_tone6refine6refine17h2b82fad203c35ef4E";
        let [(_, budget), ..] = FLASH;
        assert!(table(&image(&[(name, 0x0800_0101, budget)]), &FINGER).is_ok());
        let error = table(&image(&[(name, 0x0800_0101, budget + 1)]), &FINGER)
            .expect_err("too large")
            .to_string();
        assert!(
            error.contains(&format!(
                "ridgetone_tone takes {} bytes of flash",
                budget + 1
            )),
            "{error}"
        );
    }

    /// 224 KiB of flash, and of RAM what the stack leaves (memory.x).
    #[test]
    fn the_budgets_together_are_what_the_smaller_board_allows() {
        assert!(FLASH.iter().map(|(_, bytes)| bytes).sum::<u64>() <= 224 * 1024);
        assert!(RAM.iter().map(|(_, bytes)| bytes).sum::<u64>() <= (128 - 16) * 1024);
    }
}
