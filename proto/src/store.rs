//! Settings that survive a loss of power at any moment.
//!
//! They go behind each other into two pages of flash, each in a record of its own with a number and, written last, a
//! checksum. The record with the highest number counts whose checksum is right; one that was torn, or that a worn page has
//! spoilt, does not, so the one before it does. When a page is full the other one is erased and gets the next record: a
//! page that holds what is in force is never erased.
//!
//! To erase a page stops the STM32F405 for 1 to 2 s, for its code is in the same bank of flash (RM0090, 3.5.1; DS8626): every
//! conversion of that time is lost. So it is done only between touches, the loss is counted and told like any other, and
//! the answer says why ([`Saved::Erasing`], [`DoneErased`](crate::command::Outcome::DoneErased)). The watchdog waits for
//! longer (8 s).
//!
//! Why not the crate `sequential-storage` (8.0.2), which was tried in this place: what an interrupted erasure leaves is
//! not guaranteed (RM0090, 3.6), and it judges a page by its first and last word. If the last word alone is erased by
//! then, its queue takes the settings of a page ago for those in force, and refuses to store from then on; its map mends
//! an interrupted erasure by erasing the page that holds the whole copy first. With it an image takes 9.1 to 11.2 kB of
//! flash more.

use crate::boot::SettingsSource;
use crate::framing::checksum;
use crate::settings::Settings;
use embedded_storage::nor_flash::NorFlash;

/// Version of what a record holds: another one is not read. Raise it when [`Settings`] change.
const VERSION: u8 = 1;

/// Bytes of a record: its number, the version, the settings (72 at most), and the checksum of all that.
pub const RECORD_BYTES: usize = 96;

/// Where its settings are.
const CONTENT: core::ops::Range<usize> = 5..RECORD_BYTES - 4;

/// Times that storing is tried in another place if it cannot be read back.
const TRIES: usize = 4;

/// Bytes that are programmed at once.
pub const WORD_BYTES: usize = 4;

/// Pages there are.
pub const PAGES: u32 = 2;

/// Where settings are kept.
pub trait Store {
    /// What is in force after a start, valid in any case, and where it comes from.
    fn load(&mut self) -> (Settings, SettingsSource);

    /// Stores settings, or with none that the defaults are wanted. If `may_erase` is not given and a page is full,
    /// nothing is stored.
    ///
    /// # Errors
    /// They could not be stored; what was stored before still is.
    fn save(&mut self, settings: Option<&Settings>, may_erase: bool) -> Result<Saved, NotStored>;
}

/// How settings were stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// Into a place that was free.
    AtOnce,
    /// A page was erased before: the processor may have stood still meanwhile.
    Erasing,
}

/// The flash refuses, or a page would have had to be erased at a bad moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotStored;

/// A place for a record: its number in both pages. Only such places are ever touched.
type Slot = u32;

/// A [`Store`] in [`PAGES`] pages of flash, one behind the other, for nothing but settings. It holds the only handle to
/// them; offsets count from the first one's start. A page is what is erased at once ([`NorFlash::ERASE_SIZE`]), and words
/// are programmed one by one ([`WORD_BYTES`]).
#[derive(Debug)]
pub struct FlashStore<F: NorFlash> {
    flash: F,
}

impl<F: NorFlash> FlashStore<F> {
    /// Bytes of a page.
    const PAGE_BYTES: u32 = F::ERASE_SIZE as u32;

    /// Records that a page holds.
    const SLOTS: Slot = Self::PAGE_BYTES / RECORD_BYTES as u32;

    /// A store in pages that may hold anything.
    pub const fn new(flash: F) -> Self {
        const { assert!(Self::SLOTS > 0 && F::WRITE_SIZE == WORD_BYTES && WORD_BYTES.is_multiple_of(F::READ_SIZE)) };
        Self { flash }
    }

    /// Gives the pages back.
    pub fn release(self) -> F {
        self.flash
    }

    /// That both pages hold.
    const ALL: Slot = PAGES * Self::SLOTS;

    const fn offset(slot: Slot) -> u32 {
        slot / Self::SLOTS * Self::PAGE_BYTES + slot % Self::SLOTS * RECORD_BYTES as u32
    }

    /// The place behind this one: in the same page, or the first of the other one.
    const fn behind(slot: Slot) -> Slot {
        (slot + 1) % Self::ALL
    }

    fn record(&mut self, slot: Slot) -> [u8; RECORD_BYTES] {
        // All zeros, if it cannot be read, are neither whole nor erased.
        let mut record = [0; RECORD_BYTES];
        let _ = self.flash.read(Self::offset(slot), &mut record);
        record
    }

    /// The record with the highest number whose checksum is right, and is below `limit`: its number and place, and its
    /// bytes. One that was spoilt may have the number of the one that replaced it, so places count too. It looks at each
    /// place once, however many are spoilt, and from behind: there the newest is in its page.
    fn newest_below(&mut self, limit: (u32, Slot)) -> Option<((u32, Slot), [u8; RECORD_BYTES])> {
        let mut newest: Option<((u32, Slot), [u8; RECORD_BYTES])> = None;
        for slot in (0..Self::ALL).rev() {
            let mut number = [0; 4];
            let _ = self.flash.read(Self::offset(slot), &mut number);
            let at = (u32::from_le_bytes(number), slot);
            if at < limit && newest.is_none_or(|(most, _)| at > most) {
                let record = self.record(slot);
                if is_whole(&record) {
                    newest = Some((at, record));
                }
            }
        }
        newest
    }

    /// Whether a record's place is as it was erased.
    fn is_erased(&mut self, slot: Slot) -> bool {
        self.record(slot).iter().all(|byte| *byte == ERASED)
    }

    /// The place behind a record, or behind none: in the same page, or else in the other one, which is erased.
    /// Not that which must be kept.
    fn next_slot(
        &mut self,
        behind: Option<Slot>,
        keep: Option<Slot>,
        may_erase: bool,
    ) -> Result<(Slot, Saved), NotStored> {
        let mut slot = behind.map_or(0, Self::behind);
        while !slot.is_multiple_of(Self::SLOTS) {
            if self.is_erased(slot) {
                return Ok((slot, Saved::AtOnce));
            }
            slot = Self::behind(slot);
        }
        // New, or erased before a loss of power: there is nothing to be gained by erasing it again.
        if (slot..slot + Self::SLOTS).all(|slot| self.is_erased(slot)) {
            return Ok((slot, Saved::AtOnce));
        }
        let page = slot / Self::SLOTS;
        if !may_erase || keep.is_some_and(|kept| kept / Self::SLOTS == page) {
            return Err(NotStored);
        }
        self.flash.erase(page * Self::PAGE_BYTES, (page + 1) * Self::PAGE_BYTES).map_err(|_| NotStored)?;
        Ok((slot, Saved::Erasing))
    }

    fn write(&mut self, slot: Slot, record: &[u8; RECORD_BYTES]) -> Result<(), NotStored> {
        self.flash.write(Self::offset(slot), record).map_err(|_| NotStored)
    }
}

impl<F: NorFlash> Store for FlashStore<F> {
    #[inline(never)]
    fn load(&mut self) -> (Settings, SettingsSource) {
        let mut limit = NO_LIMIT;
        while let Some((at, record)) = self.newest_below(limit) {
            // Of another version, or out of bounds: the one before it.
            let Some(settings) = content(&record) else {
                limit = at;
                continue;
            };
            // What is unreadable where the next record would be was to be one.
            let behind = Self::behind(at.1);
            let is_last = limit == NO_LIMIT && (self.is_erased(behind) || is_whole(&self.record(behind)));
            return match (settings, is_last) {
                (Some(settings), true) => (settings, SettingsSource::Stored),
                (Some(settings), false) => (settings, SettingsSource::StoredBefore),
                (None, true) => (Settings::DEFAULT, SettingsSource::Default),
                (None, false) => (Settings::DEFAULT, SettingsSource::Damaged),
            };
        }
        let blank = (0..Self::ALL).all(|slot| self.is_erased(slot));
        (Settings::DEFAULT, if blank { SettingsSource::Default } else { SettingsSource::Damaged })
    }

    #[inline(never)]
    fn save(&mut self, settings: Option<&Settings>, may_erase: bool) -> Result<Saved, NotStored> {
        let newest = self.newest_below(NO_LIMIT);
        let number = newest.as_ref().map_or(0, |((number, _), _)| number.wrapping_add(1));
        let mut record = [0; RECORD_BYTES];
        let (content, sum) = record.split_last_chunk_mut::<4>().ok_or(NotStored)?;
        content.get_mut(..4).ok_or(NotStored)?.copy_from_slice(&number.to_le_bytes());
        *content.get_mut(4).ok_or(NotStored)? = VERSION;
        postcard::to_slice(&settings, content.get_mut(CONTENT).ok_or(NotStored)?).map_err(|_| NotStored)?;
        *sum = checksum(content).to_le_bytes();

        let mut behind = newest.map(|((_, slot), _)| slot);
        let keep = behind;
        let mut saved = Saved::AtOnce;
        for _ in 0..TRIES {
            let (slot, how) = self.next_slot(behind, keep, may_erase)?;
            saved = if how == Saved::Erasing { how } else { saved };
            // Worn where it cannot be read back.
            if self.write(slot, &record).is_ok() && self.record(slot).iter().eq(&record) {
                return Ok(saved);
            }
            behind = Some(slot);
        }
        Err(NotStored)
    }
}

/// Below the number of what is erased.
const NO_LIMIT: (u32, Slot) = (u32::MAX, 0);

/// What every byte of an erased page reads.
const ERASED: u8 = 0xff;

/// Whether a record's checksum is right.
fn is_whole(record: &[u8; RECORD_BYTES]) -> bool {
    record.split_last_chunk::<4>().is_some_and(|(content, sum)| checksum(content) == u32::from_le_bytes(*sum))
}

/// What a record holds: settings, or that the defaults are wanted. None if it is unreadable or out of bounds.
fn content(record: &[u8; RECORD_BYTES]) -> Option<Option<Settings>> {
    let (settings, _) = postcard::take_from_bytes::<Option<Settings>>(record.get(CONTENT)?).ok()?;
    let good = record.get(4) == Some(&VERSION) && settings.is_none_or(|settings| settings.validate().is_ok());
    good.then_some(settings)
}
