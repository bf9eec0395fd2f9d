//! Runs a board in its own thread, paced by this PC's clock.

use crate::emulator::{Emulator, Reset};
use crate::findings::Finding;
use std::error::Error;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError};
use std::sync::mpsc::{channel, sync_channel};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};

/// Board time between two checks of this PC's clock and of the bytes sent, nanoseconds.
const STEP_NS: u64 = 1_000_000;

/// Maximum number of steps whose bytes the reader has not fetched; the board waits at this number.
const STEPS_MAX: usize = 1000;

/// Polling interval while a reader is slow or a session is paused.
const LOOK: Duration = Duration::from_millis(2);

/// Lag at which the board's clock is set back: this PC is too slow, and the board must not rush to
/// catch up.
const LATE_MAX: Duration = Duration::from_millis(500);

/// Reason for an error, in one line.
type Reason = Box<dyn Error + Send + Sync>;

type Job = Box<dyn FnOnce(&mut Emulator) + Send>;

/// Counts of a session that has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Summary {
    /// Board time, nanoseconds since power-up.
    pub board_ns: u64,
    /// Total time by which the board has fallen behind this PC's clock.
    pub behind: Duration,
    /// Broken rules.
    pub findings: Vec<Finding>,
    /// Resets since power-up.
    pub resets: Vec<Reset>,
}

/// Error: the thread of a session has panicked.
#[derive(Clone, Copy, Debug)]
struct Panicked;

impl fmt::Display for Panicked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the emulator's thread panicked")
    }
}

impl Error for Panicked {}

#[derive(Debug, Default)]
struct Shared {
    stops: AtomicBool,
    is_paused: AtomicBool,
    board_ns: AtomicU64,
    behind_ns: AtomicU64,
}

/// An emulated board in its own thread, which ends when the session is dropped.
#[derive(Debug)]
pub struct Session {
    sent: Receiver<Vec<u8>>,
    jobs: Sender<Job>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<Summary, Reason>>>,
}

impl Session {
    /// Starts the board that `make` builds in the thread, because a scene need not be `Send`.
    /// `pace` is the ratio of board time to this PC's time, or 0 for maximum speed. Bytes arrive no
    /// earlier than at their board time. The board waits while a second of its bytes is unfetched.
    pub fn start<E: Into<Reason>>(
        pace: f64,
        make: impl FnOnce() -> Result<Emulator, E> + Send + 'static,
    ) -> Self {
        Self::start_until(pace, make, |_| false)
    }

    /// Like [`Self::start`], but the board ends once `is_over` returns true; it is called after
    /// each millisecond of board time.
    pub fn start_until<E: Into<Reason>>(
        pace: f64,
        make: impl FnOnce() -> Result<Emulator, E> + Send + 'static,
        mut is_over: impl FnMut(&mut Emulator) -> bool + Send + 'static,
    ) -> Self {
        let (to_reader, sent) = sync_channel(STEPS_MAX);
        let (jobs, from_user) = channel();
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        let thread = std::thread::spawn(move || {
            let emulator = make().map_err(Into::into)?;
            Runner {
                emulator,
                pacer: Pacer::new(pace),
                to_reader,
                jobs: from_user,
                shared: theirs,
            }
            .run(&mut is_over)
        });
        Self {
            sent,
            jobs,
            shared,
            thread: Some(thread),
        }
    }

    /// Sends bytes to the board.
    pub fn send(&self, bytes: &[u8]) {
        let bytes = bytes.to_vec();
        self.with(move |emulator| emulator.send(&bytes));
    }

    /// Runs `job` on the board between two instructions, within a millisecond of board time, for
    /// example to press reset or to stop the oscillator. Does nothing if the board has ended.
    pub fn with(&self, job: impl FnOnce(&mut Emulator) + Send + 'static) {
        let _ = self.jobs.send(Box::new(job));
    }

    /// Returns bytes that the board has sent, waiting up to `timeout`; empty if there are none.
    /// `None` if the board has ended: [`Self::end`] returns the reason.
    pub fn receive(&self, timeout: Duration) -> Option<Vec<u8>> {
        match self.sent.recv_timeout(timeout) {
            Ok(bytes) => Some(bytes),
            Err(RecvTimeoutError::Timeout) => Some(Vec::new()),
            Err(RecvTimeoutError::Disconnected) => None,
        }
    }

    /// Stops (or continues) the board's time. Returns true if it was stopped before.
    pub fn pause(&self, pause: bool) -> bool {
        self.shared.is_paused.swap(pause, Ordering::Relaxed)
    }

    /// Board time, nanoseconds since power-up, within a millisecond.
    pub fn board_ns(&self) -> u64 {
        self.shared.board_ns.load(Ordering::Relaxed)
    }

    /// Total time by which the board has fallen behind this PC's clock: zero while it keeps up.
    pub fn behind(&self) -> Duration {
        Duration::from_nanos(self.shared.behind_ns.load(Ordering::Relaxed))
    }

    /// Ends the board. Returns an error with the reason if the board had ended by itself.
    pub fn end(mut self) -> Result<Summary, Box<dyn Error + Send + Sync>> {
        self.join()
    }

    fn join(&mut self) -> Result<Summary, Reason> {
        self.shared.stops.store(true, Ordering::Relaxed);
        self.thread.take().map_or_else(
            || Err(Panicked.into()),
            |thread| thread.join().unwrap_or_else(|_| Err(Panicked.into())),
        )
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        if self.thread.is_some() {
            let _ = self.join();
        }
    }
}

/// The thread's side of a session.
struct Runner {
    emulator: Emulator,
    pacer: Pacer,
    to_reader: SyncSender<Vec<u8>>,
    jobs: Receiver<Job>,
    shared: Arc<Shared>,
}

impl Runner {
    fn run(mut self, is_over: &mut dyn FnMut(&mut Emulator) -> bool) -> Result<Summary, Reason> {
        while !self.shared.stops.load(Ordering::Relaxed) && !is_over(&mut self.emulator) {
            if self.shared.is_paused.load(Ordering::Relaxed) {
                self.hold();
                continue;
            }
            for job in self.jobs.try_iter() {
                job(&mut self.emulator);
            }
            self.emulator.run_ns(STEP_NS)?;
            self.emulator.forget_history();
            let now_ns = self.emulator.now_ns();
            self.shared.board_ns.store(now_ns, Ordering::Relaxed);
            let behind = self.pacer.wait(now_ns);
            self.shared
                .behind_ns
                .fetch_add(behind.as_nanos() as u64, Ordering::Relaxed);
            let bytes = self.emulator.take_sent();
            if !bytes.is_empty() {
                self.give(bytes);
            }
        }
        Ok(Summary {
            board_ns: self.emulator.now_ns(),
            behind: Duration::from_nanos(self.shared.behind_ns.load(Ordering::Relaxed)),
            findings: self.emulator.findings().to_vec(),
            resets: self.emulator.resets().to_vec(),
        })
    }

    /// Passes bytes to the reader, and waits while its queue is full.
    fn give(&mut self, mut bytes: Vec<u8>) {
        while !self.shared.stops.load(Ordering::Relaxed) {
            match self.to_reader.try_send(bytes) {
                // Once the session is dropped, the reader is gone and the board stops.
                Ok(()) | Err(TrySendError::Disconnected(_)) => return,
                Err(TrySendError::Full(back)) => bytes = back,
            }
            self.hold();
        }
    }

    /// Waits without making the board fall behind.
    fn hold(&mut self) {
        let begun = Instant::now();
        sleep(LOOK);
        self.pacer.shift(begun.elapsed());
    }
}

/// Paces board time by this PC's clock.
struct Pacer {
    /// Ratio of board time to this PC's time; `None` for maximum speed.
    pace: Option<f64>,
    /// Time on this PC's clock at which board time was zero.
    begun: Instant,
}

impl Pacer {
    fn new(pace: f64) -> Self {
        Self {
            pace: (pace > 0.0).then_some(pace),
            begun: Instant::now(),
        }
    }

    fn shift(&mut self, by: Duration) {
        self.begun += by;
    }

    /// Waits until a board time is due. Returns the time by which the board's clock was set back.
    fn wait(&mut self, board_ns: u64) -> Duration {
        let Some(pace) = self.pace else {
            return Duration::ZERO;
        };
        let due = self.begun + Duration::from_nanos(board_ns).div_f64(pace);
        let now = Instant::now();
        let late = now.saturating_duration_since(due);
        if late > LATE_MAX {
            self.shift(late);
            return late;
        }
        sleep(due.saturating_duration_since(now));
        Duration::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::{LATE_MAX, Pacer, Session};
    use crate::board::Board;
    use crate::emulator::{Emulator, Start};
    use crate::image::Image;
    use crate::peripherals::rcc::ResetCause;
    use crate::stop::Failure;
    use hal_mock::Constant;
    use std::time::{Duration, Instant};

    /// Creates a board that repeats one instruction, or ends at once if the instruction is not
    /// modelled.
    fn board(instruction: u32) -> Result<Emulator, Box<Failure>> {
        let words = [0x2000_2000, 0x0800_0009, instruction];
        let image = Image::of_words(&words, "_stack_end", 0x2000_1000);
        Emulator::new(
            Board::FeatherF405,
            &image,
            Constant::default(),
            Start::default(),
        )
    }

    const BRANCH_TO_ITSELF: u32 = 0xE7FE;
    const BREAKPOINT: u32 = 0xBE00;

    #[test]
    fn a_board_keeps_the_pace_and_takes_jobs_and_pauses() {
        let begun = Instant::now();
        let session = Session::start(1.0, || board(BRANCH_TO_ITSELF));
        while session.board_ns() < 60_000_000 {
            assert_eq!(session.receive(Duration::from_millis(1)), Some(vec![]));
        }
        assert!(begun.elapsed() >= Duration::from_millis(59));
        session.with(|emulator| emulator.press_reset().expect("a reset"));
        let before_ns = session.board_ns();
        while session.board_ns() < before_ns + 3_000_000 {
            let _ = session.receive(Duration::from_millis(1));
        }
        assert!(!session.pause(true));
        std::thread::sleep(Duration::from_millis(30));
        let paused_ns = session.board_ns();
        std::thread::sleep(Duration::from_millis(30));
        assert_eq!(session.board_ns(), paused_ns);
        let summary = session.end().expect("a board that runs");
        assert_eq!(summary.board_ns, paused_ns);
        assert_eq!(summary.resets[0].cause, ResetCause::Pin);
    }

    #[test]
    fn a_board_that_ends_says_why() {
        let over = |emulator: &mut Emulator| emulator.now_ns() >= 5_000_000;
        let session = Session::start_until(0.0, || board(BRANCH_TO_ITSELF), over);
        while session.receive(Duration::from_secs(1)).is_some() {}
        let summary = session.end().expect("a board that runs");
        assert!(
            (5_000_000..6_100_000).contains(&summary.board_ns),
            "{summary:?}"
        );
        let session = Session::start(0.0, || board(BREAKPOINT));
        while session.receive(Duration::from_secs(1)).is_some() {}
        let reason = session.end().expect_err("a failure").to_string();
        assert!(reason.contains("0x08000008"), "{reason}");
    }

    #[test]
    fn a_board_that_is_late_says_by_how_much_and_does_not_hurry() {
        let mut pacer = Pacer::new(1.0);
        assert_eq!(pacer.wait(1_000_000), Duration::ZERO);
        pacer.begun -= 2 * LATE_MAX;
        let late = pacer.wait(2_000_000);
        assert!(late > LATE_MAX, "{late:?}");
        let begun = Instant::now();
        assert_eq!(pacer.wait(22_000_000), Duration::ZERO);
        assert!(begun.elapsed() > Duration::from_millis(15));
        // Without a pace there is no waiting.
        assert_eq!(Pacer::new(0.0).wait(u64::MAX), Duration::ZERO);
    }
}
