//! The emulated board as a source: the firmware image in QEMU, at the speed of a real one.

use super::{Said, Source};
use crate::emulator;
use crate::emulator::Options;
use crate::input::Opened;
use anyhow::{Context, Result, anyhow, bail};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// By how much the emulated board may be late before its clock is put back: then this computer is too slow for it, and it
/// is not to be made up for in a rush.
const LATE_MAX: Duration = Duration::from_millis(500);

/// Board time between two looks at the clock.
const LOOK: Duration = Duration::from_millis(5);

/// The emulated board. Dropped, the emulator is ended.
#[derive(Debug)]
pub struct Emulated {
    said: Receiver<Said>,
    requests: Sender<Vec<u8>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<()>>>,
}

impl Emulated {
    /// Starts the firmware image `elf` in front of `input`. `pace` is the board's time over this computer's; none: as fast as
    /// it goes. It is given up after `silence` without a sign of life.
    pub fn start(input: Opened, elf: PathBuf, silence: Duration, pace: Option<f64>) -> Self {
        let (to_us, said) = channel();
        let (requests, to_board) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        let thread = std::thread::spawn(move || run(input, &elf, silence, pace, &asked, &to_us, &to_board));
        Self { said, requests, stop, thread: Some(thread) }
    }

    /// How it ended.
    fn end(&mut self) -> Result<()> {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(outcome)) => outcome,
            Some(Err(_)) => bail!("the emulator's thread panicked"),
            None => Ok(()),
        }
    }
}

fn run(
    input: Opened,
    elf: &std::path::Path,
    silence: Duration,
    pace: Option<f64>,
    asked: &AtomicBool,
    said: &Sender<Said>,
    requests: &Receiver<Vec<u8>>,
) -> Result<()> {
    let options = Options { silence, ..Options::new(elf) };
    let mut clock = pace.map(|pace| Clock { begun: Instant::now(), pace, next: Duration::ZERO });
    let mut wire = |now: Duration, bytes: &[u8]| {
        if asked.load(Ordering::Relaxed) {
            bail!("the emulated board is no longer wanted");
        }
        if !bytes.is_empty() {
            // The other end is gone only if this one is no longer wanted either.
            said.send(Said::Bytes(bytes.to_vec())).map_err(|_| anyhow!("nobody listens to the emulated board"))?;
        }
        if let Some(clock) = &mut clock {
            clock.keep(now);
        }
        Ok(requests.try_iter().flatten().collect())
    };
    emulator::run_wired(input, options, &mut wire, &mut |_, _| {}).map(|_| ())
}

/// Keeps the board's time to this computer's.
struct Clock {
    begun: Instant,
    pace: f64,
    /// Board time at which it is looked next.
    next: Duration,
}

impl Clock {
    fn keep(&mut self, now: Duration) {
        if now < self.next {
            return;
        }
        self.next = now + LOOK;
        let due = self.begun + now.div_f64(self.pace);
        let here = Instant::now();
        if due > here {
            std::thread::sleep(due - here);
        } else if here - due > LATE_MAX {
            self.begun += here - due;
        }
    }
}

impl Source for Emulated {
    fn name(&self) -> String {
        "emulated board".into()
    }

    fn next(&mut self, most: Duration) -> Result<Option<Said>> {
        match self.said.recv_timeout(most) {
            Ok(said) => Ok(Some(said)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => self.end().map(|()| Some(Said::Over)),
        }
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.requests.send(bytes.to_vec()).context("the emulated board has ended")
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // That it was stopped is what was asked for.
        let _ = self.end();
    }
}
