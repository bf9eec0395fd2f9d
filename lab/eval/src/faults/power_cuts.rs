//! Cuts the power at every word that the store of settings writes.

use super::counts::add_fields;
use hal_mock::CutFlash;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::{FlashStore, Store};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cuts {
    pub injected: u64,
    /// The settings stored before the cut.
    pub old: u64,
    /// Older settings, with a report that the latest cannot be read.
    pub reported: u64,
    /// The settings that were being stored.
    pub new: u64,
    /// The defaults, if nothing had been stored before.
    pub defaults: u64,
    /// Anything else: other settings; old settings without a report although a save had begun; a
    /// store that failed after the power returned; an operation that flash does not allow. Must be
    /// zero.
    pub wrong: u64,
}

add_fields!(Cuts: injected old reported new defaults wrong);

/// Returns settings that are different for each number.
pub fn settings(number: u64) -> Settings {
    Settings {
        window_s: 0.1 + (number % 3800) as f32 * 1e-3,
        ..Settings::DEFAULT
    }
}

/// Stores `saves` settings after `prefilled` others, and cuts the power in the middle of every word
/// and erasure, and once more in the middle of the next save. `seed` determines which bits are
/// written.
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
                // The save was complete before the power cut.
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
            // Power returns, and is lost again during the next save.
            let again = second.next_u64() % 26;
            let mut store = FlashStore::new(left.power(Some(again)));
            let saved = store.save(Some(&settings(number + 1)), true);
            let left = store.release();
            if left.is_off {
                look(&left, before, settings(number + 1), &mut cuts);
            } else {
                cuts.wrong += u64::from(saved.is_err());
            }
            // Power returns and is not cut again.
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

/// Reads the settings twice after a power loss, and counts the outcome.
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
