//! A simulated network with delay and loss; the same seed gives the same behaviour.

use crate::stimulus::Delay;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::VecDeque;

/// One direction of the network.
pub struct Network {
    delay: Delay,
    /// Fraction of messages lost, 0 to 1.
    pub loss: f64,
    random: ChaCha8Rng,
    /// Arrival times and bytes, in the order of sending.
    under_way: VecDeque<(f64, Vec<u8>)>,
    pub sent: u64,
}

impl Network {
    pub fn new(delay: Delay, loss: f64, seed: u64) -> Self {
        Self {
            delay,
            loss,
            random: ChaCha8Rng::seed_from_u64(seed),
            under_way: VecDeque::new(),
            sent: 0,
        }
    }

    pub fn send(&mut self, t_s: f64, bytes: Vec<u8>) {
        self.sent += 1;
        let arrives_s = t_s + self.delay.at_s(t_s);
        // Uniform from 0 to 1, with 53 bits.
        let even = (self.random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        if even >= self.loss {
            self.under_way.push_back((arrives_s, bytes));
        }
    }

    /// Returns a message that has arrived by `t_s`; messages with a short delay overtake others.
    pub fn arrived(&mut self, t_s: f64) -> Option<Vec<u8>> {
        let (n, _) = (self.under_way.iter().enumerate())
            .filter(|(_, (arrives_s, _))| *arrives_s <= t_s)
            .min_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b))?;
        self.under_way.remove(n).map(|(_, bytes)| bytes)
    }
}
