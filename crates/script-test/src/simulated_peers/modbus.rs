//! A Modbus device that a test plays: coils and registers by address, as it was given them and as they were written.
//!
//! Discrete inputs are the coils, input registers the registers: a device of a test has one table of each. Messages are
//! answered by the code of the controller's own server.

use std::cell::RefCell;
use std::collections::BTreeMap;

use io_bus::modbus_server::codec::{self, HEADER_BYTES};
use io_bus::modbus_server::tables::{ModbusException, Space, Tables};

/// The tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ModbusDevice {
    pub coils: BTreeMap<u16, bool>,
    pub registers: BTreeMap<u16, u16>,
}

/// What a request asks for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ModbusRequest {
    pub function: u8,
    pub address: u16,
    /// Number of values that are read, or the values that are written.
    pub values: Vec<u16>,
}

impl ModbusDevice {
    /// The reply to a whole message.
    pub(super) fn answer(&mut self, message: &[u8]) -> Vec<u8> {
        codec::build_reply(message, &DeviceTables(RefCell::new(self)))
    }
}

/// A device while it answers one message.
struct DeviceTables<'d>(RefCell<&'d mut ModbusDevice>);

impl Tables for DeviceTables<'_> {
    fn read_bits(&self, _: Space, address: u16, count: u16) -> Result<Vec<bool>, ModbusException> {
        values_at(&self.0.borrow().coils, address, count)
    }

    fn write_bits(&self, address: u16, levels: &[bool]) -> Result<(), ModbusException> {
        set_values(&mut self.0.borrow_mut().coils, address, levels)
    }

    fn read_words(&self, _: Space, address: u16, count: u16) -> Result<Vec<u16>, ModbusException> {
        values_at(&self.0.borrow().registers, address, count)
    }

    fn write_words(&self, address: u16, values: &[u16]) -> Result<(), ModbusException> {
        set_values(&mut self.0.borrow_mut().registers, address, values)
    }
}

/// The values from an address on; there must be one at every address.
fn values_at<T: Copy>(
    table: &BTreeMap<u16, T>,
    address: u16,
    count: u16,
) -> Result<Vec<T>, ModbusException> {
    addresses(address, count.into())?
        .map(|at| {
            table
                .get(&at)
                .copied()
                .ok_or(ModbusException::IllegalAddress)
        })
        .collect()
}

/// Changes the values from an address on: all, or none where one of them does not exist.
fn set_values<T: Copy>(
    table: &mut BTreeMap<u16, T>,
    address: u16,
    values: &[T],
) -> Result<(), ModbusException> {
    let found: Vec<u16> = addresses(address, values.len())?.collect();
    if found.iter().any(|at| !table.contains_key(at)) {
        return Err(ModbusException::IllegalAddress);
    }
    table.extend(found.into_iter().zip(values.iter().copied()));
    Ok(())
}

fn addresses(first: u16, count: usize) -> Result<impl Iterator<Item = u16>, ModbusException> {
    let end = usize::from(first) + count;
    match end <= 1 + usize::from(u16::MAX) {
        true => Ok((usize::from(first)..end).map(|at| at as u16)),
        false => Err(ModbusException::IllegalAddress),
    }
}

impl ModbusRequest {
    /// Of a request proper; `None` where its bytes do not fit its function.
    pub(crate) fn read(request: &[u8]) -> Option<Self> {
        let (&function, fields) = request.split_first()?;
        let word = |at: usize| Some(u16::from_be_bytes([*fields.get(at)?, *fields.get(at + 1)?]));
        let address = word(0).unwrap_or_default();
        let values = match function {
            1..=4 => vec![word(2)?],
            5 => match word(2)? {
                0 => vec![0],
                0xFF00 => vec![1],
                _ => return None,
            },
            6 => vec![word(2)?],
            15 => {
                let (count, data) = (usize::from(word(2)?), fields.get(5..)?);
                let fits = (1..=1968).contains(&count) && data.len() == count.div_ceil(8);
                let bit = |n: usize| u16::from(data[n / 8] >> (n % 8) & 1);
                fits.then(|| (0..count).map(bit).collect())?
            }
            16 => {
                let (count, data) = (usize::from(word(2)?), fields.get(5..)?);
                let fits = (1..=123).contains(&count) && data.len() == 2 * count;
                let (words, _) = data.as_chunks::<2>();
                fits.then(|| words.iter().map(|w| u16::from_be_bytes(*w)).collect())?
            }
            _ => Vec::new(),
        };
        Some(Self {
            function,
            address,
            values,
        })
    }

    /// The request that a whole message holds.
    pub(crate) fn of_message(message: &[u8]) -> Option<Self> {
        Self::read(message.get(HEADER_BYTES..)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coils_and_registers_are_read_and_written_where_they_are() {
        let mut device = ModbusDevice {
            coils: (0..10).map(|n| (n, n % 3 == 0)).collect(),
            registers: [(100, 7), (101, 0x1234)].into(),
        };
        let mut ask = |request: &[u8]| {
            let length = (request.len() + 1) as u8;
            let message = [&[0, 9, 0, 0, 0, length, 1][..], request].concat();
            let reply = device.answer(&message);
            assert_eq!((reply[..4].to_vec(), reply[6]), (vec![0, 9, 0, 0], 1));
            assert_eq!(usize::from(reply[5]), reply.len() - 6);
            reply[7..].to_vec()
        };
        assert_eq!(ask(&[1, 0, 0, 0, 10]), [1, 2, 0b0100_1001, 0b10]);
        assert_eq!(ask(&[3, 0, 100, 0, 2]), [3, 4, 0, 7, 0x12, 0x34]);
        assert_eq!(ask(&[5, 0, 1, 0xFF, 0]), [5, 0, 1, 0xFF, 0]);
        assert_eq!(ask(&[2, 0, 0, 0, 2]), [2, 1, 0b11]);
        assert_eq!(ask(&[16, 0, 100, 0, 2, 4, 0, 1, 0, 2]), [16, 0, 100, 0, 2]);
        assert_eq!(ask(&[4, 0, 100, 0, 2]), [4, 4, 0, 1, 0, 2]);
        assert_eq!(ask(&[6, 0, 101, 0, 9]), [6, 0, 101, 0, 9]);
        assert_eq!(ask(&[15, 0, 8, 0, 2, 1, 0b10]), [15, 0, 8, 0, 2]);
        for (request, exception) in [
            (&[3, 0, 102, 0, 1][..], 2),
            (&[3, 0, 100, 0, 0], 3),
            (&[5, 0, 1, 0xFF, 1], 3),
            (&[16, 0, 100, 0, 2, 4, 0, 1], 3),
            (&[43, 14, 1, 0], 1),
        ] {
            assert_eq!(ask(request), [request[0] | 0x80, exception], "{request:?}");
        }
    }
}
