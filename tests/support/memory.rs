//! Memory in use by this process.

/// Resident memory of this process, bytes, if the system reports it (proc(5), statm: the second
/// number, in pages of 4 KiB).
pub fn resident_bytes() -> Option<u64> {
    let pages = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(pages.split_ascii_whitespace().nth(1)?.parse::<u64>().ok()? * 4096)
}
