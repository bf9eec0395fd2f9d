//! The flash.

use super::{Bench, FLASH_CR, FLASH_KEYR, FREE};
use crate::findings::Rule;

#[test]
pub(super) fn the_flash_against_its_rules() {
    let mut right = Bench::ready();
    right
        .unlock()
        .set(FLASH_CR, 1 | 2 << 8)
        .set(FREE, 0x1234_5678);
    right.keeps_all();
    assert_eq!(right.get(FREE), 0x1234_5678);
    right.set(FREE, 0x1234_0000);
    right.breaks(Rule::FlashWordTwice);

    let mut locked = Bench::ready();
    locked.set(FREE, 0);
    locked.breaks(Rule::FlashSequence);
    assert_eq!(locked.get(FREE), u32::MAX);

    let mut narrow = Bench::ready();
    narrow.unlock().set(FLASH_CR, 1);
    narrow.set(FREE, 0);
    narrow.breaks(Rule::FlashSequence);

    let mut wrong_key = Bench::ready();
    wrong_key.set(FLASH_KEYR, 0x4567_0124);
    wrong_key.breaks(Rule::FlashSequence);

    // LOCK in the write that chooses the sector: the next one, with STRT, is lost.
    let mut locks_itself = Bench::ready();
    locks_itself
        .unlock()
        .set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 31);
    locks_itself.breaks(Rule::FlashSequence);
    locks_itself.set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 16);
    assert_eq!(locks_itself.0.flash.erased, 0);

    // Without keys at all.
    let mut locked = Bench::ready();
    locked.set(FLASH_CR, 1 | 2 << 8);
    locked.breaks(Rule::FlashSequence);
    assert_eq!(locked.get(FLASH_CR), 1 << 31, "the write is lost");

    let mut erases = Bench::ready();
    erases
        .unlock()
        .set(FLASH_CR, 1 | 2 << 8)
        .set(FREE, 0)
        .set(FLASH_CR, 2 | 11 << 3 | 2 << 8 | 1 << 16);
    erases.keeps_all();
    assert_eq!(erases.get(FREE), u32::MAX);
}
