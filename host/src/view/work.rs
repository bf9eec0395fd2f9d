//! Work that a page asks for and that takes long: on threads of its own, a few at a time, until it
//! is done or the page has left.

use anyhow::{Context, Result, ensure};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tokio::sync::Semaphore;

/// Pieces of work at a time; others wait. One core at least is for the board and the pages.
static FREE: Semaphore = Semaphore::const_new(2);

/// What work may take.
#[derive(Clone, Debug)]
pub struct Allowance {
    is_wanted: Arc<AtomicBool>,
    /// Greatest size in memory, bytes.
    most_bytes: usize,
}

impl Allowance {
    /// For what the command's own user has named.
    pub fn unlimited() -> Self {
        Self::new(usize::MAX)
    }

    fn new(most_bytes: usize) -> Self {
        Self {
            is_wanted: Arc::new(AtomicBool::new(true)),
            most_bytes,
        }
    }

    /// Refuses to go on when the page has left, or with a size in memory beyond the limit.
    pub fn check(&self, bytes: usize) -> Result<()> {
        ensure!(self.is_wanted.load(Ordering::Relaxed), "the page has left");
        ensure!(
            bytes <= self.most_bytes,
            "it takes more than {} MiB of memory: cut it into parts, or use `replay` or `export`",
            self.most_bytes >> 20
        );
        Ok(())
    }
}

/// Ends the work when the request for it is dropped.
struct Asking(Arc<AtomicBool>);

impl Drop for Asking {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

/// Runs work for a page, so that the other pages do not wait.
pub async fn on_a_thread(
    most_bytes: usize,
    work: impl FnOnce(&Allowance) -> Result<String> + Send + 'static,
) -> Result<String> {
    let place = FREE.acquire().await?;
    let allowance = Allowance::new(most_bytes);
    let _asking = Asking(Arc::clone(&allowance.is_wanted));
    let work = move || {
        let _place = place;
        work(&allowance)
    };
    tokio::task::spawn_blocking(work)
        .await
        .context("the work ended without a result")?
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::future::{Either, select};
    use std::sync::mpsc::channel;
    use std::time::Duration;

    #[test]
    fn work_ends_when_nobody_waits_for_it() {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .build()
            .expect("a runtime");
        let (begun, begins) = channel();
        let (ended, ends) = channel();
        let work = move |allowance: &Allowance| {
            let _ = begun.send(());
            while allowance.check(0).is_ok() {
                std::thread::sleep(Duration::from_millis(1));
            }
            let _ = ended.send(());
            Ok(String::new())
        };
        runtime.block_on(async {
            let asked = std::pin::pin!(on_a_thread(0, work));
            let leaving = std::pin::pin!(async {
                while begins.try_recv().is_err() {
                    tokio::time::sleep(Duration::from_millis(1)).await;
                }
            });
            assert!(matches!(select(asked, leaving).await, Either::Right(_)));
        });
        ends.recv_timeout(Duration::from_secs(20)).expect("it ends");
    }
}
