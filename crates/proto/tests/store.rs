//! Tests the store of settings in a flash that loses power, wears out, or was written by different
//! firmware.

#[path = "store/other_firmware.rs"]
mod other_firmware;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use hal_mock::CutFlash;
use other_firmware::with_pairs;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::framing::checksum;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::{Settings, TABLE};
use ridgetone_proto::store::{FlashStore, NotStored, Saved, Store, WORD_BYTES};

/// Bytes of a record, in the type of flash addresses.
const RECORD_BYTES: u32 = ridgetone_proto::store::RECORD_BYTES as u32;

fn settings(number: u64) -> Settings {
    Settings {
        window_s: 0.1 + (number % 3800) as f32 * 1e-3,
        ..Settings::DEFAULT
    }
}

fn empty<const PAGE_BYTES: u32>() -> FlashStore<CutFlash<PAGE_BYTES>> {
    FlashStore::new(CutFlash::new(1))
}

const STORED: SettingsSource = SettingsSource::Stored;
const DEFAULT: (Settings, SettingsSource) = (Settings::DEFAULT, SettingsSource::Default);
const DAMAGED: (Settings, SettingsSource) = (Settings::DEFAULT, SettingsSource::Damaged);

/// Returns the settings found when the board starts after a power loss.
fn found<const PAGE_BYTES: u32>(flash: &CutFlash<PAGE_BYTES>) -> (Settings, SettingsSource) {
    let mut store = FlashStore::new(flash.clone().power(None));
    let found = store.load();
    assert_eq!(store.load(), found, "the second time");
    assert_eq!(store.release().wrong, 0);
    found
}

/// Checks the settings found after power was lost while `new` settings were stored over `old` ones:
/// either must be found. For the old ones, the source must report that a newer record was begun.
fn check_cut<const PAGE_BYTES: u32>(
    flash: &CutFlash<PAGE_BYTES>,
    old: Option<Settings>,
    new: Settings,
) -> (Settings, SettingsSource) {
    let (settings, source) = found(flash);
    let is_right = match source {
        SettingsSource::Stored => settings == new || Some(settings) == old && !flash.is_marked,
        SettingsSource::StoredBefore => Some(settings) == old,
        SettingsSource::Default => old.is_none() && !flash.is_marked,
        SettingsSource::Damaged => old.is_none(),
        SettingsSource::Migrated | SettingsSource::Sent => false,
    };
    assert!(is_right, "{settings:?} {source:?} over {old:?}");
    (settings, source)
}

fn is_stored(source: SettingsSource) -> bool {
    matches!(
        source,
        SettingsSource::Stored | SettingsSource::StoredBefore
    )
}

/// Stores `saves` settings into pages that contain `prefilled` records, and loses power in the
/// middle of every word and erase, and again in the middle of the next save. Returns the sources of
/// the settings found.
fn cut_everywhere<const PAGE_BYTES: u32>(
    prefilled: u64,
    saves: u64,
    seed: u64,
) -> Vec<SettingsSource> {
    let mut sources = Vec::new();
    let mut store = FlashStore::new(CutFlash::<PAGE_BYTES>::new(seed));
    (0..prefilled).for_each(|number| assert!(store.save(Some(&settings(number)), true).is_ok()));
    let mut flash = store.release();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for number in prefilled..prefilled + saves {
        let (old, new) = (number.checked_sub(1).map(settings), settings(number));
        for cut in 0.. {
            let mut store = FlashStore::new(flash.clone().power(Some(cut)));
            let saved = store.save(Some(&new), true);
            let left = store.release();
            if !left.is_off {
                // The save was complete before the power cut.
                assert!(saved.is_ok());
                flash = left;
                break;
            }
            let (there, source) = check_cut(&left, old, new);
            sources.push(source);
            let before = if there == new { Some(new) } else { old };
            // Power returns and is lost again during the next save.
            let again = random.next_u64() % 70;
            let mut store = FlashStore::new(left.power(Some(again)));
            let saved = store.save(Some(&settings(number + 1)), true);
            let left = store.release();
            if left.is_off {
                sources.push(check_cut(&left, before, settings(number + 1)).1);
            } else {
                assert!(saved.is_ok());
            }
            let mut store = FlashStore::new(left.power(None));
            assert!(store.save(Some(&settings(number + 2)), true).is_ok());
            let last = (settings(number + 2), SettingsSource::Stored);
            assert_eq!(found(&store.release()), last);
        }
    }
    sources
}

#[test]
fn power_lost_at_any_word_leaves_the_old_settings_or_the_new_ones() {
    let mut sources = Vec::new();
    for seed in 0..12 {
        // Pages of one record, of two, and of eight with some bytes to spare.
        sources.extend(cut_everywhere::<RECORD_BYTES>(0, 5, seed));
        sources.extend(cut_everywhere::<{ 2 * RECORD_BYTES }>(0, 7, seed));
        sources.extend(cut_everywhere::<{ 8 * RECORD_BYTES + 104 }>(8, 16, seed));
    }
    let count = |source| sources.iter().filter(|found| **found == source).count();
    for source in [
        SettingsSource::Stored,
        SettingsSource::StoredBefore,
        SettingsSource::Default,
        SettingsSource::Damaged,
    ] {
        assert!(count(source) > 10, "{source:?}: {}", count(source));
    }
    assert!(sources.len() > 20_000, "{}", sources.len());
}

/// An interrupted erase leaves undefined data (RM0090, 3.6). It may have erased some words
/// completely and left others unchanged, including old records.
#[test]
fn an_erasure_that_hardly_began_or_was_nearly_done_brings_no_old_settings_back() {
    const PAGE_BYTES: usize = 10 * RECORD_BYTES as usize;
    // Both pages are full, so that the next save erases the first page, and then the second.
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
                let what = format!("page {page}, {erased:?}: {found:?} {source:?}");
                assert!(found == last && is_stored(source), "{what}");
                assert!(store.save(Some(&settings(saves)), true).is_ok(), "{what}");
                assert_eq!(store.load(), (settings(saves), STORED), "{what}");
                assert_eq!(store.release().wrong, 0, "{what}");
            }
        }
    }
}

/// Full sectors of the STM32F405. Storing rolls over to the other sector and back.
#[test]
fn power_lost_in_sectors_of_the_real_size_leaves_the_old_settings_or_the_new_ones() {
    let slots = u64::from(128 * 1024 / RECORD_BYTES);
    let sources = cut_everywhere::<{ 128 * 1024 }>(2 * slots - 1, 2, 1);
    assert!(sources.len() > 150, "{}", sources.len());
}

#[test]
fn rubbish_in_the_flash_gives_the_defaults_and_says_so() {
    for seed in 0..20 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let flash =
            CutFlash::<{ 10 * RECORD_BYTES }>::new(seed).with_bytes(|_| random.next_u32() as u8);
        let mut store = FlashStore::new(flash);
        assert_eq!(store.load(), DAMAGED);
        // Nothing is stored without permission to erase.
        assert_eq!(store.save(Some(&settings(5)), false), Err(NotStored));
        assert_eq!(store.save(Some(&settings(5)), true), Ok(Saved::Erasing));
        assert_eq!(store.load(), (settings(5), STORED));
        assert_eq!(store.release().wrong, 0);
    }
    assert_eq!(empty::<{ 10 * RECORD_BYTES }>().load(), DEFAULT);
}

/// The sectors of 128 KiB, as on the board, contain random data. A start must check each of the
/// 2,048 slots only a few times: checking it once for every other slot would delay the board's
/// first word by seconds.
#[test]
fn rubbish_in_whole_sectors_is_passed_over_quickly() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let flash = CutFlash::<131_072>::new(1).with_bytes(|_| random.next_u32() as u8);
    let mut store = FlashStore::new(flash);
    assert_eq!(store.load(), DAMAGED);
    let reads = store.release().reads;
    assert!((2_048..4 * 2_048).contains(&reads), "{reads} reads");
}

#[test]
fn what_was_stored_last_and_is_spoilt_gives_what_was_stored_before() {
    let mut store = empty::<{ 10 * RECORD_BYTES }>();
    for number in 0..3 {
        let saved = store.save(Some(&settings(number)), false);
        assert_eq!(saved, Ok(Saved::AtOnce));
    }
    let mut flash = store.release();
    flash.bytes[2 * RECORD_BYTES as usize + 8] ^= 4;
    let mut store = FlashStore::new(flash);
    assert_eq!(store.load(), (settings(1), SettingsSource::StoredBefore));
    // Deleting the settings is also a record.
    assert_eq!(store.save(None, false), Ok(Saved::AtOnce));
    assert_eq!(store.load(), DEFAULT);
    assert_eq!(store.release().wrong, 0);
}

/// During a touch nothing is erased, and stored settings are kept.
#[test]
fn a_full_page_is_not_erased_without_permission() {
    let mut store = empty::<{ 2 * RECORD_BYTES }>();
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

/// Pages with some worn words that cannot be programmed.
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
                self.flash.write(offset, &word.map(|byte| byte | sticks))
            })
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.flash.erase(from, to)
    }
}

#[test]
fn what_cannot_be_read_back_is_stored_in_another_place() {
    let store = |flash, is_worn| FlashStore::new(Worn { flash, is_worn });
    let mut sound = store(CutFlash::new(1), |_| false);
    assert_eq!(sound.save(Some(&settings(1)), true), Ok(Saved::AtOnce));
    let flash = sound.release().flash;

    // Wear out a word in each of the next two slots.
    let is_worn: fn(u32) -> bool = |offset| [RECORD_BYTES, 2 * RECORD_BYTES - 24].contains(&offset);
    let mut partly = store(flash.clone(), is_worn);
    assert_eq!(partly.save(Some(&settings(2)), true), Ok(Saved::AtOnce));
    let flash_after = partly.release().flash;
    assert_eq!(flash_after.wrong, 0);
    let (kept, source) = store(flash_after, is_worn).load();
    assert!(kept == settings(2) && is_stored(source), "{source:?}");

    // All words are worn out: saving is refused, and the old settings are kept.
    let mut worn_out = store(flash, |_| true);
    assert_eq!(worn_out.save(Some(&settings(2)), true), Err(NotStored));
    assert_eq!(worn_out.load().0, settings(1));
}

fn with_bytes(bytes: &[u8]) -> CutFlash<{ 10 * RECORD_BYTES }> {
    CutFlash::new(1).with_bytes(|at| bytes.get(at).copied().unwrap_or(0xff))
}

#[test]
fn an_id_from_the_future_is_skipped_and_one_that_is_missing_has_its_default() {
    let kept = Settings {
        harmonics: 2,
        accuracy: 0.01,
        plan: Plan::HAND,
        window_s: 0.2,
        ..settings(3)
    };
    let mut store = FlashStore::new(with_bytes(&[]));
    assert_eq!(store.save(Some(&kept), false), Ok(Saved::AtOnce));
    let pairs = other_firmware::pairs(&other_firmware::first(&mut store.release()));
    let number = 7;
    let load = |pairs: &[(u8, Vec<u8>)]| found(&with_bytes(&with_pairs(number, pairs)));
    assert_eq!(load(&pairs), (kept, SettingsSource::Stored));

    // Insert unknown pairs of zero, one or many bytes before, between and after the known ones.
    for place in [0, 5, pairs.len()] {
        for bytes in [0, 1, 60] {
            let mut more = pairs.clone();
            more.insert(place, (200, vec![0xa5; bytes]));
            assert_eq!(load(&more), (kept, SettingsSource::Migrated), "{place}");
        }
    }
    let default = Settings {
        harmonics: Settings::DEFAULT.harmonics,
        ..kept
    };
    let harmonics = TABLE.iter().find(|setting| setting.name == "harmonics");
    let harmonics = harmonics.expect("a setting").id;
    let others = pairs.iter().filter(|(id, _)| *id != harmonics).cloned();
    let others: Vec<_> = others.collect();
    assert_eq!(load(&others), (default, SettingsSource::Migrated));
    // A value of a different size counts as missing.
    let other_type = [others.clone(), vec![(harmonics, vec![2, 0])]].concat();
    assert_eq!(load(&other_type), (default, SettingsSource::Migrated));
    // A record with a value out of bounds or a truncated list must not be used.
    let refused = [others.clone(), vec![(harmonics, vec![9])]].concat();
    assert_eq!(load(&refused), DAMAGED);
    let mut cut_off = with_pairs(number, &pairs[..1]);
    cut_off[6] = 250;
    let content = [&cut_off[..124], &cut_off[128..252]].concat();
    cut_off[124..128].copy_from_slice(&checksum(&content[..124]).to_le_bytes());
    cut_off[252..].copy_from_slice(&checksum(&content).to_le_bytes());
    assert_eq!(found(&with_bytes(&cut_off)), DAMAGED);
}

/// Halves of two different records must not be accepted as one.
#[test]
fn the_second_half_belongs_to_its_first() {
    let mut store = FlashStore::new(with_bytes(&[]));
    for number in [1, 2] {
        let saved = store.save(Some(&settings(number)), false);
        assert_eq!(saved, Ok(Saved::AtOnce));
    }
    let bytes = store.release().bytes;
    let (first, second) = bytes.split_at(RECORD_BYTES as usize);
    let half = first.len() / 2;
    let mixed = [&first[..half], &second[half..2 * half]].concat();
    assert_eq!(found(&with_bytes(&mixed)), DAMAGED);
}
