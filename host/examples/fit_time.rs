//! Prints the shortest time of a fit in milliseconds, without starting a process and without
//! Python: once including reading a file, once with the same rows in memory. Both include
//! formatting the result as JSON. `host/python/benchmark.py` prints these times next to the
//! package's.

use anyhow::{Context, Result};
use ridgetone_host::fit_report::json;
use ridgetone_host::samples::Samples;
use ridgetone_host::table_fit::{Selection, fit};
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Minimum number of runs, and minimum duration of all runs together.
const RUNS_MIN: u32 = 10;
const DURATION_MIN: Duration = Duration::from_millis(500);

fn main() -> Result<()> {
    let path = std::env::args().nth(1).context("a file")?;
    let file = Samples::file(Path::new(&path))?;
    let mut rows = file.open()?;
    let names = rows.names().to_vec();
    let (mut row, mut values, mut times) = (Vec::new(), Vec::new(), Vec::new());
    while rows.advance()? {
        rows.values(&mut row)?;
        values.extend_from_slice(&row);
        times.extend(rows.time_s());
    }
    let (columns, count) = (names.len(), times.len());
    let value_at = Arc::new(move |row: usize, column: usize| values[row * columns + column]);
    let memory = Samples::array(
        "array",
        names,
        count,
        value_at,
        Some(Arc::new(move |row| times[row])),
    );
    let mut best_ms = [f64::INFINITY; 2];
    for (best_ms, samples) in best_ms.iter_mut().zip([&file, &memory]) {
        // Ten runs of 0.25 ms end before the processor's caches and clock have warmed up.
        let (started, mut runs) = (Instant::now(), 0);
        while runs < RUNS_MIN || started.elapsed() < DURATION_MIN {
            let begun = Instant::now();
            let found = fit(&mut *samples.open()?, &Selection::default(), &mut |_| {})?;
            black_box(json(samples.name(), &found)?);
            *best_ms = best_ms.min(1e3 * begun.elapsed().as_secs_f64());
            runs += 1;
        }
    }
    println!("{} {}", best_ms[0], best_ms[1]);
    Ok(())
}
