//! Sends random bytes and damaged requests on the board's line, which must have no effect.

use super::power_cuts::settings;
use anyhow::Result;
use hal_mock::CutFlash;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_host::requests::encode;
use ridgetone_host::requests::receiver::Receiver;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::{Command, Outcome, Reply, Request};

const PAGE_BYTES: u32 = 1024;

/// Numbers of the board's current settings, and of settings in requests that it must refuse.
const STORED: u64 = 7;
const OTHER: u64 = 1000;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heard {
    pub bytes: u64,
    /// Non-empty sequences that end with a zero.
    pub frames: u64,
    /// Frames that the board counted as damaged.
    pub damaged: u64,
    /// Requests that the board answered. Must be zero.
    pub answered: u64,
    /// True if the current settings or the flash have changed. Must be false.
    pub changed: bool,
    /// True if the board executes the next request. Must be true.
    pub obeys: bool,
}

/// A board whose current settings are stored.
struct Subject {
    board: Receiver<CutFlash<PAGE_BYTES>>,
    flash: Vec<u8>,
    heard: Heard,
    last: u8,
}

impl Subject {
    fn new() -> Result<Self> {
        let mut board = Receiver::new(CutFlash::new(1));
        board.hear(&request(
            1,
            Command::Set {
                settings: settings(STORED),
                keep: true,
            },
        )?);
        let pages = board.into_pages();
        let flash = pages.bytes.clone();
        Ok(Self {
            board: Receiver::new(pages),
            flash,
            heard: Heard::default(),
            last: 0,
        })
    }

    fn hear(&mut self, bytes: &[u8]) -> Vec<Reply> {
        self.heard.bytes += bytes.len() as u64;
        for byte in bytes {
            self.heard.frames += u64::from(*byte == 0 && self.last != 0);
            self.last = *byte;
        }
        self.board.hear(bytes)
    }

    fn conclude(mut self) -> Result<Heard> {
        let mut heard = Heard {
            damaged: self.board.damaged(),
            answered: self.board.answered,
            ..self.heard
        };
        heard.changed = self.board.in_force() != (settings(STORED), SettingsSource::Stored)
            || self.board.is_restarting();
        // A zero ends any partial frame on the line.
        self.board.push(0);
        self.board.obey();
        let greet = request(60_000, Command::Greet)?;
        heard.obeys = self.board.hear(&greet) == [Reply::new(60_000, Outcome::Done)];
        let pages = self.board.into_pages();
        heard.changed |= pages.bytes != self.flash || pages.wrong > 0;
        Ok(heard)
    }
}

fn request(number: u16, command: Command) -> Result<Vec<u8>> {
    encode(&Request { number, command })
}

/// Returns the requests with the largest effects.
fn requests() -> Result<Vec<Vec<u8>>> {
    let set = Command::Set {
        settings: settings(OTHER),
        keep: true,
    };
    [
        set,
        Command::Forget,
        Command::Stop,
        Command::Restart,
        Command::Raw { frames: u32::MAX },
    ]
    .into_iter()
    .zip(2..)
    .map(|(command, number)| request(number, command))
    .collect()
}

pub fn random_bytes(bytes: u64, seed: u64) -> Result<Heard> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut subject = Subject::new()?;
    let mut block = [0; 4096];
    while subject.heard.bytes < bytes {
        random.fill_bytes(&mut block);
        subject.hear(&block);
    }
    subject.conclude()
}

/// Sends `frames` damaged requests: with bit errors, without their end, with a gap, or two merged
/// into one.
pub fn damaged_requests(frames: u64, seed: u64) -> Result<Heard> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut subject = Subject::new()?;
    let whole = requests()?;
    let mut below = |n: usize| random.next_u32() as usize % n.max(1);
    for _ in 0..frames {
        let mut frame = whole[below(whole.len())].clone();
        // The zero at the end is kept unless two requests are merged.
        let length = frame.len() - 1;
        match below(4) {
            0 => (0..=below(3)).for_each(|_| frame[below(length)] ^= 1 << below(8)),
            1 => drop(frame.drain(below(length)..length)),
            2 => {
                let from = below(length);
                frame.drain(from..from + 1 + below(length - from));
            }
            _ => {
                frame.pop();
                frame.extend(&whole[below(whole.len())]);
            }
        }
        // Two errors in the same bit cancel, and the end of a request may itself be a complete
        // request.
        if whole.contains(&frame) {
            continue;
        }
        subject.hear(&frame);
    }
    subject.conclude()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_bytes_change_nothing() {
        send_random_bytes(5_000_000);
    }

    #[test]
    #[ignore = "long, a hundred megabytes: cargo xtask test --all"]
    fn a_hundred_megabytes_of_random_bytes_change_nothing() {
        send_random_bytes(100_000_000);
    }

    fn send_random_bytes(bytes: u64) {
        let heard = random_bytes(bytes, 1).expect("requests");
        assert!(
            heard.bytes >= bytes && heard.damaged > bytes / 333,
            "{heard:?}"
        );
        assert_eq!(
            (heard.answered, heard.changed, heard.obeys),
            (0, false, true),
            "{heard:?}"
        );
    }

    #[test]
    fn damaged_requests_change_nothing() {
        let heard = damaged_requests(300_000, 1).expect("requests");
        assert!(heard.damaged > 250_000, "{heard:?}");
        assert_eq!(
            (heard.answered, heard.changed, heard.obeys),
            (0, false, true),
            "{heard:?}"
        );
    }

    #[test]
    fn a_repeated_request_is_answered_again_and_not_done_twice() {
        let mut board = Receiver::new(CutFlash::<PAGE_BYTES>::new(1));
        let set = request(
            5,
            Command::Set {
                settings: settings(3),
                keep: true,
            },
        )
        .expect("a request");
        let done = [Reply {
            gives: Some(settings(0).plan.gives()),
            ..Reply::new(5, Outcome::Done)
        }];
        for _ in 0..1000 {
            assert_eq!(board.hear(&set), done);
        }
        assert_eq!(board.in_force(), (settings(3), SettingsSource::Sent));
        let pages = board.into_pages();
        let words = ridgetone_proto::store::RECORD_BYTES as u64 / 4;
        assert_eq!((pages.done, pages.erased, pages.wrong), (words, 0, 0));
    }

    #[test]
    fn a_flood_is_dropped_and_counted_while_a_request_waits() {
        let mut board = Receiver::new(CutFlash::<PAGE_BYTES>::new(1));
        let flood = 10_000u16;
        let mut taken = 0;
        for number in 0..flood {
            for byte in request(
                number,
                Command::Set {
                    settings: settings(number.into()),
                    keep: false,
                },
            )
            .expect("a request")
            {
                taken += u64::from(board.push(byte));
            }
        }
        assert_eq!((taken, board.damaged()), (1, u64::from(flood) - 1));
        let done = Reply {
            gives: Some(settings(0).plan.gives()),
            ..Reply::new(0, Outcome::Done)
        };
        assert_eq!(board.obey(), Some(done));
        assert_eq!(board.in_force().0, settings(0));
        let next = request(9, Command::Greet).expect("a request");
        assert_eq!(board.hear(&next), [Reply::new(9, Outcome::Done)]);
    }
}
