//! Loss of power at every word that the store of settings writes, in a flash on this PC.
//!
//! The flash works as in the manual: erasing sets bits, programming clears them. An operation that
//! loses power has changed any part of its bits, and no others.

use super::counts::add_fields;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::{FlashStore, PAGES, Store, WORD_BYTES};

/// Two pages of flash that lose power after a number of words and erasures.
#[derive(Clone, Debug)]
pub struct CutFlash<const PAGE_BYTES: u32> {
    pub bytes: Vec<u8>,
    /// Operations until power is lost; none: it is not.
    left: Option<u64>,
    pub done: u64,
    pub is_off: bool,
    /// Operations beyond the pages, or that program words that are not erased. Must be zero.
    pub wrong: u64,
    pub erased: u64,
    pub reads: u64,
    /// Whether a bit was cleared since power returned.
    pub is_marked: bool,
    random: ChaCha8Rng,
}

impl<const PAGE_BYTES: u32> CutFlash<PAGE_BYTES> {
    pub fn new(seed: u64) -> Self {
        let bytes = vec![0xff; (PAGES * PAGE_BYTES) as usize];
        Self {
            bytes,
            left: None,
            done: 0,
            is_off: false,
            wrong: 0,
            erased: 0,
            reads: 0,
            is_marked: false,
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    #[cfg(test)]
    pub fn with_bytes(mut self, byte: impl FnMut(usize) -> u8) -> Self {
        self.bytes = (0..self.bytes.len()).map(byte).collect();
        self
    }

    /// Power is there, and is lost in the middle of operation `left` from now on, counted from 0.
    pub fn power(mut self, left: Option<u64>) -> Self {
        (self.left, self.is_off, self.is_marked) = (left, false, false);
        self
    }

    /// Whether power lasts until the end of the next operation; an error if it is gone before it
    /// begins.
    fn lasts(&mut self) -> Result<bool, NorFlashErrorKind> {
        if self.is_off {
            return Err(NorFlashErrorKind::Other);
        }
        self.done += 1;
        self.is_off = self.left == Some(0);
        self.left = self.left.map(|left| left.saturating_sub(1));
        Ok(!self.is_off)
    }

    fn program(&mut self, offset: u32, word: [u8; WORD_BYTES]) -> Result<(), NorFlashErrorKind> {
        let range = offset as usize..offset as usize + WORD_BYTES;
        if !offset.is_multiple_of(WORD_BYTES as u32) || range.end > self.bytes.len() {
            self.wrong += 1;
            return Err(NorFlashErrorKind::OutOfBounds);
        }
        let lasts = self.lasts()?;
        let mask = if lasts {
            u32::MAX
        } else {
            part(&mut self.random)
        };
        let place = &mut self.bytes[range];
        self.wrong += u64::from(place.iter().any(|byte| *byte != 0xff));
        // The bits that were not done are still set.
        for ((kept, byte), mask) in place.iter_mut().zip(word).zip(mask.to_le_bytes()) {
            let before = *kept;
            *kept &= byte | !mask;
            self.is_marked |= *kept != before;
        }
        lasts.then_some(()).ok_or(NorFlashErrorKind::Other)
    }
}

/// Bits of a word that are done when power is lost: none, all, or any.
fn part(random: &mut ChaCha8Rng) -> u32 {
    match random.next_u32() % 4 {
        0 => 0,
        1 => u32::MAX,
        _ => random.next_u32(),
    }
}

impl<const PAGE_BYTES: u32> ErrorType for CutFlash<PAGE_BYTES> {
    type Error = NorFlashErrorKind;
}

impl<const PAGE_BYTES: u32> ReadNorFlash for CutFlash<PAGE_BYTES> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        self.reads += 1;
        let Some(kept) = self
            .bytes
            .get(offset as usize..offset as usize + bytes.len())
        else {
            self.wrong += 1;
            return Err(NorFlashErrorKind::OutOfBounds);
        };
        bytes.copy_from_slice(kept);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const PAGE_BYTES: u32> NorFlash for CutFlash<PAGE_BYTES> {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = PAGE_BYTES as usize;

    /// Word by word: power may be lost in the middle of each.
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let (words, rest) = bytes.as_chunks::<WORD_BYTES>();
        self.wrong += u64::from(!rest.is_empty());
        (offset..)
            .step_by(WORD_BYTES)
            .zip(words)
            .try_for_each(|(offset, word)| self.program(offset, *word))
    }

    /// One page.
    fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let is_one = from.is_multiple_of(PAGE_BYTES) && from.checked_add(PAGE_BYTES) == Some(to);
        if !is_one || to as usize > self.bytes.len() {
            self.wrong += 1;
            return Err(NorFlashErrorKind::OutOfBounds);
        }
        let lasts = self.lasts()?;
        let page = &mut self.bytes[from as usize..to as usize];
        if lasts {
            page.fill(0xff);
            self.erased += 1;
            return Ok(());
        }
        for word in page.as_chunks_mut::<WORD_BYTES>().0 {
            let set = part(&mut self.random).to_le_bytes();
            word.iter_mut()
                .zip(set)
                .for_each(|(byte, set)| *byte |= set);
        }
        Err(NorFlashErrorKind::Other)
    }
}

/// Counts of the settings found after losses of power.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cuts {
    pub injected: u64,
    /// The settings stored before.
    pub old: u64,
    /// Among these, those with the report that the latest settings cannot be read.
    pub reported: u64,
    /// The settings that were being stored.
    pub new: u64,
    /// The defaults, where nothing had been stored before.
    pub defaults: u64,
    /// Anything else: other settings; the old ones without the report although new ones were begun;
    /// a store that refused when power was back; an operation that a flash does not allow. Must be
    /// zero.
    pub wrong: u64,
}

add_fields!(Cuts: injected old reported new defaults wrong);

/// Settings that differ from those of every other number.
pub fn settings(number: u64) -> Settings {
    Settings {
        window_s: 0.1 + (number % 3800) as f32 * 1e-3,
        ..Settings::DEFAULT
    }
}

/// Stores `saves` settings into pages that hold `prefilled` others, and loses power in the middle
/// of every word and erasure of that; then once more in the middle of the next save. `seed` chooses
/// the bits that are done.
pub fn cut_everywhere<const PAGE_BYTES: u32>(prefilled: u64, saves: u64, seed: u64) -> Cuts {
    let mut cuts = Cuts::default();
    let mut store = FlashStore::new(CutFlash::<PAGE_BYTES>::new(seed));
    for number in 0..prefilled {
        cuts.wrong += u64::from(store.save(Some(&settings(number)), true).is_err());
    }
    let mut flash = store.release();
    let mut second = ChaCha8Rng::seed_from_u64(seed);
    for number in prefilled..prefilled + saves {
        let old = number.checked_sub(1).map(settings);
        let mut cut = 0;
        loop {
            let mut store = FlashStore::new(flash.clone().power(Some(cut)));
            let saved = store.save(Some(&settings(number)), true);
            let left = store.release();
            if !left.is_off {
                // The save was complete before the cut.
                cuts.wrong += u64::from(saved.is_err());
                flash = left;
                break;
            }
            let found = look(&left, old, settings(number), &mut cuts);
            let before = if found == Some(settings(number)) {
                Some(settings(number))
            } else {
                old
            };
            // Power is back and lost again while the next are stored.
            let again = second.next_u64() % 26;
            let mut store = FlashStore::new(left.power(Some(again)));
            let saved = store.save(Some(&settings(number + 1)), true);
            let left = store.release();
            if left.is_off {
                look(&left, before, settings(number + 1), &mut cuts);
            } else {
                cuts.wrong += u64::from(saved.is_err());
            }
            // Restored for good.
            let mut store = FlashStore::new(left.power(None));
            let stored = store.save(Some(&settings(number + 2)), true).is_ok();
            let is_there = store.load() == (settings(number + 2), SettingsSource::Stored);
            cuts.wrong += u64::from(!stored || !is_there) + store.release().wrong;
            cut += 1;
        }
    }
    cuts.wrong += flash.wrong;
    cuts
}

/// Reads the settings after a loss of power, twice.
fn look<const PAGE_BYTES: u32>(
    flash: &CutFlash<PAGE_BYTES>,
    old: Option<Settings>,
    new: Settings,
    cuts: &mut Cuts,
) -> Option<Settings> {
    let mut store = FlashStore::new(flash.clone().power(None));
    let found = store.load();
    cuts.injected += 1;
    let fell_back = found.1 == SettingsSource::StoredBefore;
    let stored = found.1 == SettingsSource::Stored || fell_back;
    if store.load() != found {
        cuts.wrong += 1;
    } else if stored && found.0 == new {
        cuts.new += 1;
    } else if stored && Some(found.0) == old && (fell_back || !flash.is_marked) {
        cuts.old += 1;
        cuts.reported += u64::from(fell_back);
    } else if old.is_none() && found.0 == Settings::DEFAULT {
        cuts.defaults += 1;
    } else {
        cuts.wrong += 1;
    }
    stored.then_some(found.0)
}

#[cfg(test)]
mod tests;
