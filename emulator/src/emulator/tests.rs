//! A program of one instruction.

use super::{Emulator, Start};
use crate::board::Board;
use crate::findings::Rule;
use crate::image::Image;
use hal_mock::Constant;

const STACK_END: u32 = 0x2000_1000;

/// A board whose stack begins here, and which does something undefined at once.
fn undefined_at(stack: u32) -> Emulator {
    // The stack, Reset, NMI, HardFault; UDF, then a branch to itself.
    let words = [stack, 0x0800_0011, 0, 0x0800_0013, 0xE7FE_DE00];
    let image = Image::of_words(&words, "_stack_end", STACK_END);
    Emulator::new(
        Board::FeatherF405,
        &image,
        Constant::default(),
        Start::default(),
    )
    .expect("vectors")
}

#[test]
pub(crate) fn a_stack_below_its_end() {
    for (stack, is_broken) in [(STACK_END + 0x100, false), (STACK_END - 8, true)] {
        let mut emulator = undefined_at(stack);
        emulator.run_ns(10_000).expect("a run");
        let broken: Vec<Rule> = emulator
            .findings()
            .iter()
            .map(|finding| finding.rule)
            .collect();
        assert_eq!(
            broken,
            if is_broken {
                vec![Rule::StackEnd]
            } else {
                vec![]
            },
            "{stack:#x}"
        );
    }
}
