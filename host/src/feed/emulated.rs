//! The emulated board as a source: the firmware image in QEMU, at the speed of a real one.

use super::decoded::Feed;
use super::source::{FeedEvent, Source};
use crate::emulator::{self, Options};
use crate::input::{Opened, first_scene, frame_rate_hz};
use crate::note;
use crate::port::BYTE_S;
use crate::touches::{first_touches, of_scene};
use anyhow::{Result, anyhow, bail};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Delay after which the emulated board's clock is set back: this computer is too slow for it, and
/// it must not hurry to make up for the delay.
const LATE_MAX: Duration = Duration::from_millis(500);

/// Board time between two readings of this computer's clock.
const LOOK: Duration = Duration::from_millis(5);

/// Time between two looks whether somebody looks again.
const LOOK_IDLE: Duration = Duration::from_millis(20);

/// Its name as a source.
pub const EMULATED: &str = "emulated board";

/// How an emulated board runs.
#[derive(Clone, Debug)]
pub struct Emulation {
    /// Firmware image.
    pub elf: PathBuf,
    /// Wall time without a sign of life after which the emulator is given up.
    pub silence: Duration,
    /// Board time over wall time; as fast as possible if none.
    pub pace: Option<f64>,
    /// The scene repeats for ever; of the first scene each touch is over another grating.
    pub repeats: bool,
}

/// Opens the emulated board in front of a scene file, or of the first scene.
pub fn emulated(scene: Option<&Path>, how: Emulation) -> Result<Feed> {
    let input = match scene {
        Some(path) => {
            let input = of_scene(hal_mock::load_scene(path, frame_rate_hz())?)?;
            if how.repeats { input.repeated() } else { input }
        }
        None if how.repeats => first_touches()?,
        None => of_scene(first_scene()?)?,
    };
    if let Some(warning) = &input.warning {
        note!("warning: {warning}");
    }
    Ok(in_front_of(input, how))
}

/// Opens the emulated board with nothing on its finger.
pub fn untouched(how: Emulation) -> Feed {
    in_front_of(Opened::untouched(), how)
}

fn in_front_of(input: Opened, how: Emulation) -> Feed {
    Feed::new(Emulated::start(input, how.elf, how.silence, how.pace))
}

/// The emulated board. Dropped, it ends the emulator.
#[derive(Debug)]
pub struct Emulated {
    telemetry: Receiver<Vec<u8>>,
    requests: Sender<Vec<u8>>,
    stop: Arc<AtomicBool>,
    idle: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<()>>>,
}

impl Emulated {
    /// Starts the firmware image `elf` in front of `input`. `pace` is board time over wall time;
    /// none: as fast as possible. With a pace, bytes arrive at their board time and not before.
    /// After `silence` without a sign of life it gives up.
    pub fn start(input: Opened, elf: PathBuf, silence: Duration, pace: Option<f64>) -> Self {
        let (to_feed, telemetry) = channel();
        let (requests, to_board) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let idle = Arc::new(AtomicBool::new(false));
        let waits = Arc::clone(&idle);
        let thread = std::thread::spawn(move || {
            let options = Options {
                silence,
                ..Options::new(&elf)
            };
            let (mut begun, mut next) = (Instant::now(), Duration::ZERO);
            let mut exchange = |now: Duration, bytes: &[u8]| {
                while waits.load(Ordering::Relaxed) && !stopped.load(Ordering::Relaxed) {
                    let here = Instant::now();
                    std::thread::sleep(LOOK_IDLE);
                    // The clock is read here alone: reading it at every exchange would look like a
                    // skew of hundreds of ppm.
                    begun += here.elapsed();
                }
                if stopped.load(Ordering::Relaxed) {
                    bail!("the emulated board is no longer wanted");
                }
                if let Some(pace) = pace
                    && (now >= next || !bytes.is_empty())
                {
                    next = now + LOOK;
                    let (due, here) = (begun + now.div_f64(pace), Instant::now());
                    if due > here {
                        std::thread::sleep(due - here);
                    } else if here - due > LATE_MAX {
                        begun += here - due;
                    }
                }
                if !bytes.is_empty() {
                    // The receiver is gone only when this thread is to end too.
                    to_feed
                        .send(bytes.to_vec())
                        .map_err(|_| anyhow!("nobody listens to the emulated board"))?;
                }
                Ok(to_board.try_iter().flatten().collect())
            };
            emulator::run_bytes(input, options, &mut exchange, &mut |_, _| {}).map(|_| ())
        });
        Self {
            telemetry,
            requests,
            stop,
            idle,
            thread: Some(thread),
        }
    }

    fn join(&mut self) -> Result<()> {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(outcome)) => outcome,
            Some(Err(_)) => bail!("the emulator's thread panicked"),
            None => Ok(()),
        }
    }
}

impl Source for Emulated {
    fn name(&self) -> String {
        EMULATED.into()
    }

    fn next(&mut self, most: Duration) -> Result<Option<FeedEvent<Vec<u8>>>> {
        match self.telemetry.recv_timeout(most) {
            Ok(bytes) => Ok(Some(FeedEvent::Data(bytes))),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => self.join().map(|()| Some(FeedEvent::Over)),
        }
    }

    fn byte_s(&self) -> f64 {
        // Its image gives bytes this time, too (BYTE_US in src/board/emulated/link.rs).
        BYTE_S
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        // A board that has ended hears nothing any more; its end is the next event.
        let _ = self.requests.send(bytes.to_vec());
        Ok(())
    }

    fn idle(&mut self, idle: bool) -> bool {
        self.idle.swap(idle, Ordering::Relaxed) && !idle
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // It ends with an error, since it was stopped.
        let _ = self.join();
    }
}
