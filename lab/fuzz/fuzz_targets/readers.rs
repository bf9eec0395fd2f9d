//! Reads the fuzzer's bytes as a file or a request; the first byte chooses which.
#![no_main]

#[path = "../../../host/tests/hostile/readers.rs"]
mod readers;

use readers::Reader;

const ALL: [Reader; 6] = [
    Reader::Rows,
    Reader::Recording,
    Reader::Mcap,
    Reader::Settings,
    Reader::Scene,
    Reader::Request,
];

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Some((first, bytes)) = bytes.split_first() {
        ALL[usize::from(*first) % ALL.len()].accepts(bytes);
    }
});
