//! A network that delays, loses, doubles and damages, simulated: the same seed does the same.

use crate::stimulus::Delay;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::VecDeque;

/// Impairments, each as a fraction of the messages, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impairments {
    pub loss: f64,
    pub doubled: f64,
    /// One bit of them is another.
    pub damaged: f64,
}

/// One way.
pub struct Network {
    delay: Delay,
    pub impairments: Impairments,
    random: ChaCha8Rng,
    /// Time of arrival, and bytes: in the order of sending.
    under_way: VecDeque<(f64, Vec<u8>)>,
    pub sent: u64,
}

impl Network {
    pub fn new(delay: Delay, impairments: Impairments, seed: u64) -> Self {
        Self {
            delay,
            impairments,
            random: ChaCha8Rng::seed_from_u64(seed),
            under_way: VecDeque::new(),
            sent: 0,
        }
    }

    fn happens(&mut self, fraction: f64) -> bool {
        // 53 bits.
        ((self.random.next_u64() >> 11) as f64) < fraction * (1u64 << 53) as f64
    }

    /// Sends a message at a time, seconds.
    pub fn send(&mut self, t_s: f64, bytes: Vec<u8>) {
        self.sent += 1;
        let arrives_s = t_s + self.delay.at_s(t_s);
        if self.happens(self.impairments.doubled) {
            self.carry(arrives_s, bytes.clone());
        }
        self.carry(arrives_s, bytes);
    }

    fn carry(&mut self, arrives_s: f64, mut bytes: Vec<u8>) {
        if self.happens(self.impairments.loss) {
            return;
        }
        if self.happens(self.impairments.damaged) {
            let bits = 8 * bytes.len().max(1) as u64;
            let bit = (self.random.next_u64() % bits) as usize;
            if let Some(byte) = bytes.get_mut(bit / 8) {
                *byte ^= 1 << (bit % 8);
            }
        }
        self.under_way.push_back((arrives_s, bytes));
    }

    /// A message that has arrived by a time; a short delay overtakes a longer one.
    pub fn arrived(&mut self, t_s: f64) -> Option<Vec<u8>> {
        let (n, _) = (self.under_way.iter().enumerate())
            .filter(|(_, (arrives_s, _))| *arrives_s <= t_s)
            .min_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b))?;
        self.under_way.remove(n).map(|(_, bytes)| bytes)
    }
}
