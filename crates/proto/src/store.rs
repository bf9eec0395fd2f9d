//! Settings that survive a loss of power at any moment, and an update of the firmware.
//!
//! Records follow each other in two pages of flash. Each has a number and, written last, a
//! checksum. The record with the highest number and a matching checksum is valid. If a write was
//! interrupted or a page is worn, that is the record before. When a page is full, the other page is
//! erased for the next record, never the page with the valid record.
//!
//! Erasing stops the STM32F405 for 1 to 2 s, because its code is in the same bank of flash (RM0090,
//! 3.5.1; DS8626). All conversions during that time are lost. So a page is only erased between
//! touches, the loss is counted and reported, and the reply gives the reason ([`Saved::Erasing`],
//! [`DoneErased`](crate::command::Outcome::DoneErased)). The watchdog's 8 s are longer.
//!
//! # Layout
//!
//! | bytes | what |
//! |---|---|
//! | 0 to 3 | number, little-endian |
//! | 4 | version, 4 |
//! | 5 to 123 | settings as pairs of id and value ([`crate::settings`]) |
//! | 124 to 127 | checksum of the bytes before it |
//! | 128 to 251 | more pairs |
//! | 252 to 255 | checksum of everything but the checksum in the middle |
//!
//! The crate `sequential-storage` (8.0.2) lost settings: it judges a page by its first and last
//! word, but an interrupted erase leaves undefined data (RM0090, 3.6). It also takes 9.1 to 11.2 kB
//! more flash.

use crate::boot::SettingsSource;
use crate::framing::checksum;
use crate::settings::{Kept, Settings};
use embedded_storage::nor_flash::NorFlash;

/// Version of a record's layout. New settings do not change it, because they have new ids.
const VERSION: u8 = 4;

/// Bytes of a record.
pub const RECORD_BYTES: usize = 2 * HALF_BYTES;
/// Bytes of half a record, including its checksum.
const HALF_BYTES: usize = 128;
const SUM_BYTES: usize = 4;
/// Bytes of a record without its two checksums, and of its first half without its checksum.
const CONTENT_BYTES: usize = RECORD_BYTES - 2 * SUM_BYTES;
const HEAD_BYTES: usize = HALF_BYTES - SUM_BYTES;
/// Bytes before the settings: number and version.
const BEFORE_SETTINGS: usize = 5;

/// Maximum number of slots tried if a record cannot be read back.
const TRIES: usize = 4;

/// Bytes that the flash programs at once.
pub const WORD_BYTES: usize = 4;

/// Number of pages.
pub const PAGES: u32 = 2;

/// A store of settings.
pub trait Store {
    /// Loads the settings for a start, which are always valid, and their source.
    fn load(&mut self) -> (Settings, SettingsSource);

    /// Stores settings; `None` stands for the defaults. Without `may_erase`, a full page is an
    /// error and nothing changes.
    fn save(&mut self, settings: Option<&Settings>, may_erase: bool) -> Result<Saved, NotStored>;
}

/// Outcome of storing settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// Into a free slot.
    AtOnce,
    /// After erasing a page, which may have stopped the processor.
    Erasing,
}

/// Error: the flash failed, or a page would have to be erased without permission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotStored;

/// Position of a record, counted through both pages.
type Slot = u32;

/// A record found in the flash.
struct Found {
    order: Age,
    content: [u8; CONTENT_BYTES],
}

/// Age of a record: its number and its slot. A damaged record may have the same number as its
/// replacement, which is in a later slot.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Age {
    number: u32,
    slot: Slot,
}

/// Greater than the age of every record: an erased slot reads as this number.
const NO_LIMIT: Age = Age {
    number: u32::MAX,
    slot: 0,
};

impl Found {
    /// Settings of the record. `None` if they cannot be read, or are out of bounds.
    fn kept(&self) -> Option<Kept> {
        match self.content.get(BEFORE_SETTINGS - 1) {
            Some(&VERSION) => Kept::read(self.content.get(BEFORE_SETTINGS..)?),
            _ => None,
        }
    }
}

/// A [`Store`] in [`PAGES`] consecutive pages of flash, for settings only. Offsets count from the
/// start of the first page. A page is the unit of erasing ([`NorFlash::ERASE_SIZE`]), a word of
/// [`WORD_BYTES`] the unit of programming.
#[derive(Debug)]
pub struct FlashStore<F: NorFlash> {
    flash: F,
}

impl<F: NorFlash> FlashStore<F> {
    const PAGE_BYTES: u32 = F::ERASE_SIZE as u32;

    const SLOTS: Slot = Self::PAGE_BYTES / RECORD_BYTES as u32;

    /// Creates a store in pages with any content.
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

    const ALL: Slot = PAGES * Self::SLOTS;

    const fn offset(slot: Slot) -> u32 {
        slot / Self::SLOTS * Self::PAGE_BYTES + slot % Self::SLOTS * RECORD_BYTES as u32
    }

    /// Returns the next slot: in the same page, or the first slot of the other page.
    const fn next(slot: Slot) -> Slot {
        (slot + 1) % Self::ALL
    }

    /// Reads the first bytes of a slot. If the read fails, returns zeros, which are neither a valid
    /// record nor erased flash.
    fn read<const BYTES: usize>(&mut self, slot: Slot) -> [u8; BYTES] {
        let mut bytes = [0; BYTES];
        let _ = self.flash.read(Self::offset(slot), &mut bytes);
        bytes
    }

    /// Returns the content of the record in a slot, if its checksums match.
    fn whole(&mut self, slot: Slot) -> Option<[u8; CONTENT_BYTES]> {
        let record = self.read::<RECORD_BYTES>(slot);
        let (first, second) = record.split_first_chunk::<HALF_BYTES>()?;
        let (head, head_sum) = first.split_last_chunk::<SUM_BYTES>()?;
        let (tail, sum) = second.split_last_chunk::<SUM_BYTES>()?;
        if checksum(head) != u32::from_le_bytes(*head_sum) {
            return None;
        }
        let mut content = [0; CONTENT_BYTES];
        content.get_mut(..HEAD_BYTES)?.copy_from_slice(head);
        content.get_mut(HEAD_BYTES..)?.copy_from_slice(tail);
        (checksum(&content) == u32::from_le_bytes(*sum)).then_some(content)
    }

    /// Finds the latest valid record before `limit`. Searches backwards from the last slot: the
    /// newest record is usually there, so few checksums are computed.
    fn latest_before(&mut self, limit: Age) -> Option<Found> {
        let mut latest: Option<Found> = None;
        for slot in (0..Self::ALL).rev() {
            let number = u32::from_le_bytes(self.read(slot));
            let order = Age { number, slot };
            let is_later = latest.as_ref().is_none_or(|latest| order > latest.order);
            if order < limit
                && is_later
                && let Some(content) = self.whole(slot)
            {
                latest = Some(Found { order, content });
            }
        }
        latest
    }

    fn is_erased(&mut self, slot: Slot) -> bool {
        // Compare words for speed, because a start checks thousands of slots.
        self.read::<RECORD_BYTES>(slot)
            .as_chunks::<WORD_BYTES>()
            .0
            .iter()
            .all(|word| u32::from_ne_bytes(*word) == u32::MAX)
    }

    /// True if no newer record was begun. Unreadable data in the next slot count as a begun record.
    fn is_last(&mut self, found: &Found) -> bool {
        let next = Self::next(found.order.slot);
        self.is_erased(next) || self.whole(next).is_some()
    }

    /// Finds a free slot for the next record: in the same page as `after`, or the first one of the
    /// other page, which is erased if necessary.
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
        // The page is new, or was already erased before a loss of power.
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
    fn load(&mut self) -> (Settings, SettingsSource) {
        let mut limit = NO_LIMIT;
        while let Some(found) = self.latest_before(limit) {
            // A different version, or out of bounds: use the record before it.
            let Some(kept) = found.kept() else {
                limit = found.order;
                continue;
            };
            let is_last = limit == NO_LIMIT && self.is_last(&found);
            return match (kept, is_last) {
                (Kept::Settings(settings), true) => (settings, SettingsSource::Stored),
                (Kept::Migrated(settings), true) => (settings, SettingsSource::Migrated),
                (Kept::Settings(settings) | Kept::Migrated(settings), false) => {
                    (settings, SettingsSource::StoredBefore)
                }
                (Kept::Defaults, true) => (Settings::DEFAULT, SettingsSource::Default),
                (Kept::Defaults, false) => (Settings::DEFAULT, SettingsSource::Damaged),
            };
        }
        let is_blank = (0..Self::ALL).all(|slot| self.is_erased(slot));
        let source = if is_blank {
            SettingsSource::Default
        } else {
            SettingsSource::Damaged
        };
        (Settings::DEFAULT, source)
    }

    fn save(&mut self, settings: Option<&Settings>, may_erase: bool) -> Result<Saved, NotStored> {
        let latest = self.latest_before(NO_LIMIT).map(|found| found.order);
        let number = latest.map_or(0, |order| order.number.wrapping_add(1));
        let record = record(number, settings).ok_or(NotStored)?;

        let keep = latest.map(|order| order.slot);
        let mut after = keep;
        let mut saved = Saved::AtOnce;
        for _ in 0..TRIES {
            let (slot, how) = self.next_slot(after, keep, may_erase)?;
            saved = if how == Saved::Erasing { how } else { saved };
            // A slot that cannot be read back is worn: try the next one.
            if self.flash.write(Self::offset(slot), &record).is_ok()
                && self.read::<RECORD_BYTES>(slot).iter().eq(&record)
            {
                return Ok(saved);
            }
            after = Some(slot);
        }
        Err(NotStored)
    }
}

/// Builds a record with its number and checksums. `None` if the settings do not fit.
fn record(number: u32, settings: Option<&Settings>) -> Option<[u8; RECORD_BYTES]> {
    let mut content = [0; CONTENT_BYTES];
    content
        .first_chunk_mut::<4>()?
        .copy_from_slice(&number.to_le_bytes());
    *content.get_mut(BEFORE_SETTINGS - 1)? = VERSION;
    Kept::write(settings, content.get_mut(BEFORE_SETTINGS..)?)?;

    let mut record = [0; RECORD_BYTES];
    let (head, tail) = content.split_at_checked(HEAD_BYTES)?;
    let (first, second) = record.split_at_mut_checked(HALF_BYTES)?;
    for (half, part, sum) in [
        (first, head, checksum(head)),
        (second, tail, checksum(&content)),
    ] {
        let (place, sum_place) = half.split_last_chunk_mut::<SUM_BYTES>()?;
        // The lengths agree, but the compiler cannot rule out the panic of `copy_from_slice`.
        place
            .iter_mut()
            .zip(part)
            .for_each(|(to, byte)| *to = *byte);
        *sum_place = sum.to_le_bytes();
    }
    Some(record)
}
