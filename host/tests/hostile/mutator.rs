//! Damages bytes at random, reproducibly from a seed.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Bytes that are likely to confuse readers of text and of lengths.
const TOKENS: [&[u8]; 16] = [
    b"nan",
    b"-inf",
    b"1e309",
    b"-1e-320",
    b"99999999999999999999",
    b"-0",
    b"\"",
    b"\n",
    b"\r",
    b",",
    b";",
    b"=",
    b"[[",
    b"\0",
    b"\xff\xff\xff\xff",
    b"\xef\xbb\xbf",
];

const CHANGES_MAX: usize = 6;

/// Maximum length of a piece that is removed, repeated or copied from a different input, bytes.
const PIECE_MAX: usize = 48;

pub struct Mutator(ChaCha8Rng);

impl Mutator {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn below(&mut self, max: usize) -> usize {
        self.0.next_u32() as usize % max.max(1)
    }

    pub fn changed(&mut self, wholes: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = wholes[self.below(wholes.len())].clone();
        for _ in 0..=self.below(CHANGES_MAX) {
            self.change(&mut bytes, wholes);
        }
        bytes
    }

    fn change(&mut self, bytes: &mut Vec<u8>, wholes: &[Vec<u8>]) {
        let at = self.below(bytes.len());
        let end = (at + 1 + self.below(PIECE_MAX)).min(bytes.len());
        match self.below(8) {
            0 | 1 => {
                let bit = self.below(8);
                bytes
                    .get_mut(at)
                    .into_iter()
                    .for_each(|byte| *byte ^= 1 << bit);
            }
            2 => drop(bytes.drain(at..end)),
            3 => {
                let piece = bytes[at..end].to_vec();
                self.insert(bytes, &piece);
            }
            4 => {
                let other = &wholes[self.below(wholes.len())];
                let from = self.below(other.len());
                let until = (from + 1 + self.below(PIECE_MAX)).min(other.len());
                self.insert(bytes, &other[from..until]);
            }
            5 => {
                let byte = self.0.next_u32() as u8;
                self.insert(bytes, &[byte]);
            }
            6 => {
                let token = TOKENS[self.below(TOKENS.len())];
                self.insert(bytes, token);
            }
            // Truncate only rarely.
            _ if self.below(4) == 0 => bytes.truncate(at),
            _ => {}
        }
    }

    fn insert(&mut self, bytes: &mut Vec<u8>, piece: &[u8]) {
        let at = self.below(bytes.len() + 1);
        bytes.splice(at..at, piece.iter().copied());
    }
}
