//! Settings that survive a loss of power at any moment, and an update of the firmware.
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
//! The first half looks like a whole record of version 3, which had 128 bytes. So firmware that
//! writes version 3 counts on from a record that it cannot read, and numbers tell which settings
//! were stored last whatever firmware stored them.
//!
//! The crate `sequential-storage` (8.0.2) lost settings: it judges a page by its first and last
//! word, and an interrupted erasure leaves undefined data (RM0090, 3.6). It also takes 9.1 to 11.2
//! kB more flash.

use crate::boot::SettingsSource;
use crate::framing::checksum;
use crate::settings::{Kept, Settings, version_3};
use embedded_storage::nor_flash::NorFlash;

/// Version of a record's layout. New settings do not change it: they have new ids.
const VERSION: u8 = 4;
/// Version that is read too.
const VERSION_BEFORE: u8 = 3;

/// Bytes of a record.
pub const RECORD_BYTES: usize = 2 * HALF_BYTES;
/// Bytes of half a record, or of a whole one of version 3.
const HALF_BYTES: usize = 128;
const SUM_BYTES: usize = 4;
/// Bytes of a record without its two checksums, and of its first half.
const CONTENT_BYTES: usize = RECORD_BYTES - 2 * SUM_BYTES;
const HEAD_BYTES: usize = HALF_BYTES - SUM_BYTES;
/// Bytes of the number and the version, before the settings.
const BEFORE_SETTINGS: usize = 5;

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
/// Place of half a record, or of a whole one of version 3, counted through both pages.
type Half = u32;

/// A record that was found.
struct Found {
    order: Age,
    content: Content,
}

/// Age of a record: its number and its place in the store. A damaged record may have the number of
/// its replacement, which comes after it.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Age {
    number: u32,
    half: Half,
}

/// Greater than the age of every record: an erased slot reads as this number.
const NO_LIMIT: Age = Age {
    number: u32::MAX,
    half: 0,
};

/// What a whole record holds besides its checksums.
struct Content {
    bytes: [u8; CONTENT_BYTES],
    version: u8,
}

impl Content {
    /// Its settings. None if they cannot be understood, or are out of their bounds.
    fn kept(&self) -> Option<Kept> {
        match self.version {
            VERSION => Kept::read(self.bytes.get(BEFORE_SETTINGS..)?),
            VERSION_BEFORE => version_3::read(self.bytes.get(BEFORE_SETTINGS..HEAD_BYTES)?),
            _ => None,
        }
    }

    /// Halves of a record that it comes from.
    const fn halves(&self) -> u32 {
        if self.version == VERSION { 2 } else { 1 }
    }
}

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

    const fn offset(half: Half) -> u32 {
        let halves = 2 * Self::SLOTS;
        half / halves * Self::PAGE_BYTES + half % halves * HALF_BYTES as u32
    }

    /// The next slot: in the same page, or the first one of the other page.
    const fn next(slot: Slot) -> Slot {
        (slot + 1) % Self::ALL
    }

    /// Some bytes. If they cannot be read zeros remain, which are neither whole nor erased.
    fn read<const BYTES: usize>(&mut self, half: Half) -> [u8; BYTES] {
        let mut bytes = [0; BYTES];
        let _ = self.flash.read(Self::offset(half), &mut bytes);
        bytes
    }

    /// The content of the record that begins here, if its checksums match.
    fn whole(&mut self, half: Half) -> Option<Content> {
        let first = self.read::<HALF_BYTES>(half);
        let (head, sum) = first.split_last_chunk::<SUM_BYTES>()?;
        if checksum(head) != u32::from_le_bytes(*sum) {
            return None;
        }
        let version = *head.get(BEFORE_SETTINGS - 1)?;
        let mut bytes = [0; CONTENT_BYTES];
        bytes.get_mut(..HEAD_BYTES)?.copy_from_slice(head);
        if version == VERSION {
            if !half.is_multiple_of(2) {
                return None;
            }
            let second = self.read::<HALF_BYTES>(half + 1);
            let (tail, sum) = second.split_last_chunk::<SUM_BYTES>()?;
            bytes.get_mut(HEAD_BYTES..)?.copy_from_slice(tail);
            if checksum(&bytes) != u32::from_le_bytes(*sum) {
                return None;
            }
        }
        Some(Content { bytes, version })
    }

    /// The latest whole record before `limit`. The search goes from the last slot back, where the
    /// newest record usually is, to compute few checksums.
    fn latest_before(&mut self, limit: Age) -> Option<Found> {
        let mut latest: Option<Found> = None;
        for half in (0..2 * Self::ALL).rev() {
            let number = u32::from_le_bytes(self.read(half));
            let order = Age { number, half };
            let is_later = latest.as_ref().is_none_or(|latest| order > latest.order);
            if order < limit
                && is_later
                && let Some(content) = self.whole(half)
            {
                latest = Some(Found { order, content });
            }
        }
        latest
    }

    fn is_half_erased(&mut self, half: Half) -> bool {
        // By words: a start looks at thousands of halves.
        self.read::<HALF_BYTES>(half)
            .as_chunks::<WORD_BYTES>()
            .0
            .iter()
            .all(|word| u32::from_ne_bytes(*word) == u32::MAX)
    }

    /// Whether a slot is erased.
    fn is_erased(&mut self, slot: Slot) -> bool {
        self.is_half_erased(2 * slot) && self.is_half_erased(2 * slot + 1)
    }

    /// Whether nothing was begun after a record: unreadable data where the next one would be, by
    /// this firmware or one of version 3, were meant to be a record.
    fn is_last(&mut self, found: &Found) -> bool {
        let end = found.order.half + found.content.halves();
        let next_slot = found.order.half / 2 + 1;
        (end..=2 * next_slot).all(|half| {
            let half = half % (2 * Self::ALL);
            self.is_half_erased(half) || self.whole(half).is_some()
        })
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
    fn load(&mut self) -> (Settings, SettingsSource) {
        let mut limit = NO_LIMIT;
        while let Some(found) = self.latest_before(limit) {
            // Another version, or out of bounds: use the record before it.
            let Some(kept) = found.content.kept() else {
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

        let keep = latest.map(|order| order.half / 2);
        let mut after = keep;
        let mut saved = Saved::AtOnce;
        for _ in 0..TRIES {
            let (slot, how) = self.next_slot(after, keep, may_erase)?;
            saved = if how == Saved::Erasing { how } else { saved };
            let half = 2 * slot;
            // A slot that cannot be read back is worn: try the next one.
            if self.flash.write(Self::offset(half), &record).is_ok()
                && self.read::<RECORD_BYTES>(half).iter().eq(&record)
            {
                return Ok(saved);
            }
            after = Some(slot);
        }
        Err(NotStored)
    }
}

/// A record with its number and checksums. None if the settings do not fit.
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
        // Their lengths agree; `copy_from_slice` would panic if not, as far as the compiler knows.
        place
            .iter_mut()
            .zip(part)
            .for_each(|(to, byte)| *to = *byte);
        *sum_place = sum.to_le_bytes();
    }
    Some(record)
}
