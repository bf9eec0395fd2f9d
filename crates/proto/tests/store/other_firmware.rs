//! Records of different firmware, with settings that this firmware does not have.

use embedded_storage::nor_flash::ReadNorFlash;
use ridgetone_proto::framing::checksum;
use ridgetone_proto::store::RECORD_BYTES;

/// Lists the id and value of each setting in a record.
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

pub fn first<F: ReadNorFlash>(flash: &mut F) -> [u8; RECORD_BYTES] {
    let mut record = [0; RECORD_BYTES];
    assert!(flash.read(0, &mut record).is_ok());
    record
}
