//! Instructions and cycles by function.

use super::counts::Counts;
use super::run::Emulator;
use crate::cpu::FLASH;
use crate::image::Image;

/// Counts of one function, excluding functions that it calls.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FunctionCounts {
    /// Demangled name. If the linker has merged functions, the name of one of them.
    pub name: String,
    /// Instructions executed.
    pub instructions: u64,
    /// Cycles taken, including waits for registers and the flash.
    pub cycles: u64,
}

impl Emulator {
    /// Starts counting instructions by function, from zero. Runs then take a quarter more time.
    pub fn count_functions(&mut self) {
        self.counts = Some(Counts::new(self.bus.flash.bytes.len()));
    }

    /// Counts since [`Self::count_functions`], sorted by instructions in descending order. `image`
    /// must be the running image. Functions that did not run are omitted.
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
