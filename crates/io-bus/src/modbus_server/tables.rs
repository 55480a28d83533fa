//! What a Modbus server serves: bits and words behind addresses. The protocol knows no more of it; [`super::map`] is
//! the controller's own, [`Store`] a device that only keeps what is written.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use parking_lot::{Mutex, MutexGuard};

/// A reason why a request is refused (MODBUS Application Protocol Specification V1.1b3, 7). The numbers are those on
/// the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
#[allow(clippy::enum_variant_names, reason = "the names of the specification")]
pub enum ModbusException {
    /// There is no such function.
    IllegalFunction = 1,
    /// There is nothing at an address, or it only shows something and was written.
    IllegalAddress = 2,
    /// A count or a value that is not allowed.
    IllegalValue = 3,
    /// The request cannot be passed on just now.
    DeviceBusy = 6,
    /// Nobody behind this server has the number of the slave.
    NoTargetDevice = 11,
}

/// One of the two spaces of a kind: values that a client can write, or values that it can only read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// Coils and holding registers: functions 1 and 3.
    Outputs,
    /// Discrete inputs and input registers: functions 2 and 4.
    Inputs,
}

/// Devices in this process, by the number of the slave. They answer at once.
pub type Slaves = BTreeMap<u8, Arc<dyn Tables + Send + Sync>>;

/// Bits and words. A request that is refused has changed nothing. Counts are at least 1, and addresses may reach beyond
/// the last one there is.
pub trait Tables {
    /// Whether the device has this function at all; one that it has not is answered with exception 1.
    fn has_function(&self, _function: u8) -> bool {
        true
    }
    /// Bits.
    ///
    /// # Errors
    /// [`ModbusException`]
    fn read_bits(
        &self,
        space: Space,
        address: u16,
        count: u16,
    ) -> Result<Vec<bool>, ModbusException>;
    /// Sets coils.
    ///
    /// # Errors
    /// [`ModbusException`]
    fn write_bits(&self, address: u16, levels: &[bool]) -> Result<(), ModbusException>;
    /// Words.
    ///
    /// # Errors
    /// [`ModbusException`]
    fn read_words(
        &self,
        space: Space,
        address: u16,
        count: u16,
    ) -> Result<Vec<u16>, ModbusException>;
    /// Sets holding registers.
    ///
    /// # Errors
    /// [`ModbusException`]
    fn write_words(&self, address: u16, values: &[u16]) -> Result<(), ModbusException>;
    /// Sets a holding register to what becomes of its value.
    ///
    /// # Errors
    /// [`ModbusException`]
    fn change_word(
        &self,
        address: u16,
        change: &dyn Fn(u16) -> u16,
    ) -> Result<(), ModbusException> {
        let [old] = self.read_words(Space::Outputs, address, 1)?[..] else {
            return Err(ModbusException::IllegalAddress);
        };
        self.write_words(address, &[change(old)])
    }
}

/// Coils of a [`Store`].
pub const STORE_COILS: usize = 128;
/// Holding registers of a [`Store`].
pub const STORE_REGISTERS: usize = 256;

/// A device with 128 coils and 256 holding registers, and nothing behind them: what a test plays a PLC with.
#[derive(Debug)]
pub struct Store {
    values: Mutex<PortValues>,
}

/// What a [`Store`] keeps.
#[derive(Debug)]
pub struct PortValues {
    /// Coils.
    pub coils: [bool; STORE_COILS],
    /// Holding registers.
    pub registers: [u16; STORE_REGISTERS],
}

impl Default for Store {
    fn default() -> Self {
        Self {
            values: Mutex::new(PortValues {
                coils: [false; STORE_COILS],
                registers: [0; STORE_REGISTERS],
            }),
        }
    }
}

impl Store {
    /// What it keeps.
    pub fn values(&self) -> MutexGuard<'_, PortValues> {
        self.values.lock()
    }
}

impl Tables for Store {
    fn read_bits(
        &self,
        space: Space,
        address: u16,
        count: u16,
    ) -> Result<Vec<bool>, ModbusException> {
        outputs_only(space)?;
        let span = span(address, count.into(), STORE_COILS)?;
        Ok(self.values().coils[span].to_vec())
    }

    fn write_bits(&self, address: u16, levels: &[bool]) -> Result<(), ModbusException> {
        let span = span(address, levels.len(), STORE_COILS)?;
        self.values().coils[span].copy_from_slice(levels);
        Ok(())
    }

    fn read_words(
        &self,
        space: Space,
        address: u16,
        count: u16,
    ) -> Result<Vec<u16>, ModbusException> {
        outputs_only(space)?;
        let span = span(address, count.into(), STORE_REGISTERS)?;
        Ok(self.values().registers[span].to_vec())
    }

    fn write_words(&self, address: u16, values: &[u16]) -> Result<(), ModbusException> {
        let span = span(address, values.len(), STORE_REGISTERS)?;
        self.values().registers[span].copy_from_slice(values);
        Ok(())
    }
}

/// Refuses a read of inputs, because the store has none.
const fn outputs_only(space: Space) -> Result<(), ModbusException> {
    match space {
        Space::Outputs => Ok(()),
        Space::Inputs => Err(ModbusException::IllegalFunction),
    }
}

/// The indices of `count` values from `address`.
fn span(address: u16, count: usize, size: usize) -> Result<Range<usize>, ModbusException> {
    let start = usize::from(address);
    let end = start + count;
    if end > size {
        return Err(ModbusException::IllegalAddress);
    }
    Ok(start..end)
}
