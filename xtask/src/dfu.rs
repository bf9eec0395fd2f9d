//! DfuSe files, which `dfu-util` and ST's tools write to a chip through its own USB boot loader (ST
//! UM0391; the suffix: USB Device Firmware Upgrade 1.1, appendix B).

use anyhow::{Context, Result, ensure};
use crc::{CRC_32_JAMCRC, Crc};

/// Bytes, and the address of the first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Segment {
    pub address: u32,
    pub bytes: Vec<u8>,
}

/// "DfuSe", the version, the size, the number of targets.
const PREFIX_BYTES: usize = 11;

/// "Target", alternate setting, whether it is named, its name, size and number of elements.
const TARGET_BYTES: usize = 274;

const NAME_BYTES: usize = 255;

/// Device, product, vendor, version of DFU, "UFD", length, checksum.
const SUFFIX_BYTES: usize = 16;

/// ST's boot loader: vendor and product.
const VENDOR: u16 = 0x0483;
const PRODUCT: u16 = 0xdf11;

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_JAMCRC);

/// The suffix's DFU version that says DfuSe.
const DFU_VERSION: u16 = 0x011a;

/// The device's version in the suffix: any.
const ANY_VERSION: u16 = 0xffff;

/// A file that writes `segments`, to the first memory of the device, its flash.
pub fn write(segments: &[Segment]) -> Vec<u8> {
    let word = |number: usize| (number as u32).to_le_bytes();
    let element = |Segment { address, bytes }: &Segment| {
        [&address.to_le_bytes(), &word(bytes.len()), &bytes[..]].concat()
    };
    let elements: Vec<u8> = segments.iter().flat_map(element).collect();
    let mut name = b"flash".to_vec();
    name.resize(NAME_BYTES, 0);
    let prefix = [
        b"DfuSe\x01",
        &word(PREFIX_BYTES + TARGET_BYTES + elements.len())[..],
        &[1],
    ]
    .concat();
    let target = [
        b"Target\0",
        &word(1)[..],
        &name,
        &word(elements.len()),
        &word(segments.len()),
    ]
    .concat();
    let suffix = [ANY_VERSION, PRODUCT, VENDOR, DFU_VERSION]
        .map(u16::to_le_bytes)
        .concat();
    let mut file = [
        prefix,
        target,
        elements,
        suffix,
        b"UFD".to_vec(),
        vec![SUFFIX_BYTES as u8],
    ]
    .concat();
    file.extend(CHECKSUM.checksum(&file).to_le_bytes());
    file
}

/// What a file writes. An error says what does not fit.
pub fn read(file: &[u8]) -> Result<Vec<Segment>> {
    let word = |at: usize| {
        let bytes = file.get(at..at + 4).and_then(|bytes| bytes.first_chunk());
        bytes
            .copied()
            .map(u32::from_le_bytes)
            .with_context(|| format!("it ends before byte {at}"))
    };
    ensure!(
        file.starts_with(b"DfuSe\x01") && file.get(10) == Some(&1),
        "no DfuSe file with one target"
    );
    ensure!(
        word(6)? as usize + SUFFIX_BYTES == file.len(),
        "its size is not what its prefix says"
    );
    let (content, checksum) = (&file[..file.len() - 4], word(file.len() - 4)?);
    ensure!(
        CHECKSUM.checksum(content) == checksum,
        "its checksum is wrong"
    );
    ensure!(
        file[PREFIX_BYTES..].starts_with(b"Target"),
        "no target behind its prefix"
    );
    let mut at = PREFIX_BYTES + TARGET_BYTES;
    let mut segments = Vec::new();
    for _ in 0..word(at - 4)? {
        let (address, length) = (word(at)?, word(at + 4)? as usize);
        let bytes = file
            .get(at + 8..at + 8 + length)
            .context("an element is longer than the file")?
            .to_vec();
        at += 8 + length;
        segments.push(Segment { address, bytes });
    }
    ensure!(
        at + SUFFIX_BYTES == file.len(),
        "there is something between the last element and the suffix"
    );
    Ok(segments)
}

#[cfg(test)]
mod tests {
    use super::{Segment, read, write};

    fn segments() -> Vec<Segment> {
        vec![
            Segment {
                address: 0x0800_0000,
                bytes: vec![1, 2, 3, 4, 5],
            },
            Segment {
                address: 0x0800_0200,
                bytes: vec![0xff; 300],
            },
        ]
    }

    /// The checksum bit by bit, as the appendix's C code has it.
    fn checksum(bytes: &[u8]) -> u32 {
        bytes.iter().fold(u32::MAX, |sum, byte| {
            (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
                if sum & 1 == 1 {
                    sum >> 1 ^ 0xedb8_8320
                } else {
                    sum >> 1
                }
            })
        })
    }

    #[test]
    fn every_byte_is_where_the_documents_have_it() {
        let file = write(&segments());
        let size = 11 + 274 + 8 + 5 + 8 + 300;
        assert_eq!(file.len(), size + 16);
        assert_eq!(
            file[..11],
            [&b"DfuSe\x01"[..], &(size as u32).to_le_bytes(), &[1]].concat()
        );
        assert_eq!(file[11..18], *b"Target\0");
        assert_eq!(file[18..22], [1, 0, 0, 0]);
        assert_eq!(file[22..28], *b"flash\0");
        assert_eq!(
            file[277..285],
            [8 + 5 + 8 + 300 - 256, 1, 0, 0, 2, 0, 0, 0].map(|byte: i32| byte as u8)
        );
        assert_eq!(file[285..298], [0, 0, 0, 8, 5, 0, 0, 0, 1, 2, 3, 4, 5]);
        assert_eq!(file[298..306], [0, 2, 0, 8, 44, 1, 0, 0]);
        let suffix = [
            0xff, 0xff, 0x11, 0xdf, 0x83, 0x04, 0x1a, 0x01, b'U', b'F', b'D', 16,
        ];
        assert_eq!(file[size..size + 12], suffix);
        assert_eq!(
            file[size + 12..],
            checksum(&file[..size + 12]).to_le_bytes()
        );
    }

    #[test]
    fn what_is_read_is_what_was_written_and_damage_is_found() {
        let file = write(&segments());
        assert_eq!(read(&file).expect("it is whole"), segments());
        for at in 0..file.len() {
            let mut damaged = file.clone();
            damaged[at] ^= 0x10;
            assert!(read(&damaged).is_err(), "byte {at}");
            assert!(read(&file[..at]).is_err(), "cut at {at}");
        }
    }
}
