//! The settings' store in that flash, and in one that wears out.

use super::*;
use ridgetone_proto::store::{NotStored, Saved};

/// Bytes of a record, as the flash counts them.
const RECORD_BYTES: u32 = ridgetone_proto::store::RECORD_BYTES as u32;

#[test]
fn power_lost_at_any_word_leaves_the_old_settings_or_the_new_ones() {
    let mut cuts = Cuts::default();
    for seed in 0..40 {
        // One record a page, two, and eight and a bit.
        cuts += cut_everywhere::<RECORD_BYTES>(0, 5, seed);
        cuts += cut_everywhere::<{ 2 * RECORD_BYTES }>(0, 7, seed);
        cuts += cut_everywhere::<{ 8 * RECORD_BYTES + 104 }>(8, 16, seed);
    }
    println!("{cuts:?}");
    assert!(
        cuts.injected > 30_000
            && cuts.old > 1000
            && cuts.reported > 1000
            && cuts.new > 100
            && cuts.defaults > 100,
        "{cuts:?}"
    );
    assert_eq!(cuts.wrong, 0, "{cuts:?}");
}

/// What an interrupted erasure leaves is not guaranteed (RM0090, 3.6): it may have done some words
/// wholly and left the others as they were, old records among them.
#[test]
fn an_erasure_that_hardly_began_or_was_nearly_done_brings_no_old_settings_back() {
    const PAGE_BYTES: usize = 10 * RECORD_BYTES as usize;
    // Both pages full, so that the first one is to be erased, and then the second one.
    for (page, saves) in [(0, 20), (1, 30)] {
        let mut store = FlashStore::new(CutFlash::<{ PAGE_BYTES as u32 }>::new(1));
        (0..saves).for_each(|number| assert!(store.save(Some(&settings(number)), true).is_ok()));
        let flash = store.release();
        let last = settings(saves - 1);
        for from in (0..=PAGE_BYTES).step_by(WORD_BYTES) {
            for erased in [0..from, from..PAGE_BYTES] {
                let left = flash.clone().with_bytes(|at| {
                    let is_erased = at / PAGE_BYTES == page && erased.contains(&(at % PAGE_BYTES));
                    if is_erased { 0xff } else { flash.bytes[at] }
                });
                let mut store = FlashStore::new(left);
                let (found, source) = store.load();
                let is_stored = matches!(
                    source,
                    SettingsSource::Stored | SettingsSource::StoredBefore
                );
                assert!(
                    found == last && is_stored,
                    "page {page}, {erased:?}: {found:?} {source:?}"
                );
                assert!(
                    store.save(Some(&settings(saves)), true).is_ok(),
                    "page {page}, {erased:?}"
                );
                assert_eq!(
                    store.load(),
                    (settings(saves), SettingsSource::Stored),
                    "page {page}, {erased:?}"
                );
                assert_eq!(store.release().wrong, 0, "page {page}, {erased:?}");
            }
        }
    }
}

/// The sectors of the STM32F405, full: the roll to the other one and back.
#[test]
fn so_it_is_in_sectors_of_the_real_size() {
    let slots = u64::from(128 * 1024 / RECORD_BYTES);
    let cuts = cut_everywhere::<{ 128 * 1024 }>(2 * slots - 1, 2, 1);
    assert!(cuts.injected > 90 && cuts.wrong == 0, "{cuts:?}");
}

#[test]
fn rubbish_in_the_flash_gives_the_defaults_and_says_so() {
    for seed in 0..20 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let flash =
            CutFlash::<{ 10 * RECORD_BYTES }>::new(seed).with_bytes(|_| random.next_u32() as u8);
        let mut store = FlashStore::new(flash);
        assert_eq!(store.load(), (Settings::DEFAULT, SettingsSource::Damaged));
        assert_eq!(
            store.save(Some(&settings(5)), false),
            Err(NotStored),
            "not without erasing"
        );
        assert_eq!(store.save(Some(&settings(5)), true), Ok(Saved::Erasing));
        assert_eq!(store.load(), (settings(5), SettingsSource::Stored));
        assert_eq!(store.release().wrong, 0);
    }
    assert_eq!(
        FlashStore::new(CutFlash::<{ 10 * RECORD_BYTES }>::new(1))
            .load()
            .1,
        SettingsSource::Default
    );
}

/// Sectors of 128 KiB, as on the board, full of anything: each of the 2,730 places is looked at a
/// few times and not once for every other, which would keep the board from its first word for
/// seconds.
#[test]
fn rubbish_in_whole_sectors_is_passed_over_quickly() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let flash = CutFlash::<131_072>::new(1).with_bytes(|_| random.next_u32() as u8);
    let mut store = FlashStore::new(flash);
    assert_eq!(store.load(), (Settings::DEFAULT, SettingsSource::Damaged));
    let reads = store.release().reads;
    assert!((2_730..4 * 2_730).contains(&reads), "{reads} reads");
}

#[test]
fn what_was_stored_last_and_is_spoilt_gives_what_was_stored_before() {
    let mut store = FlashStore::new(CutFlash::<{ 10 * RECORD_BYTES }>::new(1));
    for number in 0..3 {
        assert_eq!(
            store.save(Some(&settings(number)), false),
            Ok(Saved::AtOnce)
        );
    }
    // A bit of the third record's settings.
    let mut flash = store.release();
    flash.bytes[2 * RECORD_BYTES as usize + 8] ^= 4;
    let mut store = FlashStore::new(flash);
    assert_eq!(store.load(), (settings(1), SettingsSource::StoredBefore));
    // Forgetting is a record too.
    assert_eq!(store.save(None, false), Ok(Saved::AtOnce));
    assert_eq!(store.load(), (Settings::DEFAULT, SettingsSource::Default));
    assert_eq!(store.release().wrong, 0);
}

/// In a touch nothing is erased, and what was stored stays.
#[test]
fn a_full_page_is_not_erased_without_permission() {
    let mut store = FlashStore::new(CutFlash::<{ 2 * RECORD_BYTES }>::new(1));
    for number in 0..4 {
        assert_eq!(store.save(Some(&settings(number)), true), Ok(Saved::AtOnce));
    }
    assert_eq!(store.save(Some(&settings(4)), false), Err(NotStored));
    assert_eq!(store.load(), (settings(3), SettingsSource::Stored));
    assert_eq!(store.save(Some(&settings(4)), true), Ok(Saved::Erasing));
    assert_eq!(store.load(), (settings(4), SettingsSource::Stored));
    let flash = store.release();
    assert_eq!((flash.erased, flash.wrong), (1, 0));
}

/// Pages in which some words are worn out and cannot be programmed.
struct Worn {
    flash: CutFlash<{ 10 * RECORD_BYTES }>,
    is_worn: fn(u32) -> bool,
}

impl ErrorType for Worn {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Worn {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        self.flash.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl NorFlash for Worn {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = 10 * RECORD_BYTES as usize;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        (offset..)
            .step_by(WORD_BYTES)
            .zip(bytes.as_chunks::<WORD_BYTES>().0)
            .try_for_each(|(offset, word)| {
                let sticks = (self.is_worn)(offset) as u8;
                self.flash.program(offset, word.map(|byte| byte | sticks))
            })
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.flash.erase(from, to)
    }
}

#[test]
fn what_cannot_be_read_back_is_stored_in_another_place() {
    let load = |worn: Worn| FlashStore::new(worn).load();
    let mut store = FlashStore::new(Worn {
        flash: CutFlash::new(1),
        is_worn: |_| false,
    });
    assert_eq!(store.save(Some(&settings(1)), true), Ok(Saved::AtOnce));
    let flash = store.release().flash;

    // A word of each of the next two places.
    let is_worn: fn(u32) -> bool = |offset| [RECORD_BYTES, 2 * RECORD_BYTES - 24].contains(&offset);
    let mut store = FlashStore::new(Worn {
        flash: flash.clone(),
        is_worn,
    });
    assert_eq!(store.save(Some(&settings(2)), true), Ok(Saved::AtOnce));
    let flash_after = store.release().flash;
    assert_eq!(flash_after.wrong, 0);
    let (kept, source) = load(Worn {
        flash: flash_after,
        is_worn,
    });
    assert_eq!(kept, settings(2));
    assert!(
        matches!(
            source,
            SettingsSource::Stored | SettingsSource::StoredBefore
        ),
        "{source:?}"
    );

    // All of them: refused, and what was there is there still.
    let mut store = FlashStore::new(Worn {
        flash,
        is_worn: |_| true,
    });
    assert_eq!(store.save(Some(&settings(2)), true), Err(NotStored));
    let (kept, _) = load(store.release());
    assert_eq!(kept, settings(1));
}
