//! Queue of conversions from `drdy` to `detect`, which takes all that wait with one look at the
//! queue's ends. `heapless::spsc` hands out one at a time, which takes half as long again.

use crate::frame::TimedConversion;
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use core::sync::atomic::{AtomicU32, AtomicUsize};

/// Place of one conversion: its time and its bits.
type Place = [AtomicU32; 2];

/// Holds one conversion less than it has places. One task may write and one may read.
#[derive(Debug)]
pub struct SampleQueue<P: ?Sized = [Place]> {
    /// Places of the next conversion to read and to write: the same if none waits.
    read: AtomicUsize,
    written: AtomicUsize,
    places: P,
}

impl<const N: usize> SampleQueue<[Place; N]> {
    /// An empty queue; all zeros.
    pub const fn new() -> Self {
        Self {
            read: AtomicUsize::new(0),
            written: AtomicUsize::new(0),
            places: [const { [const { AtomicU32::new(0) }; 2] }; N],
        }
    }
}

impl<const N: usize> Default for SampleQueue<[Place; N]> {
    fn default() -> Self {
        Self::new()
    }
}

impl SampleQueue {
    /// Appends a conversion. False if there is no place.
    #[inline]
    pub fn enqueue(&self, timed: TimedConversion) -> bool {
        let at = self.written.load(Relaxed);
        let is_last = at + 1 >= self.places.len();
        let next = if is_last { 0 } else { at + 1 };
        // Acquire: the place has been read.
        let is_free = next != self.read.load(Acquire);
        if is_free && let Some([t_us, bits]) = self.places.get(at) {
            t_us.store(timed.t_us, Relaxed);
            bits.store(timed.bits, Relaxed);
            self.written.store(next, Release);
        }
        is_free
    }

    /// The next conversion, which stays in the queue.
    pub fn peek(&self) -> Option<TimedConversion> {
        let next = &mut [TimedConversion::NONE];
        (self.copy(next, &[0]).count > 0).then_some(next[0])
    }

    /// Takes the next conversion.
    pub fn dequeue(&self) -> Option<TimedConversion> {
        let next = self.peek();
        self.release(next.is_some() as usize);
        next
    }

    /// Copies the next conversions to `to`, as many as there are, and compares their tags with those
    /// in `tags`, which is as long. They stay in the queue until [`Self::release`].
    #[inline(always)]
    pub(crate) fn copy(&self, to: &mut [TimedConversion], tags: &[u8]) -> Copied {
        let from = self.read.load(Relaxed);
        // Acquire: all before this place has been written.
        let end = self.written.load(Acquire);
        let mut copied = Copied { count: 0, off: 0 };
        let mut piece = |places: Option<&[Place]>| {
            let places = places.unwrap_or_default();
            let to = to.get_mut(copied.count..).unwrap_or_default();
            let tags = tags.get(copied.count..).unwrap_or_default();
            copied.count += places.len().min(to.len());
            for (([t_us, bits], to), tag) in places.iter().zip(to).zip(tags) {
                let (t_us, bits) = (t_us.load(Relaxed), bits.load(Relaxed));
                *to = TimedConversion { t_us, bits };
                copied.off |= bits ^ *tag as u32;
            }
        };
        if from <= end {
            piece(self.places.get(from..end));
        } else {
            piece(self.places.get(from..));
            piece(self.places.get(..end));
        }
        copied
    }

    /// True if no conversion waits.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.read.load(Relaxed) == self.written.load(Relaxed)
    }

    /// Takes conversions that were copied.
    #[inline]
    pub fn release(&self, count: usize) {
        let at = self.read.load(Relaxed) + count;
        let length = self.places.len();
        // Release: their places have been read.
        let at = if at < length { at } else { at - length };
        self.read.store(at, Release);
    }
}

/// Conversions that were copied.
pub(crate) struct Copied {
    pub count: usize,
    /// The lowest byte is not zero if a tag differs from the expected one.
    pub off: u32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;
    use std::thread;
    extern crate std;

    fn of(number: u32) -> TimedConversion {
        let bits = number << 8 | 3;
        TimedConversion { t_us: number, bits }
    }

    /// Batches of every size from every place, against a queue of the standard library.
    #[test]
    fn conversions_come_out_in_order_and_none_is_lost() {
        let (queue, mut model) = (SampleQueue::<[Place; 8]>::new(), VecDeque::new());
        let queue: &SampleQueue = &queue;
        let mut number = 0;
        for round in 0..1000usize {
            for _ in 0..round * 7 % 11 {
                let is_free = model.len() < 7;
                assert_eq!(queue.enqueue(of(number)), is_free, "round {round}");
                model.extend(is_free.then(|| of(number)));
                number += 1;
            }
            assert_eq!(queue.peek().as_ref(), model.front());
            let (mut copies, wanted) = ([TimedConversion::NONE; 8], round * 5 % 9);
            let odd = round % 10;
            let tags: [u8; 8] = core::array::from_fn(|at| if at == odd { 2 } else { 3 });
            let Copied { count, off } = queue.copy(&mut copies[..wanted], &tags[..wanted]);
            assert_eq!(count, wanted.min(model.len()));
            assert_eq!(off as u8 != 0, odd < count);
            assert!(
                copies[..count].iter().eq(model.iter().take(count)),
                "round {round}"
            );
            let taken = count - usize::from(count > 0 && round % 3 == 0);
            queue.release(taken);
            model.drain(..taken);
            assert_eq!(queue.dequeue(), model.pop_front());
        }
    }

    #[test]
    fn two_threads_hand_over_every_conversion() {
        let queue: &SampleQueue = &SampleQueue::<[Place; 5]>::new();
        thread::scope(|scope| {
            scope.spawn(move || {
                for number in 0..20_000 {
                    while !queue.enqueue(of(number)) {
                        thread::yield_now();
                    }
                }
            });
            let mut next = 0;
            while next < 20_000 {
                let mut copies = [TimedConversion::NONE; 4];
                let count = queue.copy(&mut copies, &[0; 4]).count;
                queue.release(count);
                for timed in &copies[..count] {
                    assert_eq!(*timed, of(next));
                    next += 1;
                }
                thread::yield_now();
            }
        });
    }
}
