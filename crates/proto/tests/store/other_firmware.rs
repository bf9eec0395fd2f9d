//! Records that other firmware writes: version 3, as up to protocol 10, and one with other ids.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use ridgetone_proto::framing::checksum;
use ridgetone_proto::plan::Plan;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::store::{PAGES, RECORD_BYTES};

/// Bytes of a record of version 3.
pub const OLD_BYTES: usize = 128;

/// Three records that commit a66b81e wrote one after another: settings that are all different from
/// the defaults, the order to forget them, and the defaults with the plan `hand`.
pub const WRITTEN: &[u8; 3 * OLD_BYTES] = include_bytes!("version_3.bin");

/// Settings that [`save`] stores, by a number.
pub fn settings(number: u64) -> Settings {
    Settings {
        window_s: 0.1 + (number % 200) as f32 * 1e-3,
        // The stride that the plan had then.
        stride_s: 0.1,
        ..Settings::DEFAULT.with_plan(Plan::HAND)
    }
}

/// A record of version 3 with these settings.
pub fn record(number: u32, window_s: f32) -> [u8; OLD_BYTES] {
    let mut record = [0; OLD_BYTES];
    record.copy_from_slice(&WRITTEN[2 * OLD_BYTES..]);
    record[..4].copy_from_slice(&number.to_le_bytes());
    // After the version and postcard's `Some`.
    record[6..10].copy_from_slice(&window_s.to_le_bytes());
    let sum = checksum(&record[..OLD_BYTES - 4]);
    record[OLD_BYTES - 4..].copy_from_slice(&sum.to_le_bytes());
    record
}

fn read<F: NorFlash>(flash: &mut F, slot: u32) -> [u8; OLD_BYTES] {
    let mut record = [0; OLD_BYTES];
    flash.read(offset::<F>(slot), &mut record).expect("a slot");
    record
}

fn slots<F: NorFlash>() -> u32 {
    F::ERASE_SIZE as u32 / OLD_BYTES as u32
}

fn offset<F: NorFlash>(slot: u32) -> u32 {
    slot / slots::<F>() * F::ERASE_SIZE as u32 + slot % slots::<F>() * OLD_BYTES as u32
}

fn is_erased(record: &[u8; OLD_BYTES]) -> bool {
    record.iter().all(|byte| *byte == 0xff)
}

/// The greatest number of a record that is whole to version 3, and its slot.
pub fn newest<F: NorFlash>(flash: &mut F) -> Option<(u32, u32)> {
    let is_whole = |record: &[u8; OLD_BYTES]| {
        record[OLD_BYTES - 4..] == checksum(&record[..OLD_BYTES - 4]).to_le_bytes()
    };
    (0..PAGES * slots::<F>())
        .map(|slot| (slot, read(flash, slot)))
        .filter(|(_, record)| is_whole(record))
        .map(|(slot, record)| {
            (
                u32::from_le_bytes([record[0], record[1], record[2], record[3]]),
                slot,
            )
        })
        .max()
}

/// Stores settings as firmware of version 3 does.
pub fn save<F: NorFlash>(flash: &mut F, settings: &Settings) {
    let newest = newest(flash);
    let number = newest.map_or(0, |(number, _)| number + 1);
    let mut slot = newest.map_or(0, |(_, slot)| (slot + 1) % (PAGES * slots::<F>()));
    while !slot.is_multiple_of(slots::<F>()) && !is_erased(&read(flash, slot)) {
        slot = (slot + 1) % (PAGES * slots::<F>());
    }
    let page = slot / slots::<F>();
    let is_free =
        |flash: &mut F| (slot..slot + slots::<F>()).all(|slot| is_erased(&read(flash, slot)));
    if slot.is_multiple_of(slots::<F>()) && !is_free(flash) {
        let page_bytes = F::ERASE_SIZE as u32;
        flash
            .erase(page * page_bytes, (page + 1) * page_bytes)
            .expect("a page");
    }
    let record = record(number, settings.window_s);
    flash
        .write(offset::<F>(slot), &record)
        .expect("a free slot");
}

/// Id and value of each setting of a record of version 4.
pub fn pairs(record: &[u8; RECORD_BYTES]) -> Vec<(u8, Vec<u8>)> {
    let list = [&record[5..124], &record[128..252]].concat();
    let mut rest = list.as_slice();
    let mut pairs = Vec::new();
    while let [id, bytes, more @ ..] = rest
        && *id != 0
    {
        let (value, more) = more.split_at((*bytes).into());
        pairs.push((*id, value.to_vec()));
        rest = more;
    }
    pairs
}

/// A record of version 4 with these pairs.
pub fn with_pairs(number: u32, pairs: &[(u8, Vec<u8>)]) -> [u8; RECORD_BYTES] {
    let mut content = [number.to_le_bytes().to_vec(), vec![4]].concat();
    for (id, value) in pairs {
        content.extend([*id, value.len() as u8]);
        content.extend(value);
    }
    assert!(content.len() <= 248, "they fit a record");
    content.resize(248, 0);
    let mut record = [0; RECORD_BYTES];
    record[..124].copy_from_slice(&content[..124]);
    record[124..128].copy_from_slice(&checksum(&content[..124]).to_le_bytes());
    record[128..252].copy_from_slice(&content[124..]);
    record[252..].copy_from_slice(&checksum(&content).to_le_bytes());
    record
}

/// The first record of a flash.
pub fn first<F: ReadNorFlash>(flash: &mut F) -> [u8; RECORD_BYTES] {
    let mut record = [0; RECORD_BYTES];
    assert!(flash.read(0, &mut record).is_ok());
    record
}
