//! Means of the latest blocks of frames, for the comparisons of [`crate::touch::motion`]: each
//! block for a short while, sums of two for longer, and sums of eight for the longest.

use crate::touch::values::{add, scale};
use ridgetone_proto::settings::TAXELS;
use ridgetone_tone::Values;

/// Number of blocks kept. A power of two, because indices wrap.
const HISTORY: usize = 8;
/// Number of pairs of blocks kept: 0.27 s. A power of two too.
const PAIRS: usize = 8;
/// Maximum number of blocks that [`Past::mean_of_four`] can leave out.
pub const FURTHEST: usize = 2 * PAIRS - 4;
/// Pairs in a sum of eight blocks.
const PAIRS_OF_EIGHT: usize = 4;
/// Number of sums of eight blocks kept: 0.66 s.
pub const EIGHTS: usize = 5;
/// Maximum count of blocks.
const COUNTED: usize = 15;

/// Means of the latest blocks.
#[derive(Clone, Debug)]
pub struct Past {
    blocks: [Values; HISTORY],
    /// Sums of two blocks, not overlapping.
    pairs: [Values; PAIRS],
    /// Sums of eight blocks.
    eights: [Values; EIGHTS],
    latest_pair: usize,
    latest_eight: usize,
    /// True if the latest block ended a pair; and true if it ended eight blocks.
    pub pair_is_new: bool,
    pub eight_is_new: bool,
    /// Index of the latest block.
    latest: usize,
    /// Blocks since the last restart, at most [`COUNTED`].
    pub count: usize,
    /// Sums of eight blocks since the comparison of these was restarted, at most [`EIGHTS`].
    pub count_of_eights: usize,
}

impl Past {
    pub const fn new() -> Self {
        Self {
            blocks: [[0.0; TAXELS]; HISTORY],
            pairs: [[0.0; TAXELS]; PAIRS],
            eights: [[0.0; TAXELS]; EIGHTS],
            latest_pair: 0,
            latest_eight: 0,
            pair_is_new: false,
            eight_is_new: false,
            latest: 0,
            count: 0,
            count_of_eights: 0,
        }
    }

    pub fn push(&mut self, mean: Values) {
        let at = (self.latest + 1) % HISTORY;
        self.pair_is_new = !self.pair_is_new;
        if self.pair_is_new {
            let pair = (self.latest_pair + 1) % PAIRS;
            self.pairs[pair] = mean;
            add(&mut self.pairs[pair], &self.blocks[self.latest % HISTORY]);
            self.latest_pair = pair;
        }
        self.eight_is_new = self.pair_is_new && self.latest_pair.is_multiple_of(PAIRS_OF_EIGHT);
        if self.eight_is_new {
            self.add_eight();
        }
        self.blocks[at] = mean;
        self.latest = at;
        self.count = (self.count + 1).min(COUNTED);
    }

    fn add_eight(&mut self) {
        self.latest_eight = (self.latest_eight + 1) % EIGHTS;
        self.eights[self.latest_eight] = self.sum_of_pairs(PAIRS_OF_EIGHT);
        self.count_of_eights = (self.count_of_eights + 1).min(EIGHTS);
    }

    /// The block `back` blocks before the latest, at most [`HISTORY`] - 1. It may be older than a
    /// restart.
    pub fn back(&self, back: usize) -> &Values {
        &self.blocks[self.latest.wrapping_sub(back) % HISTORY]
    }

    /// The sum of a pair of blocks, `back` pairs before the latest pair.
    pub fn pair(&self, back: usize) -> &Values {
        &self.pairs[self.latest_pair.wrapping_sub(back) % PAIRS]
    }

    /// The sum of eight blocks, `back` such sums before the latest one, less than [`EIGHTS`].
    pub fn eight(&self, back: usize) -> &Values {
        &self.eights[(self.latest_eight + EIGHTS - back) % EIGHTS]
    }

    /// The mean of the four blocks before the latest `skip`, at most [`FURTHEST`]. Older blocks are
    /// kept in pairs: `skip` is one less where it would cut a pair.
    pub fn mean_of_four(&self, skip: usize) -> Values {
        let mut sum = [0.0; TAXELS];
        if skip + 4 > HISTORY {
            let back = (skip - usize::from(!self.pair_is_new)) / 2;
            (back..back + 2).for_each(|back| add(&mut sum, self.pair(back)));
        } else {
            (skip..skip + 4).for_each(|back| add(&mut sum, self.back(back)));
        }
        scale(&mut sum, 0.25);
        sum
    }

    /// Mean of the last [`PAIRS`], or of the pairs since a restart.
    pub fn recent_mean(&self) -> Values {
        let pairs = (self.count / 2).clamp(1, PAIRS);
        let mut mean = self.sum_of_pairs(pairs);
        scale(&mut mean, 0.5 / pairs as f32);
        mean
    }

    fn sum_of_pairs(&self, pairs: usize) -> Values {
        let mut sum = [0.0; TAXELS];
        (0..pairs).for_each(|back| add(&mut sum, self.pair(back)));
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks whose means are their numbers: each sum is that of the numbers.
    #[test]
    fn means_and_sums_are_those_of_the_latest_blocks() {
        let mut past = Past::new();
        for number in 1..=100u16 {
            past.push([f32::from(number); TAXELS]);
            if number <= 48 {
                continue;
            }
            let number = f32::from(number);
            assert_eq!(
                (past.back(0)[3], past.back(7)[3], past.mean_of_four(4)[3]),
                (number, number - 7.0, number - 5.5)
            );
            for skip in 5..=FURTHEST as u8 {
                let off = past.mean_of_four(skip.into())[3] - (number - f32::from(skip) - 1.5);
                assert!(off == 0.0 || off == 1.0, "{skip}: {off}");
            }
            let (latest, oldest) = (past.eight(0)[3] / 8.0, past.eight(EIGHTS - 1)[3] / 8.0);
            let age = number - latest;
            assert!((3.5..11.5).contains(&age), "{number}: {latest}");
            assert_eq!(latest - oldest, 8.0 * (EIGHTS - 1) as f32);
            assert_eq!(past.eight_is_new, age == 3.5);
        }
    }
}
