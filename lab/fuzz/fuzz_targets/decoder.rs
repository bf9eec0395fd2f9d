//! The fuzzer's bytes determine how frames on a line are damaged. The decoder must read exactly the
//! frames that arrive whole.
#![no_main]

#[path = "../../../tests/support/damage.rs"]
mod damage;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    damage::try_line(bytes);
});
