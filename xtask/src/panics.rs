//! Which panics are in an image. Every call that may panic hands over a `core::panic::Location`:
//! file, line, column. The linker drops those that nothing refers to, so those in an image are its
//! panics, inlined or not.

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection};
use std::collections::{BTreeMap, BTreeSet};

/// An index that is counted by a loop, or is the number of an unknown or harmonic of a shape, which
/// `Settings` bounds. No conversion, byte or request gives one. What the compiler checks there
/// would cost instructions to write otherwise.
const COUNTED: &str = "indices are counted by loops within a shape's bounds, never taken from data";

/// Panics that an image of the firmware may have, as far as the compiler knows: source file (of a
/// package from a registry its name, without version, and the file in it), most places in it, and
/// why they are no danger. A place more than that is an error: write it without, or say here why
/// not.
const ALLOWED: [(&str, usize, &str); 7] = [
    (
        "crates/finger/src/frame.rs",
        1,
        "a taxel's number, from a mask of 16 bits",
    ),
    ("crates/finger/src/touch/onset.rs", 1, COUNTED),
    (
        "cobs/src/dec.rs",
        2,
        "bounds that are compared before; host/src/requests/noise.rs sends noise",
    ),
    (
        "postcard/src/varint.rs",
        4,
        "a byte of a number, counted up to the most that it has",
    ),
    (
        "heapless/src/spsc.rs",
        2,
        "remainder by the queue's size, a constant",
    ),
    (
        "defmt-rtt/src/lib.rs",
        2,
        "a log within a log: nothing that is logged logs",
    ),
    (
        "embedded-hal-bus/src/spi/mod.rs",
        1,
        "a delay within a transfer: the driver has none",
    ),
];

/// The places that panic: lines and columns by file, as in [`ALLOWED`].
type Places = BTreeMap<String, BTreeSet<(u32, u32)>>;

/// Bytes of a `core::panic::Location` on a 32-bit target: the name's address and length, line,
/// column.
const LOCATION_BYTES: usize = 16;

/// Longest name that is believed to be one.
const NAME_BYTES_MAX: u32 = 1000;

/// The places that panic in an ELF image.
fn places(image: &[u8]) -> Result<Places> {
    let file = object::File::parse(image).context("no ELF file")?;
    // The statics' first values may refer to a place as well as the constants do.
    let sections: Vec<(u64, &[u8])> = [".rodata", ".data", ".text"]
        .iter()
        .filter_map(|name| file.section_by_name(name))
        .filter_map(|section| Some((section.address(), section.data().ok()?)))
        .collect();
    let text_at = |address: u32, length: u32| {
        sections.iter().find_map(|(from, bytes)| {
            let start = usize::try_from(u64::from(address).checked_sub(*from)?).ok()?;
            std::str::from_utf8(bytes.get(start..start.checked_add(length as usize)?)?).ok()
        })
    };
    let mut found = Places::new();
    for (_, bytes) in &sections {
        for words in (0..bytes.len().saturating_sub(LOCATION_BYTES - 1)).step_by(4) {
            let word = |at: usize| {
                let bytes = bytes[words + 4 * at..].first_chunk().copied();
                bytes.map_or(0, u32::from_le_bytes)
            };
            let (name, length, line, column) = (word(0), word(1), word(2), word(3));
            if length > NAME_BYTES_MAX || line == 0 || column == 0 {
                continue;
            }
            if let Some(name) = text_at(name, length).filter(|name| name.ends_with(".rs")) {
                found
                    .entry(shorten(name))
                    .or_default()
                    .insert((line, column));
            }
        }
    }
    Ok(found)
}

/// A file of a package from a registry without where the registry is, and without the package's
/// version.
fn shorten(name: &str) -> String {
    let Some((_, behind)) = name.split_once("/registry/src/") else {
        return name.to_owned();
    };
    let in_registry = behind.split_once('/').map_or(behind, |(_, rest)| rest);
    let Some((package, rest)) = in_registry.split_once('/') else {
        return in_registry.to_owned();
    };
    let is_version = |(at, _): &(usize, &str)| {
        package[at + 1..].starts_with(|first: char| first.is_ascii_digit())
    };
    let name = package
        .match_indices('-')
        .find(is_version)
        .map_or(package, |(at, _)| &package[..at]);
    format!("{name}/{rest}")
}

/// Checks that there are no more of them than are known; gives their number.
pub fn check(image: &[u8]) -> Result<usize> {
    let found = places(image)?;
    let mut more = Vec::new();
    for (file, places) in &found {
        let most = ALLOWED
            .iter()
            .find(|(allowed, ..)| allowed == file)
            .map_or(0, |(_, places, _)| *places);
        if places.len() > most {
            let list: Vec<String> = places
                .iter()
                .map(|(line, column)| format!("{file}:{line}:{column}"))
                .collect();
            more.push(format!(
                "{} places in {file}, {most} known: {}",
                places.len(),
                list.join(", ")
            ));
        }
    }
    ensure!(
        more.is_empty(),
        "it may panic where it was not known to; write that without, or list it in xtask/src/panics.rs with a reason\n{}",
        more.join("\n")
    );
    Ok(found.values().map(BTreeSet::len).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elf;

    /// An image with these places in its constants, which lie at address 0, a word of something
    /// else before each.
    fn image(places: &[(&str, u32, u32)]) -> Vec<u8> {
        let (mut words, mut names) = (Vec::new(), Vec::new());
        let names_at = 20 * places.len();
        for (name, line, column) in places {
            words.extend([
                0xdead_beef,
                (names_at + names.len()) as u32,
                name.len() as u32,
                *line,
                *column,
            ]);
            names.extend(name.bytes());
        }
        let mut bytes: Vec<u8> = words
            .iter()
            .flat_map(|word: &u32| word.to_le_bytes())
            .collect();
        bytes.extend(names);
        elf::image(&[(".rodata", bytes)], &[])
    }

    #[test]
    fn places_are_found_with_the_registry_s_path_taken_off() {
        let registry =
            "/home/someone/.cargo/registry/src/index-1949cf8c6b5b557f/defmt-rtt-1.3.1/src/lib.rs";
        let found =
            places(&image(&[("src/search.rs", 153, 11), (registry, 173, 13)])).expect("places");
        let place = |file: &str, place| (file.to_owned(), BTreeSet::from([place]));
        let expected = [
            place("defmt-rtt/src/lib.rs", (173, 13)),
            place("src/search.rs", (153, 11)),
        ];
        assert_eq!(found, BTreeMap::from(expected));
    }

    #[test]
    fn a_panic_that_was_not_known_is_refused_with_its_place() {
        let known = [("cobs/src/dec.rs", 50, 27), ("cobs/src/dec.rs", 86, 35)];
        assert_eq!(check(&image(&known)).expect("known"), 2);
        let one_more = [known[0], known[1], ("cobs/src/dec.rs", 90, 1)];
        let error = check(&image(&one_more)).expect_err("one more").to_string();
        assert!(
            error.contains("3 places in cobs/src/dec.rs, 2 known") && error.contains("dec.rs:90:1"),
            "{error}"
        );
        let other = check(&image(&[("src/search.rs", 153, 11)]))
            .expect_err("not known")
            .to_string();
        assert!(other.contains("src/search.rs:153:11"), "{other}");
    }

    #[test]
    fn an_image_without_a_panic_has_none() {
        assert_eq!(check(&image(&[])).expect("none"), 0);
        assert!(check(b"").is_err());
    }
}
