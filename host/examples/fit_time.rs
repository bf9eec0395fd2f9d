//! Milliseconds that a fit takes without Python and without a process around it, best of ten: of a file, read and fitted, and
//! of its rows in memory. `python/benchmark.py` prints them beside the package's.

use anyhow::{Context, Result};
use ridgetone_host::samples::Samples;
use ridgetone_host::table_fit::{Selection, fit};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

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
    let memory = Samples::array("array", names, count, value_at, Some(Arc::new(move |row| times[row])));
    let mut best_ms = [f64::INFINITY; 2];
    for _ in 0..10 {
        for (best_ms, samples) in best_ms.iter_mut().zip([&file, &memory]) {
            let begun = Instant::now();
            fit(&mut *samples.open()?, &Selection::default(), &mut |_| {})?;
            *best_ms = best_ms.min(1e3 * begun.elapsed().as_secs_f64());
        }
    }
    println!("{} {}", best_ms[0], best_ms[1]);
    Ok(())
}
