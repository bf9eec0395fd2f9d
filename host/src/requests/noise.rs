//! Bytes that are no orders, and orders that were not meant: what a board must not mind.

use super::encode;
use super::power_cuts::{CutFlash, settings};
use super::receiver::Receiver;
use anyhow::Result;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::command::{Command, Outcome, Reply, Request};

/// Bytes of a page of the flash here.
const PAGE_BYTES: u32 = 1024;

/// Number of the settings that are in force, and those of the orders that must not come through.
const STORED: u64 = 7;
const OTHER: u64 = 1000;

/// What came of bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Heard {
    /// Bytes.
    pub bytes: u64,
    /// Frames: whatever ends with a zero and is not empty.
    pub frames: u64,
    /// Frames that were counted as damaged.
    pub damaged: u64,
    /// Orders that were answered. Of noise and damaged orders there must be none.
    pub answered: u64,
    /// Whether the settings in force, the speed profile or anything in the flash has changed. They must not.
    pub changed: bool,
    /// Whether an order is obeyed right after it, as it must be.
    pub obeys: bool,
}

/// A board whose settings are stored and in force, that hears bytes and is asked then.
struct Subject {
    board: Receiver<CutFlash<PAGE_BYTES>>,
    flash: Vec<u8>,
    heard: Heard,
    /// Byte that was heard last.
    last: u8,
}

impl Subject {
    fn new() -> Result<Self> {
        let mut board = Receiver::new(CutFlash::new(1));
        board.hear(&request(1, Command::Set { settings: settings(STORED), keep: true })?);
        let pages = board.into_pages();
        let flash = pages.bytes().to_vec();
        Ok(Self { board: Receiver::new(pages), flash, heard: Heard::default(), last: 0 })
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
        let mut heard = Heard { damaged: self.board.damaged(), answered: self.board.answered, ..self.heard };
        heard.changed = self.board.in_force() != (settings(STORED), SettingsSource::Stored)
            || self.board.profile().is_some()
            || self.board.is_restarting();
        // A zero ends whatever was on the line.
        self.board.push(0);
        self.board.obey();
        let asked = request(60_000, Command::Greet)?;
        heard.obeys = self.board.hear(&asked) == [Reply { number: 60_000, outcome: Outcome::Done }];
        let pages = self.board.into_pages();
        heard.changed |= pages.bytes() != self.flash || pages.wrong > 0;
        Ok(heard)
    }
}

fn request(number: u16, command: Command) -> Result<Vec<u8>> {
    encode(&Request { number, command })
}

/// The orders that would change most.
fn requests() -> Result<Vec<Vec<u8>>> {
    let set = Command::Set { settings: settings(OTHER), keep: true };
    [set, Command::Forget, Command::Stop, Command::Restart, Command::Raw { frames: u32::MAX }]
        .into_iter()
        .zip(2..)
        .map(|(command, number)| request(number, command))
        .collect()
}

/// So many random bytes.
///
/// # Errors
/// None.
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

/// So many orders that were damaged on their way: bits flipped, cut off, their beginnings or middles left out, run together.
///
/// # Errors
/// None.
pub fn damaged_orders(frames: u64, seed: u64) -> Result<Heard> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut subject = Subject::new()?;
    let whole = requests()?;
    let mut below = |n: usize| random.next_u32() as usize % n.max(1);
    for _ in 0..frames {
        let mut frame = whole[below(whole.len())].clone();
        // The zero behind it stays: without it two are one.
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
        // Bits that fell twice fell back, and what lacks its beginning may be a whole one's end.
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

    /// A hundred megabytes, as the issue has it.
    #[test]
    fn random_bytes_change_nothing() {
        let heard = random_bytes(100_000_000, 1).expect("orders");
        assert!(heard.bytes >= 100_000_000 && heard.damaged > 300_000, "{heard:?}");
        assert_eq!((heard.answered, heard.changed, heard.obeys), (0, false, true), "{heard:?}");
    }

    #[test]
    fn damaged_orders_change_nothing() {
        let heard = damaged_orders(300_000, 1).expect("orders");
        assert!(heard.damaged > 250_000, "{heard:?}");
        assert_eq!((heard.answered, heard.changed, heard.obeys), (0, false, true), "{heard:?}");
    }

    #[test]
    fn an_order_that_is_repeated_is_answered_again_and_not_done_twice() {
        let mut board = Receiver::new(CutFlash::<PAGE_BYTES>::new(1));
        let set = request(5, Command::Set { settings: settings(3), keep: true }).expect("an order");
        let done = [Reply { number: 5, outcome: Outcome::Done }];
        for _ in 0..1000 {
            assert_eq!(board.hear(&set), done);
        }
        assert_eq!(board.in_force(), (settings(3), SettingsSource::Sent));
        let pages = board.into_pages();
        // One record's words.
        assert_eq!((pages.done, pages.erased, pages.wrong), (24, 0, 0));
    }

    #[test]
    fn a_flood_is_dropped_and_counted_while_an_order_waits() {
        let mut board = Receiver::new(CutFlash::<PAGE_BYTES>::new(1));
        let flood = 10_000u16;
        let mut taken = 0;
        for number in 0..flood {
            for byte in
                request(number, Command::Set { settings: settings(number.into()), keep: false }).expect("an order")
            {
                taken += u64::from(board.push(byte));
            }
        }
        assert_eq!((taken, board.damaged()), (1, u64::from(flood) - 1));
        assert_eq!(board.obey(), Some(Reply { number: 0, outcome: Outcome::Done }));
        assert_eq!(board.in_force().0, settings(0));
        let next = request(9, Command::Greet).expect("an order");
        assert_eq!(board.hear(&next), [Reply { number: 9, outcome: Outcome::Done }]);
    }
}
