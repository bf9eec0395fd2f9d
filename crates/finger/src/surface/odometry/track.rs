//! Places of the latest seconds: written by `detect`, read by `fit`, without a lock.
//!
//! Two tasks share it without waiting, because each entry but the newest stays as it is until it is
//! overwritten, and a reader finds that out ([`Track::has_kept`]). The newest moves on with every
//! message until it is far enough from the one before, so that few entries last for long at any
//! rate of messages; a reader has a copy of it from when its window fell due.

use core::sync::atomic::{AtomicU16, AtomicU32, Ordering::Relaxed};

/// Most entries.
pub const ENTRIES: usize = 64;

/// A place at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Entry {
    /// The robot's stamp, microseconds, wrapping.
    pub t_us: u32,
    /// Place, tenths of a micrometre, wrapping.
    pub place: i32,
}

/// The latest entries.
#[derive(Debug)]
pub struct Track {
    slots: [[AtomicU32; 2]; ENTRIES],
    /// Number behind that of the newest entry. Numbers wrap.
    until: AtomicU16,
    /// Number of the oldest that counts.
    oldest: AtomicU16,
}

impl Track {
    /// Without entries.
    pub const fn new() -> Self {
        let [until, oldest] = [const { AtomicU16::new(0) }; 2];
        Self {
            slots: [const { [const { AtomicU32::new(0) }; 2] }; ENTRIES],
            until,
            oldest,
        }
    }

    /// Drops all entries.
    pub fn clear(&self) {
        self.oldest.store(self.until.load(Relaxed), Relaxed);
    }

    /// Adds an entry. It takes the place of the newest one if that is less than `spacing_us` behind
    /// the one before it.
    pub fn put(&self, entry: Entry, spacing_us: u32) {
        let (until, oldest) = (self.until.load(Relaxed), self.oldest.load(Relaxed));
        let (newest, before) = (
            self.get(until.wrapping_sub(1)),
            self.get(until.wrapping_sub(2)),
        );
        let moves =
            until.wrapping_sub(oldest) >= 2 && newest.t_us.wrapping_sub(before.t_us) < spacing_us;
        let number = if moves { until.wrapping_sub(1) } else { until };
        self.write(number as usize, [entry.t_us, entry.place as u32]);
        if !moves {
            // After the entry.
            self.until.store(until.wrapping_add(1), Relaxed);
            if until.wrapping_sub(oldest) >= ENTRIES as u16 {
                self.oldest.store(oldest.wrapping_add(1), Relaxed);
            }
        }
    }

    /// The entry of a number, if it is still there.
    pub fn get(&self, number: u16) -> Entry {
        let [t_us, place] = self.read(number as usize);
        Entry {
            t_us,
            place: place as i32,
        }
    }

    /// Number behind the newest entry, and that entry.
    pub fn newest(&self) -> Option<(u16, Entry)> {
        let until = self.until.load(Relaxed);
        (until != self.oldest.load(Relaxed)).then(|| (until, self.get(until.wrapping_sub(1))))
    }

    /// Number of the oldest entry.
    pub fn oldest(&self) -> u16 {
        self.oldest.load(Relaxed)
    }

    /// Whether no entry from this number on has been overwritten, also not in part.
    pub fn has_kept(&self, number: u16) -> bool {
        self.until.load(Relaxed).wrapping_sub(number) < ENTRIES as u16
    }

    fn write(&self, slot: usize, words: [u32; 2]) {
        if let Some(to) = self.slots.get(slot % ENTRIES) {
            to.iter()
                .zip(words)
                .for_each(|(to, word)| to.store(word, Relaxed));
        }
    }

    fn read(&self, slot: usize) -> [u32; 2] {
        self.slots.get(slot % ENTRIES).map_or([0; 2], |words| {
            words.each_ref().map(|word| word.load(Relaxed))
        })
    }
}

impl Default for Track {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_keep_their_distance_and_the_newest_is_always_there() {
        let track = Track::new();
        assert_eq!(track.newest(), None);
        for t_us in (0..10_000_000u32).step_by(4000) {
            track.put(
                Entry {
                    t_us,
                    place: t_us as i32,
                },
                70_000,
            );
            assert_eq!(track.newest().map(|(_, newest)| newest.t_us), Some(t_us));
        }
        let (until, _) = track.newest().expect("entries");
        assert_eq!(until.wrapping_sub(track.oldest()), ENTRIES as u16);
        for number in track.oldest()..until - 2 {
            let (one, next) = (track.get(number), track.get(number + 1));
            assert_eq!(next.t_us - one.t_us, 72_000);
        }
        assert!(track.has_kept(track.oldest() + 1) && !track.has_kept(track.oldest()));
        track.clear();
        assert_eq!(track.newest(), None);
    }
}
