//! Works on all cores in parallel, and returns the results in order.

use anyhow::Result;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use ridgetone_host::output::Progress;
use std::sync::Mutex;

/// Applies `work` to every item and shows progress. The results do not depend on the number of
/// cores.
pub fn map<T: Sync, R: Send>(
    what: &str,
    items: &[T],
    work: impl Fn(&T) -> Result<R> + Sync,
) -> Result<Vec<R>> {
    let progress = Mutex::new((0, Progress::default()));
    let counted = |item: &T| {
        let result = work(item);
        if let Ok(mut progress) = progress.lock() {
            let (done, line) = &mut *progress;
            *done += 1;
            line.show_count(what, *done as u64, items.len() as u64);
        }
        result
    };
    let results = items.par_iter().map(counted).collect();
    if let Ok((_, mut line)) = progress.into_inner() {
        line.end();
    }
    results
}
