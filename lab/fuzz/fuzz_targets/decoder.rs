//! Damages frames on a line as the fuzzer's bytes determine. The decoder must read the frames that
//! arrive whole, and nothing else.
#![no_main]

#[path = "../../../tests/support/damage.rs"]
mod damage;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    damage::try_line(bytes);
});
