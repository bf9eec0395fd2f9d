//! Lists an image's flash by crate and RAM by static, to show where it grows. The linker refuses an
//! image that exceeds the part's memory (`memory.x`).
//!
//! The compiler may inline functions across crates; such code counts for the crate that it was
//! inlined into.

use anyhow::{Context, Result};
use object::{Object, ObjectSymbol};
use std::collections::BTreeMap;

const RAM_ADDRESS: u64 = 0x2000_0000;

/// Sum of symbols without crate or name, and of all rows below [`SMALL`].
const OTHER: &str = "all else";

/// Minimum size of a crate or static with its own row, bytes.
const SMALL: u64 = 500;

/// Constants without a name.
const CONSTANTS: &str = "constants";

/// Rows for flash and RAM, the largest first.
pub fn table(image: &[u8]) -> Result<String> {
    let file = object::File::parse(image).context("no ELF file")?;
    let (mut flash, mut ram) = (BTreeMap::new(), BTreeMap::new());
    // Functions with identical code share an address, as a function and its aliases do.
    let mut places: Vec<_> = file
        .symbols()
        .filter(|one| one.size() > 0 && !one.is_undefined())
        .collect();
    places.sort_by_key(|one| (one.address() & !1, !one.is_global()));
    places.dedup_by_key(|one| one.address() & !1);
    for symbol in places {
        let name = rustc_demangle::demangle(symbol.name().unwrap_or_default());
        let name = format!("{name:#}");
        let (memory, name) = match symbol.address() < RAM_ADDRESS {
            true => (&mut flash, crate_of(&name)),
            false => (&mut ram, static_of(&name)),
        };
        *memory.entry(name.to_owned()).or_insert(0) += symbol.size();
    }
    Ok(rows("flash", &flash) + &rows("RAM", &ram))
}

fn rows(memory: &str, used: &BTreeMap<String, u64>) -> String {
    let is_small = |(name, bytes): &(&String, &u64)| **bytes < SMALL || *name == OTHER;
    let (small, mut large): (Vec<_>, Vec<_>) = used.iter().partition(is_small);
    large.sort_by_key(|(_, bytes)| std::cmp::Reverse(**bytes));
    let small = small.iter().map(|(_, bytes)| **bytes).sum();
    let rows = large
        .into_iter()
        .map(|(name, bytes)| (name.as_str(), *bytes));
    let row = |(name, bytes)| format!("{memory:>19}  {name:<18} {bytes:>6} bytes\n");
    rows.chain([(OTHER, small)]).map(row).collect()
}

/// Crate of a function or constant: the first name before `::`. Names without it are interrupt
/// handlers, in capitals, nameless constants, and additions of compiler and linker. The stylus's
/// binary counts under the finger's name.
fn crate_of(name: &str) -> &str {
    let is_part = |character: char| character.is_ascii_alphanumeric() || character == '_';
    match name.split_once("::") {
        _ if name.starts_with(".L") => CONSTANTS,
        Some((first, _)) => match first.rsplit(|character| !is_part(character)).next() {
            Some("ridgetone_stylus_firmware") | None => "ridgetone_firmware",
            Some(name) => name,
        },
        None if name.starts_with(|first: char| first.is_ascii_uppercase()) => "ridgetone_firmware",
        None => OTHER,
    }
}

/// Name of a static, without RTIC's prefix.
fn static_of(name: &str) -> &str {
    let name = name.rsplit("::").next().unwrap_or(name);
    let Some(rtic) = name.strip_prefix("__rtic_internal_") else {
        return name;
    };
    let rtic = rtic
        .trim_start_matches("shared_resource_")
        .trim_start_matches("local_");
    rtic.trim_start_matches("init_")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf;

    /// Bytes in a table row.
    fn row(table: &str, memory: &str, name: &str) -> Option<u64> {
        let rows = table
            .lines()
            .filter_map(|line| line.trim().strip_prefix(memory));
        let mut bytes = rows.filter_map(|row| row.trim().strip_prefix(name)?.strip_suffix("bytes"));
        bytes.next()?.trim().parse().ok()
    }

    /// Mangled names of a function, a trait's method, its alias, a handler, a constant and a
    /// static.
    #[test]
    fn bytes_count_for_the_crate_or_static_whose_they_are() {
        let table = table(&elf::image(&[], &[
            ("_ZN14ridgetone_tone6refine6refine17h2b82fad203c35ef4E", 0x0800_0101, 1000),
            (
                "_ZN93_$LT$ridgetone_proto..store..FlashStore$LT$F$GT$$u20$as$u20$ridgetone_proto..store..Store$GT$4load17h05fdca9fd8eadb85E",
                0x0800_0201,
                2000,
            ),
            ("an_alias_of_it", 0x0800_0201, 2000),
            ("EXTI4", 0x0800_0301, 3000),
            (".Lanon.279d436c5c270687ae19ea2501ec2b3f.23", 0x0800_0401, 4000),
            ("__aeabi_memcpy4", 0x0800_0501, 5),
            ("_ZN18ridgetone_firmware3app31__rtic_internal_local_init_ring17he4817fb32e12982dE", 0x2000_8000, 6000),
            ("_ZN9defmt_rtt6BUFFER17he4817fb32e12982dE", 0x2000_0000, 512),
        ]))
        .expect("a table");
        for (memory, name, bytes) in [
            ("flash", "ridgetone_tone", 1000),
            ("flash", "ridgetone_proto", 2000),
            ("flash", "ridgetone_firmware", 3000),
            ("flash", "constants", 4000),
            ("flash", OTHER, 5),
            ("RAM", "ring", 6000),
            ("RAM", "BUFFER", 512),
        ] {
            assert_eq!(row(&table, memory, name), Some(bytes), "{name}\n{table}");
        }
    }
}
