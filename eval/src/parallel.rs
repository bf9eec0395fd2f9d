//! Work on all cores, results in order.

use anyhow::Result;
use ridgetone_host::output::Progress;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Does `work` on every item, on as many threads as there are cores. The results do not depend on how many those are.
///
/// # Errors
/// The first that `work` gives.
pub fn map<T: Sync, R: Send>(what: &str, items: &[T], work: impl Fn(&T) -> Result<R> + Sync) -> Result<Vec<R>> {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let (next, (sender, receiver)) = (AtomicUsize::new(0), mpsc::channel());
    let mut results: Vec<Option<R>> = items.iter().map(|_| None).collect();
    let mut progress = Progress::default();
    let failed = thread::scope(|scope| {
        for _ in 0..threads {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(number) else { break };
                    // Nobody listens any more after an error.
                    if sender.send((number, work(item))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for (done, (number, result)) in (1..).zip(receiver) {
            match result {
                Ok(result) => results[number] = Some(result),
                Err(error) => return Some(error),
            }
            progress.tell_count(what, done, items.len());
        }
        None
    });
    progress.end();
    failed.map_or_else(|| Ok(results.into_iter().flatten().collect()), Err)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_and_an_error_ends_it() {
        let items: Vec<u32> = (0..1000).collect();
        let squares = map("squares", &items, |item| Ok(item * item)).expect("no error");
        assert!(squares.iter().zip(&items).all(|(square, item)| *square == item * item) && squares.len() == 1000);
        let failed = map("errors", &items, |item| if *item == 500 { anyhow::bail!("500") } else { Ok(()) });
        assert_eq!(failed.expect_err("an error").to_string(), "500");
    }
}
