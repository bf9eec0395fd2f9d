//! Finds the panics in an image. Every call that may panic refers to a `core::panic::Location`:
//! file, line, column. The linker drops unreferenced locations, so those left in an image are its
//! panics, inlined or not.

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSection};
use std::collections::{BTreeMap, BTreeSet};

/// Panics allowed in a firmware image: source file (for a registry package its name without
/// version, and the file), maximum number of places, and why they cannot occur. An additional place
/// is an error: avoid the panic, or give the reason here.
///
/// An index that is a loop counter, or that numbers a shape's unknowns or harmonics, is bounded by
/// `Settings`; it never comes from a conversion, a received byte or a request. Avoiding its bounds
/// check would cost instructions.
const ALLOWED: &str = "
crates/finger/src/frame.rs        1  a taxel's number, from a mask of 16 bits
crates/finger/src/touch/onset.rs  1  indices are counted by loops within a shape's bounds, never taken from data
cobs/src/dec.rs                   2  bounds that are compared before; host/src/requests/noise.rs sends noise
postcard/src/varint.rs            4  a byte of a number, counted up to the most that it has
heapless/src/spsc.rs              2  remainder by the queue's size, a constant
defmt-rtt/src/lib.rs              2  a log within a log: nothing that is logged logs
embedded-hal-bus/src/spi/mod.rs   1  a delay within a transfer: the driver has none
";

/// Number of places that [`ALLOWED`] allows in a file.
fn allowed(file: &str) -> usize {
    let mut words = ALLOWED.lines().map(str::split_whitespace);
    let mut row = words.find_map(|mut row| (row.next() == Some(file)).then_some(row));
    row.as_mut()
        .and_then(|row| row.next()?.parse().ok())
        .unwrap_or(0)
}

/// Places that panic: lines and columns by file, as in [`ALLOWED`].
type Places = BTreeMap<String, BTreeSet<(u32, u32)>>;

/// Size of a `core::panic::Location` on a 32-bit target: address and length of the name, line,
/// column.
const LOCATION_BYTES: usize = 16;

/// Maximum length of a plausible name.
const NAME_BYTES_MAX: u32 = 1000;

/// Finds the places that panic in an ELF image.
fn places(image: &[u8]) -> Result<Places> {
    let file = object::File::parse(image).context("no ELF file")?;
    // Initial values of statics may contain locations, as constants do.
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

/// Shortens the path of a file in a registry package: without the registry's location and the
/// version.
fn shorten(name: &str) -> String {
    let Some((_, behind)) = name.split_once("/registry/src/") else {
        return name.to_owned();
    };
    let mut parts = behind.splitn(3, '/').skip(1);
    let (package, rest) = (
        parts.next().unwrap_or_default(),
        parts.next().unwrap_or_default(),
    );
    let is_version = |part: &&str| part.starts_with(|first: char| first.is_ascii_digit());
    let words = package.split('-').take_while(|part| !is_version(part));
    format!("{}/{rest}", words.collect::<Vec<_>>().join("-"))
}

/// Checks that the image has no more panics than allowed; returns their number.
pub fn check(image: &[u8]) -> Result<usize> {
    let found = places(image)?;
    let mut more = Vec::new();
    for (file, places) in &found {
        let max = allowed(file);
        if places.len() > max {
            let list = places
                .iter()
                .map(|(line, column)| format!(" {file}:{line}:{column}"));
            let (count, list) = (places.len(), list.collect::<String>());
            more.push(format!("{count} places in {file}, {max} known:{list}"));
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

    /// An image with `places` in its constants, which start at address 0, each after an unrelated
    /// word.
    fn image(places: &[(&str, u32, u32)]) -> Vec<u8> {
        let (mut bytes, mut names) = (Vec::new(), Vec::new());
        for (name, line, column) in places {
            let at = 20 * places.len() + names.len();
            for word in [0xdead_beef, at as u32, name.len() as u32, *line, *column] {
                bytes.extend(word.to_le_bytes());
            }
            names.extend(name.bytes());
        }
        elf::image(&[(".rodata", [bytes, names].concat())], &[])
    }

    #[test]
    fn places_are_found_and_those_that_were_not_known_are_refused() {
        let registry =
            "/home/someone/.cargo/registry/src/index-1949cf8c6b5b557f/defmt-rtt-1.3.1/src/lib.rs";
        let known = ("cobs/src/dec.rs", 50, 27);
        for (found, expected) in [
            (&[][..], Ok(0)),
            (
                &[known, ("cobs/src/dec.rs", 86, 35), (registry, 173, 13)],
                Ok(3),
            ),
            (
                &[
                    known,
                    ("cobs/src/dec.rs", 86, 35),
                    ("cobs/src/dec.rs", 90, 1),
                ],
                Err("3 places in cobs/src/dec.rs, 2 known: cobs/src/dec.rs:50:27"),
            ),
            (&[("src/search.rs", 153, 11)], Err("src/search.rs:153:11")),
        ] {
            match (check(&image(found)), expected) {
                (Ok(count), Ok(expected)) => assert_eq!(count, expected),
                (Err(error), Err(words)) => assert!(error.to_string().contains(words), "{error}"),
                (other, _) => panic!("{found:?}: {other:?}"),
            }
        }
        let places = places(&image(&[(registry, 173, 13)])).expect("places");
        assert_eq!(places["defmt-rtt/src/lib.rs"], BTreeSet::from([(173, 13)]));
        assert!(check(b"").is_err());
    }
}
