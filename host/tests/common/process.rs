//! What a process takes, as Linux tells it.
#![allow(dead_code, reason = "every test file uses a part of it")]

/// Scheduler ticks a second, as Linux reports processor time in.
const TICKS_HZ: f64 = 100.0;

/// Processor time of a process so far, seconds.
pub fn processor_s(id: u32) -> f64 {
    find_processor_s(id).expect("a process")
}

/// Memory of a process now, megabytes.
pub fn memory_mb(id: u32) -> f64 {
    find_memory_mb(id).expect("a process")
}

pub fn find_processor_s(id: u32) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    let mut fields = stat.rsplit(") ").next()?.split(' ').skip(11);
    // utime and stime (proc(5)).
    let mut ticks = || fields.next()?.parse::<f64>().ok();
    Some((ticks()? + ticks()?) / TICKS_HZ)
}

/// Memory of a process now, megabytes; none of one that has ended, even if nobody has waited for it.
pub fn find_memory_mb(id: u32) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: f64 = line.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kilobytes / 1e3)
}
