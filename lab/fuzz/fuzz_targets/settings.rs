//! Uses the fuzzer's bytes as settings: they are refused, or the pipeline runs with them.
#![no_main]

#[path = "../../../tests/support/any_settings.rs"]
mod any_settings;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    any_settings::try_settings(bytes);
});
