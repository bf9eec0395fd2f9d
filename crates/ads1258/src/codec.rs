//! Bytes on the bus, for both the blocking and the async methods (SBAS297G, commands).

use crate::register::Image;
use crate::{Error, Model, Register};

pub(crate) const RESET: [u8; 1] = [0xC0];

/// Starts one conversion.
pub(crate) const PULSE_CONVERT: [u8; 1] = [0x80];

/// Data read by command, with the MUL bit: the status byte and 24 bits follow.
pub(crate) const READ_DATA: [u8; 5] = [0x30, 0, 0, 0, 0];

/// Command bytes C\[2:0\] MUL A\[3:0\], to combine with the address of the first register.
const READ_REGISTER: u8 = 0x40;
const WRITE_REGISTER: u8 = 0x60;

/// MUL: several registers, with ascending addresses.
const MULTIPLE: u8 = 0x10;

/// A command byte followed by at most ten registers.
pub(crate) struct Block {
    bytes: [u8; 1 + Register::ALL.len()],
    length: usize,
}

impl Block {
    pub(crate) fn read<E>(first: Register, count: usize) -> Result<Self, Error<E>> {
        Self::new(READ_REGISTER, first, count, Register::ALL.len())
    }

    /// The command that writes `values`. ID is read-only.
    pub(crate) fn write<E>(first: Register, values: &[u8]) -> Result<Self, Error<E>> {
        let mut block = Self::new(WRITE_REGISTER, first, values.len(), Register::WRITABLE)?;
        for (place, value) in block.bytes.iter_mut().skip(1).zip(values) {
            *place = *value;
        }
        Ok(block)
    }

    /// Builds a command; `end` is one past the last register that it may access.
    fn new<E>(command: u8, first: Register, count: usize, end: usize) -> Result<Self, Error<E>> {
        if count == 0 || count > end.saturating_sub(first as usize) {
            return Err(Error::RegisterRange { first, count });
        }
        let mut bytes = [0; 1 + Register::ALL.len()];
        bytes[0] = command | first as u8 | if count > 1 { MULTIPLE } else { 0 };
        Ok(Self {
            bytes,
            length: count.saturating_add(1),
        })
    }

    /// Bytes of one transaction.
    pub(crate) fn bytes(&mut self) -> &mut [u8] {
        self.bytes.get_mut(..self.length).unwrap_or_default()
    }

    /// Copies the register bytes. DOUT during the command byte has no meaning.
    pub(crate) fn copy_to(&self, values: &mut [u8]) {
        for (value, byte) in values.iter_mut().zip(self.bytes.iter().skip(1)) {
            *value = *byte;
        }
    }
}

/// Compares the registers read with those that the driver wrote.
pub(crate) fn compare<E>(written: &Image, found: &Image) -> Result<(), Error<E>> {
    let [.., gpio_inputs, _] = *written;
    for ((register, &wrote), &read) in Register::ALL.into_iter().zip(written).zip(found) {
        // An input pin reads the external level.
        let compared = if register == Register::Gpiod {
            !gpio_inputs
        } else {
            0xFF
        };
        if (wrote ^ read) & compared != 0 {
            return Err(Error::Verify {
                register,
                wrote,
                read,
            });
        }
    }
    Ok(())
}

/// Checks bit 4 of ID (ID4), the only bit that the datasheet guarantees.
pub(crate) fn check_id<E>(id: u8, model: Model) -> Result<u8, Error<E>> {
    if (id & 0x10 == 0) == (model == Model::Ads1258) {
        Ok(id)
    } else {
        Err(Error::Id { read: id })
    }
}
