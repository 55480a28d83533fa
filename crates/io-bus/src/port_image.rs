//! The controller's own coils and registers: one copy for scripts (`read_port_bit` …, manual 6.1.11 to 6.1.14) and for
//! Modbus clients.
//!
//! Values outlive programs and clients. Shared by reference between threads; a lock is held for a few instructions.

use std::sync::{Mutex, MutexGuard, PoisonError};

use thiserror::Error;

/// How many coils there are: addresses 0 to 127.
pub const COILS: usize = 128;

/// How many holding registers there are: addresses 0 to 255.
pub const REGISTERS: usize = 256;

/// Why a coil or register cannot be read or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PortError {
    /// No such coil.
    #[error("coil address {address} is outside 0 to {}", COILS - 1)]
    CoilAddress {
        /// Asked for.
        address: i64,
    },
    /// No such register.
    #[error("register address {address} is outside 0 to {}", REGISTERS - 1)]
    RegisterAddress {
        /// Asked for.
        address: i64,
    },
    /// No 16-bit number.
    #[error("{value} does not fit a register: allowed are -32768 to 65535")]
    Value {
        /// To be written.
        value: i64,
    },
}

/// Coils and holding registers, all off and zero at first.
#[derive(Debug)]
pub struct PortImage {
    values: Mutex<Values>,
}

/// The values under the lock, so that several of them change at once.
#[derive(Debug)]
pub(crate) struct Values {
    pub(crate) coils: [bool; COILS],
    pub(crate) registers: [u16; REGISTERS],
}

impl Default for PortImage {
    fn default() -> Self {
        Self {
            values: Mutex::new(Values {
                coils: [false; COILS],
                registers: [0; REGISTERS],
            }),
        }
    }
}

impl PortImage {
    /// One coil.
    ///
    /// # Errors
    /// [`PortError::CoilAddress`]
    pub fn read_bit(&self, address: i64) -> Result<bool, PortError> {
        let index = coil(address)?;
        Ok(self.lock().coils[index])
    }

    /// Sets one coil.
    ///
    /// # Errors
    /// [`PortError::CoilAddress`]
    pub fn write_bit(&self, address: i64, level: bool) -> Result<(), PortError> {
        let index = coil(address)?;
        self.lock().coils[index] = level;
        Ok(())
    }

    /// One register, 0 to 65535.
    ///
    /// # Errors
    /// [`PortError::RegisterAddress`]
    pub fn read_register(&self, address: i64) -> Result<u16, PortError> {
        let index = register(address)?;
        Ok(self.lock().registers[index])
    }

    /// Sets one register; a negative number is stored as its two's complement.
    ///
    /// # Errors
    /// [`PortError::RegisterAddress`], [`PortError::Value`]
    pub fn write_register(&self, address: i64, value: i64) -> Result<(), PortError> {
        let index = register(address)?;
        let word = match (u16::try_from(value), i16::try_from(value)) {
            (Ok(word), _) => word,
            (_, Ok(signed)) => signed.cast_unsigned(),
            _ => return Err(PortError::Value { value }),
        };
        self.lock().registers[index] = word;
        Ok(())
    }

    /// Every value is valid at every moment, so a lock that was poisoned by a panic is as good as any.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Values> {
        self.values.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn coil(address: i64) -> Result<usize, PortError> {
    index(address, COILS).ok_or(PortError::CoilAddress { address })
}

fn register(address: i64) -> Result<usize, PortError> {
    index(address, REGISTERS).ok_or(PortError::RegisterAddress { address })
}

fn index(address: i64, count: usize) -> Option<usize> {
    usize::try_from(address).ok().filter(|index| *index < count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let image = PortImage::default();
        assert_eq!(image.read_bit(127), Ok(false));
        image.write_bit(127, true).unwrap();
        assert_eq!(image.read_bit(127), Ok(true));
        for (value, stored) in [(0, 0), (65535, 65535), (-1, 65535), (-32768, 32768)] {
            image.write_register(255, value).unwrap();
            assert_eq!(image.read_register(255), Ok(stored));
        }
    }

    #[test]
    fn what_lies_outside_is_named() {
        let image = PortImage::default();
        let sentences = [
            image.read_bit(128).unwrap_err(),
            image.write_bit(-1, true).unwrap_err(),
            image.read_register(256).unwrap_err(),
            image.write_register(i64::MAX, 0).unwrap_err(),
            image.write_register(0, 65536).unwrap_err(),
            image.write_register(0, -32769).unwrap_err(),
        ]
        .map(|error| error.to_string());
        assert_eq!(
            sentences,
            [
                "coil address 128 is outside 0 to 127",
                "coil address -1 is outside 0 to 127",
                "register address 256 is outside 0 to 255",
                "register address 9223372036854775807 is outside 0 to 255",
                "65536 does not fit a register: allowed are -32768 to 65535",
                "-32769 does not fit a register: allowed are -32768 to 65535",
            ]
        );
        assert_eq!(image.read_register(0), Ok(0));
    }
}
