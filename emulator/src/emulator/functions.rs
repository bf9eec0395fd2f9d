//! Instructions and cycles by function.

use super::counts::Counts;
use super::run::Emulator;
use crate::cpu::FLASH;
use crate::image::Image;

/// Counts of one function, without those of the functions that it calls.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionCounts {
    /// Name, demangled. Where the linker has merged functions it is one of theirs.
    pub name: String,
    /// Instructions that ran.
    pub instructions: u64,
    /// Cycles that they took, waits for registers and the flash included.
    pub cycles: u64,
}

impl Emulator {
    /// Begins to count instructions by function, from zero. A run then takes a quarter more time.
    pub fn count_functions(&mut self) {
        self.counts = Some(Counts::new(self.bus.flash.bytes.len()));
    }

    /// Counts since [`Self::count_functions`], the function with most instructions first.
    /// `image` is the one that runs. Functions that did not run are left out.
    pub fn function_counts(&self, image: &Image) -> Vec<FunctionCounts> {
        let Some(Counts(counts)) = &self.counts else {
            return Vec::new();
        };
        let half_word =
            |address: u32| ((address.wrapping_sub(FLASH) >> 1) as usize).min(counts.len());
        let mut functions: Vec<_> = image
            .functions
            .iter()
            .map(|function| {
                let end = function.address.saturating_add(function.bytes);
                let own = &counts[half_word(function.address)..half_word(end)];
                let sum = |at: usize| own.iter().map(|counts| counts[at]).sum();
                FunctionCounts {
                    name: function.name.clone(),
                    instructions: sum(0),
                    cycles: sum(1),
                }
            })
            .filter(|function| function.instructions > 0)
            .collect();
        functions.sort_by_key(|function| std::cmp::Reverse(function.instructions));
        functions
    }
}
