//! Tests of several modules together, and that the pages in `docs/results` are what their figures
//! give.

mod bound;
mod emulated_faults;
mod faults;
mod methods;
mod nls;
pub mod pages;
mod trade;

pub fn from_root(path: &str) -> std::path::PathBuf {
    std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path)
}

pub fn read(path: &str) -> String {
    std::fs::read_to_string(from_root(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}
