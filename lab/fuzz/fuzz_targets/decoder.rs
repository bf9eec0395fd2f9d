//! The fuzzer's bytes determine how frames are damaged on a line. The decoder must read the frames
//! that arrive whole, and nothing else.
#![no_main]

#[path = "../../../tests/support/damage.rs"]
mod damage;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    damage::try_line(bytes);
});
