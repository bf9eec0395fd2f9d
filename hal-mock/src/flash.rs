//! Flash memory of a microcontroller that may lose power in the middle of any operation.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Bytes programmed at once.
const WORD_BYTES: usize = 4;
const PAGES: u32 = 2;

/// Two pages of flash that lose power after a number of programmed words and erased pages.
///
/// Erasing sets bits, programming clears them, as in the manual. An operation that loses power has
/// changed some, all or none of its bits.
#[derive(Clone, Debug)]
pub struct CutFlash<const PAGE_BYTES: u32> {
    /// Content of the flash.
    pub bytes: Vec<u8>,
    /// Operations until power is lost; `None` if power stays on.
    left: Option<u64>,
    /// Operations begun: words programmed and pages erased.
    pub done: u64,
    /// True if power is lost.
    pub is_off: bool,
    /// Number of operations outside the pages, or that program words without erasing them first.
    /// Must be zero.
    pub wrong: u64,
    /// Number of pages erased.
    pub erased: u64,
    /// Number of reads of any length.
    pub reads: u64,
    /// True if a bit was cleared since power-up.
    pub is_marked: bool,
    random: ChaCha8Rng,
}

impl<const PAGE_BYTES: u32> CutFlash<PAGE_BYTES> {
    /// Creates erased pages. The seed chooses the bits that are changed when power is lost.
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

    /// Sets each byte to a function of its offset.
    pub fn with_bytes(mut self, byte: impl FnMut(usize) -> u8) -> Self {
        self.bytes = (0..self.bytes.len()).map(byte).collect();
        self
    }

    /// Switches the power on. Power is lost again half-way through operation `left`, counted from
    /// 0.
    pub fn power(mut self, left: Option<u64>) -> Self {
        (self.left, self.is_off, self.is_marked) = (left, false, false);
        self
    }

    /// Returns true if power lasts until the end of the next operation; an error if power is
    /// already off.
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
        // Bits that power loss left unprogrammed are still set.
        for ((kept, byte), mask) in place.iter_mut().zip(word).zip(mask.to_le_bytes()) {
            let before = *kept;
            *kept &= byte | !mask;
            self.is_marked |= *kept != before;
        }
        lasts.then_some(()).ok_or(NorFlashErrorKind::Other)
    }
}

/// Draws the bits of a word that are programmed when power is lost: none, all, or a random part.
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

    /// Writes word by word, because power may be lost within any word.
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let (words, rest) = bytes.as_chunks::<WORD_BYTES>();
        self.wrong += u64::from(!rest.is_empty());
        (offset..)
            .step_by(WORD_BYTES)
            .zip(words)
            .try_for_each(|(offset, word)| self.program(offset, *word))
    }

    /// Erases exactly one page.
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
