//! Counts and times of each kind of fault: every task writes, the detector and the fit read.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use ridgetone_proto::fault::{FaultKind, FaultSet, KINDS};

/// Age above which a fault no longer counts for windows, microseconds: longer than any window, and
/// much shorter than half the counter's range, beyond which an old fault would look new.
const OLD_US: u32 = 60_000_000;

/// A counter that stops at its maximum, because after a wrap `health` would report too small a
/// number.
#[derive(Debug, Default)]
pub struct Counter(AtomicU32);

impl Counter {
    /// Creates a counter at zero.
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Adds to the count, up to its maximum.
    pub fn add(&self, by: u32) {
        let _ = self
            .0
            .fetch_update(Relaxed, Relaxed, |count| Some(count.saturating_add(by)));
    }

    /// Present count.
    pub fn get(&self) -> u32 {
        self.0.load(Relaxed)
    }
}

/// One kind of fault. Times are the board's microseconds, wrapping.
#[derive(Debug, Default)]
struct Seen {
    count: Counter,
    /// Time of the first occurrence since [`FaultLog::take_fresh`], if its bit in `fresh` is set.
    first_us: AtomicU32,
    /// Time of the latest occurrence, if its bit in `recent` is set.
    last_us: AtomicU32,
}

/// Counts and latest times of faults, without a lock.
#[derive(Debug, Default)]
pub struct FaultLog {
    kinds: [Seen; KINDS],
    /// Bit k: kind k was seen since [`Self::take_fresh`].
    fresh: AtomicU32,
    /// Bit k: kind k was seen within about [`OLD_US`].
    recent: AtomicU32,
    /// Bit k: kind k lasts until the board restarts.
    standing: AtomicU32,
    /// Board time at which device time is zero.
    zero_us: AtomicU32,
}

impl FaultLog {
    /// Starts without faults.
    pub const fn new() -> Self {
        let kinds = [const {
            Seen {
                count: Counter::new(),
                first_us: AtomicU32::new(0),
                last_us: AtomicU32::new(0),
            }
        }; KINDS];
        let [fresh, recent, standing, zero_us] = [const { AtomicU32::new(0) }; 4];
        Self {
            kinds,
            fresh,
            recent,
            standing,
            zero_us,
        }
    }

    /// Adds a fault that was seen `times` times, the last time at `board_us`. Has no effect if
    /// `times` is zero.
    pub fn add(&self, kind: FaultKind, times: u32, board_us: u32) {
        let Some(seen) = self.kinds.get(kind as usize).filter(|_| times > 0) else {
            return;
        };
        seen.count.add(times);
        if self.fresh.load(Relaxed) & 1 << kind as u32 == 0 {
            seen.first_us.store(board_us, Relaxed);
        }
        seen.last_us.store(board_us, Relaxed);
        // Set the bits after the time, so that a reader that sees a bit also sees the time.
        self.recent.fetch_or(1 << kind as u32, Relaxed);
        self.fresh.fetch_or(1 << kind as u32, Relaxed);
    }

    /// Adds a fault that lasts until the board restarts, and so affects every window.
    pub fn stand(&self, kind: FaultKind, board_us: u32) {
        self.standing.fetch_or(1 << kind as u32, Relaxed);
        self.add(kind, 1, board_us);
    }

    /// Kinds of faults that last until the board restarts.
    pub fn standing(&self) -> FaultSet {
        FaultSet::of_bits(self.standing.load(Relaxed))
    }

    /// Number of times that each kind was seen, in the order of [`FaultKind::ALL`].
    pub fn counts(&self) -> [u32; KINDS] {
        self.kinds.each_ref().map(|seen| seen.count.get())
    }

    /// Number of times that one kind was seen.
    pub fn count(&self, kind: FaultKind) -> u32 {
        self.kinds
            .get(kind as usize)
            .map_or(0, |seen| seen.count.get())
    }

    /// Board time at which a kind was last seen; any value if it was not.
    pub fn seen_us(&self, kind: FaultKind) -> u32 {
        self.kinds
            .get(kind as usize)
            .map_or(0, |seen| seen.last_us.load(Relaxed))
    }

    /// Board time at which a kind was first seen in the period that the latest [`Self::take_fresh`]
    /// ended; any value if it was not.
    pub fn first_us(&self, kind: FaultKind) -> u32 {
        self.kinds
            .get(kind as usize)
            .map_or(0, |seen| seen.first_us.load(Relaxed))
    }

    /// True if a fault was seen since the latest [`Self::take_fresh`].
    #[inline(always)]
    pub fn has_fresh(&self) -> bool {
        self.fresh.load(Relaxed) != 0
    }

    /// Takes the kinds seen since the latest call.
    pub fn take_fresh(&self) -> FaultSet {
        FaultSet::of_bits(self.fresh.swap(0, Relaxed))
    }

    /// Sets the board time at which device time is zero.
    pub fn set_zero(&self, board_us: u32) {
        self.zero_us.store(board_us, Relaxed);
    }

    /// Kinds of faults seen since a device time (low 32 bits, microseconds), and standing faults.
    /// `since_us` must be less than half an hour ago.
    pub fn since(&self, since_us: u32) -> FaultSet {
        let since_us = self.zero_us.load(Relaxed).wrapping_add(since_us);
        let recent = self.recent.load(Relaxed);
        let seen = FaultSet::of_bits(recent)
            .iter()
            .filter(|kind| self.seen_us(*kind).wrapping_sub(since_us) as i32 >= 0);
        seen.fold(self.standing(), FaultSet::with)
    }

    /// True if a board time is before a device time (low 32 bits, microseconds). They must be less
    /// than half an hour apart.
    pub fn is_before(&self, board_us: u32, device_us: u32) -> bool {
        let since_us = self.zero_us.load(Relaxed).wrapping_add(device_us);
        (board_us.wrapping_sub(since_us) as i32) < 0
    }

    /// Forgets old faults; `board_us` is now. Must be called at least every few minutes.
    pub fn forget(&self, board_us: u32) {
        let recent = FaultSet::of_bits(self.recent.load(Relaxed));
        if recent.is_none() {
            return;
        }
        for kind in recent.iter() {
            let is_old = || board_us.wrapping_sub(self.seen_us(kind)) as i32 > OLD_US as i32;
            if is_old() {
                self.recent.fetch_and(!(1 << kind as u32), Relaxed);
                // A task of a higher priority may have just seen the fault again.
                if !is_old() {
                    self.recent.fetch_or(1 << kind as u32, Relaxed);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use FaultKind::{Bus, Lost, Silent};

    #[test]
    fn a_standing_fault_is_found_at_any_time_and_counted_once() {
        let fault_log = FaultLog::new();
        fault_log.stand(Silent, 50);
        fault_log.add(Lost, 1, 60);
        for at_us in [0, 70, OLD_US + 100] {
            let kinds = fault_log.since(at_us);
            assert!(kinds.has(Silent), "{at_us}");
            assert_eq!(kinds.has(Lost), at_us == 0, "{at_us}");
            fault_log.forget(at_us);
        }
        assert_eq!(fault_log.count(Silent), 1);
    }

    #[test]
    fn added_faults_are_counted_and_fresh_once() {
        let fault_log = FaultLog::new();
        assert!(!fault_log.has_fresh());
        fault_log.add(Silent, u32::MAX, 50);
        fault_log.add(Silent, 2, 60);
        assert_eq!(fault_log.count(Silent), u32::MAX);
        assert!(fault_log.take_fresh().iter().eq([Silent]));
        fault_log.add(Lost, 3, 100);
        fault_log.add(Lost, 2, 200);
        fault_log.add(Bus, 0, 200);
        assert!(fault_log.has_fresh());
        assert_eq!((fault_log.count(Lost), fault_log.counts()[0]), (5, 5));
        assert_eq!(
            (fault_log.first_us(Lost), fault_log.seen_us(Lost)),
            (100, 200)
        );
        assert!(fault_log.take_fresh().iter().eq([Lost]));
        assert!(!fault_log.has_fresh() && fault_log.take_fresh().is_none());
        fault_log.add(Lost, 1, 300);
        assert_eq!(
            (fault_log.first_us(Lost), fault_log.seen_us(Lost)),
            (300, 300)
        );
    }

    #[test]
    fn faults_since_a_windows_beginning_are_found_across_the_counters_wrap() {
        let fault_log = FaultLog::new();
        let zero_us = u32::MAX - 1_000_000;
        fault_log.set_zero(zero_us);
        fault_log.add(Lost, 1, zero_us.wrapping_add(900_000));
        fault_log.add(Bus, 1, zero_us.wrapping_add(1_200_000));
        assert!(fault_log.since(800_000).iter().eq([Lost, Bus]));
        assert!(fault_log.since(900_001).iter().eq([Bus]));
        assert!(fault_log.since(1_200_001).is_none());
    }

    #[test]
    fn old_faults_do_not_look_new_after_half_of_the_counters_range() {
        let fault_log = FaultLog::new();
        fault_log.add(Silent, 1, 1000);
        for now_us in (0..u32::MAX).step_by(30_000_000) {
            fault_log.forget(now_us);
            let began_us = now_us.wrapping_sub(1_000_000);
            let is_new = fault_log.since(began_us).has(Silent);
            assert_eq!(is_new, now_us < 30_000_000, "{now_us}");
        }
        assert_eq!(fault_log.count(Silent), 1);
    }
}
