//! Settings that survive a loss of power at any moment.
//!
//! Records follow each other in two pages of flash. Each has a number and, written last, a
//! checksum. The record with the highest number and a matching checksum is valid; if a write was
//! interrupted or a page is worn, the one before. When a page is full the other one is erased for
//! the next record, never the page with the valid record.
//!
//! An erasure stops the STM32F405 for 1 to 2 s, because its code is in the same bank of flash
//! (RM0090, 3.5.1; DS8626). All conversions of that time are lost. So it happens only between
//! touches, the loss is counted and reported, and the reply gives the reason ([`Saved::Erasing`],
//! [`DoneErased`](crate::command::Outcome::DoneErased)). The watchdog's 8 s are longer.
//!
//! The crate `sequential-storage` (8.0.2) lost settings: it judges a page by its first and last
//! word, and an interrupted erasure leaves undefined data (RM0090, 3.6). It also takes 9.1 to 11.2
//! kB more flash.

use crate::boot::SettingsSource;
use crate::framing::checksum;
use crate::settings::Settings;
use embedded_storage::nor_flash::NorFlash;

/// Version of a record's content; other versions are not read. Raise it when [`Settings`] change.
const VERSION: u8 = 4;

/// Bytes of a record: number, version, settings (118 at most), and the checksum of all three.
pub const RECORD_BYTES: usize = 128;

/// Place of the settings in a record.
const CONTENT: core::ops::Range<usize> = 5..RECORD_BYTES - 4;

/// Most slots that are tried if a record cannot be read back.
const TRIES: usize = 4;

/// Bytes that the flash programs at once.
pub const WORD_BYTES: usize = 4;

/// Number of pages.
pub const PAGES: u32 = 2;

/// A place that keeps settings.
pub trait Store {
    /// The settings for a start, always valid, and where they come from.
    fn load(&mut self) -> (Settings, SettingsSource);

    /// Stores settings; none stands for the defaults. Without `may_erase` a full page is an error,
    /// which changes nothing.
    fn save(&mut self, settings: Option<&Settings>, may_erase: bool) -> Result<Saved, NotStored>;
}

/// How settings were stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// Into a free slot.
    AtOnce,
    /// After the erasure of a page, which may have stopped the processor.
    Erasing,
}

/// The flash refuses, or a page would have to be erased without permission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotStored;

/// Place of a record, counted through both pages.
type Slot = u32;

/// A [`Store`] in [`PAGES`] consecutive pages of flash, for settings only. Offsets count from the
/// start of the first page. A page is the unit of erasure ([`NorFlash::ERASE_SIZE`]), a word of
/// [`WORD_BYTES`] the unit of programming.
#[derive(Debug)]
pub struct FlashStore<F: NorFlash> {
    flash: F,
}

impl<F: NorFlash> FlashStore<F> {
    /// Bytes of a page.
    const PAGE_BYTES: u32 = F::ERASE_SIZE as u32;

    /// Slots of a page.
    const SLOTS: Slot = Self::PAGE_BYTES / RECORD_BYTES as u32;

    /// A store in pages with any content.
    pub const fn new(flash: F) -> Self {
        const {
            assert!(
                Self::SLOTS > 0
                    && F::WRITE_SIZE == WORD_BYTES
                    && WORD_BYTES.is_multiple_of(F::READ_SIZE)
            )
        };
        Self { flash }
    }

    /// Releases the flash.
    pub fn release(self) -> F {
        self.flash
    }

    /// Slots of both pages.
    const ALL: Slot = PAGES * Self::SLOTS;

    const fn offset(slot: Slot) -> u32 {
        slot / Self::SLOTS * Self::PAGE_BYTES + slot % Self::SLOTS * RECORD_BYTES as u32
    }

    /// The next slot: in the same page, or the first one of the other page.
    const fn next(slot: Slot) -> Slot {
        (slot + 1) % Self::ALL
    }

    fn record(&mut self, slot: Slot) -> [u8; RECORD_BYTES] {
        // If it cannot be read, zeros remain, which are neither whole nor erased.
        let mut record = [0; RECORD_BYTES];
        let _ = self.flash.read(Self::offset(slot), &mut record);
        record
    }

    /// The record with the highest number below `limit` and a matching checksum: its number, slot
    /// and bytes. A damaged record may have the number of its replacement, so equal numbers are
    /// ordered by slot. The search reads from the last slot back, where the newest record usually
    /// is, to compute few checksums.
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

    /// Whether a slot is erased.
    fn is_erased(&mut self, slot: Slot) -> bool {
        // By words: a start looks at thousands of slots.
        self.record(slot)
            .as_chunks::<WORD_BYTES>()
            .0
            .iter()
            .all(|word| u32::from_ne_bytes(*word) == u32::MAX)
    }

    /// The next free slot after a record, or the first one: in the same page, or in the other one,
    /// which is erased for it.
    fn next_slot(
        &mut self,
        after: Option<Slot>,
        keep: Option<Slot>,
        may_erase: bool,
    ) -> Result<(Slot, Saved), NotStored> {
        let mut slot = after.map_or(0, Self::next);
        while !slot.is_multiple_of(Self::SLOTS) {
            if self.is_erased(slot) {
                return Ok((slot, Saved::AtOnce));
            }
            slot = Self::next(slot);
        }
        // The page is new, or was erased before a loss of power.
        if (slot..slot + Self::SLOTS).all(|slot| self.is_erased(slot)) {
            return Ok((slot, Saved::AtOnce));
        }
        let page = slot / Self::SLOTS;
        if !may_erase || keep.is_some_and(|kept| kept / Self::SLOTS == page) {
            return Err(NotStored);
        }
        self.flash
            .erase(page * Self::PAGE_BYTES, (page + 1) * Self::PAGE_BYTES)
            .map_err(|_| NotStored)?;
        Ok((slot, Saved::Erasing))
    }
}

impl<F: NorFlash> Store for FlashStore<F> {
    #[inline(never)]
    fn load(&mut self) -> (Settings, SettingsSource) {
        let mut limit = NO_LIMIT;
        while let Some((at, record)) = self.newest_below(limit) {
            // Another version, or out of bounds: use the record before it.
            let Some(settings) = content(&record) else {
                limit = at;
                continue;
            };
            // Unreadable data in the next slot were meant to be a record.
            let next = Self::next(at.1);
            let is_last =
                limit == NO_LIMIT && (self.is_erased(next) || is_whole(&self.record(next)));
            return match (settings, is_last) {
                (Some(settings), true) => (settings, SettingsSource::Stored),
                (Some(settings), false) => (settings, SettingsSource::StoredBefore),
                (None, true) => (Settings::DEFAULT, SettingsSource::Default),
                (None, false) => (Settings::DEFAULT, SettingsSource::Damaged),
            };
        }
        let blank = (0..Self::ALL).all(|slot| self.is_erased(slot));
        (
            Settings::DEFAULT,
            if blank {
                SettingsSource::Default
            } else {
                SettingsSource::Damaged
            },
        )
    }

    #[inline(never)]
    fn save(&mut self, settings: Option<&Settings>, may_erase: bool) -> Result<Saved, NotStored> {
        let newest = self.newest_below(NO_LIMIT).map(|(at, _)| at);
        let number = newest.map_or(0, |(number, _)| number.wrapping_add(1));
        let mut record = [0; RECORD_BYTES];
        let (content, sum) = record.split_last_chunk_mut::<4>().ok_or(NotStored)?;
        content
            .get_mut(..4)
            .ok_or(NotStored)?
            .copy_from_slice(&number.to_le_bytes());
        *content.get_mut(4).ok_or(NotStored)? = VERSION;
        postcard::to_slice(&settings, content.get_mut(CONTENT).ok_or(NotStored)?)
            .map_err(|_| NotStored)?;
        *sum = checksum(content).to_le_bytes();

        let keep = newest.map(|(_, slot)| slot);
        let mut after = keep;
        let mut saved = Saved::AtOnce;
        for _ in 0..TRIES {
            let (slot, how) = self.next_slot(after, keep, may_erase)?;
            saved = if how == Saved::Erasing { how } else { saved };
            // A slot that cannot be read back is worn: try the next one.
            if self.flash.write(Self::offset(slot), &record).is_ok()
                && self.record(slot).iter().eq(&record)
            {
                return Ok(saved);
            }
            after = Some(slot);
        }
        Err(NotStored)
    }
}

/// The number that an erased slot reads as: all records are below it.
const NO_LIMIT: (u32, Slot) = (u32::MAX, 0);

/// Whether a record's checksum matches.
fn is_whole(record: &[u8; RECORD_BYTES]) -> bool {
    record
        .split_last_chunk::<4>()
        .is_some_and(|(content, sum)| checksum(content) == u32::from_le_bytes(*sum))
}

/// Content of a record: settings, or none for the defaults. None if it is unreadable or out of
/// bounds.
fn content(record: &[u8; RECORD_BYTES]) -> Option<Option<Settings>> {
    let (settings, _) = postcard::take_from_bytes::<Option<Settings>>(record.get(CONTENT)?).ok()?;
    let good = record.get(4) == Some(&VERSION)
        && settings.is_none_or(|settings| settings.validate().is_ok());
    good.then_some(settings)
}
