//! Settings that survive a loss of power at any moment.
//!
//! They go behind each other into two pages of flash, each as an item of its own with a checksum, kept by
//! `sequential-storage`; an item that is torn or whose page is worn does not count, and the one before it does. Only when
//! a page is full is the other one erased, after what is in force has been copied.

use crate::boot::SettingsSource;
use crate::settings::Settings;
use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

/// Version of what an item holds: another one is not read. Raise it when [`Settings`] change.
const VERSION: u8 = 1;

/// Room for an item, bytes: [`Settings`] have at most 75.
const ITEM_BYTES: usize = 96;

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
    fn save(&mut self, settings: Option<&Settings>, may_erase: bool) -> Result<(), NotStored>;
}

/// The flash refuses, or a page would have had to be erased at a bad moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotStored;

/// [`PAGES`] pages of flash, one behind the other, for nothing but settings. Offsets count from the first one's start;
/// they are checked before they come here.
pub trait Pages {
    /// Bytes of a page, a multiple of [`WORD_BYTES`].
    const PAGE_BYTES: u32;

    /// Reads some bytes.
    fn read(&mut self, offset: u32, bytes: &mut [u8]);

    /// Programs an erased word.
    ///
    /// # Errors
    /// The flash refuses.
    fn program(&mut self, offset: u32, word: [u8; WORD_BYTES]) -> Result<(), NotStored>;

    /// Erases a page, 0 or 1.
    ///
    /// # Errors
    /// The flash refuses.
    fn erase(&mut self, page: u32) -> Result<(), NotStored>;
}

impl NorFlashError for NotStored {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// Nothing beyond the pages is ever touched.
#[derive(Debug)]
struct Guarded<P> {
    pages: P,
    may_erase: bool,
}

impl<P: Pages> Guarded<P> {
    /// Whether so many bytes from `offset` on are within the pages.
    fn holds(offset: u32, bytes: usize) -> bool {
        u32::try_from(bytes).ok().and_then(|bytes| offset.checked_add(bytes)).is_some_and(|end| end <= Self::END)
    }

    const END: u32 = PAGES * P::PAGE_BYTES;
}

impl<P> ErrorType for Guarded<P> {
    type Error = NotStored;
}

impl<P: Pages> ReadNorFlash for Guarded<P> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NotStored> {
        if !Self::holds(offset, bytes.len()) {
            return Err(NotStored);
        }
        self.pages.read(offset, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        Self::END as usize
    }
}

impl<P: Pages> NorFlash for Guarded<P> {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = P::PAGE_BYTES as usize;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NotStored> {
        let first = from / P::PAGE_BYTES;
        let one = first < PAGES && from == first * P::PAGE_BYTES && to == from + P::PAGE_BYTES;
        if !one || !self.may_erase { Err(NotStored) } else { self.pages.erase(first) }
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NotStored> {
        let (words, rest) = bytes.as_chunks::<WORD_BYTES>();
        if !Self::holds(offset, bytes.len()) || !rest.is_empty() || !offset.is_multiple_of(WORD_BYTES as u32) {
            return Err(NotStored);
        }
        for (number, word) in (0u32..).zip(words) {
            self.pages.program(offset + number * WORD_BYTES as u32, *word)?;
        }
        Ok(())
    }
}

/// A [`Store`] in two pages of flash. It holds the only handle to them.
#[allow(missing_debug_implementations)]
pub struct FlashStore<P: Pages> {
    map: MapStorage<(), Guarded<P>, Cache<Uncached, Uncached, Uncached, ()>>,
}

impl<P: Pages> FlashStore<P> {
    /// A store in pages that may hold anything.
    pub const fn new(pages: P) -> Self {
        let config = const { MapConfig::new(0..Guarded::<P>::END) };
        Self { map: MapStorage::new(Guarded { pages, may_erase: true }, config, Cache::new_uncached()) }
    }

    /// Gives the pages back.
    pub fn release(self) -> P {
        self.map.destroy().0.pages
    }
}

impl<P: Pages> Store for FlashStore<P> {
    fn load(&mut self) -> (Settings, SettingsSource) {
        let mut room = [0; ITEM_BYTES];
        self.map.flash().may_erase = true;
        match now(self.map.fetch_item::<&[u8]>(&mut room, &())) {
            Some(Ok(None)) => (Settings::DEFAULT, SettingsSource::Default),
            Some(Ok(Some(item))) => match read(item) {
                Some(Some(settings)) => (settings, SettingsSource::Stored),
                Some(None) => (Settings::DEFAULT, SettingsSource::Default),
                None => (Settings::DEFAULT, SettingsSource::Damaged),
            },
            _ => (Settings::DEFAULT, SettingsSource::Damaged),
        }
    }

    #[inline(never)]
    fn save(&mut self, settings: Option<&Settings>, may_erase: bool) -> Result<(), NotStored> {
        let (mut item, mut room) = ([0; ITEM_BYTES], [0; ITEM_BYTES]);
        let used = postcard::to_slice(&(VERSION, settings), &mut item).map_err(|_| NotStored)?.len();
        let item = item.get(..used).ok_or(NotStored)?;
        self.map.flash().may_erase = may_erase;
        now(self.map.store_item(&mut room, &(), &item)).and_then(Result::ok).ok_or(NotStored)
    }
}

/// What an item holds: settings, or that the defaults are wanted. None if it is unreadable or out of bounds.
fn read(item: &[u8]) -> Option<Option<Settings>> {
    let (version, content) = item.split_first()?;
    let (settings, rest) = postcard::take_from_bytes::<Option<Settings>>(content).ok()?;
    let good = *version == VERSION && rest.is_empty() && settings.is_none_or(|settings| settings.validate().is_ok());
    good.then_some(settings)
}

/// What a future gives that never waits; none if it does.
fn now<F: Future>(future: F) -> Option<F::Output> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => Some(output),
        Poll::Pending => None,
    }
}
