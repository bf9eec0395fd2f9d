//! A board that runs in a thread of its own, at the pace of this PC's clock.

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

/// Board time between two looks at this PC's clock and at what was sent, nanoseconds.
const STEP_NS: u64 = 1_000_000;

/// Steps with bytes that nobody has fetched yet, at most. The board waits then.
const STEPS_MAX: usize = 1000;

/// Time between two looks at a reader that is slow, or at a session that is paused.
const LOOK: Duration = Duration::from_millis(2);

/// Delay after which the board's clock is set back: this PC is too slow, and the board must not
/// hurry to make up for it.
const LATE_MAX: Duration = Duration::from_millis(500);

/// Error of a session: the reason in one line.
type Reason = Box<dyn Error + Send + Sync>;

/// Work for the board between two steps.
type Job = Box<dyn FnOnce(&mut Emulator) + Send>;

/// Counts of a session that has ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Summary {
    /// Board time, nanoseconds since power-up.
    pub board_ns: u64,
    /// Time by which the board has fallen behind this PC's clock, in all.
    pub behind: Duration,
    /// Rules that were broken.
    pub findings: Vec<Finding>,
    /// Resets since power-up.
    pub resets: Vec<Reset>,
}

/// The thread of a session has panicked.
#[derive(Clone, Copy, Debug)]
struct Panicked;

impl fmt::Display for Panicked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the emulator's thread panicked")
    }
}

impl Error for Panicked {}

/// State that a session and its thread share.
#[derive(Debug, Default)]
struct Shared {
    stops: AtomicBool,
    is_paused: AtomicBool,
    board_ns: AtomicU64,
    behind_ns: AtomicU64,
}

/// An emulated board in a thread. Dropped, it ends the thread.
#[derive(Debug)]
pub struct Session {
    sent: Receiver<Vec<u8>>,
    jobs: Sender<Job>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<Result<Summary, Reason>>>,
}

impl Session {
    /// Starts the board that `make` builds in the thread, since a scene need not be `Send`.
    /// `pace` is board time over this PC's time; 0: as fast as possible. Bytes arrive at their board
    /// time and not before. A board whose bytes nobody fetches waits after a second of them.
    pub fn start<E: Into<Reason>>(
        pace: f64,
        make: impl FnOnce() -> Result<Emulator, E> + Send + 'static,
    ) -> Self {
        Self::start_until(pace, make, |_| false)
    }

    /// As [`Self::start`], for a board that ends when `is_over`, which is asked after each
    /// millisecond of board time.
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

    /// Puts bytes on the line to the board.
    pub fn send(&self, bytes: &[u8]) {
        let bytes = bytes.to_vec();
        self.with(move |emulator| emulator.send(&bytes));
    }

    /// Does something to the board between two instructions, at most a millisecond of board time
    /// from now: press its reset button, break its oscillator. A board that has ended does nothing.
    pub fn with(&self, job: impl FnOnce(&mut Emulator) + Send + 'static) {
        let _ = self.jobs.send(Box::new(job));
    }

    /// Bytes that the board has sent, at most `timeout` from now; empty if it sends none. `None` if
    /// the board has ended: [`Self::end`] tells why.
    pub fn receive(&self, timeout: Duration) -> Option<Vec<u8>> {
        match self.sent.recv_timeout(timeout) {
            Ok(bytes) => Some(bytes),
            Err(RecvTimeoutError::Timeout) => Some(Vec::new()),
            Err(RecvTimeoutError::Disconnected) => None,
        }
    }

    /// Stops and continues the board's time. Gives the state before.
    pub fn pause(&self, pause: bool) -> bool {
        self.shared.is_paused.swap(pause, Ordering::Relaxed)
    }

    /// Board time, nanoseconds since power-up, to a millisecond.
    pub fn board_ns(&self) -> u64 {
        self.shared.board_ns.load(Ordering::Relaxed)
    }

    /// Time by which the board has fallen behind this PC's clock, in all: zero while it keeps up.
    pub fn behind(&self) -> Duration {
        Duration::from_nanos(self.shared.behind_ns.load(Ordering::Relaxed))
    }

    /// Ends the board, and gives the reason if it has ended by itself.
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

    /// Gives bytes to the reader, and waits while it has too many.
    fn give(&mut self, mut bytes: Vec<u8>) {
        while !self.shared.stops.load(Ordering::Relaxed) {
            match self.to_reader.try_send(bytes) {
                // Nobody reads once the session is gone, and then the board stops too.
                Ok(()) | Err(TrySendError::Disconnected(_)) => return,
                Err(TrySendError::Full(back)) => bytes = back,
            }
            self.hold();
        }
    }

    /// Waits without falling behind.
    fn hold(&mut self) {
        let begun = Instant::now();
        sleep(LOOK);
        self.pacer.shift(begun.elapsed());
    }
}

/// Board time against this PC's clock.
struct Pacer {
    /// Board time over this PC's time; none: as fast as possible.
    pace: Option<f64>,
    /// When board time was zero.
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

    /// Waits until this board time is due. Gives the time by which the board's clock had to be set
    /// back.
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

    /// A board that runs one instruction again and again, or ends at once at one that is not
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
        // Without a pace nothing waits.
        assert_eq!(Pacer::new(0.0).wait(u64::MAX), Duration::ZERO);
    }
}
