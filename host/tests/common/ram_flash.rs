//! Flash in RAM for tests. Clones share their content, which therefore outlives a board.

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use ridgetone_proto::store::WORD_BYTES;
use std::sync::{Arc, Mutex, MutexGuard};

/// Two pages of flash.
#[derive(Clone, Debug)]
pub struct RamFlash {
    bytes: Arc<Mutex<Vec<u8>>>,
    /// True if writes fail.
    pub is_worn: bool,
}

impl Default for RamFlash {
    fn default() -> Self {
        Self {
            bytes: Arc::new(Mutex::new(vec![0xff; 2048])),
            is_worn: false,
        }
    }
}

impl RamFlash {
    fn lock(&self) -> MutexGuard<'_, Vec<u8>> {
        self.bytes.lock().expect("no test panics in here")
    }
}

impl ErrorType for RamFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for RamFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        bytes.copy_from_slice(&self.lock()[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.lock().len()
    }
}

impl NorFlash for RamFlash {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = 1024;

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        if self.is_worn {
            return Err(NorFlashErrorKind::Other);
        }
        self.lock()[offset as usize..][..bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        self.lock()[from as usize..to as usize].fill(0xff);
        Ok(())
    }
}
