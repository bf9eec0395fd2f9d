//! Bytes as what happens to frames on a line: what comes through is read, and nothing else is.
#![no_main]

#[path = "../../tests/support/damage.rs"]
mod damage;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    damage::try_line(bytes);
});
