//! What a process takes, as Linux tells it.
#![allow(dead_code, reason = "every test file uses a part of it")]

/// Scheduler ticks a second, as Linux reports processor time in.
const TICKS_HZ: f64 = 100.0;

/// Processor time of a process so far, seconds.
pub fn processor_s(id: u32) -> f64 {
    let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).expect("a process");
    let fields: Vec<&str> = stat
        .rsplit(") ")
        .next()
        .expect("fields")
        .split(' ')
        .collect();
    // utime and stime (proc(5)).
    fields[11..13]
        .iter()
        .map(|field| field.parse::<f64>().expect("ticks"))
        .sum::<f64>()
        / TICKS_HZ
}

/// Memory of a process now, megabytes.
pub fn memory_mb(id: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).expect("a process");
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
    kilobytes.expect("a size") / 1e3
}
